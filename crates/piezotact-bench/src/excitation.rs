//! Drives that characterise a device.

use crate::DeviceError;
use std::f64::consts::TAU;
use std::str::FromStr;

use num_complex::Complex;
use piezotact::Series;
use piezotact::quantity::{Band, Drive, SampleRate, Seconds};
use piezotact::transfer::Blocks;
use piezotact_fourier::RealPlanner;

use crate::error::ProcedureError;
use crate::random::Random;

/// What kind of drive characterises a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Excitation {
    /// Band-limited Gaussian noise.
    Random,
    /// Exponential sine sweeps, one after the other.
    Sweep,
    /// Random-phase multisines on an odd-random grid: several realisations of several periods each.
    Multisine,
}

impl Excitation {
    /// The name as it is written on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Sweep => "sweep",
            Self::Multisine => "multisine",
        }
    }
}

impl FromStr for Excitation {
    type Err = ProcedureError;

    fn from_str(text: &str) -> Result<Self, ProcedureError> {
        let all = [Self::Random, Self::Sweep, Self::Multisine];
        all.into_iter()
            .find(|kind| kind.name() == text)
            .ok_or_else(|| {
                impossible(
                    "random, sweep or multisine",
                    format!("`{text}`"),
                    "random is what the thesis used",
                )
            })
    }
}

/// A drive that characterises a device.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitationConfig {
    /// What kind of drive.
    pub kind: Excitation,
    /// The band that is excited.
    pub band: Band,
    /// The largest duration: sweeps and multisines fill as much of it as whole blocks allow.
    pub duration: Seconds,
    /// The largest sample, full scale = 1.
    pub peak: f64,
    pub seed: u64,
}

/// Sweeps in a drive.
const SWEEPS: usize = 3;
/// Rest after a sweep, for the response to decay, s.
const TAIL_S: f64 = 0.5;
/// Fade at both ends of a sweep or a realisation, s.
const FADE_S: f64 = 0.02;
/// The settling time from the end of the fade until the response is periodic, s.
const SETTLE_S: f64 = 0.48;
/// One period of a multisine, s: lines 0.5 Hz apart, excited ones 1 Hz.
const PERIOD_S: f64 = 2.0;
/// The largest delay of a detected onset of a drive, s.
const ONSET_S: f64 = 0.01;
/// One in every group of this many neighbouring odd lines is left out.
const GROUP: usize = 4;

fn impossible(expected: &str, found: String, todo: &str) -> ProcedureError {
    ProcedureError::Device(DeviceError::Impossible {
        expected: expected.into(),
        found,
        todo: todo.into(),
    })
}

/// The distribution of a duration over realisations and periods of a multisine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Filling {
    realisations: usize,
    periods: usize,
}

impl Filling {
    fn row_s(self) -> f64 {
        2.0 * FADE_S + SETTLE_S + self.periods as f64 * PERIOD_S
    }

    /// Four periods each where four realisations fit, or else two.
    fn of(duration: Seconds) -> Result<Self, ProcedureError> {
        let fill = |periods: usize| {
            let one = Self {
                realisations: 0,
                periods,
            };
            Self {
                realisations: (duration.0 / one.row_s() + 1e-9).floor() as usize,
                periods,
            }
        };
        let found = Some(fill(4))
            .filter(|f| f.realisations >= 4)
            .unwrap_or_else(|| fill(2));
        if found.realisations < 2 {
            return Err(impossible(
                &format!(
                    "at least {:.1} s, for two realisations of two periods",
                    2.0 * found.row_s()
                ),
                duration.to_string(),
                "60 s is usual",
            ));
        }
        Ok(found)
    }
}

/// Whole samples at `rate` in `seconds`.
fn whole(seconds: f64, rate: SampleRate) -> Result<usize, ProcedureError> {
    let samples = seconds * rate.hz();
    if (samples - samples.round()).abs() > 1e-6 {
        return Err(impossible(
            &format!("a rate with a whole number of samples in {seconds:.3} s"),
            rate.to_string(),
            "use a random drive",
        ));
    }
    Ok(samples.round() as usize)
}

