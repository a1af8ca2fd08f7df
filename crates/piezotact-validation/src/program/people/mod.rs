//! `piezotact-validation people`: how often tests of people, panels and EEG find a difference where there is none, and how often their 95 %
//! intervals hold the truth.

#![allow(clippy::print_stdout, reason = "it prints a table")]

mod ability;
mod answers;
mod differences;
mod eeg;
mod felt;
mod panels;
mod thresholds;

use anyhow::{Result, bail, ensure};
use piezotact::statistics::{mean, standard_deviation};
use piezotact_people::interval::clopper_pearson;

use super::verdicts::in_threads;

/// The rate of errors of a test at 5 %.
const ERRORS: [f64; 2] = [0.03, 0.065];
/// The share of 95 % intervals that hold the truth.
const COVERAGE: [f64; 2] = [0.93, 0.97];
/// Where there is something to find, this part of the studies is made.
const OF_POWER: usize = 4;

/// Whether there is something to find.
#[derive(Clone, Copy, PartialEq, Eq)]
enum World {
    /// No difference.
    Null,
    /// The difference that stands above the table.
    Effect,
}

/// What one study says of one question.
#[derive(Clone, Copy)]
struct Found {
    /// Whether a difference is concluded; `None` where that is withheld.
    concluded: Option<bool>,
    /// Whether the interval holds the truth; `None` where there is none.
    holds: Option<bool>,
    /// How far an estimate that is decided is from the truth, in its unit.
    error: Option<f64>,
}

impl Found {
    fn tested(concluded: Option<bool>) -> Self {
        Self {
            concluded,
            holds: None,
            error: None,
        }
    }

    /// Whether `interval` holds `truth`.
    fn estimated(interval: Option<[f64; 2]>, truth: f64) -> Self {
        Self {
            concluded: None,
            holds: interval.map(|[low, high]| low <= truth && truth <= high),
            error: None,
        }
    }
}

/// What is printed of a question.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Printed {
    Test,
    Interval,
    Both,
}

/// A question that every study of a scenario answers.
struct Question {
    name: &'static str,
    printed: Printed,
}

impl Question {
    const fn of(name: &'static str, printed: Printed) -> Self {
        Self { name, printed }
    }
}

/// A study from a seed: what it says of each question.
type Study = Box<dyn Fn(u64, World) -> Result<Vec<Found>> + Sync>;

/// Studies of one kind.
struct Scenario {
    questions: Vec<Question>,
    name: &'static str,
    people: String,
    studies: usize,
    study: Study,
}

/// A part of the table.
struct Part {
    name: &'static str,
    /// What there is to find where power is counted.
    effect: &'static str,
    scenarios: fn() -> Vec<Scenario>,
}

const PARTS: [Part; 8] = [
    Part {
        name: "people",
        effect: "1 logit between groups",
        scenarios: differences::people,
    },
    Part {
        name: "tasks",
        effect: "1 logit between tasks",
        scenarios: differences::tasks,
    },
    Part {
        name: "samples",
        effect: "30 % of presentations are heard",
        scenarios: differences::samples,
    },
    Part {
        name: "shares",
        effect: "35 % right of 25 % by chance; 95 % right of a pair",
        scenarios: answers::scenarios,
    },
    Part {
        name: "felt",
        effect: "",
        scenarios: felt::scenarios,
    },
    Part {
        name: "panels",
        effect: "1 dB louder and half as far apart at the heavier load",
        scenarios: panels::scenarios,
    },
    Part {
        name: "eeg",
        effect: "1 dB between tasks",
        scenarios: eeg::scenarios,
    },
    Part {
        name: "thresholds",
        effect: "",
        scenarios: thresholds::scenarios,
    },
];

/// How many of how many, with what was withheld.
#[derive(Clone, Copy, Default)]
struct Count {
    yes: usize,
    of: usize,
    withheld: usize,
}

impl Count {
    fn of(found: impl Iterator<Item = Option<bool>>) -> Self {
        let mut count = Self::default();
        for one in found {
            match one {
                None => count.withheld += 1,
                Some(yes) => {
                    count.of += 1;
                    count.yes += usize::from(yes);
                }
            }
        }
        count
    }

