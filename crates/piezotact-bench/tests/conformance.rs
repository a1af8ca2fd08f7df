//! The contract of a bench: the fake and a measured transfer function keep to it, and one that breaks it is found.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use num_complex::Complex;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Drive, SampleRate, Seconds};
use piezotact::recording::Condition;
use piezotact::run::RunChunk;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact_bench::conformance::{Rule, Subject, of_acquirer, of_bench};
use piezotact_bench::fake::{Breach, FakeScript, Fault, fake};
use piezotact_bench::measured::{MeasuredBench, SensorNoise};
use piezotact_bench::{
    Acquire, AcquireDescription, Bench, DeviceError, Play, PlayDescription, PlayProgress, Playback,
    RunPlan, SensorCalibration, StopHandle, Until,
};

fn subject() -> Subject {
    Subject::with_tone(0.3, SampleRate::new(48_000.0).unwrap()).unwrap()
}

fn scripted(text: &str) -> impl Fn() -> Bench + Send + Sync + 'static {
    let script = FakeScript::from_toml(text).unwrap();
    move || fake(script.clone(), "F01").unwrap()
}

#[test]
fn a_fake_keeps_to_the_contract() {
    for script in [
        "seed = 1",
        "clock_ppm = 50\nchunks_s = [0.013, 0.2, 0.0004, 0.9]",
        "drop_outs = [{ at_s = 0, samples = 3 }, { at_s = 0.3, samples = 25 }, { at_s = 0.7, samples = 5000 }]\n\
         late = [{ at_s = 0.2, by_s = 0.1 }]",
    ] {
        assert_eq!(of_bench(scripted(script), &subject()), [], "{script}");
    }
}

/// A chunk takes 0.9 s of real time, and a stop ends it at once.
#[test]
fn a_fake_in_real_time_is_stopped_while_it_waits() {
    let subject = Subject {
        goes_on_for: Seconds(1.5),
        ..subject()
    };
    let paced = "pace = \"real_time\"\nchunks_s = [0.9]\nlate = [{ at_s = 0.5, by_s = 0.2 }]";
    assert_eq!(of_bench(scripted(paced), &subject), []);
}

/// At fifty times the pace of its clock, so that the tests take seconds.
#[test]
fn a_bench_that_takes_its_time_keeps_to_the_contract() {
    let subject = Subject {
        goes_on_for: Seconds(1.5),
        ..subject()
    };
    for script in ["seed = 1", "drop_outs = [{ at_s = 0.3, samples = 25 }]"] {
        let make = scripted(script);
        let paced = move || make().at_speed(50.0);
        assert_eq!(of_bench(paced, &subject), [], "{script}");
    }
}

#[test]
fn the_input_of_a_fake_keeps_to_the_contract_alone() {
    let make = || fake(FakeScript::default(), "F01").unwrap().acquirer;
    assert_eq!(of_acquirer(make, &subject()), []);
}

#[test]
fn a_measured_transfer_function_keeps_to_the_contract() {
    let rate = SampleRate::new(5_000.0).unwrap();
    let response = (0..513).map(|k| Complex::from_polar(8.0, -0.003 * f64::from(k)));
    let hand = TransferFunction::<Drive, Acceleration>::from_lines(
        response.collect(),
        vec![1.0; 513],
        2_500.0 / 512.0,
        rate,
        Estimator::H1,
        100,
    )
    .unwrap();
    let noise = SensorNoise {
        rms_m_s2: 0.002,
        seed: 7,
    };
    let make = move || {
        let bench = MeasuredBench::new(hand.clone(), "hand.json", noise);
        bench.unwrap().into_bench()
    };
    assert_eq!(of_bench(make, &subject()), []);
}

/// Whatever a bench does that none may do is found, under the rule that it breaks.
#[test]
fn a_bench_that_breaks_the_contract_is_found() {
    for (what, rule, part) in [
        (Breach::TooManySamples, Rule::Stream, "at most a second"),
        (Breach::ChannelMissing, Rule::Described, "3 channels"),
        (Breach::UnequalChannels, Rule::Described, "one length"),
        (Breach::TimeBackwards, Rule::Stream, "device time"),
        (Breach::RepeatedChunk, Rule::Stream, "sample"),
        (Breach::UnreportedGap, Rule::Stream, "device time"),
        (Breach::NotANumber, Rule::Stream, "numbers"),
        (Breach::EndsEarly, Rule::Duration, "samples in 0.777 s"),
        (Breach::NeverEnds, Rule::Duration, "an end"),
    ] {
        let script = FakeScript {
            fault: Some(Fault { what, at_s: 0.25 }),
            ..FakeScript::default()
        };
        // One that is too long does not fit into a run of less than a second.
        let at_s = Fault { what, at_s: 0.25 };
        let make = move || {
            let fault = Some(at_s);
            let script = FakeScript {
                fault,
                ..script.clone()
            };
            let mut bench = fake(script, "F01").unwrap();
            if what == Breach::TooManySamples {
                bench.acquirer = Box::new(Wrong(bench.acquirer, Wrongly::Longer));
            }
            bench
        };
        let findings = of_bench(make, &subject());
        let named = |f: &&piezotact_bench::conformance::Finding| f.rule == rule;
        let found = findings.iter().find(named);
        let found = found.unwrap_or_else(|| panic!("{what:?}: {findings:?}"));
        assert!(found.found.contains(part), "{what:?}: {found}");
    }
}

