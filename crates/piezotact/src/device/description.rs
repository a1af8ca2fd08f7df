//! Device descriptions: the data-sheet values of amplifiers and actuators.

use std::fmt;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::contradiction::DescriptionError;
use crate::quantity::{Decibels, Volts};

/// The descriptions that come with the program, by the names that they are asked for.
pub const BUILT_IN: [(&str, &str); 2] = [
    ("drv2667", include_str!("drv2667.toml")),
    ("fixed", include_str!("fixed.toml")),
];

/// An amplifier with the actuator behind it and the input before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(try_from = "StatedDescription")]
pub struct DeviceDescription {
    pub(super) name: String,
    pub(super) amplifier: Amplifier,
    pub(super) actuator: Actuator,
    pub(super) input: Input,
}

/// A description as read from a file, before validation.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct StatedDescription {
    name: String,
    amplifier: Amplifier,
    actuator: Actuator,
    #[serde(default)]
    input: Input,
}

/// An amplifier: the gains that can be set on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Amplifier {
    /// The default gain; absent if there is only one gain, or no default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub usual_gain: Option<GainName>,
    /// The gains.
    #[serde(default)]
    pub gains: Vec<GainSetting>,
}

/// One gain of an amplifier.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GainSetting {
    /// What it is called on the amplifier.
    pub name: GainName,
    /// How much it amplifies.
    pub gain: VoltageGain,
    /// The output at which the amplifier clips, V peak.
    pub limit_v: f64,
    /// How steep its output can be; absent for an actuator that is no capacitance, where nothing states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slew: Option<Slew>,
}

/// How much an amplifier amplifies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum VoltageGain {
    /// In dB of the potential.
    Db(f64),
    /// Output over input.
    Ratio(f64),
}

/// What limits the slope of an amplifier's output.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Slew {
    /// The amplifier itself, V/s.
    VPerS(f64),
    /// The current that it pushes into the actuator, A peak.
    CurrentA(f64),
    /// The largest capacitance that it drives, as load tables of data sheets state it.
    #[serde(rename_all = "snake_case")]
    LargestLoad(LargestLoad),
}

/// A line of an amplifier's load table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LargestLoad {
    /// The output, V peak to peak.
    pub peak_to_peak_v: f64,
    /// The frequency of the sine, Hz.
    pub frequency_hz: f64,
    /// The capacitance, F.
    pub capacitance_f: f64,
}

/// An actuator, as the amplifier meets it: a capacitance, or a resistance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Actuator {
    /// Its kind.
    #[serde(default, skip_serializing_if = "ActuatorKind::is_piezo")]
    pub kind: ActuatorKind,
    /// The capacitance of a piezo, F.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capacitance_f: Option<f64>,
    /// The resistance of a coil, Ω.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resistance_ohm: Option<f64>,
    /// The largest potential that it may be given, V peak; absent where nothing states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_v: Option<f64>,
    /// The largest current through its resistance, A peak.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_current_a: Option<f64>,
    /// The largest current through its resistance, A rms over the loudest second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_current_rms_a: Option<f64>,
    /// The largest excursion from rest, m peak.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_excursion_m: Option<f64>,
}

/// The kinds of actuators, as HJIF names them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ActuatorKind {
    /// A piezoelectric actuator.
    #[default]
    Piezo,
    /// A voice coil.
    VoiceCoil,
    /// A linear resonant actuator.
    LinearResonant,
    /// Another one.
    Other,
}

impl ActuatorKind {
    /// Whether it is a piezoelectric actuator.
    #[must_use]
    pub fn is_piezo(&self) -> bool {
        *self == Self::Piezo
    }
}

impl Actuator {
    /// What the amplifier meets, such as `80 nF` or `8 Ω`.
    #[must_use]
    pub fn load(&self) -> String {
        match (self.capacitance_f, self.resistance_ohm) {
            (Some(load_f), _) => format!("{:.0} nF", load_f * 1e9),
            (None, Some(ohm)) => format!("{ohm} Ω"),
            (None, None) => "a load that is not stated".into(),
        }
    }

    /// The largest potential that its limits of potential and peak current allow, V peak; `None` where nothing states one.
    #[must_use]
    pub fn peak_limit_v(&self) -> Option<f64> {
        let of_current = self.limit_current_a.zip(self.resistance_ohm);
        let of_current = of_current.map(|(current_a, ohm)| current_a * ohm);
        self.limit_v.into_iter().chain(of_current).reduce(f64::min)
    }

    /// The largest potential that its limit of rms current allows, V rms; `None` where nothing states one.
    #[must_use]
    pub fn rms_limit_v(&self) -> Option<f64> {
        let of_current = self.limit_current_rms_a.zip(self.resistance_ohm);
        of_current.map(|(current_a, ohm)| current_a * ohm)
    }
}

/// What stands between the output of the PC and the amplifier.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Input {
    /// The share of the PC's potential that reaches the amplifier.
    pub divider: f64,
    /// How the amplifier's input is coupled.
    pub coupling: Coupling,
}

impl Default for Input {
    fn default() -> Self {
        Self {
            divider: 1.0,
            coupling: Coupling::Direct,
        }
    }
}

/// How an input is coupled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Coupling {
    /// With nothing between, or nothing that is known.
    Direct,
    /// Through a high-pass of first order with its corner at so many Hz.
    HighPassHz(f64),
}

/// The name of a gain, as the amplifier has it. Upper and lower case are one.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct GainName(String);

