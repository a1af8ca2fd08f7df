//! Rendered stimuli on a bench: a prepared drive is played as the protocol says, and what the finger did is compared with its target.

use std::collections::BTreeMap;
use std::fmt;

use piezotact::criterion::Outcome;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Band, Drive, Newtons, Quantity, Seconds};
use piezotact::recording::Recording;
use piezotact::render::Rendering;
use piezotact::score::{Measurement, Target, judged_measurement};
use piezotact::series::Series;
use piezotact::statistics::{mean, peak};
use piezotact::verify::{Verdict, Verification, VerifyCriterion};
use piezotact_bench::procedure::{
    ACCELERATION_CHANNEL, DRIVE_CHANNEL, FORCE_CHANNEL, RunKeeper, play_and_record,
};
use piezotact_bench::{Bench, Placement, RunPlan, Until};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::Playing;
use piezotact_people::campaign::session::Evidence;

use crate::{PlayError, Played, Stimulator};

/// A drive that is ready to be played, with its target.
#[derive(Clone, Debug)]
pub struct PreparedDrive {
    /// The SHA-256 of its file.
    pub sha: Sha,
    /// The drive, full scale = 1.
    pub drive: Series<Drive>,
    /// The device that it was made for.
    pub setup: Option<DriveSetup>,
    /// How it was made.
    pub rendering: Option<Rendering>,
    /// The recording that holds its target.
    pub target: Recording,
    /// The target, m/s².
    pub texture: Series<Acceleration>,
    /// Whether it passed when it was prepared.
    pub verified: Outcome,
}

/// Where the run of a playing of a drive that was made so is kept, and what its journal is called there.
pub type JournalOf<'a> =
    dyn FnMut(&Played<'_>, Option<&Rendering>) -> (Box<dyn RunKeeper>, Option<String>) + 'a;

/// A bench with the drives of one participant.
pub struct BenchStimulator<'a> {
    /// The bench.
    pub bench: Bench,
    /// The drives, by stimulus.
    pub drives: BTreeMap<String, PreparedDrive>,
    /// How a stimulus is played.
    pub playing: Playing,
    /// The band over which a playing is compared with its target.
    pub band: Band,
    /// How the finger lies.
    pub load: Option<Newtons>,
    /// The angle between finger and surface.
    pub angle: piezotact::quantity::Degrees,
    /// Where the runs are kept.
    pub journal: Box<JournalOf<'a>>,
}

impl fmt::Debug for BenchStimulator<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BenchStimulator")
            .field("bench", &self.bench)
            .field("drives", &self.drives.keys())
            .finish_non_exhaustive()
    }
}

impl Stimulator for BenchStimulator<'_> {
    fn check(&self, stimulus: &str) -> Result<(), PlayError> {
        prepared(&self.drives, stimulus).map(|_there| ())
    }

    fn play(&mut self, played: Played<'_>) -> Result<Evidence, PlayError> {
        let prepared = prepared(&self.drives, played.stimulus)?;
        let (drive, strokes) = in_a_row(&prepared.drive, self.playing)?;
        let run = RunPlan {
            label: label(&played),
            load: self.load,
            angle: self.angle,
            placement: Placement::New,
            until: Until::PlaybackEnded,
        };
        let (mut keeper, journal) = (self.journal)(&played, prepared.rendering.as_ref());
        let setup = prepared.setup.as_ref();
        let recorded = play_and_record(&mut self.bench, &drive, setup, &run, keeper.as_mut(), None);
        let recording = recorded.map_err(|error| PlayError::Device(error.to_string()))?;
        drop(keeper);
        let judged = judged(prepared, &recording, self.playing, self.band);
        Ok(evidence(
            &played,
            prepared,
            &recording,
            judged.as_ref(),
            (strokes, journal),
        ))
    }
}

fn prepared<'a>(
    drives: &'a BTreeMap<String, PreparedDrive>,
    stimulus: &str,
) -> Result<&'a PreparedDrive, PlayError> {
    drives.get(stimulus).ok_or_else(|| PlayError::NoDrive {
        stimulus: stimulus.to_owned(),
    })
}

/// The name of the run of a playing: `triplets.task3.A, attempt 1, element 2, play 1`.
fn label(played: &Played<'_>) -> String {
    format!(
        "{}, attempt {}, element {}, play {}",
        played.trial,
        played.attempt,
        played.element + 1,
        played.play
    )
}

/// `stroke` as often as the protocol has it, with the pauses between, and how often that is.
fn in_a_row(stroke: &Series<Drive>, playing: Playing) -> Result<(Series<Drive>, u32), PlayError> {
    let Playing::Repeated {
        pause_s,
        duration_s,
    } = playing
    else {
        return Ok((stroke.clone(), 1));
    };
    // In whole samples: seconds that fit exactly could be rounded to one stroke less.
    let in_samples = |seconds: f64| (seconds * stroke.rate().hz()).round() as usize;
    let pause = in_samples(pause_s);
    let period = stroke.samples().len() + pause;
    let strokes = ((in_samples(duration_s) + pause) / period.max(1)).max(1);
    let mut samples = stroke.samples().to_vec();
    samples.reserve_exact((strokes - 1) * period);
    for _ in 1..strokes {
        samples.resize(samples.len() + pause, 0.0);
        samples.extend_from_slice(stroke.samples());
    }
    let drive = Series::new(samples, stroke.rate());
    let drive = drive.map_err(|error| PlayError::Device(error.to_string()))?;
    Ok((drive, u32::try_from(strokes).unwrap_or(u32::MAX)))
}

