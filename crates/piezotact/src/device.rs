//! What a drive passes through on its way to the actuator: the output of the PC, and the DRV2667
//! amplifier with its four gains and its limits.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::quantity::{Decibels, Drive, Potential, Volts};
use crate::series::{Series, SeriesError};

/// The four gains of the DRV2667EVM, named by its buttons. The thesis uses B3.
///
/// Source: TI DRV2667 data sheet SLOS751E, gain register: 25, 50, 75 and 100 V *peak*. (The names in V
/// peak to peak that circulate are twice that.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum AmplifierGain {
    /// 25 V peak at full scale, 28.8 dB.
    B1,
    /// 50 V peak at full scale, 34.8 dB.
    B2,
    /// 75 V peak at full scale, 38.4 dB.
    B3,
    /// 100 V peak at full scale, 40.7 dB.
    B4,
}

impl AmplifierGain {
    /// The four gains, lowest first.
    pub const ALL: [Self; 4] = [Self::B1, Self::B2, Self::B3, Self::B4];

    /// The voltage gain, 10^(dB/20) of the data sheet's 28.8, 34.8, 38.4 and 40.7 dB.
    #[must_use]
    pub fn voltage_ratio(self) -> f64 {
        Decibels(match self {
            Self::B1 => 28.8,
            Self::B2 => 34.8,
            Self::B3 => 38.4,
            Self::B4 => 40.7,
        })
        .amplitude_ratio()
    }

    /// The output at which the amplifier clips, V peak.
    #[must_use]
    pub fn full_scale_output(self) -> Volts {
        Volts(match self {
            Self::B1 => 25.0,
            Self::B2 => 50.0,
            Self::B3 => 75.0,
            Self::B4 => 100.0,
        })
    }

    /// The input at which the amplifier clips, V peak: about 0.90 V at every gain.
    #[must_use]
    pub fn full_scale_input(self) -> Volts {
        Volts(self.full_scale_output().0 / self.voltage_ratio())
    }

    /// The current that the amplifier can push into a capacitive load, A.
    ///
    /// Source: SLOS751E load table (680 nF at 50 Vpp, 330 nF at 100, 150 nF at 150, 100 nF at 200, all at
    /// 300 Hz): `I = π·Vpp·f·C`.
    #[must_use]
    pub fn output_current_a(self) -> f64 {
        let (output_vpp, load_f) = match self {
            Self::B1 => (50.0, 680e-9),
            Self::B2 => (100.0, 330e-9),
            Self::B3 => (150.0, 150e-9),
            Self::B4 => (200.0, 100e-9),
        };
        std::f64::consts::PI * output_vpp * 300.0 * load_f
    }
}

impl fmt::Display for AmplifierGain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

impl FromStr for AmplifierGain {
    type Err = UnknownGain;
    fn from_str(text: &str) -> Result<Self, UnknownGain> {
        Self::ALL
            .into_iter()
            .find(|gain| gain.to_string().eq_ignore_ascii_case(text.trim()))
            .ok_or_else(|| UnknownGain { found: text.into() })
    }
}

/// A gain that the amplifier does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected an amplifier gain B1, B2, B3 or B4, found `{found}`; take the one set on the board"
)]
pub struct UnknownGain {
    /// What was found.
    pub found: String,
}

/// How the drive reaches the actuator. A transfer function holds for the set-up it was measured with and
/// for no other, so it carries this, and rendering compares it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StatedSetup")]
pub struct DriveSetup {
    /// The gain set on the amplifier.
    pub gain: AmplifierGain,
    /// The potential at the output of the PC when the drive is at full scale, V peak, as calibrated.
    pub volts_per_full_scale: f64,
    /// The capacitance of the actuator, F.
    pub load_f: f64,
}

/// A set-up as a file states it, before it is believed.
#[derive(Deserialize)]
struct StatedSetup {
    gain: AmplifierGain,
    volts_per_full_scale: f64,
    load_f: f64,
}

