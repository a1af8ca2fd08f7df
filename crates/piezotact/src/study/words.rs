//! A study in words: its conclusions, and its warnings.

use super::{
    AnalysedRecording, BothWays, Comparison, Discrimination, Group, SampleTrend, SpeedTrend,
    StudyAnalysis, Trend,
};
use crate::compare::{
    CommonLine, Confounder, Contrast, FrictionChange, Groups, friction_conclusion,
    unless_confounded,
};
use crate::criterion::Outcome;
use crate::number::digits;
use crate::statistics::RankCorrelation;
use crate::stroke::{Judging, Rule};
use crate::warning::{Merged, Warning, merged_of};

impl AnalysedRecording {
    /// How its features were computed, as it can be written into a paper; `None` before it is analysed.
    #[must_use]
    pub fn features_text(&self) -> Option<String> {
        let analysis = self.analysis.as_ref()?;
        let config = &analysis.config;
        let gesture = config.high_pass;
        Some(format!(
            "{}; PSDs by Welch's method: {} window, {} samples ({:.2} Hz) with {:.0} % overlap, one-sided; band for peaks and centroid {}.",
            gesture.map_or("no filter".into(), |h| h.to_string()),
            config.welch.window.name(),
            config.welch.segment,
            analysis.psd.resolution_hz,
            config.welch.overlap * 100.0,
            config.band
        ))
    }
}

impl Rule {
    /// How strokes were cut, as it can be written into a paper.
    #[must_use]
    pub fn sentence(&self) -> String {
        match self {
            Self::Force(r) => format!(
                "Strokes by normal force: contact begins above {:.3} N and ends below {:.3} N, relative to the drifting zero, \
                smoothed over {:.0} ms; {:.0} ms of landing and {:.0} ms of take-off are cut off; {}; duration at least {:.1} \
                s; mean force within ±{:.0} % of {}.",
                r.on_n.0,
                r.off_n.0,
                r.smoothing_s.0 * 1e3,
                r.landing_s.0 * 1e3,
                r.take_off_s.0 * 1e3,
                match r.judging {
                    Judging::Sliding => "only where the finger slides",
                    Judging::ContactOnly => "whether the finger slides or not",
                },
                r.shortest_s.0,
                r.tolerance_share * 100.0,
                r.load_n
                    .map_or("the median of the strokes".into(), |load| load.to_string())
            ),
            Self::Speed(r) => format!(
                "Strokes by the plateau of the speed: within ±{:.0} %, duration at least {:.1} s, while the normal force is \
                above {:.3} N.",
                r.tolerance_share * 100.0,
                r.shortest_s.0,
                r.touch_n.0
            ),
            Self::Whole => "The whole recording is one stroke.".into(),
            Self::Played => "What was felt while a drive played is one stroke.".into(),
        }
    }
}

impl Discrimination {
    /// How it was found, or why it is withheld, in a line.
    #[must_use]
    pub fn line(&self) -> String {
        match self {
            Self::Found(found) => found.sentence.clone(),
            Self::Withheld { sentence, .. } => sentence.clone(),
        }
    }
}

impl SampleTrend {
    /// What strokes that were not repeated leave open.
    #[must_use]
    pub fn one_stroke_each(&self) -> Option<String> {
        (self.single_strokes > 0).then(|| {
            format!(
                "{} of {} samples have only one stroke: the variability between strokes of one sample is not known, so differences between samples are not decided; record 10 or more",
                self.single_strokes, self.samples
            )
        })
    }

    fn lines(&self) -> Vec<String> {
        let trend = &self.roughness;
        let rms_on_ra = trend.rms_on_ra.as_ref();
        let rms = trend.rms_rank_correlation.as_ref();
        let friction = trend.friction_rank_correlation.as_ref();
        let on_rms = self.friction_on_rms.as_ref();
        let with_size =
            |ranks: &RankCorrelation, change: Option<FrictionChange>, x: &str| match change {
                Some(change) => change.conclusion(ranks, x),
                None => ranks.conclusion("friction", x, "samples"),
            };
        [
            rms_on_ra.map(|fit| fit.conclusion("rms", "Ra", "samples")),
            rms.map(|found| found.conclusion("rms", "Ra", "samples")),
            friction.map(|found| with_size(found, trend.friction_change, "Ra")),
            on_rms.map(|found| with_size(found, self.friction_change_on_rms, "rms")),
            self.one_stroke_each(),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl SpeedTrend {
    /// What changes; a spatial period does so with nothing but the speed.
    fn lines(&self, confounders: &[Confounder]) -> Vec<String> {
        let fit = self.rms_on_speed.as_ref();
        let period = self.period.as_ref().map(|period| {
            let peaks: Vec<String> = period
                .peaks
                .iter()
                .map(|p| {
                    format!(
                        "{} Hz at {} mm/s",
                        digits(p.frequency_hz),
                        digits(p.speed_m_s * 1e3)
                    )
                })
                .collect();
            format!(
                "{}: {}; {}",
                period.conclusion(),
                peaks.join(", "),
                period.lines.likelihoods()
            )
        });
        let rms = fit.map(|fit| fit.conclusion("rms", "speed", "speeds"));
        let friction = self.friction_on_speed.as_ref();
        let friction =
            friction.map(|fit| friction_conclusion(fit, self.friction_change, ["speed", "speeds"]));
        let fits = rms.into_iter().chain(friction);
        let fits = fits.map(|said| unless_confounded(confounders, said));
        fits.chain(period).collect()
    }
}

impl Trend {
    /// What changes, line by line.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        match self {
            Self::Samples(trend) => trend.lines(),
            Self::Speeds(trend) => trend.lines(&[]),
            Self::Loads(trend) => trend.lines(),
            Self::Values(trend) => trend.lines(),
            Self::Participants { level_spread } => {
                let spread = level_spread.iter();
                spread
                    .map(crate::compare::LevelSpread::conclusion)
                    .collect()
            }
            Self::Touch {} => Vec::new(),
        }
    }
}

impl Comparison {
    /// What changes, line by line, as not decided where something else differs as completely.
    #[must_use]
    pub fn trend_lines(&self) -> Vec<String> {
        match &self.trend {
            Trend::Speeds(trend) => trend.lines(&self.confounders),
            other => {
                let lines = other.lines().into_iter();
                let lines = lines.map(|line| unless_confounded(&self.confounders, line));
                lines.collect()
            }
        }
    }