/// What an input can do wrong beside what is scripted.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wrongly {
    /// Runs of a stated duration are three seconds longer.
    Longer,
    /// It cannot be stopped.
    Deaf,
    /// It needs not be made ready.
    Hasty,
    /// It describes a channel that does not come.
    Boasting,
    /// Every calibration takes its noise further.
    Drifting(u32),
}

struct Wrong(Box<dyn Acquire>, Wrongly);

impl Acquire for Wrong {
    fn describe(&self) -> AcquireDescription {
        let mut described = self.0.describe();
        if self.1 == Wrongly::Boasting {
            described
                .channels
                .push(("more".into(), piezotact::quantity::Unit::Newton));
        }
        described
    }

    fn condition(&self, run: &RunPlan) -> Condition {
        self.0.condition(run)
    }

    fn calibrate(&mut self) -> Result<SensorCalibration, DeviceError> {
        if let Wrongly::Drifting(by) = &mut self.1 {
            *by += 1;
        }
        self.0.calibrate()
    }

    fn ready(&mut self, run: &RunPlan, stop: &StopHandle) -> Result<(), DeviceError> {
        let mut run = run.clone();
        if let (Until::Duration(duration), Wrongly::Longer) = (&mut run.until, self.1) {
            duration.0 += 3.0;
        }
        if let Wrongly::Drifting(by) = self.1 {
            run.label = format!("{} {by}", run.label);
        }
        match self.1 {
            Wrongly::Deaf => self.0.ready(&run, &StopHandle::new()),
            _ => self.0.ready(&run, stop),
        }
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        if self.1 == Wrongly::Hasty {
            let _ready_or_not = self.0.start();
            return Ok(());
        }
        self.0.start()
    }

    fn next_chunk(&mut self) -> Result<Option<RunChunk>, DeviceError> {
        self.0.next_chunk()
    }

    fn playback_ended(&mut self) {
        self.0.playback_ended();
    }

    fn stop(&mut self) {
        self.0.stop();
    }
}

/// An output that says that all was played from the start, and takes any rate.
struct Boaster(Box<dyn Play>);

impl Play for Boaster {
    fn describe(&self) -> PlayDescription {
        self.0.describe()
    }

    fn calibrate(&mut self) -> Result<Option<DriveSetup>, DeviceError> {
        self.0.calibrate()
    }

    fn ready(
        &mut self,
        drive: Playback,
        run: &RunPlan,
        stop: &StopHandle,
    ) -> Result<(), DeviceError> {
        let _at_any_rate = self.0.ready(drive, run, stop);
        Ok(())
    }

    fn start(&mut self) -> Result<(), DeviceError> {
        self.0.start()
    }

    fn progress(&mut self) -> Result<PlayProgress, DeviceError> {
        let progress = self.0.progress()?;
        Ok(PlayProgress {
            ended: true,
            ..progress
        })
    }

    fn stop(&mut self) {
        self.0.stop();
    }
}

#[test]
fn halves_that_break_the_contract_are_found() {
    for (wrongly, rules) in [
        (Wrongly::Longer, vec![Rule::Duration]),
        (
            Wrongly::Deaf,
            vec![Rule::Stopped, Rule::StopFromOutside, Rule::StoppedBefore],
        ),
        (Wrongly::Hasty, vec![Rule::Order]),
        (Wrongly::Boasting, vec![Rule::Described]),
        (Wrongly::Drifting(0), vec![Rule::Calibration]),
    ] {
        let make = move || {
            let bench = fake(FakeScript::default(), "F01").unwrap();
            Bench::new(bench.player, Box::new(Wrong(bench.acquirer, wrongly)))
        };
        let found: Vec<Rule> = of_bench(make, &subject()).iter().map(|f| f.rule).collect();
        assert!(
            rules.iter().all(|rule| found.contains(rule)),
            "{wrongly:?}: {found:?}"
        );
    }
    let make = || {
        let bench = fake(FakeScript::default(), "F01").unwrap();
        Bench::new(Box::new(Boaster(bench.player)), bench.acquirer)
    };
    let found: Vec<Rule> = of_bench(make, &subject()).iter().map(|f| f.rule).collect();
    for rule in [Rule::Rate, Rule::Progress, Rule::PlaybackEnded] {
        assert!(found.contains(&rule), "{rule:?}: {found:?}");
    }
}
