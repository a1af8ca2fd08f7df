//! `piezotact-validation replay`: the thesis' measurements again, on the digital twin.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::number::counted;
use piezotact_dataset::{keep_as_it_is, read_input_text};
use piezotact_report::parts::{Columns, figures, tables};
use piezotact_twin::TwinParameters;
use piezotact_validation::count::PanelCount;
use piezotact_validation::document::Replay;
use piezotact_validation::{CHAPTERS, CLAIMS, Chapter, Claim, Finding, Verdict, chapter};
use piezotact_volunteers::Laboratory;

use super::advice::PlainWords;
use super::failure::{Failure, Outcome};
use super::made::{Called, Written};
use super::output::{name, print, say, write_text};
use super::outputs::{Existing, Outputs};
use super::panels;
use super::report::{ChapterPart, ClaimRow, Page, Standing, html};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// One chapter of the thesis; default: all of them.
    #[arg(long, value_name = "3|4|5|6", value_parser = chapter_number)]
    chapter: Option<u8>,
    /// The folder for report.html and findings.json.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seed of the random participants, surfaces, movements and noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Counts in how many of N panels each claim holds: those of the seed and of the N - 1 after it.
    ///
    /// A panel is everything that one seed draws, and takes minutes. Every panel is stored in panels.json in the folder when it is
    /// complete. After an interruption the same command continues.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    panels: Option<u64>,
    /// Your own parameter file (TOML): its values replace the built-in parameters of the twin.
    #[arg(long, value_name = "FILE")]
    twin: Option<PathBuf>,
    /// Prints the findings as JSON.
    #[arg(long)]
    json: bool,
    /// Writes every figure of the report to this folder, as SVG.
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Writes every table of the report to this folder, as CSV.
    #[arg(long, value_name = "DIR")]
    tables: Option<PathBuf>,
    /// The width of --figures in columns of a journal: 1 (85 mm) or 2 (174 mm, the default).
    #[arg(long, value_name = "1|2", value_parser = ["1", "2"], hide_possible_values = true, requires = "figures")]
    columns: Option<String>,
}

fn chapter_number(text: &str) -> Result<u8, String> {
    let number = text.parse().ok().filter(|number| CHAPTERS.contains(number));
    number.ok_or_else(|| {
        let numbers = CHAPTERS.map(|number| number.to_string());
        format!(
            "expected one of the chapters {}, found `{text}`",
            numbers.join(", ")
        )
    })
}

/// Repeats what `args` ask for; files that another command wrote are replaced where `existing` says so.
pub(super) fn run(args: &Arguments, called: &Called, existing: Existing) -> Outcome {
    let laboratory = Laboratory {
        parameters: twin_parameters(args.twin.as_deref())?,
        seed: args.seed,
    };
    let [report, findings, stored] = written(args, called, existing)?;
    let (chapters, count) = chapters_and_count(args, &laboratory, &stored)?;
    let replay = Replay {
        report: name(&report),
        seed: laboratory.seed,
        twin: args.twin.as_deref().map(name),
        changes: laboratory.parameters.changes().to_vec(),
        chapters,
        panels: count,
    };
    let page = page(&replay);
    let written = |file| Written {
        folder: &args.out,
        file,
        read: args.twin.as_deref(),
    };
    let html = html(&page, &PlainWords)?;
    called.write_report(&html, &written(&report))?;
    write_parts(args, &html, existing)?;
    let text = called.document(&replay, &written(&findings))?;
    write_text(&findings, &text)?;
    if args.json {
        return print(&text);
    }
    print(&table(&replay.chapters))?;
    if let Some(count) = &replay.panels {
        print(&panels::table(count))?;
    }
    print(&format!("report: {}", report.display()))?;
    print(&tally(all(&replay.chapters)))
}

/// The twin's numbers, with what a laboratory's own file changes.
fn twin_parameters(file: Option<&Path>) -> Outcome<TwinParameters> {
    let Some(file) = file else {
        return Ok(TwinParameters::built_in());
    };
    let text = read_input_text(file).map_err(|error| {
        Failure::Data(anyhow!(
            "{}: expected a parameter file, see `piezotact twin parameters`: {error}",
            file.display()
        ))
    })?;
    TwinParameters::changed_by(&text).map_err(|error| {
        Failure::Data(anyhow::Error::new(error).context(file.display().to_string()))
    })
}

/// The files that are written in the folder: the report, the findings, and the panels that were counted.
fn written(args: &Arguments, called: &Called, existing: Existing) -> Outcome<[PathBuf; 3]> {
    let out = &args.out;
    create(out)?;
    let files = ["report.html", "findings.json", "panels.json"].map(|file| out.join(file));
    let outputs = Outputs {
        here: &called.folder,
        folder: out,
        existing,
    };
    outputs.check(args.twin.as_deref(), &files)?;
    Ok(files)
}

