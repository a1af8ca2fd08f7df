//! From functions of dataset 58 to recordings and transfer functions.

use piezotact::recording::RecordingWarning;
use std::path::Path;

use num_complex::Complex;
use piezotact::Warning;
use piezotact::quantity::{Degrees, Newtons, SampleRate, Seconds, Unit};
use piezotact::recording::{Condition, Recording, StartTime};
use piezotact::transfer::Estimator;

use super::write_time::OWN_TIME;
use super::{UffAbscissa, UffData, UffFunction, UffKind};
use crate::columns::{Column, WithoutUnit, recording_of_bases as table_of, start_of_part};
use crate::error::ReadError;
use crate::open::ReadOptions;
use crate::time_column::{TimeBase, base_of, choose_base};
use crate::transfer_file::{Lines, from_lines};
use crate::transfer_json::TransferDocument;

/// The number of the quantity time.
const TIME: i64 = 17;
/// Whether `functions` hold a frequency response and no time signal.
pub(crate) fn holds_transfer(functions: &[UffFunction]) -> bool {
    functions.iter().any(is_response) && !functions.iter().any(is_time)
}

fn is_response(function: &UffFunction) -> bool {
    function.kind == UffKind::FrequencyResponse && matches!(function.data, UffData::Complex(_))
}

fn is_time(function: &UffFunction) -> bool {
    matches!(function.data, UffData::Real(_))
        && (function.kind == UffKind::Time || function.abscissa_axis.quantity == TIME)
}

/// What there is, for a refusal: `2 × frequency response, 1 × coherence`.
fn kinds(functions: &[UffFunction]) -> String {
    let mut counted: Vec<(UffKind, usize)> = Vec::new();
    for function in functions {
        match counted.iter_mut().find(|(kind, _)| *kind == function.kind) {
            Some((_, count)) => *count += 1,
            None => counted.push((function.kind, 1)),
        }
    }
    let named: Vec<String> = counted
        .iter()
        .take(8)
        .map(|(kind, count)| format!("{count} × {kind}"))
        .collect();
    named.join(", ")
}

/// The time responses of a file as the channels of a recording.
pub(crate) fn recording_of(
    path: &Path,
    functions: &[UffFunction],
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let signals: Vec<&UffFunction> = functions.iter().filter(|f| is_time(f)).collect();
    let Some(first) = signals.first() else {
        return Err(ReadError::content(
            path,
            "time responses (functions of type 1) in a universal file",
            kinds(functions),
            "export the time signals; a frequency response is only read as a transfer function",
        ));
    };
    let (mut warnings, mut columns) = (Vec::new(), Vec::<(Column, usize)>::new());
    let (mut clocks, mut bases) = (Vec::<&UffFunction>::new(), Vec::new());
    for signal in &signals {
        let known = clocks.iter().position(|of| same_axis(signal, of));
        let clock = match known.map(|at| (at, clocks[at])) {
            Some((at, of)) if of.data.len() == signal.data.len() => at,
            Some((_, of)) => {
                return Err(ReadError::content(
                    path,
                    format!(
                        "time responses of one length on one axis, {} values as of {}",
                        of.data.len(),
                        of.response
                    ),
                    format!(
                        "{} values of {} ({})",
                        signal.data.len(),
                        signal.response,
                        axis(signal)
                    ),
                    "export the signals that were recorded together to a separate file",
                ));
            }
            None if options.rate.is_some() && !clocks.is_empty() => {
                return Err(ReadError::content(
                    path,
                    "time responses on one axis, because one rate is given",
                    format!("{} of {}", axis(signal), signal.response),
                    "leave the rate out: the file states a rate for each of them",
                ));
            }
            None => {
                let found = base(path, signal, &mut warnings);
                let base = choose_base(path, options, Some(found), &mut warnings)?;
                clocks.push(signal);
                bases.push((base, start_s(signal)));
                clocks.len() - 1
            }
        };
        let name = unique(name(signal), &columns);
        warnings.extend(signal_warnings(signal, &name));
        if let UffData::Real(values) = &signal.data {
            let column = Column {
                name,
                unit: Some(signal.ordinate_axis.unit.clone()),
                values: values.clone(),
            };
            columns.push((column, clock));
        }
    }
    let mut recording = table_of(
        path,
        columns,
        &bases,
        warnings,
        options,
        WithoutUnit::OnlyScale { counts: &[] },
    )?;
    if start_s(first).0 == 0.0 && recording.clocks()[0].start_s.0 <= 0.0 {
        recording.annotations.started_at =
            start_time(first.date()).map(|at| at.later(start_of_part(&bases)));
    }
    recording.about.provenance.steps.push(format!(
        "universal file of {}",
        Some(first.date())
            .filter(|date| !date.is_empty())
            .unwrap_or("no stated date")
    ));
    Ok(recording)
}

