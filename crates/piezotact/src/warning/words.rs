//! Text fragments shared by the sentences of warnings.

use crate::quantity::Band;

/// The number of entries of a list that are named.
const LISTED: usize = 4;

/// A share (0–1) in per cent: `12 %`.
///
/// Source: house rule.
#[must_use]
pub fn percent(share: f64) -> String {
    let p = share * 100.0;
    if p >= 1.0 || p <= 0.0 {
        format!("{p:.0} %")
    } else if p >= 0.01 {
        format!("{p:.2} %")
    } else {
        "less than 0.01 %".into()
    }
}

/// The first four of `bands`, and the number of the others.
pub(crate) fn bands(bands: &[Band]) -> String {
    let names: Vec<String> = bands.iter().map(ToString::to_string).collect();
    first_of(&names, ", ")
}

/// The first four of `names`, and the number of the others.
pub(crate) fn first_of(names: &[String], between: &str) -> String {
    let named = names.iter().take(LISTED).map(String::as_str);
    let named: Vec<&str> = named.collect();
    let more = match names.len().saturating_sub(LISTED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    named.join(between) + &more
}
