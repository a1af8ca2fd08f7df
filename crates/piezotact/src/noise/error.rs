//! Why noise cannot be analysed.

use crate::quantity::{Band, Hertz, Seconds};
use crate::recording::RecordingError;
use crate::series::SeriesError;
use crate::spectrum::EstimateError;

/// Why noise cannot be analysed.
#[derive(Debug, thiserror::Error)]
pub enum NoiseError {
    /// The channel cannot be picked.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording is too short.
    #[error("cannot analyse noise: expected {needed} or longer, found {found:.3}; record longer")]
    TooShort { needed: Seconds, found: Seconds },
    /// The band reaches beyond the signal.
    #[error(
        "cannot analyse noise over {band}: the signal ends at {highest}; lower the end of the band"
    )]
    Band {
        /// The band asked for.
        band: Band,
        /// Where the signal ends.
        highest: Hertz,
    },
    /// The channel never changes.
    #[error("cannot analyse noise: `{channel}` never changes; check the sensor's cable and range")]
    Dead { channel: String },
    /// The band holds no line of the spectrum.
    #[error(
        "cannot analyse noise over {band}: the spectrum has a line every {resolution} and none in the band; widen the band"
    )]
    NarrowBand {
        /// The band asked for.
        band: Band,
        /// The step between lines.
        resolution: Hertz,
    },
    /// The channel is constant for more than half of the recording.
    #[error(
        "cannot analyse noise: `{channel}` is constant for half of the recording or longer; check the sensor's cable and range"
    )]
    MostlyConstant { channel: String },
    /// The spectrum cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// The band's lower end cannot be filtered at.
    #[error(transparent)]
    Filter(#[from] SeriesError),
}
