//! Heights that no surface has, or that an instrument did not measure: wrong units, spikes, saturation, drop-outs.

use super::{HeightProfile, SurfaceDoubt};
use crate::doubt::Doubt;

/// Root-mean-square slopes of surfaces lie between these: 88° at the upper end.
const SLOPES: std::ops::RangeInclusive<f64> = 1e-6..=30.0;
/// A spike is at most this many points wide.
const SPIKE_POINTS: usize = 3;
/// It stands above its neighbours by more than the height that this share of the points spans …
const USUAL_SHARE: f64 = 0.98;
/// … and by this many times the usual change from point to point.
const USUAL_CHANGES: f64 = 10.0;
/// A share of points at the highest or lowest value from which the profile is cut off there, and the points in a row.
const SATURATED: (f64, usize) = (0.01, 5);
/// A surface of two heights is no saturated one.
const TWO_HEIGHTS: f64 = 0.9;
/// One value for so many points, for so many times as many as 95 % of its repeats have, was not measured: rounding to 4 nm holds a
/// value over 32 points of a measured plateau …
const HELD: (usize, usize) = (50, 20);
/// … and for this share of the profile.
const HELD_SHARE: f64 = 0.005;

/// The doubt that a root-mean-square `slope` is that of no surface: the units of heights or steps are wrong.
pub(super) fn of_slope(slope: f64) -> Option<Doubt> {
    let found = slope > 0.0 && !SLOPES.contains(&slope);
    found.then(|| Doubt::from(SurfaceDoubt::ImplausibleSlope { slope }))
}

/// The doubts about the heights of `profile` as they were read.
pub(super) fn of_heights(profile: &HeightProfile) -> Vec<Doubt> {
    let z = profile.heights_m();
    let mut sorted = z.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
        return Vec::new();
    };
    if low >= high {
        return Vec::new();
    }
    let runs = Runs::of(z);
    let limits =
        [(high, "highest"), (low, "lowest")].map(|(limit, at)| saturated(z, &runs, limit, at));
    let at_limits = z.iter().filter(|z| **z == low || **z == high).count();
    let two_heights = at_limits as f64 > TWO_HEIGHTS * z.len() as f64;
    if two_heights {
        return Vec::new();
    }
    let lost = drop_outs(z, &runs, &limits, profile.step_m());
    let cut = limits.into_iter().flatten().map(|(_, doubt)| doubt);
    spikes(z, &sorted, profile.step_m())
        .into_iter()
        .chain(cut)
        .chain(lost)
        .collect()
}

/// Stretches of one value: the first point and the length of each.
struct Runs(Vec<(usize, usize)>);

impl Runs {
    fn of(z: &[f64]) -> Self {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for (i, height) in z.iter().enumerate() {
            match runs.last_mut() {
                Some((first, length)) if z[*first] == *height => *length += 1,
                _ => runs.push((i, 1)),
            }
        }
        Self(runs)
    }
}

/// The limit and the doubt that heights end at it; `at` says whether it is the highest or the lowest.
fn saturated(z: &[f64], runs: &Runs, limit: f64, at: &str) -> Option<(f64, Doubt)> {
    let at_limit = runs.0.iter().filter(|(first, _)| z[*first] == limit);
    let (points, longest) = at_limit.fold((0, 0), |(points, longest), (_, length)| {
        (points + length, longest.max(*length))
    });
    let share = points as f64 / z.len() as f64;
    (share >= SATURATED.0 && longest >= SATURATED.1).then(|| {
        let doubt = SurfaceDoubt::SaturatedHeights {
            limit: at.into(),
            height_m: limit,
            share,
        };
        (limit, Doubt::from(doubt))
    })
}

/// The doubt that one value was held where nothing was measured.
fn drop_outs(
    z: &[f64],
    runs: &Runs,
    limits: &[Option<(f64, Doubt)>; 2],
    step_m: f64,
) -> Option<Doubt> {
    let mut lengths: Vec<usize> = runs.0.iter().map(|(_, length)| *length).collect();
    lengths.sort_unstable();
    let usual = lengths.get(lengths.len() * 95 / 100).copied()?;
    let is_limit = |height: f64| limits.iter().flatten().any(|(limit, _)| *limit == height);
    let held: Vec<&(usize, usize)> = (runs.0.iter())
        .filter(|(first, length)| {
            let share = *length as f64 / z.len() as f64;
            *length >= HELD.0.max(HELD.1 * usual) && share >= HELD_SHARE && !is_limit(z[*first])
        })
        .collect();
    let (first, longest) = held.iter().max_by_key(|(_, length)| *length)?;
    Some(Doubt::from(SurfaceDoubt::HeldHeights {
        count: held.len(),
        at_m: *first as f64 * step_m,
        longest_m: *longest as f64 * step_m,
    }))
}

