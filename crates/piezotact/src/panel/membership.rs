//! The criteria that decide whether a measurement is a member of a panel and of the averages over its people.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::together::Sign;
use super::{Cell, Entry, Filing, Panel, SAME};
use crate::criterion::{Criterion, Limit, Outcome};
use crate::quantity::{Band, Quantity};
use crate::transfer::TransferFunction;

/// Coherence below this counts as low where an average is to be relied on.
pub(super) const LOW_COHERENCE: f64 = 0.8;
/// The share of lines with low coherence from which on a warning is raised, 0–1.
const LOW_SHARE: f64 = 0.1;
/// A warning is raised when more than this share of the other measurements in a cell have the opposite sign, 0–1.
const OPPOSITE_SHARE: f64 = 0.5;

/// The criteria for a measurement of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum MemberCriterion {
    /// How far the load it was measured at is from the one it is filed under.
    Load,
    /// How far the angle it was measured at is from the one it is filed under.
    Angle,
    /// The difference of its line spacing from that of the first measurement, as a share.
    LineSpacing,
    /// How many lines more or fewer than the first measurement it has.
    LineCount,
    /// How far its rate is from that of the first measurement, as a share.
    Rate,
    /// Whether another device was excited than in the first measurement: 1, else 0.
    OtherDevice,
    /// Whether another estimator was used than for the first measurement: 1, else 0.
    OtherEstimator,
    /// Whether it comes from another kind of bench than the first measurement: 1, else 0.
    OtherBench,
    /// The share of the other measurements at its load and angle that have the opposite sign.
    OppositeSign,
    /// The share of the band that was excited.
    Excited,
    /// The share of the band's lines whose coherence is below 0.8.
    LowCoherence,
}

impl MemberCriterion {
    /// The unit of what is found.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Load => "N",
            Self::Angle => "°",
            _ => "",
        }
    }
}

impl fmt::Display for MemberCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Load => "load, difference from the filed value",
            Self::Angle => "angle, difference from the filed value",
            Self::LineSpacing => "spacing of lines, difference from the first measurement",
            Self::LineCount => "number of lines, difference from the first measurement",
            Self::Rate => "sampling rate, difference from the first measurement",
            Self::OtherDevice => "device different from the first measurement",
            Self::OtherEstimator => "estimator different from the first measurement",
            Self::OtherBench => "kind of bench different from the first measurement",
            Self::OppositeSign => "share of others at this load and angle with the opposite sign",
            Self::Excited => "share of the band that was excited",
            Self::LowCoherence => "share of lines with a coherence below 0.8",
        })
    }
}

/// One measurement of a panel, and the criteria that decide whether it is a member.
///
/// A measurement with a criterion that is not met is not a member, and a panel with it is refused. A measurement with a criterion
/// that is not decided is a member, included in the averages as all others, with a warning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Member {
    /// Which measurement.
    pub filing: Filing,
    /// What was looked at.
    pub criteria: Vec<Criterion<MemberCriterion>>,
}

impl Member {
    /// All criteria together.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of_all(self.criteria.iter().map(|criterion| criterion.outcome))
    }

    /// The criterion on `what`, where it was looked at.
    #[must_use]
    pub fn criterion(&self, what: MemberCriterion) -> Option<&Criterion<MemberCriterion>> {
        self.criteria
            .iter()
            .find(|criterion| criterion.what == what)
    }
}

/// The criteria for a participant in comparisons of loads and angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ParticipantCriterion {
    /// At how many loads and angles the participant was measured.
    CellsMeasured,
}

impl fmt::Display for ParticipantCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CellsMeasured => "number of loads and angles measured",
        })
    }
}

/// One participant, and the criteria that decide whether they can be part of comparisons over all loads and angles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Completeness {
    /// The pseudonym.
    pub participant: String,
    /// What was looked at.
    pub criteria: Vec<Criterion<ParticipantCriterion>>,
}

impl Completeness {
    /// All criteria together.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of_all(self.criteria.iter().map(|criterion| criterion.outcome))
    }
}

fn criterion(what: MemberCriterion, found: f64, limit: Limit) -> Criterion<MemberCriterion> {
    Criterion::new(what, what.unit(), found, None, limit)
}

/// Nothing but what rounding leaves.
const SAME_VALUE: Limit = Limit::Within { reach: SAME };

/// Whether an entry was measured at the load and angle it is filed under; `own` is its own.
pub(super) fn of_filing(filing: &Filing, own: Cell) -> [Criterion<MemberCriterion>; 2] {
    let load_n = own.load_n.0 - filing.cell.load_n.0;
    let angle_deg = own.angle_deg.0 - filing.cell.angle_deg.0;
    [
        criterion(MemberCriterion::Load, load_n, SAME_VALUE),
        criterion(MemberCriterion::Angle, angle_deg, SAME_VALUE),
    ]
}

