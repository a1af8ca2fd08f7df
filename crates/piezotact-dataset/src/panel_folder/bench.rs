//! The files from which the bench of a panel is built: two benches are the same if these files have the same content.

use std::path::Path;

use piezotact::checksum::Checksum;
use serde::{Deserialize, Serialize};

use crate::error::ReadError;

/// A file from which a bench is built (a device description, a script or a transfer function), with its checksum.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BenchFile {
    /// The file, as it was named.
    pub file: String,
    /// The checksum of its bytes.
    pub checksum: Checksum,
}

impl BenchFile {
    /// The file at `path`, as it is now.
    ///
    /// # Errors
    /// [`ReadError::Io`] when it cannot be read.
    pub fn of(path: &Path) -> Result<Self, ReadError> {
        let bytes = crate::input::read_input(path)?;
        Ok(Self {
            file: path.display().to_string(),
            checksum: Checksum::of_bytes(&bytes),
        })
    }

    /// The first file of `now` whose content differs from that in `before`.
    pub(super) fn changed<'a>(before: &[Self], now: &'a [Self]) -> Option<&'a Self> {
        let other = |now: &&Self| {
            before
                .iter()
                .any(|before| before.file == now.file && before.checksum != now.checksum)
        };
        now.iter().find(other)
    }
}

/// What differs between two campaigns, as `bench: setting, setting`: that of the first, and that of the second.
pub(super) fn differing(begun: &str, now: &str) -> [String; 2] {
    let parts = |campaign: &str| -> Vec<String> {
        let (bench, settings) = campaign.split_once(": ").unwrap_or((campaign, ""));
        let settings = settings.split(", ").filter(|setting| !setting.is_empty());
        bench
            .split(',')
            .chain(settings)
            .map(str::to_owned)
            .collect()
    };
    let [begun, now] = [begun, now].map(parts);
    [(&begun, &now), (&now, &begun)].map(|(these, others)| {
        let differ = these.iter().filter(|part| !others.contains(part));
        let differ: Vec<&str> = differ.map(String::as_str).collect();
        match differ.is_empty() {
            true => "nothing more".into(),
            false => format!("`{}`", differ.join(", ")),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::differing;

    #[test]
    fn only_what_differs_between_campaigns_is_said() {
        let begun = "twin:seed=7,gain=B3: random, 20 s over 2–1200 Hz, peak 0.8, no gate";
        for (now, said) in [
            (begun.replace("0.8", "0.7"), ["`peak 0.8`", "`peak 0.7`"]),
            (
                begun.replace("seed=7", "seed=9").replace("20 s", "4 s"),
                [
                    "`twin:seed=7, 20 s over 2–1200 Hz`",
                    "`twin:seed=9, 4 s over 2–1200 Hz`",
                ],
            ),
            (
                begun.replace("B3", "B3,device=own.toml"),
                ["nothing more", "`device=own.toml`"],
            ),
        ] {
            assert_eq!(differing(begun, &now), said);
        }
    }
}
