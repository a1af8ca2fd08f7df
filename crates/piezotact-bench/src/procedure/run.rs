//! One run on a bench, from its start document to its end document.

use piezotact::Series;
use piezotact::checksum::Checksum;
use piezotact::device::DriveSetup;
use piezotact::number::signed;
use piezotact::quantity::{Band, Drive, Seconds};
use piezotact::recording::{
    About, Annotations, BrokenPlayback, Event, EventValue, LostBy, Provenance, Reached, Recording,
    RecordingWarning,
};
use piezotact::run::{
    Ended, Judged, RunChunk, RunCollector, RunDocument, RunEnd, RunStart, RunWarning, Sink,
};
use piezotact::series::filled;
use piezotact::statistics::mean;
use piezotact::{Warning, criterion::Outcome};

use super::keeper::RunKeeper;
use super::{FORCE_CHANNEL, require_device};
use crate::error::{DeviceError, ProcedureError, Refusal};
use crate::gate::Gate;
use crate::plan::{Playback, RunPlan, Until};
use crate::stop::StopHandle;
use crate::traits::{Acquire, Bench, PlayProgress, SensorCalibration};
use crate::watch::{MOST_LOST, Watch};

/// The tolerance of the mean force re the target, as a share.
const FORCE_TOLERANCE: f64 = 0.1;
/// The longest chunk, s, with a margin for non-integer rates.
const LONGEST_CHUNK_S: f64 = 1.001;
/// The tolerance of the device time re the number of samples since the previous chunk, in s and as a share: time stamps of
/// drivers are rounded; a larger difference means lost or repeated samples that were not reported.
const TIME_OFF: (f64, f64) = (0.005, 0.001);
/// The largest relative difference between the clocks of input and output.
const CLOCKS_APART: f64 = 0.01;
/// The time allowed for playback and the rest after it, beyond the length of the drive, s.
const ENDS_WITHIN_S: f64 = 60.0;

/// The kinds of events of a run: samples that the device lost, with their number; a stop by hand; a gate that refused.
const SAMPLES_LOST: &str = "samples_lost";
const STOPPED: &str = "stopped";
const REFUSED: &str = "refused";

/// The start document of the run `run` on `acquirer`.
#[must_use]
pub fn start_document(acquirer: &dyn Acquire, run: &RunPlan) -> RunStart {
    let description = acquirer.describe();
    let mut steps = vec![run.label.clone()];
    steps.extend(description.steps);
    RunStart {
        label: run.label.clone(),
        rate_hz: description.rate,
        channels: description.channels,
        about: About::new(
            acquirer.condition(run),
            Provenance {
                source: description.name,
                bench: Some(description.kind),
                seed: description.seed,
                steps,
                answered_with: description.answers_with,
                ..Provenance::default()
            },
        ),
        annotations: Annotations::default(),
        clocks: Vec::new(),
        setup: None,
        drive: None,
        expected_s: match run.until {
            Until::Duration(duration) => Some(duration),
            Until::PlaybackEnded | Until::Stopped => None,
        },
    }
}

/// Plays `drive` and records the response; the documents of the run go to `keeper`, and to `gate`, where there is one.
/// `rendered_for` is the device the drive was made for. A run that `keeper` has already is not measured again.
///
/// # Errors
/// Those of [`require_device`]; [`ProcedureError::Refused`] when the gate does not let it pass, [`ProcedureError::Stopped`] when it
/// was stopped by hand, [`ProcedureError::Keep`] when a document cannot be kept; whatever the bench returns. Both halves are
/// stopped in any case, and what was acquired is kept with how it ended.
pub fn play_and_record(
    bench: &mut Bench,
    drive: &Series<Drive>,
    rendered_for: Option<&DriveSetup>,
    run: &RunPlan,
    keeper: &mut dyn RunKeeper,
    gate: Option<&mut Gate>,
) -> Result<Recording, ProcedureError> {
    excite_and_record(bench, (drive, None), rendered_for, run, keeper, gate)
}

