//! Pages: self-contained HTML files.

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A self-contained HTML page.
#[must_use]
pub fn document(title: &str, body: &Markup) -> String {
    page_of(title, None, body)
}

/// The same, as wide as two figures side by side where the screen is.
#[must_use]
pub fn broad_document(title: &str, body: &Markup) -> String {
    page_of(title, Some("broad"), body)
}

fn page_of(title: &str, class: Option<&str>, body: &Markup) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body class=[class] { main { (body) } }
        }
    };
    markup.into_string()
}

/// A figure with its caption in a page; `svg` is SVG text.
#[must_use]
pub fn figure(svg: &str, caption: &str) -> Markup {
    html! { figure { (PreEscaped(svg)) figcaption { (caption) } } }
}

/// The name of a file without its folder.
pub fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}
