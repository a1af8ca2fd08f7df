//! Epochs in sentences, tables and a report.

use piezotact::figure::{Axis, Chart, Figure, Line, Scale, Tone};
use piezotact::number::{counted, digits, rounded};
use piezotact::page::{Block, Cell, Column, Page, Table};

use super::EegEpochs;
use crate::eeg::person::Positions;
use crate::eeg::prepare::{EpochCounts, EyeMethod, PrepareConfig};

/// Channels that are drawn where they were recorded.
pub(in crate::eeg) const DRAWN: [&str; 3] = ["C3", "Cz", "C4"];

/// The channels that figures show: C3, Cz and C4 where they are there, else the first three.
pub(in crate::eeg) fn drawn_channels(channels: &[String]) -> Vec<usize> {
    let known: Vec<usize> = DRAWN
        .iter()
        .filter_map(|name| {
            channels
                .iter()
                .position(|own| own.eq_ignore_ascii_case(name))
        })
        .collect();
    match known.is_empty() {
        true => (0..channels.len().min(DRAWN.len())).collect(),
        false => known,
    }
}

impl PrepareConfig {
    /// How epochs were made, one step a line.
    #[must_use]
    pub fn steps(&self) -> Vec<String> {
        let mut steps: Vec<String> = self.filters.iter().map(ToString::to_string).collect();
        steps.push(format!(
            "Epochs from {} s to {} s around each marker, none across a gap",
            signed(self.extent.start_s),
            signed(self.extent.end_s)
        ));
        if !self.eog.is_empty() {
            let eog = self.eog.join(", ");
            steps.push(match &self.eyes {
                EyeMethod::Regression => format!("Eye movements: regression on {eog}"),
                EyeMethod::Components(ica) => format!(
                    "Eye movements: {} independent components (FastICA, seed {}); taken out are those whose correlation with {eog} is at least {}",
                    ica.components,
                    ica.seed,
                    rounded(ica.least_correlation)
                ),
            });
        }
        if !self.interpolated.is_empty() {
            steps.push(format!(
                "Interpolated by spherical splines: {}",
                self.interpolated.join(", ")
            ));
        }
        steps.push(format!("Reference: {}", self.reference));
        let criteria: Vec<String> = self.criteria.iter().map(ToString::to_string).collect();
        steps.push(match criteria.is_empty() {
            true => "No epoch was rejected".to_owned(),
            false => format!(
                "Epochs rejected in which a channel has {}",
                criteria.join(" or ")
            ),
        });
        steps
    }
}

fn signed(value: f64) -> String {
    rounded(value).replace('-', "−")
}

impl EpochCounts {
    /// How many epochs of each condition are kept, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let each = self.conditions.iter().map(|count| {
            format!(
                "{} {} of {} (rejected {}, not whole {})",
                count.condition, count.kept, count.markers, count.rejected, count.left_out
            )
        });
        format!("Epochs kept: {}", each.collect::<Vec<_>>().join("; "))
    }

    /// Epochs by condition.
    #[must_use]
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            Column::new("condition", "condition"),
            Column::new("markers", "markers"),
            Column::new("kept", "kept"),
            Column::new("rejected", "rejected"),
            Column::new("not whole", "not_whole"),
        ]);
        table.rows = self
            .conditions
            .iter()
            .map(|count| {
                let numbers = [count.markers, count.kept, count.rejected, count.left_out];
                let mut row = vec![Cell::from(count.condition.as_str())];
                row.extend(numbers.map(|number| Cell::Text(number.to_string())));
                row
            })
            .collect();
        table
    }

    /// Markers without an epoch that counts, with a sentence above them; nothing where there is none.
    pub(in crate::eeg) fn refused_blocks(&self) -> Vec<Block> {
        let text = "Markers without an epoch, and epochs that were rejected:".to_owned();
        let table = self.refused_table();
        let blocks = table.map(|table| [Block::Text { text }, Block::Table(table)]);
        blocks.into_iter().flatten().collect()
    }

    /// Markers without an epoch that counts, with the reason; `None` where there is none.
    #[must_use]
    pub fn refused_table(&self) -> Option<Table> {
        let mut table = Table::new([
            Column::new("marker at, s", "onset_s"),
            Column::new("condition", "condition"),
            Column::new("channel", "channel"),
            Column::new("reason", "reason"),
            Column::new("found, µV", "found_uv"),
        ]);
        let whole = self.not_whole.iter().map(|one| {
            let reason = one.reason.to_string();
            let row = vec![
                Cell::Text(rounded(one.onset_s)),
                Cell::from(one.condition.as_str()),
                Cell::from(None),
                Cell::from(reason),
                Cell::from(None),
            ];
            (one.onset_s, row)
        });
        let rejected = self.rejected.iter().map(|one| {
            let row = vec![
                Cell::Text(rounded(one.onset_s)),
                Cell::from(one.condition.as_str()),
                Cell::Text(match one.channels {
                    0 | 1 => one.channel.clone(),
                    several => format!("{} and {} more", one.channel, several - 1),
                }),
                Cell::from(one.criterion.to_string()),
                Cell::from(1e6 * one.found_v),
            ];
            (one.onset_s, row)
        });
        let mut rows: Vec<(f64, Vec<Cell>)> = whole.chain(rejected).collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        table.rows = rows.into_iter().map(|(_, row)| row).collect();
        (!table.rows.is_empty()).then_some(table)
    }
}

