//! `piezotact-validation stops`: how soon the output is silent after a person's stop, on the twin in real time and on sound devices, while the journal of
//! the run is written, and while what writes it waits.

#![allow(clippy::print_stdout, reason = "it prints a table")]

use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use piezotact::device::{DeviceAtGain, DeviceDescription};
use piezotact::quantity::{Degrees, Drive, Newtons, SampleRate};
use piezotact::recording::BenchKind;
use piezotact::run::{Judged, RunDocument, RunStart, Sink, SinkError};
use piezotact::series::Series;
use piezotact::sound::DeviceListing;
use piezotact::statistics::random::Random;
use piezotact_audio::{
    AudioBench, AudioError, AudioIo, Board, HardwareIo, InputCallback, LoopIo, OutputCallback,
    SoundSetup, StreamPlan, Streams,
};
use piezotact_bench::halves::SimulatedBench as _;
use piezotact_bench::procedure::{RunKeeper, play_and_record};
use piezotact_bench::{Bench, Placement, Plant, ProcedureError, RunPlan, StopHandle, Until};
use piezotact_dataset::JournalSink;
use piezotact_twin::{Participant, TwinBench, TwinParameters, TwinPlant};

pub(crate) const NAME: &str = "stop";

/// Stops that are measured in each way, and of them in how many the sink waits.
const STOPS: usize = 50;
const STALLED: usize = 20;
/// What is asked of every one, s.
const WITHIN_S: f64 = 0.1;
/// The sink waits so long with a chunk.
const STALLS: Duration = Duration::from_secs(2);
/// A stop comes so long after the sound was heard, s, drawn between the two.
const COMES_S: [f64; 2] = [0.2, 0.9];
/// Runs that ended otherwise before their stop are repeated, so many at most.
const REPEATED: usize = 10;
const SEED: u64 = 44;
const DRIVE_S: usize = 10;
const RATE_HZ: f64 = 48_000.0;

/// The counters of the callbacks of a sound device.
type Shown = Arc<Mutex<Option<Arc<Board>>>>;

/// A sound system whose counters are looked at.
struct Watched<T>(T, Shown);

impl<T: AudioIo> AudioIo for Watched<T> {
    fn devices(&self) -> Result<Vec<DeviceListing>, AudioError> {
        self.0.devices()
    }

    fn open(
        &mut self,
        plan: &StreamPlan,
        output: OutputCallback,
        input: InputCallback,
        board: &Arc<Board>,
    ) -> Result<Box<dyn Streams>, AudioError> {
        *self.1.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(board));
        self.0.open(plan, output, input, board)
    }
}

/// What the sink of the run does meanwhile.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Disk {
    Writes,
    Stalls,
}

impl Disk {
    fn stops(self) -> usize {
        match self {
            Self::Writes => STOPS,
            Self::Stalls => STALLED,
        }
    }
}

/// A way from the stop to the output.
struct Way {
    name: &'static str,
    bench: Bench,
    /// None on the twin, whose output ends by the clock of the bench; it begins so long after the run, s.
    board: Option<Arc<Board>>,
    lead_s: f64,
}

/// From a stop to the first zero sample, s: by the clock of the output, counted from the first frame that was not filled in yet at the stop, and by
/// the wall, to the moment at which the callback had filled it in; the twin has no callback.
#[derive(Clone, Copy)]
struct Silent {
    by_output_s: f64,
    by_wall_s: Option<f64>,
}

/// Writes the journal of a run, and has it stopped from another thread.
struct Keeper<'a> {
    file: &'a Path,
    disk: Disk,
    comes_s: f64,
    stop: StopHandle,
    board: Option<Arc<Board>>,
    began: Option<Instant>,
    stops: Option<JoinHandle<Stop>>,
}

/// What the thread that stops has seen.
struct Stop {
    at: Instant,
    /// Frames that the output had counted, and the first of silence behind them with when it was seen.
    counted: u64,
    silent: Option<(u64, Instant)>,
}

struct Kept<'a, 'b> {
    keeper: &'b mut Keeper<'a>,
    journal: JournalSink,
}

impl RunKeeper for Keeper<'_> {
    fn sink(&mut self, _start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        Ok(Box::new(Kept {
            journal: JournalSink::new(self.file, None),
            keeper: self,
        }))
    }
}

