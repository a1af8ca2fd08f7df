//! Answers of participants as a tidy table: one row for each trial.
//!
//! ```text
//! participant,task,set,trial,presented,answered
//! P1,3,A,1,S4,S4
//! P1,3,A,2,S2,S6
//! ```

use piezotact::recording::{RecordingWarning, Simulated};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use piezotact::Warning;
use piezotact_people::association::{
    Answer, AnswerTable, AssociationWarning, Declared, Flag, NotDeclared, Purpose, REPETITION,
    Stimulus,
};

use piezotact_dataset::ReadError;

/// The columns, with other names that say the same; the first five are needed.
const COLUMNS: [(&str, &[&str]); 14] = [
    ("participant", &["subject", "pseudonym", "participant_id"]),
    ("task", &[]),
    ("trial", &["trial_number"]),
    ("presented", &["stimulus"]),
    ("answered", &["declared", "answer", "response"]),
    ("set", &[]),
    ("session", &["repetition"]),
    ("position", &[]),
    ("offered", &["choices"]),
    ("source", &[]),
    ("expected", &[]),
    ("flags", &["flag"]),
    ("rehearsal", &[]),
    ("judge", &[]),
];
const NEEDED: usize = 5;
/// What stands in `answered` where nobody answered, or somebody did not know.
const NO_ANSWER: [&str; 5] = ["n/a", "NA", "NaN", "-", "?"];
/// More labels than this are no samples that hands can tell, and their pairs take minutes.
const MOST_SAMPLES: usize = 500;
/// Names of columns of samples that do not say which was presented and which was answered.
const UNCLEAR: [&str; 12] = [
    "x",
    "y",
    "sample",
    "samples",
    "real",
    "simulated",
    "row",
    "column",
    "first",
    "second",
    "texture",
    "surface",
];
const EXAMPLE: &str = "participant,task,set,trial,presented,answered";

/// Answers with what reading them leaves open.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswersFile {
    pub table: AnswerTable,
    pub warnings: Vec<Warning>,
}

/// The answers in a table with a row for each trial, separated by commas, semicolons or tabs. Columns: participant, task, trial,
/// presented, answered; set, session, position, offered (samples separated by spaces or |), source, expected, flags
/// (`missed_target`, `not_measured`, `wrong_sample`, `simulated`), rehearsal (yes, no) and judge (how a virtual volunteer judges, with a
/// warning) are optional. `n/a` (or NA, NaN, -, ?) in answered is no answer: the row is counted in a warning. The samples are `samples`; where there are none, all
/// that the table names, with a warning.
///
/// # Errors
/// [`ReadError`] naming the file and the row or the column, what was expected and what was found: missing columns, columns that
/// do not say which was presented and which was answered, a matrix, samples that are not declared, an answer that was not
/// offered, a trial with two answers, and no answers.
pub fn read_answers(path: &Path, samples: &[String]) -> Result<AnswersFile, ReadError> {
    let bytes = piezotact_dataset::read_input(path)?;
    let text = match std::str::from_utf8(&bytes) {
        Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect(),
    };
    let file = File { path };
    let rows = file.rows(&text)?;
    let Some(([header], rows)) = rows.split_first_chunk() else {
        return Err(file.wrong(
            format!("a header such as `{EXAMPLE}` and a row for each trial"),
            "nothing",
            "check the file",
        ));
    };
    let columns = file.columns(header, rows)?;
    let mut answers = Vec::new();
    let mut unanswered = 0;
    let mut stimuli: BTreeMap<String, Stimulus> = BTreeMap::new();
    for (at, row) in rows.iter().enumerate() {
        let row = file.row(header, &columns, row, at + 2)?;
        if let Some(made) = row.manipulated()? {
            let known = stimuli.entry(made.name.clone()).or_insert(made.clone());
            if *known != made {
                let [was, is] = [&*known, &made].map(|s| format!("{} as {}", s.source, s.expected));
                return Err(file.wrong(
                    format!("one source and one expected sample for `{}`", made.name),
                    format!("{was}, and {is} in row {}", row.number),
                    "give the two textures two names",
                ));
            }
        }
        let answered = row.get("answered");
        let is_sample = samples.iter().any(|sample| sample == answered);
        match NO_ANSWER.contains(&answered) && !is_sample {
            true => unanswered += 1,
            false => answers.push(row.answer()?),
        }
    }
    let mut warnings = virtual_volunteers(&answers);
    let trials = unanswered;
    warnings.extend((trials > 0).then(|| AssociationWarning::NotKnown { trials }.into()));
    let samples = if samples.is_empty() {
        warnings.push(
            AssociationWarning::NotDeclared {
                what: NotDeclared::Samples,
            }
            .into(),
        );
        samples_of(&answers, &stimuli)
    } else {
        samples.to_vec()
    };
    if samples.len() > MOST_SAMPLES {
        return Err(file.wrong(
            format!("at most {MOST_SAMPLES} samples"),
            format!(
                "{} different entries in presented, answered and offered",
                samples.len()
            ),
            "check these columns",
        ));
    }
    let plain = samples.iter().map(|sample| Stimulus::plain(sample));
    let declared = Declared {
        stimuli: plain.chain(stimuli.into_values()).collect(),
        samples,
    };
    let table = AnswerTable::new(declared, answers).map_err(ReadError::of(path))?;
    Ok(AnswersFile { table, warnings })
}

