//! The spectrogram: the PSD of every segment, in its time.

use std::marker::PhantomData;

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::{
    Averaging, Detrend, EstimateError, Held, Scaling, SegmentTransform, Symmetry, WelchConfig,
    Window, frequency_axis, one_sided, segments_in,
};
use crate::figure::SpectrogramPanel;
use crate::number::digits;
use crate::quantity::{Decibels, Hertz, Quantity, SampleRate};
use crate::series::Series;

/// How a spectrogram is estimated. There is no default: it is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpectrogramConfig {
    /// The window.
    pub window: Window,
    /// Its form.
    pub symmetry: Symmetry,
    /// The segment's length in samples.
    pub segment: usize,
    /// The share of a segment that the next one repeats, 0 ≤ overlap < 1.
    pub overlap: f64,
    /// What is taken away from every segment.
    pub detrend: Detrend,
    /// Which cells are kept.
    pub cells: Cells,
}

/// The cells of a spectrogram: its columns stand for segments, its rows for lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Cells {
    /// One column for each segment, one row for each line up to half the rate.
    All,
    /// No more than a figure shows, however long the series is: neighbouring segments and neighbouring lines
    /// are averaged in power, each in groups of one size, of which the last may hold fewer.
    AtMost {
        /// The most columns, 1 or more.
        columns: usize,
        /// The most rows, 1 or more.
        rows: usize,
        /// The line nearest to this frequency, Hz, is the last one.
        #[serde(rename = "highest_hz")]
        highest: Hertz,
    },
}

impl Cells {
    /// What a figure of the page's width shows, up to `highest`: 600 × 300 cells at most.
    #[must_use]
    pub fn of_a_figure(highest: Hertz) -> Self {
        Self::AtMost {
            columns: 600,
            rows: 300,
            highest,
        }
    }
}

impl SpectrogramConfig {
    /// Hann, 50 % overlap, constant detrend, all cells, over segments of `segment` samples.
    #[must_use]
    pub fn hann(segment: usize) -> Self {
        let WelchConfig {
            window,
            symmetry,
            segment,
            overlap,
            detrend,
            ..
        } = WelchConfig::hann(segment);
        Self {
            window,
            symmetry,
            segment,
            overlap,
            detrend,
            cells: Cells::All,
        }
    }

    /// What is usual for vibration at `rate`: [`Self::hann`] over the power of two that is nearest to 0.1 s (256
    /// samples and more at low rates), which keeps lines 10 Hz apart and changes 0.1 s apart; an overlap of 7/8, so
    /// that a short stroke has columns enough to be seen.
    #[must_use]
    pub fn usual(rate: SampleRate) -> Self {
        let segment = (rate.hz() / 10.0).log2().round().exp2() as usize;
        Self {
            overlap: 0.875,
            ..Self::hann(segment.max(256))
        }
    }

    /// The Welch estimate whose segments the columns are.
    fn welch(&self) -> WelchConfig {
        WelchConfig {
            window: self.window,
            symmetry: self.symmetry,
            segment: self.segment,
            overlap: self.overlap,
            detrend: self.detrend,
            averaging: Averaging::Mean,
            scaling: Scaling::Density,
        }
    }
}

/// One-sided PSDs of a quantity `Q` over time, in unit²/Hz: times × frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrogram<Q: Quantity> {
    /// The PSDs, one column after the other, each from the lowest frequency up.
    pub values: Vec<f64>,
    /// The time in the middle of every column, s from the first sample.
    pub times_s: Vec<f64>,
    /// The frequency in the middle of every row, Hz.
    pub frequencies_hz: Vec<f64>,
    /// The step between columns, s.
    pub time_step_s: f64,
    /// The step between rows, Hz.
    pub frequency_step_hz: f64,
    /// The number of segments in the series.
    pub segments: usize,
    /// The segments averaged in a column; the last may hold fewer.
    pub segments_per_column: usize,
    /// The lines averaged in a row; the last may hold fewer.
    pub lines_per_row: usize,
    /// How it was made.
    pub config: SpectrogramConfig,
    quantity: PhantomData<Q>,
}

