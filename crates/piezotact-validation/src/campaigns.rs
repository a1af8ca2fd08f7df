//! The discrimination campaigns of the thesis (4.3, 4.4, 5.3, 6.4), done again with virtual volunteers.
//!
//! Everybody is measured, rendered for and asked as the protocols of the library say; a presentation is one stroke, which counts as often
//! as the protocol repeats it.

use piezotact_volunteers::VolunteerError;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use piezotact::figure::{Drawn, Figure, Matrix, Shade, Square};
use piezotact::quantity::{Acceleration, Drive};
use piezotact::statistics::{correlation, mean, paired_difference};
use piezotact::transfer::TransferFunction;
use piezotact_people::association::{
    AnswerTable, AssociationMatrix, MatrixConfig, Row, Selection, association_matrix,
};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::{LIBRARY, Protocol, read};
use piezotact_people::campaign::store::MemoryStore;

use super::ReplayError;
use super::claims::{Finding, Holds, above, at_least, at_most, below, least, most, no_exception};
use super::figure::Counterpart;
use piezotact_volunteers::{Laboratory, Playings, Simulation};

/// The panel of thesis 4.3.2.
const OF_TEN: RangeInclusive<u64> = 1..=10;
/// That of 4.4, of which nothing says that it was another.
const OF_FIVE: RangeInclusive<u64> = 1..=5;
/// The one participant of the pilot (4.3.1).
const PILOT: RangeInclusive<u64> = 1..=1;
/// The panel of 5.3, to which nobody of the panel of twenty belongs.
const OF_AVERAGE: RangeInclusive<u64> = 31..=40;
/// The panel of chapter 6.
const OF_SURFACES: RangeInclusive<u64> = 1..=10;

/// What came of the campaigns of a chapter.
pub(super) struct Campaigns {
    pub(super) findings: Vec<Finding>,
    pub(super) figures: Vec<Counterpart>,
    pub(super) measured: Vec<String>,
}

/// The answers of a campaign.
struct Held {
    table: AnswerTable,
}

impl Held {
    fn matrix(&self, task: &str) -> AssociationMatrix {
        let config = MatrixConfig {
            selection: Selection {
                task: Some(task.to_owned()),
                ..Selection::default()
            },
            ..MatrixConfig::default()
        };
        association_matrix(&self.table, &config).by_expected()
    }
}

impl Held {
    /// The share of right answers of each participant to `task`, %, in the order of their pseudonyms.
    fn right_percent(&self, task: &str) -> Vec<f64> {
        let mut people: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
        let answers = self.table.answers().iter();
        for answer in answers.filter(|answer| answer.task == task) {
            let counts = people.entry(&answer.participant).or_default();
            counts[0] += usize::from(answer.presented == answer.answered);
            counts[1] += 1;
        }
        let shares = people.values();
        shares
            .map(|[right, all]| 100.0 * *right as f64 / *all as f64)
            .collect()
    }
}

/// The protocol `name` of the library.
fn protocol(name: &str) -> Result<(Protocol, Sha), ReplayError> {
    let missing = || VolunteerError::Stimulus {
        stimulus: name.to_owned(),
    };
    let (_, text) = LIBRARY
        .iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(missing)?;
    let protocol = read(text).map_err(|_not_of_the_library| missing())?;
    Ok((protocol, Sha::of(text.as_bytes())))
}

/// The campaign `name` of the library with the volunteers `numbers`, rendered with `average` where it is one of those.
fn held(
    laboratory: &Laboratory,
    name: &str,
    numbers: RangeInclusive<u64>,
    average: Option<&TransferFunction<Drive, Acceleration>>,
) -> Result<Held, ReplayError> {
    let (protocol, sha) = protocol(name)?;
    let simulation = Simulation {
        parameters: laboratory.parameters.clone(),
        average: average.cloned(),
        // As the thesis rendered: nothing was corrected in a closed loop.
        iterations: 0,
        playings: Playings::OneStroke,
        ..Simulation::usual(&protocol, sha, laboratory.seed)
    };
    let mut store = MemoryStore::new();
    let done = simulation.run::<VolunteerError>(numbers, &mut store, &mut |_| Ok(()))?;
    let (declared, answers) = simulation.answers(&store, &done.plans)?;
    Ok(Held {
        table: AnswerTable::new(declared, answers)?,
    })
}