impl TryFrom<StatedSetup> for DriveSetup {
    type Error = ImpossibleSetup;

    fn try_from(stated: StatedSetup) -> Result<Self, ImpossibleSetup> {
        Self::new(
            stated.gain,
            Volts(stated.volts_per_full_scale),
            stated.load_f,
        )
    }
}

/// A set-up that no device has.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "expected 0.001 to 1000 V at full scale and a load of 1e-12 to 1 F, found {volts} and {load_f} F; calibrate the output"
)]
pub struct ImpossibleSetup {
    /// The potential found.
    pub volts: Volts,
    /// The capacitance found.
    pub load_f: f64,
}

impl DriveSetup {
    /// The amplifier at `gain`, behind an output of `volts` at full scale, before a load of `load_f`.
    ///
    /// # Errors
    /// [`ImpossibleSetup`] when the potential is not from 0.001 to 1000 V, or the load not from 1e-12 to 1 F.
    pub fn new(gain: AmplifierGain, volts: Volts, load_f: f64) -> Result<Self, ImpossibleSetup> {
        if (1e-3..=1e3).contains(&volts.0) && (1e-12..=1.0).contains(&load_f) {
            Ok(Self {
                gain,
                volts_per_full_scale: volts.0,
                load_f,
            })
        } else {
            Err(ImpossibleSetup { volts, load_f })
        }
    }
    /// The drive (full scale = 1) at which the first limit is reached: 1, or less where the PC's output
    /// overdrives the amplifier's input.
    #[must_use]
    pub fn drive_limit(&self) -> f64 {
        (self.gain.full_scale_input().0 / self.volts_per_full_scale).min(1.0)
    }

    /// The name of the limit that [`Self::drive_limit`] gives.
    #[must_use]
    pub fn limited_by(&self) -> &'static str {
        if self.drive_limit() < 1.0 {
            "the amplifier"
        } else {
            "the digital full scale"
        }
    }

    /// The steepest slope at the actuator, V/s: `I_max / C`.
    #[must_use]
    pub fn slew_limit_v_per_s(&self) -> f64 {
        self.gain.output_current_a() / self.load_f
    }
}

/// The drive (full scale = 1) that stands behind a potential measured at the output of the PC.
///
/// Formula: u / volts per full scale.
///
/// Source: the calibration of the output, see [`DriveSetup::volts_per_full_scale`].
///
/// # Errors
/// [`SeriesError`] when `volts_per_full_scale` is not a number above zero, so that no finite drive comes out.
pub fn drive_of_potential(
    potential: &Series<Potential>,
    volts_per_full_scale: Volts,
) -> Result<Series<Drive>, SeriesError> {
    let drive = potential
        .samples()
        .iter()
        .map(|v| v / volts_per_full_scale.0)
        .collect();
    Series::new(drive, potential.rate())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_four_gains_are_those_of_the_data_sheet() {
        for (gain, ratio, input_v) in [
            (AmplifierGain::B1, 27.5, 0.908),
            (AmplifierGain::B2, 55.0, 0.910),
            (AmplifierGain::B3, 83.2, 0.902),
            (AmplifierGain::B4, 108.4, 0.923),
        ] {
            assert!((gain.voltage_ratio() - ratio).abs() < 0.06, "{gain}");
            assert!((gain.full_scale_input().0 - input_v).abs() < 1e-3, "{gain}");
            assert_eq!(gain.to_string().parse::<AmplifierGain>().unwrap(), gain);
        }
        assert!("B5".parse::<AmplifierGain>().is_err());
    }

    #[test]
    fn eighty_nanofarads_at_b3_are_slew_limited_above_560_hz_at_full_scale() {
        let setup = DriveSetup {
            gain: AmplifierGain::B3,
            volts_per_full_scale: 1.0,
            load_f: 80e-9,
        };
        let frequency_hz = setup.slew_limit_v_per_s() / (std::f64::consts::TAU * 75.0);
        assert!((frequency_hz - 562.5).abs() < 1.0, "{frequency_hz}");
    }
}
