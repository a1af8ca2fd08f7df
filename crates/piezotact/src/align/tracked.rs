//! The clocks of output and input while both run: blocks of the drive are found in the loopback as they arrive, with memory for a few seconds.

use crate::recording::{Clocks, LostBy, RecordingWarning};
use std::collections::VecDeque;

use super::line::{FEWEST_BLOCKS, Found, robust, step};
use crate::fourier::{RealTransform, fast_length, hann};
use crate::quantity::{SampleRate, Seconds};
use crate::sound::phase_slope;
use crate::warning::Warning;

/// The samples of a block, and of the stretch in which a block is looked for near where it is expected.
const BLOCK: usize = 4096;
const STRETCH: usize = 2 * BLOCK;
/// Samples before the expected place at which that stretch begins.
const BEFORE: usize = BLOCK / 2;
/// The least time from one block to the next, s.
const EVERY_S: f64 = 0.5;
/// A quieter block has no place, rms, full scale = 1.
const LEAST_RMS: f64 = 1e-4;
/// A place whose correlation is lower is none.
const LEAST_CORRELATION: f64 = 0.5;
/// Of peaks of this share of the largest one the nearest to the expected place is taken: a drive that repeats has several.
const ALIKE: f64 = 0.97;
/// A peak where it is expected is taken when it has this share of the largest one.
const AS_EXPECTED: f64 = 0.85;
/// A place may be off by so much whatever the noise, samples: found against recordings of known clocks.
const PLACE_SAMPLES: f64 = 0.03;
/// The estimate takes blocks over so much time, s.
const LEAST_S: f64 = 5.0;
/// Clocks whose times differ by less in the whole run do not matter, samples.
const MATTERS_SAMPLES: f64 = 0.5;

/// The difference between the clocks of input and output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClocksCompared {
    /// How much faster the clock of the input runs, ppm.
    pub drift_ppm: f64,
    /// Half its 95 % interval, ppm.
    pub uncertainty_ppm: f64,
    /// The blocks it was estimated from.
    pub blocks: usize,
    /// The time between the first and the last, s.
    pub over_s: Seconds,
    /// Where the delay stepped, by the clock of the input since the first block that was looked for, and by how much longer it was from there on, s.
    pub step_s: Option<[f64; 2]>,
}

impl ClocksCompared {
    /// What to know before relying on times of the drive in the recording.
    ///
    /// Source: docs/decisions/sound.md.
    #[must_use]
    pub fn warnings(&self, rate: SampleRate) -> Vec<Warning> {
        if let Some([at_s, by_s]) = self.step_s {
            return vec![
                RecordingWarning::SamplesLost {
                    by: LostBy::DelayStep { at_s, by_s },
                }
                .into(),
            ];
        }
        let samples = 1e-6 * self.drift_ppm.abs() * self.over_s.0 * rate.hz();
        let is_known = self.drift_ppm.abs() > self.uncertainty_ppm;
        if is_known && samples > MATTERS_SAMPLES {
            return vec![
                RecordingWarning::ClocksDiffer {
                    of: Clocks::Device {
                        ppm: self.drift_ppm,
                        uncertainty_ppm: self.uncertainty_ppm,
                    },
                }
                .into(),
            ];
        }
        Vec::new()
    }
}

/// Compares the clocks of output and input from the drive and its loopback, both as they come.
#[derive(Debug)]
pub struct ClockTracker {
    rate: SampleRate,
    /// From the first frame at which the drive can begin in the loopback to the last.
    latest: usize,
    /// Blocks of the drive that were not looked for, each with its first sample.
    blocks: VecDeque<(u64, Vec<f64>)>,
    /// Samples of the drive until now, and those of a block that is not complete.
    played: u64,
    partial: Vec<f64>,
    /// The loopback from frame `from` on; empty before the drive can begin.
    recorded: VecDeque<f64>,
    from: u64,
    begins: u64,
    /// The place of the last block that was found less its place in the drive, samples.
    delay: Option<f64>,
    /// The sign of the loopback.
    polarity: f64,
    found: Vec<Found>,
    transform: RealTransform,
    short: RealTransform,
    window: Vec<f64>,
}

