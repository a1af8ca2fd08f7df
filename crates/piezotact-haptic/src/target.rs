//! Haptic files as recordings that can be rendered: played at a stated rate by the science, and scaled here.

use crate::HapticError;
use piezotact::recording::RecordingWarning;
use std::collections::BTreeSet;

use crate::envelope::{
    Course, FrequencyRange, Keyframe, MOST_SAMPLES, PLAYED_AT_HZ, Shape, Wave, WaveKind, mix,
    mixed_length, synthesise,
};
use piezotact::Warning;
use piezotact::quantity::{Band, Hertz, Measure, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};

use super::HapticClip;
use super::hjif::{
    Hjif, HjifBand, HjifBandType, HjifBaseSignal, HjifChannel, HjifCurveType, HjifEffect,
    HjifEffectType, HjifKeyframe, HjifPerception,
};

/// What is left out of a file.
const NOT_PLAYED: &str =
    "composite effects, and those that refer to none in the library, are not played";
/// The ticks of a second in a file that does not say.
const DEFAULT_TICKS: u32 = 1000;

/// How a file is read as a recording.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Where it comes from, as its provenance says it.
    pub source: &'a str,
    /// What the number 1 stands for; full scale of a device where it is not known.
    pub scale: Option<&'a Measure>,
    /// The rate at which it is played.
    pub rate: Option<SampleRate>,
    /// Whether it is read as a drive, which needs no scale.
    pub is_drive: bool,
}

/// A clip as a recording of one channel, at the rate asked for or 8 kHz.
///
/// # Errors
/// [`HapticError`] when it cannot be played.
pub fn recording_of_clip(clip: HapticClip, asked: &Asked<'_>) -> Result<Recording, HapticError> {
    let rate = playing_rate(asked)?;
    let range = FrequencyRange::texture()?;
    let played = synthesise(&clip.envelopes, range, rate)?;
    let mut warnings = clip.warnings;
    warnings.push(Warning::from(RecordingWarning::Guessed {
        what: format!(
            "the clip holds envelopes and no waveform: it is played as one sine whose frequency values 0–1 cover {} \
             (logarithmic), at {rate}",
            range.band()
        ),
    }));
    let step = format!("haptic clip of version {}", clip.version);
    let named = vec![("signal".to_owned(), played.into_samples())];
    recording(named, rate, asked, warnings, step)
}

/// The channels of an HJIF file as those of a recording, at the rate asked for, that of the file, or 8 kHz.
///
/// # Errors
/// [`HapticError`] when it cannot be played.
pub fn recording_of_hjif(file: &Hjif, asked: &Asked<'_>) -> Result<Recording, HapticError> {
    let own = own_rate(file);
    let rate = match asked.rate.or(own) {
        Some(rate) => rate,
        None => playing_rate(asked)?,
    };
    let mut notes = BTreeSet::new();
    if let Some(own) = own.filter(|own| *own != rate) {
        notes.insert(format!(
            "curves sampled at {own} are read at {rate}: linear interpolation between keyframes lowers the level at one fifth \
             of {own} by 1.2 dB (--rate {} avoids the interpolation)",
            own.hz()
        ));
    }
    let departures = file.departures();
    if !departures.is_empty() {
        notes.insert(format!(
            "the file departs from ISO/IEC 23090-31:2025 ({})",
            departures.join("; ")
        ));
    }
    let ticks = f64::from(file.timescale.unwrap_or(DEFAULT_TICKS));
    if ticks <= 0.0 {
        return Err(HapticError::content(
            "a timescale of 1 tick a second or more",
            "0",
            "export it again",
        ));
    }
    let alone = file
        .perceptions
        .iter()
        .map(|p| p.channels.len())
        .sum::<usize>()
        == 1;
    let mut named: Vec<(String, Vec<Wave>)> = Vec::new();
    for perception in &file.perceptions {
        if matches!(
            perception.perception_modality.as_str(),
            "Vibrotactile Texture" | "Stiffness" | "Friction" | "User-defined Spatial"
        ) {
            notes.insert(format!(
                "`{}` is a function of position in the standard: its positions are read as times in steps of 1/{ticks} s",
                perception.perception_modality
            ));
        }
        for channel in &perception.channels {
            let waves = waves(perception, channel, ticks, &mut notes)?;
            let name = if alone {
                "signal".into()
            } else {
                format!("perception {} channel {}", perception.id, channel.id)
            };
            named.push((name, waves));
        }
    }
    // All that will be held is known before there is memory for any of it.
    let mut longest = 0;
    for (_, waves) in &named {
        let length = mixed_length(waves, rate).map_err(|error| match error {
            HapticError::NoLength { .. } if notes.contains(NOT_PLAYED) => HapticError::content(
                "basic effects, or references to such in the library",
                NOT_PLAYED,
                "export it again without composites",
            ),
            error => error,
        })?;
        longest = longest.max(length);
    }
    let all = longest.saturating_mul(named.len());
    if all > MOST_SAMPLES {
        let found = format!("{all} ({} channels of {longest} at {rate})", named.len());
        return Err(HapticError::TooMany { found });
    }
    let mut channels = Vec::with_capacity(named.len());
    for (name, waves) in named {
        let played = mix(&waves, rate)?;
        let mut samples = played.into_samples();
        samples.resize(longest, 0.0);
        channels.push((name, samples));
    }
    let warnings = notes
        .into_iter()
        .map(|what| Warning::from(RecordingWarning::Guessed { what }))
        .collect();
    let step = format!(
        "MPEG haptics JSON, profile {}, level {}",
        file.profile, file.level
    );
    recording(channels, rate, asked, warnings, step)
}

