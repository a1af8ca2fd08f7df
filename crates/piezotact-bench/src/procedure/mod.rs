//! What is done with a bench, whichever it is: play a drive and keep what comes back, characterise a device.

mod characterise;
mod closed_loop;
mod repeats;

pub(crate) use characterise::LOWEST_JUDGED;
pub use characterise::{Characterisation, CharacteriseConfig, characterise, excite, transfer_of};
pub use closed_loop::{
    Closeness, Gain, GainIn, Iteration, Kept, LoopConfig, LoopEnd, Looped, Mishap, closed_loop,
};
pub use repeats::{Attempt, Gating, Measure, Refused, RepeatConfig, Repeated, repeated};

use piezotact::Doubt;
use piezotact::Series;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Drive, Force, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};

use crate::traits::{
    Acquire, Bench, BenchError, Chunk, PlayDescription, PlayReport, RunPlan, SensorCalibration,
};

/// The drive as it was sent, looped back.
pub const DRIVE_CHANNEL: &str = "drive";
/// The acceleration of the fingernail.
pub const ACCELERATION_CHANNEL: &str = "acceleration";
/// The normal force of the finger, where it is measured.
pub const FORCE_CHANNEL: &str = "normal_force";
/// The potential at full scale may depart by this share from what a drive was made for: 0.4 dB.
const OUTPUT_TOLERANCE: f64 = 0.05;
/// The mean force may depart by this share from what was asked for.
const FORCE_TOLERANCE: f64 = 0.1;

/// What is known of a run before its first sample.
#[derive(Clone, Debug, PartialEq)]
pub struct RunStart {
    /// The rate of the channels.
    pub rate: SampleRate,
    /// The channels' names and units.
    pub channels: Vec<(String, Unit)>,
    /// Who touches how.
    pub condition: Condition,
    /// Which bench, with which seed, for what.
    pub provenance: Provenance,
}

/// What is known of the run `run` on `acquirer` before its first sample.
#[must_use]
pub fn announce(acquirer: &dyn Acquire, run: &RunPlan) -> RunStart {
    let description = acquirer.describe();
    let mut steps = vec![run.label.clone()];
    steps.extend(description.steps);
    RunStart {
        rate: description.rate,
        channels: description.channels,
        condition: acquirer.condition(run),
        provenance: Provenance {
            source: description.name,
            bench: Some(description.kind),
            seed: description.seed,
            steps,
            answered_with: description.answers_with,
            ..Provenance::default()
        },
    }
}

/// What keeps chunks as they come: a journal, a progress bar.
pub type Keep<'a> =
    &'a mut dyn FnMut(&Chunk) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;

/// Refuses a drive that was made for another device than the bench is now: another gain, another potential
/// at full scale, another rate, a described device where the bench's is not, or samples beyond full scale.
///
/// # Errors
/// [`BenchError::Gain`], [`BenchError::OutputLevel`], [`BenchError::Rate`], [`BenchError::Impossible`].
pub fn require_device(
    bench: &mut Bench,
    drive: &Series<Drive>,
    rendered_for: Option<&DriveSetup>,
) -> Result<(), BenchError> {
    let PlayDescription {
        name, rate, gain, ..
    } = bench.player.describe();
    if drive.rate() != rate {
        return Err(BenchError::Rate {
            drive: drive.rate(),
            output: rate,
            name,
        });
    }
    if drive.peak() > 1.0 {
        return Err(BenchError::Impossible {
            expected: "a drive within ±1 (full scale)".into(),
            found: format!("a peak of {:.3}", drive.peak()),
            todo: "render it again at a lower level".into(),
        });
    }
    let Some(setup) = rendered_for else {
        return Ok(());
    };
    let (Some(gain), Some(found)) = (gain, bench.player.calibrate()?) else {
        return Err(BenchError::Impossible {
            expected: format!(
                "a drive for a device that nothing describes, as that of the {name} is"
            ),
            found: format!("one for gain {}", setup.gain),
            todo: "render it with the transfer function that stands behind this bench, and leave --gain out".into(),
        });
    };
    if setup.gain != gain {
        return Err(BenchError::Gain {
            drive: setup.gain,
            bench: gain,
            name,
        });
    }
    let found = found.volts_per_full_scale;
    if (found / setup.volts_per_full_scale - 1.0).abs() > OUTPUT_TOLERANCE {
        return Err(BenchError::OutputLevel {
            drive: setup.volts_per_full_scale,
            bench: found,
            name,
        });
    }
    Ok(())
}

