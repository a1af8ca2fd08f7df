//! The report of a verification: how close a measurement came to its target, and why.

use maud::{Markup, html};
use piezotact::manipulate::Lineage;
use piezotact::quantity::{Acceleration, Drive};
use piezotact::recording::{BenchKind, Condition, Provenance, Recording};
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact::verify::Verification;
use piezotact_dataset::sidecar::Rendering;

use super::{document, figure, figures, transfer};
use crate::failure::Outcome;
use crate::output::headroom_text;

/// What a verification report shows.
pub(crate) struct Page<'a> {
    pub(crate) title: String,
    pub(crate) verification: &'a Verification,
    /// The texture as it was recorded.
    pub(crate) target: &'a Recording,
    pub(crate) function: Option<&'a TransferFunction<Drive, Acceleration>>,
    /// The drive, and the level at which the device clips.
    pub(crate) drive: Option<(&'a Series<Drive>, f64)>,
    pub(crate) rendering: Option<&'a Rendering>,
    pub(crate) provenance: &'a Provenance,
    pub(crate) condition: &'a Condition,
    /// The negative control: the texture sent straight to the device.
    pub(crate) straight: Option<&'a Straight<Verification>>,
}

/// The texture sent straight to the device, without its transfer function.
pub(crate) struct Straight<T> {
    /// One unit of texture as full scale.
    pub(crate) as_it_stands: T,
    /// Turned down until nothing clips.
    pub(crate) turned_down: T,
}

/// The report as HTML text.
pub(crate) fn render(page: &Page<'_>) -> Outcome<String> {
    let body = html! {
        h1 { (page.title) }
        p.soft { (bench_line(page)) }
        (verdict(page))
        (doubts(page))
        (spectra(page)?)
        (waveform(page)?)
        @if let Some(straight) = page.straight { (negative_control(page.verification, straight)?) }
        (transfer_function(page)?)
        (drive(page)?)
        (origin(page))
    };
    Ok(document(&page.title, &body))
}

fn bench_line(page: &Page<'_>) -> String {
    let kind = match page.provenance.bench {
        Some(BenchKind::Twin) => "Digital twin: no hardware and no person took part.",
        Some(BenchKind::Hardware) => "Measured on hardware.",
        None => "The measurement does not say which bench it comes from.",
    };
    let seed = page
        .provenance
        .seed
        .map_or(String::new(), |seed| format!(" Seed {seed}."));
    match page.condition.to_string() {
        nothing if nothing.is_empty() => format!("{kind}{seed}"),
        known => format!("{kind} Measured with {known}.{seed}"),
    }
}

fn verdict(page: &Page<'_>) -> Markup {
    let v = page.verification;
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    html! {
        section class=(if v.passed { "verdict" } else { "verdict failed" }) {
            strong { (v.verdict()) }
            div.numbers {
                (number(format!("{:.2} dB", v.error_db_rms), &format!("spectrum error, rms over {}", v.band_hz)))
                @if let Some(error_db) = v.error_db_rms_achievable {
                    (number(format!("{error_db:.2} dB"), "rms over the achievable part"))
                }
                (number(format!("{:.2} dB", v.error_db_max), &format!("largest error, at {:.0} Hz", v.error_max_at_hz)))
                (number(format!("{:+.2} dB", v.level_error_db), "level error in the band"))
                (number(format!("{:.3}", v.waveform_correlation), "waveform correlation, delay aligned"))
                (number(format!("{:.1} ms", v.delay_s * 1e3), &delay_words(page)))
                (number(format!("{:.2} %", v.clipped_fraction * 100.0), "samples at a limit"))
            }
        }
    }
}