/// One warning for each way in which virtual volunteers judge.
fn virtual_volunteers(answers: &[Answer]) -> Vec<Warning> {
    let mut sessions: BTreeMap<&str, BTreeSet<[&str; 2]>> = BTreeMap::new();
    for answer in answers {
        if let Some(judge) = &answer.judge {
            // Repetitions of an order are of one session.
            let (session, _) = answer
                .session
                .split_once(REPETITION)
                .unwrap_or((&answer.session, ""));
            let session = [answer.participant.as_str(), session];
            sessions.entry(judge).or_default().insert(session);
        }
    }
    let warning = |(judge, sessions): (&str, BTreeSet<_>)| RecordingWarning::Simulated {
        by: Simulated::Volunteers {
            sessions: sessions.len(),
            judge: judge.to_owned(),
        },
    };
    sessions
        .into_iter()
        .map(warning)
        .map(Warning::from)
        .collect()
}

/// All samples that answers name, in the order of their names, numbers by their size.
fn samples_of(answers: &[Answer], stimuli: &BTreeMap<String, Stimulus>) -> Vec<String> {
    let mut found: BTreeSet<&String> = BTreeSet::new();
    for answer in answers {
        if !stimuli.contains_key(&answer.presented) {
            found.insert(&answer.presented);
        }
        found.insert(&answer.answered);
        found.extend(&answer.offered);
    }
    found.extend(stimuli.values().flat_map(|s| [&s.source, &s.expected]));
    let mut samples: Vec<String> = found.into_iter().cloned().collect();
    samples.sort_by_key(|name| {
        let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let (letters, number) = name.split_at(name.len() - digits);
        (letters.to_owned(), number.parse::<u64>().unwrap_or(0))
    });
    samples
}

/// The file that errors name.
#[derive(Clone, Copy)]
struct File<'a> {
    path: &'a Path,
}

impl<'a> File<'a> {
    fn wrong(
        self,
        expected: impl Into<String>,
        found: impl Into<String>,
        todo: impl Into<String>,
    ) -> ReadError {
        ReadError::content(self.path, expected, found, todo)
    }

