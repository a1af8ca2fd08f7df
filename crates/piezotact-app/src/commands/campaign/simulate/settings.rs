//! How a study was simulated: kept with it, so that it goes on in the same way, and read beside its answers.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::anyhow;
use piezotact_dataset::reads::sha256_of_file;
use piezotact_people::campaign::protocol::{Protocol, TransferFunctionUse};
use piezotact_people::judge::Judge;
use piezotact_volunteers::LevelRule;
use serde::{Deserialize, Serialize};

use super::super::study::Study;
use super::Arguments;
use crate::failure::{Outcome, usage};

/// The version of the form of these settings.
const FORM: u32 = 1;

/// How a study was simulated.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Settings {
    form: u32,
    judge: Judge,
    level: String,
    iterations: u16,
    /// From the first to the last number of the panel, where the protocol renders with one.
    panel: Option<[u64; 2]>,
    surfaces: BTreeMap<String, String>,
}

impl Settings {
    /// Those of the arguments for a campaign of `protocol`.
    pub(super) fn of(args: &Arguments, protocol: &Protocol) -> Outcome<Self> {
        let surfaces = args.surface.iter().map(|(name, sample)| {
            let sample = match super::is_recording(sample) {
                // A recording is known by what is in it.
                true => format!("{sample} ({})", sha256_of_file(Path::new(sample))?),
                false => sample.clone(),
            };
            Ok((name.clone(), sample))
        });
        let rendering = protocol.rendering.as_ref();
        let has_panel = rendering.is_some_and(|rendering| {
            matches!(
                rendering.transfer_function,
                TransferFunctionUse::Average { .. }
            )
        });
        Ok(Self {
            form: FORM,
            judge: args.judge,
            level: match args.level {
                LevelRule::Common => "common".to_owned(),
                LevelRule::Fit => "fit".to_owned(),
                LevelRule::Stated(level) => format!("{}", level.0),
            },
            iterations: args.iterations,
            panel: has_panel.then(|| [*args.panel.start(), *args.panel.end()]),
            surfaces: surfaces.collect::<Outcome<_>>()?,
        })
    }

    /// The first option in which `other` differs: its name, what it is here, and what there.
    fn difference(&self, other: &Self) -> Option<[String; 3]> {
        let panel = |of: &Self| {
            of.panel
                .map_or_else(|| "none".to_owned(), |[from, to]| format!("{from}..{to}"))
        };
        let all = [
            [
                "--judge".into(),
                self.judge.name().into(),
                other.judge.name().into(),
            ],
            ["--level".into(), self.level.clone(), other.level.clone()],
            [
                "--iterations".into(),
                self.iterations.to_string(),
                other.iterations.to_string(),
            ],
            ["--panel".into(), panel(self), panel(other)],
            ["--surface".into(), surfaces(self), surfaces(other)],
        ];
        all.into_iter().find(|[_, here, there]| here != there)
    }

    /// Keeps these with a new study; refuses to go on with one that was simulated otherwise.
    pub(super) fn keep(&self, study: &Study) -> Outcome {
        let folder = study.store.folder().display();
        match study.store.simulation::<Self>()? {
            Some(kept) if kept.form != FORM => Err(usage(anyhow!(
                "{folder}: expected form {FORM} of simulation.json, found form {}; open it with a newer Piezotact",
                kept.form
            ))),
            Some(kept) => match kept.difference(self) {
                None => Ok(()),
                Some([option, was, is]) => Err(usage(anyhow!(
                    "{folder}: expected {option} {was}, with which this simulation was begun, found {is}; go on with the same, or name another folder"
                ))),
            },
            None if study.sessions()?.is_empty() => Ok(study.store.write_simulation(self)?),
            None => Err(usage(anyhow!(
                "{folder}: expected a study that was simulated, found one with sessions and without simulation.json; name another folder"
            ))),
        }
    }

    /// In words for a report.
    pub(crate) fn words(&self) -> String {
        let level = match self.level.as_str() {
            "common" => "one level for all textures".to_owned(),
            "fit" => "each texture at the level that fits".to_owned(),
            level => format!("{level} dB"),
        };
        let loops = match self.iterations {
            0 => "open loop".to_owned(),
            most => format!("closed loop with at most {most} corrections"),
        };
        let panel = self.panel.map_or_else(String::new, |[from, to]| {
            format!("; average transfer function of virtual people {from} to {to}, none of whom takes part")
        });
        let surfaces = match self.surfaces.is_empty() {
            true => String::new(),
            false => format!(
                "; samples of the twin in place of those of the protocol: {}",
                surfaces(self)
            ),
        };
        format!(
            "{loops}, {level}{panel}{surfaces}; judge: {}",
            self.judge.name()
        )
    }
}

/// The samples of the twin that stand for others, in words.
fn surfaces(of: &Settings) -> String {
    let all = of.surfaces.iter();
    let all: Vec<String> = all
        .map(|(name, sample)| format!("{name}={sample}"))
        .collect();
    match all.is_empty() {
        true => "none".to_owned(),
        false => all.join(" "),
    }
}
