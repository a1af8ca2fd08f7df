//! The report of one transfer function.

use maud::{Markup, html};
use piezotact::document::Words;
use piezotact::number::digits;
use piezotact::quantity::{Band, Quantity, Unit};
use piezotact::transfer::{Bias, Distortion, ImpactTraces, Limits, TransferFunction};
use piezotact::warning::merged;

#[cfg(feature = "modal")]
use crate::impact;
use crate::report::drawn_warnings_and;
use crate::{DrawError, bench_text, document, figure, figures};

/// What the figures of a transfer function show.
pub(crate) fn captions<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
) -> [&'static str; 3] {
    let coherence = "Coherence: the share of the response power that the drive explains linearly.";
    if function.confidence().is_none() {
        return [
            "Magnitude. Its scatter is unknown.",
            "Phase. Its scatter is unknown.",
            coherence,
        ];
    }
    match function.limits() {
        Limits::BestLinear => [
            "Magnitude. Area behind the curve: 95 % confidence interval at each spectral line, of the best linear approximation \
                at the level of this drive, if device and finger did not change. H2 is above H1 by the noise on the response and by the distortion.",
            "Phase. Area behind the curve: 95 % confidence interval.",
            coherence,
        ],
        Limits::Scatter => [
            "Magnitude. Area behind the curve: scatter of the estimate, that is its random error only. Other area: from H1 to H2. \
                Noise on the drive makes H1 too small, noise on the response makes H2 too large: for a linear system the \
                true magnitude lies between them, apart from the scatter.",
            "Phase. Area behind the curve: scatter of the estimate.",
            coherence,
        ],
    }
}

/// A level below any that can be measured, dB.
const NOTHING_DB: f64 = -300.0;

/// What a report of a transfer function shows.
#[derive(Clone, Debug)]
pub struct Page<'a, I: Quantity, O: Quantity> {
    pub title: String,
    pub function: &'a TransferFunction<I, O>,
    /// The unit of its values.
    pub unit: String,
    /// The unit of the drive.
    pub drive_unit: String,
    /// The unit of the response.
    pub response_unit: String,
    /// Noise and distortion; absent where nothing told them apart.
    pub distortion: Option<&'a Distortion>,
    /// How many repeats there are, and how far the two that differ most lie apart, dB rms.
    pub repeats: Option<(usize, f64)>,
    /// What was refused, and why.
    pub refused: Vec<String>,
    /// Forces, responses and windows of an impact test; absent for other drives.
    pub traces: Option<&'a ImpactTraces>,
}

impl<'a, I: Quantity, O: Quantity> Page<'a, I, O> {
    /// A transfer function between channels in these units: drive, response.
    #[must_use]
    pub fn of(
        title: String,
        function: &'a TransferFunction<I, O>,
        [drive_unit, response_unit]: [&Unit; 2],
    ) -> Self {
        Self {
            title,
            function,
            unit: format!("({response_unit})/{drive_unit}"),
            drive_unit: drive_unit.to_string(),
            response_unit: response_unit.to_string(),
            distortion: None,
            repeats: None,
            refused: Vec::new(),
            traces: None,
        }
    }
}

/// The report as HTML, with warnings in `words`.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn html<I: Quantity, O: Quantity>(
    page: &Page<'_, I, O>,
    words: &dyn Words,
) -> Result<String, DrawError> {
    let function = page.function;
    let (shown, judged) = (function.shown_band(), function.tactile_band());
    let figures = figures::transfer(function, shown, &page.unit)?;
    let distortion = page
        .distortion
        .map(|d| figures::distortion(d, &page.response_unit))
        .transpose()?;
    #[cfg(feature = "modal")]
    let hits = impact::section(page)?;
    #[cfg(not(feature = "modal"))]
    let hits = html! {};
    let body = html! {
        h1 { (page.title) }
        p.soft { (bench_line(function)) }
        (numbers(page, judged))
        section {
            h2 { "Warnings" }
            (drawn_warnings_and(&merged(&function.about.warnings), &page.refused, words))
        }
        section {
            h2 { "Transfer function" }
            @for (svg, caption) in figures.iter().zip(captions(function)) { (figure(svg, caption)) }
            p.soft { "Shaded: the band that was excited. Outside it, the values have no meaning." }
        }
        (hits)
        @if let (Some(svg), Some(distortion)) = (&distortion, page.distortion) {
            section {
                h2 { "Is the device linear?" }
                p { (linear_words(distortion)) }
                (figure(svg, "Levels of single spectral lines: the square root of their mean power within third octaves. \
                    Distortion that is not above the noise is not drawn."))
                p.soft { (format!("{} realisations of {} periods; lines {:.2} Hz apart. Noise: the part that differs between \
                    periods. Distortion: the part that repeats at lines that are not \
                    excited.", distortion.realisations, distortion.periods, distortion.resolution_hz)) }
            }
        }
        (origin(function))
    };
    Ok(document(&page.title, &body))
}

