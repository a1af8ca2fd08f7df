//! What an alignment says: sentences, figures, a table, and the report.

use super::{AlignedBy, AlignedRecording, Alignment, BlockPlace, BurstPlace, Which};
use crate::figure::{Axis, Chart, Figure, Line, Mark, Scale, Tone};
use crate::number::{counted, digits, plus, rounded, signed};
use crate::page::{Block, Cell, Column, Number, Page, Shown, Table};
use crate::quantity::Seconds;

impl Alignment {
    /// A place on both clocks against the line, µs.
    fn residual_us(&self, recorded_s: Seconds, drive_s: Seconds) -> f64 {
        1e6 * (drive_s.0 - self.on_drive(recorded_s).0)
    }

    /// What the line was drawn with, in words.
    fn drawn_by(&self) -> String {
        match self.by {
            AlignedBy::Bursts => "both bursts".to_owned(),
            AlignedBy::Blocks => {
                let used = self.blocks.iter().filter(|block| block.used).count();
                counted(used, "block")
            }
        }
    }

    /// Offset, drift and their uncertainty in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let [low, high] = self.drift_interval_ppm;
        let half_ms = 0.5e3 * (self.offset_interval_s[1].0 - self.offset_interval_s[0].0);
        format!(
            "the first sample of the recording is at {:.6} s ± {} ms of the drive, its clock runs at {} ppm ({} to {}); times are certain to ±{} ms \
             (95 %, by {})",
            self.offset_s.0,
            digits(half_ms),
            plus(self.drift_ppm, 2),
            plus(low, 2),
            plus(high, 2),
            digits(1e3 * self.uncertainty_s.0),
            self.drawn_by()
        )
        .replace(" -", " −")
    }

    /// How much of the drive was recorded, in one sentence.
    #[must_use]
    pub fn covered_sentence(&self) -> String {
        let [from, to] = self.covered_s;
        format!(
            "it holds {:.3} s to {:.3} s of a drive of {:.3} s",
            from.0, to.0, self.drive_length_s.0
        )
    }
}

fn name(which: Which) -> &'static str {
    match which {
        Which::First => "first burst",
        Which::Last => "last burst",
    }
}

impl Shown for AlignedRecording {
    fn page(&self) -> Page {
        let found = &self.alignment;
        let [low, high] = found.drift_interval_ppm;
        let half_us = 0.5e6 * (found.offset_interval_s[1].0 - found.offset_interval_s[0].0);
        let numbers = vec![
            Number::new(
                format!("{} s", signed(found.offset_s.0, 6)),
                format!(
                    "first sample of the recording on the clock of the drive, ±{} µs",
                    digits(half_us)
                ),
            ),
            Number::new(
                format!("{} ppm", plus(found.drift_ppm, 2)),
                format!(
                    "drift of its clock, {} to {} (95 %)",
                    plus(low, 2),
                    plus(high, 2)
                ),
            ),
            Number::new(
                format!("±{} µs", digits(1e6 * found.uncertainty_s.0)),
                "largest uncertainty of a time in the recording (95 %)",
            ),
            Number::new(
                format!("{:.3} s", found.covered_s[1].0 - found.covered_s[0].0),
                format!("of the drive recorded, of {:.3} s", found.drive_length_s.0),
            ),
        ];
        let conclusion = Block::Conclusion {
            text: format!("By {}: {}.", found.drawn_by(), found.covered_sentence()),
            outcome: None,
        };
        let origin = format!(
            "{} ({}, {}) on the clock of {} ({}, {})",
            self.recording.file,
            self.recording.channel,
            self.recording.rate_hz,
            self.drive.file,
            self.drive.channel,
            self.drive.rate_hz
        );
        let mut places = Vec::new();
        places.extend(self.residuals().map(Block::Figure));
        places.extend(self.correlations().map(Block::Figure));
        let mut page = Page::new("Recording on the clock of its drive", origin)
            .section("", [conclusion, Block::Numbers { numbers }])
            .section("Residuals from the line", places);
        if let Some(bursts) = self.bursts_table() {
            page = page.section("Bursts", [Block::Table(bursts)]);
        }
        let text = self.method();
        page.rows(self.table())
            .warnings(&found.warnings)
            .section("Method", [Block::Note { text }])
    }
}

