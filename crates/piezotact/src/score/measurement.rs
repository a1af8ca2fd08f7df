//! A measurement held against its target, with what both files say.

use super::perceived::perceived;
use super::{ScoreConfig, with_perceptible_difference};
use crate::checksum::Checksum;
use crate::clipping::clipping;
use crate::integrity::inspect;
use crate::quantity::{Acceleration, Band, Decibels, Drive, Hertz, Seconds};
use crate::recording::{OtherOrigin, Recording, RecordingWarning, RehearsalWarning, rehearsed_on};
use crate::render::Rendering;
use crate::resample::{CommonRate, to_common_rate};
use crate::series::Series;
use crate::statistics::standard_deviation;
use crate::verify::{Measured, Verification, VerifyConfig, VerifyError, verify};
use crate::warning::{Warning, Warnings};

/// The texture that was to be felt.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// The name of its file.
    pub name: &'a str,
    pub recording: &'a Recording,
    /// The texture, m/s².
    pub texture: &'a Series<Acceleration>,
}

/// What was measured while a drive was played.
#[derive(Clone, Debug)]
pub struct Measurement<'a> {
    pub recording: &'a Recording,
    /// The acceleration, m/s².
    pub response: Series<Acceleration>,
    /// The drive that was recorded beside it, and the level at which the device clips, of full scale; absent where none was.
    pub drive: Option<(&'a Series<Drive>, f64)>,
    /// How the drive was made; absent where nothing says it.
    pub rendering: Option<&'a Rendering>,
}

/// A measurement with how close it came.
#[derive(Clone, Debug)]
pub struct JudgedMeasurement {
    /// What was found, with the felt difference and the warnings about both files.
    pub verification: Verification,
    /// How it was compared.
    pub config: VerifyConfig,
    /// The target at the rate of the comparison, m/s².
    pub texture: Series<Acceleration>,
}

/// The share of the power of `target` about its mean that `compared`, the same at another rate, still has.
fn power_kept(target: &Series<Acceleration>, compared: &Series<Acceleration>) -> f64 {
    let [own, kept] = [target, compared].map(|x| standard_deviation(x.samples()));
    if own > 0.0 {
        (kept / own).powi(2).min(1.0)
    } else {
        1.0
    }
}

/// How close `measured` came to `target` over `band`, with the warnings about both and `more_warnings`, each once.
///
/// Formula: that of [`verify`] and [`with_perceptible_difference`], at the lower rate of the two, for the bands and the level that its
/// rendering states.
///
/// Source: as [`verify`].
///
/// # Errors
/// [`VerifyError`] for rates without a common one, and for what [`verify`] refuses.
pub fn judged_measurement(
    target: Target<'_>,
    measured: Measurement<'_>,
    band: Band,
    more_warnings: &[Warning],
) -> Result<JudgedMeasurement, VerifyError> {
    let mut warnings = warnings_before(target, &measured, more_warnings);
    // Clipping is looked for at the rate it was acquired with.
    let clipped = measured.rendering.map(|r| r.headroom.clipped_fraction);
    let clipping = clipping(&measured.response, measured.drive, clipped);
    let lost = longest_loss(measured.recording, &measured.response);
    let own = longest_loss(target.recording, target.texture);
    let CommonRate {
        first: texture,
        second: response,
        warning,
    } = to_common_rate(
        ("the target", target.texture.clone()),
        ("the measurement", measured.response),
    )?;
    warnings.extend(warning);
    let mut config = VerifyConfig::over(band, texture.rate().hz());
    if let Some(rendering) = measured.rendering {
        config.reached.clone_from(&rendering.achievable_band_hz);
        config.level = Decibels(rendering.level_db);
        config = config.rendered_as(&rendering.config, rendering.mode());
    }
    let compared = Measured {
        response: &response,
        clipping,
    };
    let mut verification = with_perceptible_difference(verify(&texture, compared, &config)?);
    verification.texture_share *= power_kept(target.texture, &texture);
    if verification.is_of_a_part() {
        let whole = texture.clone().amplified(config.level);
        verification.whole_texture_jnd =
            whole_difference_jnd(&whole, &response, verification.delay_s);
    }
    // What the target lacks itself is not lost by the rendering.
    if lost.0 > own.0 {
        verification = verification.with_samples_lost(lost);
    }
    let made = measured.rendering.map(|made| &made.about.provenance);
    let played = &measured.recording.about.provenance;
    let rehearsed = made.and_then(|made| rehearsed_on(made, played));
    verification.is_rehearsal = rehearsed.is_some();
    warnings.extend(rehearsed.map(|transfer| RehearsalWarning::PlayedThroughItsOwn { transfer }));
    verification.warnings.put_first(warnings);
    Ok(JudgedMeasurement {
        verification,
        config,
        texture,
    })
}

