//! What a command keeps of the commands before it, as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::process::{Child, Stdio};

use crate::support::{Done, Folder, noise, wav};

/// A folder with a drive, two textures of 5 s and the script of a fake without faults.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("good.toml", "seed = 1\n");
    folder.write("texture.wav", wav(noise(25_000), 5_000));
    folder.write("rough.wav", wav(noise(25_000).map(|v| 0.7 * v), 5_000));
    folder.write("drive.wav", wav(noise(48_000).map(|v| 0.5 * v), 48_000));
    folder
}

fn run(folder: &Folder, line: &str) -> Done {
    let words: Vec<&str> = line.split(' ').collect();
    folder.run_as_given(&words)
}

/// The recordings in a folder of runs.
fn recordings(folder: &Folder, name: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder.path(name)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name.contains(".parquet")).collect();
    names.sort();
    names
}

/// A panel whose raw recordings were kept keeps them when it goes on with `--discard-raw`.
#[test]
fn only_the_raw_recordings_of_the_command_are_discarded() {
    let folder = prepared();
    let panel = "panel run --bench fake:good.toml --participants 1 --angles 20 --seconds 4 --repeats 1 --out p";
    run(&folder, &format!("{panel} --loads 0.2")).expect_success();
    let kept = recordings(&folder, "p/raw");
    assert_eq!(kept.len(), 1);
    let more = run(
        &folder,
        &format!("{panel} --loads 0.2,0.4,0.6 --discard-raw"),
    );
    more.expect_success();
    assert_eq!(recordings(&folder, "p/raw"), kept);
    let said = "discarded 2 raw recordings of this command; 1 of earlier commands is kept in p/raw";
    assert!(more.err().contains(said), "{}", more.err());
    let alone = run(
        &folder,
        &format!("{panel} --loads 0.2 --discard-raw").replace("--out p", "--out q"),
    );
    alone.expect_success();
    assert!(
        alone
            .err()
            .contains("discarded 1 raw recording of this command\n"),
        "{}",
        alone.err()
    );
    assert!(!folder.path("q/raw").exists());
}

/// A device that delivers nothing behind `at_s` of every run, and is waited for for a day.
fn silent_from(at_s: f64) -> String {
    format!("longest_pause_s = 86400\nfault = {{ what = \"delivers_nothing\", at_s = {at_s} }}\n")
}

const CHARACTERISE: &str = "characterise --bench fake:good.toml --seconds 4";
const RENDER: &str = "--transfer tf.json --scale 2m/s2 --mode texture --iterations 1";

/// Starts the command, and interrupts it (Ctrl-C) once the folder `runs` holds the journal of a run whose name has `part` in it.
#[cfg(unix)]
fn interrupted(folder: &Folder, line: &str, runs: &str, part: &str) -> (Option<i32>, String) {
    let words: Vec<&str> = line.split(' ').collect();
    let mut command = folder.command(&words);
    let child: Child = command.stderr(Stdio::piped()).spawn().unwrap();
    let begun = || {
        let entries = std::fs::read_dir(folder.path(runs)).into_iter().flatten();
        let mut names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.any(|name| name.contains(part) && name.ends_with(".part"))
    };
    while !begun() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(sent.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), said)
}

/// Ctrl-C in the second measurement of the first of two textures: the other is not begun, nothing is done, and the same command
/// continues with what was measured.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_batch_of_closed_loops() {
    let folder = prepared();
    run(&folder, &format!("{CHARACTERISE} --out tf.json")).expect_success();
    folder.write("bench.toml", silent_from(4.5));
    let batch = format!("render texture.wav rough.wav {RENDER} --bench fake:bench.toml --out all");
    let (code, said) = interrupted(&folder, &batch, "all/texture.wav.runs", "iteration");
    assert_eq!(code, Some(130), "{said}");
    let first = "`render texture, iteration 0, first, attempt 1`";
    assert_eq!(said.matches(first).count(), 1, "{said}");
    assert!(
        !said.contains("rough:") && !said.contains("after 0.00 s"),
        "{said}"
    );
    let last = said.lines().last().unwrap();
    let expected = "piezotact: stopped by hand: 0 of 2 were rendered; give the same command again to continue with the \
 measurements made so far, which are kept in the folders *.runs of all";
    assert_eq!(last, expected);
    assert!(!folder.path("all/texture.wav.runs/done").exists());
    assert!(!folder.path("all/rough.wav.runs").exists());
    assert!(!folder.path("all/texture.wav").exists());
    folder.write("bench.toml", "seed = 1\n");
    let again = run(&folder, &batch);
    again.expect_success();
    assert!(
        again
            .err()
            .contains("1 measurement was taken from the interrupted command"),
        "{}",
        again.err()
    );
    assert!(folder.path("all/texture.wav.runs/done").exists());
}

