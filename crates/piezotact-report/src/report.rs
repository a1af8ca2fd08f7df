//! Renders reports (data of `piezotact::page`) as HTML, and their tables as CSV and text.

use maud::{Markup, html};
use piezotact::criterion::Outcome;
use piezotact::document::Words;
use piezotact::page::{Block, Cell, Fact, Number, Page, Section, Table};
use piezotact::warning::Merged;

use crate::chart::HEIGHT;
use crate::{DrawError, alternative, broad_document, document, figure, svg};

/// A page and a text hold tables up to this many columns; CSV holds any.
pub const MOST_COLUMNS: usize = 40;

/// A report as one HTML file, with warnings in `words`.
///
/// # Errors
/// [`DrawError`] for a figure without points, for a table too broad for a page, and for a row that has not as many cells as
/// the table has columns. Nothing is drawn then.
pub fn html(page: &Page, words: &dyn Words) -> Result<String, DrawError> {
    let filled = |section: &&Section| !section.blocks.is_empty();
    let sections: Vec<Markup> = (page.sections.iter().filter(filled))
        .map(|section| drawn_section(section, words))
        .collect::<Result<_, _>>()?;
    let body = html! {
        h1 { (page.title) }
        @if !page.origin.is_empty() { p.soft { (page.origin) } }
        @if let Some(simulated) = &page.simulated { p { strong { (simulated) } } }
        @for section in &sections { (section) }
        p.soft { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
    };
    let mut blocks = page.sections.iter().flat_map(|section| &section.blocks);
    let is_broad = blocks.any(|block| match block {
        Block::Beside { .. } => true,
        Block::Table(table) => table.columns.len() > 10,
        _ => false,
    });
    Ok(match is_broad {
        true => broad_document(&page.title, &body),
        false => document(&page.title, &body),
    })
}

/// A report as text for a terminal: what is simulated, its conclusions, its numbers and its first table.
///
/// # Errors
/// [`DrawError`] for a table that cannot be shown.
pub fn terminal(page: &Page) -> Result<String, DrawError> {
    let mut lines: Vec<String> = page.simulated.iter().cloned().collect();
    for block in page.blocks() {
        match block {
            Block::Conclusion { text, .. } => lines.push(text.clone()),
            Block::Numbers { numbers } => lines.extend(in_columns(numbers)),
            _ => {}
        }
    }
    if let Some(table) = page.first_table() {
        if !lines.is_empty() {
            lines.push(String::new());
        }
        lines.push(text(table)?);
    }
    Ok(lines.join("\n"))
}

/// Numbers as lines: values below each other, and what they are beside them.
fn in_columns(numbers: &[Number]) -> impl Iterator<Item = String> {
    let widest = numbers.iter().map(|number| number.value.chars().count());
    let width = widest.max().unwrap_or(0);
    numbers
        .iter()
        .map(move |number| format!("  {:<width$}  {}", number.value, number.name))
}

fn drawn_section(section: &Section, words: &dyn Words) -> Result<Markup, DrawError> {
    let drawn = drawn_blocks(&section.blocks, words)?;
    let outcome = section.blocks.iter().find_map(|block| match block {
        Block::Conclusion { outcome, .. } => *outcome,
        _ => None,
    });
    let class = outcome.map(|outcome| match outcome {
        Outcome::Met => "verdict",
        Outcome::NotMet => "verdict failed",
        Outcome::NotDecided => "verdict open",
    });
    Ok(html! {
        section class=[class] {
            @if !section.heading.is_empty() { h2 { (section.heading) } }
            @for block in &drawn { (block) }
        }
    })
}

fn drawn_block(block: &Block, words: &dyn Words) -> Result<Markup, DrawError> {
    Ok(match block {
        Block::Conclusion {
            text,
            outcome: Some(_),
        } => html! { p { strong { (text) } } },
        Block::Conclusion { text, .. } => html! { p.conclusion { (text) } },
        Block::Heading { text } => html! { h3 { (text) } },
        Block::Text { text } => html! { p { (text) } },
        Block::Note { text } => html! { p.soft { (text) } },
        Block::Numbers { numbers: all } => numbers(all),
        Block::Steps { steps } => html! { ol { @for step in steps { li { (step) } } } },
        Block::Table(table) => drawn_table(table)?,
        Block::Figure(shown) => figure(&svg(shown, HEIGHT)?, &shown.caption),
        Block::Warnings { warnings, .. } => drawn_warnings(warnings, words),
        Block::Facts { facts: all } => facts(all),
        Block::Beside { blocks } => {
            let drawn = drawn_blocks(blocks, words)?;
            html! { div.counterparts { @for block in &drawn { div { (block) } } } }
        }
        Block::Folded { summary, blocks } => {
            let drawn = drawn_blocks(blocks, words)?;
            html! { details { summary { (summary) } @for block in &drawn { (block) } } }
        }
    })
}

fn drawn_blocks(blocks: &[Block], words: &dyn Words) -> Result<Vec<Markup>, DrawError> {
    let blocks = blocks.iter();
    blocks.map(|block| drawn_block(block, words)).collect()
}

fn facts(all: &[Fact]) -> Markup {
    html! {
        div.wide tabindex="0" role="region" aria-label="Facts" {
            table.facts {
                @for fact in all {
                    tr {
                        th scope="row" { (fact.name) }
                        td {
                            (fact.value)
                            @if !fact.steps.is_empty() { ol { @for step in &fact.steps { li { (step) } } } }
                        }
                    }
                }
            }
        }
    }
}

fn numbers(all: &[Number]) -> Markup {
    html! {
        div.numbers {
            @for number in all { div { b { (number.value) } span { (number.name) } } }
        }
    }
}

/// Warnings as a list, or that there are none.
fn drawn_warnings(warnings: &[Merged], words: &dyn Words) -> Markup {
    html! {
        @if warnings.is_empty() {
            p.soft { "None: no value was limited, guessed or left out." }
        } @else {
            ul.warnings { @for warning in warnings { li { (words.merged(warning)) } } }
        }
    }
}

/// Whether all cells of a column are numbers, so that they are right-aligned.
fn is_numeric(table: &Table, column: usize) -> bool {
    let mut cells = table.rows.iter().map(|row| &row[column]);
    cells.all(|cell| !matches!(cell, Cell::Text(_) | Cell::Outcome(_)))
}

/// Refuses a table whose rows do not fit its columns.
fn require_even(table: &Table) -> Result<(), DrawError> {
    let columns = table.columns.len();
    if columns == 0 {
        return Err(DrawError::Drawing {
            reason: "a table has no column".to_owned(),
        });
    }
    match table.rows.iter().position(|row| row.len() != columns) {
        None => Ok(()),
        Some(row) => Err(DrawError::Drawing {
            reason: format!(
                "row {} of a table has {} cells for {columns} columns",
                row + 1,
                table.rows[row].len()
            ),
        }),
    }
}

/// Refuses a table that no page can hold.
fn require_narrow(table: &Table) -> Result<(), DrawError> {
    require_even(table)?;
    if table.columns.len() > MOST_COLUMNS {
        return Err(DrawError::TooManyColumns {
            most: MOST_COLUMNS,
            found: table.columns.len(),
        });
    }
    Ok(())
}

/// The whole number of a cell that a page rounds; nothing for other cells.
fn exact(cell: &Cell) -> Option<String> {
    let (Cell::Number(value) | Cell::Rounded { value, .. }) = cell else {
        return None;
    };
    value.is_finite().then(|| cell.whole())
}

/// A cell; what is not met stands out.
fn cell_text(cell: &Cell) -> Markup {
    match cell {
        Cell::Outcome(Outcome::NotMet) => html! { strong { (cell.text()) } },
        Cell::Outcome(Outcome::NotDecided) => html! { em { (cell.text()) } },
        _ => html! { (cell.text()) },
    }
}

pub(crate) fn drawn_table(table: &Table) -> Result<Markup, DrawError> {
    require_narrow(table)?;
    let class = |column| {
        Some(if is_numeric(table, column) {
            "n"
        } else {
            "text"
        })
    };
    // What is still read without scrolling at 1366 px.
    let is_tight = table.columns.len() > 7;
    Ok(html! {
        div.wide tabindex="0" role="region" aria-label=(alternative::table(table)) {
            table class=[is_tight.then_some("tight")] {
                tr { @for (i, column) in table.columns.iter().enumerate() { th class=[class(i)] scope="col" { (column.heading) } } }
                @for row in &table.rows {
                    tr { @for (i, cell) in row.iter().enumerate() { td class=[class(i)] data-value=[exact(cell)] { (cell_text(cell)) } } }
                }
            }
        }
    })
}

/// A table as CSV text: the columns' names, then one line for each row, numbers with all their digits.
///
/// # Errors
/// [`DrawError`] for a row that has not as many cells as the table has columns, and for a table without columns.
pub fn csv(table: &Table) -> Result<String, DrawError> {
    require_even(table)?;
    let failed = |error: &dyn std::fmt::Display| DrawError::Drawing {
        reason: error.to_string(),
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = table.columns.iter().map(|column| &column.name);
    writer.write_record(names).map_err(|e| failed(&e))?;
    for row in &table.rows {
        let cells = row.iter().map(Cell::whole);
        writer.write_record(cells).map_err(|e| failed(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| failed(&e))?;
    String::from_utf8(bytes).map_err(|e| failed(&e))
}

/// A table as text for a terminal: columns below each other, numbers to the right.
///
/// # Errors
/// As [`html()`].
pub fn text(table: &Table) -> Result<String, DrawError> {
    require_narrow(table)?;
    let heads = table.columns.iter().map(|column| column.heading.clone());
    let rows = table.rows.iter();
    let rows = rows.map(|row| row.iter().map(Cell::text).collect());
    let lines: Vec<Vec<String>> = std::iter::once(heads.collect()).chain(rows).collect();
    let widths: Vec<usize> = (0..table.columns.len())
        .map(|i| lines.iter().map(|line| line[i].chars().count()).max())
        .map(Option::unwrap_or_default)
        .collect();
    let line = |cells: &Vec<String>| {
        let cells = cells.iter().zip(&widths).enumerate();
        let cells = cells.map(|(i, (cell, width))| match is_numeric(table, i) {
            true => format!("{cell:>width$}"),
            false => format!("{cell:<width$}"),
        });
        let cells: Vec<String> = cells.collect();
        cells.join("  ").trim_end().to_owned()
    };
    let lines: Vec<String> = lines.iter().map(line).collect();
    Ok(lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::Warning;
    use piezotact::figure::{Axis, Chart, Line, Tone};
    use piezotact::page::Column;
    use piezotact::recording::{MissingChannel, RecordingWarning};

    struct Plain;

    impl Words for Plain {
        fn warning(&self, warning: &Warning) -> String {
            warning.code.to_string()
        }
    }

    fn table(columns: usize) -> Table {
        let mut table =
            Table::new((0..columns).map(|i| Column::new(&format!("c{i}"), &format!("c{i}_n"))));
        table.rows.push(vec![Cell::from(1.23456); columns]);
        table
    }

    fn chart(points: Vec<(f64, f64)>) -> Block {
        let line = Line::new("level", Tone::Main, points);
        let chart = Chart::new(
            Axis::new("x", 0.0, 2.0),
            Axis::new("y", 0.0, 2.0),
            vec![line],
        );
        Block::Figure(chart.captioned("what it shows"))
    }

    fn page(block: Block) -> Page {
        Page::new("A page <b>", "origin").section("Part", [block])
    }

    #[test]
    fn a_page_shows_every_block() {
        let page = page(chart(vec![(0.0, 1.0), (1.0, 2.0)]))
            .section(
                "",
                [
                    Block::Conclusion {
                        text: "a conclusion".into(),
                        outcome: Some(Outcome::NotDecided),
                    },
                    Block::Numbers {
                        numbers: vec![Number::new("3 dB", "the level")],
                    },
                    Block::Steps {
                        steps: vec!["a step".into()],
                    },
                    Block::Table(table(2)),
                    Block::Note {
                        text: "a note".into(),
                    },
                ],
            )
            .warnings(&[Warning::from(RecordingWarning::ChannelMissing {
                what: MissingChannel::Sliding,
            })]);
        let text = html(&page, &Plain).unwrap();
        for part in [
            "A page &lt;b&gt;",
            "<svg",
            "what it shows",
            "verdict open",
            "a conclusion",
            "3 dB",
            "a step",
            "1.23",
            "a note",
            "channel_missing",
        ] {
            assert!(text.contains(part), "no {part} in the page");
        }
        // A page may be served where no script runs.
        assert!(!text.contains("<script"));
    }

    #[test]
    fn what_cannot_be_drawn_is_named() {
        let refused = |block: Block| html(&page(block), &Plain).unwrap_err().to_string();
        let nothing = refused(chart(vec![]));
        assert!(nothing.contains("no point"), "{nothing}");
        let gaps = refused(chart(vec![(0.0, f64::NAN)]));
        assert!(gaps.contains("no point"), "{gaps}");
        let broad = refused(Block::Table(table(1000)));
        assert!(broad.contains("40") && broad.contains("1000"), "{broad}");
        let mut uneven = table(3);
        uneven.rows.push(vec![Cell::from(1.0)]);
        let uneven_text = refused(Block::Table(uneven.clone()));
        assert!(uneven_text.contains("row 2"), "{uneven_text}");
        assert!(csv(&uneven).is_err() && csv(&table(0)).is_err());
    }

    #[test]
    fn csv_has_all_columns_and_all_digits() {
        let text = csv(&table(1000)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert!(lines[0].starts_with("c0_n,") && lines[0].ends_with(",c999_n"));
        assert!(lines[1].starts_with("1.23456,"));
    }

    #[test]
    fn text_stands_in_columns() {
        let mut table = Table::new([Column::new("sample", "sample"), Column::new("rms", "rms")]);
        table.rows = vec![
            vec![Cell::from("S1"), Cell::from(1.5)],
            vec![Cell::from("long name"), Cell::from(None)],
        ];
        assert_eq!(
            text(&table).unwrap(),
            "sample      rms\nS1         1.50\nlong name     –"
        );
    }
}
