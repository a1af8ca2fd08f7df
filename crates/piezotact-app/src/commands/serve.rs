//! `piezotact serve`: a session with a participant on pages of a browser.

#[cfg(feature = "web")]
mod console;
#[cfg(feature = "web")]
mod led;
#[cfg(feature = "web")]
mod network;
#[cfg(feature = "web")]
mod study;

#[cfg(feature = "web")]
pub(crate) use led::{Arguments, run};

/// What there is without pages.
#[cfg(not(feature = "web"))]
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: std::path::PathBuf,
    /// The participant, the session, and how it is led.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    others: Vec<String>,
}

/// Says that there are no pages.
#[cfg(not(feature = "web"))]
pub(crate) fn run(args: &Arguments) -> crate::failure::Outcome {
    let _others = &args.others;
    Err(crate::failure::usage(anyhow::anyhow!(
        "{}: this build has no pages; build piezotact with ./x build, or lead the session on the terminal with piezotact campaign run",
        args.study.display()
    )))
}
