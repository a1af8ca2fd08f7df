//! The recording of another system, at another rate and by another clock, on the clock of a drive with and without bursts.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use piezotact::align::{
    AlignConfig, AlignError, AlignedBy, Alignment, BurstConfig, Bursts, Which, align,
    align_with_bursts, with_bursts,
};
use piezotact::quantity::{Band, Drive, Hertz, SampleRate, Seconds};
use piezotact::series::Series;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

const DRIVE_HZ: f64 = 48_000.0;

fn rate(hz: f64) -> SampleRate {
    SampleRate::new(hz).unwrap()
}

fn draws(seed: u64) -> impl FnMut() -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    move || rng.next_u64() as f64 / u64::MAX as f64
}

/// Normal noise of standard deviation 1, by Box and Muller.
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut draw = draws(seed);
    move || (-2.0 * (1.0 - draw()).ln()).sqrt() * (TAU * draw()).cos()
}

fn drive_of(seconds: f64, at: impl Fn(f64) -> f64) -> Series<Drive> {
    let count = (seconds * DRIVE_HZ) as usize;
    let samples = (0..count).map(|i| at(i as f64 / DRIVE_HZ)).collect();
    Series::new(samples, rate(DRIVE_HZ)).unwrap()
}

/// Noise from 60 to 800 Hz as a sum of sines, with a peak near 0.5.
fn noise(seed: u64, seconds: f64) -> Series<Drive> {
    let mut draw = draws(seed);
    let lines: Vec<[f64; 3]> = (0..60)
        .map(|_| [60.0 + 740.0 * draw(), TAU * draw(), 0.2 + draw()])
        .collect();
    drive_of(seconds, |t| {
        let of = |[hz, phase, size]: &[f64; 3]| size * (TAU * hz * t + phase).sin();
        0.025 * lines.iter().map(of).sum::<f64>()
    })
}

fn tone(hz: f64, seconds: f64) -> Series<Drive> {
    drive_of(seconds, |t| 0.4 * (TAU * hz * t).sin())
}

/// A texture that repeats ten times a second.
fn grating(seconds: f64) -> Series<Drive> {
    let mut draw = draws(5);
    let lines: Vec<[f64; 2]> = (5..80).map(|k| [10.0 * k as f64, TAU * draw()]).collect();
    drive_of(seconds, |t| {
        0.04 * lines
            .iter()
            .map(|[hz, phase]| (TAU * hz * t + phase).sin())
            .sum::<f64>()
    })
}

/// Another system: its rate, how fast its clock runs, from when to when of the drive it records, and the rms of its noise.
#[derive(Clone, Copy)]
struct Other {
    rate_hz: f64,
    ppm: f64,
    from_s: f64,
    to_s: f64,
    noise: f64,
    seed: u64,
}

impl Other {
    /// What it records of `drive`, by cubic interpolation (Catmull and Rom): the drive has nothing above 1 kHz at 48 kHz, so that it is
    /// exact to 1e-4.
    fn records(&self, drive: &Series<Drive>) -> Vec<f64> {
        let x = drive.samples();
        let value = |i: i64| {
            let i = usize::try_from(i).ok();
            i.and_then(|i| x.get(i)).copied().unwrap_or(0.0)
        };
        let step_s = 1.0 / (self.rate_hz * (1.0 + 1e-6 * self.ppm));
        let mut more = normal(self.seed);
        let count = ((self.to_s - self.from_s) / step_s) as usize;
        (0..count)
            .map(|i| {
                let at = (self.from_s + i as f64 * step_s) * DRIVE_HZ;
                let (base, t) = (at.floor() as i64, at.fract().rem_euclid(1.0));
                let [a, b, c, d] = [-1, 0, 1, 2].map(|k| value(base + k));
                let cubic = b + 0.5
                    * t
                    * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
                cubic + self.noise * more()
            })
            .collect()
    }

    /// The true time of the drive at a time of the recording.
    fn truth(&self, recorded_s: f64) -> f64 {
        self.from_s + recorded_s / (1.0 + 1e-6 * self.ppm)
    }

    /// The errors of the first and the last sample, s.
    fn errors(&self, found: &Alignment, samples: usize) -> [f64; 2] {
        [0.0, (samples - 1) as f64 / self.rate_hz]
            .map(|at_s| found.on_drive(Seconds(at_s)).0 - self.truth(at_s))
    }
}

fn config(other: &Other) -> AlignConfig {
    AlignConfig::usual(rate(DRIVE_HZ), rate(other.rate_hz)).unwrap()
}

