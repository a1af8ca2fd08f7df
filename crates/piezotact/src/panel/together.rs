//! Checks whether transfer functions can be combined in a panel: errors that refuse it, and warnings.

use std::collections::BTreeMap;

use super::membership::{self, LOW_COHERENCE, MemberCriterion};
use super::same_person;
use super::{Cell, Entry, Filing, Panel, PanelError};
use crate::criterion::{Criterion, Outcome};
use crate::device::DriveSetup;
use crate::quantity::{Band, Quantity};
use crate::recording::{BenchKind, OtherOrigin, RecordingWarning, ReversedSign};
use crate::transfer::TransferFunction;
use crate::warning::{Example, Warning};

/// The largest plausible load of a finger, N.
const HEAVIEST_N: f64 = 100.0;

impl Filing {
    /// Refuses a filing that no measurement can have.
    ///
    /// # Errors
    /// [`PanelError::Impossible`] for a name that is empty or has control characters or path separators, a load that is
    /// no number, not above 0 or above 100 N, an angle outside 0–90°, or a placement or repeat of 0.
    pub fn checked(&self) -> Result<(), PanelError> {
        let wrong = |what, expected, found: String| {
            Err(PanelError::Impossible {
                filing: self.clone(),
                what,
                expected,
                found,
            })
        };
        let who = &self.participant;
        if who.trim().is_empty() || who.chars().any(|c| c.is_control() || "/\\".contains(c)) {
            return wrong(
                "participant",
                "a name without control characters and path separators",
                format!("{who:?}"),
            );
        }
        let (load, angle) = (self.cell.load_n.0, self.cell.angle_deg.0);
        if !(load > 0.0 && load <= HEAVIEST_N) {
            return wrong("load", "a number above 0 and up to 100 N", load.to_string());
        }
        if !(0.0..=90.0).contains(&angle) {
            return wrong("angle", "a number from 0 to 90°", angle.to_string());
        }
        for (what, found) in [("placement", self.placement), ("repeat", self.repeat)] {
            if found == 0 {
                return wrong(what, "a number from 1", "0".into());
            }
        }
        Ok(())
    }
}

/// Refuses an entry whose own condition is not what it is filed under.
pub(super) fn belongs<I: Quantity, O: Quantity>(entry: &Entry<I, O>) -> Result<(), PanelError> {
    let filing = &entry.filing;
    filing.checked()?;
    let known = &entry.function.about.condition;
    let lacks = |what| PanelError::Unknown {
        filing: filing.clone(),
        what,
    };
    let participant = known
        .participant
        .as_ref()
        .ok_or_else(|| lacks("participant"))?;
    let load_n = known.load_n.ok_or_else(|| lacks("load"))?;
    let angle_deg = known.angle_deg.ok_or_else(|| lacks("angle"))?;
    if *participant != filing.participant {
        return Err(PanelError::Mixed {
            filing: filing.clone(),
            found: participant.clone(),
        });
    }
    let own = Cell { load_n, angle_deg };
    let met = |criterion: &Criterion<MemberCriterion>| criterion.outcome == Outcome::Met;
    if !membership::of_filing(filing, own).iter().all(met) {
        return Err(PanelError::Misfiled {
            filing: filing.clone(),
            found: own.to_string(),
        });
    }
    Ok(())
}

