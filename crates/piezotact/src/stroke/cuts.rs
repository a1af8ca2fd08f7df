//! Manual cuts: strokes that a person adds, changes or excludes after the automatic segmentation.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::criteria::{JudgedPart, StrokeCriterion};
use super::{CutBy, Interval, Reason, Rejected, Rule, Segmentation, Stroke};
use crate::criterion::Limit;
use crate::quantity::{SampleRate, Seconds};

/// One decision of a person about a part of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "act", rename_all = "snake_case")]
pub enum Cut {
    /// A stroke from `from_s` to `to_s`; it replaces the result of the rule there.
    Stroke {
        /// Where it begins.
        from_s: Seconds,
        /// Where it ends.
        to_s: Seconds,
    },
    /// No stroke touches `from_s` to `to_s`.
    LeaveOut {
        /// Where it begins.
        from_s: Seconds,
        /// Where it ends.
        to_s: Seconds,
        /// Why.
        note: String,
    },
}

/// A person's decisions about one recording, and where they are written.
#[derive(Clone, Debug, PartialEq)]
pub struct Cuts {
    /// The file, for the result to cite.
    pub source: String,
    /// The decisions, in their order.
    pub cuts: Vec<Cut>,
}

impl Cuts {
    /// `segmentation` of a recording of `samples` samples at `rate` with the manual cuts applied: manual strokes
    /// replace the result of the rule at the same place, excluded parts are rejected with the person's note, and
    /// the file is cited. Cuts outside the recording are not applied and are returned.
    #[must_use]
    pub fn apply(
        &self,
        mut segmentation: Segmentation,
        samples: usize,
        rate: SampleRate,
    ) -> (Segmentation, Vec<Cut>) {
        let mut outside = Vec::new();
        for cut in &self.cuts {
            let (Cut::Stroke { from_s, to_s } | Cut::LeaveOut { from_s, to_s, .. }) = cut;
            let interval = Interval {
                start: rate.samples_in(*from_s),
                end: rate.samples_in(*to_s).min(samples),
            };
            // An exclusion may extend beyond the recording; a stroke may not.
            let beyond = rate.samples_in(*to_s) > samples + rate.samples_in(Seconds(0.01));
            if interval.is_empty() || (beyond && matches!(cut, Cut::Stroke { .. })) {
                outside.push(cut.clone());
                continue;
            }
            let meets = |other: Interval| other.start < interval.end && interval.start < other.end;
            match cut {
                Cut::Stroke { .. } => {
                    segmentation.strokes.retain(|s| !meets(s.steady));
                    segmentation.rejected.retain(|r| !meets(r.interval));
                    segmentation.strokes.push(Stroke {
                        steady: interval,
                        contact: interval,
                        cut_by: CutBy::Person,
                        criteria: Vec::new(),
                    });
                }
                Cut::LeaveOut { note, .. } => {
                    let (out, kept) = segmentation
                        .strokes
                        .into_iter()
                        .partition(|s| meets(s.steady));
                    segmentation.strokes = kept;
                    segmentation
                        .rejected
                        .extend(out.into_iter().map(|stroke: Stroke| {
                            JudgedPart::of(&stroke).not_met(
                                StrokeCriterion::LeftOut,
                                1.0,
                                Limit::at_most(0.0),
                                (stroke.contact, Reason::ByPerson { note: note.clone() }),
                            )
                        }));
                }
            }
        }
        segmentation.strokes.sort_by_key(|s| s.steady.start);
        segmentation.rejected.sort_by_key(|r| r.interval.start);
        segmentation.cuts = Some(self.source.clone());
        (segmentation, outside)
    }
}

impl Segmentation {
    /// The same with the strokes rejected that are not `within` one of these ranges of samples, where the motion of another device was
    /// measured.
    ///
    /// Source: house rule; see [`crate::roles::Roles::on_one_clock`].
    #[must_use]
    pub fn within(mut self, within: &[Range<usize>]) -> Self {
        if !matches!(self.rule, Rule::Force(_) | Rule::Speed(_)) {
            return self;
        }
        let is_within = |stroke: &Stroke| {
            let Interval { start, end } = stroke.steady;
            within
                .iter()
                .any(|one| one.start <= start && end <= one.end)
        };
        let (strokes, outside): (Vec<Stroke>, Vec<Stroke>) =
            self.strokes.into_iter().partition(is_within);
        self.strokes = strokes;
        self.rejected
            .extend(outside.into_iter().map(|stroke| Rejected {
                interval: stroke.contact,
                reason: Reason::CutByRecording,
                criteria: stroke.criteria,
            }));
        self.rejected.sort_by_key(|one| one.interval.start);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roles::Roles;
    use crate::stroke::{Rejected, Rule};

    #[test]
    fn a_person_has_the_last_word() {
        let rate = SampleRate::new(100.0).unwrap();
        let stroke = |start, end| Stroke {
            steady: Interval { start, end },
            contact: Interval { start, end },
            cut_by: CutBy::Rule,
            criteria: Vec::new(),
        };
        let found = Segmentation {
            strokes: vec![stroke(100, 200), stroke(300, 400)],
            rejected: vec![Rejected {
                interval: Interval {
                    start: 500,
                    end: 600,
                },
                reason: Reason::NoSliding,
                criteria: Vec::new(),
            }],
            rule: Rule::Whole,
            roles: Roles::default(),
            force_zeros: None,
            cuts: None,
            untouched: None,
            warnings: Vec::new(),
        };
        let cut = |from: f64, to: f64| Cut::Stroke {
            from_s: Seconds(from),
            to_s: Seconds(to),
        };
        let cuts = Cuts {
            source: "cuts.txt".into(),
            cuts: vec![
                Cut::LeaveOut {
                    from_s: Seconds(1.5),
                    to_s: Seconds(1.6),
                    note: "sneeze".into(),
                },
                cut(5.1, 5.9),
                cut(3.0, 3.5),
                cut(9.5, 10.5),
            ],
        };
        let (result, outside) = cuts.apply(found, 1000, rate);
        let ranges: Vec<(usize, usize)> = result
            .strokes
            .iter()
            .map(|s| (s.steady.start, s.steady.end))
            .collect();
        assert_eq!(ranges, [(300, 350), (510, 590)]);
        assert!(result.strokes.iter().all(|s| s.cut_by == CutBy::Person));
        assert_eq!(result.rejected.len(), 1);
        assert_eq!(
            result.rejected[0].reason.to_string(),
            "excluded by hand: sneeze"
        );
        assert_eq!(result.cuts.as_deref(), Some("cuts.txt"));
        assert_eq!(outside, [cut(9.5, 10.5)]);
    }
}