    /// Of tests: a conclusion that is withheld is none that is wrong.
    fn of_tests(found: impl Iterator<Item = Option<bool>>) -> Self {
        let count = Self::of(found);
        match count.of {
            0 => count,
            of => Self {
                of: of + count.withheld,
                ..count
            },
        }
    }

    /// "5.1 (4.2–6.1)", %; a dash where everything is withheld.
    fn words(self) -> String {
        if self.of == 0 {
            return "–".to_owned();
        }
        let [low, high] = clopper_pearson(self.yes, self.of).map(|share| 100.0 * share);
        format!(
            "{:.1} ({low:.1}–{high:.1})",
            100.0 * self.yes as f64 / self.of as f64
        )
    }

    fn percent(self) -> String {
        match self.of {
            0 => "–".to_owned(),
            of => format!("{:.0}", 100.0 * self.yes as f64 / of as f64),
        }
    }

    /// Where the rate lies, by its 95 % interval over so many studies.
    fn place(self, [least, most]: [f64; 2]) -> Place {
        if self.of == 0 {
            return Place::Withheld;
        }
        let [low, high] = clopper_pearson(self.yes, self.of);
        match (high < least, low > most) {
            (true, _) => Place::Below,
            (_, true) => Place::Above,
            _ => Place::Within,
        }
    }
}

/// Where a rate lies.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Withheld,
    Below,
    Within,
    Above,
}

/// Prints the table of the parts named in `words`; default: all of them.
pub(crate) fn run(words: &[&str]) -> Result<()> {
    let parts: Vec<&Part> = PARTS
        .iter()
        .filter(|part| words.is_empty() || words.contains(&part.name))
        .collect();
    if let Some(unknown) = words
        .iter()
        .find(|word| !PARTS.iter().any(|part| part.name == **word))
    {
        let known: Vec<&str> = PARTS.iter().map(|part| part.name).collect();
        bail!("expected {}, found {unknown}", known.join(", "));
    }
    println!(
        "\nI2 tests at 5 % and intervals of 95 %, over people: errors (a difference is found where there is none) within {:.0} to {:.1} %, intervals that \
         hold the truth within {:.0} to {:.0} %, each with its 95 % interval over studies",
        100.0 * ERRORS[0],
        100.0 * ERRORS[1],
        100.0 * COVERAGE[0],
        100.0 * COVERAGE[1],
    );
    let mut missed = Vec::new();
    let mut counted = 0;
    for part in parts {
        println!("\n  {}{}", part.name, of_effect(part.effect));
        println!(
            "  {:<34}{:<38}{:>8}{:>8}{:>18}{:>9}{:>8}{:>20}{:>9}",
            "what",
            "scenario",
            "people",
            "studies",
            "errors, %",
            "withheld",
            "power",
            "hold, %",
            "withheld"
        );
        for scenario in (part.scenarios)() {
            let (lines, of_scenario) = scenario.counted()?;
            counted += lines;
            missed.extend(of_scenario);
        }
    }
    println!("\n  {counted} rates, {} outside", missed.len());
    ensure!(
        missed.is_empty(),
        "outside the bounds: {}",
        missed.join("; ")
    );
    Ok(())
}

fn of_effect(effect: &str) -> String {
    match effect {
        "" => String::new(),
        effect => format!("; power: {effect}"),
    }
}