/// A closed loop whose runs lost samples measures them again, once the device loses none.
#[test]
fn what_cannot_be_believed_is_measured_again() {
    let folder = prepared();
    run(&folder, &format!("{CHARACTERISE} --out tf.json")).expect_success();
    let looped = format!("render texture.wav {RENDER} --bench fake:bench.toml --out d.wav");
    folder.write("bench.toml", "drop_outs = [{ at_s = 1, samples = 500 }]\n");
    let lost = "the device lost 500 samples at 1 place, 100.0 ms at the longest";
    run(&folder, &looped).expect_failure(1, &[lost]);
    run(&folder, &looped).expect_failure(1, &[lost]);
    folder.write("bench.toml", "seed = 1\n");
    run(&folder, &looped).expect_success();
}

/// A closed loop that is interrupted names its folder; another person starts from the beginning, and one that came to its end says where its
/// recordings are.
#[cfg(unix)]
#[test]
fn a_closed_loop_goes_on_for_the_same_finger_alone() {
    let folder = prepared();
    run(&folder, &format!("{CHARACTERISE} --out tf.json")).expect_success();
    folder.write("bench.toml", silent_from(4.5));
    let looped = format!("render texture.wav {RENDER} --bench fake:bench.toml --out d.wav");
    let (code, said) = interrupted(&folder, &looped, "d.wav.runs", "iteration");
    assert_eq!(code, Some(130), "{said}");
    let last = said.lines().last().unwrap();
    assert!(last.starts_with("piezotact: stopped by hand "), "{said}");
    let kept = "; give the same command again to continue with the measurements made so far, which are kept in d.wav.runs";
    assert!(last.ends_with(kept), "{said}");
    folder.write("bench.toml", "seed = 1\n");
    let other = looped.replace("bench.toml", "bench.toml,participant=2");
    let done = run(&folder, &other);
    done.expect_success();
    let anew = "d.wav.runs: the interrupted closed loop was for F01, now F02; its recordings are kept in d.wav.runs.before-1, and everything is measured again";
    assert!(done.err().contains(anew), "{}", done.err());
    assert!(
        !done.err().contains("interrupted command"),
        "{}",
        done.err()
    );
    let people = |runs: &str, who: &str| {
        recordings(&folder, runs)
            .iter()
            .all(|name| name.starts_with(who))
    };
    assert!(people("d.wav.runs", "F02") && people("d.wav.runs.before-1", "F01"));
    let again = run(&folder, &other);
    again.expect_success();
    let ended = "d.wav.runs: it contains the runs of a completed closed loop; its recordings are kept in d.wav.runs.before-2, \
 and everything is measured again";
    assert!(again.err().contains(ended), "{}", again.err());
}

/// Where nothing was acquired, no file is left.
#[test]
fn nothing_acquired_leaves_no_file() {
    let folder = prepared();
    folder.write("dead.toml", "input_full_after_s = 0\n");
    folder.write("late.toml", "input_full_after_s = 0.5\n");
    let nothing = "the input buffer of the scripted fake overflowed after 0.00 s";
    let left = "nothing was acquired, and no file was written";
    for line in [
        "play drive.wav --bench fake:dead.toml --record m.parquet",
        "characterise --bench fake:dead.toml --seconds 4 --out tf.json --record m.parquet",
        "characterise --bench fake:dead.toml --seconds 4 --out tf.json",
    ] {
        let before = folder.names();
        run(&folder, line).expect_failure(1, &[nothing, left]);
        assert_eq!(folder.names(), before, "{line}");
        let late = run(&folder, &line.replace("dead", "late"));
        late.expect_failure(
            1,
            &[
                "overflowed after 0.50 s",
                "the acquired samples are kept in ",
            ],
        );
        let said = late.err();
        let kept = said.trim_end().rsplit(' ').next().unwrap();
        run(&folder, &format!("info {kept}")).expect_success();
        std::fs::remove_file(folder.path(kept)).unwrap();
    }
}

