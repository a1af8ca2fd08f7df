//! How a bench is named on the command line: `twin`, `twin:participant=3,seed=7,gain=B3`.

use std::str::FromStr;

use piezotact::device::AmplifierGain;

use crate::traits::{Bench, BenchError};
use crate::twin::{Participant, TwinBench, TwinParameters};

/// A bench by name, with its settings.
#[derive(Clone, Debug, PartialEq)]
pub enum BenchSpec {
    /// The digital twin.
    Twin {
        /// Whose finger, from 1; 0 is the reference participant.
        participant: u64,
        /// The seed that draws every participant, placement and noise.
        seed: u64,
        /// The gain that is set on the amplifier.
        gain: AmplifierGain,
    },
}

impl BenchSpec {
    /// Opens the bench; a twin has the numbers `parameters`.
    #[must_use]
    pub fn open(&self, parameters: &TwinParameters) -> Bench {
        match self {
            Self::Twin {
                participant,
                seed,
                gain,
            } => {
                let participant = Participant::of(*participant, *seed, parameters);
                TwinBench::new(parameters, participant, *gain).into_bench()
            }
        }
    }
}

impl BenchSpec {
    /// The same bench with somebody else at it.
    #[must_use]
    pub fn with_participant(self, number: u64) -> Self {
        match self {
            Self::Twin { seed, gain, .. } => Self::Twin {
                participant: number,
                seed,
                gain,
            },
        }
    }

    /// The bench by name and settings, whoever sits at it.
    #[must_use]
    pub fn apart_from_participant(&self) -> String {
        match self {
            Self::Twin { seed, gain, .. } => format!("twin:seed={seed},gain={gain}"),
        }
    }
}

impl FromStr for BenchSpec {
    type Err = BenchError;

    fn from_str(text: &str) -> Result<Self, BenchError> {
        let wrong = |expected: &str, found: &str| BenchError::Impossible {
            expected: expected.into(),
            found: format!("`{found}`"),
            todo: "write for example --bench twin:participant=1,seed=7".into(),
        };
        let (name, settings) = text.split_once(':').unwrap_or((text, ""));
        if name != "twin" {
            return Err(wrong("a bench that this program knows (twin)", name));
        }
        let (mut participant, mut seed, mut gain) = (1, 1, AmplifierGain::B3);
        for setting in settings.split(',').filter(|setting| !setting.is_empty()) {
            let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
            let number = || {
                value
                    .parse::<u64>()
                    .map_err(|_not_a_number| wrong("a whole number from 0", setting))
            };
            match key {
                "participant" => participant = number()?,
                "seed" => seed = number()?,
                "gain" => {
                    gain = value
                        .parse()
                        .map_err(|_unknown| wrong("a gain B1, B2, B3 or B4", setting))?
                }
                _ => return Err(wrong("participant, seed or gain", setting)),
            }
        }
        Ok(Self::Twin {
            participant,
            seed,
            gain,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn benches_have_names() {
        assert_eq!(
            "twin:participant=3,seed=9,gain=B2"
                .parse::<BenchSpec>()
                .unwrap(),
            BenchSpec::Twin {
                participant: 3,
                seed: 9,
                gain: AmplifierGain::B2
            }
        );
        for bad in [
            "",
            "shaker",
            "twin:participant=x",
            "twin:gain=B9",
            "twin:colour=red",
        ] {
            assert!(bad.parse::<BenchSpec>().is_err(), "{bad}");
        }
    }
}
