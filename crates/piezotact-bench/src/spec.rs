//! How a bench is named on the command line: `twin`, `twin:participant=3,seed=7,gain=B3`, `measured:hand.json`,
//! `measured:hand.json,noise=0.003,seed=7`, `measured:hand.json,panel=people,placement=2`.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use piezotact::device::AmplifierGain;
use piezotact::panel::PlacementSpread;
use piezotact::quantity::{Acceleration, Drive};
use piezotact::recording::Condition;
use piezotact::transfer::TransferFunction;

use crate::measured::{MeasuredBench, SensorNoise};
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
    /// A transfer function that was measured before, and is played through.
    Measured(MeasuredSpec),
}

/// A measured transfer function by its file, with the settings of the bench made from it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredSpec {
    /// The file.
    pub file: PathBuf,
    /// The noise that is added.
    pub noise: SensorNoise,
    /// Another placement of the finger than the one that was measured; absent for that one.
    pub placement: Option<DrawnPlacement>,
}

/// Another placement of a finger, drawn from how placements lie apart in a panel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DrawnPlacement {
    /// The panel's folder.
    pub panel: PathBuf,
    /// The placement's number: each is another one.
    pub number: u64,
}

/// What `measured` must look like on the command line.
const MEASURED_FORM: &str = "measured:FILE or measured:FILE,noise=M_S2,seed=N,panel=FOLDER,placement=N, the settings after the whole name of the file";

impl BenchSpec {
    /// Opens the bench; a twin has the numbers `parameters`, `read` reads the transfer function of a measured one, and
    /// `spread` finds how placements lie apart in a panel's folder at the condition of that transfer function.
    ///
    /// # Errors
    /// Those of `read`, of `spread` and of [`MeasuredBench::new`].
    pub fn open<E: From<BenchError>>(
        &self,
        parameters: &TwinParameters,
        read: impl FnOnce(&Path) -> Result<TransferFunction<Drive, Acceleration>, E>,
        spread: impl FnOnce(&Path, &Condition) -> Result<PlacementSpread, E>,
    ) -> Result<Bench, E> {
        match self {
            Self::Twin {
                participant,
                seed,
                gain,
            } => {
                let participant = Participant::of(*participant, *seed, parameters);
                Ok(TwinBench::new(parameters, participant, *gain).into_bench())
            }
            Self::Measured(MeasuredSpec {
                file,
                noise,
                placement,
            }) => {
                let called = file.file_name().unwrap_or(file.as_os_str());
                let (function, called) = (read(file)?, called.to_string_lossy());
                let bench = match placement {
                    None => MeasuredBench::new(function, &called, *noise)?,
                    Some(DrawnPlacement { panel, number }) => {
                        let spread = spread(panel, &function.condition)?;
                        MeasuredBench::at_another_placement(
                            function, &called, *noise, &spread, *number,
                        )?
                    }
                };
                Ok(bench.into_bench())
            }
        }
    }

    /// The file that is read when it is opened, where there is one.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Twin { .. } => None,
            Self::Measured(measured) => Some(&measured.file),
        }
    }

    /// The same bench with somebody else at it.
    ///
    /// # Errors
    /// [`BenchError::Impossible`] where one finger was measured, and nobody else can sit down.
    pub fn with_participant(self, number: u64) -> Result<Self, BenchError> {
        match self {
            Self::Twin { seed, gain, .. } => Ok(Self::Twin {
                participant: number,
                seed,
                gain,
            }),
            Self::Measured(MeasuredSpec { file, .. }) => Err(BenchError::Impossible {
                expected: "a bench at which people can take turns".into(),
                found: format!("{}, which is one finger at one placement", file.display()),
                todo: "file each measured transfer function with `piezotact panel add`, and rehearse on one at a time".into(),
            }),
        }
    }

    /// The bench by name and settings, whoever sits at it.
    #[must_use]
    pub fn apart_from_participant(&self) -> String {
        match self {
            Self::Twin { seed, gain, .. } => format!("twin:seed={seed},gain={gain}"),
            Self::Measured(MeasuredSpec {
                file,
                noise,
                placement,
            }) => {
                let placement = placement.as_ref().map_or(String::new(), |drawn| {
                    format!(
                        ",panel={},placement={}",
                        drawn.panel.display(),
                        drawn.number
                    )
                });
                format!(
                    "measured:{},noise={},seed={}{placement}",
                    file.display(),
                    noise.rms_m_s2,
                    noise.seed
                )
            }
        }
    }
}

fn wrong(expected: &str, found: &str) -> BenchError {
    BenchError::Impossible {
        expected: expected.into(),
        found: format!("`{found}`"),
        todo:
            "write for example --bench twin:participant=1,seed=7 or --bench measured:hand.json,seed=7"
                .into(),
    }
}

impl FromStr for BenchSpec {
    type Err = BenchError;

    fn from_str(text: &str) -> Result<Self, BenchError> {
        let (name, settings) = text.split_once(':').unwrap_or((text, ""));
        match name {
            "twin" => twin(settings),
            "measured" => measured(settings),
            _ => Err(wrong(
                "a bench that this program knows (twin, measured)",
                name,
            )),
        }
    }
}

