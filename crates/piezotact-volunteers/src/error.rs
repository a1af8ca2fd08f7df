//! Why virtual volunteers cannot be measured, or a campaign with them not be simulated.

use piezotact::feature::FeatureError;
use piezotact::manipulate::ManipulateError;
use piezotact::quantity::QuantityError;
use piezotact::series::SeriesError;
use piezotact::stroke::SegmentError;
use piezotact_bench::{DeviceError, ProcedureError};
use piezotact_people::campaign::protocol::ProtocolError;
use piezotact_people::campaign::store::StoreError;
use piezotact_people::judge::JudgeError;
use piezotact_study::session::RunError;
use piezotact_twin::TwinError;

/// Why something cannot be measured on the twin, or a campaign not be simulated.
#[derive(Debug, thiserror::Error)]
pub enum VolunteerError {
    /// The protocol has no such session.
    #[error(transparent)]
    Plan(#[from] ProtocolError),
    /// The session refuses.
    #[error(transparent)]
    Run(Box<RunError>),
    /// The store refuses.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// What was delivered has no cues.
    #[error("{what}: {error}")]
    Cues {
        /// The texture, and whose it is.
        what: String,
        error: Box<JudgeError>,
    },
    /// No stroke can be used.
    #[error("{what}: no stroke can be used; look at the world of the twin")]
    NoStroke {
        /// The texture, and whose it is.
        what: String,
    },
    /// There is no answer to a trial.
    #[error("trial {trial}: {error}")]
    Judge {
        trial: String,
        error: Box<JudgeError>,
    },
    /// No average transfer function.
    #[error(
        "the protocol renders with the average of the panel `{panel}`, and none was measured; measure one with people who do not take part"
    )]
    Average { panel: String },
    /// Somebody of the panel takes part.
    #[error(
        "volunteer {number} is in the panel and takes part: choose other numbers for the panel"
    )]
    Overlap {
        /// The number under the seed.
        number: u64,
    },
    /// A stimulus of which nothing is known.
    #[error(
        "the protocol presents `{stimulus}`, which is neither a sample nor a stimulus of it; correct the protocol"
    )]
    Stimulus { stimulus: String },
    /// A stimulus cannot be made of what was touched.
    #[error("{stimulus}: {error}")]
    Making {
        stimulus: String,
        error: Box<ManipulateError>,
    },
    /// A drive cannot be made and measured.
    #[error("{stimulus}: {error}")]
    Drive {
        stimulus: String,
        error: Box<ProcedureError>,
    },
    /// A device failed, which the twin never does.
    #[error(
        "{pseudonym}: trial {trial} is void again and again: {why}; look at the drives of this person"
    )]
    Void {
        pseudonym: String,
        trial: String,
        why: String,
    },
    /// A bench refuses.
    #[error(transparent)]
    Bench(Box<ProcedureError>),
    /// A device refuses.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The twin has no such sample.
    #[error(transparent)]
    Parameter(#[from] TwinError),
    /// A recording cannot be cut.
    #[error("{what}: {error}")]
    Segment { what: String, error: SegmentError },
    /// A recording has no strokes to analyse.
    #[error("{what}: {error}")]
    Feature {
        what: String,
        error: Box<FeatureError>,
    },
    /// Transfer functions cannot be estimated or averaged.
    #[error(transparent)]
    Transfer(#[from] piezotact::transfer::TransferError),
    /// Transfer functions make no panel.
    #[error(transparent)]
    Panel(#[from] piezotact::panel::PanelError),
    /// A number that cannot be.
    #[error(transparent)]
    Quantity(#[from] QuantityError),
    /// Samples that make no series.
    #[error(transparent)]
    Series(#[from] SeriesError),
}

impl From<RunError> for VolunteerError {
    fn from(error: RunError) -> Self {
        Self::Run(Box::new(error))
    }
}

impl From<ProcedureError> for VolunteerError {
    fn from(error: ProcedureError) -> Self {
        Self::Bench(Box::new(error))
    }
}
