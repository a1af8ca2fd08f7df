//! The report of a campaign's design: what is asked, what it can show, its faults and better plans.

use piezotact::figure::{Axis, Chart, Drawn, Figure, Line, Matrix, Shade, Square, Tone};
use piezotact::page::{Block, Cell, Column, Page, Shown, Table};

use super::CampaignDesign;
use crate::campaign::design::{BetterPlan, Change, PairCoverage, PowerPoint, PowerStudy};
use crate::difference::Difference;

/// A page shows the matrix of pairs of up to so many samples; the table has all of them.
const MATRIX_SAMPLES: usize = 40;

impl Shown for CampaignDesign {
    fn page(&self) -> Page {
        let origin = format!("Seed of simulations: {}.", self.report.seed);
        let named = format!("{} ({}, from {}).", self.title, self.protocol, self.source);
        let mut first = vec![
            Block::conclusion(self.sentence(), self.outcome()),
            Block::conclusion(named, None),
            Block::conclusion(self.asked_sentence(), None),
            Block::conclusion(self.judged_sentence(), None),
            Block::conclusion(self.time_sentence(), None),
        ];
        first.extend(
            self.pairs_sentence()
                .map(|text| Block::conclusion(text, None)),
        );
        let precision = self.precision_sentences().into_iter();
        let power = self.power.iter().flat_map(PowerStudy::sentences);
        first.extend(
            precision
                .chain(power)
                .map(|text| Block::conclusion(text, None)),
        );
        let mut page = Page::new(format!("Design of {}", self.title), origin).section("", first);
        if !self.report.faults.is_empty() {
            page = page.section("Faults and better plans", self.faults());
        }
        if let Some(study) = &self.power {
            page = page.section("Power", power_blocks(study));
        }
        page = page
            .section("Time of each participant", self.time())
            .section("Pairs of samples", self.pairs())
            .section("Chance", self.chance());
        if !self.report.criteria.is_empty() {
            let note = "The 95 % interval is that of the simulation. A rule is not decided where it contains the limit.";
            let rules = Table::of_criteria(&self.report.criteria);
            page = page.section("Rules", [rules.into(), Block::note(note)]);
        }
        page
    }
}

impl CampaignDesign {
    /// Each fault with the better plan and its cost.
    fn faults(&self) -> Vec<Block> {
        let faults = self.report.faults.iter().enumerate();
        let faults = faults.flat_map(|(i, found)| {
            let better = match &found.better {
                None => "No better plan is known.".to_owned(),
                Some(better) => format!("Better: {better}"),
            };
            let text = format!("{}. {} {better}", i + 1, found.fault);
            let details = found
                .better
                .as_ref()
                .and_then(|better| self.details(better));
            [Some(Block::conclusion(text, None)), details]
        });
        faults.flatten().collect()
    }

    /// The sets or the orders of a better plan.
    fn details(&self, better: &BetterPlan) -> Option<Block> {
        match &better.change {
            Change::Sets { sets, halves, .. } => {
                let half_of = |set: usize| {
                    let half = halves
                        .iter()
                        .position(|half: &Vec<usize>| half.contains(&set));
                    half.map_or(Cell::Missing(()), |half| Cell::Text((half + 1).to_string()))
                };
                let mut table = Table::new([
                    Column::new("set", "set"),
                    Column::new("samples", "samples"),
                    Column::new("of participant, where two share the sets", "half"),
                ]);
                let rows = sets.iter().enumerate();
                table.rows = rows
                    .map(|(i, set)| {
                        let (number, samples) = ((i + 1).to_string(), set.join(", "));
                        vec![Cell::Text(number), Cell::Text(samples), half_of(i)]
                    })
                    .collect();
                let summary = format!("The {} sets", sets.len());
                Some(Block::folded(summary, [table.into()]))
            }
            Change::EarlierMeasurement { orders } => {
                let steps = orders.iter().map(|order| order.join(", ")).collect();
                let now = self.campaign.task_orders.iter();
                let now: Vec<String> = now.map(|order| order.join(", ")).collect();
                let summary = format!("The {} orders of tasks", orders.len());
                let now = Block::note(format!("Now: {}.", now.join("; ")));
                Some(Block::folded(summary, [Block::Steps { steps }, now]))
            }
            _ => None,
        }
    }

