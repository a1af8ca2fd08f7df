//! An address as a picture that a camera reads.

use maud::{Markup, html};
use qrcode::{Color, QrCode};

/// White around the code, in modules; readers need four.
const QUIET: usize = 4;

/// `text` as a QR code with the description `label`; nothing where it is too long for one.
pub(crate) fn picture(text: &str, label: &str) -> Markup {
    let Ok(code) = QrCode::new(text) else {
        return html! {};
    };
    let width = code.width();
    let dark = code.to_colors().into_iter().enumerate();
    let dark = dark.filter(|(_, color)| *color == Color::Dark);
    let path: String = dark
        .map(|(i, _)| format!("M{} {}h1v1h-1z", QUIET + i % width, QUIET + i / width))
        .collect();
    let side = width + 2 * QUIET;
    html! {
        svg.qr viewBox=(format!("0 0 {side} {side}")) role="img" aria-label=(label) shape-rendering="crispEdges" {
            rect width=(side) height=(side) fill="#fff" {}
            path d=(path) fill="#000" {}
        }
    }
}
