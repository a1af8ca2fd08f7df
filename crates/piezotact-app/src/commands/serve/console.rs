//! The console of a bench: procedures are commands of this program, run beside it, whose runs are shown while they are acquired.
//!
//! A command that is stopped, or outlives the console, keeps what it acquired as it does on a terminal.

use std::collections::{BTreeMap, VecDeque};
use std::io::{BufRead as _, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use anyhow::anyhow;
use piezotact::run::RunDocument;
use piezotact_dataset::reads;
use piezotact_web::{
    Answerable, BenchRequest, ConsoleDesk, Field, FieldKind, Live, Procedure, Role, Site, Word,
};

use super::led::{access, named};
use super::network::Door;
use crate::benches::BenchSpec;
use crate::failure::{Failure, Outcome};
use crate::interrupt::{Between, interrupted};
use crate::invocation::this_program;
use crate::output::print;
use crate::progress;

/// How often requests and the running command are looked for.
const LOOK: Duration = Duration::from_millis(50);
/// How long a command may take to end when the console ends; after that it ends by itself.
const ENDING: Duration = Duration::from_millis(1500);
/// The file of the pages that were let in.
const PAGES: &str = "pages.json";
/// Larger files are fetched from the folder, bytes.
const LARGEST: u64 = 1 << 29;
/// The sample that is touched unless another one is chosen.
const USUAL_SAMPLE: &str = "S8";
/// The name of a console among pages.
const NAME: &str = "console";

/// Serves the console of `bench` at `door`, with everything that is made in `folder`.
pub(super) fn serve(bench: &BenchSpec, folder: &Path, door: Door) -> Outcome {
    let _ends_between = Between::items("command");
    progress::keep_off();
    // Refused before a page is opened.
    drop(bench.open()?);
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::Data(anyhow!("{}: {error}", folder.display())))?;
    let access = door.guard(access(&named(folder, NAME), &folder.join(PAGES))?, folder)?;
    let codes = [Role::Experimenter, Role::Viewer].map(|role| access.code(role, 0));
    let (live, pictures) = Live::new()?;
    let made = folder.to_owned();
    let file = Box::new(move |name: &str| {
        let path = made.join(name);
        let about = std::fs::symlink_metadata(&path).ok()?;
        let is_sent = about.is_file() && about.len() <= LARGEST;
        is_sent.then(|| reads::read(&path).ok()).flatten()
    });
    let procedures = procedures(bench, folder);
    let (site, desk) = Site::console(bench.text(), procedures.clone(), file, access);
    let site = site.showing(pictures);
    let said = door.said(
        codes,
        "Ctrl-C ends the pages; a command that runs is stopped and keeps what it acquired.",
    )?;
    let served = site
        .serve(door.listener, &door.reach)
        .map_err(anyhow::Error::new)?;
    // Whoever reads may have gone: the pages go on.
    let _reader_gone = print(&said);
    let mut console = Console {
        bench: bench.clone(),
        folder: folder.to_owned(),
        procedures,
        live,
        running: None,
    };
    while !interrupted() {
        if let Some(asked) = desk.next(LOOK) {
            console.answer(&desk, asked);
        }
        console.look(&desk);
    }
    drop(served);
    console.end();
    Ok(())
}

