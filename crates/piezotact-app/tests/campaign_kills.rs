//! A session that is killed at random moments: every answer that was confirmed on the screen is there once, the next step is right,
//! a log that was cut loses nothing without saying so, and one changed bit is found.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use crate::support::session::{Session, naming, table, trial_shown};
use crate::support::{Done, Folder, copy};

/// Forty answers, and the learning before them.
const TRIALS: usize = 41;

/// How long a session is typed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Until {
    /// It is killed after some lines.
    Killed,
    /// It ends.
    Ended,
}

/// A session and what the script knows of it.
struct Script {
    participant: String,
    random: ChaCha8Rng,
    /// The trials whose confirmation was followed by a further step on the screen.
    confirmed: BTreeMap<usize, String>,
    /// A confirmation that was typed, and by which nothing more stood on the screen yet.
    pending: Option<(usize, String)>,
    /// Each answer that was shown as noted.
    noted: Vec<(usize, String)>,
    trial: usize,
    typed: String,
    /// Whether the answer to be revised was given.
    revised: bool,
    /// Confirmations of which nothing stood on the screen: those that were stored, and those that were not.
    cut: (usize, usize),
    /// Kills before the step after the last line stood on the screen.
    unanswered: usize,
}

fn below(random: &mut ChaCha8Rng, end: usize) -> usize {
    random.next_u32() as usize % end.max(1)
}

/// The answer that belongs to a trial.
fn answer(trial: usize) -> String {
    format!("K{}", (trial * 7 + 3) % 5 + 1)
}

impl Script {
    fn new(participant: &str, seed: u64) -> Self {
        Self {
            participant: participant.to_owned(),
            random: ChaCha8Rng::seed_from_u64(seed),
            confirmed: BTreeMap::new(),
            pending: None,
            noted: Vec::new(),
            trial: 0,
            typed: String::new(),
            revised: false,
            cut: (0, 0),
            unanswered: 0,
        }
    }

    /// Notes what stands on the screen, and gives the line to type.
    fn read(&mut self, text: &str) -> String {
        let lines: Vec<&str> = text.lines().collect();
        let prompt = lines.last().copied().unwrap_or_default();
        if let Some(trial) = trial_shown(text.rsplit_once("── trial").map_or("", |_| text)) {
            self.at(trial, text);
        }
        if prompt.starts_with("Enter ends the session") {
            self.at(TRIALS + 1, text);
        }
        for line in &lines {
            if let Some(noted) = line.trim().strip_prefix("noted: ") {
                assert_eq!(noted, self.typed, "{text}");
                self.noted.push((self.trial, noted.to_owned()));
            }
        }
        if prompt.starts_with("consent>") {
            return "yes".into();
        }
        if prompt.starts_with("answer>") && self.trial > 1 {
            // Every fifth is revised.
            let first = self.trial.is_multiple_of(5);
            self.revised = !first;
            self.typed = answer(self.trial + usize::from(first));
            return self.typed.clone();
        }
        if prompt.starts_with("Enter when it is final") && !self.revised {
            self.revised = true;
            self.typed = answer(self.trial);
            return self.typed.clone();
        }
        if prompt.starts_with("Enter when it is final") {
            self.pending = Some((self.trial, answer(self.trial)));
        } else if prompt.starts_with("answer>") {
            // What is only done has no answer.
            self.pending = Some((self.trial, String::new()));
        }
        String::new()
    }

    /// The trial `trial` is due: the first that is not confirmed.
    fn at(&mut self, trial: usize, text: &str) {
        if let Some((pending, answer)) = self.pending.take() {
            match trial > pending {
                true => {
                    self.confirmed.insert(pending, answer);
                }
                false => self.cut.1 += 1,
            }
        }
        assert_eq!(trial, self.confirmed.len() + 1, "{text}");
        self.trial = trial;
    }

