//! A study in words: lines of text and the sentences of its warnings.

use super::{
    AnalysedRecording, BothWays, Comparison, Discrimination, Group, SampleTrend, SpeedTrend,
    StudyAnalysis, Trend,
};
use crate::compare::{
    CommonLine, Confounder, DirectionContrast, FrictionChange, Groups, unless_confounded,
};
use crate::number::digits;
use crate::statistics::RankCorrelation;
use crate::stroke::{Judging, Rule};
use crate::warning::{Merged, Warning, merged_of};

impl AnalysedRecording {
    /// Its strokes and rejects, one a line, with times in s.
    #[must_use]
    pub fn cuts_text(&self) -> String {
        let segmentation = &self.segmentation;
        let mut text = format!(
            "{}: {} stroke{}, {} rejected",
            self.name,
            segmentation.strokes.len(),
            if segmentation.strokes.len() == 1 {
                ""
            } else {
                "s"
            },
            segmentation.rejected.len()
        );
        for stroke in &segmentation.strokes {
            let (from, to) = (
                self.seconds(stroke.steady.start),
                self.seconds(stroke.steady.end),
            );
            text += &format!(
                "\n  stroke    {from:9.3} – {to:9.3} s  ({:.3} s)",
                to - from
            );
        }
        for rejected in &segmentation.rejected {
            let (from, to) = (
                self.seconds(rejected.interval.start),
                self.seconds(rejected.interval.end),
            );
            text += &format!("\n  rejected  {from:9.3} – {to:9.3} s  {}", rejected.reason);
        }
        if let Some(file) = &segmentation.cuts {
            text += &format!("\n  with the cuts in {file}");
        }
        text
    }

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
        let fit =
            fit.map(|fit| unless_confounded(confounders, fit.conclusion("rms", "speed", "speeds")));
        fit.into_iter().chain(period).collect()
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
            Self::Directions(trend) => trend.lines(),
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

    /// What is said of it: its setting, a line for each group, what changes, and of samples which are distinguishable.
    #[must_use]
    pub fn text(&self, groups: Option<&Groups>) -> String {
        let mut lines = Vec::new();
        if !self.setting.is_empty() {
            lines.push(format!("{}:", self.setting));
        }
        lines.extend(self.groups.iter().map(|group| group.summary.line()));
        lines.extend(self.trend_lines());
        let sentences = groups.into_iter().flat_map(Groups::sentences);
        lines.extend(sentences.map(|line| unless_confounded(&self.confounders, line)));
        lines.join("\n")
    }
}

impl BothWays {
    fn lines(&self) -> Vec<String> {
        let mut lines = self.found.of_samples();
        lines.extend(self.found.conclusions());
        lines
    }
}

/// The sentences of all warnings about `takes`, with `words` for a warning: those of one kind once, and of whom.
///
/// Source: house rule; docs/decisions/house.md.
#[must_use]
pub fn warnings_in_words(
    takes: &[AnalysedRecording],
    words: &dyn Fn(&Warning) -> String,
) -> Vec<String> {
    sentences(takes, &super::warnings_of(takes, &[]), words)
}

fn sentences(
    takes: &[AnalysedRecording],
    warnings: &[Merged],
    words: &dyn Fn(&Warning) -> String,
) -> Vec<String> {
    let recordings = (takes.len(), "recordings");
    let sentences = warnings
        .iter()
        .map(|warning| warning.text_of(recordings, words));
    sentences.collect()
}

impl Group {
    /// What its strokes say, and how it is felt, line by line.
    fn lines(&self) -> Vec<String> {
        let duplex = self.duplex.map(|duplex| format!("  texture: {duplex}"));
        let receptors = &self.summary.receptors;
        let levels: Vec<String> = receptors.iter().map(ToString::to_string).collect();
        let receptors = (!levels.is_empty()).then(|| format!("  receptors: {}", levels.join("; ")));
        let line = Some(self.summary.line());
        [line, duplex, receptors].into_iter().flatten().collect()
    }
}

