//! Reports on strokes: what was cut, what the strokes hold, and what changes from group to group.

mod apart;
mod cuts;
mod figures;
mod groups;
mod touching;
mod way;

use figures::{Courses, Sets, SpectralAxes, Spread};

use super::{
    AnalysedRecording, AnalysisDocument, Comparison, ComparisonDocument, CutsDocument, Factor,
    Group, SpeedTrend, StudyAnalysis, Trend, strokes_table,
};
use crate::compare::Summary;
use crate::document::FailedFile;
use crate::feature::{Receptor, Weighting};
use crate::number::{counted, p_text, signed};
use crate::page::{Block, Cell, Column, Fact, Number, Page, Shown, Table};
use crate::recording::BenchKind;
use crate::statistics::Direction;
use crate::stroke::{CutBy, Reason};

/// Recordings whose signals are shown; the others are in the tables.
const SHOWN: usize = 4;
/// Settings whose spectra are shown; the figure over all of them holds the rest.
const SETTINGS_SHOWN: usize = 3;
/// What small dots beside a mean are.
const DOTS: &str = "mean and standard deviation over strokes; small dots: the single strokes, where they are five or fewer.";

impl Shown for CutsDocument<'_> {
    fn page(&self) -> Page {
        cuts::page(self.takes, self.failed)
    }
}

impl Shown for AnalysisDocument<'_> {
    fn page(&self) -> Page {
        self.study.page()
    }
}

impl Shown for ComparisonDocument<'_> {
    fn page(&self) -> Page {
        self.study.page()
    }
}

impl StudyAnalysis {
    /// The groups, what changes from one to the next, and how it was done; figures of signals, and what changes beside what is
    /// asked, where they were computed with [`super::Breadth::Report`].
    fn page(&self) -> Page {
        let title = match &self.asked {
            Some(_) => format!("Comparison by {}", self.by_name()),
            None => format!("Features of the strokes, by {}", self.by_name()),
        };
        let discrimination = self.discrimination.as_ref();
        let takes = self.takes.as_slice();
        let shown = match self.example {
            Some(_) => signals(takes, SHOWN),
            None => Vec::new(),
        };
        let sections = [
            (String::new(), self.concluded()),
            ("Groups".into(), groups::blocks(self)),
            ("Spectra of the groups".into(), self.spectra()),
            ("Along the way".into(), way::blocks(&self.groups)),
            (
                "Distinguishable samples".into(),
                discrimination.map_or_else(Vec::new, apart::blocks),
            ),
            ("Across samples".into(), self.samples()),
            ("Across speeds".into(), self.speeds()),
            ("Across loads".into(), touching::blocks(self, Factor::Load)),
            (
                "Across directions".into(),
                touching::blocks(self, Factor::Direction),
            ),
            (
                format!("Across {}", self.by_name()),
                touching::blocks(self, Factor::Label),
            ),
            ("Active and passive touch".into(), self.active_passive()),
            self.single(),
            ("Signals and cuts".into(), shown),
            (
                "Rejected parts".into(),
                cuts::rejected(takes).into_iter().collect(),
            ),
        ];
        let page = Page::new(title, "").rows(strokes_table(takes));
        let page = sections
            .into_iter()
            .filter(|(_, blocks)| !blocks.is_empty())
            .fold(page, |page, (heading, blocks)| {
                page.section(&heading, blocks)
            });
        let page = page.section("Warnings", [Block::warnings("", self.warnings())]);
        ended(page, takes, &self.failed)
    }

    /// What a person wants to know first.
    fn concluded(&self) -> Vec<Block> {
        let conclusions = self.conclusions().into_iter();
        let mut blocks: Vec<Block> = conclusions
            .map(|text| Block::conclusion(text, None))
            .collect();
        let numbers = [
            Number::new(counted(self.takes.len(), "recording"), "analysed"),
            Number::new(
                counted(self.strokes(), "stroke"),
                format!("in {}", counted(self.groups.len(), "group")),
            ),
        ];
        blocks.push(Block::numbers(
            numbers.into_iter().chain(signs(&self.takes)),
        ));
        blocks
    }

    /// What is compared, as a person calls it.
    fn by_name(&self) -> String {
        let first = self.takes.first().and_then(|take| take.label.as_ref());
        match first {
            Some(label) if self.by == Factor::Label => label.name.clone(),
            _ => self.by.to_string(),
        }
    }

