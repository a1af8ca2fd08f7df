//! What the strokes of a recording say together.

use piezotact::compare::{Periods, Summary, summarise};
use piezotact_volunteers::Taken;

use crate::ReplayError;

/// What the strokes of `taken` say together, called `name`.
pub(super) fn summary(taken: &Taken, name: &str, periods: Periods) -> Result<Summary, ReplayError> {
    let members = [(&taken.analysis, &taken.condition)];
    Ok(summarise(name, &members, periods)?)
}
