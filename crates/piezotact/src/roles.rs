//! Channel roles: which channels of a recording are the vibration, the forces and the motion.

mod clock;

use serde::{Deserialize, Serialize};

use crate::quantity::{SampleRate, Unit};
use crate::recording::{
    Channel, ChannelRole, MissingChannel, Recording, RecordingError, RecordingWarning,
};
use crate::warning::Warning;

/// Most vibration channels that are taken without being named: a skin of taxels has more than one.
const MOST_CHANNELS: usize = 64;

/// The part that each channel of a recording plays, by name. What is absent was not measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Roles {
    /// What vibrates: one channel of acceleration, or all channels of a tactile skin.
    pub vibration: Vec<String>,
    /// The normal force, N.
    pub normal_force: Option<String>,
    /// The tangential forces, N: one or two.
    pub tangential_force: Vec<String>,
    /// How the surface or the finger moves.
    pub motion: Option<Motion>,
}

/// The channel that says how surface and finger move against each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// A channel of speed, m/s.
    Speed(String),
    /// A channel of position, m.
    Position(String),
}

impl Motion {
    /// The channel's name.
    #[must_use]
    pub fn channel(&self) -> &str {
        match self {
            Self::Speed(name) | Self::Position(name) => name,
        }
    }
}

impl Roles {
    /// The names of all channels that play a part.
    pub fn channels(&self) -> impl Iterator<Item = &str> + Clone {
        let named = self.vibration.iter().chain(&self.normal_force);
        let named = named.chain(&self.tangential_force).map(String::as_str);
        named.chain(self.motion.as_ref().map(Motion::channel))
    }

    /// The names of the channels of `recording` in N, m/s², m or m/s, or called as forces, that play no part: nothing is computed from
    /// them.
    #[must_use]
    pub fn without_part<'r>(&self, recording: &'r Recording) -> Vec<&'r str> {
        let units = [
            Unit::Newton,
            Unit::MetrePerSecondSquared,
            Unit::Metre,
            Unit::MetrePerSecond,
        ];
        let others = recording
            .channels()
            .iter()
            .filter(|c| units.contains(&c.unit) || is_force_in_other_unit(c));
        let names = others.map(|c| c.name.as_str());
        names
            .filter(|name| !self.channels().any(|own| own == *name))
            .collect()
    }

    /// The warning that a normal or tangential force is missing because channels of `recording` called so are in another unit.
    pub(crate) fn force_in_other_unit(&self, recording: &Recording) -> Option<Warning> {
        let channels = recording.channels().iter().filter(|c| {
            let is_missing = match has_name_of(&c.name, &TANGENTIAL) {
                true => self.tangential_force.is_empty(),
                false => self.normal_force.is_none(),
            };
            is_missing && is_force_in_other_unit(c) && !self.channels().any(|own| own == c.name)
        });
        let channels: Vec<String> = channels
            .map(|c| format!("`{}` ({})", c.name, c.unit))
            .collect();
        let warning = |channels| {
            Warning::from(RecordingWarning::ChannelMissing {
                what: MissingChannel::ForceUnit { channels },
            })
        };
        (!channels.is_empty()).then(|| warning(channels))
    }

    /// The rate in Hz that these channels of `recording` share.
    ///
    /// # Errors
    /// [`RecordingError::Clocks`] when they have no clock in common.
    pub fn rate_in(&self, recording: &Recording) -> Result<SampleRate, RecordingError> {
        recording.require_one_clock(self.channels())?;
        let first = self.channels().next();
        Ok(first.map_or(recording.rate(), |name| recording.clock_of(name).rate_hz))
    }

    /// The roles inferred from the units and names of the channels, with warnings about guesses.
    ///
    /// An acceleration vibrates; without one, a channel of speed that is called as a vibrometer or a vibration, which is never the motion;
    /// without one, the channels that are called so, or else every channel that is neither force, torque, motion, drive nor proximity. Forces
    /// are channels in N: `fz`, `fn`, `load` or a name with "normal" is the normal one, `fx`, `fy`, `ft` or a name with "tang" or "friction" are
    /// tangential, and a force alone is the normal one. A speed that nothing but its unit makes the motion is none beside a position: it may
    /// be that of the vibration.
    #[must_use]
    pub fn guess(recording: &Recording) -> (Self, Vec<Warning>) {
        let mut warnings = Vec::new();
        let channels = recording.channels();
        let (normal_force, tangential_force) = forces(channels, &mut warnings);
        let motion = match moving(channels, &Unit::MetrePerSecond, &mut warnings) {
            Some(name) => Some(Motion::Speed(name)),
            None => moving(channels, &Unit::Metre, &mut warnings).map(Motion::Position),
        };
        let roles = Self {
            vibration: vibrating(channels, &mut warnings),
            normal_force,
            tangential_force,
            motion,
        };
        (roles, warnings)
    }
}

