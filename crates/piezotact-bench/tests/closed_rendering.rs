//! Rendering in a closed loop on the twin, and on a bench with mishaps.
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test fails where it cannot go on, and prints what it measured"
)]

use std::cell::Cell;
use std::rc::Rc;

use piezotact::Doubt;
use piezotact::correct::{CorrectConfig, Mode};
use piezotact::device::AmplifierGain;
use piezotact::quantity::{
    Acceleration, Band, Decibels, Degrees, Drive, Hertz, Newtons, SampleRate, Seconds,
};
use piezotact::render::{Inverse, RenderConfig, RenderError};
use piezotact::series::Series;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact_bench::procedure::{
    CharacteriseConfig, LoopConfig, LoopEnd, Looped, characterise, closed_loop,
};
use piezotact_bench::twin::{Participant, TwinBench, TwinParameters, record_texture};
use piezotact_bench::{
    Acquire, AcquireDescription, Bench, BenchError, Chunk, Excitation, ExcitationConfig, Lying,
    RunPlan, SensorCalibration,
};

fn band() -> Band {
    Band::new(Hertz(20.0), Hertz(1_000.0)).unwrap()
}

fn bench(participant: u64) -> Bench {
    let parameters = TwinParameters::built_in();
    TwinBench::new(
        &parameters,
        Participant::of(participant, 5, &parameters),
        AmplifierGain::B3,
    )
    .into_bench()
}

fn run(label: &str) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        lying: Lying::Anew,
    }
}

fn function(participant: u64) -> TransferFunction<Drive, Acceleration> {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: Band::new(Hertz(2.0), Hertz(1_200.0)).unwrap(),
            duration: Seconds(20.0),
            peak: 0.8,
            seed: 1,
        },
        welch: WelchConfig::hann(2_048),
        estimator: Estimator::H1,
        run: run("characterise"),
    };
    characterise(&mut bench(participant), &config, &mut |_| Ok(()))
        .unwrap()
        .function
}

fn texture() -> Series<Acceleration> {
    let parameters = TwinParameters::built_in();
    let reference = Participant::of(0, 5, &parameters);
    let sample = parameters.sample("S3").unwrap();
    record_texture(&parameters, &reference, sample, 0.03, Seconds(4.0))
        .unwrap()
        .0
}

fn config(mode: Mode) -> LoopConfig {
    LoopConfig {
        render: RenderConfig::over(band(), SampleRate::new(48_000.0).unwrap()),
        correct: CorrectConfig::usual(mode),
        judged: band(),
        iterations: 4,
        force_share: 0.1,
        run: run("render"),
    }
}

fn error_of(looped: &Looped, iteration: usize) -> f64 {
    let v = &looped.iterations[iteration].verification;
    v.error_db_rms_achievable.unwrap_or(v.error_db_rms)
}

/// Both aims: never worse than the open loop, and within 1 dB rms and 3 dB of the target at a level that fits.
#[test]
fn closed_loops_are_no_worse_than_open_ones() {
    let target = texture().amplified(Decibels(-6.0));
    for participant in 1..=3 {
        let function = function(participant);
        for mode in [Mode::Replicate, Mode::Texture] {
            let mut bench = bench(participant);
            let looped =
                closed_loop(&mut bench, &target, &function, &config(mode), &mut |_| {}).unwrap();
            let (open, best) = (error_of(&looped, 0), error_of(&looped, looped.best));
            let v = &looped.iterations[looped.best].verification;
            println!(
                "P{participant} {mode:?}: {open:.2} → {best:.2} dB rms, {:.1} dB at most, r {:.3}",
                v.error_db_max, v.waveform_correlation
            );
            assert!(
                best <= open && best <= 1.0 && v.error_db_max <= 3.0,
                "{open} {best} {}",
                v.error_db_max
            );
            assert!(looped.rendered.headroom.peak <= looped.rendered.headroom.limit + 1e-9);
            assert!(
                looped
                    .rendered
                    .provenance
                    .steps
                    .last()
                    .unwrap()
                    .contains("closed loop")
            );
        }
    }
}

