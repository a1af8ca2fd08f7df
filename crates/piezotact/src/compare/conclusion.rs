//! What comparisons say, in words.

use super::trends::LEAST_CHANGE;
use super::{
    ActivePassive, CommonLine, Contacts, Contrast, ContrastTrend, ContrastUnit, FoundIn,
    FrictionChange, LevelSpread, LineOrigin, LinesOfSpeeds, LoadTrend, PeriodCriterion, PeriodUnit,
    SpatialPeriod, ValueDifference, unless_confounded,
};
use crate::criterion::Outcome;
use crate::number::{counted, digits, p_text, plus, signed};
use crate::statistics::{Direction, LogFit, RankCorrelation};

impl SpatialPeriod {
    /// What the spatial period is, in mm with its interval, or why it is not decided.
    #[must_use]
    pub fn conclusion(&self) -> String {
        let mm = |m: f64| m * 1e3;
        let over = match self.over {
            PeriodUnit::Groups => "loads",
            PeriodUnit::Recordings => "recordings",
            PeriodUnit::Harmonics => "harmonics",
        };
        let (everywhere, partly) = match self.found_in {
            FoundIn::Speeds => ("at all speeds", "at some speeds only"),
            FoundIn::Way => ("along the way", "in the slower or the faster strokes only"),
        };
        let interval = self.interval_m.map_or(String::new(), |[low, high]| {
            format!(
                " (95 %: {:.3} to {:.3} mm over {} {over})",
                mm(low),
                mm(high),
                self.units
            )
        });
        let part = if self.speeds_in_reach < self.speeds {
            format!(
                ", from {} of {} speeds: at the others its frequency is below what was analysed",
                self.speeds_in_reach, self.speeds
            )
        } else {
            String::new()
        };
        let number = format!("{:.3} mm{interval}{part}", mm(self.period_m));
        let groups: Vec<String> = self
            .groups
            .iter()
            .map(|group| {
                let own = group.period_m.filter(|_| !self.jumps());
                format!(
                    "{}: {:.3} mm",
                    group.group,
                    mm(own.unwrap_or(group.strongest_m))
                )
            })
            .collect();
        let groups = groups.join(", ");
        match self.outcome {
            Outcome::Met => {
                let groups = if groups.is_empty() {
                    groups
                } else {
                    format!("; {groups}")
                };
                let compared =
                    (self.criteria.iter()).any(|c| c.what == PeriodCriterion::OtherSamples);
                let whose = if compared {
                    ""
                } else {
                    "; one sample does not show whether it is of the surface, of the drive of the machine or of the finger"
                };
                format!("spatial period {number}{groups}{whose}")
            }
            Outcome::NotMet if self.lines.all_stay() => format!(
                "no spatial period: {} {everywhere}, as lines of a machine do",
                self.lines.fixed()
            ),
            _ if self.is_confounded_by(PeriodCriterion::Moves)
                && !self.lines.fixed_hz.is_empty() =>
            {
                format!(
                    "spatial period not decided: {} at other speeds too, as lines of a machine do; the candidate is {number}",
                    self.lines.fixed()
                )
            }
            _ if self.is_confounded_by(PeriodCriterion::Strongest)
                && (self.open_multiples_m.is_empty() || !self.lines.stronger_hz.is_empty()) =>
            {
                match self.lines.other_period_m {
                    Some(other_m) => format!(
                        "spatial period not decided: lines of {:.3} mm move with the speed too, so there are two periods, or both belong to a \
                     longer one; the candidate is {number}",
                        mm(other_m)
                    ),
                    None => format!(
                        "spatial period not decided: a line that is no multiple of it stands higher ({} Hz), so the speeds may be wrong or there \
                 are two periods; the candidate is {number}",
                        listed_hz(&self.lines.stronger_hz)
                    ),
                }
            }
            Outcome::NotDecided if self.is_shared() => format!(
                "spatial period not decided: all samples have that of {number}, so it may come from the drive of the machine or from the finger's \
                 ridges; record a smooth sample too, and the machine without contact"
            ),
            _ if self.jumps() => {
                format!("spatial period not decided: it differs between loads ({groups})")
            }
            Outcome::NotDecided if self.missed_at_a_speed() => format!(
                "spatial period not decided: its peak stands out of the noise {partly}, as a peak at a fixed frequency \
             does; the candidate is {number}"
            ),
            Outcome::NotDecided if self.may_be_a_harmonic() => {
                let multiples = self.open_multiples_m.iter();
                let multiples: Vec<String> =
                    multiples.map(|m| format!("{:.3} mm", mm(*m))).collect();
                format!(
                    "spatial period not decided: {} cannot be excluded, since that frequency is not analysed or stands out at one \
                 speed only; the candidate is {number}",
                    multiples.join(" and ")
                )
            }
            _ if self.is_confounded_by(PeriodCriterion::Moves) && self.lines.moving_speeds > 0 => {
                let of = match self.lines.telling_speeds {
                    1 => String::new(),
                    all => format!(" of {all}"),
                };
                format!(
                    "spatial period not decided: its lines are known to move at one speed{of} only; record at more speeds, of which none is a \
                     multiple of another; the candidate is {number}"
                )
            }
            _ if self.is_confounded_by(PeriodCriterion::Moves) => format!(
                "spatial period not decided: its lines cannot be distinguished from lines at fixed frequencies; record at speeds that \
                 differ more; the candidate is {number}"
            ),
            Outcome::NotDecided if self.late_s.is_some() => format!(
                "spatial period not decided: its line is clearer were the motion recorded {} ms {} than the vibration; align them; the \
                 candidate is {number}",
                digits(1e3 * self.late_s.unwrap_or(0.0).abs()),
                if self.late_s > Some(0.0) {
                    "later"
                } else {
                    "earlier"
                }
            ),
            Outcome::NotDecided if self.is_imprecise() => format!(
                "spatial period not decided: its interval reaches further than 2 %; record the surface again, or longer strokes; the \
                 candidate is {number}"
            ),
            Outcome::NotDecided => format!(
                "spatial period not decided: the shortest stroke covers fewer than 3 periods; the candidate is {number}"
            ),
            Outcome::NotMet => format!(
                "no spatial period stands out {everywhere}; the strongest candidate is {number}"
            ),
        }
    }
}

