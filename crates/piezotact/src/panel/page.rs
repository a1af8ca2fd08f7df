//! The report on a panel: first what a person wants to know in ten seconds, then the figures of a chapter on transfer functions,
//! tables, warnings, and how it was measured.

use super::page_members;
use super::page_tables as tables;
use super::sentences::percent;
use super::warning::new_person_text;
use super::{
    AnalysedPanel, AverageCriterion, CellPenalties, CleanedDip, PanelAverage, PanelKind, WorstCase,
    WorstCriterion,
};
use crate::criterion::{Criterion, Limit, Outcome};
use crate::number::{counted, plus, signed};
use crate::page::{Block, Cell, Column, Fact, Number, Page, Shown, Table, fixed};
use crate::quantity::Quantity;
use crate::recording::BenchKind;
use crate::transfer::TransferReport;

impl Shown for AnalysedPanel<'_> {
    fn page(&self) -> Page {
        let said = self.analysis;
        let title = match self.kind {
            Some(PanelKind::Device) => "Transfer functions of the device with several fingers",
            Some(PanelKind::Finger) => "Transfer functions of several fingers",
            _ => "A panel of transfer functions",
        };
        let sections = [
            ("", self.conclusions()),
            ("Differences between participants", self.differences()),
            ("Effect of load", self.load()),
            ("Effect of angle", self.angle()),
            ("Repeatability", self.repeatability()),
            ("Average over participants", self.average()),
            ("Compensation of the dip of the bench", self.cleaned_dips()),
            ("Measurements included", page_members::blocks(self)),
        ];
        let page = Page::new(title, self.bench_line()).rows(said.table());
        let page = sections
            .into_iter()
            .filter(|(_, blocks)| !blocks.is_empty())
            .fold(page, |page, (heading, blocks)| {
                page.section(heading, blocks)
            });
        page.warnings(&said.warnings)
            .section("Methods", [Block::facts(self.methods())])
    }
}

