use super::*;
use crate::quantity::Band;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

/// Noise from `low` to `high` Hz as a sum of sines: known at any time.
struct Noise {
    lines: Vec<[f64; 3]>,
}

impl Noise {
    fn new(seed: u64, low_hz: f64, high_hz: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = move || rng.next_u64() as f64 / u64::MAX as f64;
        let line = |_| {
            let hz = low_hz + (high_hz - low_hz) * draw();
            [hz, 6.3 * draw(), 0.2 + draw()]
        };
        Self {
            lines: (0..90).map(line).collect(),
        }
    }

    fn at(&self, t_s: f64) -> f64 {
        let of =
            |[hz, phase, size]: &[f64; 3]| size * (std::f64::consts::TAU * hz * t_s + phase).sin();
        self.lines.iter().map(of).sum()
    }
}

fn config() -> AlignConfig {
    AlignConfig {
        band: Band::new(Hertz(20.0), Hertz(900.0)).unwrap(),
        block_s: Seconds(1.0),
        most_drift_ppm: 300.0,
    }
}

/// A drive of `seconds` at 8 kHz, and its recording at 5 kHz by a clock that runs `drift_ppm` fast, from `from_s` to `to_s` of the drive.
fn recorded(
    noise: &Noise,
    seconds: f64,
    [from_s, to_s]: [f64; 2],
    drift_ppm: f64,
    snr: f64,
) -> [(Vec<f64>, SampleRate); 2] {
    let (drive_rate, rate) = (
        SampleRate::new(8000.0).unwrap(),
        SampleRate::new(5000.0).unwrap(),
    );
    let inside = |t: f64| {
        if (0.0..seconds).contains(&t) {
            noise.at(t)
        } else {
            0.0
        }
    };
    let drive = (0..(seconds * 8000.0) as usize).map(|i| inside(i as f64 / 8000.0));
    let step_s = 1.0 / (5000.0 * (1.0 + 1e-6 * drift_ppm));
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut draw = move || rng.next_u64() as f64 / u64::MAX as f64 - 0.5;
    let count = ((to_s - from_s) / step_s) as usize;
    let own = (0..count).map(|i| inside(from_s + i as f64 * step_s) + 25.0 / snr * draw());
    [(drive.collect(), drive_rate), (own.collect(), rate)]
}

fn aligned(
    both: &[(Vec<f64>, SampleRate); 2],
    config: &AlignConfig,
) -> Result<Alignment, AlignError> {
    align((&both[0].0, both[0].1), (&both[1].0, both[1].1), config)
}

#[test]
fn another_rate_a_drift_and_cut_ends_are_found_within_a_tenth_of_a_millisecond() {
    let noise = Noise::new(1, 60.0, 800.0);
    for (drift_ppm, extent) in [
        (100.0, [3.7123, 26.4]),
        (-100.0, [5.0, 29.0]),
        (0.0, [-2.0, 33.0]),
    ] {
        let both = recorded(&noise, 30.0, extent, drift_ppm, 10.0);
        let found = aligned(&both, &config()).unwrap();
        let [from_s, to_s] = extent;
        // The truth of the first and the last sample.
        let truth = |recorded_s: f64| from_s + recorded_s / (1.0 + 1e-6 * drift_ppm);
        let last_s = both[1].0.len() as f64 / 5000.0;
        for recorded_s in [0.0, 0.5 * last_s, last_s] {
            let error_s = found.on_drive(Seconds(recorded_s)).0 - truth(recorded_s);
            assert!(error_s.abs() < 2e-5, "{drift_ppm} {extent:?}: {error_s}");
            assert!(
                error_s.abs() < 3.0 * found.uncertainty_s.0.max(1e-6),
                "{error_s} {found:?}"
            );
        }
        assert!(
            (found.drift_ppm - drift_ppm).abs() < 1.0,
            "{}",
            found.drift_ppm
        );
        let [low, high] = found.drift_interval_ppm;
        assert!(low < high && high - low < 4.0, "{low} {high}");
        let back = found.on_recording(found.on_drive(Seconds(7.0)));
        assert!((back.0 - 7.0).abs() < 1e-9);
        let covered_s = [from_s.max(0.0), to_s.min(30.0)];
        for (found_s, covered_s) in found.covered_s.iter().zip(covered_s) {
            assert!((found_s.0 - covered_s).abs() < 1e-3, "{found:?}");
        }
    }
}

