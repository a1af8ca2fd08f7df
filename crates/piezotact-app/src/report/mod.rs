//! Reports: one HTML file that holds everything it shows.

pub(crate) mod figures;

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use piezotact::quantity::{Acceleration, Drive};
use piezotact::recording::{BenchKind, Condition, Provenance};
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact::verify::Verification;
use piezotact_dataset::sidecar::Rendering;

use crate::failure::Outcome;

/// What a verification report shows.
pub(crate) struct Page<'a> {
    pub(crate) title: String,
    pub(crate) verification: &'a Verification,
    pub(crate) target: &'a Series<Acceleration>,
    pub(crate) function: Option<&'a TransferFunction<Drive, Acceleration>>,
    /// The drive, and the level at which the device clips.
    pub(crate) drive: Option<(&'a Series<Drive>, f64)>,
    pub(crate) rendering: Option<&'a Rendering>,
    pub(crate) provenance: &'a Provenance,
    pub(crate) condition: &'a Condition,
    /// The negative control: the texture sent straight to the device.
    pub(crate) straight: Option<&'a Verification>,
}

/// A file's name without its folder.
pub(crate) fn name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
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
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (page.title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body { main { (body) } }
        }
    };
    Ok(markup.into_string())
}

fn bench_line(page: &Page<'_>) -> String {
    let kind = match page.provenance.bench {
        Some(BenchKind::Twin) => "Digital twin: no hardware and no person took part.",
        Some(BenchKind::Hardware) => "Measured on hardware.",
        None => "The measurement does not say which bench it comes from.",
    };
    let condition = page.condition;
    let parts = [
        condition
            .participant
            .as_ref()
            .map(|participant| format!("participant {participant}")),
        condition.load_n.map(|load| format!("load {load}")),
        condition
            .angle_deg
            .map(|angle| format!("angle {}°", angle.0)),
        page.provenance.seed.map(|seed| format!("seed {seed}")),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if parts.is_empty() {
        kind.into()
    } else {
        format!("{kind} {}.", parts.join(", "))
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
                (number(format!("{:.2} ms", v.delay_s * 1e3), "delay that was taken away"))
                (number(format!("{:.2} %", v.clipped_fraction * 100.0), "samples at a limit"))
            }
        }
    }
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

fn figure(svg: &str, caption: &str) -> Markup {
    html! { figure { (PreEscaped(svg)) figcaption { (caption) } } }
}

fn spectra(page: &Page<'_>) -> Outcome<Markup> {
    let v = page.verification;
    Ok(html! {
        section {
            h2 { "Spectrum: what was meant and what was felt" }
            (figure(&figures::spectra(v)?, "Power spectral densities of the target and of the acceleration measured on the fingernail. Shaded: the band that is judged."))
            (figure(&figures::error(v)?, "Error of every line. Red: the limit on its rms."))
        }
    })
}

fn waveform(page: &Page<'_>) -> Outcome<Markup> {
    Ok(html! {
        section {
            h2 { "Waveform" }
            p { "Spectra overlap even when every phase is wrong; waveforms do not." }
            (figure(&figures::waveforms(page.target, &page.verification.aligned)?, "150 ms from the middle of the texture, the measurement moved back by its delay."))
        }
    })
}

fn negative_control(rendered: &Verification, straight: &Verification) -> Outcome<Markup> {
    let row = |what: &str, error: f64, correlation: f64| {
        html! {
            tr { td { (what) } td.n { (format!("{error:.2} dB")) } td.n { (format!("{correlation:.3}")) } }
        }
    };
    Ok(html! {
        section {
            h2 { "Negative control: the texture sent straight to the device" }
            p { "Without its transfer function the device answers with something else. Here 1 m/s² of texture was sent as a drive of 1, as it stands." }
            table {
                tr { th { "strategy" } th.n { (format!("spectrum error, rms over {}", straight.band_hz)) } th.n { "waveform correlation" } }
                (row("rendered through the transfer function", rendered.error_db_rms, rendered.waveform_correlation))
                (row("sent straight, at the device's own scale", straight.error_db_rms, straight.waveform_correlation))
                (row("sent straight, level-matched", straight.error_db_rms_level_matched, straight.waveform_correlation))
            }
            (figure(&figures::straight(straight)?, "What the finger feels when the texture is sent straight, at the device's own scale and shifted to the target's level."))
        }
    })
}

fn transfer_function(page: &Page<'_>) -> Outcome<Markup> {
    let Some(function) = page.function else {
        return Ok(html! {});
    };
    let figures = figures::transfer(function, page.verification.band_hz)?;
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
            @for (svg, caption) in figures.iter().zip(["Magnitude.", "Phase.", "Coherence: how much of the response the drive explains."]) {
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
                    "The drive peaks at {:.3} of full scale, {:.1} dB below {} at {:.3}.",
                    headroom.peak, headroom.headroom_db, headroom.limited_by, headroom.limit
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

fn origin(page: &Page<'_>) -> Markup {
    html! {
        section {
            h2 { "Where it comes from" }
            table {
                tr { th { "bench" } td { (page.provenance.source) } }
                tr { th { "measurement" } td { ol { @for step in &page.provenance.steps { li { (step) } } } } }
                @if let Some(rendering) = page.rendering {
                    tr { th { "rendering" } td { (format!(
                        "over {}, regularisation {:.1e}, modelling delay {}, fade {}, level {:+.1} dB",
                        rendering.config.inverse.band, rendering.config.inverse.regularisation,
                        rendering.config.modelling_delay, rendering.config.fade, rendering.level_db
                    )) } }
                }
                @if let Some(function) = page.function {
                    tr { th { "transfer function" } td { ol { @for step in &function.provenance.steps { li { (step) } } } } }
                }
                tr { th { "program" } td { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) } }
            }
        }
    }
}