impl<Q: Quantity> Spectrogram<Q> {
    /// The PSDs column by column, each `frequencies_hz.len()` values in unit²/Hz from the lowest frequency up.
    pub fn columns(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.frequencies_hz.len())
    }

    /// The spectrogram as a part of a figure: levels in dB re 1 unit²/Hz, row by row from the highest frequency.
    #[must_use]
    pub fn panel(&self, title: impl Into<String>) -> SpectrogramPanel {
        let rows = self.frequencies_hz.len();
        let level = |power: f64| Decibels::from_power(power).0;
        SpectrogramPanel {
            title: title.into(),
            times_s: self.times_s.clone(),
            time_step_s: self.time_step_s,
            frequencies_hz: self.frequencies_hz.clone(),
            frequency_step_hz: self.frequency_step_hz,
            levels_db: (0..rows)
                .rev()
                .flat_map(|row| self.columns().map(move |column| level(column[row])))
                .collect(),
        }
    }

    /// How it was estimated, in words for a caption.
    #[must_use]
    pub fn estimate_text(&self) -> String {
        let config = &self.config;
        let averaged = |count: usize, what: &str| match count {
            1 => String::new(),
            several => format!(", {several} averaged per {what}"),
        };
        format!(
            "{} window, {} samples, {} % overlap: {} segments{}; lines {:.2} Hz apart{}",
            config.window.name(),
            config.segment,
            digits(config.overlap * 100.0),
            self.segments,
            averaged(self.segments_per_column, "column"),
            self.resolution_hz(),
            averaged(self.lines_per_row, "row"),
        )
    }

    /// The step between lines before any are averaged: the rate over the segment's length, Hz.
    #[must_use]
    pub fn resolution_hz(&self) -> f64 {
        self.frequency_step_hz / self.lines_per_row as f64
    }
}

/// Groups of `each` neighbours, so many that `count` of them make `most` groups at most.
#[derive(Clone, Copy, Debug)]
struct Groups {
    count: usize,
    each: usize,
}

impl Groups {
    fn of(count: usize, most: usize) -> Self {
        Self {
            count,
            each: count.div_ceil(most),
        }
    }

    fn len(self) -> usize {
        self.count.div_ceil(self.each)
    }

    /// How many are in group `k`.
    fn size(self, k: usize) -> usize {
        self.each.min(self.count - k * self.each)
    }

    /// The middle of every group, where neighbours are 1 apart and the first is at 0.
    fn middles(self) -> impl Iterator<Item = f64> {
        (0..self.len()).map(move |k| (k * self.each) as f64 + 0.5 * (self.size(k) - 1) as f64)
    }
}

/// One-sided PSD of every segment of `x`: a column for each segment, segment/2 + 1 rows from 0 Hz to half the
/// rate, in unit²/Hz; with [`Cells::AtMost`] fewer of both, averaged while they are computed, so that memory is
/// bounded by the result. Samples behind the last whole segment are in no column.
///
/// Formula: |FFT(w·(x − trend))|² / (rate·Σw²), doubled except at 0 Hz and Nyquist; the time of segment i is
/// (segment/2 + i·step)/rate. The mean over all columns is [`welch`](super::welch).
///
/// Source: A. V. Oppenheim and R. W. Schafer, Discrete-Time Signal Processing, section 10.3; scaled and timed as
/// SciPy's `spectrogram(mode="psd")`.
///
/// # Errors
/// [`EstimateError::TooShort`] when `x` holds no segment; [`EstimateError::Config`] when the configuration cannot
/// be, or asks for no column or no row; [`EstimateError::Frequency`] when the highest frequency is below the first
/// line, above half the rate or not a number.
///
/// ```
/// use piezotact::quantity::{Acceleration, SampleRate};
/// use piezotact::spectrum::{SpectrogramConfig, spectrogram};
/// let rate = SampleRate::new(5000.0).unwrap();
/// // A tone of 250 Hz that becomes half as strong after a second.
/// let tone = (0..10_000).map(|i| {
///     let amplitude = if i < 5_000 { 1.0 } else { 0.5 };
///     amplitude * (std::f64::consts::TAU * 250.0 * i as f64 / 5000.0).sin()
/// });
/// let tone = piezotact::Series::<Acceleration>::new(tone.collect(), rate).unwrap();
/// let result = spectrogram(&tone, &SpectrogramConfig::hann(500)).unwrap();
/// let power: Vec<f64> = result
///     .columns()
///     .map(|psd| psd.iter().sum::<f64>() * result.frequency_step_hz)
///     .collect();
/// assert_eq!(power.len(), 39);
/// assert!((power[0] - 0.5).abs() < 1e-9 && (power[38] - 0.125).abs() < 1e-9);
/// assert_eq!((result.times_s[0], result.times_s[38]), (0.05, 1.95));
/// ```
pub fn spectrogram<Q: Quantity>(
    x: &Series<Q>,
    config: &SpectrogramConfig,
) -> Result<Spectrogram<Q>, EstimateError> {
    let mut all = SpectrogramInBlocks::new(config, x.rate(), x.samples().len())?;
    for block in x.samples().chunks(BLOCK) {
        all.add(block);
    }
    Ok(all.spectrogram())
}

