//! Conformance tests that every bench passes, for use in the tests of any crate that builds a bench.
//!
//! [`of_bench`] and [`of_acquirer`] take a constructor of a bench and a [`Subject`], and return one [`Finding`] for each rule
//! that the bench breaks. Each rule is checked on a new bench in its own thread: a bench that never returns breaks a rule too.

mod ends;
mod playing;
mod steps;
mod stream;

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use piezotact::Series;
use piezotact::quantity::{Degrees, Drive, Newtons, SampleRate, Seconds};
use piezotact::run::RunChunk;
use piezotact::series::SeriesError;

use crate::error::DeviceError;
use crate::plan::{Placement, Playback, RunPlan, Until};
use crate::stop::StopHandle;
use crate::traits::{Acquire, Bench, PlayProgress};

/// A rule of the contract of a bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Steps out of order are refused and named.
    Order,
    /// The samples match the description of the bench: channels, rate, calibration at rest.
    Described,
    /// Samples are contiguous, in chunks of at most a second, and the device time advances with them.
    Stream,
    /// A run of a stated duration has exactly that duration.
    Duration,
    /// A run until the end of playback contains the whole playback and the decay after it, and ends.
    PlaybackEnded,
    /// A run until a stop continues until it is stopped.
    Stopped,
    /// A stop from another thread ends a run promptly, even while the bench waits.
    StopFromOutside,
    /// After a stop from another thread an output plays on for 0.1 s at most, also where nobody acquires meanwhile.
    OutputStops,
    /// A run that was stopped before its start holds nothing.
    StoppedBefore,
    /// `stop()` is harmless at any time, and twice.
    StopHarmless,
    /// The same run on the same bench gives the same samples.
    Repeatable,
    /// A run works after one that was stopped.
    AfterStop,
    /// A drive at another rate is refused.
    Rate,
    /// A drive generated during playback gives the same samples as the same drive given as a whole.
    Made,
    /// The progress of a playback grows to its end.
    Progress,
    /// A calibration between runs changes nothing.
    Calibration,
    /// The playing and the acquiring half work in different threads.
    Threads,
}

/// A rule that a bench breaks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    pub rule: Rule,
    pub found: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.rule, self.found)
    }
}

/// The properties of a bench that its tests need.
#[derive(Clone, Debug)]
pub struct Subject {
    /// A run that the bench can do; its label is used for every run, its end is replaced by each test.
    pub run: RunPlan,
    /// A drive that it can play, at the rate of its output, of a second or so; none for a bench that only acquires.
    pub drive: Option<Series<Drive>>,
    /// The origin of the bench's randomness.
    pub draws: Draws,
    /// The least duration of a run that nobody stops, s; a bench of real devices has no limit.
    pub goes_on_for: Seconds,
}

impl Subject {
    /// A bench whose output runs at `rate`: 0.6 s of 200 Hz with `peak` of full scale, under 0.2 N at 20°, drawn from a seed; it goes on for 8 s.
    ///
    /// # Errors
    /// Those of [`Series::new`].
    pub fn with_tone(peak: f64, rate: SampleRate) -> Result<Self, SeriesError> {
        let radians = TAU * 200.0 / rate.hz();
        let samples = (0..rate.samples_in(Seconds(0.6))).map(|i| peak * (radians * i as f64).sin());
        Ok(Self {
            run: RunPlan {
                label: "conformance".into(),
                load: Some(Newtons(0.2)),
                angle: Degrees(20.0),
                placement: Placement::New,
                until: Until::Stopped,
            },
            drive: Some(Series::new(samples.collect(), rate)?),
            draws: Draws::Seeded,
            goes_on_for: Seconds(8.0),
        })
    }
}

/// Where a bench's randomness comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Draws {
    /// From a seed: the same run gives the same samples.
    Seeded,
    /// Physical noise: no two runs are equal.
    Unseeded,
}

/// A check takes so long at most.
const AT_MOST: Duration = Duration::from_secs(60);
/// No run of a check has more chunks.
const MOST_CHUNKS: usize = 2_000;
/// The duration of runs that have one, s: no multiple of a usual chunk.
const DURATION: Seconds = Seconds(0.777);

