//! Validation of device descriptions: contradictions that are refused.

use super::description::{Coupling, DeviceDescription, GainSetting, Slew, VoltageGain};
use crate::number::rounded;

/// The capacitances that an actuator can have, F.
pub(super) const LOADS_F: std::ops::RangeInclusive<f64> = 1e-12..=1.0;

/// Why a device description is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DescriptionError {
    /// The text does not hold the fields of a description.
    #[error(
        "expected a description of a device{}, found {said}; {}compare it with the example in the README",
        line.map_or(String::new(), |line| format!(" in line {line}")),
        example.map_or(String::new(), |example| format!("write it as in `{example}`, or "))
    )]
    Text {
        /// The line, from 1, where it is known.
        line: Option<usize>,
        /// What is wrong with it.
        said: String,
        /// How the entry is written, where it is known.
        example: Option<&'static str>,
    },
    /// A name is empty.
    #[error("expected a name of {of}, found none; give it one")]
    NoName {
        /// What has no name.
        of: &'static str,
    },
    /// The amplifier has no gain.
    #[error("the {device} has no gain: describe the one that is set")]
    NoGain { device: String },
    /// A gain is there twice.
    #[error("expected every gain of the {device} once, found {gain} twice; give each its own name")]
    GainTwice { device: String, gain: String },
    /// The usual gain is none of the gains.
    #[error(
        "expected a usual gain that the {device} has ({gains}), found {found}; use one of them"
    )]
    NoSuchUsualGain {
        device: String,
        gains: String,
        found: String,
    },
    /// A number that cannot be.
    #[error(
        "expected {expected}, found {found}; correct the description of the {device}",
        found = rounded(*found)
    )]
    Number {
        device: String,
        expected: String,
        found: f64,
    },
    /// The load table is of a larger output than the amplifier gives.
    #[error(
        "expected a load table of gain {gain} up to twice its limit of {limit_v} V peak, which is {} V peak to peak, found {peak_to_peak_v} V peak to peak; correct the limit or the table of the {device}",
        2.0 * limit_v
    )]
    LoadTableAboveLimit {
        device: String,
        gain: String,
        /// Its limit, V peak.
        limit_v: f64,
        /// The output of the load table, V peak to peak.
        peak_to_peak_v: f64,
    },
    /// An amplifier whose slope depends on a capacitance that the actuator does not have, or is unknown where it has one.
    #[error("expected gain {gain} of the {device} {expected}; correct the description")]
    SlewAndLoad {
        device: String,
        gain: String,
        expected: &'static str,
    },
    /// The actuator bears less than the amplifier gives at its lowest gain.
    #[error(
        "expected an actuator of the {device} with a limit of at least {lowest_v} V, which its lowest gain {gain} can give, \
            found a limit of {limit_v} V; correct one of them"
    )]
    LimitBelowLowestGain {
        device: String,
        /// The gain with the lowest limit.
        gain: String,
        /// Its limit, V peak.
        lowest_v: f64,
        /// The limit of the actuator, V peak.
        limit_v: f64,
    },
}

