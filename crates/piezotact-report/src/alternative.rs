//! What a figure shows in one text, for who hears a page instead of seeing it.

use piezotact::figure::{Chart, Heatmap, Line, Maps, Panels, Scale, Spectrograms};

use piezotact::page::Table;

use crate::axis::number;

/// As many names stand in a text; of further ones their number.
const NAMES: usize = 12;

/// The quantities of a chart, its range and its lines.
pub(crate) fn chart(chart: &Chart) -> String {
    let title = match chart.title.as_str() {
        "" => String::new(),
        title => format!("{title}: "),
    };
    let (across, lines) = (over(chart), lines(chart));
    format!("{title}{} over {across}{lines}.", of(&chart.y.label))
}

/// The quantities of all charts, their common range and their lines.
pub(crate) fn panels(panels: &Panels) -> String {
    let each = panels.charts.iter().map(|chart| {
        let lines = lines(chart);
        format!("{}{lines}", of(&chart.y.label))
    });
    let across = panels.charts.first().map(over).unwrap_or_default();
    format!("Panels over {across}: {}.", listed(each, "; "))
}

/// The quantity of a map of heights and its size.
pub(crate) fn heatmap(map: &Heatmap) -> String {
    let (wide, high) = (number(map.size.0), number(map.size.1));
    let unit = &map.length_unit;
    format!("Map of {}, {wide} by {high} {unit}.", map.label)
}

/// What the rows and the columns of a matrix are, and how many.
pub(crate) fn matrix(
    what: &str,
    (row, rows): (&str, &[String]),
    (column, columns): (&str, &[String]),
) -> String {
    format!(
        "Matrix of {what}: {} rows ({row}: {}), {} columns ({column}: {}).",
        rows.len(),
        names(rows.iter()),
        columns.len(),
        names(columns.iter()),
    )
}

/// The quantity of spectrograms and their titles.
pub(crate) fn spectrograms(all: &Spectrograms) -> String {
    let titles = names(all.panels.iter().map(|panel| &panel.title));
    format!(
        "Spectrograms, PSD in dB re 1 {}, over time in s and frequency in Hz: {titles}.",
        all.unit
    )
}

/// The quantity of maps and their titles.
pub(crate) fn maps(all: &Maps) -> String {
    let titles = names(all.panels.iter().map(|panel| &panel.title));
    format!("Maps of {}: {titles}.", all.label)
}

/// The columns of a table.
pub(crate) fn table(table: &Table) -> String {
    let headings = table.columns.iter().map(|column| &column.heading);
    format!("Table: {}", names(headings))
}

fn of(label: &str) -> &str {
    match label {
        "" => "Values",
        label => label,
    }
}

fn over(chart: &Chart) -> String {
    let x = &chart.x;
    match &x.scale {
        Scale::Names(each) => format!("{} ({})", of(&x.label), names(each.iter())),
        Scale::Linear | Scale::Logarithmic => {
            let [low, high] = [x.low, x.high].map(number);
            format!("{}, from {low} to {high}", of(&x.label))
        }
    }
}

fn lines(chart: &Chart) -> String {
    let named = |line: &&Line| !line.label.is_empty();
    let named: Vec<&String> = (chart.lines.iter().filter(named))
        .map(|line| &line.label)
        .collect();
    match named.is_empty() {
        true => String::new(),
        false => format!(" (lines: {})", names(named.into_iter())),
    }
}

fn names<'n>(all: impl ExactSizeIterator<Item = &'n String>) -> String {
    let more = all.len().saturating_sub(NAMES);
    let shown = listed(all.take(NAMES).cloned(), ", ");
    match more {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

fn listed(all: impl Iterator<Item = String>, between: &str) -> String {
    all.collect::<Vec<_>>().join(between)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::figure::{Axis, Tone};

    #[test]
    fn a_chart_says_its_quantities_and_lines() {
        let line = |label: &str| Line::new(label, Tone::Main, vec![(0.0, 1.0)]);
        let shown = Chart::new(
            Axis::new("time, s", 0.0, 0.15),
            Axis::new("acceleration, m/s²", -1.0, 1.0),
            vec![line("target"), line(""), line("measured")],
        );
        let text = "acceleration, m/s² over time, s, from 0 to 0.15 (lines: target, measured).";
        assert_eq!(chart(&shown), text);
        let force = Chart::new(
            shown.x.clone(),
            Axis::new("force, N", 0.0, 1.0),
            vec![line("")],
        );
        assert_eq!(
            panels(&Panels::new(vec![force, shown])),
            "Panels over time, s, from 0 to 0.15: force, N; acceleration, m/s² (lines: target, measured)."
        );
    }

    #[test]
    fn many_names_are_counted() {
        let all: Vec<String> = (1..=14).map(|i| format!("S{i}")).collect();
        let text = names(all.iter());
        assert!(text.starts_with("S1, S2") && text.ends_with("S12 and 2 more"));
    }
}
