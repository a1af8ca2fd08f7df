//! How a command ends when it does not succeed: one sentence, and an exit code that means something.

use std::path::Path;

use anyhow::anyhow;
use piezotact::document::FailedFile;
use piezotact_bench::{DeviceError, ProcedureError};
use piezotact_dataset::WriteError;

use crate::advice::options_for;
use crate::interrupt;
use crate::output::{message, say};

/// Why a command did not do what it was asked.
pub(crate) enum Failure {
    /// The command was asked for something that cannot be: exit code 2, as for a wrong option.
    Usage(anyhow::Error),
    /// The words of the command line make no command, or they ask for help: what is shown then.
    Words(Box<clap::Error>),
    /// The data, a file or a device is not what it must be: exit code 1.
    Data(anyhow::Error),
    /// A verification did not pass; its result has been printed: exit code 3.
    NotPassed,
    /// A verification passed over part of its target; its result has been printed: exit code 4.
    PassedInPart,
    /// A verification could not be decided; its result has been printed: exit code 5.
    NotDecided,
    /// Whoever reads our output has gone: nobody is left to tell.
    ReaderGone,
}

impl Failure {
    /// Whether a result was handed out, which did not pass.
    pub(crate) fn is_verdict(&self) -> bool {
        matches!(
            self,
            Self::NotPassed | Self::PassedInPart | Self::NotDecided
        )
    }
}

/// The outcome of a command.
pub(crate) type Outcome<T = ()> = Result<T, Failure>;

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        let error = error.into();
        match error.downcast_ref() {
            // Another name helps, or `--force`.
            Some(WriteError::Differs { .. }) => Self::Usage(error),
            _ => Self::Data(error),
        }
    }
}

/// Marks an error as one of usage.
pub(crate) fn usage<E: Into<anyhow::Error>>(error: E) -> Failure {
    Failure::Usage(error.into())
}

/// Tells what happened and with which code the program ends: 0 done, 1 data, 2 usage, 3 not passed, 4 passed in part, 5 not decided,
/// 130 ended early by Ctrl-C, 143 by SIGTERM.
pub(crate) fn exit_code(outcome: Outcome) -> u8 {
    match outcome {
        Ok(()) | Err(Failure::ReaderGone) => 0,
        Err(Failure::NotPassed) => 3,
        Err(Failure::PassedInPart) => 4,
        Err(Failure::NotDecided) => 5,
        Err(Failure::Words(error)) => shown(&error),
        Err(Failure::Data(error)) => {
            say(&format!("piezotact: {}", sentence(&error)));
            interrupt::exit_code().unwrap_or(1)
        }
        Err(Failure::Usage(error)) => {
            say(&format!("piezotact: {}", sentence(&error)));
            2
        }
    }
}

/// Shows why a command line is refused, or the help that it asks for; the exit code.
fn shown(error: &clap::Error) -> u8 {
    let text = error.render().to_string();
    let harmless = message(&text);
    if harmless != text {
        say(harmless.trim_end());
        return 2;
    }
    let _nobody_hears = error.print();
    u8::try_from(error.exit_code()).unwrap_or(2)
}

/// An error and what caused it, each said once.
pub(crate) fn sentence(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |mut sentence, cause| {
        let options = options_for(cause);
        let cause = cause.to_string();
        if !sentence.contains(&cause) {
            if !sentence.is_empty() {
                sentence.push_str(": ");
            }
            sentence.push_str(&cause);
        }
        if let Some(options) = options {
            sentence.push_str(&format!(" ({options})"));
        }
        sentence
    })
}

/// The files of a command of several that failed: the others go on.
pub(crate) struct Failures {
    files: Vec<FailedFile>,
    all: usize,
}

impl Failures {
    /// Of a command of so many files.
    pub(crate) fn of(all: usize) -> Self {
        Self {
            files: Vec::new(),
            all,
        }
    }

    /// What a file gave; none where it failed and there are others, which is kept for the end.
    pub(crate) fn unless_failed<T>(
        &mut self,
        file: &Path,
        outcome: Outcome<T>,
    ) -> Outcome<Option<T>> {
        match outcome {
            Ok(value) => Ok(Some(value)),
            Err(Failure::Data(error) | Failure::Usage(error)) if self.all > 1 => {
                self.files.push(FailedFile {
                    file: file.to_owned(),
                    why: message(&sentence(&error)),
                });
                Ok(None)
            }
            Err(failure) => Err(failure),
        }
    }

    /// The files that failed, in their order.
    pub(crate) fn files(&self) -> &[FailedFile] {
        &self.files
    }

    /// Says which files failed, where another error ends the command.
    pub(crate) fn say(&self) {
        for file in &self.files {
            say(&format!("error: {}", file.why));
        }
    }

    /// How the command ends: a list of the files that failed, and exit code 1.
    pub(crate) fn outcome(&self) -> Outcome {
        if self.files.is_empty() {
            return Ok(());
        }
        let (failed, all) = (self.files.len(), self.all);
        let mut text = match failed == all {
            true => format!("none of {all} files gave a result:"),
            false => format!("{failed} of {all} files gave no result, the others did:"),
        };
        for file in &self.files {
            text += &format!("\n  {}", file.why);
        }
        Err(Failure::Data(anyhow!(text)))
    }
}

/// What a bench refuses because of what it was asked is a matter of the command line.
pub(crate) fn bench_failure(error: impl Into<ProcedureError>) -> Failure {
    match error.into() {
        error @ ProcedureError::Device(
            DeviceError::Impossible { .. } | DeviceError::Duration { .. },
        ) => usage(error),
        other => other.into(),
    }
}