    /// The rows that are not empty.
    fn rows(self, text: &str) -> Result<Vec<csv::StringRecord>, ReadError> {
        let first = text.lines().find(|line| !line.trim().is_empty());
        let first = first.unwrap_or("");
        let count = |sign: &u8| first.bytes().filter(|b| b == sign).count();
        let delimiter = [b'\t', b';', b','].into_iter().max_by_key(count);
        let records = csv::ReaderBuilder::new()
            .delimiter(delimiter.unwrap_or(b','))
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes())
            .into_records();
        let mut rows = Vec::new();
        for row in records {
            let row = row.map_err(|error| {
                self.wrong("rows of text", error.to_string(), "repair the file")
            })?;
            if !row.iter().all(str::is_empty) {
                rows.push(row);
            }
        }
        Ok(rows)
    }

    /// Where each known column stands.
    fn columns(
        self,
        header: &csv::StringRecord,
        rows: &[csv::StringRecord],
    ) -> Result<BTreeMap<&'static str, usize>, ReadError> {
        if is_matrix(header, rows) {
            return Err(self.wrong(
                format!("a row for each trial, with columns such as `{EXAMPLE}`"),
                "a matrix of samples by samples, which does not say who answered, nor surely which axis was presented",
                "give the table of answers that it was made of",
            ));
        }
        let names: Vec<String> = header.iter().map(str::to_lowercase).collect();
        let mut found: BTreeMap<&'static str, usize> = BTreeMap::new();
        for (at, name) in names.iter().enumerate() {
            let known = COLUMNS.iter();
            let mut known =
                known.filter(|(column, same)| column == name || same.contains(&&**name));
            let Some((column, _)) = known.next() else {
                continue;
            };
            if let Some(other) = found.insert(column, at) {
                return Err(self.wrong(
                    format!("one column `{column}`"),
                    format!("two: `{}` and `{}`", &header[other], &header[at]),
                    "leave one of them out",
                ));
            }
        }
        let needed_names: Vec<&str> = COLUMNS[..NEEDED].iter().map(|(name, _)| *name).collect();
        let missing = needed_names.iter().copied();
        let missing: Vec<&str> = missing.filter(|c| !found.contains_key(c)).collect();
        if missing.is_empty() {
            return Ok(found);
        }
        let unclear = names.iter().filter(|name| UNCLEAR.contains(&&***name));
        let unclear: Vec<&str> = unclear.map(String::as_str).collect();
        if !unclear.is_empty()
            && missing
                .iter()
                .any(|c| ["presented", "answered"].contains(c))
        {
            return Err(self.wrong(
                "columns `presented` and `answered`",
                format!(
                    "`{}`, which do not say which was presented and which was answered",
                    unclear.join("`, `")
                ),
                "rename them to presented (what was handed over or played) and answered (what it was declared to be)",
            ));
        }
        Err(self.wrong(
            format!("the columns {}", needed_names.join(", ")),
            format!(
                "no {} among {}",
                missing.join(", "),
                header.iter().collect::<Vec<_>>().join(", ")
            ),
            format!("name the columns as in `{EXAMPLE}`"),
        ))
    }

    fn row<'r>(
        self,
        header: &csv::StringRecord,
        columns: &'r BTreeMap<&'static str, usize>,
        cells: &'r csv::StringRecord,
        number: usize,
    ) -> Result<Row<'r>, ReadError>
    where
        'a: 'r,
    {
        let extra = cells.iter().skip(header.len()).any(|cell| !cell.is_empty());
        if extra {
            return Err(self.wrong(
                format!("{} columns in every row, as in the header", header.len()),
                format!("{} in row {number}", cells.len()),
                "put cells that contain the separator in quotes",
            ));
        }
        Ok(Row {
            file: self,
            columns,
            cells,
            number,
        })
    }
}

/// Whether the table is a matrix: its rows are named as its columns are, and hold numbers.
fn is_matrix(header: &csv::StringRecord, rows: &[csv::StringRecord]) -> bool {
    let columns: BTreeSet<&str> = header.iter().skip(1).filter(|c| !c.is_empty()).collect();
    let named: BTreeSet<&str> = rows.iter().filter_map(|row| row.get(0)).collect();
    let shared = columns.intersection(&named).count();
    let numbers = rows.iter().flat_map(|row| row.iter().skip(1));
    let mut numbers = numbers.filter(|cell| !cell.is_empty());
    let number = |cell: &str| {
        let cell = cell.trim_end_matches('%').trim();
        cell.replace(',', ".").parse::<f64>().is_ok() || cell == "n/a" || cell.contains('/')
    };
    shared >= 2 && 2 * shared >= columns.len() && numbers.all(number)
}

