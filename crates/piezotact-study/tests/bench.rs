//! Prepared drives on benches whose answer is known.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_study::session::RunError;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::rc::Rc;

use num_complex::Complex;
use piezotact::Series;
use piezotact::criterion::Outcome;
use piezotact::quantity::{
    Acceleration, Band, Degrees, Drive, Hertz, Newtons, Quantity as _, SampleRate,
};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::run::{Judged, RunDocument, RunStart, Sink, SinkError};
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact_bench::Bench;
use piezotact_bench::fake::{FakeScript, fake};
use piezotact_bench::measured::{MeasuredBench, SensorNoise};
use piezotact_bench::procedure::RunKeeper;
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::Playing;
use piezotact_people::campaign::session::Evidence;
use piezotact_study::session::{
    BenchStimulator, Played, PreparedDrive, Stimulator as _, StopHandle, TouchBench, TouchEnd,
    TouchKeeper,
};

const OUTPUT_HZ: f64 = 48_000.0;
const INPUT_HZ: f64 = 5_000.0;
const DELAY_S: f64 = 0.6e-3;
/// The onset after the start of the run on the measured bench, which begins to play 0.2 s after it began to acquire.
const ONSET_S: f64 = 0.2 + DELAY_S;
/// m/s² per full scale.
const GAIN: f64 = 10.0;
const STROKE_S: f64 = 0.8;

fn band() -> Band {
    Band::new(Hertz(40.0), Hertz(600.0)).unwrap()
}

/// Tones in the band with no common period, faded in and out, at `rate_hz`.
fn stroke(amplitude: f64, rate_hz: f64) -> Vec<f64> {
    let count = (STROKE_S * rate_hz).round() as usize;
    let sample = |i: usize| {
        let t_s = i as f64 / rate_hz;
        let fade = ((t_s.min(STROKE_S - t_s)) / 0.05).clamp(0.0, 1.0);
        let tone = |k: usize| {
            let k = k as f64;
            (TAU * (43.0 + 9.7 * k + 0.13 * k * k) * t_s + 2.1 * k * k).sin()
        };
        let tones: f64 = (0..38).map(tone).sum();
        amplitude * (0.5 - 0.5 * (TAU / 2.0 * fade).cos()) * tones / 38.0
    };
    (0..count).map(sample).collect()
}

fn rate(hz: f64) -> SampleRate {
    SampleRate::new(hz).unwrap()
}

/// A drive whose target is what a device of the gain [`GAIN`] makes of it.
fn prepared(verified: Outcome) -> PreparedDrive {
    let wanted = stroke(GAIN, INPUT_HZ);
    let channel = Channel {
        name: "target".to_owned(),
        unit: Acceleration::UNIT,
        samples: wanted.clone(),
    };
    let target = Recording::new(
        vec![channel],
        rate(INPUT_HZ),
        Condition::default(),
        Provenance::default(),
    );
    PreparedDrive {
        sha: Sha::of(b"the drive's file"),
        drive: Series::new(stroke(1.0, OUTPUT_HZ), rate(OUTPUT_HZ)).unwrap(),
        setup: None,
        rendering: None,
        target: target.unwrap(),
        texture: Series::new(wanted, rate(INPUT_HZ)).unwrap(),
        verified,
    }
}

/// A device that answers `gain` at all frequencies, [`DELAY_S`] late.
fn flat(gain: f64) -> Bench {
    let lines = 1_001;
    let resolution_hz = INPUT_HZ / 2.0 / (lines - 1) as f64;
    let late = |k: usize| Complex::from_polar(gain, -TAU * k as f64 * resolution_hz * DELAY_S);
    let response = (0..lines).map(late).collect();
    let mut function = TransferFunction::<Drive, Acceleration>::from_lines(
        response,
        vec![1.0; lines],
        resolution_hz,
        rate(INPUT_HZ),
        Estimator::H1,
        100,
    )
    .unwrap();
    function.about.condition.load_n = Some(Newtons(0.4));
    function.about.condition.angle_deg = Some(Degrees(30.0));
    let noise = SensorNoise {
        rms_m_s2: SensorNoise::USUAL_RMS_M_S2,
        seed: 1,
    };
    MeasuredBench::new(function, "flat.json", noise)
        .unwrap()
        .into_bench()
}

type Labels = Rc<RefCell<Vec<(String, u64)>>>;

/// Keeps the labels of runs with the number of their samples.
struct Kept(Labels);

struct Counting<'a>(&'a Labels, String);

impl RunKeeper for Kept {
    fn sink(&mut self, start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        Ok(Box::new(Counting(&self.0, start.label.clone())))
    }
}

impl Sink for Counting<'_> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        if let RunDocument::End(end) = document {
            self.0.borrow_mut().push((self.1.clone(), end.samples));
        }
        Ok(None)
    }
}

