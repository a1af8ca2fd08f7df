//! From a bench to what its strokes say, as anybody would do it: record, guess the roles, cut, analyse.

use crate::VolunteerError;
use piezotact::Warning;
use piezotact::feature::{Analysis, FeatureConfig, analyse};
use piezotact::filter::HighPass;
use piezotact::quantity::{Degrees, Newtons};
use piezotact::recording::{Condition, Recording};
use piezotact::roles::Roles;
use piezotact::spectrum::WelchConfig;
use piezotact::stroke::{Expected, Judging, Reason, Segmentation, segment};
use piezotact_bench::procedure::record;
use piezotact_bench::{Acquire, Placement, RunPlan, Until};

use crate::Laboratory;

/// What a bench gave.
#[derive(Clone, Debug)]
pub struct Taken {
    pub condition: Condition,
    pub segmentation: Segmentation,
    pub analysis: Analysis,
    /// Contacts that stuck and slipped, and what became of them.
    pub slipped: usize,
    pub judging: Judging,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

/// A run at `load_n`, or at the person's own load.
#[must_use]
pub fn run(laboratory: &Laboratory, label: &str, load_n: Option<f64>) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: load_n.map(Newtons),
        angle: Degrees(laboratory.parameters.hand.angle_deg),
        placement: Placement::New,
        until: Until::Stopped,
    }
}

/// Records, cuts and analyses, with PSDs of segments of `segment_samples`.
///
/// # Errors
/// [`VolunteerError`] where the bench or the analysis refuses.
pub fn take(
    mut acquirer: Box<dyn Acquire>,
    run: &RunPlan,
    segment_samples: usize,
) -> Result<(Taken, Recording), VolunteerError> {
    let recording = record(acquirer.as_mut(), run)?;
    let taken = taken(&recording, segment_samples)?;
    Ok((taken, recording))
}

/// The strokes of `recording`, with PSDs of segments of `segment_samples`.
///
/// # Errors
/// [`VolunteerError`] where they cannot be cut or analysed.
pub(crate) fn taken(
    recording: &Recording,
    segment_samples: usize,
) -> Result<Taken, VolunteerError> {
    let what = recording.about.condition.to_string();
    let cut = |judging: Judging| {
        let (roles, _) = Roles::guess(recording);
        let expected = Expected {
            load_n: recording.about.condition.load_n,
            speed_m_s: recording.about.condition.speed_m_s,
            judging,
        };
        segment(recording, &roles, expected).map_err(|error| VolunteerError::Segment {
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
    let analysis = analysed(recording, &segmentation, segment_samples)?;
    let mut warnings = recording.about.warnings.clone();
    warnings.extend(
        segmentation
            .warnings
            .iter()
            .chain(&analysis.warnings)
            .cloned(),
    );
    warnings.extend(segmentation.own_warnings(recording.rate()));
    Ok(Taken {
        condition: recording.about.condition.clone(),
        segmentation,
        analysis,
        slipped,
        judging,
        warnings,
    })
}

/// The features of strokes, with PSDs of segments of `segment_samples`.
fn analysed(
    recording: &Recording,
    segmentation: &Segmentation,
    segment_samples: usize,
) -> Result<Analysis, VolunteerError> {
    let feature = |error| VolunteerError::Feature {
        what: recording.about.condition.to_string(),
        error: Box::new(error),
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
