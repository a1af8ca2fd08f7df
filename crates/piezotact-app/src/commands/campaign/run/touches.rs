//! With what touches are recorded in a session, and where.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use piezotact::recording::BenchKind;
use piezotact_bench::Acquire;
use piezotact_dataset::JournalSink;
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::protocol::{Protocol, TaskKind};
use piezotact_study::session::{KeeperOf, Played, TouchKeeper};

use crate::benches::BenchSpec;
use crate::keeping::began;
use crate::live::Showing;

/// The file of a playing, or of a part of a touch: `TRIAL-ATTEMPT-ELEMENT-PLAY.parquet`.
pub(super) fn run_name(played: &Played<'_>) -> String {
    format!(
        "{}-{}-{}-{}.parquet",
        piezotact_dataset::texture_file_name(played.trial),
        played.attempt,
        played.element + 1,
        played.play
    )
}

/// Touches of the session of `plan` on the bench that `spec` names, of this kind; they are kept beside what is played, in `folder`.
pub(super) fn touches(
    (spec, kind): (BenchSpec, BenchKind),
    (protocol, plan): (&Protocol, &Plan),
    folder: &Path,
) -> Box<KeeperOf<'static>> {
    let folder: PathBuf = folder.join("runs");
    let wanted = plan
        .trials
        .iter()
        .filter_map(|trial| match protocol.task(&trial.task)?.kind {
            TaskKind::Touch { strokes } => Some((trial.name.clone(), strokes as usize)),
            _ => None,
        });
    let wanted: BTreeMap<String, usize> = wanted.collect();
    Box::new(move |touched| {
        let name = run_name(touched);
        let strokes = wanted.get(touched.trial).copied().unwrap_or_default();
        let acquirer = sensors(&spec, strokes, touched.stimulus)?;
        Ok(TouchKeeper {
            acquirer,
            sink: Box::new(Showing(JournalSink::new(&folder.join(&name), None))),
            journal: format!("runs/{name}"),
            started_at: began(kind),
        })
    })
}

/// What acquires the touch of `sample` where it is no sensor of the bench itself: the person of a twin touches samples elsewhere.
fn sensors(
    spec: &BenchSpec,
    strokes: usize,
    sample: &str,
) -> Result<Option<Box<dyn Acquire>>, String> {
    use piezotact::recording::SlidingDirection;
    use piezotact_twin::{ActTouch, ActiveProtocol, Pace, Participant, TwinParameters};

    let Some((participant, seed)) = spec.person_of_twin() else {
        return Ok(None);
    };
    let parameters = TwinParameters::built_in();
    let person = Participant::of(participant, seed, &parameters);
    let sample = parameters
        .sample(sample)
        .map_err(|error| error.to_string())?;
    let protocol = ActiveProtocol {
        strokes,
        movement: SlidingDirection::Proximal,
        pace: Pace::Free,
    };
    let touch = ActTouch::new(&parameters, person, sample, protocol);
    let touch = touch.map_err(|error| error.to_string())?;
    Ok(Some(crate::live::acquirer(touch.into_acquirer())))
}