/// The first stroke of `recording` compared with its target; `None` where it cannot be compared.
fn judged(
    prepared: &PreparedDrive,
    recording: &Recording,
    playing: Playing,
    band: Band,
) -> Option<Verification> {
    let response = recording
        .series::<Acceleration>(Some(ACCELERATION_CHANNEL))
        .ok()?;
    let drive = recording.series::<Drive>(Some(DRIVE_CHANNEL)).ok();
    let lead_s = match &drive {
        Some(drive) => begins_s(drive)? - begins_s(&prepared.drive)?,
        None => begins_s(&response)? - begins_s(&prepared.texture)?,
    };
    let end_s = end_of_first_s(lead_s.max(0.0), prepared.drive.duration(), playing);
    let response = until(response, end_s)?;
    let drive = drive.and_then(|drive| until(drive, end_s));
    let limit = prepared.setup.as_ref().map_or(1.0, DriveSetup::drive_limit);
    let target = Target {
        name: "the target",
        recording: &prepared.target,
        texture: &prepared.texture,
    };
    let measurement = Measurement {
        recording,
        response,
        drive: drive.as_ref().map(|drive| (drive, limit)),
        rendering: prepared.rendering.as_ref(),
    };
    let judged = judged_measurement(target, measurement, band, &[]).ok()?;
    Some(judged.verification)
}

/// The part of a pause after a stroke that is compared with it: the response dies away there.
const PART_OF_PAUSE: f64 = 0.8;

/// The share of the peak at which a signal has begun: above the noise of a recorded drive.
const BEGUN_SHARE: f64 = 0.1;

/// When `series` begins, in s; `None` for silence.
fn begins_s<Q: Quantity>(series: &Series<Q>) -> Option<f64> {
    let begun = BEGUN_SHARE * peak(series.samples());
    let first = series.samples().iter().position(|x| x.abs() > begun)?;
    Some(first as f64 / series.rate().hz())
}

/// When the first of the strokes is over in a run in which playing began at `lead_s`; `None` where there is one stroke. Several in a row
/// would fit their target at several delays.
fn end_of_first_s(lead_s: f64, stroke: Seconds, playing: Playing) -> Option<f64> {
    match playing {
        Playing::Once => None,
        Playing::Repeated { pause_s, .. } => Some(lead_s + stroke.0 + PART_OF_PAUSE * pause_s),
    }
}

fn until<Q: Quantity>(series: Series<Q>, end_s: Option<f64>) -> Option<Series<Q>> {
    let Some(end_s) = end_s else {
        return Some(series);
    };
    let rate = series.rate();
    let mut samples = series.into_samples();
    samples.truncate((end_s * rate.hz()).round() as usize);
    Series::new(samples, rate).ok()
}

fn evidence(
    played: &Played<'_>,
    prepared: &PreparedDrive,
    recording: &Recording,
    judged: Option<&Verification>,
    (strokes, journal): (u32, Option<String>),
) -> Evidence {
    let criteria = judged.map(|judged| judged.criteria.iter());
    let named = criteria.into_iter().flatten();
    let named = named.map(|criterion| (name_of(criterion.what), criterion.outcome));
    let force = recording.pick(Some(FORCE_CHANNEL), &piezotact::quantity::Unit::Newton);
    let felt = judged.and_then(|judged| judged.criterion(VerifyCriterion::FeltDifference));
    Evidence {
        stimulus: played.stimulus.to_owned(),
        drive: prepared.sha,
        gain: prepared
            .setup
            .as_ref()
            .map(|setup| setup.gain.name.to_string()),
        verified: prepared.verified,
        reached: judged.map_or(Outcome::NotDecided, |judged| outcome(judged.verdict)),
        criteria: named.collect(),
        score_jnd: felt.and_then(|felt| felt.found),
        level_re_target_db: judged.map(|judged| judged.level_error_db),
        normal_force_n: force.ok().map(|channel| mean(&channel.samples)),
        onset_s: judged.map(|judged| judged.delay_s),
        // The delay is found to a fraction of a sample; half a sample is what it is good for on noisy recordings.
        onset_uncertainty_s: judged.map(|judged| 0.5 / judged.rate_hz),
        strokes,
        journal,
    }
}

/// The outcome of a playing: what passed in part is not decided.
fn outcome(verdict: Verdict) -> Outcome {
    match verdict {
        Verdict::Passed => Outcome::Met,
        Verdict::NotPassed => Outcome::NotMet,
        Verdict::PassedInPart { .. } | Verdict::NotDecided => Outcome::NotDecided,
    }
}

/// The name of a criterion in data: `level`.
fn name_of(criterion: VerifyCriterion) -> String {
    match serde_json::to_value(criterion) {
        Ok(serde_json::Value::String(name)) => name,
        _ => format!("{criterion:?}"),
    }
}
