//! Renderings of short and abrupt textures through a known plant, and the limits of devices.

use num_complex::Complex;

use super::*;
use crate::device::DeviceAtGain;
use crate::fourier::RealTransform;
use crate::quantity::{Acceleration, Hertz, Volts};
use crate::statistics::rms;
use crate::transfer::Estimator;
use std::f64::consts::TAU;

const RATE_HZ: f64 = 10_000.0;

fn rate() -> SampleRate {
    SampleRate::new(RATE_HZ).unwrap()
}

fn band() -> Band {
    Band::new(Hertz(20.0), Hertz(1000.0)).unwrap()
}

fn series(samples: Vec<f64>) -> Series<Acceleration> {
    Series::new(samples, rate()).unwrap()
}

/// The response to a force of a mass on a spring, as an acceleration: a resonance at `hz` of a damping ratio of `damping`.
fn response(at_hz: f64, hz: f64, damping: f64) -> Complex<f64> {
    let r = at_hz / hz;
    Complex::from(40.0 * (r * r + 0.02)) / Complex::new(1.0 - r * r, 2.0 * damping * r)
}

/// The transfer function of that resonance, with a line every hertz.
fn plant(hz: f64, damping: f64) -> TransferFunction<Drive, Acceleration> {
    let lines = (0..=1200).map(|k| response(f64::from(k), hz, damping));
    let coherence = vec![0.999; 1201];
    TransferFunction::from_lines(lines.collect(), coherence, 1.0, rate(), Estimator::H1, 100)
        .unwrap()
}

/// What the plant makes of a drive, with the silence around it.
fn played(drive: &Series<Drive>, hz: f64, damping: f64) -> Vec<f64> {
    let count = drive.samples().len();
    let n = crate::fourier::fast_length(2 * count);
    let mut samples = drive.samples().to_vec();
    samples.resize(n, 0.0);
    let mut bins = RealTransform::new(n).forward(&samples);
    for (k, bin) in bins.iter_mut().enumerate() {
        *bin *= response(k as f64 * RATE_HZ / n as f64, hz, damping);
    }
    let mut out = RealTransform::new(n).inverse(bins);
    out.truncate(count);
    out
}

/// A decaying tone that begins at its full amplitude in its first sample.
fn tick(seconds: f64) -> Vec<f64> {
    let count = (seconds * RATE_HZ) as usize;
    let at = |i: usize| {
        let t_s = i as f64 / RATE_HZ;
        0.5 * (-t_s / (0.25 * seconds)).exp() * (TAU * 220.0 * t_s).cos()
    };
    (0..count).map(at).collect()
}

fn config() -> RenderConfig {
    RenderConfig::over(band(), rate())
}

/// The level of what is felt of `target` re what it should be within the band, dB.
fn delivered_db(target: &[f64], config: &RenderConfig) -> f64 {
    let function = plant(250.0, 0.1);
    let rendered = render(&series(target.to_vec()), &function, config).unwrap();
    let felt = played(&rendered.drive, 250.0, 0.1);
    let mut wanted = vec![0.0; felt.len()];
    let begins = rate().samples_in(rendered.config.modelling_delay);
    for (place, v) in wanted[begins..].iter_mut().zip(target) {
        *place = *v;
    }
    let n = wanted.len();
    let in_band = |samples: &[f64]| {
        let mut bins = RealTransform::new(n).forward(samples);
        for (k, bin) in bins.iter_mut().enumerate() {
            *bin *= band().weight(k as f64 * RATE_HZ / n as f64, 0.1);
        }
        RealTransform::new(n).inverse(bins)
    };
    let wanted = in_band(&wanted);
    let near = begins..begins + target.len();
    20.0 * (rms(&felt[near.clone()]) / rms(&wanted[near])).log10()
}

fn faded() -> RenderConfig {
    RenderConfig {
        fade: Seconds(0.02),
        ..config()
    }
}

/// A tick that begins in its first sample used to lose 11 dB of 5 ms, and 4 dB of 40 ms, to a fade that was there by default.
#[test]
fn without_a_fade_nothing_of_a_texture_is_lost() {
    for seconds in [0.005, 0.02, 0.04, 0.3] {
        let change_db = delivered_db(&tick(seconds), &config());
        assert!(change_db.abs() < 0.1, "{seconds} s: {change_db:.2} dB");
    }
}

/// The level and the peak that a fade takes, dB, as the rendering says; none where it says nothing.
fn stated_loss(target: &[f64], config: &RenderConfig) -> Option<(f64, f64)> {
    let rendered = render(&series(target.to_vec()), &plant(250.0, 0.1), config).unwrap();
    let mut warnings = rendered.about.warnings.iter();
    warnings.find_map(|one| match one.kind() {
        Some(RenderWarning::Faded {
            level_db, peak_db, ..
        }) => Some((level_db, peak_db)),
        _ => None,
    })
}

/// A fade used to take the beginning of a tick, or of a texture that begins abruptly, without a word.
#[test]
fn what_a_fade_takes_is_stated() {
    let short = tick(0.04);
    let (level_db, _) = stated_loss(&short, &faded()).unwrap();
    assert!(level_db < -4.0, "{level_db}");
    assert!((delivered_db(&short, &faded()) - level_db).abs() < 1.0);
    let mut attack = noise();
    for (v, t) in attack.iter_mut().zip(tick(0.02)) {
        *v = 0.1 * *v + 20.0 * t;
    }
    let (level_db, peak_db) = stated_loss(&attack, &faded()).unwrap();
    assert!(peak_db < -6.0 && peak_db < level_db, "{peak_db} {level_db}");
    assert_eq!(stated_loss(&attack, &config()), None);
    let steady: Vec<f64> = noise().iter().map(|v| 0.5 * v).collect();
    assert_eq!(stated_loss(&steady, &faded()), None);
}

