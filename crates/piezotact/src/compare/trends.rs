//! Effects of the sample, the speed, the participant and the kind of touch.

use serde::Serialize;

use super::{Confounder, Summary, confounders, difference_db_rms};
use crate::feature::Statistics;
use crate::quantity::Band;
use crate::statistics::{
    LogFit, PairedDifference, RankCorrelation, deviation_interval, log_fit, median,
    paired_difference, rank_correlation,
};

/// How vibration and friction follow the roughness of the samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RoughnessTrend {
    /// The samples whose roughness is known, in order.
    pub samples: Vec<String>,
    /// Their Ra, m.
    pub ra_m: Vec<f64>,
    /// The line of log rms on log Ra.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_on_ra: Option<LogFit>,
    /// The rank correlation of Ra and rms over samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_rank_correlation: Option<RankCorrelation>,
    /// The rank correlation of Ra and friction coefficient over samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_rank_correlation: Option<RankCorrelation>,
    /// By how much friction changes with Ra.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_change: Option<FrictionChange>,
}

/// A power law needs values of what it is on whose ratio is more than this.
const LEAST_SPAN: f64 = 1.2;
/// A change of the friction coefficient that counts is at least this share of it.
pub(super) const LEAST_CHANGE: f64 = 0.01;
/// A sensor and a contact drift by so much from the first to the last recording, dB: it may look like an effect of what was changed between.
const DRIFT_DB: f64 = 0.5;

/// By how much the friction coefficient changes with something: ranks say nothing of that.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FrictionChange {
    /// The change from the lowest to the highest value of what it follows, as a share of the friction at the lowest.
    pub share: f64,
    /// The standard deviation of the friction coefficient over strokes of one sample, as a share: the median over samples.
    pub scatter_share: f64,
}

impl FrictionChange {
    /// The smallest change that counts, as a share: 1 %, or the scatter of strokes.
    #[must_use]
    pub fn least_share(&self) -> f64 {
        LEAST_CHANGE.max(self.scatter_share)
    }

    /// Whether the change has the sign of the rank correlation: a few samples far from the others turn a slope, and no ranks.
    #[must_use]
    pub fn agrees_with(&self, ranks: &RankCorrelation) -> bool {
        self.share * ranks.rho > 0.0
    }

    /// Whether the change is as large as one that counts.
    #[must_use]
    pub fn matters(&self) -> bool {
        self.share.abs() >= self.least_share()
    }
}

/// By how much the friction coefficient of samples changes with `x`, each pair the x of a sample and its friction over strokes; `None` for
/// fewer than three samples, and where x or friction is not above zero.
///
/// Formula: the power law μ = a·xᵇ by least squares in logarithms ([`log_fit`]); (largest x / least x)ᵇ − 1.
///
/// Source: docs/decisions/strokes.md.
#[must_use]
pub fn friction_change(pairs: &[(f64, Statistics)]) -> Option<FrictionChange> {
    let (x, friction): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(x, s)| (*x, s.mean)).unzip();
    let fit = log_fit(&x, &friction).filter(|fit| fit.points > 2)?;
    let mut scatter: Vec<f64> = pairs.iter().map(|(_, s)| s.sd / s.mean).collect();
    Some(FrictionChange {
        share: ratio(&x).powf(fit.slope) - 1.0,
        scatter_share: median(&mut scatter)?,
    })
}

