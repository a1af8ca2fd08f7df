//! From a bench to what its strokes say, as anybody would do it: record, guess the roles, cut, analyse.

use piezotact::Doubt;
use piezotact::compare::{Periods, Summary, summarise};
use piezotact::feature::{Analysis, FeatureConfig, analyse};
use piezotact::filter::HighPass;
use piezotact::quantity::{Degrees, Newtons};
use piezotact::recording::{Condition, Recording};
use piezotact::roles::Roles;
use piezotact::spectrum::WelchConfig;
use piezotact::stroke::{Expected, Judging, Reason, Segmentation, segment};

use super::{Replay, ReplayError};
use piezotact_bench::procedure::record;
use piezotact_bench::{Acquire, Placement, RunPlan, Until};

/// What a bench gave.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    pub(super) condition: Condition,
    pub(super) segmentation: Segmentation,
    pub(super) analysis: Analysis,
    /// Contacts that stuck and slipped, and what became of them.
    pub(super) slipped: usize,
    pub(super) judging: Judging,
    /// What a person should know before relying on it.
    pub(super) doubts: Vec<Doubt>,
}

/// A run at `load_n`, or at the person's own load.
pub(super) fn run(replay: &Replay, label: &str, load_n: Option<f64>) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: load_n.map(Newtons),
        angle: Degrees(replay.parameters.hand.angle_deg),
        placement: Placement::New,
        until: Until::Stopped,
    }
}

/// Records, cuts and analyses, with PSDs of segments of `segment_samples`.
pub(super) fn take(
    mut acquirer: Box<dyn Acquire>,
    run: &RunPlan,
    segment_samples: usize,
) -> Result<(Taken, Recording), ReplayError> {
    let recording = record(acquirer.as_mut(), run)?;
    let what = recording.about.condition.to_string();
    let cut = |judging: Judging| {
        let (roles, _) = Roles::guess(&recording);
        let expected = Expected {
            load_n: recording.about.condition.load_n,
            speed_m_s: recording.about.condition.speed_m_s,
            judging,
        };
        segment(&recording, &roles, expected).map_err(|error| ReplayError::Segment {
            what: what.clone(),
            error,
        })
    };
    let mut segmentation = cut(Judging::Sliding)?;
    let slipped = segmentation
        .rejected
        .iter()
        .filter(|rejected| matches!(rejected.reason, Reason::StickSlip { .. }))
        .count();
    // Where it only sticks and slips, the contacts are analysed all the same.
    let mut judging = Judging::Sliding;
    if segmentation.strokes.len() < 2 {
        judging = Judging::ContactOnly;
        segmentation = cut(Judging::ContactOnly)?;
    }
    let analysis = analysed(&recording, &segmentation, segment_samples)?;
    let mut doubts = recording.about.doubts.clone();
    doubts.extend(segmentation.doubts.iter().chain(&analysis.doubts).cloned());
    doubts.extend(segmentation.rejection_doubt());
    let taken = Taken {
        condition: recording.about.condition.clone(),
        segmentation,
        analysis,
        slipped,
        judging,
        doubts,
    };
    Ok((taken, recording))
}

/// The features of strokes, with PSDs of segments of `segment_samples`.
fn analysed(
    recording: &Recording,
    segmentation: &Segmentation,
    segment_samples: usize,
) -> Result<Analysis, ReplayError> {
    let feature = |error| ReplayError::Feature {
        what: recording.about.condition.to_string(),
        error,
    };
    let longest: Vec<usize> = segmentation
        .strokes
        .iter()
        .map(|stroke| stroke.steady.len())
        .collect();
    let usual = FeatureConfig::usual(recording.rate(), &longest, Some(HighPass::gesture()))
        .map_err(feature)?;
    let config = FeatureConfig {
        welch: WelchConfig::hann(segment_samples),
        ..usual
    };
    analyse(recording, segmentation, &config).map_err(feature)
}

impl Taken {
    /// What its strokes say together.
    pub(super) fn summary(&self, name: &str, periods: Periods) -> Result<Summary, ReplayError> {
        let members = [(&self.analysis, &self.condition)];
        Ok(summarise(name, &members, periods)?)
    }
}
