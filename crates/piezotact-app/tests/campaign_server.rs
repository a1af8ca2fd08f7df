//! A study that stations share in a PostgreSQL database, from the command line: the same campaign as in a folder, at two stations.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::campaign_session::{holds, line_for, run, session, until, whole};
use crate::postgres::{Server, server};
use crate::support::session::naming;
use crate::support::{Done, Folder, results};

const MEASUREMENT: &str = "campaign run study P01 measurement";
const BY_HAND: &str = "campaign run study P01 discrimination --by-hand";

/// Protocol and consent text of a campaign whose sessions can be done in a row.
fn prepared() -> Folder {
    let folder = Folder::new();
    let library = folder.run(&["campaign", "protocol", "amplitude_inversion"]);
    let protocol = library.out().replace("another_day", "any_time");
    folder.write("protocol.toml", protocol);
    folder.write("consent.txt", "I take part.\n");
    folder
}

const NEW: &str = "campaign new study --protocol protocol.toml --seed 7 --consent consent.txt";

#[track_caller]
fn done(folder: &Folder, line: &str) -> Done {
    let done = run(folder, line);
    done.expect_success();
    done
}

#[test]
fn two_stations_have_the_matrix_of_one() {
    let database = server().database();
    let (alone, here, there) = (prepared(), prepared(), Folder::new());
    done(&alone, NEW);
    whole(&alone, MEASUREMENT);
    whole(&alone, BY_HAND);

    let made = done(&here, &format!("{NEW} --store {database}"));
    holds(
        &made.err(),
        &[&format!(
            "another station takes part with: piezotact campaign join {database} FOLDER"
        )],
    );
    holds(
        &done(&there, &format!("campaign join {database} study")).out(),
        &[
            "a station of the study with the protocol",
            "sessions so far: 0",
        ],
    );
    whole(&here, MEASUREMENT);
    // The second session at the other station.
    whole(&there, BY_HAND);

    for line in [
        "answers study --json",
        "campaign plan study P02 discrimination --json",
    ] {
        let of = |folder: &Folder| {
            let document = run(folder, line).json();
            match line.starts_with("answers") {
                true => results(document),
                false => document,
            }
        };
        assert_eq!(of(&alone), of(&here), "{line}");
        assert_eq!(of(&alone), of(&there), "{line}");
    }
    let matrices = [&alone, &here, &there].map(|folder| done(folder, "answers study").out());
    assert!(matrices.iter().all(|matrix| *matrix == matrices[0]));
    let status = done(&there, "campaign status study").out();
    holds(
        &status,
        &["1 of", "measurement", "discrimination", "complete"],
    );
    for folder in [&here, &there] {
        let verified = done(folder, "campaign verify study").out();
        holds(&verified, &["2 sessions verified"]);
        done(folder, "campaign export study --out exported");
    }

    here.write("secret.txt", "four words of wood\n");
    there.write("secret.txt", "other words of stone\n");
    for folder in [&here, &there] {
        let line = "campaign identity study P01 --contact none --passphrase secret.txt --name Rosa";
        done(folder, line);
    }
    let withdrawn = done(&here, "campaign withdraw study P01 --passphrase secret.txt");
    holds(&withdrawn.out(), &["erased 2 sessions", "1 identity"]);
    holds(
        &withdrawn.err(),
        &[
            "The write-ahead log of the server, its replicas and its backups may still hold answers of P01",
        ],
    );
    let left = server().sql(&database, "SELECT count(payload) FROM piezotact.events");
    assert_eq!(left, "0");
    let plans = server().sql(&database, "SELECT count(*) FROM piezotact.plans");
    assert_eq!(plans, "0");
    let status = done(&there, "campaign status study");
    holds(
        &status.err(),
        &[
            "P01 has withdrawn at another station, and",
            "identity.age may still hold who it is",
            "piezotact campaign withdraw study P01 --passphrase FILE",
        ],
    );
    holds(&status.out(), &["withdrawn and erased"]);
    done(
        &there,
        "campaign withdraw study P01 --passphrase secret.txt",
    );
    assert_eq!(done(&there, "campaign status study").err(), "");
    done(&there, "campaign verify study");
}

