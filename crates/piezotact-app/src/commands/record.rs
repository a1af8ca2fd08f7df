//! `piezotact record`: what the sensors of a bench acquire while a person touches something; nothing is played.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use indicatif::ProgressBar;
use piezotact::Warning;
use piezotact::quantity::{Degrees, Drive, Newtons, Quantity as _, Seconds};
use piezotact::recording::{
    Condition, Reached, RecordingWarning, ReversedSign, SlidingDirection, Touch,
};
use piezotact::run::{
    Acquired, Ended, Judged, Recorded, RunChunk, RunDocument, RunEnd, RunStart, RunWarning, Sink,
    SinkError,
};
use piezotact_bench::procedure::{FORCE_CHANNEL, acquire};
use piezotact_bench::{Acquire, Placement, ProcedureError, RunPlan, StopHandle, Until};
use piezotact_dataset::JournalSink;

use crate::benches::{self, BenchSpec};
use crate::cli::twin::{DirectionName, speed};
use crate::dashboard::{Counts, Dashboard};
use crate::failure::{Failure, Outcome, bench_failure, usage};
use crate::interrupt;
use crate::keeping::{began, say_moved};
use crate::live::{Live, Showing};
use crate::output::{print, print_kept, say_warnings};
use crate::places::{has_ending, outputs, recording_files};
use crate::progress;
use crate::runs::USUAL_ANGLE_DEG;

/// The finger touches where the force exceeds this share of its target; its mean there may be off by the other share.
const CONTACT_SHARE: f64 = 0.1;
const FORCE_TOLERANCE: f64 = 0.1;
/// A larger share of samples below minus a tenth of the target is no noise.
const MOST_NEGATIVE: f64 = 0.05;
/// The longest run, s, and the periods of a metronome, s.
const SECONDS: [f64; 2] = [0.5, 86_400.0];
const PERIOD_S: [f64; 2] = [0.2, 20.0];

/// The options of `piezotact record`.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The bench.
    #[arg(long, help = benches::help("The bench"))]
    bench: BenchSpec,
    /// The duration, in s; default: until Ctrl-C, which ends the recording in order.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// The surface sample.
    #[arg(long)]
    sample: Option<String>,
    /// How finger and surface meet.
    #[arg(long, value_enum, default_value = "active")]
    touch: TouchName,
    /// The nominal sliding speed, such as 30mm/s.
    #[arg(long, value_name = "SPEED", value_parser = speed, allow_hyphen_values = true)]
    speed: Option<f64>,
    /// The direction in which the finger slides.
    #[arg(long, value_enum)]
    direction: Option<DirectionName>,
    /// The normal force that the participant holds, in N; default: the participant chooses it.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    load: Option<f64>,
    /// The angle between finger and surface, in degrees.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    angle: Option<f64>,
    /// How many strokes are wanted, for the display; they do not end the recording.
    #[arg(long, value_name = "N")]
    strokes: Option<usize>,
    /// A metronome with this period in s, seen on the terminal and heard as its bell.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    metronome: Option<f64>,
    /// A label for the recording.
    #[arg(long, default_value = "record")]
    label: String,
    /// The recording to write.
    #[arg(long, value_name = "OUT.parquet")]
    out: PathBuf,
    #[command(flatten)]
    live: Live,
    /// Prints a summary as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum TouchName {
    /// The person moves the finger.
    Active,
    /// The surface moves under a finger at rest.
    Passive,
    /// The finger rests.
    Resting,
}

impl From<TouchName> for Touch {
    fn from(name: TouchName) -> Self {
        match name {
            TouchName::Active => Self::Active,
            TouchName::Passive => Self::Passive,
            TouchName::Resting => Self::Resting,
        }
    }
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    args.live.begin();
    has_ending(&args.out, &["parquet"])?;
    let written = recording_files(&args.out);
    let read: Vec<&Path> = args.bench.file().into_iter().collect();
    outputs(&read, &written.each_ref().map(PathBuf::as_path))?;
    let plan = plan(args)?;
    let mut bench = args.bench.open()?;
    let here = bench.acquirer.describe().condition.angle_deg;
    let plan = RunPlan {
        angle: args.angle.map(Degrees).or(here).unwrap_or(plan.angle),
        ..plan
    };
    // Refused before a file is begun.
    let stop = StopHandle::new();
    bench.acquirer.ready(&plan, &stop).map_err(bench_failure)?;
    bench.acquirer.stop();
    interrupt::stops(&stop);
    let (start, samples, warnings) = recorded(args, bench.acquirer.as_mut(), &plan, &stop)?;
    let recorded = Recorded(Acquired::of_run(&start, samples, warnings));
    if args.json {
        return print_kept(&args.out, &recorded);
    }
    let Recorded(acquired) = recorded;
    say_warnings(&acquired.about.warnings);
    print(&format!(
        "wrote {}: {:.2} on the {}",
        args.out.display(),
        acquired.duration_s,
        acquired.about.provenance.source
    ))
}

