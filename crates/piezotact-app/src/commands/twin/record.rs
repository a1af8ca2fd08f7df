//! `piezotact twin record`: what a finger does on a bench of the twin, and its person's EEG.

use std::path::Path;

use anyhow::anyhow;
use piezotact::quantity::{Acceleration, Degrees, Newtons, Seconds};
use piezotact::recording::{Annotations, Event};
use piezotact::run::{Acquired, Judged, RunDocument, RunStart, Sink, SinkError, TwinRecorded};
use piezotact::series::Series;
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, acquire};
use piezotact_bench::{Acquire, Placement, RunPlan, StopHandle, Until};
use piezotact_dataset::JournalSink;
use piezotact_dataset::sidecar::{Sidecar, sidecar_path};
use piezotact_dataset::wav::{SampleFormat, write_wav_with_sidecar};
use piezotact_twin::{
    ActTouch, ActiveProtocol, Pace, Participant, Sample, ShakerBench, ShakerExcitation,
    ShakerMount, TriboAir, TwinParameters,
};

use super::{eeg, twin_parameters};
use crate::cli::twin::{BenchName, DirectionName, Record};
use crate::failure::bench_failure;
use crate::failure::{Outcome, usage};
use crate::interrupt;
use crate::keeping::{Earlier, say_moved};
use crate::live::{self, Showing};
use crate::output::{print, print_kept};
use crate::places::{has_ending, outputs, recording_files};

/// What is usual unless it is stated.
const SPEED_M_S: f64 = 0.03;
const LOAD_N: f64 = 0.2;
const ACTIVE_STROKES: usize = 15;
const PASSIVE_STROKES: usize = 6;
const SHAKER_S: f64 = 60.0;
const SHAKER_ANGLE_DEG: f64 = 20.0;

pub(crate) fn run(args: &Record) -> Outcome {
    only_where_they_count(args)?;
    if args.label.chars().any(char::is_control) {
        return Err(usage(anyhow!(
            "expected a label without control characters, found {:?}; write plain words",
            args.label
        )));
    }
    let parameters = twin_parameters(args.who.twin.as_deref())?;
    let Some(bench) = bench(args, &parameters)? else {
        return eeg::run(args, &parameters);
    };
    let wav = checked(args)?;
    args.live.begin();
    let mut acquirer = live::acquirer(bench);
    let run = plan(args, &parameters);
    // Refused before a file is begun.
    let stop = StopHandle::new();
    acquirer.ready(&run, &stop).map_err(bench_failure)?;
    acquirer.stop();
    interrupt::stops(&stop);
    let (start, samples) = if wav {
        sound(acquirer.as_mut(), &run, &args.out, &stop)?
    } else {
        journal(acquirer.as_mut(), &run, &args.out, &stop)?
    };
    let acquired = Acquired::of_run(&start, samples, start.about.warnings.clone());
    if stop.is_stopped() {
        return Err(stopped(&acquired, samples, &args.out).into());
    }
    if args.json {
        return print_kept(&args.out, &TwinRecorded(acquired));
    }
    print(&format!(
        "wrote {}: {:.2} on the {}",
        args.out.display(),
        acquired.duration_s,
        acquired.about.provenance.source
    ))
}

/// Refuses outputs that cannot be; whether a sound is asked for.
fn checked(args: &Record) -> Outcome<bool> {
    let read: Vec<&Path> = args.who.twin.as_deref().into_iter().collect();
    let wav = has_ending(&args.out, &["parquet", "wav"])? == "wav";
    if wav {
        outputs(&read, &[&args.out, &sidecar_path(&args.out)])?;
    } else {
        let written = recording_files(&args.out);
        outputs(&read, &written.each_ref().map(std::path::PathBuf::as_path))?;
    }
    Ok(wav)
}

fn plan(args: &Record, parameters: &TwinParameters) -> RunPlan {
    RunPlan {
        label: args.label.clone(),
        load: (!args.free && !args.control).then(|| Newtons(args.load.unwrap_or(LOAD_N))),
        angle: Degrees(args.angle.unwrap_or(match args.bench {
            BenchName::Shaker => SHAKER_ANGLE_DEG,
            BenchName::Acttouch | BenchName::Triboair | BenchName::Eeg => parameters.hand.angle_deg,
        })),
        placement: Placement::New,
        until: Until::Stopped,
    }
}

/// What is said of a run that was stopped by hand.
fn stopped(acquired: &Acquired, samples: usize, out: &Path) -> anyhow::Error {
    match samples {
        0 => anyhow!("stopped by hand: nothing was acquired, and no file was written"),
        _ => anyhow!(
            "stopped by hand after {:.2}; the recording is kept in {}",
            acquired.duration_s,
            out.display()
        ),
    }
}

/// The bench with the participant at it; none for EEG, which no bench acquires.
fn bench(args: &Record, parameters: &TwinParameters) -> Outcome<Option<Box<dyn Acquire>>> {
    let participant = Participant::of(args.who.participant, args.who.seed, parameters);
    let speed_m_s = args.speed.unwrap_or(SPEED_M_S);
    Ok(Some(match args.bench {
        BenchName::Acttouch => {
            let protocol = active_protocol(args, speed_m_s);
            ActTouch::new(parameters, participant, sample(args, parameters)?, protocol)
                .map_err(bench_failure)?
                .into_acquirer()
        }
        BenchName::Triboair => {
            let strokes = args.strokes.unwrap_or(PASSIVE_STROKES);
            let sample = sample(args, parameters)?;
            TriboAir::new(parameters, participant, sample, strokes, speed_m_s)
                .map_err(bench_failure)?
                .into_acquirer()
        }
        BenchName::Shaker => {
            let mount = if args.control {
                ShakerMount::Plate
            } else {
                ShakerMount::Finger
            };
            let duration = Seconds(args.seconds.unwrap_or(SHAKER_S));
            let excitation = ShakerExcitation::thesis(duration, args.who.seed);
            ShakerBench::new(parameters, participant, mount, excitation).into_acquirer()
        }
        BenchName::Eeg => return Ok(None),
    }))
}