/// As [`play_and_record`], of a drive that excites a known band, which the recording states.
pub(super) fn excite_and_record(
    bench: &mut Bench,
    (drive, excited): (&Series<Drive>, Option<Band>),
    rendered_for: Option<&DriveSetup>,
    run: &RunPlan,
    keeper: &mut dyn RunKeeper,
    gate: Option<&mut Gate>,
) -> Result<Recording, ProcedureError> {
    require_device(bench, drive, rendered_for)?;
    let mut start = start_document(bench.acquirer.as_ref(), run);
    start.setup = rendered_for.cloned();
    start.drive = Some(Checksum::of(drive.samples().iter().copied()));
    start.expected_s = start.expected_s.or(Some(drive.duration()));
    start.about.provenance.excited_hz = excited;
    start.annotations.started_at = keeper.now(bench.acquirer.describe().kind);
    if let Some(recording) = keeper.completed(&start).map_err(ProcedureError::Keep)? {
        return Ok(recording);
    }
    let at_rest = bench.acquirer.calibrate()?;
    let mut provenance = with_rest(&start, &at_rest);
    let watch = Watch::new(&bench.stop, bench.acquirer.longest_pause());
    let ready = bench.acquirer.ready(run, &watch.stop).and_then(|()| {
        let playback = Playback::Whole(drive.clone());
        bench.player.ready(playback, run, &watch.stop)
    });
    let sink = ready
        .map_err(ProcedureError::from)
        .and_then(|()| keeper.sink(&start).map_err(ProcedureError::Keep));
    let mut sink = match sink {
        Ok(sink) => sink,
        Err(error) => {
            bench.player.stop();
            bench.acquirer.stop();
            return Err(error);
        }
    };
    let mut gathered = RunCollector::default();
    let mut run_of = Run::new(&start, bench.acquirer.describe().name);
    let force = |(channel, _): &(String, _)| channel == FORCE_CHANNEL;
    run_of.force.1 = start.channels.iter().position(force);
    run_of.drive_s = Some(drive.duration().0);
    if let Some(gate) = gate {
        run_of.sinks.push(gate);
    }
    run_of.sinks.push(sink.as_mut());
    run_of.sinks.push(&mut gathered);
    let mut progress = PlayProgress::default();
    let outcome = run_of.begin(|run_of| {
        if bench.stop.is_stopped() {
            return Ok(());
        }
        bench.acquirer.start()?;
        bench.player.start()?;
        watch.during(|| {
            while !bench.stop.is_stopped() && run_of.goes_on(run.until) {
                let chunk = bench.acquirer.next_chunk()?;
                watch.answers(&run_of.name, run_of.at_s())?;
                let Some(chunk) = chunk else {
                    run_of.over(run.until, &bench.stop)?;
                    let now = bench.player.progress()?;
                    run_of.as_long_as_the_drive(run.until, now, &bench.stop)?;
                    break;
                };
                run_of.take(chunk, run.until, &watch)?;
                let now = bench.player.progress()?;
                if now.ended && !progress.ended {
                    bench.acquirer.playback_ended();
                }
                progress = now;
                run_of.in_time(run.until)?;
            }
            progress = bench.player.progress()?;
            Ok(())
        })
    });
    bench.player.stop();
    bench.acquirer.stop();
    let outcome = run_of.noticed(bench.acquirer.events(), outcome);
    let mut warnings = bench.acquirer.warnings(run);
    warnings.extend(run_of.force_warning(run));
    let (played, expected) = (progress.played as usize, drive.samples().len());
    // If a run ended early for a known cause, that cause is reported.
    let early = outcome.is_err() || bench.stop.is_stopped() || run_of.refused.is_some();
    if played < expected && !early || progress.underruns > 0 {
        let underruns = progress.underruns;
        provenance.losses.playback = Some(BrokenPlayback {
            played,
            expected,
            underruns,
        });
        warnings.push(Warning::from(RecordingWarning::SamplesLost {
            by: LostBy::Playback {
                played,
                expected,
                underruns,
            },
        }));
    }
    run_of.end(outcome, &bench.stop, run, (&mut provenance, warnings))?;
    drop(run_of);
    Ok(gathered.recording()?)
}

/// Acquires a run in which a person touches something and returns all of it.
///
/// # Errors
/// Whatever the bench returns. It is stopped in any case.
pub fn record(acquirer: &mut dyn Acquire, run: &RunPlan) -> Result<Recording, ProcedureError> {
    let mut gathered = RunCollector::default();
    acquire(acquirer, run, &StopHandle::new(), &mut gathered)?;
    Ok(gathered.recording()?)
}