/// The transfer function of another person or seed is not replaced.
#[test]
fn a_transfer_function_of_another_is_kept() {
    let folder = prepared();
    folder.write("other.toml", "seed = 2\n");
    let line = format!("{CHARACTERISE} --out tf.json");
    run(&folder, &line).expect_success();
    let again = run(&folder, &line);
    again.expect_success();
    assert!(!folder.path("tf.json.before-1").exists());
    let first = std::fs::read(folder.path("tf.json")).unwrap();
    for (number, bench) in [(1, "good.toml,participant=2"), (2, "other.toml")] {
        let done = run(&folder, &line.replace("good.toml", bench));
        done.expect_success();
        let kept = format!("tf.json.before-{number}");
        let said = format!(
            "tf.json: the earlier file is of another participant, condition or seed, and is kept as {kept}"
        );
        assert!(done.err().contains(&said), "{}", done.err());
        assert!(number == 2 || std::fs::read(folder.path(&kept)).unwrap() == first);
    }
}

/// What cannot be meant is said before anything is measured.
#[test]
fn endings_and_people_are_checked() {
    let folder = prepared();
    let parquet = ".csv: expected a name that ends in .parquet";
    run(
        &folder,
        "play drive.wav --bench fake:good.toml --record r.csv",
    )
    .expect_failure(2, &[parquet]);
    run(
        &folder,
        &format!("{CHARACTERISE} --out tf.json --record r.csv"),
    )
    .expect_failure(2, &[parquet]);
    let panel = "panel run --participants 1..2 --out p --seconds 4 --bench ";
    for bench in ["twin:participant=2", "fake:good.toml,participant=2"] {
        run(&folder, &format!("{panel}{bench}")).expect_failure(
            2,
            &[
                "expected a bench without participant",
                "found participant=2; leave it out of --bench",
            ],
        );
    }
    assert!(!folder.path("p").exists() && !folder.path("tf.json").exists());
}

/// Commands that write one file, and a name for it.
const WRITING: [(&str, &str); 9] = [
    (
        "spectrum texture.wav --scale 1m/s2 --over-time --report OUT",
        "spectrum.html",
    ),
    ("spectrum texture.wav --csv OUT --scale 1m/s2", "psd.csv"),
    ("strokes texture.wav --scale 1m/s2 --csv OUT", "strokes.csv"),
    (
        "score texture.wav rough.wav --scale 1m/s2 --report OUT",
        "score.html",
    ),
    (
        "manipulate texture.wav --scale 1m/s2 --gain -3dB --out OUT",
        "softer.wav",
    ),
    (
        "export texture.wav --scale 1m/s2 --out OUT",
        "texture.haptic",
    ),
    (
        "transfer bench.csv --drive drive --response nail --out OUT",
        "estimate.json",
    ),
    (
        "render texture.wav --scale 0.2m/s2 --transfer tf.json --level fit --out OUT",
        "d.wav",
    ),
    (
        "twin surface S4 --size 2mm --step 40um --out OUT",
        "map.sur",
    ),
];

fn with_bench() -> Folder {
    let folder = prepared();
    let rows = noise(30_000).enumerate();
    let rows = rows.map(|(i, v)| format!("{},{v},{}\n", i as f64 / 5000.0, 3.0 * v));
    let table = format!(
        "time (s),drive (m/s2),nail (m/s2)\n{}",
        rows.collect::<String>()
    );
    folder.write("bench.csv", table);
    run(&folder, &format!("{CHARACTERISE} --out tf.json")).expect_success();
    folder
}

