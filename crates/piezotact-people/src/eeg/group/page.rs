//! What differs over people, in sentences, tables and a report.

use piezotact::criterion::Outcome;
use piezotact::figure::{Axis, Chart, Figure, Line, Maps, Mark, Scale, Tone};
use piezotact::number::{counted, digits, p_text, plus, rounded, signed};
use piezotact::page::{self, Block, Cell, Column, Number, Page, Table};

use super::contrasts::unit_of;
use super::people::unequal;
use super::{ALL_SURFACES, EegStats, Gradient, LEVEL, Shown, TaskClusters, TaskContrast};
use crate::eeg::cluster::Tried;
use crate::eeg::erd::Mode;
use crate::eeg::person::{FEWEST_OF_A_MAP, head_map};

/// The convention of signs, below each figure.
const SIGNS: &str = "Negative: desynchronisation, less power than in the baseline.";
/// What a map of a difference shows.
const SIGNS_OF_DIFFERENCES: &str =
    "Negative: more desynchronisation in the task that is named first; positive: in the other one.";
/// What maps of tasks are called.
const TASKS: &str = "Tasks";
/// How much of a place on an axis of names the tasks take.
const ROOM: f64 = 0.62;

impl TaskContrast {
    /// The difference, its interval and what is decided.
    fn short_sentence(&self, unit: Mode) -> String {
        let Some(found) = &self.contrast else {
            return self.sentence(unit);
        };
        let [a, b] = &self.tasks;
        let [low, high] = found.difference.interval;
        format!(
            "{b} − {a}, {}, {}, {}: {} {} (95 % {} to {}): {}",
            self.surface,
            self.region,
            self.band,
            plus(found.difference.mean, 1),
            unit_of(unit),
            plus(low, 1),
            plus(high, 1),
            self.words()
        )
    }

    /// What is decided, in words.
    fn words(&self) -> &'static str {
        match (self.outcome(), self.within_margin()) {
            (Outcome::Met, Some(Outcome::Met)) => "they differ, by less than the margin",
            (Outcome::Met, Some(Outcome::NotMet)) => "they differ, by more than the margin",
            (Outcome::Met, _) => "they differ",
            (_, Some(Outcome::Met)) => "alike within the margin",
            _ if self.may_be_of_baselines() => {
                "not decided, as the baselines may be all that differs"
            }
            _ => "not decided",
        }
    }

    /// The contrast in one sentence, in `unit`.
    #[must_use]
    pub fn sentence(&self, unit: Mode) -> String {
        let [a, b] = &self.tasks;
        let place = format!("{}, {}, {}", self.surface, self.region, self.band);
        let Some(found) = &self.contrast else {
            let people = counted(self.people.len(), "participant");
            let reason = match self.people.len() {
                0..3 => format!("{people} in both; at least 3 are needed"),
                _ => format!(
                    "the difference is the same in all {people}; check that they are different measurements"
                ),
            };
            return format!("{b} − {a}, {place}: not decided, {reason}");
        };
        let difference = found.difference;
        let unit = unit_of(unit);
        let [low, high] = difference.interval;
        let [small, large] = found.d_z_interval;
        let holm = self.p_holm.unwrap_or(1.0);
        let outcome = self.words();
        format!(
            "{b} − {a}, {place}: {} {unit} (95 % {} to {}), d_z {} ({} to {}), t({}) = {}, {} after Holm over {}, n = {}: {outcome}",
            plus(difference.mean, 2),
            plus(low, 2),
            plus(high, 2),
            plus(found.d_z, 2),
            plus(small, 2),
            plus(large, 2),
            difference.pairs - 1,
            plus(difference.t, 2),
            p_text(holm),
            self.holm_over,
            difference.pairs
        )
    }
}

impl Gradient {
    /// Whether the order holds, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let holds = match self.outcome() {
            Outcome::Met => "holds",
            Outcome::NotMet => "does not hold",
            Outcome::NotDecided => "not decided",
        };
        let open = self
            .criteria
            .iter()
            .filter(|step| step.outcome != Outcome::Met);
        let open = open.filter_map(|step| match &step.what {
            super::GroupCriterion::Below { tasks: [a, b], .. } => Some(format!("{a} > {b}")),
            _ => None,
        });
        let open: Vec<String> = open.collect();
        let holds = match open.is_empty() {
            true => holds.to_owned(),
            false => format!("{holds} (open: {})", open.join(", ")),
        };
        format!(
            "Desynchronisation {} ({}, {}): {holds}",
            self.tasks.join(" > "),
            self.region,
            self.band
        )
    }
}