/// What does not fit is said before anything plays, with the level that does; asked to fit, it fits.
#[test]
fn a_level_that_does_not_fit_is_refused_or_turned_down() {
    let (function, target) = (function(1), texture().amplified(Decibels(16.0)));
    let mut loop_config = config(Mode::Texture);
    let refused = closed_loop(&mut bench(1), &target, &function, &loop_config, &mut |_| {
        panic!("it played")
    });
    let Err(BenchError::Render(RenderError::ExceedsFullScale { fits_at, .. })) = refused else {
        panic!("it does not fit")
    };
    assert!((-20.0..0.0).contains(&fits_at.0), "{fits_at:?}");
    loop_config.render.inverse.inverse = Inverse::DriveLimited;
    let looped = closed_loop(&mut bench(1), &target, &function, &loop_config, &mut |_| {}).unwrap();
    let headroom = &looped.rendered.headroom;
    println!(
        "turned down: {:.2} dB rms over what is left, given up {:?}",
        error_of(&looped, looped.best),
        looped.rendered.given_up
    );
    assert!(headroom.peak <= headroom.limit + 1e-9, "{headroom:?}");
}

#[derive(Clone, Copy)]
enum Mishap {
    Lifts,
    Clips,
    Presses,
}

/// A bench on which something happens from the run of a number on.
struct Disturbed {
    inner: Box<dyn Acquire>,
    mishap: Mishap,
    from: usize,
    runs: Rc<Cell<usize>>,
}

impl Acquire for Disturbed {
    fn describe(&self) -> AcquireDescription {
        self.inner.describe()
    }
    fn calibrate(&mut self) -> Result<SensorCalibration, BenchError> {
        self.inner.calibrate()
    }
    fn ready(&mut self, run: &RunPlan) -> Result<(), BenchError> {
        self.inner.ready(run)
    }
    fn start(&mut self) -> Result<(), BenchError> {
        self.runs.set(self.runs.get() + 1);
        self.inner.start()
    }
    fn wait(&mut self) -> Result<Option<Chunk>, BenchError> {
        let Some(mut chunk) = self.inner.wait()? else {
            return Ok(None);
        };
        if self.runs.get() >= self.from {
            match self.mishap {
                Mishap::Lifts => chunk.channels[1].iter_mut().enumerate().for_each(|(i, v)| {
                    *v = 1e-3 * ((i * i * 7919 % 1000) as f64 / 500.0 - 1.0);
                }),
                Mishap::Clips => chunk.channels[1]
                    .iter_mut()
                    .for_each(|v| *v = v.clamp(-0.2, 0.2)),
                Mishap::Presses => chunk.channels[2].iter_mut().for_each(|v| *v *= 2.0),
            }
        }
        Ok(Some(chunk))
    }
    fn stop(&mut self) {
        self.inner.stop();
    }
}

fn disturbed(mishap: Mishap, from: usize) -> Result<Looped, BenchError> {
    let Bench { player, acquirer } = bench(1);
    let acquirer = Disturbed {
        inner: acquirer,
        mishap,
        from,
        runs: Rc::new(Cell::new(0)),
    };
    let mut bench = Bench {
        player,
        acquirer: Box::new(acquirer),
    };
    let target = texture().amplified(Decibels(-6.0));
    closed_loop(
        &mut bench,
        &target,
        &function(1),
        &config(Mode::Texture),
        &mut |_| {},
    )
}

/// Run 1 is silence, 2 and 3 the open loop: what happens from 4 on leaves the open loop's drive, with a doubt that says why.
#[test]
fn what_happens_in_the_loop_leaves_the_best_so_far() {
    for (mishap, why) in [
        (Mishap::Lifts, "finger lifted"),
        (Mishap::Clips, "sensor clips"),
        (Mishap::Presses, "the force averaged"),
    ] {
        let looped = disturbed(mishap, 4).unwrap();
        assert!(
            matches!(&looped.end, LoopEnd::Broken(reason) if reason.contains(why)),
            "{}",
            looped.end
        );
        assert_eq!((looped.best, looped.iterations.len()), (0, 1));
        let said = looped
            .rendered
            .doubts
            .iter()
            .find(|d| matches!(d, Doubt::LoopStopped { .. }));
        assert!(said.unwrap().to_string().contains(why));
    }
}

#[test]
fn what_happens_at_once_is_an_error() {
    for (mishap, why) in [
        (Mishap::Lifts, "finger lifted"),
        (Mishap::Presses, "the force averaged"),
    ] {
        let error = disturbed(mishap, 2).unwrap_err().to_string();
        assert!(
            error.contains("nothing was corrected") && error.contains(why),
            "{error}"
        );
    }
}