/// Samples that are taken at a time.
const BLOCK: usize = 1 << 16;

/// A spectrogram of a signal that comes in blocks: that of the whole signal, bit for bit.
#[derive(Debug)]
pub struct SpectrogramInBlocks {
    config: SpectrogramConfig,
    rate: SampleRate,
    hop: usize,
    segments: usize,
    sums: Sums,
    held: Held,
    transform: SegmentTransform,
    z: Vec<Complex<f64>>,
}

/// The sums of power in the cells.
#[derive(Debug)]
struct Sums {
    times: Groups,
    frequencies: Groups,
    /// The lines that are kept, and what each counts in its row.
    lines: usize,
    weights: Vec<f64>,
    values: Vec<f64>,
    /// The segments that were added.
    done: usize,
}

impl Sums {
    /// Adds the transform of so many `segments`, one or two.
    fn add(&mut self, z: &[Complex<f64>], segments: usize) {
        let (rows, each, lines) = (self.frequencies.len(), self.frequencies.each, self.lines);
        let start = |segment: usize| segment / self.times.each * rows;
        let (a, b) = (start(self.done), start(self.done + 1));
        let (values, weights) = (&mut self.values, &self.weights);
        piezotact_fourier::split_power(z, |k, power_a, power_b| {
            if k < lines {
                let row = k / each;
                values[a + row] += power_a * weights[k];
                if segments == 2 {
                    values[b + row] += power_b * weights[k];
                }
            }
        });
        self.done += 2;
    }
}

impl SpectrogramInBlocks {
    /// The spectrogram of a signal of so many `samples` at `rate`.
    ///
    /// # Errors
    /// Those of [`spectrogram`].
    pub fn new(
        config: &SpectrogramConfig,
        rate: SampleRate,
        samples: usize,
    ) -> Result<Self, EstimateError> {
        let welch = config.welch();
        welch.fits(samples)?;
        let (rate_hz, segment) = (rate.hz(), config.segment);
        let resolution_hz = rate_hz / segment as f64;
        let bins = segment / 2 + 1;
        let (columns, rows, lines) = match config.cells {
            Cells::All => (usize::MAX, bins, bins),
            Cells::AtMost {
                columns,
                rows,
                highest,
            } => (columns, rows, lines_up_to(highest, resolution_hz, rate)?),
        };
        if columns == 0 || rows == 0 {
            return Err(EstimateError::Config {
                what: "at least one column and one row",
                found: format!("{columns} and {rows}"),
            });
        }
        let hop = welch.hop()?;
        let window = welch.window.coefficients(segment, welch.symmetry);
        let window_power: f64 = window.iter().map(|w| w * w).sum();
        let segments = segments_in(samples, segment, hop);
        let (times, frequencies) = (Groups::of(segments, columns), Groups::of(lines, rows));
        // What every line counts in its row.
        let mut weights = vec![1.0; bins];
        one_sided(&mut weights, segment, 1.0 / (rate_hz * window_power));
        for (k, weight) in weights[..lines].iter_mut().enumerate() {
            *weight /= frequencies.size(k / frequencies.each) as f64;
        }
        Ok(Self {
            config: config.clone(),
            rate,
            hop,
            segments,
            sums: Sums {
                times,
                frequencies,
                lines,
                weights,
                values: vec![0.0; times.len() * frequencies.len()],
                done: 0,
            },
            held: Held::new(segment, hop),
            transform: SegmentTransform::new(window, welch.detrend.into()),
            z: vec![Complex::default(); segment],
        })
    }

