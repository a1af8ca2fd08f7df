//! Instructions to a participant, and their possible ranges.

use piezotact_bench::{DeviceError, RunPlan};

pub use piezotact::recording::SlidingDirection;

/// Who sets the speed and the force of active touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// A metronome: strokes at `speed_m_s`, each `stroke_s` long (over the whole plate where absent), at the load of
    /// the run.
    Metronome {
        /// The speed asked for, m/s.
        speed_m_s: f64,
        /// How long a stroke is to last, s.
        stroke_s: Option<f64>,
    },
    /// The person, in speed and force.
    Free,
}

/// Strokes that one recording can hold.
const MOST_STROKES: usize = 20_000;
/// Loads that a finger can hold, N.
pub(crate) const LOADS_N: [f64; 2] = [0.05, 2.0];
/// Angles between finger and surface that a hand can take, degrees.
pub(crate) const ANGLES_DEG: [f64; 2] = [10.0, 60.0];

/// Refuses a value outside its possible range.
pub(crate) fn within(what: &str, value: f64, [low, high]: [f64; 2]) -> Result<(), DeviceError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(DeviceError::Impossible {
        expected: format!("{what} from {low} to {high}"),
        found: value.to_string(),
        todo: "ask for one that is possible".into(),
    })
}

/// Refuses a run without a load, or with one that no finger holds.
pub(crate) fn load_possible(run: &RunPlan) -> Result<(), DeviceError> {
    match run.load {
        Some(load) => within("a load in N", load.0, LOADS_N),
        None => Err(DeviceError::Impossible {
            expected: format!("a load in N from {} to {}", LOADS_N[0], LOADS_N[1]),
            found: "none".into(),
            todo: "state one; 0.2 N is usual".into(),
        }),
    }
}

pub(crate) fn strokes_possible(strokes: usize) -> Result<(), DeviceError> {
    if (1..=MOST_STROKES).contains(&strokes) {
        return Ok(());
    }
    Err(DeviceError::Impossible {
        expected: format!("from 1 to {MOST_STROKES} strokes"),
        found: strokes.to_string(),
        todo: "15 are usual in active touch, 6 in passive touch".into(),
    })
}