/// Acquires a run in which a person touches something; its documents go to `sink` and no samples are kept in memory, so a run may
/// have any length. Returns its end document with its number of samples.
///
/// # Errors
/// [`DeviceError::Impossible`] for a run until a playback ended, as nothing plays; [`ProcedureError::Keep`] when a document cannot be
/// kept, [`ProcedureError::Stopped`] when a run that has an end of its own was stopped by hand; whatever the bench returns. It is stopped
/// in any case.
pub fn acquire(
    acquirer: &mut dyn Acquire,
    run: &RunPlan,
    stop: &StopHandle,
    sink: &mut dyn Sink,
) -> Result<(RunStart, usize), ProcedureError> {
    if run.until == Until::PlaybackEnded {
        return Err(ProcedureError::Device(DeviceError::Impossible {
            expected:
                "a run of a stated duration, or one until it is stopped, since there is no playback"
                    .into(),
            found: "one until a playback ended".into(),
            todo: "state a duration".into(),
        }));
    }
    let at_rest = acquirer.calibrate()?;
    let watch = Watch::new(stop, acquirer.longest_pause());
    if let Err(refused) = acquirer.ready(run, &watch.stop) {
        acquirer.stop();
        return Err(refused.into());
    }
    let mut start = start_document(acquirer, run);
    let mut provenance = with_rest(&start, &at_rest);
    let mut run_of = Run::new(&start, acquirer.describe().name);
    run_of.sinks.push(sink);
    let outcome = run_of.begin(|run_of| {
        if stop.is_stopped() {
            return Ok(());
        }
        acquirer.start()?;
        watch.during(|| {
            while !stop.is_stopped() && run_of.goes_on(run.until) {
                let chunk = acquirer.next_chunk()?;
                watch.answers(&run_of.name, run_of.at_s())?;
                let Some(chunk) = chunk else {
                    run_of.over(run.until, stop)?;
                    break;
                };
                run_of.take(chunk, run.until, &watch)?;
            }
            Ok(())
        })
    });
    acquirer.stop();
    let outcome = run_of.noticed(acquirer.events(), outcome);
    let warnings = acquirer.warnings(run);
    let samples = run_of.end(outcome, stop, run, (&mut provenance, warnings))?;
    start.about.provenance = provenance;
    Ok((start, samples))
}

/// A run in progress: passes documents to its sinks and checks that the bench keeps its contract.
struct Run<'a> {
    sinks: Vec<&'a mut dyn Sink>,
    start: &'a RunStart,
    /// The acquiring half, for messages.
    name: String,
    /// The number of samples passed to the sinks, including those filled in.
    samples: u64,
    /// The first sample of the last chunk, lost samples counted, and the device's own time of it, s.
    device: Option<(u64, f64)>,
    /// The last sample of each channel; none before the first.
    last: Option<Vec<f64>>,
    /// Samples lost since the last one received.
    pending: u64,
    gaps: Vec<u64>,
    /// Start and end of each gap, s.
    places_s: Vec<[f64; 2]>,
    /// How long the drive is, s; none where nothing plays.
    drive_s: Option<f64>,
    /// The samples of the normal force, and its channel; none where it is not judged.
    force: (Vec<f64>, Option<usize>),
    refused: Option<Judged>,
}

impl<'a> Run<'a> {
    fn new(start: &'a RunStart, name: String) -> Self {
        Self {
            sinks: Vec::new(),
            start,
            name,
            samples: 0,
            device: None,
            last: None,
            pending: 0,
            gaps: Vec::new(),
            places_s: Vec::new(),
            drive_s: None,
            force: (Vec::new(), None),
            refused: None,
        }
    }

    /// Emits the start document, then does what acquires.
    fn begin(
        &mut self,
        acquires: impl FnOnce(&mut Self) -> Result<(), ProcedureError>,
    ) -> Result<(), ProcedureError> {
        self.emit(RunDocument::Start(Box::new(self.start.clone())))?;
        acquires(self)
    }

    /// Passes a document, and the judgements of it, to all sinks, even if one of them fails.
    fn emit(&mut self, document: RunDocument) -> Result<(), ProcedureError> {
        let mut judged = Vec::new();
        let mut failed = None;
        for sink in &mut self.sinks {
            match sink.take(&document) {
                Ok(found) => judged.extend(found),
                Err(error) => failed = failed.or(Some(error)),
            }
        }
        for judged in judged {
            if judged.outcome() == Outcome::NotMet {
                self.refused.get_or_insert_with(|| judged.clone());
            }
            let document = RunDocument::Judged(judged);
            for sink in &mut self.sinks {
                if let Err(error) = sink.take(&document) {
                    failed = failed.or(Some(error));
                }
            }
        }
        failed.map_or(Ok(()), |error| Err(ProcedureError::Keep(error)))
    }