impl ExcitationConfig {
    fn possible(&self, rate: SampleRate) -> Result<(), ProcedureError> {
        if !(1.0..=600.0).contains(&self.duration.0) {
            let found = self.duration;
            return Err(DeviceError::Duration { found }.into());
        }
        if !(1e-3..=1.0).contains(&self.peak) {
            return Err(impossible(
                "a peak from 0.001 to 1",
                self.peak.to_string(),
                "0.8 is usual",
            ));
        }
        if self.band.high().0 >= rate.nyquist().0 {
            return Err(impossible(
                &format!("a band below half of {rate}"),
                self.band.to_string(),
                "lower its end",
            ));
        }
        Ok(())
    }

    /// The positions of the sweeps or periods in a recording at `rate`, from the onset of the drive; `None` for a random
    /// drive, which has no blocks.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] when the duration holds too few, or the rate no whole number of samples.
    pub fn blocks(&self, rate: SampleRate) -> Result<Option<Blocks>, ProcedureError> {
        match self.kind {
            Excitation::Random => Ok(None),
            Excitation::Sweep => {
                let stride = whole(self.sweep_s()?, rate)?;
                Ok(Some(Blocks {
                    lead: 0,
                    length: stride - rate.samples_in(Seconds(2.0 * ONSET_S)),
                    in_a_row: 1,
                    stride,
                    rows: SWEEPS,
                }))
            }
            Excitation::Multisine => {
                let filling = Filling::of(self.duration)?;
                Ok(Some(Blocks {
                    lead: rate.samples_in(Seconds(FADE_S + SETTLE_S - ONSET_S)),
                    length: whole(PERIOD_S, rate)?,
                    in_a_row: filling.periods,
                    stride: whole(filling.row_s(), rate)?,
                    rows: filling.realisations,
                }))
            }
        }
    }

    /// One sweep with the rest after it, whole milliseconds.
    fn sweep_s(&self) -> Result<f64, ProcedureError> {
        let each_s = (self.duration.0 / SWEEPS as f64 * 1e3).floor() / 1e3;
        if each_s < 2.0 || self.band.low().0 < 1.0 {
            return Err(impossible(
                "at least 6 s and a band from 1 Hz up for three sweeps",
                format!("{} over {}", self.duration, self.band),
                "60 s over 2..1200 is usual",
            ));
        }
        Ok(each_s)
    }

    /// A description for the provenance, for a drive that was played with a peak of `peak` of full scale.
    #[must_use]
    pub fn text(&self, peak: f64) -> String {
        let mut lasted = self.duration;
        let kind = match (self.kind, Filling::of(self.duration)) {
            (Excitation::Multisine, Ok(filling)) => {
                lasted = Seconds(filling.row_s() * filling.realisations as f64);
                format!(
                    "{} random-phase multisines of {} periods of {PERIOD_S} s on odd lines, one of {GROUP} left out,",
                    filling.realisations, filling.periods
                )
            }
            (Excitation::Sweep, _) => format!("{SWEEPS} exponential sine sweeps"),
            _ => "random drive".into(),
        };
        format!(
            "{kind} over {}, {}, peak {peak:.3} of full scale, seed {}",
            self.band, lasted, self.seed
        )
    }
}

/// The drive that `config` describes, at `rate`, with the stated peak.
///
/// # Errors
/// [`DeviceError::Impossible`] when the duration is shorter than a second (6 s for sweeps, 9.04 s for multisines) or longer
/// than 10 minutes, the peak is not from 0.001 to 1, or the band does not fit the rate.
pub fn excitation(
    config: &ExcitationConfig,
    rate: SampleRate,
) -> Result<Series<Drive>, ProcedureError> {
    config.possible(rate)?;
    let mut samples = match config.kind {
        Excitation::Random => random(config, rate),
        Excitation::Sweep => sweeps(config, rate)?,
        Excitation::Multisine => multisines(config, rate)?,
    };
    let largest = piezotact::statistics::peak(&samples);
    if largest <= 0.0 {
        return Err(impossible(
            &format!(
                "a band wider than the lines that {} resolve",
                config.duration
            ),
            config.band.to_string(),
            "widen it, 2..1200 is usual",
        ));
    }
    for sample in &mut samples {
        *sample *= config.peak / largest;
    }
    Ok(Series::new(samples, rate)?)
}

