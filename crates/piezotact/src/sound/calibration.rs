//! The calibration of a sound device: volts at full scale, sensitivities of its inputs, and the level of its loopback.

use super::SoundError;
use serde::{Deserialize, Serialize};

use super::tone::Tone;
use super::{CalibrationFault, SoundWarning, Wire};
use crate::document::Content;
use crate::number::digits;
use crate::quantity::{Hertz, SampleRate, Unit};
use crate::warning::Warning;

/// A tone must stand so far above what is left of the signal, dB: over 5 s noise then changes its level by less than 0.01 dB, and mains hum beside it by
/// less than 0.02 dB.
pub(super) const LEAST_ABOVE_DB: f64 = 12.0;
/// A recorded value of this share of full scale or more is clipped.
const CLIPPED: f64 = 0.999;
/// A calibration is old after so many days.
const OLD_DAYS: i64 = 90;
/// Two ways of finding a level that differ by more contradict each other, dB.
const DISAGREES_DB: f64 = 1.0;
/// The largest change of the loopback's level from the calibration to a session, dB.
const MOST_OFF_DB: f64 = 0.1;

/// A vibration calibrator on which an accelerometer is mounted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Exciter {
    /// Its frequency.
    pub frequency_hz: Hertz,
    /// Its level, rms, in the unit of the sensor.
    pub rms: f64,
}

impl Exciter {
    /// The usual handheld calibrator: 159.2 Hz (1000 rad/s), 10 m/s² rms.
    ///
    /// Source: ISO 16063-21; handheld calibrators of several makers.
    #[must_use]
    pub fn handheld() -> Self {
        Self {
            frequency_hz: Hertz(159.2),
            rms: 10.0,
        }
    }
}

/// How the potential at full scale was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum VoltsMethod {
    /// A voltmeter at the output read this while a tone played.
    Voltmeter {
        /// What it read, V rms.
        read_v_rms: f64,
        /// The tone, rms, full scale = 1.
        played_rms: f64,
    },
    /// A loopback into an input whose potential at full scale is known.
    Loopback {
        /// That potential, V peak.
        input_v_per_full_scale: f64,
        /// The recorded value per played value.
        gain: f64,
    },
}

/// The day of a part of a calibration that is kept while others are made again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct MadeOn {
    /// Days since 1970-01-01, as the caller counts them.
    pub day: i64,
    /// The same as a date, for people.
    pub date: String,
}

/// The output of a sound device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct OutputCalibration {
    /// The potential at the output when the drive is at full scale, V peak.
    pub v_per_full_scale: f64,
    /// How it was found.
    pub method: VoltsMethod,
    /// When; absent where it is as old as the whole calibration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub made: Option<MadeOn>,
}

impl OutputCalibration {
    /// The potential at full scale, V peak, by `method`.
    ///
    /// Formula: voltmeter: reading / rms of the tone, both rms, so that full scale (peak 1) is as many V peak; loopback: potential of the input at
    /// full scale times the gain.
    ///
    /// Source: docs/decisions/sound.md.
    ///
    /// # Errors
    /// [`SoundError::Numbers`] when the potential is not from 0.001 to 1000 V.
    pub fn by(method: VoltsMethod) -> Result<Self, SoundError> {
        let v_per_full_scale = match method {
            VoltsMethod::Voltmeter {
                read_v_rms,
                played_rms,
            } => read_v_rms / played_rms,
            VoltsMethod::Loopback {
                input_v_per_full_scale,
                gain,
            } => input_v_per_full_scale * gain.abs(),
        };
        match (1e-3..=1e3).contains(&v_per_full_scale) {
            true => Ok(Self {
                v_per_full_scale,
                method,
                made: None,
            }),
            false => Err(SoundError::Numbers {
                what: "V at full scale",
                range: [1e-3, 1e3],
                found: v_per_full_scale,
            }),
        }
    }
}

/// How the sensitivity of an input was found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SensorMethod {
    /// The sensor was mounted on a calibrator.
    Exciter {
        /// The calibrator.
        exciter: Exciter,
        /// The recorded tone, rms, full scale = 1.
        recorded_rms: f64,
        /// How far it stood above the rest of the signal, dB.
        above_residual_db: f64,
    },
    /// From the data sheet of the sensor and the potential of the input at full scale.
    Stated {
        /// The sensitivity of the sensor with its amplifier, V per unit.
        v_per_unit: f64,
        /// The potential of the input at full scale, V peak.
        input_v_per_full_scale: f64,
    },
}