/// How rms and friction follow `ra`: the Ra in m of each of `samples`, where it is known.
///
/// Formula: [`log_fit`] and [`rank_correlation`] over sample means: intervals and p are over samples.
///
/// Source: L. Felicetti's thesis (2024), figures 33 and 34.
#[must_use]
pub fn across_roughness(samples: &[&Summary], ra: impl Fn(&str) -> Option<f64>) -> RoughnessTrend {
    let known: Vec<(&Summary, f64)> = samples
        .iter()
        .filter_map(|sample| Some((*sample, ra(&sample.name)?)))
        .collect();
    let ra_m: Vec<f64> = known.iter().map(|(_, ra_m)| *ra_m).collect();
    let samples: Vec<&Summary> = known.iter().map(|(s, _)| *s).collect();
    let rms: Vec<f64> = samples.iter().map(|s| s.rms.mean).collect();
    let with_friction: Vec<(f64, Statistics)> = known
        .iter()
        .filter_map(|(s, ra_m)| Some((*ra_m, s.friction_coefficient?)))
        .collect();
    let (of_friction, friction): (Vec<f64>, Vec<f64>) = with_friction
        .iter()
        .map(|(ra_m, s)| (*ra_m, s.mean))
        .unzip();
    RoughnessTrend {
        samples: known.iter().map(|(s, _)| s.name.clone()).collect(),
        // Two samples always lie on a line.
        rms_on_ra: level_on(&ra_m, &samples).filter(|fit| fit.points > 2),
        rms_rank_correlation: rank_correlation(&ra_m, &rms),
        friction_rank_correlation: rank_correlation(&of_friction, &friction),
        friction_change: friction_change(&with_friction),
        ra_m,
    }
}

/// The rank correlation of friction coefficient and rms over `groups`, and by how much friction changes with rms; `None` for fewer than
/// three with friction.
///
/// Source: [`rank_correlation`].
#[must_use]
pub fn friction_against_rms(
    groups: &[&Summary],
) -> (Option<RankCorrelation>, Option<FrictionChange>) {
    let pairs: Vec<(f64, Statistics)> = groups
        .iter()
        .filter_map(|s| Some((s.rms.mean, s.friction_coefficient?)))
        .collect();
    let (rms, friction): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(rms, s)| (*rms, s.mean)).unzip();
    (rank_correlation(&friction, &rms), friction_change(&pairs))
}

/// The line of log rms on log speed over `groups`, one for each speed; `None` for fewer than two speeds, and where all are within 20 %.
///
/// Source: [`log_fit`].
#[must_use]
pub fn rms_on_speed(groups: &[&Summary]) -> Option<LogFit> {
    let (speed, groups): (Vec<f64>, Vec<&Summary>) = groups
        .iter()
        .filter_map(|s| Some((s.speed_m_s?.mean, *s)))
        .unzip();
    level_on(&speed, &groups)
}

/// The line of the log friction coefficient on log speed over `groups`, as [`rms_on_speed`], and by how much friction changes; `None` where
/// friction was not measured too.
///
/// Source: [`log_fit`].
#[must_use]
pub fn friction_on_speed(groups: &[&Summary]) -> Option<(LogFit, Option<FrictionChange>)> {
    let speeds = groups.iter().map(|s| Some(s.speed_m_s?.mean));
    friction_on(&speeds.collect::<Vec<_>>(), groups)
}

/// The line of the log friction coefficient of `groups` on log `x`, where both are known, and by how much friction changes; `None` where x
/// spans less than 20 %.
pub(super) fn friction_on(
    x: &[Option<f64>],
    groups: &[&Summary],
) -> Option<(LogFit, Option<FrictionChange>)> {
    let pairs = x.iter().zip(groups);
    let pairs: Vec<(f64, Statistics)> = pairs
        .filter_map(|(x, s)| Some(((*x)?, s.friction_coefficient?)))
        .collect();
    let (x, friction): (Vec<f64>, Vec<f64>) = pairs.iter().map(|(x, s)| (*x, s.mean)).unzip();
    let fit = log_fit(&x, &friction).filter(|_| spans(&x))?;
    let fit = fit.reaching((1.0 + LEAST_CHANGE).ln() / ratio(&x).ln());
    Some((fit, friction_change(&pairs)))
}

