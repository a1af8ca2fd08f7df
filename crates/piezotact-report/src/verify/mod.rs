//! The report of a verification: how close a measurement came to its target, and why.

mod also;
mod before;
mod drive;
mod uncompensated;

use maud::{Markup, html};
use piezotact::document::Words;
use piezotact::lineage::Lineage;
use piezotact::number::plus;
use piezotact::quantity::{Acceleration, Drive};
use piezotact::recording::{Condition, Provenance, Recording};
use piezotact::render::Rendering;
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact::verify::{Tones, UncompensatedOutcome, Verdict, Verification};

use crate::chart::HEIGHT;
use crate::criteria::outcome;
use crate::report::warnings_section;
use crate::{DrawError, UNKNOWN_BENCH, bench_text, document, figure, figures, origin};

pub use also::{Also, Stated};
pub use before::Before;
pub use drive::ShownDrive;

/// What a verification report shows.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    pub title: String,
    pub verification: &'a Verification,
    /// The amplitude spectra of target and measurement.
    pub tones: Tones,
    /// The texture as it was recorded.
    pub target: &'a Recording,
    /// The transfer function that it was rendered through; absent where it is not shown.
    pub function: Option<&'a TransferFunction<Drive, Acceleration>>,
    /// The texture as it is compared, at its own level.
    pub texture: &'a Series<Acceleration>,
    /// What the measurement is called.
    pub measured: &'a str,
    /// The drive; absent where none was recorded or stated.
    pub drive: Option<ShownDrive<'a>>,
    /// How the drive was made; absent where nothing says it.
    pub rendering: Option<&'a Rendering>,
    /// Where the measurement comes from.
    pub provenance: &'a Provenance,
    pub condition: &'a Condition,
    /// The predicted result of sending the texture directly to the device.
    pub predicted: Option<&'a UncompensatedOutcome>,
    /// Further measurements of the same target.
    pub also: Vec<Also<'a>>,
    /// The textures before the target was made of them.
    pub before: Vec<Before<'a>>,
    /// The negative control: the texture sent directly to the device.
    pub uncompensated: Option<&'a Uncompensated<Verification>>,
}

/// The texture sent directly to the device, without its transfer function.
#[derive(Clone, Debug)]
pub struct Uncompensated<T> {
    /// One unit of texture as full scale.
    pub as_it_stands: T,
    /// Turned down until nothing clips.
    pub turned_down: T,
}

/// The report as HTML, with warnings in `words`.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn html(page: &Page<'_>, words: &dyn Words) -> Result<String, DrawError> {
    let body = html! {
        h1 { (page.title) }
        p.soft { (bench_line(page)) }
        (verdict(page))
        (warnings_section(&page.verification.warnings.merged(), words))
        (spectra(page)?)
        (waveform(page)?)
        (also::section(page, words)?)
        (before::section(page)?)
        (drive::beside_texture(page)?)
        (transfer_function(page)?)
        (drive::headroom(page)?)
        @if let Some(uncompensated) = page.uncompensated { (uncompensated::measured(page.verification, uncompensated)?) }
        @if let Some(predicted) = page.predicted { (uncompensated::predicted(page.verification, predicted)?) }
        (origin_of(page))
    };
    Ok(document(&page.title, &body))
}

fn bench_line(page: &Page<'_>) -> String {
    let kind = bench_text(page.provenance.bench).unwrap_or(UNKNOWN_BENCH);
    let seed = page
        .provenance
        .seed
        .map_or(String::new(), |seed| format!(" Seed {seed}."));
    match page.condition.to_string() {
        nothing if nothing.is_empty() => format!("{kind}{seed}"),
        known => format!("{kind} Measured with {known}.{seed}"),
    }
}

/// The style of a verdict.
fn class_of(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Passed => "verdict",
        Verdict::PassedInPart { .. } | Verdict::NotDecided => "verdict open",
        Verdict::NotPassed => "verdict failed",
    }
}

fn verdict(page: &Page<'_>) -> Markup {
    let v = page.verification;
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    html! {
        section class=(class_of(v.verdict)) {
            strong { (v.verdict.word()) }
            p { (v.sentence()) }
            div.numbers {
                (number(format!("{:.2} dB", v.error_db_rms), &format!("spectrum error as measured, rms over {}", v.band_hz)))
                @if let Some(error_db) = v.error_db_rms_achievable {
                    (number(format!("{error_db:.2} dB"), "spectrum error, rms over the reached part of the band"))
                }
                (number(format!("{:.2} dB", v.error_db_max), &format!("largest error, at {:.0} Hz", v.error_max_at_hz)))
                (number(format!("{} dB", plus(v.level_error_db, 2)), "level error in the band"))
                (number(format!("{:.3}", v.waveform_correlation), "waveform correlation after alignment of the delay"))
                (number(format!("{:.1} ms", v.delay_s * 1e3), &delay_words(page)))
                (number(format!("{:.2} %", v.clipped_fraction * 100.0), "samples at a limit"))
            }
        }
        (criteria(v))
    }
}