fn plan(args: &Arguments) -> Outcome<RunPlan> {
    let within = |name: &str, value: Option<f64>, [low, high]: [f64; 2]| match value {
        Some(value) if !(low..=high).contains(&value) => Err(usage(anyhow!(
            "expected {name} from {low} to {high} s, found {value}"
        ))),
        _ => Ok(()),
    };
    within("--seconds", args.seconds, SECONDS)?;
    within("--metronome", args.metronome, PERIOD_S)?;
    if args.load.is_some_and(|load| !(load > 0.0 && load <= 100.0)) {
        return Err(usage(anyhow!(
            "expected --load above 0 and up to 100 N, found {}",
            args.load.unwrap_or_default()
        )));
    }
    if [Some(&args.label), args.sample.as_ref()]
        .into_iter()
        .flatten()
        .any(|text| text.trim().is_empty() || text.chars().any(char::is_control))
    {
        return Err(usage(anyhow!(
            "expected a label and a sample in words without control characters; write plain words"
        )));
    }
    Ok(RunPlan {
        label: args.label.clone(),
        load: args.load.map(Newtons),
        angle: Degrees(args.angle.unwrap_or(USUAL_ANGLE_DEG)),
        placement: Placement::New,
        until: args
            .seconds
            .map_or(Until::Stopped, |seconds| Until::Duration(Seconds(seconds))),
    })
}

/// Acquires the run, shows it, and keeps it: its start, how many samples, and the warnings about it.
fn recorded(
    args: &Arguments,
    acquirer: &mut dyn Acquire,
    plan: &RunPlan,
    stop: &StopHandle,
) -> Outcome<(RunStart, usize, Vec<Warning>)> {
    let bar = progress::of_run(&args.label, args.seconds.map(Seconds));
    let dashboard = Dashboard::new(
        &bar,
        match args.touch {
            TouchName::Resting => Counts::Nothing,
            TouchName::Active | TouchName::Passive => Counts::Strokes(args.strokes),
        },
    );
    let metronome = args
        .metronome
        .and_then(|period| dashboard.metronome(Seconds(period)));
    let mut sink = Showing(Stated {
        args,
        journal: JournalSink::new(&args.out, None),
        dashboard,
        bar: bar.clone(),
        start: None,
        silent: None,
        force: Contact::default(),
        samples: 0,
        warnings: Vec::new(),
    });
    let done = acquire(acquirer, plan, stop, &mut sink);
    drop(metronome);
    bar.finish_and_clear();
    let mut stated = sink.0;
    say_moved(&mut stated.journal);
    if let Err(error) = done {
        let is_kept = error.continues() && stated.samples > 0;
        return Err(match is_kept && !matches!(error, ProcedureError::Keep(_)) {
            true => Failure::Data(anyhow!(
                "{error}; the acquired samples are kept in {}",
                args.out.display()
            )),
            false => bench_failure(error),
        });
    }
    let start = stated.start.take();
    let start = start.ok_or_else(|| anyhow!("expected a run that begins, found none"))?;
    Ok((start, stated.samples, stated.warnings))
}

/// The force while the finger touches: the mean of what exceeds a tenth of the target.
#[derive(Default)]
struct Contact {
    channel: Option<usize>,
    sum: f64,
    count: usize,
    all: (f64, usize),
    negative: usize,
}

impl Contact {
    fn take(&mut self, chunk: &RunChunk, target_n: f64) {
        let samples = self.channel.and_then(|at| chunk.channels.get(at));
        for sample in samples.into_iter().flatten() {
            self.all.0 += sample;
            self.all.1 += 1;
            if *sample > CONTACT_SHARE * target_n {
                self.sum += sample;
                self.count += 1;
            }
            self.negative += usize::from(*sample < -CONTACT_SHARE * target_n);
        }
    }

