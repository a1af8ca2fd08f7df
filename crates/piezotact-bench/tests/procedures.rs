//! Every procedure on a fake with two clocks, drop-outs and devices that are lost: it ends in order, keeps what it has, and says what
//! happened.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::cell::RefCell;
use std::time::Duration;

use piezotact::correct::CorrectConfig;
use piezotact::criterion::Outcome;
use piezotact::lineage::Mode;
use piezotact::quantity::{
    Acceleration, Band, Degrees, Drive, Hertz, Newtons, SampleRate, Seconds,
};
use piezotact::recording::{Event, EventValue, LostBy, Recording, RecordingWarning};
use piezotact::render::RenderConfig;
use piezotact::run::{
    Discard, Ended, Judged, RunDocument, RunEnd, RunStart, RunWarning, Sink, SinkError,
};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Estimator, at_rest};
use piezotact::verify::{Measured, VerifyConfig, verify};
use piezotact::{Series, Warning};
use piezotact_bench::fake::{Breach, FakeScript, Fault, fake};
use piezotact_bench::procedure::{
    CharacteriseConfig, ClosedLoopResult, GatePolicy, LoopConfig, LoopEnd, LoopFailure,
    RepeatConfig, RunKeeper, acquire, characterise, closed_loop, play_and_record, repeated,
};
use piezotact_bench::{
    Bench, DeviceError, Excitation, ExcitationConfig, GateConfig, Placement, ProcedureError,
    RunPlan, StopHandle, Until,
};

/// What is kept of one run.
#[derive(Default)]
struct Kept {
    label: String,
    samples: usize,
    judged: usize,
    events: Vec<Event>,
    end: Option<RunEnd>,
}

fn of_playback(warning: &Warning) -> bool {
    matches!(
        warning.kind(),
        Some(RecordingWarning::SamplesLost {
            by: LostBy::Playback { .. }
        })
    )
}

/// Keeps what the documents of every run say.
#[derive(Default)]
struct Keeper(RefCell<Vec<Kept>>);

struct OneOf<'a>(&'a Keeper);

impl RunKeeper for Keeper {
    fn sink(&mut self, _start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        Ok(Box::new(OneOf(self)))
    }
}

impl Sink for OneOf<'_> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        let mut runs = self.0.0.borrow_mut();
        if let RunDocument::Start(start) = document {
            runs.push(Kept {
                label: start.label.clone(),
                ..Kept::default()
            });
        }
        let run = runs.last_mut().unwrap();
        assert!(
            run.end.is_none(),
            "{}: a document behind the end",
            run.label
        );
        match document {
            RunDocument::Start(_) => {}
            RunDocument::Chunk(chunk) => {
                assert_eq!(chunk.first, run.samples as u64, "{}", run.label);
                run.samples += chunk.len();
            }
            RunDocument::Judged(_) => run.judged += 1,
            RunDocument::Event(event) => run.events.push(event.clone()),
            RunDocument::End(end) => {
                assert_eq!(end.samples, run.samples as u64, "{}", run.label);
                run.end = Some(RunEnd::clone(end));
            }
        }
        Ok(None)
    }
}

impl Keeper {
    /// What happened in the last run.
    fn events(&self) -> Vec<Event> {
        self.0.borrow().last().unwrap().events.clone()
    }

    /// How the runs ended, each of which has an end.
    fn ended(&self) -> Vec<Ended> {
        let runs = self.0.borrow();
        runs.iter()
            .map(|run| run.end.clone().unwrap().ended)
            .collect()
    }

    /// The last run: its length in s and its end.
    fn last(&self) -> (f64, RunEnd) {
        let runs = self.0.borrow();
        let last = runs.last().unwrap();
        (last.samples as f64 / 5_000.0, last.end.clone().unwrap())
    }
}

fn bench(script: &str) -> Bench {
    fake(FakeScript::from_toml(script).unwrap(), "F01").unwrap()
}

fn run(label: &str) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}

