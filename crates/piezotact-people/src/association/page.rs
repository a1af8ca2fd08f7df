//! The report of association matrices: what was presented, and what it was declared to be.

use piezotact::criterion::Outcome;
use piezotact::figure::{Axis, Chart, Drawn, Figure, Line, Matrix, Shade, Square, Tone, range};
use piezotact::number::signed;
use piezotact::page::{Block, Cell, Column, Page, Shown, Table};

use super::{
    Asked, Association, AssociationMatrix, Felt, FeltPair, FeltSpectrum, Ordering, PairOutcome, Row,
};
use crate::difference::Difference;

/// As many pairs stand in a report; the table of pairs has all of them.
const PAIRS: usize = 40;
/// As many pairs of what was felt are drawn; the table has all of them.
const PAIRS_DRAWN: usize = 20;
/// A table of counts has at most so many samples, as a page cannot hold more; the table of cells has all of them.
const SAMPLES_COUNTED: usize = 36;
/// The range of levels that is drawn, dB.
const DEPTH_DB: f64 = 70.0;

impl Shown for Association {
    fn page(&self) -> Page {
        let title = format!("Association matrices of {}", self.name);
        let mut first = vec![Block::conclusion(self.sentence(), self.verdict())];
        let drawn = self.conclusions_sentence();
        first.extend(drawn.map(|sentence| Block::conclusion(sentence, None)));
        let asked = self.asked.iter().flat_map(Asked::sentences);
        let groups = self.group_sentences();
        let found = asked
            .chain(groups)
            .chain(self.comparisons.iter().map(|one| one.sentence()))
            .chain(self.orderings.iter().map(|one| one.sentence()));
        first.extend(found.map(|sentence| Block::conclusion(sentence, None)));
        first.extend(self.matrix_table().map(Block::Table));
        first.push(Block::note(
            "A percentage is how often an association was declared, over how often the stimulus was presented. Intervals are 95 %, \
             of Clopper and Pearson, with the effective number of answers of Korn and Graubard (1998): they allow for participants \
             who differ, and speak of people like those who answered: where none of 10 participants guesses, up to 26 % of such people may. \
             Chance: one over the number of samples that could be answered.",
        ));
        let mut page = Page::new(title, "")
            .section("", first)
            .warnings(&self.warnings);
        if let Some(asked) = &self.asked {
            page = page.section("What was found, task by task", tasks(asked));
        }
        if !self.comparisons.is_empty() {
            page = page.section("Differences", self.differences());
        }
        for group in &self.matrices {
            let by = self.config.by.map_or("", |by| by.name());
            let heading = match group.group.as_str() {
                "all" => "Association matrix of all answers".to_owned(),
                group => format!("Association matrix of {by} {group}"),
            };
            let share = group.expected.as_ref();
            let share = share.map(|share| format!("{} answers: {}.", share.answers, share.words()));
            let blocks = share.map(Block::text).into_iter();
            page = page.section(&heading, blocks.chain(self.matrix_blocks(&group.matrix)));
        }
        page = page.section("Confused pairs", self.pairs_blocks());
        if let Some(felt) = &self.felt {
            page = page.section("What was felt in confused pairs", felt_blocks(felt));
        }
        for ordering in &self.orderings {
            let heading = format!("Orders of task {}", ordering.task);
            page = page.section(&heading, ordering_blocks(ordering));
        }
        page.rows(self.cells_table())
    }
}

impl Association {
    /// Met only where the answers are shown to be better than guesses.
    fn verdict(&self) -> Outcome {
        let share = self.expected.first();
        share.map_or(Outcome::NotDecided, |share| share.criterion.outcome)
    }

    /// The differences that were asked for.
    fn differences(&self) -> Vec<Block> {
        let mut differences = self.comparisons.iter().map(|one| &one.difference);
        let of_people = differences
            .clone()
            .any(|of| matches!(of, Difference::People(_)));
        let of_samples = differences.any(|of| matches!(of, Difference::Samples(_)));
        let mut note = "Each participant is one number; signs of paired differences, or groups of people, are exchanged in all ways, \
             or in 19 999. An interval holds the differences that the test does not reject. That nothing is decided does not show that two \
             are alike."
            .to_owned();
        if of_people {
            note += " Of groups Welch's t is compared, by permutation and by Student's t; the larger p decides, so that groups that differ in \
                 spread or size are not taken for groups that differ in their mean.";
        }
        if of_samples {
            note += " Told apart better than by guessing: right answers are more frequent than the other's name, over both samples \
                 together. A pair can be that and still be confused: one of the two may often be called the other.";
        }
        let sentences = self
            .comparisons
            .iter()
            .map(|one| Block::text(one.sentence()));
        sentences.chain([Block::note(note)]).collect()
    }