/// Words in the names of normal and of tangential forces in English, German, French, Italian and Spanish; whole words, and parts of
/// words.
type ForceNames = (&'static [&'static str], &'static [&'static str]);
const NORMAL: ForceNames = (
    &[
        "fz", "fn", "f3", "load", "last", "charge", "carico", "carga",
    ],
    &["normal", "anpress", "andruck", "auflast"],
);
const TANGENTIAL: ForceNames = (
    &["fx", "fy", "ft", "f1", "f2"],
    &[
        "tang", "shear", "friction", "reib", "scher", "frott", "cisaill", "attrito", "taglio",
        "rozam", "fricc",
    ],
);
/// The word force.
const FORCE: [&str; 5] = ["force", "kraft", "forza", "fuerza", "effort"];
/// What may stand beside it in the name of a channel that holds no more than a force.
const OF_FORCE: [&str; 27] = [
    "",
    "x",
    "y",
    "z",
    "n",
    "t",
    "f",
    "fx",
    "fy",
    "fz",
    "fn",
    "ft",
    "normal",
    "normale",
    "tangential",
    "tangentielle",
    "tangenziale",
    "shear",
    "friction",
    "reib",
    "contact",
    "kontakt",
    "grip",
    "load",
    "ai",
    "ch",
    "channel",
];

/// Whether the name of a channel, without the structure that it stands in, says that it is a force and nothing else about it: `fz`,
/// `AI 2 Fz`, `rec.fz`, `Normalkraft`, `load`; not `force raw`.
///
/// Source: docs/guide/files.md, what laboratories call their channels.
///
/// ```
/// use piezotact::roles::is_force_name;
/// assert!(["rec.fz", "AI 2 Fz", "Reibkraft", "F_z"].iter().all(|name| is_force_name(name)));
/// assert!(!["force raw", "normal", "f", "offset"].iter().any(|name| is_force_name(name)));
/// ```
#[must_use]
pub fn is_force_name(name: &str) -> bool {
    let last = name.rsplit('.').next().unwrap_or(name);
    let mut words = words_of(last);
    words.push(plain(last));
    let whole = words.pop().unwrap_or_default();
    let without_force = |word: &str| {
        let force = FORCE.iter().find(|force| word.contains(*force));
        force.map_or(word.to_owned(), |force| word.replacen(force, "", 1))
    };
    let says = |word: &String| {
        ["fx", "fy", "fz", "fn", "ft", "load"].contains(&word.as_str())
            || FORCE.iter().any(|force| word.contains(force))
    };
    let fits = words
        .iter()
        .all(|word| OF_FORCE.contains(&without_force(word).as_str()));
    fits && (words.iter().any(says) || says(&whole))
}

/// Whether a name holds one of these words.
fn has_name_of(name: &str, (words, parts): &ForceNames) -> bool {
    let plain = plain(name);
    let mut own = words_of(name);
    // `Force X`, `F_z`, `zKraft`: what is left without the word.
    let rest = FORCE
        .iter()
        .find_map(|force| plain.contains(force).then(|| plain.replacen(force, "", 1)));
    own.extend(rest.map(|rest| format!("f{rest}")));
    own.push(plain.clone());
    parts.iter().any(|part| plain.contains(part))
        || own.iter().any(|own| words.contains(&own.as_str()))
}