    /// The unit of the vibration.
    fn unit(&self) -> String {
        let first = self.groups.first();
        first.map_or(String::new(), |group| group.summary.unit.to_string())
    }

    /// The axes of all figures of spectra: what is compared has one scale.
    fn spectral_axes(&self) -> SpectralAxes {
        let band = self
            .band_hz
            .map_or((1.0, 1000.0), |[low, high]| (low, high));
        let all = self.asked.iter().chain(&self.beside);
        let compared = all.flat_map(|across| &across.comparisons);
        let compared = compared.flat_map(|comparison| &comparison.groups);
        let both = self.both_ways.iter();
        let both = both.flat_map(|both| both.active.iter().chain(&both.passive));
        let groups = self.groups.iter().chain(compared).chain(both);
        SpectralAxes::around(
            band,
            &groups.map(|group| &group.summary).collect::<Vec<_>>(),
        )
    }

    fn spectra(&self) -> Vec<Block> {
        let summaries: Vec<&Summary> = self.groups.iter().map(|g| &g.summary).collect();
        if summaries.len() < 2 {
            return Vec::new();
        }
        let chart = figures::psds(&summaries, &self.spectral_axes());
        let caption = "Mean power spectral density of each group, over all its strokes.";
        vec![chart.captioned(caption).into()]
    }

    /// What follows from `comparison`, where it does not stand at the top already.
    fn trend(&self, comparison: &Comparison) -> Vec<Block> {
        let asked = self.comparisons();
        if asked.iter().any(|one| std::ptr::eq(one, comparison)) {
            return Vec::new();
        }
        let lines = comparison.trend_lines().into_iter();
        lines.map(Block::text).collect()
    }

    fn samples(&self) -> Vec<Block> {
        let all = self.across(Factor::Sample);
        let names = names_of(all);
        let of = |value: fn(&Summary) -> Option<Spread>| -> Sets {
            let settings = all.iter().map(|comparison| {
                let named = |name: &String| {
                    let mut groups = comparison.groups.iter();
                    let group = groups.find(|g| g.summary.name == *name)?;
                    value(&group.summary)
                };
                (
                    comparison.setting.clone(),
                    names.iter().map(named).collect(),
                )
            });
            settings.collect()
        };
        if all.is_empty() {
            return Vec::new();
        }
        let (rms, friction) = (of(Spread::of_rms), of(Spread::of_friction));
        let label = format!("rms, {}", self.unit());
        let mut blocks = vec![Block::from(
            figures::by_name(&names, label, "sample", &rms)
                .captioned(format!("Rms of the vibration of each sample: {DOTS}")),
        )];
        let mut values = friction.iter().flat_map(|(_, values)| values);
        if values.any(Option::is_some) {
            let label = "friction coefficient".into();
            let chart = figures::by_name(&names, label, "sample", &friction);
            let caption = format!("Friction coefficient of each sample: {DOTS}");
            blocks.push(Block::from(chart.captioned(caption)));
        }
        let axes = self.spectral_axes();
        for comparison in all {
            let Trend::Samples(changes) = &comparison.trend else {
                continue;
            };
            let summaries = comparison.summaries();
            if !comparison.setting.is_empty() {
                blocks.push(Block::heading(comparison.setting.as_str()));
                let caption = "Mean power spectral density of each sample.";
                blocks.push(figures::psds(&summaries, &axes).captioned(caption).into());
            }
            let trend = &changes.roughness;
            if trend.samples.len() > 2 {
                blocks.push(figures::in_order(&summaries, trend).into());
                blocks.push(figures::roughness(&summaries, trend).into());
                let fit = trend.rms_on_ra.as_ref();
                blocks.extend(fit.map(|fit| {
                    Block::note(format!("Power law of rms on Ra: R² {:.2}.", fit.r_squared))
                }));
            }
            blocks.extend(self.trend(comparison));
        }
        blocks
    }

