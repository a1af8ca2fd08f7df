//! Writes a texture or a drive as HJIF for the actuator of a device.

use std::collections::BTreeMap;

use piezotact::Warning;
use piezotact::device::{ActuatorKind, DriveSetup};
use piezotact::quantity::{Band, Measure, Quantity, Unit};
use piezotact::series::Series;

use super::Mismatch;
use super::clip::scale_text;
use super::hjif::{
    Hjif, HjifBand, HjifBandType, HjifBaseSignal, HjifChannel, HjifCurveType, HjifEffect,
    HjifEffectType, HjifKeyframe, HjifPerception, HjifReferenceDevice,
};
use super::{Exported, loses};

/// The edition that is written.
const EDITION: &str = "2025";
/// Every part of the body: which bit is the finger stands only in the standard's own table 7.
const ANYWHERE: u32 = u32::MAX;
/// Keyframes in one effect; the binary form of the format counts them with 16 bits.
const KEYFRAMES_AN_EFFECT: usize = 32_768;

/// What is written, beside its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct HjifTexture {
    pub description: String,
    /// When it was written, ISO 8601; see [`date_of`].
    pub date: String,
    /// What an amplitude of 1 stands for.
    pub full_scale: Measure,
    /// The device it is for.
    pub device: HjifReferenceDevice,
}

/// The actuator behind the amplifier of `setup` as a reference device, with its type: what is known of its band and resonance. Without a
/// set-up its type is `Unknown`.
#[must_use]
pub fn reference_device(
    setup: Option<&DriveSetup>,
    band: Option<Band>,
    resonance_hz: Option<f64>,
) -> HjifReferenceDevice {
    HjifReferenceDevice {
        id: 0,
        name: setup.map_or_else(
            || "a device that is not described".into(),
            |setup| format!("{} at gain {}", setup.device().name(), setup.gain),
        ),
        body_part_mask: Some(ANYWHERE),
        minimum_frequency: band.map(|band| band.low().0),
        maximum_frequency: band.map(|band| band.high().0),
        resonance_frequency: resonance_hz
            .filter(|hertz| band.is_none_or(|band| band.contains(*hertz))),
        maximum_voltage: setup.map(|setup| setup.gain.full_scale_output().0),
        kind: Some(
            match setup.map(|setup| setup.device().actuator().kind) {
                Some(ActuatorKind::Piezo) => "Piezo",
                Some(ActuatorKind::VoiceCoil) => "VCA",
                Some(ActuatorKind::LinearResonant) => "LRA",
                Some(ActuatorKind::Other) | None => "Unknown",
            }
            .into(),
        ),
        ..HjifReferenceDevice::default()
    }
}

/// The day of a moment counted in seconds from the start of 1970 (UTC), as ISO 8601 writes it.
///
/// ```
/// assert_eq!(piezotact_haptic::date_of(951_782_400), "2000-02-29");
/// ```
#[must_use]
pub fn date_of(unix_s: u64) -> String {
    let mut day = unix_s / 86_400;
    let mut year = 1970u64;
    let leap = |year: u64| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let length = |year| if leap(year) { 366 } else { 365 };
    while day >= length(year) && year < 9999 {
        day -= length(year);
        year += 1;
    }
    let february = if leap(year) { 29 } else { 28 };
    let mut month = 1;
    for days in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30] {
        if day < days {
            break;
        }
        day -= days;
        month += 1;
    }
    format!("{year:04}-{month:02}-{:02}", day.min(30) + 1)
}