fn aligned(
    drive: &Series<Drive>,
    bursts: Option<&Bursts>,
    other: &Other,
    own: &[f64],
) -> Result<Alignment, AlignError> {
    let (drive, own) = ((drive.samples(), drive.rate()), (own, rate(other.rate_hz)));
    match bursts {
        Some(bursts) => align_with_bursts(drive, own, bursts, &config(other)),
        None => align(drive, own, &config(other)),
    }
}

fn codes(found: &Alignment) -> Vec<String> {
    let fault =
        |d: &piezotact::Warning| match d.fields.get("fault").and_then(|fault| fault.as_str()) {
            Some(fault) if d.code == "align_doubtful" => fault.to_owned(),
            _ => d.code.clone(),
        };
    found.warnings.iter().map(fault).collect()
}

fn burst() -> BurstConfig {
    BurstConfig::usual(rate(DRIVE_HZ), 0.4).unwrap()
}

/// What every recording has to hold: 0.1 ms at the first and the last sample, and no warning of its times.
#[track_caller]
fn check(what: &str, other: &Other, found: &Alignment, samples: usize) {
    for error_s in other.errors(found, samples) {
        assert!(
            error_s.abs() < 1e-4 && error_s.abs() < 4.0 * found.uncertainty_s.0.max(1e-6),
            "{what} at {} Hz, {} ppm: {error_s} ± {} s, {:?}",
            other.rate_hz,
            other.ppm,
            found.uncertainty_s.0,
            codes(found)
        );
    }
    let codes = codes(found);
    assert!(
        codes.is_empty(),
        "{what} at {} Hz, {} ppm: {codes:?}",
        other.rate_hz,
        other.ppm
    );
}