/// One input of a sound device with its sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct InputCalibration {
    /// The channel, from 1.
    pub channel: u32,
    /// What it measures: the name of the channel in recordings.
    pub name: String,
    /// Its unit.
    pub unit: Unit,
    /// The value at full scale, in its unit; negative where the polarity of the sensor is inverted.
    pub per_full_scale: f64,
    /// How it was found.
    pub method: SensorMethod,
    /// When; absent where it is as old as the whole calibration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub made: Option<MadeOn>,
}

impl InputCalibration {
    /// The value at full scale of the input `channel`, in `unit`, from the tone of a calibrator that it recorded (full scale = 1).
    ///
    /// Formula: rms of the calibrator / rms of the recorded tone.
    ///
    /// Source: ISO 16063-21: calibration by comparison, here with a calibrator as reference.
    ///
    /// # Errors
    /// [`SoundError`] when the tone is clipped (its peak as a share of full scale), or stands less than 25 dB above the rest.
    pub fn by_exciter(
        (channel, name, unit): (u32, &str, Unit),
        exciter: Exciter,
        recorded: &Tone,
        peak_share: f64,
    ) -> Result<Self, SoundError> {
        if peak_share >= CLIPPED {
            return Err(SoundError::Clipped {
                channel,
                peak: peak_share,
            });
        }
        let above_residual_db = recorded.above_residual_db();
        if above_residual_db.is_nan() || above_residual_db < LEAST_ABOVE_DB {
            return Err(SoundError::NoTone {
                channel,
                hz: exciter.frequency_hz.0,
                above_db: above_residual_db,
            });
        }
        Self::checked(
            (channel, name, unit),
            exciter.rms / recorded.rms,
            SensorMethod::Exciter {
                exciter,
                recorded_rms: recorded.rms,
                above_residual_db,
            },
        )
    }

    /// The value at full scale of the input `channel`, in `unit`, from the sensitivity of its sensor, V per unit, and the potential of the input at full
    /// scale, V peak.
    ///
    /// Formula: V at full scale / (V per unit).
    ///
    /// Source: docs/decisions/sound.md.
    ///
    /// # Errors
    /// [`SoundError::Numbers`] when the value is 0 or no number.
    pub fn stated(
        of: (u32, &str, Unit),
        per_unit_v: f64,
        input_v: f64,
    ) -> Result<Self, SoundError> {
        Self::checked(
            of,
            input_v / per_unit_v,
            SensorMethod::Stated {
                v_per_unit: per_unit_v,
                input_v_per_full_scale: input_v,
            },
        )
    }

    fn checked(
        (channel, name, unit): (u32, &str, Unit),
        per_full_scale: f64,
        method: SensorMethod,
    ) -> Result<Self, SoundError> {
        match (1e-9..=1e9).contains(&per_full_scale.abs()) {
            true => Ok(Self {
                channel,
                name: name.into(),
                unit,
                per_full_scale,
                method,
                made: None,
            }),
            false => Err(SoundError::Numbers {
                what: "value at full scale",
                range: [1e-9, 1e9],
                found: per_full_scale,
            }),
        }
    }
}

/// The level of the loopback when the device was calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LoopbackLevel {
    /// The frequency of the tone.
    pub frequency_hz: Hertz,
    /// The recorded value per played value at that frequency.
    pub gain: f64,
}

/// The calibration of a sound device, stored as a document in the same folder as its set-up file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SoundCalibration {
    /// The device, by host and ids: a calibration holds for no other.
    pub device: String,
    /// When it was made: days since 1970-01-01, as the caller counts them.
    pub made_on_day: i64,
    /// The same as a date, for people.
    pub made_on: String,
    /// The rate of the streams, Hz.
    pub rate_hz: SampleRate,
    /// The output; absent where it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<OutputCalibration>,
    /// The loopback; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loopback: Option<LoopbackLevel>,
    /// The inputs with sensors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<InputCalibration>,
    /// The cables that were found.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub wires: Vec<Wire>,
    /// What to know of it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl Content for SoundCalibration {
    const SCHEMA: &'static str = "sound_calibration";
}

impl SoundCalibration {
    /// Checks that the calibration is of `device` at `rate`.
    ///
    /// Source: docs/decisions/sound.md.
    ///
    /// # Errors
    /// [`SoundError::OtherDevice`] with both.
    pub fn holds_for(&self, device: &str, rate: SampleRate) -> Result<(), SoundError> {
        let named = |device: &str, rate: SampleRate| format!("{device} at {rate}");
        match self.device == device && self.rate_hz == rate {
            true => Ok(()),
            false => Err(SoundError::OtherDevice {
                expected: named(device, rate),
                found: named(&self.device, self.rate_hz),
            }),
        }
    }

