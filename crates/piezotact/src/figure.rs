//! Figures as data: curves, maps and spectrograms with their axes. Whoever draws them computes nothing.
//!
//! A value that can be shown makes a [`Figure`]; `piezotact-report` draws it as SVG. Colours are named by what they stand for
//! ([`Tone`]), so that one quantity has one colour in all figures.

use serde::{Deserialize, Deserializer, Serialize};

/// A figure and the text below it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Figure {
    /// What is drawn.
    pub drawn: Drawn,
    /// What it shows, how it was computed, and what the marks mean.
    pub caption: String,
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Drawn {
    /// Curves and points between two axes.
    Chart(Chart),
    /// Charts below each other, over one axis.
    Panels(Panels),
    /// Values on a grid as colours.
    Heatmap(Heatmap),
    /// Squares with the names of rows and columns.
    Matrix(Matrix),
    /// The percentages of a matrix as bars on a plane; outlined squares have bars of another colour.
    Bars(Matrix),
    /// Spectrograms with one scale of colours.
    Spectrograms(Spectrograms),
    /// Changes around 0 on maps with one scale of colours.
    Maps(Maps),
}

/// Curves and points between two axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Chart {
    /// Above it, where it stands alone; empty below a heading.
    pub title: String,
    /// Across.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// The lines, later ones above earlier ones.
    pub lines: Vec<Line>,
    /// Ranges of x that are shaded.
    pub shaded: Vec<(f64, f64)>,
    /// Ranges of x that are shaded in red: what was rejected.
    pub rejected: Vec<(f64, f64)>,
    /// Horizontal lines, in the unit of y: limits.
    pub levels: Vec<f64>,
    /// Texts beside points: x, y, text.
    pub notes: Vec<(f64, f64, String)>,
    /// Where the legend stands; that of many lines is beside the chart wherever there is room.
    pub legend: Legend,
}

impl Chart {
    /// A chart of `lines` without marks, its legend above it.
    #[must_use]
    pub fn new(x: Axis, y: Axis, lines: Vec<Line>) -> Self {
        Self {
            title: String::new(),
            x,
            y,
            lines,
            shaded: Vec::new(),
            rejected: Vec::new(),
            levels: Vec::new(),
            notes: Vec::new(),
            legend: Legend::Above,
        }
    }

    /// The same with its legend beside it, however few lines there are.
    #[must_use]
    pub fn beside(self) -> Self {
        Self {
            legend: Legend::Beside,
            ..self
        }
    }

    /// The figure of this chart.
    #[must_use]
    pub fn captioned(self, caption: impl Into<String>) -> Figure {
        Figure {
            drawn: Drawn::Chart(self),
            caption: caption.into(),
        }
    }
}

/// Charts below each other over one axis x, which stands below the last: their plots begin and end at the same places.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Panels {
    /// The charts from the top, all with the same x.
    pub charts: Vec<Chart>,
}

impl Panels {
    /// `charts` over the x of the first.
    #[must_use]
    pub fn new(mut charts: Vec<Chart>) -> Self {
        if let Some(x) = charts.first().map(|chart| chart.x.clone()) {
            for chart in &mut charts {
                chart.x = x.clone();
            }
        }
        Self { charts }
    }

    /// The figure of these charts.
    #[must_use]
    pub fn captioned(self, caption: impl Into<String>) -> Figure {
        Figure {
            drawn: Drawn::Panels(self),
            caption: caption.into(),
        }
    }
}

/// Where a legend stands: it covers nothing that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Legend {
    /// Above the chart.
    Above,
    /// To its right, however few lines there are.
    Beside,
}

/// A line, or points, of a chart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Line {
    /// What it is in the legend; empty for one among many.
    pub label: String,
    /// Its colour.
    pub tone: Tone,
    /// How thick it is.
    pub weight: Weight,
    /// How its points are drawn.
    pub mark: Mark,
    /// x and y of its points.
    pub points: Vec<(f64, f64)>,
    /// Bars: x, and from where to where the value is spread.
    pub spread: Vec<(f64, f64, f64)>,
    /// The same as an area behind the line.
    #[serde(deserialize_with = "area")]
    pub ribbon: Vec<(f64, f64, f64)>,
}

