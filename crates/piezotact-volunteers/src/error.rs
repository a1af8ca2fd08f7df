//! Why virtual volunteers cannot be measured, or a campaign with them not be simulated.

use piezotact::feature::FeatureError;
use piezotact::quantity::QuantityError;
use piezotact::series::SeriesError;
use piezotact::stroke::SegmentError;
use piezotact_bench::{DeviceError, ProcedureError};
use piezotact_people::campaign::plan::PlanError;
use piezotact_people::campaign::store::StoreError;
use piezotact_people::judge::{CuesError, JudgeError};
use piezotact_study::session::RunError;
use piezotact_twin::ParameterError;

/// Why something cannot be measured on the twin.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// A bench refuses.
    #[error("{0}")]
    Bench(#[from] ProcedureError),
    /// A device refuses.
    #[error("{0}")]
    Device(#[from] DeviceError),
    /// The twin has no such sample.
    #[error("{0}")]
    Parameter(#[from] ParameterError),
    /// A recording cannot be cut.
    #[error("{what}: {error}")]
    Segment { what: String, error: SegmentError },
    /// A recording has no strokes to analyse.
    #[error("{what}: {error}")]
    Feature { what: String, error: FeatureError },
    /// Transfer functions make no bundle.
    #[error("{0}")]
    Ensemble(#[from] piezotact::transfer::BundleError),
    /// Transfer functions make no panel.
    #[error("{0}")]
    Panel(#[from] piezotact::panel::PanelError),
    /// A number that cannot be.
    #[error("{0}")]
    Quantity(#[from] QuantityError),
    /// Samples that make no series.
    #[error("{0}")]
    Series(#[from] SeriesError),
}

/// Why a campaign cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// The twin refuses.
    #[error(transparent)]
    Measure(Box<MeasureError>),
    /// The protocol has no such session.
    #[error(transparent)]
    Plan(#[from] PlanError),
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
        error: CuesError,
    },
    /// No stroke can be used.
    #[error("{what}: expected a stroke, found none; look at the world of the twin")]
    NoStroke {
        /// The texture, and whose it is.
        what: String,
    },
    /// There is no answer to a trial.
    #[error("trial {trial}: {error}")]
    Judge { trial: String, error: JudgeError },
    /// No average transfer function.
    #[error(
        "the protocol renders with the average of the panel `{panel}`, and none was measured; measure one with people who do not take part"
    )]
    Average { panel: String },
    /// Somebody of the panel takes part.
    #[error(
        "expected a panel to which no participant belongs, found volunteer {number} in both; choose other numbers for the panel"
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
    /// A device failed, which the twin never does.
    #[error(
        "{pseudonym}: trial {trial} is void again and again: {why}; look at the drives of this person"
    )]
    Void {
        pseudonym: String,
        trial: String,
        why: String,
    },
}

impl From<MeasureError> for CampaignError {
    fn from(error: MeasureError) -> Self {
        Self::Measure(Box::new(error))
    }
}

impl From<RunError> for CampaignError {
    fn from(error: RunError) -> Self {
        Self::Run(Box::new(error))
    }
}
