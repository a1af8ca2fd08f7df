//! The period of a textured surface, and the height and width of its dots or ridges.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::HeightMap;
use super::autocorrelation::Correlogram;
use super::mean_period::MeanPeriod;
use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::statistics::standard_deviation;

/// The autocorrelation one and two periods away, and how far it falls in between, of what repeats itself.
///
/// Source: docs/decisions/roughness.md.
const LEAST: f64 = 0.5;
/// Maxima of the autocorrelation that are this share of the highest are neighbours of the same kind.
const ALIKE: f64 = 0.8;
/// Along ridges the autocorrelation keeps this share of that one period away.
const ALONG: f64 = 0.5;
/// Two neighbours of a dot whose directions differ by less (sine) stand in one line.
const OBLIQUE: f64 = 0.3;
/// Cells of the mean period in each direction, at most.
const MOST_CELLS: usize = 64;
/// Places along a direction at which the autocorrelation is looked at, at most: steps of a map can differ by any factor.
const MOST_PLACES: f64 = 4096.0;
/// Elements with a smaller share of the usual area are noise.
const SMALLEST: f64 = 0.2;

/// The shape of what repeats itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum TextureKind {
    /// Separate elevations.
    Dots,
    /// Separate depressions.
    Pits,
    /// Parallel ridges and grooves.
    Ridges,
}

impl fmt::Display for TextureKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Dots => "dots",
            Self::Pits => "pits",
            Self::Ridges => "ridges",
        })
    }
}

/// A surface that repeats itself: lengths in m.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicTexture {
    pub kind: TextureKind,
    /// The distance from a dot to its nearest neighbour, or across the ridges, m.
    pub period_m: f64,
    /// The direction of that distance from the rows of the map towards its columns, degrees, −90 to 90.
    pub direction_deg: f64,
    /// The distance to the nearest neighbour in another direction, m; absent for ridges.
    pub second_period_m: Option<f64>,
    /// From the lowest to the highest part of the mean period, m; depth of pits.
    pub height_m: f64,
    /// The diameter of a circle of the area of a dot at half its height, or the width of a ridge there, m.
    pub width_m: f64,
    /// How many whole dots the map holds, and the standard deviation of their diameters, m; absent for ridges.
    pub dots: Option<(usize, f64)>,
}

/// What decides whether a surface repeats itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PeriodRule {
    /// The autocorrelation one period away.
    OnePeriod,
    /// Two periods away in the same direction.
    TwoPeriods,
    /// One period away less its lowest value on the way.
    Fall,
}

impl fmt::Display for PeriodRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OnePeriod => "autocorrelation one period away",
            Self::TwoPeriods => "autocorrelation two periods away",
            Self::Fall => "fall of the autocorrelation in between",
        })
    }
}

/// Whether a surface repeats itself, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The rule for the most likely period; empty where the autocorrelation has no second maximum up to a quarter of the map.
    pub criteria: Vec<Criterion<PeriodRule>>,
    /// The period with the shape of the elements; absent where a criterion is not met.
    pub periodic: Option<PeriodicTexture>,
}

/// A maximum of the autocorrelation away from its centre.
#[derive(Clone, Copy)]
struct Maximum {
    /// Its lag in columns and rows.
    lag: (f64, f64),
    value: f64,
    twice: f64,
    fall: f64,
}

impl Maximum {
    fn least(&self) -> f64 {
        self.value.min(self.twice).min(self.fall)
    }

    fn criteria(&self) -> Vec<Criterion<PeriodRule>> {
        [
            (PeriodRule::OnePeriod, self.value),
            (PeriodRule::TwoPeriods, self.twice),
            (PeriodRule::Fall, self.fall),
        ]
        .map(|(what, found)| Criterion::new(what, "", found, None, Limit::at_least(LEAST)))
        .into()
    }
}

/// The period of `map`, whose heights are about zero, with the elements that repeat.
///
/// Formula: the nearest maximum of the autocorrelation up to a quarter of the map that, as twice as far, is 0.5 and more, and 0.5
/// above the lowest value on the way. The mean period, over the places of the map within it, gives the height and the
/// part above half of it.
pub(super) fn texture(map: &HeightMap, correlogram: &Correlogram) -> Texture {
    let maxima = correlogram.maxima();
    let Some(best) = (maxima.iter()).max_by(|a, b| a.least().total_cmp(&b.least())) else {
        return Texture {
            criteria: Vec::new(),
            periodic: None,
        };
    };
    let criteria = best.criteria();
    let is_met = |maximum: &Maximum| maximum.least() >= LEAST;
    let highest = (maxima.iter().filter(|m| is_met(m))).fold(0.0f64, |most, m| most.max(m.value));
    let length_m = |lag: (f64, f64)| (lag.0 * map.step_x_m()).hypot(lag.1 * map.step_y_m());
    let mut alike: Vec<&Maximum> = maxima
        .iter()
        .filter(|m| is_met(m) && m.value >= ALIKE * highest)
        .collect();
    alike.sort_by(|a, b| length_m(a.lag).total_cmp(&length_m(b.lag)));
    if Outcome::of_all(criteria.iter().map(|c| c.outcome)) != Outcome::Met {
        return Texture {
            criteria,
            periodic: None,
        };
    }
    let first = alike[0];
    let periodic = match correlogram.along_ridges(length_m(first.lag), first.value) {
        Some(angle) => ridges(map, correlogram, angle, length_m(first.lag)),
        None => dots(map, correlogram, &alike),
    };
    Texture {
        criteria: first.criteria(),
        periodic,
    }
}