/// Another file of that name is refused before it is touched, and replaced on request alone; the same bytes are written again.
#[test]
fn what_another_left_is_not_replaced_silently() {
    let folder = with_bench();
    for (line, name) in WRITING {
        let line = line.replace("OUT", name);
        folder.write(name, "of somebody else");
        let before = folder.names();
        let refused = run(&folder, &line);
        refused.expect_failure(2, &[name, "already exists", "--force"]);
        // A report carries its date, and says who made it.
        let is_report = name.ends_with(".html");
        assert_eq!(refused.err().contains("differs"), !is_report, "{line}");
        assert_eq!(
            std::fs::read(folder.path(name)).unwrap(),
            b"of somebody else"
        );
        assert_eq!(folder.names(), before, "{line}");
        run(&folder, &format!("{line} --force")).expect_success();
        let written = std::fs::read(folder.path(name)).unwrap();
        assert_ne!(written, b"of somebody else");
        run(&folder, &line).expect_success();
        if is_report {
            continue;
        }
        assert_eq!(std::fs::read(folder.path(name)).unwrap(), written, "{line}");
        // Killed before its end, a command goes on: with what it had not written, and without unfinished files.
        folder.write(&format!(".piezotact-unfinished-{name}-abc123.tmp"), "half");
        let sidecar = folder.path(&format!("{name}.json"));
        let _none = std::fs::remove_file(&sidecar);
        run(&folder, &line).expect_success();
        assert_eq!(std::fs::read(folder.path(name)).unwrap(), written, "{line}");
    }
    assert!(folder.names().iter().all(|name| !name.starts_with('.')));
    folder.write("kept.wav.json", "{}");
    let sidecar = "manipulate texture.wav --scale 1m/s2 --gain -3dB --out kept.wav";
    run(&folder, sidecar).expect_failure(2, &["kept.wav.json already exists"]);
    std::fs::create_dir(folder.path("study")).unwrap();
    folder.write("study/tf.json", "of somebody else");
    run(&folder, "demo --out study").expect_failure(2, &["study/tf.json already exists"]);
}

