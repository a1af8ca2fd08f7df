//! A build without some commands says which build has them.

use crate::support::Folder;

#[test]
fn every_command_that_a_build_lacks_says_which_build_has_it() {
    let folder = Folder::new();
    let lacks = [
        ("study", "campaign status study", "campaign status"),
        ("study", "answers answers.csv --report m.html", "answers"),
        ("study", "bids check data", "bids check"),
        ("study", "eeg stats a.json", "eeg stats"),
        (
            "study",
            "twin record --bench eeg --task control --out a.edf",
            "--bench eeg",
        ),
        ("web", "serve study P01 discrimination", "serve"),
        ("audio", "sound devices", "sound devices"),
        (
            "audio",
            "sound calibrate setup.toml --tone 20",
            "sound calibrate",
        ),
        (
            "audio",
            "play d.wav --bench audio:setup.toml --record r.parquet",
            "audio",
        ),
        (
            "fake",
            "play d.wav --bench fake:script.toml --record r.parquet",
            "fake",
        ),
        ("surface", "roughness a.tx2", "roughness"),
    ];
    for (feature, command, named) in lacks {
        if has(feature) {
            continue;
        }
        let words: Vec<&str> = command.split(' ').collect();
        folder.run(&words).expect_failure(2, &[named, "./x build"]);
    }
}

#[test]
fn the_help_says_so_too() {
    let folder = Folder::new();
    for (feature, command) in [
        ("study", "answers"),
        ("web", "serve"),
        ("audio", "sound devices"),
        ("surface", "roughness"),
    ] {
        let words: Vec<&str> = command.split(' ').collect();
        let (name, above) = words.split_last().unwrap();
        let help = folder.run(&[above, &["--help"]].concat()).out();
        let line = help
            .lines()
            .find(|line| line.trim_start().starts_with(&format!("{name} ")));
        let says = line.is_some_and(|line| line.contains("Not in this build"));
        let own = folder.run(&[&words[..], &["--help"]].concat()).out();
        assert_eq!(says, !has(feature), "{line:?}");
        assert_eq!(own.contains("Not in this build"), !has(feature), "{own}");
    }
}

/// Whether this build has the feature.
fn has(feature: &str) -> bool {
    match feature {
        "audio" => cfg!(feature = "audio"),
        "fake" => cfg!(feature = "fake"),
        "study" => cfg!(feature = "study"),
        "surface" => cfg!(feature = "surface"),
        "web" => cfg!(feature = "web"),
        other => panic!("expected a feature of the app, found {other}"),
    }
}