fn twin(settings: &str) -> Result<BenchSpec, BenchError> {
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
    Ok(BenchSpec::Twin {
        participant,
        seed,
        gain,
    })
}

fn whole(setting: &str, value: &str) -> Result<u64, BenchError> {
    value
        .parse()
        .map_err(|_not_a_number| wrong("a whole number from 0", setting))
}

/// A file and what comes after it. A file's name may hold colons, and commas too: a part behind a comma is a setting
/// when it has an equals sign.
fn measured(text: &str) -> Result<BenchSpec, BenchError> {
    let (mut file, mut noise_m_s2, mut seed) = (text, None, None);
    let (mut panel, mut number) = (None, None);
    while let Some((before, setting)) = file.rsplit_once(',') {
        let Some((key, value)) = setting.split_once('=') else {
            break;
        };
        let known = match key {
            "noise" => noise_m_s2.replace(level(setting, value)?).is_none(),
            "seed" => seed.replace(whole(setting, value)?).is_none(),
            "panel" if !value.is_empty() => panel.replace(PathBuf::from(value)).is_none(),
            "placement" => number.replace(whole(setting, value)?).is_none(),
            _ => {
                return Err(wrong(
                    &format!(
                        "{MEASURED_FORM} (a file with `,` and `=` in its name needs another name)"
                    ),
                    setting,
                ));
            }
        };
        if !known {
            return Err(wrong("each setting once", text));
        }
        file = before;
    }
    if file.is_empty() {
        return Err(wrong(MEASURED_FORM, &format!("measured:{text}")));
    }
    let placement = match (panel, number) {
        (Some(panel), number) => Some(DrawnPlacement {
            panel,
            number: number.unwrap_or(1),
        }),
        (None, None) => None,
        (None, Some(_)) => {
            return Err(wrong(
                "panel=FOLDER with placement=N: how far placements lie apart is known of people who were placed more than once, a single transfer function does not hold it",
                text,
            ));
        }
    };
    Ok(BenchSpec::Measured(MeasuredSpec {
        placement,
        file: file.into(),
        noise: SensorNoise {
            rms_m_s2: noise_m_s2.unwrap_or(SensorNoise::USUAL_RMS_M_S2),
            seed: seed.unwrap_or(1),
        },
    }))
}

fn level(setting: &str, value: &str) -> Result<f64, BenchError> {
    let largest = SensorNoise::LARGEST_RMS_M_S2;
    let level = value.parse().ok();
    level
        .filter(|level| (0.0..=largest).contains(level))
        .ok_or_else(|| {
            let expected = format!("a noise from 0 to {largest} m/s² rms, such as noise=0.003");
            wrong(&expected, setting)
        })
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

    #[test]
    fn a_measured_bench_is_a_file_and_what_comes_after_it() {
        let usual = SensorNoise::USUAL_RMS_M_S2;
        for (text, file, rms_m_s2, seed) in [
            ("hand.json", "hand.json", usual, 1),
            ("hand.json,noise=0.003,seed=7", "hand.json", 0.003, 7),
            ("hand.json,seed=7,noise=0", "hand.json", 0.0, 7),
            ("a/P01, 0.2 N.json,seed=2", "a/P01, 0.2 N.json", usual, 2),
            ("C:\\hands\\P01.json", "C:\\hands\\P01.json", usual, 1),
            ("a=b.json", "a=b.json", usual, 1),
        ] {
            let spec: BenchSpec = format!("measured:{text}").parse().unwrap();
            let noise = SensorNoise { rms_m_s2, seed };
            let file = PathBuf::from(file);
            let placement = None;
            assert_eq!(
                spec,
                BenchSpec::Measured(MeasuredSpec {
                    file,
                    noise,
                    placement
                })
            );
            assert!(spec.with_participant(2).is_err());
        }
        let drawn: BenchSpec = "measured:hand.json,panel=a/people,placement=3"
            .parse()
            .unwrap();
        assert_eq!(
            drawn.apart_from_participant(),
            "measured:hand.json,noise=0.0022,seed=1,panel=a/people,placement=3"
        );
        for (bad, part) in [
            ("measured", "measured:FILE"),
            ("measured:", "measured:FILE"),
            ("measured:,seed=7", "measured:FILE"),
            ("measured:hand.json,noise=-0.1", "from 0 to 1000 m/s²"),
            ("measured:hand.json,noise=NaN", "from 0 to 1000 m/s²"),
            ("measured:hand.json,noise=inf", "from 0 to 1000 m/s²"),
            ("measured:hand.json,noise=", "from 0 to 1000 m/s²"),
            ("measured:hand.json,seed=1.5", "a whole number"),
            ("measured:hand.json,seed=1,seed=2", "each setting once"),
            ("measured:hand.json,gain=B3", "noise=M_S2"),
            ("measured:hand.json,panel=", "panel=FOLDER"),
            ("measured:hand.json,placement=2", "placed more than once"),
            ("measured:a,b=c.json", "another name"),
        ] {
            let said = bad.parse::<BenchSpec>().unwrap_err().to_string();
            assert!(said.contains(part), "{bad}: {said}");
        }
    }
}