/// Builds a new bench for each check; one that only acquires has no player.
type Make = Arc<dyn Fn() -> Bench + Send + Sync>;
type Check = fn(&Make, &Subject) -> Result<(), String>;

const BOTH: [(Rule, Check); 9] = [
    (Rule::Described, stream::described),
    (Rule::Stream, stream::contiguous),
    (Rule::Duration, ends::duration),
    (Rule::Stopped, ends::stopped),
    (Rule::StopFromOutside, ends::stop_from_outside),
    (Rule::StoppedBefore, ends::stopped_before),
    (Rule::StopHarmless, ends::stop_harmless),
    (Rule::Repeatable, stream::repeatable),
    (Rule::AfterStop, ends::after_stop),
];
const ACQUIRING: [(Rule, Check); 2] = [
    (Rule::Order, steps::acquiring),
    (Rule::Calibration, stream::calibration),
];
const PLAYING: [(Rule, Check); 8] = [
    (Rule::Order, steps::playing),
    (Rule::Calibration, playing::calibration),
    (Rule::PlaybackEnded, playing::playback_ended),
    (Rule::OutputStops, playing::output_stops),
    (Rule::Rate, playing::rate),
    (Rule::Made, playing::made),
    (Rule::Progress, playing::progress),
    (Rule::Threads, playing::threads),
];

/// The rules broken by the bench that `make` constructs; none for a bench that passes.
#[must_use]
pub fn of_bench(
    make: impl Fn() -> Bench + Send + Sync + 'static,
    subject: &Subject,
) -> Vec<Finding> {
    let make: Make = Arc::new(make);
    let checks = BOTH.iter().chain(&ACQUIRING).chain(&PLAYING);
    all(&make, subject, checks)
}

/// The rules broken by the acquiring half that `make` constructs, for a bench that only acquires.
#[must_use]
pub fn of_acquirer(
    make: impl Fn() -> Box<dyn Acquire> + Send + Sync + 'static,
    subject: &Subject,
) -> Vec<Finding> {
    let make: Make = Arc::new(move || Bench::new(Box::new(playing::NoPlayer), make()));
    let subject = Subject {
        drive: None,
        ..subject.clone()
    };
    let checks = BOTH.iter().chain(&ACQUIRING);
    all(&make, &subject, checks)
}

/// What `checks` find, each in a thread of its own.
fn all<'a>(
    make: &Make,
    subject: &Subject,
    checks: impl Iterator<Item = &'a (Rule, Check)>,
) -> Vec<Finding> {
    let begun: Vec<_> = checks
        .map(|(rule, check)| {
            let (said, hear) = mpsc::channel();
            let (make, subject, check) = (Arc::clone(make), subject.clone(), *check);
            std::thread::spawn(move || {
                // The receiver is gone if the check took too long.
                let _heard = said.send(check(&make, &subject));
            });
            (*rule, hear)
        })
        .collect();
    let until = Instant::now() + AT_MOST;
    let found = |(rule, hear): (Rule, mpsc::Receiver<Result<(), String>>)| {
        let left = until.saturating_duration_since(Instant::now());
        let found = match hear.recv_timeout(left) {
            Ok(Ok(())) => return None,
            Ok(Err(found)) => found,
            Err(mpsc::RecvTimeoutError::Timeout) => {
                format!("expected an end within {} s, found none", AT_MOST.as_secs())
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => "expected an end, found a panic".into(),
        };
        Some(Finding { rule, found })
    };
    begun.into_iter().filter_map(found).collect()
}

/// What one run gave.
#[derive(Debug, Default, PartialEq)]
struct Taken {
    chunks: Vec<RunChunk>,
    progress: Vec<PlayProgress>,
    /// Whether the bench said that it was over.
    over: bool,
}

impl Taken {
    /// Samples, with those that were lost.
    fn samples(&self) -> u64 {
        self.chunks
            .iter()
            .map(|chunk| chunk.lost + chunk.len() as u64)
            .sum()
    }

    /// All samples, channel by channel.
    fn channels(&self) -> Vec<Vec<f64>> {
        let mut all: Vec<Vec<f64>> = Vec::new();
        for chunk in &self.chunks {
            all.resize(all.len().max(chunk.channels.len()), Vec::new());
            for (channel, new) in all.iter_mut().zip(&chunk.channels) {
                channel.extend(new);
            }
        }
        all
    }
}

fn said(error: DeviceError) -> String {
    error.to_string()
}

fn until(subject: &Subject, until: Until) -> RunPlan {
    RunPlan {
        until,
        ..subject.run.clone()
    }
}

fn playback(subject: &Subject) -> Option<Playback> {
    subject.drive.clone().map(Playback::Whole)
}

/// Makes both halves ready for `run` and starts them, the input first.
fn begin(bench: &mut Bench, playback: Option<Playback>, run: &RunPlan) -> Result<(), String> {
    let plays = playback.is_some();
    bench.acquirer.ready(run, &bench.stop).map_err(said)?;
    if let Some(playback) = playback {
        bench
            .player
            .ready(playback, run, &bench.stop)
            .map_err(said)?;
    }
    bench.acquirer.start().map_err(said)?;
    if plays {
        bench.player.start().map_err(said)?;
    }
    Ok(())
}

/// What an output does in a run.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Playing {
    /// It plays a drive.
    Drive,
    /// Nothing.
    Nothing,
}