    fn rate_hz(&self) -> f64 {
        self.start.rate_hz.hz()
    }

    fn broken<T>(&self, expected: String, found: String) -> Result<T, DeviceError> {
        Err(DeviceError::Contract {
            name: self.name.clone(),
            expected,
            found,
        })
    }

    /// Records that the device reported the end of the run.
    fn over(&mut self, until: Until, stop: &StopHandle) -> Result<(), ProcedureError> {
        let pending = std::mem::take(&mut self.pending);
        if pending > 0 {
            let held = self.last.clone().unwrap_or_default();
            self.fill(pending, &held, until)?;
        }
        if let Until::Duration(duration) = until
            && self.goes_on(until)
            && !stop.is_stopped()
        {
            let found = self.at_s();
            self.broken(
                format!("samples for {duration:.2}"),
                format!("an end after {found:.2} s"),
            )?;
        }
        Ok(())
    }

    /// Checks that an input that reports the end of the run acquired until the playback ended.
    fn as_long_as_the_drive(
        &self,
        until: Until,
        now: PlayProgress,
        stop: &StopHandle,
    ) -> Result<(), DeviceError> {
        let (Until::PlaybackEnded, Some(drive_s)) = (until, self.drive_s) else {
            return Ok(());
        };
        let announced = (drive_s * self.rate_hz()).floor();
        let enough = self.samples as f64 >= announced * (1.0 - CLOCKS_APART);
        if stop.is_stopped() || enough && now.ended {
            return Ok(());
        }
        self.broken(
            format!("the {announced} samples announced with a drive of {drive_s:.2} s"),
            format!("{} samples delivered", self.samples),
        )
    }

    /// Checks that a run until the end of playback terminates.
    fn in_time(&self, until: Until) -> Result<(), DeviceError> {
        let (Until::PlaybackEnded, Some(drive_s)) = (until, self.drive_s) else {
            return Ok(());
        };
        let acquired_s = self.at_s();
        if acquired_s > drive_s * (1.0 + CLOCKS_APART) + ENDS_WITHIN_S {
            return self.broken(
                format!("an end at most {ENDS_WITHIN_S} s after a drive of {drive_s:.2} s"),
                format!("samples for {acquired_s:.2} s"),
            );
        }
        Ok(())
    }

    /// Whether more is to be acquired.
    fn goes_on(&self, until: Until) -> bool {
        let enough = match until {
            Until::Duration(duration) => {
                self.samples >= self.start.rate_hz.samples_in(duration) as u64
            }
            Until::PlaybackEnded | Until::Stopped => false,
        };
        self.refused.is_none() && !enough
    }

    /// Passes on a chunk that keeps the contract, after samples filled in for lost ones.
    fn take(&mut self, chunk: RunChunk, until: Until, watch: &Watch) -> Result<(), ProcedureError> {
        self.check(&chunk)?;
        self.pending += chunk.lost;
        if chunk.is_empty() {
            return Ok(());
        }
        watch.handle(|| self.hand_on_filled(chunk, until))
    }

    fn hand_on_filled(&mut self, mut chunk: RunChunk, until: Until) -> Result<(), ProcedureError> {
        let lost = std::mem::take(&mut self.pending);
        if lost > 0 {
            let next: Vec<f64> = chunk.channels.iter().map(|channel| channel[0]).collect();
            self.fill(lost, &next, until)?;
        }
        chunk.first = self.samples;
        chunk.lost = 0;
        self.hand_on(chunk, until)
    }

    /// Emits an event at `onset_s`.
    fn happened(
        &mut self,
        onset_s: f64,
        duration_s: f64,
        kind: &str,
        value: Option<EventValue>,
    ) -> Result<(), ProcedureError> {
        self.emit(RunDocument::Event(Event {
            onset_s: Seconds(onset_s),
            duration_s: Seconds(duration_s),
            kind: kind.into(),
            value,
        }))
    }