/// JSON has no infinity: an end of an area that it lacks has no limit.
fn area<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<(f64, f64, f64)>, D::Error> {
    let all = Vec::<(f64, Option<f64>, Option<f64>)>::deserialize(from)?;
    let ends = all.into_iter().map(|(x, low, high)| {
        let (low, high) = (
            low.unwrap_or(f64::NEG_INFINITY),
            high.unwrap_or(f64::INFINITY),
        );
        (x, low, high)
    });
    Ok(ends.collect())
}

impl Line {
    /// A line through `points`, of usual weight.
    #[must_use]
    pub fn new(label: impl Into<String>, tone: Tone, points: Vec<(f64, f64)>) -> Self {
        Self {
            label: label.into(),
            tone,
            weight: Weight::Usual,
            mark: Mark::Line,
            points,
            spread: Vec::new(),
            ribbon: Vec::new(),
        }
    }

    /// The same, thick.
    #[must_use]
    pub fn thick(mut self) -> Self {
        self.weight = Weight::Thick;
        self
    }

    /// The same, thin.
    #[must_use]
    pub fn thin(mut self) -> Self {
        self.weight = Weight::Thin;
        self
    }

    /// The same with its points drawn as `mark`.
    #[must_use]
    pub fn marked(mut self, mark: Mark) -> Self {
        self.mark = mark;
        self
    }

    /// The same with an area behind it.
    #[must_use]
    pub fn ribbon(mut self, ribbon: Vec<(f64, f64, f64)>) -> Self {
        self.ribbon = ribbon;
        self
    }

    /// The same with bars.
    #[must_use]
    pub fn spread(mut self, spread: Vec<(f64, f64, f64)>) -> Self {
        self.spread = spread;
        self
    }
}

/// How points are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    /// A line.
    Line,
    /// A dashed line.
    Dashed,
    /// A dot for each point.
    Dots,
    /// Dots joined by a line.
    Joined,
}

/// How thick a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Weight {
    /// One among many.
    Thin,
    /// As lines are.
    Usual,
    /// A reference that others are drawn over.
    Thick,
}

/// What a colour stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Tone {
    /// The reference: a target, a mean.
    Reference,
    /// The reference where something else is drawn over it; one of many.
    Pale,
    /// What the report is about: a measurement, a result.
    Main,
    /// What it is compared with: another measurement, a threshold.
    Second,
    /// A signal over time or length.
    Signal,
    /// A second signal, or what stands out.
    Accent,
    /// A third signal.
    Third,
    /// A border between parts.
    Border,
    /// One of several that count alike: distinct colours for a few, a scale from dark to light for many.
    Of {
        /// Its place, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
}

impl Tone {
    /// The colours of `count` lines that count alike.
    #[must_use]
    pub fn several(count: usize) -> Vec<Self> {
        (0..count).map(|index| Self::Of { index, count }).collect()
    }
}

/// How values become places on an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By ratios.
    Logarithmic,
    /// Whole numbers from 0 stand for names.
    Names(Vec<String>),
}

/// An axis: its label with the unit, and its range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Axis {
    /// The quantity and its unit.
    pub label: String,
    /// The value at its beginning.
    pub low: f64,
    /// The value at its end.
    pub high: f64,
    /// How it is divided.
    pub scale: Scale,
    /// Where its ticks stand: at what was measured; round numbers where it is empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ticks: Vec<f64>,
}

/// More ticks than this are round numbers.
const MOST_TICKS: usize = 12;

impl Axis {
    /// A linear axis from `low` to `high`.
    #[must_use]
    pub fn new(label: impl Into<String>, low: f64, high: f64) -> Self {
        Self {
            label: label.into(),
            low,
            high,
            scale: Scale::Linear,
            ticks: Vec::new(),
        }
    }

    /// The same with ticks at `values`, each once with three digits; as it is where they are many.
    #[must_use]
    pub fn ticks_at(mut self, values: impl Iterator<Item = f64>) -> Self {
        let mut ticks: Vec<f64> = values
            .filter(|value| value.is_finite() && *value > 0.0)
            .map(|value| {
                let step = 10f64.powf(value.log10().floor() - 2.0);
                (value / step).round() * step
            })
            .collect();
        ticks.sort_by(f64::total_cmp);
        ticks.dedup_by(|a, b| *a - *b < 1e-9 * a.abs());
        if ticks.len() <= MOST_TICKS {
            self.ticks = ticks;
        }
        self
    }