impl AnalysedPanel<'_> {
    fn bench_line(&self) -> String {
        let said = self.analysis;
        let entries = self.panel.entries().iter();
        let kinds: Vec<Option<BenchKind>> = entries
            .map(|entry| entry.function.about.provenance.bench)
            .collect();
        let first = kinds.first().copied().flatten();
        let alike = first.filter(|_| kinds.iter().all(|kind| *kind == first));
        let bench = alike.map_or(
            "The measurements are from different kinds of bench (digital twin, hardware, measured transfer function), or some do not \
             state theirs.",
            BenchKind::sentence,
        );
        let loads: Vec<String> = self.panel.loads_n().iter().map(f64::to_string).collect();
        let angles = self.panel.angles_deg();
        let angles: Vec<String> = angles.iter().map(|angle| format!("{angle}°")).collect();
        format!(
            "{bench} {} at {} N and {}: {}, over {}.",
            counted(said.participants.len(), "participant"),
            loads.join(", "),
            angles.join(", "),
            counted(said.measurements, "measurement"),
            said.config.band
        )
    }

    /// What a person wants to know first: the conclusions, the numbers, and the criteria.
    fn conclusions(&self) -> Vec<Block> {
        let said = self.analysis;
        let judged = self
            .judged
            .and_then(|cell| Some((cell, said.penalties_at(cell)?)));
        let Some((cell, costs)) = judged else {
            let text = "No load and angle was measured with two or more participants: differences between them cannot be estimated.";
            return vec![Block::conclusion(text, Outcome::NotDecided)];
        };
        let spread = said.spreads.iter().find(|spread| spread.cell.is(cell));
        let worst = match (&said.worst, spread) {
            (Some(worst), _) => worst.conclusion(),
            (None, Some(spread)) => format!(
                "No two participants were measured at every load and angle, so conditions cannot be compared: the largest measured \
                 deviation is {:.1} dB at {:.0} Hz, at {cell}.",
                spread.bundle.max_deviation_db, spread.bundle.max_deviation_at_hz
            ),
            (None, None) => String::new(),
        };
        let mut criteria: Vec<Criterion<String>> = costs
            .verdict
            .criteria
            .iter()
            .map(|rule| named(rule, costs))
            .collect();
        criteria.extend(said.worst.iter().flat_map(WorstCase::criteria).map(|rule| {
            let name = match rule.what {
                WorstCriterion::People => "participants measured at every load and angle",
                WorstCriterion::Agreement => {
                    "random halves of the participants that differ most at the same load and angle"
                }
            };
            in_percent(rule.called(name.to_owned()))
        }));
        vec![
            Block::conclusion(costs.conclusion(cell), costs.verdict.outcome),
            Block::conclusion(worst, None),
            Block::numbers(self.numbers(costs)),
            Table::of_criteria(&criteria).into(),
        ]
    }

    fn numbers(&self, costs: &CellPenalties) -> Vec<Number> {
        let said = self.analysis;
        let conditions = match said.cells.len() {
            1 => "1 load and angle".into(),
            many => format!("{many} loads and angles"),
        };
        let mut numbers = vec![Number::new(
            counted(said.participants.len(), "participant"),
            format!(
                "panel of {} at {conditions}, over {}",
                counted(said.measurements, "measurement"),
                said.config.band
            ),
        )];
        let spread = self
            .judged
            .and_then(|cell| said.spreads.iter().find(|spread| spread.cell.is(cell)));
        if let Some(spread) = spread {
            let cell = spread.cell;
            let (deviation_db, at_hz) = match &said.worst {
                Some(worst) => (worst.max_deviation_db, worst.at_hz),
                None => (
                    spread.bundle.max_deviation_db,
                    spread.bundle.max_deviation_at_hz,
                ),
            };
            numbers.extend([
                Number::new(
                    format!("{deviation_db:.1} dB"),
                    format!("maximum deviation between participants at {cell}, at {at_hz:.0} Hz"),
                ),
                Number::new(
                    format!("{:.1} dB", spread.spread_rms_db),
                    "standard deviation over participants at this load and angle, rms over the band",
                ),
            ]);
        }
        numbers.extend(of_costs(costs));
        numbers.push(Number::new(
            percent(costs.verdict.share_within),
            format!(
                "of these participants are within {} dB rms of the average of the others",
                costs.verdict.criterion.db_rms
            ),
        ));
        let curve = said.learning.iter();
        let curve = curve.filter(|curve| self.judged.is_some_and(|cell| cell.is(curve.cell)));
        numbers.extend(curve.filter_map(|curve| {
            let (found, [low, high]) = (curve.enough.found?, curve.enough.interval?);
            Some(Number::new(
                format!("{low:.0} to {high:.0}"),
                format!(
                    "participants in the average, beyond which more reduce the error by less than {} dB (95 %; most likely {found:.0})",
                    curve.within_db
                ),
            ))
        }));
        numbers
    }

    fn differences(&self) -> Vec<Block> {
        let said = self.analysis;
        let falls = said.falls.iter().map(|falls| {
            let each = falls.loads_n.iter().zip(&falls.deviations_db);
            let each: Vec<String> = each
                .map(|(load, db)| format!("{load}: {db:.1} dB"))
                .collect();
            let halves = falls.share.zip(falls.share_overall);
            let halves = halves.map_or(String::new(), |(every, overall)| {
                format!(
                    "; over random halves of these participants, it falls at every load step in {}, and from the lightest to the \
                     heaviest load in {}",
                    percent(every),
                    percent(overall)
                )
            });
            let text = format!(
                "Maximum deviation at {}° ({}): {}{halves}.",
                falls.angle_deg.0,
                each.join(", "),
                falls.text()
            );
            Block::conclusion(text, None)
        });
        let mut blocks: Vec<Block> = falls.collect();
        if said.spreads.is_empty() {
            return blocks;
        }
        let bundles = said.spreads.iter().map(|spread| self.bundle(spread));
        let figures = [
            super::page_figures::deviations(said),
            super::page_figures::spreads(said),
        ];
        let all = (said.cells.len() > 1).then(|| self.all());
        let figures = figures.into_iter().chain(bundles).chain(all);
        blocks.push(Block::beside(figures.map(Block::Figure)));
        blocks.push(tables::cells(said).into());
        blocks.extend(tables::bands(said));
        blocks
    }

    fn load(&self) -> Vec<Block> {
        if self.analysis.load_steps.is_empty() {
            return Vec::new();
        }
        let figures = self.panel.angles_deg().into_iter().flat_map(|angle_deg| {
            let averages = self.averages_by_load(angle_deg);
            self.person_by_load(angle_deg)
                .into_iter()
                .chain([averages])
                .map(Block::Figure)
        });
        vec![Block::beside(figures), tables::loads(self.analysis).into()]
    }

    fn angle(&self) -> Vec<Block> {
        if self.analysis.angle_effects.is_empty() {
            return Vec::new();
        }
        let loads_n = self.panel.loads_n().into_iter();
        let figures = loads_n.filter_map(|load_n| self.person_by_angle(load_n));
        let figures: Vec<Block> = figures.map(Block::Figure).collect();
        let figures = (!figures.is_empty()).then(|| Block::beside(figures));
        figures
            .into_iter()
            .chain(tables::angles(self.analysis))
            .collect()
    }

    fn repeatability(&self) -> Vec<Block> {
        let found = &self.analysis.repeatability;
        let mut blocks = Vec::new();
        if found.lying.is_none() && found.put_back.is_none() {
            blocks.push(Block::note(
                "Each participant was measured once at each load and angle: repeatability cannot be estimated.",
            ));
        }
        blocks.extend(self.repeats().map(Block::Figure));
        blocks.extend(tables::repeats(found));
        blocks
    }

    fn average(&self) -> Vec<Block> {
        let said = self.analysis;
        let averages = said.averages.iter();
        let mut averages = averages.filter(|a| self.judged.is_some_and(|cell| cell.is(a.cell)));
        let Some(found) = averages.next() else {
            return Vec::new();
        };
        let mut learning = said.learning.iter();
        let learning = learning.find(|curve| curve.cell.is(found.cell));
        let enough = learning.map(|curve| {
            let text = format!(
                "Number of participants beyond which one more improves the average by less than {} dB: {}.",
                curve.within_db,
                curve.enough_text()
            );
            Block::conclusion(text, None)
        });
        let figures = [
            self.both_averages(found),
            super::page_figures::penalties(found, said),
        ];
        let figures = figures.into_iter();
        let figures = figures.chain(super::page_figures::learning(said));
        enough
            .into_iter()
            .chain([
                Block::text(difference_text(found)),
                Block::beside(figures.map(Block::Figure)),
                tables::averages(said).into(),
            ])
            .collect()
    }

    fn cleaned_dips(&self) -> Vec<Block> {
        let Some(cleaning) = self.artefact else {
            return Vec::new();
        };
        let range = |select: &dyn Fn(&CleanedDip) -> f64| {
            let values = || cleaning.dips.iter().map(select);
            let low = values().fold(f64::MAX, f64::min);
            let high = values().fold(f64::MIN, f64::max);
            Cell::from(format!("{} to {}", fixed(low, 1), fixed(high, 1)))
        };
        let mut table = Table::new([
            Column::new("over all measurements", "quantity"),
            Column::new("before", "before"),
            Column::new("after", "after"),
        ]);
        table.rows = vec![
            vec![
                "lowest line near the dip, Hz".into(),
                range(&|dip| dip.before.at_hz),
                range(&|dip| dip.after.at_hz),
            ],
            vec![
                "depth below a line fitted 15–25 % to both sides of it, dB".into(),
                range(&|dip| dip.before.depth_db),
                range(&|dip| dip.after.depth_db),
            ],
            vec![
                "largest deviation from this line within 15 %, dB".into(),
                range(&|dip| dip.before.largest_db),
                range(&|dip| dip.after.largest_db),
            ],
        ];
        let artefact = &cleaning.artefact;
        let text = format!(
            "The control measurement has a dip of {:.1} dB at {:.1} Hz. Every measurement was divided by the narrow structure of the \
             control in {} (magnitude and phase). The level and trend of the control were kept: a straight line in dB over log \
             frequency, fitted to the values around the dip.",
            artefact.depth_db, artefact.at_hz, artefact.window_hz
        );
        let figures = self.cleaned(cleaning).into_iter();
        vec![
            Block::text(text),
            Block::beside(figures.map(Block::Figure)),
            table.into(),
        ]
    }

    fn methods(&self) -> Vec<Fact> {
        let said = self.analysis;
        let config = &said.config;
        let mut facts = Vec::new();
        facts.extend(self.bench.map(|bench| Fact::new("bench", bench)));
        if let Some(function) = self.panel.entries().first().map(|entry| &entry.function) {
            let provenance = &function.about.provenance;
            let [drive, response] = self.units;
            facts.push(
                Fact::new("first measurement", provenance.source.as_str()).steps(&provenance.steps),
            );
            facts.push(Fact::new(
                "transfer functions",
                format!(
                    "{}, {} lines every {:.2} Hz, from {drive} to {response}",
                    function.estimator,
                    function.response().len(),
                    function.resolution_hz()
                ),
            ));
            facts.extend(function.drive.as_ref().map(|setup| {
                let text = format!(
                    "amplifier gain {}, {:.3} V at full scale",
                    setup.gain, setup.volts_per_full_scale
                );
                Fact::new("device", text)
            }));
        }
        facts.extend([
            Fact::new(
                "averages",
                format!(
                    "First over the repeats of a placement, then over placements, then over participants, each with equal weight: {}.",
                    config.averaging.name()
                ),
            ),
            Fact::new(
                "comparisons",
                format!(
                    "Loads and angles are compared only over the participants measured in both conditions; {} of {} were measured in \
                     every condition.",
                    said.complete,
                    said.participants.len()
                ),
            ),
            Fact::new(
                "confidence",
                format!(
                    "A random half of the participants is drawn {} times, seed {}: a maximum deviation depends on two participants \
                     only, and a result that holds for such halves may hold for another panel.",
                    config.resamples, config.seed
                ),
            ),
        ]);
        facts
    }
}

