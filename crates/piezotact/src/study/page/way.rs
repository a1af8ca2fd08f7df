//! What freely moved strokes say along the way.

use super::figures;
use crate::compare::{SpatialPeriod, WaySpectrum};
use crate::number::digits;
use crate::page::{Block, Cell, Column, Table};
use crate::study::Group;

/// Peaks of a spectrum that the table names.
const NAMED: usize = 4;

/// The spectra of the groups whose motion was measured, and their lines.
pub(super) fn blocks(groups: &[Group]) -> Vec<Block> {
    let known = groups.iter().filter_map(|group| {
        let way = group.way.as_ref()?;
        Some((group.summary.name.as_str(), way))
    });
    let known: Vec<_> = known.collect();
    if known.is_empty() {
        return Vec::new();
    }
    let spectra: Vec<(&str, &WaySpectrum)> = (known.iter())
        .map(|(name, way)| (*name, &way.spectrum))
        .collect();
    let mut table = Table::new([
        Column::new("group", "group"),
        Column::new("highest peaks, 1/mm", "peaks_1_mm"),
        Column::new("spatial period, mm", "period_mm"),
        Column::new("from, mm", "period_from_mm"),
        Column::new("to, mm", "period_to_mm"),
        Column::new("outcome", "outcome"),
    ]);
    let rows = known.iter().map(|(name, way)| {
        let peaks = way.spectrum.peaks.iter().take(NAMED);
        let peaks = peaks.map(|peak| digits(peak.wavenumber_1_m * 1e-3));
        let period = way.period.as_ref();
        let mm = |of: &dyn Fn(&SpatialPeriod) -> Option<f64>| {
            let found = period.and_then(of);
            found.map_or(Cell::Missing(()), |m| Cell::rounded(m * 1e3, 3))
        };
        vec![
            Cell::from(*name),
            Cell::from(peaks.collect::<Vec<_>>().join(", ")),
            mm(&|period| Some(period.period_m)),
            mm(&|period| Some(period.interval_m?[0])),
            mm(&|period| Some(period.interval_m?[1])),
            period.map_or(Cell::Missing(()), |period| {
                Cell::from(period.outcome.word())
            }),
        ]
    });
    table.rows = rows.collect();
    let caption = "Mean power spectral density of each group over the way: the strokes resampled at equal ways, by the channel of \
                   speed or position.";
    vec![
        figures::along_the_way(&spectra).captioned(caption).into(),
        table.into(),
    ]
}
