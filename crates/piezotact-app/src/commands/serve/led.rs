//! A session that is led on pages.

use std::io::Write as _;
use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact_dataset::{read_input_text, reads};
use piezotact_people::campaign::session::Event;
use piezotact_session::{BenchStimulator, Given, Runner, Stimulator};
use piezotact_web::{Access, PlayedBy, Role, Screen, Shown, Site, StudyPages, View};

use crate::commands::campaign::export::answers_of;
use crate::commands::campaign::run::{self as session, About, Front, first_command, left, status};
use crate::commands::matrix::report_of;
use crate::failure::{Failure, Outcome, sentence};
use crate::interrupt::{Between, interrupted};
use crate::output::{print, say};
use crate::progress;

/// The file of the pages that were let in, in the folder of the session.
const PAGES: &str = "pages.json";

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    session: session::Arguments,
    /// The port of the pages on this machine; 0 for any that is free.
    #[arg(long, default_value_t = 7700)]
    port: u16,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let address = (Ipv4Addr::LOCALHOST, args.port);
    let listener = TcpListener::bind(address).map_err(|error| {
        Failure::Data(anyhow!(
            "port {} of this machine: {error}; state another --port, or 0 for any that is free",
            args.port
        ))
    })?;
    let mut pages = Pages {
        listener: Some(listener),
        screen: Screen::default(),
    };
    session::lead(&args.session, &mut pages)
}

/// Pages of a browser.
struct Pages {
    listener: Option<TcpListener>,
    screen: Screen,
}

impl Front for Pages {
    fn shown(&self, bench: BenchStimulator<'static>) -> Box<dyn Stimulator> {
        Box::new(Shown::new(bench, self.screen.clone()))
    }

    fn lead(
        &mut self,
        mut runner: Runner<'_>,
        args: &session::Arguments,
        about: About<'_>,
    ) -> Outcome {
        let _ends_between = Between::items("step");
        progress::keep_off();
        if let Some(command) = first_command(&mut runner, args)
            && let Given::Done(Event::ResumeRefused { after_hours }) = runner.give(command)?
        {
            say(&format!(
                "it was left {after_hours:.1} h ago, and the protocol does not let it go on after so long"
            ));
        }
        let played_by = match args.by_hand {
            true => PlayedBy::Hand,
            false => PlayedBy::Bench,
        };
        let kept = about.folder.join(PAGES);
        let access = access(args, &kept)?;
        let codes = [Role::Experimenter, Role::Viewer].map(|role| access.code(role));
        let view = View::of(runner.state(), about.consent, played_by);
        let consent = about.consent.map(str::to_owned);
        let study = Box::new(OfStudy(args.study.clone()));
        let (site, mut desk) =
            Site::new((view, runner.events()?), consent, played_by, access, study);
        self.screen.shows(&desk);
        let Some(listener) = self.listener.take() else {
            return Ok(());
        };
        let at = listener.local_addr()?;
        let served = site.serve(listener).map_err(anyhow::Error::new)?;
        let [experimenter, viewer] = codes.map(Option::unwrap_or_default);
        // Whoever reads may have gone, as behind `head -1`: the pages go on.
        let _reader_gone = print(&format!(
            "experimenter:  http://{at}/enter?code={experimenter}\nto look on:    http://{at}/enter?code={viewer}\nThe participant's code is made on the experimenter's page. Ctrl-C ends the pages; everything that was noted is stored."
        ));
        let done = desk.run(&mut runner, &interrupted);
        drop(served);
        done?;
        match runner.state().is_complete() {
            true => say(&format!("the session is complete: {}", status(&runner))),
            false => return Err(Failure::Data(anyhow!(left(&runner)))),
        }
        Ok(())
    }
}

/// Who is let in: pages that were let in before, and whoever has one of the new codes.
fn access(args: &session::Arguments, kept: &Path) -> Outcome<Access> {
    let name = format!("{} {}", args.participant, args.session);
    let is_there = kept.symlink_metadata().is_ok();
    // Where it cannot be read, pages enter their codes again.
    let known = reads::is_there(kept).then(|| read_input_text(kept).ok());
    let known = known.flatten();
    if is_there && known.is_none() {
        say(&format!(
            "{}: cannot be read; pages that were let in before enter the new codes",
            kept.display()
        ));
    }
    let kept = kept.to_owned();
    let keep = move |json: &str| keep(&kept, json).map_err(|error| error.to_string());
    let access = Access::new(&name, known.as_deref(), Box::new(keep));
    Ok(access.map_err(anyhow::Error::new)?)
}

/// Writes `json` to the side, for this user alone, flushes it, and renames it to `path`.
fn keep(path: &Path, json: &str) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(json.as_bytes())?;
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

/// The study in a folder.
struct OfStudy(PathBuf);

impl StudyPages for OfStudy {
    fn matrix(&self) -> Result<String, String> {
        report_of(&self.0).map_err(said)
    }

    fn answers(&self) -> Result<String, String> {
        answers_of(&self.0).map_err(said)
    }
}

fn said(failure: Failure) -> String {
    match failure {
        Failure::Data(error) | Failure::Usage(error) => sentence(&error),
        _ => "the command ended".to_owned(),
    }
}
