//! The reports of a calibration and of a latency.

use super::{InputCalibration, LatencySummary, SensorMethod, SoundCalibration, VoltsMethod};
use crate::figure::{Axis, Chart, Figure, Line, Mark, Tone};
use crate::number::{counted, digits, rounded};
use crate::page::{Block, Cell, Column, Number, Page, Shown, Table};
use crate::quantity::Seconds;

impl Shown for SoundCalibration {
    fn page(&self) -> Page {
        let mut numbers = Vec::new();
        if let Some(output) = &self.output {
            let method = match output.method {
                VoltsMethod::Voltmeter {
                    read_v_rms,
                    played_rms,
                } => format!(
                    "by a voltmeter: {} V rms for a tone of {} rms",
                    digits(read_v_rms),
                    digits(played_rms)
                ),
                VoltsMethod::Loopback {
                    input_v_per_full_scale,
                    gain,
                } => format!(
                    "by the loopback: {} V peak at full scale of the input, times {}",
                    digits(input_v_per_full_scale),
                    digits(gain.abs())
                ),
            };
            numbers.push(Number::new(
                format!("{} V", digits(output.v_per_full_scale)),
                format!("peak at the output at full scale, {method}"),
            ));
        }
        if let Some(loopback) = &self.loopback {
            let polarity = if loopback.gain < 0.0 {
                "inverted"
            } else {
                "not inverted"
            };
            numbers.push(Number::new(
                digits(loopback.gain.abs()),
                format!(
                    "recorded per played value of the loopback at {} Hz, {polarity}",
                    rounded(loopback.frequency_hz.0)
                ),
            ));
        }
        let missing = [
            ("the output was not calibrated", self.output.is_none()),
            ("there is no loopback", self.loopback.is_none()),
            ("no input has a scale", self.inputs.is_empty()),
        ];
        let missing: Vec<&str> = missing
            .iter()
            .filter(|(_, is)| *is)
            .map(|(what, _)| *what)
            .collect();
        let text = match missing.as_slice() {
            [] => "Output, loopback and inputs have their levels.".to_owned(),
            missing => format!("Not complete: {}.", missing.join("; ")),
        };
        let conclusion = Block::Conclusion {
            text,
            outcome: None,
        };
        let origin = format!(
            "{} at {}, calibrated on {}",
            self.device, self.rate_hz, self.made_on
        );
        let mut first = vec![conclusion];
        if !numbers.is_empty() {
            first.push(Block::Numbers { numbers });
        }
        let mut page = Page::new("Calibration of a sound device", origin).section("", first);
        if !self.inputs.is_empty() {
            page = page.section("Inputs", [Block::Table(self.inputs_table())]);
        }
        if !self.wires.is_empty() {
            page = page.section("Cables", [Block::Table(self.wires_table())]);
        }
        page.warnings(&self.warnings).section(
            "Method",
            [Block::Note {
                text: "Full scale is a peak of 1 in the samples. The level of the loopback is compared with this one whenever the device is \
                       opened, and refused where it is more than 0.1 dB off."
                    .into(),
            }],
        )
    }
}

impl SoundCalibration {
    fn inputs_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("input", "input"),
            Column::new("channel of recordings", "channel"),
            Column::new("at full scale", "per_full_scale"),
            Column::new("unit", "unit"),
            Column::new("found by", "method"),
            Column::new("calibrated on", "made_on"),
        ]);
        let row = |input: &InputCalibration| {
            let made = input.made.as_ref().map_or(&self.made_on, |made| &made.date);
            let method = match &input.method {
                SensorMethod::Exciter {
                    exciter,
                    above_residual_db,
                    ..
                } => format!(
                    "calibrator, {} {} rms at {}; the tone stood {} dB above the noise",
                    digits(exciter.rms),
                    input.unit,
                    exciter.frequency_hz,
                    rounded(above_residual_db.round())
                ),
                SensorMethod::Stated {
                    v_per_unit,
                    input_v_per_full_scale,
                } => format!(
                    "data sheet: {} mV per {}, {} V at full scale",
                    digits(1e3 * v_per_unit),
                    input.unit,
                    digits(*input_v_per_full_scale)
                ),
            };
            vec![
                Cell::Text(input.channel.to_string()),
                Cell::from(input.name.as_str()),
                Cell::from(input.per_full_scale),
                Cell::Text(input.unit.to_string()),
                Cell::Text(method),
                Cell::Text(made.clone()),
            ]
        };
        table.rows = self.inputs.iter().map(row).collect();
        table
    }

    fn wires_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("output", "output"),
            Column::new("input", "input"),
            Column::new("recorded per played peak", "gain"),
        ]);
        let wires = self.wires.iter().map(|wire| {
            vec![
                Cell::Text(wire.output.to_string()),
                Cell::Text(wire.input.to_string()),
                Cell::from(wire.gain),
            ]
        });
        table.rows = wires.collect();
        table
    }
}