/// The words of a name in small letters, without numbers at their ends but for the `f1` of a platform.
fn words_of(name: &str) -> Vec<String> {
    let words = name
        .split(|c: char| !c.is_alphanumeric())
        .map(str::to_lowercase);
    let short = |word: String| match word.as_str() {
        "f1" | "f2" | "f3" => word,
        word => word
            .trim_end_matches(|c: char| c.is_ascii_digit())
            .to_owned(),
    };
    words.map(short).filter(|word| !word.is_empty()).collect()
}

/// Whether a channel is called as a force and is in a unit that is none of a force: it neither is one, nor a vibration.
fn is_force_in_other_unit(channel: &Channel) -> bool {
    let is_other = match &channel.unit {
        Unit::Volt | Unit::FullScale => true,
        Unit::Other(unit) => !unit.is_empty(),
        _ => false,
    };
    is_other && is_force_name(&channel.name)
}

/// Whether `unit` is one of a torque: `Nm`, `N·mm`, `lbf-in`.
///
/// Source: docs/guide/files.md, the channels that laboratories record.
#[must_use]
pub fn is_torque_unit(unit: &Unit) -> bool {
    let unit: String = match unit {
        Unit::Other(unit) => unit.chars().filter(|c| c.is_alphanumeric()).collect(),
        _ => String::new(),
    };
    ["Nm", "Nmm", "mNm", "Ncm", "lbfin", "lbin", "inlb"].contains(&unit.as_str())
}

/// Whether a channel is a torque, by its unit or its name: the sensors that give three forces give three torques too.
fn is_torque(channel: &Channel) -> bool {
    is_torque_unit(&channel.unit)
        || is_called(
            channel,
            &["torque", "drehmoment", "momento"],
            &["tx", "ty", "tz", "mx", "my", "mz"],
        )
}

fn in_unit<'a>(channels: &'a [Channel], unit: &Unit) -> Vec<&'a Channel> {
    channels.iter().filter(|c| c.unit == *unit).collect()
}

/// Whether the plain name of `channel` contains one of `words`, or is one of `names`.
fn is_called(channel: &Channel, words: &[&str], names: &[&str]) -> bool {
    let name = plain(&channel.name);
    words.iter().any(|word| name.contains(word)) || names.contains(&name.as_str())
}

/// The normal force, and at most two tangential ones.
fn forces(channels: &[Channel], warnings: &mut Vec<Warning>) -> (Option<String>, Vec<String>) {
    let forces = in_unit(channels, &Unit::Newton);
    let tangential = |c: &Channel| has_name_of(&c.name, &TANGENTIAL);
    let normal = |c: &Channel| {
        !tangential(c)
            && (has_name_of(&c.name, &NORMAL)
                || plain(&c.name).starts_with("fz")
                || plain(&c.name).ends_with("fz"))
    };
    let normals = forces.iter().filter(|c| normal(c));
    let normals: Vec<String> = normals.map(|c| c.name.clone()).collect();
    let normal_force = match forces.as_slice() {
        [only] if !tangential(only) => Some(only.name.clone()),
        _ => normals.first().cloned(),
    };
    if normals.len() > 1 {
        warnings.push(Warning::from(RecordingWarning::ChannelChosen {
            role: ChannelRole::NormalForce,
            channel: normal_force.clone(),
            of: normals,
        }));
    }
    if normal_force.is_none() && !forces.is_empty() {
        warnings.push(Warning::from(RecordingWarning::ChannelChosen {
            role: ChannelRole::NormalForce,
            channel: None,
            of: forces.iter().map(|c| c.name.clone()).collect(),
        }));
    }
    let tangential_forces = forces.iter().filter(|c| tangential(c));
    let tangential_force: Vec<String> = tangential_forces.map(|c| c.name.clone()).take(2).collect();
    // A friction under another name would be missing without a word.
    let others = forces.iter().filter(|c| !normal(c));
    let others: Vec<String> = others.map(|c| c.name.clone()).collect();
    let others_than = |chosen: &String| others.iter().any(|other| other != chosen);
    if tangential_force.is_empty() && normal_force.as_ref().is_some_and(others_than) {
        warnings.push(Warning::from(RecordingWarning::ChannelChosen {
            role: ChannelRole::TangentialForce,
            channel: None,
            of: others,
        }));
    }
    (normal_force, tangential_force)
}

