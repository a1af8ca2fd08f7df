//! `./x bench S1`: pairs of vibrations of the literature, and what the score and other models say of them.

#![allow(clippy::print_stdout, reason = "it prints a table")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use piezotact::quantity::{Band, Hertz};
use piezotact::score::{ScoreConfig, ScoreModel, Verdict, score};
use piezotact::spectrum::WelchConfig;
use serde::Deserialize;

use super::signals::{FS, pair, series};

pub(super) const NAME: &str = "S1";
const EXPECTED: &str = include_str!("../../../piezotact/tests/perception/expected.txt");
/// The pairs that may be left undecided, as a share.
const MOST_NOT_DECIDED: f64 = 0.2;
/// So many segments fit, without overlap, for a score by spectra of recordings longer than so many samples.
const SEGMENTS: usize = 4;
const SHORTEST: usize = 4_096;
const MODELS: [&str; 4] = ["score", "spectral", "two-channel", "segments"];

/// A pair with the JND by which people find it apart.
struct Expected {
    key: &'static str,
    low: f64,
    high: f64,
}

impl Expected {
    fn all() -> Result<Vec<Self>> {
        let rows = EXPECTED.lines().filter(|line| !line.starts_with('#'));
        let of = |row: &'static str| {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let [key, _, _, low, high, _] = cells[..] else {
                anyhow::bail!("expected six cells, found {row}");
            };
            Ok(Self {
                key,
                low: low.parse()?,
                high: match high {
                    "" => f64::INFINITY,
                    high => high.parse()?,
                },
            })
        };
        rows.map(of).collect()
    }

    fn text(&self) -> String {
        match (self.low, self.high) {
            (low, high) if high.is_infinite() => format!("above {low}"),
            (low, high) if low <= 0.0 => format!("below {high}"),
            (low, high) => format!("{low}–{high}"),
        }
    }
}

/// What a model says of a pair.
#[derive(Clone, Copy)]
enum Said {
    Below,
    Apart,
    NotDecided,
}

#[derive(Clone, Copy)]
struct Answer {
    jnd: f64,
    said: Said,
}

impl Answer {
    /// Of a model that states no interval.
    fn plain(jnd: f64) -> Self {
        let said = if jnd > 1.0 { Said::Apart } else { Said::Below };
        Self { jnd, said }
    }

    fn is_right(self, expected: &Expected) -> bool {
        (expected.low..=expected.high).contains(&self.jnd)
    }

    /// Whether it says that people do not tell apart what they do, or the reverse.
    fn is_false(self, expected: &Expected) -> bool {
        match self.said {
            Said::Below => expected.low >= 1.0,
            Said::Apart => expected.high <= 1.0,
            Said::NotDecided => false,
        }
    }

    fn is_open(self, expected: &Expected) -> bool {
        matches!(self.said, Said::NotDecided) && (expected.low >= 1.0 || expected.high <= 1.0)
    }

    fn text(self, expected: &Expected) -> String {
        let mark = match (self.is_false(expected), self.is_right(expected)) {
            (true, _) => "FALSE",
            (false, true) => "",
            (false, false) => "outside",
        };
        let open = match self.said {
            Said::NotDecided => "?",
            _ => " ",
        };
        let jnd = match self.jnd.is_nan() {
            true => "refused".to_owned(),
            false => format!("{:.2}", self.jnd),
        };
        format!("{jnd}{open}{mark:>8}")
    }
}

/// What is printed by `bench/rivals.py`.
#[derive(Deserialize)]
struct Rivals {
    two_channel: f64,
    segments: f64,
}