    /// What changes with the speed.
    fn speeds(&self) -> Vec<Block> {
        let all = self.across(Factor::Speed);
        let speeds = || {
            let comparisons = all.iter();
            comparisons.filter_map(|comparison| match &comparison.trend {
                Trend::Speeds(trend) => Some((comparison, trend)),
                _ => None,
            })
        };
        if all.is_empty() {
            return Vec::new();
        }
        let course = |comparison: &Comparison| {
            let course = comparison.summaries().into_iter().filter_map(|s| {
                let speed = s.speed_m_s?;
                Some((speed.mean * 1e3, Spread::of_rms(s)?))
            });
            (comparison.setting.clone(), course.collect())
        };
        let courses: Courses = all.iter().map(course).collect();
        let label = format!("rms, {}", self.unit());
        let mut blocks = vec![Block::from(
            figures::over_quantity("speed, mm/s", label, &courses)
                .captioned(format!("Rms of the vibration at each speed: {DOTS}")),
        )];
        if all.len() > 1 {
            let mut table =
                Table::new(SPEED_COLUMNS.map(|(heading, name)| Column::new(heading, name)));
            table.rows = speeds().map(|(one, trend)| speed_row(one, trend)).collect();
            blocks.push(table.into());
        }
        let axes = self.spectral_axes();
        let shown = || speeds().take(SETTINGS_SHOWN);
        let peak_axes =
            figures::period_axes(shown().filter_map(|(_, trend)| trend.period.as_ref()));
        if all.len() > SETTINGS_SHOWN {
            let text = format!("Spectra of the first {SETTINGS_SHOWN} of {}:", all.len());
            blocks.push(Block::note(text));
        }
        for (comparison, trend) in shown() {
            // One setting has its spectra above.
            if !comparison.setting.is_empty() {
                blocks.push(Block::heading(comparison.setting.as_str()));
                let chart = figures::psds(&comparison.summaries(), &axes);
                let caption = "Mean power spectral density at each speed.";
                blocks.push(chart.captioned(caption).into());
            }
            blocks.extend(self.trend(comparison));
            if let Some(period) = &trend.period {
                blocks.push(figures::period(period, &peak_axes).into());
                blocks.push(Block::note(format!(
                    "The peaks are on average over speeds {} dB above the background.",
                    signed(period.prominence_db, 1)
                )));
            }
        }
        blocks
    }

    fn active_passive(&self) -> Vec<Block> {
        let both = self.both_ways.as_ref();
        let Some(both) = both.filter(|both| !both.found.pairs.is_empty()) else {
            return Vec::new();
        };
        let compared = &both.found;
        let axes = self.spectral_axes();
        // Where the same samples are compared in one way of touching, their figure stands there.
        let is_shown = |shared: &[&Summary]| {
            let settings = self.across(Factor::Sample).iter();
            let mut settings = settings.filter(|comparison| !comparison.setting.is_empty());
            settings.any(|comparison| {
                let there = comparison.summaries();
                let same = |(a, b): (&&Summary, &&Summary)| a.name == b.name && a.psd == b.psd;
                there.len() == shared.len() && there.iter().zip(shared).all(same)
            })
        };
        let (mut blocks, mut elsewhere) = (Vec::new(), false);
        for (way, groups) in [("Passive", &both.passive), ("Active", &both.active)] {
            let summaries = groups.iter().map(|group: &Group| &group.summary);
            let shared: Vec<&Summary> = summaries
                .filter(|s| compared.pairs.iter().any(|pair| pair.sample == s.name))
                .collect();
            if is_shown(&shared) {
                elsewhere = true;
                continue;
            }
            let caption = format!("{way} touch: mean power spectral density of each sample.");
            blocks.push(figures::psds(&shared, &axes).captioned(caption).into());
        }
        if elsewhere {
            let text = "Mean power spectral densities: see “Across samples”.";
            blocks.insert(0, Block::note(text));
        }
        let mut table = Table::new([
            Column::new("sample", "sample"),
            Column::new("difference of the PSDs, dB rms", "difference_db_rms"),
            Column::new("active − passive level, dB", "level_difference_db"),
        ]);
        let pairs = compared.pairs.iter();
        let rounded =
            |value: Option<f64>| value.map_or(Cell::Missing(()), |db| Cell::rounded(db, 1));
        table.rows = pairs
            .map(|pair| {
                vec![
                    Cell::from(pair.sample.as_str()),
                    rounded(pair.difference_db_rms),
                    rounded(pair.level_difference_db),
                ]
            })
            .collect();
        blocks.push(table.into());
        blocks.push(Block::note(format!(
            "PSDs over {}, levels over all frequencies.",
            compared.band_hz
        )));
        if self
            .asked
            .as_ref()
            .is_none_or(|asked| asked.by != Factor::Touch)
        {
            blocks.extend(compared.conclusions().into_iter().map(Block::text));
        }
        blocks
    }