fn band() -> Band {
    Band::new(Hertz(30.0), Hertz(900.0)).unwrap()
}

fn config(seconds: f64) -> CharacteriseConfig {
    CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: band(),
            duration: Seconds(seconds),
            peak: 0.8,
            seed: 1,
        },
        welch: WelchConfig::hann(1_024),
        estimator: Estimator::H1,
        run: run("characterise"),
    }
}

fn noise(seconds: f64) -> Series<Drive> {
    let rate = SampleRate::new(48_000.0).unwrap();
    piezotact_bench::excitation(&config(seconds).excitation, rate).unwrap()
}

fn played(script: &str, seconds: f64) -> (Result<Recording, ProcedureError>, Keeper) {
    let mut keeper = Keeper::default();
    let mut bench = bench(script);
    let done = play_and_record(
        &mut bench,
        &noise(seconds),
        None,
        &run("play"),
        &mut keeper,
        None,
    );
    (done, keeper)
}

fn lost(warnings: &[Warning]) -> Option<(usize, u64)> {
    warnings.iter().find_map(|warning| match warning.kind() {
        Some(RecordingWarning::SamplesLost {
            by: LostBy::Device { gaps, samples, .. },
        }) => Some((gaps, samples)),
        _ => None,
    })
}

/// Clocks 50 ppm apart are seen where a texture is compared with what came of it, and lost samples do not hide them.
#[test]
fn two_clocks_and_drop_outs_are_said() {
    let (reference, _) = played("device = { noise_m_s2 = 0.0 }", 20.0);
    let target = reference.unwrap().series::<Acceleration>(None).unwrap();
    let (measured, keeper) = played(
        "clock_ppm = 50\nchunks_s = [0.03, 0.2, 0.011]\n\
         drop_outs = [{ at_s = 4, samples = 25 }, { at_s = 11.3, samples = 7 }]\nlate = [{ at_s = 2, by_s = 0.5 }]",
        20.0,
    );
    let measured = measured.unwrap();
    assert_eq!(keeper.ended(), [Ended::Completed]);
    assert_eq!(lost(&measured.about.warnings), Some((2, 32)));
    let losses = &measured.about.provenance.losses;
    assert_eq!((losses.samples, losses.stretches_s.len()), (32, 2));
    assert!((losses.longest().0 - 0.005).abs() < 1e-9, "{losses:?}");
    assert!(losses.playback.is_none() && !losses.is_interrupted);
    let response = measured.series::<Acceleration>(None).unwrap();
    let config = VerifyConfig::over(band(), 5_000.0);
    let v = verify(&target, Measured::alone(&response), &config).unwrap();
    let ppm = v.clock.drift_ppm.unwrap();
    assert!((ppm - 50.0).abs() < 2.0, "{ppm} ppm: {}", v.sentence());
}

#[test]
fn a_lost_device_ends_a_run_and_what_came_before_is_kept() {
    for (script, name) in [
        (
            "lost = { half = \"input\", after_s = 3.25 }",
            "input of the scripted fake no longer answers after 3.25 s",
        ),
        (
            "lost = { half = \"output\", after_s = 3.25 }",
            "output of the scripted fake no longer answers after 3.3",
        ),
        (
            "input_full_after_s = 3.25",
            "the input buffer of the scripted fake overflowed after 3.25 s",
        ),
    ] {
        let (done, keeper) = played(script, 6.0);
        let said = done.unwrap_err().to_string();
        assert!(said.contains(name) && !said.contains('\n'), "{said}");
        let (seconds, end) = keeper.last();
        assert!((3.25..3.35).contains(&seconds), "{script}: {seconds}");
        assert_eq!(end.ended, Ended::Failed { said });
        let early = |d: &Warning| matches!(d.kind(), Some(RunWarning::EndedEarly { .. }));
        let all = end.all_warnings(SampleRate::new(5_000.0).unwrap());
        assert!(all.iter().any(early), "{script}: {all:?}");
    }
}