/// Whether a measurement can be combined with the first of a panel.
pub(super) fn against_first<I: Quantity, O: Quantity>(
    first: &TransferFunction<I, O>,
    other: &TransferFunction<I, O>,
) -> [Criterion<MemberCriterion>; 6] {
    let lines = other.response().len() as f64 - first.response().len() as f64;
    let spacing = other.resolution_hz() / first.resolution_hz() - 1.0;
    let rate = other.rate.hz() / first.rate.hz() - 1.0;
    // A measurement without a stated origin is compatible with any.
    let [one, two] = [first, other].map(|f| f.about.provenance.bench);
    let other_bench = one.zip(two).is_some_and(|(one, two)| one != two);
    let differs = |what, differs: bool| {
        let found = f64::from(u8::from(differs));
        criterion(what, found, Limit::at_most(0.0))
    };
    [
        criterion(MemberCriterion::LineSpacing, spacing, SAME_VALUE),
        criterion(
            MemberCriterion::LineCount,
            lines,
            Limit::Within { reach: 0.0 },
        ),
        criterion(MemberCriterion::Rate, rate, SAME_VALUE),
        differs(MemberCriterion::OtherDevice, first.drive != other.drive),
        differs(
            MemberCriterion::OtherEstimator,
            first.estimator != other.estimator,
        ),
        differs(MemberCriterion::OtherBench, other_bench),
    ]
}

/// The share of the band that was excited: not decided where a part was not.
pub(super) fn excited<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    band: Band,
) -> Criterion<MemberCriterion> {
    let missing = function.unexcited_share(band);
    let limit = Limit::AtLeast {
        met: 1.0,
        not_met: 0.0,
    };
    let mut found = criterion(MemberCriterion::Excited, 1.0 - missing, limit);
    if missing > 0.0 {
        found.outcome = Outcome::NotDecided;
    }
    found
}

/// The share of lines of the band with low coherence: not met from a tenth on.
pub(super) fn low_coherence<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    band: Band,
) -> Criterion<MemberCriterion> {
    let limit = Limit::AtMost {
        met: LOW_SHARE,
        not_met: 1.0,
    };
    let share = function.low_coherence_share(band, LOW_COHERENCE);
    criterion(MemberCriterion::LowCoherence, share, limit)
}

/// The share of the other measurements of a cell with the opposite sign: `against` of `of`.
pub(super) fn opposite(against: usize, of: usize) -> Criterion<MemberCriterion> {
    let limit = Limit::AtMost {
        met: OPPOSITE_SHARE,
        not_met: 1.0,
    };
    let share = against as f64 / of.max(1) as f64;
    criterion(MemberCriterion::OppositeSign, share, limit)
}

impl<I: Quantity, O: Quantity> Panel<I, O> {
    /// Every measurement with what makes it a member, over `band`, in the order they were given; `signs` are those over `band`.
    ///
    /// Formula: of measurement i, the share of the others j at its load and angle with Re Σ Hᵢ·conj(Hⱼ) < 0 over the lines of
    /// the band; the shares of the band's lines that were not excited, and whose coherence is below 0.8.
    pub(super) fn members(&self, signs: &[Sign<'_>], band: Band) -> Vec<Member> {
        let first = &self.entries()[0].function;
        let member = |entry: &Entry<I, O>| {
            let (filing, function) = (&entry.filing, &entry.function);
            let known = &function.about.condition;
            let own = known.load_n.zip(known.angle_deg);
            let own = own.map(|(load_n, angle_deg)| Cell { load_n, angle_deg });
            let filed = own.into_iter().flat_map(|own| of_filing(filing, own));
            let sign = signs.iter().find(|sign| sign.of.is(filing));
            let judged = [excited(function, band), low_coherence(function, band)];
            Member {
                filing: filing.clone(),
                criteria: filed
                    .chain(against_first(first, function))
                    .chain(sign.map(|sign| sign.criterion.clone()))
                    .chain(judged)
                    .collect(),
            }
        };
        self.entries().iter().map(member).collect()
    }

    /// Every participant with what decides whether all loads and angles can be compared over them.
    pub(super) fn attendances(&self) -> Vec<Completeness> {
        let all = Limit::at_least(self.cells().len() as f64);
        let what = ParticipantCriterion::CellsMeasured;
        let of = |who: &String| {
            let there = |cell: &&Cell| self.of(who, **cell).next().is_some();
            let measured = self.cells().iter().filter(there).count() as f64;
            Completeness {
                participant: who.clone(),
                criteria: vec![Criterion::new(what, "", measured, None, all)],
            }
        };
        self.participants().iter().map(of).collect()
    }
}