    /// Emits what the device noticed, after `outcome`.
    fn noticed(
        &mut self,
        events: Vec<Event>,
        outcome: Result<(), ProcedureError>,
    ) -> Result<(), ProcedureError> {
        for event in events {
            let kept = self.emit(RunDocument::Event(event));
            if outcome.is_ok() {
                kept?;
            }
        }
        outcome
    }

    /// Fills in `lost` samples on straight lines from the last sample to `next`, at most a second in a chunk.
    fn fill(&mut self, lost: u64, next: &[f64], until: Until) -> Result<(), ProcedureError> {
        self.gaps.push(lost);
        let gap = [self.samples, self.samples + lost];
        let rate_hz = self.rate_hz();
        self.places_s
            .push(gap.map(|sample| sample as f64 / rate_hz));
        let last = self.last.clone().unwrap_or_else(|| next.to_vec());
        self.happened(
            self.at_s(),
            lost as f64 / self.rate_hz(),
            SAMPLES_LOST,
            Some(EventValue::Number(lost as f64)),
        )?;
        let lines = last.iter().zip(next);
        let mut lines: Vec<_> = lines
            .map(|(last, next)| filled([*last, *next], lost))
            .collect();
        let most = (self.rate_hz() as usize).max(1);
        loop {
            let chunk = RunChunk {
                first: self.samples,
                channels: lines.iter_mut().map(|l| l.take(most).collect()).collect(),
                ..RunChunk::default()
            };
            if chunk.is_empty() {
                return Ok(());
            }
            self.hand_on(chunk, until)?;
        }
    }

    fn hand_on(&mut self, mut chunk: RunChunk, until: Until) -> Result<(), ProcedureError> {
        if let Until::Duration(duration) = until {
            let left =
                (self.start.rate_hz.samples_in(duration) as u64).saturating_sub(self.samples);
            for channel in &mut chunk.channels {
                channel.truncate(left as usize);
            }
        }
        if chunk.is_empty() {
            return Ok(());
        }
        let last = chunk.channels.iter().filter_map(|c| c.last().copied());
        self.last = Some(last.collect());
        if let Some(force) = self.force.1 {
            self.force.0.extend(&chunk.channels[force]);
        }
        self.samples += chunk.len() as u64;
        self.emit(RunDocument::Chunk(chunk))
    }

    fn check(&mut self, chunk: &RunChunk) -> Result<(), DeviceError> {
        let channels = self.start.channels.len();
        let rate_hz = self.rate_hz();
        let found = chunk.channels.len();
        if found != channels && !(found == 0 && chunk.is_empty()) {
            return self.broken(
                format!("{channels} channels in every chunk"),
                found.to_string(),
            );
        }
        if chunk.channels.iter().any(|c| c.len() != chunk.len()) {
            return self.broken(
                "as many samples in each channel of a chunk".into(),
                "lists of different length".into(),
            );
        }
        if chunk.len() as f64 > (LONGEST_CHUNK_S * rate_hz).max(1.0) {
            let length_s = chunk.len() as f64 / rate_hz;
            return self.broken(
                "at most a second of samples in a chunk".into(),
                format!("{} samples, {length_s:.2} s", chunk.len()),
            );
        }
        if !chunk.channels.iter().flatten().all(|v| v.is_finite()) {
            return self.broken(
                "numbers in every channel".into(),
                format!("a sample that is not a number, after {:.2} s", self.at_s()),
            );
        }
        let lost = self.pending + chunk.lost;
        let before = self.drive_s.map_or(0, |_plays| self.gaps.iter().sum());
        let in_all = lost.saturating_add(before);
        if in_all as f64 > MOST_LOST.0 * rate_hz {
            let after_s = Seconds(self.at_s());
            return Err(DeviceError::lost_samples(
                &self.name,
                in_all,
                self.start.rate_hz,
                after_s,
            ));
        }
        if chunk.first != self.samples + lost {
            return self.broken(
                format!(
                    "sample {} next, after {lost} lost ones",
                    self.samples + lost
                ),
                format!("a chunk that begins at sample {}", chunk.first),
            );
        }
        let Some(now_s) = chunk.device_s else {
            return Ok(());
        };
        if let Some((first, before_s)) = self.device {
            let passed_s = (chunk.first - first) as f64 / rate_hz;
            if now_s.is_nan() || now_s < before_s {
                return self.broken(
                    format!("a device time that does not run backwards from {before_s:.6} s"),
                    format!("{now_s:.6} s"),
                );
            }
            let (off_s, share) = TIME_OFF;
            if (now_s - before_s - passed_s).abs() > off_s + share * passed_s {
                return self.broken(
                    format!(
                        "a device time of {:.6} s at sample {}, or lost samples that are reported",
                        before_s + passed_s,
                        chunk.first
                    ),
                    format!("{now_s:.6} s"),
                );
            }
        }
        if !chunk.is_empty() {
            self.device = Some((chunk.first, now_s));
        }
        Ok(())
    }

