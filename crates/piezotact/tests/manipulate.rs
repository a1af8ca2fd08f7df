//! Textures made otherwise: against NumPy and SciPy (`golden/manipulate.py`), and for what each operation promises.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test fails where it cannot go on, and prints what it measured"
)]

use piezotact::recording::{MissingChannel, RecordingWarning};
use std::f64::consts::TAU;

use piezotact::Warning;
use piezotact::lineage::{BandChange, Level, Lineage, Operation, WarpedLength};
use piezotact::manipulate::{
    DrawnPhases, JoinConfig, ManipulateError, ManipulateWarning, NoticeableJoin, Texture, Tilt,
    change_band, exchanged, gain, level, looped, phases_needed, randomise_phases, rms_of, shift,
    spectrum_of, tilt, warp,
};
use piezotact::quantity::{Acceleration, Band, Decibels, Hertz, SampleRate, Seconds};
use piezotact::series::Series;
use piezotact::spectrum::{Spectrum, WelchConfig, welch};
use piezotact::statistics::{peak, standard_deviation};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::Deserialize;

type Acc = Series<Acceleration>;

fn series(samples: Vec<f64>, rate_hz: f64) -> Acc {
    Series::new(samples, SampleRate::new(rate_hz).unwrap()).unwrap()
}

fn band(low: f64, high: f64) -> Band {
    Band::new(Hertz(low), Hertz(high)).unwrap()
}

#[derive(Deserialize)]
struct Golden {
    shifts: Vec<Shift>,
    tilts: Vec<Slope>,
    bands: Vec<Change>,
    spectra: Vec<Swap>,
}

#[derive(Deserialize)]
struct Shift {
    n: usize,
    by_hz: f64,
    share: f64,
    values: Vec<f64>,
}

#[derive(Deserialize)]
struct Slope {
    n: usize,
    db_per_octave: f64,
    pivot_hz: f64,
    held_below_hz: f64,
    values: Vec<f64>,
}

#[derive(Deserialize)]
struct Change {
    n: usize,
    low_hz: f64,
    high_hz: f64,
    gain_db: Option<f64>,
    values: Vec<f64>,
}

#[derive(Deserialize)]
struct Swap {
    n: usize,
    segment: usize,
    values: Vec<f64>,
}

fn golden() -> Golden {
    serde_json::from_str(include_str!("golden/manipulate.json")).unwrap()
}

/// The texture of `golden/manipulate.py`, 1 kHz.
fn formula(n: usize) -> Acc {
    let sample = |i: usize| {
        let (i, t) = (i as f64, i as f64 / 1000.0);
        let slow = 1.0 + 0.3 * (TAU * 3.0 * t).sin();
        let tones = (TAU * 73.3 * t).sin() + 0.5 * (TAU * 211.7 * t).sin() * slow;
        tones + 0.2 * (0.01 * i * i).sin() + 0.25
    };
    series((0..n).map(sample).collect(), 1000.0)
}

#[track_caller]
fn equal(got: &Acc, expected: &[f64], what: &str) {
    assert_eq!(got.samples().len(), expected.len(), "{what}");
    let worst = got
        .samples()
        .iter()
        .zip(expected)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    // Two transforms of 160 numbers of about 1: 1e-13 is rounding.
    assert!(worst < 1e-11, "{what}: {worst:e}");
}

#[test]
fn shifts_equal_scipy() {
    for case in golden().shifts {
        let done = shift(&formula(case.n), Hertz(case.by_hz)).unwrap();
        equal(&done.series, &case.values, &format!("{} Hz", case.by_hz));
        let said = done
            .warnings
            .iter()
            .find_map(|warning| match warning.kind() {
                Some(ManipulateWarning::LeftTheBand { share, .. }) => Some(share),
                _ => None,
            });
        if case.share > 1e-3 {
            assert!((said.unwrap() - case.share).abs() < 1e-9, "{said:?}");
        } else {
            assert_eq!(said, None);
        }
    }
}

#[test]
fn tilts_equal_numpy() {
    for case in golden().tilts {
        let slope = Tilt {
            db_per_octave: case.db_per_octave,
            pivot: Hertz(case.pivot_hz),
            held_below: Hertz(case.held_below_hz),
        };
        let done = tilt(&formula(case.n), slope).unwrap();
        equal(&done.series, &case.values, &done.step.to_string());
    }
}