    /// What to know of the calibration on the day `today`, counted as [`Self::made_on_day`].
    ///
    /// Source: docs/decisions/sound.md: a calibration is old after 90 days.
    #[must_use]
    pub fn warnings_on(&self, today: i64) -> Vec<Warning> {
        let mut warnings = self.warnings.clone();
        for (what, made) in self.parts() {
            let days = today - made.day;
            if !(0..=OLD_DAYS).contains(&days) {
                warnings.push(Warning::from(SoundWarning::Calibration {
                    fault: CalibrationFault::Old {
                        what,
                        made_on: made.date,
                        days: days as f64,
                        most_days: OLD_DAYS as f64,
                    },
                }));
            }
        }
        warnings
    }

    /// What was calibrated, each with its day.
    fn parts(&self) -> Vec<(String, MadeOn)> {
        let whole = MadeOn {
            day: self.made_on_day,
            date: self.made_on.clone(),
        };
        let day = |made: &Option<MadeOn>| made.clone().unwrap_or_else(|| whole.clone());
        let output = self.output.iter();
        let output = output.map(|output| ("the output".to_owned(), day(&output.made)));
        let inputs = self.inputs.iter().map(|input| {
            let name = format!("input {} (`{}`)", input.channel, input.name);
            (name, day(&input.made))
        });
        let loopback = self.loopback.iter();
        let loopback = loopback.map(|_| ("the loopback".to_owned(), whole.clone()));
        output.chain(inputs).chain(loopback).collect()
    }

    /// The same as the beginning of a new calibration on another day: each part keeps its own day until it is made again.
    #[must_use]
    pub fn renewed(mut self, made: MadeOn) -> Self {
        let before = MadeOn {
            day: self.made_on_day,
            date: std::mem::replace(&mut self.made_on, made.date),
        };
        self.made_on_day = made.day;
        if let Some(output) = &mut self.output {
            output.made.get_or_insert_with(|| before.clone());
        }
        for input in &mut self.inputs {
            input.made.get_or_insert_with(|| before.clone());
        }
        self.warnings = Vec::new();
        self
    }

    /// Checks that input `channel` was calibrated with the sensitivity that is stated now, V per unit; absent where none is stated. A sensor on a
    /// calibrator needs none.
    ///
    /// Source: docs/decisions/sound.md.
    ///
    /// # Errors
    /// [`SoundError::OtherSensor`] with both.
    pub fn sensor_holds(&self, channel: u32, per_unit_v: Option<f64>) -> Result<(), SoundError> {
        let input = self.inputs.iter().find(|input| input.channel == channel);
        let Some(SensorMethod::Stated { v_per_unit, .. }) = input.map(|input| &input.method) else {
            return Ok(());
        };
        match per_unit_v {
            Some(now) if (now / v_per_unit - 1.0).abs() < 1e-9 => Ok(()),
            now => Err(SoundError::OtherSensor {
                channel,
                expected_mv: 1e3 * v_per_unit,
                found: now.map_or("none".into(), |now| {
                    format!("{} mV per unit", digits(1e3 * now))
                }),
            }),
        }
    }

    /// The warning about two ways of finding `what` that lead to values in the ratio `found` to `other`, each named by its way; none where they
    /// agree within 1 dB: sensors and meters are no better.
    ///
    /// Formula: 20·log10(|found / other|).
    ///
    /// Source: docs/decisions/sound.md.
    #[must_use]
    pub fn disagreement(what: &str, found: (&str, f64), other: (&str, f64)) -> Option<Warning> {
        let by_db = 20.0 * (found.1 / other.1).abs().log10();
        (by_db.is_nan() || by_db.abs() > DISAGREES_DB).then(|| {
            Warning::from(SoundWarning::Calibration {
                fault: CalibrationFault::WaysDisagree {
                    what: what.into(),
                    found_by: found.0.into(),
                    other_by: other.0.into(),
                    by_db,
                },
            })
        })
    }

    /// Checks the gain of the loopback `found_ratio` that is found now (recorded per played value) against the calibration.
    ///
    /// Formula: 20·log10(|found| / |calibrated|), at most 0.1 dB, and the same sign.
    ///
    /// Source: docs/decisions/sound.md.
    ///
    /// # Errors
    /// [`SoundError::LevelChanged`] with both levels; [`SoundError::Inverted`] where the polarity changed.
    pub fn level_holds(&self, found_ratio: f64) -> Result<(), SoundError> {
        let Some(stored) = self.loopback else {
            return Ok(());
        };
        let off_db = 20.0 * (found_ratio / stored.gain).abs().log10();
        if off_db.is_nan() || off_db.abs() > MOST_OFF_DB {
            return Err(SoundError::LevelChanged {
                off_db,
                most_db: MOST_OFF_DB,
            });
        }
        match found_ratio * stored.gain > 0.0 {
            true => Ok(()),
            false => Err(SoundError::Inverted),
        }
    }
}
