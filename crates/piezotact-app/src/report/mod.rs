//! Reports: one HTML file that holds everything it shows.

pub(crate) mod axis;
pub(crate) mod chart;
mod criteria;
pub(crate) mod figures;
pub(crate) mod heatmap;
mod image;
pub(crate) mod manipulate;
pub(crate) mod panel;
pub(crate) mod rendering;
pub(crate) mod replay;
pub(crate) mod roughness;
pub(crate) mod score;
pub(crate) mod spectrogram;
pub(crate) mod touch;
pub(crate) mod transfer;
pub(crate) mod verify;

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use piezotact::recording::BenchKind;

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

/// What stands in a report of something that does not say which bench it comes from.
const UNKNOWN_BENCH: &str = "The measurement does not say which bench it comes from.";

/// What a report says of the bench that a measurement comes from.
fn bench_told(bench: Option<BenchKind>) -> Option<&'static str> {
    bench.map(|kind| match kind {
        BenchKind::Twin => "Digital twin: no hardware and no person took part.",
        BenchKind::Hardware => "Measured on hardware.",
        BenchKind::Measured => {
            "Played through a measured transfer function: no finger was touched."
        }
        BenchKind::Scripted => "Scripted fake of a bench: no device and no finger, for tests only.",
    })
}

pub(crate) fn figure(svg: &str, caption: &str) -> Markup {
    html! { figure { (PreEscaped(svg)) figcaption { (caption) } } }
}
