//! What a study says, conclusion by conclusion, held against what was made.

use std::fmt;

use piezotact::clipping::ClippingWarning;
use piezotact::compare::{Distinguishability, LoadTrend, RoughnessTrend, SpatialPeriod};
use piezotact::criterion::Outcome;
use piezotact::integrity::SignalWarning;
use piezotact::statistics::{Direction, LogFit, log_fit, mean};
use piezotact::stroke::ForceWarning;
use piezotact::study::{
    AnalysedRecording, Comparison, Factor, Group, SampleTrend, SpeedTrend, StudyAnalysis, Trend,
};

use super::generator::{Made, Surface};
use super::kinds::Is;

/// A period, and a coefficient of friction or a force, may be off by these shares.
const PERIOD_OFF: f64 = 0.02;
const FRICTION_OFF: f64 = 0.1;
/// An exponent may be off by this, and a direction is one from here on. Intervals of 95 % miss the truth in 5 %: only one that misses it when it
/// is so many times as wide is false.
const EXPONENT_OFF: f64 = 0.3;
const EXPONENT_NONE: f64 = 0.05;
const WIDENED: f64 = 3.0;

/// What a conclusion is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum About {
    Period,
    Pair,
    Slope,
    Friction,
}

impl About {
    pub(super) const ALL: [Self; 4] = [Self::Period, Self::Pair, Self::Slope, Self::Friction];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Period => "periods",
            Self::Pair => "pairs",
            Self::Slope => "slopes",
            Self::Friction => "friction",
        }
    }
}

/// Whether a conclusion is true.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fact {
    /// It is said, and true.
    Right,
    /// It could be said, and is not.
    Withheld,
    /// Nothing is said where nothing has to be.
    Silent,
    /// It is said, and false.
    False,
}

/// Whether something has to be said.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Due {
    /// Of a right study, always.
    Said,
    /// Nothing is lost where it is not said.
    Open,
}

/// One conclusion.
#[derive(Clone, Debug)]
pub(super) struct Conclusion {
    pub(super) about: About,
    pub(super) fact: Fact,
    /// What is said, and what is true.
    pub(super) said: String,
    pub(super) truth: String,
}

impl fmt::Display for Conclusion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; true: {}", self.said, self.truth)
    }
}

/// What was made, with what its conclusions are held against.
pub(super) struct Truth<'a> {
    pub(super) made: &'a [Made],
    pub(super) is: Is,
}

