//! Whether the lines of a candidate move with the speed, or stay at their frequencies as those of a machine do.

use serde::Serialize;

use super::spectra::{AROUND, Spectrum, WANDER};
use super::{HIGHEST_OF_MANY, LEAST_SPEEDS, PROMINENT_DB, PeriodCriterion, SCATTER_DB, SpeedPeak};
use crate::criterion::{Criterion, Limit};

/// What the lines at all speeds say of a candidate.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LinesOfSpeeds {
    /// The natural logarithm of the likelihood that lines move with the speed …
    pub moving_log_likelihood: f64,
    /// … and that they stay at their frequencies.
    pub fixed_log_likelihood: f64,
    /// At how many speeds the line moves …
    pub moving_speeds: usize,
    /// … of those whose line is no multiple of the candidate at some other speed: those at double the speed of another cannot tell.
    pub telling_speeds: usize,
    /// The lines of the candidate that other speeds have at the same frequency, Hz.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fixed_hz: Vec<f64>,
    /// Lines that are no multiple of the candidate and stand higher, one a speed, Hz.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stronger_hz: Vec<f64>,
    /// Another period whose lines stand at all speeds nearly as high, and is no multiple and no part of the candidate, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_period_m: Option<f64>,
}

/// The line of one speed stays when that is 20 times as likely as that it moves, and moves when that is 3 times as likely: logarithms.
const STAYS: f64 = 2.995_732_273_553_991;
const MOVES: f64 = 1.098_612_288_668_109_8;
/// Lines of all speeds together move when that is 100 times as likely, and those of two speeds or more do: logarithm.
pub(super) const ALL_MOVE: f64 = 4.605_170_185_988_092;
/// The level of a line that stays differs so far between speeds, since the contact does, dB.
const LINE_SPREAD_DB: f64 = 6.0;
/// The level beside a line differs so far from noise of the same level everywhere, dB.
const BACKGROUND_SPREAD_DB: f64 = 4.0;
/// Another line counts when it is so much higher than the highest of the candidate, dB.
const HIGHER_DB: f64 = 3.0;
/// Another period counts when its lines are no more than this below the highest of the candidate, dB.
const NEARLY_AS_HIGH_DB: f64 = 8.0;
/// Another speed can tell where the line is so many widths beside its own lines.
const BESIDE: f64 = 1.5;
/// A machine's own lines change by some per cent between recordings: speeds whose ratio is no more than this tell nothing.
const OTHER_SPEED: f64 = 1.2;
/// Multiples of a candidate up to this one are its own.
const ORDERS: usize = 20;
/// So many of the highest lines of a speed are looked at.
const HIGHEST: usize = 12;

/// Whether lines of the candidate `wavenumber` at the speeds of `reaching` move: the line of each speed is looked for at its frequency
/// at all other speeds, where it is no multiple of the candidate.
///
/// Formula: the height p of the line of speed i at the same frequency at speed j is `N(p_i, s_i² + s_j² + 6²)` dB where lines stay, and
/// the highest of n values of noise, `N(m_n·s_j, s_j² + 4²)`, or less, where they move; s = 5.57 dB/√(strokes), the scatter of a mean of log
/// periodograms. Lines move where that is 100 times as likely over all speeds
/// and 3 times at two of them or more, or at the only one that can tell; the line of a speed stays where that is 20 times as likely.
///
/// Source: house rule; 5.57 dB is the standard deviation of the logarithm of a χ² with two degrees of freedom.
pub(super) fn lines_of_speeds(
    all: &[Spectrum],
    reaching: &[&Spectrum],
    wavenumber: f64,
) -> LinesOfSpeeds {
    let mut found = LinesOfSpeeds::default();
    for own in reaching {
        let peak = moving_peak(all, own, wavenumber);
        let line_hz = peak.map_or(wavenumber * own.speed_m_s, |peak| peak.frequency_hz);
        if let Some((moving, fixed)) = likelihoods(all, own, line_hz, wavenumber) {
            found.moving_log_likelihood += moving;
            found.fixed_log_likelihood += fixed;
            found.telling_speeds += 1;
            found.moving_speeds += usize::from(moving >= fixed + MOVES);
            if fixed >= moving + STAYS {
                found.fixed_hz.push(line_hz);
            }
        }
        found.stronger_hz.extend(stronger(all, own, line_hz));
    }
    found.other_period_m = other_period_m(all, reaching, wavenumber);
    found
}

