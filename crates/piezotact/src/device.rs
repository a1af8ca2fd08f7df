//! The signal path from the drive to the actuator: the output of the PC, and an amplifier with its gains and limits as
//! stated by a device description.

mod contradiction;
mod description;
mod plain_words;

use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use contradiction::DescriptionError;
pub use description::{
    Actuator, ActuatorKind, Amplifier, BUILT_IN, Coupling, DeviceDescription, GainName,
    GainSetting, Input, LargestLoad, Slew, UnknownGain, VoltageGain,
};

use crate::quantity::{Drive, Potential, Volts};
use crate::series::{Series, SeriesError};
use contradiction::LOADS_F;

/// How the drive reaches the actuator. A transfer function holds for the set-up it was measured with and
/// for no other, so it carries this, and rendering compares it. Files hold the gain by name, and the description of the
/// device; one that a person writes may leave the device out, and then means the [`DeviceDescription::drv2667`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(try_from = "StatedSetup", into = "StatedSetup")]
pub struct DriveSetup {
    /// The gain set on the amplifier.
    pub gain: Arc<GainSetting>,
    /// The potential at the output of the PC when the drive is at full scale, V peak, as calibrated.
    pub volts_per_full_scale: f64,
    /// The capacitance of the actuator, F; absent for one that is none.
    pub load_f: Option<f64>,
    /// The device, of whose gains it is one.
    device: Arc<DeviceDescription>,
}

/// A set-up as read from a file, before validation.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
struct StatedSetup {
    gain: GainName,
    volts_per_full_scale: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    load_f: Option<f64>,
    device: Option<DeviceDescription>,
}

impl From<DriveSetup> for StatedSetup {
    fn from(setup: DriveSetup) -> Self {
        Self {
            gain: setup.gain.name.clone(),
            volts_per_full_scale: setup.volts_per_full_scale,
            load_f: setup.load_f,
            device: Some(Arc::unwrap_or_clone(setup.device)),
        }
    }
}

impl TryFrom<StatedSetup> for DriveSetup {
    type Error = ImpossibleSetup;

    fn try_from(stated: StatedSetup) -> Result<Self, ImpossibleSetup> {
        let device = match stated.device {
            Some(device) => device,
            None => DeviceDescription::drv2667().clone(),
        };
        let set = device.at(&stated.gain)?;
        Self::new(set, Volts(stated.volts_per_full_scale), stated.load_f)
    }
}

/// A device with one of its gains set.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceAtGain {
    device: DeviceDescription,
    gain: GainSetting,
}

impl DeviceAtGain {
    /// The device.
    #[must_use]
    pub fn device(&self) -> &DeviceDescription {
        &self.device
    }

    /// The gain that is set.
    #[must_use]
    pub fn gain(&self) -> &GainSetting {
        &self.gain
    }
}

impl DeviceDescription {
    /// The device with its gain called `name` set.
    ///
    /// # Errors
    /// [`UnknownGain`] with the gains that it has.
    pub fn at(&self, name: &GainName) -> Result<DeviceAtGain, UnknownGain> {
        Ok(DeviceAtGain {
            gain: self.gain(name)?.clone(),
            device: self.clone(),
        })
    }

    /// The device with its usual gain set.
    #[must_use]
    pub fn at_usual_gain(&self) -> DeviceAtGain {
        DeviceAtGain {
            gain: self.usual_gain().clone(),
            device: self.clone(),
        }
    }
}

/// An impossible set-up.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImpossibleSetup {
    /// A potential or a capacitance that cannot be.
    #[error(
        "expected 0.001 to 1000 V at full scale and a load of 1e-12 to 1 F, found {volts} and {} F; calibrate the output",
        load_f.map_or("no".into(), |load_f| load_f.to_string())
    )]
    Numbers { volts: Volts, load_f: Option<f64> },
    /// A gain that the device does not have.
    #[error(transparent)]
    Gain(#[from] UnknownGain),
}