impl Sink for Kept<'_, '_> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        let judged = self.journal.take(document);
        let keeper = &mut *self.keeper;
        match document {
            RunDocument::Start(_) => keeper.began = Some(Instant::now()),
            // The sound began 0.2 s after the run.
            RunDocument::Chunk(chunk) if keeper.stops.is_none() && chunk.first > 0 => {
                keeper.stops = Some(keeper.stops_soon());
                if keeper.disk == Disk::Stalls {
                    std::thread::sleep(STALLS);
                }
            }
            _ => {}
        }
        judged
    }
}

impl Keeper<'_> {
    fn stops_soon(&self) -> JoinHandle<Stop> {
        let (stop, board) = (self.stop.clone(), self.board.clone());
        let comes = Duration::from_secs_f64(self.comes_s);
        std::thread::spawn(move || {
            std::thread::sleep(comes);
            let counted = |board: &Arc<Board>| board.output.frames.load(Ordering::Acquire);
            let counted = board.as_ref().map_or(0, counted);
            let at = Instant::now();
            stop.stop();
            let seen = board.and_then(|board| {
                loop {
                    let frame = board.silent_from.load(Ordering::Acquire);
                    if frame >= counted {
                        return Some((frame, Instant::now()));
                    }
                    if at.elapsed() > 2 * STALLS {
                        return None;
                    }
                    std::thread::sleep(Duration::from_micros(200));
                }
            });
            Stop {
                at,
                counted,
                silent: seen,
            }
        })
    }
}

impl Way {
    fn twin() -> Result<Self> {
        let parameters = TwinParameters::built_in();
        let person = Participant::of(1, SEED, &parameters);
        let twin = TwinBench::new(&parameters, person, &device());
        let lead_s = twin.lead_s();
        Ok(Self {
            name: "twin in real time",
            bench: twin.into_bench().in_real_time(),
            board: None,
            lead_s,
        })
    }

    /// A loop within the program in real time, with the finger of the twin behind it.
    fn looped() -> Result<Self> {
        let setup = setup(
            "host = \"loop\"\nrecord = [{ channel = 1, measures = \"drive\" }, { channel = 2, measures = \"acceleration\", mv_per_m_s2 = 10.2 }]\n\
             [loop]\npace = \"real_time\"",
        )?;
        let plant = Box::new(|run: Option<&RunPlan>, rate| {
            let parameters = TwinParameters::built_in();
            let person = Participant::of(1, SEED, &parameters);
            let resting = plan("at rest");
            let run = run.unwrap_or(&resting);
            let plant = TwinPlant::new(&parameters, &person, &device(), run, rate)?;
            Ok(Box::new(plant) as Box<dyn Plant>)
        });
        let io = LoopIo::new(&setup, Some(plant))?;
        Self::over("loop with a twin", setup, io)
    }

    fn jack() -> Result<Self> {
        let setup = setup(
            "host = \"jack\"\noutput = \"output\"\ninput = \"input\"\nrecord = [{ channel = 1, measures = \"drive\" }]",
        )?;
        Self::over("JACK", setup, HardwareIo::new("jack")?)
    }

    fn over(name: &'static str, setup: SoundSetup, io: impl AudioIo) -> Result<Self> {
        let shown = Shown::default();
        let bench = AudioBench {
            setup,
            calibration: None,
            device: device(),
            participant: None,
            latency: None,
            twin_seed: None,
            kind: BenchKind::Scripted,
            today: 0,
        };
        let bench = bench.open(&mut Watched(io, Arc::clone(&shown)))?;
        let board = shown.lock().unwrap_or_else(PoisonError::into_inner).take();
        Ok(Self {
            name,
            bench,
            board,
            lead_s: 0.0,
        })
    }

    /// A texture that is stopped `comes_s` after its first samples; none where the run ended otherwise, which is said.
    fn silent(&mut self, file: &Path, comes_s: f64, disk: Disk) -> Result<Option<Silent>> {
        // As in a session: what ends the program, what ends one trial.
        let for_good = StopHandle::new();
        self.bench.stop = for_good.child();
        let rate = self.bench.player.describe().rate;
        let mut random = Random::stream(SEED, 0, "texture");
        let noise = (0..DRIVE_S * rate.hz() as usize).map(|_| 0.1 * random.normal());
        let drive = Series::<Drive>::new(noise.collect(), rate)?;
        let mut keeper = Keeper {
            file,
            disk,
            comes_s,
            stop: for_good,
            board: self.board.clone(),
            began: None,
            stops: None,
        };
        let run = plan("texture");
        let done = play_and_record(&mut self.bench, &drive, None, &run, &mut keeper, None);
        let stop = keeper.stops.take().map(JoinHandle::join);
        match done {
            Err(ProcedureError::Stopped { .. }) => {}
            Err(error) => {
                println!("     {}: {error}", self.name);
                return Ok(None);
            }
            Ok(_) => anyhow::bail!("{}: a stop did not end the run", self.name),
        }
        let stop = stop.and_then(Result::ok).context("nothing was stopped")?;
        let began = keeper.began.context("the run has no beginning")?;
        if self.board.is_none() {
            let played_s = self.bench.player.progress()?.played as f64 / rate.hz();
            let stopped_s = stop.at.duration_since(began).as_secs_f64();
            return Ok(Some(Silent {
                // Silence before the stop would be as wrong as after it.
                by_output_s: (self.lead_s + played_s - stopped_s).abs(),
                by_wall_s: None,
            }));
        }
        let (frame, seen) = stop.silent.context("the output was not silent in 4 s")?;
        Ok(Some(Silent {
            by_output_s: (frame - stop.counted) as f64 / RATE_HZ,
            by_wall_s: Some(seen.duration_since(stop.at).as_secs_f64()),
        }))
    }