fn stimulator(
    bench: Bench,
    verified: Outcome,
    playing: Playing,
    kept: &Labels,
) -> BenchStimulator<'static> {
    let kept = Rc::clone(kept);
    BenchStimulator {
        bench,
        drives: BTreeMap::from([("S8".to_owned(), prepared(verified))]),
        playing,
        band: band(),
        load: Some(Newtons(0.4)),
        angle: Degrees(30.0),
        journal: Box::new(move |played, _| {
            let name = format!("{}-{}", played.trial, played.play);
            (Box::new(Kept(Rc::clone(&kept))), Some(name))
        }),
    }
}

const PLAYED: Played<'static> = Played {
    trial: "triplets.task3.A",
    attempt: 2,
    element: 0,
    play: 3,
    stimulus: "S8",
};

fn on(bench: Bench, verified: Outcome, playing: Playing) -> (Evidence, Vec<(String, u64)>) {
    let kept = Labels::default();
    let mut stimulator = stimulator(bench, verified, playing, &kept);
    let evidence = stimulator.play(PLAYED, &StopHandle::new()).unwrap();
    drop(stimulator);
    (evidence, kept.take())
}

#[test]
fn a_drive_on_the_device_it_was_made_for_reaches_its_target() {
    let (evidence, runs) = on(flat(GAIN), Outcome::Met, Playing::Once);
    assert_eq!(evidence.drive, Sha::of(b"the drive's file"));
    assert_eq!((evidence.stimulus.as_str(), evidence.strokes), ("S8", 1));
    assert_eq!(evidence.journal.as_deref(), Some("triplets.task3.A-3"));
    // The noise of the sensor is 50 dB below the target, and resampling flat in the band.
    let level_db = evidence.level_re_target_db.unwrap();
    assert!(level_db.abs() < 0.1, "{level_db} dB");
    // A hundredth of a sample at 5 kHz: the noise moves the best delay by less.
    let onset_s = evidence.onset_s.unwrap();
    let samples = (onset_s - ONSET_S) * INPUT_HZ;
    assert!(samples.abs() < 0.05, "{onset_s} s");
    let uncertainty_s = evidence.onset_uncertainty_s.unwrap();
    assert!((onset_s - ONSET_S).abs() < uncertainty_s && uncertainty_s <= 1.0 / INPUT_HZ);
    assert_eq!(evidence.reached, Outcome::Met, "{:?}", evidence.criteria);
    assert!(!evidence.missed());
    assert!(
        evidence.criteria.contains_key("level"),
        "{:?}",
        evidence.criteria
    );
    assert_eq!(runs.len(), 1);
    assert_eq!(runs[0].0, "triplets.task3.A, attempt 2, element 1, play 3");
    // The same playing of a drive that had not passed.
    for verified in [Outcome::NotMet, Outcome::NotDecided] {
        let (evidence, _) = on(flat(GAIN), verified, Playing::Once);
        assert_eq!(
            (evidence.verified, evidence.reached),
            (verified, Outcome::Met)
        );
        assert!(evidence.missed());
    }
}

#[test]
fn a_device_that_answers_6_db_lower_misses_it() {
    let (evidence, _) = on(flat(GAIN / 2.0), Outcome::Met, Playing::Once);
    let level_db = evidence.level_re_target_db.unwrap();
    assert!((level_db + 6.02).abs() < 0.1, "{level_db} dB");
    assert_eq!(evidence.reached, Outcome::NotMet, "{:?}", evidence.criteria);
    assert_eq!(evidence.criteria["level"], Outcome::NotMet);
    assert!(evidence.missed());
}

/// One bench plays and records touches in turn: a touch ends before anything is played, and leaves the bench as it was.
#[test]
fn a_bench_plays_after_a_touch_and_never_beside_it() {
    let kept = Labels::default();
    let inner = stimulator(flat(GAIN), Outcome::Met, Playing::Once, &kept);
    let keeper = Box::new(|touched: &Played<'_>| {
        Ok(TouchKeeper {
            acquirer: None,
            sink: Box::new(piezotact::run::Discard),
            journal: touched.trial.to_owned(),
            started_at: None,
        })
    });
    let mut bench = TouchBench::new(inner, "P01", keeper);
    assert_eq!(bench.heard(TouchEnd::Done), None);
    for _ in 0..3 {
        assert_eq!(bench.listen(PLAYED, &StopHandle::new()), Ok(true));
        let beside = bench.play(PLAYED, &StopHandle::new());
        let Err(RunError::Device(said)) = &beside else {
            panic!("{beside:?}");
        };
        assert!(said.contains("still acquire"), "{said}");
        std::thread::sleep(std::time::Duration::from_millis(200));
        let heard = bench.heard(TouchEnd::Done).unwrap();
        assert_eq!(heard.failed, None);
        // A sensor of vibration alone counts nothing.
        assert_eq!(heard.strokes, None);
        assert!(heard.recording.unwrap().recorded.is_some());
        let begun = std::time::Instant::now();
        let played = bench.play(PLAYED, &StopHandle::new()).unwrap();
        assert_eq!(played.reached, Outcome::Met);
        let took = begun.elapsed();
        assert!(took < std::time::Duration::from_secs(30), "{took:?}");
    }
    assert_eq!(kept.borrow().len(), 3);
}