    /// One stroke, and all strokes of its recording.
    fn single(&self) -> (String, Vec<Block>) {
        let example = self.example.as_ref();
        let shown = example.and_then(|example| {
            let take = &self.takes[example.take];
            Some((example, take, take.analysis.as_ref()?))
        });
        let Some((example, take, analysis)) = shown else {
            return (String::new(), Vec::new());
        };
        let unit = analysis.unit.to_string();
        let stroke = figures::stroke(take, example, &unit).into_iter();
        let spectra = figures::strokes_with_mean(analysis);
        (
            format!("Single strokes and their mean: {}", take.name),
            stroke.chain(spectra).map(Block::from).collect(),
        )
    }
}

/// The signs of the normal force in contact and of the motion in strokes; of what was measured.
fn signs(takes: &[AnalysedRecording]) -> impl Iterator<Item = Number> {
    let zeros = takes.iter();
    let zeros = zeros.filter_map(|take| take.segmentation.force_zeros.as_ref());
    let signs: Vec<f64> = zeros.map(|zeros| zeros.sign).collect();
    let negative = signs.iter().filter(|sign| **sign < 0.0).count();
    let force = (!signs.is_empty()).then(|| {
        let of = both_signs(signs.len() - negative, negative, "recording");
        Number::new(of, "sign of the normal force in contact")
    });
    let motions = takes.iter().filter_map(|take| take.signs_of_motion);
    let motion = motions.reduce(|a, b| [a[0] + b[0], a[1] + b[1]]);
    let motion = motion.map(|[positive, negative]| {
        let of = both_signs(positive, negative, "stroke");
        Number::new(of, "sign of the motion")
    });
    force.into_iter().chain(motion)
}

/// How many of `what` have which sign.
fn both_signs(positive: usize, negative: usize, what: &str) -> String {
    match (positive, negative) {
        (_, 0) => "positive".into(),
        (0, _) => "negative".into(),
        _ => format!(
            "positive in {}, negative in {negative}",
            counted(positive, what)
        ),
    }
}

/// The names of the groups of all comparisons, in their order: first those of the one with most.
fn names_of(comparisons: &[Comparison]) -> Vec<String> {
    let mut longest: Vec<&Comparison> = comparisons.iter().collect();
    longest.sort_by_key(|comparison| std::cmp::Reverse(comparison.groups.len()));
    let mut names: Vec<String> = Vec::new();
    for group in longest
        .into_iter()
        .flat_map(|comparison| &comparison.groups)
    {
        if !names.contains(&group.summary.name) {
            names.push(group.summary.name.clone());
        }
    }
    names
}

const SPEED_COLUMNS: [(&str, &str); 6] = [
    ("setting", "setting"),
    ("exponent of rms versus speed", "exponent"),
    ("95 % interval", "exponent_interval"),
    ("trend", "trend"),
    ("spatial period, mm", "period_mm"),
    ("95 % interval, mm", "period_interval_mm"),
];

/// A setting's slope of rms on speed and its spatial period, each with its interval.
fn speed_row(comparison: &Comparison, trend: &SpeedTrend) -> Vec<Cell> {
    let fit = trend.rms_on_speed.as_ref();
    let period = trend.standing_out();
    let range = |interval: Option<[f64; 2]>, scale: f64, decimals: usize| {
        interval.map_or(Cell::Missing(()), |[low, high]| {
            let [low, high] = [low, high].map(|end| signed(end * scale, decimals));
            Cell::Text(format!("{low} to {high}"))
        })
    };
    let rounded = |value: Option<f64>, decimals: usize| {
        value.map_or(Cell::Missing(()), |value| Cell::rounded(value, decimals))
    };
    let direction = fit.map_or(Cell::Missing(()), |fit| {
        let word = match fit.direction() {
            Direction::Rises => "rises",
            Direction::Falls => "falls",
            Direction::NotShown => "no trend shown",
        };
        Cell::Text(match fit.p_value {
            Some(p) => format!("{word}, {}", p_text(p)),
            None => "not decided".into(),
        })
    });
    vec![
        Cell::from(comparison.setting.as_str()),
        rounded(fit.map(|fit| fit.slope), 2),
        range(fit.and_then(|fit| fit.slope_interval), 1.0, 2),
        direction,
        rounded(period.map(|p| p.period_m * 1e3), 3),
        range(period.and_then(|p| p.interval_m), 1e3, 3),
    ]
}

