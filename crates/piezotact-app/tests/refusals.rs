//! What is wrong is refused in a sentence that says what was expected, what was found and what to do, with an
//! exit code that means something, and nothing is written.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::known_cuts::{Kind, Random, recorded, table};
use crate::support::{BENCH, Folder, RENDER, noise, prepared, wav};

#[test]
fn a_file_that_cannot_be_read_is_named_with_what_to_do() {
    let folder = Folder::new();
    let whole = wav(noise(5_000), 5_000);
    folder.write("empty.wav", []);
    folder.write("cut.wav", &whole[..whole.len() / 2]);
    folder.write("head.wav", &whole[..20]);
    folder.write("other.wav", b"MATLAB 5.0 MAT-file, and more of it");
    folder.write("binary.dat", [7, 0, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    folder.write("words.csv", "once upon a time\nthere was a finger\n");
    folder.write("nan.csv", "time (s),acc (m/s2)\n0,1\n0.001,NaN\n0.002,1\n");
    folder.write("decimal.csv", "time (ms),acc (g)\n0,1,5\n1,1,6\n");
    folder.write(
        "gap.csv",
        "time (s),acc (g)\n0,1\n0.001,1\n0.002,1\n0.9,1\n0.901,1\n",
    );
    folder.write("cut.parquet", b"PAR1 and then nothing");
    folder.write("notes.json", "{\"hello\": 1}");
    folder.write("scale.wav", &whole);
    folder.write(
        "scale.wav.json",
        "{\"full_scale\": {\"value\": 200, \"unit\": \"bananas\"}}",
    );
    let mut float_nan = whole.clone();
    // 32-bit float, one sample that is not a number.
    float_nan[20] = 3;
    float_nan[32] = 4;
    float_nan[34] = 32;
    float_nan[44..48].copy_from_slice(&f32::NAN.to_le_bytes());
    folder.write("nan.wav", float_nan);
    for (file, parts) in [
        ("absent.wav", &["absent.wav", "no such file"][..]),
        (".", &["folder"]),
        ("empty.wav", &["an empty file"]),
        ("head.wav", &["damaged"]),
        ("other.wav", &["a MATLAB file", "CSV"]),
        ("binary.dat", &["binary file of an unknown kind"]),
        ("words.csv", &["rows of numbers", "check the export"]),
        (
            "decimal.csv",
            &["one more, `5`, in row 2", "decimal commas"],
        ),
        ("nan.csv", &["`NaN` in row 3, column `acc`"]),
        ("nan.wav", &["NaN at sample 0"]),
        ("cut.parquet", &["Parquet", "copy it again"]),
        ("notes.json", &["transfer function", "frequency_hz"]),
        ("scale.wav", &["scale.wav.json", "bananas"]),
    ] {
        folder.run(&["info", file]).expect_failure(1, parts);
    }
    // A pause makes parts, of which the first is read.
    let gap = folder.run(&["info", "gap.csv"]);
    gap.expect_success();
    assert!(gap.out().contains("2 parts"), "{}", gap.out());
    // What is there is read, and what is missing counted.
    let cut = folder.run(&["info", "cut.wav"]);
    cut.expect_success();
    let found = "states 5000 samples of each channel, and the file holds 2489: 2511 are missing";
    assert!(cut.out().contains(found), "{}", cut.out());
}

#[test]
fn what_does_not_go_together_is_refused_and_nothing_is_written() {
    let folder = prepared();
    folder.write(
        "words.json",
        "{\"frequency_hz\": [0, 1], \"real\": [1], \"imaginary\": [0, 0], \"coherence\": [1, 1]}",
    );
    folder.write("slow.wav", wav(noise(4_000), 1_000));
    folder.write("mono.csv", "time (s),acc (m/s2)\n0,1\n0.001,2\n0.002,1\n");
    folder.write("short.wav", wav(noise(300), 5_000));
    let before = folder.names();
    let render = |extra: &[&str]| {
        folder.run(
            &[
                &["render", "--transfer", "tf.json", "--out", "drive.wav"],
                extra,
            ]
            .concat(),
        )
    };
    // No physical scale is guessed.
    render(&["texture.wav"]).expect_failure(1, &["physical scale", "--scale", "texture.wav.json"]);
    render(&["texture.wav", "--scale", "200 N"]).expect_failure(1, &["m/s²", "in N"]);
    render(&["texture.wav", "--scale", "200"]).expect_failure(2, &["200 m/s2"]);
    // Another gain than the transfer function's.
    render(&["texture.wav", "--scale", "2 m/s2", "--gain", "B2"])
        .expect_failure(1, &["B3", "B2", "characterise at B2"]);
    // Another rate, whose half is below the band.
    render(&["slow.wav", "--scale", "2 m/s2"]).expect_failure(2, &["20–1000 Hz", "500 Hz"]);
    render(&["texture.wav", "--scale", "2 m/s2", "--band", "20..3000"])
        .expect_failure(2, &["2500 Hz"]);
    render(&["texture.wav", "--scale", "2 m/s2", "--band", "1000..20"])
        .expect_failure(2, &["20..1000"]);
    // More than full scale.
    render(&["texture.wav", "--scale", "200 m/s2"])
        .expect_failure(1, &["--level -", "--allow-clipping", "amplifier"]);
    folder
        .run(&[
            "render",
            "texture.wav",
            "--scale",
            "2 m/s2",
            "--transfer",
            "words.json",
            "--out",
            "drive.wav",
        ])
        .expect_failure(1, &["2 values in `real`", "found 1"]);
    folder
        .run(&[
            "render",
            "texture.wav",
            "--scale",
            "2 m/s2",
            "--transfer",
            "absent.json",
            "--out",
            "drive.wav",
        ])
        .expect_failure(1, &["absent.json"]);
    // One channel too few.
    folder
        .run(&[
            "transfer",
            "mono.csv",
            "--drive",
            "force",
            "--response",
            "acc",
            "--out",
            "new.json",
        ])
        .expect_failure(1, &["`force`", "acc [m/s²]"]);
    folder
        .run(&["spectrum", "short.wav"])
        .expect_failure(1, &["1024", "300", "shorter segment"]);
    folder
        .run(&["spectrum", "texture.wav", "--overlap", "1"])
        .expect_failure(2, &["overlap"]);
    let over_time = "spectrum texture.wav --over-time --report time.html";
    let over_time: Vec<&str> = over_time.split(' ').collect();
    for (option, value, parts) in [
        ("--overlap", "1", &["overlap from 0", "found 1"][..]),
        ("--overlap", "nan", &["overlap from 0", "NaN"]),
        ("--segment", "1", &["2 samples or more"]),
        (
            "--max-frequency",
            "0",
            &["to half the rate, 2500 Hz, found 0 Hz"],
        ),
        ("--max-frequency", "-5", &["found -5 Hz", "choose one"]),
        ("--max-frequency", "2501", &["2500 Hz, found 2501 Hz"]),
        ("--max-frequency", "nan", &["found NaN Hz"]),
        ("--median", "--rest", &["cannot be used with"]),
    ] {
        folder
            .run(&[&over_time[..], &[option, value]].concat())
            .expect_failure(2, parts);
    }
    folder
        .run(&[&over_time[..], &["--segment", "20001"]].concat())
        .expect_failure(1, &["20001", "20000", "shorter segment"]);
    folder
        .run(&["spectrum", "texture.wav", "--csv", "texture.wav"])
        .expect_failure(2, &["would be replaced"]);
    folder
        .run(&["spectrum", "texture.wav", "--max-frequency", "500"])
        .expect_failure(2, &["--over-time"]);
    folder
        .run(&["spectrum", "texture.wav", "--window", "hat"])
        .expect_failure(2, &["hann"]);
    folder
        .run(&[
            "characterise",
            "--bench",
            "twin:participant=one",
            "--out",
            "new.json",
        ])
        .expect_failure(2, &["participant=one"]);
    folder
        .run(&[
            "characterise",
            "--bench",
            BENCH,
            "--load",
            "-1",
            "--out",
            "new.json",
        ])
        .expect_failure(2, &["0.05 to 2", "-1"]);
    folder
        .run(&[
            "characterise",
            "--bench",
            BENCH,
            "--load",
            "9",
            "--out",
            "new.json",
        ])
        .expect_failure(2, &["0.05 to 2"]);
    assert_eq!(folder.names(), before, "a refusal writes nothing");
}

#[test]
fn a_drive_goes_only_to_the_device_it_was_made_for() {
    let folder = prepared();
    folder
        .run(&[&RENDER[..], &["2 m/s2"]].concat())
        .expect_success();
    let play = |drive: &str, bench: &str| {
        folder.run(&["play", drive, "--bench", bench, "--record", "m.parquet"])
    };
    play("drive.wav", "twin:gain=B2").expect_failure(1, &["B3", "B2"]);
    // Without its sidecar nobody knows which gain it is for.
    play("texture.wav", BENCH).expect_failure(1, &["gain", "--gain"]);
    folder
        .run(&[&RENDER[..], &["2 m/s2", "--drive-rate", "44100"]].concat())
        .expect_success();
    play("drive.wav", BENCH).expect_failure(1, &["44100 Hz", "--drive-rate 48000"]);
    assert!(
        !folder
            .names()
            .iter()
            .any(|name| name.starts_with("m.parquet"))
    );
}

/// No output takes the place of an input, and a measurement is not made when it could not be kept.
#[test]
fn outputs_are_looked_at_before_anything_is_done() {
    let folder = prepared();
    let characterise = |extra: &[&str]| {
        folder.run(&[&["characterise", "--bench", BENCH, "--seconds", "5"], extra].concat())
    };
    characterise(&["--out", "none/tf.json"]).expect_failure(1, &["none", "create it"]);
    characterise(&["--out", "a.parquet", "--record", "a.parquet"])
        .expect_failure(2, &["written twice"]);
    characterise(&["--out", "a.parquet", "--record", "./a.parquet"])
        .expect_failure(2, &["written twice"]);
    characterise(&["--out", "r.parquet.part", "--record", "r.parquet"])
        .expect_failure(2, &["written twice"]);
    characterise(&["--out", "a.json", "--record", "r.parquet", "--segment", "1"])
        .expect_failure(2, &["segment"]);
    characterise(&["--out", "a.json", "--record", "r.parquet", "--peak", "1.5"])
        .expect_failure(2, &["1.5", "0.8"]);
    characterise(&[
        "--out",
        "a.json",
        "--record",
        "r.parquet",
        "--band",
        "10..4000",
    ])
    .expect_failure(2, &["5000 Hz"]);
    folder
        .run(&[
            "render",
            "texture.wav",
            "--scale",
            "2 m/s2",
            "--transfer",
            "tf.json",
            "--out",
            "tf.json",
        ])
        .expect_failure(2, &["would be replaced"]);
    folder.write("texture.wav.json", "{\"full_scale\": \"2 m/s2\"}");
    folder
        .run(&["spectrum", "texture.wav", "--report", "texture.wav.json"])
        .expect_failure(2, &["would be replaced"]);
    std::fs::remove_file(folder.path("texture.wav.json")).unwrap();
    assert_eq!(folder.names(), ["texture.wav", "tf.json"]);
    folder
        .run(&[
            "spectrum",
            "texture.wav",
            "--segment",
            "18446744073709551615",
        ])
        .expect_failure(1, &["20000"]);
    folder
        .run(&[
            "render",
            "texture.wav",
            "--transfer",
            "tf.json",
            "--out",
            "d.wav",
            "--drive-rate",
            "4000000000",
        ])
        .expect_failure(2, &["768000"]);
}

/// What is advised on a refusal works when it is followed, whatever the level was.
#[test]
fn the_level_that_is_advised_fits() {
    let folder = prepared();
    let refused = folder.run(&[&RENDER[..], &["2 m/s2", "--level", "30"]].concat());
    refused.expect_failure(1, &["--level"]);
    let text = refused.err();
    let advised = text
        .split("--level ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    folder
        .run(&[&RENDER[..], &["2 m/s2", "--level", advised]].concat())
        .expect_success();
    let louder = (advised.parse::<f64>().unwrap() + 0.3).to_string();
    folder
        .run(&[&RENDER[..], &["2 m/s2", "--level", &louder]].concat())
        .expect_failure(1, &["--level"]);
    // No level is advised that --level refuses.
    for level in ["fit", "0"] {
        let refused = folder.run(&[&RENDER[..], &["2e9 m/s2", "--level", level]].concat());
        refused.expect_failure(
            1,
            &["below the softest --level of -120 dB", "check the scales"],
        );
        assert!(!refused.err().contains(" fits"), "{}", refused.err());
    }
}

/// What cannot be written is refused before anything is measured, in one sentence, and nothing is left.
#[test]
fn places_that_cannot_be_written_are_refused_before_the_run() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("a-folder.json")).unwrap();
    folder.write("bench.toml", "lost = { half = \"input\", after_s = 0 }\n");
    let before = folder.names();
    let characterise = |out: &str, record: &str| {
        folder.run(&[
            "characterise",
            "--bench",
            "fake:bench.toml",
            "--seconds",
            "6",
            "--out",
            out,
            "--record",
            record,
        ])
    };
    let long = format!("{}.json", "n".repeat(300));
    // The recording has room, but not the names that it gets when it is interrupted.
    let nearly = format!("{}.parquet", "n".repeat(232));
    let mut cases = vec![
        (long.as_str(), "raw.parquet", "give a shorter one"),
        ("tf.json", nearly.as_str(), "give a shorter one"),
        ("a-folder.json", "raw.parquet", "found a folder"),
    ];
    if cfg!(target_os = "linux") {
        cases.push(("/proc/tf.json", "raw.parquet", "cannot write /proc/tf.json"));
    }
    for (out, record, part) in cases {
        let done = characterise(out, record);
        done.expect_failure(1, &[part]);
        assert_eq!(done.err().lines().count(), 1, "{}", done.err());
        assert_eq!(folder.names(), before);
    }
}

/// What a person edited is lost nowhere, and what cannot be computed takes no memory.
#[test]
fn cuts_beside_a_recording_are_never_replaced() {
    let folder = Folder::new();
    folder.write(
        "S8.csv",
        table(&recorded(&mut Random::new(8), &[Kind::Plain; 3])),
    );
    folder
        .run(&[
            "strokes",
            "--cuts-only",
            "S8.csv",
            "--write-cuts",
            "S8.csv.cuts",
        ])
        .expect_success();
    // No output of another kind replaces what a person edited.
    let edited = std::fs::read(folder.path("S8.csv.cuts")).unwrap();
    for command in [
        "strokes S8.csv --csv S8.csv.cuts --cuts-only",
        "strokes S8.csv --report S8.csv.cuts",
        "spectrum S8.csv --report S8.csv.cuts --rest",
    ] {
        let arguments: Vec<&str> = command.split(' ').collect();
        folder
            .run(&arguments)
            .expect_failure(2, &["would be replaced"]);
    }
    assert_eq!(std::fs::read(folder.path("S8.csv.cuts")).unwrap(), edited);
    // A segment longer than every stroke is refused, however long.
    for segment in ["100000", "18446744073709551615"] {
        folder
            .run(&["strokes", "S8.csv", "--segment", segment])
            .expect_failure(1, &["found"]);
    }
}

/// What does not fit into memory is refused with both figures before it is computed; where there is enough, it is computed.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_a_comparison_that_does_not_fit_into_memory_is_refused_before_it_is_computed() {
    let folder = Folder::new();
    for name in ["a.wav", "b.wav"] {
        folder.write(name, wav(noise(4_000_000).map(|v| v * 0.01), 48_000));
    }
    folder.write(
        "long.wav",
        wav(std::iter::repeat_n(0.01, 60_000_000), 48_000),
    );
    let score = "score a.wav b.wav --scale '1 m/s2'";
    let verify = "verify --target a.wav --measured b.wav --scale '1 m/s2'";
    // The limit is of addresses, of which the program takes as many as its file is long.
    let program = env!("CARGO_BIN_EXE_piezotact");
    let own = std::fs::metadata(program).unwrap().len() / 1024;
    let within = |kilobytes: u64, command: &str| {
        let limited = format!("ulimit -v {}; {program} {command}", own + kilobytes);
        let output = std::process::Command::new("bash")
            .args(["-c", &limited])
            .current_dir(folder.path(""))
            .output();
        let output = output.unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    for (command, said) in [
        (
            score,
            "the score: 4000000 samples take about 640 MB of memory, and ",
        ),
        (
            verify,
            "the verification: 4000000 samples take about 1.04 GB of memory, and ",
        ),
        (
            "strokes a.wav --scale '1 m/s2'",
            "a.wav: its analysis: 4000000 samples take about 256 MB of memory, and ",
        ),
        (
            "info long.wav --scale '1 m/s2'",
            "long.wav: reading this file of 120 MB takes about 720 MB of memory, and ",
        ),
    ] {
        let (code, err) = within(328_000, command);
        assert_eq!(code, Some(1), "{err}");
        assert!(err.contains(said), "{err}");
    }
    let (code, err) = within(1_500_000, score);
    assert_eq!(code, Some(0), "{err}");
}

/// An option that needs another says which; where the other is needed anyway, that is said.
#[test]
fn an_option_that_needs_another_says_so() {
    let folder = Folder::new();
    for (given, says) in [
        ("spectrum a.csv --band 10..20", "--band needs --rest"),
        (
            "spectrum a.csv --over-time",
            "--over-time needs --report or --json",
        ),
        (
            "render a.wav --transfer t.json --out d.wav --discard-raw",
            "--discard-raw needs --bench",
        ),
        ("info a.csv --figures f", "unexpected argument '--figures'"),
        ("characterise --bench twin", "--out <OUT>"),
    ] {
        let words: Vec<&str> = given.split(' ').collect();
        folder.run(&words).expect_failure(2, &[says]);
    }
}

/// A former name is refused with the present one, of whatever level; what was given to `replay` is what the other program is given.
#[test]
fn former_names_say_the_present_ones() {
    let folder = Folder::new();
    for (given, says) in [
        ("segment a.csv", "is now `piezotact strokes --cuts-only`"),
        ("analyse a.csv --by file", "is now `piezotact strokes`"),
        ("analyze a.csv", "is now `piezotact strokes`"),
        ("noise a.csv", "is now `piezotact spectrum --rest`"),
        ("comapre a.csv", "did you mean `compare`?"),
        (
            "campaign simulat p.toml",
            "did you mean `campaign simulate`?",
        ),
        (
            "spectrum a.csv --svg a.svg",
            "--svg of `piezotact spectrum` is now --report",
        ),
        ("spectrum a.csv --spectrogram a.svg", "is now --over-time"),
        ("twin record --duration 60s", "is now --seconds"),
        ("campaign status st --csv-text", "is now --csv TABLE.csv"),
        (
            "campaign simulate p.toml --study st",
            "STUDY --protocol PROTOCOL",
        ),
        (
            "--date 2026-03-01 matrix a.csv",
            "is now `piezotact answers`",
        ),
        ("align a.wav b.csv", "is now `piezotact sound align`"),
        ("devices", "is now `piezotact sound devices`"),
        (
            "replay --chapter 3 --out replay",
            "./x validate replay --chapter 3 --out replay builds and runs it",
        ),
        (
            "replay",
            "`piezotact replay` is now `piezotact-validation replay`",
        ),
        // What is no command and never was one: the nearest.
        ("stroke a.csv", "`strokes`"),
        ("panel anlyse panel", "`panel analyse`"),
        ("panel align", "unrecognized subcommand 'align'"),
    ] {
        let words: Vec<&str> = given.split(' ').collect();
        folder.run(&words).expect_failure(2, &[says]);
    }
    #[cfg(feature = "study")]
    for (given, says) in [
        (
            "campaign dictionary roughness_jnd",
            "is now `piezotact campaign protocol PROTOCOL --dictionary`",
        ),
        (
            "campaign verify-journal study",
            "is now `piezotact campaign verify`",
        ),
    ] {
        let words: Vec<&str> = given.split(' ').collect();
        folder.run(&words).expect_failure(2, &[says]);
    }
    assert!(folder.names().is_empty());
    // The two spellings of a name are one command.
    for given in [["panel", "analyze"], ["characterize", "--help"]] {
        folder
            .run(&[&given[..], &["--help"]].concat())
            .expect_success();
    }
}
