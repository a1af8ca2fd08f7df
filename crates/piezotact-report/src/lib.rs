//! Documents drawn: figures as SVG, pages as HTML. It computes nothing, touches no file and knows no command line.

mod axis;
pub mod chart;
pub mod heatmap;
mod image;
mod page;
pub mod spectrogram;

use piezotact::figure::{Chart, Drawn, Figure};

pub use page::{broad_document, document, figure};

/// A figure that could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a figure could not be drawn: {reason}")]
pub struct DrawError {
    /// What the drawing library says.
    pub reason: String,
}

/// A figure as SVG text that takes the width there is; `height` is that of a chart.
///
/// # Errors
/// [`DrawError`] where it cannot be drawn.
pub fn svg(figure: &Figure, height: u32) -> Result<String, DrawError> {
    match &figure.drawn {
        Drawn::Chart(chart) => chart::svg(chart, height),
        Drawn::Heatmap(map) => heatmap::svg(map),
        Drawn::Spectrograms(all) => spectrogram::svg(all),
    }
}

/// What can be drawn with a height.
pub trait Draw {
    /// The drawing as SVG text that takes the width there is.
    ///
    /// # Errors
    /// [`DrawError`] where it cannot be drawn.
    fn svg(&self, height: u32) -> Result<String, DrawError>;
}

impl Draw for Chart {
    fn svg(&self, height: u32) -> Result<String, DrawError> {
        chart::svg(self, height)
    }
}