#[test]
fn every_rate_and_clock_is_found_without_and_with_bursts() {
    every_rate_and_clock_is_found_without_and_with_bursts_in(&[8000.0], &[-100.0]);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_every_rate_and_clock_is_found_without_and_with_bursts() {
    every_rate_and_clock_is_found_without_and_with_bursts_in(
        &[5000.0, 8000.0, 10_000.0],
        &[-100.0, 100.0],
    );
}

fn every_rate_and_clock_is_found_without_and_with_bursts_in(rates_hz: &[f64], clocks_ppm: &[f64]) {
    let drives = [
        ("noise", noise(1, 12.0)),
        ("tone", tone(250.0, 12.0)),
        ("grating", grating(12.0)),
    ];
    for (what, plain) in drives {
        let with = with_bursts(&plain, &burst()).unwrap();
        for &rate_hz in rates_hz {
            for &ppm in clocks_ppm {
                let mut other = Other {
                    rate_hz,
                    ppm,
                    from_s: 1.2345678,
                    to_s: 10.9,
                    noise: 0.05,
                    seed: 3,
                };
                if what == "noise" {
                    let own = other.records(&plain);
                    let found = aligned(&plain, None, &other, &own).unwrap();
                    check(what, &other, &found, own.len());
                }
                // Cut within the silence before the first burst and after the last one.
                (other.from_s, other.to_s) = (0.12345678, 13.9);
                let own = other.records(&with.drive);
                let found = aligned(&with.drive, Some(&with.bursts), &other, &own).unwrap();
                check(&format!("{what} with bursts"), &other, &found, own.len());
                assert_eq!(found.bursts.len(), 2);
                let by = match what {
                    "tone" => AlignedBy::Bursts,
                    _ => found.by,
                };
                assert_eq!(found.by, by);
            }
        }
    }
}

/// A sweep that is compared by a clock that is not corrected is found too early or too late: twice the drift, or none.
#[test]
fn a_sweep_is_placed_as_noise_is() {
    for high_hz in [900.0, -900.0] {
        let drive = drive_of(20.0, |t| {
            let (from, to): (f64, f64) = if high_hz > 0.0 {
                (30.0, 900.0)
            } else {
                (900.0, 30.0)
            };
            0.4 * (TAU * (from * t + 0.5 * (to - from) * t * t / 20.0)).sin()
        });
        for ppm in [-100.0, 80.0] {
            let other = Other {
                rate_hz: 5000.0,
                ppm,
                from_s: 1.5,
                to_s: 18.7,
                noise: 0.01,
                seed: 8,
            };
            let own = other.records(&drive);
            let found = aligned(&drive, None, &other, &own).unwrap();
            let errors = other.errors(&found, own.len());
            assert!(
                errors.iter().all(|e| e.abs() < 1e-4),
                "{ppm}: {errors:?} {}",
                found.drift_ppm
            );
        }
    }
}

/// A device that rings at 240 Hz delays both bursts alike: the drift is that of the clocks, and the intervals are not those of the ringing.
#[test]
fn a_device_that_rings_does_not_widen_the_intervals() {
    let with = with_bursts(&tone(250.0, 8.0), &burst()).unwrap();
    let (radius, turn) = (
        (-TAU * 240.0 / 6.0 / DRIVE_HZ).exp(),
        TAU * 240.0 / DRIVE_HZ,
    );
    let (mut before, mut last) = (0.0, 0.0);
    let answer = with.drive.samples().iter().map(|v| {
        let next = 0.01 * v + 2.0 * radius * turn.cos() * last - radius * radius * before;
        (before, last) = (last, next);
        next
    });
    let answer = Series::new(answer.collect(), with.drive.rate()).unwrap();
    let mut held = 0;
    for seed in 0..20 {
        let other = Other {
            rate_hz: 5000.0,
            ppm: -63.0,
            from_s: 0.05,
            to_s: 9.95,
            noise: 0.05 * answer.rms(),
            seed: 300 + seed,
        };
        let own = other.records(&answer);
        let found = aligned(&with.drive, Some(&with.bursts), &other, &own).unwrap();
        let [low, high] = found.drift_interval_ppm;
        held += usize::from(low <= other.ppm && other.ppm <= high);
        assert!(high - low < 10.0, "{low} {high}");
        assert!(found.uncertainty_s.0 < 5e-5, "{}", found.uncertainty_s.0);
        let delay_s = other.from_s - found.offset_s.0;
        // Q/(π·f) of the resonance is 4 ms.
        assert!(delay_s > -1e-4 && delay_s < 4e-3, "{delay_s}");
    }
    // 95 % of 20, less three binomial standard deviations.
    assert!(held >= 16, "{held}");
}

/// 95 % of 60, less three binomial standard deviations; and intervals are not much wider than errors.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_the_intervals_of_bursts_hold_the_truth() {
    let with = with_bursts(&tone(180.0, 4.0), &burst()).unwrap();
    let (mut held, mut drifts, mut ratios) = (0, 0, Vec::new());
    for seed in 0..60 {
        let mut draw = draws(1000 + seed);
        let other = Other {
            rate_hz: 5000.0,
            ppm: 200.0 * draw() - 100.0,
            from_s: -0.3 + 0.5 * draw(),
            to_s: 5.9 + 0.3 * draw(),
            // Of the whole 2.5 kHz; the burst has an rms of 0.27.
            noise: 0.05 + 0.35 * draw(),
            seed,
        };
        let own = other.records(&with.drive);
        let found = aligned(&with.drive, Some(&with.bursts), &other, &own).unwrap();
        let error_s = other.errors(&found, own.len())[0];
        let [low, high] = found.offset_interval_s;
        held += usize::from(low.0 <= other.from_s && other.from_s <= high.0);
        let [low, high] = found.drift_interval_ppm;
        drifts += usize::from(low <= other.ppm && other.ppm <= high);
        ratios.push(
            (error_s / (0.5 * (found.offset_interval_s[1].0 - found.offset_interval_s[0].0)))
                .powi(2),
        );
    }
    assert!(held >= 52 && drifts >= 52, "{held} {drifts} of 60");
    let rms = (ratios.iter().sum::<f64>() / 60.0).sqrt();
    // 1/1.96 where intervals are exact.
    assert!(rms > 0.25 && rms < 0.75, "{rms}");
}

#[test]
fn one_burst_is_not_taken_for_the_other() {
    let other = |from_s: f64, to_s: f64| Other {
        rate_hz: 8000.0,
        ppm: 50.0,
        from_s,
        to_s,
        noise: 0.05,
        seed: 2,
    };
    let of_noise = with_bursts(&noise(4, 10.0), &burst()).unwrap();
    let of_tone = with_bursts(&tone(250.0, 10.0), &burst()).unwrap();
    for (cut, which) in [
        (other(-0.5, 8.0), Which::First),
        (other(4.0, 12.6), Which::Last),
    ] {
        let own = cut.records(&of_noise.drive);
        let found = aligned(&of_noise.drive, Some(&of_noise.bursts), &cut, &own).unwrap();
        check("one burst", &cut, &found, own.len());
        assert_eq!(
            found.bursts.iter().map(|b| b.which).collect::<Vec<_>>(),
            [which]
        );
        let own = cut.records(&of_tone.drive);
        let found = aligned(&of_tone.drive, Some(&of_tone.bursts), &cut, &own);
        assert_eq!(found.unwrap_err(), AlignError::OneBurst { which });
    }
    // None of a drive that repeats.
    let middle = other(2.0, 9.0);
    let own = middle.records(&of_tone.drive);
    let found = aligned(&of_tone.drive, Some(&of_tone.bursts), &middle, &own);
    assert!(found.is_err(), "{found:?}");
    // None of noise: as without bursts.
    let own = middle.records(&of_noise.drive);
    let found = aligned(&of_noise.drive, Some(&of_noise.bursts), &middle, &own).unwrap();
    check("no burst", &middle, &found, own.len());
}