impl Scenario {
    /// Prints a line for each question: how many rates there are, and those that are outside their bounds.
    fn counted(&self) -> Result<(usize, Vec<String>)> {
        let null = in_threads(self.studies, |i| (self.study)(i as u64 + 1, World::Null))?;
        let tests = |question: &Question| question.printed != Printed::Interval;
        let effects = match self.questions.iter().any(tests) {
            true => self.studies / OF_POWER,
            false => 0,
        };
        let effects = in_threads(effects, |i| (self.study)(i as u64 + 1, World::Effect))?;
        let (mut rates, mut missed) = (0, Vec::new());
        for (at, question) in self.questions.iter().enumerate() {
            let errors = Count::of_tests(null.iter().map(|found| found[at].concluded));
            let power = Count::of_tests(effects.iter().map(|found| found[at].concluded));
            let holds = Count::of(null.iter().map(|found| found[at].holds));
            let [tested, estimated] = match question.printed {
                Printed::Test => [true, false],
                Printed::Interval => [false, true],
                Printed::Both => [true, true],
            };
            let mut cells = vec![String::new(); 5];
            let mut judged = |what: &str, count: Count, bounds: [f64; 2]| {
                rates += 1;
                let place = count.place(bounds);
                if matches!(place, Place::Above | Place::Below) {
                    missed.push(format!(
                        "{what} of {}, {}, {} people: {} %",
                        question.name,
                        self.name,
                        self.people,
                        count.words()
                    ));
                    return format!("! {}", count.words());
                }
                count.words()
            };
            if tested {
                // A test that withholds conclusions is wrong less often.
                let least = if errors.withheld > 0 { 0.0 } else { ERRORS[0] };
                cells[0] = judged("errors", errors, [least, ERRORS[1]]);
                cells[1] = errors.withheld.to_string();
                cells[2] = power.percent();
            }
            if estimated {
                cells[3] = judged("coverage", holds, COVERAGE);
                cells[4] = holds.withheld.to_string();
            }
            println!(
                "  {:<34}{:<38}{:>8}{:>8}{:>18}{:>9}{:>8}{:>20}{:>9}",
                question.name,
                self.name,
                self.people,
                self.studies,
                cells[0],
                cells[1],
                cells[2],
                cells[3],
                cells[4]
            );
            let errors: Vec<f64> = null.iter().filter_map(|found| found[at].error).collect();
            if errors.len() > 1 {
                println!(
                    "    decided in {}: bias {:+.2} dB, spread {:.2} dB",
                    errors.len(),
                    mean(&errors),
                    standard_deviation(&errors)
                );
            }
        }
        Ok((rates, missed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A test that finds something in a fifth of null studies is outside, and so is one that finds nothing; what is withheld is neither.
    #[test]
    fn rates_outside_their_bounds_are_found() {
        let of = |yes: usize| {
            let found = (0..1_000).map(|i| Some(i < yes));
            Count::of(found)
        };
        let some = [Some(true), Some(false), None];
        let [tests, intervals] = [
            Count::of_tests(some.into_iter()),
            Count::of(some.into_iter()),
        ];
        assert_eq!((tests.yes, tests.of, tests.withheld), (1, 3, 1));
        assert_eq!((intervals.yes, intervals.of, intervals.withheld), (1, 2, 1));
        for (yes, place) in [
            (200, Place::Above),
            (90, Place::Above),
            (50, Place::Within),
            // Compatible with 3 %.
            (25, Place::Within),
            (5, Place::Below),
        ] {
            assert!(of(yes).place(ERRORS) == place, "{yes}");
        }
        assert!(of(999).place(COVERAGE) == Place::Above);
        assert!(Count::of([None; 9].into_iter()).place(COVERAGE) == Place::Withheld);
        assert_eq!(of(50).words(), "5.0 (3.7–6.5)");
    }

    /// Every study answers every question of its scenario, with and without something to find; a seed gives the same study again.
    #[test]
    fn every_study_answers_its_questions() {
        for part in &PARTS {
            let scenarios = (part.scenarios)();
            assert!(!scenarios.is_empty(), "{}", part.name);
            for scenario in &scenarios[..1] {
                for world in [World::Null, World::Effect] {
                    let said = |seed: u64| -> Vec<[Option<bool>; 2]> {
                        let found = (scenario.study)(seed, world).unwrap();
                        found.iter().map(|one| [one.concluded, one.holds]).collect()
                    };
                    let once = said(3);
                    assert_eq!(once.len(), scenario.questions.len(), "{}", part.name);
                    assert_eq!(once, said(3), "{}", part.name);
                }
            }
        }
        assert!(run(&["nothing"]).is_err());
    }
}
