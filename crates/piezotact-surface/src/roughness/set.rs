//! The roughness of several surfaces: a set ordered by Ra, its table and its figure.

use serde::Serialize;

use super::page::file_name;
use super::{EvaluatedSurface, Parameter, RoughnessDocument};
use piezotact::document::{Content, FailedFile};
use piezotact::figure::{Axis, Chart, Figure, Line, Mark, Scale, Tone};
use piezotact::number::counted;
use piezotact::page::{Block, Cell, Column, Page, Shown, Table};
use piezotact::warning::Merged;

/// The parameters of the figure, of profiles and of maps.
const DRAWN: [(&str, &str); 3] = [("Ra", "Sa"), ("Rq", "Sq"), ("Rz", "Sz")];
/// The parameters of the table that people read; CSV and JSON hold all.
const SHOWN: [&str; 16] = [
    "Ra", "Rq", "Rz", "Rt", "RSm", "Rdq", "Rk", "Rpk", "Rvk", "Mr1", "Mr2", "Sa", "Sq", "Sz",
    "Sdr", "Str",
];

/// The roughness of several surfaces, the roughest first.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RoughnessSet {
    /// The surfaces, ordered by Ra (of maps: Sa), the roughest first; last those profiles whose sections are not those of one surface.
    surfaces: Vec<EvaluatedSurface>,
    /// The files that could not be read or evaluated.
    failed: Vec<FailedFile>,
}

impl Content for RoughnessSet {
    const SCHEMA: &'static str = "roughness_set";
}

impl Shown for RoughnessSet {
    fn page(&self) -> Page {
        let mut blocks = vec![Block::conclusion(self.order(), None)];
        blocks.extend(self.figure().map(Block::Figure));
        let mut page = Page::new("Roughness of a set of surfaces", "").section("", blocks);
        if !self.failed.is_empty() {
            page = page.section(
                "Files without a result",
                [Block::Steps {
                    steps: self
                        .failed
                        .iter()
                        .map(|failed| failed.why.clone())
                        .collect(),
                }],
            );
        }
        page = page.section("Parameters", [Block::Table(self.short_table())]);
        let methods = self.surfaces.iter().map(|surface| {
            let instrument = match &surface.instrument {
                Some(stated) => format!(" Instrument: {}.", stated.text()),
                None => String::new(),
            };
            let (size, method) = (
                surface.roughness.size_text(),
                surface.roughness.method_text(),
            );
            format!(
                "{}: {size} ({}). {method}.{instrument}",
                name(surface),
                surface.format
            )
        });
        page = page.section(
            "How they were computed",
            [Block::Steps {
                steps: methods.collect(),
            }],
        );
        for (name, warnings) in self.warnings() {
            page = page.section(
                &format!("Warnings about {name}"),
                [Block::warnings(name, warnings)],
            );
        }
        page.rows(self.table())
    }
}

impl RoughnessSet {
    /// The set of `surfaces`, ordered by Ra (of maps: Sa) from the roughest to the smoothest, and the files that `failed`.
    /// Surfaces of equal roughness keep their order; profiles whose sections are not those of one surface come last.
    ///
    /// Source: thesis 2.1.2, which orders the samples S1 to S14 so.
    #[must_use]
    pub fn of(mut surfaces: Vec<EvaluatedSurface>, failed: Vec<FailedFile>) -> Self {
        let mean_height = |surface: &EvaluatedSurface| {
            let parameters = surface.roughness.parameters();
            value(&parameters, DRAWN[0]).unwrap_or(f64::NAN)
        };
        surfaces.sort_by(|a, b| mean_height(b).total_cmp(&mean_height(a)));
        surfaces.sort_by_key(|surface| !surface.roughness.is_uniform());
        Self { surfaces, failed }
    }

    /// The order of the surfaces in words, with those that have no place in it.
    fn order(&self) -> String {
        let uniform = self.surfaces.iter().filter(|of| of.roughness.is_uniform());
        let ordered: Vec<String> = uniform.map(name).collect();
        let others: Vec<String> = self.surfaces[ordered.len()..].iter().map(name).collect();
        let mut text = match ordered.as_slice() {
            [] => String::new(),
            ordered => format!(
                "{} in the order of their arithmetic mean height, the roughest first: {}.",
                counted(ordered.len(), "surface"),
                ordered.join(", ")
            ),
        };
        if !others.is_empty() {
            let separator = if text.is_empty() { "" } else { " " };
            text += &format!(
                "{separator}Not ordered, because their sections are not those of one surface: {}.",
                others.join(", ")
            );
        }
        text
    }

    /// The surfaces, the roughest first.
    #[must_use]
    pub fn surfaces(&self) -> &[EvaluatedSurface] {
        &self.surfaces
    }

    /// The files that could not be read or evaluated.
    #[must_use]
    pub fn failed(&self) -> &[FailedFile] {
        &self.failed
    }

    /// All parameters of all surfaces, one row for each, with cut-off and evaluation length: lengths in µm and mm.
    ///
    /// Source: docs/decisions/roughness.md.
    #[must_use]
    pub fn table(&self) -> Table {
        self.table_of(|_| true)
    }