/// The vibrations that a finger feels, Hz.
const FELT_HZ: (f64, f64) = (10.0, 1000.0);

/// The difference that a finger could feel between `texture` and `response`, which begins `delay_s` later, at all frequencies that are felt, JND; `None` where
/// it cannot be computed.
fn whole_difference_jnd(
    texture: &Series<Acceleration>,
    response: &Series<Acceleration>,
    delay_s: f64,
) -> Option<f64> {
    let rate = texture.rate();
    let later = (delay_s * rate.hz()).round() as i64;
    // The part that both have, in samples of the texture.
    let from = (-later).max(0) as usize;
    let to =
        (response.samples().len() as i64 - later).clamp(0, texture.samples().len() as i64) as usize;
    let both = [(texture, 0), (response, later)].map(|(x, later)| {
        let part = x
            .samples()
            .get((from as i64 + later) as usize..(to as i64 + later) as usize);
        Series::<Acceleration>::new(part?.to_vec(), rate).ok()
    });
    let [Some(texture), Some(response)] = &both else {
        return None;
    };
    let band = Band::new(Hertz(FELT_HZ.0), Hertz(FELT_HZ.1.min(rate.nyquist().0))).ok()?;
    let found = perceived(
        [texture, response],
        None,
        &ScoreConfig::over(band, rate.hz()),
    );
    Some(found.ok()?.difference.jnd.value)
}

/// The longest stretch that `recording` lost, or in which `series`, the channel of it that is compared, falls to its floor, s.
fn longest_loss(recording: &Recording, series: &Series<Acceleration>) -> Seconds {
    let gaps = inspect(series).gaps;
    let seen = gaps
        .iter()
        .map(|span| series.rate().duration_of(span.len()).0);
    Seconds(seen.fold(recording.about.provenance.losses.longest().0, f64::max))
}

/// What gives a warning before anything is compared: of both recordings, of the rendering, and whether they belong together.
fn warnings_before(target: Target<'_>, measured: &Measurement<'_>, more: &[Warning]) -> Warnings {
    let mut warnings: Warnings = target.recording.about.warnings.iter().cloned().collect();
    warnings.extend(measured.recording.about.warnings.iter().cloned());
    warnings.extend(more.iter().cloned());
    let Some(rendering) = measured.rendering else {
        return warnings;
    };
    let condition = &measured.recording.about.condition;
    warnings.extend(rendering.about.condition.warnings_when_measured(condition));
    warnings.extend(other_target(target, rendering));
    warnings.extend(rendering.about.warnings.iter().cloned());
    warnings
}

/// The warning that `target` is another texture than that of `rendering`: by its samples where the rendering states them, else by name.
fn other_target(target: Target<'_>, rendering: &Rendering) -> Option<RecordingWarning> {
    let found = Checksum::of(target.texture.samples().iter().copied());
    let is_named_alike = rendering.target == target.name;
    let is_other = match rendering.target_samples {
        Some(samples) => samples != found,
        None => !rendering.target.is_empty() && !is_named_alike,
    };
    let [rendered, compared] = match rendering.target_samples {
        Some(samples) if is_named_alike => {
            [samples, found].map(|checksum| format!("{} (checksum {checksum})", target.name))
        }
        _ => [rendering.target.clone(), target.name.to_owned()],
    };
    is_other.then_some(RecordingWarning::OtherOrigin {
        what: OtherOrigin::Target { rendered, compared },
    })
}