#[test]
fn an_output_that_runs_dry_is_said() {
    let script = "underruns = [{ at_s = 1, samples = 480 }, { at_s = 2, samples = 96 }]";
    let about = played(script, 3.0).0.unwrap().about;
    let lost = about.provenance.losses.playback.unwrap();
    assert_eq!((lost.underruns, lost.played), (2, lost.expected));
    let said = about.warnings.iter().any(of_playback);
    assert!(said, "{:?}", about.warnings);
}

/// Each break of the contract is named in one sentence, and what came before is kept.
#[test]
fn breaks_of_the_contract_are_named() {
    for (what, part) in [
        (
            Breach::TooManySamples,
            "at most a second of samples in a chunk, found 12500 samples",
        ),
        (Breach::ChannelMissing, "3 channels in every chunk, found 2"),
        (
            Breach::UnequalChannels,
            "as many samples in each channel of a chunk",
        ),
        (
            Breach::TimeBackwards,
            "a device time that does not run backwards from 1.400000 s, found 0.500000 s",
        ),
        (
            Breach::RepeatedChunk,
            "sample 7500 next, after 0 lost ones, found a chunk that begins at sample 7000",
        ),
        (
            Breach::UnreportedGap,
            "or lost samples that are reported, found 1.550000 s",
        ),
        (Breach::NotANumber, "numbers in every channel"),
        (
            Breach::NeverEnds,
            "an end at most 60 s after a drive of 3.00 s",
        ),
        (
            Breach::EndsEarly,
            "the 15000 samples announced with a drive of 3.00 s, found 7500 samples delivered",
        ),
    ] {
        let mut keeper = Keeper::default();
        let script = FakeScript {
            fault: Some(Fault { what, at_s: 1.5 }),
            ..FakeScript::default()
        };
        let mut bench = fake(script, "F01").unwrap();
        let error = play_and_record(
            &mut bench,
            &noise(3.0),
            None,
            &run("play"),
            &mut keeper,
            None,
        );
        let error = error.unwrap_err();
        let named = matches!(error, ProcedureError::Device(DeviceError::Contract { .. }));
        let said = error.to_string();
        assert!(
            named && said.contains(part) && !said.contains('\n'),
            "{what:?}: {said}"
        );
        let (seconds, end) = keeper.last();
        assert_eq!(end.ended, Ended::Failed { said });
        assert!(
            what == Breach::NeverEnds || seconds == 1.5,
            "{what:?}: {seconds}"
        );
    }
}

/// A computer that does not keep up is no fault of a driver: how much was lost, why, what to do; and the run is no measurement.
#[test]
fn seconds_of_lost_samples_end_a_run_with_their_number_and_the_cause() {
    for (script, samples) in [
        ("drop_outs = [{ at_s = 4, samples = 28125 }]", 28_125),
        // Each of them could be filled in.
        (
            "drop_outs = [{ at_s = 4, samples = 4000 }, { at_s = 8, samples = 4000 }, { at_s = 12, samples = 4000 }]",
            12_000,
        ),
    ] {
        let (done, keeper) = played(script, 20.0);
        let error = done.unwrap_err();
        assert!(error.continues());
        let said = error.to_string();
        assert_eq!(keeper.last().1.ended, Ended::Failed { said: said.clone() });
        let lost_s = f64::from(samples) / 5_000.0;
        for part in [
            format!("lost {samples} samples ({lost_s:.2} s) after"),
            "the computer is too busy".into(),
            "real-time priority".into(),
            "close other programs, use larger buffers".into(),
        ] {
            assert!(said.contains(&part), "{part}: {said}");
        }
        assert!(!said.contains("bug"), "{said}");
    }
    let (done, _) = played("drop_outs = [{ at_s = 4, samples = 9000 }]", 20.0);
    assert_eq!(lost(&done.unwrap().about.warnings), Some((1, 9_000)));
}

/// Stops what runs from another thread as soon as its first samples came.
struct StopsAtOnce(StopHandle, Keeper);

