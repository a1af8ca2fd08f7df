//! The table at the end of a report: where its data come from, and which program wrote it.

use std::fmt::Display;

use maud::{Markup, Render, html};

/// A section called `heading` with a table of `rows`, the program last.
#[must_use]
pub fn section(heading: &str, rows: &Markup) -> Markup {
    html! {
        section {
            h2 { (heading) }
            table {
                (rows)
                (row("program", &concat!("piezotact ", env!("CARGO_PKG_VERSION"))))
            }
        }
    }
}

/// A row: what, and its value.
pub fn row(what: &str, value: &dyn Render) -> Markup {
    html! { tr { th { (what) } td { (value) } } }
}

/// What was done, step by step.
pub fn steps(done: &[impl Display]) -> Markup {
    html! { ol { @for step in done { li { (step.to_string()) } } } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_ends_with_the_program() {
        let rows = html! { (row("bench", &"S8 & S4")) (row("texture", &steps(&["cut", "gain"]))) };
        let found = section("Origin of the data", &rows).into_string();
        let version = env!("CARGO_PKG_VERSION");
        let expected = format!(
            "<section><h2>Origin of the data</h2><table><tr><th>bench</th><td>S8 &amp; S4</td></tr>\
             <tr><th>texture</th><td><ol><li>cut</li><li>gain</li></ol></td></tr>\
             <tr><th>program</th><td>piezotact {version}</td></tr></table></section>"
        );
        assert_eq!(found, expected);
    }
}
