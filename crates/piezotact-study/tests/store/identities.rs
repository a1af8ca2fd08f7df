//! The encrypted identities.

use piezotact_study::store::StudyError;
use piezotact_study::store::{ConsentStored, Passphrase, PersonalData, SignedConsent};

use crate::{fill, is_in, name, passphrase, study};

#[test]
fn identities_are_read_with_their_passphrase_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = study(folder.path(), 1);
    assert!(store.identities(&passphrase()).unwrap().is_empty());
    assert!(matches!(
        Passphrase::new(" ".into()),
        Err(StudyError::NoPassphrase)
    ));
    fill(&mut store, "P01");
    let path = folder.path().join("identity.age");
    let good = std::fs::read(&path).unwrap();
    assert!(good.starts_with(b"age-encryption.org/v1") && !is_in(&good, "quince"));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        assert_eq!(
            std::fs::metadata(&path).unwrap().permissions().mode() & 0o777,
            0o600
        );
    }
    let people = store.identities(&passphrase()).unwrap();
    assert_eq!(people["P01"].consent.as_ref().unwrap().version, "2");

    let wrong = Passphrase::new("other words".into())
        .unwrap()
        .with_work_factor(2);
    let refused = store.identities(&wrong).unwrap_err();
    assert!(matches!(refused, StudyError::WrongPassphrase { .. }));
    assert!(refused.to_string().contains("type it again"));
    // Nor is anything written with another one.
    let person = people["P01"].clone();
    let refused = store.set_identity(&name("P02"), person.clone(), &wrong);
    assert!(matches!(refused, Err(StudyError::WrongPassphrase { .. })));
    let refused = store.set_identity(&name("p01"), person, &passphrase());
    assert!(matches!(refused, Err(StudyError::PseudonymCase { .. })));
    assert_eq!(std::fs::read(&path).unwrap(), good);

    // Every byte that is changed, and every length that is cut, is found.
    for at in (0..good.len()).step_by(7) {
        let mut bad = good.clone();
        bad[at] ^= 1;
        std::fs::write(&path, &bad).unwrap();
        assert!(store.identities(&passphrase()).is_err(), "byte {at}");
        std::fs::write(&path, &good[..at]).unwrap();
        let refused = store.identities(&passphrase()).unwrap_err();
        assert!(
            matches!(refused, StudyError::IdentitiesDamaged { .. }),
            "{at}: {refused}"
        );
    }
    std::fs::write(&path, "name,contact\n").unwrap();
    let refused = store.identities(&passphrase()).unwrap_err().to_string();
    assert!(
        refused.ends_with("restore the file from a copy"),
        "{refused}"
    );
}

/// `a` encrypts no names; a file that an earlier version wrote with it is still read, changed and erased with it.
#[test]
fn the_first_identity_wants_a_passphrase_that_is_not_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = study(folder.path(), 1);
    let of = |text: &str| Passphrase::new(text.into()).unwrap().with_work_factor(2);
    let person = || PersonalData {
        name: "Rosa".into(),
        contact: "room 7".into(),
        consent: None,
    };
    for (weak, found) in [
        ("a", "1 characters are too few, 12 are needed"),
        ("aaaaaaaaaaaaaaaa", "only 1 different"),
    ] {
        let refused = store.set_identity(&name("P01"), person(), &of(weak));
        let refused = refused.unwrap_err().to_string();
        assert!(
            refused.starts_with("the passphrase: ") && refused.contains(found),
            "{refused}"
        );
        assert!(!folder.path().join("identity.age").exists());
    }
    store
        .set_identity(&name("P01"), person(), &passphrase())
        .unwrap();
    let written = std::fs::read(folder.path().join("identity.age")).unwrap();
    // As an earlier version wrote it.
    let earlier = of("a");
    let plain = age::decrypt(
        &age::scrypt::Identity::new("four words of wood".to_owned().into()),
        &written,
    )
    .unwrap();
    let mut recipient = age::scrypt::Recipient::new("a".to_owned().into());
    recipient.set_work_factor(2);
    let again = age::encrypt(&recipient, &plain).unwrap();
    std::fs::write(folder.path().join("identity.age"), again).unwrap();
    assert_eq!(store.identities(&earlier).unwrap()["P01"].name, "Rosa");
    store
        .set_identity(&name("P02"), person(), &earlier)
        .unwrap();
    assert!(earlier.check().is_err());
}

#[test]
fn a_text_that_would_forge_a_line_of_the_list_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = study(folder.path(), 1);
    let person = |name: &str, contact: &str, version: &str| PersonalData {
        name: name.into(),
        contact: contact.into(),
        consent: Some(SignedConsent::new(version, "I take part.", 0)),
    };
    for (person, part) in [
        (
            person("Rosa\nP02: Quentin", "room 7", "2"),
            "the name of P01: character 5 (U+000A) is a control character",
        ),
        (person("Rosa", "room\u{1b}[2K", "2"), "the contact of P01"),
        (person("Rosa", "\u{202e}7 moor", "2"), "(U+202E)"),
        (
            person("Rosa", "room 7", "2\r1"),
            "the version of the consent",
        ),
    ] {
        let refused = store.set_identity(&name("P01"), person, &passphrase());
        let refused = refused.unwrap_err().to_string();
        assert!(refused.contains(part), "{refused}");
    }
    assert!(!folder.path().join("identity.age").exists());
    // A telephone number begins with a sign that a table would not take.
    store
        .set_identity(&name("P01"), person("Zoë", "+33 1", "2"), &passphrase())
        .unwrap();
}

#[test]
fn a_signed_consent_stays_until_another_one_is_signed() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = study(folder.path(), 1);
    let mut set = |name_of: &str, version: Option<&str>| {
        let person = PersonalData {
            name: name_of.into(),
            contact: "room 7".into(),
            consent: version.map(|version| SignedConsent::new(version, "I take part.", 5)),
        };
        let stored = store.set_identity(&name("P01"), person, &passphrase());
        let people = store.identities(&passphrase()).unwrap();
        let consent = people["P01"].consent.as_ref();
        let version = consent.map(|signed| signed.version.clone());
        (stored.unwrap(), people["P01"].name.clone(), version)
    };
    let expected = |stored, name: &str, version: Option<&str>| {
        (stored, name.to_owned(), version.map(str::to_owned))
    };
    use ConsentStored::{Given, Kept, Unsigned};
    assert_eq!(set("Rosa", None), expected(Unsigned, "Rosa", None));
    assert_eq!(set("Rosa", Some("2")), expected(Given, "Rosa", Some("2")));
    assert_eq!(set("Rosa B", None), expected(Kept, "Rosa B", Some("2")));
    assert_eq!(set("Rosa", Some("3")), expected(Given, "Rosa", Some("3")));
}