/// Whether a description is free of contradictions.
pub(super) fn check(description: &DeviceDescription) -> Result<(), DescriptionError> {
    let device = || description.name.clone();
    if description.name.trim().is_empty() {
        return Err(DescriptionError::NoName { of: "the device" });
    }
    let number = |holds: bool, expected: String, found: f64| {
        if holds {
            Ok(())
        } else {
            Err(DescriptionError::Number {
                device: device(),
                expected,
                found,
            })
        }
    };
    let gains = &description.amplifier.gains;
    let Some(lowest) = gains.iter().min_by(|a, b| a.limit_v.total_cmp(&b.limit_v)) else {
        return Err(DescriptionError::NoGain { device: device() });
    };
    for (i, gain) in gains.iter().enumerate() {
        if gain.name.as_str().trim().is_empty() {
            return Err(DescriptionError::NoName { of: "every gain" });
        }
        if gains[..i].iter().any(|other| other.name == gain.name) {
            return Err(DescriptionError::GainTwice {
                device: device(),
                gain: gain.to_string(),
            });
        }
        check_gain(gain, &number)?;
        let expected = match (gain.slew, description.actuator.capacitance_f) {
            (None, Some(_)) => Some("with a slew, because its actuator is a capacitance"),
            (Some(Slew::CurrentA(_) | Slew::LargestLoad(_)), None) => Some(
                "with a slew as { v_per_s = … } or without one, because its actuator has no capacitance_f",
            ),
            _ => None,
        };
        if let Some(expected) = expected {
            return Err(DescriptionError::SlewAndLoad {
                device: device(),
                gain: gain.to_string(),
                expected,
            });
        }
        if let Some(Slew::LargestLoad(load)) = gain.slew
            && load.peak_to_peak_v > 2.0 * gain.limit_v * (1.0 + 1e-9)
        {
            return Err(DescriptionError::LoadTableAboveLimit {
                device: device(),
                gain: gain.to_string(),
                limit_v: gain.limit_v,
                peak_to_peak_v: load.peak_to_peak_v,
            });
        }
    }
    if let Some(usual) = &description.amplifier.usual_gain
        && !gains.iter().any(|gain| gain.name == *usual)
    {
        return Err(DescriptionError::NoSuchUsualGain {
            device: device(),
            gains: description.gain_names(),
            found: usual.to_string(),
        });
    }
    let actuator = &description.actuator;
    if let Some(capacitance_f) = actuator.capacitance_f {
        number(
            LOADS_F.contains(&capacitance_f),
            "an actuator of 1e-12 to 1 F".into(),
            capacitance_f,
        )?;
    }
    for (stated, what) in [
        (
            actuator.resistance_ohm,
            "a resistance of the actuator above 0 Ω",
        ),
        (
            actuator.limit_current_a,
            "a peak current of the actuator above 0 A",
        ),
        (
            actuator.limit_current_rms_a,
            "an rms current of the actuator above 0 A",
        ),
        (
            actuator.limit_excursion_m,
            "an excursion of the actuator above 0 m",
        ),
    ] {
        let Some(value) = stated else { continue };
        number(value > 0.0 && value.is_finite(), what.into(), value)?;
    }
    let current_a = actuator.limit_current_a.or(actuator.limit_current_rms_a);
    if let (Some(found), None) = (current_a, actuator.resistance_ohm) {
        number(
            false,
            "resistance_ohm with a limit of current of the actuator".into(),
            found,
        )?;
    }
    if let Some(limit_v) = actuator.limit_v {
        number(
            limit_v > 0.0 && limit_v.is_finite(),
            "a limit of the actuator above 0 V".into(),
            limit_v,
        )?;
        if limit_v < lowest.limit_v {
            return Err(DescriptionError::LimitBelowLowestGain {
                device: device(),
                gain: lowest.to_string(),
                lowest_v: lowest.limit_v,
                limit_v,
            });
        }
    }
    let divider = description.input.divider;
    number(
        divider > 0.0 && divider <= 1.0,
        "a divider that passes a share above 0 and up to 1".into(),
        divider,
    )?;
    if let Coupling::HighPassHz(corner_hz) = description.input.coupling {
        number(
            corner_hz > 0.0 && corner_hz.is_finite(),
            "a corner of the input's high-pass above 0 Hz".into(),
            corner_hz,
        )?;
    }
    Ok(())
}