/// The same command again, with other settings too, may replace its own report and what it wrote beside it; another command may not.
#[test]
fn a_command_replaces_what_it_wrote_itself() {
    let folder = prepared();
    let analyse = "strokes texture.wav --scale 1m/s2 --report r.html --csv r.csv --figures figures --tables tables";
    run(&folder, analyse).expect_success();
    run(&folder, analyse).expect_success();
    run(
        &folder,
        &format!("{analyse} --high-pass none --date 2024-03-01"),
    )
    .expect_success();
    let score = "score texture.wav rough.wav --scale 1m/s2 --report";
    run(&folder, &format!("{score} r.html")).expect_failure(2, &["r.html already exists"]);
    // A CSV that this report does not name is of somebody else.
    folder.write("s.csv", "mine");
    run(&folder, &analyse.replace("r.csv", "s.csv")).expect_failure(2, &["s.csv already exists"]);
    run(&folder, &format!("{score} s.html --figures figures"))
        .expect_failure(2, &["figures", "other files", "--force"]);
    assert!(!folder.path("s.html").exists());
    // Killed while it wrote the figures, with the report written or not, the same command goes on; a file of somebody else is refused.
    let figures = || {
        let entries = std::fs::read_dir(folder.path("figures")).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        let mut paths: Vec<_> = paths
            .filter(|path| path.extension().unwrap() == "svg")
            .collect();
        paths.sort();
        paths
    };
    let all = figures();
    for report in [true, false] {
        std::fs::remove_file(&all[0]).unwrap();
        folder.write("figures/.piezotact-unfinished-01-abc123.tmp", "half");
        if !report {
            std::fs::remove_file(folder.path("r.html")).unwrap();
        }
        run(&folder, &format!("{analyse} --high-pass none")).expect_success();
        assert_eq!(figures(), all);
    }
    // Figures of the earlier run that the new report does not have go.
    let shows = "spectrum texture.wav --scale 1m/s2 --report p.html --figures psd";
    run(&folder, &format!("{shows} --over-time")).expect_success();
    assert!(folder.path("psd/02-over-time.svg").exists());
    run(&folder, shows).expect_success();
    assert!(folder.path("psd/01-power-spectral-density.svg").exists());
    assert!(!folder.path("psd/02-over-time.svg").exists());
    // What a person put there under such a name stays, is said, and nothing but what was written before is removed.
    run(&folder, &format!("{shows} --over-time")).expect_success();
    folder.write("psd/01-power-spectral-density.svg", "mine");
    folder.write("psd/02-over-time.svg", "mine too");
    let done = run(&folder, shows);
    done.expect_success();
    assert!(
        done.err()
            .contains("is kept as psd/01-power-spectral-density.svg.before-1"),
        "{}",
        done.err()
    );
    for (file, text) in [
        ("psd/01-power-spectral-density.svg.before-1", "mine"),
        ("psd/02-over-time.svg", "mine too"),
    ] {
        assert_eq!(std::fs::read_to_string(folder.path(file)).unwrap(), text);
    }
    let figure = std::fs::read_to_string(folder.path("psd/01-power-spectral-density.svg")).unwrap();
    assert!(figure.starts_with("<svg"), "{figure}");
    // Again, with what is kept beside it.
    run(&folder, shows).expect_success();
    // A folder that cannot be made is refused before anything is written.
    let within = "spectrum texture.wav --scale 1m/s2 --report q.html --figures texture.wav/psd";
    run(&folder, within).expect_failure(2, &["cannot create the folder texture.wav/psd"]);
    assert!(!folder.path("q.html").exists());
    std::fs::remove_file(folder.path("r.html")).unwrap();
    std::fs::write(&all[0], "mine").unwrap();
    run(&folder, &format!("{analyse} --high-pass none"))
        .expect_failure(2, &["figures/", "already exists", "from line 1 on"]);
    assert_eq!(std::fs::read(&all[0]).unwrap(), b"mine");
    // Cuts are written again where they are the same, and never replaced.
    let cuts = "strokes texture.wav --scale 1m/s2 --write-cuts t.cuts --cuts-only";
    run(&folder, cuts).expect_success();
    run(&folder, cuts).expect_success();
    folder.write("t.cuts", "edited");
    for line in [cuts.to_owned(), format!("{cuts} --force")] {
        run(&folder, &line).expect_failure(2, &["t.cuts already exists", "edited by hand"]);
    }
    let document = "spectrum texture.wav --report document.html --scale 1m/s2";
    run(&folder, document).expect_success();
    run(&folder, &format!("{document} --segment 512")).expect_success();
}

/// A recording and a transfer function that were measured are kept, as WAV too, with their sidecars.
#[test]
fn what_was_measured_is_kept_beside_the_new() {
    let folder = prepared();
    let record = "twin record --bench triboair --sample S4 --strokes 1 --out x.wav";
    run(&folder, record).expect_success();
    let of = |name: &str| std::fs::read(folder.path(name)).unwrap();
    let (first, sidecar) = (of("x.wav"), of("x.wav.json"));
    run(&folder, record).expect_success();
    assert!(
        !folder.path("x.wav.before-1").exists(),
        "the same is kept twice"
    );
    let other = run(&folder, &record.replace("S4", "S8"));
    other.expect_success();
    assert!(
        other.err().contains("kept as x.wav.before-1"),
        "{}",
        other.err()
    );
    assert_eq!(
        [of("x.wav.before-1"), of("x.wav.before-1.json")],
        [first, sidecar]
    );
    assert_ne!(of("x.wav"), of("x.wav.before-1"));
    run(&folder, "info x.wav.before-1 --json").expect_success();
    // The same person and seed again, with another drive: another measurement.
    run(&folder, &format!("{CHARACTERISE} --out tf.json")).expect_success();
    let first = of("tf.json");
    let longer = run(
        &folder,
        "characterise --bench fake:good.toml --seconds 6 --out tf.json",
    );
    longer.expect_success();
    assert!(
        longer.err().contains("tf.json.before-1"),
        "{}",
        longer.err()
    );
    assert_eq!(of("tf.json.before-1"), first);
}

