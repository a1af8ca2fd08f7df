//! Changes on the scalp, and over time and frequency, as maps.

use piezotact::Warning;
use piezotact::figure::{Axis, MapGround, MapPanel};

use super::{Electrode, FEWEST_OF_A_MAP};
use crate::eeg::reference::{Interpolation, Montage, map_positions};

/// Points across a scalp map.
const SIDE: usize = 161;
/// The angle from the top at which the square of a map ends, degrees, and the one at which the head is drawn.
const EDGE_DEG: f64 = 110.0;
const HEAD_DEG: f64 = 90.0;
/// A point further from every electrode than this has no value, degrees.
const FAR_DEG: f64 = 30.0;

/// A map of values at electrodes on the scalp, interpolated by a spherical spline where an electrode is within 30°; no map of fewer than
/// eight electrodes, or of electrodes that determine none.
pub(in crate::eeg) fn head_map(
    title: String,
    electrodes: &[Electrode],
    values: &[f64],
) -> Option<(MapPanel, Vec<Warning>)> {
    if electrodes.len() < FEWEST_OF_A_MAP || values.len() != electrodes.len() {
        return None;
    }
    let names = electrodes.iter().map(|one| one.name.clone()).collect();
    let positions = electrodes.iter().map(|one| one.position).collect();
    let montage = Montage::new(names, positions).ok()?;
    let near: Vec<(usize, [f64; 3])> = map_positions(SIDE)
        .into_iter()
        .filter(|(_, position)| is_near(&montage, position))
        .collect();
    let at: Vec<[f64; 3]> = near.iter().map(|(_, position)| *position).collect();
    let plan = Interpolation::plan(&montage, &at).ok()?;
    let found = plan.apply(values).ok()?;
    let mut all = vec![f64::NAN; SIDE * SIDE];
    for ((index, _), value) in near.iter().zip(found) {
        all[*index] = value;
    }
    let panel = MapPanel {
        title,
        values: all,
        columns: SIDE,
        ground: MapGround::Head {
            electrodes: electrodes.iter().map(seen_from_above).collect(),
            radius: HEAD_DEG / EDGE_DEG,
        },
    };
    Some((panel, plan.warnings))
}

fn is_near(montage: &Montage, position: &[f64; 3]) -> bool {
    let least = FAR_DEG.to_radians().cos();
    montage.positions.iter().any(|own| {
        let cosine: f64 = own.iter().zip(position).map(|(a, b)| a * b).sum();
        cosine >= least
    })
}

/// Where an electrode is on the map: azimuthal equidistant, as the positions of the map.
fn seen_from_above(electrode: &Electrode) -> (f64, f64, String) {
    let [x, y, z] = electrode.position;
    let angle = z.clamp(-1.0, 1.0).acos().to_degrees();
    let flat = x.hypot(y);
    let share = if flat > 0.0 {
        angle / EDGE_DEG / flat
    } else {
        0.0
    };
    (x * share, y * share, electrode.name.clone())
}

/// The change at one electrode over time and frequency: `decibels` is frequencies × times, from the lowest frequency up.
pub(in crate::eeg) fn time_frequency_panel(
    title: String,
    times_s: &[f64],
    frequencies_hz: &[f64],
    decibels: &[f64],
    outlined: Vec<[f64; 4]>,
) -> Option<MapPanel> {
    let columns = times_s.len();
    if columns < 2 || decibels.len() != columns * frequencies_hz.len() {
        return None;
    }
    let rows = decibels.chunks_exact(columns).rev();
    let step_s = times_s[1] - times_s[0];
    // Rows of one height: frequencies are evenly spaced or there is one.
    let step_hz = match frequencies_hz {
        [first, second, ..] => second - first,
        _ => 1.0,
    };
    let (low, high) = (frequencies_hz[0], frequencies_hz[frequencies_hz.len() - 1]);
    Some(MapPanel {
        title,
        values: rows.flatten().copied().collect(),
        columns,
        ground: MapGround::Axes {
            x: Axis::new(
                "time from the marker, s",
                times_s[0] - 0.5 * step_s,
                times_s[columns - 1] + 0.5 * step_s,
            ),
            y: Axis::new("frequency, Hz", low - 0.5 * step_hz, high + 0.5 * step_hz),
            marked: vec![0.0],
            outlined,
        },
    })
}
