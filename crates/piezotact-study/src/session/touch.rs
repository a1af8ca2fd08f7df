//! What the sensors of a bench record while a real sample is touched.

use crate::session::RunError;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use piezotact::quantity::{Acceleration, Drive, Quantity as _};
use piezotact::recording::{Recording, StartTime, Touch};
use piezotact::roles::Roles;
use piezotact::run::{Ended, Judged, RunCollector, RunDocument, RunEnd, RunStart, Sink};
use piezotact::run::{RunChunk, SinkError};
use piezotact::stroke::{Expected, Judging, SegmentError, segment};
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, acquire};
use piezotact_bench::{Acquire, Paced, Placement, ProcedureError, RunPlan, Until};
use piezotact_people::campaign::session::{Evidence, TouchRecording, sha_of_samples};

use crate::session::{BenchStimulator, Heard, Played, Stimulator, StopHandle, TouchEnd};

/// How long it is waited for the sensors, so that the first stroke is recorded too.
const SENSORS_READY: Duration = Duration::from_secs(3);
/// As many samples of all channels are kept in memory, 240 MB: five minutes of two channels at 48 kHz. A longer part is recorded, and neither
/// counted nor summed up.
const MOST_COUNTED: usize = 30_000_000;

/// With what one touch is recorded, and where.
pub struct TouchKeeper {
    /// What acquires it; none for the sensors of the bench, at their own pace.
    pub acquirer: Option<Box<dyn Acquire>>,
    pub sink: Box<dyn Sink + Send>,
    /// The recording, re the folder of the session.
    pub journal: String,
    /// The time of day at which it begins; none where nothing has one.
    pub started_at: Option<StartTime>,
}

impl fmt::Debug for TouchKeeper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TouchKeeper")
            .field("journal", &self.journal)
            .finish_non_exhaustive()
    }
}

/// Makes the keeper of each touch, or says why it cannot be recorded.
pub type KeeperOf<'a> = dyn FnMut(&Played<'_>) -> Result<TouchKeeper, String> + 'a;

/// A bench that plays textures and, while a real sample is touched, records what its sensors acquire. It does one at a time.
pub struct TouchBench<'a> {
    bench: BenchStimulator<'a>,
    participant: String,
    keeper: Box<KeeperOf<'a>>,
    listening: Option<Listening>,
}

impl fmt::Debug for TouchBench<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TouchBench")
            .field("bench", &self.bench)
            .field("is_listening", &self.listening.is_some())
            .finish_non_exhaustive()
    }
}

impl<'a> TouchBench<'a> {
    /// `bench`, which records what `participant` touches as `keeper` says.
    #[must_use]
    pub fn new(bench: BenchStimulator<'a>, participant: &str, keeper: Box<KeeperOf<'a>>) -> Self {
        Self {
            bench,
            participant: participant.to_owned(),
            keeper,
            listening: None,
        }
    }
}