/// The percentage of the cell of `presented` and `answered`; NaN where it is untested.
fn percent(matrix: &AssociationMatrix, presented: &str, answered: &str) -> f64 {
    let cell = matrix.cell(presented, answered);
    cell.and_then(|cell| cell.percent).unwrap_or(f64::NAN)
}

/// The diagonal of `names`, %.
fn diagonal<'a>(
    matrix: &'a AssociationMatrix,
    names: impl IntoIterator<Item = &'a str> + 'a,
) -> impl Iterator<Item = f64> + 'a {
    names.into_iter().map(|name| percent(matrix, name, name))
}

/// The mean diagonal of the samples that were presented, %.
fn mean_diagonal(matrix: &AssociationMatrix) -> f64 {
    let presented = matrix.rows.iter().filter(|row| row.presented > 0);
    let own = presented.map(|row| percent(matrix, &row.stimulus.name, &row.stimulus.expected));
    mean(&own.collect::<Vec<f64>>())
}

/// The errors of the rows of `block`, and how many of them lie within it.
fn errors_of(matrix: &AssociationMatrix, block: &[&str]) -> (usize, usize) {
    let mut errors = (0, 0);
    for row in matrix
        .rows
        .iter()
        .filter(|row| block.contains(&&*row.stimulus.name))
    {
        for cell in row
            .cells
            .iter()
            .filter(|cell| cell.answered != row.stimulus.expected)
        {
            errors.0 += cell.declared;
            if block.contains(&&*cell.answered) {
                errors.1 += cell.declared;
            }
        }
    }
    errors
}

/// The rows whose stimulus is `wanted`, alone.
fn only(matrix: &AssociationMatrix, wanted: impl Fn(&Row) -> bool) -> AssociationMatrix {
    AssociationMatrix {
        samples: matrix.samples.clone(),
        rows: matrix
            .rows
            .iter()
            .filter(|row| row.presented > 0 && wanted(row))
            .cloned()
            .collect(),
    }
}

/// `matrix` as the counterpart of a figure; rows and columns that nobody met are left out.
fn drawn(number: &'static str, matrix: &AssociationMatrix, caption: &str) -> Counterpart {
    let rows: Vec<&Row> = matrix.rows.iter().filter(|row| row.presented > 0).collect();
    let columns: Vec<usize> = (0..matrix.samples.len())
        .filter(|i| rows.iter().any(|row| row.cells[*i].offered > 0))
        .collect();
    let outlined = |row: &&Row| {
        let is_expected = |i: &usize| matrix.samples[*i] == row.stimulus.expected;
        columns.iter().position(is_expected)
    };
    let drawn = Matrix {
        rows: rows.iter().map(|row| row.stimulus.name.clone()).collect(),
        columns: columns.iter().map(|i| matrix.samples[*i].clone()).collect(),
        squares: rows
            .iter()
            .map(|row| {
                let expected = outlined(row);
                let cells = columns.iter().enumerate();
                cells
                    .map(|(place, i)| Square {
                        outlined: expected == Some(place),
                        ..Square::plain(
                            row.cells[*i]
                                .percent
                                .map_or(Shade::Untested, Shade::Percent),
                        )
                    })
                    .collect()
            })
            .collect(),
        row_label: "presented".into(),
        column_label: "declared as".into(),
        scale_label: "association, %".into(),
        untested_label: "untested".into(),
    };
    Counterpart {
        number,
        figure: Figure {
            drawn: Drawn::Matrix(drawn),
            caption: caption.to_owned(),
        },
    }
}

