//! What the tests of the program share.

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

/// A folder of its own in which the program is run.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_piezotact-validation"));
        command
            .args(arguments)
            .current_dir(self.0.path())
            .stdin(Stdio::null());
        command
    }

    /// Runs the program, which may replace what it left before.
    pub(crate) fn run(&self, arguments: &[&str]) -> Done {
        self.run_as_given(&[&["--force"], arguments].concat())
    }

    /// Runs the program as it is given.
    pub(crate) fn run_as_given(&self, arguments: &[&str]) -> Done {
        Done {
            called: arguments.join(" "),
            output: self.command(arguments).output().unwrap(),
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

    pub(crate) fn code(&self) -> Option<i32> {
        self.output.status.code()
    }

    #[track_caller]
    pub(crate) fn expect_success(&self) {
        assert!(
            self.output.status.success(),
            "{}: {}",
            self.called,
            self.err()
        );
    }

    /// It failed with `code`, in one sentence that holds every one of `parts`, and without a panic.
    #[track_caller]
    pub(crate) fn expect_failure(&self, code: i32, parts: &[&str]) {
        let (called, text) = (&self.called, self.err());
        assert_eq!(self.code(), Some(code), "{called}: {text}");
        assert!(!text.contains("panicked"), "{called}: {text}");
        for part in parts {
            assert!(
                text.contains(part),
                "{called}: expected `{part}` in: {text}"
            );
        }
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
