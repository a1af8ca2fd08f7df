//! `piezotact campaign withdraw`: erases everything of a participant.

use std::io::{BufRead as _, IsTerminal as _, Read as _};
use std::path::{Path, PathBuf};

use clap::Args;
use piezotact::number::counted;
use piezotact_dataset::read_input_text;
use piezotact_study::store::{Passphrase, Pseudonym, Remains, StudyStore};

use super::study::{now_ms, open_store};
use crate::failure::{Outcome, usage};
use crate::output::{print, say};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The participant's pseudonym.
    participant: String,
    /// A file with the passphrase of the identities, where the study has some.
    #[arg(long, value_name = "FILE")]
    passphrase: Option<PathBuf>,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    // The protocol is not needed: nothing keeps a participant from withdrawing.
    let mut store = open_store(&args.study)?;
    let participant = Pseudonym::new(&args.participant).map_err(usage)?;
    let passphrase = args.passphrase.as_deref().map(passphrase).transpose()?;
    if !is_confirmed(&participant)? {
        return print("nothing was erased");
    }
    require_not_led(&store, &participant)?;
    // Before the links are removed with the rest.
    let linked = store.linked_outside(&participant)?;
    let erased = store.withdraw(&participant, now_ms(), passphrase.as_ref())?;
    print(&format!(
        "{participant}: erased {}, {}, {}; a tombstone stays, with which the journals verify. Copies of the folder and what was exported are not reached: erase them too.",
        counted(erased.sessions, "session"),
        counted(erased.files, "file"),
        match erased.identities {
            1 => "1 identity".to_owned(),
            several => format!("{several} identities"),
        }
    ))?;
    say_remains(&participant, &erased.remains);
    for path in linked {
        say(&format!(
            "{} was linked in the folder of {participant}: the link was removed, what it led to was not erased; look at it, and erase it by hand",
            path.display()
        ));
    }
    for path in store.named_alike(&participant)? {
        say(&format!(
            "{} may hold data of {participant}, by its name: it was not erased; look at it, and erase it by hand",
            path.display()
        ));
    }
    Ok(())
}

/// Refuses while a session of `participant` is led: it would go on, and what plays with it. It is withdrawn from there, which stops both.
fn require_not_led(store: &StudyStore, participant: &Pseudonym) -> Outcome {
    for entry in store.entries()? {
        let (of, session) = entry.key.names();
        let is_of = of == participant.as_str();
        if is_of && store.session_folder(participant, session)?.is_dir() {
            drop(store.run_alone(participant, session)?);
        }
    }
    Ok(())
}

/// Says what a server that stations share still has.
fn say_remains(participant: &Pseudonym, remains: &Remains) {
    if *remains == Remains::Nothing {
        return;
    }
    say(&format!(
        "The write-ahead log of the server, its replicas and its backups may still hold answers of {participant}: they are the administrator's to erase. Other stations erase their files of {participant} when they open the study next."
    ));
    if let Remains::NotRewritten { why } = remains {
        say(&format!(
            "The tables were not rewritten, as {why}: what was erased may stand in free space of their files until their owner opens the study, or executes VACUUM FULL piezotact.events and VACUUM FULL piezotact.plans."
        ));
    }
}

/// Asks at a keyboard for the pseudonym once more; a script is not asked.
fn is_confirmed(participant: &Pseudonym) -> Outcome<bool> {
    let keyboard = std::io::stdin();
    if !keyboard.is_terminal() {
        return Ok(true);
    }
    say(&format!(
        "Everything of {participant} is erased: sessions, recordings, identity. It cannot be undone. Type {participant} to confirm:"
    ));
    let mut line = String::new();
    // Nothing longer is a pseudonym.
    let _bytes = keyboard.lock().take(1000).read_line(&mut line)?;
    Ok(line.trim() == participant.as_str())
}

/// The passphrase in the first line of `file`.
pub(super) fn passphrase(file: &Path) -> Outcome<Passphrase> {
    let text = read_input_text(file)?;
    let line = text.lines().next().unwrap_or_default();
    Ok(Passphrase::new(line.to_owned())?)
}
