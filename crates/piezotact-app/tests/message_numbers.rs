//! The numbers that commands print have the digits that mean something; settings that cannot be are refused with a sentence.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::support::{Folder, noise, prepared, wav};

/// The numbers of `text` with more than six digits that count, which do not stand in `quoted`.
fn too_long(text: &str, quoted: &str) -> Vec<String> {
    let is_part = |sign: char| sign.is_ascii_alphanumeric() || sign == '.';
    let text = text.replace("e-", "e");
    let words = text.split(|sign: char| !is_part(sign));
    let words = words.map(|word| word.trim_matches('.'));
    let numbers = words.filter(|word| word.parse::<f64>().is_ok() && !quoted.contains(word));
    let numbers = numbers.filter(|number| {
        let mantissa = number.split('e').next().unwrap_or_default();
        let digits = mantissa.replace('.', "");
        let digits = digits.trim_start_matches('0');
        let digits = match mantissa.contains('.') {
            true => digits,
            false => digits.trim_end_matches('0'),
        };
        digits.len() > 6
    });
    numbers.map(str::to_owned).collect()
}

/// Results, warnings and errors of many commands on signals whose rates and levels are no round numbers.
#[test]
fn what_commands_say_has_the_digits_that_mean_something() {
    let folder = prepared();
    folder.write("odd.wav", wav(noise(24_577).map(|v| v / 3.0), 44_077));
    folder.write("short.wav", wav(noise(701), 44_077));
    folder.write("silent.wav", wav((0..30_011).map(|_| 0.0), 44_077));
    let clipped = noise(30_011).map(|v| (v * 7.0).clamp(-0.7, 0.7));
    folder.write("clipped.wav", wav(clipped, 4_999));
    folder.write(
        "cuts.csv",
        "time,a (m/s2)\n0,1\n0.00033333333,2\n0.00066666667,1e200\n",
    );
    for line in [
        "info odd.wav --scale 2m/s2",
        "info clipped.wav --scale 1.23456g",
        "info cuts.csv",
        "spectrum odd.wav --scale 2m/s2",
        "spectrum short.wav --scale 2m/s2",
        "spectrum odd.wav --scale 2m/s2 --rest",
        "spectrum silent.wav --scale 2m/s2 --rest",
        "score odd.wav texture.wav --scale 2m/s2",
        "score clipped.wav texture.wav --scale 2m/s2 --band 20..500",
        "score odd.wav short.wav --scale 2m/s2",
        "score odd.wav odd.wav --scale 2m/s2 --band 20..30000",
        "verify --target texture.wav --measured clipped.wav --scale 2m/s2",
        "verify --target odd.wav --measured clipped.wav --scale 2m/s2 --transfer tf.json",
        "render clipped.wav --transfer tf.json --scale 2m/s2 --out d1.wav",
        "render odd.wav --transfer tf.json --scale 2m/s2 --level fit --out d2.wav",
        "render silent.wav --transfer tf.json --scale 2m/s2 --out d3.wav",
        "manipulate clipped.wav --scale 2m/s2 --band 50..100:+6dB --out m1.wav",
        "manipulate odd.wav --scale 2m/s2 --band 50..30000:+6dB --out m2.wav",
        "strokes odd.wav --scale 2m/s2 --cuts-only",
        "strokes odd.wav clipped.wav --scale 2m/s2 --high-pass 30000",
        "transfer odd.wav --drive a --response b --out t.json",
        "export odd.wav --scale 2m/s2 --out o.haptic",
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        let done = folder.run_as_given(&words);
        let said = done.out() + &done.err();
        assert!(!said.is_empty(), "{line}");
        // What is to be given to an option stays exact.
        let options = said.match_indices("--scale \"").map(|(at, _)| &said[at..]);
        let options = options.filter_map(|option| option.split('"').nth(1));
        let long = too_long(
            &said,
            &options.fold(line.to_owned(), |all, one| all + " " + one),
        );
        assert!(long.is_empty(), "{line}: {long:?}\n{said}");
        assert!(
            !said.contains("-0 ") && !said.contains("−0.0 "),
            "{line}\n{said}"
        );
    }
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let folder = Folder::new();
    folder.write("a.wav", wav(noise(20_000), 5_000));
    for (line, parts) in [
        (
            "strokes a.wav --speed 25 --cuts-only",
            ["a speed with its unit (mm/s, m/s)", "found `25`"],
        ),
        (
            "strokes a.wav --scale 2m/s2 --speed 1e9m/s --cuts-only",
            ["up to 10 m/s, found 1e9 m/s", "(--speed)"],
        ),
        (
            "score a.wav a.wav --scale 2m/s2 --jnd 1e300",
            ["above 0 and up to 60, found 1e300", "1.58 dB"],
        ),
        (
            "score a.wav a.wav --scale 2m/s2 --frequency-jnd 1e6",
            ["above 0 and up to 10, found 1e6", "0.2"],
        ),
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        folder.run_as_given(&words).expect_failure(2, &parts);
    }
}

/// A multiple of both frequencies of the mains is one line of the table.
#[test]
fn a_line_of_both_mains_stands_once_in_the_report() {
    let folder = Folder::new();
    folder.write("a.wav", wav(noise(60_000), 5_000));
    let line = "spectrum a.wav --scale 2m/s2 --report n.html --tables t --rest";
    let words: Vec<&str> = line.split(' ').collect();
    folder.run_as_given(&words).expect_success();
    let tables = std::fs::read_dir(folder.path("t")).unwrap();
    let tables = tables.map(|entry| std::fs::read_to_string(entry.unwrap().path()).unwrap());
    let text: String = tables.collect();
    let lines = |hz: &str| text.lines().filter(|line| line.contains(hz)).count();
    assert_eq!([lines(" 300 Hz"), lines(" 250 Hz")], [1, 1], "{text}");
}
