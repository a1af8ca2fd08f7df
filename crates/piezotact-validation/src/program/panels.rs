//! The panels that `replay --panels` counts: measured in parallel, each stored when it is complete.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow};
use piezotact::criterion::Limit;
use piezotact::document::read;
use piezotact::number::{counted as plural, digits};
use piezotact_dataset::read_input_text;
use piezotact_validation::count::{
    ClaimCount, CountSettings, CountedPanels, Decided, Miss, PanelCount, PanelFindings,
};
use piezotact_validation::{CLAIMS, Chapter, chapter};
use piezotact_volunteers::Laboratory;

use super::failure::Outcome;
use super::output::{say, state_text, write_text};
use super::report::{PanelMiss, PanelPart, PanelRow};

/// The panels that an interrupted command stored in `stored`, or none yet.
pub(super) fn begun(
    laboratory: &Laboratory,
    chapters: &[u8],
    stored: &Path,
) -> Outcome<CountedPanels> {
    let settings = CountSettings::of(laboratory, chapters);
    if std::fs::metadata(stored).is_err_and(|error| error.kind() == std::io::ErrorKind::NotFound) {
        return Ok(CountedPanels::none(settings));
    }
    let text = read_input_text(stored)?;
    let todo = "give another folder to --out, or remove the file to count anew";
    let panels: CountedPanels =
        read(&text).map_err(|error| anyhow!("{}: {error}; {todo}", stored.display()))?;
    let panels = panels
        .go_on(&settings)
        .map_err(|error| anyhow!("{}: {error}; {todo}", stored.display()))?;
    Ok(panels)
}

/// Measures what is missing of `count` panels, the first of which is `chapters`, and counts.
pub(super) fn counted(
    laboratory: &Laboratory,
    chapters: &[Chapter],
    mut panels: CountedPanels,
    count: u64,
    stored: &Path,
) -> Outcome<PanelCount> {
    panels.add(PanelFindings::of(laboratory.seed, chapters));
    store(&panels, stored)?;
    let missing = panels.missing(count);
    let known = count as usize - missing.len();
    if known > 1 {
        say(&format!(
            "{}: continues with {} of an interrupted command",
            stored.display(),
            plural(known, "panel")
        ));
    }
    let numbers: Arc<[u8]> = chapters.iter().map(|chapter| chapter.number).collect();
    let work = Arc::new(Mutex::new(VecDeque::from(missing.clone())));
    let (done, results) = channel();
    for _ in 0..std::thread::available_parallelism()
        .map_or(1, usize::from)
        .min(missing.len())
    {
        let (laboratory, work) = (laboratory.clone(), Arc::clone(&work));
        let (numbers, done) = (Arc::clone(&numbers), done.clone());
        std::thread::spawn(move || worker(&laboratory, &numbers, &work, &done));
    }
    drop(done);
    let began = Instant::now();
    let mut measured = 0;
    while measured < missing.len() {
        let (seed, found) = results
            .recv()
            .map_err(|_ended| anyhow!("a panel ended without a result; report this"))?;
        let panel = found.with_context(|| format!("panel of seed {seed}"))?;
        measured += 1;
        let left = missing.len() - measured;
        let per_panel = began.elapsed() / u32::try_from(measured).unwrap_or(u32::MAX);
        let (holding, of) = panel.holding();
        let left = match u32::try_from(left).unwrap_or(u32::MAX) {
            0 => String::new(),
            left => format!("; about {} left", time(per_panel * left)),
        };
        say(&format!(
            "{}/{count} panel of seed {seed}: {holding} of {} hold{left}",
            known + measured,
            plural(of, "claim"),
        ));
        panels.add(panel);
        store(&panels, stored)?;
    }
    Ok(panels.counts(count))
}

/// A time that is left, in words: in steps of 5 s below a minute, else in minutes.
fn time(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    if seconds <= 55.0 {
        return format!("{:.0} s", (seconds / 5.0).ceil() * 5.0);
    }
    let minutes = (seconds / 60.0).ceil() as u64;
    match (minutes / 60, minutes % 60) {
        (0, minutes) => format!("{minutes} min"),
        (hours, minutes) => format!("{hours} h {minutes:02} min"),
    }
}

