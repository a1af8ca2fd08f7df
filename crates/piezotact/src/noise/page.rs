//! What noise says: sentences, table and report.

use super::{Noise, OTHER_LINE_DB, PARTS, SHORTEST_OF_DRIFT, STANDS_OUT_DB};
use crate::criterion::Outcome;
use crate::figure::{Axis, Chart, Line, Mark, Scale, Tone};
use crate::number::{counted, digits, rounded};
use crate::page::{Block, Cell, Column, Number, Page, Shown, Table};

impl Shown for Noise {
    fn page(&self) -> Page {
        let (unit, part_s) = (self.unit_text(), self.config.segment_s.0 / PARTS as f64);
        let mut numbers = vec![
            Number::new(
                format!("{} {unit}", digits(self.rms)),
                format!("rms over {}, everything included", self.config.band_hz),
            ),
            Number::new(
                format!("{} {unit}", digits(self.floor_rms)),
                "rms of the noise floor: without lines and short events",
            ),
        ];
        numbers.extend(self.densities.iter().map(|density| {
            Number::new(
                format!("{} {unit}/√Hz", digits(density.value)),
                format!(
                    "floor at {} Hz (median over a third octave)",
                    rounded(density.frequency_hz)
                ),
            )
        }));
        let conclusion = Block::Conclusion {
            text: format!("{}.", self.sentence()),
            outcome: Some(self.at_rest()),
        };
        let of_rest = self.criteria.iter().filter(|c| c.what.of_rest());
        let others = self.criteria.iter().filter(|c| !c.what.of_rest());
        let others: Vec<_> = others.collect();
        // Once each: 300 Hz is a multiple of 50 Hz and of 60 Hz.
        let others = (others.iter().enumerate())
            .filter(|(i, c)| others[..*i].iter().all(|before| before.what != c.what))
            .map(|(_, c)| *c);
        let note = format!(
            "PSD by Welch's method: Hann window, segments of {}, 50 % overlap, median of {}; the rms of everything is from their mean. Levels: rms above {} over quarters of a segment. Drift: least squares over the means of segments; the interval takes into account that neighbouring means are correlated. A line of the mains stands out when it is more than {STANDS_OUT_DB} dB above the floor around it with 95 % confidence. Other lines are named from {OTHER_LINE_DB} dB; they may come from a machine or from a steady motion. A motion whose level does not change, such as a finger that slides during the whole recording, cannot be distinguished from noise.",
            self.config.segment_s,
            counted(self.averages, "segment"),
            self.config.band_hz.low(),
        );
        Page::new(format!("Noise of {}", self.channel), &self.file)
            .section("", [conclusion, Block::Numbers { numbers }])
            .section(
                "Was the sensor at rest?",
                [
                    Block::Table(Table::of_criteria(of_rest)),
                    Block::Figure(
                        self.over_time("rms of parts", &self.levels, part_s, self.config.disturbed_parts())
                            .captioned(format!(
                                "Level of each part of {part_s} s, above {}. Without motion it is constant.",
                                self.config.band_hz.low()
                            )),
                    ),
                ],
            )
            .section("Spectrum", [Block::Figure(self.spectrum_figure())])
            .section(
                "Lines of the mains and drift",
                [
                    Block::conclusion(format!("{}.", self.mains_sentence()), None),
                    Block::conclusion(format!("{}.", self.drift_sentence()), None),
                    Block::Figure(
                        self.over_time("mean of parts", &self.means, self.config.segment_s.0, 0)
                            .captioned("Mean of each second of the recording: drift."),
                    ),
                    Block::Table(Table::of_criteria(others)),
                ],
            )
            .rows(self.spectrum_table())
            .warnings(&self.warnings)
            .section("Method", [Block::Note { text: note }])
    }
}

impl Noise {
    /// Whether the sensor was at rest.
    #[must_use]
    pub fn at_rest(&self) -> Outcome {
        let of_rest = self.criteria.iter().filter(|c| c.what.of_rest());
        Outcome::of_all(of_rest.map(|c| c.outcome))
    }