/// Plays `drive` and acquires what comes of it, handing every chunk to `keep` as it comes and returning all
/// of it. `rendered_for` is the device the drive was made for.
///
/// # Errors
/// Those of [`require_device`]; [`BenchError::Keep`] when a chunk cannot be kept; whatever the bench returns. Both halves are stopped in any case.
pub fn play_and_record(
    bench: &mut Bench,
    drive: &Series<Drive>,
    rendered_for: Option<&DriveSetup>,
    run: &RunPlan,
    keep: Keep<'_>,
) -> Result<Recording, BenchError> {
    require_device(bench, drive, rendered_for)?;
    let at_rest = bench.acquirer.calibrate()?;
    let outcome = acquire_while_playing(bench, drive, run, keep);
    bench.player.stop();
    bench.acquirer.stop();
    let start = announce(bench.acquirer.as_ref(), run);
    let (samples, report) = outcome?;
    let mut recording = recording_of(with_rest(start, &at_rest), samples)?;
    recording.doubts.extend(bench.acquirer.doubts(run));
    recording.doubts.extend(force_doubt(&recording, run));
    let expected = drive.samples().len();
    if report.played < expected || report.underruns > 0 {
        let PlayReport { played, underruns } = report;
        recording.doubts.push(Doubt::PlaybackIncomplete {
            played,
            expected,
            underruns,
        });
    }
    Ok(recording)
}

/// Acquires a run in which a person touches something and returns all of it.
///
/// # Errors
/// Whatever the bench returns. It is stopped in any case.
pub fn record(acquirer: &mut dyn Acquire, run: &RunPlan) -> Result<Recording, BenchError> {
    let mut samples = vec![Vec::new(); acquirer.describe().channels.len()];
    let start = acquire(acquirer, run, &mut |chunk| {
        gather(&mut samples, &chunk.channels);
        Ok(())
    })?;
    recording_of(start, samples)
}

/// Acquires a run in which a person touches something, handing every chunk to `keep` as it comes and holding on to
/// none, so that a run of any length fits. Returns what is known of it, with the sensors at rest.
///
/// # Errors
/// [`BenchError::Keep`] when a chunk cannot be kept; whatever the bench returns. It is stopped in any case.
pub fn acquire(
    acquirer: &mut dyn Acquire,
    run: &RunPlan,
    keep: Keep<'_>,
) -> Result<RunStart, BenchError> {
    let at_rest = acquirer.calibrate()?;
    let outcome = acquire_all(acquirer, run, keep);
    acquirer.stop();
    outcome?;
    Ok(with_rest(announce(acquirer, run), &at_rest))
}

fn acquire_all(
    acquirer: &mut dyn Acquire,
    run: &RunPlan,
    keep: Keep<'_>,
) -> Result<(), BenchError> {
    acquirer.ready(run)?;
    acquirer.start()?;
    while let Some(chunk) = acquirer.wait()? {
        keep(&chunk).map_err(BenchError::Keep)?;
    }
    Ok(())
}

fn gather(samples: &mut [Vec<f64>], chunk: &[Vec<f64>]) {
    for (channel, new) in samples.iter_mut().zip(chunk) {
        channel.extend(new);
    }
}

/// The same start with what the sensors read at rest.
fn with_rest(mut start: RunStart, at_rest: &SensorCalibration) -> RunStart {
    let at_rest: Vec<String> = start
        .channels
        .iter()
        .zip(at_rest.offset.iter().zip(&at_rest.noise_rms))
        .filter(|(_, (_, noise))| **noise > 0.0)
        .map(|((name, unit), (offset, noise))| format!("{name} {offset:.4} ± {noise:.4} {unit}"))
        .collect();
    if !at_rest.is_empty() {
        let step = format!("sensors at rest: {}", at_rest.join(", "));
        start.provenance.steps.push(step);
    }
    start
}

fn recording_of(start: RunStart, samples: Vec<Vec<f64>>) -> Result<Recording, BenchError> {
    let channels = start
        .channels
        .into_iter()
        .zip(samples)
        .map(|((name, unit), samples)| Channel {
            name,
            unit,
            samples,
        })
        .collect();
    Ok(Recording::new(
        channels,
        start.rate,
        start.condition,
        start.provenance,
    )?)
}

fn acquire_while_playing(
    bench: &mut Bench,
    drive: &Series<Drive>,
    run: &RunPlan,
    keep: Keep<'_>,
) -> Result<(Vec<Vec<f64>>, PlayReport), BenchError> {
    bench.acquirer.ready(run)?;
    bench.player.ready(drive, run)?;
    bench.acquirer.start()?;
    bench.player.start()?;
    let mut samples = vec![Vec::new(); bench.acquirer.describe().channels.len()];
    while let Some(chunk) = bench.acquirer.wait()? {
        keep(&chunk).map_err(BenchError::Keep)?;
        gather(&mut samples, &chunk.channels);
    }
    Ok((samples, bench.player.wait()?))
}

fn force_doubt(recording: &Recording, run: &RunPlan) -> Option<Doubt> {
    let Ok(force) = recording.series::<Force>(Some(FORCE_CHANNEL)) else {
        let load_n = recording.condition.load_n?.0;
        return Some(Doubt::ForceNotMeasured { load_n });
    };
    let target_n = run.load?.0;
    let mean_n = piezotact::statistics::mean(force.samples());
    ((mean_n / target_n - 1.0).abs() > FORCE_TOLERANCE)
        .then_some(Doubt::LoadOffTarget { mean_n, target_n })
}