    /// A logarithmic axis from `low` to `high`, both above 0.
    #[must_use]
    pub fn log(label: impl Into<String>, low: f64, high: f64) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::new(label, low, high)
        }
    }

    /// An axis of names, the first at 0.
    #[must_use]
    pub fn names(label: impl Into<String>, names: Vec<String>) -> Self {
        Self {
            high: names.len() as f64 - 0.5,
            scale: Scale::Names(names),
            ..Self::new(label, -0.5, 0.0)
        }
    }

    /// An axis around all of `values`, with a little room; logarithmic ones end on whole steps.
    #[must_use]
    pub fn around(
        label: impl Into<String>,
        scale: Scale,
        values: impl Iterator<Item = f64>,
    ) -> Self {
        let (low, high) = values
            .filter(|v| v.is_finite() && (scale != Scale::Logarithmic || *v > 0.0))
            .fold((f64::MAX, f64::MIN), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        let (low, high) = match scale {
            _ if low > high => (0.1, 1.0),
            Scale::Logarithmic => (low / 1.25, high * 1.25),
            _ => {
                let room = 0.08 * (high - low).max(0.05 * high.abs()).max(f64::MIN_POSITIVE);
                // What begins near zero begins at zero.
                let low = if low >= 0.0 && low < 0.4 * high {
                    0.0
                } else {
                    low - room
                };
                (low, high + room)
            }
        };
        Self {
            label: label.into(),
            low,
            high,
            scale,
            ticks: Vec::new(),
        }
    }

    /// The place of `value` along the axis: its decimal logarithm on a logarithmic one, itself on others.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Logarithmic => value.log10(),
            _ => value,
        }
    }
}

/// The largest number of points of a line in a wide figure.
pub const MOST_POINTS: usize = 2400;

/// A line of more than `most` points as the lowest and highest point of every stretch, which looks the same.
#[must_use]
pub fn extremes(points: Vec<(f64, f64)>, most: usize) -> Vec<(f64, f64)> {
    if points.len() <= most {
        return points;
    }
    let stretch = points.len().div_ceil(most / 2);
    points
        .chunks(stretch)
        .flat_map(|chunk| {
            let low = chunk.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
            let high = chunk.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
            let mut both: Vec<(f64, f64)> = low.into_iter().chain(high).collect();
            both.sort_by(|a, b| a.0.total_cmp(&b.0));
            both
        })
        .collect()
}

/// The range of y that holds every line's points whose x lies between `low` and `high`, in whole steps of `step` and at most
/// `depth` below its top; a step above 0 where there are no points.
#[must_use]
pub fn range(lines: &[&[(f64, f64)]], low: f64, high: f64, step: f64, depth: f64) -> (f64, f64) {
    let inside = || {
        lines
            .iter()
            .flat_map(|line| line.iter())
            .filter(|(x, y)| *x >= low && *x <= high && y.is_finite())
    };
    let top = inside().map(|(_, y)| *y).fold(f64::MIN, f64::max);
    let bottom = inside().map(|(_, y)| *y).fold(f64::MAX, f64::min);
    if top < bottom {
        return (0.0, step);
    }
    let top = (top / step).floor() * step + step;
    (((bottom / step).floor() * step).max(top - depth), top)
}

/// Values on a grid as colours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Heatmap {
    /// Row by row from the top; NaN where nothing was measured, `null` in a document.
    #[serde(deserialize_with = "gaps")]
    pub values: Vec<f64>,
    /// How many values a row has.
    pub columns: usize,
    /// How wide and how high the area is, in `length_unit`.
    pub size: (f64, f64),
    /// The unit of its sides.
    pub length_unit: String,
    /// The values at the ends of the scale of colours.
    pub scale: (f64, f64),
    /// The quantity that is shown, with its unit.
    pub label: String,
}

/// Squares with the names of rows and columns, such as an association matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Matrix {
    /// The names of the rows.
    pub rows: Vec<String>,
    /// The names of the columns.
    pub columns: Vec<String>,
    /// Row by row.
    pub squares: Vec<Vec<Square>>,
    /// What the rows are.
    pub row_label: String,
    /// What the columns are.
    pub column_label: String,
    /// What the numbers are, with their unit.
    pub scale_label: String,
    /// What an untested square means.
    pub untested_label: String,
}

