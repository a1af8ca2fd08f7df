//! Panels on disk, whole, broken and worked on by several at once.

use super::*;
use crate::transfer_file::write_transfer;
use piezotact::quantity::{Degrees, Newtons};

fn filing(who: &str, repeat: u32) -> Filing {
    Filing {
        participant: who.into(),
        cell: Cell {
            load_n: Newtons(0.2),
            angle_deg: Degrees(20.0),
        },
        placement: 1,
        repeat,
    }
}

fn document(who: &str) -> TransferDocument {
    let mut document: TransferDocument = serde_json::from_str(
        r#"{"frequency_hz":[0,1,2],"real":[1,2,3],"imaginary":[0,0,1],"coherence":[1,1,1],"averages":20}"#,
    )
    .unwrap();
    document.about.condition.participant = Some(who.into());
    document.about.condition.load_n = Some(Newtons(0.2));
    document.about.condition.angle_deg = Some(Degrees(20.0));
    document
}

/// Every state that a crash can leave is a panel that can be read: no index, a file that is not listed, a plan.
#[test]
fn a_session_that_breaks_off_leaves_a_panel() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut panel = PanelFolder::open_or_begin(at).unwrap();
    panel.begin("bench", Vec::new()).unwrap();
    panel
        .plan(&[filing("a", 1), filing("b", 1), filing("b", 2)])
        .unwrap();
    panel.file(&filing("a", 1), &document("a")).unwrap();
    // Between the file and the index.
    let of_campaign = |bench: &str, filing: &Filing| {
        let mut document = document(&filing.participant);
        document.measured_for = Some(PanelFolder::measured_for(bench, filing));
        document
    };
    let left = filing("b", 1);
    write_transfer(&at.join(file_name(&left)), &of_campaign("bench", &left)).unwrap();
    drop(panel);
    let mut again = PanelFolder::open_or_begin(at).unwrap();
    let contents = again.read().unwrap();
    assert_eq!((contents.panel.len(), again.index.planned.len()), (1, 2));
    assert_eq!(again.index.participants, ["a", "b"]);
    let text: Vec<String> = contents.warnings.iter().map(ToString::to_string).collect();
    assert!(
        text[0].contains("2 planned") && text[1].contains("b_20deg_0.2N_p1_r1.json"),
        "{text:?}"
    );
    assert_eq!(again.adopt(&filing("b", 1)).unwrap(), Adopted::Listed);
    assert_eq!(again.adopt(&filing("b", 2)).unwrap(), Adopted::Nothing);
    let last = PanelFolder::open(at).unwrap();
    assert_eq!(
        (last.read().unwrap().panel.len(), last.index.planned.len()),
        (2, 1)
    );
    assert!(last.not_listed().is_empty());
    // A file of somebody else, of another bench or repeat or of no campaign is not taken for it, nor replaced.
    let asked = filing("c", 1);
    for other in [
        document("b"),
        document("c"),
        of_campaign("another bench", &asked),
        of_campaign("bench", &filing("c", 2)),
    ] {
        write_transfer(&at.join(file_name(&asked)), &other).unwrap();
        assert_eq!(again.adopt(&asked).unwrap(), Adopted::Nothing);
    }
    again.file(&filing("c", 1), &document("c")).unwrap();
    assert_eq!(again.index.entries[2].file, "c_20deg_0.2N_p1_r1_2.json");
}

#[test]
fn units_and_warnings_survive() {
    let folder = tempfile::tempdir().unwrap();
    let mut panel = PanelFolder::open_or_begin(folder.path()).unwrap();
    let mut finger = document("a");
    finger.drive_unit = Unit::Newton;
    panel.file(&filing("a", 1), &finger).unwrap();
    assert_eq!(panel.index.kind, Some(PanelKind::Finger));
    let other = panel
        .file(&filing("b", 1), &document("b"))
        .unwrap_err()
        .to_string();
    assert!(
        other.contains("from N to") && other.contains("from FS to"),
        "{other}"
    );
    let twice = panel
        .file(&filing("a", 1), &finger)
        .unwrap_err()
        .to_string();
    assert!(twice.contains("each measurement once"), "{twice}");
    let contents = panel.read().unwrap();
    assert_eq!(contents.drive_unit, Unit::Newton);
    assert!(contents.panel[0].function.about.warnings.is_empty());
}