/// What speaks against the times of an alignment.
const AGAINST: [&str; 7] = [
    "bursts_apart",
    "step",
    "uneven",
    "drive_not_there",
    "between_not_seen",
    "uncertain",
    "left_out",
];

#[test]
fn lost_samples_are_refused_or_reported() {
    lost_samples_are_refused_or_reported_in(&[29_000]);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_lost_samples_are_refused_or_reported() {
    lost_samples_are_refused_or_reported_in(&[12_000, 29_000, 46_000]);
}

fn lost_samples_are_refused_or_reported_in(places: &[usize]) {
    let other = Other {
        rate_hz: 5000.0,
        ppm: 30.0,
        from_s: 0.1,
        to_s: 13.9,
        noise: 0.03,
        seed: 12,
    };
    for (what, plain) in [
        ("noise", noise(9, 12.0)),
        ("tone", tone(250.0, 12.0)),
        ("grating", grating(12.0)),
    ] {
        let with = with_bursts(&plain, &burst()).unwrap();
        let whole = other.records(&with.drive);
        // 0.2 ms; 2 ms; one period of the tone; more than a search reaches; one of the grating; a second.
        for lost in [1, 10, 20, 35, 500, 5000] {
            // Near the ends of the drive, and in its middle.
            for &at in places {
                let mut own = whole.clone();
                own.drain(at..at + lost);
                let said = |found: &Result<Alignment, AlignError>| match found {
                    Ok(found) => codes(found)
                        .iter()
                        .any(|code| AGAINST.contains(&code.as_str())),
                    Err(_) => true,
                };
                let found = aligned(&with.drive, Some(&with.bursts), &other, &own);
                assert!(
                    said(&found),
                    "{what}, {lost} at {at} with bursts: {:?}",
                    found.map(|found| (codes(&found), found.drift_ppm))
                );
                if what == "noise" {
                    let found = aligned(&with.drive, None, &other, &own);
                    assert!(
                        said(&found),
                        "{what}, {lost} at {at}: {:?}",
                        found.map(|found| (codes(&found), found.drift_ppm))
                    );
                }
            }
        }
    }
}

/// Whether the first and the last sample lie where they are stated to, within the interval; of a recording whose samples `lost` are missing.
fn holds(found: &Alignment, other: &Other, lost: &[(usize, usize)], samples: usize) -> bool {
    let last = samples - 1;
    let missing: usize = lost.iter().map(|(_, count)| count).sum();
    let truths = [
        other.truth(0.0),
        other.truth((last + missing) as f64 / other.rate_hz),
    ];
    let at_s = [0.0, last as f64 / other.rate_hz];
    at_s.iter().zip(truths).all(|(at_s, truth)| {
        (found.on_drive(Seconds(*at_s)).0 - truth).abs() <= found.uncertainty_s.0
    })
}

/// Samples that are missing early, late, or one by one: what is stated of the first and the last sample holds.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_intervals_hold_where_samples_are_missing() {
    let other = Other {
        rate_hz: 8000.0,
        ppm: 40.0,
        from_s: -0.5,
        to_s: 19.5,
        noise: 1e-3,
        seed: 4,
    };
    for seed in [31, 32] {
        let drive = noise(seed, 20.0);
        let whole = other.records(&drive);
        let spread = |count: usize, each: usize| -> Vec<(usize, usize)> {
            (0..count)
                .map(|i| ((i + 1) * whole.len() / (count + 1), each))
                .collect()
        };
        let cases = [
            vec![(12_000, 40)],
            vec![(12_000, 80)],
            vec![(12_000, 200)],
            vec![(25_600, 80)],
            vec![(137_600, 400)],
            vec![(60_000, 8000)],
            spread(3, 1),
            spread(3, 2),
            spread(6, 1),
        ];
        for lost in cases {
            let mut own = whole.clone();
            for (at, count) in lost.iter().rev() {
                own.drain(*at..at + count);
            }
            let found = aligned(&drive, None, &other, &own);
            let Ok(found) = found else { continue };
            assert!(
                holds(&found, &other, &lost, own.len()),
                "{seed}, {lost:?}: {:?} ± {:?}, {:?}",
                found.offset_s,
                found.uncertainty_s,
                codes(&found)
            );
            let ([low, high], said) = (found.drift_interval_ppm, codes(&found));
            assert!(
                (low..=high).contains(&other.ppm),
                "{seed}, {lost:?}: {low} to {high} ppm, {said:?}"
            );
            let of_loss = ["step", "scatter"];
            assert!(
                said.iter().any(|code| of_loss.contains(&code.as_str())),
                "{seed}, {lost:?}: {said:?}"
            );
        }
        let plain = aligned(&drive, None, &other, &whole).unwrap();
        assert_eq!(codes(&plain), [""; 0], "{seed}");
        assert!(plain.uncertainty_s.0 < 1e-5);
    }
}

