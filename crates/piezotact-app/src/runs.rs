//! A run on a bench as the options ask for it.

use piezotact::quantity::{Degrees, Newtons};
use piezotact_bench::{Acquire, Placement, RunPlan, Until};

use crate::cli::Finger;

/// The load of a run that states none, N.
const USUAL_LOAD_N: f64 = 0.2;
/// The angle of a run that states none, degrees.
pub(crate) const USUAL_ANGLE_DEG: f64 = 20.0;

/// A run of what the options ask for; what they leave open is as the bench has it, or as is usual.
pub(crate) fn run_plan(label: &str, finger: &Finger, acquirer: &dyn Acquire) -> RunPlan {
    let here = acquirer.describe().condition;
    let (load, angle) = (finger.load.map(Newtons), finger.angle.map(Degrees));
    RunPlan {
        label: label.into(),
        load: Some(load.or(here.load_n).unwrap_or(Newtons(USUAL_LOAD_N))),
        angle: angle.or(here.angle_deg).unwrap_or(Degrees(USUAL_ANGLE_DEG)),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}