    /// What to know of a force that is stated as `target_n`.
    fn warnings(&self, target_n: f64) -> Vec<Warning> {
        if self.channel.is_none() {
            return vec![RunWarning::ForceNotMeasured { load_n: target_n }.into()];
        }
        let over_all_n = self.all.0 / self.all.1.max(1) as f64;
        let share = self.negative as f64 / self.all.1.max(1) as f64;
        let negative = (share > MOST_NEGATIVE).then_some(RecordingWarning::Sign {
            of: ReversedSign::Force {
                share,
                mean_n: over_all_n,
                target_n,
            },
        });
        let mean_n = match self.count {
            0 => over_all_n,
            count => self.sum / count as f64,
        };
        let is_off = (mean_n / target_n - 1.0).abs() > FORCE_TOLERANCE;
        let off = is_off.then_some(RecordingWarning::ConditionDiffers {
            what: Reached::Load { mean_n, target_n },
        });
        negative.into_iter().chain(off).map(Warning::from).collect()
    }
}

/// Keeps the run with the condition that the options state, without the loopback, in which nothing is played.
struct Stated<'a> {
    args: &'a Arguments,
    journal: JournalSink,
    dashboard: Dashboard,
    bar: ProgressBar,
    start: Option<RunStart>,
    /// The channel of the loopback.
    silent: Option<usize>,
    force: Contact,
    samples: usize,
    warnings: Vec<Warning>,
}

impl Stated<'_> {
    fn condition(&self, of_bench: &Condition) -> Condition {
        let args = self.args;
        Condition {
            sample: args.sample.clone(),
            speed_m_s: args.speed,
            touch: Some(args.touch.into()),
            direction: args.direction.map(SlidingDirection::from),
            load_n: args.load.map(Newtons),
            angle_deg: args.angle.map(Degrees),
            ..of_bench.clone()
        }
    }

    fn start(&mut self, start: &RunStart) -> RunDocument {
        let mut start = start.clone();
        start.about.condition = self.condition(&start.about.condition);
        let kind = start.about.provenance.bench;
        start.annotations.started_at = kind.and_then(began);
        self.silent = start
            .channels
            .iter()
            .position(|(_, unit)| *unit == Drive::UNIT);
        // A bench whose only channel is the loopback records it.
        if start.channels.len() < 2 {
            self.silent = None;
        }
        if let Some(at) = self.silent {
            start.channels.remove(at);
        }
        let force = start
            .channels
            .iter()
            .position(|(name, _)| name == FORCE_CHANNEL);
        self.force.channel = force;
        self.start = Some(start.clone());
        RunDocument::Start(Box::new(start))
    }

    fn chunk(&mut self, chunk: &RunChunk) -> RunDocument {
        let mut chunk = chunk.clone();
        if let Some(at) = self.silent
            && at < chunk.channels.len()
        {
            chunk.channels.remove(at);
        }
        if let Some(target_n) = self.args.load {
            self.force.take(&chunk, target_n);
        }
        self.samples += chunk.len();
        let acquired = self.start.as_ref();
        let acquired = acquired.map_or(0.0, |start| start.rate_hz.duration_of(self.samples).0);
        self.bar.set_position((10.0 * acquired) as u64);
        RunDocument::Chunk(chunk)
    }

    fn end(&mut self, end: &RunEnd) -> RunDocument {
        let mut end = end.clone();
        if self.args.seconds.is_none() && end.ended == Ended::Stopped {
            // To be stopped is how it was to end.
            end.ended = Ended::Completed;
        }
        let target_n = self.args.load;
        let force = target_n.map(|target_n| self.force.warnings(target_n));
        end.warnings.extend(force.into_iter().flatten());
        let rate = self.start.as_ref().map(|start| start.rate_hz);
        self.warnings = rate.map_or_else(Vec::new, |rate| end.all_warnings(rate));
        RunDocument::End(Box::new(end))
    }
}

impl Sink for Stated<'_> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        let document = match document {
            RunDocument::Start(start) => self.start(start),
            RunDocument::Chunk(chunk) => self.chunk(chunk),
            RunDocument::End(end) => self.end(end),
            other => other.clone(),
        };
        self.dashboard.take(&document);
        self.journal.take(&document)
    }
}
