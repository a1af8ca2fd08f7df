//! `twin:participant=3,seed=7,gain=B3`, `twin:device=own.toml`: the digital twin.

use std::path::Path;

use piezotact::device::{DeviceAtGain, DeviceDescription, GainName};
use piezotact_bench::{Bench, DeviceError};
use piezotact_dataset::read_device;
use piezotact_twin::{Participant, TwinBench, TwinParameters};

use super::{BenchEntry, BenchSpec, NamedBench, whole, wrong};
use crate::failure::{Outcome, usage};

/// The line of the table of benches.
pub(super) const ENTRY: BenchEntry = BenchEntry {
    name: "twin",
    example: "twin:participant=1,seed=7",
    help: "twin, or twin:participant=K,seed=N,gain=B3,device=NAME|FILE.toml",
    help_with_turns: Some("twin, or twin:seed=N,gain=B3,device=NAME|FILE.toml"),
    parse,
};

/// The digital twin with one participant at it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TwinSpec {
    /// Whose finger, from 1; 0 is the reference participant. Absent for the first.
    pub(crate) participant: Option<u64>,
    /// The seed that draws every participant, placement and noise.
    pub(crate) seed: u64,
    /// The gain that is set on the amplifier; absent for the usual one.
    pub(crate) gain: Option<GainName>,
    /// The device by its name or its file; absent for that of the thesis.
    pub(crate) device: Option<String>,
}

impl TwinSpec {
    /// The device with its gain set, where it is one that comes with the program; `None` where it is a file.
    fn built_in(&self) -> Option<DeviceDescription> {
        match &self.device {
            None => Some(DeviceDescription::drv2667().clone()),
            Some(name) => DeviceDescription::built_in(name),
        }
    }

    pub(super) fn set(&self) -> Outcome<DeviceAtGain> {
        let device = match &self.device {
            None => DeviceDescription::drv2667().clone(),
            Some(named) => read_device(named)?,
        };
        match &self.gain {
            None => Ok(device.at_usual_gain()),
            Some(gain) => device.at(gain).map_err(usage),
        }
    }
}

impl NamedBench for TwinSpec {
    fn open(&self) -> Outcome<Bench> {
        let parameters = TwinParameters::built_in();
        let participant = Participant::of(self.participant.unwrap_or(1), self.seed, &parameters);
        Ok(TwinBench::new(&parameters, participant, &self.set()?).into_bench())
    }

    fn file(&self) -> Option<&Path> {
        let named = self.device.as_deref();
        named.filter(|_| self.built_in().is_none()).map(Path::new)
    }

    fn participant(&self) -> Option<u64> {
        self.participant
    }

    #[cfg(feature = "study")]
    fn person_of_twin(&self) -> Option<(u64, u64)> {
        Some((self.participant.unwrap_or(1), self.seed))
    }

    fn with_participant(&self, number: u64) -> Result<BenchSpec, DeviceError> {
        Ok(BenchSpec::of(Self {
            participant: Some(number),
            ..self.clone()
        }))
    }

    fn apart_from_participant(&self) -> String {
        let usual = || {
            self.built_in()
                .map(|device| device.usual_gain().name.clone())
        };
        let gain = self.gain.clone().or_else(usual);
        let gain = gain.map_or(String::new(), |gain| format!(",gain={gain}"));
        let device = self.device.as_ref();
        let device = device.map_or(String::new(), |device| format!(",device={device}"));
        format!("twin:seed={}{gain}{device}", self.seed)
    }
}

fn parse(settings: &str) -> Result<BenchSpec, DeviceError> {
    spec(settings).map(BenchSpec::of)
}

/// The twin of `settings`, as they stand behind `twin:`.
pub(super) fn spec(settings: &str) -> Result<TwinSpec, DeviceError> {
    let mut spec = TwinSpec {
        participant: None,
        seed: 1,
        gain: None,
        device: None,
    };
    for setting in settings.split(',').filter(|setting| !setting.is_empty()) {
        let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
        match key {
            "participant" => spec.participant = Some(whole(setting, value)?),
            "seed" => spec.seed = whole(setting, value)?,
            "gain" => spec.gain = Some(GainName::new(value)),
            "device" if !value.is_empty() => spec.device = Some(value.into()),
            _ => return Err(wrong("participant, seed, gain or device", setting)),
        }
    }
    // The gains of a file are known when it is read.
    if let (Some(gain), Some(device)) = (&spec.gain, spec.built_in()) {
        let known = device.gain(gain).map(|gain| gain.name.clone());
        let expected = format!("a gain of the {} ({})", device.name(), device.gain_names());
        spec.gain = Some(known.map_err(|_unknown| wrong(&expected, &format!("gain={gain}")))?);
    }
    Ok(spec)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twin_has_settings() {
        assert_eq!(
            spec("participant=3,seed=9,gain=b2").unwrap(),
            TwinSpec {
                participant: Some(3),
                seed: 9,
                gain: Some(GainName::new("B2")),
                device: None,
            }
        );
        for bad in [
            "participant=x",
            "gain=B9",
            "colour=red",
            "device=fixed,gain=B3",
            "device=",
        ] {
            assert!(spec(bad).is_err(), "{bad}");
        }
        for (settings, named) in [
            ("", "twin:seed=1,gain=B3"),
            ("gain=b2", "twin:seed=1,gain=B2"),
            ("device=fixed", "twin:seed=1,gain=x20,device=fixed"),
            (
                "device=own.toml,gain=low",
                "twin:seed=1,gain=low,device=own.toml",
            ),
        ] {
            assert_eq!(spec(settings).unwrap().apart_from_participant(), named);
        }
        let own = spec("device=own.toml").unwrap();
        assert_eq!(own.file(), Some(Path::new("own.toml")));
        assert_eq!(spec("device=fixed").unwrap().file(), None);
    }
}
