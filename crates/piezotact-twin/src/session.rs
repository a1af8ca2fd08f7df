//! A bench on which a person touches a sample while channels are acquired, with the trait of hardware benches.

use std::collections::VecDeque;

use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{BenchKind, Condition};

use super::RATE_HZ;
use super::parameters::TwinParameters;
use super::participant::Participant;
use super::sensors::{Accelerometer, SlowHand, TriaxialCell, at_rest};
use super::sliding::{Scene, Sliding};
use piezotact::run::RunChunk;
use piezotact_bench::random::Random;
use piezotact_bench::{
    Acquire, AcquireDescription, DeviceError, RunPlan, SensorCalibration, StopHandle, Until,
};

/// Samples of a chunk: half a second.
pub(crate) const CHUNK: usize = 2_500;
/// Samples of a calibration at rest.
pub(crate) const CALIBRATION: usize = 5_000;

/// The rate of the acquisition.
pub(crate) fn rate() -> SampleRate {
    SampleRate::new(RATE_HZ).unwrap_or_else(|_| unreachable!("a constant rate above zero"))
}

/// The channels of the nail and of the forces on the sample.
pub(crate) fn nail_and_forces() -> Vec<(String, Unit)> {
    let mut channels = vec![("acceleration".to_owned(), Unit::MetrePerSecondSquared)];
    channels.extend(["force_x", "force_y", "force_z"].map(|name| (name.into(), Unit::Newton)));
    channels
}

/// A finger on a sample and its sensors in one run, drawn from the streams of that run.
pub(crate) struct Touched {
    pub(crate) sliding: Sliding,
    pub(crate) held: SlowHand,
    pub(crate) nail: Accelerometer,
}

impl Touched {
    /// Those of `scene`; `random` is the run's stream of a name.
    pub(crate) fn of(scene: Scene<'_>, random: impl Fn(&str) -> Random) -> Self {
        let hand = &scene.parameters.hand;
        Self {
            sliding: Sliding::new(scene, random("friction")),
            held: SlowHand::new(hand, scene.load_n, RATE_HZ, random("force")),
            nail: on_nail(scene.parameters, scene.participant, random("accelerometer")),
        }
    }
}

/// The accelerometer on the nail of `participant`.
pub(crate) fn on_nail(
    parameters: &TwinParameters,
    participant: &Participant,
    random: Random,
) -> Accelerometer {
    Accelerometer::new(&parameters.accelerometer, RATE_HZ, random).calibrated(participant.seed)
}

/// A second of these while nothing moves.
pub(crate) fn quiet(mut nail: Accelerometer, mut cell: TriaxialCell) -> Vec<Vec<f64>> {
    let mut channels = empty(nail_and_forces().len(), CALIBRATION);
    for _ in 0..CALIBRATION {
        let [x, y, z] = cell.read([0.0; 3]);
        for (channel, reading) in channels.iter_mut().zip([nail.read(0.0), x, y, z]) {
            channel.push(reading);
        }
    }
    channels
}

/// Empty lists for `channels`, with room for `samples` each.
pub(crate) fn empty(channels: usize, samples: usize) -> Vec<Vec<f64>> {
    (0..channels).map(|_| Vec::with_capacity(samples)).collect()
}

/// A simulated touch bench, stretch by stretch: a stroke with the time before it.
pub(crate) trait Touching: Send {
    /// What the bench is, for people.
    fn name(&self) -> String;
    /// The channels.
    fn channels(&self) -> Vec<(String, Unit)>;
    /// Who touches what, and how.
    fn condition(&self) -> Condition;
    /// The seed.
    fn seed(&self) -> u64;
    /// Steps of the recording's provenance.
    fn provenance(&self) -> Vec<String>;
    /// Refuses a run that cannot be.
    fn check(&self, run: &RunPlan) -> Result<(), DeviceError>;
    /// A second of the sensors at rest.
    fn at_rest(&self) -> Vec<Vec<f64>>;
    /// Begins a run: what follows comes of `stretches` one after the other.
    fn begin(&self, run: &RunPlan) -> Box<dyn Stretches>;
}

/// A run, stretch by stretch.
pub(crate) trait Stretches: Send {
    /// The next stretch, a list of samples a channel; `None` when the run is over.
    fn next(&mut self) -> Option<Vec<Vec<f64>>>;
}

/// The acquiring half of a bench on which somebody touches something.
pub(crate) struct Session<T> {
    bench: T,
    planned: Option<(RunPlan, StopHandle)>,
    run: Option<UnderWay>,
    waiting: Vec<VecDeque<f64>>,
}

struct UnderWay {
    stretches: Box<dyn Stretches>,
    stop: StopHandle,
    /// The requested number of samples, if there is one.
    wanted: Option<usize>,
    acquired: usize,
}

impl<T: Touching + 'static> Session<T> {
    pub(crate) fn boxed(bench: T) -> Box<dyn Acquire> {
        let waiting = bench.channels().iter().map(|_| VecDeque::new()).collect();
        Box::new(Self {
            bench,
            planned: None,
            run: None,
            waiting,
        })
    }
}

impl<T: Touching> Acquire for Session<T> {
    fn describe(&self) -> AcquireDescription {
        AcquireDescription {
            answers_with: None,
            name: self.bench.name(),
            kind: BenchKind::Twin,
            rate: rate(),
            channels: self.bench.channels(),
            condition: self.bench.condition(),
            seed: Some(self.bench.seed()),
            steps: self.bench.provenance(),
        }
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError> {
        Ok(at_rest(&self.bench.at_rest()))
    }

    fn ready(&mut self, run: &RunPlan, stop: &StopHandle) -> Result<(), DeviceError> {
        self.bench.check(run)?;
        self.planned = Some((run.clone(), stop.clone()));
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        let planned = self.planned.take();
        let (plan, stop) = planned.ok_or(DeviceError::Order {
            asked: "acquire",
            before: "made ready",
        })?;
        for channel in &mut self.waiting {
            channel.clear();
        }
        let wanted = match plan.until {
            Until::Duration(duration) => Some(rate().samples_in(duration)),
            Until::PlaybackEnded | Until::Stopped => None,
        };
        self.run = Some(UnderWay {
            stretches: self.bench.begin(&plan),
            stop,
            wanted,
            acquired: 0,
        });
        Ok(())
    }

    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        let run = self.run.as_mut().ok_or(DeviceError::Order {
            asked: "wait",
            before: "started",
        })?;
        let left = run.wanted.map_or(CHUNK, |wanted| wanted - run.acquired);
        if run.stop.is_stopped() || left == 0 {
            return Ok(None);
        }
        while self.waiting.first().map_or(0, VecDeque::len) < CHUNK {
            let Some(stretch) = run.stretches.next() else {
                break;
            };
            for (channel, samples) in self.waiting.iter_mut().zip(stretch) {
                channel.extend(samples);
            }
        }
        let here = self.waiting.first().map_or(0, VecDeque::len);
        let count = CHUNK.min(left).min(here);
        if count == 0 {
            return Ok(None);
        }
        let channels = self
            .waiting
            .iter_mut()
            .map(|channel| channel.drain(..count).collect())
            .collect();
        let chunk = RunChunk {
            first: run.acquired as u64,
            device_s: Some(run.acquired as f64 / RATE_HZ),
            channels,
            ..RunChunk::default()
        };
        run.acquired += count;
        Ok(Some(chunk))
    }

    fn stop(&mut self) {
        self.planned = None;
        self.run = None;
    }
}
