//! Trials of touch on a bench with sensors: what is recorded, how strokes are counted, and what ends it.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::path::Path;
use std::rc::Rc;
use std::time::Duration;

use piezotact::quantity::{Band, Degrees, Hertz};
use piezotact::recording::Touch;
use piezotact::run::{Ended, RunWarning};
use piezotact_bench::fake::{FakeScript, fake};
use piezotact_dataset::{JournalSink, ReadOptions, read_recording};
use piezotact_people::campaign::protocol::Playing;
use piezotact_people::campaign::session::{
    Command, Event, Evidence, Refusal, Stage, Step, TouchRecord, TouchRecording,
};
use piezotact_people::campaign::store::{MemoryStore, Purpose};
use piezotact_study::session::{
    BenchStimulator, Given, Heard, Outside, PlayStop, Played, RunError, Runner, Stimulator,
    Stimuli, StopHandle, TouchBench, TouchEnd, TouchKeeper, events_of,
};

use crate::support::{START_MS, done, planned, present, until_presenting};

/// A part of a touch, and whether it was done; none while it goes on.
type Recorded = (String, Option<bool>);

/// Sensors that find as many strokes as a test says.
#[derive(Clone, Default)]
struct Sensors {
    found: Rc<Cell<Option<u32>>>,
    refuses: Rc<Cell<bool>>,
    /// What was recorded: `TRIAL-ATTEMPT-PART`, and whether it was done.
    heard: Rc<RefCell<Vec<Recorded>>>,
    stop: Rc<RefCell<Option<StopHandle>>>,
}

impl Stimulator for Sensors {
    fn check(&self, _stimulus: &str) -> Result<(), RunError> {
        Ok(())
    }

    fn play(&mut self, _played: Played<'_>, _stop: &StopHandle) -> Result<Evidence, RunError> {
        Err(RunError::Device("nothing plays here".to_owned()))
    }

    fn listen(&mut self, touched: Played<'_>, stop: &StopHandle) -> Result<bool, String> {
        if self.refuses.get() {
            return Err("the cable is off".to_owned());
        }
        let name = format!("{}-{}-{}", touched.trial, touched.attempt, touched.play);
        self.heard.borrow_mut().push((name, None));
        *self.stop.borrow_mut() = Some(stop.clone());
        Ok(true)
    }

    fn strokes(&self) -> Option<u32> {
        self.found.get()
    }

    fn heard(&mut self, end: TouchEnd) -> Option<Heard> {
        let mut heard = self.heard.borrow_mut();
        let (name, ended) = heard.last_mut()?;
        *ended = Some(end == TouchEnd::Done);
        Some(Heard {
            recording: Some(TouchRecording {
                journal: name.clone(),
                recorded: None,
            }),
            strokes: self.found.get(),
            failed: None,
        })
    }
}