#[cfg(test)]
mod tests {
    use num_complex::Complex;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;
    use crate::criterion::Outcome;
    use crate::quantity::{Force, Quantity, SampleRate, Unit};
    use crate::recording::{Channel, Condition, Provenance};
    use crate::render::{RenderConfig, render};
    use crate::transfer::{Estimator, TransferFunction};
    use crate::verify::VerifyCriterion;

    const RATE_HZ: f64 = 5000.0;
    const COUNT: usize = 15_000;

    /// Noise with a spectrum that falls, 1 m/s² rms, in the middle of a recording with 0.3 s of silence before and after.
    fn texture(seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut slow = 0.0;
        let noise = (0..COUNT).map(|_| {
            slow = 0.8 * slow + uniform(&mut rng);
            slow
        });
        let mut samples: Vec<f64> = noise.collect();
        let level = crate::statistics::rms(&samples);
        samples.iter_mut().for_each(|v| *v /= level);
        samples
    }

    fn uniform(rng: &mut ChaCha8Rng) -> f64 {
        (rng.next_u64() >> 11) as f64 * 2f64.powi(-52) - 1.0
    }

    /// What a sensor with 5 mm/s² of noise reads of `delivered`.
    fn read(delivered: &[f64], seed: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let silence = [0.0; 1500];
        let all = silence.iter().chain(delivered).chain(&silence);
        all.map(|v| v + 0.009 * uniform(&mut rng)).collect()
    }

    fn zeroed(mut samples: Vec<f64>, from: usize, count: usize) -> Vec<f64> {
        samples[from..from + count].fill(0.0);
        samples
    }

    fn recording(acceleration: Vec<f64>, force: Vec<f64>) -> Recording {
        let channel = |name: &str, unit: Unit, samples| Channel {
            name: name.into(),
            unit,
            samples,
        };
        Recording::new(
            vec![
                channel("acc", Acceleration::UNIT, acceleration),
                channel("fz", Force::UNIT, force),
            ],
            SampleRate::new(RATE_HZ).unwrap(),
            Condition::default(),
            Provenance::default(),
        )
        .unwrap()
    }

    fn band() -> Band {
        Band::new(Hertz(30.0), Hertz(500.0)).unwrap()
    }

    /// The criterion on drop-outs, and the verdict, of `measured` held against `target`.
    fn compared(measured: &Recording, target: &Recording) -> (Outcome, Verification) {
        let verification = judged(measured, target, None);
        let criterion = verification.criterion(VerifyCriterion::DropOut);
        (criterion.unwrap().outcome, verification)
    }

    fn judged(
        measured: &Recording,
        target: &Recording,
        rendering: Option<&Rendering>,
    ) -> Verification {
        let texture: Series<Acceleration> = target.series(Some("acc")).unwrap();
        let compared = judged_measurement(
            Target {
                name: "target.wav",
                recording: target,
                texture: &texture,
            },
            Measurement {
                recording: measured,
                response: measured.series(Some("acc")).unwrap(),
                drive: None,
                rendering,
            },
            band(),
            &[],
        );
        compared.unwrap().verification
    }