fn signal_warnings(signal: &UffFunction, name: &str) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if signal.kind != UffKind::Time {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "`{name}` is marked as a {} but has a time axis: it is read as a time response",
                signal.kind
            ),
        }));
    }
    if signal.data.len() < signal.promised {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "the header states {} samples of `{name}` and {} follow: the file is truncated, the available samples were \
                 read",
                signal.promised,
                signal.data.len()
            ),
        }));
    }
    warnings
}

/// The time of the first value on the axis of a signal.
fn start_s(signal: &UffFunction) -> Seconds {
    let (unit, second) = Unit::parse(&signal.abscissa_axis.unit);
    let second = if unit == Unit::Second { second } else { 1.0 };
    Seconds(second * signal.places().first().copied().unwrap_or(0.0))
}

/// The time in a date line, `05-Mar-24 10:22:33`, without a zone, as the format states none; `None` where it holds
/// no time or another form. Years of two digits are 1970–2069.
fn start_time(date: &str) -> Option<StartTime> {
    const MONTHS: [&str; 12] = [
        "jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec",
    ];
    let (day, time) = date.trim().split_once(char::is_whitespace)?;
    let mut parts = day.split('-');
    let (day, month, year) = (parts.next()?, parts.next()?, parts.next()?);
    let month = month.to_ascii_lowercase();
    let month = 1 + MONTHS.iter().position(|name| *name == month)?;
    let year: u32 = match (year.len(), year.parse().ok()?) {
        (2, year @ 70..) => 1900 + year,
        (2, year) => 2000 + year,
        (_, year) => year,
    };
    let day: u32 = day.parse().ok()?;
    let time = time.trim();
    StartTime::try_from(format!("{year:04}-{month:02}-{day:02}T{time}")).ok()
}

fn axis(function: &UffFunction) -> String {
    match &function.abscissa {
        UffAbscissa::Even { start, step } => format!("from {start} in steps of {step}"),
        UffAbscissa::List(_) => "its own list of abscissa values".into(),
    }
}

fn same_axis(a: &UffFunction, b: &UffFunction) -> bool {
    match (&a.abscissa, &b.abscissa) {
        (
            UffAbscissa::Even {
                start: a0,
                step: da,
            },
            UffAbscissa::Even {
                start: b0,
                step: db,
            },
        ) => (a0 - b0).abs() <= 1e-3 * db && (da - db).abs() <= 1e-6 * db,
        (UffAbscissa::List(a), UffAbscissa::List(b)) => a == b,
        _ => false,
    }
}

fn name(signal: &UffFunction) -> String {
    let point = &signal.response;
    if !point.entity.is_empty() {
        point.entity.clone()
    } else if point.node != 0 {
        point.to_string()
    } else if !signal.id_lines[0].is_empty() {
        signal.id_lines[0].clone()
    } else {
        "signal".into()
    }
}

fn unique(name: String, columns: &[(Column, usize)]) -> String {
    let taken = |name: &str| columns.iter().any(|(column, _)| column.name == name);
    if !taken(&name) {
        return name;
    }
    (2..)
        .map(|k: u64| format!("{name} {k}"))
        .find(|name| !taken(name))
        .unwrap_or(name)
}

fn base(
    path: &Path,
    signal: &UffFunction,
    warnings: &mut Vec<Warning>,
) -> Result<TimeBase, ReadError> {
    match &signal.abscissa {
        UffAbscissa::Even { step, .. } => {
            let second = match Unit::parse(&signal.abscissa_axis.unit) {
                (Unit::Second, factor) => factor,
                (Unit::Other(text), _) if text.is_empty() => 1.0,
                (unit, _) => {
                    return Err(ReadError::content(
                        path,
                        "an abscissa in s, ms or µs",
                        unit.symbol().to_owned(),
                        "export time signals over time",
                    ));
                }
            };
            let found_hz = 1.0 / (step * second);
            // The step of the header has seven digits; our own files hold the rate as well.
            let stated_hz = signal.id_lines[1]
                .strip_prefix("rate_hz=")
                .filter(|_| signal.id_lines[4] == OWN_TIME)
                .and_then(|text| text.parse().ok())
                .filter(|stated: &f64| (stated - found_hz).abs() <= 1e-6 * found_hz);
            let rate = SampleRate::new(stated_hz.unwrap_or(found_hz));
            rate.map(TimeBase::even).map_err(ReadError::of(path))
        }
        UffAbscissa::List(places) => {
            let time = Column {
                name: "abscissa".into(),
                unit: Some(signal.abscissa_axis.unit.clone()),
                values: places.clone(),
            };
            base_of(path, &time, warnings)
        }
    }
}