fn synthesised(mut bins: Vec<Complex<f64>>, samples: usize) -> Vec<f64> {
    if samples.is_multiple_of(2) {
        bins[samples / 2].im = 0.0;
    }
    let plan = RealPlanner::new().plan_fft_inverse(samples);
    let mut output = plan.make_output_vec();
    let done = plan.process(&mut bins, &mut output);
    debug_assert!(done.is_ok());
    output
}

/// A random drive whose spectrum is flat in the band and zero outside: Gaussian bins of one long transform, so that there
/// is nothing outside the band and no filter's ripple inside (thesis 2.5.3: "a random signal up to 1 kHz").
fn random(config: &ExcitationConfig, rate: SampleRate) -> Vec<f64> {
    let n = rate.samples_in(config.duration);
    let mut random = Random::stream(config.seed, 0, "excitation");
    let bins = (0..=n / 2)
        .map(|k| {
            if config.band.contains(k as f64 * rate.hz() / n as f64) && k > 0 {
                Complex::new(random.normal(), random.normal())
            } else {
                Complex::default()
            }
        })
        .collect();
    synthesised(bins, n)
}

/// The share of full level `i` samples into a stretch of `length` that fades over `fade` samples at both ends.
fn faded(i: usize, length: usize, fade: usize) -> f64 {
    piezotact::fourier::fade(i.min(length - 1 - i) as f64 / fade.max(1) as f64)
}

/// Exponential sweeps, with a constant number of octaves per second (A. Farina, 108th AES Convention, 2000): low
/// frequencies, where the device responds least, get most of the time.
fn sweeps(config: &ExcitationConfig, rate: SampleRate) -> Result<Vec<f64>, ProcedureError> {
    let each_s = config.sweep_s()?;
    let (stride, fade) = (whole(each_s, rate)?, rate.samples_in(Seconds(FADE_S)));
    let sweep_s = each_s - TAIL_S;
    let length = rate.samples_in(Seconds(sweep_s));
    let (low, high) = (config.band.low().0, config.band.high().0);
    let growth = (high / low).ln() / sweep_s;
    let one: Vec<f64> = (0..stride)
        .map(|i| {
            if i >= length {
                return 0.0;
            }
            let turns = low / growth * ((growth * i as f64 / rate.hz()).exp() - 1.0);
            faded(i, length, fade) * (TAU * turns).sin()
        })
        .collect();
    Ok(one.repeat(SWEEPS))
}

/// Multisines of equal level and random phases on odd lines, one line of every group left out: power of the response on
/// the lines left out, and on even lines, is distortion (J. Schoukens, M. Vaes and R. Pintelon (2016), IEEE
/// Control Systems 36(3)).
fn multisines(config: &ExcitationConfig, rate: SampleRate) -> Result<Vec<f64>, ProcedureError> {
    let filling = Filling::of(config.duration)?;
    let (period, row) = (whole(PERIOD_S, rate)?, whole(filling.row_s(), rate)?);
    let fade = rate.samples_in(Seconds(FADE_S));
    let odd: Vec<usize> = (1..period / 2)
        .step_by(2)
        .filter(|k| config.band.contains(*k as f64 / PERIOD_S))
        .collect();
    let mut grid = Random::stream(config.seed, 0, "multisine grid");
    let lines: Vec<usize> = odd
        .chunks(GROUP)
        .flat_map(|group| {
            let out = (grid.uniform() * GROUP as f64) as usize;
            group
                .iter()
                .enumerate()
                .filter(move |(k, _)| *k != out)
                .map(|(_, line)| *line)
        })
        .collect();
    let mut samples = Vec::with_capacity(row * filling.realisations);
    for realisation in 1..=filling.realisations {
        let mut phases = Random::stream(config.seed, realisation as u64, "multisine phases");
        let mut bins = vec![Complex::default(); period / 2 + 1];
        for line in &lines {
            bins[*line] = Complex::from_polar(1.0, TAU * phases.uniform());
        }
        let one = synthesised(bins, period);
        samples.extend((0..row).map(|i| faded(i, row, fade) * one[i % period]));
    }
    Ok(samples)
}

