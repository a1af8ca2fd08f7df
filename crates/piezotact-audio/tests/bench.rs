//! The sound device as a bench: the contract that every bench keeps, and what its runs say.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::device::{DeviceDescription, DriveSetup};
use piezotact::quantity::{Degrees, Drive, Newtons, SampleRate, Seconds};
use piezotact::recording::{BenchKind, Recording};
use piezotact::run::Discard;
use piezotact::statistics::random::Random;
use piezotact::{Series, Warning};
use piezotact_audio::{AudioBench, LoopIo};
use piezotact_bench::conformance::{Draws, Rule, Subject, of_bench};
use piezotact_bench::procedure::play_and_record;
use piezotact_bench::{
    Bench, DeviceError, Placement, Play, PlayDescription, PlayProgress, Playback, RunPlan,
    StopHandle, Until,
};

use super::loops::setup_at;

fn bench(looped: &str, rate: SampleRate) -> Bench {
    let setup = setup_at(rate.hz(), looped);
    let mut io = LoopIo::new(&setup, None).unwrap();
    let bench = AudioBench {
        setup,
        calibration: None,
        device: DeviceDescription::drv2667().at_usual_gain(),
        participant: None,
        latency: None,
        twin_seed: None,
        kind: BenchKind::Scripted,
        today: 0,
    };
    bench.open(&mut io).unwrap()
}

fn rate() -> SampleRate {
    SampleRate::new(48_000.0).unwrap()
}

#[test]
fn it_keeps_the_contract_of_a_bench() {
    let subject = Subject {
        draws: Draws::Unseeded,
        ..Subject::with_tone(0.3, rate()).unwrap()
    };
    for looped in ["", "pace = \"real_time\""] {
        let findings = of_bench(move || bench(looped, rate()), &subject);
        let texts: Vec<String> = findings.iter().map(ToString::to_string).collect();
        assert!(texts.is_empty(), "{looped}: {texts:?}");
    }
}

/// An output that no stop reaches, as one that waits for its procedure.
struct Deaf(Box<dyn Play>);

impl Play for Deaf {
    fn describe(&self) -> PlayDescription {
        self.0.describe()
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, DeviceError> {
        self.0.calibrate()
    }

    fn ready(
        &mut self,
        playback: Playback,
        run: &RunPlan,
        _stop: &StopHandle,
    ) -> Result<(), DeviceError> {
        self.0.ready(playback, run, &StopHandle::new())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        self.0.start()
    }

    fn progress(&mut self) -> Result<PlayProgress, DeviceError> {
        self.0.progress()
    }

    fn stop(&mut self) {
        self.0.stop();
    }
}

#[test]
fn an_output_that_no_stop_reaches_is_found() {
    let subject = Subject {
        draws: Draws::Unseeded,
        ..Subject::with_tone(0.3, rate()).unwrap()
    };
    let deaf = || {
        let bench = bench("pace = \"real_time\"", rate());
        Bench::new(Box::new(Deaf(bench.player)), bench.acquirer)
    };
    let found: Vec<Rule> = of_bench(deaf, &subject).iter().map(|f| f.rule).collect();
    assert!(found.contains(&Rule::OutputStops), "{found:?}");
}

fn run(looped: &str) -> Recording {
    let mut random = Random::stream(1, 0, "drive");
    let samples = (0..48_000).map(|_| 0.1 * random.normal()).collect();
    let drive = Series::<Drive>::new(samples, rate()).unwrap();
    recorded_at(looped, &drive)
}

/// What is recorded while `drive` plays at its rate.
pub(super) fn recorded_at(looped: &str, drive: &Series<Drive>) -> Recording {
    let plan = RunPlan {
        label: "run".into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    };
    let mut bench = bench(looped, drive.rate());
    play_and_record(&mut bench, drive, None, &plan, &mut Discard, None).unwrap()
}

pub(super) fn codes(recording: &Recording) -> Vec<String> {
    let warnings = recording.about.warnings.iter();
    let cause = |warning: &Warning| -> Option<String> {
        let mut tags = ["by", "fault", "of"].iter();
        let cause = tags.find_map(|tag| warning.fields.get(*tag)?.as_str())?;
        Some(format!("{}/{cause}", warning.code))
    };
    warnings
        .map(|warning| cause(warning).unwrap_or_else(|| warning.code.clone()))
        .collect()
}

#[test]
fn a_run_without_faults_has_its_onset_and_no_warning_of_the_playback() {
    let recording = run("");
    let codes = codes(&recording);
    assert!(
        !codes.iter().any(|code| code.starts_with("samples_lost")),
        "{codes:?}"
    );
    let onset = recording
        .annotations
        .events
        .iter()
        .find(|event| event.kind == "playback_onset");
    assert!(onset.is_some(), "{:?}", recording.annotations.events);
}

#[test]
fn underruns_stalls_and_silent_parts_stand_in_the_record() {
    for (looped, code, event) in [
        (
            "faults = [{ what = \"underrun\", at_s = 1.2, for_s = 0.01 }]",
            "samples_lost/playback",
            Some("playback_ran_dry"),
        ),
        (
            "faults = [{ what = \"stall\", at_s = 1.2, for_s = 0.1 }]",
            "samples_lost/playback",
            Some("playback_ran_dry"),
        ),
        (
            "faults = [{ what = \"overrun\", at_s = 1.2, for_s = 0.1 }]",
            "samples_lost/device",
            Some("samples_lost"),
        ),
        (
            "noise = 0\nsilent = { of = 170, every = 682 }",
            "samples_lost/silence",
            None,
        ),
    ] {
        let recording = run(looped);
        let codes = codes(&recording);
        assert!(
            codes.iter().any(|found| found == code),
            "{looped}: {codes:?}"
        );
        if let Some(kind) = event {
            let found = recording
                .annotations
                .events
                .iter()
                .any(|event| event.kind == kind);
            assert!(found, "{looped}: {:?}", recording.annotations.events);
        }
    }
}

/// Frames that are lost across the end of a run count up to its end alone; that is no breach of the contract of a bench either.
#[test]
fn seconds_of_frames_lost_before_the_end_of_a_run_are_not_called_a_bug() {
    let mut random = Random::stream(1, 0, "drive");
    let samples = (0..96_000).map(|_| 0.1 * random.normal()).collect();
    let drive = Series::<Drive>::new(samples, rate()).unwrap();
    let run = |until, at_s: f64, for_s: f64| {
        let looped = format!("faults = [{{ what = \"overrun\", at_s = {at_s}, for_s = {for_s} }}]");
        let plan = RunPlan {
            label: "run".into(),
            load: Some(Newtons(0.2)),
            angle: Degrees(20.0),
            placement: Placement::New,
            until,
        };
        let mut bench = bench(&looped, rate());
        play_and_record(&mut bench, &drive, None, &plan, &mut Discard, None)
    };
    let two_s = Until::Duration(Seconds(2.5));
    for (until, at_s) in [
        (Until::PlaybackEnded, 1.5),
        (Until::PlaybackEnded, 3.0),
        (two_s, 1.5),
        (two_s, 2.5),
    ] {
        let said = run(until, at_s, 5.625).unwrap_err().to_string();
        assert!(
            said.contains("lost 270000 samples (5.62 s)") && said.contains("close other programs"),
            "{until:?} at {at_s} s: {said}"
        );
        // What is lost within a second of the end is a gap.
        let recorded = run(until, at_s, 1.5).unwrap();
        assert!(
            codes(&recorded).contains(&"samples_lost/device".into()),
            "{at_s}"
        );
    }
}
