//! A candidate for a spatial period against its criteria.

use super::moving::{LinesOfSpeeds, moving_peak};
use super::spectra::Spectrum;
use super::{
    Agreed, CYCLES, FoundIn, GroupPeriod, HIGHEST_OF_MANY, LEAST_WAY_REACH, MOST_WAY_REACH,
    MULTIPLES, PeriodCriterion, PeriodUnit, SpatialPeriod, SpeedPeak, is_excluded,
    lines_of_most_speeds, noise_db, reaching, weighted,
};
use crate::compare::CompareWarning;
use crate::criterion::{Criterion, Limit, Outcome};
use crate::warning::{Few, FewWarning, Warning};

/// What was found of a wavenumber on which spectra agree.
pub(super) struct Candidate<'a> {
    pub(super) found_in: FoundIn,
    pub(super) all: &'a [Spectrum],
    pub(super) agreed: Agreed,
    pub(super) lines: LinesOfSpeeds,
    pub(super) groups: Vec<GroupPeriod>,
    pub(super) over: PeriodUnit,
    /// The logarithm of the period in m of every unit, with its weight.
    pub(super) units: Vec<(f64, f64)>,
}

impl Candidate<'_> {
    /// The period with its interval and criteria; none where no unit shows it.
    pub(super) fn judged(self) -> Option<SpatialPeriod> {
        let Self {
            found_in,
            all,
            agreed,
            lines,
            groups,
            over,
            units,
        } = self;
        if units.is_empty() {
            return None;
        }
        let (wavenumber, prominence_db) = (agreed.wavenumber, agreed.prominence_db);
        let spectra = reaching(all, wavenumber);
        let peaks: Vec<SpeedPeak> = (spectra.iter())
            .filter_map(|own| moving_peak(all, own, wavenumber))
            .collect();
        let (log, mut interval) = weighted(&units);
        if found_in == FoundIn::Way {
            interval = interval.map(|[low, high]| [low - LEAST_WAY_REACH, high + LEAST_WAY_REACH]);
        }
        let period_m = log.exp();
        let interval_m = interval.map(|interval| interval.map(f64::exp));
        let shortest_m = spectra.iter().map(|s| s.length_m).fold(f64::MAX, f64::min);
        let mut criteria = vec![
            Criterion::new(
                PeriodCriterion::Prominence,
                "dB",
                prominence_db,
                None,
                Limit::at_least(noise_db(HIGHEST_OF_MANY, &spectra)),
            ),
            Criterion::new(
                PeriodCriterion::Speeds,
                "",
                peaks.len() as f64 / spectra.len() as f64,
                None,
                Limit::at_least(1.0),
            ),
            Criterion::new(
                PeriodCriterion::Cycles,
                "",
                shortest_m / period_m,
                None,
                Limit::AtLeast {
                    met: CYCLES,
                    not_met: 0.0,
                },
            ),
        ];
        let weakest = spectra
            .iter()
            .map(|s| s.found_and_needed_db(wavenumber))
            .min_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)));
        if let Some((found_db, needed_db)) = weakest {
            criteria.push(Criterion::new(
                PeriodCriterion::EverySpeed,
                "dB",
                found_db,
                None,
                Limit::AtLeast {
                    met: needed_db,
                    not_met: f64::MIN,
                },
            ));
        }
        criteria.extend(lines.criteria());
        if found_in == FoundIn::Way {
            let reach = interval.map_or(f64::MAX, |[low, high]| 0.5 * (high - low));
            let limit = Limit::AtMost {
                met: MOST_WAY_REACH,
                not_met: f64::INFINITY,
            };
            criteria.push(Criterion::new(
                PeriodCriterion::Reach,
                "",
                reach,
                None,
                limit,
            ));
        }
        let open: Vec<f64> = (2..=MULTIPLES)
            .filter(|m| !is_excluded(all, wavenumber, *m))
            .map(|m| m as f64 * period_m)
            .collect();
        criteria.push(Criterion::new(
            PeriodCriterion::Multiples,
            "",
            (MULTIPLES - 1 - open.len()) as f64,
            None,
            Limit::AtLeast {
                met: (MULTIPLES - 1) as f64,
                not_met: f64::MIN,
            },
        ));
        let missing = |group: &&GroupPeriod| group.needed_db - group.prominence_db;
        let least = groups
            .iter()
            .max_by(|a, b| missing(a).total_cmp(&missing(b)));
        if let Some(least) = least {
            // A group that does not show it leaves it open.
            let limit = Limit::AtLeast {
                met: least.needed_db,
                not_met: f64::MIN,
            };
            let found = least.prominence_db;
            criteria.push(Criterion::new(
                PeriodCriterion::EveryGroup,
                "dB",
                found,
                None,
                limit,
            ));
        }
        let mut found = SpatialPeriod {
            found_in,
            late_s: None,
            period_m,
            outcome: Outcome::of_all(criteria.iter().map(|criterion| criterion.outcome)),
            interval_m,
            over,
            units: units.len(),
            peaks,
            prominence_db,
            speeds_in_reach: spectra.len(),
            speeds: all.len(),
            open_multiples_m: open,
            groups,
            lines,
            criteria,
            lines_1_m: lines_of_most_speeds(all),
            warnings: Vec::new(),
        };
        if !found.stands_out() {
            found
                .warnings
                .push(Warning::from(CompareWarning::NoCommonPeriod {
                    prominence_db,
                }));
        } else if let Some(multiple_m) = found
            .open_multiples_m
            .last()
            .filter(|_| !found.lines.all_stay())
        {
            let fastest_m_s = all.iter().map(|s| s.speed_m_s).fold(0.0, f64::max);
            found
                .warnings
                .push(Warning::from(CompareWarning::OpenMultiple {
                    period_m,
                    multiple_m: *multiple_m,
                    needed_hz: fastest_m_s / multiple_m,
                }));
        }
        if interval_m.is_none() {
            found.warnings.push(Warning::from(FewWarning::Few {
                found: units.len(),
                recommended: 3,
                what: Few::Groups {
                    result: "the spatial period".into(),
                },
            }));
        }
        Some(found)
    }
}
