//! The power of baseline and window over people: what a change is made of.

use piezotact::number::{p_text, plus, signed};
use piezotact::page::{Block, Cell, Column, Table};
use piezotact::statistics::{mean, mean_interval, standard_deviation};
use serde::{Deserialize, Serialize};

use super::{EegStats, TaskContrast};
use crate::eeg::contrast::Contrast;

/// The level of a power over people, dB re 1 µV².
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PowerLevel {
    /// The mean over people.
    pub mean_db: f64,
    /// The standard deviation over people, dB; absent of one person.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sd_db: Option<f64>,
    /// The 95 % interval of the mean; absent of one person.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval_db: Option<[f64; 2]>,
}

impl PowerLevel {
    /// The level of `levels_db`, one of each person.
    pub(super) fn of(levels_db: &[f64]) -> Self {
        Self {
            mean_db: mean(levels_db),
            sd_db: (levels_db.len() > 1).then(|| standard_deviation(levels_db)),
            interval_db: mean_interval(levels_db),
        }
    }

    /// The mean with its standard deviation: "17.2 (SD 2.1)".
    pub(super) fn text(&self) -> String {
        let spread = self.sd_db.map(|sd| format!(" (SD {sd:.1})"));
        format!("{}{}", signed(self.mean_db, 1), spread.unwrap_or_default())
    }
}

/// The power at `level_db`, re that at 0 dB.
pub(super) fn power_of(level_db: f64) -> f64 {
    10f64.powf(level_db / 10.0)
}

/// A difference with its 95 % interval, dB.
fn difference_text(found: &Contrast) -> String {
    let [low, high] = found.difference.interval;
    format!(
        "{} dB (95 % {} to {})",
        plus(found.difference.mean, 2),
        plus(low, 2),
        plus(high, 2)
    )
}

/// A difference with its 95 % interval, percentage points.
fn percent_text(found: &Contrast) -> String {
    let [low, high] = found.difference.interval;
    let mean = plus(found.difference.mean, 1);
    format!("{mean} (95 % {} to {})", plus(low, 1), plus(high, 1))
}

impl TaskContrast {
    /// The differences of the power in baseline and window, in words.
    pub(super) fn power_text(&self) -> String {
        let baseline = self.baseline.as_ref().map_or_else(
            || "differs by the same in all participants".to_owned(),
            |found| {
                let p = p_text(found.difference.p_value);
                format!("{}, {p}", difference_text(found))
            },
        );
        let same = || "by the same in all participants".to_owned();
        let window = self.window.as_ref().map_or_else(same, difference_text);
        let step = self.step.as_ref().map_or_else(same, percent_text);
        let p = self.power_p_holm.map_or_else(String::new, |p| {
            format!(
                "; larger p of both in the direction of the change {} after Holm",
                p_text(p)
            )
        });
        format!(
            "power in the baseline {baseline}; in the window {window}; from baseline to window {step}{p}"
        )
    }

    /// Why a difference is not decided, where the baselines may be all that differs.
    pub(super) fn baseline_sentence(&self) -> Option<String> {
        let [a, b] = &self.tasks;
        self.may_be_of_baselines().then(|| {
            format!(
                "{b} − {a}, {}, {}, {}: the changes differ, but not power itself in the same direction, in the window and from the baseline to it, \
                 so the baselines, or noise in one task, may be all that differs ({})",
                self.surface,
                self.region,
                self.band,
                self.power_text()
            )
        })
    }
}

impl EegStats {
    /// What is not decided as the baselines may be all that differs: one sentence each.
    pub(super) fn baseline_sentences(&self) -> Vec<String> {
        let contrasts = self.first_contrasts();
        let contrasts = contrasts.filter_map(TaskContrast::baseline_sentence);
        let clusters = self.clusters.iter().filter(|one| one.may_be_of_baselines());
        let clusters = clusters.map(|one| {
            let [a, b] = &one.tasks;
            format!(
                "{b} − {a}: changes have a cluster, but power itself has none that overlaps it in the same direction ({} after Holm), so the \
                 baselines, or noise in one task, may be all that differs",
                p_text(one.power_p_holm)
            )
        });
        contrasts.chain(clusters).collect()
    }

    /// The power of each task, and its contrasts.
    pub(super) fn power_blocks(&self) -> Vec<Block> {
        vec![
            Block::Table(self.power_table()),
            Block::Table(self.power_contrasts_table()),
            Block::note(
                "Mean power of the wavelets in the band, dB re 1 µV², over participants. A change differs between tasks also where their \
                 baselines alone differ, or where one has more noise throughout: tasks are said to differ only where the power in the window, and \
                 the power in it less that in the baseline (% of the mean baseline of both tasks), differ in the same direction.",
            ),
        ]
    }

    fn power_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("task", "task"),
            Column::new("surface", "surface"),
            Column::new("region", "region"),
            Column::new("band", "band"),
            Column::new("n", "participants"),
            Column::new("baseline, dB re 1 µV² (SD)", "baseline_db"),
            Column::new("window, dB re 1 µV² (SD)", "window_db"),
        ]);
        let rows = self.changes.iter().map(|one| {
            vec![
                Cell::from(one.task.as_str()),
                Cell::from(one.surface.as_str()),
                Cell::from(one.region.as_str()),
                Cell::from(one.band.as_str()),
                Cell::Text(one.people.len().to_string()),
                Cell::Text(one.baseline.text()),
                Cell::Text(one.window.text()),
            ]
        });
        table.rows = rows.collect();
        table
    }

    fn power_contrasts_table(&self) -> Table {
        let mut table = Table::new([
            Column::new("contrast", "contrast"),
            Column::new("surface", "surface"),
            Column::new("region", "region"),
            Column::new("band", "band"),
            Column::new("baseline (95 %)", "baseline_difference"),
            Column::new("p", "baseline_p"),
            Column::new("window (95 %)", "window_difference"),
            Column::new("window − baseline, % (95 %)", "step_difference"),
            Column::new(
                "larger p of both in the direction of the change, Holm",
                "power_p_holm",
            ),
        ]);
        let rows = self.contrasts.iter().map(|one| {
            let [a, b] = &one.tasks;
            let of = |found: Option<&Contrast>, text: fn(&Contrast) -> String| {
                found.map_or(Cell::from(None), |found| Cell::Text(text(found)))
            };
            let text = |found| of(found, difference_text);
            let baseline_p = one.baseline.map(|found| found.difference.p_value);
            vec![
                Cell::Text(format!("{b} − {a}")),
                Cell::from(one.surface.as_str()),
                Cell::from(one.region.as_str()),
                Cell::from(one.band.as_str()),
                text(one.baseline.as_ref()),
                Cell::from(baseline_p),
                text(one.window.as_ref()),
                of(one.step.as_ref(), percent_text),
                Cell::from(one.power_p_holm),
            ]
        });
        table.rows = rows.collect();
        table
    }
}
