//! One run on a bench, from its start document to its end document.

use piezotact::Series;
use piezotact::checksum::Checksum;
use piezotact::device::DriveSetup;
use piezotact::quantity::Drive;
use piezotact::recording::{Provenance, Recording};
use piezotact::run::{
    Discard, Ended, Gathered, Judged, RunChunk, RunDocument, RunDoubt, RunEnd, RunStart, Sink,
    SinkError,
};
use piezotact::statistics::mean;
use piezotact::{Doubt, criterion::Outcome};

use super::{FORCE_CHANNEL, require_device};
use crate::error::{DeviceError, ProcedureError};
use crate::gate::{Gate, Refusal};
use crate::plan::{Playback, RunPlan, Until};
use crate::stop::StopHandle;
use crate::traits::{Acquire, Bench, PlayProgress, SensorCalibration};

/// The mean force may depart by this share from what was asked for.
const FORCE_TOLERANCE: f64 = 0.1;
/// A chunk is at most this long, s, with a little room for rates that are no whole numbers.
const LONGEST_CHUNK_S: f64 = 1.001;
/// More lost samples in a row than this are no gap, but a device that is gone, s.
const LONGEST_GAP_S: f64 = 60.0;

/// Where the runs of a procedure are kept.
pub trait RunKeeper {
    /// The recording of a run with this start that was completed before, by a procedure that was interrupted: it is used in
    /// place of another measurement.
    ///
    /// # Errors
    /// Whatever keeps it from looking.
    fn completed(&mut self, _start: &RunStart) -> Result<Option<Recording>, SinkError> {
        Ok(None)
    }
    /// What takes the documents of the run that begins with `start`.
    ///
    /// # Errors
    /// Whatever keeps it from beginning.
    fn sink(&mut self, start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError>;
}

/// Keeps nothing.
impl RunKeeper for Discard {
    fn sink(&mut self, _start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        Ok(Box::new(Self))
    }
}

/// What is known of the run `run` on `acquirer` before its first sample.
#[must_use]
pub fn announce(acquirer: &dyn Acquire, run: &RunPlan) -> RunStart {
    let description = acquirer.describe();
    let mut steps = vec![run.label.clone()];
    steps.extend(description.steps);
    RunStart {
        label: run.label.clone(),
        rate_hz: description.rate,
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
        setup: None,
        drive: None,
    }
}

/// Plays `drive` and acquires what comes of it; the documents of the run go to `keeper`, and to `gate`, where there is one.
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
    require_device(bench, drive, rendered_for)?;
    let start = RunStart {
        setup: rendered_for.cloned(),
        drive: Some(Checksum::of(drive.samples().iter().copied())),
        ..announce(bench.acquirer.as_ref(), run)
    };
    if let Some(recording) = keeper.completed(&start).map_err(ProcedureError::Keep)? {
        return Ok(recording);
    }
    let at_rest = bench.acquirer.calibrate()?;
    bench.acquirer.ready(run, &bench.stop)?;
    let playback = Playback::Whole(drive.clone());
    bench.player.ready(playback, run, &bench.stop)?;
    let provenance = with_rest(&start, &at_rest);
    let mut sink = keeper.sink(&start).map_err(ProcedureError::Keep)?;
    let mut gathered = Gathered::default();
    let mut run_of = Run::new(&start, bench.acquirer.describe().name);
    if let Some(gate) = gate {
        run_of.sinks.push(gate);
    }
    run_of.sinks.push(sink.as_mut());
    run_of.sinks.push(&mut gathered);
    run_of.emit(RunDocument::Start(start.clone()))?;
    let mut progress = PlayProgress::default();
    let outcome = (|| {
        bench.acquirer.start()?;
        bench.player.start()?;
        while !bench.stop.is_stopped() && run_of.goes_on(run.until) {
            let Some(chunk) = bench.acquirer.next_chunk()? else {
                break;
            };
            run_of.take(chunk, run.until)?;
            let now = bench.player.progress()?;
            if now.ended && !progress.ended {
                bench.acquirer.playback_ended();
            }
            progress = now;
        }
        progress = bench.player.progress()?;
        Ok(())
    })();
    bench.player.stop();
    bench.acquirer.stop();
    let mut doubts = bench.acquirer.doubts(run);
    doubts.extend(run_of.force_doubt(run));
    let (played, expected) = (progress.played as usize, drive.samples().len());
    if played < expected || progress.underruns > 0 {
        doubts.push(Doubt::from(RunDoubt::PlaybackIncomplete {
            played,
            expected,
            underruns: progress.underruns,
        }));
    }
    run_of.end(outcome, &bench.stop, run, (provenance, doubts))?;
    drop(run_of);
    Ok(gathered.recording()?)
}

