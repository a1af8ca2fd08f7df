//! The report of the spectrum of one channel.

use super::{Averaging, Spectrogram, SpectrumDocument};
use crate::figure::{Axis, Chart, Drawn, Figure, Line, Spectrograms, Tone, range};
use crate::number::{counted, digits, rounded};
use crate::page::{Block, Cell, Column, Number, Page, Shown, Table};
use crate::quantity::{Decibels, Quantity};
use crate::recording::BenchKind;

impl Shown for SpectrumDocument<'_> {
    fn page(&self) -> Page {
        let page = Page::new(
            format!("Spectrum of {}", self.channel),
            self.file.display().to_string(),
        )
        .simulated(BenchKind::simulated([self.bench]))
        .section(
            "",
            [
                Block::conclusion(self.sentence(), None),
                Block::numbers(self.numbers()),
            ],
        )
        .section("Power spectral density", self.spectrum().map(Block::Figure));
        let page = match &self.over_time {
            Some(over_time) => page.section("Over time", [self.spectrogram(over_time).into()]),
            None => page,
        };
        let warnings = Block::warnings("", self.warnings.clone());
        page.section("Warnings", [warnings])
            .section("Method", [Block::note(self.method())])
            .rows(self.table())
    }
}

impl SpectrumDocument<'_> {
    fn sentence(&self) -> String {
        let (frequency_hz, psd) = self.strongest;
        format!(
            "The PSD of {} is highest at {} Hz: {} {}.",
            self.channel,
            digits(frequency_hz),
            digits(psd).replace('-', "−"),
            self.unit
        )
    }

    fn numbers(&self) -> [Number; 2] {
        [
            Number::new(
                format!("{:.3} Hz", self.resolution_hz),
                "distance of two lines",
            ),
            Number::new(
                self.averages.to_string(),
                format!("segments of {} samples", self.config.segment),
            ),
        ]
    }

    fn method(&self) -> String {
        let config = self.config;
        format!(
            "PSD by Welch's method at {}: {} window, segments of {} samples ({:.2} Hz), {} % overlap, {} of {}.",
            self.rate_hz,
            config.window.name(),
            config.segment,
            self.resolution_hz,
            rounded(config.overlap * 100.0),
            match config.averaging {
                Averaging::Mean => "mean",
                Averaging::Median => "median",
            },
            counted(self.averages, "segment"),
        )
    }

    fn spectrogram(&self, over_time: &Spectrogram<impl Quantity>) -> Figure {
        let file = self.file.file_name().unwrap_or(self.file.as_os_str());
        let title = format!("{}, {}", file.display(), self.channel);
        Figure {
            drawn: Drawn::Spectrograms(Spectrograms {
                panels: vec![over_time.panel(title)],
                unit: self.unit.clone(),
                note: over_time.estimate_text(),
            }),
            caption: "Power spectral density over time.".into(),
        }
    }

    /// `None` where every line above 0 Hz is 0: decibels have no point there.
    fn spectrum(&self) -> Option<Figure> {
        let lines = self.frequency_hz.iter().zip(self.psd).skip(1);
        let lines = lines.filter(|(_, psd)| **psd > 0.0);
        let points: Vec<_> = lines
            .map(|(hz, psd)| (*hz, Decibels::from_power(*psd).0))
            .collect();
        let _point = points.first()?;
        let first = *self.frequency_hz.get(1)?;
        let last = *self.frequency_hz.last()?;
        let (low, high) = range(&[&points], 0.0, last, 10.0, 120.0);
        let chart = Chart::new(
            Axis::log("frequency, Hz", first, last),
            Axis::new(format!("PSD, dB re 1 {}", self.unit), low, high),
            vec![Line::new("", Tone::Main, points)],
        );
        Some(chart.captioned(format!("Power spectral density of {}.", self.channel)))
    }

    /// The PSD by frequency: one row a line.
    fn table(&self) -> Table {
        let psd = format!("PSD, {}", self.unit);
        let mut table = Table::new([
            Column::new("frequency, Hz", "frequency_hz"),
            Column::new(&psd, &format!("psd ({})", self.unit)),
        ]);
        let lines = self.frequency_hz.iter().zip(self.psd);
        table.rows = lines
            .map(|(hz, psd)| vec![Cell::from(*hz), Cell::from(*psd)])
            .collect();
        table
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::quantity::{Acceleration, SampleRate};
    use crate::series::Series;
    use crate::spectrum::{WelchConfig, welch};

    fn page_of(sample: impl Fn(usize) -> f64) -> Page {
        let rate = SampleRate::new(1000.0).unwrap();
        let samples = (0..8192).map(sample).collect();
        let series = Series::<Acceleration>::new(samples, rate).unwrap();
        let psd = welch(&series, &WelchConfig::hann(1000)).unwrap();
        let document = SpectrumDocument {
            file: Path::new("S4.wav"),
            channel: "nail",
            unit: "(m/s²)²/Hz".into(),
            rate_hz: rate,
            resolution_hz: psd.resolution_hz,
            averages: psd.averages,
            config: &psd.config,
            frequency_hz: psd.frequencies_hz(),
            psd: &psd.values,
            warnings: Vec::new(),
            strongest: psd.strongest(),
            bench: None,
            over_time: None,
        };
        document.page()
    }

    #[test]
    fn the_strongest_line_is_named_and_every_line_is_a_row() {
        let page = page_of(|i| (std::f64::consts::TAU * 0.1 * i as f64).sin());
        let Some(Block::Conclusion { text, .. }) = page.blocks().next() else {
            panic!("{page:?}");
        };
        assert!(
            text.starts_with("The PSD of nail is highest at 100 Hz: 0.333 (m/s²)²/Hz"),
            "{text}"
        );
        let rows = &page.csv_table().unwrap().rows;
        assert_eq!((rows.len(), rows[100][0].whole().as_str()), (501, "100"));
        let figures = page.blocks().filter(|b| matches!(b, Block::Figure(_)));
        assert_eq!(figures.count(), 1);
    }

    /// Nothing can be drawn in decibels of a channel that never changes.
    #[test]
    fn silence_has_numbers_and_no_figure() {
        let page = page_of(|_| 0.0);
        assert!(!page.blocks().any(|b| matches!(b, Block::Figure(_))));
        assert!(page.blocks().any(|b| matches!(b, Block::Numbers { .. })));
    }
}