    /// Runs the session until it ends, or until it is killed after some lines; whether it ended.
    fn run(&mut self, folder: &Folder, until: Until) -> bool {
        let kill = until == Until::Killed;
        let command = folder.command(&["campaign", "run", "study", &self.participant, "naming"]);
        let mut session = Session::begin(command);
        let lines = below(&mut self.random, 13);
        if kill && lines == 0 {
            // While it opens the study.
            let after = below(&mut self.random, 120_000) as u64;
            std::thread::sleep(Duration::from_micros(after));
            session.kill();
            return false;
        }
        for number in 1.. {
            let Some(text) = session.prompt() else {
                let (status, said) = session.end();
                assert!(status.success() && !kill, "{said}");
                return true;
            };
            let line = self.read(&text);
            session.type_line(&line);
            if kill && number >= lines {
                // While it stores the answer: what comes after some 0.1 ms as often as what comes after 1 ms.
                let most = 1 << below(&mut self.random, 12);
                let after = below(&mut self.random, most) as u64;
                std::thread::sleep(Duration::from_micros(after));
                session.kill();
                // What stood there before it was killed.
                self.unanswered += 1;
                while let Some(text) = session.prompt() {
                    self.unanswered -= 1;
                    let (trial, pending) = (self.trial, self.pending.clone());
                    self.read(&text);
                    if trial == self.trial {
                        self.pending = pending;
                    } else {
                        self.pending = None;
                    }
                }
                return false;
            }
        }
        unreachable!("a session ends")
    }

    /// The answers in an exported study are those that were confirmed, each once; `stored` of them.
    fn check(&self, exported: &Path) -> usize {
        let of = |row: &&BTreeMap<String, String>| row["participant"] == self.participant;
        let trials = table(&exported.join("trials.csv"));
        let mut stored = BTreeMap::new();
        let mut names = BTreeMap::new();
        for row in trials.iter().filter(of) {
            let number: usize = row["number"].parse().unwrap();
            assert!(names.insert(row["trial"].clone(), number).is_none());
            if !row["seconds"].is_empty() {
                stored.insert(number, row["answer"].clone());
            }
        }
        for (trial, answer) in &self.confirmed {
            assert_eq!(stored.get(trial), Some(answer), "trial {trial}");
        }
        let more: Vec<_> = stored.iter().skip(self.confirmed.len()).collect();
        let pending = self.pending.as_ref().map(|(trial, answer)| (trial, answer));
        assert!(
            more.is_empty() || more == Vec::from_iter(pending),
            "{more:?}"
        );
        let answers = table(&exported.join("answers.csv"));
        let mut seen = BTreeMap::new();
        for row in answers.iter().filter(of) {
            let trial = row["trial"].as_str();
            let earlier = seen.insert(names[trial], row["answered"].clone());
            assert_eq!(earlier, None, "{trial} stands twice");
        }
        stored.remove(&1);
        assert_eq!(seen, stored);
        let events = format!("events/{}_naming.jsonl", self.participant);
        let events = std::fs::read_to_string(exported.join(events)).unwrap_or_default();
        let mut left: Vec<(usize, String)> = events
            .lines()
            .filter_map(|line| {
                let line: serde_json::Value = serde_json::from_str(line).unwrap();
                let event = &line["event"];
                (event["event"] == "answered").then(|| {
                    let trial = names[event["trial"].as_str().unwrap()];
                    let named = event["answer"]["names"][0].as_str();
                    (trial, named.unwrap_or_else(|| panic!("{line}")).to_owned())
                })
            })
            .collect();
        for noted in &self.noted {
            let place = left.iter().position(|one| one == noted);
            left.remove(place.unwrap_or_else(|| panic!("{noted:?} is lost")));
        }
        seen.len()
    }
}

fn run(folder: &Folder, line: &str) -> Done {
    folder.run(&line.split_whitespace().collect::<Vec<_>>())
}

/// A copy of the study whose log lost its last `cut` bytes: whole, or refused with the number of lost changes.
fn torn(folder: &Folder, script: &mut Script) -> Option<bool> {
    let log = folder.path("study/study.sqlite-wal");
    let length = std::fs::metadata(&log).map_or(0, |data| data.len()) as usize;
    if length == 0 {
        return None;
    }
    let torn: PathBuf = folder.path("torn");
    let _may_be_there = std::fs::remove_dir_all(&torn);
    copy(&folder.path("study"), &torn);
    // Every second time within the last page.
    let most = match script.random.next_u32().is_multiple_of(2) {
        true => 4096.min(length),
        false => length,
    };
    let cut = 1 + below(&mut script.random, most);
    let file = std::fs::File::options()
        .write(true)
        .open(torn.join("study.sqlite-wal"))
        .unwrap();
    file.set_len((length - cut) as u64).unwrap();
    let exported = run(folder, "campaign export torn --out from_torn");
    if exported.code() == Some(0) {
        script.check(&folder.path("from_torn"));
        return Some(true);
    }
    exported.expect_failure(1, &["stored answers are missing"]);
    let said = exported.err();
    let number = |before: &str| -> u64 {
        let (_, after) = said.split_once(before).unwrap();
        let digits = after.split(|c: char| !c.is_ascii_digit()).next();
        digits.unwrap().parse().unwrap()
    };
    assert!(number("found ") < number("expected "), "{said}");
    // Without the seal the rest is whole.
    std::fs::remove_file(torn.join("study.seal")).unwrap();
    run(folder, "campaign verify torn").expect_success();
    Some(false)
}