#[test]
fn strokes_fill_the_duration_to_the_sample() {
    // With strokes of 0.8 s.
    for (pause_s, duration_s, strokes) in [
        (0.5, 30.0, 23),
        // Exactly two strokes and a pause: (1.9 + 0.3) / (0.8 + 0.3) is less than 2 in floating point.
        (0.3, 1.9, 2),
        (0.4, 3.2, 3),
        (0.3, 1.8999, 1),
        (0.0, 4.0, 5),
        // One at least.
        (0.5, 0.1, 1),
    ] {
        let playing = Playing::Repeated {
            pause_s,
            duration_s,
        };
        let (evidence, runs) = on(flat(GAIN), Outcome::Met, playing);
        assert_eq!(evidence.strokes, strokes, "{pause_s} {duration_s}");
        let strokes = f64::from(strokes);
        let length_s = strokes * STROKE_S + (strokes - 1.0) * pause_s;
        let found_s = runs[0].1 as f64 / INPUT_HZ;
        // The bench begins earlier, and lets the response die away.
        assert!(
            (0.0..1.0).contains(&(found_s - length_s)),
            "{pause_s} {duration_s}: {found_s} s of {length_s} s"
        );
        let level_db = evidence.level_re_target_db.unwrap();
        assert!(
            level_db.abs() < 0.1,
            "{pause_s} {duration_s}: {level_db} dB"
        );
        let onset_s = evidence.onset_s.unwrap();
        assert!((onset_s - ONSET_S).abs() < 0.1 / INPUT_HZ, "{onset_s} s");
    }
}

/// A bench whose output runs dry in one of three strokes: the participant felt something else, and what was recorded of it is kept.
#[test]
fn a_playing_that_was_interrupted_in_any_stroke_makes_its_trial_void() {
    let playing = Playing::Repeated {
        pause_s: 0.2,
        duration_s: 2.8,
    };
    let with = |script: &str, kept: &Labels| {
        let script = FakeScript::from_toml(&format!(
            "device = {{ gain_m_s2 = {GAIN}, resonance_hz = 1, delay_s = 0.001, noise_m_s2 = 0.002 }}\n{script}"
        ));
        let bench = fake(script.unwrap(), "P01").unwrap();
        stimulator(bench, Outcome::Met, playing, kept).play(PLAYED, &StopHandle::new())
    };
    let whole = with("", &Labels::default()).unwrap();
    assert_eq!(whole.strokes, 3);
    assert!(!whole.missed(), "{whole:?}");
    for at_s in [0.3, 2.3] {
        let kept = Labels::default();
        let underrun = format!("underruns = [{{ at_s = {at_s}, samples = 9600 }}]");
        let Err(RunError::Device(said)) = with(&underrun, &kept) else {
            panic!("a playing that was interrupted at {at_s} s counts");
        };
        assert!(said.contains("interrupted 1 time"), "{said}");
        assert_eq!(kept.borrow().len(), 1);
    }
    // What the fake says of force, and of its delay after a lead of 50 ms.
    let force_n = whole.normal_force_n.unwrap();
    assert!((force_n - 0.4).abs() < 0.001, "{force_n} N");
    let onset_s = whole.onset_s.unwrap();
    assert!((onset_s - 0.051).abs() < 1.0 / INPUT_HZ, "{onset_s} s");
}

#[test]
fn a_lost_device_and_a_missing_drive_are_said() {
    let kept = Labels::default();
    let script = FakeScript::from_toml("lost = { half = \"input\", after_s = 0.4 }").unwrap();
    let bench = fake(script, "P01").unwrap();
    let mut stimulator = stimulator(bench, Outcome::Met, Playing::Once, &kept);
    let missing = Played {
        stimulus: "S9",
        ..PLAYED
    };
    let none = |refused: Option<RunError>| matches!(refused, Some(RunError::NoDrive { stimulus }) if stimulus == "S9");
    assert!(none(stimulator.check("S9").err()));
    assert!(stimulator.check("S8").is_ok());
    assert!(none(stimulator.play(missing, &StopHandle::new()).err()));
    assert!(kept.borrow().is_empty(), "nothing was played");
    let lost = stimulator.play(PLAYED, &StopHandle::new());
    assert!(matches!(lost, Err(RunError::Device(_))), "{lost:?}");
    // Its run is kept as far as it went.
    assert_eq!(kept.borrow().len(), 1);
}