fn bench_line<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> String {
    let kind = bench_text(function.about.provenance.bench)
        .unwrap_or("The recording does not say which bench it comes from.");
    match function.about.condition.to_string() {
        nothing if nothing.is_empty() => kind.into(),
        known => format!("{kind} Measured with {known}."),
    }
}

fn numbers<I: Quantity, O: Quantity>(page: &Page<'_, I, O>, judged: Band) -> Markup {
    let function = page.function;
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    html! {
        section.verdict {
            strong { (format!("{} from {}, lines {:.2} Hz apart", function.estimator, averaged(function), function.resolution_hz())) }
            div.numbers {
                @if let Some(test) = function.impact.as_ref().filter(|test| test.added_damping_per_s > 0.0) {
                    (number(format!("{} 1/s", digits(test.added_damping_per_s)), &format!("damping σ added by the exponential window: \
                        half-power bandwidths are {} Hz wider", digits(test.added_bandwidth_hz()))))
                }
                @if !function.has_coherence() { (number("none".into(), "coherence: one hit has none")) }
                @if let Some(reach_db) = function.median_reach_db(judged) {
                    @let reach = if reach_db.is_finite() { format!("± {reach_db:.2} dB") } else { "no lower limit".into() };
                    (number(reach, &format!("{} of the median line over {judged}", limits_name(function.limits()))))
                }
                @if let Some(bias) = function.bias(judged) {
                    (number(bias.median_db.map_or_else(|| "unknown".into(), |db| format!("{db:.2} dB")), &bias_text(&bias)))
                }
                @if let Some(coherence) = function.coherence_in(judged) {
                    (number(format!("{:.3}", coherence.median), "median coherence"))
                    (number(format!("{:.3}", coherence.lowest), &format!("lowest coherence, at {:.0} \
                        Hz", coherence.lowest_at_hz)))
                }
                @if let Some(delay) = function.delay().filter(|_| function.impact.is_none()) {
                    (number(format!("{:.2} ± {:.2} ms", delay.delay_s * 1e3, delay.ci_half_width_s * 1e3), "from the drive to the response, within a segment"))
                }
                @if let Some((repeats, apart_db)) = page.repeats {
                    (number(format!("{apart_db:.2} dB"), &format!("largest rms difference between two of {repeats} repeats")))
                }
                @let distortion = page.distortion.and_then(Distortion::worst);
                // Where none stands above the noise its level is that of nothing.
                @if distortion.is_some_and(|(level_db, _)| level_db < NOTHING_DB) {
                    (number("none".into(), "distortion above the noise"))
                } @else if let Some((level_db, band)) = distortion {
                    (number(format!("{level_db:.0} dB").replace('-', "−"), &format!("largest distortion re the \
                        response, {band}")))
                }
            }
        }
    }
}

/// What limits are called.
fn limits_name(limits: Limits) -> &'static str {
    match limits {
        Limits::BestLinear => "95 % confidence interval",
        Limits::Scatter => "scatter (random error only)",
    }
}

fn bias_text(bias: &Bias) -> String {
    match bias.largest_db {
        Some(db) => format!(
            "H2 above H1 at the median line; at most {db:.1} dB, at {:.0} Hz",
            bias.largest_at_hz
        ),
        None => format!(
            "H2 above H1 at the median line; without limit at {:.0} Hz",
            bias.largest_at_hz
        ),
    }
}

/// What was averaged.
fn averaged<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> String {
    match &function.impact {
        Some(test) => format!("{} of {} hits", test.used(), test.hits.len()),
        None => format!("{} averages", function.averages),
    }
}

fn linear_words(distortion: &Distortion) -> String {
    match distortion.worst() {
        Some((level_db, band)) if level_db > -200.0 => format!(
            "At the level of this drive, distortion reaches −{:.0} dB re the response at {band}; even lines show even-order \
                distortion, odd lines odd-order distortion.",
            -level_db
        ),
        _ => "At the level of this drive, no distortion is above the noise.".into(),
    }
}

fn origin<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Markup {
    html! {
        section {
            h2 { "Origin of the data" }
            table {
                tr { th { "source" } td { (function.about.provenance.source) } }
                tr { th { "steps" } td { ol { @for step in &function.about.provenance.steps { li { (step) } } } } }
                @if let Some(setup) = &function.drive {
                    tr { th { "device" } td { (format!("gain {}, {:.3} V at full scale, {:.0} nF", setup.gain, setup.volts_per_full_scale, setup.load_f * 1e9)) } }
                }
                tr { th { "program" } td { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) } }
            }
        }
    }
}