/// Acquires a run in which a person touches something and returns all of it.
///
/// # Errors
/// Whatever the bench returns. It is stopped in any case.
pub fn record(acquirer: &mut dyn Acquire, run: &RunPlan) -> Result<Recording, ProcedureError> {
    let mut gathered = Gathered::default();
    acquire(acquirer, run, &StopHandle::new(), &mut gathered)?;
    Ok(gathered.recording()?)
}

/// Acquires a run in which a person touches something; its documents go to `sink`, and nothing is held on to, so that a run of
/// any length fits. Returns what is known of it at its end, and its number of samples.
///
/// # Errors
/// [`ProcedureError::Keep`] when a document cannot be kept, [`ProcedureError::Stopped`] when a run that has an end of its own was
/// stopped by hand; whatever the bench returns. It is stopped in any case.
pub fn acquire(
    acquirer: &mut dyn Acquire,
    run: &RunPlan,
    stop: &StopHandle,
    sink: &mut dyn Sink,
) -> Result<(RunStart, usize), ProcedureError> {
    let at_rest = acquirer.calibrate()?;
    acquirer.ready(run, stop)?;
    let mut start = announce(acquirer, run);
    let provenance = with_rest(&start, &at_rest);
    let mut run_of = Run::new(&start, acquirer.describe().name);
    run_of.sinks.push(sink);
    run_of.emit(RunDocument::Start(start.clone()))?;
    let outcome = (|| {
        acquirer.start()?;
        while !stop.is_stopped() && run_of.goes_on(run.until) {
            let Some(chunk) = acquirer.next_chunk()? else {
                break;
            };
            run_of.take(chunk, run.until)?;
        }
        Ok(())
    })();
    acquirer.stop();
    let doubts = acquirer.doubts(run);
    let samples = run_of.end(outcome, stop, run, (provenance.clone(), doubts))?;
    start.provenance = provenance;
    Ok((start, samples))
}

/// A run under way: what it hands to its sinks, and what it checks of the bench.
struct Run<'a> {
    sinks: Vec<&'a mut dyn Sink>,
    start: &'a RunStart,
    /// The acquiring half, for messages.
    name: String,
    /// Samples that were handed out, with those filled in.
    samples: u64,
    /// The device's own time of the last chunk, s.
    device_s: Option<f64>,
    /// The last sample of each channel.
    last: Vec<f64>,
    gaps: Vec<u64>,
    /// Sum and number of the samples of the normal force.
    force: (Vec<f64>, Option<usize>),
    refused: Option<Judged>,
}

impl<'a> Run<'a> {
    fn new(start: &'a RunStart, name: String) -> Self {
        let force = start
            .channels
            .iter()
            .position(|(channel, _)| channel == FORCE_CHANNEL);
        Self {
            sinks: Vec::new(),
            start,
            name,
            samples: 0,
            device_s: None,
            last: vec![0.0; start.channels.len()],
            gaps: Vec::new(),
            force: (Vec::new(), force),
            refused: None,
        }
    }