/// The waves of the basic effects of `channel`, those of the library among them; `notes` say what is not played.
fn waves(
    perception: &HjifPerception,
    channel: &HjifChannel,
    ticks: f64,
    notes: &mut BTreeSet<String>,
) -> Result<Vec<Wave>, HapticError> {
    let mut waves = Vec::new();
    for band in &channel.bands {
        let playing = Playing {
            ticks,
            channel,
            band,
        };
        for effect in &band.effects {
            let effect = match effect.effect_type {
                HjifEffectType::Reference => perception
                    .effect_library
                    .iter()
                    .find(|known| known.id.is_some() && known.id == effect.id)
                    .map(|known| HjifEffect {
                        position: effect.position,
                        ..known.clone()
                    }),
                _ => Some(effect.clone()),
            };
            match effect {
                Some(effect) if effect.effect_type == HjifEffectType::Basis => {
                    waves.push(playing.wave(&effect, notes)?);
                }
                _ => {
                    notes.insert(NOT_PLAYED.into());
                }
            }
        }
    }
    Ok(waves)
}

fn bands(file: &Hjif) -> impl Iterator<Item = &HjifBand> {
    let channels = file.perceptions.iter().flat_map(|p| &p.channels);
    channels.flat_map(|channel| &channel.bands)
}

/// The rate that all channels were made at, where they state one and hold curves only: other bands have no samples.
fn own_rate(file: &Hjif) -> Option<SampleRate> {
    let mut stated = file
        .perceptions
        .iter()
        .flat_map(|perception| &perception.channels)
        .map(|channel| channel.frequency_sampling);
    let first = stated.next()??;
    let curves = bands(file).all(|band| band.band_type == HjifBandType::Curve);
    if !curves || stated.any(|other| other != Some(first)) {
        return None;
    }
    SampleRate::new(f64::from(first)).ok()
}

fn playing_rate(asked: &Asked<'_>) -> Result<SampleRate, HapticError> {
    asked.rate.map_or_else(
        || SampleRate::new(PLAYED_AT_HZ).map_err(HapticError::from),
        Ok,
    )
}

fn recording(
    named: Vec<(String, Vec<f64>)>,
    rate: SampleRate,
    asked: &Asked<'_>,
    mut warnings: Vec<Warning>,
    step: String,
) -> Result<Recording, HapticError> {
    let (unit, factor) = asked.scale.map_or((Unit::FullScale, 1.0), |scale| {
        (scale.unit.clone(), scale.value)
    });
    let channels = named
        .into_iter()
        .map(|(name, mut samples)| {
            if asked.scale.is_none() && !asked.is_drive {
                warnings.push(Warning::from(RecordingWarning::Uncalibrated {
                    channel: name.clone(),
                }));
            }
            for sample in &mut samples {
                *sample *= factor;
            }
            Channel {
                name,
                unit: unit.clone(),
                samples,
            }
        })
        .collect();
    let provenance = Provenance {
        source: asked.source.to_owned(),
        ..Provenance::default()
    }
    .then(step);
    let mut recording = Recording::new(channels, rate, Condition::default(), provenance)?;
    recording.about.warnings = warnings;
    Ok(recording)
}

