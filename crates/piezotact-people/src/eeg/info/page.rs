//! What a file of EEG holds, in sentences, tables and a report.

use piezotact::number::{counted, digits, plus, rounded};
use piezotact::page::{Block, Cell, Column, Number, Page, Table};

use super::{ChannelInfo, EegInfo};
use crate::eeg::source::SignalKind;

impl EegInfo {
    /// What the file holds, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let recorded: f64 = self.parts.iter().map(|part| part.duration_s.0).sum();
        let mut rates: Vec<f64> = self.electrodes().map(|c| c.rate_hz.hz()).collect();
        rates.dedup();
        let rates: Vec<String> = rates.into_iter().map(rounded).collect();
        let at = match rates.is_empty() {
            true => String::new(),
            false => format!(" at {} Hz", rates.join(", ")),
        };
        format!(
            "{}: {} and {}{at}, {} s recorded in {}",
            self.kind,
            counted(self.electrodes().count(), "electrode"),
            counted(
                self.channels.len() - self.electrodes().count(),
                "other channel"
            ),
            rounded(recorded),
            counted(self.parts.len(), "part")
        )
    }

    /// Which positions are known.
    #[must_use]
    pub fn montage_sentence(&self) -> String {
        let unknown: Vec<&str> = self
            .electrodes()
            .filter(|channel| !channel.positioned)
            .map(|channel| channel.name.as_str())
            .collect();
        let all = self.electrodes().count();
        match (all, unknown.len()) {
            (0, _) => "Montage: no electrode".to_owned(),
            (_, 0) => format!("Montage: all {all} names have a position of the 10-10 system"),
            (all, none) if all == none => {
                "Montage: no name has a position of the 10-10 system, so no scalp map can be drawn without measured positions".to_owned()
            }
            _ => format!(
                "Montage: {} of {all} names have a position of the 10-10 system; without a position: {}",
                all - unknown.len(),
                unknown.join(", ")
            ),
        }
    }

    /// Which channels are flat, saturated or frozen, and which hold the mains.
    #[must_use]
    pub fn signal_sentences(&self) -> Vec<String> {
        let named = |of: &dyn Fn(&ChannelInfo) -> Option<String>| -> Vec<String> {
            self.channels.iter().filter_map(of).collect()
        };
        let percent = |share: f64| format!("{} %", digits(100.0 * share));
        let flat = named(&|c| c.flat.then(|| c.name.clone()));
        let limited = named(&|c| {
            let share = c.saturated_share;
            (share > 0.0).then(|| format!("{} ({})", c.name, percent(share)))
        });
        let frozen = named(&|c| {
            let share = c.frozen_share;
            (share > 0.0).then(|| format!("{} ({})", c.name, percent(share)))
        });
        let missing = named(&|c| {
            let share = c.missing_share;
            (share > 0.0).then(|| format!("{} ({})", c.name, percent(share)))
        });
        let bad = named(&|c| c.bad.then(|| c.name.clone()));
        let mains = named(&|c| {
            let hz = c.mains_hz?;
            Some(format!(
                "{} ({:.0} Hz, {})",
                c.name,
                hz,
                percent(c.mains_share)
            ))
        });
        let listed = |what: &str, found: Vec<String>| match found.is_empty() {
            true => format!("{what}: none"),
            false => format!("{what}: {}", found.join(", ")),
        };
        vec![
            listed("Flat channels", flat),
            listed("Channels at a limit (share of samples)", limited),
            listed(
                "Channels that hold one value for a while (share of samples)",
                frozen,
            ),
            listed("Channels with samples that are no numbers (share)", missing),
            listed("Mains (share of the power)", mains),
            listed("Called bad by the table beside the file", bad),
        ]
    }

    /// The tasks that markers name; nothing where there is one or none.
    #[must_use]
    pub fn tasks_sentence(&self) -> Option<String> {
        let several = self.tasks.len() > 1;
        several.then(|| {
            format!(
                "Markers name {} tasks ({}): state whose epochs are taken",
                self.tasks.len(),
                self.tasks.join(", ")
            )
        })
    }

    /// The channels: one row each.
    #[must_use]
    pub fn channels_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("channel", "channel"),
            Column::new("records", "kind"),
            Column::new("unit", "unit"),
            Column::new("rate, Hz", "rate_hz"),
            Column::new("position", "position"),
            Column::new("SD", "standard_deviation"),
            Column::new("state", "state"),
            Column::new("at a limit, %", "saturated_percent"),
            Column::new("held, %", "frozen_percent"),
            Column::new("no number, %", "missing_percent"),
            Column::new("mains, %", "mains_percent"),
        ]);
        table.rows = self
            .channels
            .iter()
            .map(|c| {
                let position = match (c.kind, c.positioned) {
                    (SignalKind::Eeg, true) => "10-10",
                    (SignalKind::Eeg, false) => "unknown",
                    _ => "–",
                };
                vec![
                    Cell::from(c.name.as_str()),
                    Cell::from(c.kind.word()),
                    Cell::from(c.unit.symbol()),
                    Cell::Text(rounded(c.rate_hz.hz())),
                    Cell::from(position),
                    Cell::from(c.spread),
                    Cell::from(match (c.flat, c.bad) {
                        (true, _) => "flat",
                        (false, true) => "called bad",
                        (false, false) => "",
                    }),
                    Cell::from(100.0 * c.saturated_share),
                    Cell::from(100.0 * c.frozen_share),
                    Cell::from(100.0 * c.missing_share),
                    Cell::from(100.0 * c.mains_share),
                ]
            })
            .collect();
        table
    }

    /// The parts and the gaps before them.
    #[must_use]
    pub fn parts_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("part", "part"),
            Column::new("begins, s", "start_s"),
            Column::new("lasts, s", "duration_s"),
            Column::new("gap before it, s", "gap_before_s"),
        ]);
        table.rows = self
            .parts
            .iter()
            .zip(1..)
            .map(|(part, number)| {
                let times = [part.start_s.0, part.duration_s.0, part.gap_before_s.0];
                let mut row = vec![Cell::Text(i32::to_string(&number))];
                row.extend(times.map(|time| Cell::Text(rounded(time))));
                row
            })
            .collect();
        table
    }

    /// Markers by name.
    #[must_use]
    pub fn markers_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("marker", "marker"),
            Column::new("count", "count"),
            Column::new("first, s", "first_s"),
            Column::new("last, s", "last_s"),
        ]);
        table.rows = self
            .markers
            .iter()
            .map(|one| {
                vec![
                    Cell::from(one.marker.as_str()),
                    Cell::Text(one.count.to_string()),
                    Cell::Text(rounded(one.first_s.0)),
                    Cell::Text(rounded(one.last_s.0)),
                ]
            })
            .collect();
        table
    }

    /// The report.
    #[must_use]
    pub fn page(&self) -> Page {
        let conclusion = Block::Conclusion {
            text: self.sentence(),
            outcome: None,
        };
        let mut first = vec![
            conclusion,
            Block::Text {
                text: self.montage_sentence(),
            },
        ];
        let sentences = self.signal_sentences().into_iter();
        first.extend(
            sentences
                .chain(self.tasks_sentence())
                .map(|text| Block::Text { text }),
        );
        let started = self.started_at.as_ref();
        let origin = started.map_or_else(String::new, |at| format!("recorded from {at}"));
        let mut page = Page::new(format!("EEG file: {}", self.file), origin).section("", first);
        if let Some(clock) = &self.clock {
            let numbers = vec![
                Number::new(
                    format!("{} ppm", plus(clock.drift_ppm, 2)),
                    "drift of the second clock",
                ),
                Number::new(
                    format!("{:.3} ms", clock.jitter_ms),
                    "jitter, SD of both devices together",
                ),
                Number::new(clock.matched.to_string(), "shared pulses"),
                Number::new(
                    format!("{} / {}", clock.only_first, clock.only_second),
                    "pulses of the first / second device alone",
                ),
            ];
            page = page.section(
                "Clock of the other file",
                [
                    Block::Text {
                        text: clock.sentence(),
                    },
                    Block::Numbers { numbers },
                ],
            );
        }
        let markers = match self.markers.is_empty() {
            true => Block::Text {
                text: "No marker: no epoch can be cut. Check that the triggers were recorded."
                    .into(),
            },
            false => Block::Table(self.markers_table()),
        };
        page.section("Markers", [markers])
            .section("Parts without a gap", [Block::Table(self.parts_table())])
            .section("Channels", [Block::Table(self.channels_table())])
            .warnings(&self.warnings)
    }
}