/// Refuses an entry that cannot be combined with the first, and says where it is one of the earlier ones on other lines.
pub(super) fn fits<I: Quantity, O: Quantity>(
    first: &Entry<I, O>,
    entry: &Entry<I, O>,
    earlier: &[Entry<I, O>],
) -> Result<(), PanelError> {
    let (one, other) = (&first.function, &entry.function);
    let differ = |what, one: String, other: String| PanelError::Differ {
        what,
        one: first.filing.to_string(),
        one_has: one,
        other: entry.filing.to_string(),
        other_has: other,
    };
    let lines = |f: &TransferFunction<I, O>| {
        format!(
            "{} lines every {:.4} Hz",
            f.response().len(),
            f.resolution_hz()
        )
    };
    let criteria = membership::against_first(one, other);
    let Some(found) = criteria.iter().find(|c| c.outcome != Outcome::Met) else {
        return Ok(());
    };
    let name = |f: &TransferFunction<I, O>| f.estimator.to_string();
    let bench =
        |f: &TransferFunction<I, O>| f.about.provenance.bench.map_or_else(String::new, kind);
    Err(match found.what {
        MemberCriterion::Rate => differ("rate", one.rate.to_string(), other.rate.to_string()),
        MemberCriterion::OtherDevice => differ("device", device(&one.drive), device(&other.drive)),
        MemberCriterion::OtherEstimator => differ("estimator", name(one), name(other)),
        MemberCriterion::OtherBench => differ("bench", bench(one), bench(other)),
        MemberCriterion::LineSpacing | MemberCriterion::LineCount => {
            let is_of = |known: &&Entry<I, O>| {
                known.filing.participant != entry.filing.participant
                    && same_person::is_resampled(&known.function, other)
            };
            match earlier.iter().find(is_of) {
                Some(known) => PanelError::Resampled {
                    one: known.filing.to_string(),
                    other: entry.filing.to_string(),
                },
                None => differ("lines", lines(one), lines(other)),
            }
        }
        _ => differ("lines", lines(one), lines(other)),
    })
}

fn kind(bench: BenchKind) -> String {
    match bench {
        BenchKind::Twin => "the digital twin".into(),
        BenchKind::Hardware => "real devices".into(),
        BenchKind::Measured => "a measured transfer function, with no finger".into(),
        BenchKind::Scripted => "a scripted fake, with no device and no finger".into(),
    }
}

fn device(setup: &Option<DriveSetup>) -> String {
    setup.as_ref().map_or_else(
        || "a device that is not described".into(),
        |setup| {
            format!(
                "{}, {:.4} V at full scale, {}",
                setup.amplification(),
                setup.volts_per_full_scale,
                setup.load()
            )
        },
    )
}

/// Refuses two entries with bit-identical responses: two measurements never have the same noise.
pub(super) fn distinct<I: Quantity, O: Quantity>(
    entries: &[Entry<I, O>],
) -> Result<(), PanelError> {
    let bits = |entry: &Entry<I, O>| -> Vec<u64> {
        let lines = entry.function.response().iter();
        lines
            .flat_map(|h| [h.re.to_bits(), h.im.to_bits()])
            .collect()
    };
    let mut seen = BTreeMap::new();
    for entry in entries {
        if let Some(one) = seen.insert(bits(entry), &entry.filing) {
            return Err(PanelError::Same {
                one: one.to_string(),
                other: entry.filing.to_string(),
            });
        }
    }
    Ok(())
}

/// Refuses two people under one name: P02 of the twin of one seed and P02 of that of another.
pub(super) fn require_distinct_people<I: Quantity, O: Quantity>(
    entries: &[Entry<I, O>],
) -> Result<(), PanelError> {
    let mut people: BTreeMap<&str, (&Entry<I, O>, Option<String>)> = BTreeMap::new();
    for entry in entries {
        let is = entry.function.about.condition.person();
        let name = entry.filing.participant.as_str();
        let (one, one_is) = people.entry(name).or_insert_with(|| (entry, is.clone()));
        if *one_is != is {
            return Err(PanelError::TwoPeople {
                one: Box::new(one.filing.clone()),
                one_is: one_is.clone().unwrap_or_default(),
                other: Box::new(entry.filing.clone()),
                other_is: is.unwrap_or_default(),
            });
        }
    }
    Ok(())
}

/// A measurement, and the others in its cell whose sign is opposite.
pub(super) struct Sign<'a> {
    pub(super) of: &'a Filing,
    pub(super) criterion: Criterion<MemberCriterion>,
    against: Vec<&'a Filing>,
    /// How many others there are.
    others: usize,
}

impl Sign<'_> {
    /// Whether most others have the opposite sign.
    pub(super) fn is_opposite(&self) -> bool {
        self.criterion.outcome != Outcome::Met
    }

    /// The warning about it; `None` where no other has the opposite sign.
    pub(super) fn warning(&self) -> Option<Warning> {
        let first = self.against.first()?;
        let opposite = RecordingWarning::Sign {
            of: ReversedSign::Member {
                measurement: self.of.to_string(),
                count: self.against.len(),
                of_others: self.others,
                such_as: Example::from(first.to_string()),
            },
        };
        Some(opposite.into())
    }
}