/// One square of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Square {
    pub shade: Shade,
    /// Whether it is the expected one of its row.
    pub outlined: bool,
    /// Whether something about it is to be looked at.
    pub dotted: bool,
}

impl Square {
    /// A square without marks.
    #[must_use]
    pub fn plain(shade: Shade) -> Self {
        Self {
            shade,
            outlined: false,
            dotted: false,
        }
    }
}

/// What a square shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Shade {
    /// A percentage.
    Percent(f64),
    /// A count, of which the second is the largest: the darkest.
    Count(usize, usize),
    /// It was not tested.
    Untested,
    /// It cannot be.
    Blank,
}

/// Spectrograms with one scale of colours, one of time and one of frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Spectrograms {
    /// The spectrograms, each with its title.
    pub panels: Vec<SpectrogramPanel>,
    /// The unit of their power spectral densities.
    pub unit: String,
    /// Below them; empty for none.
    pub note: String,
}

/// One spectrogram of several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpectrogramPanel {
    /// Above it.
    pub title: String,
    /// The middles of the columns, s.
    pub times_s: Vec<f64>,
    /// From one column to the next, s.
    pub time_step_s: f64,
    /// The middles of the rows, Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// From one row to the next, Hz.
    pub frequency_step_hz: f64,
    /// The level of every cell, dB, row by row from the highest frequency; `null` in a document where it is no number.
    #[serde(deserialize_with = "gaps")]
    pub levels_db: Vec<f64>,
}

/// Changes around 0 on maps of one size, with one scale of colours: blue below 0, white at 0, red above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Maps {
    /// The maps, each with its title.
    pub panels: Vec<MapPanel>,
    /// The scale of colours reaches from −`reach` to `reach`; above 0.
    pub reach: f64,
    /// The quantity that is shown, with its unit.
    pub label: String,
}

impl Maps {
    /// The maps with a scale that holds all their values, rounded up to two digits.
    #[must_use]
    pub fn around_zero(label: impl Into<String>, panels: Vec<MapPanel>) -> Self {
        let values = panels.iter().flat_map(|panel| &panel.values);
        let largest = values
            .filter(|value| value.is_finite())
            .fold(0.0f64, |largest, value| largest.max(value.abs()));
        let step = 10f64.powf(largest.log10().floor() - 1.0);
        let reach = match largest > 0.0 {
            true => (largest / step - 1e-9).ceil() * step,
            false => 1.0,
        };
        Self {
            panels,
            reach,
            label: label.into(),
        }
    }

    /// The figure of these maps.
    #[must_use]
    pub fn captioned(self, caption: impl Into<String>) -> Figure {
        Figure {
            drawn: Drawn::Maps(self),
            caption: caption.into(),
        }
    }
}

/// One map of several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct MapPanel {
    /// Above it.
    pub title: String,
    /// Row by row from the top; NaN where there is no value, `null` in a document.
    #[serde(deserialize_with = "gaps")]
    pub values: Vec<f64>,
    /// How many values a row has.
    pub columns: usize,
    /// What the map is of.
    pub ground: MapGround,
}

/// What a map is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum MapGround {
    /// Two quantities.
    Axes {
        /// Across.
        x: Axis,
        /// Up.
        y: Axis,
        /// Where on x something happens: a vertical line.
        marked: Vec<f64>,
        /// The part that is evaluated, outlined: from and to on x, from and to on y.
        outlined: Vec<[f64; 4]>,
    },
    /// A head from above, the nose at the top, in a square from −1 to 1.
    Head {
        /// The electrodes: to the right, to the front, name.
        electrodes: Vec<(f64, f64, String)>,
        /// How far from the middle the head reaches: the equator of the sphere.
        radius: f64,
    },
}

/// Numbers of a document in which `null` stands for what is none.
fn gaps<'de, D: Deserializer<'de>>(document: D) -> Result<Vec<f64>, D::Error> {
    let values: Vec<Option<f64>> = Deserialize::deserialize(document)?;
    Ok(values
        .into_iter()
        .map(|value| value.unwrap_or(f64::NAN))
        .collect())
}

#[cfg(test)]
mod tests;
