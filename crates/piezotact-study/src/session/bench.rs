//! Rendered stimuli on a bench: a prepared drive is played as the protocol says, and what the finger did is compared with its target.

use crate::session::RunError;
use std::collections::BTreeMap;
use std::fmt;

use piezotact::criterion::Outcome;
use piezotact::device::DriveSetup;
use piezotact::number::counted;
use piezotact::quantity::{Acceleration, Band, Drive, Newtons, Quantity};
use piezotact::recording::{BrokenPlayback, Recording};
use piezotact::render::Rendering;
use piezotact::score::{Measurement, Target, judged_measurement};
use piezotact::series::Series;
use piezotact::statistics::{mean, peak};
use piezotact::verify::{Verdict, Verification, VerifyCriterion};
use piezotact_bench::procedure::{
    ACCELERATION_CHANNEL, DRIVE_CHANNEL, FORCE_CHANNEL, RunKeeper, play_and_record,
};
use piezotact_bench::{Bench, Placement, RunPlan, StopHandle, Until};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::{AROUND_S, Playing};
use piezotact_people::campaign::session::{Evidence, sha_of_samples};

use crate::session::{Played, Stimulator};

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
    fn check(&self, stimulus: &str) -> Result<(), RunError> {
        let drive = &prepared(&self.drives, stimulus)?.drive;
        let found_s = drive.duration().0;
        match self.playing.longest_s() {
            Some(longest_s) if found_s > longest_s => Err(RunError::TooLong {
                stimulus: stimulus.to_owned(),
                found_s,
                longest_s: longest_s - AROUND_S,
            }),
            _ => Ok(()),
        }
    }

    fn play(&mut self, played: Played<'_>, stop: &StopHandle) -> Result<Evidence, RunError> {
        let played = self.play_recorded(played, stop);
        played.map(|(evidence, _)| evidence)
    }
}

impl BenchStimulator<'_> {
    /// Plays `played` as the protocol says, and gives what was recorded beside what is known of it: for whoever feels it on a
    /// simulated finger. `stop` ends it at any time.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn play_recorded(
        &mut self,
        played: Played<'_>,
        stop: &StopHandle,
    ) -> Result<(Evidence, Recording), RunError> {
        let prepared = prepared(&self.drives, played.stimulus)?;
        let (drive, row) = in_a_row(prepared, self.playing)?;
        let run = RunPlan {
            label: label(&played),
            load: self.load,
            angle: self.angle,
            placement: Placement::New,
            until: Until::PlaybackEnded,
        };
        let (mut keeper, journal) = (self.journal)(&played, prepared.rendering.as_ref());
        let setup = prepared.setup.as_ref();
        // A stop is final: each playing has its own.
        self.bench.stop = stop.clone();
        let recorded = play_and_record(&mut self.bench, &drive, setup, &run, keeper.as_mut(), None);
        let recording = recorded.map_err(|error| RunError::Device(error.to_string()))?;
        drop(keeper);
        whole(&recording)?;
        let judged = judged(prepared, &recording, row, self.band);
        let evidence = evidence(
            &played,
            prepared,
            &recording,
            &judged,
            (row.strokes, journal),
        );
        Ok((evidence, recording))
    }
}

/// Refuses a playing of which samples were not played in time, as the participant felt something else, and one of which samples were not
/// recorded, as what was felt is not known. What was recorded is kept.
fn whole(recording: &Recording) -> Result<(), RunError> {
    let losses = &recording.about.provenance.losses;
    let why = if let Some(BrokenPlayback {
        played,
        expected,
        underruns,
    }) = losses.playback
    {
        format!(
            "the playback was interrupted: {played} of {expected} samples were played, and the output was interrupted {}; close other programs",
            counted(underruns, "time")
        )
    } else if losses.samples > 0 {
        format!(
            "{} of each channel were lost while it was recorded; close other programs",
            counted(losses.samples as usize, "sample")
        )
    } else {
        return Ok(());
    };
    Err(RunError::Device(why))
}