impl TaskClusters {
    /// Whether the tasks differ somewhere: met, or not decided.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of_all(self.criteria.iter().map(|criterion| criterion.outcome))
    }

    fn short_sentence(&self) -> String {
        let [a, b] = &self.tasks;
        let outcome = match self.outcome() {
            Outcome::Met => "differ somewhere over electrodes, frequencies and times",
            _ => "not decided whether they differ over electrodes, frequencies and times",
        };
        format!(
            "{a} and {b}: {outcome} ({} after Holm)",
            p_text(self.p_holm)
        )
    }

    /// The test in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let [a, b] = &self.tasks;
        let flips = match self.tried {
            Tried::All => format!("all {} sign flips were tried", self.flips),
            Tried::Drawn { seed } => format!("{} sign flips drawn from seed {seed}", self.flips),
        };
        let outcome = match self.outcome() {
            Outcome::Met => "they differ somewhere",
            _ if self.may_be_of_baselines() => {
                "not decided, as the baselines may be all that differs"
            }
            _ => "not decided",
        };
        let largest = match self.clusters.first() {
            None => "no cluster".to_owned(),
            Some(one) => format!(
                "largest cluster {}, mass {}, {} to {} Hz, {} to {} s, {}",
                p_text(one.p_value),
                plus(one.mass, 1),
                rounded(one.hz[0]),
                rounded(one.hz[1]),
                plus(one.time_s[0], 2),
                plus(one.time_s[1], 2),
                electrodes_text(&one.electrodes)
            ),
        };
        format!(
            "{b} − {a}, {}: {largest}; over the pairs of tasks {} after Holm ({flips}, smallest possible {}): {outcome}",
            counted(self.people.len(), "participant"),
            p_text(self.p_holm),
            p_text(self.smallest_p)
        )
    }
}

fn electrodes_text(names: &[String]) -> String {
    match names.len() {
        0..=8 => names.join(" "),
        many => format!("{} … ({many} electrodes)", names[..6].join(" ")),
    }
}