impl ClockTracker {
    /// For a drive that begins in the loopback at frame `begins` or up to `latest` samples later.
    #[must_use]
    pub fn new(rate: SampleRate, begins: u64, latest: usize) -> Self {
        let window = (0..BLOCK).map(|i| hann((i as f64 + 0.5) / BLOCK as f64));
        Self {
            rate,
            latest,
            blocks: VecDeque::new(),
            played: 0,
            partial: Vec::with_capacity(BLOCK),
            recorded: VecDeque::new(),
            from: begins,
            begins,
            delay: None,
            polarity: 1.0,
            found: Vec::new(),
            transform: RealTransform::new(STRETCH),
            short: RealTransform::new(BLOCK),
            window: window.collect(),
        }
    }

    /// From one block to the next, samples.
    fn hop(&self) -> u64 {
        self.rate.samples_in(Seconds(EVERY_S)).max(BLOCK) as u64
    }

    /// Takes the next samples of the drive, full scale = 1.
    pub fn played(&mut self, samples: impl IntoIterator<Item = f64>) {
        let hop = self.hop();
        for sample in samples {
            let within = self.played % hop;
            self.played += 1;
            if within >= BLOCK as u64 {
                continue;
            }
            self.partial.push(sample);
            if self.partial.len() == BLOCK {
                let block = std::mem::replace(&mut self.partial, Vec::with_capacity(BLOCK));
                let power = block.iter().map(|v| v * v).sum::<f64>() / BLOCK as f64;
                if power.sqrt() >= LEAST_RMS {
                    self.blocks.push_back((self.played - BLOCK as u64, block));
                }
            }
        }
    }

    /// Takes the samples of the loopback from frame `first` on, in any unit; frames that were lost before them are taken for silence.
    pub fn recorded(&mut self, first: u64, samples: &[f64]) {
        let end = self.from + self.recorded.len() as u64;
        let skip = end.saturating_sub(first) as usize;
        let lost = first.saturating_sub(end);
        // What came before the drive is left out.
        if lost > 0 && !self.recorded.is_empty() {
            let most = (self.latest + STRETCH) as u64;
            self.recorded.extend((0..lost.min(most)).map(|_| 0.0));
            self.from += lost.saturating_sub(most);
        } else {
            self.from += lost;
        }
        self.recorded.extend(samples.iter().skip(skip));
        while self.next() {}
        // What lies before all that is looked for is kept no more.
        let wanted = match self.blocks.front() {
            Some((at, _)) => self.expected(*at),
            None => self.from + self.recorded.len() as u64,
        };
        let keep = wanted.saturating_sub((BEFORE + self.latest) as u64);
        let gone = keep
            .saturating_sub(self.from)
            .min(self.recorded.len() as u64);
        self.recorded.drain(..gone as usize);
        self.from += gone;
    }

    /// The frame of the loopback at which the block from sample `at` of the drive on is expected: the earliest one before any was found.
    fn expected(&self, at: u64) -> u64 {
        match self.delay {
            Some(delay) => (at as f64 + delay).round().max(0.0) as u64,
            None => self.begins + at,
        }
    }

    /// Looks for the next block, where enough of the loopback is there.
    fn next(&mut self) -> bool {
        let Some((at, _)) = self.blocks.front() else {
            return false;
        };
        let expected = self.expected(*at);
        let end = self.from + self.recorded.len() as u64;
        // Behind the wider of both stretches.
        if end < expected + (STRETCH + self.latest) as u64 {
            return false;
        }
        let Some((at, block)) = self.blocks.pop_front() else {
            return false;
        };
        let found = match self.delay {
            Some(_) => {
                let near = expected.saturating_sub(BEFORE as u64);
                let wide = expected.saturating_sub(self.latest as u64 / 2);
                self.place(&block, near, STRETCH, expected)
                    .or_else(|| self.place(&block, wide, BLOCK + self.latest, expected))
            }
            None => self.place(&block, expected, BLOCK + self.latest, expected),
        };
        if let Some((place, correlation)) = found {
            let middle = 0.5 * BLOCK as f64;
            if self.delay.is_none() {
                self.polarity = correlation.signum();
            }
            self.delay = Some(place - at as f64);
            self.found.push(Found {
                recorded_s: (place + middle - self.begins as f64) / self.rate.hz(),
                drive_s: (at as f64 + middle) / self.rate.hz(),
                correlation: correlation.abs(),
            });
        }
        true
    }