/// The doubt about points that stand out of their neighbours on both sides by more than the profile is high elsewhere.
fn spikes(z: &[f64], sorted: &[f64], step_m: f64) -> Option<Doubt> {
    let beyond = (sorted.len() as f64 * (1.0 - USUAL_SHARE) / 2.0).ceil() as usize;
    let usual_m = sorted.get(sorted.len() - 1 - beyond)? - sorted.get(beyond)?;
    let mut changes: Vec<f64> = z.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    changes.sort_unstable_by(f64::total_cmp);
    let least_m = usual_m.max(USUAL_CHANGES * changes.get(changes.len() / 2)?);
    if least_m <= 0.0 {
        return None;
    }
    let stands_out = |i: usize| {
        (1..=SPIKE_POINTS).find_map(|k| {
            let (before, after) = (z.get(i.checked_sub(k)?)?, z.get(i + k)?);
            let (left, right) = (z[i] - before, z[i] - after);
            (left * right > 0.0 && left.abs().min(right.abs()) > least_m)
                .then_some(left.abs().min(right.abs()))
        })
    };
    let mut count = 0;
    let mut highest: Option<(usize, f64)> = None;
    let mut last = None;
    for (i, height_m) in (0..z.len()).filter_map(|i| Some((i, stands_out(i)?))) {
        if last.is_none_or(|last| i > last + SPIKE_POINTS) {
            count += 1;
        }
        last = Some(i);
        if highest.is_none_or(|(_, most)| height_m > most) {
            highest = Some((i, height_m));
        }
    }
    let (at, height_m) = highest?;
    Some(Doubt::from(SurfaceDoubt::Spikes {
        count,
        at_m: at as f64 * step_m,
        height_m,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rough(change: impl Fn(usize, f64) -> f64) -> Vec<String> {
        let mut state = 5u64;
        let mut z = 0.0;
        let heights = (0..4000)
            .map(|i| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                z = 0.9 * z + 1e-6 * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
                // an instrument rounds to 4 nm
                change(i, (z / 4e-9).round() * 4e-9)
            })
            .collect();
        let profile = HeightProfile::new(heights, 1e-6).unwrap();
        of_heights(&profile)
            .iter()
            .map(|doubt| doubt.code.to_string())
            .collect()
    }

    #[test]
    fn what_an_instrument_did_not_measure_is_named() {
        assert_eq!(rough(|_, z| z), [""; 0]);
        let spiky = |i, z| if i == 1000 || i == 2500 { z + 40e-6 } else { z };
        assert_eq!(rough(spiky), ["spikes"]);
        // two points wide, and downwards
        assert_eq!(
            rough(|i, z| if i == 70 || i == 71 { z - 40e-6 } else { z }),
            ["spikes"]
        );
        assert_eq!(rough(|_, z| z.min(0.8e-6)), ["saturated_heights"]);
        assert_eq!(
            rough(|i, z| if (900..960).contains(&i) { 0.0 } else { z }),
            ["held_heights"]
        );
        // grooves and steps are surfaces
        assert_eq!(
            rough(|i, z| if (900..1400).contains(&i) {
                z - 90e-6
            } else {
                z
            }),
            [""; 0]
        );
        let squares: Vec<f64> = (0..4000).map(|i| f64::from(i / 50 % 2) * 1e-6).collect();
        assert_eq!(of_heights(&HeightProfile::new(squares, 1e-6).unwrap()), []);
        assert_eq!(
            of_heights(&HeightProfile::new(vec![1e-6; 100], 1e-6).unwrap()),
            []
        );
    }

    #[test]
    fn slopes_of_swapped_units_are_those_of_no_surface() {
        assert_eq!(of_slope(0.6), None);
        assert_eq!(of_slope(0.0), None);
        assert!(of_slope(687_855.0).is_some());
        assert!(of_slope(6e-7).is_some());
    }
}