impl EegStats {
    fn unit_label(&self) -> &'static str {
        match self.config.unit {
            Mode::Percent => "%",
            Mode::Decibels => "dB",
        }
    }

    /// Why nothing is decided in percent, where that is so.
    #[must_use]
    pub fn withheld_sentence(&self) -> Option<&'static str> {
        let unequal = unequal(&self.epochs).is_some();
        (unequal && self.config.unit == Mode::Percent).then_some(
            "Contrasts in percent are not decided: tasks have quite different numbers of epochs, and the bias of a percentage follows that number; \
             compare in dB, or equal numbers of epochs",
        )
    }

    /// How many people there are, and how many epochs each task has.
    pub(super) fn numbers(&self) -> Vec<Number> {
        let people = Number::new(self.participants.len().to_string(), "participants");
        let epochs = self.epochs.iter().map(|one| {
            let count = match one.fewest == one.most {
                true => one.most.to_string(),
                false => format!("{} to {}", one.fewest, one.most),
            };
            let name = format!("epochs of each participant and surface, {}", one.task);
            Number::new(count, name)
        });
        std::iter::once(people).chain(epochs).collect()
    }

    /// What every number depends on: window, bands, regions, what signs mean, and the margin where there is one.
    #[must_use]
    pub fn settings_sentence(&self) -> String {
        let bands = self.measured.bands.iter().map(|band| band.text());
        let regions = self
            .measured
            .regions
            .iter()
            .map(|region| match region.channels.as_slice() {
                [one] if *one == region.name => region.name.clone(),
                channels => format!("{} ({})", region.name, channels.join(" ")),
            });
        let margin = self.config.margin.map_or_else(String::new, |margin| {
            let unit = unit_of(self.config.unit);
            format!(
                "; margin ±{} {unit}, against 95 % intervals of single contrasts",
                rounded(margin)
            )
        });
        format!(
            "Window {}; bands {}; regions {}{margin}. Negative: desynchronisation; a difference above 0: more desynchronisation in the task named \
             second",
            crate::eeg::person::span_text(self.measured.window_s),
            bands.collect::<Vec<_>>().join(", "),
            regions.collect::<Vec<_>>().join(", ")
        )
    }

    /// The mean of each task with its 95 % interval, of the mean of surfaces or the only one: one sentence each.
    #[must_use]
    pub fn task_sentences(&self) -> Vec<String> {
        let several = self.surfaces.len() > 1;
        let own = self.changes.iter();
        let own = own.filter(|one| !several || one.surface == ALL_SURFACES);
        own.map(|one| {
            let interval = one.interval.map_or_else(String::new, |[low, high]| {
                format!(" (95 % {} to {})", plus(low, 1), plus(high, 1))
            });
            format!(
                "{}, {}, {}, {}: {} {}{interval}, power in the baseline {}, in the window {} dB re 1 µV², n = {}",
                one.task,
                one.surface,
                one.region,
                one.band,
                plus(one.mean, 1),
                self.unit_label(),
                one.baseline.text(),
                one.window.text(),
                one.people.len()
            )
        })
        .collect()
    }

    /// How many people, tasks and surfaces there are, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        format!(
            "{}, tasks {}, surfaces {}; {}",
            counted(self.participants.len(), "participant"),
            self.tasks.join(", "),
            self.surfaces.join(", "),
            self.measured.baseline_text()
        )
    }

    /// The contrasts that are looked at first: of the mean of surfaces, or of the only surface.
    pub fn first_contrasts(&self) -> impl Iterator<Item = &TaskContrast> {
        let several = self.surfaces.len() > 1;
        let all = self.contrasts.iter();
        all.filter(move |one| !several || one.surface == ALL_SURFACES)
    }

    /// The contrasts: one row each.
    #[must_use]
    pub fn contrasts_table(&self) -> Table {
        let unit = unit_of(self.config.unit);
        let mut table = Table::new([
            Column::new("contrast", "contrast"),
            Column::new("surface", "surface"),
            Column::new("region", "region"),
            Column::new("band", "band"),
            Column::new("n", "participants"),
            Column::new(&format!("difference, {unit}"), "difference"),
            Column::new("95 % from", "difference_low"),
            Column::new("95 % to", "difference_high"),
            Column::new("d_z", "d_z"),
            Column::new("95 % from", "d_z_low"),
            Column::new("95 % to", "d_z_high"),
            Column::new("p", "p"),
            Column::new("p, Holm", "p_holm"),
            Column::new("differ", "differ"),
            Column::new("within the margin", "within_margin"),
            Column::new("power in the baseline, dB", "baseline_difference"),
            Column::new("95 % from", "baseline_difference_low"),
            Column::new("95 % to", "baseline_difference_high"),
            Column::new("p", "baseline_p"),
            Column::new("power in the window, dB", "window_difference"),
            Column::new("95 % from", "window_difference_low"),
            Column::new("95 % to", "window_difference_high"),
            Column::new(
                "window − baseline, % of the mean baseline",
                "step_difference",
            ),
            Column::new("95 % from", "step_difference_low"),
            Column::new("95 % to", "step_difference_high"),
            Column::new(
                "larger p of both in the direction of the change, Holm",
                "power_p_holm",
            ),
        ]);
        table.rows = self
            .contrasts
            .iter()
            .map(|one| {
                let [a, b] = &one.tasks;
                let found = one.contrast.as_ref();
                let [baseline, window, step] = [one.baseline, one.window, one.step]
                    .map(|found| found.map(|one| one.difference));
                let of = |value: &dyn Fn(&crate::eeg::contrast::Contrast) -> f64| {
                    Cell::from(found.map(value))
                };
                vec![
                    Cell::Text(format!("{b} − {a}")),
                    Cell::from(one.surface.as_str()),
                    Cell::from(one.region.as_str()),
                    Cell::from(one.band.as_str()),
                    Cell::Text(one.people.len().to_string()),
                    of(&|c| c.difference.mean),
                    of(&|c| c.difference.interval[0]),
                    of(&|c| c.difference.interval[1]),
                    of(&|c| c.d_z),
                    of(&|c| c.d_z_interval[0]),
                    of(&|c| c.d_z_interval[1]),
                    of(&|c| c.difference.p_value),
                    Cell::from(one.p_holm),
                    Cell::from(one.outcome().answer()),
                    Cell::from(one.within_margin().map_or("no margin", Outcome::answer)),
                    Cell::from(baseline.map(|found| found.mean)),
                    Cell::from(baseline.map(|found| found.interval[0])),
                    Cell::from(baseline.map(|found| found.interval[1])),
                    Cell::from(baseline.map(|found| found.p_value)),
                    Cell::from(window.map(|found| found.mean)),
                    Cell::from(window.map(|found| found.interval[0])),
                    Cell::from(window.map(|found| found.interval[1])),
                    Cell::from(step.map(|found| found.mean)),
                    Cell::from(step.map(|found| found.interval[0])),
                    Cell::from(step.map(|found| found.interval[1])),
                    Cell::from(one.power_p_holm),
                ]
            })
            .collect();
        table
    }

    /// The contrasts for a page: intervals beside their values.
    fn page_table(&self) -> Table {
        let unit = unit_of(self.config.unit);
        let mut table = Table::new([
            Column::new("contrast", "contrast"),
            Column::new("surface", "surface"),
            Column::new("region", "region"),
            Column::new("band", "band"),
            Column::new("n", "participants"),
            Column::new(&format!("difference, {unit} (95 %)"), "difference"),
            Column::new("d_z (95 %)", "d_z"),
            Column::new("p", "p"),
            Column::new("p, Holm", "p_holm"),
            Column::new("differ", "differ"),
            Column::new("within the margin", "within_margin"),
        ]);
        let with = |value: f64, [low, high]: [f64; 2], decimals: usize| {
            format!(
                "{} ({} to {})",
                plus(value, decimals),
                plus(low, decimals),
                plus(high, decimals)
            )
        };
        table.rows = self
            .contrasts
            .iter()
            .map(|one| {
                let [a, b] = &one.tasks;
                let found = one.contrast.as_ref();
                let text = |text: Option<String>| text.map_or(Cell::from(None), Cell::Text);
                let difference = found.map(|c| with(c.difference.mean, c.difference.interval, 1));
                vec![
                    Cell::Text(format!("{b} − {a}")),
                    Cell::from(one.surface.as_str()),
                    Cell::from(one.region.as_str()),
                    Cell::from(one.band.as_str()),
                    Cell::Text(one.people.len().to_string()),
                    text(difference),
                    text(found.map(|c| with(c.d_z, c.d_z_interval, 2))),
                    Cell::from(found.map(|c| c.difference.p_value)),
                    Cell::from(one.p_holm),
                    Cell::from(one.outcome().answer()),
                    Cell::from(one.within_margin().map_or("no margin", Outcome::answer)),
                ]
            })
            .collect();
        table
    }

    /// Every change of every person: one row each.
    #[must_use]
    pub fn people_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("participant", "participant"),
            Column::new("task", "task"),
            Column::new("surface", "surface"),
            Column::new("region", "region"),
            Column::new("band", "band"),
            Column::new(&format!("ERD/ERS, {}", self.unit_label()), "change"),
            Column::new("baseline, dB re 1 µV²", "baseline_db"),
            Column::new("window, dB re 1 µV²", "window_db"),
        ]);
        for changes in &self.changes {
            for one in &changes.people {
                table.rows.push(vec![
                    Cell::from(one.participant.as_str()),
                    Cell::from(changes.task.as_str()),
                    Cell::from(changes.surface.as_str()),
                    Cell::from(changes.region.as_str()),
                    Cell::from(changes.band.as_str()),
                    Cell::from(one.change),
                    Cell::from(one.baseline_db),
                    Cell::from(one.window_db),
                ]);
            }
        }
        table
    }

    fn clusters_table(&self, of: &TaskClusters) -> Table {
        let mut table = Table::new([
            Column::new("p", "p"),
            Column::new("mass, Σt", "mass"),
            Column::new("nodes", "nodes"),
            Column::new("frequencies, Hz", "hz"),
            Column::new("times, s", "time_s"),
            Column::new("electrodes", "electrodes"),
            Column::new("largest t", "peak_t"),
            Column::new("there", "peak"),
        ]);
        table.rows = of
            .clusters
            .iter()
            .map(|one| {
                let ([from_hz, to_hz], [from_s, to_s]) = (one.hz, one.time_s);
                vec![
                    Cell::from(one.p_value),
                    Cell::from(one.mass),
                    Cell::Text(one.nodes.to_string()),
                    Cell::Text(format!("{} to {}", rounded(from_hz), rounded(to_hz))),
                    Cell::Text(format!("{} to {}", signed(from_s, 3), signed(to_s, 3))),
                    Cell::Text(electrodes_text(&one.electrodes)),
                    Cell::from(one.peak_t),
                    Cell::Text(format!(
                        "{}, {} Hz, {} s",
                        one.peak_electrode,
                        rounded(one.peak_hz),
                        digits(one.peak_s).replace('-', "−")
                    )),
                ]
            })
            .collect();
        table
    }

    /// Means by task and surface with a point for each participant, of one region and band.
    fn people_figure(&self, region: &str, band: &str) -> Option<Figure> {
        let own: Vec<_> = self
            .changes
            .iter()
            .filter(|one| one.region == region && one.band == band)
            .collect();
        let mut surfaces = self.surfaces.clone();
        if surfaces.len() > 1 {
            surfaces.push(ALL_SURFACES.to_owned());
        }
        let count = self.tasks.len();
        let place = |surface: &str, task: usize| {
            let at = surfaces.iter().position(|own| own == surface)?;
            Some(at as f64 + ROOM * ((task as f64 + 0.5) / count as f64 - 0.5))
        };
        let mut lines = Vec::new();
        for (number, (task, tone)) in self.tasks.iter().zip(Tone::several(count)).enumerate() {
            let mut points = Vec::new();
            let (mut means, mut spread) = (Vec::new(), Vec::new());
            for one in own.iter().filter(|one| one.task == *task) {
                let x = place(&one.surface, number)?;
                points.extend(one.people.iter().map(|person| (x + 0.05, person.change)));
                means.push((x - 0.03, one.mean));
                spread.extend(one.interval.map(|[low, high]| (x - 0.03, low, high)));
            }
            lines.push(Line::new("", tone, points).marked(Mark::Dots).thin());
            lines.push(
                Line::new(task, tone, means)
                    .marked(Mark::Dots)
                    .spread(spread)
                    .thick(),
            );
        }
        let values = own.iter().flat_map(|one| {
            let ends = one.interval.into_iter().flatten();
            one.people.iter().map(|p| p.change).chain(ends).chain([0.0])
        });
        let label = format!("ERD/ERS at {region}, {}", self.unit_label());
        let y = Axis::around(label, Scale::Linear, values);
        let chart = Chart {
            levels: vec![0.0],
            ..Chart::new(Axis::names("surface", surfaces), y, lines)
        };
        Some(chart.captioned(format!(
            "{band} at {region} by task and surface: mean with its 95 % interval (large), and each participant (small). {SIGNS} Window {}; {}. Counterpart \
             of Figure 97 of the thesis.",
            crate::eeg::person::span_text(self.measured.window_s),
            self.measured.baseline_text()
        )))
    }

    /// The means over people on the scalp: tasks, or differences; `None` where no map can be drawn.
    fn scalp_figure(&self, band: &str, differences: Maps, what: &str) -> Option<Figure> {
        if differences.panels.is_empty() {
            return None;
        }
        let reach = rounded(differences.reach);
        let is_change = what == TASKS;
        let (unit, signs) = match is_change {
            true => (self.unit_label().to_owned(), SIGNS),
            false => (unit_of(self.config.unit).to_owned(), SIGNS_OF_DIFFERENCES),
        };
        Some(differences.captioned(format!(
            "{what}, {band}, mean over participants and surfaces, seen from above, nose up; window {}; {}. Blue: below 0, red: above 0. {signs} One \
             scale, ±{reach} {unit}.",
            crate::eeg::person::span_text(self.measured.window_s),
            self.measured.baseline_text()
        )))
    }

    fn scalp_figures(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        for band in &self.measured.bands {
            let panels = |of_tasks: bool| {
                let own = self.scalps.iter().filter(|one| {
                    one.band == band.name && matches!(one.shown, Shown::Task(_)) == of_tasks
                });
                let drawn = own.filter_map(|one| {
                    let title = match &one.shown {
                        Shown::Task(task) => format!("{task} (n = {})", one.people),
                        Shown::Difference([a, b]) => format!("{b} − {a} (n = {})", one.people),
                    };
                    head_map(title, &self.electrodes, &one.values).map(|(panel, _)| panel)
                });
                drawn.collect()
            };
            let unit = self.unit_label();
            let tasks = Maps::around_zero(format!("ERD/ERS, {unit}"), panels(true));
            let label = format!("difference, {}", unit_of(self.config.unit));
            let differences = Maps::around_zero(label, panels(false));
            let text = band.text();
            blocks.extend(self.scalp_figure(&text, tasks, TASKS).map(Block::Figure));
            blocks.extend(
                self.scalp_figure(&text, differences, "Differences of tasks")
                    .map(Block::Figure),
            );
        }
        let text = match blocks.is_empty() {
            true => format!(
                "No scalp map is drawn: {} electrodes that all documents have with a known position, and a map needs {FEWEST_OF_A_MAP}.",
                self.electrodes.len()
            ),
            false => "Counterpart of Figure 96 of the thesis at the electrodes. Maps of sources in the brain need a model of the head, and are not computed: \
                 a maximum at an electrode is not an active area below it."
                .to_owned(),
        };
        blocks.push(Block::Note { text });
        blocks
    }

    fn cluster_blocks(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        for of in &self.clusters {
            blocks.push(Block::Text {
                text: of.sentence(),
            });
            if !of.clusters.is_empty() {
                blocks.push(Block::Table(self.clusters_table(of)));
            }
        }
        let text = match self.clusters.first() {
            None => "No cluster test: fewer than two participants took part in two tasks, or no time lies behind the baseline.".to_owned(),
            Some(first) => format!(
                "Differences in dB (corrected for the bias of the logarithm), mean of surfaces, over {} electrodes × frequencies × times from {} s to {} s; nodes beyond t = ±{} form clusters; \
                 electrodes up to {}° apart are neighbours ({}). A cluster says that the tasks differ, not where or when exactly.",
                first.nodes,
                rounded(first.time_s[0]),
                rounded(first.time_s[1]),
                digits(first.threshold_t),
                rounded(self.config.neighbours_deg),
                counted(first.neighbours, "pair")
            )
            .replace('-', "−"),
        };
        blocks.push(Block::Note { text });
        blocks
    }

    /// The rules that decide, in words.
    fn rules() -> String {
        format!(
            "Two tasks differ where p ≤ {LEVEL} after Holm's adjustment (means of surfaces, single surfaces and pairs of tasks in cluster tests, each \
             among themselves), of the changes and, in the same direction, of power itself, in the window and from the baseline to it: where baselines alone \
             differ, or one task has more noise throughout, nothing is decided. A larger p decides nothing. Tasks are alike within a margin that was stated where the 95 % interval lies within it; \
             they may differ and be alike within the margin. An order holds where each of its steps differs in its direction."
        )
    }
}

