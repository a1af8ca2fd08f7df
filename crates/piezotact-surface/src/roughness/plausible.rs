//! Heights that no surface has, or that an instrument did not measure: wrong units, spikes, saturation, drop-outs.

use super::{Extent as _, HeightMap, HeightProfile, HeightsFault, SurfaceWarning};
use piezotact::statistics::median;
use piezotact::warning::Warning;

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

/// The warning that a root-mean-square `slope` is that of no surface: the units of heights or steps are wrong.
pub(super) fn of_slope(slope: f64) -> Option<Warning> {
    let found = slope > 0.0 && !SLOPES.contains(&slope);
    found.then(|| {
        Warning::from(SurfaceWarning::Heights {
            fault: HeightsFault::Slope { slope },
        })
    })
}

/// The warnings about the heights of `profile` as they were read.
pub(super) fn of_heights(profile: &HeightProfile) -> Vec<Warning> {
    let z = profile.heights_m();
    let mut sorted = z.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
        return Vec::new();
    };
    if low >= high {
        return vec![Warning::from(SurfaceWarning::Heights {
            fault: HeightsFault::Flat,
        })];
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
    let cut = limits.into_iter().flatten().map(|(_, warning)| warning);
    spikes(z, &sorted, profile.step_m())
        .into_iter()
        .chain(cut)
        .chain(lost)
        .collect()
}

