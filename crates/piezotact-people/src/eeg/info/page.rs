//! What a file of EEG holds, in sentences, tables and a report.

use piezotact::number::{counted, digits, plus, rounded};
use piezotact::page::{Block, Cell, Column, Number, Page, Shown, Table};

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

    /// Which channels are flat, saturated or frozen, and which hold the mains: a conclusion for each that was found, and a text
    /// about the others.
    fn signal_blocks(&self) -> Vec<Block> {
        let named = |of: &dyn Fn(&ChannelInfo) -> Option<String>| -> Vec<String> {
            self.channels.iter().filter_map(of).collect()
        };
        let percent = |share: f64| format!("{} %", digits(100.0 * share));
        let shared = |of: fn(&ChannelInfo) -> f64| {
            named(&|c| {
                let share = of(c);
                (share > 0.0).then(|| format!("{} ({} of samples)", c.name, percent(share)))
            })
        };
        let mains = named(&|c| {
            let hz = c.mains_hz?;
            Some(format!(
                "{} ({:.0} Hz, {})",
                c.name,
                hz,
                percent(c.mains_share)
            ))
        });
        let looked_for = [
            ("that are flat", named(&|c| c.flat.then(|| c.name.clone()))),
            ("at a limit", shared(|c| c.saturated_share)),
            (
                "that hold one value for a while",
                shared(|c| c.frozen_share),
            ),
            (
                "with samples that are no numbers",
                shared(|c| c.missing_share),
            ),
            ("with mains (share of the power)", mains),
            (
                "called bad by the table beside the file",
                named(&|c| c.bad.then(|| c.name.clone())),
            ),
        ];
        let (none, found): (Vec<_>, Vec<_>) =
            (looked_for.into_iter()).partition(|(_, found)| found.is_empty());
        let found = found.into_iter().map(|(what, names)| {
            Block::conclusion(format!("Channels {what}: {}", names.join(", ")), None)
        });
        let mut blocks: Vec<Block> = found.collect();
        if !none.is_empty() {
            let none: Vec<&str> = none.into_iter().map(|(what, _)| what).collect();
            blocks.push(Block::text(format!("No channels {}", none.join("; "))));
        }
        blocks
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
}

impl Shown for EegInfo {
    fn page(&self) -> Page {
        let mut first = vec![
            Block::conclusion(self.sentence(), None),
            Block::conclusion(self.montage_sentence(), None),
        ];
        let tasks = self.tasks_sentence();
        first.extend(tasks.map(|text| Block::conclusion(text, None)));
        if self.markers.is_empty() {
            let text = "No marker: no epoch can be cut. Check that the triggers were recorded.";
            first.push(Block::conclusion(text, None));
        }
        first.extend(self.signal_blocks());
        let started = self.started_at.as_ref();
        let origin = started.map_or_else(String::new, |at| format!("recorded from {at}"));
        let mut page = Page::new(format!("EEG file: {}", self.file), origin).section("", first);
        if let Some(clock) = &self.clock {
            let numbers = [
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
                    Block::conclusion(clock.sentence(), None),
                    Block::numbers(numbers),
                ],
            );
        }
        let markers = (!self.markers.is_empty()).then(|| Block::Table(self.markers_table()));
        page.section("Markers", markers)
            .section("Parts without a gap", [Block::Table(self.parts_table())])
            .section("Channels", [Block::Table(self.channels_table())])
            .warnings(&self.warnings)
            .rows(self.channels_table())
    }
}