/// A drive of narrow noise is like itself a few milliseconds later; that is no second place.
#[test]
fn a_narrow_drive_has_one_place() {
    a_narrow_drive_has_one_place_in(0..1);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_a_narrow_drive_has_one_place() {
    a_narrow_drive_has_one_place_in(0..6);
}

fn a_narrow_drive_has_one_place_in(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let mut draw = draws(100 + seed);
        let lines: Vec<[f64; 3]> = (0..80)
            .map(|_| [30.0 + 300.0 * draw(), TAU * draw(), 0.2 + draw()])
            .collect();
        let drive = drive_of(20.0, |t| {
            let of = |[hz, phase, size]: &[f64; 3]| size * (TAU * hz * t + phase).sin();
            0.02 * lines.iter().map(of).sum::<f64>()
        });
        let other = Other {
            rate_hz: 8000.0,
            ppm: 40.0,
            from_s: -0.5,
            to_s: 19.5,
            noise: 1e-3,
            seed,
        };
        let own = other.records(&drive);
        let found = aligned(&drive, None, &other, &own);
        let found = found.unwrap_or_else(|error| panic!("{seed}: {error}"));
        check("narrow noise", &other, &found, own.len());
    }
}

#[test]
fn another_drive_silence_and_two_playbacks_are_refused_or_reported() {
    let with = with_bursts(&noise(1, 10.0), &burst()).unwrap();
    let other = Other {
        rate_hz: 10_000.0,
        ppm: -40.0,
        from_s: -0.4,
        to_s: 12.5,
        noise: 0.03,
        seed: 1,
    };
    let find = |own: &[f64]| aligned(&with.drive, Some(&with.bursts), &other, own);
    for wrong in [noise(2, 10.0), tone(200.0, 10.0)] {
        let played = with_bursts(&wrong, &burst()).unwrap();
        let own = other.records(&played.drive);
        // The same bursts in the same places: times are right, and the drive is not.
        let said = codes(&find(&own).unwrap());
        assert!(said.contains(&"drive_not_there".into()), "{said:?}");
        // Without bursts.
        let own = other.records(&wrong);
        let found = find(&own);
        assert!(
            matches!(found, Err(AlignError::NotThere { .. })),
            "{found:?}"
        );
    }
    let found = find(&vec![0.0; 120_000]);
    assert!(
        matches!(found, Err(AlignError::FewBlocks { found: 0 })),
        "{found:?}"
    );
    let mut more = normal(3);
    let found = find(&(0..120_000).map(|_| more()).collect::<Vec<_>>());
    assert!(
        matches!(found, Err(AlignError::NotThere { .. })),
        "{found:?}"
    );
    let once = other.records(&with.drive);
    let found = find(&[once.clone(), once.clone()].concat());
    assert!(
        matches!(found, Err(AlignError::SeveralPlaces { .. })),
        "{found:?}"
    );
    // The end of one playback and the beginning of the next.
    let found = find(&[&once[60_000..], &once[..60_000]].concat());
    assert!(
        matches!(found, Err(AlignError::BurstsApart { .. })),
        "{found:?}"
    );
}