    /// The conclusion in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let unit = self.unit_text();
        let level = format!(
            "{} {unit} rms over {}, noise floor {} {unit} rms",
            digits(self.rms),
            self.config.band_hz,
            digits(self.floor_rms)
        );
        match self.at_rest() {
            Outcome::Met => format!("No sign of motion: {level}"),
            Outcome::NotMet => format!("The sensor was not at rest: {level}, motion included"),
            Outcome::NotDecided => {
                format!("Not decided whether the sensor was at rest: {level}")
            }
        }
    }

    fn unit_text(&self) -> &str {
        match self.unit.symbol() {
            "no unit" => "(no unit)",
            symbol => symbol,
        }
    }

    /// The lines of the mains in one sentence.
    #[must_use]
    pub fn mains_sentence(&self) -> String {
        let unit = self.unit_text();
        let found = self.mains.iter().filter_map(|line| Some((line, line.rms?)));
        let mut named: Vec<(f64, f64)> = found
            .map(|(line, rms)| (line.mains_hz * line.harmonic as f64, rms))
            .collect();
        named.sort_by(|a, b| a.0.total_cmp(&b.0));
        named.dedup_by(|a, b| a.0 == b.0);
        if named.is_empty() {
            return format!(
                "No line of the mains stands {STANDS_OUT_DB} dB over the floor with 95 % confidence"
            );
        }
        let named = named
            .iter()
            .map(|(hz, rms)| format!("{hz:.0} Hz {} {unit} rms", digits(*rms)));
        let named: Vec<String> = named.collect();
        format!("Hum of the mains: {}", named.join(", "))
    }

    /// The drift in one sentence.
    #[must_use]
    pub fn drift_sentence(&self) -> String {
        let (unit, least) = (self.unit_text(), SHORTEST_OF_DRIFT as f64);
        let Some(drift) = &self.drift else {
            let least_s = digits(least * self.config.segment_s.0);
            return format!("Drift is not decided: it needs {least_s} s or longer");
        };
        let interval = drift
            .slope_interval
            .map_or("not decided".into(), |[low, high]| {
                format!("{} to {}", digits(low), digits(high))
            });
        let (slope, range) = (digits(drift.slope), digits(drift.range));
        let text = format!(
            "The mean changes by {slope} {unit}/s (95 %: {interval}), range {range} {unit}"
        );
        text.replace('-', "−")
    }

    /// The PSD and the amplitude density by frequency: one row a line.
    fn spectrum_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("frequency, Hz", "frequency_hz"),
            Column::new(&format!("PSD, {}", self.unit.of_psd()), "psd"),
            Column::new(&self.density_label(), "amplitude_density"),
        ]);
        table.rows = (self.psd.iter().enumerate())
            .map(|(k, psd)| vec![k as f64 * self.resolution_hz, *psd, psd.sqrt()])
            .map(|row| row.into_iter().map(Cell::from).collect())
            .collect();
        table
    }

    fn density_label(&self) -> String {
        format!("amplitude density, {}/√Hz", self.unit_text())
    }

    fn spectrum_figure(&self) -> crate::figure::Figure {
        let (step_hz, last) = (self.resolution_hz, self.psd.len() - 1);
        let point = |k: usize| (k as f64 * step_hz, self.psd[k].sqrt());
        let above = |points: &(f64, f64)| points.1 > 0.0;
        let points: Vec<_> = (1..=last).map(point).filter(above).collect();
        let lines = self.mains.iter().filter(|line| line.rms.is_some());
        let lines = lines.map(|line| line.mains_hz * line.harmonic as f64 / step_hz);
        let lines = lines.map(|k| point(k.round() as usize)).filter(above);
        let y = points.iter().map(|point| point.1);
        let y = Axis::around(self.density_label(), Scale::Logarithmic, y);
        let x = Axis::log("frequency, Hz", step_hz, last as f64 * step_hz);
        let mut chart = Chart::new(x, y, vec![Line::new("noise", Tone::Main, points).thin()]);
        let lines = Line::new("lines of the mains", Tone::Second, lines.collect());
        if !lines.points.is_empty() {
            chart.lines.push(lines.marked(Mark::Dots));
        }
        chart.captioned("Amplitude density: the square root of the PSD.")
    }

    fn over_time(&self, what: &str, values: &[f64], part_s: f64, skipped: usize) -> Chart {
        let time = |i: usize| ((i + skipped) as f64 + 0.5) * part_s;
        let points: Vec<(f64, f64)> = (values.iter().enumerate())
            .map(|(i, value)| (time(i), *value))
            .collect();
        let label = format!("{what}, {}", self.unit_text());
        let y = Axis::around(label, Scale::Linear, values.iter().copied());
        let x = Axis::new("time, s", 0.0, self.duration_s.0);
        Chart::new(x, y, vec![Line::new("", Tone::Main, points)])
    }
}