/// The procedures that can be started on `bench`.
fn procedures(bench: &BenchSpec, folder: &Path) -> Vec<Procedure> {
    let number = |name, label, unit, usual, range| Field {
        name,
        label,
        unit,
        kind: FieldKind::Number { usual, range },
    };
    let choice = |name, label, choices: &[&str]| Field {
        name,
        label,
        unit: "",
        kind: FieldKind::Choice(choices.iter().map(ToString::to_string).collect()),
    };
    let force = number("load", Word::ForceWord, "N", 0.2, [0.01, 10.0]);
    let angle = number("angle", Word::AngleWord, "°", 20.0, [0.0, 90.0]);
    let mut all = vec![Procedure {
        name: "characterise",
        title: Word::Characterise,
        fields: vec![
            choice(
                "excitation",
                Word::Excitation,
                &["random", "sweep", "multisine"],
            ),
            number("seconds", Word::Duration, "s", 60.0, [1.0, 3600.0]),
            number("repeats", Word::RepeatsWord, "", 1.0, [1.0, 100.0]),
            force.clone(),
            angle.clone(),
        ],
    }];
    let drives = drives(folder);
    if !drives.is_empty() {
        let drives: Vec<&str> = drives.iter().map(String::as_str).collect();
        all.push(Procedure {
            name: "play",
            title: Word::PlayDrive,
            fields: vec![
                choice("drive", Word::DriveFile, &drives),
                force.clone(),
                angle,
            ],
        });
    }
    if bench.person_of_twin().is_none() {
        all.push(Procedure {
            name: "record",
            title: Word::RecordTouch,
            fields: vec![
                Field {
                    name: "sample",
                    label: Word::SampleName,
                    unit: "",
                    kind: FieldKind::Name,
                },
                number("speed", Word::SpeedWord, "mm/s", 30.0, [1.0, 500.0]),
                number("seconds", Word::Duration, "s", 60.0, [1.0, 3600.0]),
                force.clone(),
            ],
        });
    }
    if bench.person_of_twin().is_some() {
        let samples = piezotact_twin::TwinParameters::built_in();
        let mut samples = samples.sample_names();
        samples.sort_by_key(|name| *name != USUAL_SAMPLE);
        all.push(Procedure {
            name: "touch",
            title: Word::TouchSample,
            fields: vec![
                choice("bench", Word::TouchBenchWord, &["acttouch", "triboair"]),
                choice("sample", Word::SampleWord, &samples),
                number("speed", Word::SpeedWord, "mm/s", 30.0, [1.0, 500.0]),
                number("strokes", Word::StrokeCount, "", 10.0, [1.0, 1000.0]),
                force,
            ],
        });
    }
    all
}

/// The drives in `folder`.
fn drives(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut drives: Vec<String> = names.filter(|name| name.ends_with(".wav")).collect();
    drives.sort();
    drives
}

struct Console {
    bench: BenchSpec,
    folder: PathBuf,
    procedures: Vec<Procedure>,
    live: Live,
    running: Option<Running>,
}

/// A command that runs, and those that follow it when it is done.
struct Running {
    child: Child,
    stem: String,
    said: Receiver<String>,
    then: VecDeque<Vec<String>>,
}

impl Console {
    fn answer(&mut self, desk: &ConsoleDesk, asked: Answerable) {
        let answer = match (&asked.request, &mut self.running) {
            (BenchRequest::Stop, None) => Err("nothing runs".to_owned()),
            (BenchRequest::Stop, Some(running)) => {
                running.then.clear();
                interrupt(&mut running.child);
                desk.change(|view| view.say("stop asked for"));
                Ok(())
            }
            (BenchRequest::Start { .. }, Some(_)) => {
                Err("something runs already: stop it, or wait until it has ended".to_owned())
            }
            (BenchRequest::Start { procedure, values }, None) => {
                self.start(desk, procedure, values)
            }
        };
        asked.answer(answer);
    }

    fn start(
        &mut self,
        desk: &ConsoleDesk,
        procedure: &str,
        values: &BTreeMap<String, String>,
    ) -> Result<(), String> {
        let known = self.procedures.iter().find(|known| known.name == procedure);
        let known = known.ok_or_else(|| format!("there is no procedure `{procedure}`"))?;
        let values = checked(known, values)?;
        let stem = self.free_stem(procedure);
        let path = |ending: &str| {
            self.folder
                .join(format!("{stem}.{ending}"))
                .display()
                .to_string()
        };
        let mut commands = VecDeque::from(commands(
            procedure,
            &values,
            &self.bench,
            &self.folder,
            &path,
        ));
        let first = commands.pop_front().unwrap_or_default();
        let running = begun(&first, &self.live, stem).map_err(|error| error.to_string())?;
        desk.change(|view| {
            view.running = Some(running.stem.clone());
            view.command = Some(line(&first));
            view.say(format!("{} begins", running.stem));
        });
        self.running = Some(Running {
            then: commands,
            ..running
        });
        Ok(())
    }