/// What a panel said, or why it could not be measured.
type Found = (u64, anyhow::Result<PanelFindings>);

/// Measures panels until none is left, nobody listens, or one cannot be measured.
fn worker(
    laboratory: &Laboratory,
    numbers: &[u8],
    work: &Mutex<VecDeque<u64>>,
    done: &Sender<Found>,
) {
    let next = || {
        work.lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop_front()
    };
    while let Some(seed) = next() {
        let found = panel(laboratory, numbers, seed);
        let failed = found.is_err();
        if done.send((seed, found)).is_err() || failed {
            return;
        }
    }
}

fn panel(laboratory: &Laboratory, numbers: &[u8], seed: u64) -> anyhow::Result<PanelFindings> {
    let laboratory = Laboratory {
        seed,
        ..laboratory.clone()
    };
    let mut chapters = Vec::new();
    for number in numbers {
        let chapter = chapter(&laboratory, *number).transpose();
        chapters
            .extend(chapter.map_err(|error| anyhow!(error).context(format!("chapter {number}")))?);
    }
    Ok(PanelFindings::of(seed, &chapters))
}

/// Writes what is known: whole or not at all.
fn store(panels: &CountedPanels, stored: &Path) -> Outcome {
    write_text(stored, &state_text(panels)?)
}

/// How the rules of a claim are counted where that is not all of them in one panel, in words.
fn decided(count: &ClaimCount) -> Option<&'static str> {
    match count.decided {
        Decided::Together => None,
        Decided::EachAlone => Some("each criterion by itself; the fewest"),
    }
}

/// A limit with no more digits than were stated.
fn limit_in_words(limit: Limit) -> String {
    match limit {
        Limit::AtMost { met, .. } => format!("at most {met}"),
        Limit::AtLeast { met, .. } => format!("at least {met}"),
        Limit::Within { reach } => format!("within ±{reach}"),
    }
}

/// By how much the panels that miss a rule do.
fn margin(miss: &Miss) -> String {
    let space = if miss.unit.is_empty() { "" } else { " " };
    let (unit, limit) = (&miss.unit, limit_in_words(miss.limit));
    let margins = (miss.usual_margin, miss.smallest_margin, miss.largest_margin);
    let by = match margins {
        (Some(usual), Some(smallest), Some(largest)) if miss.panels > 1 => format!(
            "by {}{space}{unit} (median; {} to {}{space}{unit})",
            digits(usual),
            digits(smallest),
            digits(largest)
        ),
        (Some(usual), ..) => format!("by {}{space}{unit}", digits(usual)),
        (None, ..) => "with nothing measured".into(),
    };
    let range = miss.range.map_or(String::new(), |[low, high]| {
        let (low, high) = (digits(low), digits(high));
        format!(", 95 % of them {low} to {high}{space}{unit}")
    });
    let all = match (miss.mean, miss.sd) {
        (Some(mean), Some(sd)) => format!(
            "; all panels {} ± {}{space}{unit}{range}",
            digits(mean),
            digits(sd)
        ),
        _ => String::new(),
    };
    format!(
        "{} the limit ({limit}{space}{unit}) {by}{all}",
        match miss.panels {
            1 => "1 panel misses".into(),
            more => format!("{more} panels miss"),
        }
    )
}

/// What the report shows of the panels.
pub(super) fn part(count: &PanelCount) -> PanelPart<'_> {
    let rows = count.claims.iter().map(|of| PanelRow {
        number: of.claim,
        says: (CLAIMS.iter().find(|claim| claim.number == of.claim)).map_or("", |claim| claim.says),
        held: of.held,
        of: of.of,
        interval: of.share.interval,
        enough: of.share.outcome,
        decided: decided(of),
        misses: (of.misses.iter())
            .map(|miss| PanelMiss {
                by: margin(miss),
                why: &miss.unless_met,
            })
            .collect(),
    });
    PanelPart {
        panels: count.panels,
        first_seed: count.first_seed,
        rows: rows.collect(),
    }
}

