//! The figures and tables of a report as files of their own.

use crate::DrawError;
use crate::format::Format;

/// A figure of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FigurePart {
    /// Its name without ending: its number in the report, the heading above it, and where several figures have that heading, how its
    /// caption begins: `02-spectra`, `03-stroke-1-normal-force`.
    pub name: String,
    pub svg: String,
}

/// A table of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TablePart {
    /// Its name without ending: its number in the report and the heading above it, `01-criteria`.
    pub name: String,
    /// CSV text: one line of names, then one line for each row.
    pub csv: String,
}

/// How wide a figure is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Columns {
    /// One column of a journal: 85 mm.
    One,
    /// Two columns: 174 mm.
    Two,
}

impl Columns {
    /// The width in mm.
    #[must_use]
    pub fn width_mm(self) -> f64 {
        match self {
            Self::One => 85.0,
            Self::Two => 174.0,
        }
    }
}

/// The figures of the report `html`, in order, each as wide as `columns`, with their captions as descriptions.
#[must_use]
pub fn figures(html: &str, columns: Columns) -> Vec<FigurePart> {
    let mut found: Vec<(FigurePart, String)> = Vec::new();
    let (mut heading, mut rest) = (String::new(), html);
    while let Some((tag, inner, after)) = next(rest, &["h1", "h2", "h3", "figure"]) {
        rest = after;
        if tag != "figure" {
            heading = plain(inner);
            continue;
        }
        let Some(svg) = drawn_for(inner, columns) else {
            continue;
        };
        let caption = next(inner, &["figcaption"]).map_or("", |(_, caption, _)| caption);
        let caption = plain(caption);
        let figure = FigurePart {
            name: short(&heading),
            svg: alone(svg, &caption, columns),
        };
        found.push((figure, caption));
    }
    let headings: Vec<String> = found.iter().map(|(one, _)| one.name.clone()).collect();
    let named = found.into_iter().enumerate().map(|(i, (one, caption))| {
        let alike = headings.iter().filter(|other| **other == one.name).count();
        let begins = caption.split(['.', ':', ';', ',', '(']).next();
        let name = match begins {
            Some(begins) if alike > 1 && !begins.is_empty() => {
                format!("{:02}-{}-{}", i + 1, one.name, short(begins))
            }
            _ => format!("{:02}-{}", i + 1, one.name),
        };
        FigurePart { name, ..one }
    });
    named.collect()
}

/// Of the drawings in a figure the one for `columns`, or the only one.
fn drawn_for(figure: &str, columns: Columns) -> Option<&str> {
    let class = match columns {
        Columns::One => Format::NARROW.class,
        Columns::Two => Format::WIDE.class,
    };
    let (mut first, mut rest) = (None, figure);
    while let Some((_, _, after)) = next(rest, &["svg"]) {
        let svg = &rest[rest.find("<svg")?..rest.len() - after.len()];
        rest = after;
        if svg.split('>').next().is_some_and(|tag| tag.contains(class)) {
            return Some(svg);
        }
        first = first.or(Some(svg));
    }
    first
}

/// The tables of the report `html`, in order, as tidy CSV: one line of names, numbers with a point and a plain minus sign, and
/// nothing where nothing was measured. A cell that is rounded in the report has all its digits where the report knows them.
///
/// # Errors
/// [`DrawError`] where the CSV cannot be put together.
pub fn tables(html: &str) -> Result<Vec<TablePart>, DrawError> {
    let mut found = Vec::new();
    let (mut heading, mut rest) = (String::new(), html);
    while let Some((tag, inner, after)) = next(rest, &["h1", "h2", "h3", "table"]) {
        rest = after;
        if tag != "table" {
            heading = plain(inner);
            continue;
        }
        found.push(TablePart {
            name: format!("{:02}-{}", found.len() + 1, short(&heading)),
            csv: csv_of(inner)?,
        });
    }
    Ok(found)
}