/// The channel in `unit`, a speed or a position, that says how surface and finger move.
fn moving(channels: &[Channel], unit: &Unit, warnings: &mut Vec<Warning>) -> Option<String> {
    let mut all = in_unit(channels, unit);
    all.retain(|c| !is_velocity_of_vibration(c));
    let known = |c: &&&Channel| is_called(c, &MOVING, &["v"]);
    let positions = in_unit(channels, &Unit::Metre);
    if let (Some(first), [position, ..]) = (all.first(), positions.as_slice())
        && *unit == Unit::MetrePerSecond
        && !all.iter().any(|c| known(&c))
    {
        warnings.push(Warning::from(RecordingWarning::ChannelChosen {
            role: ChannelRole::Motion,
            channel: Some(position.name.clone()),
            of: [*first, *position]
                .map(|c| format!("{} ({})", c.name, c.unit))
                .to_vec(),
        }));
        return None;
    }
    let chosen = all.iter().find(known).or(all.first())?;
    if all.len() > 1 {
        warnings.push(Warning::from(RecordingWarning::ChannelChosen {
            role: ChannelRole::Motion,
            channel: Some(chosen.name.clone()),
            of: all.iter().map(|c| format!("{} ({unit})", c.name)).collect(),
        }));
    }
    Some(chosen.name.clone())
}

/// Words in the name of a channel of speed that says how surface and finger move.
const MOVING: [&str; 4] = ["speed", "platform", "encoder", "stage"];

/// Whether a channel is the velocity of a vibration, as a laser vibrometer measures it, by its unit and its name.
fn is_velocity_of_vibration(channel: &Channel) -> bool {
    channel.unit == Unit::MetrePerSecond
        && is_called(channel, &["vib", "ldv", "laser", "doppler", "polytec"], &[])
        && !is_called(channel, &MOVING, &[])
}

fn vibrating(channels: &[Channel], warnings: &mut Vec<Warning>) -> Vec<String> {
    let mut measured = in_unit(channels, &Unit::MetrePerSecondSquared);
    if measured.is_empty() {
        measured = channels
            .iter()
            .filter(|c| is_velocity_of_vibration(c))
            .collect();
    }
    match measured.as_slice() {
        [] => {
            let others = without_acceleration(channels);
            if others.len() > 1 {
                warnings.push(Warning::from(RecordingWarning::ChannelChosen {
                    role: ChannelRole::Vibration,
                    channel: None,
                    of: others.clone(),
                }));
            }
            others
        }
        [only] => vec![only.name.clone()],
        several => {
            let chosen = several
                .iter()
                .find(|c| is_called(c, &["nail", "fiv"], &[]))
                .unwrap_or(&several[0]);
            warnings.push(Warning::from(RecordingWarning::ChannelChosen {
                role: ChannelRole::Vibration,
                channel: Some(chosen.name.clone()),
                of: several.iter().map(|c| c.name.clone()).collect(),
            }));
            vec![chosen.name.clone()]
        }
    }
}

