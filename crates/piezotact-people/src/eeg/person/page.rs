//! The desynchronisation of a person in sentences, tables and a report.

use piezotact::figure::{Figure, Maps};
use piezotact::number::{counted, digits, plus, rounded};
use piezotact::page::{Block, Cell, Column, Number, Page, Shown, Table};

use super::{Change, EegErd, NamedBand, PersonConfig, head_map, time_frequency_panel};
use crate::eeg::erd::Order;

/// The convention of signs and colours, below each figure.
pub(in crate::eeg) const SIGNS: &str = "Negative (blue): desynchronisation, less power than in the baseline; positive (red): synchronisation.";

/// Channels that are drawn where they were recorded.
const DRAWN: [&str; 3] = ["C3", "Cz", "C4"];

/// The channels that figures show: C3, Cz and C4 where they are there, else the first three.
fn drawn_channels(channels: &[String]) -> Vec<usize> {
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

/// Times in words: "−1.5 to −0.5 s".
pub(in crate::eeg) fn span_text([from, to]: [f64; 2]) -> String {
    format!("{} to {} s", rounded(from), rounded(to)).replace('-', "−")
}

impl NamedBand {
    /// "alpha (8–12 Hz)".
    pub(in crate::eeg) fn text(&self) -> String {
        format!(
            "{} ({}–{} Hz)",
            self.name,
            rounded(self.hz.low().0),
            rounded(self.hz.high().0)
        )
    }
}

impl Order {
    /// What is averaged first, in words.
    fn words(self) -> &'static str {
        match self {
            Self::PowerFirst => "power averaged over epochs, then divided by the baseline",
            Self::PercentOfEachEpoch => {
                "percentage of each epoch, then averaged: biased towards synchronisation"
            }
        }
    }
}

impl PersonConfig {
    /// The baseline with what is averaged first: it stands with every number.
    #[must_use]
    pub fn baseline_text(&self) -> String {
        format!(
            "baseline {}, {}",
            span_text(self.baseline_s),
            self.order.words()
        )
    }

    /// What is estimated, one line each.
    #[must_use]
    pub fn steps(&self) -> Vec<String> {
        let hz = &self.power.frequencies_hz;
        let (low, high) = (hz[0], hz[hz.len() - 1]);
        let cycles = &self.power.cycles;
        vec![
            format!(
                "Morlet wavelets from {} to {} Hz (frequencies: {}), {} to {} cycles",
                rounded(low),
                rounded(high),
                hz.len(),
                rounded(cycles[0]),
                rounded(cycles[cycles.len() - 1])
            ),
            format!(
                "Window {}; {}",
                span_text(self.window_s),
                self.baseline_text()
            ),
            "Regions: the mean of the changes of their electrodes".to_owned(),
        ]
    }
}

impl EegErd {
    /// How far the wavelets of a band smear, in words.
    pub(in crate::eeg) fn smear_text(&self, band: &str) -> String {
        let own = self.smears.iter().find(|smear| smear.band == band);
        let smear_s = own.map_or(0.0, |smear| smear.smear_s);
        format!(
            "smear ±{:.0} ms (1 SD of the longest wavelet)",
            1e3 * smear_s
        )
    }

    fn band(&self, name: &str) -> String {
        let own = self.config.bands.iter().find(|band| band.name == name);
        own.map_or_else(|| name.to_owned(), NamedBand::text)
    }

    /// One change with its baseline and what is averaged first, for a place where window and smear stand beside it.
    fn short_sentence(&self, change: &Change) -> String {
        let order = match self.config.order {
            Order::PowerFirst => "power averaged first",
            Order::PercentOfEachEpoch => "percentage of each epoch: biased",
        };
        let interval = change.percent_interval.map_or(String::new(), |[from, to]| {
            format!("95 % over epochs: {} to {} %; ", plus(from, 1), plus(to, 1))
        });
        format!(
            "{}, {}, {}: {} % ({interval}{} dB, from {} to {} µV²) re {} ({order}), {}",
            change.surface,
            change.place,
            self.band(&change.band),
            plus(change.percent, 1),
            plus(change.decibels, 2),
            digits(1e12 * change.baseline_power_v2),
            digits(1e12 * change.window_power_v2),
            span_text(self.config.baseline_s),
            counted(change.epochs, "epoch")
        )
    }