impl DriveSetup {
    /// The device as it is `set`, behind an output of `volts` at full scale, before an actuator with a capacitance of `load_f`,
    /// or with none, as its description says.
    ///
    /// # Errors
    /// [`ImpossibleSetup`] when the potential is not from 0.001 to 1000 V, the load not from 1e-12 to 1 F, or absent for an actuator
    /// that is described as a capacitance.
    pub fn new(
        set: DeviceAtGain,
        volts: Volts,
        load_f: Option<f64>,
    ) -> Result<Self, ImpossibleSetup> {
        let fits = match load_f {
            Some(load_f) => LOADS_F.contains(&load_f),
            None => set.device.actuator.capacitance_f.is_none(),
        };
        if (1e-3..=1e3).contains(&volts.0) && fits {
            Ok(Self {
                gain: Arc::new(set.gain),
                volts_per_full_scale: volts.0,
                load_f,
                device: Arc::new(set.device),
            })
        } else {
            Err(ImpossibleSetup::Numbers { volts, load_f })
        }
    }

    /// The device whose gain is set.
    #[must_use]
    pub fn device(&self) -> &DeviceDescription {
        &self.device
    }

    /// The same set-up with another gain of its device.
    ///
    /// # Errors
    /// [`UnknownGain`] with the gains that the device has.
    pub fn with_gain(&self, name: &GainName) -> Result<Self, UnknownGain> {
        Ok(Self {
            gain: Arc::new(self.device.gain(name)?.clone()),
            ..self.clone()
        })
    }

    /// Whether a drive for one of them gives the same signal at the actuator of the other, apart from the output level:
    /// the gain with its limits, and the input before it.
    #[must_use]
    pub fn amplifies_like(&self, other: &Self) -> bool {
        self.gain == other.gain && self.device.input == other.device.input
    }

    /// The amplifier with its gain as text: `DRV2667 at gain B3 (×83.2, up to 75 V)`.
    #[must_use]
    pub fn amplification(&self) -> String {
        let divider = self.device.input.divider;
        let before = match divider {
            whole if whole >= 1.0 => String::new(),
            share => format!(" behind a divider of {share}"),
        };
        format!(
            "{} at gain {} (×{:.1}, up to {} V){before}",
            self.device.name,
            self.gain,
            self.gain.voltage_ratio(),
            self.gain.limit_v
        )
    }

    /// The drive (full scale = 1) at which the first limit is reached: 1, or less where the PC's output
    /// overdrives the amplifier's input, or the amplifier the actuator.
    #[must_use]
    pub fn drive_limit(&self) -> f64 {
        let full_scale = self.volts_per_full_scale * self.device.input.divider;
        let limit_v = match self.device.actuator.peak_limit_v() {
            Some(actuator_v) => actuator_v.min(self.gain.limit_v),
            None => self.gain.limit_v,
        };
        (limit_v / self.gain.voltage_ratio() / full_scale).min(1.0)
    }