    /// The first name of `procedure` under which nothing stands.
    fn free_stem(&self, procedure: &str) -> String {
        let entries = std::fs::read_dir(&self.folder)
            .into_iter()
            .flatten()
            .flatten();
        let names: Vec<String> = entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        let mut number = 1;
        loop {
            let stem = format!("{procedure}-{number}");
            let taken = |name: &String| {
                let rest = name.strip_prefix(&stem);
                rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()))
            };
            if !names.iter().any(taken) {
                return stem;
            }
            number += 1;
        }
    }

    /// Shows what the running command said, and goes on when it has ended.
    fn look(&mut self, desk: &ConsoleDesk) {
        let Some(running) = &mut self.running else {
            return;
        };
        let ended = running.child.try_wait();
        let is_over = !matches!(ended, Ok(None));
        if is_over {
            // What was said last may still be on its way.
            while let Ok(line) = running.said.recv_timeout(LOOK) {
                desk.change(|view| view.say(line));
            }
        }
        for line in running.said.try_iter() {
            desk.change(|view| view.say(line));
        }
        if !is_over {
            return;
        }
        let code = ended.ok().flatten().and_then(|status| status.code());
        let is_done = code == Some(0);
        let next = running.then.pop_front().filter(|_| is_done);
        let stem = running.stem.clone();
        self.running = next.as_ref().and_then(|next| {
            let then = std::mem::take(&mut running.then);
            let begun = begun(next, &self.live, stem.clone()).ok()?;
            Some(Running { then, ..begun })
        });
        let files = made(&self.folder);
        let goes_on = self.running.is_some();
        desk.change(|view| {
            view.files = files;
            if let Some(next) = next.filter(|_| goes_on) {
                view.command = Some(line(&next));
                return;
            }
            view.running = None;
            view.say(match code {
                Some(0) => format!("{stem}: done"),
                Some(code) => format!("{stem}: ended with exit code {code}"),
                None => format!("{stem}: was ended from outside"),
            });
        });
    }

    /// Stops what runs; it has a moment to keep what it acquired, and ends by itself after that.
    fn end(&mut self) {
        let Some(running) = &mut self.running else {
            return;
        };
        interrupt(&mut running.child);
        let began = Instant::now();
        while began.elapsed() < ENDING && matches!(running.child.try_wait(), Ok(None)) {
            std::thread::sleep(LOOK);
        }
    }
}

/// The values of `procedure`, each of which is one that it may be.
fn checked<'a>(
    procedure: &Procedure,
    values: &'a BTreeMap<String, String>,
) -> Result<BTreeMap<&'static str, &'a str>, String> {
    let mut found = BTreeMap::new();
    for field in &procedure.fields {
        let value = values.get(field.name).map(|value| value.trim());
        let value =
            value.ok_or_else(|| format!("expected a value for {}, found none", field.name))?;
        match &field.kind {
            FieldKind::Number {
                range: [low, high], ..
            } => {
                let number = value.parse::<f64>().ok();
                if !number.is_some_and(|number| (*low..=*high).contains(&number)) {
                    return Err(format!(
                        "{}: expected a number from {low} to {high} {}, found `{value}`",
                        field.name, field.unit
                    ));
                }
            }
            FieldKind::Name => {
                let is_name = value.len() <= 64
                    && !value.starts_with('-')
                    && !value.chars().any(char::is_control);
                if !is_name {
                    return Err(format!(
                        "{}: expected a short name that does not begin with a hyphen, found `{value}`",
                        field.name
                    ));
                }
            }
            FieldKind::Choice(choices) => {
                if !choices.iter().any(|choice| choice == value) {
                    return Err(format!(
                        "{}: expected one of {}, found `{value}`",
                        field.name,
                        choices.join(", ")
                    ));
                }
            }
        }
        found.insert(field.name, value);
    }
    Ok(found)
}