/// The line of the log rms of `groups` on log `x`; `None` where x spans less than 20 %. Where lines that may not be the texture's hold some of
/// the power, or the noise of the sensor at rest does, its interval reaches over those of the lines without them too: noise that is always there
/// pulls every exponent towards 0. It has none where some level is not above them. To each side it reaches at least what 0.5 dB from the lowest
/// to the highest x would make.
pub(super) fn level_on(x: &[f64], groups: &[&Summary]) -> Option<LogFit> {
    let least = DRIFT_DB / (20.0 * ratio(x).log10());
    let fit = |level: fn(&Summary) -> f64| {
        let levels: Vec<f64> = groups.iter().map(|group| level(group)).collect();
        log_fit(x, &levels).map(|fit| fit.reaching(least))
    };
    let with = fit(|group| group.rms.mean).filter(|_| spans(x))?;
    let mut found = with;
    for without in [Summary::rms_without_lines, Summary::rms_without_rest] {
        // Where a level is not above them, nothing is known of the exponent.
        let without = fit(without).filter(|fit| fit.points == with.points);
        let both = (found.slope_interval).zip(without.and_then(|fit| fit.slope_interval));
        found.slope_interval = both.map(|(a, b)| [a[0].min(b[0]), a[1].max(b[1])]);
        let p_values = (found.p_value).zip(without.and_then(|fit| fit.p_value));
        found.p_value = p_values.map(|(a, b)| a.max(b));
    }
    Some(found)
}

/// Whether values differ by enough for a power law: over less than 20 % what else differs decides.
fn spans(x: &[f64]) -> bool {
    ratio(x) > LEAST_SPAN
}

/// The largest over the least of the values above zero, which a power law is on.
fn ratio(x: &[f64]) -> f64 {
    let above = || x.iter().copied().filter(|x| *x > 0.0 && x.is_finite());
    above().fold(f64::MIN, f64::max) / above().fold(f64::MAX, f64::min)
}

/// One sample touched actively and passively.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ActivePassivePair {
    /// The sample.
    pub sample: String,
    /// The rms over the band of the difference of the mean PSDs, dB; absent when their lines differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference_db_rms: Option<f64>,
    /// Active over passive rms, dB; absent where one of them is silent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_difference_db: Option<f64>,
}

/// Active against passive touch of the same samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ActivePassive {
    /// One for each sample that was touched both ways.
    pub pairs: Vec<ActivePassivePair>,
    /// The level of active less that of passive touch, dB: mean, interval and p over samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<PairedDifference>,
    /// The rank correlation of the two rms over samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_rank_correlation: Option<RankCorrelation>,
    /// The band of the differences, Hz.
    pub band_hz: Band,
    /// What else differs between active and passive touch of some sample.
    #[serde(skip)]
    pub confounders: Vec<Confounder>,
}

/// Active against passive touch: the samples that occur in both lists, by name. `stated_n` is the load that the recordings of a sample state,
/// N, those of active touch first.
///
/// Formula: [`difference_db_rms`] of mean PSDs over `band`; [`rank_correlation`] of the rms and [`paired_difference`] of the levels,
/// both over samples.
///
/// Source: L. Felicetti's thesis (2024), section 3.2.3.
#[must_use]
pub fn active_against_passive(
    active: &[&Summary],
    passive: &[&Summary],
    stated_n: impl Fn(&str) -> [Option<f64>; 2],
    band: Band,
) -> ActivePassive {
    let both: Vec<(&Summary, &Summary)> = active
        .iter()
        .filter_map(|a| Some((*a, *passive.iter().find(|p| p.name == a.name)?)))
        .collect();
    let (a, p): (Vec<f64>, Vec<f64>) = both.iter().map(|(a, p)| (a.rms.mean, p.rms.mean)).unzip();
    let pairs: Vec<ActivePassivePair> = both
        .iter()
        .map(|(a, p)| {
            let step_hz = a.psd.resolution_hz;
            let same = (p.psd.resolution_hz / step_hz - 1.0).abs() < 1e-3;
            let difference = difference_db_rms(&a.psd.mean, &p.psd.mean, step_hz, band);
            let level = 20.0 * (a.rms.mean / p.rms.mean).log10();
            ActivePassivePair {
                sample: a.name.clone(),
                difference_db_rms: difference.filter(|_| same),
                level_difference_db: Some(level).filter(|db| db.is_finite()),
            }
        })
        .collect();
    let levels: Vec<f64> = pairs.iter().filter_map(|p| p.level_difference_db).collect();
    ActivePassive {
        level: paired_difference(&vec![0.0; levels.len()], &levels),
        pairs,
        rms_rank_correlation: rank_correlation(&a, &p),
        band_hz: band,
        confounders: widest(
            both.iter()
                .flat_map(|(a, p)| confounders(&[a, p], &stated_n(&a.name), "touch")),
        ),
    }
}