/// What an average costs a new person.
fn of_costs(costs: &CellPenalties) -> [Number; 2] {
    let interval = new_person_text(costs.new_person_db_rms);
    [
        Number::new(
            format!("{:.1} dB rms", costs.mean_db_rms),
            format!("error of the average for a new participant, mean ({interval})"),
        ),
        Number::new(
            format!("{:.1} dB rms", costs.worst.db_rms),
            format!("largest error, for {}", costs.worst.participant),
        ),
    ]
}

/// A criterion of the verdict on the average under the name that a report gives it.
fn named(rule: &Criterion<AverageCriterion>, costs: &CellPenalties) -> Criterion<String> {
    let name = match rule.what {
        AverageCriterion::ShareWithin => format!(
            "participants with an error within {} dB rms",
            costs.verdict.criterion.db_rms
        ),
        AverageCriterion::Excited => {
            "participants measured with a drive over the whole band".into()
        }
        AverageCriterion::Distinct => "participants who are nobody else in the average".into(),
    };
    in_percent(rule.clone().called(name))
}

/// The same with a share in percent.
fn in_percent<W>(rule: Criterion<W>) -> Criterion<W> {
    if !rule.unit.is_empty() {
        return rule;
    }
    let percent = |share: f64| share * 100.0;
    let limit = match rule.limit {
        Limit::AtMost { met, not_met } => Limit::AtMost {
            met: percent(met),
            not_met: percent(not_met),
        },
        Limit::AtLeast { met, not_met } => Limit::AtLeast {
            met: percent(met),
            not_met: percent(not_met),
        },
        Limit::Within { reach } => Limit::Within {
            reach: percent(reach),
        },
    };
    Criterion {
        unit: "%".into(),
        found: rule.found.map(percent),
        interval: rule.interval.map(|ends| ends.map(percent)),
        limit,
        ..rule
    }
}

