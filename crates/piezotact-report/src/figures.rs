//! Figures that are files of their own.

use piezotact::figure::{Axis, Chart, Line, Tone, range};
use piezotact::quantity::Decibels;

use crate::DrawError;
use crate::chart::{self, HEIGHT};

/// The PSD of one channel, as a file of its own: `title` says what it is and how it was estimated.
///
/// # Errors
/// [`DrawError`] where it cannot be drawn.
pub fn psd(
    title: &str,
    unit: &str,
    frequencies_hz: &[f64],
    values: &[f64],
) -> Result<String, DrawError> {
    let lines = frequencies_hz.iter().zip(values).skip(1);
    let points: Vec<_> = lines
        .map(|(hz, power)| (*hz, Decibels::from_power(*power).0))
        .collect();
    let last = frequencies_hz[frequencies_hz.len() - 1];
    let (low, high) = range(&[&points], 0.0, last, 10.0, 120.0);
    let chart = Chart {
        title: title.into(),
        ..Chart::new(
            Axis::log("frequency, Hz", frequencies_hz[1], last),
            Axis::new(format!("PSD, dB re 1 {unit}"), low, high),
            vec![Line::new("", Tone::Main, points)],
        )
    };
    chart::file(&chart, HEIGHT + 120)
}
