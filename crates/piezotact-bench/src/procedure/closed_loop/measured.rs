//! The measurements of a closed loop, and the checks of their reliability.

use piezotact::Warning;
use piezotact::clipping::{Clipping, clipping};
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Drive, Force, Hertz, SampleRate, Seconds};
use piezotact::recording::{
    BenchKind, BrokenPlayback, LostBy, Recording, RecordingWarning, StartTime,
};
use piezotact::resample::resample_over;
use piezotact::run::{RunStart, Sink, SinkError};
use piezotact::series::Series;
use piezotact::spectrum::{Spectrum, WelchConfig, WelchPlan};
use piezotact::statistics::{mean, standard_deviation};

use super::{LoopConfig, LoopFailure, impossible};
use crate::error::ProcedureError;
use crate::plan::{Placement, RunPlan};
use crate::procedure::{ACCELERATION_CHANNEL, FORCE_CHANNEL, RunKeeper, play_and_record};
use crate::traits::Bench;

/// The duration of the noise measurement before anything is played, s.
const SILENCE_S: f64 = 4.0;
/// The window over which the mean force is checked, s.
const WINDOW_S: f64 = 10.0;
/// The largest factor by which the tolerance is widened for shorter windows, in which the mean force varies more (with the
/// square root of time).
const MOST_WIDER: f64 = 3.0;
/// The least ratio of the response to its noise.
const SILENT_RATIO: f64 = 2.0;
/// The number of attempts at a measurement that is not reliable.
const ATTEMPTS: usize = 2;

/// The measured response to one drive.
pub(super) struct MeasuredResponse {
    pub(super) recording: Recording,
    /// The response at the rate of the loop.
    pub(super) response: Series<Acceleration>,
    /// The clipping found at the rate of the acquisition.
    pub(super) clipping: Clipping,
}

/// Why a measurement does not count.
pub(super) enum Broken {
    Bench(ProcedureError),
    Unbelievable(LoopFailure),
}

impl Broken {
    /// The message of the bench if it failed; the loop could be resumed with a working bench.
    pub(super) fn of_the_bench(&self) -> Option<String> {
        match self {
            Self::Bench(error) if error.continues() => Some(error.to_string()),
            Self::Bench(_) | Self::Unbelievable(_) => None,
        }
    }
}

impl From<ProcedureError> for Broken {
    fn from(error: ProcedureError) -> Self {
        Self::Bench(error)
    }
}

impl From<Broken> for LoopFailure {
    fn from(broken: Broken) -> Self {
        match broken {
            Broken::Bench(error) => Self::Bench {
                said: error.to_string(),
            },
            Broken::Unbelievable(why) => why,
        }
    }
}

impl std::fmt::Display for Broken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bench(error) => error.fmt(f),
            Self::Unbelievable(why) => why.fmt(f),
        }
    }
}

/// Measures responses: a bench with a finger on it, with the settings and the noise needed to judge them.
pub(super) struct ResponseMeter<'a> {
    pub(super) bench: &'a mut Bench,
    /// Where every run is kept.
    pub(super) keeper: &'a mut dyn RunKeeper,
    pub(super) config: &'a LoopConfig,
    /// The device that drives are made for.
    pub(super) setup: Option<DriveSetup>,
    /// The rate of the loop.
    pub(super) rate: SampleRate,
    /// The PSD of the noise, measured with silence as the drive; none before it was measured.
    pub(super) noise: Option<Spectrum<Acceleration>>,
}

/// Whether attempts may reuse runs stored by an interrupted command. If none of the stored runs is reliable, all attempts are
/// measured again: otherwise every resumed loop would end at the same runs.
#[derive(Debug, Default, PartialEq)]
enum Before {
    /// Stored runs may be reused; none was so far.
    #[default]
    Welcome,
    /// Stored runs may be reused, and one was.
    Taken,
    /// Stored runs are not used: everything is measured.
    Refused,
}