    /// What was acquired so far, s.
    fn at_s(&self) -> f64 {
        self.samples as f64 / self.rate_hz()
    }

    /// The warning about a mean force that differs from the target.
    fn force_warning(&self, run: &RunPlan) -> Option<Warning> {
        if self.force.1.is_none() {
            let load_n = self.start.about.condition.load_n?.0;
            return Some(Warning::from(RunWarning::ForceNotMeasured { load_n }));
        }
        let target_n = run.load?.0;
        let mean_n = mean(&self.force.0);
        ((mean_n / target_n - 1.0).abs() > FORCE_TOLERANCE).then_some(Warning::from(
            RecordingWarning::ConditionDiffers {
                what: Reached::Load { mean_n, target_n },
            },
        ))
    }

    /// Completes the provenance with what was lost, and emits the end document in any case; returns the number of samples if there was no error.
    fn end(
        &mut self,
        outcome: Result<(), ProcedureError>,
        stop: &StopHandle,
        run: &RunPlan,
        (provenance, mut warnings): (&mut Provenance, Vec<Warning>),
    ) -> Result<usize, ProcedureError> {
        provenance.losses.samples = self.gaps.iter().sum();
        provenance.losses.stretches_s.clone_from(&self.places_s);
        let acquired_s = self.at_s();
        let enough = matches!(run.until, Until::Duration(_)) && !self.goes_on(run.until);
        let ended = match &outcome {
            Err(error) => Ended::Failed {
                said: error.to_string(),
            },
            Ok(()) if self.refused.is_some() => Ended::Refused,
            Ok(()) if stop.is_stopped() && !enough => Ended::Stopped,
            Ok(()) => Ended::Completed,
        };
        warnings.extend(self.gaps.iter().max().map(|longest| {
            RecordingWarning::SamplesLost {
                by: LostBy::Device {
                    gaps: self.gaps.len(),
                    samples: self.gaps.iter().sum(),
                    longest_s: *longest as f64 / self.start.rate_hz.hz(),
                    places_s: self.places_s.clone(),
                },
            }
            .into()
        }));
        let kind = match ended {
            Ended::Stopped => Some(STOPPED),
            Ended::Refused => Some(REFUSED),
            Ended::Completed | Ended::Failed { .. } => None,
        };
        let said = kind.map_or(Ok(()), |kind| self.happened(acquired_s, 0.0, kind, None));
        let kept = self.emit(RunDocument::End(Box::new(RunEnd {
            samples: self.samples,
            ended: ended.clone(),
            provenance: provenance.clone(),
            warnings,
        })));
        outcome?;
        said?;
        kept?;
        match (ended, self.refused.take()) {
            (Ended::Refused, Some(judged)) => Err(ProcedureError::Refused(Refusal(judged))),
            (Ended::Stopped, _) if run.until != Until::Stopped => Err(ProcedureError::Stopped {
                label: run.label.clone(),
                after_s: acquired_s,
            }),
            _ => Ok(self.samples as usize),
        }
    }
}

/// The provenance of a run with the calibration of the sensors at rest.
fn with_rest(start: &RunStart, at_rest: &SensorCalibration) -> Provenance {
    let read: Vec<String> = start
        .channels
        .iter()
        .zip(at_rest.offset.iter().zip(&at_rest.noise_rms))
        .filter(|(_, (_, noise))| **noise > 0.0)
        .map(|((name, unit), (offset, noise))| {
            format!("{name} {} ± {noise:.4} {unit}", signed(*offset, 4))
        })
        .collect();
    match read.is_empty() {
        true => start.about.provenance.clone(),
        false => start
            .about
            .provenance
            .clone()
            .then(format!("sensors at rest: {}", read.join(", "))),
    }
}