/// The frequency response of a file, with its coherence.
pub(crate) fn transfer_of(
    path: &Path,
    functions: &[UffFunction],
) -> Result<TransferDocument, ReadError> {
    let mut responses = functions.iter().filter(|f| is_response(f));
    let (response, values) = match (responses.next(), responses.next()) {
        (Some(only), None) => match &only.data {
            UffData::Complex(values) => (only, values),
            UffData::Real(_) => return Err(no_response(path, functions)),
        },
        (Some(_), Some(_)) => {
            let named: Vec<String> = functions
                .iter()
                .filter(|f| is_response(f))
                .take(8)
                .map(|f| format!("{} over {}", f.response, f.reference))
                .collect();
            return Err(ReadError::content(
                path,
                "one frequency response",
                format!("several ({})", named.join(", ")),
                "export the required one to a separate file",
            ));
        }
        (None, _) => return Err(no_response(path, functions)),
    };
    if values.len() < response.promised {
        return Err(ReadError::content(
            path,
            format!(
                "{} frequency lines, as the header states",
                response.promised
            ),
            format!("{}", values.len()),
            "the file was cut short: copy or export it again",
        ));
    }
    let mut warnings = Vec::new();
    let to_hz = to_hz(path, response, &mut warnings)?;
    let (response_unit, drive_unit, factor) = units(response);
    let coherence = coherence(functions, response, &mut warnings);
    let own = Own::of(response);
    let mut frequency_hz: Vec<f64> = response
        .places()
        .iter()
        .map(|place| place * to_hz)
        .collect();
    own.restore(&mut frequency_hz);
    let values: Vec<Complex<f64>> = values.iter().map(|value| value * factor).collect();
    let lines = Lines {
        frequency_hz,
        response: values,
        coherence,
    };
    let mut document = from_lines(path, lines, warnings)?;
    document.drive_unit = drive_unit;
    document.response_unit = response_unit;
    document.estimator = own.estimator;
    document.averages = own.averages;
    document.rate_hz = own.rate;
    document.about.condition = own.condition;
    Ok(document)
}

fn no_response(path: &Path, functions: &[UffFunction]) -> ReadError {
    ReadError::content(
        path,
        "a complex frequency response (function of type 4) in a universal file",
        kinds(functions),
        "export the frequency response, or estimate it from the time signals with `piezotact transfer`",
    )
}

fn to_hz(
    path: &Path,
    response: &UffFunction,
    warnings: &mut Vec<Warning>,
) -> Result<f64, ReadError> {
    let axis = &response.abscissa_axis;
    match axis.unit.to_ascii_lowercase().as_str() {
        "hz" | "1/s" | "cps" => Ok(1.0),
        "khz" => Ok(1e3),
        "rad/s" => Ok(0.5 / std::f64::consts::PI),
        "" if axis.quantity != TIME => {
            warnings.push(Warning::from(RecordingWarning::Guessed {
                what: "the abscissa names no unit and is read as Hz".into(),
            }));
            Ok(1.0)
        }
        found => Err(ReadError::content(
            path,
            "a frequency response over Hz, kHz or rad/s",
            if found.is_empty() {
                "time".into()
            } else {
                format!("`{found}`")
            },
            "export it over frequency",
        )),
    }
}

