//! Haptic files as recordings that can be rendered: played at a stated rate by the science, and scaled here.

use piezotact::recording::RecordingDoubt;
use std::collections::BTreeSet;
use std::path::Path;

use piezotact::Doubt;
use piezotact::envelope::{
    Course, EnvelopeError, FrequencyRange, Keyframe, MOST_SAMPLES, PLAYED_AT_HZ, Shape, Wave,
    WaveKind, mix, mixed_length, synthesise,
};
use piezotact::quantity::{Band, Hertz, SampleRate};
use piezotact::recording::{Channel, Condition, Provenance, Recording};

use super::HapticClip;
use super::clip::broken;
use super::hjif::{
    Hjif, HjifBand, HjifBandType, HjifBaseSignal, HjifChannel, HjifCurveType, HjifEffect,
    HjifEffectType, HjifKeyframe,
};
use crate::error::ReadError;
use crate::open::ReadOptions;
use crate::sidecar::unit_and_factor;

/// What is left out of a file.
const NOT_PLAYED: &str =
    "composite effects, and those that refer to none in the library, are not played";
/// The ticks of a second in a file that does not say.
const DEFAULT_TICKS: u32 = 1000;

/// A clip as a recording of one channel, at the rate of the options or 8 kHz.
pub(crate) fn recording_of_clip(
    path: &Path,
    clip: HapticClip,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let rate = playing_rate(path, options)?;
    let range = FrequencyRange::texture().map_err(|source| ReadError::Quantity {
        path: path.into(),
        source,
    })?;
    let played = synthesise(&clip.envelopes, range, rate).map_err(|error| broken(path, error))?;
    let mut doubts = clip.doubts;
    doubts.push(Doubt::from(RecordingDoubt::Guessed {
        what: format!(
            "the clip holds envelopes and no waveform: it is played as one sine whose frequency values 0–1 cover {} \
             (logarithmic), at {rate}",
            range.band()
        ),
    }));
    let step = format!("haptic clip of version {}", clip.version);
    let named = vec![("signal".to_owned(), played.into_samples())];
    recording(path, named, rate, options, doubts, step)
}

/// The channels of an HJIF file as those of a recording, at the rate of the options, that of the file, or 8 kHz.
pub(crate) fn recording_of_hjif(
    path: &Path,
    file: &Hjif,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let own = own_rate(file);
    let rate = match options.rate.or(own) {
        Some(rate) => rate,
        None => playing_rate(path, options)?,
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
        return Err(ReadError::content(
            path,
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
            let mut waves = Vec::new();
            for band in &channel.bands {
                let playing = Playing {
                    path,
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
                            waves.push(playing.wave(&effect, &mut notes)?);
                        }
                        _ => {
                            notes.insert(NOT_PLAYED.into());
                        }
                    }
                }
            }
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
            EnvelopeError::NoLength { .. } if notes.contains(NOT_PLAYED) => ReadError::content(
                path,
                "basic effects, or references to such in the library",
                NOT_PLAYED,
                "export it again without composites",
            ),
            error => broken(path, error),
        })?;
        longest = longest.max(length);
    }
    let all = longest.saturating_mul(named.len());
    if all > MOST_SAMPLES {
        let found = format!("{all} ({} channels of {longest} at {rate})", named.len());
        return Err(broken(path, EnvelopeError::TooMany { found }));
    }
    let mut channels = Vec::with_capacity(named.len());
    for (name, waves) in named {
        let played = mix(&waves, rate).map_err(|error| broken(path, error))?;
        let mut samples = played.into_samples();
        samples.resize(longest, 0.0);
        channels.push((name, samples));
    }
    let doubts = notes
        .into_iter()
        .map(|what| Doubt::from(RecordingDoubt::Guessed { what }))
        .collect();
    let step = format!(
        "MPEG haptics JSON, profile {}, level {}",
        file.profile, file.level
    );
    recording(path, channels, rate, options, doubts, step)
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

fn playing_rate(path: &Path, options: &ReadOptions) -> Result<SampleRate, ReadError> {
    options.rate.map_or_else(
        || {
            SampleRate::new(PLAYED_AT_HZ).map_err(|source| ReadError::Quantity {
                path: path.into(),
                source,
            })
        },
        Ok,
    )
}

fn recording(
    path: &Path,
    named: Vec<(String, Vec<f64>)>,
    rate: SampleRate,
    options: &ReadOptions,
    mut doubts: Vec<Doubt>,
    step: String,
) -> Result<Recording, ReadError> {
    let (unit, factor) = unit_and_factor(options.scale.as_ref());
    let channels = named
        .into_iter()
        .map(|(name, mut samples)| {
            if options.scale.is_none() {
                doubts.push(Doubt::from(RecordingDoubt::Uncalibrated {
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
        source: path.display().to_string(),
        ..Provenance::default()
    }
    .then(step);
    let mut recording =
        Recording::new(channels, rate, Condition::default(), provenance).map_err(|source| {
            ReadError::Recording {
                path: path.into(),
                source,
            }
        })?;
    recording.about.doubts = doubts;
    Ok(recording)
}

/// Where an effect stands.
struct Playing<'a> {
    path: &'a Path,
    ticks: f64,
    channel: &'a HjifChannel,
    band: &'a HjifBand,
}

impl Playing<'_> {
    fn wave(&self, effect: &HjifEffect, notes: &mut BTreeSet<String>) -> Result<Wave, ReadError> {
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

    fn limits(&self) -> Result<Band, ReadError> {
        let (low, high) = (
            self.band.lower_frequency_limit,
            self.band.upper_frequency_limit,
        );
        Band::new(Hertz(f64::from(low)), Hertz(f64::from(high))).map_err(|source| {
            ReadError::Quantity {
                path: self.path.into(),
                source,
            }
        })
    }

    /// A block: as many coefficients as a power of two, or these with their scale and their number of bits after them.
    fn wavelets(
        &self,
        frames: &[HjifKeyframe],
        notes: &mut BTreeSet<String>,
    ) -> Result<WaveKind, ReadError> {
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
        let rate = rate.map_err(|source| ReadError::Quantity {
            path: self.path.into(),
            source,
        })?;
        if coefficients.is_empty() {
            return Err(broken(
                self.path,
                EnvelopeError::NoLength {
                    found: "a block of wavelets without coefficients".into(),
                },
            ));
        }
        Ok(WaveKind::Wavelet { rate, coefficients })
    }
}