    /// The window, the baseline and the smear of each band, which all values share.
    fn shared_numbers(&self) -> Vec<Number> {
        let order = self.config.order.words();
        let mut numbers = vec![
            Number::new(span_text(self.config.window_s), "window"),
            Number::new(
                span_text(self.config.baseline_s),
                format!("baseline, {order}"),
            ),
        ];
        numbers.extend(self.smears.iter().map(|smear| {
            Number::new(
                format!("±{:.0} ms", 1e3 * smear.smear_s),
                format!("smear of {} (1 SD of the longest wavelet)", smear.band),
            )
        }));
        numbers
    }

    /// The changes in regions for a page whose title says who and what they are of; baseline and window as one cell each.
    fn page_table(&self) -> Table {
        let mut table = self.regions_table();
        let spans = [self.config.baseline_s, self.config.window_s];
        let spans = spans.map(|span| Cell::Text(span_text(span).replace(" s", "")));
        let columns = [
            Column::new("baseline, s", "baseline_s"),
            Column::new("window, s", "window_s"),
        ];
        // Between what leads to a change and what is averaged first.
        let from = table.columns.len() - 5;
        table.columns.splice(from..from + 4, columns);
        table.columns.drain(..2);
        for row in &mut table.rows {
            row.splice(from..from + 4, spans.clone());
            row.drain(..2);
        }
        table
    }

    /// The changes in regions, or at electrodes: one row each, with all that it depends on.
    fn table_of(&self, changes: &[Change]) -> Table {
        let mut table = Table::new([
            Column::new("participant", "participant"),
            Column::new("task", "task"),
            Column::new("surface", "surface"),
            Column::new("band", "band"),
            Column::new("place", "place"),
            Column::new("ERD (−) or ERS (+), %", "percent"),
            Column::new("95 % from", "percent_from"),
            Column::new("to, %", "percent_to"),
            Column::new("dB", "decibels"),
            Column::new("power in the baseline, µV²", "baseline_power_uv2"),
            Column::new("in the window, µV²", "window_power_uv2"),
            Column::new("bias, points", "bias_points"),
            Column::new("epochs", "epochs"),
            Column::new("baseline from, s", "baseline_from_s"),
            Column::new("to, s", "baseline_to_s"),
            Column::new("window from, s", "window_from_s"),
            Column::new("to, s", "window_to_s"),
            Column::new("averaged first", "averaged_first"),
        ]);
        let order = match self.config.order {
            Order::PowerFirst => "power",
            Order::PercentOfEachEpoch => "nothing (biased)",
        };
        table.rows = changes
            .iter()
            .map(|change| {
                vec![
                    Cell::from(self.subject.participant.as_str()),
                    Cell::from(self.subject.task.as_str()),
                    Cell::from(change.surface.as_str()),
                    Cell::from(change.band.as_str()),
                    Cell::from(change.place.as_str()),
                    Cell::from(change.percent),
                    Cell::from(change.percent_interval.map(|[from, _]| from)),
                    Cell::from(change.percent_interval.map(|[_, to]| to)),
                    Cell::from(change.decibels),
                    Cell::from(1e12 * change.baseline_power_v2),
                    Cell::from(1e12 * change.window_power_v2),
                    Cell::from(change.bias_points),
                    Cell::Text(change.epochs.to_string()),
                    Cell::from(self.config.baseline_s[0]),
                    Cell::from(self.config.baseline_s[1]),
                    Cell::from(self.config.window_s[0]),
                    Cell::from(self.config.window_s[1]),
                    Cell::from(order),
                ]
            })
            .collect();
        table
    }

    /// The changes in regions: one row each.
    #[must_use]
    pub fn regions_table(&self) -> Table {
        self.table_of(&self.regions)
    }

    /// The changes in regions and at electrodes: one row each.
    #[must_use]
    pub fn all_table(&self) -> Table {
        let mut table = self.table_of(&[self.regions.clone(), self.electrodes.clone()].concat());
        let at = table
            .columns
            .iter()
            .position(|column| column.name == "place");
        let at = at.unwrap_or_default();
        table
            .columns
            .insert(at, Column::new("place is", "place_kind"));
        for (number, row) in table.rows.iter_mut().enumerate() {
            let is_region = number < self.regions.len();
            let kind = if is_region { "region" } else { "electrode" };
            row.insert(at, Cell::from(kind));
        }
        table
    }