/// The movement and pace of active touch.
fn active_protocol(args: &Record, speed_m_s: f64) -> ActiveProtocol {
    ActiveProtocol {
        strokes: args.strokes.unwrap_or(ACTIVE_STROKES),
        movement: args.direction.into(),
        pace: if args.free {
            Pace::Free
        } else {
            Pace::Metronome {
                speed_m_s,
                stroke_s: args.stroke_time,
            }
        },
    }
}

fn sample<'a>(args: &Record, parameters: &'a TwinParameters) -> Outcome<&'a Sample> {
    let name = args.sample.as_deref().ok_or_else(|| {
        usage(anyhow!(
            "expected a sample, found none; name one of {} with --sample",
            parameters.sample_names().join(", ")
        ))
    })?;
    parameters.sample(name).map_err(usage)
}

/// Refuses options that the bench would pass over in silence.
fn only_where_they_count(args: &Record) -> Outcome {
    let active = args.bench == BenchName::Acttouch;
    let shaker = args.bench == BenchName::Shaker;
    let eeg = args.bench == BenchName::Eeg;
    let sample = !shaker && !eeg;
    let stated = [
        ("--free", args.free, active),
        (
            "--direction",
            args.direction != DirectionName::Proximal,
            active,
        ),
        ("--stroke-time", args.stroke_time.is_some(), active),
        ("--sample", args.sample.is_some(), sample),
        ("--speed", args.speed.is_some(), sample),
        ("--strokes", args.strokes.is_some(), sample),
        ("--load", args.load.is_some(), !eeg),
        ("--angle", args.angle.is_some(), !eeg),
        ("--live", args.live.is_asked_for(), !eeg),
        ("--seconds", args.seconds.is_some(), shaker),
        ("--control", args.control, shaker),
        ("--task", args.task.is_some(), eeg),
        ("--trials", args.trials.is_some(), eeg),
    ];
    match stated.iter().find(|(_, given, counts)| *given && !counts) {
        Some((option, ..)) => Err(usage(anyhow!(
            "expected options of the bench {}, found {option}, which this bench does not use; leave it out",
            match args.bench {
                BenchName::Acttouch => "acttouch",
                BenchName::Triboair => "triboair",
                BenchName::Shaker => "shaker",
                BenchName::Eeg => "eeg",
            }
        ))),
        None => Ok(()),
    }
}

/// Records into a Parquet file, chunk by chunk.
fn journal(
    acquirer: &mut dyn Acquire,
    run: &RunPlan,
    out: &Path,
    stop: &StopHandle,
) -> Outcome<(RunStart, usize)> {
    let mut sink = Showing(JournalSink::new(out, None));
    let done = acquire(acquirer, run, stop, &mut sink).map_err(bench_failure)?;
    say_moved(&mut sink.0);
    Ok(done)
}

/// The samples of one channel of a run.
struct OneChannel {
    channel: usize,
    samples: Vec<f64>,
    events: Vec<Event>,
}

impl Sink for OneChannel {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        match document {
            RunDocument::Chunk(chunk) => self.samples.extend(&chunk.channels[self.channel]),
            RunDocument::Event(event) => self.events.push(event.clone()),
            _ => {}
        }
        Ok(None)
    }
}

/// Records the nail's acceleration as sound, as loud as fits.
fn sound(
    acquirer: &mut dyn Acquire,
    run: &RunPlan,
    out: &Path,
    stop: &StopHandle,
) -> Outcome<(RunStart, usize)> {
    let channels = acquirer.describe().channels;
    let nail = channels
        .iter()
        .position(|(name, _)| name == ACCELERATION_CHANNEL);
    let mut sink = Showing(OneChannel {
        channel: nail.unwrap_or_default(),
        samples: Vec::new(),
        events: Vec::new(),
    });
    let (start, _) = acquire(acquirer, run, stop, &mut sink).map_err(bench_failure)?;
    let sink = sink.0;
    if sink.samples.is_empty() && stop.is_stopped() {
        return Ok((start, 0));
    }
    let vibration = Series::<Acceleration>::new(sink.samples, start.rate_hz)?;
    let (shares, full_scale) = vibration.in_shares_of_peak();
    let sidecar = Sidecar {
        full_scale: Some(full_scale),
        channels: vec![ACCELERATION_CHANNEL.into()],
        about: start.about.clone(),
        annotations: Annotations {
            events: sink.events,
            ..start.annotations.clone()
        },
        rendering: None,
    };
    let rate_hz = start.rate_hz.hz().round() as u32;
    let earlier = Earlier::at(out, "the earlier recording")?;
    write_wav_with_sidecar(out, &[&shares], rate_hz, SampleFormat::Float32, &sidecar)?;
    earlier.settle()?;
    Ok((start, shares.len()))
}