/// Whatever is asked for by force, and through a link too, what was measured stays.
#[test]
fn an_estimate_and_a_link_keep_what_was_measured() {
    let folder = with_bench();
    let of = |name: &str| std::fs::read(folder.path(name)).unwrap();
    let first = of("tf.json");
    let estimate = "transfer bench.csv --drive drive --response nail --out tf.json --force";
    run(&folder, estimate).expect_success();
    assert_eq!(of("tf.json.before-1"), first);
    assert_ne!(of("tf.json"), first);
    run(&folder, estimate).expect_success();
    assert!(!folder.path("tf.json.before-2").exists());
    #[cfg(unix)]
    {
        let record = "twin record --bench triboair --strokes 1 --out link.parquet --sample";
        let real = record.replace("link", "real");
        run(&folder, &format!("{real} S4")).expect_success();
        let first = of("real.parquet");
        std::os::unix::fs::symlink("real.parquet", folder.path("link.parquet")).unwrap();
        run(&folder, &format!("{record} S8")).expect_success();
        assert!(folder.path("link.parquet").is_symlink());
        assert_eq!(of("real.parquet.before-1"), first);
        assert_ne!(of("real.parquet"), first);
        run(&folder, &format!("{real} S2")).expect_success();
        assert_eq!(of("real.parquet.before-1"), first);
    }
}

/// A name says what the file is.
#[test]
fn an_ending_that_is_not_ours_is_refused() {
    let folder = with_bench();
    run(&folder, "panel add panel tf.json").expect_success();
    for (line, name, expected) in [
        (WRITING[0].0, "psd.png", ".html"),
        (WRITING[1].0, "psd.xlsx", ".csv"),
        (WRITING[2].0, "strokes.xlsx", ".csv"),
        (WRITING[3].0, "S4.pdf", ".html"),
        (WRITING[4].0, "softer.mp3", ".wav"),
        (WRITING[6].0, "estimate.csv", ".json"),
        (WRITING[6].0, "estimate", ".json"),
        (WRITING[7].0, "d.flac", ".wav"),
        (WRITING[8].0, "map.png", ".sur"),
        (
            "strokes texture.wav --scale 1m/s2 --write-cuts OUT --cuts-only",
            "t.csv",
            ".cuts",
        ),
        (
            "strokes texture.wav --scale 1m/s2 --csv OUT --cuts-only",
            "t.json",
            ".csv",
        ),
        (
            "strokes texture.wav --scale 1m/s2 --report OUT --cuts-only",
            "t.md",
            ".html",
        ),
        (
            "spectrum texture.wav --scale 1m/s2 --report OUT --rest",
            "t.pdf",
            ".html",
        ),
        (
            "manipulate texture.wav --scale 1m/s2 --gain 1dB --out s.wav --report OUT",
            "t.pdf",
            ".html",
        ),
        (
            "compare texture.wav rough.wav --scale 1m/s2 --by file --csv OUT",
            "t.html",
            ".csv",
        ),
        (
            "compare texture.wav rough.wav --scale 1m/s2 --by file --report OUT",
            "t.csv",
            ".html",
        ),
        (
            "verify --target texture.wav --measured rough.wav --scale 1m/s2 --report OUT",
            "t.pdf",
            ".html",
        ),
        (
            "characterise --bench fake:good.toml --seconds 4 --out OUT",
            "tf.wav",
            ".json",
        ),
        (
            "characterise --bench fake:good.toml --seconds 4 --out tf2.json --report OUT",
            "tf.pdf",
            ".html",
        ),
        ("panel average panel --out OUT", "average.csv", ".json"),
        ("panel analyse panel --report OUT", "panel.pdf", ".html"),
    ] {
        let before = folder.names();
        let refused = run(&folder, &line.replace("OUT", name));
        refused.expect_failure(2, &[expected]);
        assert_eq!(folder.names(), before, "{line} {name}");
    }
}