impl StudyAnalysis {
    /// What is asked, line by line.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let Some(asked) = &self.asked else {
            return self.groups.iter().flat_map(Group::lines).collect();
        };
        let discrimination = self.discrimination.as_ref();
        let numbered = asked.comparisons.iter().enumerate();
        let mut lines: Vec<String> = numbered
            .map(|(number, comparison)| {
                comparison.text(discrimination.and_then(|found| found.groups(number)))
            })
            .collect();
        lines.extend(discrimination.map(Discrimination::line));
        lines.extend(asked.directions.iter().map(DirectionContrast::conclusion));
        if asked.by == super::Factor::Touch {
            lines.extend(self.both_ways.iter().flat_map(BothWays::lines));
        }
        lines.extend(self.common_lines.iter().map(CommonLine::conclusion));
        lines
    }

    /// The sentences of all warnings about what is asked, with `words` for a warning: those of one kind once, and of whom.
    #[must_use]
    pub fn warnings_in_words(&self, words: &dyn Fn(&Warning) -> String) -> Vec<String> {
        let groups = match self.asked {
            Some(_) => &[][..],
            None => &self.groups,
        };
        let mut all = sentences(&self.takes, &super::warnings_of(&self.takes, groups), words);
        let comparisons = self.comparisons();
        let warnings: Vec<(Option<&str>, Vec<Warning>)> = comparisons
            .iter()
            .enumerate()
            .map(|(number, comparison)| {
                let setting = Some(comparison.setting.as_str());
                (
                    setting.filter(|setting| !setting.is_empty()),
                    self.warnings_of_comparison(number),
                )
            })
            .collect();
        let warnings = warnings
            .iter()
            .flat_map(|(setting, warnings)| warnings.iter().map(|warning| (*setting, warning)));
        let settings = (comparisons.len(), "settings");
        let warnings = merged_of(warnings);
        all.extend(
            warnings
                .iter()
                .map(|warning| warning.text_of(settings, words)),
        );
        let discrimination = self.discrimination.iter();
        all.extend(discrimination.flat_map(|found| found.warnings().map(words)));
        all
    }

    /// The sentences of all warnings that a report shows, with `words` for a warning.
    #[must_use]
    pub fn warnings_of_report(&self, words: &dyn Fn(&Warning) -> String) -> Vec<String> {
        let of_groups = super::warnings_of(&self.takes, &self.groups);
        let mut all = sentences(&self.takes, &of_groups, words);
        all.extend(self.warnings_of_speeds(words));
        all.extend(self.confounded(words));
        all.extend(self.left_out.iter().map(words));
        let discrimination = self.discrimination.iter();
        all.extend(discrimination.flat_map(|found| found.warnings().map(words)));
        all
    }

    /// What else differs between the groups of what is asked, setting by setting.
    fn confounded(&self, words: &dyn Fn(&Warning) -> String) -> Vec<String> {
        let comparisons = self.comparisons().iter();
        let warnings: Vec<(Option<&str>, &Warning)> = comparisons
            .flat_map(|comparison| {
                let setting = Some(comparison.setting.as_str()).filter(|s| !s.is_empty());
                comparison
                    .warnings
                    .iter()
                    .map(move |warning| (setting, warning))
            })
            .collect();
        let settings = (self.comparisons().len(), "settings");
        let warnings = merged_of(warnings);
        warnings
            .iter()
            .map(|warning| warning.text_of(settings, words))
            .collect()
    }

    /// What spatial periods leave open, setting by setting.
    fn warnings_of_speeds(&self, words: &dyn Fn(&Warning) -> String) -> Vec<String> {
        let across_speeds = self.across(super::Factor::Speed);
        let warnings = across_speeds.iter().flat_map(|comparison| {
            let setting = match comparison.setting.as_str() {
                "" => "across speeds",
                setting => setting,
            };
            let period = match &comparison.trend {
                Trend::Speeds(trend) => trend.period.as_ref(),
                _ => None,
            };
            let found = period.into_iter().flat_map(|period| &period.warnings);
            found.map(move |warning| (Some(setting), warning))
        });
        let settings = (across_speeds.len(), "settings");
        merged_of(warnings)
            .iter()
            .map(|warning| warning.text_of(settings, words))
            .collect()
    }
}