    /// What is concluded of it, each with its setting: what changes, and of samples which are distinguishable.
    fn conclusions(&self, groups: Option<&Groups>) -> Vec<String> {
        let sentences = groups.into_iter().flat_map(Groups::sentences);
        let sentences = sentences.map(|line| unless_confounded(&self.confounders, line));
        let all = self.trend_lines().into_iter().chain(sentences);
        all.map(|line| match self.setting.as_str() {
            "" => line,
            setting => format!("{setting}: {line}"),
        })
        .collect()
    }
}

impl BothWays {
    fn lines(&self) -> Vec<String> {
        let mut lines = self.found.of_samples();
        lines.extend(self.found.conclusions());
        lines
    }
}

/// Up to so many groups are said one by one how they are felt; a table holds those of more.
pub(super) const GROUPS_FELT: usize = 8;

impl Group {
    /// How it is felt.
    fn felt(&self) -> Option<String> {
        let duplex = self.duplex.map(|duplex| format!("texture {duplex}"));
        let receptors = &self.summary.receptors;
        let levels: Vec<String> = receptors.iter().map(ToString::to_string).collect();
        let receptors = (!levels.is_empty()).then(|| levels.join("; "));
        let all: Vec<String> = [duplex, receptors].into_iter().flatten().collect();
        (!all.is_empty()).then(|| format!("{}: {}", self.summary.name, all.join("; ")))
    }

    /// What its strokes say along the way, where the motion was measured.
    fn along_the_way(&self) -> Option<String> {
        let period = self.way.as_ref()?.period.as_ref();
        let found = period.filter(|period| period.outcome != Outcome::NotMet);
        let said = found.map_or_else(
            || "no spatial period stands out along the way".to_owned(),
            |period| format!("{}; {}", period.conclusion(), period.lines.likelihoods()),
        );
        Some(format!("{}: {said}", self.summary.name))
    }
}

impl StudyAnalysis {
    /// What is concluded of what is asked, one sentence each.
    #[must_use]
    pub fn conclusions(&self) -> Vec<String> {
        let common = self.common_lines.iter().map(CommonLine::conclusion);
        let few = self.groups.len() <= GROUPS_FELT;
        let groups = || self.groups.iter().filter(|_| few);
        let periods = groups().filter_map(Group::along_the_way);
        let Some(asked) = &self.asked else {
            let felt = groups().filter_map(Group::felt);
            return felt.chain(periods).chain(common).collect();
        };
        let discrimination = self.discrimination.as_ref();
        let numbered = asked.comparisons.iter().enumerate();
        let mut lines: Vec<String> = numbered
            .flat_map(|(number, comparison)| {
                let groups = discrimination.and_then(|found| found.groups(number));
                comparison.conclusions(groups)
            })
            .collect();
        lines.extend(periods);
        lines.extend(discrimination.map(Discrimination::line));
        lines.extend(asked.contrasts.iter().map(Contrast::conclusion));
        if asked.by == super::Factor::Touch {
            lines.extend(self.both_ways.iter().flat_map(BothWays::lines));
        }
        lines.extend(common);
        lines
    }

    /// All warnings about what is asked, and about what changes beside it: those of one kind once, and of whom.
    #[must_use]
    pub fn warnings(&self) -> Vec<Merged> {
        let groups = match self.asked {
            Some(_) => &[][..],
            None => &self.groups,
        };
        let mut all = super::warnings_of(&self.takes, groups);
        let comparisons = self.comparisons();
        let mut found: Vec<(&str, Vec<Warning>)> = (0..comparisons.len())
            .map(|number| {
                let setting = comparisons[number].setting.as_str();
                (setting, self.warnings_of_comparison(number))
            })
            .collect();
        for across in &self.beside {
            found.extend(across.comparisons.iter().map(|comparison| {
                let setting = comparison.setting.as_str();
                (setting, comparison.trend_warnings().to_vec())
            }));
        }
        let named = found.iter().flat_map(|(setting, warnings)| {
            let setting = Some(*setting).filter(|setting| !setting.is_empty());
            warnings.iter().map(move |warning| (setting, warning))
        });
        let settings = (comparisons.len(), "settings");
        let of_settings = merged_of(named).into_iter();
        all.extend(of_settings.map(|warning| warning.of_all(settings)));
        let discrimination = self.discrimination.iter();
        let of_pairs = discrimination.flat_map(Discrimination::warnings);
        all.extend(merged_of(of_pairs.map(|warning| (None, warning))));
        all
    }
}
