//! Sidecars: what JSON files say of the files beside them.

use std::collections::BTreeMap;

use piezotact::quantity::Unit;
use piezotact::recording::{Condition, Provenance};
use piezotact::warning::Warning;
use piezotact_people::campaign::dictionary::ColumnMeaning;
use serde::{Deserialize, Serialize};

use super::name::STIM;
use super::privacy::personal;

/// What a column means, with the tags of its levels.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct ColumnSidecar {
    /// Description, unit and levels.
    #[serde(flatten)]
    pub(super) meaning: ColumnMeaning,
    /// Its HED tags; absent where it has none.
    #[serde(rename = "HED", skip_serializing_if = "Tags::are_none")]
    pub(super) hed: Tags,
}

/// HED tags of a column.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(super) enum Tags {
    /// None.
    #[default]
    None,
    /// For each level.
    Levels(BTreeMap<String, String>),
    /// For every value, which takes the place of `#`.
    Every(&'static str),
}

impl Tags {
    fn are_none(&self) -> bool {
        match self {
            Self::None => true,
            Self::Levels(levels) => levels.is_empty(),
            Self::Every(_) => false,
        }
    }
}

impl From<ColumnMeaning> for ColumnSidecar {
    fn from(meaning: ColumnMeaning) -> Self {
        Self {
            meaning,
            hed: Tags::None,
        }
    }
}

/// The columns of a table, by their names.
pub(super) type Columns = BTreeMap<String, ColumnSidecar>;

/// The file `dataset_description.json`.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct Description<'a> {
    pub(super) name: &'a str,
    #[serde(rename = "BIDSVersion")]
    pub(super) bids_version: &'static str,
    #[serde(rename = "HEDVersion", skip_serializing_if = "Option::is_none")]
    pub(super) hed_version: Option<&'static str>,
    pub(super) dataset_type: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) license: Option<&'a str>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    pub(super) authors: &'a [String],
    pub(super) generated_by: [GeneratedBy<'a>; 1],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) dataset_links: Option<DatasetLinks>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) source_datasets: Option<[SourceDataset; 1]>,
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct GeneratedBy<'a> {
    pub(super) name: &'static str,
    pub(super) version: &'a str,
    pub(super) description: &'static str,
}

/// Where the data sets are that URIs name.
#[derive(Clone, Debug, Serialize)]
pub(super) struct DatasetLinks {
    pub(super) study: &'static str,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct SourceDataset {
    #[serde(rename = "URL")]
    pub(super) url: &'static str,
}

/// What a file in the folder `beh` says of itself beside its columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub(super) struct SignalSidecar {
    pub(super) sampling_frequency: f64,
    pub(super) start_time: f64,
    pub(super) columns: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) physio_type: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) task_name: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) study: Option<String>,
    /// The places of the columns among the channels of the recording, from 0, which its files share.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) channels: Vec<usize>,
    #[serde(default)]
    pub(super) condition: Condition,
    #[serde(default)]
    pub(super) provenance: Provenance,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[serde(alias = "Doubts")]
    pub(super) warnings: Vec<Warning>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) labels: BTreeMap<String, String>,
    /// The file that it was made from, from the root.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) source_file: Option<String>,
    /// The meaning of each column, and whatever else stands there.
    #[serde(flatten)]
    pub(super) others: BTreeMap<String, serde_json::Value>,
}

/// Longer words of units than three letters.
const WORDS_OF_UNITS: [&str; 12] = [
    "count", "counts", "volt", "volts", "newton", "metre", "meter", "kelvin", "degree", "percent",
    "pixel", "pixels",
];

/// Whether a text may be a unit: its words are symbols of up to three letters, or words for units.
fn is_unit(text: &str) -> bool {
    let words = text.split(|sign: char| !sign.is_alphabetic());
    let mut words = words.filter(|word| word.chars().count() > 3);
    words.all(|word| WORDS_OF_UNITS.contains(&word.to_lowercase().as_str()))
}

/// The symbol of a unit as BIDS has units; `arbitrary` for none, and for a text that is no unit, or holds a date, an address or a number of
/// a telephone.
#[must_use]
pub fn unit_text(unit: &Unit) -> String {
    match unit {
        Unit::MetrePerSecondSquared => "m/s^2".into(),
        // A share of full scale is a number without a unit.
        Unit::FullScale => "1".into(),
        Unit::Other(text) if text.is_empty() || personal(text).is_some() || !is_unit(text) => {
            "arbitrary".into()
        }
        other => other.symbol().to_owned(),
    }
}

/// What a channel of a file with this suffix is, in words, and its unit.
pub(super) fn channel_meaning(name: &str, unit: &Unit, suffix: &str) -> ColumnMeaning {
    let what = match unit {
        Unit::FullScale if suffix != STIM => {
            "Signal of a file that states no scale, as a share of full scale"
        }
        Unit::MetrePerSecondSquared => "Acceleration",
        Unit::Newton => "Force",
        Unit::FullScale => "Digital drive that was sent to the amplifier, as a share of full scale",
        Unit::Metre => "Position",
        Unit::MetrePerSecond => "Speed",
        Unit::Volt => "Voltage",
        _ => "Signal",
    };
    ColumnMeaning {
        description: format!("{what}, channel `{name}`."),
        units: Some(unit_text(unit)),
        ..ColumnMeaning::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn unit_that_may_tell_who_somebody_is_is_not_carried() {
        let text = |unit: &str| unit_text(&Unit::parse(unit).0);
        for unit in ["counts", "V/m/s", "N·mm", "°C", "Pa"] {
            assert_eq!(text(unit), unit);
        }
        for unit in [
            "Dupont 12.03.1988",
            "jane@lab.org",
            "",
            "m/s2 Dupont",
            "uS Dupont",
        ] {
            assert_eq!(text(unit), "arbitrary", "{unit}");
        }
    }

    /// A data set of an earlier form has its warnings under another key: refused, not read without them.
    #[test]
    fn sidecar_with_warnings_of_an_earlier_form_is_refused() {
        let mut written = serde_json::to_value(SignalSidecar::default()).unwrap();
        assert!(serde_json::from_value::<SignalSidecar>(written.clone()).is_ok());
        let fields = written.as_object_mut().unwrap();
        let earlier: Value = json!([{ "code": "few_averages", "values": { "averages": 6 } }]);
        fields.insert("Doubts".into(), earlier);
        let refused = serde_json::from_value::<SignalSidecar>(written).unwrap_err();
        assert!(
            refused.to_string().contains("make the file again"),
            "{refused}"
        );
    }
}
