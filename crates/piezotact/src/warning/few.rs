//! The warning that a result is of few strokes, people, averages or other things.

use serde::{Deserialize, Serialize};

use super::words::first_of;
use crate::number::{counted, rounded};

/// Warnings about how few things a result is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum FewWarning {
    /// A result is of fewer things than are recommended or needed.
    #[error(
        "{}only {}, {recommended} or more are {}: {}; {}",
        what.of(),
        what.counted(*found),
        what.wanted(),
        what.consequence(*found),
        what.advice()
    )]
    Few {
        found: usize,
        recommended: usize,
        #[serde(flatten)]
        what: Few,
    },
}

/// Of what there are few.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Few {
    /// Strokes of a group.
    Strokes { group: String },
    /// Groups that a value is of.
    Groups { result: String },
    /// Strokes of each of these samples.
    StrokesOfSample { samples: Vec<String> },
    /// Recordings of each of these samples.
    RecordingsOfSample { samples: Vec<String> },
    /// Strokes or recordings of a sample in a permutation test.
    Units { unit: String, pairs: usize },
    /// Strokes of a texture.
    StrokesOfTexture { texture: String },
    /// Hits of an impact test.
    Hits,
    /// Averages of a transfer function.
    Averages,
    /// Participants of a panel.
    Participants,
    /// Participants who answered.
    Answering,
    /// Segments of a spectrum.
    Segments,
    /// Restarts of a sound device.
    Restarts,
    /// Participants of a cluster test.
    ParticipantsOfClusters {
        flips: usize,
        smallest_p: f64,
        tests: usize,
    },
    /// Sections of a roughness profile, each a cut-off long.
    Sections { cutoff_m: f64 },
}

impl Few {
    /// Whose they are.
    fn of(&self) -> String {
        match self {
            Self::Strokes { group: name } | Self::Groups { result: name } => format!("{name}: "),
            Self::StrokesOfSample { samples } | Self::RecordingsOfSample { samples } => {
                format!("{}: ", first_of(samples, ", "))
            }
            _ => String::new(),
        }
    }

    /// How many there are.
    fn counted(&self, found: usize) -> String {
        let what = match self {
            Self::Units { unit, .. } => return format!("{found} {unit} of a sample"),
            Self::Strokes { .. } | Self::StrokesOfSample { .. } | Self::StrokesOfTexture { .. } => {
                "stroke"
            }
            Self::Groups { .. } => "group",
            Self::RecordingsOfSample { .. } => "recording",
            Self::Hits => "hit",
            Self::Averages => "average",
            Self::Participants | Self::Answering | Self::ParticipantsOfClusters { .. } => {
                "participant"
            }
            Self::Segments => "segment",
            Self::Restarts => "restart",
            Self::Sections { .. } => "section",
        };
        counted(found, what)
    }

    /// Whether more would be better, or a result needs them.
    fn wanted(&self) -> &'static str {
        match self {
            Self::Sections { .. } => "required by the standard",
            Self::Groups { .. }
            | Self::StrokesOfSample { .. }
            | Self::RecordingsOfSample { .. }
            | Self::Units { .. }
            | Self::Answering
            | Self::Restarts
            | Self::ParticipantsOfClusters { .. } => "needed",
            _ => "recommended",
        }
    }

    /// What follows from that.
    fn consequence(&self, found: usize) -> String {
        let said = match self {
            Self::Strokes { .. } => "averages are uncertain",
            Self::Groups { .. } => "it has no confidence interval",
            Self::StrokesOfSample { .. } => {
                "the variation between strokes is not known, and nothing is decided"
            }
            Self::RecordingsOfSample { .. } => {
                "all strokes are from one recording, so that the distance within a sample does not include the variation between placements, \
                 sessions or days"
            }
            Self::Units { pairs, .. } => {
                let pairs = counted(*pairs, "pair");
                return format!("no difference over {pairs} can be significant at 5 %");
            }
            Self::StrokesOfTexture { .. } => "whether it is typical is not known",
            Self::Hits if found == 1 => "neither noise nor a second force would show",
            Self::Hits => "coherence and limits are uncertain",
            Self::Averages => "the estimate is uncertain",
            Self::Participants => "the result of another panel cannot be predicted",
            Self::Answering => {
                "how much people differ is not known, so that cells have no interval and no pair is decided"
            }
            Self::Segments => {
                let deviation_db = 4.34 * (1.0 / found.max(1) as f64).sqrt();
                return format!(
                    "the standard deviation of the spectrum is about {deviation_db:.1} dB"
                );
            }
            Self::Restarts => "the latency has no percentiles",
            Self::ParticipantsOfClusters {
                flips,
                smallest_p,
                tests,
            } => {
                let least =
                    format!("they have {flips} sign flips, and the smallest p is {smallest_p:.3}");
                return match tests {
                    1 => format!("{least}, so that no cluster can reach p < 0.05"),
                    tests => format!(
                        "{least} ({:.3} after Holm over {tests} pairs of tasks), so that no cluster may reach p < 0.05",
                        (smallest_p * *tests as f64).min(1.0)
                    ),
                };
            }
            Self::Sections { cutoff_m } => {
                let cutoff_mm = rounded(cutoff_m * 1e3);
                return format!("one section is as long as the cut-off, {cutoff_mm} mm");
            }
        };
        said.into()
    }

    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Strokes { .. }
            | Self::Groups { .. }
            | Self::StrokesOfSample { .. }
            | Self::Units { .. }
            | Self::StrokesOfTexture { .. } => "record more",
            Self::RecordingsOfSample { .. } => "record each sample several times",
            Self::Hits => "hit more often",
            Self::Averages => "measure longer, or use shorter segments",
            Self::Participants => "measure more participants",
            Self::Answering => "ask more participants",
            Self::Segments => "record longer",
            Self::Restarts => "measure more restarts",
            Self::ParticipantsOfClusters { .. } => "measure more participants",
            Self::Sections { .. } => "measure a longer line, or state the cut-off",
        }
    }
}