/// The experience of one perception `Vibrotactile Texture` with one channel, whose only band is a linear curve with a
/// keyframe for each sample and a tick for each sample: the waveform itself, in single precision.
///
/// # Errors
/// [`Mismatch`] when a sample lies beyond ±1, there are fewer than two, or the rate is no whole number of
/// at most 48000 Hz.
fn experience<Q: Quantity>(x: &Series<Q>, texture: &HjifTexture) -> Result<Hjif, Mismatch> {
    let (samples, rate_hz) = (x.samples(), x.rate().hz());
    if !(1.0..=48_000.0).contains(&rate_hz) || rate_hz.fract() > 0.0 {
        return Err(Mismatch::new(
            "a rate of whole Hz, at most 48000",
            format!("{rate_hz} Hz"),
            "resample it first",
        ));
    }
    if samples.len() < 2 {
        return Err(Mismatch::new(
            "two samples or more",
            samples.len().to_string(),
            "give a longer signal",
        ));
    }
    if let Some(at) = samples.iter().position(|v| !(-1.0..=1.0).contains(v)) {
        return Err(Mismatch::new(
            "amplitudes from −1 to 1",
            format!("{} in sample {at}", samples[at]),
            "lower the level",
        ));
    }
    let count = u32::try_from(samples.len());
    let Ok(count) = count else {
        return Err(Mismatch::new(
            "at most 4294967295 samples",
            samples.len().to_string(),
            "write a part of it",
        ));
    };
    // A whole number of at most 48000, as checked above.
    let ticks = rate_hz as u32;
    let effects = effects(samples);
    let channel = HjifChannel {
        id: 0,
        description: texture.description.clone(),
        gain: 1.0,
        mixing_coefficient: Some(1.0),
        mixing_weight: None,
        body_part_mask: ANYWHERE,
        reference_device_id: Some(texture.device.id),
        frequency_sampling: Some(ticks),
        sample_count: Some(count),
        direction: None,
        actuator_resolution: None,
        body_part_target: None,
        actuator_target: None,
        vertices: None,
        bands: vec![HjifBand {
            band_type: HjifBandType::Curve,
            curve_type: Some(HjifCurveType::Linear),
            block_length: None,
            lower_frequency_limit: 0,
            upper_frequency_limit: ticks / 2,
            effects,
            unknown: BTreeMap::new(),
        }],
        unknown: BTreeMap::new(),
    };
    Ok(Hjif {
        version: EDITION.into(),
        profile: "Main".into(),
        level: 1,
        date: texture.date.clone(),
        description: format!(
            "{}; an amplitude of 1 stands for {}",
            texture.description, texture.full_scale
        ),
        timescale: Some(ticks),
        avatars: Vec::new(),
        perceptions: vec![HjifPerception {
            id: 0,
            avatar_id: 0,
            description: texture.description.clone(),
            perception_modality: "Vibrotactile Texture".into(),
            unit_exponent: None,
            perception_unit_exponent: None,
            reference_devices: vec![texture.device.clone()],
            effect_library: Vec::new(),
            effect_semantic_scheme: None,
            channels: vec![channel],
            unknown: BTreeMap::new(),
        }],
        syncs: Vec::new(),
        unknown: BTreeMap::new(),
    })
}

/// Effects with a keyframe for each of `samples`.
fn effects(samples: &[f64]) -> Vec<HjifEffect> {
    samples
        .chunks(KEYFRAMES_AN_EFFECT)
        .enumerate()
        .map(|(k, chunk)| HjifEffect {
            effect_type: HjifEffectType::Basis,
            id: None,
            position: (k * KEYFRAMES_AN_EFFECT) as i64,
            semantic_keywords: None,
            phase: Some(0.0),
            base_signal: Some(HjifBaseSignal::Sine),
            keyframes: Some(
                chunk
                    .iter()
                    .enumerate()
                    .map(|(i, v)| HjifKeyframe {
                        relative_position: Some(i as i64),
                        amplitude_modulation: Some(*v as f32),
                        frequency_modulation: None,
                    })
                    .collect(),
            ),
            unknown: BTreeMap::new(),
        })
        .collect()
}

/// `x`, in shares of full scale, as HJIF for the device of `texture`, and what it does not carry.
///
/// # Errors
/// [`Mismatch`] when a sample lies beyond ±1, there are fewer than two, or the rate is no whole number of
/// at most 48000 Hz.
pub fn hjif_of<Q: Quantity>(
    x: &Series<Q>,
    texture: &HjifTexture,
) -> Result<Exported<Hjif>, Mismatch> {
    let content = experience(x, texture)?;
    let mut losses: Vec<Warning> = vec![loses(
        "HJIF",
        "the sliding speed (in the standard a Vibrotactile Texture is a function of position; here positions are times)",
    )];
    if texture.full_scale.unit != Unit::FullScale {
        losses.push(loses("HJIF", scale_text(&texture.full_scale)));
    }
    losses.push(loses(
        "HJIF",
        "the transfer function, the condition and the warnings of a rendering",
    ));
    Ok(Exported { content, losses })
}
