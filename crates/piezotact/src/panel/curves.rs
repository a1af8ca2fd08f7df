//! The curves of a panel, as its figures show them.

use super::{Cell, Cleaning, Filing, Panel, PanelAnalysis, PanelError};
use crate::quantity::{Band, Decibels, Quantity, Uncalibrated};
use crate::transfer::TransferFunction;

/// A curve over frequency: Hz, and the value there.
pub type Curve = Vec<(f64, f64)>;

/// The curves of a panel over the band of its analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelCurves {
    /// The level of each participant in each cell, participant by participant.
    pub own: Vec<OwnCurve>,
    /// The measurements of the participant and cell with most of them, in the worst case if it is one of these; absent where
    /// nobody was measured twice in one cell.
    pub repeats: Option<RepeatCurves>,
    /// What a control measurement took away; absent without one.
    pub cleaning: Option<CleaningCurves>,
}

/// The level of one participant in one cell, averaged over repeats and placements.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnCurve {
    pub participant: String,
    pub cell: Cell,
    /// The magnitude of the average, dB.
    pub level_db: Curve,
}

/// All measurements of one participant in one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatCurves {
    pub participant: String,
    pub cell: Cell,
    pub each: Vec<RepeatCurve>,
}

/// One measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatCurve {
    pub filing: Filing,
    pub level_db: Curve,
    /// Its coherence, 0–1.
    pub coherence: Curve,
}

/// A control measurement, and a measurement before and after it was compensated.
#[derive(Clone, Debug, PartialEq)]
pub struct CleaningCurves {
    /// The magnitude of the control, dB.
    pub control_db: Curve,
    /// The magnitudes of the first measurement before and after, dB.
    pub example_db: Option<[Curve; 2]>,
}

impl PanelCurves {
    /// The level of one participant in one cell; `None` where there is no measurement.
    #[must_use]
    pub fn own_db(&self, participant: &str, cell: Cell) -> Option<&Curve> {
        let there = |own: &&OwnCurve| own.participant == participant && own.cell.is(cell);
        Some(&self.own.iter().find(there)?.level_db)
    }
}

/// The curves of `panel` in dB and as coherence over the band of its analysis `said`, and those of its `cleaning`.
///
/// Formula: 20·lg|H|, H averaged first over the repeats of a placement, then over placements, as [`Panel::person`] does.
///
/// Source: thesis figures 22, 67, 70, 71, 74 to 76 and 78.
///
/// # Errors
/// Those of [`Panel::person`].
pub fn panel_curves(
    panel: &Panel<Uncalibrated, Uncalibrated>,
    said: &PanelAnalysis,
    cleaning: Option<&Cleaning>,
) -> Result<PanelCurves, PanelError> {
    let band = said.config.band;
    let mut own = Vec::new();
    for participant in panel.participants() {
        for cell in panel.cells() {
            let function = panel.person(participant, *cell, said.config.averaging)?;
            own.extend(function.map(|function| OwnCurve {
                participant: participant.clone(),
                cell: *cell,
                level_db: level_db(&function, band),
            }));
        }
    }
    Ok(PanelCurves {
        own,
        repeats: repeats_of(panel, said.judged(), band),
        cleaning: cleaning.map(|cleaning| {
            let after = panel.entries().first().map(|entry| &entry.function);
            let both = cleaning.example_before.as_ref().zip(after);
            CleaningCurves {
                control_db: level_db(&cleaning.control, band),
                example_db: both
                    .map(|(before, after)| [before, after].map(|one| level_db(one, band))),
            }
        }),
    })
}

/// The measurements of the participant and cell with most of them; among equal counts those in the cell `judged`, then the first.
fn repeats_of<I: Quantity, O: Quantity>(
    panel: &Panel<I, O>,
    judged: Option<Cell>,
    band: Band,
) -> Option<RepeatCurves> {
    let groups = panel.participants().iter().flat_map(|who| {
        let cells = panel.cells().iter();
        cells.map(move |cell| (who, *cell))
    });
    let rank = |(who, cell): &(&String, Cell)| {
        let in_judged = judged.is_some_and(|judged| judged.is(*cell));
        (panel.of(who, *cell).count(), in_judged)
    };
    let (participant, cell) = groups.reduce(|most, next| {
        if rank(&most) >= rank(&next) {
            most
        } else {
            next
        }
    })?;
    let each: Vec<RepeatCurve> = panel
        .of(participant, cell)
        .map(|entry| {
            let function = &entry.function;
            let lines = function.lines_in(band).filter(|(_, hz)| *hz > 0.0);
            RepeatCurve {
                filing: entry.filing.clone(),
                level_db: level_db(function, band),
                coherence: lines
                    .map(|(line, hz)| (hz, function.coherence()[line]))
                    .collect(),
            }
        })
        .collect();
    (each.len() > 1).then(|| RepeatCurves {
        participant: participant.clone(),
        cell,
        each,
    })
}

