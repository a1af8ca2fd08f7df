//! `piezotact campaign identity`: who the participants are, in an encrypted file of its own.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use piezotact_people::campaign::text::shown;
use piezotact_study::store::{
    ConsentStored, Passphrase, PersonalData, SignedConsent, StudyCampaign,
};

use super::study::{Study, now_ms, open_store, said};
use super::withdraw::passphrase;
use crate::failure::{Outcome, usage};
use crate::output::{print, say};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The participant's pseudonym; without it, all identities are printed.
    #[arg(requires_all = ["name", "contact"])]
    participant: Option<String>,
    /// The file with the passphrase, in its first line: 12 characters or more. The first identity decides it; who loses it loses the names.
    #[arg(long, value_name = "FILE")]
    passphrase: PathBuf,
    /// The person's name.
    #[arg(long, requires = "participant")]
    name: Option<String>,
    /// How the person is reached.
    #[arg(long, requires = "participant")]
    contact: Option<String>,
    /// The version of the study's text of consent that the person signed on paper, now.
    #[arg(long, value_name = "VERSION", requires = "participant")]
    signed: Option<String>,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let passphrase = passphrase(&args.passphrase)?;
    match (&args.participant, &args.name, &args.contact) {
        (Some(participant), Some(name), Some(contact)) => {
            stored(args, &passphrase, [participant, name, contact])?;
        }
        _ => listed(args, &passphrase)?,
    }
    if let Err(weak) = passphrase.check() {
        say(&format!(
            "warning: the passphrase of the identities, which an earlier version accepted, is easy to guess: {weak}; encrypt \
             identity.age anew: age --decrypt identity.age | age --passphrase > new.age, then rename new.age"
        ));
    }
    Ok(())
}

/// Stores who a participant is.
fn stored(
    args: &Arguments,
    passphrase: &Passphrase,
    [participant, name, contact]: [&String; 3],
) -> Outcome {
    let mut study = Study::open(&args.study)?;
    let participant = study.participant(participant)?;
    let consent = signed(args, &study.campaign)?;
    let person = PersonalData {
        name: name.clone(),
        contact: contact.clone(),
        consent,
    };
    let consent = study.store.set_identity(&participant, person, passphrase)?;
    let consent = match consent {
        ConsentStored::Given => "the consent is signed",
        ConsentStored::Kept => "the consent that was signed before is kept",
        ConsentStored::Unsigned => "no consent is signed",
    };
    print(&format!(
        "{participant}: the identity is stored, encrypted; {consent}"
    ))
}

/// Prints all identities.
fn listed(args: &Arguments, passphrase: &Passphrase) -> Outcome {
    let store = open_store(&args.study)?;
    for (pseudonym, person) in store.identities(passphrase)? {
        let consent = person.consent.map_or_else(
            || "no consent signed".to_owned(),
            |signed| {
                format!(
                    "consent {} of {} (UTC)",
                    shown(&signed.version),
                    said(signed.signed_at_ms)
                )
            },
        );
        print(&format!(
            "{}: {}, {}, {consent}",
            shown(&pseudonym),
            shown(&person.name),
            shown(&person.contact)
        ))?;
    }
    Ok(())
}

/// The consent that was signed, where the options say so.
fn signed(args: &Arguments, campaign: &StudyCampaign) -> Outcome<Option<SignedConsent>> {
    match (&args.signed, &campaign.consent) {
        (None, _) => Ok(None),
        (Some(version), Some(text)) => Ok(Some(SignedConsent::new(version, text, now_ms()))),
        (Some(_), None) => Err(usage(anyhow!(
            "the study has no text of consent that could be signed; make it with --consent"
        ))),
    }
}
