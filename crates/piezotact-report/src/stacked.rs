//! Charts below each other over one axis, as one figure: their plots begin and end at the same places.

use piezotact::figure::Panels;

use crate::DrawError;
use crate::alternative;
use crate::chart::{Below, FINE, Plot};
use crate::format::{Format, both};

/// Charts below each other in both formats, as SVG text that takes the width there is: the first is 4/5 of `height` high, the
/// others are 3/5.
///
/// # Errors
/// [`DrawError`] where the plotting library refuses it.
pub(crate) fn svg(panels: &Panels, height: u32) -> Result<String, DrawError> {
    both(&alternative::panels(panels), |format| {
        stacked(panels, format, height)
    })
}

/// Charts below each other: what stands left and right of every plot is as wide as the widest needs.
fn stacked(panels: &Panels, format: Format, height: u32) -> Result<String, DrawError> {
    let charts = panels.charts.iter().enumerate();
    let plots: Vec<Plot<'_>> = charts
        .map(|(i, chart)| {
            let share = if i == 0 { 4 } else { 3 };
            Plot::new(chart, format, height * share / 5)
        })
        .collect();
    // Labels of y stand in one place.
    let plots: Vec<Plot<'_>> = match plots.iter().any(Plot::is_labelled_above) {
        true => plots.into_iter().map(Plot::labelled_above).collect(),
        false => plots,
    };
    let left = plots.iter().map(|plot| plot.left).max().unwrap_or(0);
    let beside = plots.iter().map(|plot| plot.beside).max().unwrap_or(0);
    let last = plots.len().saturating_sub(1);
    let (mut drawn, mut top) = (String::new(), 0);
    for (i, plot) in plots.into_iter().enumerate() {
        let below = if i == last { Below::Axis } else { Below::Marks };
        let plot = plot.framed(left, beside, below);
        let svg = plot.svg()?;
        let begin = svg.find('>').map_or(0, |end| end + 1);
        let end = svg.rfind("</svg>").unwrap_or(svg.len());
        let shift = top * FINE;
        drawn += &format!(
            "\n<g transform=\"translate(0 {shift})\">{}</g>",
            &svg[begin..end]
        );
        top += plot.height();
    }
    let (width, height) = (format.width * FINE, top * FINE);
    Ok(format!(
        "<svg role=\"img\" viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\">{drawn}\n</svg>\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::figure::{Axis, Chart, Line, Tone};

    /// Left and right ends of the frames of plots: horizontal lines of the mesh begin and end there.
    #[test]
    fn panels_are_aligned_and_share_one_axis() {
        let chart = |label: &str, high: f64, lines: usize| {
            let line = |i: usize| {
                Line::new(
                    format!("line {i}"),
                    Tone::Main,
                    vec![(0.0, 0.0), (1.0, high)],
                )
            };
            Chart::new(
                Axis::new("time, s", 0.0, 1.0),
                Axis::new(label, 0.0, high),
                (0..lines).map(line).collect(),
            )
        };
        let both = Panels::new(vec![
            chart("force, N", 1.0, 1),
            chart("a, m/s²", 90000.0, 9),
        ]);
        for format in [Format::WIDE, Format::NARROW] {
            let svg = stacked(&both, format, 300).unwrap();
            assert_eq!(svg.matches("<svg").count(), 1);
            assert_eq!(svg.matches("\ntime, s\n").count(), 1);
            // The last point of each diagonal stands at the right end of its plot.
            let ends: Vec<&str> = svg
                .split("points=\"")
                .skip(1)
                .filter_map(|points| points.split('"').next())
                .filter_map(|points| points.split_whitespace().last())
                .filter_map(|point| point.split(',').next())
                .collect();
            let right = |part: &str| ends.iter().filter(|end| **end == part).count();
            let last = ends.last().unwrap();
            assert!(right(last) >= 10, "{ends:?}");
        }
    }
}