/// Changed copies of the study: a bit of an answer, in the payload of an event.
fn flipped(folder: &Folder, random: &mut ChaCha8Rng, times: usize) {
    let database = std::fs::read(folder.path("study/study.sqlite")).unwrap();
    let word = b"\"event\":\"answered\"";
    let places = database.windows(word.len()).enumerate();
    let places: Vec<usize> = places
        .filter(|(_, window)| window == word)
        .map(|(place, _)| place)
        .collect();
    assert!(places.len() >= 40, "{}", places.len());
    for _ in 0..times {
        let place = places[below(random, places.len())];
        let sample = database[place..].windows(2).position(|two| two == b"\"K");
        let mut changed = database.clone();
        changed[place + sample.unwrap() + 2] ^= 1;
        let other = folder.path("flipped");
        let _may_be_there = std::fs::remove_dir_all(&other);
        copy(&folder.path("study"), &other);
        std::fs::write(other.join("study.sqlite"), changed).unwrap();
        run(folder, "campaign verify flipped").expect_failure(1, &["naming"]);
    }
}

/// Kills sessions `times` in all, 20 in each.
fn kill(times: usize, seed: u64) {
    let folder = Folder::new();
    folder.write("protocol.toml", naming(8));
    run(
        &folder,
        "campaign new study --protocol protocol.toml --seed 7",
    )
    .expect_success();
    let (mut whole, mut lost, mut cut, mut unanswered) = (0, 0, (0, 0), 0);
    for session in 0..times.div_ceil(20) {
        let name = format!("P{:02}", session + 1);
        let mut script = Script::new(&name, seed + session as u64);
        for _ in 0..20 {
            script.run(&folder, Until::Killed);
            match torn(&folder, &mut script) {
                Some(true) => whole += 1,
                Some(false) => lost += 1,
                None => {}
            }
            let exported = run(&folder, "campaign export study --out exported");
            exported.expect_success();
            let stored = script.check(&folder.path("exported"));
            cut.0 += usize::from(stored > script.confirmed.len().saturating_sub(1));
        }
        assert!(script.run(&folder, Until::Ended));
        script.pending = None;
        assert_eq!(script.confirmed.len(), TRIALS);
        run(&folder, "campaign export study --out exported").expect_success();
        assert_eq!(script.check(&folder.path("exported")), TRIALS - 1);
        cut.1 += script.cut.1;
        unanswered += script.unanswered;
        // The same command once more adds nothing.
        let again = run(&folder, &format!("campaign run study {name} naming"));
        again.expect_success();
        assert!(again.out().contains("is complete"), "{}", again.out());
    }
    run(&folder, "campaign verify study").expect_success();
    flipped(
        &folder,
        &mut ChaCha8Rng::seed_from_u64(seed),
        times.div_ceil(5),
    );
    println!(
        "{times} kills, {unanswered} while a line was worked on: of confirmations without a further step on the screen {} were stored and {} were not; of logs that were cut, {whole} held every confirmed answer, {lost} were refused",
        cut.0, cut.1
    );
    // What is cut from a log is its last event, which was acknowledged in nearly every case.
    assert!(lost > 0 && whole + lost > times / 2, "{whole} {lost}");
    assert!(
        unanswered > 0 && (times < 100 || cut.0 > 0 && cut.1 > 0),
        "{unanswered} {cut:?}: kill earlier"
    );
}

#[test]
fn a_confirmed_answer_survives_a_kill_and_a_cut_log() {
    kill(20, 18);
}

#[test]
#[ignore = "300 kills take minutes: ./x soak session_kill"]
fn soak_kill_session() {
    kill(300, 1800);
}
