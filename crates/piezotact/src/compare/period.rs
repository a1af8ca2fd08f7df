//! The spatial period of a surface (or of a fingerprint) from sliding at several speeds: f = v/λ.

mod judged;
mod moving;
mod spectra;
mod travelled;

use serde::{Deserialize, Serialize};

use judged::Candidate;
pub use moving::LinesOfSpeeds;
use moving::{lines_of_speeds, moving_peak, stays};

use crate::criterion::{Criterion, Limit, Outcome};
use crate::quantity::{Hertz, SampleRate};
use crate::statistics::{standard_deviation, t_quantile};
use crate::warning::Warning;
pub(crate) use spectra::lines_of_strokes;
use spectra::{Spectrum, by_speed, spectrum};
pub use travelled::{AlongTheWay, WayPeak, WaySpectrum};
pub(crate) use travelled::{Travelled, along_the_way};

/// One speed: what was recorded while sliding at it.
#[derive(Clone, Debug)]
pub struct Sliding<'a> {
    pub speed_m_s: f64,
    pub rate: SampleRate,
    /// The condition shared with other recordings apart from the speed, such as the load: recordings of one group are repeats.
    pub group: String,
    /// Every stroke of every channel.
    pub stretches: Vec<&'a [f64]>,
}

/// The peak that belongs to the common period at one speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpeedPeak {
    /// The speed, m/s.
    pub speed_m_s: f64,
    /// The frequency of the peak, Hz.
    pub frequency_hz: f64,
    /// How far it stands above the background, dB.
    pub prominence_db: f64,
}

/// The units over which the interval of a period is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PeriodUnit {
    /// Groups, such as loads: there are two or more.
    Groups,
    /// Single recordings of one group.
    Recordings,
    /// The harmonics of one recording, along the way.
    Harmonics,
}

/// Where a period is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FoundIn {
    /// In the frequencies at several speeds.
    Speeds,
    /// Along the way of strokes whose motion was measured; the speeds are the means of the slower and of the faster strokes.
    Way,
}

/// The criteria for a spatial period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PeriodCriterion {
    /// How far it stands above the background in the mean over speeds.
    Prominence,
    /// The share of the speeds that have a peak there.
    Speeds,
    /// Its level above the background at the speed where it is lowest: a line at a fixed frequency is high at one speed and would
    /// raise the mean.
    EverySpeed,
    /// The logarithm of how much likelier lines that move with the speed are than lines that stay at their frequencies, as those of a
    /// machine do whatever their ratios; no more than 0 where only one of several speeds that can tell shows it.
    Moves,
    /// The number of speeds at which a line that is no multiple of the candidate stands higher, and of other periods that stand nearly as
    /// high at all speeds.
    Strongest,
    /// The number of other samples that have the same period, where all have it: it may be the drive's or the finger's.
    OtherSamples,
    /// The reach of its 95 % interval to one side, as a share, along the way.
    Reach,
    /// By how much it stands higher, dB, were the motion recorded some ms earlier or later than the vibration: its value is another one then.
    OneTime,
    /// How often it fits into the shortest stroke.
    Cycles,
    /// Its level above the background in the group where it is lowest.
    EveryGroup,
    /// How many of its multiples, from twice up to three times the period, are known not to be the period: at some speed their
    /// frequency is analysed, and has no peak. Strokes that are short or filtered leave them open.
    Multiples,
}

/// The period found in one group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct GroupPeriod {
    /// Which.
    pub group: String,
    /// The period that its own spectra agree on best, m.
    pub strongest_m: f64,
    /// How far the common period stands above its background, dB …
    pub prominence_db: f64,
    /// … and how far it has to, dB.
    pub needed_db: f64,
    /// The mean period of its recordings' peaks near the common one, m; absent where none has a peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_m: Option<f64>,
}

