//! Scales of channels: from stored numbers to physical values.
//!
//! Each scale names what it is applied to: another scale, or the stored numbers. The last one gives the samples.
//!
//! Source: National Instruments, *TDMS Create Scaling Information*. That the operands of `Subtract` count from right to left is how the
//! readers of National Instruments and npTDMS take them.

use super::index::NO_SCALER;
use super::layout::Slot;
use super::property::{Properties, Property};

/// More scales than this are none that a program writes.
const MOST_SCALES: usize = 256;
/// Samples that are scaled at a time.
const BLOCK: usize = 4096;

/// A chain of scales, each applied to what those before it left.
#[derive(Debug, PartialEq)]
pub(super) struct Chain(Vec<Step>);

/// One step; a step takes its operands from the end of a list, and puts its result there.
#[derive(Debug, PartialEq)]
enum Step {
    /// The samples of a slot.
    Stored(usize),
    Linear {
        slope: f64,
        intercept: f64,
    },
    /// Coefficients from the constant one on.
    Polynomial(Vec<f64>),
    /// A bridge of strain gauges: −`factor`·v/(1 + `bend`·v) of the voltage beyond that at rest.
    Strain {
        rest_v: f64,
        factor: f64,
        bend: f64,
    },
    /// Points of a curve of straight lines, from left to right.
    Table(Vec<(f64, f64)>),
    Add,
    /// The second operand minus the first.
    Subtract,
}

/// The scales that one object describes.
struct Scales<'a> {
    properties: &'a Properties,
    slots: &'a [Slot],
    count: usize,
}

impl Chain {
    /// The scales in the first of `properties` that describe any; `None` where none does, or where the samples are scaled already.
    ///
    /// # Errors
    /// What is described that is not known or not possible.
    pub(super) fn of(properties: &[&Properties], slots: &[Slot]) -> Result<Option<Self>, String> {
        let described = properties.iter().find_map(|properties| {
            let stated = properties.get("NI_Number_Of_Scales");
            let stated = stated
                .and_then(Property::number)
                .map(|count| count as usize);
            let counted = || {
                let typed = properties.keys().filter_map(|name| {
                    let number = name.strip_prefix("NI_Scale[")?;
                    number.strip_suffix("]_Scale_Type")?.parse::<u32>().ok()
                });
                Some(typed.max()? as usize + 1)
            };
            let count = stated.or_else(counted).filter(|count| *count > 0)?;
            Some(Scales {
                properties,
                slots,
                count,
            })
        });
        let Some(scales) = described else {
            return Ok(None);
        };
        let status = scales.properties.get("NI_Scaling_Status");
        if status.and_then(Property::text) == Some("scaled") {
            return Ok(None);
        }
        if scales.count > MOST_SCALES {
            return Err(format!("{} scales", scales.count));
        }
        let mut steps = Vec::new();
        scales.add(scales.count as u64 - 1, &mut steps, 0)?;
        Ok(Some(Self(steps)))
    }

    /// Whether samples can lie outside a table of it.
    pub(super) fn has_a_table(&self) -> bool {
        self.0.iter().any(|step| matches!(step, Step::Table(_)))
    }

    /// The samples, and how many of them lie outside a table, whose ends they get.
    pub(super) fn apply(&self, mut stored: Vec<Vec<f64>>) -> (Vec<f64>, usize) {
        let length = stored.iter().map(Vec::len).min().unwrap_or(0);
        let mut outside = 0;
        for from in (0..length).step_by(BLOCK) {
            let part = from..(from + BLOCK).min(length);
            let mut results: Vec<Vec<f64>> = Vec::new();
            for step in &self.0 {
                if let Step::Stored(slot) = step {
                    results.push(stored[*slot][part.clone()].to_vec());
                } else if let Step::Add | Step::Subtract = step {
                    let right = results.pop().unwrap_or_default();
                    if let Some(left) = results.last_mut() {
                        for (left, right) in left.iter_mut().zip(right) {
                            *left = match step {
                                Step::Add => *left + right,
                                _ => right - *left,
                            };
                        }
                    }
                } else if let Some(last) = results.last_mut() {
                    outside += step.on(last);
                }
            }
            let result = results.pop().unwrap_or_default();
            stored[0][part].copy_from_slice(&result);
        }
        let mut values = stored.swap_remove(0);
        values.truncate(length);
        (values, outside)
    }
}

impl Step {
    /// Applies a step of one operand; how many lie outside its table.
    fn on(&self, values: &mut [f64]) -> usize {
        let mut outside = 0;
        for value in values {
            *value = match self {
                Self::Linear { slope, intercept } => *value * slope + intercept,
                Self::Strain {
                    rest_v,
                    factor,
                    bend,
                } => {
                    let beyond_v = *value - rest_v;
                    -factor * beyond_v / (1.0 + bend * beyond_v)
                }
                Self::Polynomial(coefficients) => {
                    let highest_first = coefficients.iter().rev();
                    highest_first.fold(0.0, |sum, coefficient| sum * *value + coefficient)
                }
                Self::Table(points) => {
                    let (place, is_outside) = on_lines(points, *value);
                    outside += usize::from(is_outside);
                    place
                }
                Self::Stored(_) | Self::Add | Self::Subtract => *value,
            };
        }
        outside
    }
}