impl Stimulator for TouchBench<'_> {
    fn check(&self, stimulus: &str) -> Result<(), RunError> {
        self.bench.check(stimulus)
    }

    fn play(&mut self, played: Played<'_>, stop: &StopHandle) -> Result<Evidence, RunError> {
        self.bench.play(played, stop)
    }

    fn listen(&mut self, touched: Played<'_>, stop: &StopHandle) -> Result<bool, String> {
        let _of_another_trial = self.heard(TouchEnd::Cut);
        let mut keeper = (self.keeper)(&touched)?;
        let sensors = match keeper.acquirer.take() {
            Some(own) => Sensors::Own(own),
            // Nothing happens faster than a person touches.
            None => Sensors::OfBench(Paced::real_time(self.bench.bench.take_acquirer())),
        };
        let run = RunPlan {
            label: format!(
                "{}, attempt {}, part {}",
                touched.trial, touched.attempt, touched.play
            ),
            load: None,
            angle: self.bench.angle,
            placement: Placement::New,
            until: Until::Stopped,
        };
        let heard = Arc::new(Gathered::default());
        let sink = OfTouch {
            inner: keeper.sink,
            sample: touched.stimulus.to_owned(),
            participant: self.participant.clone(),
            started_at: keeper.started_at,
            silent: None,
            gathered: Arc::clone(&heard),
            samples: 0,
            most: 0,
            began: None,
        };
        let begun = Listening::begin(sensors, run, stop, sink);
        let (thread, stop) = begun.map_err(|error| error.to_string())?;
        self.listening = Some(Listening {
            journal: keeper.journal,
            gathered: heard,
            thread: Some(thread),
            stop,
        });
        Ok(true)
    }

    fn strokes(&self) -> Option<u32> {
        let listening = self.listening.as_ref()?;
        // What is not recorded any more does not become complete.
        if listening.stop.is_stopped() || listening.gathered.is_failed.load(Ordering::SeqCst) {
            return None;
        }
        strokes_in(&listening.gathered.recording()?)
    }

    fn heard(&mut self, end: TouchEnd) -> Option<Heard> {
        let mut listening = self.listening.take()?;
        let (sensors, done) = listening.end(end)?;
        if let Sensors::OfBench(paced) = sensors {
            self.bench.bench.acquirer = paced.into_inner();
        }
        let was_stopped = listening.gathered.is_cut.load(Ordering::SeqCst);
        let failed = match done {
            Err(error) => Some(error.to_string()),
            Ok(()) if was_stopped && end == TouchEnd::Done => {
                Some("it was stopped before the trial was confirmed".to_owned())
            }
            Ok(()) => None,
        };
        let recording = listening.gathered.recording();
        let response = recording.as_ref().and_then(|recording| {
            let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL));
            response
                .ok()
                .map(|response| sha_of_samples(response.samples()))
        });
        let samples = listening.gathered.samples.load(Ordering::SeqCst);
        Some(Heard {
            recording: samples.then(|| TouchRecording {
                journal: listening.journal.clone(),
                recorded: response,
            }),
            strokes: recording.as_ref().and_then(strokes_in),
            failed,
        })
    }
}

/// The strokes in `recording`, by its force or motion; none where neither was recorded, or they cannot be cut.
fn strokes_in(recording: &Recording) -> Option<u32> {
    let (roles, _) = Roles::guess(recording);
    if roles.normal_force.is_none() && roles.motion.is_none() {
        return None;
    }
    let (recording, measured) = roles.on_one_clock(recording.clone()).ok()?;
    let expected = Expected {
        load_n: None,
        speed_m_s: None,
        judging: Judging::Sliding,
    };
    match segment(&recording, &roles, expected) {
        Ok(found) => u32::try_from(found.within(&measured).strokes.len()).ok(),
        Err(SegmentError::TooShort { .. }) => Some(0),
        Err(_cannot_be_cut) => None,
    }
}

/// What acquires a touch.
enum Sensors {
    Own(Box<dyn Acquire>),
    /// They go back to the bench when it is over.
    OfBench(Paced),
}

type Done = (Sensors, Result<(), ProcedureError>);

/// A touch that is being recorded, on a thread of its own.
struct Listening {
    journal: String,
    stop: StopHandle,
    gathered: Arc<Gathered>,
    thread: Option<JoinHandle<Done>>,
}

impl Listening {
    /// Begins the run, and waits until it began.
    fn begin(
        mut sensors: Sensors,
        run: RunPlan,
        stop: &StopHandle,
        mut sink: OfTouch,
    ) -> std::io::Result<(JoinHandle<Done>, StopHandle)> {
        let (began, begins) = channel();
        sink.began = Some(began);
        let (stop, ends) = (stop.clone(), stop.clone());
        let thread = std::thread::Builder::new().spawn(move || {
            let acquirer: &mut dyn Acquire = match &mut sensors {
                Sensors::Own(own) => own.as_mut(),
                Sensors::OfBench(paced) => paced,
            };
            let done = acquire(acquirer, &run, &ends, &mut sink);
            (sensors, done.map(|_| ()))
        })?;
        // What failed has begun, too; what is slow is recorded from when it begins.
        let _slow = begins.recv_timeout(SENSORS_READY);
        Ok((thread, stop))
    }