/// A spatial period that the spectra at all speeds agree on.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpatialPeriod {
    /// Where it was looked for.
    pub found_in: FoundIn,
    /// The period, m.
    pub period_m: f64,
    /// Whether it is a period: met, not met, or not decided.
    pub outcome: Outcome,
    /// Its 95 % confidence interval over `units`, m; absent for fewer than two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_m: Option<[f64; 2]>,
    /// What the interval is over.
    pub over: PeriodUnit,
    /// How many of them there are.
    pub units: usize,
    /// The peak at each speed.
    pub peaks: Vec<SpeedPeak>,
    /// How far the period stands above the background in the mean over speeds, dB.
    pub prominence_db: f64,
    /// The speeds at which its frequency is analysed: at slower ones it lies below the filter of the gesture, or fits too rarely
    /// into a stroke. What is not analysed is unknown, not absent.
    pub speeds_in_reach: usize,
    /// Of how many.
    pub speeds: usize,
    /// Multiples that may be the period: their frequency is analysed at no speed, or stands out at the only one, m.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open_multiples_m: Vec<f64>,
    /// The results of every group, if there are two or more.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<GroupPeriod>,
    /// Whether its lines move with the speed.
    pub lines: LinesOfSpeeds,
    /// The criteria and their outcomes.
    pub criteria: Vec<Criterion<PeriodCriterion>>,
    /// How much later the motion seems to be recorded than the vibration, s, where that leaves the period open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub late_s: Option<f64>,
    /// The wavenumbers at which two speeds or more, and most of those that hold them, have a line, whatever stands highest, 1/m.
    #[serde(skip)]
    lines_1_m: Vec<f64>,
    /// What a person should know before relying on it; a document has these among its own.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

impl SpatialPeriod {
    /// Whether it stands out at all speeds, whatever its lines are.
    fn stands_out(&self) -> bool {
        let of_level = [PeriodCriterion::Prominence, PeriodCriterion::Speeds];
        let mut criteria = self.criteria.iter();
        criteria.all(|c| !of_level.contains(&c.what) || c.outcome == Outcome::Met)
    }

    /// Whether the spectra agree on it: every criterion is met, but for multiples that may be the period instead.
    #[must_use]
    pub fn is_common(&self) -> bool {
        let others = self.criteria.iter();
        let others = others.filter(|criterion| criterion.what != PeriodCriterion::Multiples);
        Outcome::of_all(others.map(|criterion| criterion.outcome)) == Outcome::Met
    }

    /// Whether the groups show different periods.
    #[must_use]
    pub fn jumps(&self) -> bool {
        self.leaves_open(PeriodCriterion::EveryGroup)
    }

    /// Whether it stands out of the noise at some of the speeds only.
    #[must_use]
    pub fn missed_at_a_speed(&self) -> bool {
        self.leaves_open(PeriodCriterion::EverySpeed)
    }

    /// Whether a multiple of it may be the period.
    #[must_use]
    pub fn may_be_a_harmonic(&self) -> bool {
        self.leaves_open(PeriodCriterion::Multiples)
    }

    /// Whether nothing but what other lines say speaks against it: it stands out at all speeds.
    #[must_use]
    pub fn is_confounded_by(&self, rule: PeriodCriterion) -> bool {
        self.leaves_open(rule) && self.stands_out()
    }

    /// Whether nothing speaks against it but that all samples have it.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        let mut criteria = self.criteria.iter();
        self.leaves_open(PeriodCriterion::OtherSamples)
            && criteria
                .all(|c| c.what == PeriodCriterion::OtherSamples || c.outcome == Outcome::Met)
    }

    /// Whether `other` is the same period: they differ by no more than both intervals reach, or by 1 %.
    fn is_same_as(&self, other: &Self) -> bool {
        let reach = |period: &Self| {
            let interval = period.interval_m;
            interval.map_or(0.0, |[low, high]| 0.5 * (high / low).ln())
        };
        let apart = (self.period_m / other.period_m).ln().abs();
        apart <= SAME_PERIOD.max(reach(self).hypot(reach(other)).min(MOST_REACH))
    }

    /// Whether its sample has lines at the period `other` at most speeds, also where its own period stands higher; multiples of its own
    /// wavenumber do not count.
    fn has_lines_of(&self, other: &Self) -> bool {
        let wavenumber = 1.0 / other.period_m;
        let order = (wavenumber * self.period_m).round();
        let own = self.stands_out()
            && order >= 2.0
            && (wavenumber * self.period_m / order - 1.0).abs() <= SAME_PERIOD;
        let mut lines = self.lines_1_m.iter();
        !own && lines.any(|line| (line / wavenumber - 1.0).abs() <= SAME_PERIOD)
    }

    /// Whether nothing but the width of its interval speaks against it.
    #[must_use]
    pub fn is_imprecise(&self) -> bool {
        let mut criteria = self.criteria.iter();
        self.leaves_open(PeriodCriterion::Reach)
            && criteria.all(|c| c.what == PeriodCriterion::Reach || c.outcome == Outcome::Met)
    }

    /// Adds how high it stands were the motion so many s late, to one side or the other: it is not decided where that is higher.
    pub(crate) fn require_one_time(&mut self, others: impl Iterator<Item = (f64, f64)>) {
        let highest = others.max_by(|a, b| a.1.total_cmp(&b.1));
        let higher_db = highest.map_or(0.0, |(_, db)| db - self.prominence_db);
        let limit = Limit::AtMost {
            met: LATE_DB,
            not_met: f64::MAX,
        };
        let what = PeriodCriterion::OneTime;
        self.criteria
            .push(Criterion::new(what, "dB", higher_db, None, limit));
        let outcomes = self.criteria.iter().map(|criterion| criterion.outcome);
        self.outcome = Outcome::of_all(outcomes);
        if self.outcome == Outcome::NotDecided {
            self.late_s = highest.map(|(late_s, _)| late_s);
        }
    }

    fn leaves_open(&self, rule: PeriodCriterion) -> bool {
        let mut criteria = self.criteria.iter();
        criteria.any(|c| c.what == rule && c.outcome == Outcome::NotDecided)
    }
}