/// The campaigns of chapter 4: isotropic and periodic textures, and textures with exchanged levels.
pub(super) fn of_chapter_4(laboratory: &Laboratory) -> Result<Campaigns, ReplayError> {
    let isotropic = held(laboratory, "isotropic_triplets", OF_TEN, None)?;
    let inverted = held(laboratory, "amplitude_inversion", OF_FIVE, None)?;
    let periodic = held(laboratory, "periodic_pilot", PILOT, None)?;
    let tasks = ["task1", "task2", "task3"].map(|task| isotropic.matrix(task));
    let [_, places, associated] = ["", "task2", "task3"].map(|task| inverted.matrix(task));
    let pilot = ["task1", "task2"].map(|task| periodic.matrix(task));
    let (found, manipulated) = (
        [
            confusions(&tasks),
            alike(&tasks),
            by_level(&places, &associated),
            pilot_of(&pilot),
        ],
        only(&associated, |row| !row.stimulus.is_plain()),
    );
    let plain = only(&associated, |row| row.stimulus.is_plain());
    Ok(Campaigns {
        findings: found.into(),
        figures: vec![
            drawn("52a", &pilot[0], "Real periodic textures, one participant."),
            drawn("52b", &pilot[1], "Rendered periodic textures, the same participant."),
            drawn("55a", &tasks[0], "Task 1: the places of 14 real textures, ten participants, three orders each."),
            drawn("55b", &tasks[1], "Task 2: the places of real textures in sets of three. Hatched: never in one set."),
            drawn("55c", &tasks[2], "Task 3: rendered textures. Hatched: never in one set."),
            drawn("63b", &places, "The places of real textures, five participants."),
            drawn("63d", &plain, "Rendered textures with their own levels."),
            drawn("63f", &manipulated, "Rendered textures with exchanged levels; outlined: the sample that has this level."),
        ],
        measured: vec![
            "Ten virtual volunteers did the isotropic campaign, five the one with exchanged levels and one the periodic pilot: strokes, transfer function, renderings in open loop as in the thesis, and sessions as the protocols of the library say. A presentation was one stroke, which counted as often as the protocol repeats it. How volunteers judge: docs/decisions/twin.md.".into(),
        ],
    })
}

const BLOCK: [&str; 5] = ["S9", "S10", "S11", "S12", "S13"];

/// Claim 24.
fn confusions(tasks: &[AssociationMatrix; 3]) -> Finding {
    let right = tasks
        .each_ref()
        .map(|m| least(diagonal(m, ["S4", "S5", "S6", "S7"])));
    let pair = tasks
        .each_ref()
        .map(|m| mean(&[percent(m, "S2", "S3"), percent(m, "S3", "S2")]));
    let inside = tasks.each_ref().map(|m| {
        let (errors, within) = errors_of(m, &BLOCK);
        100.0 * within as f64 / errors as f64
    });
    let smooth = percent(&tasks[0], "NO", "NO");
    let three = |values: [f64; 3]| values.map(|value| format!("{value:.0}")).join(", ");
    Finding::of(
        24,
        Holds::all([
            at_least(
                least(right),
                80.0,
                "%",
                "one of S4 to S7 is taken for a neighbour in more than a fifth of its presentations in some task: their levels are 15 to 20 % apart on average, and finger, strokes and biases of one person move each by 5 to 10 %",
            ),
            at_least(
                least(pair),
                10.0,
                "%",
                "S2 and S3 are confused in less than 10 % of their presentations in some task: each is also presented in sets without the other, which count as well",
            ),
            at_least(
                least(inside),
                80.0,
                "%",
                "of the errors on S9 to S13 more than a fifth lie outside them in some task: S8 is one step of level away from S9",
            ),
            at_least(
                smooth,
                100.0,
                "%",
                "the plate without texture was not always placed last",
            ),
        ]),
        format!(
            "tasks 1, 2 and 3: worst diagonal of S4–S7 {} %; S2 for S3 and S3 for S2 {} % on average; errors of S9–S13 inside the group {} %; plate without texture {smooth:.0} %",
            three(right),
            three(pair),
            three(inside)
        ),
    )
}