    /// Takes the next samples of the signal; those beyond its stated number are left out.
    pub fn add(&mut self, block: &[f64]) {
        self.held.add(block, |a, b| {
            if self.sums.done + 2 <= self.segments {
                self.transform.transform_pair(a, b, &mut self.z);
                self.sums.add(&self.z, 2);
            }
        });
    }

    /// The spectrogram of all samples, as [`spectrogram`] gives it.
    #[must_use]
    pub fn spectrogram<Q: Quantity>(mut self) -> Spectrogram<Q> {
        if self.sums.done < self.segments
            && let Some(last) = self.held.last()
        {
            self.transform.transform_single(last, &mut self.z);
            self.sums.add(&self.z, 1);
        }
        let Self {
            config,
            rate,
            hop,
            segments,
            sums,
            ..
        } = self;
        let Sums {
            times,
            frequencies,
            mut values,
            ..
        } = sums;
        let (rate_hz, segment, rows) = (rate.hz(), config.segment, frequencies.len());
        let resolution_hz = rate_hz / segment as f64;
        for (k, column) in values.chunks_exact_mut(rows).enumerate() {
            let averaged = times.size(k) as f64;
            column.iter_mut().for_each(|value| *value /= averaged);
        }
        let hop = hop as f64;
        Spectrogram {
            values,
            times_s: times
                .middles()
                .map(|i| (0.5 * segment as f64 + i * hop) / rate_hz)
                .collect(),
            frequencies_hz: if frequencies.each == 1 {
                frequency_axis(resolution_hz, rows)
            } else {
                frequencies.middles().map(|k| k * resolution_hz).collect()
            },
            time_step_s: times.each as f64 * hop / rate_hz,
            frequency_step_hz: frequencies.each as f64 * resolution_hz,
            segments,
            segments_per_column: times.each,
            lines_per_row: frequencies.each,
            config,
            quantity: PhantomData,
        }
    }
}

