//! The figures of a report on a panel, one function for each.

use super::levels::Own;
use super::{
    AnalysedPanel, Cell, CellAverage, CellSpread, Cleaning, Entry, Filing, Panel, PanelAnalysis,
};
use crate::figure::{Axis, Chart, Figure, Line, Mark, Panels, Scale, Tone};
use crate::number::counted;
use crate::quantity::{Band, Degrees, Newtons, Uncalibrated, Unit};
use crate::transfer::{BundleAverage, TransferFunction};

/// A curve over frequency: Hz, and the value there.
type Curve = Vec<(f64, f64)>;
type Measured = Entry<Uncalibrated, Uncalibrated>;

/// One among many.
const SINGLE: Tone = Tone::Pale;
const MEAN: Tone = Tone::Reference;
const MEASURED: Tone = Tone::Main;
/// The odd one.
const OUTSIDE: Tone = Tone::Accent;
/// Where people lie furthest apart.
const WIDEST: Tone = Tone::Signal;

/// Below this, two frequencies, loads or angles are one.
const SAME: f64 = 1e-9;

fn frequency(band: Band) -> Axis {
    Axis::log("frequency, Hz", band.low().0.max(1.0), band.high().0)
}

fn unit_name(unit: &Unit) -> String {
    match unit {
        Unit::FullScale => "full scale".into(),
        Unit::MetrePerSecondSquared => "(m/s²)".into(),
        other => other.to_string(),
    }
}

fn values(lines: &[Line]) -> impl Iterator<Item = f64> {
    lines
        .iter()
        .flat_map(|line| line.points.iter().map(|point| point.1))
}

fn over_frequency(band: Band, label: &str, lines: Vec<Line>) -> Chart {
    let y = Axis::around(label, Scale::Linear, values(&lines));
    Chart::new(frequency(band), y, lines).beside()
}

fn coloured(lines: Vec<(String, Curve)>) -> Vec<Line> {
    let colours = Tone::several(lines.len());
    let lines = lines.into_iter().zip(colours).enumerate();
    lines
        .map(|(i, ((label, points), colour))| {
            let line = Line::new(label, colour, points);
            // Neighbours among many colours look alike: dashes distinguish them.
            match i % 2 {
                1 => line.marked(Mark::Dashed),
                _ => line,
            }
        })
        .collect()
}

/// A curve without the line at 0 Hz.
fn zipped(frequencies_hz: &[f64], values: &[f64]) -> Curve {
    let points = frequencies_hz.iter().copied().zip(values.iter().copied());
    points.filter(|(hz, _)| *hz > 0.0).collect()
}

/// The measurements of the participant and cell with most of them; among equal counts those in the cell `judged`, then the first.
fn most_measured(
    panel: &Panel<Uncalibrated, Uncalibrated>,
    judged: Option<Cell>,
) -> Vec<&Measured> {
    let cells = panel.cells().iter();
    let groups = panel
        .participants()
        .iter()
        .flat_map(|who| cells.clone().map(move |cell| (who, *cell)));
    let rank = |(who, cell): &(&String, Cell)| {
        let in_judged = judged.is_some_and(|judged| judged.is(*cell));
        (panel.of(who, *cell).count(), in_judged)
    };
    let most = groups.reduce(|most, next| {
        if rank(&most) >= rank(&next) {
            most
        } else {
            next
        }
    });
    most.map_or_else(Vec::new, |(who, cell)| panel.of(who, cell).collect())
}

fn average_db(average: &CellAverage, averaging: BundleAverage) -> &[f64] {
    match averaging {
        BundleAverage::LogMagnitude => &average.log_magnitude_db,
        BundleAverage::Complex => &average.complex_db,
    }
}

fn distinct(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() < SAME);
    values
}