    /// The samples from frame `first` on, silence outside what is kept.
    fn stretch(&self, first: u64, length: usize) -> Vec<f64> {
        let offset = first as i64 - self.from as i64;
        let at = |i: i64| {
            let place = usize::try_from(i + offset).ok()?;
            self.recorded.get(place).copied()
        };
        (0..length as i64).map(|i| at(i).unwrap_or(0.0)).collect()
    }

    /// The place of `block` in the `length` samples from `first` on, frames with their fraction, and the correlation there with its sign; of
    /// several that are alike the nearest to `expected`.
    fn place(
        &mut self,
        block: &[f64],
        first: u64,
        length: usize,
        expected: u64,
    ) -> Option<(f64, f64)> {
        let stretch = self.stretch(first, length);
        let n = fast_length(length);
        if self.transform.length() != n {
            self.transform = RealTransform::new(n);
        }
        let played = self.transform.forward(block);
        let mut bins = self.transform.forward(&stretch);
        for (bin, played) in bins.iter_mut().zip(&played) {
            *bin *= played.conj();
        }
        let correlation = self.transform.inverse(bins);
        // Before the first place is known, either sign may be that of the cable.
        let height = |lag: usize| match self.delay {
            Some(_) => self.polarity * correlation[lag],
            None => correlation[lag].abs(),
        };
        let lags = length - BLOCK;
        let climbed = |mut lag: usize| {
            while lag < lags && height(lag + 1) > height(lag) {
                lag += 1;
            }
            while lag > 0 && height(lag - 1) > height(lag) {
                lag -= 1;
            }
            lag
        };
        let most = (0..=lags).map(height).fold(0.0, f64::max);
        let nearest = (expected.saturating_sub(first)) as usize;
        // Where it is expected there is a peak that is nearly as high: a tone has one in every period.
        let expected_one = climbed(nearest.min(lags));
        let best = match self.delay {
            Some(_) if most > 0.0 && height(expected_one) >= AS_EXPECTED * most => expected_one,
            _ => {
                let high = (0..=lags).filter(|lag| most > 0.0 && height(*lag) >= ALIKE * most);
                climbed(high.min_by_key(|lag| lag.abs_diff(nearest))?)
            }
        };
        self.refined(block, first + best as u64)
    }

    /// The place near frame `at` to a fraction of a sample, and the correlation there.
    fn refined(&mut self, block: &[f64], at: u64) -> Option<(f64, f64)> {
        let there = self.stretch(at, BLOCK);
        let windowed = |samples: &[f64]| -> Vec<f64> {
            samples
                .iter()
                .zip(&self.window)
                .map(|(v, w)| v * w)
                .collect()
        };
        let (played, heard) = (windowed(block), windowed(&there));
        let energy = |samples: &[f64]| samples.iter().map(|v| v * v).sum::<f64>();
        let product: f64 = played.iter().zip(&heard).map(|(a, b)| a * b).sum();
        let correlation = product / (energy(&played) * energy(&heard)).sqrt();
        if correlation.is_nan() || correlation.abs() < LEAST_CORRELATION {
            return None;
        }
        let (played, heard) = (self.short.forward(&played), self.short.forward(&heard));
        // A loopback of inverted polarity is the same signal.
        let fraction = phase_slope(&played, &heard, BLOCK, correlation.signum());
        (fraction.abs() < 1.5).then_some((at as f64 + fraction, correlation))
    }