/// Where an effect stands.
struct Playing<'a> {
    ticks: f64,
    channel: &'a HjifChannel,
    band: &'a HjifBand,
}

impl Playing<'_> {
    fn wave(&self, effect: &HjifEffect, notes: &mut BTreeSet<String>) -> Result<Wave, HapticError> {
        let frames = effect.keyframes.as_deref().unwrap_or(&[]);
        let shape = match effect.base_signal.unwrap_or_default() {
            HjifBaseSignal::Sine => Shape::Sine,
            HjifBaseSignal::Square => Shape::Square,
            HjifBaseSignal::Triangle => Shape::Triangle,
            HjifBaseSignal::SawToothUp => Shape::SawToothUp,
            HjifBaseSignal::SawToothDown => Shape::SawToothDown,
        };
        let kind = match self.band.band_type {
            HjifBandType::Transient => WaveKind::Tap(shape),
            HjifBandType::Curve => WaveKind::Curve(self.course(frames, notes)),
            HjifBandType::VectorialWave => WaveKind::Oscillation {
                shape,
                limits: self.limits()?,
            },
            HjifBandType::WaveletWave => self.wavelets(frames, notes)?,
        };
        let keyframes = if self.band.band_type == HjifBandType::WaveletWave {
            Vec::new()
        } else {
            frames
                .iter()
                .map(|frame| Keyframe {
                    time_s: frame.relative_position.unwrap_or(0) as f64 / self.ticks,
                    amplitude: frame.amplitude_modulation.map(f64::from),
                    frequency_hz: frame.frequency_modulation.map(|hertz| hertz as f64),
                })
                .collect()
        };
        Ok(Wave {
            kind,
            start_s: effect.position as f64 / self.ticks,
            phase_rad: effect.phase.unwrap_or(0.0),
            gain: self.channel.gain,
            keyframes,
        })
    }

    fn course(&self, frames: &[HjifKeyframe], notes: &mut BTreeSet<String>) -> Course {
        match self.band.curve_type {
            Some(HjifCurveType::Linear) => Course::Linear,
            _ if frames.len() <= 2 => Course::Linear,
            Some(HjifCurveType::Cubic) => Course::Cubic,
            other => {
                notes.insert(format!(
                    "curves of type {} are played as cubic splines",
                    other.map_or("unstated".into(), |kind| format!("{kind:?}"))
                ));
                Course::Cubic
            }
        }
    }

    fn limits(&self) -> Result<Band, HapticError> {
        let (low, high) = (
            self.band.lower_frequency_limit,
            self.band.upper_frequency_limit,
        );
        Band::new(Hertz(f64::from(low)), Hertz(f64::from(high))).map_err(HapticError::from)
    }

    /// A block: as many coefficients as a power of two, or these with their scale and their number of bits after them.
    fn wavelets(
        &self,
        frames: &[HjifKeyframe],
        notes: &mut BTreeSet<String>,
    ) -> Result<WaveKind, HapticError> {
        let mut coefficients: Vec<f64> = frames
            .iter()
            .map(|frame| f64::from(frame.amplitude_modulation.unwrap_or(0.0)))
            .collect();
        let count = coefficients.len();
        if count > 2 && (count - 2).is_power_of_two() {
            let scale = coefficients[count - 2];
            coefficients.truncate(count - 2);
            for value in &mut coefficients {
                *value *= scale;
            }
            notes.insert(
                "the last two keyframes of a block of wavelets are read as its scale and its number of bits".into(),
            );
        }
        let rate = SampleRate::new(f64::from(self.band.upper_frequency_limit));
        let rate = rate?;
        if coefficients.is_empty() {
            return Err(HapticError::NoLength {
                found: "a block of wavelets without coefficients".into(),
            });
        }
        Ok(WaveKind::Wavelet { rate, coefficients })
    }
}