    fn force() -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let all = 0..COUNT + 3000;
        all.map(|_| 0.5 + 0.05 * uniform(&mut rng)).collect()
    }

    /// A force that falls to zero for 0.3 s does not say that the vibration was not delivered; 0.1 s of zeros of the acceleration do,
    /// unless the target holds them.
    #[test]
    fn only_a_drop_out_of_the_compared_channel_counts() {
        let of_target = texture(3);
        let target = recording(of_target.clone(), force()[..COUNT].to_vec());
        let whole = compared(&recording(read(&of_target, 1), force()), &target);
        assert_eq!(whole.0, Outcome::Met, "{}", whole.1.sentence());

        let force_lost = recording(read(&of_target, 1), zeroed(force(), 6000, 1500));
        let (outcome, verification) = compared(&force_lost, &target);
        assert_eq!(outcome, Outcome::Met, "{}", verification.sentence());
        assert_eq!(verification.verdict, whole.1.verdict);

        let acceleration_lost = recording(zeroed(read(&of_target, 1), 6000, 500), force());
        let (outcome, verification) = compared(&acceleration_lost, &target);
        assert_ne!(outcome, Outcome::Met, "{}", verification.sentence());

        let of_target = zeroed(of_target, 4500, 500);
        let target = recording(of_target.clone(), force()[..COUNT].to_vec());
        let (outcome, verification) = compared(&acceleration_lost, &target);
        assert_eq!(outcome, Outcome::Met, "{}", verification.sentence());
    }

    /// What device or journal lost counts wherever it is, unless the target lacks as much.
    #[test]
    fn reported_losses_count() {
        let of_target = texture(3);
        let mut target = recording(of_target.clone(), force()[..COUNT].to_vec());
        let mut measured = recording(read(&of_target, 1), force());
        measured.about.provenance.losses.stretches_s = vec![[1.0, 1.008]];
        assert_eq!(compared(&measured, &target).0, Outcome::Met);
        measured.about.provenance.losses.stretches_s = vec![[1.0, 1.008], [2.0, 2.025]];
        assert_ne!(compared(&measured, &target).0, Outcome::Met);
        target.about.provenance.losses.stretches_s = vec![[0.5, 0.53]];
        assert_eq!(compared(&measured, &target).0, Outcome::Met);
    }

    /// What answered states which transfer function it was made of, and the drive with which it was rendered.
    #[test]
    fn a_drive_played_through_its_own_transfer_function_is_a_rehearsal() {
        let of_target = texture(3);
        let target = recording(of_target.clone(), force()[..COUNT].to_vec());
        let function = function();
        let rendering = rendered(&target, &function);
        let mut measured = recording(read(&of_target, 1), force());
        for (through, is_rehearsal) in [
            (None, false),
            (Some(Checksum::of([1.0])), false),
            (Some(function.checksum()), true),
        ] {
            measured.about.provenance.answered_with = through;
            let found = judged(&measured, &target, Some(&rendering));
            assert_eq!(found.is_rehearsal, is_rehearsal);
            assert_eq!(found.sentence().contains("rehearsal"), is_rehearsal);
            let warnings = found.warnings.iter();
            let own = warnings.filter(|one| one.kind::<RehearsalWarning>().is_some());
            assert_eq!(own.count(), usize::from(is_rehearsal));
        }
    }

    /// The device of these tests.
    fn function() -> TransferFunction<Drive, Acceleration> {
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let lines = vec![Complex::new(20.0, 0.0); 501];
        let coherence = vec![0.99; 501];
        TransferFunction::from_lines(lines, coherence, 5.0, rate, Estimator::H1, 100).unwrap()
    }

    /// How `target`, called target.wav, is rendered through `function`.
    fn rendered(target: &Recording, function: &TransferFunction<Drive, Acceleration>) -> Rendering {
        let wanted: Series<Acceleration> = target.series(Some("acc")).unwrap();
        let config = RenderConfig::over(band(), wanted.rate());
        let drive = render(&wanted, function, &config).unwrap();
        Rendering::of(&drive, "target.wav", 0.0)
    }

    /// A texture is known by its samples, not by what it is called; by its name where the rendering does not state them.
    #[test]
    fn a_drive_of_another_texture_is_a_warning() {
        let of_target = texture(3);
        let target = recording(of_target.clone(), force()[..COUNT].to_vec());
        let measured = recording(read(&of_target, 1), force());
        let [own, other] = [of_target, texture(4)].map(|samples| Some(Checksum::of(samples)));
        let mut rendering = rendered(&target, &function());
        for (name, samples, is_warned) in [
            ("target.wav", own, false),
            ("texture", own, false),
            ("target.wav", other, true),
            ("texture", other, true),
            ("target.wav", None, false),
            ("texture", None, true),
            ("", None, false),
        ] {
            rendering.target = name.into();
            rendering.target_samples = samples;
            let found = judged(&measured, &target, Some(&rendering));
            let mut warnings = found.warnings.iter();
            let own = warnings.find(|one| one.code == "other_origin");
            assert_eq!(own.is_some(), is_warned, "{name} {samples:?}");
        }
    }
}
