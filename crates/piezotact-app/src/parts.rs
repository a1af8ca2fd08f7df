//! The figures and tables of a report as files of their own, for every command that has a report.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::builder::PossibleValuesParser;
use clap::{Arg, Command, value_parser};
use piezotact_report::parts::{Columns, FigurePart, figures, tables};

use crate::arguments::Arguments;
use crate::failure::{Outcome, usage};
use crate::output::write_bytes;

/// Commands that always write a report.
const REPORTING: [&str; 1] = ["demo"];
const FIGURES: &str = "figures";
const TABLES: &str = "tables";
/// The same in both builds, so that help and manuals are.
const FIGURES_HELP: &str = "Writes every figure of the report to this folder, as SVG; the full build (./x build) also writes PNG and PDF";
const COLUMNS: &str = "columns";

/// `command`, each of whose commands with a report has the options of its figures and tables.
pub(crate) fn with_options(command: Command) -> Command {
    let names: Vec<String> = command
        .get_subcommands()
        .map(|below| below.get_name().to_owned())
        .collect();
    let command = names.iter().fold(command, |command, name| {
        command.mut_subcommand(name, with_options)
    });
    let asks = command
        .get_arguments()
        .any(|argument| argument.get_id() == "report");
    if asks {
        return command.args(options().map(|option| option.requires("report")));
    }
    if REPORTING.contains(&command.get_name()) {
        return command.args(options());
    }
    command
}

fn options() -> [Arg; 3] {
    let folder = |name: &'static str, help: &'static str| {
        Arg::new(name)
            .long(name)
            .value_name("DIR")
            .value_parser(value_parser!(PathBuf))
            .help(help)
    };
    [
        folder(FIGURES, FIGURES_HELP),
        folder(
            TABLES,
            "Writes every table of the report to this folder, as CSV",
        ),
        Arg::new(COLUMNS)
            .long(COLUMNS)
            .value_name("1|2")
            .value_parser(PossibleValuesParser::new(["1", "2"]))
            .hide_possible_values(true)
            .requires(FIGURES)
            .help("The width of --figures in columns of a journal: 1 (85 mm) or 2 (174 mm, the default)"),
    ]
}

/// What is written of a report beside it.
pub(crate) struct Parts {
    figures: Option<PathBuf>,
    tables: Option<PathBuf>,
    columns: Columns,
}

impl Parts {
    /// What `arguments` ask for.
    pub(crate) fn of(arguments: &Arguments<'_>) -> Self {
        let folder = |name: &str| arguments.value(name).map(PathBuf::from);
        Self {
            figures: folder(FIGURES),
            tables: folder(TABLES),
            columns: match arguments.value(COLUMNS).as_deref() {
                Some("1") => Columns::One,
                _ => Columns::Two,
            },
        }
    }

    /// The parts of the report `html` that are asked for: their files with what is in them.
    pub(crate) fn of_report(&self, html: &str) -> Outcome<Vec<(PathBuf, Vec<u8>)>> {
        let mut files = Vec::new();
        if let Some(folder) = &self.figures {
            let drawn = figures(html, self.columns);
            required(drawn.len(), FIGURES)?;
            let file = |figure: &FigurePart| folder.join(format!("{}.svg", figure.name));
            #[cfg(feature = "full")]
            files.extend(pictures(folder, &drawn)?);
            files.extend(
                drawn
                    .into_iter()
                    .map(|figure| (file(&figure), figure.svg.into_bytes())),
            );
        }
        if let Some(folder) = &self.tables {
            let file = |name: &str| folder.join(format!("{name}.csv"));
            let drawn = tables(html)?;
            required(drawn.len(), TABLES)?;
            files.extend(
                drawn
                    .into_iter()
                    .map(|table| (file(&table.name), table.csv.into_bytes())),
            );
        }
        Ok(files)
    }

    /// Those files of the figures and tables of the report `html`, of any width, that stand there as they were written: what a person
    /// changed, or put there under such a name, is not among them. Pictures stand as their SVG does.
    pub(crate) fn unchanged_of(&self, html: &str) -> Outcome<Vec<PathBuf>> {
        let mut files = Vec::new();
        let stands =
            |path: &Path, bytes: &[u8]| std::fs::read(path).is_ok_and(|found| found == bytes);
        if let Some(folder) = &self.figures {
            let widths = [Columns::One, Columns::Two].into_iter();
            for figure in widths.flat_map(|columns| figures(html, columns)) {
                let file = |ending: &str| folder.join(format!("{}.{ending}", figure.name));
                if stands(&file("svg"), figure.svg.as_bytes()) {
                    files.extend(["svg", "png", "pdf"].map(file));
                }
            }
        }
        if let Some(folder) = &self.tables {
            let all = tables(html)?.into_iter();
            let all = all.map(|table| (folder.join(format!("{}.csv", table.name)), table.csv));
            files.extend(
                all.filter(|(file, csv)| stands(file, csv.as_bytes()))
                    .map(|(file, _)| file),
            );
        }
        files.retain(|file| file.is_file());
        Ok(files)
    }

    /// Writes `files`.
    pub(crate) fn write(&self, files: &[(PathBuf, Vec<u8>)]) -> Outcome {
        for folder in self.figures.iter().chain(&self.tables) {
            made(folder)?;
        }
        for (path, bytes) in files {
            write_bytes(path, bytes)?;
        }
        Ok(())
    }
}

/// `figures` as PNG and PDF.
#[cfg(feature = "full")]
fn pictures(folder: &Path, figures: &[FigurePart]) -> Outcome<Vec<(PathBuf, Vec<u8>)>> {
    let pictures = crate::pictures::Pictures::new()?;
    let mut files = Vec::new();
    for figure in figures {
        let file = |ending: &str| folder.join(format!("{}.{ending}", figure.name));
        files.push((file("pdf"), pictures.pdf(&figure.svg)?));
        files.push((file("png"), pictures.png(&figure.svg)?));
    }
    Ok(files)
}

/// Refuses an option for what the report does not have: its folder would be empty.
fn required(count: usize, what: &str) -> Outcome {
    match count {
        1.. => Ok(()),
        0 => Err(usage(anyhow!(
            "expected {what} in the report for --{what}, found none; leave the option out"
        ))),
    }
}

fn made(folder: &Path) -> Outcome {
    std::fs::create_dir_all(folder).map_err(|error| {
        anyhow!(
            "cannot create the folder {}: {error}; check the path",
            folder.display()
        )
    })?;
    Ok(())
}
