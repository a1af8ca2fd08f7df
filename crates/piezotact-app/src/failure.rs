//! How a command ends when it does not succeed: one sentence, and an exit code that means something.

use std::process::ExitCode;

use crate::advice::options_for;
use crate::output::say;

/// Why a command did not do what it was asked.
pub(crate) enum Failure {
    /// The command was asked for something that cannot be: exit code 2, as for a wrong option.
    Usage(anyhow::Error),
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

/// The outcome of a command.
pub(crate) type Outcome<T = ()> = Result<T, Failure>;

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Data(error.into())
    }
}

/// Marks an error as one of usage.
pub(crate) fn usage<E: Into<anyhow::Error>>(error: E) -> Failure {
    Failure::Usage(error.into())
}

/// Tells what happened and with which code the program ends: 0 done, 1 data, 2 usage, 3 not passed, 4 passed in part, 5 not decided.
pub(crate) fn exit_code(outcome: Outcome) -> ExitCode {
    match outcome {
        Ok(()) | Err(Failure::ReaderGone) => ExitCode::SUCCESS,
        Err(Failure::NotPassed) => ExitCode::from(3),
        Err(Failure::PassedInPart) => ExitCode::from(4),
        Err(Failure::NotDecided) => ExitCode::from(5),
        Err(Failure::Data(error)) => {
            say(&format!("piezotact: {}", sentence(&error)));
            ExitCode::from(1)
        }
        Err(Failure::Usage(error)) => {
            say(&format!("piezotact: {}", sentence(&error)));
            ExitCode::from(2)
        }
    }
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