    fn matrix_blocks(&self, matrix: &AssociationMatrix) -> Vec<Block> {
        let cells = matrix.rows.iter().flat_map(|row| &row.cells);
        let hatched = match cells.filter(|cell| !cell.is_tested()).count() {
            0 => String::new(),
            count => format!(
                " Hatched: untested, as the stimulus was never presented while this sample could be answered ({count} cells); this \
                 is not 0 %."
            ),
        };
        let flagged = match matrix.rows.iter().any(|row| row.flagged > 0) {
            true => " Dot: some of these answers are of flagged trials.",
            false => "",
        };
        let drawn = self.drawn(matrix);
        let squares = Figure {
            drawn: Drawn::Matrix(drawn.clone()),
            caption: format!(
                "Rows: the stimulus that was presented. Columns: the sample that it was declared to be. Numbers: %. Outlined: the \
                 expected association.{hatched}{flagged}"
            ),
        };
        let bars = Figure {
            drawn: Drawn::Bars(drawn),
            caption: "The same as bars. Dark: the expected associations; red: the others. Grey tiles: untested. Bars can hide others: \
                 the numbers are those above."
                .into(),
        };
        let mut blocks = vec![squares.into(), bars.into()];
        if matrix.samples.len() <= SAMPLES_COUNTED {
            let note = "Each cell: % of the presentations of the stimulus, its interval, and how often it was declared of how often it was \
                 offered. n/a: untested. No interval: too few participants.";
            blocks.push(Block::folded(
                "Counts and 95 % intervals",
                [counts(matrix).into(), Block::note(note)],
            ));
        }
        blocks
    }

    fn drawn(&self, matrix: &AssociationMatrix) -> Matrix {
        let squares = |row: &Row| {
            let cells = row.cells.iter().map(|cell| Square {
                shade: cell.percent.map_or(Shade::Untested, Shade::Percent),
                outlined: cell.answered == row.stimulus.expected,
                dotted: cell.flagged > 0,
            });
            cells.collect()
        };
        Matrix {
            rows: (matrix.rows.iter())
                .map(|row| row.stimulus.name.clone())
                .collect(),
            columns: matrix.samples.clone(),
            squares: matrix.rows.iter().map(squares).collect(),
            row_label: match self.virtual_answers {
                0 => "presented".into(),
                all if all == self.answers => "presented to virtual volunteers".into(),
                _ => "presented, in part to virtual volunteers".into(),
            },
            column_label: "declared as".into(),
            scale_label: "association, %".into(),
            untested_label: "untested".into(),
        }
    }

    fn pairs_blocks(&self) -> Vec<Block> {
        let confused = self.pairs.iter();
        let confused = confused.filter(|pair| pair.outcome == PairOutcome::Confused);
        let names: Vec<String> = confused.map(|pair| pair.pair.join(" – ")).collect();
        let text = match names.len() {
            0 => "No pair is shown to be confused.".to_owned(),
            _ => format!("Confused: {}.", names.join(", ")),
        };
        let mut table = self.pairs_table();
        let all = table.rows.len();
        table.rows.truncate(PAIRS);
        let shown = match all > PAIRS {
            true => format!(" The first {PAIRS} of {all} tested pairs."),
            false => String::new(),
        };
        let note = format!(
            "A pair is confused if a quarter or more of the presentations of both, each sample weighing alike, are declared to be the other sample. Two samples that \
             feel the same are confused half of the time; guesses among three samples name the other in a third. Not confused: the whole 95 % \
             interval lies below a quarter, and right answers are shown to be more frequent than the name of the other sample. Not decided: anything else, and pairs that are confused in one task and not in another (select a task); more participants narrow it. About \
             five of a hundred such intervals do not contain the true share.{shown}"
        );
        let mut blocks = vec![Block::text(text), Block::note(note)];
        if all > 0 {
            blocks.push(table.into());
        }
        blocks
    }
}