#[test]
fn the_drive_is_kept_between_its_bursts() {
    let plain = noise(6, 3.0);
    let with = with_bursts(&plain, &burst()).unwrap();
    let Bursts { first, drive, last } = with.bursts;
    let at = |t: Seconds| (t.0 * DRIVE_HZ).round() as usize;
    let samples = with.drive.samples();
    let (from, to) = (
        at(drive.from_s),
        at(Seconds(drive.from_s.0 + drive.length_s.0)),
    );
    assert_eq!(&samples[from..to], plain.samples());
    assert!((with.drive.duration().0 - (3.0 + 2.0 * 0.5 + 4.0 * 0.25)).abs() < 1e-9);
    let part = |from: Seconds| &samples[at(from)..at(from) + 24_000];
    let backwards: Vec<f64> = part(last.from_s).iter().rev().copied().collect();
    assert_eq!(part(first.from_s), backwards);
    let peak = part(first.from_s)
        .iter()
        .fold(0.0, |a: f64, b| a.max(b.abs()));
    // A tenth at each end is lower, and the sweep passes its peak in between.
    assert!(peak <= 0.4 && peak > 0.399, "{peak}");
    assert_eq!(Bursts::of_events(&with.bursts.events()), Some(with.bursts));
    let mut twice = with.bursts.events();
    twice.extend(with.bursts.events());
    assert_eq!(Bursts::of_events(&twice), None);
}

#[test]
fn bursts_that_cannot_be_are_refused() {
    let plain = noise(6, 3.0);
    let refused = |change: &dyn Fn(&mut BurstConfig)| {
        let mut config = burst();
        change(&mut config);
        with_bursts(&plain, &config).unwrap_err()
    };
    let band = |low, high| Band::new(Hertz(low), Hertz(high)).unwrap();
    assert!(matches!(
        refused(&|c| c.band = band(100.0, 23_000.0)),
        AlignError::BurstBand { .. }
    ));
    assert!(matches!(
        refused(&|c| c.band = band(100.0, 150.0)),
        AlignError::Short { .. }
    ));
    for bad in [0.0, -1.0, 1.1, f64::NAN] {
        assert!(matches!(
            refused(&|c| c.peak = bad),
            AlignError::Peak { .. }
        ));
    }
    for bad in [-1.0, 1e9, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            refused(&|c| c.duration_s = Seconds(bad)),
            AlignError::Lengths { .. }
        ));
        assert!(matches!(
            refused(&|c| c.guard_s = Seconds(bad)),
            AlignError::Lengths { .. }
        ));
    }
    let like = with_bursts(&plain, &burst()).unwrap().drive;
    let found = with_bursts(&like, &burst());
    assert!(matches!(found, Err(AlignError::Alike { .. })), "{found:?}");
    assert!(AlignConfig::usual(rate(100.0), rate(48_000.0)).is_err());
}

/// The sweep of `scipy.signal.chirp` in a Tukey window, and a recording that SciPy made by a cubic spline and placed by Hilbert transforms
/// (golden/align.py).
#[test]
fn scipy_has_the_same_burst_and_the_same_place() {
    let golden: serde_json::Value =
        serde_json::from_str(include_str!("golden/align.json")).unwrap();
    let numbers = |name: &str| -> Vec<f64> {
        let all = golden[name].as_array().unwrap().iter();
        all.map(|v| v.as_f64().unwrap()).collect()
    };
    let of = |by: &str, what: &str| golden[by][what].as_f64().unwrap();
    let silent = Series::new(vec![0.0; 4000], rate(4000.0)).unwrap();
    let made = with_bursts(&silent, &BurstConfig::usual(rate(4000.0), 0.4).unwrap()).unwrap();
    // A quarter of a second of silence first.
    let own = made.drive.samples()[1000..3000].iter().step_by(10);
    for (own, scipy) in own.zip(numbers("burst")) {
        assert!((own - scipy).abs() < 1e-12, "{own} {scipy}");
    }
    let (drive, own) = (numbers("drive"), numbers("recorded"));
    let config = AlignConfig {
        band: Band::new(Hertz(50.0), Hertz(600.0)).unwrap(),
        block_s: Seconds(0.5),
        most_drift_ppm: 300.0,
    };
    let both = ((&*drive, rate(2000.0)), (&*own, rate(1600.0)));
    let found = align(both.0, both.1, &config).unwrap();
    for by in ["truth", "scipy"] {
        let offset_s = found.offset_s.0 - of(by, "offset_s");
        let drift_ppm = found.drift_ppm - of(by, "drift_ppm");
        // Noise of 5 % of the rms leaves 2 µs and 1 ppm.
        assert!(
            offset_s.abs() < 5e-6 && drift_ppm.abs() < 2.0,
            "{by}: {offset_s} s, {drift_ppm} ppm"
        );
    }
}