impl Shown for LatencySummary {
    fn page(&self) -> Page {
        let ms = |s: Seconds| format!("{} ms", digits(1e3 * s.0));
        let dropped: u64 = self.runs.iter().map(|run| run.drop_outs).sum();
        let mut numbers = Vec::new();
        if let Some(latency) = &self.latency {
            numbers.push(Number::new(
                ms(latency.median_s),
                "median from output to input",
            ));
            if self.has_percentiles() {
                let of = |share| format!("{share} % of the restarts were not slower");
                numbers.push(Number::new(ms(latency.p95_s), of(95)));
                numbers.push(Number::new(ms(latency.p99_s), of(99)));
            }
            let [low, high] = latency.range_s;
            let sample_s = 1.0 / self.rate_hz.hz();
            let apart = match high.0 - low.0 {
                apart if apart < sample_s => "less than a sample".to_owned(),
                apart => ms(Seconds(apart)),
            };
            numbers.push(Number::new(
                apart,
                format!(
                    "between the shortest ({}) and the longest ({}); a sample is {} µs",
                    ms(low),
                    ms(high),
                    digits(1e6 * sample_s)
                ),
            ));
        }
        numbers.push(Number::new(
            dropped.to_string(),
            "drop-outs in all restarts",
        ));
        let restarts = counted(self.runs.len(), "restart");
        let text = match (self.scatter_s(), self.latency) {
            (Some(scatter), _) => format!(
                "In {} of {restarts} the latency was measured. Corrected by the median, no time was off by more than {}.",
                self.found(),
                ms(scatter)
            ),
            (None, Some(_)) => {
                format!("Measured once in {restarts}: nothing is known of its spread.")
            }
            (None, None) => format!(
                "The latency could not be measured: the loopback held the signal in none of {restarts}."
            ),
        };
        let conclusion = Block::Conclusion {
            text,
            outcome: None,
        };
        let origin = format!(
            "{} at {}, buffers of {} frames, measured on {}",
            self.device, self.rate_hz, self.buffer_frames, self.measured_on
        );
        let figures = self.over_restarts().map(Block::Figure);
        Page::new("Latency of a sound device", origin)
            .section("", [conclusion, Block::Numbers { numbers }])
            .section("Restarts", figures)
            .warnings(&self.warnings)
            .section(
                "Method",
                [Block::Note {
                    text: "The streams are started anew each time, and a burst of noise is looked for in the loopback: from the sample handed to the \
                           output to the sample taken in, converters and buffers included. A percentile is the smallest measured latency that at \
                           least so many restarts did not exceed; below 50 restarts none is stated."
                        .into(),
                }],
            )
    }
}

impl LatencySummary {
    /// The latency of each restart.
    fn over_restarts(&self) -> Option<Figure> {
        let latency = self.latency.as_ref()?;
        let point = |(i, s): (usize, Option<Seconds>)| Some(((i + 1) as f64, 1e3 * s?.0));
        let found = self.runs.iter().map(|run| run.latency_s).enumerate();
        let points: Vec<(f64, f64)> = found.filter_map(point).collect();
        let count = self.runs.len() as f64;
        let median_ms = 1e3 * latency.median_s.0;
        let ends = [0.5, count + 0.5].map(|at| (at, median_ms));
        let lines = vec![
            Line::new("median", Tone::Reference, ends.into()),
            Line::new("restarts", Tone::Main, points).marked(Mark::Dots),
        ];
        let [low, high] = latency.range_s.map(|s| 1e3 * s.0);
        let margin = (0.1 * (high - low)).max(0.01 * high).max(0.01);
        let x = Axis::new("restart", 0.5, count + 0.5);
        let y = Axis::new("output to input, ms", low - margin, high + margin);
        Some(Chart::new(x, y, lines).captioned(
            "The latency of each restart. Steps of a buffer are usual where a sound server starts output and input one after the other.",
        ))
    }
}
