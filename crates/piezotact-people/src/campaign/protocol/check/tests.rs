//! What a protocol is refused for.

use super::super::{LIBRARY, from_library};
use super::*;

fn changed(from: &str, to: &str) -> ProtocolError {
    let (_, toml) = LIBRARY[1];
    assert!(toml.contains(from), "{from}");
    read(&toml.replacen(from, to, 1)).unwrap_err()
}

#[test]
fn every_protocol_of_the_library_is_read_and_has_its_name() {
    for (name, toml) in LIBRARY {
        let protocol = read(toml).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(protocol.name, name);
        let again = read(&toml::to_string(&protocol).unwrap()).unwrap();
        assert_eq!(again, protocol, "{name} reads back");
    }
    assert_eq!(from_library("unknown"), Ok(None));
}

#[test]
fn sets_and_tests_are_those_of_the_tables() {
    let count = |name: &str| from_library(name).unwrap().unwrap().sets.len();
    assert_eq!(count("periodic_pilot"), 18);
    assert_eq!(count("isotropic_triplets"), 12);
    let inversion = from_library("amplitude_inversion").unwrap().unwrap();
    assert_eq!(inversion.expected("S2 INVERTED"), Some("S13"));
    assert_eq!(inversion.expected("S6"), Some("S6"));
    assert_eq!(inversion.sample_of("S2 INVERTED"), Some("S2"));
    assert_eq!(inversion.expected("S3"), None);
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let says = |from: &str, to: &str, part: &str| {
        let text = changed(from, to).to_string();
        assert!(text.contains(part), "{text}");
    };
    says("form = 1", "form = 2", "expected form 1");
    says(
        "\"S2\", \"S4\", \"S8\"",
        "\"S2\", \"S4\", \"S99\"",
        "set A: sample `S99` is not declared",
    );
    says(
        "\"S2\", \"S4\", \"S8\"",
        "\"S2\", \"S4\", \"S4\"",
        "sample `S4` stands twice in set A",
    );
    says("tray_slots = 14", "tray_slots = 2", "the tray holds 2");
    says(
        "tray_slots = 14",
        "tray_slots = 14\norientation = { S99 = \"notch to the left\" }",
        "orientation: sample `S99` is not declared",
    );
    says(
        "lengths = [3, 4]",
        "lengths = [0]",
        "expected 1 to 100, found 0",
    );
    says("lengths = [3, 4]", "lengths = []", "expected at least 1");
    says("lengths = [3, 4]", "length = [3, 4]", "length");
    says(
        "task = \"task2\"",
        "task = \"task9\"",
        "ordering task `task9` is not declared",
    );
    says(
        "tasks = [\"task2\", \"task3\"]",
        "tasks = [\"task3\", \"task2\"]",
        "does not stand before it",
    );
    says(
        "tasks = [\"task2\", \"task3\"]",
        "tasks = [\"task2\", \"task4\"]",
        "task `task4` is not declared",
    );
    says(
        "participants = 10",
        "participants = 0",
        "panel.participants: expected at least 1",
    );
    says(
        "refused_after_hours = 12",
        "refused_after_hours = nan",
        "more than 0",
    );
    says("name = \"A\"", "name = \"A/B\"", "`A/B` is no name");
    says(
        "seconds_per_trial = 90",
        "seconds_per_trial = -1",
        "seconds_per_trial",
    );
    says(
        "form = 1",
        "form = 1\nfrom = 2",
        "line 3: unknown field `from`",
    );
    says("kind = \"touch\"", "kind = \"taste\"", "taste");
    says("strokes = 10", "strokes = 10\nstroke = 3", "stroke");
    says(
        "session = \"discrimination\"",
        "session = \"discriminate\"",
        "aims: session `discriminate` is not declared",
    );
    says(
        "logit_sd = 0.9",
        "logit_sd = 0.9\nearlier_tasks = [\"touch\"]",
        "aims: task `touch` is not declared",
    );
}

#[test]
fn a_fixed_test_stays_in_its_set() {
    let (_, toml) = LIBRARY[2];
    let foreign = toml.replacen(
        "stimuli = [\"S6\", \"S13\", \"S2\"]",
        "stimuli = [\"S6\", \"S13\", \"S5\"]",
        1,
    );
    let text = read(&foreign).unwrap_err().to_string();
    assert!(text.contains("stimulus of the set `S5`"), "{text}");
}

#[test]
fn rendered_stimuli_need_a_rendering() {
    let (_, toml) = LIBRARY[1];
    let (before, after) = toml.split_once("[rendering]").unwrap();
    let (_, after) = after.split_once("[resuming]").unwrap();
    let error = read(&format!("{before}[resuming]{after}")).unwrap_err();
    assert!(
        matches!(error, ProtocolError::NoRendering { .. }),
        "{error}"
    );
}

#[test]
fn counts_and_times_that_no_session_has_are_refused() {
    for (from, to, part) in [
        ("repeats = 3", "repeats = 1001", "repeats"),
        ("strokes = 10", "strokes = 4000000000", "strokes"),
        ("duration_s = 30", "duration_s = 1e12", "duration_s"),
    ] {
        let refused = changed(from, to).to_string();
        assert!(refused.contains(part), "{refused}");
    }
}