impl Playing {
    fn of<T>(drive: Option<&T>) -> Self {
        drive.map_or(Self::Nothing, |_| Self::Drive)
    }
}

/// Takes chunks until the bench says that the run is over, or `enough` says so.
fn take(
    bench: &mut Bench,
    playing: Playing,
    mut enough: impl FnMut(&Taken) -> bool,
) -> Result<Taken, String> {
    let mut taken = Taken::default();
    let mut ended = false;
    while taken.chunks.len() < MOST_CHUNKS && !enough(&taken) {
        let Some(chunk) = bench.acquirer.next_chunk().map_err(said)? else {
            taken.over = true;
            return Ok(taken);
        };
        taken.chunks.push(chunk);
        if playing == Playing::Drive {
            let now = bench.player.progress().map_err(said)?;
            if now.ended && !ended {
                bench.acquirer.playback_ended();
            }
            ended |= now.ended;
            taken.progress.push(now);
        }
    }
    Ok(taken)
}

/// One run on `bench` from its start to its end.
fn whole_run(
    bench: &mut Bench,
    playback: Option<Playback>,
    run: &RunPlan,
) -> Result<Taken, String> {
    let playing = Playing::of(playback.as_ref());
    begin(bench, playback, run)?;
    let taken = take(bench, playing, |_| false)?;
    bench.player.stop();
    bench.acquirer.stop();
    match taken.over {
        true => Ok(taken),
        false => Err(format!(
            "expected an end, found none after {MOST_CHUNKS} chunks"
        )),
    }
}

/// A usual run on a bench, all of it.
fn usual(bench: &mut Bench, subject: &Subject) -> Result<Taken, String> {
    whole_run(
        bench,
        playback(subject),
        &until(subject, Until::Duration(DURATION)),
    )
}

/// The same in two runs.
fn same(one: &Taken, other: &Taken, what: &str) -> Result<(), String> {
    let (one, other) = (one.channels(), other.channels());
    if one == other {
        return Ok(());
    }
    let apart = one.iter().zip(&other).find_map(|(a, b)| {
        let place = a
            .iter()
            .zip(b)
            .position(|(a, b)| a.to_bits() != b.to_bits());
        place.or((a.len() != b.len()).then_some(a.len().min(b.len())))
    });
    Err(format!(
        "expected the same samples {what}, found others from sample {} on",
        apart.unwrap_or(0)
    ))
}

#[allow(
    clippy::fn_params_excessive_bools,
    reason = "the condition of an assertion"
)]
fn expect(met: bool, expected: impl fmt::Display, found: impl fmt::Display) -> Result<(), String> {
    match met {
        true => Ok(()),
        false => Err(format!("expected {expected}, found {found}")),
    }
}

/// A new handle, as after a stop.
fn renewed(bench: &mut Bench) {
    bench.stop = StopHandle::new();
}