/// The count as a table.
pub(super) fn table(count: &PanelCount) -> String {
    let head = format!(
        "\n{} from seed {}\n{:>5}  {:>8}  in 9 of 10",
        plural(count.panels, "panel"),
        count.first_seed,
        "claim",
        "held"
    );
    let lines = count.claims.iter().flat_map(|of| {
        let held = format!("{}/{}", of.held, of.of);
        let line = format!("{:>5}  {held:>8}  {}", of.claim, of.share.outcome.answer());
        let misses = of.misses.iter();
        let misses = misses.map(|miss| format!("{:17}{}: {}", "", margin(miss), miss.unless_met));
        std::iter::once(line).chain(misses)
    });
    let lines = std::iter::once(head).chain(lines);
    lines.collect::<Vec<String>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::criterion::Criterion;
    use piezotact_twin::TwinParameters;
    use piezotact_validation::count::PanelFinding;
    use piezotact_validation::{ClaimRule, Counting};

    fn laboratory(seed: u64) -> Laboratory {
        Laboratory {
            parameters: TwinParameters::built_in(),
            seed,
        }
    }

    fn panel_of(seed: u64, deviation_db: f64) -> PanelFindings {
        let rule = ClaimRule {
            unless_met: "too wide".into(),
            counting: Counting::Together,
        };
        PanelFindings {
            seed,
            findings: vec![PanelFinding {
                claim: 1,
                measured: "wide".into(),
                criteria: vec![Criterion::new(
                    rule,
                    "dB",
                    deviation_db,
                    None,
                    Limit::at_most(9.0),
                )],
            }],
        }
    }

    /// What is stored is continued; of another seed, of another kind or cut off it is refused with what to do.
    #[test]
    fn stored_panels_are_continued_or_refused() {
        let folder = tempfile::tempdir().unwrap();
        let stored = folder.path().join("panels.json");
        let mut panels = begun(&laboratory(1), &[5], &stored).ok().unwrap();
        assert!(panels.panels.is_empty());
        panels.add(panel_of(1, 8.0));
        store(&panels, &stored).ok().unwrap();
        assert_eq!(begun(&laboratory(1), &[5], &stored).ok().unwrap(), panels);
        let refused = |laboratory: &Laboratory| match begun(laboratory, &[5], &stored) {
            Err(super::super::failure::Failure::Data(error)) => error.to_string(),
            _ => String::new(),
        };
        let text = refused(&laboratory(2));
        assert!(
            text.contains("seed: expected 2, found 1") && text.contains("--out"),
            "{text}"
        );
        let whole = std::fs::read_to_string(&stored).unwrap();
        for (wrong, says) in [
            (whole.replace("replay_panels", "replay"), "replay"),
            (whole.replace("\"version\": 1", "\"version\": 99"), "99"),
            (whole[..whole.len() / 2].to_owned(), "replay_panels"),
        ] {
            std::fs::write(&stored, wrong).unwrap();
            let text = refused(&laboratory(1));
            assert!(
                text.contains(says) && text.contains("remove the file"),
                "{text}"
            );
        }
    }

    /// The table names what a claim misses, with the number.
    #[test]
    fn the_table_says_by_how_much_a_claim_fails() {
        let mut panels = CountedPanels::none(CountSettings::of(&laboratory(1), &[5]));
        for (seed, db) in [(1, 8.0), (2, 9.5), (3, 11.0)] {
            panels.add(panel_of(seed, db));
        }
        let text = table(&panels.counts(3));
        for part in [
            "3 panels from seed 1",
            "1/3",
            "no",
            "2 panels miss the limit (at most 9 dB) by 1.25 dB (median; 0.500 to 2.00 dB); all panels 9.50 ± 1.22 dB: too wide",
        ] {
            assert!(text.contains(part), "{part}\n{text}");
        }
        for seed in 1..=40 {
            panels.add(panel_of(seed, 9.0 + seed as f64 / 8.0));
        }
        let text = table(&panels.counts(40));
        let range = "; all panels 11.6 ± 1.44 dB, 95 % of them 9.25 to 13.9 dB: too wide";
        assert!(text.contains(range), "{text}");
    }
}