    /// The scalp maps of one band, one for each surface; `None` where no map can be drawn.
    fn head_figure(&self, band: &NamedBand) -> Option<Figure> {
        let panels = self.surfaces.iter().map(|surface| {
            let values = self.positions.iter().map(|electrode| {
                let own = self.electrodes.iter().find(|change| {
                    change.surface == *surface
                        && change.band == band.name
                        && change.place == electrode.name
                });
                own.map(|change| change.percent)
            });
            let values: Option<Vec<f64>> = values.collect();
            head_map(surface.clone(), &self.positions, &values?).map(|(panel, _)| panel)
        });
        let panels: Vec<_> = panels.collect::<Option<_>>()?;
        let maps = Maps::around_zero("ERD/ERS, %", panels);
        let reach = rounded(maps.reach);
        Some(maps.captioned(format!(
            "{} over the scalp, seen from above, nose up; window {}; {}; {}. {SIGNS} One scale, ±{reach} %. Dots are electrodes; between them a \
             spherical spline, nothing further than 30° from one.",
            band.text(),
            span_text(self.config.window_s),
            self.config.baseline_text(),
            self.smear_text(&band.name),
        )))
    }

    /// Time and frequency at C3, Cz and C4, or the first electrodes; `None` without times.
    fn time_figure(&self, channel: usize) -> Option<Figure> {
        let (hz, times) = (&self.config.power.frequencies_hz, self.times_s.len());
        let each = hz.len() * times;
        let [from, to] = self.config.window_s;
        let bands = self.config.bands.iter();
        let outlined: Vec<[f64; 4]> = bands
            .map(|band| [from, to, band.hz.low().0, band.hz.high().0])
            .collect();
        let panels = self.maps.iter().map(|map| {
            let own = map.decibels.get(channel * each..(channel + 1) * each)?;
            time_frequency_panel(
                map.surface.clone(),
                &self.times_s,
                hz,
                own,
                outlined.clone(),
            )
        });
        let panels: Vec<_> = panels.collect::<Option<_>>()?;
        let smears = self
            .smears
            .iter()
            .map(|smear| format!("{} ±{:.0} ms", smear.band, 1e3 * smear.smear_s));
        let smears: Vec<String> = smears.collect();
        let maps = Maps::around_zero("change of power, dB", panels);
        let reach = rounded(maps.reach);
        Some(maps.captioned(format!(
            "{} over time and frequency, dB; baseline {}, power averaged over epochs first, corrected for the bias of the logarithm. {SIGNS} One scale, ±{reach} dB. The line is the marker; the \
             outlines are the windows that are evaluated; smear (1 SD): {}.",
            self.channels[channel],
            span_text(self.config.baseline_s),
            smears.join(", ")
        )))
    }

    /// Why there is no scalp map; `None` where there is one.
    #[must_use]
    pub fn no_map_sentence(&self) -> Option<String> {
        let (known, all) = (self.positions.len(), self.channels.len());
        (known < super::FEWEST_OF_A_MAP).then(|| {
            format!(
                "No scalp map is drawn: {known} of {all} electrodes have a known position, and a map needs {}; name the channels by the 10-10 \
                 system, or give measured positions",
                super::FEWEST_OF_A_MAP
            )
        })
    }
}

impl Shown for EegErd {
    fn page(&self) -> Page {
        let conclusions = self.regions.iter();
        let mut first: Vec<Block> = conclusions
            .map(|one| Block::conclusion(self.short_sentence(one), None))
            .collect();
        first.push(Block::numbers(self.shared_numbers()));
        let steps = [self.preparation.steps(), self.config.steps()].concat();
        let mut scalp: Vec<Block> = self
            .config
            .bands
            .iter()
            .filter_map(|band| self.head_figure(band))
            .map(Block::Figure)
            .collect();
        let missing = self.no_map_sentence();
        scalp.extend(missing.map(Block::text));
        if scalp.is_empty() {
            scalp.push(Block::text(
                "No scalp map is drawn: the positions of the electrodes determine none",
            ));
        }
        let figures = drawn_channels(&self.channels).into_iter();
        let figures: Vec<Block> = figures
            .filter_map(|channel| self.time_figure(channel))
            .map(Block::Figure)
            .collect();
        let mut counts = vec![
            Block::text(self.counts.sentence()),
            Block::Table(self.counts.table()),
        ];
        counts.extend(self.counts.refused_blocks());
        Page::new(
            format!("EEG desynchronisation: {}", self.file),
            self.subject.to_string(),
        )
        .section("", first)
        .section("Regions", [Block::Table(self.page_table())])
        .section("Scalp", scalp)
        .section("Time and frequency", figures)
        .section("Method", [Block::Steps { steps }])
        .section("Epochs", counts)
        .warnings(&self.warnings)
        .rows(self.all_table())
    }
}