/// The server crashes in the middle of a session: what was typed is refused aloud, and given again once it runs.
#[test]
fn a_session_goes_on_when_the_server_runs_again() {
    let own = Server::start("");
    let database = own.database();
    let folder = Folder::new();
    folder.write("protocol.toml", naming(1));
    let line = format!("campaign new study --protocol protocol.toml --seed 7 --store {database}");
    done(&folder, &line);
    let mut first = session(&folder, "campaign run study P01 naming");
    until(&mut first, "one of K1");
    own.crash();
    let refused = first.type_and_read("K1");
    holds(
        &refused,
        &["NOT STORED", "check the network and that the server runs"],
    );
    own.start_again();
    let text = first.type_and_read("K1");
    let mut seen = text;
    loop {
        first.type_line(&line_for(&seen));
        match first.prompt() {
            Some(next) => seen = next,
            None => break,
        }
    }
    let (status, said) = first.end();
    assert!(status.success(), "{said}");
    holds(&done(&folder, "campaign status study").out(), &["complete"]);
    done(&folder, "campaign verify study");
    // Meanwhile the pages of a session are served on the same store: another station is refused while it runs.
    let other = Folder::new();
    done(&other, &format!("campaign join {database} study"));
    let mut second = session(&folder, "campaign run study P02 naming");
    until(&mut second, "consent");
    let held = run(&other, "campaign run study P02 naming");
    held.expect_failure(
        1,
        &["session naming of P02 is run by another program (a station at 127.0.0.1)"],
    );
}

#[test]
fn an_address_with_a_password_is_not_repeated() {
    let folder = prepared();
    for line in [
        format!("{NEW} --store postgres://lab:quince@127.0.0.1/touch"),
        "campaign join postgres://lab:quince@127.0.0.1/touch study".to_owned(),
    ] {
        let refused = run(&folder, &line);
        refused.expect_failure(2, &["holds a password: leave it out", "PGPASSWORD"]);
        assert!(!refused.err().contains("quince"), "{}", refused.err());
        assert!(!folder.path("study").exists());
    }
    run(&folder, &format!("{NEW} --store touch")).expect_failure(
        2,
        &["expected the URL of a database, such as postgres://user@host:5432/database"],
    );
    run(
        &folder,
        "campaign join postgres://lab@127.0.0.1:1/touch study",
    )
    .expect_failure(
        1,
        &[
            "postgres://lab@127.0.0.1:1/touch",
            "check host and port in the URL",
        ],
    );
    assert!(!folder.path("study").exists());
}

#[test]
fn the_password_is_that_of_the_environment_or_of_the_users_file() {
    let own = Server::start("");
    let database = own.database();
    own.sql(&database, "CREATE ROLE keeper LOGIN PASSWORD 'quince'");
    own.sql(
        &database,
        &format!(
            "GRANT CREATE ON DATABASE {} TO keeper",
            database.rsplit('/').next().unwrap()
        ),
    );
    own.allow("host all lab 127.0.0.1/32 trust\nhost all keeper 127.0.0.1/32 scram-sha-256\n");
    let folder = prepared();
    let url = database.replace("lab@", "keeper@");
    let line = format!("{NEW} --store {url}");
    let words: Vec<&str> = line.split(' ').collect();
    run(&folder, &line).expect_failure(
        1,
        &["check the user in the URL, and the password in PGPASSWORD or ~/.pgpass"],
    );
    let made = folder
        .command(&words)
        .env("PGPASSWORD", "quince")
        .output()
        .unwrap();
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    folder.write("passwords", "127.0.0.1:*:*:keeper:quince\n");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let alone = std::fs::Permissions::from_mode(0o600);
        std::fs::set_permissions(folder.path("passwords"), alone).unwrap();
    }
    let mut status = folder.command(&["campaign", "status", "study"]);
    let status = status
        .env("PGPASSFILE", folder.path("passwords"))
        .output()
        .unwrap();
    assert!(
        status.status.success(),
        "{}",
        String::from_utf8_lossy(&status.stderr)
    );
    for file in std::fs::read_dir(folder.path("study")).unwrap() {
        let path = file.unwrap().path();
        let has = path.is_file()
            && std::fs::read(&path)
                .unwrap()
                .windows(6)
                .any(|w| w == b"quince");
        assert!(!has, "{}", path.display());
    }
}
