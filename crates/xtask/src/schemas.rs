//! The JSON Schemas of all documents: written to `docs/schemas/`, and held there by a test.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use piezotact::align::{AlignedRecording, BurstDocument};
use piezotact::document::{Content, Kept};
use piezotact::invocation::{Invocation, Rerun};
use piezotact::manipulate::ManipulateDocument;
use piezotact::noise::Noise;
use piezotact::panel::{AnalysedPanel, PanelAverage};
use piezotact::prepare::PreparedDrives;
use piezotact::quantity::{Acceleration, Drive};
use piezotact::run::{Played, Recorded, TwinRecorded};
use piezotact::score::ScoredRecordings;
use piezotact::sound::{LatencySummary, SoundCalibration, SoundDevices};
use piezotact::spectrum::SpectrumDocument;
use piezotact::study::{AnalysisDocument, ComparisonDocument, CutsDocument};
use piezotact::transfer::BetweenChannels;
use piezotact::verify::{DemoDocument, VerifyDocument};
use piezotact_bench::document::{RenderBatchDocument, RenderDocument};
use piezotact_bench::procedure::RepeatedCharacterisation;
use piezotact_dataset::document::{InfoDocument, PanelAddDocument, PanelRun, Written};
use piezotact_people::association::Association;
use piezotact_people::campaign::dictionary::DataDictionary;
use piezotact_people::campaign::overview::CampaignDesign;
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::campaign::readiness::PreparedStimuli;
use piezotact_people::eeg::counts::EegEpochs;
use piezotact_people::eeg::group::EegStats;
use piezotact_people::eeg::info::EegInfo;
use piezotact_people::eeg::person::EegErd;
use piezotact_study::bids::{Checked, Exported, Imported};
use piezotact_surface::{EvaluatedSurface, RoughnessSet};
use piezotact_twin::document::SimulatedSurface;
use piezotact_validation::count::CountedPanels;
use piezotact_validation::document::Replay;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

/// Where the schemas stand, from the root of the repository.
const FOLDER: &str = "docs/schemas";

/// Writes `docs/schemas/NAME.json` for every document, and removes those of documents that are no more.
pub(crate) fn run() -> Result<()> {
    let folder = folder();
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let schemas = all()?;
    for name in stored(&folder)?.keys() {
        if !schemas.contains_key(name) {
            std::fs::remove_file(folder.join(name))?;
        }
    }
    for (name, text) in &schemas {
        std::fs::write(folder.join(name), text)?;
    }
    Ok(())
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(FOLDER)
}

/// The schemas in `folder`, by the name of their file.
fn stored(folder: &Path) -> Result<BTreeMap<String, String>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        found.insert(name.into_owned(), std::fs::read_to_string(&path)?);
    }
    Ok(found)
}

/// The schemas of all documents, by the name of their file.
fn all() -> Result<BTreeMap<String, String>> {
    let mut all = BTreeMap::new();
    for (name, text) in [
        schema::<AlignedRecording>()?,
        schema::<AnalysisDocument<'_>>()?,
        schema::<Association>()?,
        schema::<BurstDocument>()?,
        schema::<CampaignDesign>()?,
        schema::<Kept<'_, RepeatedCharacterisation>>()?,
        schema::<ComparisonDocument<'_>>()?,
        schema::<CutsDocument<'_>>()?,
        schema::<Checked>()?,
        schema::<DataDictionary>()?,
        schema::<Exported>()?,
        schema::<Imported>()?,
        schema::<DemoDocument<'_>>()?,
        schema::<EegEpochs>()?,
        schema::<EegErd>()?,
        schema::<EegInfo>()?,
        schema::<EegStats>()?,
        schema::<Kept<'_, BetweenChannels>>()?,
        schema::<Kept<'_, Written>>()?,
        schema::<InfoDocument<'_>>()?,
        schema::<ManipulateDocument<'_>>()?,
        schema::<Noise>()?,
        schema::<LatencySummary>()?,
        schema::<SoundCalibration>()?,
        schema::<SoundDevices>()?,
        schema::<PanelAddDocument<'_>>()?,
        schema::<AnalysedPanel<'_>>()?,
        schema::<Kept<'_, PanelAverage<Drive, Acceleration>>>()?,
        schema::<Kept<'_, PanelRun<'_>>>()?,
        schema::<Kept<'_, Played>>()?,
        schema::<PreparedDrives>()?,
        schema::<PreparedStimuli>()?,
        schema::<Kept<'_, Recorded>>()?,
        also_of_files(schema::<Protocol>()?)?,
        schema::<RenderBatchDocument<RenderDocument<'_>>>()?,
        schema::<RenderDocument<'_>>()?,
        schema::<Replay>()?,
        schema::<Rerun>()?,
        schema::<CountedPanels>()?,
        schema::<EvaluatedSurface>()?,
        schema::<RoughnessSet>()?,
        schema::<ScoredRecordings>()?,
        schema::<SpectrumDocument<'_>>()?,
        schema::<Kept<'_, TwinRecorded>>()?,
        schema::<Kept<'_, SimulatedSurface>>()?,
        schema::<VerifyDocument<'_>>()?,
    ] {
        if all.insert(format!("{name}.json"), text).is_some() {
            bail!("two documents are called `{name}`: give each its own name");
        }
    }
    Ok(all)
}