/// Spectra are compared on lines this far apart, as a ratio.
const STEP: f64 = 1.001;
/// The least level of a period above the background, dB …
const PROMINENT_DB: f64 = 6.0;
/// … nor is what noise reaches: the level of one periodogram's line scatters by this, dB, and the highest of a
/// thousand lines lies this many standard deviations up.
const SCATTER_DB: f64 = 5.57;
const HIGHEST_OF_MANY: f64 = 4.0;
/// The same for the few lines close to a period.
const HIGHEST_OF_FEW: f64 = 2.5;
/// The same for the lines close to a period at one speed, in standard deviations.
const HIGHEST_AT_A_SPEED: f64 = 3.0;
/// Close to a period is within this ratio of it.
const NEAR: f64 = 1.03;
/// The least level of a peak at one speed above the background, dB.
const PEAK_DB: f64 = 3.0;
/// A period that fits less often than this into a stroke may be the stroke's own shape.
const CYCLES: f64 = 3.0;
/// The largest multiple of a period that is looked for: the strongest line may be the third harmonic of the period.
const MULTIPLES: usize = 3;
/// A line that is analysed at fewer speeds than this is no period: it may stay at its frequency.
const LEAST_SPEEDS: usize = 2;
/// Periods that differ by less than this share are the same …
const SAME_PERIOD: f64 = 0.01;
/// … or by what their intervals reach, but no more than this share.
const MOST_REACH: f64 = 0.05;
/// A line that stands so much higher with a motion of another time is not read, dB.
const LATE_DB: f64 = 1.0;
/// The least that an interval along the way reaches to each side, as a share: what a peak of a spectrum is read to.
const LEAST_WAY_REACH: f64 = 1e-3;
/// Along the way a period is known to this share, or it is not decided.
const MOST_WAY_REACH: f64 = 0.02;
/// Speeds that differ by less than this share are one speed.
const SAME_SPEED: f64 = 0.01;