fn delay_words(page: &Page<'_>) -> String {
    let modelling = page
        .rendering
        .map(|rendering| rendering.config.modelling_delay.0 * 1e3);
    match modelling {
        Some(modelling_ms) => format!(
            "delay taken away: {modelling_ms:.0} ms of silence before the texture, and the start of the devices"
        ),
        None => "delay taken away".into(),
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

fn doubts(page: &Page<'_>) -> Markup {
    let doubts = &page.verification.doubts;
    html! {
        section {
            h2 { "Doubts" }
            @if doubts.is_empty() {
                p.soft { "None: nothing had to be clamped, guessed or left out." }
            } @else {
                ul.doubts { @for doubt in doubts { li { (doubt) } } }
            }
        }
    }
}

fn spectra(page: &Page<'_>) -> Outcome<Markup> {
    let v = page.verification;
    Ok(html! {
        section {
            h2 { "Spectrum: what was meant and what was felt" }
            (figure(&figures::spectra(v)?, "Power spectral densities of the target and of the acceleration measured on the fingernail. Shaded: what is judged."))
            (figure(&figures::error(v)?, "Error of every line of the band. Red: the limit that its rms is judged by; single lines may cross it."))
            p.soft { (estimator_line(v)) }
        }
    })
}

fn waveform(page: &Page<'_>) -> Outcome<Markup> {
    Ok(html! {
        section {
            h2 { "Waveform" }
            p { "Spectra overlap even when every phase is wrong; waveforms do not." }
            (figure(&figures::waveforms(page.verification)?, "150 ms from the middle of the texture, both limited to the band that is compared, the measurement moved back by its delay."))
        }
    })
}

fn negative_control(rendered: &Verification, straight: &Straight<Verification>) -> Outcome<Markup> {
    let row = |what: &str, v: &Verification, error_db: f64| {
        html! {
            tr {
                td { (what) }
                td.n { (format!("{error_db:.2} dB")) }
                td.n { (format!("{:.3}", v.waveform_correlation)) }
                td.n { (format!("{:.1} %", v.clipped_fraction * 100.0)) }
            }
        }
    };
    let (loud, fitting) = (&straight.as_it_stands, &straight.turned_down);
    Ok(html! {
        section {
            h2 { "Negative control: the texture sent straight to the device" }
            p { "Without its transfer function the device answers with something else. The texture was sent as it stands, 1 m/s² as a drive of 1, which the device clips; and turned down until nothing clips, compared after the mean error is taken away." }
            table {
                tr { th { "strategy" } th.n { (format!("spectrum error, rms over {}", rendered.band_hz)) } th.n { "waveform correlation" } th.n { "clipped" } }
                (row("rendered through the transfer function", rendered, rendered.error_db_rms))
                (row("sent straight, at the device's own scale", loud, loud.error_db_rms))
                (row("sent straight without clipping, level-matched", fitting, fitting.error_db_rms_level_matched))
            }
            (figure(&figures::straight(straight)?, "What the finger feels when the texture is sent straight: at the device's own scale, and turned down."))
        }
    })
}

fn transfer_function(page: &Page<'_>) -> Outcome<Markup> {
    let Some(function) = page.function else {
        return Ok(html! {});
    };
    let shown = page
        .rendering
        .map_or(page.verification.band_hz, |rendering| {
            rendering.config.inverse.band
        });
    let figures = figures::transfer(function, shown, "(m/s²)/FS")?;
    Ok(html! {
        section {
            h2 { "Transfer function of the device with the finger on it" }
            p {
                (format!("{:?} from {} averages in steps of {:.2} Hz", function.estimator, function.averages, function.resolution_hz()))
                @if let Some(setup) = &function.drive {
                    (format!("; amplifier gain {}, {:.3} V at full scale", setup.gain, setup.volts_per_full_scale))
                }
                "."
            }
            @for (svg, caption) in figures.iter().zip(transfer::CAPTIONS) {
                (figure(svg, caption))
            }
        }
    })
}

fn drive(page: &Page<'_>) -> Outcome<Markup> {
    let Some((drive, limit)) = page.drive else {
        return Ok(html! {});
    };
    Ok(html! {
        section {
            h2 { "Drive and its headroom" }
            @if let Some(rendering) = page.rendering {
                @let headroom = &rendering.headroom;
                p { (format!(
                    "The drive as computed: {}.", headroom_text(headroom)
                )) }
                p {
                    "Achievable: "
                    @for (i, band) in rendering.achievable_band_hz.iter().enumerate() { @if i > 0 { ", " } (band) }
                    "."
                    @if !rendering.given_up_band_hz.is_empty() {
                        " Given up: "
                        @for (i, band) in rendering.given_up_band_hz.iter().enumerate() { @if i > 0 { ", " } (band) }
                        "."
                    }
                }
            }
            (figure(&figures::drive(drive, limit)?, "The drive as it was played. Red: where the device clips."))
        }
    })
}

/// What was done to the texture on purpose, up to its rendering where that is known.
fn lineage<'a>(page: &Page<'a>) -> Option<&'a Lineage> {
    let rendered = page.rendering.and_then(|r| r.provenance.lineage.as_ref());
    rendered.or(page.target.provenance.lineage.as_ref())
}

fn origin(page: &Page<'_>) -> Markup {
    html! {
        section {
            h2 { "Where it comes from" }
            table {
                tr { th { "texture" } td { (page.target.provenance.source) ol { @for step in &page.target.provenance.steps { li { (step) } } } } }
                @if let Some(lineage) = lineage(page) {
                    tr { th { "what was done" } td { (lineage.source) ol { @for step in &lineage.steps { li { (step) } } } } }
                }
                tr { th { "bench" } td { (page.provenance.source) } }
                tr { th { "measurement" } td { ol { @for step in &page.provenance.steps { li { (step) } } } } }
                @if let Some(rendering) = page.rendering {
                    tr { th { "transfer function" } td { ol { @for step in &rendering.provenance.steps { li { (step) } } } } }
                    tr { th { "rendering" } td { (format!(
                        "over {}, regularisation {:.1e}, modelling delay {}, fade {}, level {:+.1} dB",
                        rendering.config.inverse.band, rendering.config.inverse.regularisation,
                        rendering.config.modelling_delay, rendering.config.fade, rendering.level_db
                    )) } }
                }

                tr { th { "program" } td { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) } }
            }
        }
    }
}
