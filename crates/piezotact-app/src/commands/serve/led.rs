//! A session that is led on pages.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::anyhow;
use clap::Args;
use piezotact_dataset::{read_input_text, reads};
use piezotact_study::session::{Runner, Stimulator, TouchBench};
use piezotact_web::{Access, Live, PlayedBy, Role, Screen, Shown, Site, View};

use super::console;
use super::network::{Door, Where, write_for_user};
use super::study::{self, OfStudy};
use crate::commands::campaign::run::{self as session, About, Front, first_command, left, status};
use crate::failure::{Failure, Outcome, usage};
use crate::interrupt::{Between, interrupted};
use crate::live;
use crate::output::{print, say};
use crate::progress;

/// The file of the pages that were let in, in the folder of the session.
pub(super) const PAGES: &str = "pages.json";

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study; none for the console of a bench.
    #[arg(value_name = "STUDY")]
    study: Option<PathBuf>,
    /// The participant's pseudonym; none to look at the study alone.
    #[arg(requires = "session")]
    participant: Option<String>,
    /// The session, by its name in the protocol.
    session: Option<String>,
    #[command(flatten)]
    leading: session::Leading,
    /// The folder of what is made on the console of a bench; drives (WAV) in it can be played.
    #[arg(
        long,
        value_name = "FOLDER",
        default_value = "console",
        conflicts_with = "study"
    )]
    folder: PathBuf,
    /// Simulated benches take as long as real ones, so that the force can be followed on the pages, as in a rehearsal.
    #[arg(long, requires = "study")]
    real_time: bool,
    #[command(flatten)]
    door: Where,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    if let (Some(study), None) = (&args.study, &args.participant) {
        return study::serve(study, args.door.open()?);
    }
    let (Some(study), Some(participant), Some(session)) =
        (&args.study, &args.participant, &args.session)
    else {
        let bench = args.leading.bench.as_ref().ok_or_else(|| {
            usage(anyhow!(
                "expected STUDY PARTICIPANT SESSION, which are led on pages, STUDY alone to look at it, or --bench alone for its console, found none of them; `piezotact campaign status STUDY` lists sessions"
            ))
        })?;
        return console::serve(bench, &args.folder, args.door.open()?);
    };
    if args.real_time {
        live::in_real_time();
    }
    let mut pages = Pages {
        door: Some(args.door.open()?),
        screen: Screen::default(),
    };
    let led = session::Arguments {
        study: study.clone(),
        participant: participant.clone(),
        session: session.clone(),
        leading: args.leading.clone(),
    };
    session::lead(&led, &mut pages)
}

/// Pages of a browser.
struct Pages {
    door: Option<Door>,
    screen: Screen,
}

impl Front for Pages {
    fn shown(&self, bench: TouchBench<'static>) -> Box<dyn Stimulator> {
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
        if let Some(command) = first_command(&mut runner, args) {
            session::require_in_time(&mut runner, &command)?;
            let _begun = runner.give(command)?;
        }
        let played_by = match args.leading.by_hand {
            true => PlayedBy::Hand,
            false => PlayedBy::Bench,
        };
        let Some(door) = self.door.take() else {
            return Ok(());
        };
        let kept = about.folder.join(PAGES);
        // Two studies on one machine may both have a P01.
        let name = format!("{} {}", args.participant, args.session);
        let name = named(&args.study, &name);
        let access = door.guard(access(&name, &kept)?, &args.study)?;
        let codes = [Role::Experimenter, Role::Viewer].map(|role| access.code(role, 0));
        let view = View::of(runner.state(), about.consent, played_by);
        let consent = about.consent.map(str::to_owned);
        let study = Arc::new(OfStudy(args.study.clone()));
        let (site, mut desk) = Site::new(
            (view, runner.events()?),
            (consent, played_by),
            about.stop.clone(),
            access,
            study,
        );
        let site = match &args.leading.bench {
            None => site,
            Some(_) => {
                let (shows, pictures) = Live::new()?;
                live::watched_by(Box::new(move |document| shows.show(document.clone())));
                site.showing(pictures)
            }
        };
        if let Some(why) = about.clock {
            desk.clock_is_behind(why.to_owned());
        }
        self.screen.shows(&desk);
        let said = door.said(
            codes,
            "The participant's code is made on the experimenter's page. Ctrl-C ends the pages; everything that was noted is stored.",
        )?;
        let served = site
            .serve(door.listener, &door.reach)
            .map_err(anyhow::Error::new)?;
        // Whoever reads may have gone, as behind `head -1`: the pages go on.
        let _reader_gone = print(&said);
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

/// The name of `what` in `folder`: cookies are shared by all that one machine serves.
pub(super) fn named(folder: &Path, what: &str) -> String {
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    format!("{}: {what}", folder.display())
}

/// Who is let in to what is called `name`: pages that were let in before, as the file `kept` says, and whoever has one of the new codes.
pub(super) fn access(name: &str, kept: &Path) -> Outcome<Access> {
    let is_there = kept.symlink_metadata().is_ok();
    // Where it cannot be read, pages enter their codes again.
    let known = reads::is_there(kept).then(|| read_input_text(kept).ok());
    let known = known.flatten().filter(|text| Access::reads(text));
    if is_there && known.is_none() {
        say(&format!(
            "{}: cannot be read; pages that were let in before enter the new codes",
            kept.display()
        ));
    }
    let kept = kept.to_owned();
    let keep = move |json: &str| write_for_user(&kept, json).map_err(|error| error.to_string());
    let access = Access::new(name, known.as_deref(), Box::new(keep));
    Ok(access.map_err(anyhow::Error::new)?)
}