/// A session of touch with `stimulator`; its confirmed touches, and all of its events.
fn session(
    stimulator: &mut dyn Stimulator,
    act: impl FnOnce(&mut Runner<'_>, &PlayStop),
) -> (Vec<Option<TouchRecord>>, Vec<Event>) {
    let (protocol, plan) = planned("isotropic_triplets", "measurement");
    let mut store = MemoryStore::new();
    let mut now_ms = START_MS;
    let mut now = || {
        now_ms += 10_000;
        now_ms
    };
    let mut salt = || Ok([7; 16]);
    let stop = PlayStop::default();
    let outside = Outside {
        now_ms: &mut now,
        salt: &mut salt,
        stop: stop.clone(),
    };
    let mut runner = Runner::open(
        &mut store,
        (&protocol, &plan),
        Purpose::Volunteer,
        Stimuli::On(stimulator),
        outside,
    )
    .unwrap();
    until_presenting(&mut runner, &plan.trials[0].task);
    act(&mut runner, &stop);
    drop(runner);
    let events = events_of(&store, &plan).unwrap().into_iter();
    let events: Vec<Event> = events.map(|(_, event)| event).collect();
    let touched = events.iter().filter_map(|event| match event {
        Event::Confirmed { touched, .. } => Some(touched.clone()),
        _ => None,
    });
    (touched.collect(), events)
}

#[test]
fn missing_strokes_are_said_once_and_noted() {
    let mut sensors = Sensors::default();
    let (found, heard) = (Rc::clone(&sensors.found), Rc::clone(&sensors.heard));
    let (touched, _) = session(&mut sensors, |runner, _| {
        for strokes in [10, 7] {
            done(runner, present());
            found.set(Some(7));
            let refused = runner.give(Command::Confirm).unwrap_err();
            assert!(
                matches!(&refused, RunError::Refused(Refusal::TooFew { expected, found: 7 }) if expected == "10 strokes"),
                "{refused}"
            );
            // The recording goes on.
            assert_eq!(heard.borrow().last().unwrap().1, None);
            found.set(Some(strokes));
            done(runner, Command::Confirm);
            assert_eq!(heard.borrow().last().unwrap().1, Some(true));
        }
    });
    let strokes = touched.into_iter().map(|one| one.unwrap().strokes);
    assert_eq!(strokes.collect::<Vec<_>>(), [Some(10), Some(7)]);
    assert_eq!(heard.borrow().len(), 2);
}

#[test]
fn a_pause_ends_a_part_and_a_stop_ends_all() {
    let mut sensors = Sensors::default();
    let (found, heard) = (Rc::clone(&sensors.found), Rc::clone(&sensors.heard));
    let stop_of = Rc::clone(&sensors.stop);
    found.set(Some(5));
    let (touched, events) = session(&mut sensors, |runner, stop| {
        done(runner, present());
        // Before the turn of the command.
        assert!(!stop.stop("a pause"), "nothing is played");
        assert!(stop_of.borrow().as_ref().unwrap().is_stopped());
        done(runner, Command::Pause);
        assert_eq!(heard.borrow()[0].1, Some(false));
        done(
            runner,
            Command::Note {
                text: "a cough".to_owned(),
            },
        );
        assert_eq!(heard.borrow().len(), 1, "nothing is recorded in a pause");
        done(runner, Command::GoOn);
        assert!(!stop_of.borrow().as_ref().unwrap().is_stopped());
        done(runner, Command::Confirm);
        // The next trial is void in the middle, and begun again.
        done(runner, present());
        done(
            runner,
            Command::Void {
                why: "the sample fell".to_owned(),
            },
        );
        done(runner, present());
        done(
            runner,
            Command::Stop {
                why: "tired".to_owned(),
            },
        );
        assert_eq!(runner.state().stage(), Stage::Stopped);
    });
    let touched: Vec<TouchRecord> = touched.into_iter().flatten().collect();
    assert_eq!(touched.len(), 1, "{events:?}");
    assert_eq!(touched[0].strokes, Some(10));
    let heard = heard.borrow();
    let ended: Vec<Option<bool>> = heard.iter().map(|(_, ended)| *ended).collect();
    assert_eq!(
        ended,
        [Some(false), Some(true), Some(false), Some(false)],
        "{heard:?}"
    );
    let of_first = touched[0].recordings.iter().map(|one| &one.journal);
    assert!(of_first.eq(heard[..2].iter().map(|(name, _)| name)));
    assert!(heard[0].0.ends_with("-1-1") && heard[1].0.ends_with("-1-2"));
    assert!(heard[2].0.ends_with("-1-1") && heard[3].0.ends_with("-2-1"));
}

#[test]
fn a_touch_without_sensors_is_as_it_was() {
    let mut sensors = Sensors::default();
    sensors.refuses.set(true);
    let (touched, _) = session(&mut sensors, |runner, _| {
        done(runner, present());
        done(runner, Command::Confirm);
    });
    let touched = touched[0].clone().unwrap();
    assert_eq!(touched.not_recorded.as_deref(), Some("the cable is off"));
    assert_eq!((touched.strokes, touched.recordings.len()), (None, 0));
    // The strokes of what neither measures force nor motion are not counted.
    sensors.refuses.set(false);
    let (touched, _) = session(&mut sensors, |runner, _| {
        done(runner, present());
        done(runner, Command::Confirm);
    });
    let touched = touched[0].clone().unwrap();
    assert_eq!((touched.strokes, touched.not_recorded), (None, None));
    // Nothing has sensors.
    let mut tape = crate::support::Tape::default();
    let (touched, _) = session(&mut tape, |runner, _| {
        done(runner, present());
        done(runner, Command::Confirm);
    });
    assert_eq!(touched, [None]);
}

/// A scripted bench that records touches in `folder`.
fn bench(script: &str, folder: &Path) -> TouchBench<'static> {
    let script = FakeScript::from_toml(script).unwrap();
    let stimulator = BenchStimulator {
        bench: fake(script, "F01").unwrap(),
        drives: BTreeMap::new(),
        playing: Playing::Once,
        band: Band::new(Hertz(40.0), Hertz(600.0)).unwrap(),
        load: None,
        angle: Degrees(30.0),
        journal: Box::new(|_, _| (Box::new(piezotact::run::Discard), None)),
    };
    let folder = folder.to_owned();
    let keeper = Box::new(move |touched: &Played<'_>| {
        let name = format!("{}-{}.parquet", touched.attempt, touched.play);
        Ok(TouchKeeper {
            acquirer: None,
            sink: Box::new(JournalSink::new(&folder.join(&name), None)),
            journal: name,
            started_at: None,
        })
    });
    TouchBench::new(stimulator, "P01", keeper)
}

