//! `measured:hand.json`, `measured:hand.json,noise=0.003,seed=7`, `measured:hand.json,panel=people,placement=2`: a transfer
//! function that was measured before, and is played through.

use std::path::{Path, PathBuf};

use piezotact::panel::{Cell, placement_spread};
use piezotact::quantity::{Acceleration, Drive};
use piezotact_bench::measured::{MeasuredBench, SensorNoise};
use piezotact_bench::{Bench, DeviceError};
use piezotact_dataset::{PanelFolder, panel_of, read_transfer};

use super::{BenchEntry, BenchSpec, NamedBench, whole, wrong};
use crate::failure::Outcome;

/// The line of the table of benches.
pub(super) const ENTRY: BenchEntry = BenchEntry {
    name: "measured",
    example: "measured:hand.json,seed=7",
    help: "measured:FILE,noise=0.003,seed=N (noise in m/s² rms), which simulates the response with the transfer function in \
         FILE; with panel=FOLDER,placement=N, for another placement of that finger, drawn from the variability between \
         placements in the panel",
    help_with_turns: None,
    parse,
};

/// A measured transfer function by its file, with the settings of the bench made from it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeasuredSpec {
    pub(crate) file: PathBuf,
    /// The noise that is added.
    pub(crate) noise: SensorNoise,
    /// Another placement of the finger than the one that was measured; absent for that one.
    pub(crate) placement: Option<DrawnPlacement>,
}

/// Another placement of a finger, drawn from how placements lie apart in a panel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct DrawnPlacement {
    pub(crate) panel: PathBuf,
    /// The placement's number: each is another one.
    pub(crate) number: u64,
}

impl NamedBench for MeasuredSpec {
    fn open(&self) -> Outcome<Bench> {
        let called = self.file.file_name().unwrap_or(self.file.as_os_str());
        let called = called.to_string_lossy();
        let function = read_transfer(&self.file)?.function::<Drive, Acceleration>(&self.file)?;
        let bench = match &self.placement {
            None => MeasuredBench::new(function, &called, self.noise)?,
            Some(DrawnPlacement { panel, number }) => {
                let condition = &function.about.condition;
                let panel = panel_of(&PanelFolder::open(panel)?.read()?)?;
                let cell = condition.load_n.zip(condition.angle_deg);
                let cell = cell.map(|(load_n, angle_deg)| Cell { load_n, angle_deg });
                let spread = placement_spread(&panel, cell)?;
                MeasuredBench::at_another_placement(
                    function, &called, self.noise, &spread, *number,
                )?
            }
        };
        Ok(bench.into_bench())
    }

    fn file(&self) -> Option<&Path> {
        Some(&self.file)
    }

    fn with_participant(&self, _number: u64) -> Result<BenchSpec, DeviceError> {
        Err(DeviceError::Impossible {
            expected: "a bench that can be used with several participants".into(),
            found: format!("{}, which is one finger at one placement", self.file.display()),
            todo: "add each measured transfer function to a panel with `piezotact panel add`, and rehearse on one at a \
                 time".into(),
        })
    }

    fn apart_from_participant(&self) -> String {
        let placement = self.placement.as_ref().map_or(String::new(), |drawn| {
            format!(
                ",panel={},placement={}",
                drawn.panel.display(),
                drawn.number
            )
        });
        format!(
            "measured:{},noise={},seed={}{placement}",
            self.file.display(),
            self.noise.rms_m_s2,
            self.noise.seed
        )
    }
}

/// What `measured` must look like on the command line.
const MEASURED_FORM: &str = "measured:FILE or measured:FILE,noise=M_S2,seed=N,panel=FOLDER,placement=N, with the settings \
     after the file name";

fn parse(text: &str) -> Result<BenchSpec, DeviceError> {
    parsed(text).map(BenchSpec::of)
}

/// A file and what comes after it. A file's name may hold colons, and commas too: a part behind a comma is a setting
/// when it has an equals sign.
fn parsed(text: &str) -> Result<MeasuredSpec, DeviceError> {
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
                "panel=FOLDER with placement=N: the variability between placements is estimated from participants whose finger \
                 was placed more than once, a single transfer function does not contain it",
                text,
            ));
        }
    };
    Ok(MeasuredSpec {
        placement,
        file: file.into(),
        noise: SensorNoise {
            rms_m_s2: noise_m_s2.unwrap_or(SensorNoise::USUAL_RMS_M_S2),
            seed: seed.unwrap_or(1),
        },
    })
}

fn level(setting: &str, value: &str) -> Result<f64, DeviceError> {
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
            let spec = parsed(text).unwrap();
            let noise = SensorNoise { rms_m_s2, seed };
            let file = PathBuf::from(file);
            let placement = None;
            assert_eq!(
                spec,
                MeasuredSpec {
                    file,
                    noise,
                    placement
                }
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