/// What was found in each task of a study, and which judge the answers of virtual volunteers show.
fn tasks(asked: &Asked) -> Vec<Block> {
    let mut blocks = vec![asked.table().into()];
    if let Some(sentence) = &asked.which_sentence {
        blocks.push(Block::heading("Which judge the answers show"));
        blocks.push(Block::text(format!("{sentence}.")));
    }
    if let Some(table) = asked.judges_table() {
        blocks.push(table.into());
        blocks.push(Block::note(
            "A judge is a model of how people answer from what was delivered to the nail; its noise, weight and lapses are fitted. AICc: \
             Akaike's criterion for small samples. A judge is named only if its Akaike weight is at least 0.99, it predicts left-out participants \
             best, and its fit is not rejected. Fewer than four participants are too few to decide. An ordering of samples counts as one answer.",
        ));
    }
    blocks
}

/// The matrix as numbers: percentages with counts and intervals.
fn counts(matrix: &AssociationMatrix) -> Table {
    let samples = matrix
        .samples
        .iter()
        .map(|sample| Column::new(sample, sample));
    let first = [
        Column::new("presented", "presented"),
        Column::new("times", "times"),
    ];
    let mut table = Table::new(first.into_iter().chain(samples));
    table.rows = (matrix.rows.iter())
        .map(|row| {
            let first = [
                Cell::from(row.stimulus.name.as_str()),
                Cell::rounded(row.presented as f64, 0),
            ];
            first
                .into_iter()
                .chain(row.cells.iter().map(|cell| {
                    let Some(percent) = cell.percent else {
                        return Cell::from("n/a");
                    };
                    let interval = cell.interval_percent.map_or(String::new(), |[low, high]| {
                        format!(" ({low:.0}–{high:.0})")
                    });
                    Cell::Rounded {
                        value: percent,
                        text: format!(
                            "{percent:.1}{interval}, {} of {}",
                            cell.declared, cell.offered
                        ),
                    }
                }))
                .collect()
        })
        .collect();
    table
}

fn felt_blocks(felt: &Felt) -> Vec<Block> {
    let shown = match felt.pairs.len() {
        all if all > PAIRS_DRAWN => {
            format!(" The figures show the first {PAIRS_DRAWN} of {all} pairs.")
        }
        _ => String::new(),
    };
    let note = format!(
        "Pairs that at least one participant confused and that are not shown to be distinguishable. Level: the difference in sensation level. \
         Spectrum: the difference at equal sensation level, the louder attenuated to the level of the softer. Both in just-noticeable \
         differences (JND) over {}; one of them separates a pair if its whole 95 % interval lies above the published range of the JND and above the \
         difference between the halves of one recording.{shown}",
        felt.model.band
    );
    let mut blocks = vec![Block::note(note)];
    if felt.pairs.is_empty() {
        blocks.push(Block::text("Nobody confused a pair."));
    }
    let table = felt.table();
    if !table.rows.is_empty() {
        blocks.push(table.into());
    }
    for pair in felt.pairs.iter().take(PAIRS_DRAWN) {
        blocks.push(Block::heading(pair.pair.join(" – ")));
        blocks.push(Block::conclusion(pair.sentence(), None));
        blocks.extend(pair_figure(felt, pair).map(Block::Figure));
    }
    blocks
}

/// The spectra of a pair in one figure; `None` where neither was recorded.
fn pair_figure(felt: &Felt, pair: &FeltPair) -> Option<Figure> {
    let tones = [Tone::Reference, Tone::Main];
    let of = |i: usize| -> Vec<&FeltSpectrum> {
        let spectra = felt.spectra.iter();
        spectra.filter(|s| s.sample == pair.pair[i]).collect()
    };
    let both = [of(0), of(1)];
    let people = both[0].len().max(both[1].len());
    let mut lines = Vec::new();
    for (i, spectra) in both.iter().enumerate() {
        for (number, spectrum) in spectra.iter().enumerate() {
            let label = if number == 0 { &*pair.pair[i] } else { "" };
            let line = Line::new(label, tones[i], spectrum.points());
            lines.push(if people > 1 { line.thin() } else { line });
        }
    }
    let first = both.iter().flatten().next()?;
    let (from, to) = (felt.model.band.low().0, felt.model.band.high().0);
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, DEPTH_DB);
    let chart = Chart::new(
        Axis::log("frequency, Hz", from, to),
        Axis::new("PSD, dB re 1 (m/s²)²/Hz", low, high),
        lines,
    );
    let each = match people {
        1 => String::new(),
        people => format!(" One thin line for each of {people} participants."),
    };
    Some(chart.captioned(format!(
        "Acceleration of the fingernail: PSD (Welch, Hann, lines {:.1} Hz apart).{each}",
        first.resolution_hz
    )))
}