/// The direction of a line, degrees from the rows, −90 to 90.
fn direction_deg((x_m, y_m): (f64, f64)) -> f64 {
    let degrees = y_m.atan2(x_m).to_degrees();
    match degrees {
        d if d > 90.0 => d - 180.0,
        d if d <= -90.0 => d + 180.0,
        d => d,
    }
}

fn ridges(
    map: &HeightMap,
    correlogram: &Correlogram,
    along: f64,
    about_m: f64,
) -> Option<PeriodicTexture> {
    let across = (-along.sin(), along.cos());
    let finest_m = map.step_x_m().min(map.step_y_m());
    let highest_near = |from_m: f64, to_m: f64| {
        let count = ((to_m - from_m) / (finest_m / 8.0))
            .ceil()
            .clamp(1.0, MOST_PLACES);
        let places = (0..=count as usize).map(|k| from_m + (to_m - from_m) * k as f64 / count);
        let values =
            places.filter_map(|r| Some((correlogram.at_m(r * across.0, r * across.1)?, r)));
        values.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    // The foot of the crest of the autocorrelation is not further than its nearest maximum on the grid.
    let mut period_m = highest_near(0.6 * about_m, 1.1 * about_m)?.1;
    for k in [2.0, 3.0, 4.0, 6.0] {
        match highest_near((k - 0.2) * period_m, (k + 0.2) * period_m) {
            Some((value, at_m))
                if value >= LEAST && correlogram.holds(k + 0.2, period_m, across) =>
            {
                period_m = at_m / k;
            }
            _ => break,
        }
    }
    let cells = cells(period_m, finest_m);
    let mut mean = MeanPeriod::new(cells, 1);
    for (x_m, y_m, z) in places(map) {
        mean.add(
            [(x_m * across.0 + y_m * across.1) / period_m, 0.0],
            [x_m, y_m, z],
        );
    }
    let (low_m, high_m, share) = mean.half_height()?;
    Some(PeriodicTexture {
        kind: TextureKind::Ridges,
        period_m,
        direction_deg: direction_deg(across),
        second_period_m: None,
        height_m: high_m - low_m,
        width_m: share * period_m,
        dots: None,
    })
}

fn dots(map: &HeightMap, correlogram: &Correlogram, alike: &[&Maximum]) -> Option<PeriodicTexture> {
    let in_m = |lag: (f64, f64)| (lag.0 * map.step_x_m(), lag.1 * map.step_y_m());
    let a = in_m(correlogram.refined(alike.first()?.lag));
    let period_m = a.0.hypot(a.1);
    let second = alike.iter().find(|maximum| {
        let b = in_m(maximum.lag);
        (a.0 * b.1 - a.1 * b.0).abs() > OBLIQUE * period_m * b.0.hypot(b.1)
    })?;
    let b = in_m(correlogram.refined(second.lag));
    let area_m2 = a.0 * b.1 - a.1 * b.0;
    let finest_m = map.step_x_m().min(map.step_y_m());
    let second_m = b.0.hypot(b.1);
    let mut mean = MeanPeriod::new(cells(period_m, finest_m), cells(second_m, finest_m));
    for (x_m, y_m, z) in places(map) {
        let u = (x_m * b.1 - y_m * b.0) / area_m2;
        let v = (y_m * a.0 - x_m * a.1) / area_m2;
        mean.add([u, v], [x_m, y_m, z]);
    }
    let (low_m, high_m, above) = mean.half_height()?;
    let (kind, share) = match above > 0.5 {
        true => (TextureKind::Pits, 1.0 - above),
        false => (TextureKind::Dots, above),
    };
    let diameter_m = |area_m2: f64| (4.0 * area_m2 / std::f64::consts::PI).sqrt();
    let expected_m2 = share * area_m2.abs();
    let half_m = f64::midpoint(low_m, high_m);
    let point_m2 = map.step_x_m() * map.step_y_m();
    let inside = |z: &f64| match kind {
        TextureKind::Pits => *z < half_m,
        _ => *z > half_m,
    };
    let diameters_m: Vec<f64> = whole_regions(map, inside)
        .into_iter()
        .map(|points| points as f64 * point_m2)
        .filter(|area_m2| *area_m2 >= SMALLEST * expected_m2)
        .map(diameter_m)
        .collect();
    Some(PeriodicTexture {
        kind,
        period_m,
        direction_deg: direction_deg(a),
        second_period_m: Some(second_m),
        height_m: high_m - low_m,
        width_m: diameter_m(expected_m2),
        dots: (diameters_m.len() > 1)
            .then(|| (diameters_m.len(), standard_deviation(&diameters_m))),
    })
}

/// Into how many cells a period is divided: each is as wide as a whole number of points, so that all hold as many.
fn cells(period_m: f64, step_m: f64) -> usize {
    let points = period_m / step_m;
    let wide = (points / MOST_CELLS as f64).ceil().max(1.0);
    ((points / wide).round() as usize).clamp(2, MOST_CELLS)
}

/// The measured points with their places, m.
fn places(map: &HeightMap) -> impl Iterator<Item = (f64, f64, f64)> {
    let columns = map.columns();
    let points = map.heights_m().iter().enumerate();
    points.filter(|(_, z)| !z.is_nan()).map(move |(i, z)| {
        let (row, column) = (i / columns, i % columns);
        (
            column as f64 * map.step_x_m(),
            row as f64 * map.step_y_m(),
            *z,
        )
    })
}

/// The numbers of points of the connected regions inside, of those that touch neither the border nor a point that was not measured.
fn whole_regions(map: &HeightMap, inside: impl Fn(&f64) -> bool) -> Vec<usize> {
    let (z, columns, rows) = (map.heights_m(), map.columns(), map.rows());
    let mut seen: Vec<bool> = z.iter().map(|z| !inside(z)).collect();
    let mut sizes = Vec::new();
    for start in 0..z.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let (mut points, mut next, mut is_whole) = (vec![start], 0, true);
        while let Some(&at) = points.get(next) {
            next += 1;
            let (row, column) = (at / columns, at % columns);
            if row == 0 || column == 0 || row + 1 == rows || column + 1 == columns {
                is_whole = false;
            }
            let beside = [
                (column > 0).then(|| at - 1),
                (column + 1 < columns).then_some(at + 1),
                (row > 0).then(|| at - columns),
                (row + 1 < rows).then_some(at + columns),
            ];
            for beside in beside.into_iter().flatten() {
                is_whole &= !z[beside].is_nan();
                if !seen[beside] {
                    seen[beside] = true;
                    points.push(beside);
                }
            }
        }
        if is_whole {
            sizes.push(points.len());
        }
    }
    sizes
}