/// The counterpart of figures 68 and 77.
pub(super) fn deviations(said: &PanelAnalysis) -> Figure {
    let loads = distinct(said.spreads.iter().map(|s| s.cell.load_n.0).collect());
    let angles = distinct(said.spreads.iter().map(|s| s.cell.angle_deg.0).collect());
    let colours = Tone::several(angles.len());
    let at_angle = |angle_deg: f64| {
        let points = loads.iter().enumerate().filter_map(|(i, load_n)| {
            let cell = Cell {
                load_n: Newtons(*load_n),
                angle_deg: Degrees(angle_deg),
            };
            let spread = said.spreads.iter().find(|s| s.cell.is(cell))?;
            Some((i as f64, spread.bundle.max_deviation_db))
        });
        points.collect()
    };
    let lines: Vec<Line> = angles
        .iter()
        .zip(colours)
        .map(|(angle_deg, colour)| {
            Line::new(format!("{angle_deg}°"), colour, at_angle(*angle_deg)).marked(Mark::Joined)
        })
        .collect();
    let highest = values(&lines).fold(0.0, f64::max);
    let names = loads.iter().map(|load| format!("{load} N")).collect();
    // From zero: a step is seen as large as it is.
    let y = Axis::new("maximum deviation, dB", 0.0, (highest * 1.15).max(0.1));
    Chart::new(Axis::names("load", names), y, lines)
        .beside()
        .captioned(
            "Maximum deviation by load and angle: the largest distance between the highest and the lowest curve over the band.",
        )
}

pub(super) fn spreads(said: &PanelAnalysis) -> Figure {
    let lines = said.spreads.iter().map(|spread| {
        let points = zipped(&spread.bundle.frequencies_hz, &spread.bundle.spread_db);
        (spread.cell.to_string(), points)
    });
    let label = "standard deviation over participants, dB";
    over_frequency(said.config.band, label, coloured(lines.collect())).captioned(
        "Spread by frequency: standard deviation over participants at each spectral line.",
    )
}

pub(super) fn penalties(average: &CellAverage, said: &PanelAnalysis) -> Figure {
    let costs = average.penalties_of(said.config.averaging);
    let people = costs.people.iter().enumerate();
    let points = people.map(|(i, person)| (i as f64, person.db_rms));
    let line = Line::new("", MEASURED, points.collect()).marked(Mark::Dots);
    let criterion_db = said.config.criterion.db_rms;
    let highest = values(std::slice::from_ref(&line)).fold(criterion_db, f64::max);
    let names = costs.people.iter().map(|p| p.participant.clone()).collect();
    let y = Axis::new("error of the average, dB rms", 0.0, highest * 1.15);
    let x = Axis::names("participant left out of the average", names);
    let mut chart = Chart::new(x, y, vec![line]);
    chart.levels.push(criterion_db);
    chart.captioned(
        "Error of the average for each participant: the average of all others compared with the participant's own transfer \
         function, rms over the band. Red: the criterion.",
    )
}

/// The learning curve of the cell that is judged.
pub(super) fn learning(said: &PanelAnalysis) -> Option<Figure> {
    let judged = said.judged()?;
    let curve = said.learning.iter().find(|curve| judged.is(curve.cell))?;
    let names = curve.points.iter().map(|p| p.people.to_string()).collect();
    let points = curve.points.iter().enumerate();
    let points = points.map(|(i, p)| (i as f64, p.mean_db_rms));
    let line = Line::new("", MEASURED, points.collect()).marked(Mark::Joined);
    let highest = values(std::slice::from_ref(&line)).fold(0.0, f64::max);
    let y = Axis::new(
        "error for a new participant, mean, dB rms",
        0.0,
        (highest * 1.1).max(0.1),
    );
    let x = Axis::names("participants in the average", names);
    let how = match curve.orders {
        0 => "over all subsets of the others".to_owned(),
        orders => format!("over {orders} random orders of the others for each participant"),
    };
    Some(Chart::new(x, y, vec![line]).captioned(format!(
        "Number of participants needed at {}, {how}.",
        curve.cell
    )))
}