fn ordering_blocks(ordering: &Ordering) -> Vec<Block> {
    let tau = |tau: Option<f64>| {
        tau.map_or(Cell::Missing(()), |value| Cell::Rounded {
            value,
            text: signed(value, 3),
        })
    };
    let mut table = Table::new([
        Column::new("participant", "participant"),
        Column::new("session", "session"),
        Column::new("set", "set"),
        Column::new("τ", "tau"),
        Column::new("in place", "in_place"),
        Column::new("order", "order"),
    ]);
    table.rows = (ordering.repetitions.iter())
        .map(|repetition| {
            vec![
                Cell::Text(repetition.participant.clone()),
                Cell::Text(repetition.session.clone()),
                Cell::Text(repetition.set.clone()),
                tau(repetition.tau),
                Cell::Text(format!(
                    "{} of {}",
                    repetition.in_place,
                    repetition.order.len()
                )),
                Cell::Text(repetition.order.join(" ")),
            ]
        })
        .collect();
    let places = Figure {
        drawn: Drawn::Matrix(places(ordering)),
        caption: "How often each sample (row) was put in each place (column) of its set, % of its orders. Outlined: its declared \
             place, where all samples are ordered together."
            .into(),
    };
    let dominance = Figure {
        drawn: Drawn::Matrix(dominance(ordering)),
        caption: "How often the sample of the row was put before that of the column, % of the orders of both. In the declared order \
             all above the diagonal is 100 %. Hatched: never ordered together."
            .into(),
    };
    vec![
        Block::text(ordering.sentence()),
        Block::note(
            "One sample in the wrong place shifts all others: the places then say that nothing is right, while most pairs are in \
             order. τ counts pairs: 1 all in order, 0 none more than by chance, −1 all reversed.",
        ),
        places.into(),
        dominance.into(),
        table.into(),
    ]
}

fn places(ordering: &Ordering) -> Matrix {
    let widest = ordering.repetitions.iter().map(|r| r.order.len()).max();
    let widest = widest.unwrap_or(0);
    let squares = ordering.places.iter().enumerate().map(|(i, row)| {
        let all: usize = row.iter().sum();
        let row = row.iter().take(widest).enumerate();
        row.map(|(place, count)| Square {
            outlined: place == i && widest == ordering.samples.len(),
            ..Square::plain(match all {
                0 => Shade::Untested,
                all => Shade::Percent(100.0 * *count as f64 / all as f64),
            })
        })
        .collect()
    });
    Matrix {
        rows: ordering.samples.clone(),
        columns: (1..=widest).map(|place| place.to_string()).collect(),
        squares: squares.collect(),
        row_label: "sample".into(),
        column_label: "place".into(),
        scale_label: "orders, %".into(),
        untested_label: "untested".into(),
    }
}

fn dominance(ordering: &Ordering) -> Matrix {
    let squares = ordering.dominance.iter().enumerate().map(|(i, row)| {
        let row = row.iter().enumerate();
        row.map(|(j, pair)| {
            Square::plain(match pair.together {
                _ if i == j => Shade::Blank,
                0 => Shade::Untested,
                together => Shade::Percent(100.0 * pair.before as f64 / together as f64),
            })
        })
        .collect()
    });
    Matrix {
        rows: ordering.samples.clone(),
        columns: ordering.samples.clone(),
        squares: squares.collect(),
        row_label: "put before".into(),
        column_label: "the other".into(),
        scale_label: "orders, %".into(),
        untested_label: "untested".into(),
    }
}