impl Correlogram {
    /// The value at a whole lag in columns and rows; `None` beyond the lags.
    fn at(&self, (x, y): (i64, i64)) -> Option<f64> {
        let (reach_y, reach_x) = (self.most.0 as i64, self.most.1 as i64);
        // Steps of a map can differ by any factor, so that lags do.
        let within = (-reach_x..=reach_x).contains(&x) && (-reach_y..=reach_y).contains(&y);
        within.then(|| {
            let at = (y + reach_y) * (2 * reach_x + 1) + x + reach_x;
            self.values.get(usize::try_from(at).ok()?).copied()
        })?
    }

    /// The value at a lag in m, between those of the grid.
    fn at_m(&self, x_m: f64, y_m: f64) -> Option<f64> {
        let (x, y) = (x_m / self.step_x_m, y_m / self.step_y_m);
        let (left, low) = (x.floor(), y.floor());
        let (right_share, high_share) = (x - left, y - low);
        let corner = |dx: i64, dy: i64, share: f64| match share > 0.0 {
            true => {
                let lag = (
                    (left as i64).saturating_add(dx),
                    (low as i64).saturating_add(dy),
                );
                Some(share * self.at(lag)?)
            }
            false => Some(0.0),
        };
        Some(
            corner(0, 0, (1.0 - right_share) * (1.0 - high_share))?
                + corner(1, 0, right_share * (1.0 - high_share))?
                + corner(0, 1, (1.0 - right_share) * high_share)?
                + corner(1, 1, right_share * high_share)?,
        )
    }

    /// Whether lags reach `periods` of `period_m` in a direction.
    fn holds(&self, periods: f64, period_m: f64, (x, y): (f64, f64)) -> bool {
        let reach_m = periods * period_m;
        self.at_m(reach_m * x, reach_m * y).is_some()
    }