#[test]
fn a_lost_sensor_loses_no_trial() {
    let folder = tempfile::tempdir().unwrap();
    let mut lost = bench(
        "lost = { half = \"input\", after_s = 0.4 }\nchunks_s = [0.1]",
        folder.path(),
    );
    let (touched, events) = session(&mut lost, |runner, _| {
        done(runner, present());
        std::thread::sleep(Duration::from_millis(800));
        done(runner, Command::Confirm);
        // The next one finds no sensor, and is touched all the same.
        done(runner, present());
        done(runner, Command::Confirm);
    });
    for touched in &touched {
        let touched = touched.as_ref().unwrap();
        assert!(touched.not_recorded.is_some(), "{touched:?}");
        assert_eq!(touched.strokes, None);
    }
    assert_eq!(touched.len(), 2, "{events:?}");
    // What came before is kept.
    let kept = &touched[0].as_ref().unwrap().recordings;
    assert_eq!(kept.len(), 1, "{touched:?}");
    let file = folder.path().join(&kept[0].journal);
    let recording = read_recording(&file, &ReadOptions::default());
    let recording = recording.unwrap().recording;
    assert!(
        (0.2..0.5).contains(&recording.duration().0),
        "{recording:?}"
    );
    let about = &recording.about;
    assert_eq!(about.condition.touch, Some(Touch::Active));
    assert!(about.condition.sample.is_some() && about.condition.load_n.is_none());
    let failed = about.warnings.iter().any(|warning| {
        matches!(
            warning.kind(),
            Some(RunWarning::EndedEarly {
                ended: Ended::Failed { .. },
                ..
            })
        )
    });
    assert!(failed, "{:?}", about.warnings);
}

#[test]
fn a_stop_from_another_thread_ends_the_acquisition() {
    let folder = tempfile::tempdir().unwrap();
    let mut whole = bench("chunks_s = [0.1]", folder.path());
    let (touched, _) = session(&mut whole, |runner, stop| {
        done(runner, present());
        std::thread::sleep(Duration::from_millis(300));
        stop.stop("a pause");
        std::thread::sleep(Duration::from_millis(500));
        assert!(matches!(runner.state().step(), Step::Answer { .. }));
        let Given::Done(Event::Confirmed { .. }) = runner.give(Command::Confirm).unwrap() else {
            panic!("it was not confirmed");
        };
        // The bench has its sensors again.
        done(runner, present());
        std::thread::sleep(Duration::from_millis(300));
        while let Step::Answer { .. } = runner.state().step() {
            let _said_once = runner.give(Command::Confirm);
        }
    });
    let first = touched[0].as_ref().unwrap();
    let why = first.not_recorded.as_deref();
    assert!(
        why.is_some_and(|why| why.contains("stopped before")),
        "{first:?}"
    );
    let second = touched[1].as_ref().unwrap();
    assert_eq!(second.not_recorded, None, "{second:?}");
    let read = |record: &TouchRecord| {
        let file = folder.path().join(&record.recordings[0].journal);
        read_recording(&file, &ReadOptions::default())
            .unwrap()
            .recording
    };
    // Nothing was acquired after the stop, also where the trial went on for longer.
    assert!(read(first).duration().0 < 0.7, "{first:?}");
    assert!(read(second).duration().0 > 0.2, "{second:?}");
}