/// The number of lines from 0 Hz to the one nearest to `highest`.
fn lines_up_to(
    highest: Hertz,
    resolution_hz: f64,
    rate: SampleRate,
) -> Result<usize, EstimateError> {
    let half = rate.nyquist();
    if !(resolution_hz..=half.0).contains(&highest.0) {
        return Err(EstimateError::Frequency {
            lowest: Hertz(resolution_hz),
            highest: half,
            found: highest,
        });
    }
    let bins = (rate.hz() / resolution_hz).round() as usize / 2 + 1;
    Ok(bins.min((highest.0 / resolution_hz).round() as usize + 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Acceleration;
    use crate::spectrum::welch;

    fn series(samples: usize) -> Series<Acceleration> {
        let values = (0..samples).map(|i| ((i * i) as f64 * 0.37).sin() + (i as f64 * 0.01).cos());
        Series::new(values.collect(), SampleRate::new(1000.0).unwrap()).unwrap()
    }

    fn few(columns: usize, rows: usize, highest_hz: f64) -> Cells {
        Cells::AtMost {
            columns,
            rows,
            highest: Hertz(highest_hz),
        }
    }

    /// Even and odd segments, even and odd numbers of them: the mean of all columns is Welch's estimate.
    #[test]
    fn the_mean_of_the_columns_is_welch() {
        for (samples, segment) in [(1000, 64), (1000, 63), (64, 64), (95, 64), (130, 2)] {
            let x = series(samples);
            let config = SpectrogramConfig::hann(segment);
            let result = spectrogram(&x, &config).unwrap();
            let psd = welch(&x, &config.welch()).unwrap();
            assert_eq!(result.times_s.len(), psd.averages);
            assert_eq!(result.frequencies_hz, psd.frequencies_hz());
            let largest = psd.values.iter().copied().fold(0.0, f64::max);
            for (k, expected) in psd.values.iter().enumerate() {
                let mean = result.columns().map(|column| column[k]).sum::<f64>()
                    / result.columns().len() as f64;
                // Sums in another order.
                assert!((mean - expected).abs() < 1e-13 * largest, "{segment}, {k}");
            }
        }
    }

    /// Fewer cells are the averages of all cells, with their times and frequencies; the last may hold fewer.
    #[test]
    fn fewer_cells_are_averages() {
        let x = series(1000);
        let all = spectrogram(&x, &SpectrogramConfig::hann(64)).unwrap();
        assert_eq!((all.segments, all.frequencies_hz.len()), (30, 33));
        for (columns, rows, highest_hz) in [
            (30, 33, 500.0),
            (7, 10, 400.0),
            (1, 1, 15.625),
            (4, 99, 499.0),
        ] {
            let config = SpectrogramConfig {
                cells: few(columns, rows, highest_hz),
                ..SpectrogramConfig::hann(64)
            };
            let result = spectrogram(&x, &config).unwrap();
            assert!(result.times_s.len() <= columns && result.frequencies_hz.len() <= rows);
            let lines = (highest_hz / 15.625).round() as usize + 1;
            let (g, h) = (result.segments_per_column, result.lines_per_row);
            for (c, column) in result.columns().enumerate() {
                let segments = c * g..((c + 1) * g).min(30);
                let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
                let time_s = mean(&all.times_s[segments.clone()]);
                assert!((result.times_s[c] - time_s).abs() < 1e-12);
                for (r, value) in column.iter().enumerate() {
                    let lines = r * h..((r + 1) * h).min(lines);
                    let frequency_hz = mean(&all.frequencies_hz[lines.clone()]);
                    assert!((result.frequencies_hz[r] - frequency_hz).abs() < 1e-9);
                    let cells: Vec<f64> = segments
                        .clone()
                        .flat_map(|s| all.values[s * 33..][lines.clone()].iter().copied())
                        .collect();
                    assert!((value / mean(&cells) - 1.0).abs() < 1e-12, "{c}, {r}");
                }
            }
        }
    }

    /// A loud segment does not leak into a silent one that is transformed together with it.
    #[test]
    fn silence_beside_noise_is_silence() {
        let mut samples = series(64).into_samples();
        samples.extend([0.0; 64]);
        let x = Series::<Acceleration>::new(samples, SampleRate::new(1000.0).unwrap()).unwrap();
        let config = SpectrogramConfig {
            overlap: 0.0,
            ..SpectrogramConfig::hann(64)
        };
        let result = spectrogram(&x, &config).unwrap();
        let loudest = |k: usize| {
            let column = result.columns().nth(k).unwrap();
            column.iter().copied().fold(0.0, f64::max)
        };
        // The square of a double's rounding, 290 dB down.
        assert!(loudest(1) < 1e-29 * loudest(0), "{:e}", loudest(1));
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let x = series(100);
        let config = SpectrogramConfig::hann(64);
        let check = |config: SpectrogramConfig, parts: &[&str]| {
            let text = spectrogram(&x, &config).unwrap_err().to_string();
            for part in parts {
                assert!(text.contains(part), "{part}: {text}");
            }
        };
        check(SpectrogramConfig::hann(101), &["101", "100", "shorter"]);
        check(SpectrogramConfig::hann(1), &["2 samples or more"]);
        for overlap in [1.0, -0.1, f64::NAN] {
            check(
                SpectrogramConfig {
                    overlap,
                    ..config.clone()
                },
                &["overlap from 0"],
            );
        }
        for highest_hz in [0.0, -1.0, 15.0, 500.1, f64::NAN, f64::INFINITY] {
            let cells = few(10, 10, highest_hz);
            let found = format!("found {highest_hz} Hz");
            check(
                SpectrogramConfig {
                    cells,
                    ..config.clone()
                },
                &["15.625 Hz", "500 Hz", &found],
            );
        }
        for cells in [few(0, 10, 100.0), few(10, 0, 100.0)] {
            check(
                SpectrogramConfig {
                    cells,
                    ..config.clone()
                },
                &["one column"],
            );
        }
    }

    #[test]
    fn the_usual_segment_is_about_a_tenth_of_a_second() {
        for (rate_hz, segment) in [
            (1000.0, 256),
            (5000.0, 512),
            (10_000.0, 1024),
            (48_000.0, 4096),
        ] {
            let rate = SampleRate::new(rate_hz).unwrap();
            assert_eq!(SpectrogramConfig::usual(rate).segment, segment);
        }
    }
}