/// The name of a document and its schema, with the fields `schema` and `version` that every document has.
fn schema<T: Content + JsonSchema>() -> Result<(&'static str, String)> {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let mut generator = settings.into_generator();
    let invocation = generator.subschema_for::<Invocation>();
    let mut schema = generator.into_root_schema_for::<T>().to_value();
    let fields = schema
        .as_object_mut()
        .context("a schema is expected to be an object")?;
    fields.insert("title".into(), T::SCHEMA.into());
    fields.insert("type".into(), "object".into());
    let properties = fields.entry("properties").or_insert_with(|| json!({}));
    properties["schema"] = json!({ "const": T::SCHEMA });
    properties["version"] = json!({ "const": T::VERSION });
    properties["invocation"] = invocation.to_value();
    let required = fields.entry("required").or_insert_with(|| json!([]));
    if let Value::Array(required) = required {
        required.extend([json!("schema"), json!("version")]);
    }
    Ok((T::SCHEMA, serde_json::to_string_pretty(&schema)? + "\n"))
}

/// A schema that also holds for files without the fields `schema` and `version`: protocols in TOML name their own `form`.
fn also_of_files((name, text): (&'static str, String)) -> Result<(&'static str, String)> {
    let mut schema: Value = serde_json::from_str(&text)?;
    let required = schema["required"].as_array_mut();
    let required = required.context("a schema is expected to require fields")?;
    required.retain(|field| field != "schema" && field != "version");
    Ok((name, serde_json::to_string_pretty(&schema)? + "\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stored_schemas_are_those_of_the_documents() {
        let (stored, all) = (stored(&folder()).unwrap(), all().unwrap());
        let names = |of: &BTreeMap<String, String>| of.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&stored), names(&all));
        for (name, text) in &all {
            assert!(
                stored[name] == *text,
                "docs/schemas/{name} is not that of the type: run `cargo run -p xtask --features schemas -- schemas`"
            );
        }
    }

    #[test]
    fn a_schema_asks_for_its_name_its_version_and_the_fields_of_its_value() {
        let (name, text) = schema::<Kept<'_, Played>>().unwrap();
        let schema: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(name, "play");
        assert_eq!(schema["properties"]["schema"]["const"], "play");
        let mut required = schema["required"].as_array().unwrap().clone();
        // A document that is one value has the fields of that value's definition.
        let value = schema["$ref"].as_str().unwrap().trim_start_matches('#');
        let fields = schema.pointer(value).unwrap()["required"].as_array();
        required.extend(fields.unwrap().iter().cloned());
        for field in ["schema", "version", "duration_s", "warnings"] {
            assert!(required.contains(&json!(field)), "{field}");
        }
        let warning = &schema["$defs"]["Merged"]["required"];
        assert!(
            warning.as_array().unwrap().contains(&json!("text")),
            "{warning}"
        );
    }
}