/// Figures and tables of a report as files: as many as it shows, each whole.
#[test]
fn figures_and_tables_of_a_report_are_files() {
    let folder = prepared();
    let score = "score texture.wav rough.wav --scale 1m/s2 --report s.html --figures f --tables t";
    run(&folder, score).expect_success();
    let report = std::fs::read_to_string(folder.path("s.html")).unwrap();
    let report = report.split("<section id=\"invocation\">").next().unwrap();
    let files = |name: &str| -> Vec<String> {
        let entries = std::fs::read_dir(folder.path(name)).unwrap();
        entries
            .map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap())
            .collect()
    };
    let (figures, tables) = (files("f"), files("t"));
    assert!(!figures.is_empty() && figures.len() == report.matches("<figure").count());
    assert!(!tables.is_empty() && tables.len() == report.matches("<table").count());
    for svg in &figures {
        assert!(
            svg.starts_with("<svg") && svg.contains("width=\"174mm\"") && svg.contains("<desc>"),
            "{svg}"
        );
    }
    for csv in &tables {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(csv.as_bytes());
        let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
        assert!(rows.len() > 1 && rows[0].len() > 1, "{csv}");
    }
    let narrow = score.replace("--figures f", "--figures narrow --columns 1");
    run(&folder, &narrow).expect_success();
    assert!(
        files("narrow")
            .iter()
            .all(|svg| svg.contains("width=\"85mm\""))
    );
    let without = "score texture.wav rough.wav --scale 1m/s2 --figures f";
    run(&folder, without).expect_failure(2, &["--report"]);
}

/// The full build: every figure as PDF with its font, and as PNG of 300 dots per inch.
#[cfg(feature = "full")]
#[test]
fn figures_are_pdf_and_png_in_the_full_build() {
    let folder = prepared();
    let score = "score texture.wav rough.wav --scale 1m/s2 --report s.html --figures f --columns 1";
    run(&folder, score).expect_success();
    let entries = std::fs::read_dir(folder.path("f")).unwrap();
    let files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    for ending in ["svg", "pdf", "png"] {
        let of = files
            .iter()
            .filter(|path| path.extension().unwrap() == ending);
        assert_eq!(of.count(), files.len() / 3);
    }
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        match file.extension().unwrap().to_str().unwrap() {
            "pdf" => {
                let holds = |part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
                assert!(
                    bytes.starts_with(b"%PDF") && holds(b"/FontFile"),
                    "{}",
                    file.display()
                );
            }
            "png" => {
                let width = u32::from_be_bytes(bytes[16..20].try_into().unwrap());
                // 85 mm at 300 dots per inch.
                assert!((1002..=1006).contains(&width), "{width}");
            }
            _ => {}
        }
    }
}

/// A Makefile renders again: a drive whose sidecar says that it was rendered is replaced; one that was changed, and one that was corrected on
/// a bench, are not.
#[test]
fn a_drive_is_rendered_again_under_its_name() {
    let folder = with_bench();
    let render = "render texture.wav --transfer tf.json --scale 2m/s2 --out d.wav";
    run(&folder, &format!("{render} --level=-20")).expect_success();
    let first = std::fs::read(folder.path("d.wav")).unwrap();
    run(&folder, &format!("{render} --level=-21")).expect_success();
    let second = std::fs::read(folder.path("d.wav")).unwrap();
    assert_ne!(first, second);
    let mut changed = second.clone();
    let last = changed.len() - 2;
    changed[last] ^= 1;
    folder.write("d.wav", changed.as_slice());
    let refused = run(&folder, &format!("{render} --level=-22"));
    refused.expect_failure(2, &["d.wav already exists", "--force"]);
    let corrected = "render texture.wav --transfer tf.json --scale 2m/s2 --level=-20 --out c.wav";
    run(
        &folder,
        &format!("{corrected} --mode texture --iterations 1 --bench fake:good.toml"),
    )
    .expect_success();
    let measured = std::fs::read(folder.path("c.wav")).unwrap();
    run(&folder, corrected).expect_failure(2, &["c.wav", "already exists", "--force"]);
    assert_eq!(std::fs::read(folder.path("c.wav")).unwrap(), measured);
}