/// Claim 25: the cells off the diagonal that were tested in both tasks.
fn alike(tasks: &[AssociationMatrix; 3]) -> Finding {
    let [_, real, rendered] = tasks;
    let mut cells: (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for row in &real.rows {
        for cell in row
            .cells
            .iter()
            .filter(|cell| cell.answered != row.stimulus.expected)
        {
            let other = percent(rendered, &row.stimulus.name, &cell.answered);
            if let (Some(percent), false) = (cell.percent, other.is_nan()) {
                cells.0.push(percent);
                cells.1.push(other);
            }
        }
    }
    let centred = |cells: &[f64]| -> Vec<f64> {
        let middle = mean(cells);
        cells.iter().map(|percent| percent - middle).collect()
    };
    let r = match cells.0.is_empty() {
        true => f64::NAN,
        false => correlation(&centred(&cells.0), &centred(&cells.1)),
    };
    Finding::of(
        25,
        Holds::all([at_least(
            r,
            0.6,
            "",
            "errors on rendered textures lie in other cells than those on real ones: rendered ones lack the spatial cue and the biases of real ones",
        )]),
        format!(
            "correlation {r:.2} of the {} cells off the diagonal of tasks 2 and 3",
            cells.0.len()
        ),
    )
}

/// Claim 27.
fn by_level(places: &AssociationMatrix, associated: &AssociationMatrix) -> Finding {
    let manipulated = only(associated, |row| !row.stimulus.is_plain());
    let expected = 100.0 * manipulated.expected_share().unwrap_or(f64::NAN);
    let misplaced: usize = places.rows.iter().map(errors_in).sum();
    let of_set = |names: [&str; 3]| {
        let plain = only(associated, |row| {
            row.stimulus.is_plain() && names.contains(&&*row.stimulus.name)
        });
        plain.rows.iter().map(errors_in).sum::<usize>()
    };
    let plain = most([of_set(["S2", "S6", "S13"]), of_set(["S5", "S8", "S11"])].map(|n| n as f64));
    let declared = |presented: &str, answered: &str| {
        associated
            .cell(presented, answered)
            .map_or(0, |cell| cell.declared) as f64
    };
    let wanted = declared("S11 INVERTED", "S8");
    let others = manipulated.rows.iter().flat_map(|row| {
        let cells = row.cells.iter().filter(|cell| {
            cell.answered != row.stimulus.expected
                && (&*row.stimulus.name, &*cell.answered) != ("S11 INVERTED", "S8")
        });
        cells.map(|cell| cell.declared as f64)
    });
    let others = most(others);
    Finding::of(
        27,
        Holds::all([
            at_least(
                expected,
                80.0,
                "%",
                "fewer than 80 % of the textures with exchanged levels are taken for the sample that has this level",
            ),
            no_exception(
                misplaced,
                "real textures of a set were not always put in their order: volunteers have lapses (1.5 % of orders have two neighbours exchanged)",
            ),
            at_most(
                plain,
                1.0,
                "",
                "in one of the sets more than one of thirty rendered textures with its own level was taken for another",
            ),
            at_least(
                wanted,
                1.0,
                "",
                "S11 with the level of S5 was never taken for S8, as two of the five participants of the thesis did",
            ),
            at_least(
                wanted - others,
                0.0,
                "",
                "another error on exchanged levels is more frequent than that of S11 taken for S8",
            ),
        ]),
        format!(
            "{expected:.0} % of the textures with exchanged levels as expected; real textures out of place {misplaced}; errors on rendered textures with their own levels in a set at most {plain:.0} of 30; S11 INVERTED taken for S8 {wanted:.0} times, every other error at most {others:.0} times"
        ),
    )
}

/// The answers to a stimulus that are not as expected.
fn errors_in(row: &Row) -> usize {
    let errors = row
        .cells
        .iter()
        .filter(|cell| cell.answered != row.stimulus.expected);
    errors.map(|cell| cell.declared).sum()
}

/// Claim 28, of both matrices: real and rendered.
fn pilot_of(pilot: &[AssociationMatrix; 2]) -> Finding {
    const HARD: [&str; 4] = ["M5", "M7", "M11", "M12"];
    let means = pilot.each_ref().map(mean_diagonal);
    let beyond = pilot.each_ref().map(|matrix| {
        let mut all: Vec<f64> = matrix
            .rows
            .iter()
            .filter(|row| row.presented > 0)
            .map(|row| percent(matrix, &row.stimulus.name, &row.stimulus.name))
            .collect();
        all.sort_by(f64::total_cmp);
        let middle = all.len() / 2;
        let median = match all.len() {
            0 => f64::NAN,
            even if even % 2 == 0 => f64::midpoint(all[middle - 1], all[middle]),
            _ => all[middle],
        };
        most(diagonal(matrix, HARD)) - median
    });
    let apart = pilot.each_ref().map(|m| {
        most(
            [percent(m, "M4", "M8"), percent(m, "M8", "M4")]
                .map(|p| if p.is_nan() { 0.0 } else { p }),
        )
    });
    let two = |values: [f64; 2]| values.map(|value| format!("{value:.0}")).join(" and ");
    Finding::of(
        28,
        Holds::all([
            below(
                most(beyond),
                0.0,
                "points",
                "one of M5, M7, M11 and M12 is recognised as often as half of all samples, or oftener: nearly all answers of one participant are right, and a few errors fall anywhere",
            ),
            at_most(most(apart), 0.0, "%", "M4 and M8 were confused"),
        ]),
        format!(
            "real and rendered: mean diagonal {} %; best of M5, M7, M11, M12 above the median by {} points; M4 and M8 confused in {} %",
            two(means),
            two(beyond),
            two(apart)
        ),
    )
}

/// The campaign of chapter 5: rendered with `average` for people who do not belong to its panel, beside that with everybody's own.
pub(super) fn of_chapter_5(
    laboratory: &Laboratory,
    average: &TransferFunction<Drive, Acceleration>,
) -> Result<Campaigns, ReplayError> {
    let averaged = held(
        laboratory,
        "averaged_transfer_function",
        OF_AVERAGE,
        Some(average),
    )?;
    let own = held(laboratory, "isotropic_triplets", OF_TEN, None)?;
    let tasks = ["task1", "task2", "task3"].map(|task| averaged.matrix(task));
    let own = mean_diagonal(&own.matrix("task3"));
    let with_average = mean_diagonal(&tasks[2]);
    let difference = (own - with_average).abs();
    let finding = Finding::of(
        26,
        Holds::all([at_most(
            difference,
            8.0,
            "points",
            "the mean diagonals of the two campaigns differ by more than 8 points: people outside the panel feel the error of the average, which is up to 4 dB rms for them",
        )]),
        format!(
            "rendered textures: mean diagonal {with_average:.1} % with the average of twenty, {own:.1} % with the own transfer function of ten others"
        ),
    );
    Ok(Campaigns {
        findings: vec![finding],
        figures: vec![
            drawn("80a", &tasks[0], "Task 1: the places of 14 real textures, ten participants outside the panel."),
            drawn("80b", &tasks[1], "Task 2: the places of real textures in sets of three."),
            drawn("80c", &tasks[2], "Task 3: textures rendered with the average transfer function."),
        ],
        measured: vec![
            "Ten virtual volunteers outside the panel of twenty did the campaign of 4.3.2 with textures rendered in open loop with the average of the panel; ten others with their own transfer functions.".into(),
        ],
    })
}

/// The discrimination of chapter 6: three surfaces, with and without imagery.
pub(super) fn of_chapter_6(laboratory: &Laboratory) -> Result<Campaigns, ReplayError> {
    let held = held(laboratory, "touch_control_imagery", OF_SURFACES, None)?;
    let [control, imagery] = ["control", "imagery"].map(|task| held.matrix(task));
    let smooth = percent(&control, "smooth", "smooth");
    let confused = mean(&[
        percent(&control, "rough", "biomimetic"),
        percent(&control, "biomimetic", "rough"),
    ]);
    let means = [&control, &imagery].map(mean_diagonal);
    let each = ["control", "imagery"].map(|task| held.right_percent(task));
    let by_people = paired_difference(&each[0], &each[1]);
    let difference = by_people.map_or("no interval".to_owned(), |d| {
        let [low, high] = d.interval;
        format!(
            "difference over participants {:.1} points (95 %: {low:.1} to {high:.1})",
            d.mean
        )
    });
    let finding = Finding::of(
        32,
        Holds::all([
            at_least(
                smooth,
                100.0,
                "%",
                "without imagery, the smooth surface was not always recognised",
            ),
            above(
                confused,
                0.0,
                "%",
                "without imagery, nobody confused the rough and the biomimetic surface",
            ),
            above(
                by_people.map_or(f64::NAN, |d| d.interval[0]),
                0.0,
                "points",
                "the interval of the difference between imagery and control over participants contains zero: virtual volunteers feel the same textures in both tasks and imagine nothing, as no source gives a number for it",
            ),
        ]),
        format!(
            "control: smooth {smooth:.0} %, rough for biomimetic and biomimetic for rough {confused:.0} % on average; mean diagonal {:.1} % in control, {:.1} % with imagery; {difference}",
            means[0], means[1]
        ),
    );
    Ok(Campaigns {
        findings: vec![finding],
        figures: vec![
            drawn("95a", &control, "Control: rendered textures without imagery, ten participants."),
            drawn("95b", &imagery, "The same with imagery: volunteers of the twin judge both alike."),
        ],
        measured: vec![
            "Ten virtual volunteers did the control and the imagery task of the library's protocol; each surface was associated once in each task.".into(),
        ],
    })
}
