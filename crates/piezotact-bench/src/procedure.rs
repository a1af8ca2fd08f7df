//! What is done with a bench, whichever it is: play a drive and keep what comes back, characterise a device.

use piezotact::Doubt;
use piezotact::Series;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Drive, Force, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording, Touch};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Estimator, TransferFunction, estimate};

use crate::excitation::{ExcitationConfig, random_excitation};
use crate::traits::{Bench, BenchError, Chunk, RunPlan};

/// The channels that every bench of this kind has.
pub const DRIVE_CHANNEL: &str = "drive";
/// The acceleration of the fingernail.
pub const ACCELERATION_CHANNEL: &str = "acceleration";
/// The normal force of the finger.
pub const FORCE_CHANNEL: &str = "normal_force";
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

/// What is known of the run `run` on `bench` before its first sample.
#[must_use]
pub fn announce(bench: &Bench, run: &RunPlan) -> RunStart {
    let description = bench.acquirer.describe();
    RunStart {
        rate: description.rate,
        channels: description.channels,
        condition: Condition {
            participant: description.participant,
            load_n: Some(run.load),
            angle_deg: Some(run.angle),
            touch: Some(Touch::Resting),
            ..Condition::default()
        },
        provenance: Provenance {
            source: description.name,
            bench: Some(description.kind),
            seed: description.seed,
            steps: vec![run.label.clone()],
        },
    }
}

/// What keeps chunks as they come: a journal, a progress bar.
pub type Keep<'a> =
    &'a mut dyn FnMut(&Chunk) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;

/// Plays `drive` and acquires what comes of it, handing every chunk to `keep` as it comes and returning all
/// of it. `rendered_for` is the device the drive was made for.
///
/// # Errors
/// [`BenchError::Gain`] when the amplifier is set otherwise than the drive needs; [`BenchError::Keep`] when a
/// chunk cannot be kept; whatever the bench returns. Both halves are stopped in any case.
pub fn play_and_record(
    bench: &mut Bench,
    drive: &Series<Drive>,
    rendered_for: Option<&DriveSetup>,
    run: &RunPlan,
    keep: Keep<'_>,
) -> Result<Recording, BenchError> {
    let description = bench.player.describe();
    if let Some(setup) = rendered_for
        && setup.gain != description.gain
    {
        return Err(BenchError::Gain {
            drive: setup.gain,
            bench: description.gain,
            name: description.name,
        });
    }
    let outcome = acquire_while_playing(bench, drive, run, keep);
    bench.player.stop();
    bench.acquirer.stop();
    let start = announce(bench, run);
    let channels = start
        .channels
        .into_iter()
        .zip(outcome?)
        .map(|((name, unit), samples)| Channel {
            name,
            unit,
            samples,
        })
        .collect();
    let mut recording = Recording::new(channels, start.rate, start.condition, start.provenance)?;
    recording.doubts.extend(force_doubt(&recording, run));
    Ok(recording)
}

fn acquire_while_playing(
    bench: &mut Bench,
    drive: &Series<Drive>,
    run: &RunPlan,
    keep: Keep<'_>,
) -> Result<Vec<Vec<f64>>, BenchError> {
    bench.acquirer.ready(run)?;
    bench.player.ready(drive, run)?;
    bench.acquirer.start()?;
    bench.player.start()?;
    let mut samples = vec![Vec::new(); bench.acquirer.describe().channels.len()];
    while let Some(chunk) = bench.acquirer.wait()? {
        keep(&chunk).map_err(BenchError::Keep)?;
        for (channel, new) in samples.iter_mut().zip(chunk.channels) {
            channel.extend(new);
        }
    }
    bench.player.wait()?;
    Ok(samples)
}

fn force_doubt(recording: &Recording, run: &RunPlan) -> Option<Doubt> {
    let force = recording.series::<Force>(Some(FORCE_CHANNEL)).ok()?;
    let mean_n = force.samples().iter().sum::<f64>() / force.samples().len() as f64;
    ((mean_n / run.load.0 - 1.0).abs() > FORCE_TOLERANCE).then_some(Doubt::LoadOffTarget {
        mean_n,
        target_n: run.load.0,
    })
}

/// How a device is characterised.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacteriseConfig {
    /// The drive, its peak relative to what the device can play.
    pub excitation: ExcitationConfig,
    /// How the spectra are estimated.
    pub welch: WelchConfig,
    /// Which ratio estimates the transfer function.
    pub estimator: Estimator,
    /// Who touches how.
    pub run: RunPlan,
}

/// A device with a finger on it, characterised.
#[derive(Clone, Debug)]
pub struct Characterisation {
    /// What was recorded.
    pub recording: Recording,
    /// From the digital drive to the nail's acceleration.
    pub function: TransferFunction<Drive, Acceleration>,
}

/// Sends a random drive to the device and estimates the transfer function from the drive to the nail's
/// acceleration, with the gain, the level and the condition that it holds for.
///
/// Source: thesis 2.5.3.
///
/// # Errors
/// Those of [`random_excitation`] and [`play_and_record`]; [`BenchError::Transfer`] when nothing comes through.
pub fn characterise(
    bench: &mut Bench,
    config: &CharacteriseConfig,
    keep: Keep<'_>,
) -> Result<Characterisation, BenchError> {
    let setup = bench.player.calibrate()?;
    let excitation = ExcitationConfig {
        peak: config.excitation.peak * setup.drive_limit(),
        ..config.excitation.clone()
    };
    let drive = random_excitation(&excitation, bench.player.describe().rate)?;
    let recording = play_and_record(bench, &drive, Some(&setup), &config.run, keep)?;
    let mut function = estimate(
        &recording.series::<Drive>(Some(DRIVE_CHANNEL))?,
        &recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL))?,
        &config.welch,
        config.estimator,
    )?;
    let estimated = std::mem::take(&mut function.provenance.steps);
    function.provenance = recording.provenance.clone().then(format!(
        "random drive over {}, {}, peak {:.3} of full scale, seed {}",
        excitation.band, excitation.duration, excitation.peak, excitation.seed
    ));
    function.provenance.steps.extend(estimated);
    function.condition = recording.condition.clone();
    function.drive = Some(setup);
    function.doubts.extend(recording.doubts.clone());
    Ok(Characterisation {
        recording,
        function,
    })
}