impl Before {
    /// Whether a stored run was reused; from now on everything is measured.
    fn measures_again(&mut self) -> bool {
        let taken = *self == Self::Taken;
        if taken {
            *self = Self::Refused;
        }
        taken
    }
}

/// Keeps the attempts at one measurement.
struct Attempts<'a> {
    keeper: &'a mut dyn RunKeeper,
    before: &'a mut Before,
}

impl RunKeeper for Attempts<'_> {
    fn now(&self, kind: BenchKind) -> Option<StartTime> {
        self.keeper.now(kind)
    }

    fn completed(&mut self, start: &RunStart) -> Result<Option<Recording>, SinkError> {
        if *self.before == Before::Refused {
            return Ok(None);
        }
        let found = self.keeper.completed(start)?;
        if found.is_some() {
            *self.before = Before::Taken;
        }
        Ok(found)
    }

    fn sink(&mut self, start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        self.keeper.sink(start)
    }
}

/// `response` resampled to `rate`, with the corrected band unchanged.
pub(super) fn resampled_to(
    response: &Series<Acceleration>,
    rate: SampleRate,
    config: &LoopConfig,
) -> Result<Series<Acceleration>, ProcedureError> {
    let inverse = &config.render.inverse;
    let lower = response.rate().nyquist().0.min(rate.nyquist().0);
    let passband = Hertz((inverse.band.high().0 * (1.0 + inverse.edge_ratio)).min(0.995 * lower));
    resample_over(response, rate, passband)
        .map_err(|error| impossible("rates that go together", &error))
}

