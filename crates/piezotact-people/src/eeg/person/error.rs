//! Why there is no desynchronisation.

use crate::eeg::epochs::EpochsError;
use crate::eeg::tfr::TfrError;

/// Why there is no desynchronisation of a person.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PersonError {
    /// No band or region.
    #[error("no band or no region is stated: state at least one of each")]
    Nothing,
    /// Two bands or two regions of one name.
    #[error("`{name}` is the name of two: rename one")]
    Twice { name: String },
    /// A band that the wavelets do not cover.
    #[error(
        "expected the band {name} ({} to {} Hz) within the frequencies of the wavelets, found {} to {} Hz; state frequencies that cover it",
        .band[0], .band[1], .covered[0], .covered[1]
    )]
    Band {
        /// The name of the band.
        name: String,
        /// Its ends, Hz.
        band: [f64; 2],
        /// The first and the last frequency, Hz.
        covered: [f64; 2],
    },
    /// A band or region that a document does not have.
    #[error("{file}: expected a band or region among {there}, found `{name}`; correct the name")]
    NotThere {
        name: String,
        /// The file of the document.
        file: String,
        /// Those that there are.
        there: String,
    },
    /// A filter that takes away a band.
    #[error(
        "expected the band {name} ({} to {} Hz) among what the filters leave, found {filter}; leave the filter out, or state another band",
        .band[0], .band[1]
    )]
    FilteredOut {
        /// The name of the band.
        name: String,
        /// Its ends, Hz.
        band: [f64; 2],
        filter: String,
    },
    /// A region with an electrode that was not recorded.
    #[error(
        "expected the electrodes of region {region} among {channels}; found `{channel}`; correct its name, interpolate it, or state another region"
    )]
    Region {
        region: String,
        channel: String,
        /// The electrodes that there are.
        channels: String,
    },
    /// Positions of other electrodes.
    #[error(
        "expected positions of the channels {channels}, found those of {found} alone; rename the channels, or give the positions of this cap"
    )]
    NoPosition {
        channels: String,
        /// The names that have a position.
        found: String,
    },
    /// Power cannot be estimated.
    #[error(transparent)]
    Power(#[from] TfrError),
    /// Epochs cannot be picked.
    #[error(transparent)]
    Epochs(#[from] EpochsError),
    /// There is no change of power on one surface.
    #[error("{surface}: {error}")]
    Erd { surface: String, error: TfrError },
}
