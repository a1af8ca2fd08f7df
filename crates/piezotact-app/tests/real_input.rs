//! Real textures through the whole loop: on the twin with the command, and through measured hands.
//!
//! The files lie beside the checkout, in `../shared/data`; without them a test says that it was skipped, and
//! with `CI=true` it fails.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test prints what it measured, and fails where it cannot"
)]

use crate::support::{Folder, shared};
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, Measure, SampleRate};
use piezotact::render::{RenderConfig, RenderError, render};
use piezotact::resample::resample;
use piezotact::series::Series;
use piezotact::spectrum::WelchConfig;
use piezotact::statistics::{peak, rms};
use piezotact::transfer::{Estimator, TransferFunction, estimate};
use piezotact::verify::{Measured, VerifyConfig, verify};
use piezotact_dataset::{ReadOptions, TransferDocument, read_recording, write_transfer};

const TEXTSENSE: [&str; 10] = [
    "text3_ref",
    "text3_v1",
    "text3_v2",
    "text3_v3",
    "text3_v4",
    "text9_ref",
    "text9_v1",
    "text9_v2",
    "text9_v3",
    "text9_v4",
];
const SCALE: &str = "200 m/s2";

/// Every file, with the command and nothing else: render, play, verify over 20–1000 Hz.
#[test]
fn textsense_is_rendered_through_the_twin() {
    let Some(data) = shared("data/vibration/textsense") else {
        return;
    };
    let folder = Folder::new();
    let bench = "twin:participant=2,seed=7";
    folder
        .run(&["characterise", "--bench", bench, "--out", "tf.json"])
        .expect_success();
    for name in TEXTSENSE {
        let texture = data.join(format!("{name}.wav"));
        let texture = texture.to_str().unwrap();
        let render = [
            "render",
            texture,
            "--scale",
            SCALE,
            "--transfer",
            "tf.json",
            "--out",
            "drive.wav",
        ];
        folder.run(&render).expect_success();
        folder
            .run(&[
                "play",
                "drive.wav",
                "--bench",
                bench,
                "--record",
                "measured.parquet",
            ])
            .expect_success();
        let verified = folder
            .run(&[
                "verify",
                "--target",
                texture,
                "--scale",
                SCALE,
                "--measured",
                "measured.parquet",
                "--json",
            ])
            .json();
        let number = |key: &str| verified[key].as_f64().unwrap();
        eprintln!(
            "{name}: {:.3} dB rms, {:.2} dB max, r {:.4}, achievable {}",
            number("error_db_rms_achievable"),
            number("error_db_max"),
            number("waveform_correlation"),
            verified["achievable_band_hz"]
        );
        assert!(
            number("error_db_rms_achievable") <= 1.0,
            "{name}: {verified}"
        );
        assert!(number("waveform_correlation") >= 0.95, "{name}: {verified}");
    }
}

/// The skin of one hand: one output axis of its measured impulse responses, its largest |H| made 1 so that
/// full scale means something.
struct Hand {
    impulse: Vec<f64>,
    rate: SampleRate,
}

impl Hand {
    const SAMPLES: usize = 522;

    /// The axis that is stronger than `rank` of all 216, from 0 to 1.
    fn load(path: &std::path::Path, rank: f64) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let all: Vec<f64> = bytes
            .chunks_exact(4)
            .map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])))
            .collect();
        let mut axes: Vec<&[f64]> = all.chunks_exact(Self::SAMPLES).collect();
        axes.sort_by(|a, b| rms(a).total_cmp(&rms(b)));
        let axis = axes[(rank * (axes.len() - 1) as f64) as usize];
        let mut hand = Self {
            impulse: axis.to_vec(),
            rate: SampleRate::new(1300.0).unwrap(),
        };
        let largest = (1..650)
            .map(|f| {
                let turn = std::f64::consts::TAU * f64::from(f) / 1300.0;
                let (re, im) =
                    hand.impulse
                        .iter()
                        .enumerate()
                        .fold((0.0, 0.0), |(re, im), (i, h)| {
                            (
                                re + h * (turn * i as f64).cos(),
                                im - h * (turn * i as f64).sin(),
                            )
                        });
                re.hypot(im)
            })
            .fold(0.0, f64::max);
        hand.impulse.iter_mut().for_each(|h| *h /= largest);
        hand
    }

    /// Its transfer function, by the Fourier transform of the impulse response, on lines 1 Hz apart; at its strongest full
    /// scale makes 20 m/s², about as much as the PIEZOTACT's.
    fn written(&self, path: &std::path::Path, who: &str) {
        let line = |hz: u32, part: fn(f64) -> f64| -> f64 {
            let samples = (0..1300).zip(&self.impulse);
            // Whole turns are left out, so that the angle stays exact.
            let turn = |i: u32| std::f64::consts::TAU * f64::from((i * hz) % 1300) / 1300.0;
            20.0 * samples.map(|(i, h)| h * part(turn(i))).sum::<f64>()
        };
        let lines = 0..=650;
        let mut document: TransferDocument = serde_json::from_value(serde_json::json!({
            "drive_unit": "FS",
            "response_unit": "m/s2",
            "rate_hz": 1300.0,
            "frequency_hz": lines.clone().map(f64::from).collect::<Vec<_>>(),
            "real": lines.clone().map(|hz| line(hz, f64::cos)).collect::<Vec<_>>(),
            "imaginary": lines.clone().map(|hz| -line(hz, f64::sin)).collect::<Vec<_>>(),
            "coherence": vec![1.0; 651],
        }))
        .unwrap();
        document.about.condition.participant = Some(who.into());
        write_transfer(path, &document).unwrap();
    }

    /// What the skin does for a drive, with the sensor's noise 60 dB below it.
    fn feel(&self, drive: &[f64], noise: &mut Noise) -> Vec<f64> {
        let mut out = vec![0.0; drive.len()];
        for (i, d) in drive.iter().enumerate().filter(|(_, d)| **d != 0.0) {
            for (sum, h) in out[i..].iter_mut().zip(&self.impulse) {
                *sum += d * h;
            }
        }
        let level = rms(&out) * 1e-3;
        out.iter_mut().for_each(|v| *v += level * noise.next());
        out
    }
}