/// Every criterion with what was found: the verdict follows from them.
fn criteria(v: &Verification) -> Markup {
    let intervals = v.criteria.iter().any(|c| c.interval.is_some());
    html! {
        section {
            h2 { "Criteria" }
            div.wide {
                table.judged {
                    tr { th { "criterion" } th { "outcome" } th.n { "found" } @if intervals { th.n { "95 % interval" } } th { "limit" } }
                    @for c in &v.criteria {
                        tr {
                            td { (c.what) }
                            td { (outcome(c.outcome)) }
                            td.n { (c.found_text()) }
                            @if intervals { td.n { @if c.interval.is_some() { (c.interval_text()) } @else { "–" } } }
                            td.limit { (c.limit_text()) }
                        }
                    }
                }
            }
            p.soft { "The verdict follows from these criteria: if one is not met, it is “not passed”; if one is not decided, “not decided”; if only part of the target could be evaluated, “passed in part”. Errors and levels here are those of the vibration alone: the sensor noise, measured before and after the texture, and the scatter of estimates of this length are subtracted. They are for " (v.judged_band()) "; the numbers above are as measured over all of " (v.band_hz) ", with noise and scatter, and therefore differ." }
        }
    }
}

fn delay_words(page: &Page<'_>) -> String {
    let modelling = page
        .rendering
        .map(|rendering| rendering.config.modelling_delay.0 * 1e3);
    match modelling {
        Some(modelling_ms) => format!(
            "delay removed: {modelling_ms:.0} ms of silence before the texture, plus the start delay of the devices"
        ),
        None => "delay removed".into(),
    }
}

fn estimator_line(v: &Verification) -> String {
    format!(
        "PSDs by Welch's method at {} Hz: {} window, segments of {} samples ({:.2} Hz), {:.0} % overlap, {} averages; one-sided, in {}. Error: unweighted rms over the lines of the band.",
        v.rate_hz,
        v.welch.window.name(),
        v.welch.segment,
        v.rate_hz / v.welch.segment as f64,
        v.welch.overlap * 100.0,
        v.averages,
        v.psd_unit
    )
}

fn spectra(page: &Page<'_>) -> Result<Markup, DrawError> {
    let v = page.verification;
    let tones = &page.tones;
    Ok(html! {
        section {
            h2 { "Target and measured spectrum" }
            (figure(&figures::spectra(v)?, "Power spectral densities of the target and of the acceleration measured on the fingernail, and below the error at each spectral line. Shaded: the evaluated band. Red: the limit for the rms of the error; single lines may exceed it."))
            p.soft { (estimator_line(v)) }
            (figure(&figures::amplitudes(v, tones)?, &amplitudes_line(v, tones)))
        }
    })
}

/// How the amplitude spectra were computed.
fn amplitudes_line(v: &Verification, tones: &Tones) -> String {
    format!(
        "Amplitude spectra (FFT) of target and measurement within {}: a tone, for example of a periodic texture, is shown at its peak amplitude. Computed with a {} window over segments of {} samples ({:.2} s, lines {:.2} Hz apart), {:.0} % overlap, {} averages of power; single-sided, each line divided by the sum of the window, so that the amplitude of a tone is correct within 0.1 %. For noise, the amplitude depends on the width of the spectral lines: use the PSD.",
        v.band_hz,
        tones.welch.window.name(),
        tones.welch.segment,
        tones.welch.segment as f64 / v.rate_hz,
        v.rate_hz / tones.welch.segment as f64,
        tones.welch.overlap * 100.0,
        tones.averages,
    )
}

fn waveform(page: &Page<'_>) -> Result<Markup, DrawError> {
    Ok(html! {
        section {
            h2 { "Waveform" }
            p { "Spectra can agree even if every phase is wrong; waveforms cannot." }
            (figure(&figures::waveforms(page.verification)?, "150 ms from the middle of the texture, both limited to the \
                compared band; the measurement is shifted earlier by its delay."))
        }
    })
}

fn transfer_function(page: &Page<'_>) -> Result<Markup, DrawError> {
    let Some(function) = page.function else {
        return Ok(html! {});
    };
    let shown = page
        .rendering
        .map_or(page.verification.band_hz, |rendering| {
            rendering.config.inverse.band
        });
    let shown = piezotact::transfer::figure(function, shown, "(m/s²)/FS");
    let drawn = figure(&crate::svg(&shown, HEIGHT)?, &shown.caption);
    Ok(html! {
        section {
            h2 { "Transfer function of the device with the finger on it" }
            p {
                (format!("{} from {} averages in steps of {:.2} Hz", function.estimator, function.averages, function.resolution_hz()))
                @if let Some(setup) = &function.drive {
                    (format!("; amplifier gain {}, {:.3} V at full scale", setup.gain, setup.volts_per_full_scale))
                }
                "."
            }
            (drawn)
        }
    })
}

/// The manipulations of the texture, up to its rendering where that is known.
fn lineage<'a>(page: &Page<'a>) -> Option<&'a Lineage> {
    let rendered = page
        .rendering
        .and_then(|r| r.about.provenance.lineage.as_ref());
    rendered.or(page.target.about.provenance.lineage.as_ref())
}

fn origin_of(page: &Page<'_>) -> Markup {
    let of_texture = &page.target.about.provenance;
    let rows = html! {
        (origin::traced("texture", &of_texture.source, &of_texture.steps))
        @if let Some(lineage) = lineage(page) {
            (origin::traced("processing steps", &lineage.source, &lineage.steps))
        }
        (origin::row("bench", &page.provenance.source))
        (origin::row("measurement", &origin::steps(&page.provenance.steps)))
        @if let Some(rendering) = page.rendering {
            (origin::row("transfer function", &origin::steps(&rendering.about.provenance.steps)))
            (origin::row("rendering", &format!(
                "over {}, regularisation {:.1e}, modelling delay {}, fade {}, level {} dB",
                rendering.config.inverse.band, rendering.config.inverse.regularisation,
                rendering.config.modelling_delay, rendering.config.fade, plus(rendering.level_db, 1)
            )))
        }
    };
    origin::section("Origin of the data", &rows)
}
