//! Which samples can be told apart by their vibration, for text, JSON and report alike.

use piezotact::Doubt;
use piezotact::compare::{
    AcrossSamples, DiscriminationConfig, Groups, Texture, Withheld, discriminate,
};
use piezotact::discrimination::Model;
use piezotact::quantity::{Band, Hertz};
use serde_json::{Value, json};

use super::Comparison;
use crate::cli::Feeling;
use crate::failure::Outcome;

/// What a finger feels, over the band that `score` compares unless told otherwise.
pub(crate) fn model(args: &Feeling) -> Outcome<Model> {
    let band = Band::new(Hertz(20.0), Hertz(1000.0))?;
    crate::commands::score::model(args, band)
}

/// "1 pair", "all 6 pairs".
pub(crate) fn pairs(count: usize) -> String {
    match count {
        1 => "1 pair".into(),
        count => format!("all {count} pairs"),
    }
}

/// What was found, with the settings' names, or why it is withheld.
pub(crate) struct Discrimination {
    pub(crate) settings: Vec<String>,
    pub(crate) found: Result<AcrossSamples, Withheld>,
}

impl Discrimination {
    pub(crate) fn of(compared: &[Comparison<'_>], model: Model) -> Self {
        let textures: Vec<Vec<Texture>> = compared
            .iter()
            .map(|comparison| {
                let cells = comparison.cells.iter();
                cells
                    .filter_map(|cell| {
                        let analyses: Vec<_> = cell
                            .takes
                            .iter()
                            .filter_map(|take| take.analysis.as_ref())
                            .collect();
                        Texture::of(&cell.summary.name, &analyses)
                    })
                    .collect()
            })
            .collect();
        Self {
            settings: compared.iter().map(|c| c.setting.clone()).collect(),
            found: discriminate(&textures, &DiscriminationConfig::usual(model)),
        }
    }

    pub(crate) fn groups(&self, setting: usize) -> Option<&Groups> {
        self.found.as_ref().ok()?.settings.get(setting)
    }

    pub(crate) fn doubts(&self) -> Vec<Doubt> {
        let doubts = self.found.iter().flat_map(|found| &found.doubts);
        doubts.cloned().collect()
    }

    /// How it was found, or why it is withheld, in a line.
    pub(crate) fn line(&self) -> String {
        match &self.found {
            Ok(found) => format!(
                "what decides: told apart beyond what {} of one sample differ by (permutation test, {:.0} % over {}) and beyond {:.1} dB or {:.2} JND, below the JND within {:.2} dB; distances in JND of {:.2} dB over {}",
                found.units.word(),
                found.config.alpha * 100.0,
                pairs(found.family),
                found
                    .config
                    .model
                    .level_jnd_high
                    .0
                    .max(found.config.model.level_jnd.0),
                (found.config.model.level_jnd_high.0 / found.config.model.level_jnd.0).max(1.0),
                found.config.model.level_jnd.0,
                found.config.model.level_jnd.0,
                found.config.model.band,
            ),
            Err(withheld) => withheld.to_string(),
        }
    }

    pub(crate) fn json(&self) -> Outcome<Value> {
        let found = match &self.found {
            Err(withheld) => {
                let mut value = serde_json::to_value(withheld)?;
                if let Some(fields) = value.as_object_mut() {
                    fields.insert("sentence".into(), json!(withheld.to_string()));
                }
                return Ok(value);
            }
            Ok(found) => found,
        };
        let mut value = serde_json::to_value(found)?;
        if let Some(fields) = value.as_object_mut() {
            // They stand among all doubts, with their sentences.
            fields.remove("doubts");
            fields.insert("sentence".into(), json!(self.line()));
            fields.insert("jnd_source".into(), json!(found.config.model.jnd_source()));
            if let Some(Value::Array(settings)) = fields.get_mut("settings") {
                for (setting, name) in settings.iter_mut().zip(&self.settings) {
                    if let Some(fields) = setting.as_object_mut() {
                        fields.insert("setting".into(), json!(name));
                    }
                }
            }
        }
        Ok(value)
    }
}
