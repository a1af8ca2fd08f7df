//! What a closed loop came to, for tables and reports of several.

use crate::quantity::Band;
use crate::recording::BenchKind;
use crate::render::RenderedDrive;
use crate::statistics::mean;
use crate::verify::Verification;

/// A texture that was rendered for a finger in a closed loop.
#[derive(Clone, Debug)]
pub struct CorrectedRendering<'a> {
    /// What it is called beside others.
    pub called: &'a str,
    /// The level it was rendered at, relative to the texture, dB.
    pub level_db: f64,
    /// The drive that is kept.
    pub drive: &'a RenderedDrive,
    /// What the drive of the open loop came to.
    pub open: &'a Verification,
    /// What the drive that is kept came to.
    pub closed: &'a Verification,
    /// Whether the drive that is kept was measured once more.
    pub is_confirmed: bool,
    /// Whether it came close to its target in a measurement that did not choose it.
    pub is_close: bool,
    /// Whether the drive of the open loop is kept.
    pub is_open_kept: bool,
    /// Which drive is kept and why, in words.
    pub kept: String,
    /// Whether the drive that is kept is a corrected one with a worse spectrum than the open loop, beyond the spread of measurements.
    pub got_worse: bool,
    /// How much closer the best corrected drive came than the open loop, with its interval, dB; absent where none was judged closer.
    pub gain_db: Option<(f64, [f64; 2])>,
    /// The number of the drive that is kept.
    pub best: usize,
    /// The share of its samples that stood at the limit of the device, 0–1.
    pub held: f64,
    /// Why the loop ended, in two words.
    pub ended: &'static str,
    /// Which bench it was played on; absent where that is not known.
    pub bench: Option<BenchKind>,
}

impl CorrectedRendering<'_> {
    /// The share of the band that the inverse reaches, 0–1.
    #[must_use]
    pub fn reached_share(&self) -> f64 {
        let width = |bands: &[Band]| bands.iter().map(|b| b.high().0 - b.low().0).sum::<f64>();
        width(&self.drive.coverage.reached) / width(&[self.drive.config.inverse.band])
    }

    /// The share of the samples where device or sensor clips, 0–1.
    #[must_use]
    pub fn share_at_limit(&self) -> f64 {
        self.closed.clipped_fraction.max(self.held)
    }
}

/// What several renderings came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderingSums {
    /// How many there are.
    pub count: usize,
    /// How many came close.
    pub close: usize,
    /// In how many the open loop is kept.
    pub open_kept: usize,
    /// The error of the open loop over what is reached, dB rms, mean.
    pub open_db_mean: f64,
    /// The error of what is kept, dB rms, mean.
    pub closed_db_mean: f64,
    pub closed_db_largest: f64,
    /// The largest error of a line, dB.
    pub line_db_largest: f64,
    open_db: Vec<f64>,
    closed_db: Vec<f64>,
}

impl RenderingSums {
    /// Counts a rendering.
    pub fn add(&mut self, one: &CorrectedRendering<'_>) {
        let closed_db = one.closed.judged_error_db();
        self.count += 1;
        self.close += usize::from(one.is_close);
        self.open_kept += usize::from(one.is_open_kept);
        self.open_db.push(one.open.judged_error_db());
        self.closed_db.push(closed_db);
        self.open_db_mean = mean(&self.open_db);
        self.closed_db_mean = mean(&self.closed_db);
        self.closed_db_largest = self.closed_db_largest.max(closed_db);
        let line_db = one.closed.error_db_max_achievable();
        self.line_db_largest = self.line_db_largest.max(line_db);
    }
}