    fn emit(&mut self, document: RunDocument) -> Result<(), ProcedureError> {
        let mut judged = Vec::new();
        for sink in &mut self.sinks {
            judged.extend(sink.take(&document).map_err(ProcedureError::Keep)?);
        }
        for judged in judged {
            if judged.outcome() == Outcome::NotMet {
                self.refused.get_or_insert_with(|| judged.clone());
            }
            let document = RunDocument::Judged(judged);
            for sink in &mut self.sinks {
                sink.take(&document).map_err(ProcedureError::Keep)?;
            }
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

    /// Hands on a chunk that keeps to the contract, with what is filled in for lost samples before it.
    fn take(&mut self, mut chunk: RunChunk, until: Until) -> Result<(), ProcedureError> {
        self.check(&chunk)?;
        if chunk.lost > 0 && !chunk.is_empty() {
            self.gaps.push(chunk.lost);
            let steps = (chunk.lost + 1) as f64;
            let filled = self.last.iter().zip(&chunk.channels).map(|(last, next)| {
                (1..=chunk.lost)
                    .map(|k| last + (next[0] - last) * k as f64 / steps)
                    .collect()
            });
            let filled = RunChunk {
                first: self.samples,
                device_s: None,
                lost: 0,
                channels: filled.collect(),
            };
            self.hand_on(filled, until)?;
        }
        chunk.first = self.samples;
        self.hand_on(chunk, until)
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
        for (last, channel) in self.last.iter_mut().zip(&chunk.channels) {
            *last = channel.last().copied().unwrap_or(*last);
        }
        if let Some(force) = self.force.1 {
            self.force.0.extend(&chunk.channels[force]);
        }
        self.samples += chunk.len() as u64;
        self.emit(RunDocument::Chunk(chunk))
    }

    fn check(&mut self, chunk: &RunChunk) -> Result<(), DeviceError> {
        let broken = |expected: String, found: String| {
            Err(DeviceError::Contract {
                name: self.name.clone(),
                expected,
                found,
            })
        };
        let channels = self.start.channels.len();
        let rate_hz = self.start.rate_hz.hz();
        if chunk.channels.len() != channels {
            return broken(
                format!("{channels} channels in every chunk"),
                chunk.channels.len().to_string(),
            );
        }
        if chunk.channels.iter().any(|c| c.len() != chunk.len()) {
            return broken(
                "as many samples in each channel of a chunk".into(),
                "lists of different length".into(),
            );
        }
        if chunk.len() as f64 > (LONGEST_CHUNK_S * rate_hz).max(1.0) {
            return broken(
                "at most a second of samples in a chunk".into(),
                format!(
                    "{} samples, {:.2} s",
                    chunk.len(),
                    chunk.len() as f64 / rate_hz
                ),
            );
        }
        if chunk.first != self.samples + chunk.lost {
            return broken(
                format!(
                    "sample {} next, after {} lost ones",
                    self.samples + chunk.lost,
                    chunk.lost
                ),
                format!("a chunk that begins with sample {}", chunk.first),
            );
        }
        if chunk.lost as f64 > LONGEST_GAP_S * rate_hz {
            return Err(DeviceError::Lost {
                name: self.name.clone(),
                after_s: self.samples as f64 / rate_hz,
            });
        }
        if let (Some(before), Some(now)) = (self.device_s, chunk.device_s)
            && (now.is_nan() || now < before)
        {
            return broken(
                format!("a device time that does not run backwards from {before:.6} s"),
                format!("{now:.6} s"),
            );
        }
        self.device_s = chunk.device_s.or(self.device_s);
        Ok(())
    }

    /// The mean force against what was asked for.
    fn force_doubt(&self, run: &RunPlan) -> Option<Doubt> {
        if self.force.1.is_none() {
            let load_n = self.start.condition.load_n?.0;
            return Some(Doubt::from(RunDoubt::ForceNotMeasured { load_n }));
        }
        let target_n = run.load?.0;
        let mean_n = mean(&self.force.0);
        ((mean_n / target_n - 1.0).abs() > FORCE_TOLERANCE)
            .then_some(Doubt::from(RunDoubt::LoadOffTarget { mean_n, target_n }))
    }

    /// Emits the end document, whatever came before it; the number of samples where all is well.
    fn end(
        &mut self,
        outcome: Result<(), ProcedureError>,
        stop: &StopHandle,
        run: &RunPlan,
        (provenance, mut doubts): (Provenance, Vec<Doubt>),
    ) -> Result<usize, ProcedureError> {
        let acquired_s = self.samples as f64 / self.start.rate_hz.hz();
        let ended = match &outcome {
            Err(error) => Ended::Failed {
                said: error.to_string(),
            },
            Ok(()) if self.refused.is_some() => Ended::Refused,
            Ok(()) if stop.is_stopped() && run.until != Until::Stopped => Ended::Stopped,
            Ok(()) => Ended::Completed,
        };
        doubts.extend(self.gaps.iter().max().map(|longest| {
            RunDoubt::SamplesLost {
                gaps: self.gaps.len(),
                samples: self.gaps.iter().sum(),
                longest_s: *longest as f64 / self.start.rate_hz.hz(),
            }
            .into()
        }));
        if ended != Ended::Completed {
            doubts.push(
                RunDoubt::EndedEarly {
                    ended: ended.clone(),
                    after_s: acquired_s,
                }
                .into(),
            );
        }
        let kept = self.emit(RunDocument::End(RunEnd {
            samples: self.samples,
            ended: ended.clone(),
            provenance,
            doubts,
        }));
        outcome?;
        kept?;
        match (ended, self.refused.take()) {
            (Ended::Refused, Some(judged)) => Err(ProcedureError::Refused(Refusal(judged))),
            (Ended::Stopped, _) => Err(ProcedureError::Stopped {
                label: run.label.clone(),
                after_s: acquired_s,
            }),
            _ => Ok(self.samples as usize),
        }
    }
}

/// The provenance of a run with what the sensors read at rest.
fn with_rest(start: &RunStart, at_rest: &SensorCalibration) -> Provenance {
    let read: Vec<String> = start
        .channels
        .iter()
        .zip(at_rest.offset.iter().zip(&at_rest.noise_rms))
        .filter(|(_, (_, noise))| **noise > 0.0)
        .map(|((name, unit), (offset, noise))| format!("{name} {offset:.4} ± {noise:.4} {unit}"))
        .collect();
    match read.is_empty() {
        true => start.provenance.clone(),
        false => start
            .provenance
            .clone()
            .then(format!("sensors at rest: {}", read.join(", "))),
    }
}