/// A period beside the candidate: two textures at once, or two harmonics of a longer period whose own line is missing.
fn other_period_m(all: &[Spectrum], reaching: &[&Spectrum], wavenumber: f64) -> Option<f64> {
    // Parts of the candidate, its multiples, and what its windows leave around them.
    let related = |other: f64| {
        let order = (wavenumber / other).round().max(1.0);
        let tooth = wavenumber * (other / wavenumber).round().max(1.0);
        (other * order / wavenumber - 1.0).abs() <= WANDER
            || reaching.iter().any(|own| {
                let apart_hz = (other - tooth).abs() * own.speed_m_s;
                apart_hz <= AROUND * own.width_hz(tooth * own.speed_m_s)
            })
    };
    let least_db: Vec<f64> = reaching
        .iter()
        .map(|own| {
            let teeth =
                (1..=ORDERS).filter_map(|n| own.line_db(n as f64 * wavenumber * own.speed_m_s));
            let highest_db = teeth.fold(f64::MIN, f64::max);
            let noise_db = PROMINENT_DB.max(HIGHEST_OF_MANY * own.scatter_db());
            noise_db.max(highest_db - NEARLY_AS_HIGH_DB)
        })
        .collect();
    let shows = |other: f64| {
        reaching.iter().zip(&least_db).all(|(own, least_db)| {
            let hz = other * own.speed_m_s;
            own.reaches(other)
                && own.at(other) >= *least_db
                && own.line_db(hz).is_some_and(|db| db >= *least_db)
                && !stays(all, own, hz, other)
        })
    };
    let first = reaching.first()?;
    let mut others = first.wavenumbers.iter().copied();
    others
        .find(|other| !related(*other) && shows(*other))
        .map(f64::recip)
}

/// The highest peak around `wavenumber` that does not stand at the same frequency at other speeds, where it stands out of the noise;
/// otherwise the highest.
pub(super) fn moving_peak(all: &[Spectrum], own: &Spectrum, wavenumber: f64) -> Option<SpeedPeak> {
    let peaks = own.peaks(wavenumber);
    let needed_db = PROMINENT_DB.max(HIGHEST_OF_MANY * own.scatter_db());
    let stands_out = |peak: &&SpeedPeak| {
        own.line_db(peak.frequency_hz)
            .is_some_and(|db| db >= needed_db)
    };
    let moves = |peak: &&SpeedPeak| !stays(all, own, peak.frequency_hz, wavenumber);
    let mut others = peaks.iter().skip(1).filter(stands_out);
    let highest = peaks.first()?;
    let found = if moves(&highest) {
        Some(highest)
    } else {
        others.find(moves)
    };
    found.or(Some(highest)).copied()
}

/// Whether a line of `own` stands at the same frequency at other speeds, and is no multiple of the candidate there.
pub(super) fn stays(all: &[Spectrum], own: &Spectrum, line_hz: f64, wavenumber: f64) -> bool {
    likelihoods(all, own, line_hz, wavenumber)
        .is_some_and(|(moving, fixed)| fixed >= moving + STAYS)
}

impl LinesOfSpeeds {
    /// Whether no line moves, and two or more stay.
    #[must_use]
    pub fn all_stay(&self) -> bool {
        self.moving_speeds == 0 && self.fixed_hz.len() >= 2
    }

    /// What has to hold of them for a spatial period.
    pub(super) fn criteria(&self) -> [Criterion<PeriodCriterion>; 2] {
        let moves = Limit::AtLeast {
            met: ALL_MOVE,
            not_met: if self.all_stay() { 0.0 } else { f64::MIN },
        };
        // One speed whose line moves may be chance, where others could tell.
        let several =
            self.moving_speeds >= LEAST_SPEEDS.min(self.telling_speeds) || self.all_stay();
        let ratio = self.moving_log_likelihood - self.fixed_log_likelihood;
        let strongest = Limit::AtMost {
            met: 0.0,
            not_met: f64::MAX,
        };
        [
            Criterion::new(
                PeriodCriterion::Moves,
                "",
                if several { ratio } else { ratio.min(0.0) },
                None,
                moves,
            ),
            Criterion::new(
                PeriodCriterion::Strongest,
                "",
                (self.stronger_hz.len() + usize::from(self.other_period_m.is_some())) as f64,
                None,
                strongest,
            ),
        ]
    }
}