impl AlignedRecording {
    /// The places of blocks and bursts, one in a row.
    #[must_use]
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            Column::new("what", "what"),
            Column::new("middle in the recording, s", "recorded_s"),
            Column::new("middle in the drive, s", "drive_s"),
            Column::new("residual from the line, µs", "residual_us"),
            Column::new("correlation", "correlation"),
            Column::new("used", "used"),
        ]);
        let word = |used| if used { "yes" } else { "no" };
        let by_bursts = self.alignment.by == AlignedBy::Bursts;
        let bursts = self.alignment.bursts.iter();
        let bursts = bursts.map(|one| {
            let times = (one.recorded_s, one.drive_s);
            self.row(name(one.which), times, one.correlation, word(by_bursts))
        });
        let blocks = self.alignment.blocks.iter();
        let blocks = blocks.map(|one| {
            let times = (one.recorded_s, one.drive_s);
            self.row("block", times, one.correlation, word(one.used))
        });
        table.rows = bursts.chain(blocks).collect();
        table
    }

    fn row(
        &self,
        what: &str,
        (recorded_s, drive_s): (Seconds, Seconds),
        correlation: f64,
        used: &'static str,
    ) -> Vec<Cell> {
        let residual_us = self.alignment.residual_us(recorded_s, drive_s);
        vec![
            Cell::from(what),
            Cell::from(recorded_s.0),
            Cell::from(drive_s.0),
            Cell::from(residual_us),
            Cell::from(correlation),
            Cell::from(used),
        ]
    }

    fn bursts_table(&self) -> Option<Table> {
        let bursts = &self.alignment.bursts;
        let mut table = Table::new([
            Column::new("burst", "burst"),
            Column::new("middle in the recording, s", "recorded_s"),
            Column::new("middle in the drive, s", "drive_s"),
            Column::new("residual from the line, µs", "residual_us"),
            Column::new("standard error, µs", "error_us"),
            Column::new("correlation", "correlation"),
        ]);
        table.rows = bursts
            .iter()
            .map(|one| {
                vec![
                    Cell::from(match one.which {
                        Which::First => "first",
                        Which::Last => "last",
                    }),
                    Cell::Text(format!("{:.6}", one.recorded_s.0)),
                    Cell::Text(format!("{:.6}", one.drive_s.0)),
                    Cell::from(self.alignment.residual_us(one.recorded_s, one.drive_s)),
                    Cell::from(1e6 * one.error_s.0),
                    Cell::from(one.correlation),
                ]
            })
            .collect();
        (!bursts.is_empty()).then_some(table)
    }

    /// Each place against the line over time, with the interval of the line.
    fn residuals(&self) -> Option<Figure> {
        let found = &self.alignment;
        let block = |one: &BlockPlace| {
            (
                one.recorded_s.0,
                found.residual_us(one.recorded_s, one.drive_s),
            )
        };
        let burst = |one: &BurstPlace| {
            (
                one.recorded_s.0,
                found.residual_us(one.recorded_s, one.drive_s),
            )
        };
        let bursts: Vec<_> = found.bursts.iter().map(burst).collect();
        let ribbon = found.intervals_s.iter();
        let ribbon: Vec<_> = ribbon
            .map(|(at, half)| (at.0, -1e6 * half.0, 1e6 * half.0))
            .collect();
        let ends = [0.0, self.recording.length_s.0].map(|at_s| (at_s, 0.0));
        let line = Line::new("line, with its 95 % interval", Tone::Reference, ends.into());
        let mut lines = vec![line.ribbon(ribbon)];
        lines.extend(self.blocks_by_use(block));
        if !bursts.is_empty() {
            let bars = found.bursts.iter().zip(&bursts).map(|(one, (at, value))| {
                let half = 1.96e6 * one.error_s.0;
                (*at, value - half, value + half)
            });
            let bars = bars.collect();
            let line = Line::new("bursts, with their 95 % intervals", Tone::Accent, bursts);
            lines.push(line.marked(Mark::Dots).spread(bars));
        }
        let values = lines.iter().flat_map(|line| {
            let areas = line.ribbon.iter().chain(&line.spread);
            let areas = areas.flat_map(|(_, low, high)| [*low, *high]);
            line.points.iter().map(|point| point.1).chain(areas)
        });
        // A single block far away would hide all others; it is in the table.
        let mut sizes: Vec<f64> = values.map(f64::abs).collect();
        sizes.sort_by(f64::total_cmp);
        let usual = sizes
            .get(sizes.len() * 9 / 10)
            .copied()
            .unwrap_or(1.0)
            .max(1.0);
        let reach = 1.15
            * sizes
                .last()
                .copied()
                .unwrap_or(1.0)
                .clamp(1.0, 12.0 * usual);
        let outside: usize = lines
            .iter_mut()
            .map(|line| {
                let before = line.points.len();
                line.points.retain(|(_, value)| value.abs() <= reach);
                line.spread
                    .retain(|(_, low, high)| low.abs().max(high.abs()) <= reach);
                before - line.points.len()
            })
            .sum();
        lines.retain(|line| !line.points.is_empty());
        let x = Axis::new("time of the recording, s", 0.0, self.recording.length_s.0);
        let y = Axis::new("residual from the line, µs", -reach, reach);
        let hidden = match outside {
            0 => String::new(),
            count => format!(" {} outside the figure.", counted(count, "place")),
        };
        (self.recording.length_s.0 > 0.0).then(|| {
            Chart::new(x, y, lines).captioned(format!(
                "Where each block was found in the drive, less where the line has it. Above 0: later in the drive.{hidden}"
            ))
        })
    }

    /// The correlation of each block over time.
    fn correlations(&self) -> Option<Figure> {
        let found = &self.alignment;
        let mut lines: Vec<Line> = self
            .blocks_by_use(|one: &BlockPlace| (one.recorded_s.0, one.correlation))
            .collect();
        let bursts = found.bursts.iter();
        let bursts: Vec<_> = bursts
            .map(|one| (one.recorded_s.0, one.correlation))
            .collect();
        if !bursts.is_empty() {
            lines.push(Line::new("bursts", Tone::Accent, bursts).marked(Mark::Dots));
        }
        let x = Axis::new("time of the recording, s", 0.0, self.recording.length_s.0);
        let y = Axis {
            scale: Scale::Linear,
            ..Axis::new("correlation", 0.0, 1.05)
        };
        let is_empty = lines.is_empty();
        (!is_empty).then(|| {
            Chart::new(x, y, lines).captioned(
                "Correlation of the envelopes of each block and of the drive at its place. 1: the same except for scale and phase; a device that \
                 filters, and noise, lower it.",
            )
        })
    }

    /// Blocks that the line was drawn with, and others.
    fn blocks_by_use(
        &self,
        point: impl Fn(&BlockPlace) -> (f64, f64),
    ) -> impl Iterator<Item = Line> {
        let of = |used: bool| -> Vec<(f64, f64)> {
            let blocks = self.alignment.blocks.iter();
            blocks.filter(|one| one.used == used).map(&point).collect()
        };
        let others = match self.alignment.by {
            AlignedBy::Blocks => "blocks left out",
            AlignedBy::Bursts => "blocks, not used",
        };
        let both = [
            Line::new("blocks", Tone::Main, of(true)),
            Line::new(others, Tone::Second, of(false)),
        ];
        both.into_iter()
            .filter(|line| !line.points.is_empty())
            .map(|line| line.marked(Mark::Dots))
    }

    fn method(&self) -> String {
        let config = &self.alignment.config;
        let line = match self.alignment.by {
            AlignedBy::Blocks => {
                "offset and drift are the least-squares line through them without those further than five robust standard deviations, with \
                 Student's intervals"
            }
            AlignedBy::Bursts => {
                "offset and drift are the line through both bursts, whose standard errors follow from what differs between the answers to them"
            }
        };
        format!(
            "Drive and recording are limited to {} at the lower of their rates. Blocks of {} s are found by the envelope of the cross-correlation \
             over the energies of both parts; {line}. Drifts up to {} ppm were looked for; above 0 the clock of the recording runs faster. \
             The delay of the device is in the offset.",
            config.band,
            rounded(config.block_s.0),
            rounded(config.most_drift_ppm)
        )
    }
}
