//! What was rendered on a bench, as it is handed out.

use std::path::{Path, PathBuf};

use piezotact::device::DriveSetup;
use piezotact::document::Content;
use piezotact::quantity::Band;
use piezotact::recording::Condition;
use piezotact::render::{GainFit, Headroom, RenderedDrive, gains_for};
use piezotact::warning::{Merged, merged};
use serde::Serialize;

use crate::procedure::ClosedLoopResult;

mod rendered;

pub use rendered::RenderedTextures;

/// A texture that was rendered. It differs from the rendered drive by the names of files and by what every gain would need.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RenderDocument<'a> {
    /// The names of its files.
    #[serde(flatten)]
    pub names: RenderNames<'a>,
    /// The rate of the drive, Hz.
    pub rate_hz: u32,
    /// The level it was rendered at, relative to the texture, dB.
    pub level_db: f64,
    /// How much of the device it uses.
    pub headroom: &'a Headroom,
    /// The parts of the band that the inverse reaches, Hz.
    pub achievable_band_hz: &'a [Band],
    /// The parts it gives up, Hz.
    pub given_up_band_hz: &'a [Band],
    /// The device it is for.
    pub drive_setup: Option<&'a DriveSetup>,
    /// What it would need, and have, at every gain; absent where the device is not known.
    pub gains: Option<Vec<GainFit>>,
    /// What the closed loop found; absent for an open loop.
    #[serde(rename = "loop")]
    pub looped: Option<&'a ClosedLoopResult>,
    /// Whose finger it is for.
    pub condition: &'a Condition,
    /// What limits it.
    pub warnings: Vec<Merged>,
    /// The drive.
    #[serde(skip)]
    pub drive: &'a RenderedDrive,
}

impl Content for RenderDocument<'_> {
    const SCHEMA: &'static str = "render";
}

/// The names of a rendering: of the texture, of the transfer function, of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RenderNames<'a> {
    /// What it is called beside others.
    pub called: &'a str,
    /// The file of the texture.
    pub target: &'a Path,
    /// The file of the transfer function.
    pub transfer: &'a Path,
    /// The file that holds the drive.
    pub out: &'a Path,
}

impl<'a> RenderDocument<'a> {
    /// `drive`, rendered at `level_db` dB relative to the texture and kept at `rate_hz`, with its closed loop where there was one.
    #[must_use]
    pub fn of(
        names: RenderNames<'a>,
        drive: &'a RenderedDrive,
        (rate_hz, level_db): (u32, f64),
        looped: Option<&'a ClosedLoopResult>,
    ) -> Self {
        let setup = drive.setup.as_ref();
        Self {
            names,
            rate_hz,
            level_db,
            headroom: &drive.headroom,
            achievable_band_hz: &drive.coverage.reached,
            given_up_band_hz: &drive.coverage.given_up,
            drive_setup: setup,
            gains: setup.map(|setup| gains_for(&drive.headroom, setup)),
            looped,
            condition: &drive.about.condition,
            warnings: merged(&drive.about.warnings),
            drive,
        }
    }
}

/// A texture that could not be rendered.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RefusedRendering {
    /// What it is called.
    pub called: String,
    /// The file of the texture.
    pub target: PathBuf,
    /// The file of the transfer function.
    pub transfer: PathBuf,
    /// Why.
    pub why: String,
}

/// Several textures or fingers in one go.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RenderBatchDocument<R> {
    /// What was rendered: each [`RenderDocument`], or what it is as JSON, so that no samples are held until all is done.
    pub renderings: Vec<R>,
    /// What could not be.
    pub refused: Vec<RefusedRendering>,
    /// What a report shows of all of them.
    #[serde(skip)]
    pub shown: RenderedTextures,
}

impl<R: Serialize> Content for RenderBatchDocument<R> {
    const SCHEMA: &'static str = "render_batch";
}
