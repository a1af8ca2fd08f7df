//! Prepared drives as a value: of each texture the stroke, the drive, what was measured, and whether it is good enough.

use serde::Serialize;

use crate::criterion::Outcome;
use crate::document::{Content, FailedFile};
use crate::lineage::Mode;
use crate::quantity::Band;
use crate::score::not_felt;
use crate::verify::{Verdict, Verification};
use crate::warning::Warnings;

use super::PrepareWarning;

/// The stroke that stands for a texture.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ChosenStroke {
    /// The recording that it is cut from.
    pub file: String,
    /// Its number in that recording, from 1.
    pub number: usize,
    /// Where its steady part begins there, s.
    pub from_s: f64,
    /// Where its steady part ends there, s.
    pub to_s: f64,
    /// Its level, rms about the mean, m/s².
    pub rms_m_s2: f64,
    /// How far it lies from the median of the texture's strokes, dB rms over third octaves; absent if it was not compared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_db: Option<f64>,
}

/// The strokes of one texture, and the one that stands for them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TextureStrokes {
    /// The texture: the sample, or the file of recordings that name none.
    pub texture: String,
    /// Its recordings.
    pub recordings: usize,
    /// The strokes found in them.
    pub strokes: usize,
    /// The parts that were rejected.
    pub rejected: usize,
    /// The median distance of its strokes from their median, dB rms over third octaves.
    pub spread_db: f64,
    /// The stroke that is rendered.
    pub stroke: ChosenStroke,
}

/// What became of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It was played, measured, and met all criteria.
    Passed,
    /// It met all criteria over a part of the target.
    PassedInPart,
    /// It was measured and did not meet a criterion.
    NotPassed,
    /// It was measured, and the measurement does not decide.
    NotDecided,
    /// It was measured through the transfer function that it was rendered with: no evidence.
    Rehearsed,
    /// It was rendered, and not measured.
    NotMeasured,
    /// It could not be rendered.
    NotRendered,
}

impl State {
    /// What became of a drive that was measured as `verification` says.
    #[must_use]
    pub fn of(verification: &Verification) -> Self {
        match verification.verdict {
            _ if verification.is_rehearsal => Self::Rehearsed,
            Verdict::Passed => Self::Passed,
            Verdict::PassedInPart { .. } => Self::PassedInPart,
            Verdict::NotPassed => Self::NotPassed,
            Verdict::NotDecided => Self::NotDecided,
        }
    }

    /// The state in plain words.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::PassedInPart => "passed in part",
            Self::NotPassed => "not passed",
            Self::NotDecided => "not decided",
            Self::Rehearsed => "rehearsed only",
            Self::NotMeasured => "not measured",
            Self::NotRendered => "not rendered",
        }
    }

    /// Whether the drive can be used as it is.
    #[must_use]
    pub fn outcome(self) -> Outcome {
        match self {
            Self::Passed => Outcome::Met,
            Self::NotPassed | Self::NotRendered => Outcome::NotMet,
            Self::PassedInPart | Self::NotDecided | Self::Rehearsed | Self::NotMeasured => {
                Outcome::NotDecided
            }
        }
    }
}

/// One texture with its drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Prepared {
    /// Its strokes.
    #[serde(flatten)]
    pub strokes: TextureStrokes,
    /// The file of the stroke that is rendered.
    pub target: String,
    /// The file of the drive; absent if it could not be rendered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive: Option<String>,
    /// The recording of its playing; absent if it was not played.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<String>,
    /// The level re the stroke at which it was rendered, dB; absent if it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_db: Option<f64>,
    /// How far the peak of the drive is below the limit of the device, dB; absent if it was not rendered, or is silent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub headroom_db: Option<f64>,
    /// The parts of the band that the drive reaches.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub achievable_band_hz: Vec<Band>,
    /// What became of it.
    pub state: State,
    /// The state with its reasons, in one sentence.
    pub sentence: String,
    /// How close the measurement came; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verification: Option<Verification>,
    /// What a person should know before using it.
    pub warnings: Warnings,
}