/// The levels of the lines of a band, without the one at 0 Hz, dB.
fn level_db<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>, band: Band) -> Curve {
    function
        .lines_in(band)
        .filter(|(_, hz)| *hz > 0.0)
        .map(|(line, hz)| {
            let magnitude = function.response()[line].norm().max(f64::MIN_POSITIVE);
            (hz, Decibels::from_amplitude_ratio(magnitude).0)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex;

    use super::super::{Entry, PanelConfig, analyse};
    use super::*;
    use crate::quantity::{Degrees, Hertz, Newtons, SampleRate};
    use crate::transfer::Estimator;

    type AnyPanel = Panel<Uncalibrated, Uncalibrated>;

    fn cell(load_n: f64) -> Cell {
        Cell {
            load_n: Newtons(load_n),
            angle_deg: Degrees(20.0),
        }
    }

    /// A flat measurement at a level; no two are the same bit by bit, as no two measurements are.
    fn flat(
        who: &str,
        load_n: f64,
        [placement, repeat]: [u32; 2],
        level_db: f64,
    ) -> Entry<Uncalibrated, Uncalibrated> {
        let own = f64::from(10 * placement + repeat) * 1e-12;
        let line = Complex::from(10f64.powf((level_db + own) / 20.0));
        let rate = SampleRate::new(2_000.0).unwrap();
        let coherence = 0.9 + f64::from(placement) / 100.0;
        let mut function = TransferFunction::from_lines(
            vec![line; 201],
            vec![coherence; 201],
            5.0,
            rate,
            Estimator::H1,
            100,
        )
        .unwrap();
        let cell = cell(load_n);
        function.about.condition.participant = Some(who.into());
        function.about.condition.load_n = Some(cell.load_n);
        function.about.condition.angle_deg = Some(cell.angle_deg);
        let filing = Filing {
            participant: who.into(),
            cell,
            placement,
            repeat,
        };
        Entry { filing, function }
    }

    fn curves(entries: Vec<Entry<Uncalibrated, Uncalibrated>>) -> PanelCurves {
        let panel: AnyPanel = Panel::new(entries).unwrap();
        let band = Band::new(Hertz(20.0), Hertz(900.0)).unwrap();
        let said = analyse(&panel, &PanelConfig::usual(band, 1)).unwrap();
        panel_curves(&panel, &said, None).unwrap()
    }

    /// Two repeats of one placement count as much as the one of another: 6 dB and (0 dB, 0 dB) are 3 dB, not 2.
    #[test]
    fn own_curves_average_placements_not_measurements() {
        let found = curves(vec![
            flat("P1", 0.2, [1, 1], 0.0),
            flat("P1", 0.2, [1, 2], 0.0),
            flat("P1", 0.2, [2, 1], 6.0),
            flat("P2", 0.2, [1, 1], 1.0),
        ]);
        let own = found.own_db("P1", cell(0.2)).unwrap();
        assert!((own[0].0 - 20.0).abs() < 1e-9 && (own.last().unwrap().0 - 900.0).abs() < 1e-9);
        assert!(own.iter().all(|(_, db)| (db - 3.0).abs() < 1e-6), "{own:?}");
        assert_eq!(found.own_db("P1", cell(0.4)), None);
        assert_eq!(found.own_db("P3", cell(0.2)), None);
        let repeats = found.repeats.unwrap();
        assert_eq!(
            (repeats.participant.as_str(), repeats.each.len()),
            ("P1", 3)
        );
        assert_eq!(repeats.each[2].filing.placement, 2);
        assert!((repeats.each[2].coherence[0].1 - 0.92).abs() < 1e-9);
        assert!((repeats.each[2].level_db[0].1 - 6.0).abs() < 1e-6);
    }

    /// Of equally many repeats, those in the worst case are shown, whoever comes first; of single measurements, none.
    #[test]
    fn repeats_are_those_of_the_worst_case() {
        let twice = |load_n: f64, levels_db: [f64; 3]| {
            let people = ["P1", "P2", "P3"].into_iter().zip(levels_db);
            people.flat_map(move |(who, db)| {
                let first = flat(who, load_n, [1, 1], db + load_n);
                let second = (who == "P2").then(|| flat(who, load_n, [1, 2], db + load_n));
                std::iter::once(first).chain(second)
            })
        };
        let entries = twice(0.2, [0.0, 1.0, 2.0]).chain(twice(0.6, [0.0, 3.0, 9.0]));
        let repeats = curves(entries.collect()).repeats.unwrap();
        assert_eq!(repeats.participant, "P2");
        assert!(repeats.cell.is(cell(0.6)));
        let once = [0.0, 1.0, 2.0].into_iter().zip(["P1", "P2", "P3"]);
        let once = once.map(|(db, who)| flat(who, 0.2, [1, 1], db));
        assert_eq!(curves(once.collect()).repeats, None);
    }
}
