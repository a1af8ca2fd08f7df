//! Renders documents: figures as SVG, pages as HTML. It computes nothing, touches no file and knows no command line.

mod alternative;
mod axis;
mod bars;
pub mod chart;
mod colour;
pub mod criteria;
mod format;
mod grid;
pub mod heatmap;
mod image;
pub mod invocation;
mod legend;
mod maps;
pub mod origin;
mod page;
pub mod parts;
pub mod report;
pub mod spectrogram;
mod stacked;

use piezotact::figure::{Chart, Drawn, Figure, Panels};

pub use page::{broad_document, document, figure, file_name};

/// A figure, a table or a report that could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DrawError {
    /// The drawing library failed.
    #[error("a figure or table could not be drawn: {reason}")]
    Drawing {
        /// What the drawing library says.
        reason: String,
    },
    /// A figure holds nothing.
    #[error(
        "a figure could not be drawn: expected a point with finite coordinates, found no point ({caption}); give data that has some"
    )]
    NoPoint {
        /// The text below the figure.
        caption: String,
    },
    /// A table is too broad for a page.
    #[error(
        "a table could not be drawn: expected at most {most} columns, found {found}; write it as CSV"
    )]
    TooManyColumns {
        /// The largest number of columns.
        most: usize,
        /// How many there are.
        found: usize,
    },
}

/// A figure as SVG text that takes the width there is; `height` is that of a chart.
///
/// # Errors
/// [`DrawError`] where it cannot be drawn, and for a figure without a point.
pub fn svg(figure: &Figure, height: u32) -> Result<String, DrawError> {
    if !has_a_point(&figure.drawn) {
        return Err(DrawError::NoPoint {
            caption: figure.caption.clone(),
        });
    }
    match &figure.drawn {
        Drawn::Chart(chart) => chart::svg(chart, height),
        Drawn::Panels(panels) => stacked::svg(panels, height),
        Drawn::Heatmap(map) => heatmap::svg(map),
        Drawn::Matrix(matrix) => Ok(grid::Grid(matrix).svg()),
        Drawn::Bars(matrix) => Ok(bars::svg(matrix)),
        Drawn::Spectrograms(all) => spectrogram::svg(all),
        Drawn::Maps(all) => maps::svg(all),
    }
}

/// Whether the figure shows at least one point.
fn has_a_point(drawn: &Drawn) -> bool {
    let plotted = |chart: &Chart| {
        let mut points = chart.lines.iter().flat_map(|line| &line.points);
        points.any(|(x, y)| x.is_finite() && y.is_finite())
    };
    match drawn {
        Drawn::Chart(chart) => plotted(chart),
        Drawn::Panels(panels) => panels.charts.iter().any(plotted),
        Drawn::Heatmap(map) => map.values.iter().any(|value| value.is_finite()),
        Drawn::Matrix(matrix) | Drawn::Bars(matrix) => {
            matrix.squares.iter().any(|row| !row.is_empty())
        }
        Drawn::Spectrograms(all) => !all.panels.is_empty(),
        Drawn::Maps(all) => {
            let mut values = all.panels.iter().flat_map(|panel| &panel.values);
            values.any(|value| value.is_finite())
        }
    }
}

/// A figure that can be drawn with a given height.
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

impl Draw for Panels {
    fn svg(&self, height: u32) -> Result<String, DrawError> {
        stacked::svg(self, height)
    }
}
