//! Reports: one HTML file that holds everything it shows.

pub(crate) mod axis;
pub(crate) mod chart;
pub(crate) mod figures;
pub(crate) mod heatmap;
mod image;
pub(crate) mod manipulate;
pub(crate) mod panel;
pub(crate) mod replay;
pub(crate) mod roughness;
pub(crate) mod score;
pub(crate) mod spectrogram;
pub(crate) mod touch;
pub(crate) mod transfer;
pub(crate) mod verify;

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A file's name without its folder.
pub(crate) fn name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// A page of HTML that holds everything it shows.
pub(crate) fn document(title: &str, body: &Markup) -> String {
    page_of(title, None, body)
}

/// The same, as wide as two figures side by side where the screen is.
pub(crate) fn broad_document(title: &str, body: &Markup) -> String {
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

pub(crate) fn figure(svg: &str, caption: &str) -> Markup {
    html! { figure { (PreEscaped(svg)) figcaption { (caption) } } }
}