/// One row with the places of its columns.
struct Row<'a> {
    file: File<'a>,
    columns: &'a BTreeMap<&'static str, usize>,
    cells: &'a csv::StringRecord,
    number: usize,
}

impl Row<'_> {
    /// What stands in a column; empty where there is no such column.
    fn get(&self, column: &str) -> &str {
        let at = self.columns.get(column);
        at.and_then(|at| self.cells.get(*at)).unwrap_or("")
    }

    fn needed(&self, column: &str) -> Result<String, ReadError> {
        match self.get(column) {
            "" => Err(self.wrong(
                column,
                "an entry",
                "add what is missing, or leave out the row (n/a in `answered` for a trial without an answer)",
            )),
            text => Ok(text.to_owned()),
        }
    }

    fn wrong(&self, column: &str, expected: &str, todo: &str) -> ReadError {
        let found = match self.get(column) {
            "" => "an empty cell".to_owned(),
            text => format!("`{text}`"),
        };
        let found = format!("{found} in row {}, column `{column}`", self.number);
        self.file.wrong(expected, found, todo)
    }

    /// Several names in one cell: between | where there is one, else between spaces.
    fn words(&self, column: &str) -> Vec<&str> {
        let text = self.get(column);
        let between = if text.contains('|') { '|' } else { ' ' };
        let words = text.split(between).map(str::trim);
        words.filter(|word| !word.is_empty()).collect()
    }

    /// The texture that was presented, where it is not a sample's own.
    fn manipulated(&self) -> Result<Option<Stimulus>, ReadError> {
        let name = self.needed("presented")?;
        let source = match self.get("source") {
            "" => name.as_str(),
            source => source,
        };
        let expected = match self.get("expected") {
            "" => source,
            expected => expected,
        };
        if source == name && expected != name {
            return Err(self.wrong(
                "expected",
                &format!("the sample itself (`{name}`) for a sample that is not manipulated"),
                "name the manipulated texture in `presented`, such as `S2 INVERTED`, and its sample in `source`",
            ));
        }
        Ok((source != name).then(|| Stimulus::manipulated(&name, source, expected)))
    }

    fn answer(&self) -> Result<Answer, ReadError> {
        let flags = self.words("flags").into_iter().map(|word| {
            let flag = Flag::ALL.into_iter().find(|flag| flag.word() == word);
            flag.ok_or_else(|| {
                self.wrong(
                    "flags",
                    "missed_target, not_measured, wrong_sample or simulated",
                    "write one of them, or leave the cell empty",
                )
            })
        });
        let position = match self.get("position") {
            "" => None,
            text => Some(text.parse().map_err(|_not_whole| {
                self.wrong("position", "a whole number", "count the places from 1")
            })?),
        };
        let purpose = match self.get("rehearsal").to_lowercase().as_str() {
            "" | "no" | "false" | "0" => Purpose::Trial,
            "yes" | "true" | "1" => Purpose::Rehearsal,
            _ => return Err(self.wrong("rehearsal", "yes or no", "write one of them")),
        };
        Ok(Answer {
            participant: self.needed("participant")?,
            session: self.get("session").into(),
            task: self.needed("task")?,
            set: self.get("set").into(),
            trial: self.needed("trial")?,
            presented: self.needed("presented")?,
            answered: self.needed("answered")?,
            position,
            offered: self.words("offered").into_iter().map(Into::into).collect(),
            flags: flags.collect::<Result<_, _>>()?,
            purpose,
            judge: Some(self.get("judge"))
                .filter(|judge| !judge.is_empty())
                .map(str::to_owned),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, samples: &[&str]) -> Result<AnswersFile, ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("answers.csv");
        std::fs::write(&path, text).unwrap();
        let samples: Vec<String> = samples.iter().map(|&s| s.into()).collect();
        read_answers(&path, &samples)
    }

    #[test]
    fn separators_and_optional_columns_are_read() {
        let text = "participant,task,set,trial,presented,answered,source,expected,flags,rehearsal\n\
            P1,3,A,1,S2 INVERTED,S13,S2,S13,missed_target,\n\
            P1,3,A,2,S6,S10,,,,no\n\
            P1,3,A,3,S6,S6,,,,yes\n";
        for (text, name) in [
            (text.to_owned(), "comma"),
            (text.replace(',', ";"), "semicolon"),
        ] {
            let found = read(&text, &[]).unwrap();
            let declared = found.table.declared();
            assert_eq!(declared.samples, ["S2", "S6", "S10", "S13"], "{name}");
            assert_eq!(
                declared.stimuli[4],
                Stimulus::manipulated("S2 INVERTED", "S2", "S13")
            );
            assert_eq!(
                (found.table.answers().len(), found.table.rehearsals()),
                (2, 1)
            );
            assert_eq!(found.table.answers()[0].flags, [Flag::MissedTarget]);
            assert_eq!(
                found.warnings[0].kind(),
                Some(AssociationWarning::NotDeclared {
                    what: NotDeclared::Samples
                })
            );
        }
        let listed = read(text, &["S1", "S2", "S6", "S10", "S13"]).unwrap();
        assert!(listed.warnings.is_empty() && listed.table.declared().samples.len() == 5);
    }

    #[test]
    fn what_is_no_table_of_answers_is_refused_with_what_to_do() {
        let check = |text: &str, samples: &[&str], parts: &[&str]| {
            let error = read(text, samples).unwrap_err().to_string();
            for part in parts {
                assert!(error.contains(part), "no `{part}` in: {error}");
            }
        };
        check("", &[], &["found nothing", "check the file"]);
        check(
            "participant,set,presented,answered\nP1,A,S1,S1\n",
            &[],
            &[
                "no task, trial among participant, set",
                "name the columns as in",
            ],
        );
        check(
            "participant,task,trial,real,simulated\nP1,3,1,S1,S2\n",
            &[],
            &[
                "`real`, `simulated`, which do not say which",
                "rename them to presented",
            ],
        );
        // A matrix in either order of its axes.
        for corner in ["presented", "answered", ""] {
            let matrix = format!("{corner};S1;S2\nS1;3;0\nS2;1;2\n");
            check(
                &matrix,
                &[],
                &["found a matrix", "give the table of answers"],
            );
        }
        let header = "participant,task,trial,presented,answered";
        check(
            &format!("{header}\nP1,3,1,S9,S1\n"),
            &["S1", "S2"],
            &["participant P1", "declared stimuli (S1, S2)", "`S9`"],
        );
        check(
            &format!("{header}\nP1,3,1,S1,\n"),
            &["S1", "S2"],
            &[
                "an empty cell in row 2, column `answered`",
                "leave out the row",
            ],
        );
        check(
            &format!("{header}\nP1,3,1,S1,S1\nP1,3,1,S1,S2\n"),
            &["S1", "S2"],
            &["one answer for each trial", "number the trials"],
        );
        check(
            &format!("{header},offered\nP1,3,1,S1,S3,S1 S2\n"),
            &["S1", "S2", "S3"],
            &["offered (S1, S2)", "`S3`"],
        );
        check(
            &format!("{header}\n"),
            &["S1", "S2"],
            &["no answers", "at least one trial that is not a rehearsal"],
        );
        check(
            &format!("{header},stimulus\nP1,3,1,S1,S1,S1\n"),
            &[],
            &["one column `presented`", "leave one of them out"],
        );
        check(
            &format!("{header},flags\nP1,3,1,S1,S1,odd\n"),
            &["S1", "S2"],
            &[
                "missed_target, not_measured, wrong_sample or simulated",
                "`odd` in row 2",
            ],
        );
        check(
            &format!("{header},expected\nP1,3,1,S1,S1,S2\n"),
            &["S1", "S2"],
            &["such as `S2 INVERTED`"],
        );
    }

    /// A column that is read has a meaning in the data dictionary of a campaign, and one with a meaning is read.
    #[test]
    fn the_columns_are_those_of_the_data_dictionary() {
        let mut read = COLUMNS.map(|(name, _)| name);
        let mut described = piezotact_people::campaign::dictionary::ANSWER_COLUMNS;
        read.sort_unstable();
        described.sort_unstable();
        assert_eq!(read, described);
    }
}
