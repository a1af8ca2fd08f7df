//! A nail-to-skin map as a table: a column of frequencies and one of the ratio of the skin's acceleration to the nail's.
//!
//! ```text
//! frequency (Hz),skin over nail (dB)
//! 50,-3.5
//! 200,-9.0
//! ```

use std::path::Path;

use piezotact::discrimination::ContactMap;

use crate::error::ReadError;

/// The nail-to-skin map in a CSV file: two columns, frequency in Hz and skin over nail, in dB where the header of the second says
/// dB, and as a ratio of amplitudes where it says `ratio`. Lines that begin with # are remarks.
///
/// # Errors
/// [`ReadError`] naming the file and the line, what was expected and what was found.
pub fn read_contact_map(path: &Path) -> Result<ContactMap, ReadError> {
    let bytes = crate::reads::read(path).map_err(|error| ReadError::io(path, &error))?;
    let text = String::from_utf8_lossy(&bytes);
    let mut rows = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let wrong = |found: String| {
        ReadError::content(
            path,
            "a nail-to-skin map: a header such as `frequency (Hz),skin over nail (dB)` or `frequency (Hz),ratio`, and two \
                 numbers per row",
            found,
            "write one row for each frequency, lowest first",
        )
    };
    let mut points = Vec::new();
    let mut in_db = None;
    for (i, row) in rows.records().enumerate() {
        let row = row.map_err(|error| wrong(error.to_string()))?;
        let cells: Vec<&str> = row.iter().collect();
        let [first, second] = cells[..] else {
            return Err(wrong(format!("{} columns in row {}", cells.len(), i + 1)));
        };
        let Some(db) = in_db else {
            let says = second.to_lowercase();
            in_db = Some(match (says.contains("db"), says.contains("ratio")) {
                (true, _) => true,
                (false, true) => false,
                _ => return Err(wrong(format!("the header `{first},{second}`"))),
            });
            continue;
        };
        let (Ok(frequency_hz), Ok(value)) = (first.parse::<f64>(), second.parse::<f64>()) else {
            return Err(wrong(format!("`{first},{second}` in row {}", i + 1)));
        };
        points.push((frequency_hz, if db { value } else { 20.0 * value.log10() }));
    }
    ContactMap::new(&points, &path.display().to_string()).map_err(|error| {
        ReadError::content(
            path,
            "a nail-to-skin map",
            "invalid values",
            error.to_string(),
        )
    })
}
