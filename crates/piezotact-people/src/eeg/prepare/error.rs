//! Why a recording gives no epochs.

use crate::eeg::clean::{IcaError, RegressionError};
use crate::eeg::epochs::{CutError, EpochsError, RejectError};
use crate::eeg::filter::FirError;
use crate::eeg::reference::ReferenceError;

/// Why a recording gives no epochs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PrepareError {
    /// No segment, or none with samples.
    #[error("expected a recording with samples, found none; check the export")]
    Empty,
    /// No electrode.
    #[error("expected channels of EEG (in V), found none among {channels}; name them")]
    NoElectrode {
        /// The channels that there are.
        channels: String,
    },
    /// A channel that the file does not hold.
    #[error(
        "expected the channel `{name}`, found {channels}; correct the name, or rename the channel in the file"
    )]
    NoChannel {
        name: String,
        /// The channels that there are.
        channels: String,
    },
    /// A channel in the reference that is no electrode.
    #[error(
        "expected electrodes where the reference is made of all of them, found {name}, which records {kind}; leave it out, or name it as EOG"
    )]
    NotAnElectrode { name: String, kind: &'static str },
    /// Channels of other rates.
    #[error(
        "expected channels of one rate, found {first} at {first_hz} Hz and {other} at {other_hz} Hz; leave one of them out"
    )]
    Rates {
        first: String,
        first_hz: f64,
        other: String,
        other_hz: f64,
    },
    /// Channels that never change.
    #[error(
        "expected signals that change, found {channels} flat over the whole recording; leave {channels} out"
    )]
    Flat { channels: String },
    /// Channels at a limit of the amplifier.
    #[error(
        "expected signals within the range of the amplifier, found {channel} at its limit in {percent:.1} % of the samples; leave it out, or \
         record with a lower gain"
    )]
    Saturated {
        channel: String,
        /// The share of samples, %.
        percent: f64,
    },
    /// No epoch that can be used.
    #[error(
        "expected an epoch without unusable parts, found none of {markers} markers; of the first, {why}; leave that channel out, or correct the \
         events"
    )]
    NoneUsable {
        /// How many markers there are.
        markers: usize,
        /// Why the first has no epoch.
        why: String,
    },
    /// No marker was asked for.
    #[error(
        "expected the markers around which epochs are cut, found none stated; the file has {found}"
    )]
    NoMarkerStated {
        /// The markers that there are.
        found: String,
    },
    /// A marker that the file does not hold.
    #[error(
        "expected markers `{wanted}`, found {found}; name one of them, or check that the triggers were recorded"
    )]
    NoMarker {
        /// The marker asked for.
        wanted: String,
        /// The markers that there are.
        found: String,
    },
    /// Markers of another task, or none.
    #[error(
        "expected markers `{wanted}` within task {task}, found them in other tasks only; name another task or marker"
    )]
    NoMarkerInTask {
        /// The marker asked for.
        wanted: String,
        task: String,
    },
    /// Markers of several kinds with one value.
    #[error("expected markers `{wanted}` of one kind, found {found}; name the whole marker")]
    SeveralKinds {
        /// The marker asked for.
        wanted: String,
        /// The markers that there are.
        found: String,
    },
    /// Several tasks.
    #[error(
        "expected one task in a recording, found {tasks}; state whose epochs are taken, or export each task to a file of its own"
    )]
    SeveralTasks { tasks: String },
    /// Another task than the one stated.
    #[error("expected task {wanted}, found {tasks}; correct the task")]
    OtherTask {
        /// The task asked for.
        wanted: String,
        /// The tasks that there are.
        tasks: String,
    },
    /// Too few epochs of a condition.
    #[error(
        "expected at least {needed} epochs of {condition}, found {found} ({rejected} rejected, {left_out} not whole{why}); record more, reject \
         fewer, or ask for fewer"
    )]
    FewEpochs {
        condition: String,
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
        /// How many were rejected.
        rejected: usize,
        /// How many would cross a gap or an end.
        left_out: usize,
        /// Why the first of them was left out; may be empty.
        why: String,
    },
    /// Epochs cannot be cut.
    #[error(transparent)]
    Cut(#[from] CutError),
    /// Epochs cannot be.
    #[error(transparent)]
    Epochs(#[from] EpochsError),
    /// Epochs cannot be rejected, or all are.
    #[error(transparent)]
    Reject(#[from] RejectError),
    /// A filter cannot be.
    #[error(transparent)]
    Filter(#[from] FirError),
    /// The regression on EOG cannot be.
    #[error(transparent)]
    Regression(#[from] RegressionError),
    /// Independent components cannot be.
    #[error(transparent)]
    Components(#[from] IcaError),
    /// An electrode that is interpolated and left out.
    #[error(
        "expected `{name}` to be left out or interpolated, found it in both; take it out of one of them"
    )]
    OutAndInterpolated { name: String },
    /// Too few electrodes for a spline.
    #[error(
        "expected at least {needed} other electrodes with a known position from which to interpolate {names}, found {found}; leave {names} out instead, or \
         give measured positions"
    )]
    FewForInterpolation {
        /// What was to be interpolated.
        names: String,
        /// How many electrodes there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
    /// The reference cannot be.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
}