/// Writes the figures and tables of the report `html` that are asked for; what stands there and differs is refused, where it is not
/// replaced.
fn write_parts(args: &Arguments, html: &str, existing: Existing) -> Outcome {
    let mut files = Vec::new();
    if let Some(folder) = &args.figures {
        let columns = match args.columns.as_deref() {
            Some("1") => Columns::One,
            _ => Columns::Two,
        };
        let drawn = figures(html, columns).into_iter();
        files.extend(drawn.map(|one| (folder, format!("{}.svg", one.name), one.svg)));
    }
    if let Some(folder) = &args.tables {
        let drawn = tables(html)?.into_iter();
        files.extend(drawn.map(|one| (folder, format!("{}.csv", one.name), one.csv)));
    }
    for (folder, name, text) in files {
        let path = folder.join(name);
        create(folder)?;
        if existing == Existing::Compared && path.is_file() {
            keep_as_it_is(&path);
        }
        write_text(&path, &text)?;
    }
    Ok(())
}

fn create(folder: &Path) -> Outcome {
    std::fs::create_dir_all(folder).map_err(|error| {
        anyhow!(
            "cannot create the folder {}: {error}; check the path",
            folder.display()
        )
    })?;
    Ok(())
}

/// What is measured with the seed, and how many panels meet each claim, where that is asked for.
fn chapters_and_count(
    args: &Arguments,
    laboratory: &Laboratory,
    stored: &Path,
) -> Outcome<(Vec<Chapter>, Option<PanelCount>)> {
    let asked: Vec<u8> = (args.chapter).map_or(CHAPTERS.to_vec(), |number| vec![number]);
    let Some(count) = args.panels else {
        return Ok((measured(laboratory, &asked)?, None));
    };
    // What cannot be continued is refused before anything is measured.
    let begun = panels::begun(laboratory, &asked, stored)?;
    let chapters = measured(laboratory, &asked)?;
    let counted = panels::counted(laboratory, &chapters, begun, count, stored)?;
    Ok((chapters, Some(counted)))
}

/// The chapters `asked`.
fn measured(laboratory: &Laboratory, asked: &[u8]) -> Outcome<Vec<Chapter>> {
    let mut chapters = Vec::new();
    for (i, number) in asked.iter().enumerate() {
        say(&format!("{}/{} chapter {number}", i + 1, asked.len()));
        let chapter = chapter(laboratory, *number).transpose();
        chapters
            .extend(chapter.map_err(|error| anyhow!(error).context(format!("chapter {number}")))?);
    }
    Ok(chapters)
}

fn all(chapters: &[Chapter]) -> impl Iterator<Item = &Finding> {
    chapters.iter().flat_map(|chapter| &chapter.findings)
}

fn table(chapters: &[Chapter]) -> String {
    let mut lines = vec![format!("{:>5}  {:<13}  measured", "claim", "verdict")];
    lines.extend(all(chapters).map(|finding| {
        let verdict = word(&finding.verdict);
        format!("{:>5}  {verdict:<13}  {}", finding.claim, finding.measured)
    }));
    lines.join("\n")
}

/// How many claims hold, do not hold, and cannot be measured yet.
fn tally<'a>(findings: impl IntoIterator<Item = &'a Finding>) -> String {
    let words: Vec<&str> = findings.into_iter().map(|f| word(&f.verdict)).collect();
    let counts = [Standing::Holds, Standing::DoesNot, Standing::NotYet].map(|standing| {
        let same = words.iter().filter(|word| **word == standing.word());
        format!("{} {}", standing.word(), same.count())
    });
    format!("{}: {}", counted(words.len(), "claim"), counts.join(", "))
}

fn standing(verdict: &Verdict) -> Standing {
    match verdict {
        Verdict::Holds => Standing::Holds,
        Verdict::DoesNot { .. } => Standing::DoesNot,
        Verdict::NotYet { .. } => Standing::NotYet,
    }
}

/// A verdict in words.
fn word(verdict: &Verdict) -> &'static str {
    standing(verdict).word()
}

/// What the report shows.
fn page(replay: &Replay) -> Page<'_> {
    let chapters = &replay.chapters;
    let all_asked = chapters.len() == CHAPTERS.len();
    let claims = CLAIMS.iter().map(|claim| {
        let found = all(chapters).find(|finding| finding.claim == claim.number);
        let otherwise = if all_asked {
            Standing::NotYet
        } else {
            Standing::NotAsked
        };
        row(claim, found, otherwise)
    });
    let parts = chapters.iter().map(|chapter| {
        let figures = chapter.figures.iter().map(|of| (of.number, &of.figure));
        let claims = chapter.findings.iter().filter_map(|finding| {
            let claim = CLAIMS.iter().find(|claim| claim.number == finding.claim)?;
            Some(row(claim, Some(finding), Standing::NotYet))
        });
        ChapterPart {
            number: chapter.number,
            title: chapter.title,
            measured: &chapter.measured,
            tally: tally(&chapter.findings),
            claims: claims.collect(),
            figures: figures.collect(),
            warnings: &chapter.warnings,
            missing: &chapter.missing,
        }
    });
    Page {
        seed: replay.seed,
        twin: replay.twin.clone(),
        changes: &replay.changes,
        claims: claims.collect(),
        panels: replay.panels.as_ref().map(panels::part),
        chapters: parts.collect(),
    }
}

