//! `piezotact record`: what the sensors of a bench acquire while a person touches something; nothing is played.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::Doubt;
use piezotact::quantity::{Degrees, Newtons, Seconds};
use piezotact::recording::{Condition, SlidingDirection, Touch};
use piezotact::run::{Judged, RunDocument, RunStart, Sink, SinkError};
use piezotact_bench::document::RecordDocument;
use piezotact_bench::procedure::acquire;
use piezotact_bench::{Acquire, Placement, RunPlan, StopHandle, Until};
use piezotact_dataset::JournalSink;

use super::{USUAL_ANGLE_DEG, bench_failure, has_ending, outputs, recording_files};
use crate::benches::{self, BenchSpec};
use crate::cli::twin::{DirectionName, speed};
use crate::dashboard::{Counts, Dashboard};
use crate::failure::{Outcome, usage};
use crate::interrupt;
use crate::keeping::say_moved;
use crate::live::{Live, Showing};
use crate::output::{print, print_document, say_doubts};
use crate::progress;

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
    let (start, samples, doubts) = recorded(args, bench.acquirer.as_mut(), &plan, &stop)?;
    let document = RecordDocument::of(&start, samples, &args.out, &doubts);
    if args.json {
        return print_document(&document);
    }
    say_doubts(&doubts);
    print(&format!(
        "wrote {}: {:.2} on the {}",
        args.out.display(),
        document.duration_s,
        document.provenance.source
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

/// Acquires the run, shows it, and keeps it: its start, how many samples, and what is doubted of it.
fn recorded(
    args: &Arguments,
    acquirer: &mut dyn Acquire,
    plan: &RunPlan,
    stop: &StopHandle,
) -> Outcome<(RunStart, usize, Vec<Doubt>)> {
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
        condition: args,
        journal: JournalSink::new(&args.out, None),
        dashboard,
        start: None,
        doubts: Vec::new(),
    });
    let done = acquire(acquirer, plan, stop, &mut sink);
    drop(metronome);
    bar.finish_and_clear();
    say_moved(&mut sink.0.journal);
    let (_, samples) = done.map_err(|error| match (error.continues(), &sink.0.start) {
        (true, Some(_)) => crate::failure::Failure::Data(anyhow!(
            "{error}; the acquired samples are kept in {}",
            args.out.display()
        )),
        _ => bench_failure(error),
    })?;
    let Stated { start, doubts, .. } = sink.0;
    let start = start.ok_or_else(|| anyhow!("expected a run that begins, found none"))?;
    Ok((start, samples, doubts))
}

/// Keeps the run with the condition that the options state.
struct Stated<'a> {
    condition: &'a Arguments,
    journal: JournalSink,
    dashboard: Dashboard,
    start: Option<RunStart>,
    doubts: Vec<Doubt>,
}

impl Stated<'_> {
    fn condition(&self, of_bench: &Condition) -> Condition {
        let args = self.condition;
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
}

impl Sink for Stated<'_> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        let stated = match document {
            RunDocument::Start(start) => {
                let mut start = start.clone();
                start.about.condition = self.condition(&start.about.condition);
                self.start = Some((*start).clone());
                Some(RunDocument::Start(start))
            }
            RunDocument::End(end) => {
                self.doubts.clone_from(&end.doubts);
                None
            }
            _ => None,
        };
        let document = stated.as_ref().unwrap_or(document);
        self.dashboard.take(document);
        self.journal.take(document)
    }
}