/// What vibrates where no channel is an acceleration by its unit: those called so, or else every channel of no other role.
fn without_acceleration(channels: &[Channel]) -> Vec<String> {
    let others: Vec<String> = channels
        .iter()
        .filter(|c| matches!(c.unit, Unit::FullScale | Unit::Volt | Unit::Other(_)))
        .filter(|c| !is_force_in_other_unit(c) && !is_torque(c))
        .filter(|c| {
            !is_called(
                c,
                &["prox", "drive", "trigger", "encoder"],
                &["index", "time"],
            )
        })
        .map(|c| c.name.clone())
        .take(MOST_CHANNELS)
        .collect();
    let accelerations: Vec<String> = others
        .iter()
        .filter(|name| plain(name).contains("acc"))
        .cloned()
        .collect();
    if accelerations.is_empty() {
        others
    } else {
        accelerations
    }
}

/// A name in small letters without anything but letters and digits.
fn plain(name: &str) -> String {
    name.chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::SampleRate;
    use crate::recording::{Condition, Provenance};

    fn recording(channels: &[(&str, Unit)]) -> Recording {
        let channels = channels
            .iter()
            .map(|(name, unit)| Channel {
                name: (*name).into(),
                unit: unit.clone(),
                samples: vec![0.0; 4],
            })
            .collect();
        let rate = SampleRate::new(5000.0).unwrap();
        Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap()
    }

    #[test]
    fn names_and_units_say_what_a_channel_is() {
        let (roles, warnings) = Roles::guess(&recording(&[
            ("nail", Unit::MetrePerSecondSquared),
            ("Fx", Unit::Newton),
            ("Fy", Unit::Newton),
            ("F_z", Unit::Newton),
            ("encoder", Unit::Metre),
        ]));
        assert_eq!(roles.vibration, ["nail"]);
        assert_eq!(roles.normal_force.as_deref(), Some("F_z"));
        assert_eq!(roles.tangential_force, ["Fx", "Fy"]);
        assert_eq!(roles.motion, Some(Motion::Position("encoder".into())));
        assert_eq!(warnings, []);
    }

    #[test]
    fn forces_are_known_by_the_names_of_laboratories() {
        for (normal, tangential) in [
            ("AI 2 Fz", "AI 1 Fx"),
            ("rec.fz", "rec.fx"),
            ("Load", "Friction"),
            ("Anpresskraft", "Reibkraft"),
            ("Normalkraft", "Querkraft Fx"),
            ("effort normal", "force de frottement"),
            ("carico", "forza d'attrito"),
            ("Force Z", "Force X"),
            ("Kraft_z", "Kraft_t"),
        ] {
            let channels = [(tangential, Unit::Newton), (normal, Unit::Newton)];
            let (roles, warnings) = Roles::guess(&recording(&channels));
            assert_eq!(roles.normal_force.as_deref(), Some(normal));
            assert_eq!(roles.tangential_force, [tangential]);
            assert_eq!(warnings, []);
        }
    }

    #[test]
    fn a_force_of_unknown_name_beside_the_normal_one_is_said() {
        let channels = [
            ("fz", Unit::Newton),
            ("lateral", Unit::Newton),
            ("ay", Unit::MetrePerSecondSquared),
        ];
        let recording = recording(&channels);
        let (roles, warnings) = Roles::guess(&recording);
        assert_eq!(roles.tangential_force, [""; 0]);
        let [said] = warnings.as_slice() else {
            panic!("{warnings:?}")
        };
        let said = said.to_string();
        assert!(
            said.contains("none of lateral has a name known as that of a tangential force"),
            "{said}"
        );
        assert_eq!(roles.without_part(&recording), ["lateral"]);
    }

    #[test]
    fn the_velocity_of_a_vibrometer_vibrates_and_is_no_motion() {
        let guess = |channels: &[(&str, Unit)]| Roles::guess(&recording(channels)).0;
        let ldv = || ("LDV velocity", Unit::MetrePerSecond);
        let of = guess(&[ldv(), ("stage", Unit::Metre)]);
        assert_eq!(of.vibration, ["LDV velocity"]);
        assert_eq!(of.motion, Some(Motion::Position("stage".into())));
        let of = guess(&[ldv(), ("v", Unit::MetrePerSecond)]);
        assert_eq!(of.motion, Some(Motion::Speed("v".into())));
        assert_eq!(guess(&[ldv(), ("fz", Unit::Newton)]).motion, None);
        // An acceleration goes before it; a laser that measures the speed of the stage is none.
        let of = guess(&[ldv(), ("acc", Unit::MetrePerSecondSquared)]);
        assert_eq!((of.vibration, of.motion), (vec!["acc".to_owned()], None));
        let of = guess(&[("laser stage", Unit::MetrePerSecond)]);
        assert_eq!(of.motion, Some(Motion::Speed("laser stage".into())));
        assert!(of.vibration.is_empty());
    }

    #[test]
    fn a_force_in_volts_or_an_unknown_unit_is_none_and_named() {
        for unit in [Unit::Volt, Unit::Other("lbs".into())] {
            let channels = [("fz", unit.clone()), ("nail", Unit::Volt)];
            let recording = recording(&channels);
            let (roles, warnings) = Roles::guess(&recording);
            assert_eq!(
                (roles.normal_force.clone(), roles.vibration.len()),
                (None, 1)
            );
            assert_eq!(warnings, []);
            let said = roles.force_in_other_unit(&recording).unwrap().to_string();
            let named = format!("`fz` ({unit}): named as a force, but not used as a force");
            assert!(said.starts_with(&named), "{said}");
            assert_eq!(roles.without_part(&recording), ["fz"]);
        }
        // Beside a force in N of its kind it is the signal of the cell.
        for (other, is_missing) in [("fz", false), ("fx", true)] {
            let recording = recording(&[("Fz", Unit::Newton), (other, Unit::Volt)]);
            let (roles, _) = Roles::guess(&recording);
            assert_eq!(roles.force_in_other_unit(&recording).is_some(), is_missing);
        }
    }

    #[test]
    fn torques_of_a_force_sensor_do_not_vibrate() {
        let torque = |unit: &str| Unit::Other(unit.into());
        for unit in ["", "Nm", "N·m", "N-mm", "mN m"] {
            let channels = [
                ("Fz", Unit::Newton),
                ("Tx", torque(unit)),
                ("Moment y", torque("N.m")),
                ("Torque Z", torque(unit)),
            ];
            let (roles, _) = Roles::guess(&recording(&channels));
            assert_eq!(roles.vibration, [""; 0], "{unit}");
            let (roles, _) = Roles::guess(&recording(&[channels[0].clone(), ("mic", Unit::Volt)]));
            assert_eq!(roles.vibration, ["mic"]);
        }
    }

    #[test]
    fn a_velocity_beside_a_position_is_no_motion() {
        let channels = [
            ("velocity", Unit::MetrePerSecond),
            ("x", Unit::Metre),
            ("acc", Unit::MetrePerSecondSquared),
        ];
        let (roles, warnings) = Roles::guess(&recording(&channels));
        assert_eq!(roles.motion, Some(Motion::Position("x".into())));
        let said = warnings.first().map(ToString::to_string).unwrap();
        assert!(
            said.contains("`x` of velocity (m/s), x (m) is used as the motion"),
            "{said}"
        );
        // Alone it is the motion, and so is one that its name makes it.
        let (roles, warnings) = Roles::guess(&recording(&channels[..1]));
        assert_eq!(roles.motion, Some(Motion::Speed("velocity".into())));
        assert_eq!(warnings, []);
        let stage = [("stage velocity", Unit::MetrePerSecond), ("x", Unit::Metre)];
        let (roles, _) = Roles::guess(&recording(&stage));
        assert_eq!(roles.motion, Some(Motion::Speed("stage velocity".into())));
    }

    #[test]
    fn a_skin_of_taxels_vibrates_without_its_proximity() {
        let plain = || Unit::Other(String::new());
        let (roles, warnings) = Roles::guess(&recording(&[
            ("proximity1", plain()),
            ("channel1", plain()),
            ("channel2", plain()),
        ]));
        assert_eq!(roles.vibration, ["channel1", "channel2"]);
        assert_eq!(warnings.len(), 1);
        assert_eq!(roles.normal_force, None);
    }
}
