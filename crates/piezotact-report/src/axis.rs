//! The axes of a chart: positions of values, and ticks.

use piezotact::figure::{Axis, Scale};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// How the values of an axis are drawn.
pub(crate) trait Drawable {
    /// The range of places with its ticks: about `marks` of a logarithmic axis, and as many names, each as wide as `width`
    /// says, as there is room for.
    fn ranged(&self, marks: usize, room: f64, width: &dyn Fn(&str) -> f64) -> Ticked;
    /// The label of a tick at `place`.
    fn text(&self, place: f64) -> String;
    /// The places of its own ticks within its range whose texts do not meet over `room`.
    fn apart(&self, room: f64, width: &dyn Fn(&str) -> f64) -> Vec<f64>;
}

impl Drawable for Axis {
    fn ranged(&self, marks: usize, room: f64, width: &dyn Fn(&str) -> f64) -> Ticked {
        let (low, high) = (self.place(self.low), self.place(self.high));
        Ticked {
            range: (low..high).into(),
            low,
            high,
            ticks: match &self.scale {
                _ if !self.ticks.is_empty() => Some(self.apart(room, width)),
                Scale::Linear => (!has_steps(low, high)).then(|| vec![low, high]),
                Scale::Names(names) => {
                    let needed: f64 = names.iter().map(|name| width(name) + width("m")).sum();
                    let every = (needed / room).ceil().max(1.0) as usize;
                    Some((0..names.len()).step_by(every).map(|i| i as f64).collect())
                }
                Scale::Logarithmic => Some(log_ticks(low, high, marks)),
            },
        }
    }

    fn text(&self, place: f64) -> String {
        match &self.scale {
            Scale::Linear => number(place),
            Scale::Names(names) => names
                .get(place.round().max(0.0) as usize)
                .cloned()
                .unwrap_or_default(),
            Scale::Logarithmic => {
                let (low, high) = (self.low, self.high);
                if low >= 0.0099 && high <= 1e5 {
                    number(10f64.powf(place))
                } else {
                    power_of_ten(place)
                }
            }
        }
    }

    fn apart(&self, room: f64, width: &dyn Fn(&str) -> f64) -> Vec<f64> {
        let (low, high) = (self.place(self.low), self.place(self.high));
        let mut end = f64::MIN;
        let places = self.ticks.iter().map(|tick| self.place(*tick));
        let inside = places.filter(|place| *place >= low && *place <= high);
        let apart = inside.filter(|place| {
            if !room.is_finite() {
                return true;
            }
            let middle = (place - low) / (high - low) * room;
            let half = 0.5 * (width(&self.text(*place)) + width("n"));
            let is_free = middle - half >= end;
            if is_free {
                end = middle + half;
            }
            is_free
        });
        apart.collect()
    }
}

/// Whether round numbers can be stepped through between two values: between almost equal ones, or huge ones, a step is lost in
/// rounding, and the plotting library steps for ever.
fn has_steps(low: f64, high: f64) -> bool {
    let span = (high - low).abs();
    span.is_finite() && span > 1e-9 * low.abs().max(high.abs()) && span > 1e-150
}

/// Whole decades for long ranges; 1, 2, 5 and more between for short ones.
fn log_ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
    let steps: &[f64] = match high - low {
        span if span > 3.6 => &[1.0],
        span if span > 2.2 && most < 10 => &[1.0],
        span if span > 2.2 => &[1.0, 2.0, 5.0],
        span if span > 0.7 && most < 10 => &[1.0, 2.0, 5.0],
        span if span > 0.7 => &[1.0, 2.0, 3.0, 5.0, 7.0],
        span if span > 0.3 => &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        _ => &[
            1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2.0, 2.2, 2.5, 2.8, 3.0, 3.3, 3.6, 4.0, 4.5,
            5.0, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0, 8.5, 9.0, 9.5,
        ],
    };
    let ticks: Vec<f64> = (low.floor() as i32..=high.ceil() as i32)
        .flat_map(|e| steps.iter().map(move |m| m.log10() + f64::from(e)))
        .filter(|t| *t >= low - 1e-9 && *t <= high + 1e-9)
        .collect();
    let every = ticks.len().div_ceil(most).max(1);
    ticks.into_iter().step_by(every).collect()
}

fn power_of_ten(place: f64) -> String {
    let exponent = place.floor() as i32;
    let mantissa = 10f64.powf(place - place.floor());
    let digits = exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '0' => '⁰',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            _ => '⁹',
        })
        .collect::<String>();
    if (mantissa - 1.0).abs() < 0.01 {
        format!("10{digits}")
    } else {
        let mantissa = format!("{mantissa:.1}");
        format!("{}·10{digits}", mantissa.trim_end_matches(".0"))
    }
}

/// A range of places with its own ticks.
pub(crate) struct Ticked {
    range: plotters::coord::types::RangedCoordf64,
    low: f64,
    high: f64,
    ticks: Option<Vec<f64>>,
}

impl Ranged for Ticked {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.range.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match &self.ticks {
            Some(ticks) => ticks.clone(),
            None => self.range.key_points(hint),
        }
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Ticked {
    fn format_ext(&self, value: &f64) -> String {
        number(*value)
    }
}

/// Larger ticks are written as powers of ten.
const LARGEST_WHOLE: f64 = 1e7;

/// A tick's number without needless digits.
pub(crate) fn number(value: f64) -> String {
    if value.abs() >= LARGEST_WHOLE {
        let sign = if value < 0.0 { "−" } else { "" };
        return format!("{sign}{}", power_of_ten(value.abs().log10()));
    }
    // Ticks are sums of steps: what is left at 0 is rounding.
    let value = if value.abs() < 1e-9 { 0.0 } else { value };
    // Five digits that count distinguish neighbouring ticks; zeros at the end go.
    let decimals = match value {
        0.0 => 0,
        _ => (4.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize,
    };
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    };
    text.replace('-', "−")
}