/// The warnings about the heights of `map` as they were read: points that stand out of their row and of their column, so that grooves
/// and ridges count for none.
pub(super) fn of_map(map: &HeightMap) -> Vec<Warning> {
    let (z, columns) = (map.heights_m(), map.columns());
    let mut sorted: Vec<f64> = z.iter().copied().filter(|z| !z.is_nan()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
        return Vec::new();
    };
    if low >= high {
        return vec![Warning::from(SurfaceWarning::Heights {
            fault: HeightsFault::Flat,
        })];
    }
    let rows = z.chunks_exact(columns);
    let changes = rows.flat_map(|row| row.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
    let Some(least_m) = least_of_spike(&sorted, changes) else {
        return Vec::new();
    };
    let along = |i: usize, by: usize, room: (usize, usize)| {
        (1..=SPIKE_POINTS).find_map(|k| {
            let inside = k <= room.0 && k <= room.1;
            let (before, after) = inside.then(|| (z[i - k * by], z[i + k * by]))?;
            out_of(z[i], before, after).filter(|height_m| *height_m > least_m)
        })
    };
    let mut count = 0;
    let mut highest: Option<(usize, f64)> = None;
    for i in 0..z.len() {
        let (x, y) = (i % columns, i / columns);
        let in_row = along(i, 1, (x, columns - 1 - x));
        let found =
            in_row.and_then(|in_row| Some(in_row.min(along(i, columns, (y, map.rows() - 1 - y))?)));
        let Some(height_m) = found else { continue };
        count += 1;
        if highest.is_none_or(|(_, most)| height_m > most) {
            highest = Some((i, height_m));
        }
    }
    let spike = highest.map(|(i, height_m)| {
        let (step_x_m, step_y_m) = map.steps_m();
        Warning::from(SurfaceWarning::Heights {
            fault: HeightsFault::MapSpikes {
                count,
                at_x_m: (i % columns) as f64 * step_x_m,
                at_y_m: (i / columns) as f64 * step_y_m,
                height_m,
            },
        })
    });
    spike.into_iter().collect()
}

/// How far a height stands out of the two beside it, m; `None` where it lies between them, or one is not measured.
fn out_of(height_m: f64, before_m: f64, after_m: f64) -> Option<f64> {
    let (left, right) = (height_m - before_m, height_m - after_m);
    (left * right > 0.0).then_some(left.abs().min(right.abs()))
}

/// The height from which a point is a spike, m, of heights in order and the sizes of their changes; `None` for flat ones.
fn least_of_spike(sorted: &[f64], changes: impl Iterator<Item = f64>) -> Option<f64> {
    let beyond = (sorted.len() as f64 * (1.0 - USUAL_SHARE) / 2.0).ceil() as usize;
    let usual_m = sorted.get(sorted.len().checked_sub(1 + beyond)?)? - sorted.get(beyond)?;
    let mut changes: Vec<f64> = changes.filter(|change| !change.is_nan()).collect();
    let least_m = usual_m.max(USUAL_CHANGES * median(&mut changes)?);
    (least_m > 0.0).then_some(least_m)
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

/// The limit and the warning that heights end at it; `at` says whether it is the highest or the lowest.
fn saturated(z: &[f64], runs: &Runs, limit: f64, at: &str) -> Option<(f64, Warning)> {
    let at_limit = runs.0.iter().filter(|(first, _)| z[*first] == limit);
    let (points, longest) = at_limit.fold((0, 0), |(points, longest), (_, length)| {
        (points + length, longest.max(*length))
    });
    let share = points as f64 / z.len() as f64;
    (share >= SATURATED.0 && longest >= SATURATED.1).then(|| {
        let warning = SurfaceWarning::Heights {
            fault: HeightsFault::Saturated {
                limit: at.into(),
                height_m: limit,
                share,
            },
        };
        (limit, Warning::from(warning))
    })
}

/// The warning that one value was held where nothing was measured.
fn drop_outs(
    z: &[f64],
    runs: &Runs,
    limits: &[Option<(f64, Warning)>; 2],
    step_m: f64,
) -> Option<Warning> {
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
    Some(Warning::from(SurfaceWarning::Heights {
        fault: HeightsFault::Held {
            count: held.len(),
            at_m: *first as f64 * step_m,
            longest_m: *longest as f64 * step_m,
        },
    }))
}

/// The warning about points that stand out of their neighbours on both sides by more than the profile is high elsewhere.
fn spikes(z: &[f64], sorted: &[f64], step_m: f64) -> Option<Warning> {
    let changes = z.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let least_m = least_of_spike(sorted, changes)?;
    let stands_out = |i: usize| {
        (1..=SPIKE_POINTS).find_map(|k| {
            let (before, after) = (z.get(i.checked_sub(k)?)?, z.get(i + k)?);
            out_of(z[i], *before, *after).filter(|height_m| *height_m > least_m)
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
    Some(Warning::from(SurfaceWarning::Heights {
        fault: HeightsFault::Spikes {
            count,
            at_m: at as f64 * step_m,
            height_m,
        },
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is wrong with heights.
    fn fault(warning: &Warning) -> String {
        assert_eq!(warning.code, "heights_doubtful");
        warning.fields["fault"].as_str().unwrap().to_owned()
    }

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
        of_heights(&profile).iter().map(fault).collect()
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
        assert_eq!(rough(|_, z| z.min(0.8e-6)), ["saturated"]);
        assert_eq!(
            rough(|i, z| if (900..960).contains(&i) { 0.0 } else { z }),
            ["held"]
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
        let flat = of_heights(&HeightProfile::new(vec![1e-6; 100], 1e-6).unwrap());
        assert_eq!(
            flat,
            [Warning::from(SurfaceWarning::Heights {
                fault: HeightsFault::Flat
            })]
        );
    }

    #[test]
    fn spikes_of_a_map_stand_out_of_their_row_and_of_their_column() {
        let map = |change: &dyn Fn(usize, usize, f64) -> f64| {
            let mut state = 9u64;
            let heights = (0..120 * 80).map(|i| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                let z = 1e-6 * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
                change(i % 120, i / 120, z)
            });
            HeightMap::new(heights.collect(), 120, 1e-6, 2e-6).unwrap()
        };
        let codes = |change: &dyn Fn(usize, usize, f64) -> f64| -> Vec<String> {
            let warnings = of_map(&map(change));
            warnings.iter().map(fault).collect()
        };
        assert_eq!(codes(&|_, _, z| z), [""; 0]);
        let spike = |x, y, z| if (x, y) == (40, 30) { z + 40e-6 } else { z };
        let found = of_map(&map(&spike));
        let Some(SurfaceWarning::Heights {
            fault:
                HeightsFault::MapSpikes {
                    count,
                    at_x_m,
                    at_y_m,
                    height_m,
                },
        }) = found[0].kind()
        else {
            panic!("{found:?}");
        };
        assert_eq!(count, 1);
        assert!((at_x_m - 40e-6).abs() < 1e-12 && (at_y_m - 60e-6).abs() < 1e-12);
        assert!((height_m - 40e-6).abs() < 1.1e-6);
        // A narrow groove and a narrow ridge are surfaces.
        assert_eq!(
            codes(&|x, _, z| if x == 50 { z - 40e-6 } else { z }),
            [""; 0]
        );
        assert_eq!(
            codes(&|_, y, z| if y == 50 { z + 40e-6 } else { z }),
            [""; 0]
        );
        assert_eq!(codes(&|_, _, _| 0.0), ["flat"]);
        // Points that were not measured are none.
        assert_eq!(
            codes(&|x, y, z| if (x, y) == (40, 30) { f64::NAN } else { z }),
            [""; 0]
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