fn prepared<'a>(
    drives: &'a BTreeMap<String, PreparedDrive>,
    stimulus: &str,
) -> Result<&'a PreparedDrive, RunError> {
    drives.get(stimulus).ok_or_else(|| RunError::NoDrive {
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

/// Strokes in a row.
#[derive(Clone, Copy, Debug)]
struct Row {
    strokes: u32,
    /// From the beginning of one to that of the next, s.
    period_s: f64,
    /// The silence between two drives, s.
    pause_s: f64,
}

/// The stroke of `prepared` as often as the protocol has it, with the pauses between. The pause is from the end of one texture to the
/// beginning of the next: what a drive has before and after its texture is part of it.
fn in_a_row(prepared: &PreparedDrive, playing: Playing) -> Result<(Series<Drive>, Row), RunError> {
    let stroke = &prepared.drive;
    let Playing::Repeated {
        pause_s,
        duration_s,
    } = playing
    else {
        let period_s = stroke.duration().0;
        let row = Row {
            strokes: 1,
            period_s,
            pause_s: 0.0,
        };
        return Ok((stroke.clone(), row));
    };
    // In whole samples: seconds that fit exactly could be rounded to one stroke less.
    let rate_hz = stroke.rate().hz();
    let in_samples = |seconds: f64| (seconds * rate_hz).round() as usize;
    let around = stroke
        .samples()
        .len()
        .saturating_sub(in_samples(prepared.texture.duration().0));
    let pause = in_samples(pause_s).saturating_sub(around);
    let period = (stroke.samples().len() + pause).max(1);
    // The last one needs no pause after it.
    let strokes = ((in_samples(duration_s) + pause + around) / period).max(1);
    let mut samples = stroke.samples().to_vec();
    samples.reserve_exact((strokes - 1) * period);
    for _ in 1..strokes {
        samples.resize(samples.len() + pause, 0.0);
        samples.extend_from_slice(stroke.samples());
    }
    let drive = Series::new(samples, stroke.rate());
    let drive = drive.map_err(|error| RunError::Device(error.to_string()))?;
    let row = Row {
        strokes: u32::try_from(strokes).unwrap_or(u32::MAX),
        period_s: period as f64 / rate_hz,
        pause_s: pause as f64 / rate_hz,
    };
    Ok((drive, row))
}

/// Each stroke of `recording` compared with its target; without those that cannot be compared.
fn judged(
    prepared: &PreparedDrive,
    recording: &Recording,
    row: Row,
    band: Band,
) -> Vec<Verification> {
    let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL));
    let Ok(response) = response else {
        return Vec::new();
    };
    let drive = recording.series::<Drive>(Some(DRIVE_CHANNEL)).ok();
    let lead_s = match &drive {
        Some(drive) => begins_s(drive).zip(begins_s(&prepared.drive)),
        None => begins_s(&response).zip(begins_s(&prepared.texture)),
    };
    let Some((begins, own)) = lead_s else {
        return Vec::new();
    };
    let lead_s = (begins - own).max(0.0);
    let one = |number: u32| {
        let from_s = lead_s + f64::from(number) * row.period_s;
        let to_s = from_s + prepared.drive.duration().0 + PART_OF_PAUSE * row.pause_s;
        // What is before the first stroke and after the only one says how the sensor is at rest.
        let from_s = if number == 0 { 0.0 } else { from_s };
        let to_s = if row.strokes == 1 {
            f64::INFINITY
        } else {
            to_s
        };
        compared(
            prepared,
            recording,
            (
                part(&response, from_s, to_s)?,
                drive.as_ref().and_then(|drive| part(drive, from_s, to_s)),
            ),
            band,
        )
    };
    (0..row.strokes).filter_map(one).collect()
}