impl AnalysedPanel<'_> {
    /// The level of a participant in one cell.
    fn own(&self, who: &str, cell: Cell) -> Option<Curve> {
        let levels = &self.analysis.levels;
        Some(zipped(&levels.frequencies_hz, levels.named(who, cell)?))
    }

    /// The level of one measurement over the band that is analysed.
    fn level(&self, function: &TransferFunction<Uncalibrated, Uncalibrated>) -> Curve {
        let own = Own::of(function, self.analysis.config.band);
        zipped(&self.analysis.levels.frequencies_hz, &own.db)
    }

    /// Magnitudes over the band that is analysed, on one scale in all figures: around all participants in all conditions, and
    /// `lines`.
    fn magnitudes(&self, lines: Vec<Line>) -> Chart {
        let [drive, response] = self.units.map(unit_name);
        let label = format!("magnitude, dB re 1 {response}/{drive}");
        let spreads = self.analysis.spreads.iter();
        let ends =
            spreads.flat_map(|one| one.bundle.lowest_db.iter().chain(&one.bundle.highest_db));
        let all = ends.copied().chain(values(&lines));
        let y = Axis::around(label, Scale::Linear, all);
        Chart::new(frequency(self.analysis.config.band), y, lines).beside()
    }

    /// The counterpart of figures 67 and 76: everybody, and the average.
    pub(super) fn bundle(&self, spread: &CellSpread) -> Figure {
        let mut lines = Vec::new();
        let mut outside = Vec::new();
        for person in &spread.people {
            let who = &person.participant;
            let points = self.own(who, spread.cell).unwrap_or_default();
            match person.is_odd {
                true => outside.push(Line::new(who.as_str(), OUTSIDE, points)),
                false => lines.push(Line::new("", SINGLE, points).thin()),
            }
        }
        if let Some(first) = lines.first_mut() {
            first.label = "each participant".into();
        }
        lines.extend(outside);
        let mut averages = self.analysis.averages.iter();
        if let Some(average) = averages.find(|a| a.cell.is(spread.cell)) {
            let db = average_db(average, self.analysis.config.averaging);
            let points = zipped(&average.frequencies_hz, db);
            lines.push(Line::new("average", MEAN, points));
        }
        let mut chart = self.magnitudes(lines);
        let bundle = &spread.bundle;
        let at_hz = bundle.max_deviation_at_hz;
        let mut lines_hz = bundle.frequencies_hz.iter();
        if let Some(line) = lines_hz.position(|hz| (hz - at_hz).abs() < SAME) {
            let ends = (at_hz, bundle.lowest_db[line], bundle.highest_db[line]);
            let widest = Line::new("maximum deviation", WIDEST, Vec::new());
            chart.lines.push(widest.spread(vec![ends]));
        }
        chart.captioned(format!(
            "{}: {} and their average; maximum deviation {:.1} dB at {at_hz:.0} Hz (marked).",
            spread.cell,
            counted(bundle.count, "participant"),
            bundle.max_deviation_db,
        ))
    }

    /// Everybody in all conditions.
    pub(super) fn all(&self) -> Figure {
        let cells = &self.analysis.cells;
        let mut lines = Vec::new();
        for (cell, colour) in cells.iter().zip(Tone::several(cells.len())) {
            let mut label = cell.to_string();
            for who in &self.analysis.participants {
                if let Some(points) = self.own(who, *cell) {
                    lines.push(Line::new(std::mem::take(&mut label), colour, points).thin());
                }
            }
        }
        let all = &self.analysis.all;
        self.magnitudes(lines).captioned(format!(
            "All participants at all loads and angles, {} curves; maximum deviation {:.1} dB at {:.0} Hz.",
            all.count, all.max_deviation_db, all.max_deviation_at_hz
        ))
    }

    /// The first participant who was measured in all of `cells`, with a curve for each.
    fn example(&self, cells: &[(String, Cell)]) -> Option<(String, Chart)> {
        if cells.len() < 2 {
            return None;
        }
        let complete = |who: &&String| {
            let mut cells = cells.iter();
            cells.all(|(_, cell)| self.analysis.levels.named(who, *cell).is_some())
        };
        let who = self.analysis.participants.iter().find(complete)?;
        let lines = cells.iter();
        let lines = lines.filter_map(|(name, cell)| Some((name.clone(), self.own(who, *cell)?)));
        Some((who.clone(), self.magnitudes(coloured(lines.collect()))))
    }

    /// The counterpart of figures 22, 70a and 74.
    pub(super) fn person_by_load(&self, angle_deg: f64) -> Option<Figure> {
        let cells = self.analysis.cells.iter();
        let cells: Vec<(String, Cell)> = cells
            .filter(|cell| (cell.angle_deg.0 - angle_deg).abs() < SAME)
            .map(|cell| (cell.load_n.to_string(), *cell))
            .collect();
        let (who, chart) = self.example(&cells)?;
        Some(chart.captioned(format!(
            "{who} by load, {angle_deg}°: the first participant who was measured at every load."
        )))
    }

    /// The counterpart of figure 75.
    pub(super) fn person_by_angle(&self, load_n: f64) -> Option<Figure> {
        let cells = self.analysis.cells.iter();
        let cells: Vec<(String, Cell)> = cells
            .filter(|cell| (cell.load_n.0 - load_n).abs() < SAME)
            .map(|cell| (format!("{}°", cell.angle_deg.0), *cell))
            .collect();
        let (who, chart) = self.example(&cells)?;
        Some(chart.captioned(format!(
            "{who} by angle, {load_n} N: the first participant who was measured at every angle."
        )))
    }

    /// The counterpart of figure 70b.
    pub(super) fn averages_by_load(&self, angle_deg: f64) -> Figure {
        let averaging = self.analysis.config.averaging;
        let averages = self.analysis.averages.iter();
        let lines = averages
            .filter(|average| (average.cell.angle_deg.0 - angle_deg).abs() < SAME)
            .map(|average| {
                let points = zipped(&average.frequencies_hz, average_db(average, averaging));
                (average.cell.load_n.to_string(), points)
            });
        self.magnitudes(coloured(lines.collect()))
            .captioned(format!(
                "Averages by load, {angle_deg}°: the {} over participants.",
                averaging.name()
            ))
    }

    /// The counterpart of figure 78: magnitudes and coherences of the participant and cell with most measurements; `None` where nobody
    /// was measured twice in one cell.
    pub(super) fn repeats(&self) -> Option<Figure> {
        let each = most_measured(self.panel, self.analysis.judged());
        let [first, _, ..] = each[..] else {
            return None;
        };
        let of = |curve: &dyn Fn(&Measured) -> Curve| {
            let named = each.iter().map(|entry| {
                let Filing {
                    placement, repeat, ..
                } = entry.filing;
                let name = format!("placement {placement}, repeat {repeat}");
                (name, curve(entry))
            });
            coloured(named.collect())
        };
        let band = self.analysis.config.band;
        let mut lines = of(&|entry| {
            let lines = entry.function.lines_in(band);
            let coherence = lines.map(|(line, _)| entry.function.coherence()[line]);
            let frequencies_hz = &self.analysis.levels.frequencies_hz;
            zipped(frequencies_hz, &coherence.collect::<Vec<_>>())
        });
        for line in &mut lines {
            line.label.clear();
        }
        let lowest = values(&lines).fold(1.0, f64::min);
        let low = if lowest > 0.9 { 0.9 } else { 0.0 };
        let axis = Axis::new("coherence", low, 1.005);
        let coherence = Chart::new(frequency(band), axis, lines);
        let magnitudes = self.magnitudes(of(&|entry| self.level(&entry.function)));
        Some(
            Panels::new(vec![magnitudes, coherence]).captioned(format!(
                "Repeats of one finger: {} measurements of {} at {}. Coherence: the share of the response power that the drive explains \
                 linearly.",
                each.len(),
                first.filing.participant,
                first.filing.cell
            )),
        )
    }

    /// Both kinds of average in one cell.
    pub(super) fn both_averages(&self, average: &CellAverage) -> Figure {
        let lines = [
            ("log magnitudes", &average.log_magnitude_db),
            ("complex", &average.complex_db),
        ];
        let lines = lines.map(|(name, db)| (name.to_owned(), zipped(&average.frequencies_hz, db)));
        self.magnitudes(coloured(lines.into()))
            .captioned(format!("Both averages at {}.", average.cell))
    }

    /// The counterpart of figure 71: the control, and a finger before and after.
    pub(super) fn cleaned(&self, cleaning: &Cleaning) -> Vec<Figure> {
        let control = Line::new("", MEASURED, self.level(&cleaning.control));
        let label = "magnitude of the control, dB";
        let mut chart = over_frequency(self.analysis.config.band, label, vec![control]);
        let window = cleaning.artefact.window_hz;
        chart.shaded.push((window.low().0, window.high().0));
        let mut drawn = vec![chart.captioned(
            "The control measurement, without a finger. Shaded: the band in which the dip is divided out.",
        )];
        let both = cleaning
            .example_before
            .as_ref()
            .zip(self.panel.entries().first());
        drawn.extend(both.map(|(before, after)| {
            let lines = vec![
                Line::new("before", SINGLE, self.level(before)).thick(),
                Line::new("after", MEASURED, self.level(&after.function)),
            ];
            self.magnitudes(lines)
                .captioned("A finger before and after: the first measurement of the panel.")
        }));
        drawn
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex;

    use super::*;
    use crate::panel::{PanelConfig, analyse};
    use crate::quantity::{Hertz, SampleRate};
    use crate::transfer::Estimator;

    /// A flat measurement at a level; no two are the same bit by bit, as no two measurements are.
    fn flat(who: &str, load_n: f64, [placement, repeat]: [u32; 2], level_db: f64) -> Measured {
        let own = f64::from(10 * placement + repeat) * 1e-12;
        let lines = vec![Complex::from(10f64.powf((level_db + own) / 20.0)); 201];
        let rate = SampleRate::new(2_000.0).unwrap();
        let coherence = vec![0.9; 201];
        let mut function =
            TransferFunction::from_lines(lines, coherence, 5.0, rate, Estimator::H1, 100).unwrap();
        let filing = Filing {
            participant: who.into(),
            cell: cell(load_n),
            placement,
            repeat,
        };
        function.about.condition.participant = Some(who.into());
        function.about.condition.load_n = Some(filing.cell.load_n);
        function.about.condition.angle_deg = Some(filing.cell.angle_deg);
        Entry { filing, function }
    }

    fn cell(load_n: f64) -> Cell {
        let (load_n, angle_deg) = (Newtons(load_n), Degrees(20.0));
        Cell { load_n, angle_deg }
    }

    /// Two repeats of one placement count as much as the one of another: 6 dB and (0 dB, 0 dB) are 3 dB, not 2.
    #[test]
    fn own_curves_average_placements_not_measurements() {
        let panel = Panel::new(vec![
            flat("P1", 0.2, [1, 1], 0.0),
            flat("P1", 0.2, [1, 2], 0.0),
            flat("P1", 0.2, [2, 1], 6.0),
            flat("P2", 0.2, [1, 1], 1.0),
        ])
        .unwrap();
        let band = Band::new(Hertz(20.0), Hertz(900.0)).unwrap();
        let said = analyse(&panel, &PanelConfig::usual(band, 1)).unwrap();
        let own = said.levels.named("P1", cell(0.2)).unwrap();
        assert!(own.iter().all(|db| (db - 3.0).abs() < 1e-6), "{own:?}");
        let hz = &said.levels.frequencies_hz;
        assert!((hz[0] - 20.0).abs() < 1e-9 && (hz[own.len() - 1] - 900.0).abs() < 1e-9);
        assert_eq!(said.levels.named("P1", cell(0.4)), None);
        assert_eq!(said.levels.named("P3", cell(0.2)), None);
        let most = most_measured(&panel, said.judged());
        assert_eq!(most.len(), 3);
        assert_eq!(
            (
                most[2].filing.participant.as_str(),
                most[2].filing.placement
            ),
            ("P1", 2)
        );
    }

    /// Of equally many repeats, those in the worst case are shown, whoever comes first.
    #[test]
    fn repeats_are_those_of_the_worst_case() {
        let people = [("P1", 1), ("P2", 1), ("P2", 2), ("P3", 1)];
        let loads = [0.2, 0.6].into_iter();
        let entries = loads.flat_map(|load| people.map(|(who, n)| flat(who, load, [1, n], load)));
        let panel = Panel::new(
            entries
                .enumerate()
                .map(|(i, mut entry)| {
                    entry.function = entry
                        .function
                        .times(|_| Complex::from(1.0 + i as f64 * 1e-9));
                    entry
                })
                .collect(),
        )
        .unwrap();
        for judged in [0.2, 0.6] {
            let most = most_measured(&panel, Some(cell(judged)));
            assert_eq!((most.len(), most[0].filing.participant.as_str()), (2, "P2"));
            assert!(most[0].filing.cell.is(cell(judged)));
        }
    }
}