impl Prepared {
    /// The texture `strokes` with its stroke in the file `target`, not rendered because of `why`.
    #[must_use]
    pub fn not_rendered(strokes: TextureStrokes, target: String, why: &str) -> Self {
        Self {
            strokes,
            target,
            drive: None,
            measured: None,
            level_db: None,
            headroom_db: None,
            achievable_band_hz: Vec::new(),
            state: State::NotRendered,
            sentence: format!("not rendered: {why}"),
            verification: None,
            warnings: Warnings::default(),
        }
    }

    /// The same with what its measurement in the file `measured` showed.
    #[must_use]
    pub fn measured(mut self, measured: String, verification: Verification) -> Self {
        self.state = State::of(&verification);
        self.sentence = verification.sentence();
        let levels = verification.sensation_db.unwrap_or([f64::INFINITY; 2]);
        if levels.iter().any(|db| *db <= 0.0) {
            self.sentence += "; at this level it lies below the detection threshold";
        }
        self.warnings
            .extend(not_felt(["the reference", "the test"], levels));
        self.measured = Some(measured);
        self.warnings.extend(verification.warnings.iter().cloned());
        self.verification = Some(verification);
        self
    }
}

/// A texture that is not good enough, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct NotGoodEnough {
    /// The texture.
    pub texture: String,
    /// Why, in one sentence.
    pub why: String,
}

/// The drives of one participant, one for each texture.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PreparedDrives {
    /// The participant; absent if nobody is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub participant: Option<String>,
    /// The transfer function.
    pub transfer: String,
    /// The bench on which the drives were measured; absent if they were not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bench: Option<String>,
    /// The band that was rendered and compared.
    pub band_hz: Band,
    /// What a closed loop corrected; absent in an open loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<Mode>,
    /// The level of all textures relative to their strokes, dB; absent where each has its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_db: Option<f64>,
    /// The texture that sets this level; absent where it was stated, or all fit at their own level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_set_by: Option<String>,
    /// Whether all drives can be used.
    pub outcome: Outcome,
    /// The conclusion in one sentence.
    pub sentence: String,
    /// The textures that are not good enough.
    pub not_good_enough: Vec<NotGoodEnough>,
    /// The textures, in the order of their recordings.
    pub textures: Vec<Prepared>,
    /// Recordings that gave no stroke.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<FailedFile>,
    /// What a person should know before using the drives, beside what each texture has.
    pub warnings: Warnings,
}

impl Content for PreparedDrives {
    const SCHEMA: &'static str = "prepare";
}

impl PreparedDrives {
    /// The same with what follows from its textures and recordings: conclusion, sentence, and the warning about levels that differ.
    #[must_use]
    pub fn concluded(mut self) -> Self {
        let open = self
            .textures
            .iter()
            .filter(|one| one.state != State::Passed);
        self.not_good_enough = open
            .map(|one| NotGoodEnough {
                texture: one.strokes.texture.clone(),
                why: one.sentence.clone(),
            })
            .collect();
        let none = self.textures.is_empty() || !self.failed.is_empty();
        let states = self.textures.iter().map(|one| one.state.outcome());
        self.outcome = match Outcome::of_all(states) {
            Outcome::Met if none => Outcome::NotDecided,
            all => all,
        };
        self.sentence = self.said();
        let levels = self.textures.iter().filter_map(|one| one.level_db);
        let (lowest_db, highest_db) = levels
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), level| {
                (low.min(level), high.max(level))
            });
        if highest_db - lowest_db > 0.05 {
            self.warnings.push(PrepareWarning::LevelsDiffer {
                lowest_db,
                highest_db,
            });
        }
        self
    }

    fn said(&self) -> String {
        let all = self.textures.len();
        let passed = self.textures.iter();
        let passed = passed.filter(|one| one.state == State::Passed).count();
        let others: Vec<String> = (self.textures.iter())
            .filter(|one| one.state != State::Passed)
            .map(|one| format!("{} {}", one.strokes.texture, one.state.word()))
            .collect();
        let failed = match self.failed.len() {
            0 => String::new(),
            1 => "; 1 recording gave no stroke".into(),
            more => format!("; {more} recordings gave no stroke"),
        };
        let drives = match (passed, all) {
            (1, 1) => "The drive passed".to_owned(),
            (some, all) if some == all => format!("All {all} drives passed"),
            (0, _) => format!("No drive passed; {}", others.join(", ")),
            (some, all) => format!("{some} of {all} drives passed; {}", others.join(", ")),
        };
        format!("{drives}{failed}")
    }
}