    /// Ends it; none where its thread broke down.
    fn end(&mut self, end: TouchEnd) -> Option<Done> {
        let gathered = &self.gathered;
        gathered
            .is_cut
            .store(self.stop.is_stopped(), Ordering::SeqCst);
        let is_done = end == TouchEnd::Done;
        gathered.is_done.store(is_done, Ordering::SeqCst);
        self.stop.stop();
        self.thread.take()?.join().ok()
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        let _ended = self.end(TouchEnd::Cut);
    }
}

/// What was recorded until now.
#[derive(Default)]
struct Gathered {
    /// None where it was too long to be kept in memory.
    documents: Mutex<Option<RunCollector>>,
    /// Whether any sample was recorded.
    samples: AtomicBool,
    /// Whether it was stopped before the trial was done.
    is_cut: AtomicBool,
    /// Whether it ends as it is to end.
    is_done: AtomicBool,
    /// Whether the sensors failed.
    is_failed: AtomicBool,
}

impl Gathered {
    fn documents(&self) -> MutexGuard<'_, Option<RunCollector>> {
        self.documents
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn recording(&self) -> Option<Recording> {
        let documents = self.documents().clone();
        documents?.recording().ok()
    }
}

/// Keeps a run as the recording of a touch: its condition is that of the touch, and the loopback, in which nothing is played, is left out.
struct OfTouch {
    inner: Box<dyn Sink + Send>,
    sample: String,
    participant: String,
    started_at: Option<StartTime>,
    /// The channel of the loopback.
    silent: Option<usize>,
    gathered: Arc<Gathered>,
    samples: usize,
    /// The most samples that are kept in memory.
    most: usize,
    began: Option<Sender<()>>,
}

impl OfTouch {
    fn start(&mut self, start: &RunStart) -> RunDocument {
        let mut start = start.clone();
        let condition = &mut start.about.condition;
        condition.sample = Some(self.sample.clone());
        condition.touch = Some(Touch::Active);
        let participant = self.participant.clone();
        condition.participant.get_or_insert(participant);
        // The participant chooses them.
        (condition.load_n, condition.angle_deg) = (None, None);
        start.annotations.started_at = self.started_at.take();
        let loopback = start
            .channels
            .iter()
            .position(|(_, unit)| *unit == Drive::UNIT);
        self.silent = loopback.filter(|_| start.channels.len() > 1);
        if let Some(at) = self.silent {
            start.channels.remove(at);
        }
        self.most = MOST_COUNTED / start.channels.len().max(1);
        *self.gathered.documents() = Some(RunCollector::default());
        RunDocument::Start(Box::new(start))
    }

    fn chunk(&mut self, chunk: &RunChunk) -> RunDocument {
        let mut chunk = chunk.clone();
        if let Some(at) = self.silent.filter(|at| *at < chunk.channels.len()) {
            chunk.channels.remove(at);
        }
        self.samples += chunk.len();
        if self.samples > 0 {
            self.gathered.samples.store(true, Ordering::SeqCst);
        }
        if self.samples > self.most {
            *self.gathered.documents() = None;
        }
        RunDocument::Chunk(chunk)
    }

    fn end(&self, end: &RunEnd) -> RunDocument {
        let mut end = end.clone();
        if matches!(end.ended, Ended::Failed { .. }) {
            self.gathered.is_failed.store(true, Ordering::SeqCst);
        }
        if end.ended == Ended::Stopped
            && self.gathered.is_done.load(Ordering::SeqCst)
            && !self.gathered.is_cut.load(Ordering::SeqCst)
        {
            // To be stopped is how it was to end.
            end.ended = Ended::Completed;
        }
        RunDocument::End(Box::new(end))
    }
}

impl Sink for OfTouch {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        let document = match document {
            RunDocument::Start(start) => self.start(start),
            RunDocument::Chunk(chunk) => self.chunk(chunk),
            RunDocument::End(end) => self.end(end),
            other => other.clone(),
        };
        // Stored before it is counted.
        let judged = self.inner.take(&document);
        if let Some(gathered) = self.gathered.documents().as_mut() {
            let _takes_all = gathered.take(&document);
        }
        if matches!(document, RunDocument::Chunk(_) | RunDocument::End(_))
            && let Some(began) = self.began.take()
        {
            let _nobody_waits = began.send(());
        }
        judged
    }
}
