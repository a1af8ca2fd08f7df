//! The parameters of the material ratio curve of a profile: core, peaks and valleys.

/// The share of the curve that the secant spans.
const CENTRAL_SHARE: f64 = 0.4;
/// Fewer points than this give no curve.
const FEWEST_POINTS: usize = 20;

/// The parameters of the material ratio curve of a roughness profile: heights in m, ratios as shares 0–1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialRatio {
    /// Core height Rk, m.
    pub rk_m: f64,
    /// Reduced peak height Rpk, m.
    pub rpk_m: f64,
    /// Reduced valley depth Rvk, m, above zero.
    pub rvk_m: f64,
    /// Material ratio Mr1 that separates the peaks from the core, 0–1.
    pub mr1: f64,
    /// Material ratio Mr2 that separates the valleys from the core, 0–1.
    pub mr2: f64,
}

/// Core, peaks and valleys of `heights_m`, in m: the graphical construction on their material ratio curve; `None` for fewer
/// than 20 heights and for a flat profile.
///
/// Formula: the secant over 40 % of the curve with the smallest gradient (the first of equal ones) marks the central region; the
/// line through its points with the least squares of height meets 0 % and 100 % at heights that are Rk apart; Mr1 and Mr2 are the
/// ratios of the curve at these heights; Rpk = 2·A1/Mr1 and Rvk = 2·A2/(1 − Mr2), with A1 and A2 the areas of the curve above and
/// below them. The k-th highest of n heights stands at the ratio (k − 1)/(n − 1).
///
/// Source: ISO 13565-2:1996, 4 and 5; ISO 21920-2:2021, annex on the material ratio curve. The profile is the one given: the
/// two-step filter of ISO 13565-1 is not applied.
///
/// ```
/// use piezotact_surface::material_ratio;
/// // evenly distributed heights from 0 to 1 µm are all core
/// let ramp: Vec<f64> = (0..=100).map(|i| f64::from(i) * 1e-8).collect();
/// let found = material_ratio(&ramp).unwrap();
/// assert!((found.rk_m - 1e-6).abs() < 1e-12 && found.rpk_m < 1e-12);
/// ```
#[must_use]
pub fn material_ratio(heights_m: &[f64]) -> Option<MaterialRatio> {
    let mut falling = heights_m.to_vec();
    falling.sort_unstable_by(|a, b| b.total_cmp(a));
    let (highest, lowest) = (*falling.first()?, *falling.last()?);
    if falling.len() < FEWEST_POINTS || highest <= lowest {
        return None;
    }
    let curve = Curve { falling };
    let (first, last) = curve.central_region();
    let (at_zero, slope) = curve.line(first, last);
    let at_one = at_zero + slope;
    let (mr1, mr2) = (curve.ratio_at(at_zero), curve.ratio_at(at_one));
    let twice = |area: f64, base: f64| if base > 0.0 { 2.0 * area / base } else { 0.0 };
    Some(MaterialRatio {
        rk_m: -slope,
        rpk_m: twice(curve.area_above(at_zero), mr1),
        rvk_m: twice(curve.area_below(at_one), 1.0 - mr2),
        mr1,
        mr2,
    })
}

/// Heights from the highest to the lowest, at even ratios from 0 to 1.
struct Curve {
    falling: Vec<f64>,
}

impl Curve {
    fn steps(&self) -> f64 {
        (self.falling.len() - 1) as f64
    }

    /// The height at a place between two points, in steps from the first.
    fn height_at(&self, place: f64) -> f64 {
        let last = self.falling.len() - 1;
        let before = (place.max(0.0) as usize).min(last);
        let after = (before + 1).min(last);
        let share = (place - before as f64).clamp(0.0, 1.0);
        self.falling[before] + share * (self.falling[after] - self.falling[before])
    }

    /// The first and the last point of the region whose secant falls least.
    fn central_region(&self) -> (usize, usize) {
        let span = CENTRAL_SHARE * self.steps();
        // Rounding must not lose the last place of the secant.
        let places = (self.steps() - span + 1e-9) as usize;
        let fall = |at: usize| self.falling[at] - self.height_at(at as f64 + span);
        let mut first = 0;
        let mut least = fall(0);
        for at in 1..=places {
            let found = fall(at);
            if found < least {
                (first, least) = (at, found);
            }
        }
        (first, first + (span + 1e-9) as usize)
    }

    /// The line of least squares through the points from `first` to `last`: its height at ratio 0, and its fall to ratio 1.
    fn line(&self, first: usize, last: usize) -> (f64, f64) {
        let points = &self.falling[first..=last];
        let count = points.len() as f64;
        let (middle_x, middle_z) = (
            (first + last) as f64 / 2.0 / self.steps(),
            points.iter().sum::<f64>() / count,
        );
        let (mut products, mut squares) = (0.0, 0.0);
        for (i, z) in points.iter().enumerate() {
            let x = (first + i) as f64 / self.steps() - middle_x;
            products += x * (z - middle_z);
            squares += x * x;
        }
        let slope = products / squares;
        (middle_z - slope * middle_x, slope)
    }