/// The value of the straight lines between `points` at `x`, and whether it lies outside of them, where the nearest end holds.
fn on_lines(points: &[(f64, f64)], x: f64) -> (f64, bool) {
    let behind = points.partition_point(|(place, _)| *place <= x);
    match (points.get(behind.wrapping_sub(1)), points.get(behind)) {
        (Some((x0, y0)), Some((x1, y1))) => (y0 + (y1 - y0) * (x - x0) / (x1 - x0), false),
        (Some((end, y)), None) => (if x.is_nan() { x } else { *y }, x > *end),
        (None, Some((_, y))) => (if x.is_nan() { x } else { *y }, !x.is_nan()),
        (None, None) => (x, true),
    }
}

impl Scales<'_> {
    /// A property of scale `at`.
    fn property(&self, at: u64, name: &str) -> Option<&Property> {
        self.properties.get(&format!("NI_Scale[{at}]_{name}"))
    }

    fn number(&self, at: u64, name: &str) -> Result<f64, String> {
        let found = self.property(at, name).and_then(Property::number);
        found.ok_or_else(|| format!("no number `NI_Scale[{at}]_{name}`"))
    }

    /// A list of numbers with its length, which is `usual` where it is not stated.
    fn list(&self, at: u64, name: &str, usual: Option<f64>) -> Result<Vec<f64>, String> {
        let stated = self.number(at, &format!("{name}_Size"));
        let count = match (stated, usual) {
            (Ok(count), _) | (Err(_), Some(count)) => count as u64,
            (Err(error), None) => return Err(error),
        };
        let each = (0..count).map(|k| self.number(at, &format!("{name}[{k}]")));
        each.collect()
    }

    /// The scale of a bridge, with the names that `DAQmx` gives its arrangements.
    ///
    /// Source: National Instruments, *Strain Gauge Configuration Types*: the voltage ratio of each bridge, solved for the strain.
    fn strain(&self, at: u64) -> Result<Step, String> {
        let number = |name: &str| self.number(at, &format!("Strain_{name}"));
        let poisson = number("Poisson_Ratio")?;
        let wires = 1.0 + number("Lead_Wire_Resistance")? / number("Gage_Resistance")?;
        let both = (1.0 - poisson) / (1.0 + poisson);
        let (factor, bend) = match number("Configuration")? as u64 {
            10_183 => (1.0, 0.0),
            10_184 => (2.0 / (1.0 + poisson), 0.0),
            10_185 => (2.0 / (1.0 + poisson), both),
            10_188 => (4.0 * wires / (1.0 + poisson), 2.0 * both),
            10_189 => (2.0 * wires, 0.0),
            10_271 | 10_272 => (4.0 * wires, 2.0),
            other => return Err(format!("a bridge of strain gauges of type {other}")),
        };
        let excitation_v = number("Voltage_Excitation")?;
        let gain = number("Bridge_Shunt_Calibration_Gain_Adjustment")?;
        Ok(Step::Strain {
            rest_v: number("Initial_Bridge_Voltage")?,
            factor: factor * gain / (number("Gage_Factor")? * excitation_v),
            bend: bend / excitation_v,
        })
    }

    /// Adds the steps of scale `at` behind those of its operands.
    fn add(&self, at: u64, steps: &mut Vec<Step>, depth: usize) -> Result<(), String> {
        if depth > MOST_SCALES || steps.len() > MOST_SCALES {
            return Err("scales that refer to each other in a circle".into());
        }
        let scale_type = self.property(at, "Scale_Type").and_then(Property::text);
        let Some(scale_type) = scale_type else {
            // A scale that is not described stands for the scaler of this number, or for the stored numbers.
            let slot = self.slots.iter().position(|slot| slot.scaler == at);
            steps.push(Step::Stored(slot.ok_or_else(|| match at {
                NO_SCALER => {
                    "a scale of samples of several scalers, which names none of them".into()
                }
                at => format!("no description of scale {at}"),
            })?));
            return Ok(());
        };
        let operand = |name: &str, steps: &mut Vec<Step>| {
            let source = self.property(at, &format!("{name}Input_Source"));
            let source = source
                .and_then(Property::number)
                .map_or(NO_SCALER, |n| n as u64);
            if source != NO_SCALER && source >= self.count as u64 {
                return Err(format!("scale {source} of {}", self.count));
            }
            self.add(source, steps, depth + 1)
        };
        let step = match scale_type {
            "Linear" => {
                operand("Linear_", steps)?;
                Step::Linear {
                    slope: self.number(at, "Linear_Slope")?,
                    intercept: self.number(at, "Linear_Y_Intercept")?,
                }
            }
            "Polynomial" => {
                operand("Polynomial_", steps)?;
                Step::Polynomial(self.list(at, "Polynomial_Coefficients", Some(4.0))?)
            }
            "Strain" => {
                operand("Strain_", steps)?;
                self.strain(at)?
            }
            "Table" => {
                operand("Table_", steps)?;
                let from = self.list(at, "Table_Pre_Scaled_Values", None)?;
                let to = self.list(at, "Table_Scaled_Values", None)?;
                let same = from.len() == to.len() && !from.is_empty();
                let mut points: Vec<(f64, f64)> = from.into_iter().zip(to).collect();
                if points.first() > points.last() {
                    points.reverse();
                }
                if !same || !points.windows(2).all(|pair| pair[0].0 < pair[1].0) {
                    return Err(format!(
                        "table {at}, which does not rise or fall throughout"
                    ));
                }
                Step::Table(points)
            }
            "Add" | "Subtract" => {
                operand(&format!("{scale_type}_Left_Operand_"), steps)?;
                operand(&format!("{scale_type}_Right_Operand_"), steps)?;
                match scale_type {
                    "Add" => Step::Add,
                    _ => Step::Subtract,
                }
            }
            other => return Err(format!("a scale of type `{other}`")),
        };
        steps.push(step);
        Ok(())
    }
}