/// The log likelihoods that the line of `own` at `line_hz` moves, and that it stays; none where no other speed can tell.
fn likelihoods(
    all: &[Spectrum],
    own: &Spectrum,
    line_hz: f64,
    wavenumber: f64,
) -> Option<(f64, f64)> {
    let own_db = own.line_db(line_hz)?;
    let (mut moving, mut fixed, mut telling) = (0.0, 0.0, 0);
    for other in all {
        let ratio = (other.speed_m_s / own.speed_m_s).max(own.speed_m_s / other.speed_m_s);
        if ratio <= OTHER_SPEED {
            continue;
        }
        let first_hz = wavenumber * other.speed_m_s;
        let width_hz = own.width_hz(line_hz).max(other.width_hz(line_hz));
        let order = (line_hz / first_hz).round();
        if order >= 1.0 && (line_hz - order * first_hz).abs() <= BESIDE * width_hz {
            continue;
        }
        let Some(found_db) = other.line_db(line_hz) else {
            continue;
        };
        telling += 1;
        let independent = (width_hz * other.length_m / other.speed_m_s).max(1.0);
        let noise_db = other.scatter_db() * 0.8 * (2.0 * independent.ln()).sqrt();
        moving += log_normal(
            (found_db - noise_db).max(0.0),
            other.scatter_db().powi(2) + BACKGROUND_SPREAD_DB.powi(2),
        );
        let spread = own.scatter_db().powi(2) + other.scatter_db().powi(2);
        fixed += log_normal(found_db - own_db, spread + LINE_SPREAD_DB.powi(2));
    }
    (telling > 0).then_some((moving, fixed))
}

/// The logarithm of the normal density of a `difference` from the mean.
pub(super) fn log_normal(difference: f64, variance: f64) -> f64 {
    -0.5 * (difference.powi(2) / variance + (std::f64::consts::TAU * variance).ln())
}

/// The highest line of `own`, Hz, where it is neither a multiple of the candidate's own line at `first_hz` nor a line that another speed has at the same
/// frequency, and stands above every multiple of the candidate.
fn stronger(all: &[Spectrum], own: &Spectrum, first_hz: f64) -> Option<f64> {
    let tooth = |hz: f64| {
        let order = (hz / first_hz).round();
        order >= 1.0 && (hz - order * first_hz).abs() <= own.width_hz(hz)
    };
    let highest_tooth_db = (1..=ORDERS)
        .filter_map(|order| own.line_db(order as f64 * first_hz))
        .fold(f64::MIN, f64::max);
    let needed_db = PROMINENT_DB
        .max(HIGHEST_OF_MANY * own.scatter_db())
        .max(highest_tooth_db + HIGHER_DB);
    // One speed that has it is enough: at the others it may lie on a multiple of the candidate.
    let elsewhere = |hz: f64, own_db: f64| {
        let mut others = all.iter().filter(|s| s.speed_m_s != own.speed_m_s);
        others.any(|other| {
            let found_db = other.line_db(hz);
            found_db.is_some_and(|db| db >= PROMINENT_DB && db >= 0.5 * own_db)
        })
    };
    let lines = own.highest_lines_hz(HIGHEST);
    lines.into_iter().find(|hz| {
        let level_db = own.line_db(*hz).unwrap_or(f64::MIN);
        level_db >= needed_db && !tooth(*hz) && !elsewhere(*hz, level_db)
    })
}

impl Spectrum {
    /// The scatter of its levels, dB.
    fn scatter_db(&self) -> f64 {
        SCATTER_DB / self.stretches.sqrt()
    }

    /// The frequencies of the `most` lines that stand highest above the background, the highest first, each beyond the
    /// surroundings of the others, where the window's own lobes lie.
    fn highest_lines_hz(&self, most: usize) -> Vec<f64> {
        let mut order: Vec<usize> = (0..self.prominence_db.len()).collect();
        order.sort_by(|a, b| self.prominence_db[*b].total_cmp(&self.prominence_db[*a]));
        let mut lines: Vec<f64> = Vec::new();
        for place in order {
            let hz = self.wavenumbers[place] * self.speed_m_s;
            let reach_hz = AROUND * self.width_hz(hz);
            if lines.iter().all(|line| (line - hz).abs() > reach_hz) {
                lines.push(hz);
            }
            if lines.len() == most {
                break;
            }
        }
        lines
    }
}
