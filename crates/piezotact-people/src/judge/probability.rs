//! The probabilities of answers: the model of [`super::answer`] integrated over its noise.

use std::sync::OnceLock;

use super::answer::{AXES, JudgeError, Look, Moment, Person, Recall, Scene, squared, together};
use super::normal::{both_above, cdf, even_point, quantile};
use super::{CUE_BANDS, Judge};

/// Points over which more than two dimensions are integrated.
const POINTS: usize = 1024;
/// Two alternatives that are nearer than this, in steps, are one.
const SAME_STEPS: f64 = 1e-9;
/// Steps of the grid of roughness in one standard deviation, and how many of them it reaches beyond the outermost texture.
const PER_SD: f64 = 10.0;
const REACH_SD: f64 = 6.5;
/// The grid of roughness has at most so many points.
const MOST_POINTS: usize = 20_000;

impl Person {
    /// The probabilities with which each of `alternatives` is associated with `presented`; they sum to 1.
    ///
    /// Exact for one, two and three alternatives and for any number on one axis (normal probabilities of one and two dimensions);
    /// otherwise one dimension in closed form over 1024 even points in the others. A lapse is a guess among all.
    ///
    /// # Errors
    /// [`JudgeError`] as [`Person::associate`].
    pub fn choice_probabilities(
        &self,
        presented: Look<'_>,
        alternatives: &[Look<'_>],
        (recall, moment): (Recall, Moment),
    ) -> Result<Vec<f64>, JudgeError> {
        let attentive = self.attentive_choice(presented, alternatives, (recall, moment))?;
        let lapse = self.touch.lapse_share;
        let guess = lapse / alternatives.len() as f64;
        Ok(attentive
            .into_iter()
            .map(|p| guess + (1.0 - lapse) * p)
            .collect())
    }

    /// The same without lapses.
    pub(super) fn attentive_choice(
        &self,
        presented: Look<'_>,
        alternatives: &[Look<'_>],
        at: (Recall, Moment),
    ) -> Result<Vec<f64>, JudgeError> {
        let scene = Scene::of(self, presented, alternatives, at)?;
        let count = alternatives.len();
        if self.judge == Judge::Guesser {
            return Ok(vec![1.0 / count as f64; count]);
        }
        Ok(nearest(&scene))
    }

    /// The probability of `order`, places of `textures` with the roughest first.
    ///
    /// Without a lapse: the recursion G(t) ← ∫ₜ^∞ φ(s)·G(s) ds over the textures from the first to the last, on a grid of a tenth of
    /// a standard deviation, by the rule of four points. A lapse exchanges two neighbours.
    ///
    /// # Errors
    /// [`JudgeError`] as [`Person::order`], or where the order does not name each texture once.
    pub fn order_probability(
        &self,
        textures: &[Look<'_>],
        order: &[usize],
        moment: Moment,
    ) -> Result<f64, JudgeError> {
        let [attentive, exchanged] = self.attentive_order(textures, order, moment)?;
        let lapse = self.touch.lapse_share;
        Ok((1.0 - lapse) * attentive + lapse * exchanged)
    }

    /// The probability of `order` without a lapse, and the mean probability of the orders that one exchange turns into it.
    pub(super) fn attentive_order(
        &self,
        textures: &[Look<'_>],
        order: &[usize],
        moment: Moment,
    ) -> Result<[f64; 2], JudgeError> {
        together(textures, 1)?;
        let mut seen = order.to_vec();
        seen.sort_unstable();
        if seen != (0..textures.len()).collect::<Vec<usize>>() {
            return Err(JudgeError::Order {
                textures: textures.len(),
                found: order.to_vec(),
            });
        }
        if self.judge == Judge::Guesser {
            let orders: f64 = (1..=order.len()).map(|n| n as f64).product();
            return Ok([orders.recip(); 2]);
        }
        let rough: Vec<(f64, f64, bool)> = textures
            .iter()
            .map(|look| {
                let (mean, sd) = self.roughness(*look, moment);
                (mean, sd, self.is_placed_last(*look))
            })
            .collect();
        let falling = Falling::over(&rough);
        let attentive = falling.probability(order);
        if order.len() < 2 {
            return Ok([attentive; 2]);
        }
        let mut exchanged = 0.0;
        let mut other = order.to_vec();
        for place in 0..order.len() - 1 {
            other.swap(place, place + 1);
            exchanged += falling.probability(&other);
            other.swap(place, place + 1);
        }
        Ok([attentive, exchanged / (order.len() - 1) as f64])
    }

    /// The probability that the first of two textures is judged the rougher one.
    ///
    /// Φ(Δ/√(σ₁² + σ₂²)) with lapses that guess. Source: Thurstone 1927, case V.
    ///
    /// # Errors
    /// [`JudgeError`] as [`Person::rougher`].
    pub fn first_rougher_probability(
        &self,
        pair: [Look<'_>; 2],
        moment: Moment,
    ) -> Result<f64, JudgeError> {
        together(&pair, 2)?;
        let [(one, one_sd), (other, other_sd)] = pair.map(|look| self.roughness(look, moment));
        let attentive = cdf((one - other) / one_sd.hypot(other_sd));
        let lapse = self.touch.lapse_share;
        Ok(0.5 * lapse + (1.0 - lapse) * attentive)
    }
}

/// The probability of each alternative of `scene` to be the nearest.
fn nearest(scene: &Scene) -> Vec<f64> {
    // Equal alternatives share what one of them would have.
    let all = &scene.alternatives;
    let same = |a: &[f64; AXES], b: &[f64; AXES]| squared(a, b) < SAME_STEPS * SAME_STEPS;
    let mut distinct: Vec<[f64; AXES]> = Vec::new();
    for one in all {
        if !distinct.iter().any(|other| same(one, other)) {
            distinct.push(*one);
        }
    }
    let mut each: Vec<f64> = (0..distinct.len())
        .map(|j| {
            let own = &distinct[j];
            let walls: Vec<Wall> = (0..distinct.len())
                .filter(|k| *k != j)
                .map(|k| Wall::between(scene, own, &distinct[k]))
                .collect();
            within(&walls)
        })
        .collect();
    let sum: f64 = each.iter().sum();
    if sum > 0.0 {
        each.iter_mut().for_each(|p| *p /= sum);
    }
    all.iter()
        .map(|one| {
            let sharing = all.iter().filter(|other| same(one, other)).count();
            let place = distinct.iter().position(|other| same(one, other));
            place.map_or(0.0, |place| each[place]) / sharing as f64
        })
        .collect()
}

/// The half space of the noise z in which one alternative is nearer than another: `normal`·z > `above`, with a normal of length 1
/// or, where noise does not matter, 0.
struct Wall {
    normal: [f64; AXES],
    above: f64,
}

impl Wall {
    fn between(scene: &Scene, own: &[f64; AXES], other: &[f64; AXES]) -> Self {
        let mut normal: [f64; AXES] =
            std::array::from_fn(|i| 2.0 * scene.noise[i] * (own[i] - other[i]));
        let above = squared(&scene.presented, own) - squared(&scene.presented, other);
        let length = dot(&normal, &normal).sqrt();
        if length > 1e-12 * (1.0 + above.abs()) {
            normal.iter_mut().for_each(|x| *x /= length);
            Self {
                normal,
                above: above / length,
            }
        } else {
            Self {
                normal: [0.0; AXES],
                above: if above < 0.0 {
                    f64::NEG_INFINITY
                } else {
                    f64::INFINITY
                },
            }
        }
    }
}

fn dot(a: &[f64; AXES], b: &[f64; AXES]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The probability that standard normal noise is within all of `walls`.
fn within(walls: &[Wall]) -> f64 {
    if walls.iter().any(|wall| wall.above == f64::INFINITY) {
        return 0.0;
    }
    let walls: Vec<&Wall> = walls.iter().filter(|wall| wall.above.is_finite()).collect();
    match walls.as_slice() {
        [] => 1.0,
        [one] => cdf(-one.above),
        [one, other] => both_above(one.above, other.above, dot(&one.normal, &other.normal)),
        several => over_points(several),
    }
}

/// The same, with the tightest wall's direction integrated in closed form.
fn over_points(walls: &[&Wall]) -> f64 {
    // Axes of the space that the normals span, the tightest wall first.
    let mut by_tightness = walls.to_vec();
    by_tightness.sort_by(|a, b| b.above.total_cmp(&a.above));
    let mut axes: Vec<[f64; AXES]> = Vec::new();
    for wall in &by_tightness {
        let mut rest = wall.normal;
        for axis in &axes {
            let along = dot(&rest, axis);
            for (rest, axis) in rest.iter_mut().zip(axis) {
                *rest -= along * axis;
            }
        }
        let length = dot(&rest, &rest).sqrt();
        if length > 1e-6 {
            axes.push(rest.map(|x| x / length));
        }
    }
    let coordinates: Vec<(Vec<f64>, f64)> = walls
        .iter()
        .map(|wall| {
            let along = axes.iter().map(|axis| dot(&wall.normal, axis));
            (along.collect(), wall.above)
        })
        .collect();
    let rest = axes.len().saturating_sub(1);
    if rest == 0 {
        return interval(&coordinates, &[]);
    }
    let sum: f64 = points()
        .iter()
        .map(|point| interval(&coordinates, &point[..rest.min(CUE_BANDS)]))
        .sum();
    sum / POINTS as f64
}

/// The probability of the part of the first axis that is within all walls, where the other coordinates are `point`.
fn interval(walls: &[(Vec<f64>, f64)], point: &[f64]) -> f64 {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (along, above) in walls {
        let rest: f64 = along[1..].iter().zip(point).map(|(a, z)| a * z).sum();
        let limit = above - rest;
        if along[0] > 1e-9 {
            low = low.max(limit / along[0]);
        } else if along[0] < -1e-9 {
            high = high.min(limit / along[0]);
        } else if limit > 0.0 {
            return 0.0;
        }
    }
    (cdf(high) - cdf(low)).max(0.0)
}

/// Standard normal points that fill their space evenly, computed once.
fn points() -> &'static [[f64; CUE_BANDS]] {
    static ALL: OnceLock<Vec<[f64; CUE_BANDS]>> = OnceLock::new();
    ALL.get_or_init(|| {
        (0..POINTS)
            .map(|i| even_point::<CUE_BANDS>(i).map(quantile))
            .collect()
    })
}

/// Probabilities of orders of independent normal numbers.
struct Falling {
    /// The density of each texture at each point of the grid, times its step.
    densities: Vec<Vec<f64>>,
    /// Whether each is placed last.
    last: Vec<bool>,
}

impl Falling {
    fn over(rough: &[(f64, f64, bool)]) -> Self {
        let least_sd = rough.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
        let low = rough.iter().map(|r| r.0 - REACH_SD * r.1);
        let high = rough.iter().map(|r| r.0 + REACH_SD * r.1);
        let low = low.fold(f64::INFINITY, f64::min);
        let high = high.fold(f64::NEG_INFINITY, f64::max);
        let points = ((high - low) / least_sd * PER_SD).ceil();
        let points = (points.min(MOST_POINTS as f64) as usize).max(4);
        let step = (high - low) / points as f64;
        let density = |(mean, sd, _): &(f64, f64, bool)| {
            let scale = step / (sd * std::f64::consts::TAU.sqrt());
            let at = |i: usize| (low + i as f64 * step - mean) / sd;
            (0..=points)
                .map(|i| scale * (-0.5 * at(i) * at(i)).exp())
                .collect()
        };
        Self {
            densities: rough.iter().map(density).collect(),
            last: rough.iter().map(|r| r.2).collect(),
        }
    }

    fn probability(&self, order: &[usize]) -> f64 {
        let split = order.iter().position(|i| self.last[*i]);
        let (before, after) = order.split_at(split.unwrap_or(order.len()));
        if after.iter().any(|i| !self.last[*i]) {
            return 0.0;
        }
        self.chain(before) * self.chain(after)
    }

    /// The probability that the textures fall in this order.
    fn chain(&self, order: &[usize]) -> f64 {
        let [first, ..] = order else { return 1.0 };
        if order.len() == 1 {
            return 1.0;
        }
        let count = self.densities[*first].len();
        let mut above = vec![1.0; count];
        let mut product = vec![0.0; count];
        for texture in order {
            let density = &self.densities[*texture];
            for ((product, above), density) in product.iter_mut().zip(&above).zip(density) {
                *product = above * density;
            }
            let at = |i: usize| product.get(i).copied().unwrap_or(0.0);
            above[count - 1] = 0.0;
            for i in (0..count - 1).rev() {
                let before = if i == 0 { 0.0 } else { at(i - 1) };
                let cell = 13.0 * (at(i) + at(i + 1)) - before - at(i + 2);
                above[i] = above[i + 1] + cell / 24.0;
            }
        }
        above[0].clamp(0.0, 1.0)
    }
}

#[cfg(test)]
#[path = "probability_tests.rs"]
mod tests;