impl Truth<'_> {
    /// Every conclusion of a study.
    pub(super) fn of(&self, study: &StudyAnalysis) -> Vec<Conclusion> {
        let mut all = Vec::new();
        for comparison in study.across(Factor::Speed) {
            if let Trend::Speeds(trend) = &comparison.trend {
                all.push(self.period(study, comparison, trend));
                all.extend(self.on_speed(study, comparison, trend));
            }
        }
        for (setting, comparison) in study.across(Factor::Sample).iter().enumerate() {
            all.extend(self.pairs(study, comparison, setting));
            if let Trend::Samples(trend) = &comparison.trend {
                all.extend(self.on_roughness(study, comparison, trend));
            }
        }
        for comparison in study.across(Factor::Load) {
            if let Trend::Loads(trend) = &comparison.trend {
                all.extend(self.on_load(study, comparison, trend));
            }
        }
        all.extend(study.takes.iter().flat_map(|take| self.forces(take)));
        all
    }

    fn made(&self, take: &AnalysedRecording) -> Option<&Made> {
        self.made.get(take.file.parse::<usize>().ok()?)
    }

    fn of_group<'g>(&'g self, study: &'g StudyAnalysis, group: &'g Group) -> Vec<&'g Made> {
        let takes = study.takes_of(group);
        takes.filter_map(|take| self.made(take)).collect()
    }

    fn of_comparison<'g>(
        &'g self,
        study: &'g StudyAnalysis,
        comparison: &'g Comparison,
    ) -> Vec<Vec<&'g Made>> {
        let groups = comparison.groups.iter();
        groups.map(|group| self.of_group(study, group)).collect()
    }

    /// `fact` where something is said; what is not said is withheld where it has to be.
    fn judged(&self, about: About, said: Option<bool>, due: Due, words: [String; 2]) -> Conclusion {
        let fact = match said {
            Some(true) => Fact::Right,
            Some(false) => Fact::False,
            None if due == Due::Said && self.is == Is::Right => Fact::Withheld,
            None => Fact::Silent,
        };
        let [said, truth] = words;
        Conclusion {
            about,
            fact,
            said,
            truth,
        }
    }

    /// A period is one of the surface that was touched at all speeds.
    fn period(
        &self,
        study: &StudyAnalysis,
        comparison: &Comparison,
        trend: &SpeedTrend,
    ) -> Conclusion {
        let groups = self.of_comparison(study, comparison);
        let all: Vec<&Made> = groups.concat();
        let mut periods: Vec<f64> = all
            .iter()
            .flat_map(|made| made.surface.iter())
            .flat_map(|surface| surface.combs.iter().map(|(period_m, _)| *period_m))
            .collect();
        periods.sort_by(f64::total_cmp);
        periods.dedup();
        // Ridges of the finger are on all samples.
        let of_finger = |period_m: &f64| {
            let mut surfaces = self.made.iter().filter_map(|made| made.surface.as_ref());
            let several = all.len() < self.made.len();
            several && surfaces.all(|s| s.combs.iter().any(|(other_m, _)| other_m == period_m))
        };
        periods.retain(|period_m| !of_finger(period_m));
        if all.len() == self.made.len() {
            periods.extend(all.iter().filter_map(|made| made.drive_m));
        }
        let is_true = |period: &SpatialPeriod| {
            let mut periods = periods.iter();
            periods.any(|true_m| (period.period_m / true_m - 1.0).abs() <= PERIOD_OFF)
        };
        let period = trend.period.as_ref();
        let said = match period {
            Some(period) if period.outcome == Outcome::Met => Some(is_true(period)),
            // That its lines stay, as a machine's do, is said of a period too.
            Some(period)
                if period.outcome == Outcome::NotMet
                    && period.lines.all_stay()
                    && is_true(period) =>
            {
                Some(false)
            }
            _ => None,
        };
        let words = period.map_or("no period".into(), SpatialPeriod::conclusion);
        let truth = match periods.as_slice() {
            [] => "none".into(),
            all => all
                .iter()
                .map(|m| format!("{:.3} mm", 1e3 * m))
                .collect::<Vec<_>>()
                .join(", "),
        };
        let due = match periods.as_slice() {
            [] => Due::Open,
            _ => Due::Said,
        };
        self.judged(About::Period, said, due, [words, truth])
    }

    /// Samples of one surface are no more than below the JND; those of others are distinguishable. Of copies and mixtures nothing can be said.
    fn pairs(
        &self,
        study: &StudyAnalysis,
        comparison: &Comparison,
        setting: usize,
    ) -> Vec<Conclusion> {
        let Some(found) = study
            .discrimination
            .as_ref()
            .and_then(|d| d.groups(setting))
        else {
            return Vec::new();
        };
        let groups = self.of_comparison(study, comparison);
        let pairs = found.pairs.iter().map(|pair| {
            let [a, b] = [&groups[pair.a], &groups[pair.b]];
            let same = same_surface(a, b);
            let said = match (pair.outcome, same) {
                (Distinguishability::NotDecided, _) => None,
                (Distinguishability::BelowJnd, Some(same)) => Some(same),
                (Distinguishability::ToldApart, Some(same)) => Some(!same),
                (_, None) => Some(false),
            };
            let truth = match same {
                Some(true) => "one surface",
                Some(false) => "two surfaces",
                None => "copies, a mixture, or nothing touched",
            };
            let words = format!(
                "{} and {}{}: {} ({:.2} JND)",
                found.names[pair.a],
                found.names[pair.b],
                if comparison.setting.is_empty() {
                    String::new()
                } else {
                    format!(" at {}", comparison.setting)
                },
                pair.outcome.word(),
                pair.distance_jnd
            );
            let due = same.map_or(Due::Open, |_| Due::Said);
            self.judged(About::Pair, said, due, [words, truth.into()])
        });
        pairs.collect()
    }

    fn on_speed(
        &self,
        study: &StudyAnalysis,
        comparison: &Comparison,
        trend: &SpeedTrend,
    ) -> Option<Conclusion> {
        let groups = self.of_comparison(study, comparison);
        let x = |made: &Made| made.speed_m_s;
        self.slope(
            trend.rms_on_speed.as_ref(),
            &groups,
            x,
            level,
            "rms on speed",
        )
    }

    fn on_load(
        &self,
        study: &StudyAnalysis,
        comparison: &Comparison,
        trend: &LoadTrend,
    ) -> Vec<Conclusion> {
        let groups = self.of_comparison(study, comparison);
        let x = |made: &Made| made.load_n;
        let rms = self.slope(trend.rms_on_load.as_ref(), &groups, x, level, "rms on load");
        let friction = self.slope(
            trend.friction_on_load.as_ref(),
            &groups,
            x,
            friction,
            "friction on load",
        );
        rms.into_iter().chain(friction).collect()
    }

    fn on_roughness(
        &self,
        study: &StudyAnalysis,
        comparison: &Comparison,
        trend: &SampleTrend,
    ) -> Option<Conclusion> {
        let groups = self.of_comparison(study, comparison);
        let x = |made: &Made| {
            made.surface
                .as_ref()
                .map_or(f64::NAN, |surface| surface.ra_m)
        };
        let RoughnessTrend { rms_on_ra, .. } = &trend.roughness;
        self.slope(rms_on_ra.as_ref(), &groups, x, level, "rms on Ra")
    }

    /// The exponent of a power law that has an interval, against that of what was made.
    fn slope(
        &self,
        found: Option<&LogFit>,
        groups: &[Vec<&Made>],
        x: impl Fn(&Made) -> f64,
        y: impl Fn(&Made, &Surface) -> f64,
        what: &str,
    ) -> Option<Conclusion> {
        let found = found?;
        let [low, high] = found.slope_interval?;
        let of = |value: &dyn Fn(&Made) -> f64| -> Vec<f64> {
            let means = groups.iter().map(|all| {
                let values: Vec<f64> = all.iter().map(|made| value(made)).collect();
                mean(&values)
            });
            means.collect()
        };
        let known = |made: &Made| {
            made.surface
                .as_ref()
                .map_or(f64::NAN, |surface| y(made, surface))
        };
        let truth = log_fit(&of(&x), &of(&known)).map(|fit| fit.slope);
        let said = match (found.direction(), truth) {
            // An interval that is too wide says nothing.
            (Direction::NotShown, _) => None,
            (_, None) => Some(false),
            (direction, Some(truth)) => {
                let off = (found.slope - truth).abs();
                let holds = off <= 0.5 * WIDENED * (high - low);
                let contrary = match direction {
                    Direction::Rises => truth < EXPONENT_NONE,
                    _ => truth > -EXPONENT_NONE,
                };
                Some(holds || off <= EXPONENT_OFF && !contrary)
            }
        };
        let words = format!(
            "{what}: exponent {:.2} ({low:.2} to {high:.2})",
            found.slope
        );
        let truth_text = truth.map_or("none".into(), |truth| format!("{truth:.2}"));
        // Three points have intervals that say little.
        let due = match truth {
            Some(truth) if found.points > 3 && truth.abs() > EXPONENT_OFF => Due::Said,
            _ => Due::Open,
        };
        Some(self.judged(About::Slope, said, due, [words, truth_text]))
    }

    /// The mean friction coefficient and normal force of a recording; beside a warning about its forces nothing is said.
    fn forces(&self, take: &AnalysedRecording) -> Option<Conclusion> {
        let made = self.made(take)?;
        let strokes = take.analysis.as_ref().map_or(&[][..], |a| &a.strokes);
        let means = |value: &dyn Fn(&piezotact::feature::StrokeFeatures) -> Option<f64>| {
            let values: Vec<f64> = strokes.iter().filter_map(value).collect();
            (!values.is_empty()).then(|| mean(&values))
        };
        let friction = means(&|s| s.friction_coefficient.map(|v| v.mean));
        let force_n = means(&|s| s.normal_force_n.map(|v| v.mean));
        let warned = take.warnings().iter().any(|warning| {
            let force = warning.kind::<ForceWarning>().is_some();
            let clipped = warning.kind::<ClippingWarning>().is_some();
            force || clipped || warning.kind::<SignalWarning>().is_some()
        });
        let is_true = |found: Option<f64>, truth: Option<f64>| match (found, truth) {
            (Some(found), Some(truth)) => (found / truth - 1.0).abs() <= FRICTION_OFF,
            (found, _) => found.is_none(),
        };
        let surface = made.surface.as_ref();
        let right = is_true(friction, surface.map(|s| s.friction))
            && is_true(force_n, surface.map(|_| made.true_load_n));
        let said = match (friction.or(force_n), right, warned) {
            (None, ..) | (Some(_), false, true) => None,
            (Some(_), right, _) => Some(right),
        };
        let number = |value: Option<f64>| value.map_or("–".into(), |value| format!("{value:.3}"));
        let words = format!(
            "{}: friction {}, normal force {} N in {} strokes",
            take.name,
            number(friction),
            number(force_n),
            strokes.len()
        );
        let truth = match surface {
            Some(surface) => format!("{}, {} N", surface.friction, made.true_load_n),
            None => "nothing slides".into(),
        };
        let due = surface.map_or(Due::Open, |_| Due::Said);
        Some(self.judged(About::Friction, said, due, [words, truth]))
    }
}

fn level(made: &Made, surface: &Surface) -> f64 {
    surface.level_at(made.true_speed_m_s, made.true_load_n)
}

fn friction(_: &Made, surface: &Surface) -> f64 {
    surface.friction
}

/// Whether two groups are of one surface each, and the same; none for copies of each other, mixtures and what was not touched.
fn same_surface(a: &[&Made], b: &[&Made]) -> Option<bool> {
    let one = |all: &[&Made]| -> Option<String> {
        let mut names = all.iter().map(|made| Some(kind_of(made.surface.as_ref()?)));
        let first = names.next()??;
        names
            .all(|name| name.as_ref() == Some(&first))
            .then_some(first)
    };
    let copies = a
        .iter()
        .any(|one| b.iter().any(|other| one.origin == other.origin));
    let [a, b] = [one(a)?, one(b)?];
    (!copies).then_some(a == b)
}

/// What a surface is, whatever it is called.
fn kind_of(surface: &Surface) -> String {
    format!(
        "{:?} {} {}",
        surface.combs, surface.level_m_s2, surface.high_hz
    )
}