/// One confounder of each kind, over all of its values.
pub(super) fn widest(all: impl Iterator<Item = Confounder>) -> Vec<Confounder> {
    let mut found: Vec<Confounder> = Vec::new();
    for one in all {
        match found.iter_mut().find(|known| known.what == one.what) {
            Some(known) => {
                known.low = known.low.min(one.low);
                known.high = known.high.max(one.high);
                known.complete |= one.complete;
            }
            None => found.push(one),
        }
    }
    found
}

/// The rms of one group as a level, with its spread over strokes or participants, dB.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LevelSpread {
    /// Mean, standard deviation and median of 20·log10(rms), dB re 1 u.
    pub level_db: Statistics,
    /// The 95 % confidence interval of the standard deviation over people, dB; absent for fewer than two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sd_interval_db: Option<[f64; 2]>,
    /// The number of participants.
    pub participants: usize,
}

/// How far participants differ: the level of each group's mean rms in dB, over `groups`, one for each participant.
/// `None` without groups above zero.
///
/// Formula: statistics of 20·log10(rms); the standard deviation times √((n − 1)/χ²) at the quantiles of χ² with n − 1
/// degrees of freedom.
///
/// Source: spread between people as a ratio, since levels differ by factors; G. W. Snedecor and W. G. Cochran,
/// *Statistical Methods*, 8th ed., section 5.11, for the interval.
#[must_use]
pub fn across_participants(groups: &[&Summary]) -> Option<LevelSpread> {
    let mut levels: Vec<f64> = groups
        .iter()
        .filter(|s| s.rms.mean > 0.0)
        .map(|s| 20.0 * s.rms.mean.log10())
        .collect();
    let participants = levels.len();
    let level_db = Statistics::of(&mut levels)?;
    Some(LevelSpread {
        participants,
        sd_interval_db: deviation_interval(level_db.sd, participants),
        level_db,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(mean: f64) -> Statistics {
        Statistics {
            sd: 0.02 * mean,
            ..Statistics::of(&mut [mean]).unwrap()
        }
    }

    /// Ranks that rise beside a slope that falls, as one smooth sample with high friction makes it, are no trend either way.
    #[test]
    fn a_slope_against_the_ranks_decides_nothing() {
        let ra_m = [
            0.01e-6, 1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6, 7e-6, 8e-6, 9e-6,
        ];
        let friction = [1.5, 0.40, 0.42, 0.44, 0.46, 0.48, 0.5, 0.52, 0.54, 0.56];
        let ranks = rank_correlation(&ra_m, &friction).unwrap();
        let with: Vec<(f64, Statistics)> = ra_m.iter().copied().zip(friction.map(of)).collect();
        let change = friction_change(&with).unwrap();
        assert!(
            ranks.rho > 0.4 && change.share < -0.2,
            "{ranks:?} {change:?}"
        );
        let ranks = RankCorrelation {
            p_value: 0.01,
            ..ranks
        };
        let said = change.conclusion(&ranks, "Ra");
        assert!(said.starts_with("friction and Ra: not decided"), "{said}");
        // Without that sample both agree.
        let rising = friction_change(&with[1..]).unwrap();
        let said = rising.conclusion(&ranks, "Ra");
        assert!(said.starts_with("friction rises with Ra"), "{said}");
    }
}