impl ResponseMeter<'_> {
    fn run(&self, label: &str) -> RunPlan {
        let run = &self.config.run;
        RunPlan {
            label: format!("{}, {label}", run.label),
            placement: Placement::SameAs(run.placed_for().into()),
            ..run.clone()
        }
    }

    fn play(
        &mut self,
        drive: &Series<Drive>,
        label: &str,
        before: &mut Before,
    ) -> Result<(Recording, Series<Acceleration>), ProcedureError> {
        let run = self.run(label);
        let setup = self.setup.as_ref();
        let mut keeper = Attempts {
            keeper: self.keeper,
            before,
        };
        let recording = play_and_record(self.bench, drive, setup, &run, &mut keeper, None)?;
        let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL))?;
        Ok((recording, response))
    }

    fn at_rate(
        &self,
        response: &Series<Acceleration>,
    ) -> Result<Series<Acceleration>, ProcedureError> {
        resampled_to(response, self.rate, self.config)
    }

    /// Measures the noise (the response to silence) and estimates its PSD with `welch`.
    pub(super) fn measure_noise(
        &mut self,
        welch: &WelchConfig,
    ) -> Result<&Spectrum<Acceleration>, ProcedureError> {
        let rate = self.bench.player.describe().rate;
        let silence = Series::<Drive>::new(vec![0.0; rate.samples_in(Seconds(SILENCE_S))], rate)?;
        let (mut attempt, mut before) = (1, Before::default());
        let response = loop {
            let label = format!("silence, attempt {attempt}");
            let (recording, response) = self.play(&silence, &label, &mut before)?;
            let clipping = clipping(&response, None, None);
            match self.undisturbed(&recording, &clipping) {
                Ok(()) => break self.at_rate(&response)?,
                Err(_of_before) if attempt >= ATTEMPTS && before.measures_again() => attempt = 1,
                Err(why) if attempt >= ATTEMPTS => {
                    return Err(ProcedureError::Broken(format!(
                        "while the noise was recorded, {why}"
                    )));
                }
                Err(_again) => attempt += 1,
            }
        };
        let noise = WelchPlan::new(welch, self.rate)
            .and_then(|mut plan| plan.estimate::<Acceleration>(&[response.samples()]))
            .map_err(|error| impossible("a spectrum of the noise", &error))?;
        Ok(self.noise.insert(noise))
    }

    /// Plays `drive` and measures the response; repeats the measurement if it is not reliable.
    pub(super) fn measure(
        &mut self,
        drive: &Series<Drive>,
        label: &str,
    ) -> Result<MeasuredResponse, Broken> {
        let (mut attempt, mut before) = (1, Before::default());
        loop {
            let label = format!("{label}, attempt {attempt}");
            let (recording, response) = self.play(drive, &label, &mut before)?;
            let measured = MeasuredResponse {
                clipping: clipping(&response, None, None),
                response: self.at_rate(&response)?,
                recording,
            };
            match self.believable(&measured) {
                Ok(()) => return Ok(measured),
                Err(_of_before) if attempt >= ATTEMPTS && before.measures_again() => attempt = 1,
                Err(why) if attempt >= ATTEMPTS => return Err(Broken::Unbelievable(why)),
                Err(_again) => attempt += 1,
            }
        }
    }

    /// Checks that a run was complete, independent of its response.
    fn undisturbed(&self, recording: &Recording, clipping: &Clipping) -> Result<(), LoopFailure> {
        if let Some(warning) = incomplete(recording) {
            return Err(LoopFailure::Playback {
                warning: Box::new(warning),
            });
        }
        self.held(recording)?;
        if clipping.fraction > 0.0 {
            return Err(LoopFailure::SensorClips {
                fraction: clipping.fraction,
            });
        }
        Ok(())
    }

    fn believable(&self, measured: &MeasuredResponse) -> Result<(), LoopFailure> {
        self.undisturbed(&measured.recording, &measured.clipping)?;
        let noise = self.noise.as_ref().map_or(0.0, |noise| {
            (noise.values.iter().sum::<f64>() * noise.resolution_hz).sqrt()
        });
        let level = standard_deviation(measured.response.samples());
        if level < SILENT_RATIO * noise {
            return Err(LoopFailure::Faint {
                rms_m_s2: level,
                noise_m_s2: noise,
            });
        }
        Ok(())
    }

    /// Checks that the load was held, in windows of ten seconds.
    fn held(&self, recording: &Recording) -> Result<(), LoopFailure> {
        let Some(load) = self.config.run.load else {
            return Ok(());
        };
        let Ok(force) = recording.series::<Force>(Some(FORCE_CHANNEL)) else {
            return Ok(());
        };
        let window = force.rate().samples_in(Seconds(WINDOW_S));
        let whole = force.samples().len() / window.max(1);
        let windows = whole.max(1);
        for i in 0..windows {
            // The remainder belongs to the last window.
            let to = if i + 1 == windows {
                force.samples().len()
            } else {
                (i + 1) * window
            };
            let part = &force.samples()[i * window..to];
            let mean_n = mean(part);
            let wider = (window as f64 / part.len().max(1) as f64).sqrt();
            let share = self.config.force_share * wider.clamp(1.0, MOST_WIDER);
            if (mean_n / load.0 - 1.0).abs() > share {
                return Err(LoopFailure::Force {
                    from_s: force.rate().duration_of(i * window).0,
                    mean_n,
                    asked_n: load.0,
                    share,
                });
            }
        }
        Ok(())
    }
}

/// What `recording` lacks of its run: of the drive that was played, of the samples, or of its end.
fn incomplete(recording: &Recording) -> Option<Warning> {
    let losses = &recording.about.provenance.losses;
    if let Some(BrokenPlayback {
        played,
        expected,
        underruns,
    }) = losses.playback
    {
        let cut = RecordingWarning::SamplesLost {
            by: LostBy::Playback {
                played,
                expected,
                underruns,
            },
        };
        return Some(cut.into());
    }
    if losses.samples > 0 {
        let lost = RecordingWarning::SamplesLost {
            by: LostBy::Device {
                gaps: losses.stretches_s.len(),
                samples: losses.samples,
                longest_s: losses.longest().0,
                places_s: losses.stretches_s.clone(),
            },
        };
        return Some(lost.into());
    }
    let read_s = recording.duration().0;
    (losses.is_interrupted).then(|| RecordingWarning::Interrupted { read_s }.into())
}