/// A criterion of a measurement, and how much of the band does not meet it, with its warning.
type Check<'a, I, O> = (
    &'a dyn Fn(&TransferFunction<I, O>) -> Criterion<MemberCriterion>,
    &'a dyn Fn(&TransferFunction<I, O>) -> (f64, Option<Warning>),
);

impl<I: Quantity, O: Quantity> Panel<I, O> {
    /// The warning about twins of different seeds: other people, under the same names.
    pub(super) fn of_several_twins(&self) -> Option<Warning> {
        let mut twins = self.entries.iter().filter_map(|entry| {
            let provenance = &entry.function.about.provenance;
            let seed = (provenance.bench == Some(BenchKind::Twin)).then_some(provenance.seed)?;
            Some((&entry.filing, seed?))
        });
        let (one, one_seed) = twins.next()?;
        let (other, other_seed) = twins.find(|(_, seed)| *seed != one_seed)?;
        Some(Warning::from(RecordingWarning::OtherOrigin {
            what: OtherOrigin::Twins {
                one: one.to_string(),
                one_seed: one_seed.to_string(),
                other: other.to_string(),
                other_seed: other_seed.to_string(),
            },
        }))
    }

    /// For every measurement, the number of others in its cell with the opposite sign over `band`, by cell.
    ///
    /// Formula: Re Σ Hᵢ·conj(Hⱼ) < 0 over the lines of the band.
    pub(super) fn signs(&self, band: Band) -> Vec<Sign<'_>> {
        let mut signs = Vec::new();
        for cell in &self.cells {
            let inside: Vec<&Entry<I, O>> = self
                .entries
                .iter()
                .filter(|e| e.filing.cell.is(*cell))
                .collect();
            let others = inside.len().saturating_sub(1);
            for entry in &inside {
                let opposite = |other: &&&Entry<I, O>| {
                    !std::ptr::eq(**other, *entry)
                        && shared_power(&entry.function, &other.function, band) < 0.0
                };
                let against: Vec<&Filing> = inside
                    .iter()
                    .filter(opposite)
                    .map(|other| &other.filing)
                    .collect();
                signs.push(Sign {
                    of: &entry.filing,
                    criterion: membership::opposite(against.len(), others),
                    against,
                    others,
                });
            }
        }
        signs
    }

    /// The warnings about parts of `band` that were not excited or have low coherence: the worst case, with the number of
    /// measurements concerned, in one cell or in all.
    pub(super) fn unsound(&self, band: Band, cell: Option<Cell>) -> Vec<Warning> {
        let inside = self
            .entries
            .iter()
            .filter(|e| cell.is_none_or(|cell| e.filing.cell.is(cell)));
        let checks: [Check<'_, I, O>; 2] = [
            (&|of| membership::excited(of, band), &|of| {
                (of.unexcited_share(band), of.not_excited(band))
            }),
            (&|of| membership::low_coherence(of, band), &|of| {
                let share = of.low_coherence_share(band, LOW_COHERENCE);
                (share, of.low_coherence(band, LOW_COHERENCE))
            }),
        ];
        let mut warnings = Vec::new();
        for (judge, warn) in checks {
            let each = inside.clone().map(|e| {
                let (share, warning) = warn(&e.function);
                let raised = judge(&e.function).outcome != Outcome::Met;
                (e.filing.to_string(), share, warning.filter(|_| raised))
            });
            let all: Vec<(String, f64, Option<Warning>)> = each.collect();
            let worst = all.iter().filter(|(.., raised)| raised.is_some());
            let worst = worst.max_by(|a, b| a.1.total_cmp(&b.1));
            warnings.extend(worst.and_then(|(.., raised)| raised.clone()));
            warnings.extend(super::average::of_members(
                all.iter()
                    .map(|(name, _, raised)| (name.clone(), raised.as_slice())),
            ));
        }
        warnings
    }
}

fn shared_power<I: Quantity, O: Quantity>(
    one: &TransferFunction<I, O>,
    other: &TransferFunction<I, O>,
    band: Band,
) -> f64 {
    one.lines_in(band)
        .map(|(line, _)| (one.response()[line] * other.response()[line].conj()).re)
        .sum()
}