    /// The name of the limit that [`Self::drive_limit`] gives.
    #[must_use]
    pub fn limited_by(&self) -> &'static str {
        let actuator_v = self.device.actuator.peak_limit_v();
        if self.drive_limit() >= 1.0 {
            "the digital full scale"
        } else if actuator_v.is_some_and(|limit_v| limit_v < self.gain.limit_v) {
            "the actuator"
        } else {
            "the amplifier"
        }
    }

    /// The potential at the actuator for a drive at full scale, were there no limit, V peak.
    #[must_use]
    pub fn actuator_v_per_full_scale(&self) -> f64 {
        self.gain.voltage_ratio() * self.volts_per_full_scale * self.device.input.divider
    }

    /// The largest rms of a drive (full scale = 1) over a second, from the current that the actuator may carry; `None` without such a
    /// limit.
    #[must_use]
    pub fn rms_limit(&self) -> Option<f64> {
        let limit_v = self.device.actuator.rms_limit_v()?;
        Some(limit_v / self.actuator_v_per_full_scale())
    }

    /// The steepest slope at the actuator, V/s; `None` where nothing limits it.
    #[must_use]
    pub fn slew_limit_v_per_s(&self) -> Option<f64> {
        self.gain.slew_limit_v_per_s(self.load_f)
    }

    /// The steepest drive (full scale = 1) that the amplifier follows, 1/s; `None` where nothing limits it.
    #[must_use]
    pub fn slew_limit_per_s(&self) -> Option<f64> {
        Some(self.slew_limit_v_per_s()? / self.actuator_v_per_full_scale())
    }

    /// The actuator as the amplifier meets it, such as `80 nF` or `8 Ω`.
    #[must_use]
    pub fn load(&self) -> String {
        let met = Actuator {
            capacitance_f: self.load_f,
            ..self.device.actuator.clone()
        };
        met.load()
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

    fn b3() -> DeviceAtGain {
        let name = GainName::new("B3");
        DeviceDescription::drv2667().at(&name).unwrap()
    }

    #[test]
    fn the_four_gains_are_those_of_the_data_sheet() {
        let device = DeviceDescription::drv2667();
        for (name, ratio, input_v, output_v) in [
            ("B1", 27.5, 0.908, 25.0),
            ("B2", 55.0, 0.910, 50.0),
            ("b3", 83.2, 0.902, 75.0),
            ("B4", 108.4, 0.923, 100.0),
        ] {
            let gain = device.gain(&GainName::new(name)).unwrap();
            assert!((gain.voltage_ratio() - ratio).abs() < 0.06, "{name}");
            let clips_at_v = gain.full_scale_output().0 / gain.voltage_ratio();
            assert!((clips_at_v - input_v).abs() < 1e-3, "{name}");
            assert_eq!(gain.full_scale_output().0, output_v);
        }
        let said = device.gain(&GainName::new("B5")).unwrap_err().to_string();
        assert!(
            said.contains("DRV2667 (B1, B2, B3 or B4), found `B5`"),
            "{said}"
        );
        assert_eq!(device.usual_gain().name.as_str(), "B3");
        assert_eq!(device.only_gain(), None);
    }

    #[test]
    fn eighty_nanofarads_at_b3_are_slew_limited_above_560_hz_at_full_scale() {
        let setup = DriveSetup::new(b3(), Volts(1.0), Some(80e-9)).unwrap();
        let frequency_hz = setup.slew_limit_v_per_s().unwrap() / (std::f64::consts::TAU * 75.0);
        assert!((frequency_hz - 562.5).abs() < 1.0, "{frequency_hz}");
    }

    /// A fixed gain of 20 behind a divider by two: 10 V at the PC are 5 V at the amplifier and 100 V behind it.
    #[test]
    fn a_fixed_amplifier_behind_a_divider_has_its_own_limits() {
        let mut device = DeviceDescription::built_in("fixed").unwrap();
        device.input.divider = 0.5;
        let setup = |device: &DeviceDescription, volts: f64| {
            let load_f = device.actuator.capacitance_f;
            DriveSetup::new(device.at_usual_gain(), Volts(volts), load_f).unwrap()
        };
        let loud = setup(&device, 20.0);
        assert_eq!(
            (loud.drive_limit(), loud.limited_by()),
            (0.5, "the amplifier")
        );
        assert_eq!(loud.actuator_v_per_full_scale(), 200.0);
        assert_eq!(loud.slew_limit_v_per_s(), Some(1.0 / 80e-9));
        let soft = setup(&device, 5.0);
        assert_eq!(
            (soft.drive_limit(), soft.limited_by()),
            (1.0, "the digital full scale")
        );
        device.amplifier.gains[0].limit_v = 200.0;
        let loud = setup(&device, 20.0);
        assert_eq!(
            (loud.drive_limit(), loud.limited_by()),
            (0.5, "the actuator")
        );
        device.amplifier.gains[0].slew = Some(Slew::VPerS(3e6));
        assert_eq!(setup(&device, 1.0).slew_limit_v_per_s(), Some(3e6));
        assert!(!loud.amplifies_like(&setup(DeviceDescription::drv2667(), 20.0)));
    }

    /// A voice coil has no capacitance and needs no slew; its currents limit the drive.
    #[test]
    fn a_voice_coil_is_described_by_its_resistance_and_currents() {
        const LOUD: &str = r#"
name = "coil"
[amplifier]
[[amplifier.gains]]
name = "x2"
gain = { ratio = 2.0 }
limit_v = 6.0
[actuator]
kind = "voice_coil"
resistance_ohm = 8.0
limit_current_a = 0.5
limit_current_rms_a = 0.1
limit_excursion_m = 0.4e-3
"#;
        let device = DeviceDescription::from_toml(LOUD).unwrap();
        let setup = DriveSetup::new(device.at_usual_gain(), Volts(4.0), None).unwrap();
        assert_eq!(setup.slew_limit_v_per_s(), None);
        assert_eq!(
            (setup.drive_limit(), setup.limited_by()),
            (0.5, "the actuator")
        );
        assert!((setup.rms_limit().unwrap() - 0.1).abs() < 1e-12);
        assert_eq!(setup.load(), "8 Ω");
        let text = serde_json::to_string(&setup).unwrap();
        assert_eq!(serde_json::from_str::<DriveSetup>(&text).unwrap(), setup);
        for (from, to, expected) in [
            (
                "limit_v = 6.0",
                "limit_v = 6.0\nslew = { current_a = 1.0 }",
                "without one, because its actuator has no capacitance_f",
            ),
            (
                "resistance_ohm = 8.0\n",
                "",
                "resistance_ohm with a limit of current",
            ),
            (
                "limit_excursion_m = 0.4e-3",
                "limit_excursion_m = 0.0",
                "an excursion of the actuator above 0 m",
            ),
        ] {
            let wrong = LOUD.replace(from, to);
            let said = DeviceDescription::from_toml(&wrong)
                .unwrap_err()
                .to_string();
            assert!(said.contains(expected), "{said}");
        }
    }

    /// A set-up without a device is one with the DRV2667; what is written contains the device's values.
    #[test]
    fn a_set_up_is_stored_with_its_device() {
        let by_hand = r#"{"gain": "B3", "volts_per_full_scale": 1.25, "load_f": 8e-8}"#;
        let setup: DriveSetup = serde_json::from_str(by_hand).unwrap();
        assert_eq!(
            setup,
            DriveSetup::new(b3(), Volts(1.25), Some(80e-9)).unwrap()
        );
        let text = serde_json::to_string(&setup).unwrap();
        assert!(
            text.starts_with(
                r#"{"gain":"B3","volts_per_full_scale":1.25,"load_f":8e-8,"device":{"#
            )
        );
        assert_eq!(serde_json::from_str::<DriveSetup>(&text).unwrap(), setup);
        for (from, to, expected) in [
            ("B3", "B9", "found `B9`"),
            ("1.25", "-1.25", "0.001 to 1000 V"),
        ] {
            let wrong = by_hand.replace(from, to);
            let said = serde_json::from_str::<DriveSetup>(&wrong)
                .unwrap_err()
                .to_string();
            assert!(said.contains(expected), "{said}");
        }
        let own = text
            .replace("DRV2667", "own")
            .replace("\"limit_v\":25.0", "\"limit_v\":500.0");
        let own: DriveSetup = serde_json::from_str(&own.replace("B1", "low")).unwrap();
        assert!(own.with_gain(&GainName::new("low")).is_ok());
        assert!(own.with_gain(&GainName::new("B1")).is_err());
    }
}