    /// The share of the curve above `height_m`, between its points along the straight line.
    fn ratio_at(&self, height_m: f64) -> f64 {
        let above = self.falling.partition_point(|z| *z > height_m);
        let place = match (above.checked_sub(1), self.falling.get(above)) {
            (None, _) => 0.0,
            (Some(before), None) => before as f64,
            (Some(before), Some(after)) => {
                let fall = self.falling[before] - after;
                before as f64 + (self.falling[before] - height_m) / fall
            }
        };
        place / self.steps()
    }

    /// The area between the curve and `height_m` where the curve is above it, in m.
    fn area_above(&self, height_m: f64) -> f64 {
        let heights = self.falling.iter().map(|z| z - height_m);
        area_of_positive(heights) / self.steps()
    }

    /// The area between `height_m` and the curve where the curve is below it, in m.
    fn area_below(&self, height_m: f64) -> f64 {
        let depths = self.falling.iter().rev().map(|z| height_m - z);
        area_of_positive(depths) / self.steps()
    }
}

/// The area under falling values at steps of one, as far as they are above zero.
fn area_of_positive(falling: impl Iterator<Item = f64>) -> f64 {
    let mut area = 0.0;
    let mut before: Option<f64> = None;
    for z in falling {
        if let Some(higher) = before {
            area += if z > 0.0 {
                (higher + z) / 2.0
            } else {
                // the part of the step before the curve reaches zero
                return area + higher * higher / (2.0 * (higher - z));
            };
        } else if z <= 0.0 {
            return 0.0;
        }
        before = Some(z);
    }
    area
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(heights_um: impl Fn(f64) -> f64, expected: [f64; 5], tolerance: f64) {
        // the curve itself is given, at 20 001 ratios
        let heights: Vec<f64> = (0..=20_000)
            .map(|i| heights_um(f64::from(i) / 20_000.0) * 1e-6)
            .collect();
        let found = material_ratio(&heights).unwrap();
        let found = [
            found.rk_m * 1e6,
            found.rpk_m * 1e6,
            found.rvk_m * 1e6,
            found.mr1 * 100.0,
            found.mr2 * 100.0,
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (found - expected).abs() <= tolerance * expected.abs().max(1.0),
                "{found} {expected}"
            );
        }
    }

    #[test]
    fn a_plateau_with_peaks_and_valleys_has_the_areas_of_their_triangles() {
        // Peaks: a triangle of 2 µm over 10 %. Core: 1 µm over the whole width. Valleys: a triangle of 5 µm over 20 %.
        let curve = |ratio: f64| {
            let core = 1.0 - ratio;
            let peak = 2.0 * (1.0 - ratio / 0.1).max(0.0);
            let valley = 5.0 * ((ratio - 0.8) / 0.2).max(0.0);
            core + peak - valley
        };
        // The curve meets height 1 µm where (1 − r) + 2(1 − r/0.1) = 1: r = 2/21; the area above it is a triangle. Likewise the
        // valleys: −5(r − 0.8)/0.2 + 1 − r = 0 at r = 21/26, with a depth of 5 µm at 100 %.
        check(
            curve,
            [1.0, 2.0, 5.0, 200.0 / 21.0, 2100.0 / 26.0],
            // the straight pieces are sampled at 0.005 %
            1e-3,
        );
    }

    #[test]
    fn a_sine_has_its_own_construction() {
        // The curve is cos(πr), steepest in the middle: the secant falls least at one end, and of two equal ones the first counts.
        let curve = |ratio: f64| (std::f64::consts::PI * ratio).cos();
        let heights: Vec<f64> = (0..=1000).map(|i| curve(f64::from(i) / 1000.0)).collect();
        let found = material_ratio(&heights).unwrap();
        // the line of least squares of cos(πr) over 0 … 0.4, from its integrals
        let (a, pi) = (0.4, std::f64::consts::PI);
        let sum = (pi * a).sin() / pi;
        let moment = a * (pi * a).sin() / pi + ((pi * a).cos() - 1.0) / (pi * pi);
        let slope = (moment - sum * a / 2.0) / (a * a * a / 12.0);
        // sums in place of integrals, at 400 points
        assert!(
            (found.rk_m / -slope - 1.0).abs() < 5e-3,
            "{found:?} {slope}"
        );
    }

    #[test]
    fn the_same_surface_upside_down_changes_peaks_and_valleys() {
        let mut state = 7u64;
        let heights: Vec<f64> = (0..4000)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                let share = (state >> 11) as f64 / (1u64 << 53) as f64;
                share.powi(3)
            })
            .collect();
        let down: Vec<f64> = heights.iter().map(|z| -z).collect();
        let (up, down) = (
            material_ratio(&heights).unwrap(),
            material_ratio(&down).unwrap(),
        );
        for (a, b) in [
            (up.rk_m, down.rk_m),
            (up.rpk_m, down.rvk_m),
            (up.rvk_m, down.rpk_m),
            (up.mr1, 1.0 - down.mr2),
            (up.mr2, 1.0 - down.mr1),
        ] {
            // the region begins at another point of the 40 %
            assert!((a - b).abs() < 2e-3, "{up:?} {down:?}");
        }
    }

    #[test]
    fn nothing_is_made_of_a_flat_or_a_short_profile() {
        assert_eq!(material_ratio(&[]), None);
        assert_eq!(material_ratio(&[1.0; 500]), None);
        assert_eq!(material_ratio(&[1.0, 2.0, 3.0]), None);
    }
}