/// How the two kinds of average differ in one cell, and why.
fn difference_text(average: &super::CellAverage) -> String {
    let difference = &average.difference;
    format!(
        "At {} the complex mean differs from the mean of log magnitudes by {} dB on average over the band; the lowest difference is {} \
         dB, at {:.0} Hz. Differences of level between participants raise it (by {} dB), differences of phase lower it (by {} dB): \
         the phases differ by {:.1}° rms over the band, and by {:.1}° where it is lowest.",
        average.cell,
        plus(difference.mean_db, 2),
        plus(difference.lowest_db, 2),
        difference.lowest_at_hz,
        plus(difference.by_levels_db, 2),
        signed(difference.by_phases_db, 2),
        difference.phase_rms_deg,
        difference.phase_rms_there_deg
    )
}

impl<I: Quantity, O: Quantity> Shown for PanelAverage<I, O> {
    fn page(&self) -> Page {
        let cell = self.cell;
        let title = format!("Average transfer function at {cell}");
        let [drive, response] = &self.units;
        let mut page = TransferReport::of(title, &self.function, [drive, response]).page();
        let conclusion = format!(
            "The average of {} at {cell}: {}",
            counted(self.participants.len(), "participant"),
            self.average.name()
        );
        let numbers = self.costs.iter().flat_map(of_costs);
        let blocks = [Block::conclusion(conclusion, None), Block::numbers(numbers)];
        if let Some(first) = page.sections.first_mut() {
            first.blocks.splice(0..0, blocks);
        }
        page
    }
}
