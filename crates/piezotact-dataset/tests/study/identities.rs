//! The encrypted identities.

use piezotact_dataset::study::{IdentityError, Passphrase};

use crate::{fill, is_in, name, passphrase, study};

#[test]
fn identities_are_read_with_their_passphrase_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = study(folder.path(), 1);
    assert!(store.identities(&passphrase()).unwrap().is_empty());
    assert!(matches!(
        Passphrase::new(" ".into()),
        Err(IdentityError::Empty)
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
    assert!(matches!(refused, IdentityError::Passphrase { .. }));
    assert!(refused.to_string().contains("type it again"));
    // Nor is anything written with another one.
    let person = people["P01"].clone();
    let refused = store.set_identity(&name("P02"), person.clone(), &wrong);
    assert!(matches!(refused, Err(IdentityError::Passphrase { .. })));
    let refused = store.set_identity(&name("p01"), person, &passphrase());
    assert!(matches!(refused, Err(IdentityError::Pseudonym(_))));
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
            matches!(refused, IdentityError::Damaged { .. }),
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