impl LinesOfSpeeds {
    /// How likely lines that move and lines that stay are, as logarithms.
    #[must_use]
    pub fn likelihoods(&self) -> String {
        format!(
            "log likelihood {} for lines that move with the speed, {} for lines that stay",
            signed(self.moving_log_likelihood, 1),
            signed(self.fixed_log_likelihood, 1)
        )
    }

    fn fixed(&self) -> String {
        match self.fixed_hz.as_slice() {
            [only] => format!("a line at {} Hz stays at its frequency", digits(*only)),
            all => format!("lines at {} Hz stay at their frequencies", listed_hz(all)),
        }
    }
}

pub(super) fn listed_hz(lines_hz: &[f64]) -> String {
    let lines: Vec<String> = lines_hz.iter().map(|hz| digits(*hz)).collect();
    lines.join(", ")
}

impl CommonLine {
    /// Whose a line is that every sample has.
    #[must_use]
    pub fn conclusion(&self) -> String {
        let where_found = format!(
            "{} Hz: in all {} recordings of {} samples",
            digits(self.frequency_hz),
            self.recordings,
            self.samples
        );
        let speeds = self.speed_ratio.map_or(String::new(), |ratio| {
            format!(" at speeds that differ by a factor of up to {ratio:.1}")
        });
        match self.origin {
            LineOrigin::Mains => {
                format!("{where_found}{speeds}: mains hum, not due to a texture or the finger")
            }
            LineOrigin::Machine => {
                format!("{where_found}{speeds}: due to the machine, not to a texture or the finger")
            }
            LineOrigin::Resonance => format!(
                "{where_found}{speeds}: a resonance of the machine, of the mount of the sensor, or of the finger; no period of a texture"
            ),
            LineOrigin::NotDecided => format!(
                "{where_found}: due to the machine, to the finger, or to a period that all samples have; record at another speed to decide: \
             what is due to the machine does not move with the speed"
            ),
        }
    }
}

impl LevelSpread {
    /// How far participants differ, dB, with what their number leaves open.
    #[must_use]
    pub fn conclusion(&self) -> String {
        match self.sd_interval_db {
            Some([low, high]) => format!(
                "standard deviation of the level between {} participants: {:.1} dB (95 %: {low:.1} to {high:.1} dB in their \
             population)",
                self.participants, self.level_db.sd
            ),
            None => "one participant: the variability between participants is not decided".into(),
        }
    }
}

impl ActivePassive {
    /// What active and passive touch say of each sample.
    #[must_use]
    pub fn of_samples(&self) -> Vec<String> {
        let sentences = self.pairs.iter().map(|pair| {
            format!(
                "{}: active and passive PSDs differ by {} dB rms, level by {}",
                pair.sample,
                pair.difference_db_rms
                    .map_or("?".into(), |db| format!("{db:.1}")),
                pair.level_difference_db
                    .map_or("more than can be measured".into(), |db| format!(
                        "{} dB",
                        plus(db, 1)
                    ))
            )
        });
        sentences.collect()
    }