#[cfg(test)]
mod tests {
    use piezotact::quantity::Hertz;

    use super::*;

    fn config(kind: Excitation, seconds: f64) -> ExcitationConfig {
        ExcitationConfig {
            kind,
            band: Band::new(Hertz(2.0), Hertz(1_000.0)).unwrap(),
            duration: Seconds(seconds),
            peak: 0.5,
            seed: 3,
        }
    }

    fn rate() -> SampleRate {
        SampleRate::new(5_000.0).unwrap()
    }

    #[test]
    fn drives_have_the_peak_asked_for_and_fit_the_time() {
        for kind in [Excitation::Random, Excitation::Sweep, Excitation::Multisine] {
            let drive = excitation(&config(kind, 20.0), rate()).unwrap();
            assert!((drive.peak() - 0.5).abs() < 1e-12, "{kind:?}");
            assert!(
                drive.duration().0 <= 20.0 && drive.duration().0 > 15.0,
                "{kind:?}: {}",
                drive.duration()
            );
            assert_eq!(kind.name().parse::<Excitation>().unwrap(), kind);
            assert_eq!(drive, excitation(&config(kind, 20.0), rate()).unwrap());
        }
    }

    /// A minute holds seven realisations of four periods; ten seconds two of two.
    #[test]
    fn multisines_fill_the_time_with_periods() {
        let filled = |seconds: f64| Filling::of(Seconds(seconds));
        assert_eq!(
            filled(60.0).unwrap(),
            Filling {
                realisations: 7,
                periods: 4
            }
        );
        assert_eq!(
            filled(10.0).unwrap(),
            Filling {
                realisations: 2,
                periods: 2
            }
        );
        assert!(filled(9.0).is_err());
    }

    /// The blocks that the analysis cuts are periods: they repeat, and only odd lines of the band are in them.
    #[test]
    fn blocks_hold_whole_periods_of_odd_lines() {
        let config = config(Excitation::Multisine, 20.0);
        let drive = excitation(&config, rate()).unwrap();
        let blocks = config.blocks(rate()).unwrap().unwrap();
        for row in 0..blocks.rows {
            let at = blocks.lead + row * blocks.stride;
            let first = &drive.samples()[at..at + blocks.length];
            let second = &drive.samples()[at + blocks.length..at + 2 * blocks.length];
            assert!(first.iter().zip(second).all(|(a, b)| (a - b).abs() < 1e-12));
            // A signal with only odd lines changes sign after half a period.
            let half = blocks.length / 2;
            assert!(
                first
                    .iter()
                    .zip(&first[half..])
                    .all(|(a, b)| (a + b).abs() < 1e-12)
            );
        }
        let end = blocks.lead + (blocks.rows - 1) * blocks.stride + blocks.in_a_row * blocks.length;
        assert!(end < drive.samples().len());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for (kind, seconds) in [
            (Excitation::Sweep, 5.0),
            (Excitation::Multisine, 9.0),
            (Excitation::Random, 0.5),
        ] {
            let refused = excitation(&config(kind, seconds), rate())
                .unwrap_err()
                .to_string();
            assert!(refused.contains("60 s"), "{refused}");
        }
        assert!("chirp".parse::<Excitation>().is_err());
        let odd = SampleRate::new(5_000.1).unwrap();
        assert!(config(Excitation::Multisine, 20.0).blocks(odd).is_err());
    }
}
