//! How a drive was made, as it stands with the drive and with what was recorded while it was played.

use serde::{Deserialize, Serialize};

use super::{Headroom, PhaseForm, RenderConfig, RenderedDrive, headroom};
use crate::checksum::Checksum;
use crate::clipping::{ClippedAt, ClippingWarning};
use crate::device::DriveSetup;
use crate::lineage::Mode;
use crate::quantity::{Band, Drive};
use crate::recording::{About, Condition};
use crate::series::Series;
use crate::warning::Warning;

/// Two levels that differ by less are one, dB.
const SAME_LEVEL_DB: f64 = 0.005;

/// How a drive was rendered, with its warnings: a [`RenderedDrive`] without its samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Rendering {
    /// The device it is for.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub setup: Option<DriveSetup>,
    /// The texture it was rendered from, by name.
    pub target: String,
    /// The checksum of its samples in m/s²; absent where it is not stated.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub target_samples: Option<Checksum>,
    /// The condition it is for, the provenance of its transfer function, and its warnings.
    #[serde(flatten)]
    pub about: About,
    /// The level it was rendered at, relative to the target, dB.
    pub level_db: f64,
    /// How it was made.
    pub config: RenderConfig,
    /// What a closed loop corrected it for; none in an open loop.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub aim: Option<Mode>,
    /// How much of the device it uses.
    pub headroom: Headroom,
    /// The parts of the band that the inverse reaches, Hz.
    pub achievable_band_hz: Vec<Band>,
    /// The parts it gives up, Hz.
    pub given_up_band_hz: Vec<Band>,
}

impl Rendering {
    /// Whether `other` was rendered from the same texture, at the same level, for the same device: levels within 0.005 dB.
    ///
    /// Source: docs/decisions/verification.md.
    #[must_use]
    pub fn is_alike(&self, other: &Self) -> bool {
        let device = match (&self.setup, &other.setup) {
            (Some(one), Some(another)) => one.amplifies_like(another),
            _ => true,
        };
        let level = (self.level_db - other.level_db).abs() <= SAME_LEVEL_DB;
        self.target == other.target && level && device
    }

    /// Whether the waveform of the texture was rendered, or its spectrum alone.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn mode(&self) -> Mode {
        if self.config.inverse.phase == PhaseForm::Minimum {
            Mode::Texture
        } else {
            self.aim.unwrap_or(Mode::Replicate)
        }
    }

    /// What `rendered`, made from the texture called `target` at `level_db` dB relative to it, is.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn of(rendered: &RenderedDrive, target: &str, level_db: f64) -> Self {
        Self {
            target: target.into(),
            target_samples: None,
            about: rendered.about.clone(),
            setup: rendered.setup.clone(),
            level_db,
            config: rendered.config.clone(),
            aim: rendered.aim,
            headroom: rendered.headroom.clone(),
            achievable_band_hz: rendered.coverage.reached.clone(),
            given_up_band_hz: rendered.coverage.given_up.clone(),
        }
    }
}

/// The warnings about a recording made under `measured` while `drive` was played at `setup`, apart from the recording itself: that
/// the drive is steeper than the amplifier follows, that it clips, and that it was made (`rendering`) for another condition.
///
/// Source: docs/decisions/documents.md, for one place for all three.
#[must_use]
pub fn warnings_of_played(
    drive: &Series<Drive>,
    setup: Option<&DriveSetup>,
    rendering: Option<&Rendering>,
    measured: &Condition,
) -> Vec<Warning> {
    let headroom = headroom(drive.samples(), drive.rate(), setup);
    let mut warnings: Vec<Warning> = headroom.slew_warning(setup).into_iter().collect();
    let fraction = headroom.clipped_fraction;
    if fraction > 0.0 {
        warnings.push(Warning::from(ClippingWarning::Clipped {
            signal: "the played drive".into(),
            at: ClippedAt::Played { fraction },
        }));
    }
    if let Some(rendering) = rendering {
        warnings.extend(rendering.about.condition.warnings_when_measured(measured));
    }
    warnings
}