struct Stops<'a>(OneOf<'a>, StopHandle);

impl RunKeeper for StopsAtOnce {
    fn sink(&mut self, _start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        Ok(Box::new(Stops(OneOf(&self.1), self.0.clone())))
    }
}

impl Sink for Stops<'_> {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        if let RunDocument::Chunk(_) = document {
            let stop = self.1.clone();
            std::thread::spawn(move || stop.stop());
        }
        self.0.take(document)
    }
}

/// Whatever does not come to an end by itself is ended from another thread: here nothing else would end it within a day.
#[test]
fn a_bench_that_delivers_nothing_is_stopped() {
    for script in [
        "fault = { what = \"delivers_nothing\", at_s = 0.5 }",
        "fault = { what = \"delivers_empty\", at_s = 0.5 }",
        "pace = \"real_time\"\nchunks_s = [0.1]\nlate = [{ at_s = 0.1, by_s = 86400 }]",
    ] {
        let mut bench = bench(&format!("longest_pause_s = 86400\n{script}"));
        let mut keeper = StopsAtOnce(bench.stop.clone(), Keeper::default());
        let drive = noise(2.0);
        let done = play_and_record(&mut bench, &drive, None, &run("play"), &mut keeper, None);
        assert!(
            matches!(done, Err(ProcedureError::Stopped { .. })),
            "{script}: {done:?}"
        );
        assert_eq!(keeper.1.ended(), [Ended::Stopped], "{script}");
        let known = keeper.1.last().1.warnings;
        assert!(!known.iter().any(of_playback), "{script}: {known:?}");
    }
}

/// A device that delivers no more samples ends every procedure by itself, with what was acquired kept.
#[test]
fn a_bench_that_delivers_nothing_is_given_up() {
    for fault in ["delivers_nothing", "delivers_empty"] {
        let script =
            format!("longest_pause_s = 0.05\nfault = {{ what = \"{fault}\", at_s = 0.5 }}");
        let given_up = |done: Result<(), ProcedureError>, keeper: &Keeper| {
            let error = done.unwrap_err();
            assert!(error.continues(), "{error}");
            let said = error.to_string();
            let expected = "no samples for 0.05 s: the scripted fake of a bench (no device and no finger) delivers nothing after 0.50 s; check its cable";
            assert!(said.starts_with(expected) && !said.contains('\n'), "{said}");
            let (seconds, end) = keeper.last();
            assert_eq!(
                (seconds, end.ended),
                (0.5, Ended::Failed { said }),
                "{fault}"
            );
            assert!(
                !end.warnings.iter().any(of_playback),
                "{fault}: {:?}",
                end.warnings
            );
        };
        let (done, keeper) = played(&script, 2.0);
        given_up(done.map(drop), &keeper);
        let keeper = Keeper::default();
        let plan = RunPlan {
            until: Until::Duration(Seconds(2.0)),
            ..run("touch")
        };
        let mut bench = bench(&script);
        let stop = bench.stop.clone();
        let done = acquire(bench.acquirer.as_mut(), &plan, &stop, &mut OneOf(&keeper));
        given_up(done.map(drop), &keeper);
        assert!(!stop.is_stopped(), "another run may follow");
    }
}