    /// The highest value up to `reach` columns and rows round a lag, and where it is.
    fn highest_near(&self, (x, y): (f64, f64), reach: i64) -> Option<(f64, (i64, i64))> {
        let (x, y) = (x.round() as i64, y.round() as i64);
        let lags =
            (y - reach..=y + reach).flat_map(|v| (x - reach..=x + reach).map(move |u| (u, v)));
        let values = lags.filter_map(|lag| Some((self.at(lag)?, lag)));
        values.max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The maxima at lags of up to a quarter of the map, one of each pair that lie opposite each other, with a value above zero.
    fn maxima(&self) -> Vec<Maximum> {
        let (most_y, most_x) = (self.most.0 as i64 / 2, self.most.1 as i64 / 2);
        let half = (0..=most_y).flat_map(|y| (-most_x..=most_x).map(move |x| (x, y)));
        let maxima = half.filter(|(x, y)| *y > 0 || *x > 0).filter_map(|lag| {
            let value = self.at(lag)?;
            let beside = (-1..=1).flat_map(|y| (-1..=1).map(move |x| (x, y)));
            let mut beside = beside.filter_map(|(x, y)| self.at((lag.0 + x, lag.1 + y)));
            if value <= 0.0 || beside.any(|other| other > value) {
                return None;
            }
            let steps = lag.0.abs().max(lag.1).max(1);
            let on_the_way = (1..steps).filter_map(|k| {
                let share = k as f64 / steps as f64;
                self.at_m(
                    share * lag.0 as f64 * self.step_x_m,
                    share * lag.1 as f64 * self.step_y_m,
                )
            });
            let lag = (lag.0 as f64, lag.1 as f64);
            Some(Maximum {
                lag,
                value,
                twice: self.highest_near((2.0 * lag.0, 2.0 * lag.1), 1)?.0,
                fall: value - on_the_way.fold(value, f64::min),
            })
        });
        maxima.collect()
    }

    /// The direction, rad, in which the autocorrelation stays high over a whole period, where there is one.
    fn along_ridges(&self, period_m: f64, value: f64) -> Option<f64> {
        let finest_m = self.step_x_m.min(self.step_y_m);
        let lowest = |angle: f64, reach_m: f64| {
            let count = (reach_m / finest_m).ceil().clamp(2.0, MOST_PLACES) as usize;
            let lags = (1..=count).map(|k| reach_m * k as f64 / count as f64);
            let values = lags.map(|r| self.at_m(r * angle.cos(), r * angle.sin()));
            values
                .map(|v| v.unwrap_or(f64::MAX))
                .fold(f64::MAX, f64::min)
        };
        let best = |angles: &mut dyn Iterator<Item = f64>, reach_m: f64| {
            let found = angles.map(|angle| (lowest(angle, reach_m), angle));
            found.max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let mut degrees = (0..180).map(f64::from).map(f64::to_radians);
        let (kept, mut angle) = best(&mut degrees, period_m)?;
        if kept < ALONG * value {
            return None;
        }
        // Further away the direction shows in finer steps.
        let reach_m = (self.most.1 as f64 * self.step_x_m).min(self.most.0 as f64 * self.step_y_m);
        for (step_deg, reach_m) in [(0.25, 0.5 * reach_m), (0.05, 0.9 * reach_m)] {
            let mut near = (-8..=8).map(|k| angle + (step_deg * f64::from(k)).to_radians());
            angle = best(&mut near, reach_m.max(period_m))?.1;
        }
        Some(angle)
    }

    /// The lag of a maximum between the points of the grid, in columns and rows, from its multiples as far as they are found.
    fn refined(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let reach = ((0.25 * x.hypot(y)) as i64).max(1);
        let mut lag = (x, y);
        for (k, reach) in [(1.0, reach), (2.0, 2), (3.0, 2), (4.0, 2), (6.0, 2)] {
            let Some((value, (column, row))) = self.highest_near((k * lag.0, k * lag.1), reach)
            else {
                break;
            };
            let vertex = |before: Option<f64>, after: Option<f64>| {
                let (before, after) = before.zip(after)?;
                let curvature = before - 2.0 * value + after;
                (curvature < 0.0).then(|| 0.5 * (before - after) / curvature)
            };
            let (Some(dx), Some(dy)) = (
                vertex(self.at((column - 1, row)), self.at((column + 1, row))),
                vertex(self.at((column, row - 1)), self.at((column, row + 1))),
            ) else {
                break;
            };
            if value < LEAST || dx.abs() > 1.0 || dy.abs() > 1.0 {
                break;
            }
            lag = ((column as f64 + dx) / k, (row as f64 + dy) / k);
        }
        lag
    }
}