#[test]
fn what_cannot_be_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let said = |at: &Path| PanelFolder::open(at).unwrap_err().to_string();
    assert!(said(at).contains("none in it"));
    assert!(said(&at.join("gone")).contains("no such folder"));
    let mut panel = PanelFolder::open_or_begin(at).unwrap();
    panel.plan(&[]).unwrap();
    assert!(
        panel
            .read()
            .unwrap_err()
            .to_string()
            .contains("expected measurements")
    );
    panel.file(&filing("a", 1), &document("a")).unwrap();
    std::fs::remove_file(at.join("a_20deg_0.2N_p1_r1.json")).unwrap();
    let missing = panel.read().unwrap_err().to_string();
    assert!(
        missing.contains("a_20deg_0.2N_p1_r1.json") && missing.contains("participant a"),
        "{missing}"
    );
    let index = std::fs::read_to_string(at.join(PANEL_INDEX)).unwrap();
    for (change, part) in [
        (index[..index.len() / 2].to_owned(), "index of a panel"),
        (index.replace("panel 1", "panel 9"), "panel 9"),
        (
            index.replace("a_20deg", "../a_20deg"),
            "files in the folder",
        ),
        ("\u{fffd}".into(), "index of a panel"),
    ] {
        std::fs::write(at.join(PANEL_INDEX), change).unwrap();
        assert!(said(at).contains(part), "{}", said(at));
    }
    assert_eq!(
        file_name(&filing("../a b", 1)),
        "---a-b_20deg_0.2N_p1_r1.json"
    );
}

/// Six at once: everybody waits for the others, and every measurement is there under a number of its own.
#[test]
fn several_writers_lose_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::thread::scope(|scope| {
        for _ in 0..6 {
            scope.spawn(|| {
                for _ in 0..3 {
                    let mut panel = PanelFolder::open_or_begin(at).unwrap();
                    let next = panel.index.entries.len() as u32 + 1;
                    panel.file(&filing("a", next), &document("a")).unwrap();
                }
            });
        }
    });
    let panel = PanelFolder::open(at).unwrap();
    let mut repeats: Vec<u32> = panel
        .index
        .entries
        .iter()
        .map(|e| e.filing.repeat)
        .collect();
    repeats.sort_unstable();
    assert_eq!(repeats, (1..=18).collect::<Vec<_>>());
    assert_eq!(panel.read().unwrap().panel.len(), 18);
    assert!(panel.not_listed().is_empty());
}

#[test]
fn a_panel_that_somebody_writes_to_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(".piezotact-killed.tmp"), "half").unwrap();
    let first = PanelFolder::open_or_begin(folder.path()).unwrap();
    assert!(!folder.path().join(".piezotact-killed.tmp").exists());
    let said = PanelFolder::open_or_begin(folder.path())
        .unwrap_err()
        .to_string();
    let own = format!("process {}", std::process::id());
    assert!(said.contains(&own) && said.contains("wait until"), "{said}");
    drop(first);
    PanelFolder::open_or_begin(folder.path()).unwrap();
    // What was opened to read cannot be written.
    let mut panel = PanelFolder::open_or_begin(folder.path()).unwrap();
    panel.plan(&[]).unwrap();
    drop(panel);
    let mut read = PanelFolder::open(folder.path()).unwrap();
    assert!(read.plan(&[]).is_err());
}

#[test]
fn a_campaign_is_one_way_of_measuring() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut panel = PanelFolder::open_or_begin(at).unwrap();
    panel.begin("one", Vec::new()).unwrap();
    panel.plan(&[filing("a", 1)]).unwrap();
    // Nothing was measured: another way may be chosen.
    panel.begin("two", Vec::new()).unwrap();
    assert!(panel.index.planned.is_empty());
    panel.file(&filing("a", 1), &document("a")).unwrap();
    panel.file(&filing("a", 2), &document("a")).unwrap();
    let other = panel.begin("one", Vec::new()).unwrap_err().to_string();
    assert!(
        other.contains("two") && other.contains("another folder"),
        "{other}"
    );
    // One is lost and one is damaged: both are to be measured again, and what is left of them stays.
    let [lost, damaged] = [1, 2].map(|repeat| at.join(file_name(&filing("a", repeat))));
    std::fs::remove_file(lost).unwrap();
    std::fs::write(damaged, "{").unwrap();
    let all = [filing("a", 1), filing("a", 2)];
    let told = panel.set_aside_unreadable(&all).unwrap();
    assert_eq!((told.len(), panel.index.planned.len()), (2, 2), "{told:?}");
    assert!(at.join("a_20deg_0.2N_p1_r2.json.damaged1").exists());
    panel.file(&filing("a", 2), &document("a")).unwrap();
    assert_eq!(panel.index.entries[0].file, "a_20deg_0.2N_p1_r2.json");
    assert!(panel.set_aside_unreadable(&all).unwrap().is_empty());
    // A file of the bench that now holds something else is another bench.
    let script = at.join("script.toml");
    let now = |text: &str| {
        std::fs::write(&script, text).unwrap();
        vec![BenchFile::of(&script).unwrap()]
    };
    panel.begin("two", now("seed = 1")).unwrap();
    panel.begin("two", now("seed = 1")).unwrap();
    let other = panel.begin("two", now("seed = 2")).unwrap_err().to_string();
    assert!(
        other.contains("script.toml as it was") && other.contains("changed contents"),
        "{other}"
    );
    drop(panel);
    // Without the index nobody knows of which campaign the files are.
    std::fs::remove_file(at.join(PANEL_INDEX)).unwrap();
    let mut gone = PanelFolder::open_or_begin(at).unwrap();
    let said = gone.begin("two", Vec::new()).unwrap_err().to_string();
    assert!(
        said.contains("no index, but a_20deg") && said.contains("panel add"),
        "{said}"
    );
}