    fn measured(&mut self, folder: &Path, disk: Disk) -> Result<Vec<Silent>> {
        let wanted = disk.stops();
        let mut random = Random::stream(SEED, 0, &format!("{} {disk:?}", self.name));
        let mut all = Vec::new();
        for number in 0..wanted + REPEATED {
            let file = folder.join(format!("{}-{disk:?}-{number}.parquet", self.name));
            let comes_s = COMES_S[0] + random.uniform() * (COMES_S[1] - COMES_S[0]);
            all.extend(self.silent(&file, comes_s, disk)?);
            if all.len() == wanted {
                break;
            }
        }
        Ok(all)
    }
}

fn device() -> DeviceAtGain {
    DeviceDescription::drv2667().at_usual_gain()
}

fn setup(text: &str) -> Result<SoundSetup> {
    let rate = SampleRate::new(RATE_HZ)?.hz();
    let common = format!("rate_hz = {rate}\nbuffer_frames = 1024\nplay = {{ drive = [1] }}");
    Ok(SoundSetup::from_toml(&format!("{common}\n{text}"))?)
}

fn plan(label: &str) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}

/// Measures and prints the table.
pub(crate) fn run() -> Result<()> {
    println!(
        "\n{NAME} from a stop in another thread to the first zero sample, while the journal is written: {STOPS} times, and {STALLED} times while its disk stalls for {} s; ms, median (largest), by the clock of the output and by the wall",
        STALLS.as_secs()
    );
    let folder = std::env::temp_dir().join(format!("piezotact-stop-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let measured = measure(&folder);
    std::fs::remove_dir_all(&folder)?;
    let missed = measured?;
    ensure!(missed.is_empty(), "not reached: {}", missed.join("; "));
    Ok(())
}

/// What was not reached.
fn measure(folder: &Path) -> Result<Vec<String>> {
    let mut missed = Vec::new();
    for open in [Way::twin, Way::looped, Way::jack] {
        let mut way = match open() {
            Ok(way) => way,
            Err(error) => {
                println!("  not decided: {error}");
                continue;
            }
        };
        for disk in [Disk::Writes, Disk::Stalls] {
            let all = way.measured(folder, disk)?;
            let wanted = disk.stops();
            let by_output: Vec<f64> = all.iter().map(|one| one.by_output_s).collect();
            let by_wall: Vec<f64> = all.iter().filter_map(|one| one.by_wall_s).collect();
            let name = match disk {
                Disk::Writes => way.name.to_owned(),
                Disk::Stalls => format!("{}, disk stalls", way.name),
            };
            let slowest = |one: &Silent| one.by_output_s.max(one.by_wall_s.unwrap_or(0.0));
            let within = all.iter().filter(|one| slowest(one) <= WITHIN_S).count();
            println!(
                "  {name:<32}{:>18}{:>18}   {within} of {wanted} within {:.0} ms",
                told(&by_output),
                told(&by_wall),
                1e3 * WITHIN_S
            );
            if within < wanted {
                missed.push(format!("{name}: {within} of {wanted}"));
            }
        }
    }
    Ok(missed)
}

/// Median and largest, ms.
fn told(seconds: &[f64]) -> String {
    let mut sorted = seconds.to_vec();
    sorted.sort_by(f64::total_cmp);
    match (sorted.get(sorted.len() / 2), sorted.last()) {
        (Some(median), Some(largest)) => format!("{:.1} ({:.1})", 1e3 * median, 1e3 * largest),
        _ => "–".into(),
    }
}