    /// The clocks so far; `None` while too few blocks were found, or over too short a time.
    ///
    /// Formula: t(drive) = offset + t(input)/(1 + drift) by least squares over the places of blocks, without those further than five robust
    /// standard deviations; intervals by Student's t. A place is that of the largest correlation, to a fraction of a sample by the weighted
    /// slope of the phases of the cross-spectrum.
    ///
    /// Source: C. H. Knapp, G. C. Carter (1976), IEEE Trans. ASSP 24(4), for the delay; [`super::align`] for the line.
    #[must_use]
    pub fn result(&self) -> Option<ClocksCompared> {
        let (first, last) = (self.found.first()?, self.found.last()?);
        let over_s = last.recorded_s - first.recorded_s;
        if over_s < LEAST_S || self.found.len() < FEWEST_BLOCKS {
            return None;
        }
        let (line, used) = robust(&self.found).ok()?;
        let step_s = step(&self.found).map(|[at_s, by_s]| [at_s, -by_s]);
        let [low, high] = line.drift_interval_ppm();
        Some(ClocksCompared {
            drift_ppm: line.drift_ppm(),
            uncertainty_ppm: (0.5 * (high - low))
                .hypot(1e6 * PLACE_SAMPLES / (over_s * self.rate.hz())),
            blocks: used.iter().filter(|used| **used).count(),
            over_s: Seconds(over_s),
            step_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    const RATE_HZ: f64 = 48_000.0;

    /// The drive, played from frame `onset` of the loopback on and recorded by a clock that runs `ppm` faster, with noise.
    fn heard(played: &dyn Fn(f64) -> f64, seconds: f64, onset: f64, ppm: f64) -> Vec<f64> {
        let mut random = Random::stream(7, 0, "tracked");
        let frames = ((seconds + 1.5) * RATE_HZ) as usize;
        let at = |frame: usize| (frame as f64 - onset) / (1.0 + 1e-6 * ppm);
        let inside = |place: f64| place >= 0.0 && place < seconds * RATE_HZ;
        (0..frames)
            .map(|frame| {
                let place = at(frame);
                let sample = if inside(place) { played(place) } else { 0.0 };
                -0.5 * sample + 1e-4 * random.normal()
            })
            .collect()
    }

    /// Many tones of no common period, so that it is known between samples: up to 1 kHz, without a repeat.
    fn texture(place: f64) -> f64 {
        let tone = |k: f64| (place * (0.004 + 0.0031 * k + 0.0007 * k * k) + k * k).sin();
        (0..12).map(|k| 0.05 * tone(f64::from(k))).sum()
    }

    fn tracked(played: &dyn Fn(f64) -> f64, seconds: f64, recorded: &[f64]) -> ClockTracker {
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let mut tracker = ClockTracker::new(rate, 100, 36_000);
        let drive = (0..(seconds * RATE_HZ) as usize).map(|n| played(n as f64));
        tracker.played(drive);
        for (k, chunk) in recorded.chunks(2_400).enumerate() {
            tracker.recorded(100 + 2_400 * k as u64, chunk);
            assert!(tracker.recorded.len() < 4 * 48_000, "memory is bounded");
        }
        tracker
    }

    #[test]
    fn two_clocks_are_compared_while_they_run() {
        let rate = SampleRate::new(RATE_HZ).unwrap();
        for ppm in [0.0, 50.0, -120.0] {
            let recorded = heard(&texture, 60.0, 9_600.0, ppm);
            let found = tracked(&texture, 60.0, &recorded).result().unwrap();
            assert!((found.drift_ppm - ppm).abs() < 0.1, "{ppm}: {found:?}");
            assert!(found.uncertainty_ppm < 0.2, "{found:?}");
            assert_eq!(found.step_s, None, "{ppm}");
            assert_eq!(
                found.warnings(rate).len(),
                usize::from(ppm != 0.0),
                "{found:?}"
            );
        }
    }

    /// A tone has the same phase a period later.
    #[test]
    fn a_tone_is_followed_from_period_to_period() {
        let tone = |place: f64| 0.4 * (place * std::f64::consts::TAU * 250.0 / RATE_HZ).sin();
        let recorded = heard(&tone, 30.0, 9_600.0, 80.0);
        let found = tracked(&tone, 30.0, &recorded).result().unwrap();
        assert!(
            (found.drift_ppm - 80.0).abs() < 1.0 && found.step_s.is_none(),
            "{found:?}"
        );
    }

    /// Frames that a system loses without a word shift what comes after them; what it reports does not.
    #[test]
    fn lost_frames_that_were_not_reported_are_a_step_and_no_drift() {
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let mut recorded = heard(&texture, 60.0, 9_600.0, 0.0);
        recorded.drain(1_500_000..1_500_064);
        let found = tracked(&texture, 60.0, &recorded).result().unwrap();
        let [at_s, by_s] = found.step_s.unwrap();
        assert!((at_s - 31.25).abs() < 1.0, "{found:?}");
        assert!((by_s + 64.0 / RATE_HZ).abs() < 2e-5, "{found:?}");
        let said: Vec<String> = found
            .warnings(rate)
            .iter()
            .map(ToString::to_string)
            .collect();
        assert!(said.len() == 1 && said[0].contains("stepped"), "{said:?}");

        let mut tracker = tracked(&texture, 60.0, &[]);
        let recorded = heard(&texture, 60.0, 9_600.0, 0.0);
        tracker.recorded(100, &recorded[..1_500_000]);
        tracker.recorded(100 + 1_500_064, &recorded[1_500_064..]);
        let found = tracker.result().unwrap();
        assert!(
            found.step_s.is_none() && found.drift_ppm.abs() < 0.1,
            "{found:?}"
        );
    }

    /// A sweep has many peaks that are alike where it is fast.
    #[test]
    fn sweeps_are_followed_without_a_step() {
        let rate_hz = 8_000.0;
        let rate = SampleRate::new(rate_hz).unwrap();
        let (seconds, growth) = (60.0, 50f64.ln());
        let sweep = |place: f64| {
            let t = place / rate_hz;
            let phase = std::f64::consts::TAU * 20.0 * seconds / growth
                * ((growth * t / seconds).exp() - 1.0);
            0.5 * phase.sin()
        };
        for ppm in [10.0, 20.0] {
            let mut tracker = ClockTracker::new(rate, 0, 8_000);
            tracker.played((0..480_000).map(|n| sweep(f64::from(n))));
            let recorded: Vec<f64> = (0..490_000)
                .map(|n| (f64::from(n) - 2_000.0) / (1.0 + 1e-6 * ppm))
                .map(|place| {
                    if (0.0..480_000.0).contains(&place) {
                        0.5 * sweep(place)
                    } else {
                        0.0
                    }
                })
                .collect();
            tracker.recorded(0, &recorded);
            let found = tracker.result().unwrap();
            assert_eq!(found.step_s, None, "{found:?}");
            assert!(
                (found.drift_ppm - ppm).abs() < found.uncertainty_ppm,
                "{found:?}"
            );
        }
    }

    /// Two short parts of noise with silence between them: 27 s apart, 50 ppm are 65 samples.
    #[test]
    fn a_drive_with_a_long_silence_is_compared() {
        let played = |place: f64| match place / RATE_HZ {
            s if s < 1.2 || (28.0..29.2).contains(&s) => texture(place),
            _ => 0.0,
        };
        let recorded = heard(&played, 30.0, 9_600.0, 50.0);
        let found = tracked(&played, 30.0, &recorded).result().unwrap();
        assert!(
            (found.drift_ppm - 50.0).abs() < found.uncertainty_ppm,
            "{found:?}"
        );
    }

    #[test]
    fn of_noise_silence_and_short_drives_nothing_is_said() {
        let mut random = Random::stream(1, 0, "noise");
        let noise: Vec<f64> = (0..1_000_000).map(|_| 0.1 * random.normal()).collect();
        assert_eq!(tracked(&texture, 20.0, &noise).result(), None);
        assert_eq!(
            tracked(&texture, 20.0, &vec![0.0; 1_000_000]).result(),
            None
        );
        assert_eq!(tracked(&|_| 0.0, 20.0, &noise).result(), None);
        let recorded = heard(&texture, 3.0, 9_600.0, 50.0);
        assert_eq!(tracked(&texture, 3.0, &recorded).result(), None);
    }
}