fn check_gain(
    gain: &GainSetting,
    number: &dyn Fn(bool, String, f64) -> Result<(), DescriptionError>,
) -> Result<(), DescriptionError> {
    let above_zero = |value: f64| value > 0.0 && value.is_finite();
    match gain.gain {
        VoltageGain::Db(db) => number(
            (-120.0..=120.0).contains(&db),
            format!("gain {gain} within -120 to 120 dB"),
            db,
        )?,
        VoltageGain::Ratio(ratio) => number(
            (1e-6..=1e6).contains(&ratio),
            format!("gain {gain} as a ratio of 1e-6 to 1e6"),
            ratio,
        )?,
    }
    number(
        above_zero(gain.limit_v),
        format!("gain {gain} with a limit above 0 V"),
        gain.limit_v,
    )?;
    let Some(slew) = gain.slew else {
        return Ok(());
    };
    match slew {
        Slew::VPerS(slope) => number(
            above_zero(slope),
            format!("gain {gain} with a slew above 0 V/s"),
            slope,
        ),
        Slew::CurrentA(current) => number(
            above_zero(current),
            format!("gain {gain} with a current above 0 A"),
            current,
        ),
        Slew::LargestLoad(load) => [
            ("an output above 0 V", load.peak_to_peak_v),
            ("a frequency above 0 Hz", load.frequency_hz),
            ("a capacitance above 0 F", load.capacitance_f),
        ]
        .into_iter()
        .try_for_each(|(what, value)| {
            number(
                above_zero(value),
                format!("gain {gain} with a largest load of {what}"),
                value,
            )
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::super::description::BUILT_IN;
    use super::*;

    /// A description that contradicts itself is named, with what was expected and found.
    #[test]
    fn contradictions_are_named() {
        let good = BUILT_IN[0].1;
        for (from, to, expected) in [
            (
                "limit_v = 100.0\n\n[input]",
                "limit_v = 20.0\n\n[input]",
                "with a limit of at least 25 V, which its lowest gain B1 can give, found a limit of 20 V",
            ),
            (
                "name = \"B2\"",
                "name = \"b1\"",
                "every gain of the DRV2667 once, found b1 twice",
            ),
            (
                "capacitance_f = 80e-9",
                "capacitance_f = -80e-9",
                "an actuator of 1e-12 to 1 F, found -8e-8",
            ),
            (
                "usual_gain = \"B3\"",
                "usual_gain = \"B7\"",
                "that the DRV2667 has (B1, B2, B3 or B4), found B7",
            ),
            (
                "limit_v = 75.0",
                "limit_v = 0.0",
                "gain B3 with a limit above 0 V, found 0",
            ),
            (
                "gain = { db = 38.4 }",
                "gain = { ratio = -83.0 }",
                "gain B3 as a ratio of 1e-6 to 1e6, found -83",
            ),
            (
                "gain = { db = 38.4 }",
                "gain = { db = nan }",
                "gain B3 within -120 to 120 dB, found NaN",
            ),
            (
                "divider = 1.0",
                "divider = 0.0",
                "a divider that passes a share above 0 and up to 1, found 0",
            ),
            (
                "coupling = \"direct\"",
                "coupling = { high_pass_hz = -3 }",
                "above 0 Hz, found -3",
            ),
            (
                "peak_to_peak_v = 150.0",
                "peak_to_peak_v = 0",
                "gain B3 with a largest load of an output above 0 V, found 0",
            ),
            (
                "name = \"DRV2667\"",
                "name = \" \"",
                "a name of the device, found none",
            ),
            (
                "divider = 1.0",
                "dividor = 1.0",
                "an entry called `dividor`",
            ),
            (
                "divider = 1.0",
                "divider = \"half\"",
                "the text \"half\" where a number belongs; write it as in `divider = 0.5`",
            ),
            (
                "gain = { db = 38.4 }",
                "gain = { db = 38.4, ratio = 3 }",
                "several entries where one belongs; write it as in `gain = { ratio = 20 }`",
            ),
            (
                "gain = { db = 38.4 }",
                "gain = 83",
                "a plain value where an entry in braces belongs; write it as in `gain = { ratio = 20 }`",
            ),
            (
                "capacitance_f = 80e-9",
                "limit_nv = 3",
                "an entry called `limit_nv`, which is none of",
            ),
            (
                "coupling = \"direct\"",
                "coupling = \"ac\"",
                "`ac`, which is none of",
            ),
            (
                "peak_to_peak_v = 150.0",
                "peak_to_peak_v = 300.0",
                "gain B3 up to twice its limit of 75 V peak, which is 150 V peak to peak, found 300",
            ),
            ("[actuator]", "[actuator", "in line"),
        ] {
            let text = good.replace(from, to);
            assert_ne!(text, good, "{from}");
            let said = DeviceDescription::from_toml(&text).unwrap_err().to_string();
            assert!(said.contains(expected), "{to}: {said}");
            assert!([';', ':'].iter().any(|sign| said.contains(*sign)), "{said}");
            assert!(!said.contains('\n'), "{said}");
        }
        let fixed = BUILT_IN[1].1;
        for (from, to, expected) in [
            (
                "slew = { current_a = 1.0 }",
                "slew = { v_per_s = 0 }",
                "gain x20 with a slew above 0 V/s, found 0",
            ),
            (
                "slew = { current_a = 1.0 }",
                "slew = { current_a = -1 }",
                "a current above 0 A, found -1",
            ),
            ("slew = { current_a = 1.0 }", "", "slew"),
        ] {
            let text = fixed.replace(from, to);
            assert_ne!(text, fixed, "{from}");
            let said = DeviceDescription::from_toml(&text).unwrap_err().to_string();
            assert!(said.contains(expected), "{to}: {said}");
        }
        let none = "name = \"a\"\n[amplifier]\n[actuator]\ncapacitance_f = 1e-7\n";
        let said = DeviceDescription::from_toml(none).unwrap_err().to_string();
        assert!(said.contains("the a has no gain"), "{said}");
    }
}