#[test]
fn an_acquisition_without_a_drive_ends_in_order() {
    let duration = |until| RunPlan {
        until,
        ..run("touch")
    };
    let taken = |script: &str, until: Until| {
        let mut keeper = Keeper::default();
        let mut bench = bench(script);
        let stop = bench.stop.clone();
        let plan = duration(until);
        if until == Until::Stopped {
            let stop = stop.clone();
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(150));
                stop.stop();
            });
        }
        let start = piezotact_bench::procedure::start_document(bench.acquirer.as_ref(), &plan);
        let done = {
            let mut sink = keeper.sink(&start).unwrap();
            acquire(bench.acquirer.as_mut(), &plan, &stop, sink.as_mut())
        };
        (done, keeper)
    };
    // The last samples of the run are lost: they are filled in, and it is as long as it was to be.
    let gaps =
        "clock_ppm = 50\ndrop_outs = [{ at_s = 1, samples = 10 }, { at_s = 1.999, samples = 100 }]";
    let (done, keeper) = taken(gaps, Until::Duration(Seconds(2.0)));
    assert_eq!(done.unwrap().1, 10_000);
    assert_eq!(lost(&keeper.last().1.warnings), Some((2, 15)));
    // Each stretch is an event as well, with its time and its number of samples.
    let events: Vec<(String, f64, f64)> = keeper
        .events()
        .iter()
        .map(|event| match event.value {
            Some(EventValue::Number(count)) => (event.kind.clone(), event.onset_s.0, count),
            _ => unreachable!("a number of samples"),
        })
        .collect();
    let counts: Vec<f64> = events.iter().map(|(_, _, count)| *count).collect();
    assert_eq!(counts, [10.0, 5.0]);
    assert!(events.iter().all(|(kind, ..)| kind == "samples_lost"));
    assert!((events[0].1 - 1.0).abs() < 0.01, "{events:?}");
    assert_eq!(keeper.ended(), [Ended::Completed]);
    let (done, keeper) = taken(
        "lost = { half = \"input\", after_s = 1.5 }",
        Until::Duration(Seconds(2.0)),
    );
    assert!(
        done.unwrap_err()
            .to_string()
            .contains("input of the scripted fake")
    );
    assert_eq!(keeper.last().0, 1.5);
    let (done, keeper) = taken("pace = \"real_time\"\nchunks_s = [0.05]", Until::Stopped);
    assert!(done.unwrap().1 > 0);
    assert_eq!(keeper.ended(), [Ended::Stopped]);
    let kinds: Vec<String> = keeper.events().into_iter().map(|e| e.kind).collect();
    assert_eq!(kinds, ["stopped"]);
    let early = "fault = { what = \"ends_early\", at_s = 1.5 }";
    let (done, _) = taken(early, Until::Duration(Seconds(2.0)));
    let said = done.unwrap_err().to_string();
    assert!(
        said.contains("samples for 2.00 s") && said.contains("an end after 1.50 s"),
        "{said}"
    );
    let (done, keeper) = taken("seed = 1", Until::PlaybackEnded);
    assert!(
        done.unwrap_err()
            .to_string()
            .contains("there is no playback")
    );
    assert!(keeper.0.borrow().is_empty());
}

#[test]
fn a_characterisation_ends_in_order() {
    let mut keeper = Keeper::default();
    let gaps = "clock_ppm = 50\ndrop_outs = [{ at_s = 2, samples = 5 }]";
    let done = characterise(&mut bench(gaps), &config(8.0), &mut keeper).unwrap();
    assert_eq!(lost(&done.function.about.warnings), Some((1, 5)));
    let clean = characterise(&mut bench("seed = 1"), &config(8.0), &mut keeper).unwrap();
    for (line, _) in clean
        .function
        .lines_in(Band::new(Hertz(60.0), Hertz(800.0)).unwrap())
    {
        let ratio = done.function.response()[line] / clean.function.response()[line];
        assert!((20.0 * ratio.norm().log10()).abs() < 1.0, "{line}: {ratio}");
    }
    assert_eq!(keeper.ended(), [Ended::Completed, Ended::Completed]);
    let lost = "lost = { half = \"output\", after_s = 4 }";
    let error = characterise(&mut bench(lost), &config(8.0), &mut keeper).unwrap_err();
    assert!(error.to_string().contains("output of the scripted fake"));
    assert!(matches!(keeper.ended()[2], Ended::Failed { .. }));
}

