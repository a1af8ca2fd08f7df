//! A sound device as a bench.

mod halves;
mod silent;

use piezotact::Warning;
use piezotact::device::{DeviceAtGain, DriveSetup};
use piezotact::quantity::{Seconds, Volts};
use piezotact::recording::{BenchKind, MissingChannel, RecordingWarning};
use piezotact::sound::{CalibrationFault, LatencySummary, SoundCalibration, SoundWarning};
use piezotact_bench::Bench;

use crate::error::AudioError;
use crate::forced::{JoinedForce, source};
use crate::io::{AudioIo, StreamPlan};
use crate::setup::{Measures, RecordedChannel, SoundSetup};
use crate::streams::{RunningStreams, StreamChannels};
use halves::{Parts, halves};

/// Everything that makes a sound device a bench.
#[derive(Debug)]
pub struct AudioBench {
    pub setup: SoundSetup,
    /// Its calibration; absent where it was never calibrated.
    pub calibration: Option<SoundCalibration>,
    /// The amplifier and the actuator, with the gain that is set.
    pub device: DeviceAtGain,
    /// Who is at it, where it is known.
    pub participant: Option<String>,
    /// Its latency; absent where it was never measured.
    pub latency: Option<LatencySummary>,
    /// The seed of a simulated person in front of it.
    pub twin_seed: Option<u64>,
    /// What stands behind the device: hardware, or a simulation.
    pub kind: BenchKind,
    /// The day, counted as [`SoundCalibration::made_on_day`].
    pub today: i64,
}

impl AudioBench {
    /// Opens the device on `io` and checks the level of its loopback against the calibration.
    ///
    /// # Errors
    /// Those of [`RunningStreams::open`]; [`AudioError::Sound`] when the calibration is of another device, or the loopback's level is
    /// off by more than 0.1 dB.
    pub fn open(mut self, io: &mut dyn AudioIo) -> Result<Bench, AudioError> {
        let (called, buffer_frames) = (self.setup.called(), self.setup.buffer_frames);
        // What was measured with other buffers or another device says nothing of this one.
        self.latency = self
            .latency
            .filter(|latency| latency.device == called && latency.buffer_frames == buffer_frames);
        let mut streams = self.setup.open_streams(io)?;
        let mut warnings = Vec::new();
        match &self.calibration {
            Some(calibration) => {
                calibration.holds_for(&self.setup.called(), self.setup.rate()?)?;
                for recorded in &self.setup.record {
                    calibration.sensor_holds(recorded.channel, recorded.v_per_unit())?;
                }
                warnings.extend(calibration.warnings_on(self.today));
                if calibration.loopback.is_some() && self.setup.loopback().is_some() {
                    let found = crate::calibrate::measured_loopback(&mut streams, &self.setup)?;
                    calibration.level_holds(found.gain)?;
                    let buffers = 2.0 * f64::from(buffer_frames) / self.setup.rate_hz;
                    let stored = self.latency.as_ref();
                    let changed =
                        stored.and_then(|stored| stored.changed(found.latency, Seconds(buffers)));
                    if let Some(changed) = changed {
                        warnings.push(changed);
                        self.latency = None;
                    }
                }
            }
            None => warnings.push(Warning::from(SoundWarning::Calibration {
                fault: CalibrationFault::Missing {
                    what: format!("the sound device `{}`", self.setup.called()),
                },
            })),
        }
        if self.setup.loopback().is_none() {
            warnings.push(Warning::from(RecordingWarning::ChannelMissing {
                what: MissingChannel::Loopback,
            }));
        }
        let inputs: Vec<Input> = self
            .setup
            .record
            .iter()
            .map(|recorded| self.input(recorded))
            .collect();
        for input in &inputs {
            if input.measures == Measures::Force {
                warnings.push(Warning::from(RecordingWarning::ChannelMissing {
                    what: MissingChannel::SteadyForce {
                        channel: input.measures.name().into(),
                    },
                }));
            }
            if input.calibrated == Calibrated::No {
                warnings.push(Warning::from(SoundWarning::Calibration {
                    fault: CalibrationFault::Missing {
                        what: format!("input {} (`{}`)", input.channel + 1, input.measures.name()),
                    },
                }));
            }
        }
        let drive_setup = self.drive_setup()?;
        let force = match &self.setup.force {
            Some(settings) => {
                let late_s = settings.least_delay_s.unwrap_or(0.0);
                Some(JoinedForce::start(
                    source(settings)?,
                    late_s,
                    streams.rate(),
                )?)
            }
            None => None,
        };
        Ok(halves(Parts {
            bench: self,
            drive_setup,
            streams,
            inputs,
            warnings,
            force,
        }))
    }

    /// The path from the drive to the actuator; none where the output was not calibrated.
    fn drive_setup(&self) -> Result<Option<DriveSetup>, AudioError> {
        let output = self
            .calibration
            .as_ref()
            .and_then(|calibration| calibration.output.as_ref());
        let Some(output) = output else {
            return Ok(None);
        };
        let load_f = self.device.device().actuator().capacitance_f;
        DriveSetup::new(self.device.clone(), Volts(output.v_per_full_scale), load_f)
            .map(Some)
            .map_err(|error| AudioError::Setup(error.to_string()))
    }

    /// How the channel `recorded` is read.
    fn input(&self, recorded: &RecordedChannel) -> Input {
        let calibration = self.calibration.as_ref();
        let known = calibration.and_then(|calibration| {
            calibration
                .inputs
                .iter()
                .find(|input| input.channel == recorded.channel)
        });
        let (scale, calibrated) = match recorded.measures {
            // What is played at full scale reads 1.
            Measures::Drive => {
                let gain = calibration
                    .and_then(|calibration| calibration.loopback)
                    .map(|level| level.gain);
                (gain.map_or(1.0, |gain| 1.0 / gain), gain.is_some())
            }
            _ => (
                known.map_or(1.0, |input| input.per_full_scale),
                known.is_some(),
            ),
        };
        Input {
            channel: recorded.channel as usize - 1,
            measures: recorded.measures,
            scale,
            calibrated: if calibrated {
                Calibrated::Yes
            } else {
                Calibrated::No
            },
        }
    }
}

impl SoundSetup {
    /// Opens its streams on `io`.
    ///
    /// # Errors
    /// Those of [`RunningStreams::open`].
    pub fn open_streams(&self, io: &mut dyn AudioIo) -> Result<RunningStreams, AudioError> {
        let from_zero = |channel: &u32| *channel as usize - 1;
        let channels = StreamChannels {
            output: self.output_channels(),
            drive: self.play.drive.iter().map(from_zero).collect(),
            trigger: self.play.trigger.as_ref().map(from_zero),
            input: self.input_channels(),
        };
        let plan = StreamPlan {
            output: self.output.clone(),
            input: self.input.clone(),
            rate: self.rate()?,
            buffer_frames: self.buffer_frames,
        };
        RunningStreams::open(io, &self.called(), &plan, &channels)
    }
}

/// Whether an input has a scale of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Calibrated {
    Yes,
    No,
}

/// One recorded channel.
#[derive(Clone, Debug)]
struct Input {
    channel: usize,
    measures: Measures,
    /// The value at full scale, in the SI unit.
    scale: f64,
    calibrated: Calibrated,
}