/// The units of response and drive, and the factor that brings the values to them.
fn units(response: &UffFunction) -> (Unit, Unit, f64) {
    let over = &response.denominator_axis.unit;
    let label = response.ordinate_axis.unit.as_str();
    if !over.is_empty() {
        let ((o, fo), (i, fi)) = (Unit::parse(label), Unit::parse(over));
        return (o, i, fo / fi);
    }
    // `(1/N)*(m/s²)`, `(m/s^2)/N`, `g/N`: everything in the label of the ordinate.
    let inverse = label
        .strip_prefix("(1/")
        .and_then(|rest| rest.split_once(")*"))
        .map(|(over, of)| (of, over));
    let divided = label
        .char_indices()
        .filter(|(_, c)| *c == '/')
        .map(|(at, _)| (&label[..at], &label[at + 1..]));
    inverse
        .into_iter()
        .chain(divided)
        .map(|(of, over)| {
            let bare = |text: &str| {
                let text = text.trim();
                text.strip_prefix('(')
                    .and_then(|text| text.strip_suffix(')'))
                    .unwrap_or(text)
                    .to_owned()
            };
            (Unit::parse(&bare(of)), Unit::parse(&bare(over)))
        })
        .find(|((o, _), (i, _))| {
            // A whole compound such as m/s² is no quotient of a length and a time here.
            !matches!(o, Unit::Other(_)) && !matches!(i, Unit::Other(_) | Unit::Second)
        })
        .map_or_else(
            || {
                let (unit, factor) = Unit::parse(label);
                (unit, Unit::Other(String::new()), factor)
            },
            |((o, fo), (i, fi))| (o, i, fo / fi),
        )
}

/// The coherence between the same points, when there is one on the same axis.
fn coherence(
    functions: &[UffFunction],
    response: &UffFunction,
    warnings: &mut Vec<Warning>,
) -> Option<Vec<f64>> {
    let mut others = 0;
    for function in functions.iter().filter(|f| f.kind == UffKind::Coherence) {
        let same =
            function.response == response.response && function.reference == response.reference;
        let fits = function.data.len() == response.data.len() && same_axis(function, response);
        match &function.data {
            UffData::Real(values) if same && fits => return Some(values.clone()),
            _ => others += 1,
        }
    }
    if others > 0 {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "the file contains {others} coherence function(s), but for other points or on another axis than the frequency \
                 response: not used"
            ),
        }));
    }
    None
}

/// What our own id lines say, and what can be read off those of others.
struct Own {
    estimator: Estimator,
    averages: usize,
    rate: Option<SampleRate>,
    condition: Condition,
}

impl Own {
    fn of(response: &UffFunction) -> Self {
        let mut own = Self {
            estimator: Estimator::H1,
            averages: 0,
            rate: None,
            condition: Condition::default(),
        };
        let named = |line: &String| {
            // Our own files give the noise ratio of Hv in brackets; in others a bracket may stand around the name.
            let own = line.split(['=', ';', ' ']).find_map(Estimator::named);
            own.or_else(|| {
                line.split(|c: char| !c.is_ascii_alphanumeric())
                    .find_map(Estimator::named)
            })
        };
        if let Some(estimator) = response.id_lines.iter().find_map(named) {
            own.estimator = estimator;
        }
        if response.id_lines[4] != super::write::OWN {
            return own;
        }
        for line in [&response.id_lines[0], &response.id_lines[1]] {
            let mut rest = line.as_str();
            // The participant's name stands last: it may hold a semicolon.
            if let Some((before, name)) = rest.split_once("participant=") {
                own.condition.participant = Some(name.to_owned());
                rest = before;
            }
            for (key, value) in rest.split(';').filter_map(|part| part.split_once('=')) {
                match (key.trim(), value.trim().parse::<f64>()) {
                    ("averages", Ok(count)) => own.averages = count as usize,
                    ("rate_hz", Ok(hz)) => own.rate = SampleRate::new(hz).ok(),
                    ("load_n", Ok(load)) => own.condition.load_n = Some(Newtons(load)),
                    ("angle_deg", Ok(angle)) => own.condition.angle_deg = Some(Degrees(angle)),
                    _ => {}
                }
            }
        }
        own
    }

    /// The header has six or seven digits of the step. Where the rate that we wrote beside it gives the same step for
    /// an even or an odd segment, the exact one is taken.
    fn restore(&self, frequency_hz: &mut [f64]) {
        let (Some(rate), Some(&last), lines) = (self.rate, frequency_hz.last(), frequency_hz.len())
        else {
            return;
        };
        if lines < 2 || frequency_hz[0] != 0.0 {
            return;
        }
        let written = last / (lines - 1) as f64;
        let exact = [2 * (lines - 1), 2 * lines - 1]
            .map(|segment| rate.hz() / segment as f64)
            .into_iter()
            .find(|step| (step / written - 1.0).abs() < 1e-6);
        if let Some(step) = exact {
            for (k, frequency) in frequency_hz.iter_mut().enumerate() {
                *frequency = k as f64 * step;
            }
        }
    }
}