    /// The parameters that people compare first, one row for each surface: lengths in µm and mm.
    ///
    /// Source: as [`table`](Self::table).
    #[must_use]
    pub fn short_table(&self) -> Table {
        self.table_of(|symbol| SHOWN.contains(&symbol))
    }

    fn table_of(&self, is_shown: impl Fn(&str) -> bool) -> Table {
        let all: Vec<Vec<Parameter>> = (self.surfaces.iter())
            .map(|surface| surface.roughness.parameters())
            .collect();
        let mut symbols: Vec<(&str, &str, &str)> = Vec::new();
        for parameter in all.iter().flatten() {
            let known = symbols
                .iter()
                .any(|(symbol, ..)| *symbol == parameter.symbol);
            if !known && is_shown(parameter.symbol) {
                symbols.push((parameter.symbol, parameter.unit, parameter.key()));
            }
        }
        let mut columns = vec![Column::new("file", "file")];
        columns.extend(symbols.iter().map(|(symbol, unit, key)| match *unit {
            "" => Column::new(symbol, key),
            "µm" => Column::new(&format!("{symbol}, µm"), &format!("{key}_um")),
            unit => Column::new(&format!("{symbol}, {unit}"), key),
        }));
        columns.push(Column::new("λc, mm", "cutoff_mm"));
        columns.push(Column::new("evaluated, mm", "evaluation_length_mm"));
        columns.push(Column::new("filter", "filter"));
        columns.push(Column::new("warnings", "warnings"));
        let mut table = Table::new(columns);
        for (surface, parameters) in self.surfaces.iter().zip(&all) {
            let document = RoughnessDocument::of(surface);
            let mut row = vec![Cell::Text(name(surface))];
            row.extend(symbols.iter().map(|(symbol, ..)| {
                let found = parameters.iter().find(|p| p.symbol == *symbol);
                Cell::from(found.and_then(|p| p.value))
            }));
            row.push(Cell::from(document.method.cutoff_mm));
            row.push(Cell::from(document.method.evaluation_length_mm));
            row.push(Cell::from(document.method.filter));
            row.push(Cell::Text(document.warnings.len().to_string()));
            table.rows.push(row);
        }
        table
    }

    /// Ra, Rq and Rz (of maps Sa, Sq and Sz) of the surfaces in their order, in µm; `None` for a set without any above zero.
    ///
    /// Source: thesis, figure 11.
    #[must_use]
    pub fn figure(&self) -> Option<Figure> {
        let all: Vec<Vec<Parameter>> = (self.surfaces.iter())
            .map(|surface| surface.roughness.parameters())
            .collect();
        let has = |symbol: &str| all.iter().flatten().any(|p| p.symbol == symbol);
        let tones = [Tone::Main, Tone::Second, Tone::Third];
        let lines: Vec<Line> = DRAWN
            .into_iter()
            .zip(tones)
            .map(|(symbols, tone)| {
                let points = all.iter().enumerate().filter_map(|(place, parameters)| {
                    let height = value(parameters, symbols).filter(|height| *height > 0.0)?;
                    Some((place as f64, height))
                });
                let label = match (has(symbols.0), has(symbols.1)) {
                    (true, true) => format!("{} or {}", symbols.0, symbols.1),
                    (false, true) => symbols.1.into(),
                    _ => symbols.0.into(),
                };
                Line::new(label, tone, points.collect()).marked(Mark::Dots)
            })
            .collect();
        let heights = || {
            lines
                .iter()
                .flat_map(|line| line.points.iter().map(|p| p.1))
        };
        heights().next()?;
        let y = Axis::around("height, µm", Scale::Logarithmic, heights());
        let names = self
            .surfaces
            .iter()
            .map(|surface| match surface.roughness.is_uniform() {
                true => name(surface),
                false => format!("{} (not ordered)", name(surface)),
            });
        let names = names.collect();
        let chart = Chart::new(Axis::names("surface, the roughest first", names), y, lines);
        Some(chart.beside().captioned(
            "Arithmetic mean height, root-mean-square height and maximum height of each surface, ordered by the first.",
        ))
    }

    /// The warnings of all surfaces, each with the name of its file.
    #[must_use]
    pub fn warnings(&self) -> Vec<(String, Vec<Merged>)> {
        let of = |surface: &EvaluatedSurface| (name(surface), surface.warnings.merged());
        let all = self.surfaces.iter().map(of);
        all.filter(|(_, warnings)| !warnings.is_empty()).collect()
    }
}

/// The value of one of two parameters, of a profile or of a map.
fn value(parameters: &[Parameter], symbols: (&str, &str)) -> Option<f64> {
    let mut found = parameters
        .iter()
        .filter(|p| p.symbol == symbols.0 || p.symbol == symbols.1);
    found.find_map(|parameter| parameter.value)
}

/// The name of a surface: that of its file.
fn name(surface: &EvaluatedSurface) -> String {
    file_name(&surface.file)
}