#[test]
fn a_recording_is_placed_on_the_clock_of_the_drive() {
    let noise = Noise::new(4, 60.0, 800.0);
    let both = recorded(&noise, 20.0, [1.3, 18.2], 100.0, 1e9);
    let found = aligned(&both, &config()).unwrap();
    let (placed, first_s) = found.placed(&both[1].0, both[1].1);
    let mut worst: f64 = 0.0;
    for (i, value) in placed.iter().enumerate().skip(200).take(placed.len() - 400) {
        let truth = noise.at(first_s.0 + i as f64 / 5000.0);
        worst = worst.max((value - truth).abs());
    }
    // A time error of 5 µs at 800 Hz, of an rms of 5.
    assert!(worst < 0.6, "{worst}");
    assert!((first_s.0 * 5000.0).fract().abs() < 1e-6);
}

#[test]
fn what_is_not_there_or_repeats_is_refused() {
    let noise = Noise::new(1, 60.0, 800.0);
    let mut both = recorded(&noise, 20.0, [2.0, 18.0], 50.0, 10.0);
    let other = Noise::new(2, 60.0, 800.0);
    let wrong = recorded(&other, 20.0, [2.0, 18.0], 50.0, 10.0);
    let found = aligned(&[both[0].clone(), wrong[1].clone()], &config());
    assert!(
        matches!(found, Err(AlignError::NotThere { .. })),
        "{found:?}"
    );
    // The same 4 s again and again, of which the recording holds the middle.
    let period = 4 * 8000;
    for i in period..both[0].0.len() {
        both[0].0[i] = both[0].0[i - period];
    }
    let drive = &both[0].0;
    let own: Vec<f64> = (0..8 * 5000).map(|i| drive[6 * 8000 + i * 8 / 5]).collect();
    let found = aligned(&[both[0].clone(), (own, both[1].1)], &config());
    assert!(
        matches!(found, Err(AlignError::SeveralPlaces { .. })),
        "{found:?}"
    );
    let silence = vec![0.0; 50_000];
    assert!(aligned(&[both[0].clone(), (silence, both[1].1)], &config()).is_err());
    let short = both[1].0[..9000].to_vec();
    let found = aligned(&[both[0].clone(), (short, both[1].1)], &config());
    assert!(
        matches!(found, Err(AlignError::FewBlocks { found: 1 })),
        "{found:?}"
    );
    let mut broken = both.clone();
    broken[1].0[77] = f64::NAN;
    assert!(matches!(
        aligned(&broken, &config()),
        Err(AlignError::NotFinite { .. })
    ));
    let wide = AlignConfig {
        band: Band::new(Hertz(20.0), Hertz(2400.0)).unwrap(),
        ..config()
    };
    for most_drift_ppm in [f64::INFINITY, f64::NAN, -1.0] {
        let endless = AlignConfig {
            most_drift_ppm,
            ..config()
        };
        assert_eq!(aligned(&both, &endless), Err(AlignError::Settings));
    }
    assert!(matches!(
        aligned(&both, &wide),
        Err(AlignError::Band { .. })
    ));
}

#[test]
fn lost_samples_are_said() {
    let noise = Noise::new(7, 60.0, 800.0);
    let mut both = recorded(&noise, 30.0, [0.0, 30.0], 20.0, 10.0);
    // 2 ms are missing from the middle on.
    both[1].0.drain(75_000..75_010);
    let found = aligned(&both, &config()).unwrap();
    let uncertain = |warning: &Warning| {
        let fault = warning.kind();
        matches!(
            fault,
            Some(AlignWarning::Doubtful {
                fault: AlignFault::Uncertain { .. }
            })
        )
    };
    assert!(found.warnings.iter().any(uncertain), "{found:?}");
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_intervals_hold_the_truth() {
    let mut held = 0;
    for seed in 0..20 {
        let noise = Noise::new(100 + seed, 60.0, 800.0);
        let both = recorded(&noise, 12.0, [0.4, 11.5], 40.0, 2.0);
        let found = aligned(&both, &config()).unwrap();
        let [low, high] = found.drift_interval_ppm;
        held += usize::from(low <= 40.0 && 40.0 <= high);
    }
    // 95 % of 20, two binomial standard deviations.
    assert!(held >= 17, "{held}");
}