impl GainName {
    /// The name that a text holds, without the blanks around it.
    #[must_use]
    pub fn new(text: &str) -> Self {
        Self(text.trim().into())
    }

    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl PartialEq for GainName {
    fn eq(&self, other: &Self) -> bool {
        self.0.eq_ignore_ascii_case(&other.0)
    }
}

impl Eq for GainName {}

impl fmt::Display for GainName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Display for GainSetting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.name.fmt(f)
    }
}

/// A gain that the amplifier does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected a gain of the {device} ({gains}), found `{found}`; use the one set on the amplifier"
)]
pub struct UnknownGain {
    pub device: String,
    /// The gains that it has.
    pub gains: String,
    pub found: String,
}

impl GainSetting {
    /// The voltage gain, output over input.
    #[must_use]
    pub fn voltage_ratio(&self) -> f64 {
        match self.gain {
            VoltageGain::Db(db) => Decibels(db).amplitude_ratio(),
            VoltageGain::Ratio(ratio) => ratio,
        }
    }

    /// The output at which the amplifier clips, V peak.
    #[must_use]
    pub fn full_scale_output(&self) -> Volts {
        Volts(self.limit_v)
    }

    /// The steepest slope into a load of `load_f`, V/s; `None` where nothing limits it.
    ///
    /// Formula: I/C; of a line of a load table `I = π·Vpp·f·C`.
    #[must_use]
    pub fn slew_limit_v_per_s(&self, load_f: Option<f64>) -> Option<f64> {
        let current_a = match self.slew? {
            Slew::VPerS(slope) => return Some(slope),
            Slew::CurrentA(current) => current,
            Slew::LargestLoad(LargestLoad {
                peak_to_peak_v,
                frequency_hz,
                capacitance_f,
            }) => std::f64::consts::PI * peak_to_peak_v * frequency_hz * capacitance_f,
        };
        load_f.map(|load_f| current_a / load_f)
    }
}

static DRV2667: LazyLock<DeviceDescription> = LazyLock::new(|| {
    DeviceDescription::from_toml(BUILT_IN[0].1)
        .unwrap_or_else(|_| unreachable!("a text of this program that its tests read"))
});

impl DeviceDescription {
    /// The amplifier board and the actuator of the thesis, assumed for files that name a gain but no device.
    #[must_use]
    pub fn drv2667() -> &'static Self {
        &DRV2667
    }

    /// The description that comes with the program under `name`; `None` when none does.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        let (_, text) = BUILT_IN.iter().find(|(known, _)| *known == name)?;
        Self::from_toml(text).ok()
    }

    /// The device that a TOML text describes.
    ///
    /// Source: docs/decisions/house.md, for the fields.
    ///
    /// # Errors
    /// [`DescriptionError`] when it is no TOML, has a field too many or too few, or contradicts itself.
    pub fn from_toml(text: &str) -> Result<Self, DescriptionError> {
        let stated: StatedDescription = toml::from_str(text).map_err(|error| {
            let line = error
                .span()
                .map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
            let stands = line.and_then(|line| text.lines().nth(line - 1));
            let said = super::plain_words::of(error.message());
            DescriptionError::Text {
                line,
                example: super::plain_words::example(error.message(), stands.unwrap_or("")),
                said,
            }
        })?;
        Self::try_from(stated)
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The gains of its amplifier, at least one.
    #[must_use]
    pub fn gains(&self) -> &[GainSetting] {
        &self.amplifier.gains
    }

    /// Its actuator.
    #[must_use]
    pub fn actuator(&self) -> &Actuator {
        &self.actuator
    }

    /// What stands between the output of the PC and the amplifier.
    #[must_use]
    pub fn input(&self) -> &Input {
        &self.input
    }

    /// Its gain called `name`.
    ///
    /// # Errors
    /// [`UnknownGain`] with the gains that it has.
    pub fn gain(&self, name: &GainName) -> Result<&GainSetting, UnknownGain> {
        let mut gains = self.amplifier.gains.iter();
        gains
            .find(|gain| gain.name == *name)
            .ok_or_else(|| UnknownGain {
                device: self.name.clone(),
                gains: self.gain_names(),
                found: name.to_string(),
            })
    }

    /// Its gains by name, such as `B1, B2, B3 or B4`.
    #[must_use]
    pub fn gain_names(&self) -> String {
        let names: Vec<&str> = self
            .amplifier
            .gains
            .iter()
            .map(|gain| gain.name.as_str())
            .collect();
        match names.split_last() {
            Some((last, before)) if !before.is_empty() => {
                format!("{} or {last}", before.join(", "))
            }
            Some((only, _)) => (*only).into(),
            None => String::new(),
        }
    }

    /// The only gain that can be set; `None` where there are several.
    #[must_use]
    pub fn only_gain(&self) -> Option<&GainSetting> {
        match self.amplifier.gains.as_slice() {
            [only] => Some(only),
            _ => None,
        }
    }

    /// The gain that is set where nothing else is said: the usual one, else the first.
    #[must_use]
    pub fn usual_gain(&self) -> &GainSetting {
        let gains = &self.amplifier.gains;
        let usual = self.amplifier.usual_gain.as_ref();
        usual
            .and_then(|name| gains.iter().find(|gain| gain.name == *name))
            // A description has at least one gain, see `StatedDescription`.
            .unwrap_or(&gains[0])
    }
}

impl TryFrom<StatedDescription> for DeviceDescription {
    type Error = DescriptionError;

    fn try_from(stated: StatedDescription) -> Result<Self, DescriptionError> {
        let StatedDescription {
            name,
            amplifier,
            actuator,
            input,
        } = stated;
        let description = Self {
            name,
            amplifier,
            actuator,
            input,
        };
        super::contradiction::check(&description)?;
        Ok(description)
    }
}
