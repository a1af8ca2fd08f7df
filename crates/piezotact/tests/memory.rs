//! How much memory a comparison takes for each sample of the recordings (docs/decisions/verification.md says what the limits are for), and that a
//! convolution in real time takes none.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where it cannot go on, and says what it measured"
)]

use num_complex::Complex;
use peak_alloc::PeakAlloc;
use piezotact::Series;
use piezotact::convolve::{BlockConvolver, Partitions};
use piezotact::quantity::{Acceleration, Band, Decibels, Drive, Hertz, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::render::{self, RenderConfig, render};
use piezotact::score::{self, ScoreConfig, score};
use piezotact::statistics::random::Random;
use piezotact::study::{self, Breadth, Gesture, Naming, Question, Recorded, Stated, StudySettings};
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::verify::{self, Measured, VerifyConfig, verify};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// The largest number of bytes that `work` holds at a time beyond what there was before, for each of `samples`.
fn bytes_a_sample<T>(samples: usize, work: impl FnOnce() -> T) -> f64 {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let _result = work();
    (MEMORY.peak_usage() - before) as f64 / samples as f64
}

/// Noise of `seconds` at `rate_hz`, and the same a little louder and with a little noise of its own.
fn pair(rate_hz: f64, seconds: f64) -> [Series<Acceleration>; 2] {
    let rate = SampleRate::new(rate_hz).unwrap();
    let mut random = Random::stream(1, 1, "memory");
    let mut smooth = 0.0;
    let target: Vec<f64> = (0..(rate_hz * seconds) as usize)
        .map(|_| {
            smooth += 0.1 * (10.0 * random.normal() - smooth);
            smooth
        })
        .collect();
    let measured = target.iter().map(|v| 1.02 * v + 0.01 * random.normal());
    let measured = Series::new(measured.collect(), rate).unwrap();
    [Series::new(target, rate).unwrap(), measured]
}

/// One test, as the counts are of the whole program; the one that counts single bytes is last, when nothing else runs.
#[test]
fn memory_is_as_stated() {
    a_comparison_takes_few_bytes_a_sample();
    convolution_in_real_time_takes_no_memory();
}

fn convolution_in_real_time_takes_no_memory() {
    // A block whose transform has factors, one that is a prime and one of a sample.
    for block in [64, 480, 61, 1] {
        let level = |level: f64| Partitions::new(&vec![level; 500], block).unwrap();
        let mut convolver = BlockConvolver::new(level(1.0));
        let mut next = [level(2.0), level(3.0), level(4.0)];
        let input: Vec<f64> = (0..block).map(|i| (i as f64).sin()).collect();
        let mut output = vec![0.0; block];
        let too_long = vec![0.0; block + 1];
        let mut blocks = || {
            for next in &mut next {
                convolver.process(&input, &mut output).unwrap();
                convolver.change(next).unwrap();
                convolver.process(&input, &mut output).unwrap();
                assert!(convolver.process(&too_long, &mut output).is_err());
            }
        };
        assert_eq!(memory_of(&mut blocks), [0, 0], "blocks of {block}");
    }
    // That this counts: memory that is kept, and memory that is only taken for a while.
    let mut kept = Vec::new();
    assert_eq!(memory_of(|| kept.push(1u8))[0], kept.capacity());
    let [held, most] = memory_of(|| drop(std::hint::black_box(vec![1u8; 100])));
    assert_eq!([held, most], [0, 100]);
}

/// Bytes that `work` holds after it beyond what there was before, and the most that it held.
fn memory_of(work: impl FnOnce()) -> [usize; 2] {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    work();
    [MEMORY.current_usage(), MEMORY.peak_usage()].map(|now| now.abs_diff(before))
}

fn a_comparison_takes_few_bytes_a_sample() {
    let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    for (rate_hz, seconds) in [(5000.0, 100.0), (48_000.0, 12.0)] {
        let [target, measured] = pair(rate_hz, seconds);
        let samples = target.samples().len();
        let scored = bytes_a_sample(samples, || {
            score(&target, &measured, &ScoreConfig::over(band, rate_hz)).unwrap()
        });
        let verified = bytes_a_sample(samples, || {
            let measured = Measured::alone(&measured);
            verify(&target, measured, &VerifyConfig::over(band, rate_hz)).unwrap()
        });
        // A device of 20 m/s² at full scale, whatever the frequency.
        let lines = vec![Complex::from(20.0); 1025];
        let rate = SampleRate::new(rate_hz).unwrap();
        let device = TransferFunction::<Drive, Acceleration>::from_lines(
            lines,
            vec![1.0; 1025],
            rate_hz / 2048.0,
            rate,
            Estimator::H1,
            100,
        );
        let (device, soft) = (device.unwrap(), target.clone().amplified(Decibels(-20.0)));
        let config = RenderConfig::over(band, SampleRate::new(48_000.0).unwrap());
        let rendered = bytes_a_sample(samples, || render(&soft, &device, &config).unwrap());
        assert!(rendered < render::MEMORY_BYTES_A_SAMPLE as f64);
        println!(
            "{rate_hz} Hz: render {rendered:.0}, score {scored:.0}, verify {verified:.0} bytes a sample"
        );
        assert!(
            scored < score::MEMORY_BYTES_A_SAMPLE as f64
                && verified < verify::MEMORY_BYTES_A_SAMPLE as f64
        );
    }
    let samples = 100 * 5000;
    let analysed = bytes_a_sample(samples, || {
        let take = study::cut(touched(samples), &Stated::nothing()).unwrap();
        study::analyse(vec![take], &settings()).unwrap()
    });
    // The four channels are 32 of them, in the recording that is handed over, and nothing is freed of it.
    println!("analyse {analysed:.0} bytes a sample, with the recording");
    assert!(analysed - 32.0 < study::MEMORY_BYTES_A_SAMPLE as f64);
}

/// Strokes of 1 s every 1.5 s at 5 kHz: acceleration, two tangential forces and the normal force.
fn touched(samples: usize) -> Recorded {
    let mut random = Random::stream(2, 1, "memory");
    let mut channels: Vec<Vec<f64>> = vec![Vec::new(); 4];
    for i in 0..samples {
        let on = if i % 7500 < 5000 { 1.0 } else { 0.0 };
        let noise: [f64; 4] = std::array::from_fn(|_| random.normal());
        channels[0].push(on * noise[0] + 0.001 * noise[1]);
        channels[1].push(0.15 * on + 0.001 * noise[2]);
        channels[2].push(0.001 * noise[1]);
        channels[3].push(0.3 * on + 0.001 * noise[3]);
    }
    let named = [
        ("nail", Unit::MetrePerSecondSquared),
        ("fx", Unit::Newton),
        ("fy", Unit::Newton),
        ("fz", Unit::Newton),
    ];
    let channels = named.into_iter().zip(channels);
    let channels = channels.map(|((name, unit), samples)| Channel {
        name: name.into(),
        unit,
        samples,
    });
    let rate = SampleRate::new(5000.0).unwrap();
    let (own, provenance) = (Condition::default(), Provenance::default());
    let recording = Recording::new(channels.collect(), rate, own, provenance).unwrap();
    Recorded {
        file: "S1.csv".into(),
        name: "S1.csv".into(),
        recording,
        naming: Naming::default(),
        cuts: None,
        cuts_are_looked_for_in: String::new(),
    }
}

fn settings() -> StudySettings {
    StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: Vec::new(),
        twin_sets: Vec::new(),
        ridge_m: None,
        question: Question::Groups(None),
        breadth: Breadth::Question,
    }
}
