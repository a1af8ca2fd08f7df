//! Why a recording gives no epochs.

use crate::eeg::epochs::EpochsError;

/// Why a recording gives no epochs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PrepareError {
    /// No segment, or none with samples.
    #[error("the recording has no samples: check the export")]
    Empty,
    /// No electrode.
    #[error("no channel of EEG (in V) is among {channels}: name them")]
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
        "{name} records {kind} and cannot be part of the average reference: leave it out, or name it as EOG"
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
    #[error("{channels} never changed over the whole recording: leave {channels} out")]
    Flat { channels: String },
    /// Channels at a limit of the amplifier.
    #[error(
        "{channel} is at the limit of the amplifier in {percent:.1} % of the samples: leave it out, or record with a lower gain"
    )]
    Saturated {
        channel: String,
        /// The share of samples, %.
        percent: f64,
    },
    /// No epoch that can be used.
    #[error(
        "none of {markers} markers has an epoch without unusable parts (the first: {why}); leave that channel out, or correct the events"
    )]
    NoneUsable {
        /// How many markers there are.
        markers: usize,
        /// Why the first has no epoch.
        why: String,
    },
    /// A high-pass filter at or above the low-pass one.
    #[error(
        "the high-pass filter at {high_pass_hz} Hz is not below the low-pass filter at {low_pass_hz} Hz, so nothing passes; exchange or correct them"
    )]
    NothingPasses { high_pass_hz: f64, low_pass_hz: f64 },
    /// No marker was asked for.
    #[error("state the markers around which epochs are cut; the file has {found}")]
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
        "the markers `{wanted}` occur in other tasks than {task} only: name another task or marker"
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
    /// Epochs cannot be.
    #[error(transparent)]
    Epochs(#[from] EpochsError),
    /// An electrode that is interpolated and left out.
    #[error("`{name}` is both left out and interpolated: choose one")]
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
}