/// One stroke compared with its target.
fn compared(
    prepared: &PreparedDrive,
    recording: &Recording,
    (response, drive): (Series<Acceleration>, Option<Series<Drive>>),
    band: Band,
) -> Option<Verification> {
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

/// The part of the silence after a stroke that is compared with it: the response dies away there.
const PART_OF_PAUSE: f64 = 0.8;

/// The share of the peak at which a signal has begun: above the noise of a recorded drive.
const BEGUN_SHARE: f64 = 0.1;

/// When `series` begins, in s; `None` for silence.
fn begins_s<Q: Quantity>(series: &Series<Q>) -> Option<f64> {
    let begun = BEGUN_SHARE * peak(series.samples());
    let first = series.samples().iter().position(|x| x.abs() > begun)?;
    Some(first as f64 / series.rate().hz())
}

/// The samples of `series` from one time to another, in s.
fn part<Q: Quantity>(series: &Series<Q>, from_s: f64, to_s: f64) -> Option<Series<Q>> {
    let rate_hz = series.rate().hz();
    let length = series.samples().len();
    let at = |seconds: f64| ((seconds * rate_hz).round() as usize).min(length);
    let (from, to) = (at(from_s), at(to_s));
    Series::new(series.samples().get(from..to)?.to_vec(), series.rate()).ok()
}

fn evidence(
    played: &Played<'_>,
    prepared: &PreparedDrive,
    recording: &Recording,
    judged: &[Verification],
    (strokes, journal): (u32, Option<String>),
) -> Evidence {
    let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL));
    let force = recording.pick(Some(FORCE_CHANNEL), &piezotact::quantity::Unit::Newton);
    let felt = judged.iter().filter_map(|one| {
        let felt = one.criterion(VerifyCriterion::FeltDifference)?;
        felt.found
    });
    let levels: Vec<f64> = judged.iter().map(|one| one.level_error_db).collect();
    let felt: Vec<f64> = felt.collect();
    let mean_of = |values: &[f64]| (!values.is_empty()).then(|| mean(values));
    let first = judged.first();
    let criteria = criteria(judged, strokes);
    Evidence {
        stimulus: played.stimulus.to_owned(),
        drive: prepared.sha,
        gain: prepared
            .setup
            .as_ref()
            .map(|setup| setup.gain.name.to_string()),
        verified: prepared.verified,
        reached: reached(judged, &criteria, strokes),
        criteria,
        score_jnd: mean_of(&felt),
        level_re_target_db: mean_of(&levels),
        rendered_at_db: prepared.rendering.as_ref().map(|made| made.level_db),
        normal_force_n: force.ok().map(|channel| mean(&channel.samples)),
        onset_s: first.map(|judged| judged.delay_s),
        // The delay is found to a fraction of a sample; half a sample is what it is good for on noisy recordings.
        onset_uncertainty_s: first.map(|judged| 0.5 / judged.rate_hz),
        strokes,
        bench: recording.about.provenance.bench,
        recorded: response
            .ok()
            .map(|response| sha_of_samples(response.samples())),
        journal,
    }
}

/// The criteria of a playing, by name.
fn criteria(judged: &[Verification], strokes: u32) -> BTreeMap<String, Outcome> {
    let names = judged.iter().flat_map(|one| &one.criteria);
    let names = names.map(|one| one.what);
    let each = names.map(|what| {
        let of_each = judged.iter().filter_map(|one| one.criterion(what));
        let mut outcomes = of_each.map(|criterion| criterion.outcome);
        let outcome = match BREAKS.contains(&what) {
            true if outcomes.any(|one| one == Outcome::NotMet) => Outcome::NotMet,
            true => Outcome::Met,
            false => most(outcomes, strokes),
        };
        (name_of(what), outcome)
    });
    each.collect()
}

/// What breaks a playing where it happens in one of its strokes.
const BREAKS: [VerifyCriterion; 2] = [VerifyCriterion::DropOut, VerifyCriterion::Clipped];

/// Whether a playing reached its target: not where one of its strokes is broken; else what is so of more than half of them.
fn reached(judged: &[Verification], criteria: &BTreeMap<String, Outcome>, strokes: u32) -> Outcome {
    let is_broken = BREAKS
        .iter()
        .any(|what| criteria.get(&name_of(*what)) == Some(&Outcome::NotMet));
    match is_broken {
        true => Outcome::NotMet,
        false => most(judged.iter().map(|one| outcome(one.verdict)), strokes),
    }
}

/// What is so of more than half of the strokes; not decided where neither is.
fn most(outcomes: impl Iterator<Item = Outcome>, strokes: u32) -> Outcome {
    let (mut met, mut not_met) = (0, 0);
    for outcome in outcomes {
        match outcome {
            Outcome::Met => met += 2,
            Outcome::NotMet => not_met += 2,
            Outcome::NotDecided => {}
        }
    }
    match (met > strokes, not_met > strokes) {
        (true, _) => Outcome::Met,
        (_, true) => Outcome::NotMet,
        _ => Outcome::NotDecided,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_playing_is_what_more_than_half_of_its_strokes_are() {
        use Outcome::{Met, NotDecided, NotMet};
        let of = |outcomes: &[Outcome], strokes| most(outcomes.iter().copied(), strokes);
        assert_eq!(of(&[Met, Met, NotMet], 3), Met);
        assert_eq!(of(&[NotMet, NotMet, Met], 3), NotMet);
        assert_eq!(of(&[Met, NotMet], 2), NotDecided);
        assert_eq!(of(&[Met, NotDecided, NotMet], 3), NotDecided);
        // Strokes that could not be compared say nothing.
        assert_eq!(of(&[Met], 3), NotDecided);
        assert_eq!(of(&[], 1), NotDecided);
    }
}