/// The commands of `procedure`, one after the other, which write at `path`.
fn commands(
    procedure: &str,
    values: &BTreeMap<&'static str, &str>,
    spec: &BenchSpec,
    folder: &Path,
    path: &dyn Fn(&str) -> String,
) -> Vec<Vec<String>> {
    let bench = &spec.text();
    let value = |name: &str| values.get(name).copied().unwrap_or_default().to_owned();
    let words = |words: &[&str]| words.iter().map(ToString::to_string).collect::<Vec<_>>();
    let finger = [
        "--load".to_owned(),
        value("load"),
        "--angle".to_owned(),
        value("angle"),
    ];
    match procedure {
        "characterise" => {
            let mut command = words(&["characterise", "--live", "--bench", bench]);
            command.extend(["--excitation".to_owned(), value("excitation")]);
            command.extend(["--seconds".to_owned(), value("seconds")]);
            command.extend(["--repeats".to_owned(), value("repeats")]);
            command.extend(finger);
            command.extend([
                "--out".to_owned(),
                path("json"),
                "--record".to_owned(),
                path("parquet"),
            ]);
            command.extend(["--report".to_owned(), path("html")]);
            vec![command]
        }
        "play" => {
            let drive = folder.join(value("drive")).display().to_string();
            let mut command = words(&["play", &drive, "--live", "--bench", bench]);
            command.extend(finger);
            command.extend(["--record".to_owned(), path("parquet")]);
            vec![command]
        }
        "record" => {
            let record = path("parquet");
            let mut command = words(&["record", "--live", "--bench", bench, "--out", &record]);
            if !value("sample").is_empty() {
                command.extend(["--sample".to_owned(), value("sample")]);
            }
            command.extend(["--speed".to_owned(), format!("{} mm/s", value("speed"))]);
            command.extend(["--seconds".to_owned(), value("seconds")]);
            command.extend(["--load".to_owned(), value("load")]);
            let cuts = words(&["strokes", &record, "--cuts-only", "--report", &path("html")]);
            vec![command, cuts]
        }
        _ => {
            let record = path("parquet");
            let mut command = words(&["twin", "record", "--live", "--out", &record]);
            command.extend(["--bench".to_owned(), value("bench")]);
            command.extend(["--sample".to_owned(), value("sample")]);
            command.extend(["--speed".to_owned(), format!("{} mm/s", value("speed"))]);
            command.extend(["--strokes".to_owned(), value("strokes")]);
            command.extend(["--load".to_owned(), value("load")]);
            if let Some((participant, seed)) = spec.person_of_twin() {
                command.extend([
                    format!("--participant={participant}"),
                    format!("--seed={seed}"),
                ]);
            }
            let cuts = words(&["strokes", &record, "--cuts-only", "--report", &path("html")]);
            vec![command, cuts]
        }
    }
}

/// `words` as a command that can be typed.
fn line(words: &[String]) -> String {
    let quoted =
        |word: &String| match word.contains([' ', '\'', '"', '(', ')', '&', ';', '*', '?', '$']) {
            true => format!("'{}'", word.replace('\'', r"'\''")),
            false => word.clone(),
        };
    let words: Vec<String> = words
        .iter()
        .filter(|word| *word != "--live")
        .map(quoted)
        .collect();
    format!("piezotact {}", words.join(" "))
}

/// This program with `words`, whose runs `live` shows.
fn begun(words: &[String], live: &Live, stem: String) -> std::io::Result<Running> {
    let mut child = this_program()?
        .args(words)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let (says, said) = channel();
    let of_stdout = (says.clone(), live.clone());
    if let Some(out) = child.stdout.take() {
        let (says, live) = of_stdout;
        std::thread::spawn(move || told(out, &says, Some(&live)));
    }
    if let Some(err) = child.stderr.take() {
        std::thread::spawn(move || told(err, &says, None));
    }
    Ok(Running {
        child,
        stem,
        said,
        then: VecDeque::new(),
    })
}

/// Shows the documents among the lines of `from`, and says the others.
fn told(from: impl Read, says: &Sender<String>, live: Option<&Live>) {
    for line in BufReader::new(from).lines() {
        let Ok(line) = line else {
            return;
        };
        let document = live
            .filter(|_| line.starts_with("{\"document\":"))
            .and_then(|live| Some((live, serde_json::from_str::<RunDocument>(&line).ok()?)));
        match document {
            Some((live, document)) => live.show(document),
            None if line.trim().is_empty() => {}
            // Where nobody listens any more, the command goes on.
            None => drop(says.send(line)),
        }
    }
}

/// What was made in `folder`, the newest first.
fn made(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .filter_map(|entry| {
            let name = entry.file_name().to_str()?.to_owned();
            let about = entry.metadata().ok()?;
            let is_made = ["characterise-", "play-", "touch-", "record-"]
                .iter()
                .any(|stem| name.starts_with(stem));
            (about.is_file() && is_made).then(|| (about.modified().ok(), name))
        })
        .collect();
    files.sort_by(|a, b| b.cmp(a));
    files.into_iter().map(|(_, name)| name).collect()
}

/// Asks a command to end in order, as Ctrl-C does.
#[cfg(unix)]
fn interrupt(child: &mut Child) {
    let id = rustix::process::Pid::from_child(child);
    // One that has ended already needs none.
    let _ended = rustix::process::kill_process(id, rustix::process::Signal::INT);
}

/// Ends a command; its journal keeps what it acquired.
#[cfg(not(unix))]
fn interrupt(child: &mut Child) {
    let _ended = child.kill();
}