#[test]
fn changed_bands_equal_numpy() {
    for case in golden().bands {
        let change = case
            .gain_db
            .map_or(BandChange::Removed, |gain_db| BandChange::Gain { gain_db });
        let done = change_band(&formula(case.n), band(case.low_hz, case.high_hz), change).unwrap();
        equal(&done.series, &case.values, &done.step.to_string());
    }
}

#[test]
fn spectra_of_another_equal_numpy_and_keep_the_level() {
    let other = (0..300).map(|i| {
        let i = f64::from(i);
        (0.003 * i * i).sin() * (0.7 * i).cos() + 0.1 * (0.02 * i * i).cos()
    });
    let other = Texture::of("other", series(other.collect(), 1000.0));
    for case in golden().spectra {
        let x = formula(case.n);
        let done = spectrum_of(&x, &other, &WelchConfig::hann(case.segment)).unwrap();
        equal(&done.series, &case.values, "spectrum of another");
        let level = |x: &Acc| standard_deviation(x.samples());
        assert!((level(&done.series) / level(&x) - 1.0).abs() < 1e-12);
    }
}

struct Noise(ChaCha8Rng);

impl Noise {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

/// Noise as a texture has it: most of it below some hundred Hz.
fn isotropic(seed: u64, n: usize, corner_hz: f64, rms: f64) -> Acc {
    let mut noise = Noise::new(seed);
    let share = 1.0 - (-TAU * corner_hz / 5000.0).exp();
    let (mut slow, mut slower, mut last) = (0.0, 0.0, 0.0);
    let mut samples: Vec<f64> = (0..n + 500)
        .map(|_| {
            slow += share * (noise.normal() - slow);
            slower += share * (slow - slower);
            let step = slower - last;
            last = slower;
            step
        })
        .skip(500)
        .collect();
    let scale = rms / standard_deviation(&samples);
    for sample in &mut samples {
        *sample *= scale;
    }
    series(samples, 5000.0)
}

/// A comb as M8 has it: harmonics of 41.7 Hz.
fn periodic(n: usize) -> Acc {
    let sample = |i: usize| {
        let t = i as f64 / 5000.0;
        (1..8)
            .map(|k| (TAU * 41.7 * f64::from(k) * t + f64::from(k * k)).sin() / f64::from(k))
            .sum()
    };
    series((0..n).map(sample).collect(), 5000.0)
}

fn psd(x: &Acc) -> Spectrum<Acceleration> {
    welch(x, &WelchConfig::thesis_2024()).unwrap()
}

/// A PSD relative to its own sum.
fn shape(x: &Acc) -> Vec<f64> {
    let psd = psd(x);
    let sum: f64 = psd.values.iter().sum();
    psd.values.iter().map(|v| v / sum).collect()
}

/// What the thesis did in 4.4: the levels of S2 and S13 exchanged, each with its own shape.
#[test]
fn exchanged_levels_are_equal_to_a_thousandth_and_shapes_to_1e_9() {
    for seed in 0..20 {
        let loud = isotropic(seed, 10_000, 120.0, 2.1);
        let soft = isotropic(seed + 100, 9_000, 260.0, 0.41);
        let first = Texture::of("S2", loud.clone());
        let second = Texture::of("S13", soft.clone());
        let [s2_inverted, s13_inverted] = exchanged(first, second).unwrap();
        for (inverted, original, other) in
            [(&s2_inverted, &loud, &soft), (&s13_inverted, &soft, &loud)]
        {
            let off = inverted.series.rms() / other.rms() - 1.0;
            assert!(off.abs() < 1e-3, "Must show: 0.1 %, found {off:e}");
            // It is a pure gain: what differs is rounding, and the mean of a texture.
            let level = |x: &Acc| standard_deviation(x.samples());
            assert!((level(&inverted.series) / level(other) - 1.0).abs() < 1e-12);
            let worst = shape(&inverted.series)
                .iter()
                .zip(shape(original))
                .map(|(a, b)| (a / b - 1.0).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-9, "{worst:e}");
        }
        assert!(matches!(
            &s2_inverted.lineage.steps[..],
            [step] if matches!(&step.operation, Operation::RmsOf { of, .. } if of.source == "S13")
        ));
    }
}

#[test]
fn a_level_within_a_band_is_that_of_the_band() {
    let tone =
        |hz: f64, amplitude: f64, i: i32| amplitude * (TAU * hz * f64::from(i) / 5000.0).sin();
    let two = |a, b| {
        series(
            (0..5000)
                .map(|i| tone(100.0, a, i) + tone(400.0, b, i))
                .collect(),
            5000.0,
        )
    };
    let within = Level::Within(band(50.0, 200.0));
    let half = 0.5f64.sqrt();
    assert!((level(&two(2.0, 5.0), within).unwrap() - 2.0 * half).abs() < 1e-9);
    let done = rms_of(&two(2.0, 5.0), &Texture::of("b", two(6.0, 1.0)), within).unwrap();
    assert!((level(&done.series, within).unwrap() - 6.0 * half).abs() < 1e-9);
    // All of it is louder by the same gain.
    assert!(
        (level(&done.series, Level::Whole).unwrap()
            - 3.0 * level(&two(2.0, 5.0), Level::Whole).unwrap())
        .abs()
            < 1e-9
    );
    let error = level(&two(1.0, 0.0), Level::Within(band(600.0, 700.0))).unwrap_err();
    assert!(
        matches!(error, ManipulateError::SilentWithin { .. }),
        "{error}"
    );
}

fn drawn(seed: u64, count: usize) -> DrawnPhases {
    let mut noise = Noise::new(seed);
    DrawnPhases {
        turns: (0..count).map(|_| noise.uniform()).collect(),
        drawn_by: format!("ChaCha8, seed {seed}"),
    }
}

#[test]
fn random_phases_keep_every_line_s_power_and_destroy_the_waveform() {
    for n in [4000, 4001] {
        // A click: all phases in line.
        let mut samples = vec![0.0; n];
        samples[n / 2] = 1.0;
        let click = series(samples, 5000.0);
        let done = randomise_phases(&click, &drawn(3, phases_needed(n))).unwrap();
        assert!((done.series.rms() / click.rms() - 1.0).abs() < 1e-12);
        let crest = peak(done.series.samples()) / done.series.rms();
        assert!(crest < 5.0, "{crest}");
        let again = randomise_phases(&click, &drawn(3, phases_needed(n))).unwrap();
        assert_eq!(done.series, again.series);
        let error = randomise_phases(&click, &drawn(3, 7)).unwrap_err();
        assert!(matches!(error, ManipulateError::Phases { found: 7, .. }));
    }
}

#[test]
fn a_warp_moves_every_line_in_proportion() {
    for ratio in [1.25, 0.8, 1.5, 1.001, 0.5, 2.0] {
        let tone: Vec<f64> = (0..20_000)
            .map(|i| (TAU * 200.0 * f64::from(i) / 5000.0).sin())
            .collect();
        let done = warp(&series(tone, 5000.0), ratio, WarpedLength::Follows).unwrap();
        let y = done.series.samples();
        assert_eq!(y.len(), (20_000.0 / ratio).ceil() as usize);
        let worst = (y.len() / 4..3 * y.len() / 4)
            .map(|i| (y[i] - (TAU * 200.0 * ratio * i as f64 / 5000.0).sin()).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-3, "× {ratio}: {worst:e}");
        assert!(done.warnings.is_empty());
    }
    let high: Vec<f64> = (0..5000)
        .map(|i| {
            (TAU * 2000.0 * f64::from(i) / 5000.0).sin()
                + (TAU * 100.0 * f64::from(i) / 5000.0).sin()
        })
        .collect();
    let done = warp(&series(high.clone(), 5000.0), 1.5, WarpedLength::Follows).unwrap();
    assert!(
        matches!(&done.warnings[..], [warning] if matches!(warning.kind(), Some(ManipulateWarning::LeftTheBand { share, .. }) if (share - 0.5).abs() < 1e-3)),
        "{:?}",
        done.warnings
    );
    let kept = warp(&isotropic(1, 10_000, 150.0, 1.0), 1.25, WarpedLength::Kept).unwrap();
    assert_eq!(kept.series.samples().len(), 10_000);
    let kept = warp(&isotropic(1, 10_000, 150.0, 1.0), 0.8, WarpedLength::Kept).unwrap();
    assert_eq!(kept.series.samples().len(), 10_000);
}

/// No click: at no join is the step between two samples larger, or the short-time spectrum stronger, than elsewhere.
#[test]
fn loops_do_not_click() {
    let mut worst = (0.0f64, f64::MIN);
    for seed in 0..40 {
        let texture = isotropic(
            seed,
            6_000 + 37 * seed as usize,
            80.0 + 10.0 * seed as f64,
            1.0,
        );
        let config = JoinConfig::usual(texture.duration());
        let done = looped(&texture, Seconds(10.0), &config).unwrap();
        assert_eq!(done.series.samples().len(), 50_000);
        let Operation::Looped {
            join: Some(join), ..
        } = done.step.operation
        else {
            panic!("joined")
        };
        worst = (worst.0.max(join.step_ratio), worst.1.max(join.spectrum_db));
        assert!(done.warnings.is_empty(), "{join:?}");
        // Looked at from outside as well: the steps of the whole, with every join in it.
        let step = |x: &[f64]| {
            x.windows(2)
                .map(|p| (p[1] - p[0]).abs())
                .fold(0.0, f64::max)
        };
        assert!(
            step(done.series.samples())
                <= step(texture.samples()) * join.step_ratio.max(1.0) * (1.0 + 1e-9)
        );
        // And its level stays within what a stretch of the texture has by chance.
        let around = (join.period_s * 5000.0) as usize;
        let level = standard_deviation(&done.series.samples()[around..around + 500]);
        assert!((0.6..1.5).contains(&level), "{level}");
    }
    println!(
        "largest step at a join {:.3} of the texture's, strongest spectrum {:+.2} dB",
        worst.0, worst.1
    );
    assert!(worst.0 <= 1.0 && worst.1 <= 0.0, "{worst:?}");
}

#[test]
fn a_periodic_texture_is_joined_in_step() {
    let done = looped(
        &periodic(5_200),
        Seconds(5.0),
        &JoinConfig::usual(Seconds(1.04)),
    )
    .unwrap();
    let Operation::Looped {
        join: Some(join), ..
    } = done.step.operation
    else {
        panic!("joined")
    };
    println!("{join:?}");
    assert!(
        join.correlation > 0.995 && join.step_ratio <= 1.0 + 1e-9,
        "{join:?}"
    );
    let periods = join.period_s * 41.7;
    assert!((periods - periods.round()).abs() < 0.01, "{periods}");
}

/// Ends that are put together out of step are found: the measure sees a click where there is one.
#[test]
fn ends_out_of_step_are_seen_and_said() {
    // 9.8 periods and a search of no length: the end falls where it falls.
    let texture = periodic(1_180);
    let rough = JoinConfig {
        crossfade: Seconds(0.0016),
        search: Seconds(0.0),
    };
    let done = looped(&texture, Seconds(3.0), &rough).unwrap();
    let said = done.warnings.iter().any(
        |warning| matches!(warning.kind(), Some(ManipulateWarning::JoinShows { by: NoticeableJoin::Waveform { step_ratio, spectrum_db, .. } }) if step_ratio > 1.5 && spectrum_db > 6.0),
    );
    assert!(said, "{:?}", done.step);
}

/// The level of a stroke that decays jumps where it begins again; one that only scatters has no such place.
#[test]
fn a_stroke_that_decays_or_grows_is_named_where_it_is_joined() {
    let jumps = |done: &piezotact::manipulate::Manipulated<Acceleration>| {
        done.warnings
            .iter()
            .find_map(|warning| match warning.kind() {
                Some(ManipulateWarning::JoinShows {
                    by: NoticeableJoin::Level { jump_db, own_db },
                }) => Some((jump_db, own_db)),
                _ => None,
            })
    };
    let loop_of = |db_a_second: f64| {
        let texture = isotropic(3, 10_000, 150.0, 1.0);
        let shaped = texture
            .samples()
            .iter()
            .enumerate()
            .map(|(i, v)| v * 10f64.powf(db_a_second * i as f64 / 5000.0 / 20.0))
            .collect();
        let shaped = series(shaped, 5000.0);
        looped(&shaped, Seconds(6.0), &JoinConfig::usual(Seconds(2.0))).unwrap()
    };
    assert_eq!(jumps(&loop_of(0.0)), None);
    for db_a_second in [-10.0, 10.0] {
        let (jump_db, own_db) = jumps(&loop_of(db_a_second)).unwrap();
        assert!((jump_db + 1.8 * db_a_second).abs() < 6.0, "{jump_db}");
        assert!(own_db < 8.0, "{own_db}");
    }
}

/// The warnings about the texture that a level is taken of gives a warning of the result; its rate does not matter.
#[test]
fn a_level_comes_with_its_warnings_and_from_any_rate() {
    let x = isotropic(1, 5_000, 100.0, 1.0);
    let mut other = Texture::of("S13", series(vec![3.0, -3.0, 3.0, -3.0], 1000.0));
    other
        .warnings
        .push(Warning::from(RecordingWarning::ChannelMissing {
            what: MissingChannel::Cutting,
        }));
    let done = rms_of(&x, &other, Level::Whole).unwrap();
    assert!((standard_deviation(done.series.samples()) - 3.0).abs() < 1e-12);
    assert_eq!(
        done.warnings,
        [Warning::from(RecordingWarning::ChannelMissing {
            what: MissingChannel::Cutting
        })]
    );
    let [first, second] = exchanged(Texture::of("S2", x), other).unwrap();
    assert_eq!(
        first.warnings,
        [Warning::from(RecordingWarning::ChannelMissing {
            what: MissingChannel::Cutting
        })]
    );
    assert_eq!(
        second.warnings,
        [Warning::from(RecordingWarning::ChannelMissing {
            what: MissingChannel::Cutting
        })]
    );
}

#[test]
fn levels_far_from_one_are_told_in_digits() {
    let x = gain(&isotropic(1, 500, 100.0, 1.0), Decibels(-100.0)).unwrap();
    let text = x.step.to_string();
    assert!(
        text.contains("1.0000 m/s²") && text.contains("1.000e-5"),
        "{text}"
    );
}

#[test]
fn what_cannot_be_is_refused() {
    let x = isotropic(1, 5_000, 100.0, 1.0);
    let silent = series(vec![9.81; 5_000], 5000.0);
    let slower = Texture::of("S13", series(vec![1.0, -1.0, 1.0], 1000.0));
    let removed = BandChange::Removed;
    let tone = series(
        (0..1000)
            .map(|i| (TAU * 0.1 * f64::from(i)).sin())
            .collect(),
        1000.0,
    );
    let steep = Tilt {
        db_per_octave: f64::NAN,
        pivot: Hertz(100.0),
        held_below: Hertz(10.0),
    };
    let usual = JoinConfig::usual(Seconds(1.0));
    for (refused, parts) in [
        (
            gain(&silent, Decibels(3.0)).err(),
            &["constant", "1.000 s"][..],
        ),
        (
            gain(&x, Decibels(f64::NAN)).err(),
            &["-120 to 120 dB", "NaN"],
        ),
        (
            change_band(&x, band(100.0, 2501.0), removed).err(),
            &["2500 Hz", "2501 Hz"],
        ),
        (
            change_band(&tone, band(50.0, 200.0), removed).err(),
            &["50–200 Hz removed", "silence"],
        ),
        (tilt(&x, steep).err(), &["slope", "NaN"]),
        (
            shift(&x, Hertz(2600.0)).err(),
            &["-2500 to 2500 Hz", "2600"],
        ),
        (
            shift(&tone, Hertz(-200.0)).err(),
            &["shift -200 Hz", "silence"],
        ),
        (warp(&x, 0.0, WarpedLength::Follows).err(), &["0.1 to 10"]),
        (
            warp(&x, std::f64::consts::SQRT_2, WarpedLength::Follows).err(),
            &["few decimals", "1.414"],
        ),
        (
            warp(
                &series(isotropic(1, 900, 0.1, 1.0).into_samples(), 0.5),
                0.1,
                WarpedLength::Kept,
            )
            .err(),
            &[
                "after the warp",
                "3600 s",
                "found 18000 s",
                "cut the texture",
            ],
        ),
        (
            spectrum_of(&x, &slower, &WelchConfig::hann(64)).err(),
            &["spectrum of S13", "1000 Hz"],
        ),
        (
            spectrum_of(&x, &Texture::of("S1", x.clone()), &WelchConfig::hann(9999)).err(),
            &["S1", "9999", "5000"],
        ),
        (
            looped(&x, Seconds(0.0), &usual).err(),
            &["a length from 0.0002", "found 0 s", "in between"],
        ),
        (
            looped(&x, Seconds(f64::INFINITY), &usual).err(),
            &["3600 s", "inf"],
        ),
        (
            looped(&series(vec![1.0, -1.0], 5000.0), Seconds(1.0), &usual).err(),
            &["for looping"],
        ),
    ] {
        let text = refused.unwrap().to_string();
        for part in parts {
            assert!(text.contains(part), "expected `{part}` in: {text}");
        }
    }
}

/// Textures of any length and size: every operation gives a texture or says why not.
#[test]
fn short_and_odd_textures_are_changed_or_refused() {
    let (mut done, mut refused) = (0, 0);
    for n in (1..70).chain([255, 256, 1000]) {
        for (scale, offset) in [
            (1.0, 0.0),
            (1e-90, 0.0),
            (1e90, 0.0),
            (1.0, 1e9),
            (0.0, 1.0),
        ] {
            let mut noise = Noise::new(n as u64);
            let x = series(
                (0..n).map(|_| scale * noise.normal() + offset).collect(),
                5000.0,
            );
            let other = Texture::of("other", isotropic(1, 3_000, 100.0, 1.0));
            let slope = Tilt {
                db_per_octave: 6.0,
                pivot: Hertz(200.0),
                held_below: Hertz(10.0),
            };
            let all = [
                gain(&x, Decibels(60.0)),
                rms_of(&x, &other, Level::Whole),
                rms_of(&x, &other, Level::Within(band(100.0, 400.0))),
                change_band(&x, band(0.0, 2500.0), BandChange::Removed),
                change_band(&x, band(100.0, 900.0), BandChange::Gain { gain_db: -30.0 }),
                tilt(&x, slope),
                shift(&x, Hertz(-333.3)),
                warp(&x, 1.3, WarpedLength::Follows),
                warp(&x, 1.3, WarpedLength::Kept),
                warp(&x, 0.1, WarpedLength::Kept),
                spectrum_of(&x, &other, &WelchConfig::hann(64)),
                randomise_phases(&x, &drawn(1, phases_needed(n))),
                looped(&x, Seconds(0.3), &JoinConfig::usual(x.duration())),
                looped(&x, Seconds(0.0004), &JoinConfig::usual(x.duration())),
            ];
            for result in all {
                match result {
                    Ok(_) => done += 1,
                    Err(error) => {
                        assert!(
                            error.to_string().contains("expected")
                                || error.to_string().contains("texture"),
                            "{error}"
                        );
                        refused += 1;
                    }
                }
            }
        }
    }
    println!("{done} changed, {refused} refused");
    assert!(done > 2_000, "{done} changed, {refused} refused");
}

#[test]
fn a_chain_is_kept_whole_also_that_of_another_and_survives_being_saved() {
    let other = Texture::of("S13", isotropic(2, 6_000, 200.0, 0.4));
    let softer = gain(&other.series, Decibels(-3.0)).unwrap();
    let other = other.then(softer);
    let mut texture = Texture::of("S2", isotropic(1, 6_000, 120.0, 2.0));
    let levelled = rms_of(&texture.series, &other, Level::Whole).unwrap();
    texture = texture.then(levelled);
    let raised = change_band(
        &texture.series,
        band(50.0, 100.0),
        BandChange::Gain { gain_db: 6.0 },
    );
    texture = texture.then(raised.unwrap());
    let longer = looped(
        &texture.series,
        Seconds(3.0),
        &JoinConfig::usual(Seconds(1.2)),
    )
    .unwrap();
    texture = texture.then(longer);
    let text = texture.lineage.to_string();
    for part in [
        "S2 (rms of S13 (gain -3.000 dB), gain",
        "50–100 Hz +6 dB",
        "looped to 3.000 s",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let saved = serde_json::to_string(&texture.lineage).unwrap();
    let read: Lineage = serde_json::from_str(&saved).unwrap();
    assert_eq!(read.to_string(), text);
    assert_eq!(read.steps.len(), 3);
    for pair in read.steps.windows(2) {
        assert!((pair[0].rms_after.value / pair[1].rms_before.value - 1.0).abs() < 1e-12);
    }
}