/// The signals of the first `most` recordings with their cuts.
fn signals(takes: &[AnalysedRecording], most: usize) -> Vec<Block> {
    let mut blocks = Vec::new();
    if takes.len() > most {
        blocks.push(Block::note(format!(
            "The first {most} of {} recordings; the table of cuts (CSV) lists those of all.",
            takes.len()
        )));
    }
    let shown = &takes[..takes.len().min(most)];
    for (take, figure) in shown.iter().zip(figures::signals(shown)) {
        blocks.extend([Block::heading(take.name.as_str()), figure.into()]);
    }
    blocks
}

/// `page` with what is simulated, the files that failed, and how it was done.
fn ended(page: Page, takes: &[AnalysedRecording], failed: &[FailedFile]) -> Page {
    let benches = takes.iter();
    let page = page.simulated(BenchKind::simulated(
        benches.map(|take| take.recording.about.provenance.bench),
    ));
    let failed = failed.iter().map(|file| Block::text(file.why.as_str()));
    let failed: Vec<Block> = failed.collect();
    let page = match failed.is_empty() {
        true => page,
        false => page.section("Files without a result", failed),
    };
    page.section("Methods", [Block::facts(methods(takes))])
}

/// How it was done, so that it can be written into a paper.
fn methods(takes: &[AnalysedRecording]) -> Vec<Fact> {
    let mut facts: Vec<Fact> = Vec::new();
    let mut add = |name: &str, text: String| {
        let fact = Fact::new(name, text);
        if !facts.contains(&fact) {
            facts.push(fact);
        }
    };
    for take in takes {
        add("strokes", take.segmentation.rule.sentence());
        if take.sections > 1 {
            let sections = counted(take.sections, "section");
            add(
                "sections",
                format!(
                    "{}: larger than memory, and cut and analysed in {sections} that end where nothing touches; the zero and the sign of a \
                     force and the usual level of a vibration are those of a section.",
                    take.name
                ),
            );
        }
        if let Some(text) = take.features_text() {
            add("features", text);
        }
        let channels = &take.segmentation.roles.vibration;
        if take.analysis.is_some() && channels.len() > 1 {
            add("several channels of vibration", several(channels));
        }
        if let Some(text) = person(take) {
            add("cuts of a file", text);
        }
    }
    if takes.iter().any(|take| take.analysis.is_some()) {
        add(
            "friction coefficient",
            "√(Fx² + Fy²)/Fz for every sample of a stroke, with each force relative to its zero while the finger is lifted; not \
             given below 10 mN."
                .into(),
        );
        let bands = Receptor::ALL.iter().map(|receptor| match receptor.band() {
            Ok(band) => format!("{} {band}", receptor.name()),
            Err(_) => receptor.name().to_owned(),
        });
        let bands: Vec<String> = bands.collect();
        add(
            "mechanoreceptor bands",
            format!("after the filter: {}.", bands.join(", ")),
        );
        add(
            "kurtosis",
            "of the filtered vibration: mean of the fourth power over the square of the mean square, 3 for Gaussian noise.".into(),
        );
        add(
            "spread of levels",
            "standard deviation of the levels of parts of 0.1 s, dB.".into(),
        );
        add(
            "Pacinian power",
            format!("{}.", Weighting::Pacinian.source()),
        );
    }
    facts
}

/// How the channels of one recording are taken together.
fn several(channels: &[String]) -> String {
    format!(
        "{} ({}) are taken together stroke by stroke: rms and amplitude spectrum are the root of the mean of the squares over channels, \
         PSDs and kurtosis the mean, the spread of levels that of the sum of their powers, the peak the largest of any channel.",
        counted(channels.len(), "channel"),
        channels.join(", ")
    )
}

/// What a file of cuts decides about a recording.
fn person(take: &AnalysedRecording) -> Option<String> {
    let segmentation = &take.segmentation;
    let file = segmentation.cuts.as_ref()?;
    let strokes = segmentation.strokes.iter();
    let strokes = strokes
        .filter(|stroke| stroke.cut_by == CutBy::Person)
        .count();
    let rejected = segmentation.rejected.iter();
    let excluded = rejected.filter(|part| matches!(part.reason, Reason::ByPerson { .. }));
    Some(format!(
        "{file}: {} as it states, {} left out",
        counted(strokes, "stroke"),
        counted(excluded.count(), "stroke")
    ))
}
