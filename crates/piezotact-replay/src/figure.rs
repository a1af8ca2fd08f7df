//! Figures as data: what is drawn, by whoever draws.

use piezotact::Series;
use piezotact::quantity::Acceleration;

/// The counterpart of a figure of the thesis.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Its number in the thesis, such as `38a`.
    pub number: &'static str,
    /// What it shows.
    pub caption: String,
    /// What is drawn.
    pub shown: Shown,
}

/// What is drawn.
#[derive(Clone, Debug)]
pub enum Shown {
    /// Lines in one frame.
    Lines {
        /// Across.
        x: Axis,
        /// Up.
        y: Axis,
        /// The lines.
        lines: Vec<Line>,
    },
    /// Spectrograms with one scale of colours, each with its title.
    Spectrograms(Vec<(String, Series<Acceleration>)>),
}

/// One axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The quantity with its unit.
    pub label: String,
    /// How it is divided.
    pub scale: Scale,
}

/// How an axis is divided.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By ratios.
    Logarithmic,
    /// Whole numbers from 0 stand for names.
    Names(Vec<String>),
}

/// One line.
#[derive(Clone, Debug)]
pub struct Line {
    /// What it is; empty for one among many.
    pub label: String,
    /// Its points.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub mark: Mark,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A thin line, one among many.
    Thin,
    /// A line.
    Line,
    /// A dashed line.
    Dashed,
    /// Dots joined by a line.
    Joined,
    /// Dots.
    Dots,
}

impl Axis {
    pub(super) fn linear(label: &str) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Linear,
        }
    }

    pub(super) fn log(label: &str) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Logarithmic,
        }
    }

    pub(super) fn names(label: &str, names: impl Iterator<Item = String>) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Names(names.collect()),
        }
    }
}

impl Line {
    pub(super) fn new(label: impl Into<String>, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        Self {
            label: label.into(),
            points,
            mark,
        }
    }

    /// A line of `values` over whole numbers from 0.
    pub(super) fn over_names(label: &str, values: impl Iterator<Item = f64>) -> Self {
        Self::new(
            label,
            Mark::Joined,
            values.enumerate().map(|(i, v)| (i as f64, v)).collect(),
        )
    }
}

/// A PSD in dB between two frequencies.
pub(super) fn decibels(
    psd: &[f64],
    resolution_hz: f64,
    from_hz: f64,
    to_hz: f64,
) -> Vec<(f64, f64)> {
    psd.iter()
        .enumerate()
        .map(|(k, value)| (k as f64 * resolution_hz, *value))
        .filter(|(hz, value)| (from_hz..=to_hz).contains(hz) && *value > 0.0)
        .map(|(hz, value)| (hz, 10.0 * value.log10()))
        .collect()
}

/// Frequency across.
pub(super) fn frequency() -> Axis {
    Axis::linear("frequency, Hz")
}

/// A PSD of acceleration up.
pub(super) fn density() -> Axis {
    Axis::linear("PSD, dB re 1 (m/s²)²/Hz")
}