#[test]
fn repeats_with_a_gate_end_in_order() {
    let repeats = RepeatConfig {
        repeats: 2,
        attempts: 2,
        gating: GatePolicy::Judged(GateConfig {
            window: Seconds(2.0),
            ..GateConfig::usual()
        }),
    };
    let of = |script: &str| {
        let mut keeper = Keeper::default();
        let mut bench = bench(script);
        let done = repeated(&mut bench, &config(6.0), &repeats, &mut keeper, &mut |_| {});
        (done, keeper)
    };
    let (done, keeper) = of("clock_ppm = 50\ndrop_outs = [{ at_s = 2, samples = 5 }]");
    assert_eq!(done.unwrap().each.len(), 2);
    assert_eq!(keeper.ended(), [Ended::Completed, Ended::Completed]);
    assert!(keeper.0.borrow().iter().all(|run| run.judged >= 3));
    let (done, keeper) = of("device = { force_share = 1.5 }");
    assert!(matches!(done, Err(ProcedureError::RepeatRefused { .. })));
    assert_eq!(keeper.ended(), [Ended::Refused, Ended::Refused]);
    // The second repeat begins 6.35 s after the first.
    let (done, keeper) = of("lost = { half = \"input\", after_s = 9 }");
    let said = done.unwrap_err().to_string();
    assert!(
        said.contains("input of the scripted fake no longer answers after 9.00 s"),
        "{said}"
    );
    assert_eq!(keeper.ended(), [Ended::Completed, Ended::Failed { said }]);
}

fn looped(mut bench: Bench) -> (Result<ClosedLoopResult, ProcedureError>, Keeper) {
    let done = characterise(&mut self::bench("seed = 1"), &config(8.0), &mut Discard).unwrap();
    let rate = SampleRate::new(5_000.0).unwrap();
    let count = 10_000;
    let mut samples = vec![0.0; count];
    for k in 8..160 {
        let (hz, phase) = (5.0 * f64::from(k), f64::from(k * k) * 0.37);
        for (i, sample) in samples.iter_mut().enumerate() {
            *sample += 0.05 * (std::f64::consts::TAU * hz * i as f64 / 5_000.0 + phase).sin();
        }
    }
    let target = Series::<Acceleration>::new(samples, rate).unwrap();
    let band = Band::new(Hertz(60.0), Hertz(700.0)).unwrap();
    let config = LoopConfig {
        render: RenderConfig::over(band, SampleRate::new(48_000.0).unwrap()),
        correct: CorrectConfig::usual(Mode::Texture),
        judged: band,
        iterations: 2,
        force_share: GateConfig::usual().force_share,
        run: run("render"),
    };
    let mut keeper = Keeper::default();
    let function = &done.function;
    let looped = closed_loop(
        &mut bench,
        &target,
        function,
        &config,
        &mut keeper,
        &mut |_| {},
    );
    (looped, keeper)
}

/// The open loop is judged after three runs: silence, and its drive twice.
#[test]
fn a_closed_loop_ends_in_order() {
    let (done, clean) = looped(bench("clock_ppm = 50"));
    let done = done.unwrap();
    assert!(done.confirmed.is_some(), "{:?}", done.end);
    assert_eq!(done.failed, None);
    assert!(clean.ended().iter().all(|ended| *ended == Ended::Completed));
    let runs = clean.0.borrow();
    let judged = runs.iter().take(3).map(|run| run.samples).sum::<usize>();
    let judged_s = judged as f64 / 5_000.0;
    // Samples are lost once: that measurement is made again.
    let gap = "drop_outs = [{ at_s = 5, samples = 25, since = \"opened\" }]";
    let (done, keeper) = looped(bench(gap));
    assert!(done.is_ok());
    let again = |run: &Kept| run.label.contains("attempt 2");
    assert_eq!(keeper.0.borrow().iter().filter(|run| again(run)).count(), 1);
    // In every run: nothing that was measured is believed.
    let (done, _) = looped(bench("drop_outs = [{ at_s = 1, samples = 25 }]"));
    let said = done.unwrap_err().to_string();
    assert!(said.contains("lost 25 samples"), "{said}");
    // Lost before there is a drive that was judged, and after.
    let (done, keeper) = looped(bench("lost = { half = \"input\", after_s = 6 }"));
    assert!(
        done.unwrap_err()
            .to_string()
            .contains("no longer answers after 6.00 s")
    );
    assert!(matches!(keeper.last().1.ended, Ended::Failed { .. }));
    let late = format!(
        "lost = {{ half = \"output\", after_s = {} }}",
        judged_s + 1.0
    );
    let (done, keeper) = looped(bench(&late));
    let done = done.unwrap();
    let LoopEnd::Broken(LoopFailure::Bench { said }) = &done.end else {
        panic!("{:?}", done.end)
    };
    assert!(said.contains("output of the scripted fake"), "{said}");
    assert_eq!(done.failed.as_ref(), Some(said));
    assert_eq!((done.best, done.confirmed.is_some()), (0, false));
    let stopped = |d: &Warning| {
        matches!(
            d.kind(),
            Some(piezotact::correct::LoopWarning::LoopStopped { .. })
        )
    };
    assert!(done.rendered.about.warnings.iter().any(stopped));
    assert!(
        keeper
            .ended()
            .iter()
            .any(|ended| matches!(ended, Ended::Failed { .. }))
    );
}

