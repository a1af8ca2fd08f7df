//! What the tests of the command share.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test says what it skipped, and fails where it cannot go on"
)]

#[cfg(feature = "study")]
pub(crate) mod session;
#[path = "../../../piezotact/tests/shared_data/mod.rs"]
mod shared_data;

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

#[allow(unused_imports, reason = "each test file uses its part")]
pub(crate) use shared_data::shared;

/// Every command and every command of a command.
pub(crate) const COMMANDS: &[&str] = &[
    "demo",
    "info",
    "spectrum",
    "characterise",
    "transfer",
    "manipulate",
    "render",
    "play",
    "record",
    "verify",
    "prepare",
    "score",
    "serve",
    "strokes",
    "compare",
    "roughness",
    "answers",
    "sound",
    "sound devices",
    "sound calibrate",
    "sound latency",
    "sound burst",
    "sound align",
    "eeg",
    "eeg info",
    "eeg epochs",
    "eeg erd",
    "eeg stats",
    "bids",
    "bids export",
    "bids import",
    "bids check",
    "campaign",
    "campaign design",
    "campaign identity",
    "campaign protocol",
    "campaign new",
    "campaign join",
    "campaign plan",
    "campaign run",
    "campaign simulate",
    "campaign status",
    "campaign export",
    "campaign verify",
    "campaign withdraw",
    "panel",
    "panel run",
    "panel add",
    "panel analyse",
    "panel average",
    "export",
    "twin",
    "twin record",
    "twin plant",
    "twin surface",
    "twin parameters",
    "rerun",
];

/// Copies a folder with everything in it.
pub(crate) fn copy(from: &std::path::Path, to: &std::path::Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let there = to.join(path.file_name().unwrap());
        match path.is_dir() {
            true => copy(&path, &there),
            false => {
                std::fs::copy(&path, there).unwrap();
            }
        }
    }
}

/// A folder of its own in which the command is run.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A copy of the folder that `make` makes once for all tests of a program.
    pub(crate) fn once(made: &OnceLock<Self>, make: impl FnOnce() -> Self) -> Self {
        let folder = Self::new();
        copy(made.get_or_init(make).0.path(), folder.0.path());
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_piezotact"));
        command
            .args(arguments)
            .current_dir(self.0.path())
            .stdin(Stdio::null());
        command
    }

    /// Runs a command that may replace what an earlier one left: most tests use a folder several times.
    pub(crate) fn run(&self, arguments: &[&str]) -> Done {
        let forced: Vec<&str> = ["--force"]
            .into_iter()
            .chain(arguments.iter().copied())
            .collect();
        self.run_as_given(&forced)
    }

    /// Runs a command as it is given.
    pub(crate) fn run_as_given(&self, arguments: &[&str]) -> Done {
        let output = self.command(arguments).output().unwrap();
        Done {
            called: arguments.join(" "),
            output,
        }
    }

    /// The names of what is in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// A command that has ended.
pub(crate) struct Done {
    called: String,
    output: Output,
}

impl Done {
    pub(crate) fn out(&self) -> String {
        String::from_utf8_lossy(&self.output.stdout).into_owned()
    }

    pub(crate) fn err(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).into_owned()
    }

    #[track_caller]
    pub(crate) fn expect_success(&self) {
        assert!(
            self.output.status.success(),
            "piezotact {}: {}",
            self.called,
            self.err()
        );
    }

    /// It failed with `code`, in one sentence that holds every one of `parts`, and without a panic.
    #[track_caller]
    pub(crate) fn expect_failure(&self, code: i32, parts: &[&str]) {
        let (called, text) = (&self.called, self.err());
        assert_eq!(
            self.output.status.code(),
            Some(code),
            "piezotact {called}: {text}"
        );
        assert!(!text.contains("panicked"), "piezotact {called}: {text}");
        for part in parts {
            assert!(
                text.contains(part),
                "piezotact {called}: expected `{part}` in: {text}"
            );
        }
    }

    /// Its JSON, with which code it ended.
    #[track_caller]
    pub(crate) fn json_and_code(&self) -> (serde_json::Value, Option<i32>) {
        (
            serde_json::from_slice(&self.output.stdout).unwrap(),
            self.output.status.code(),
        )
    }

    #[track_caller]
    pub(crate) fn code(&self) -> Option<i32> {
        self.output.status.code()
    }

    #[track_caller]
    pub(crate) fn json(&self) -> serde_json::Value {
        self.expect_success();
        serde_json::from_slice(&self.output.stdout).unwrap()
    }
}

/// A document without how it was made.
pub(crate) fn results(mut document: serde_json::Value) -> serde_json::Value {
    let made = document.as_object_mut().unwrap().remove("invocation");
    assert!(made.is_some());
    document
}

pub(crate) const BENCH: &str = "twin:participant=1,seed=7";

/// A mono WAV file of 16-bit integers.
pub(crate) fn wav(samples: impl Iterator<Item = f64>, rate_hz: u32) -> Vec<u8> {
    let data: Vec<u8> = samples
        .flat_map(|v| ((v * 32_767.0).round() as i16).to_le_bytes())
        .collect();
    let mut bytes = b"RIFF".to_vec();
    bytes.extend((36 + data.len() as u32).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16u32.to_le_bytes());
    bytes.extend([1, 0, 1, 0]);
    bytes.extend(rate_hz.to_le_bytes());
    bytes.extend((rate_hz * 2).to_le_bytes());
    bytes.extend([2, 0, 16, 0]);
    bytes.extend(b"data");
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes
}

/// Noise-like samples of about 0.3 rms that hold something at every frequency.
pub(crate) fn noise(count: usize) -> impl Iterator<Item = f64> {
    let mut state = 1u64;
    (0..count).map(move |_| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    })
}

/// A folder with a texture, the transfer function of a twin, and what is wrong in one way or another.
pub(crate) fn prepared() -> Folder {
    static PREPARED: OnceLock<Folder> = OnceLock::new();
    Folder::once(&PREPARED, || {
        let folder = Folder::new();
        folder.write("texture.wav", wav(noise(20_000), 5_000));
        folder
            .run(&[
                "characterise",
                "--bench",
                BENCH,
                "--seconds",
                "10",
                "--out",
                "tf.json",
            ])
            .expect_success();
        folder
    })
}

pub(crate) const RENDER: [&str; 7] = [
    "render",
    "texture.wav",
    "--transfer",
    "tf.json",
    "--out",
    "drive.wav",
    "--scale",
];

/// Nothing is fetched and nothing runs; what a program reads is data alone.
#[track_caller]
pub(crate) fn self_contained(html: &str) {
    const SAVE: &str = include_str!("../../../piezotact-report/src/save.js");
    for outside in ["fetch", "XMLHttpRequest", "WebSocket", "import", "http"] {
        let found = SAVE.replace("http://www.w3.org/", "");
        assert!(!found.contains(outside), "the script reaches for {outside}");
    }
    let html = html
        .replace("<script type=\"application/json\"", "")
        .replace(&format!("<script>{SAVE}"), "");
    for outside in ["<script", "<link", "src=", "http://", "https://", "url("] {
        let found = html
            .match_indices(outside)
            .filter(|(at, _)| !html[*at..].starts_with("http://www.w3.org/"));
        assert_eq!(found.count(), 0, "the report reaches for {outside}");
    }
}
