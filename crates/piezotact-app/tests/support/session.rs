//! A session of a campaign, typed by a script that reads what stands on the screen.

use std::io::{Read as _, Write as _};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use piezotact_people::campaign::protocol::LIBRARY;

/// How long a script waits for the next prompt.
const PATIENCE: Duration = Duration::from_secs(60);

/// A session under way.
pub(crate) struct Session {
    child: Child,
    keyboard: Option<ChildStdin>,
    screen: Receiver<Vec<u8>>,
    /// Everything that stood on the screen.
    pub(crate) seen: String,
    said: Option<std::thread::JoinHandle<String>>,
}

impl Session {
    /// Begins `command`, such as `piezotact campaign run …`.
    pub(crate) fn begin(mut command: Command) -> Self {
        let pipes = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = pipes.spawn().unwrap();
        let mut stdout = child.stdout.take().unwrap();
        let mut stderr = child.stderr.take().unwrap();
        let (sender, screen) = channel();
        let _until_it_ends = std::thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(count) = stdout.read(&mut buffer) {
                if count == 0 || sender.send(buffer[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        let said = std::thread::spawn(move || {
            let mut text = Vec::new();
            let _what_there_is = stderr.read_to_end(&mut text);
            String::from_utf8_lossy(&text).into_owned()
        });
        Self {
            keyboard: child.stdin.take(),
            child,
            screen,
            seen: String::new(),
            said: Some(said),
        }
    }

    /// The process.
    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// What stands on the screen up to the next prompt, with it; `None` where the program ended instead.
    pub(crate) fn prompt(&mut self) -> Option<String> {
        let mut bytes = Vec::new();
        loop {
            match self.screen.recv_timeout(PATIENCE) {
                Ok(more) => bytes.extend(more),
                Err(RecvTimeoutError::Disconnected) => {
                    self.seen.push_str(&String::from_utf8_lossy(&bytes));
                    return None;
                }
                Err(RecvTimeoutError::Timeout) => {
                    self.kill();
                    panic!("no prompt in {PATIENCE:?}:\n{}", self.seen);
                }
            }
            if bytes.ends_with(b"> ") {
                let text = String::from_utf8_lossy(&bytes).into_owned();
                self.seen.push_str(&text);
                return Some(text);
            }
        }
    }

    /// Types `line`.
    pub(crate) fn type_line(&mut self, line: &str) {
        let keyboard = self.keyboard.as_mut().unwrap();
        // A program that was killed reads nothing.
        let _read = keyboard
            .write_all(format!("{line}\n").as_bytes())
            .and_then(|()| keyboard.flush());
    }

    /// Types `line`; gives what stands there up to the next prompt, or up to the end.
    #[track_caller]
    pub(crate) fn type_and_read(&mut self, line: &str) -> String {
        let before = self.seen.len();
        self.type_line(line);
        let _prompt = self.prompt();
        self.seen[before..].to_owned()
    }

    /// Kills the process, as a lost machine would.
    pub(crate) fn kill(&mut self) {
        let _may_have_ended = self.child.kill();
        let _status = self.child.wait();
    }

    /// Ends the input; gives how the program ended, and what it said on standard error.
    pub(crate) fn end(mut self) -> (ExitStatus, String) {
        drop(self.keyboard.take());
        while self.prompt().is_some() {}
        let status = self.child.wait().unwrap();
        (status, self.said.take().unwrap().join().unwrap())
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.kill();
    }
}

/// The number of the trial whose heading stands last in `text`: `trial 7 of 41`.
pub(crate) fn trial_shown(text: &str) -> Option<usize> {
    let (_, after) = text.rsplit_once("trial ")?;
    let (number, _) = after.split_once(" of ")?;
    number.parse().ok()
}

/// A table of `campaign export`: each row by the names of its columns.
pub(crate) fn table(path: &std::path::Path) -> Vec<std::collections::BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader
        .deserialize()
        .collect::<Result<_, _>>()
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A protocol with one session `naming`: five samples are learned and then named, each `presentations` times.
pub(crate) fn naming(presentations: usize) -> String {
    format!(
        r#"form = 1
name = "naming"
title = "Five samples from memory"
source = "a test"
samples = ["K1", "K2", "K3", "K4", "K5"]
tray_slots = 5
orientation = {{ K1 = "notch left", K2 = "notch left", K3 = "notch left", K4 = "notch left", K5 = "notch left" }}

[exploration]
finger = "dominant index"
direction = "proximal"

[resuming]
at = "trial_anew"
refused_after_hours = 12

[panel]
participants = 3

[aims]
session = "naming"
pairs = "all"
scoring = "by_position"
power_share = 0.8
half_width_share = 0.15
cell_share = 0.8
logit_sd = 0.9

[[sets]]
name = "A"
samples = ["K1", "K2", "K3", "K4", "K5"]

[[tasks]]
name = "task1"
title = "Samples from memory"
instruction = "Say for each sample which one it is."
checklist = ["blindfold on"]
seconds_per_trial = 10
kind = "identify"
presentations = {presentations}

[[sessions]]
name = "naming"
when = "any_time"

[[sessions.blocks]]
name = "memory"
tasks = ["task1"]
task_order = "as_listed"
over = "all_samples"
set_order = "as_listed"
repeats = 1
"#
    )
}

/// The isotropic protocol of the library with two sets, four samples, strokes played once, and both sessions on one day.
pub(crate) fn two_sets() -> String {
    let (_, library) = LIBRARY
        .iter()
        .find(|(name, _)| *name == "isotropic_triplets")
        .unwrap();
    let (head, _) = library.split_once("[[sets]]").unwrap();
    let (_, tasks) = library.split_once("[[tasks]]").unwrap();
    let (head_start, samples) = head.split_once("samples = [").unwrap();
    let (_, head_end) = samples.split_once(']').unwrap();
    let sets = "[[sets]]\nname = \"A\"\nsamples = [\"S2\", \"S4\", \"S8\"]\n\n[[sets]]\nname = \"M\"\nsamples = [\"S4\", \"S8\", \"S9\"]\n\n[[tasks]]";
    let playing = "playing = { how = \"repeated\", pause_s = 0.5, duration_s = 30 }";
    let text =
        format!("{head_start}samples = [\"S2\", \"S4\", \"S8\", \"S9\"]{head_end}{sets}{tasks}");
    assert!(text.contains(playing) && text.contains("another_day"));
    text.replace(playing, "playing = { how = \"once\" }")
        .replace("another_day", "any_time")
}