/// Uniform noise of variance 1 from a linear congruential generator (Knuth's MMIX), good enough for a test.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 12f64.sqrt()
    }
}

/// Characterised by H1 from a minute of noise, as any device would be.
fn characterised(hand: &Hand, noise: &mut Noise) -> TransferFunction<Drive, Acceleration> {
    let drive: Vec<f64> = (0..60 * 1300).map(|_| 0.3 * noise.next()).collect();
    let felt = hand.feel(&drive, noise);
    let drive = Series::new(drive, hand.rate).unwrap();
    let felt = Series::new(felt, hand.rate).unwrap();
    estimate(&drive, &felt, &WelchConfig::hann(4096), Estimator::H1).unwrap()
}

/// Each texture through three measured hands, at the level that fits, within 1 dB rms of the part of
/// 20–550 Hz that the inverse declares achievable, which is stated.
#[test]
fn textsense_is_rendered_through_measured_hands() {
    let (Some(textures), Some(hands)) = (
        shared("data/vibration/textsense"),
        shared("data/frf/skinsource"),
    ) else {
        return;
    };
    let scale: Measure = SCALE.parse().unwrap();
    let options = ReadOptions {
        scale: Some(scale),
        rate: None,
        ..ReadOptions::default()
    };
    let band = Band::new(Hertz(20.0), Hertz(550.0)).unwrap();
    // The strongest axis, near the contact, and a middling one far from it, which has notches.
    for (model, rank) in [(1, 1.0), (2, 1.0), (3, 1.0), (1, 0.5), (2, 0.5), (3, 0.5)] {
        let hand = Hand::load(&hands.join(format!("model-{model}-location-07.f32")), rank);
        let mut noise = Noise(model);
        let function = characterised(&hand, &mut noise);
        let config = RenderConfig::over(band, hand.rate);
        for name in TEXTSENSE {
            let recording = read_recording(&textures.join(format!("{name}.wav")), &options)
                .unwrap()
                .recording;
            let target =
                resample(&recording.series::<Acceleration>(None).unwrap(), hand.rate).unwrap();
            let (target, drive) = match render(&target, &function, &config) {
                Err(RenderError::ExceedsFullScale { fits_at, .. }) => {
                    let fitting = target.amplified(fits_at);
                    let drive = render(&fitting, &function, &config).unwrap();
                    (fitting, drive)
                }
                other => (target, other.unwrap()),
            };
            assert!(peak(drive.drive.samples()) <= 1.0);
            let felt =
                Series::new(hand.feel(drive.drive.samples(), &mut noise), hand.rate).unwrap();
            let mut config = VerifyConfig::over(band, hand.rate.hz());
            config.reached.clone_from(&drive.coverage.reached);
            let verified = verify(&target, Measured::alone(&felt), &config).unwrap();
            let given_up: Vec<String> = drive
                .coverage
                .given_up
                .iter()
                .map(ToString::to_string)
                .collect();
            eprintln!(
                "hand {model}, axis {rank}, {name}: {:.3} dB rms of the achievable part ({:.3} of all), r {:.4}; given up: {}",
                verified.error_db_rms_achievable.unwrap(),
                verified.error_db_rms,
                verified.waveform_correlation,
                given_up.join(", ")
            );
            let reached_hz: f64 = drive
                .coverage
                .reached
                .iter()
                .map(|band| band.high().0 - band.low().0)
                .sum();
            assert!(
                reached_hz > 0.8 * 530.0,
                "hand {model}, axis {rank}: only {reached_hz:.0} Hz of 530 are declared achievable"
            );
            let error_db = verified.error_db_rms_achievable.unwrap();
            assert!(
                error_db <= 1.0,
                "hand {model}, axis {rank}, {name}: {}",
                verified.sentence()
            );
            // What is given up costs a little of the waveform.
            assert!(
                verified.waveform_correlation >= 0.9,
                "hand {model}, axis {rank}, {name}: {}",
                verified.sentence()
            );
        }
    }
}