    fn time(&self) -> [Block; 2] {
        [
            self.sessions_table().into(),
            Block::note("Trials are a mean where sequences have several lengths."),
        ]
    }

    fn pairs(&self) -> Vec<Block> {
        let (Some(coverage), Some(table)) = (&self.report.coverage, self.pairs_table()) else {
            let none = "No task uses sets: no pair of samples is presented in a set.";
            return vec![Block::text(none)];
        };
        let samples = &self.report.samples;
        let hatched = match coverage.never.is_empty() {
            true => "",
            false => " Hatched: never, so that this cell of an association matrix stays untested.",
        };
        let mut blocks = Vec::new();
        if samples.len() <= MATRIX_SAMPLES {
            blocks.push(Block::Figure(Figure {
                drawn: Drawn::Matrix(coverage_matrix(samples, coverage)),
                caption: format!("In how many sets both samples are together.{hatched}"),
            }));
        }
        let summary = "Sets of each sample, and the samples that it is never together with";
        blocks.push(Block::folded(summary, [table.into()]));
        blocks
    }

    fn chance(&self) -> Vec<Block> {
        match self.report.chance.is_empty() {
            true => vec![Block::text("No task has answers that are right or wrong.")],
            false => vec![self.chance_table().into(), Block::note(self.chance_note())],
        }
    }
}

fn coverage_matrix(samples: &[String], coverage: &PairCoverage) -> Matrix {
    let most = coverage.counts.iter().flatten().max().copied().unwrap_or(1);
    let squares = coverage.counts.iter().enumerate().map(|(i, row)| {
        let row = row.iter().enumerate();
        row.map(|(j, count)| {
            Square::plain(match count {
                _ if i == j => Shade::Blank,
                0 => Shade::Untested,
                count => Shade::Count(*count, most),
            })
        })
        .collect()
    });
    Matrix {
        rows: samples.to_vec(),
        columns: samples.to_vec(),
        squares: squares.collect(),
        row_label: "sample".into(),
        column_label: "together with".into(),
        scale_label: "sets".into(),
        untested_label: "never".into(),
    }
}

/// How often a stated difference is found, with its curves and those of the precision of a cell.
fn power_blocks(study: &PowerStudy) -> Vec<Block> {
    let most = study.curves.iter().flatten();
    let most = most.map(|point| point.found.participants).max();
    let most = most.unwrap_or(1) as f64;
    let lines = |of: fn(&PowerPoint) -> f64| {
        let curves = study.curves.iter().enumerate();
        let lines = curves.map(|(index, curve)| {
            let label = match curve.first().map_or(1, |point| point.found.times) {
                1 => "as designed".to_owned(),
                times => format!("{times} times the presentations"),
            };
            let points = curve.iter();
            let points = points.map(|point| (point.found.participants as f64, 100.0 * of(point)));
            let tone = Tone::Of {
                index,
                count: study.curves.len(),
            };
            Line::new(label, tone, points.collect())
        });
        lines.collect::<Vec<_>>()
    };
    let each = match study.question.difference {
        Difference::People(_) => "participants in each group",
        _ => "participants",
    };
    let found = Chart {
        levels: vec![100.0 * study.wanted_share],
        ..Chart::new(
            Axis::new(each, 0.0, most),
            Axis::new("campaigns that find it, %", 0.0, 100.0),
            lines(|point| point.found.power_share),
        )
    };
    let widest = study.curves.iter().flatten();
    let widest = widest.map(|point| 100.0 * point.half_width_share);
    let precision = Chart::new(
        Axis::new(each, 0.0, most),
        Axis::new(
            "half-width of a cell, points",
            0.0,
            widest.fold(10.0, f64::max),
        ),
        lines(|point| point.half_width_share),
    );
    let campaigns = study.planned.campaigns;
    vec![
        found
            .captioned("How often the difference is found, over the number of participants. Line: what is wanted.")
            .into(),
        precision
            .captioned(
                "The mean half-width of the 95 % interval of a cell of the association matrix, for the first of the two shares.",
            )
            .into(),
        Block::note(format!("Each point: {campaigns} simulated campaigns.")),
        study.table().into(),
    ]
}
