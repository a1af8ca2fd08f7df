//! How the program ends when it does not succeed: one sentence, and an exit code that means something.

use std::process::ExitCode;

use piezotact_dataset::WriteError;

use super::output::say;

/// The name of the program, before what it says of its end.
pub(super) const NAME: &str = "piezotact-validation";

/// Why a command did not do what it was asked.
#[derive(Debug)]
pub(super) enum Failure {
    /// The command was asked for something that cannot be: exit code 2, as for a wrong option.
    Usage(anyhow::Error),
    /// The data or a file is not what it must be: exit code 1.
    Data(anyhow::Error),
    /// Whoever reads our output has gone: nobody is left to tell.
    ReaderGone,
}

/// The outcome of a command.
pub(super) type Outcome<T = ()> = Result<T, Failure>;

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
pub(super) fn usage(error: anyhow::Error) -> Failure {
    Failure::Usage(error)
}

/// Tells what happened and with which code the program ends: 0 done, 1 data, 2 usage.
pub(super) fn exit_code(outcome: Outcome) -> ExitCode {
    match outcome {
        Ok(()) | Err(Failure::ReaderGone) => ExitCode::SUCCESS,
        Err(Failure::Data(error)) => {
            say(&format!("{NAME}: {}", sentence(&error)));
            ExitCode::FAILURE
        }
        Err(Failure::Usage(error)) => {
            say(&format!("{NAME}: {}", sentence(&error)));
            ExitCode::from(2)
        }
    }
}

/// An error and what caused it, each said once.
fn sentence(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |mut sentence, cause| {
        let cause = cause.to_string();
        if !sentence.contains(&cause) {
            if !sentence.is_empty() {
                sentence.push_str(": ");
            }
            sentence.push_str(&cause);
        }
        sentence
    })
}