/// All files through the three hands in a closed loop, with the command alone: characterised and corrected on a bench that
/// is the measured hand, each at the level that fits. The table is the one of the report.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_textsense_is_corrected_on_measured_hands() {
    let (Some(textures), Some(hands)) = (
        shared("data/vibration/textsense"),
        shared("data/frf/skinsource"),
    ) else {
        return;
    };
    let folder = Folder::new();
    let files: Vec<String> = TEXTSENSE
        .iter()
        .map(|name| textures.join(format!("{name}.wav")).display().to_string())
        .collect();
    let mut line: Vec<String> = ["render"].map(String::from).to_vec();
    line.extend(files);
    for (model, rank, axis) in [
        (1, 1.0, "strong"),
        (2, 1.0, "strong"),
        (3, 1.0, "strong"),
        (1, 0.5, "middling"),
        (2, 0.5, "middling"),
        (3, 0.5, "middling"),
    ] {
        let hand = Hand::load(&hands.join(format!("model-{model}-location-07.f32")), rank);
        let who = format!("hand-{model}-{axis}");
        hand.written(&folder.path(&format!("{who}-skin.json")), &who);
        let bench = format!("measured:{who}-skin.json,noise=0.0005");
        folder
            .run(&[
                "characterise",
                "--bench",
                &bench,
                "--band",
                "5..580",
                "--seconds",
                "30",
                "--segment",
                "2600",
                "--out",
                &format!("{who}.json"),
            ])
            .expect_success();
        for (option, value) in [("--transfer", format!("{who}.json")), ("--bench", bench)] {
            line.extend([option.into(), value]);
        }
    }
    let rest = "--scale=200 m/s2|--band|20..550|--mode|texture|--level|fit|--out|drives|--record|felt|--report|report.html|--json";
    line.extend(rest.split('|').map(String::from));
    let line: Vec<&str> = line.iter().map(String::as_str).collect();
    let said = folder.run(&line).json();
    let all = said["renderings"].as_array().unwrap();
    assert_eq!(all.len(), 60);
    for one in all {
        let number = |of: &serde_json::Value, key: &str| of[key].as_f64().unwrap();
        let (open, closed) = (&one["loop"]["iterations"][0], &one["loop"]["confirmed"]);
        let reached_hz: f64 = one["achievable_band_hz"]
            .as_array()
            .unwrap()
            .iter()
            .map(|band| band[1].as_f64().unwrap() - band[0].as_f64().unwrap())
            .sum();
        let called = one["out"].as_str().unwrap();
        eprintln!(
            "{called}: {:+.1} dB, {:.2} → {:.2} dB rms of {:.0} % of the band, {:.1} dB at most anywhere, r {:.3}",
            number(one, "level_db"),
            number(open, "error_db_rms_achievable"),
            number(closed, "error_db_rms_achievable"),
            reached_hz / 5.3,
            number(closed, "error_db_max"),
            number(closed, "waveform_correlation")
        );
        let error_db = number(closed, "error_db_rms_achievable");
        assert!(error_db <= 1.0, "{called}: {closed}");
        assert!(
            // The sensor's noise on the softest lines is another each time.
            error_db <= number(open, "error_db_rms_achievable") + 0.15,
            "{called}"
        );
        assert!(reached_hz > 0.8 * 530.0, "{called}: {reached_hz} Hz");
    }
    let report = std::fs::read_to_string(folder.path("report.html")).unwrap();
    for part in [
        "60 of 60 results are within 1 dB rms",
        "text9_v4-hand-3-middling",
        "no finger was involved",
        "largest error of a line, dB",
    ] {
        assert!(report.contains(part), "{part}");
    }
    // What was recorded of the best drive can be verified.
    folder
        .run(&[
            "verify",
            "--target",
            &textures.join("text9_v1.wav").display().to_string(),
            "--scale=200 m/s2",
            "--measured",
            "felt/text9_v1-hand-1-strong.parquet",
            "--band",
            "20..550",
        ])
        .expect_success();
}