/// The first element of `html` that is one of `tags`: its tag, what is in it, and what stands behind it. Elements of one kind do not
/// stand in each other.
fn next<'h, 't>(html: &'h str, tags: &[&'t str]) -> Option<(&'t str, &'h str, &'h str)> {
    let mut from = 0;
    while let Some(at) = html[from..].find('<') {
        let begin = from + at;
        let name = html[begin + 1..].split([' ', '>', '\n', '/']).next();
        if let Some(tag) = tags.iter().find(|tag| Some(**tag) == name) {
            let open = begin + html[begin..].find('>')? + 1;
            let close = format!("</{tag}>");
            let end = open + html[open..].find(&close)?;
            return Some((tag, &html[open..end], &html[end + close.len()..]));
        }
        from = begin + 1;
    }
    None
}

/// The text of HTML, without tags, in one line.
fn plain(html: &str) -> String {
    let mut text = String::new();
    let mut rest = html;
    while let Some((before, tag)) = rest.split_once('<') {
        text += before;
        // What stands in tags of its own is a word of its own.
        text.push(' ');
        rest = tag.split_once('>').map_or("", |(_, after)| after);
    }
    text += rest;
    let text = [
        ("&lt;", "<"),
        ("&gt;", ">"),
        ("&quot;", "\""),
        ("&amp;", "&"),
    ]
    .into_iter()
    .fold(text, |text, (escaped, sign)| text.replace(escaped, sign));
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A heading as part of the name of a file: small letters, digits and hyphens.
fn short(heading: &str) -> String {
    const MOST_LETTERS: usize = 40;
    let words = heading.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<String> = words
        .filter(|word| !word.is_empty())
        .map(str::to_ascii_lowercase)
        .collect();
    let mut name = String::new();
    for word in words {
        if name.len() + word.len() > MOST_LETTERS {
            break;
        }
        if !name.is_empty() {
            name.push('-');
        }
        name += &word;
    }
    if name.is_empty() {
        "report".into()
    } else {
        name
    }
}

/// A figure as a file of its own: with its size, and its caption as description.
fn alone(svg: &str, caption: &str, columns: Columns) -> String {
    let mut svg = svg.to_owned();
    let size = view_box(&svg).map(|[width, height]| {
        let width_mm = columns.width_mm();
        format!(
            " width=\"{width_mm}mm\" height=\"{:.2}mm\"",
            width_mm * height / width
        )
    });
    svg.insert_str("<svg".len(), &size.unwrap_or_default());
    if !svg.contains("xmlns=") {
        svg.insert_str("<svg".len(), " xmlns=\"http://www.w3.org/2000/svg\"");
    }
    let caption = caption.replace('&', "&amp;").replace('<', "&lt;");
    if let (Some(end), false) = (svg.find('>'), caption.is_empty()) {
        svg.insert_str(end + 1, &format!("<desc>{caption}</desc>"));
    }
    svg.push('\n');
    svg
}

/// Width and height of the view box.
fn view_box(svg: &str) -> Option<[f64; 2]> {
    let (_, rest) = svg.split_once("viewBox=\"")?;
    let numbers: Vec<f64> = rest
        .split('"')
        .next()?
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()
        .ok()?;
    match numbers[..] {
        [_, _, width, height] if width > 0.0 => Some([width, height]),
        _ => None,
    }
}

/// A cell of a table: whether it is a heading, its text, and over how many columns and rows it stands.
struct Drawn {
    heading: bool,
    text: String,
    columns: usize,
    rows: usize,
}

fn csv_of(table: &str) -> Result<String, DrawError> {
    let rows = in_numbers(laid_out(&cells(table)));
    let width = rows.iter().map(Vec::len).max().unwrap_or(0);
    // A table whose first row is no heading has headings in its first column: what, and its value.
    let headed = rows
        .first()
        .is_some_and(|row| row.iter().all(|(heading, _)| *heading));
    let failed = |error: &dyn std::fmt::Display| DrawError::Drawing {
        reason: error.to_string(),
    };
    let mut writer = csv::WriterBuilder::new()
        .flexible(true)
        .from_writer(Vec::new());
    if !headed {
        let names = (0..width).map(|i| match (i, width) {
            (0, _) => "item".to_owned(),
            (1, 2) => "value".to_owned(),
            (i, _) => format!("value_{i}"),
        });
        writer.write_record(names).map_err(|e| failed(&e))?;
    }
    for row in &rows {
        let texts = row.iter().map(|(_, text)| text.as_str());
        let missing = std::iter::repeat_n("", width - row.len());
        writer
            .write_record(texts.chain(missing))
            .map_err(|e| failed(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| failed(&e))?;
    String::from_utf8(bytes).map_err(|e| failed(&e))
}

/// `rows` with a column of its own for each deviation that a cell states behind ±.
fn in_numbers(rows: Vec<Row>) -> Vec<Row> {
    const SIGN: &str = " ± ";
    let stated = |row: &Row, i: usize| row.get(i).is_some_and(|(_, text)| text.contains(SIGN));
    let width = rows.iter().map(Vec::len).max().unwrap_or(0);
    let deviating: Vec<bool> = (0..width)
        .map(|i| rows.iter().any(|row| stated(row, i)))
        .collect();
    let row = |row: Row| {
        let cells = row.into_iter().enumerate();
        let cells = cells.flat_map(|(i, (heading, text))| {
            let (value, deviation) = match text.split_once(SIGN) {
                Some((value, deviation)) => (value.to_owned(), deviation.to_owned()),
                None if heading => (text.clone(), format!("{text}, ±")),
                None => (text, String::new()),
            };
            let deviation = deviating[i].then_some((heading, deviation));
            [Some((heading, value)), deviation]
        });
        cells.flatten().collect()
    };
    rows.into_iter().map(row).collect()
}

/// The cells of a row: whether each is a heading, and its text.
type Row = Vec<(bool, String)>;

/// The rows of a table.
fn cells(table: &str) -> Vec<Vec<Drawn>> {
    let mut rows = Vec::new();
    let mut rest = table;
    while let Some((_, row, after)) = next(rest, &["tr"]) {
        rest = after;
        let (mut found, mut left) = (Vec::new(), row);
        while let Some((tag, inner, behind)) = next(left, &["th", "td"]) {
            // The tag itself stands before what is in it.
            let before = &left[..left.len() - behind.len() - inner.len() - "</td>".len()];
            let open = &before[before.rfind('<').unwrap_or(0)..];
            let attribute = |name: &str| {
                let (_, value) = open.split_once(&format!(" {name}=\""))?;
                value.split('"').next()
            };
            let span = |name: &str| attribute(name).and_then(|n| n.parse().ok()).unwrap_or(1);
            found.push(Drawn {
                heading: tag == "th",
                text: attribute("data-value").map_or_else(|| number(&plain(inner)), plain),
                columns: span("colspan"),
                rows: span("rowspan"),
            });
            left = behind;
        }
        rows.push(found);
    }
    rows
}

/// Rows with every cell in its column: one that stands over several columns or rows is repeated.
fn laid_out(drawn: &[Vec<Drawn>]) -> Vec<Row> {
    let mut rows: Vec<Vec<Option<(bool, String)>>> = vec![Vec::new(); drawn.len()];
    for (i, cells) in drawn.iter().enumerate() {
        let mut column = 0;
        for cell in cells {
            while rows[i].get(column).is_some_and(Option::is_some) {
                column += 1;
            }
            let last = (i + cell.rows.max(1)).min(rows.len());
            for row in &mut rows[i..last] {
                let end = column + cell.columns.max(1);
                row.resize(row.len().max(end), None);
                row[column..end].fill(Some((cell.heading, cell.text.clone())));
            }
            column += cell.columns.max(1);
        }
    }
    let whole = |row: Vec<Option<(bool, String)>>| row.into_iter().map(Option::unwrap_or_default);
    rows.into_iter().map(|row| whole(row).collect()).collect()
}

/// A number for a program: with a plain minus sign; nothing for a dash.
fn number(text: &str) -> String {
    let plain = text.replace('−', "-").replace('\u{a0}', " ");
    match plain.as_str() {
        "–" | "—" => String::new(),
        _ => plain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPORT: &str = "<h1>Score of S4 &amp; S8</h1><section><h2>Spectra, re 1 (m/s²)²</h2>\
        <figure><svg role=\"img\" viewBox=\"0 0 900 300\"><text>1 &lt; 2</text></svg><figcaption>What <b>it</b> shows</figcaption></figure>\
        <div class=\"wide\"><table class=\"x\"><tr><th>band</th><th class=\"n\" colspan=\"2\">level</th></tr>\
        <tr><td rowspan=\"2\">low</td><td class=\"n\" data-value=\"-1.23456\">−1.23</td><td>–</td></tr>\
        <tr><td>−3 dB</td><td>a, \"b\"</td></tr></table></div></section>\
        <section><h2></h2><table><tr><th>bench</th><td>twin</td></tr></table></section>";

    #[test]
    fn figures_are_files_with_their_size_and_caption() {
        let found = figures(REPORT, Columns::Two);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].name, "01-spectra-re-1-m-s");
        assert_eq!(
            found[0].svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"174mm\" height=\"58.00mm\" role=\"img\" viewBox=\"0 0 900 300\">\
             <desc>What it shows</desc><text>1 &lt; 2</text></svg>\n"
        );
        assert!(
            figures(REPORT, Columns::One)[0]
                .svg
                .contains("width=\"85mm\" height=\"28.33mm\"")
        );
    }

    #[test]
    fn figures_under_one_heading_have_names_of_what_they_show() {
        let figure = |caption: &str| {
            format!("<figure><svg></svg><figcaption>{caption}</figcaption></figure>")
        };
        let [level, drift] = ["Level of each part, above 10 Hz.", "Drift: means."].map(figure);
        let html = format!("<h2>Rest</h2>{level}{drift}<h2>Spectrum</h2>{level}");
        let names = figures(&html, Columns::Two);
        let names: Vec<&str> = names.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(
            names,
            ["01-rest-level-of-each-part", "02-rest-drift", "03-spectrum"]
        );
    }

    #[test]
    fn tables_are_tidy() {
        let found = tables(REPORT).unwrap();
        assert_eq!(found[0].name, "01-spectra-re-1-m-s");
        assert_eq!(
            found[0].csv,
            "band,level,level\nlow,-1.23456,\nlow,-3 dB,\"a, \"\"b\"\"\"\n"
        );
        assert_eq!(
            (found[1].name.as_str(), found[1].csv.as_str()),
            ("02-report", "item,value\nbench,twin\n")
        );
    }

    #[test]
    fn a_deviation_has_a_column_of_its_own() {
        let table = "<table><tr><th>group</th><th>rms</th></tr><tr><td>S4</td><td>1.90 ± 0.20</td></tr>\
             <tr><td>S8</td><td>–</td></tr></table>";
        let found = tables(table).unwrap();
        assert_eq!(found[0].csv, "group,rms,\"rms, ±\"\nS4,1.90,0.20\nS8,,\n");
    }

    #[test]
    fn what_is_cut_short_gives_what_is_whole() {
        for end in (0..REPORT.len()).filter(|end| REPORT.is_char_boundary(*end)) {
            assert!(figures(&REPORT[..end], Columns::One).len() <= 1);
            assert!(tables(&REPORT[..end]).unwrap().len() <= 2);
        }
    }
}