/// Our scores of the pair `key`: perceived and spectral.
fn ours(key: &str) -> Result<[Answer; 2]> {
    let [a, b] = pair(key).map(|x| series(&x));
    let band = Band::new(Hertz(20.0), Hertz(1000.0))?;
    let of = |config: &ScoreConfig| -> Result<Answer> {
        let found = score(&a, &b, config).with_context(|| key.to_owned())?;
        let perceived = found.perceived.map(|found| found.difference.jnd.value);
        Ok(Answer {
            jnd: perceived.unwrap_or(found.spectral.jnd),
            said: match found.verdict {
                Verdict::BelowJnd => Said::Below,
                Verdict::Distinguishable { .. } => Said::Apart,
                Verdict::NotDecided { .. } => Said::NotDecided,
            },
        })
    };
    let config = ScoreConfig::over(band, FS);
    // Spectra of a second have more to say in segments of which several fit; what is shorter is compared by one segment around it.
    let shorter = a.samples().len().min(b.samples().len());
    let mut segment = config.welch.segment;
    while shorter > SHORTEST && SEGMENTS * segment > shorter {
        segment /= 2;
    }
    let spectral = ScoreConfig {
        judged_by: ScoreModel::Spectral,
        welch: WelchConfig::hann(segment),
        ..config.clone()
    };
    // Short ones are refused by spectra.
    let refused = Answer {
        jnd: f64::NAN,
        said: Said::NotDecided,
    };
    Ok([of(&config)?, of(&spectral).unwrap_or(refused)])
}

/// What other models say of the pairs `keys`, by the program `bench/rivals.py`.
fn rivals(python: &str, keys: &[&str]) -> Result<BTreeMap<String, Rivals>> {
    let folder = std::env::temp_dir().join(format!("piezotact-pairs-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    for key in keys {
        for (name, x) in ["a", "b"].into_iter().zip(pair(key)) {
            let bytes: Vec<u8> = x.iter().flat_map(|v| v.to_le_bytes()).collect();
            std::fs::write(folder.join(format!("{key}.{name}.f64")), bytes)?;
        }
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bench/rivals.py");
    let done = Command::new(python)
        .arg(script)
        .arg(&folder)
        .args(keys)
        .output()
        .context(python.to_owned())?;
    std::fs::remove_dir_all(&folder)?;
    ensure!(
        done.status.success(),
        "bench/rivals.py failed: {}",
        String::from_utf8_lossy(&done.stderr)
    );
    Ok(serde_json::from_slice(&done.stdout)?)
}

/// Prints the table, and fails where the score says something false, leaves too much open, or another model has as many pairs right.
pub(super) fn run(python: &str) -> Result<()> {
    let pairs = Expected::all()?;
    let keys: Vec<&str> = pairs.iter().map(|pair| pair.key).collect();
    let others = rivals(python, &keys)?;
    println!(
        "S1 how far people find pairs of vibrations apart, JND, and what models say; ?: not decided; outside: not where it is expected;\n\
         FALSE: called below the JND although people tell the two apart, or the reverse\n"
    );
    let [score, spectral, two_channel, segments] = MODELS;
    println!(
        "{:<10}{:>10}{score:>16}{spectral:>16}{two_channel:>16}{segments:>16}",
        "pair", "expected"
    );
    // Right, false, not decided.
    let mut counts = [[0usize; 3]; MODELS.len()];
    for expected in &pairs {
        let other = others.get(expected.key).context("a pair is missing")?;
        let [score, spectral] = ours(expected.key)?;
        let plain = [other.two_channel, other.segments].map(Answer::plain);
        let answers = [score, spectral, plain[0], plain[1]];
        for (counts, answer) in counts.iter_mut().zip(answers) {
            counts[0] += usize::from(answer.is_right(expected));
            counts[1] += usize::from(answer.is_false(expected));
            counts[2] += usize::from(answer.is_open(expected));
        }
        let cells = answers.map(|answer| format!("{:>16}", answer.text(expected)));
        println!(
            "{:<10}{:>10}{}",
            expected.key,
            expected.text(),
            cells.concat()
        );
    }
    println!(
        "\n{:<14}{:>8}{:>8}{:>13}   of {} pairs",
        "",
        "right",
        "false",
        "not decided",
        pairs.len()
    );
    for (name, [right, false_, open]) in MODELS.iter().zip(counts) {
        println!("{name:<14}{right:>8}{false_:>8}{open:>13}");
    }
    let [[right, false_, open], rivals @ ..] = counts;
    ensure!(false_ == 0, "{false_} false statements");
    ensure!(
        open as f64 <= MOST_NOT_DECIDED * pairs.len() as f64,
        "{open} pairs are not decided"
    );
    ensure!(
        rivals.iter().all(|rival| rival[0] < right),
        "another model has as many pairs right"
    );
    println!("\nno false statement, and more pairs right than any other model");
    Ok(())
}