impl page::Shown for EegStats {
    fn page(&self) -> Page {
        let outcomes = self.gradients.iter();
        let mut first: Vec<Block> = outcomes
            .map(|gradient| Block::conclusion(gradient.sentence(), gradient.outcome()))
            .collect();
        // What is found, where no order is claimed.
        if self.gradients.is_empty() {
            first.extend(
                self.first_contrasts().map(|one| {
                    Block::conclusion(one.short_sentence(self.config.unit), one.outcome())
                }),
            );
        }
        first.extend(
            (self.clusters.iter())
                .map(|one| Block::conclusion(one.short_sentence(), one.outcome())),
        );
        let of_baselines = self.baseline_sentences().into_iter();
        first.extend(of_baselines.map(|text| Block::conclusion(text, None)));
        let withheld = self.withheld_sentence();
        first.extend(withheld.map(|text| Block::conclusion(text, None)));
        first.push(Block::numbers(self.numbers()));
        first.push(Block::text(self.settings_sentence()));
        let sentences = self.first_contrasts();
        let sentences = sentences.map(|one| Block::text(one.sentence(self.config.unit)));
        let mut contrasts: Vec<Block> = sentences.collect();
        contrasts.push(Block::Table(self.page_table()));
        contrasts.push(Block::note(Self::rules()));
        let mut people = Vec::new();
        for band in &self.measured.bands {
            for region in &self.measured.regions {
                let figure = self.people_figure(&region.name, &band.name);
                people.extend(figure.map(Block::Figure));
            }
        }
        let gradients = self.gradients.iter().flat_map(|one| &one.criteria);
        let of_contrasts = self.contrasts.iter().flat_map(|one| &one.criteria);
        let clusters = self.clusters.iter().flat_map(|one| &one.criteria);
        let criteria = gradients.chain(of_contrasts).chain(clusters);
        Page::new("EEG desynchronisation over participants", self.sentence())
            .section("", first)
            .section("Tasks and surfaces", people)
            .section("Means", self.task_sentences().into_iter().map(Block::text))
            .section("Contrasts", contrasts)
            .section("Power", self.power_blocks())
            .section("Clusters", self.cluster_blocks())
            .section("Scalp", self.scalp_figures())
            .section("Criteria", [Block::Table(Table::of_criteria(criteria))])
            .section("Participants", [Block::Table(self.people_table())])
            .warnings(&self.warnings)
            .rows(self.contrasts_table())
    }
}
