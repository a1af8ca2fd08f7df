//! How a command ends when it does not succeed: one sentence, and an exit code that means something.

use std::process::ExitCode;

/// Why a command did not do what it was asked.
pub(crate) enum Failure {
    /// The command was asked for something that cannot be: exit code 2, as for a wrong option.
    Usage(anyhow::Error),
    /// The data, a file or a device is not what it must be: exit code 1.
    Data(anyhow::Error),
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

/// Tells what happened and with which code the program ends: 0 done, 1 data, 2 usage.
#[allow(clippy::print_stderr, reason = "this is where errors are told")]
pub(crate) fn exit_code(outcome: Outcome) -> ExitCode {
    match outcome {
        Ok(()) | Err(Failure::ReaderGone) => ExitCode::SUCCESS,
        Err(Failure::Data(error)) => {
            eprintln!("piezotact: {error:#}");
            ExitCode::from(1)
        }
        Err(Failure::Usage(error)) => {
            eprintln!("piezotact: {error:#}");
            ExitCode::from(2)
        }
    }
}
