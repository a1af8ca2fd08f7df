//! `twin:participant=3,seed=7,gain=B3`: the digital twin.

use piezotact::device::AmplifierGain;
use piezotact_bench::{Bench, DeviceError};
use piezotact_twin::{Participant, TwinBench, TwinParameters};

use super::{BenchEntry, BenchSpec, NamedBench, whole, wrong};
use crate::failure::Outcome;

/// The line of the table of benches.
pub(super) const ENTRY: BenchEntry = BenchEntry {
    name: "twin",
    example: "twin:participant=1,seed=7",
    parse,
};

/// The digital twin with one participant at it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TwinSpec {
    /// Whose finger, from 1; 0 is the reference participant.
    pub(crate) participant: u64,
    /// The seed that draws every participant, placement and noise.
    pub(crate) seed: u64,
    /// The gain that is set on the amplifier.
    pub(crate) gain: AmplifierGain,
}

impl NamedBench for TwinSpec {
    fn open(&self) -> Outcome<Bench> {
        let parameters = TwinParameters::built_in();
        let participant = Participant::of(self.participant, self.seed, &parameters);
        Ok(TwinBench::new(&parameters, participant, self.gain).into_bench())
    }

    fn with_participant(&self, number: u64) -> Result<BenchSpec, DeviceError> {
        Ok(BenchSpec::of(Self {
            participant: number,
            ..self.clone()
        }))
    }

    fn apart_from_participant(&self) -> String {
        format!("twin:seed={},gain={}", self.seed, self.gain)
    }
}

fn parse(settings: &str) -> Result<BenchSpec, DeviceError> {
    parsed(settings).map(BenchSpec::of)
}

fn parsed(settings: &str) -> Result<TwinSpec, DeviceError> {
    let (mut participant, mut seed, mut gain) = (1, 1, AmplifierGain::B3);
    for setting in settings.split(',').filter(|setting| !setting.is_empty()) {
        let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
        match key {
            "participant" => participant = whole(setting, value)?,
            "seed" => seed = whole(setting, value)?,
            "gain" => {
                gain = value
                    .parse()
                    .map_err(|_unknown| wrong("a gain B1, B2, B3 or B4", setting))?
            }
            _ => return Err(wrong("participant, seed or gain", setting)),
        }
    }
    Ok(TwinSpec {
        participant,
        seed,
        gain,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_twin_has_settings() {
        assert_eq!(
            parsed("participant=3,seed=9,gain=B2").unwrap(),
            TwinSpec {
                participant: 3,
                seed: 9,
                gain: AmplifierGain::B2
            }
        );
        for bad in ["participant=x", "gain=B9", "colour=red"] {
            assert!(parsed(bad).is_err(), "{bad}");
        }
    }
}