impl EegEpochs {
    /// How many epochs there are, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let kept: usize = self.counts.conditions.iter().map(|count| count.kept).sum();
        format!(
            "{} of {} kept of {}, {} at {} Hz",
            kept,
            counted(
                self.counts.conditions.iter().map(|c| c.markers).sum(),
                "epoch"
            ),
            self.subject,
            counted(self.channels.len(), "electrode"),
            rounded(self.rate_hz.hz())
        )
    }

    /// The averages: one row for each condition, channel and time.
    #[must_use]
    pub fn evoked_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("condition", "condition"),
            Column::new("channel", "channel"),
            Column::new("time, s", "time_s"),
            Column::new("mean, V", "mean_v"),
            Column::new("standard error, V", "error_v"),
        ]);
        for evoked in &self.evoked {
            for (channel, name) in self.channels.iter().enumerate() {
                let values = evoked.mean_v[channel].iter().zip(&evoked.error_v[channel]);
                for (time, (mean, error)) in self.times_s.iter().zip(values) {
                    table.rows.push(vec![
                        Cell::from(evoked.condition.as_str()),
                        Cell::from(name.as_str()),
                        Cell::from(*time),
                        Cell::from(*mean),
                        Cell::from(*error),
                    ]);
                }
            }
        }
        table
    }

    fn evoked_figure(&self, channel: usize) -> Figure {
        let tones = Tone::several(self.evoked.len());
        let lines = self.evoked.iter().zip(tones).map(|(evoked, tone)| {
            let values = || self.times_s.iter().zip(&evoked.mean_v[channel]);
            let errors = values().zip(&evoked.error_v[channel]);
            let ribbon = errors.map(|((t, v), e)| (*t, 1e6 * (v - e), 1e6 * (v + e)));
            let points = values().map(|(t, v)| (*t, 1e6 * v)).collect();
            Line::new(
                format!("{} ({})", evoked.condition, evoked.epochs),
                tone,
                points,
            )
            .ribbon(ribbon.collect())
        });
        let lines: Vec<Line> = lines.collect();
        let reach = lines
            .iter()
            .flat_map(|line| &line.ribbon)
            .map(|(_, low, high)| low.abs().max(high.abs()));
        let reach = 1.08 * reach.fold(f64::MIN_POSITIVE, f64::max);
        let times = Axis {
            low: self.times_s[0],
            high: self.times_s[self.times_s.len() - 1],
            ..Axis::around(
                "time from the marker, s",
                Scale::Linear,
                self.times_s.iter().copied(),
            )
        };
        let name = &self.channels[channel];
        let unit = match &self.config.reference {
            crate::eeg::prepare::Reference::CurrentSourceDensity(_) => "µV/m²",
            _ => "µV",
        };
        let label = format!("{name}, {unit}");
        let before = self.baseline_s.map_or_else(
            || "no baseline was taken away".to_owned(),
            |[from, to]| {
                format!(
                    "each epoch less its mean from {} s to {} s",
                    signed(from),
                    signed(to)
                )
            },
        );
        Chart::new(times, Axis::new(label, -reach, reach), lines).captioned(format!(
            "Average of the epochs of each condition at {name} (number of epochs in brackets), ± standard error; positive up; {before}."
        ))
    }

    /// The report.
    #[must_use]
    pub fn page(&self) -> Page {
        let conclusion = Block::Conclusion {
            text: self.sentence(),
            outcome: None,
        };
        let steps = Block::Steps {
            steps: self.config.steps(),
        };
        let components = self.eye_components.iter().flat_map(|found| {
            // A name without a position is no error.
            let positions = Positions::OfNames.of(&found.channels);
            found.blocks(&positions.unwrap_or_default())
        });
        let components: Vec<Block> = components.collect();
        let mut counts = vec![Block::Table(self.counts.table())];
        counts.extend(self.counts.refused_blocks());
        let figures = drawn_channels(&self.channels).into_iter();
        let figures: Vec<Block> = figures
            .map(|channel| Block::Figure(self.evoked_figure(channel)))
            .collect();
        Page::new(
            format!("EEG epochs: {}", self.file),
            self.subject.to_string(),
        )
        .section(
            "",
            [
                conclusion,
                Block::Text {
                    text: self.counts.sentence(),
                },
            ],
        )
        .section("How epochs were made", [steps])
        .section("Independent components", components)
        .section("Epochs by condition", counts)
        .section("Evoked responses", figures)
        .warnings(&self.warnings)
    }

    /// The largest average at each drawn channel, one sentence for each condition.
    #[must_use]
    pub fn peak_sentences(&self) -> Vec<String> {
        let of = |evoked: &super::Evoked| {
            let peaks = drawn_channels(&self.channels)
                .into_iter()
                .filter_map(|channel| {
                    let values = self.times_s.iter().zip(&evoked.mean_v[channel]);
                    let (t, v) = values.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
                    Some(format!(
                        "{} {} µV at {} s",
                        self.channels[channel],
                        digits(1e6 * v),
                        rounded(*t)
                    ))
                });
            let peaks: Vec<String> = peaks.collect();
            let text = format!("{}: largest average {}", evoked.condition, peaks.join(", "));
            text.replace('-', "−")
        };
        self.evoked.iter().map(of).collect()
    }
}