/// The spatial period on which the spectra of `slidings` agree: the wavenumber f/v that stands highest above its
/// background in the mean over speeds; the geometric mean of the v/f of the recordings' own peaks there.
/// `None` when no stretch is long enough, or no speed is above zero.
///
/// Below `lowest` nothing is looked for: what a filter has taken away there has a slope and no period. At slow speeds a long period
/// lies below it, and only its harmonics above. So the strongest line of all speeds is compared with those at a half and a third of its
/// wavenumber, at the speeds that hold them: where two speeds or more all have a line there, that is the period; where no
/// speed holds it (nor, of a third, shows other harmonics to be absent), or only one does and has a line, it is not decided which is the period. Where all speeds agree on nothing, the lines that
/// at least two speeds hold are searched.
///
/// It is one only where its lines move with the speed: lines that stay at their frequencies fit v/λ at speeds of 1:2:3 too, when they
/// are harmonics of one tone. Where a line that belongs to another period stands higher, it is not decided.
///
/// It is not decided whether it is one where groups or speeds do not all show it, or where it fits into a stroke fewer than three
/// times. The interval is over what was repeated: over groups, such as loads, where there are two or more, else over
/// recordings. How sharp a pooled line is says nothing of how far repeats lie apart. Recordings of
/// one speed count as one where the period is looked for.
///
/// Formula: periodograms of whole stretches (Hann), averaged in dB over stretches and channels; background: the
/// running median; ln λ = Σw·ln(v/f) over the recordings of a group with w ∝ v² (peaks are read with the same error in Hz), and
/// the plain mean over groups; the interval ± t·s·√Σw², s the standard deviation of ln(v/f) over units, Student's t with n − 1
/// degrees of freedom.
///
/// Source: f = v/λ, as used for fingerprints and ridged boards by J. Scheibert et al. (2009), Science 323(5920); docs/decisions/periods.md
/// for the multiples.
#[must_use]
pub fn spatial_period(slidings: &[Sliding<'_>], lowest: Hertz) -> Option<SpatialPeriod> {
    let all = by_speed(slidings.iter(), lowest);
    let found = agreed(&all)?;
    let wavenumber = found.wavenumber;
    let spectra = reaching(&all, wavenumber);
    let mut names: Vec<&str> = slidings.iter().map(|s| s.group.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    // The logarithm of the period of every recording that has a peak there, and its weight, by group; where lines of several speeds move,
    // one that stays beside them says nothing of the period.
    let lines = lines_of_speeds(&all, &spectra, wavenumber);
    let only_moving = lines.moving_speeds >= LEAST_SPEEDS;
    let logs: Vec<Vec<(f64, f64)>> = names
        .iter()
        .map(|name| {
            let own = slidings.iter().filter(|s| s.group == *name);
            let peaks = own.filter_map(|s| {
                let own = spectrum(s, lowest).filter(|own| own.reaches(wavenumber))?;
                let peak = moving_peak(&all, &own, wavenumber)?;
                let counts = !(only_moving && stays(&all, &own, peak.frequency_hz, wavenumber));
                counts.then_some(peak)
            });
            peaks
                .map(|p| ((p.speed_m_s / p.frequency_hz).ln(), p.speed_m_s.powi(2)))
                .collect()
        })
        .collect();
    let means: Vec<Option<f64>> = logs
        .iter()
        .map(|logs| (!logs.is_empty()).then(|| weighted(logs).0))
        .collect();
    let groups: Vec<GroupPeriod> = match names.as_slice() {
        [_] => Vec::new(),
        names => names
            .iter()
            .zip(&means)
            .filter_map(|(name, own)| {
                let spectra = by_speed(slidings.iter().filter(|s| s.group == *name), lowest);
                let strongest = agreed(&spectra)?.wavenumber;
                let spectra = reaching(&spectra, wavenumber);
                (!spectra.is_empty()).then(|| GroupPeriod {
                    group: (*name).to_owned(),
                    strongest_m: 1.0 / strongest,
                    prominence_db: prominence_near(&spectra, wavenumber),
                    needed_db: noise_db(HIGHEST_OF_FEW, &spectra),
                    period_m: own.map(f64::exp),
                })
            })
            .collect(),
    };
    let (over, units): (_, Vec<(f64, f64)>) = match means.iter().flatten().count() {
        0 | 1 => (PeriodUnit::Recordings, logs.concat()),
        _ => {
            let groups = means.into_iter().flatten();
            (PeriodUnit::Groups, groups.map(|log| (log, 1.0)).collect())
        }
    };
    Candidate {
        found_in: FoundIn::Speeds,
        all: &all,
        agreed: found,
        lines,
        groups,
        over,
        units,
    }
    .judged()
}

/// Adds to the periods of several samples whether all others have the same, as their period or as lines at most speeds below their own: then it
/// is not decided whose it is, as those of the drive of the machine and of the ridges of the finger move with the speed as a texture's do, and
/// a louder texture hides them at some speeds.
///
/// Source: house rule; f = v/λ holds for a lead screw, a gear and a finger too.
pub fn compare_periods(periods: &mut [(&str, &mut SpatialPeriod)]) {
    let known: Vec<(String, SpatialPeriod)> = periods
        .iter()
        .filter(|(_, period)| period.stands_out() || !period.lines_1_m.is_empty())
        .map(|(sample, period)| ((*sample).to_owned(), (**period).clone()))
        .collect();
    for (sample, period) in periods {
        let others = known.iter().filter(|(other, _)| other != sample);
        let (mut all, mut same): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
        for (other, its) in others {
            all.push(other);
            if its.stands_out() && period.is_same_as(its) || its.has_lines_of(period) {
                same.push(other);
            }
        }
        for names in [&mut all, &mut same] {
            names.sort_unstable();
            names.dedup();
        }
        // Where some sample has another one, the drive and the finger do not make them all.
        let found = if same.len() == all.len() {
            same.len()
        } else {
            0
        };
        let limit = Limit::AtMost {
            met: 0.0,
            not_met: f64::MAX,
        };
        let criterion =
            Criterion::new(PeriodCriterion::OtherSamples, "", found as f64, None, limit);
        period.criteria.push(criterion);
        let outcomes = period.criteria.iter().map(|criterion| criterion.outcome);
        period.outcome = Outcome::of_all(outcomes);
    }
}

/// The weighted mean of values, each with its weight, and its 95 % confidence interval: θ ± t·s·√Σw², s the standard
/// deviation of the values, t with n − 1 degrees of freedom.
fn weighted(values: &[(f64, f64)]) -> (f64, Option<[f64; 2]>) {
    let all: f64 = values.iter().map(|(_, weight)| weight).sum();
    let middle = values
        .iter()
        .map(|(value, weight)| value * weight)
        .sum::<f64>()
        / all;
    let squares: f64 = values
        .iter()
        .map(|(_, weight)| (weight / all).powi(2))
        .sum();
    let n = values.len() as f64;
    let plain: Vec<f64> = values.iter().map(|(value, _)| *value).collect();
    let deviation = standard_deviation(&plain) * (n / (n - 1.0)).sqrt();
    let interval = t_quantile(values.len().saturating_sub(1)).map(|t| {
        let reach = t * deviation * squares.sqrt();
        [middle - reach, middle + reach]
    });
    (middle, interval)
}

/// What noise does not reach, dB: `deviations` above the mean of as many stretches as `spectra` hold.
fn noise_db(deviations: f64, spectra: &[&Spectrum]) -> f64 {
    let averaged: f64 = spectra.iter().map(|s| s.stretches).sum();
    PROMINENT_DB.max(deviations * SCATTER_DB / averaged.sqrt())
}

/// How far the mean over `spectra` stands above the background close to a wavenumber, dB.
fn prominence_near(spectra: &[&Spectrum], wavenumber: f64) -> f64 {
    let reach = (NEAR.ln() / STEP.ln()) as i32;
    (-reach..=reach)
        .map(|i| {
            let near = wavenumber * STEP.powi(i);
            spectra.iter().map(|s| s.at(near)).sum::<f64>() / spectra.len() as f64
        })
        .fold(f64::MIN, f64::max)
}

/// A wavenumber on which spectra agree.
struct Agreed {
    /// 1/m.
    wavenumber: f64,
    /// How far it stands above the background in the mean over the spectra that hold it, dB.
    prominence_db: f64,
}

/// Those of `spectra` that hold a wavenumber.
fn reaching(spectra: &[Spectrum], wavenumber: f64) -> Vec<&Spectrum> {
    let all = spectra.iter();
    all.filter(|s| s.reaches(wavenumber)).collect()
}

/// Whether the spectra that hold a wavenumber have a line there: `Some(true)` where two or more all have one, `Some(false)` where one
/// of them has none, `None` where that is unknown, since none holds it, or only one does and has a line.
fn has_line(spectra: &[Spectrum], wavenumber: f64) -> Option<bool> {
    match speeds_with_line(spectra, wavenumber) {
        (with, reaching) if with < reaching => Some(false),
        (with, _) => (with >= LEAST_SPEEDS).then_some(true),
    }
}

/// How many of `spectra` have a line at a wavenumber, and how many hold it.
fn speeds_with_line(spectra: &[Spectrum], wavenumber: f64) -> (usize, usize) {
    // All that is close to it has to be held.
    let reaching = reaching(spectra, wavenumber / NEAR);
    let shows = |s: &&&Spectrum| {
        let (found_db, needed_db) = s.found_and_needed_db(wavenumber);
        found_db >= needed_db
    };
    (reaching.iter().filter(shows).count(), reaching.len())
}

/// The wavenumbers at which two speeds or more, and more than half of those that hold them, have a line, on a grid as fine as periods are
/// compared.
fn lines_of_most_speeds(spectra: &[Spectrum]) -> Vec<f64> {
    let ends = spectra.iter().filter_map(|s| s.wavenumbers.last());
    let high = ends.copied().fold(f64::MAX, f64::min);
    let lows = spectra.iter().map(|s| s.wavenumbers[0]);
    let low = lows.fold(f64::MAX, f64::min);
    if spectra.len() < LEAST_SPEEDS || low >= high {
        return Vec::new();
    }
    let step = 1.0 + SAME_PERIOD;
    let lines = ((high / low).ln() / step.ln()) as i32;
    let grid = (0..=lines).map(|i| low * step.powi(i));
    grid.filter(|wavenumber| {
        let (with, reaching) = speeds_with_line(spectra, *wavenumber);
        with >= LEAST_SPEEDS && 2 * with > reaching
    })
    .collect()
}

/// Whether `wavenumber` is known not to be the harmonic number `order` of a longer period: at some speed that period's own frequency is
/// analysed, and has no line. Where it is analysed nowhere, a third harmonic is excluded where the second, fourth and fifth have no line; a
/// second one is not, as the others of a smooth surface may be too weak.
fn is_excluded(spectra: &[Spectrum], wavenumber: f64, order: usize) -> bool {
    let longest = wavenumber / order as f64;
    let absent = |harmonic: usize| has_line(spectra, longest * harmonic as f64) == Some(false);
    let unknown = reaching(spectra, longest / NEAR).is_empty();
    let mut others = (2..2 * order).filter(|harmonic| *harmonic != order);
    absent(1) || (unknown && order > 2 && others.all(absent))
}

/// The wavenumber on which `spectra` agree: the strongest that all hold, or of its half and third the smallest at which all spectra
/// that hold it (two or more) have a line; where the strongest is no more than noise, the strongest that two or more hold, if it is more.
fn agreed(spectra: &[Spectrum]) -> Option<Agreed> {
    let all: Vec<&Spectrum> = spectra.iter().collect();
    let lows = || spectra.iter().map(|s| s.wavenumbers[0]);
    let common = strongest(&all, lows().fold(0.0, f64::max), f64::MAX);
    let stands_out =
        |found: &Agreed, of: &[&Spectrum]| found.prominence_db >= noise_db(HIGHEST_OF_MANY, of);
    if let Some(found) = common.filter(|found| stands_out(found, &all)) {
        let longest = (2..=MULTIPLES)
            .map(|m| found.wavenumber / m as f64)
            .rfind(|wavenumber| has_line(spectra, *wavenumber) == Some(true));
        return Some(match longest {
            Some(near) => strongest(&reaching(spectra, near / NEAR), near / NEAR, near * NEAR)
                .unwrap_or(found),
            None => found,
        });
    }
    // From the fewest spectra on: those that hold the smallest wavenumbers.
    let mut edges: Vec<f64> = lows().collect();
    edges.sort_by(f64::total_cmp);
    let partly = edges.windows(2).skip(LEAST_SPEEDS - 1).filter_map(|edge| {
        let of = reaching(spectra, edge[0]);
        let found = strongest(&of, edge[0], edge[1])?;
        let everywhere = of.iter().all(|s| {
            let (found_db, needed_db) = s.found_and_needed_db(found.wavenumber);
            found_db >= needed_db
        });
        (everywhere && stands_out(&found, &of)).then_some(found)
    });
    let partly = partly.max_by(|a, b| a.prominence_db.total_cmp(&b.prominence_db));
    partly.or_else(|| strongest(&all, lows().fold(0.0, f64::max), f64::MAX))
}

/// The wavenumber from `low` to `high` that stands highest above the background in the mean over `spectra`, as far as all hold it.
fn strongest(spectra: &[&Spectrum], low: f64, high: f64) -> Option<Agreed> {
    let high = spectra
        .iter()
        .filter_map(|s| s.wavenumbers.last())
        .copied()
        .fold(high, f64::min);
    if spectra.is_empty() || low * STEP >= high {
        return None;
    }
    let lines = ((high / low).ln() / STEP.ln()) as usize;
    (0..lines)
        .map(|i| low * STEP.powi(i as i32))
        .map(|wavenumber| {
            let sum: f64 = spectra.iter().map(|s| s.at(wavenumber)).sum();
            Agreed {
                wavenumber,
                prominence_db: sum / spectra.len() as f64,
            }
        })
        .max_by(|a, b| a.prominence_db.total_cmp(&b.prominence_db))
}

#[cfg(test)]
mod tests;