/// A claim with what was found of it; where nothing was it stands as `otherwise`.
fn row<'a>(claim: &'a Claim, found: Option<&'a Finding>, otherwise: Standing) -> ClaimRow<'a> {
    let verdict = found.map(|finding| &finding.verdict);
    let criteria = found.map_or(&[][..], |finding| &finding.criteria);
    ClaimRow {
        number: claim.number,
        chapter: claim.chapter,
        at: claim.at,
        says: claim.says,
        quote: claim.quote,
        holds_if: claim.holds_if,
        standing: verdict.map_or(otherwise, standing),
        is_found: found.is_some(),
        measured: found.map_or("", |finding| &finding.measured),
        why: match verdict {
            Some(Verdict::DoesNot { reason }) => reason.clone(),
            Some(Verdict::NotYet { with }) => {
                format!("needs {with}, which the program does not contain yet")
            }
            Some(Verdict::Holds) | None => String::new(),
        },
        criteria: (criteria.iter())
            .map(|criterion| criterion.clone().called(criterion.what.unless_met.clone()))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::Warning;
    use piezotact::figure::{Axis, Chart, Line, Mark, Tone};
    use piezotact::recording::RecordingWarning;
    use piezotact::warning::merged_of;
    use piezotact_validation::Counterpart;

    fn finding(claim: u8, verdict: Verdict) -> Finding {
        Finding {
            claim,
            measured: format!("measured of {claim}"),
            verdict,
            criteria: Vec::new(),
        }
    }

    fn figure(number: &'static str) -> Counterpart {
        let marks = [Mark::Dots, Mark::Line, Mark::Dashed, Mark::Joined];
        let line = |mark: Mark| {
            Line::new(
                format!("{mark:?}"),
                Tone::Main,
                vec![(0.0, 0.0), (1.0, 2.0)],
            )
            .marked(mark)
        };
        let (x, y) = (
            Axis::names("", vec!["S1".into(), "NO".into()]),
            Axis::new("Ra & rms", 0.0, 2.0),
        );
        Counterpart {
            number,
            figure: Chart::new(x, y, marks.map(line).into()).captioned("A caption."),
        }
    }

    /// Every claim has a row that the overview leads to, whatever became of it.
    #[test]
    fn every_claim_has_its_row() {
        let does_not = Verdict::DoesNot {
            reason: "too loud".into(),
        };
        let uncalibrated = Warning::from(RecordingWarning::Uncalibrated {
            channel: "a".into(),
        });
        let warning = merged_of([(Some("S8"), &uncalibrated)]).remove(0);
        let chapter = Chapter {
            number: 4,
            title: "Rendering",
            measured: vec!["Somebody touched.".into()],
            findings: vec![
                finding(20, Verdict::Holds),
                finding(21, does_not),
                finding(24, Verdict::NotYet { with: "people" }),
                finding(34, Verdict::Holds),
            ],
            figures: vec![figure("47a"), figure("47b"), figure("48")],
            warnings: vec![warning],
            missing: vec!["figure 51".into()],
        };
        let replay = Replay {
            report: "report.html".into(),
            seed: 7,
            twin: None,
            changes: Vec::new(),
            chapters: vec![chapter],
            panels: None,
        };
        let page = page(&replay);
        let html = html(&page, &PlainWords).unwrap();
        for claim in CLAIMS {
            let (row, link) = (
                format!("id=\"claim-{}\"", claim.number),
                format!("#claim-{}\"", claim.number),
            );
            assert_eq!(html.matches(&row).count(), 1, "{row}");
            assert_eq!(html.matches(&link).count(), 1, "{link}");
        }
        for part in [
            "4 claims: holds 2, does not hold 1, not yet 1.",
            "too loud",
            "needs people",
            "<li>S8: ",
            "state the scale",
            "<li>figure 51</li>",
            "Counterpart of figure 47b",
            "Seed 7, built-in parameters.",
        ] {
            assert!(html.contains(part), "{part}");
        }
        // Neither was asked for.
        let standing = |number: u8| page.claims[usize::from(number) - 1].standing.word();
        assert_eq!(
            [standing(33), standing(1)],
            ["not selected", "not selected"]
        );
        // 47a begins a row of two; 48 stands alone.
        assert_eq!(html.matches("<figure class=\"first\">").count(), 1);
    }
}