/// What is felt more than 2 ms before a tick begins, of all that is felt, dB.
fn before_db(phase: PhaseForm) -> f64 {
    let mut config = config();
    config.inverse.phase = phase;
    let function = plant(250.0, 0.1);
    let rendered = render(&series(tick(0.04)), &function, &config).unwrap();
    let felt = played(&rendered.drive, 250.0, 0.1);
    let begins = rate().samples_in(config.modelling_delay) - (0.002 * RATE_HZ) as usize;
    let power = |samples: &[f64]| samples.iter().map(|v| v * v).sum::<f64>();
    10.0 * (power(&felt[..begins]) / power(&felt)).log10()
}

/// The help said that the minimum phase has no pre-ringing.
#[test]
fn the_minimum_phase_rings_before_a_tick_as_well() {
    let [linear_db, minimum_db] = [PhaseForm::Linear, PhaseForm::Minimum].map(before_db);
    // −35.6 and −37.8 dB: both have the ringing of the edges of the band.
    assert!(
        (minimum_db - linear_db).abs() < 4.0,
        "{linear_db} {minimum_db}"
    );
}

fn noise() -> Vec<f64> {
    let mut state = 1u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 11) as f64 * 2f64.powi(-52) - 1.0
    };
    (0..20_000).map(|_| next()).collect()
}

/// A plant behind an amplifier of 20 that follows `slew_v_per_s`, 1 V at full scale.
fn behind_an_amplifier(slew_v_per_s: f64) -> TransferFunction<Drive, Acceleration> {
    let text = crate::device::BUILT_IN[1].1.replace(
        "slew = { current_a = 1.0 }",
        &format!("slew = {{ v_per_s = {slew_v_per_s:.1} }}"),
    );
    let device = DeviceDescription::from_toml(&text).unwrap();
    let set: DeviceAtGain = device.at_usual_gain();
    let mut function = plant(250.0, 0.1);
    function.drive = Some(DriveSetup::new(set, Volts(1.0), Some(80e-9)).unwrap());
    function
}

/// A drive that is steeper than the amplifier follows used to be written with a warning and a headroom of its peak alone.
#[test]
fn a_drive_beyond_a_limit_is_refused_in_slope_as_in_amplitude() {
    let target = series(noise().iter().map(|v| 0.5 * v).collect());
    let free = render(&target, &behind_an_amplifier(1e9), &config()).unwrap();
    assert!(free.headroom.headroom_db.unwrap() > 0.0);
    let asked = free.headroom.slope_v_per_s.unwrap();
    let slow = behind_an_amplifier(asked / 9.0);
    let refused = render(&target, &slow, &config()).unwrap_err();
    assert!(
        matches!(refused, RenderError::ExceedsSlew { .. }),
        "{refused}"
    );
    let fits_at = refused.fits_at().unwrap();
    assert!(
        (fits_at.0 + 20.0 * 9f64.log10()).abs() < 0.15,
        "{fits_at:?}"
    );
    let softer = render(&target.clone().amplified(fits_at), &slow, &config()).unwrap();
    let left = softer.headroom.headroom_db.unwrap();
    assert!((0.0..0.2).contains(&left), "{left}");
    assert!(
        softer.headroom.text().contains("slope"),
        "{}",
        softer.headroom.text()
    );
    let allowed = RenderConfig {
        clipping: Overload::Allow,
        ..config()
    };
    let beyond = render(&target, &slow, &allowed).unwrap();
    assert!(beyond.headroom.headroom_db.unwrap() < -19.0);
}

/// Where a few samples exceed the limit, attenuating lines for them gives up much of the band: both shares are said, and the level.
#[test]
fn drive_limited_says_how_few_samples_it_gives_the_band_up_for() {
    let mut samples: Vec<f64> = noise().iter().map(|v| 0.1 * v).collect();
    for (v, t) in samples[9000..].iter_mut().zip(tick(0.02)) {
        *v += 20.0 * t;
    }
    let mut config = config();
    let function = plant(250.0, 0.1);
    let target = series(samples);
    let own = render(
        &target,
        &function,
        &RenderConfig {
            clipping: Overload::Allow,
            ..config.clone()
        },
    );
    let peak = own.unwrap().headroom.peak;
    let target = target.amplified(Decibels::from_amplitude_ratio(1.4 / peak));
    config.inverse.inverse = Inverse::DriveLimited;
    let rendered = render(&target, &function, &config).unwrap();
    let said = rendered
        .about
        .warnings
        .iter()
        .find_map(|one| match one.kind() {
            Some(RenderWarning::BandPartLost {
                share,
                why:
                    PartLost::TurnedDown {
                        fits_at_db,
                        beyond_limit,
                    },
                ..
            }) => Some((share, fits_at_db, beyond_limit.unwrap())),
            _ => None,
        });
    let (share, fits_at_db, beyond) = said.unwrap();
    assert!(
        share > 0.15 && beyond > 0.0 && beyond < 0.01,
        "{share} {beyond}"
    );
    assert!((-3.1..-2.8).contains(&fits_at_db), "{fits_at_db}");
}