/// Whoever stops a loop goes on with it later: it does not end as if it were done.
#[test]
fn a_closed_loop_that_is_stopped_says_so() {
    let nothing = "longest_pause_s = 86400\nfault = { what = \"delivers_nothing\", at_s = 2.2 }";
    let bench = bench(nothing);
    let stop = bench.stop.clone();
    let stops = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(300));
        stop.stop();
    });
    let (done, keeper) = looped(bench);
    stops.join().unwrap();
    assert!(
        matches!(done, Err(ProcedureError::Stopped { .. })),
        "{:?}",
        done.err()
    );
    assert_eq!(keeper.ended(), [Ended::Stopped]);
}

/// A knob of a sensor turned by a factor of two is found by the response at rest; what is within its calibration is not accused.
#[test]
fn a_sensor_that_was_turned_up_is_found_by_the_response_at_rest() {
    let measured = |script: &str| {
        let mut bench = bench(script);
        characterise(&mut bench, &config(5.0), &mut Discard)
            .unwrap()
            .function
    };
    let usual = FakeScript::default().device.gain_m_s2;
    let turned = |db: f64| {
        let gain = usual * 10f64.powf(db / 20.0);
        // Another measurement: another noise.
        measured(&format!("seed = 2\ndevice = {{ gain_m_s2 = {gain} }}"))
    };
    let stored = measured("seed = 1");
    for (db, outcome) in [
        (0.0, Outcome::Met),
        (0.5, Outcome::Met),
        (-0.5, Outcome::Met),
        (3.0, Outcome::NotMet),
        (6.0, Outcome::NotMet),
        (-6.0, Outcome::NotMet),
    ] {
        let found = at_rest(&turned(db), &stored, band()).unwrap();
        assert_eq!(found.outcome(), outcome, "{db} dB: {found:?}");
        let level = found.criteria[0].found.unwrap();
        assert!((level - db).abs() < 0.1, "{db} dB: {level}");
        assert!(found.lines > 100, "{}", found.lines);
    }
    // A finger, or a loose sensor, is no knob.
    let moved = measured("device = { resonance_hz = 300.0, damping = 0.05 }");
    let found = at_rest(&moved, &stored, band()).unwrap();
    assert_eq!(found.criteria[1].outcome, Outcome::NotMet, "{found:?}");
    let nothing = Band::new(Hertz(2_000.0), Hertz(2_001.0)).unwrap();
    let found = at_rest(&stored, &stored, nothing).unwrap();
    assert_eq!(found.outcome(), Outcome::NotDecided);
    let mut somebody = stored.clone();
    somebody.about.condition.participant = Some("F02".into());
    assert!(at_rest(&somebody, &stored, band()).is_err());
}