    /// What active and passive touch say over all samples.
    #[must_use]
    pub fn conclusions(&self) -> Vec<String> {
        let level = self.level.as_ref();
        let level = level.map(|l| {
            let said = l.conclusion_on_levels(["active", "passive touch"], "samples");
            unless_confounded(&self.confounders, said)
        });
        let ranks = self.rms_rank_correlation.as_ref();
        let ranks = ranks.map(|r| r.conclusion("active rms", "passive rms", "samples"));
        let few = (self.pairs.len() == 1)
            .then(|| "active and passive touch: not decided from 1 sample".to_owned());
        level.into_iter().chain(ranks).chain(few).collect()
    }
}

impl FrictionChange {
    /// What the rank correlation `ranks` of the friction coefficient and `x` over samples says, with the size of the change.
    #[must_use]
    pub fn conclusion(&self, ranks: &RankCorrelation, x: &str) -> String {
        let said = ranks.conclusion("friction", x, "samples");
        let size = format!(
            "from the lowest to the highest {x} it changes by {} %",
            plus(
                100.0 * self.share,
                if self.share.abs() < 0.01 { 2 } else { 1 }
            )
        );
        if ranks.direction() == Direction::NotShown {
            return format!("{said}; {size}");
        }
        if !self.agrees_with(ranks) {
            return format!(
                "friction and {x}: not decided: ranks {} (rank correlation {}, {} over {} samples), but {size}",
                if ranks.rho > 0.0 { "rise" } else { "fall" },
                signed(ranks.rho, 2),
                p_text(ranks.p_value),
                ranks.pairs
            );
        }
        if self.matters() {
            return format!("{said}; {size}");
        }
        format!(
            "friction and {x}: no change that matters: {size}, less than {:.1} %, {} (rank correlation {}, {} over {} samples)",
            100.0 * self.least_share(),
            if self.least_share() > LEAST_CHANGE {
                "the scatter of strokes"
            } else {
                "the least change that counts"
            },
            signed(ranks.rho, 2),
            p_text(ranks.p_value),
            ranks.pairs
        )
    }
}

/// What a power law of the friction coefficient on `x` says over `units`, where it changes by as much as counts.
///
/// Source: docs/decisions/strokes.md.
#[must_use]
pub fn friction_conclusion(
    fit: &LogFit,
    change: Option<FrictionChange>,
    [x, units]: [&str; 2],
) -> String {
    match change.filter(|change| !change.matters()) {
        Some(change) if fit.direction() != Direction::NotShown => format!(
            "friction coefficient and {x}: no change that matters: {} % over {} {units}, less than {:.1} %",
            plus(100.0 * change.share, 2),
            fit.points,
            100.0 * change.least_share()
        ),
        _ => fit.conclusion("friction coefficient", x, units),
    }
}

impl LoadTrend {
    /// What changes with the load, line by line.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let rms = self.rms_on_load.as_ref();
        let rms = rms.map(|fit| fit.conclusion("rms", "load", "loads"));
        let friction = self.friction_on_load.as_ref();
        let friction =
            friction.map(|fit| friction_conclusion(fit, self.friction_change, ["load", "loads"]));
        rms.into_iter().chain(friction).collect()
    }
}

impl ContrastTrend {
    /// How each differs from the first in level, and how much of it stuck and slipped.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let first = self.values.first().map_or("", |one| one.value.as_str());
        let line = |one: &ValueDifference| {
            let Contacts { all, stick_slip } = one.contacts;
            let level = one.level_difference_db.map_or(String::new(), |db| {
                format!("level {} dB re {first}, ", plus(db, 1))
            });
            let contacts = counted(all, "stroke");
            format!(
                "{}: {level}stick-slip in {stick_slip} of {contacts}",
                one.value
            )
        };
        self.values.iter().map(line).collect()
    }
}

impl Contrast {
    /// Whether the levels of two values differ, over settings or participants; one setting or two participants decide nothing.
    #[must_use]
    pub fn conclusion(&self) -> String {
        let between = [self.value.as_str(), self.reference.as_str()];
        let units = match self.over {
            ContrastUnit::Settings => "setting",
            ContrastUnit::Participants => "participant",
        };
        match &self.level {
            Some(level) => {
                let said = level.conclusion_on_levels(between, &format!("{units}s"));
                unless_confounded(&self.confounders, said)
            }
            None => format!(
                "{} and {}: the difference in level is not decided from {}",
                self.value,
                self.reference,
                counted(self.units, units)
            ),
        }
    }
}
