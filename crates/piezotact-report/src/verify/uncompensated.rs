//! The texture sent directly to the device, without its transfer function: measured in the demo, computed elsewhere.

use maud::{Markup, html};
use piezotact::verify::{UncompensatedOutcome, Verification};

use super::Uncompensated;
use crate::{DrawError, figure, figures};
use piezotact::number::digits;

/// The negative control, measured.
pub(super) fn measured(
    rendered: &Verification,
    uncompensated: &Uncompensated<Verification>,
) -> Result<Markup, DrawError> {
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
    let (loud, fitting) = (&uncompensated.as_it_stands, &uncompensated.turned_down);
    Ok(html! {
        section {
            h2 { "Negative control: the texture sent directly to the device" }
            p { "Without compensation by the transfer function, the device reproduces a different spectrum. The texture was \
                sent unscaled (1 m/s² as a drive of 1), which the device clips; and attenuated until nothing clips, compared \
                after subtracting the mean error." }
            table {
                tr { th { "strategy" } th.n { (format!("spectrum error, rms over {}", rendered.band_hz)) } th.n { "waveform correlation" } th.n { "clipped" } }
                (row("rendered through the transfer function", rendered, rendered.error_db_rms))
                (row("sent directly, unscaled", loud, loud.error_db_rms))
                (row("sent directly, attenuated until nothing clips, level-matched", fitting, fitting.error_db_rms_level_matched))
            }
            (figure(&figures::uncompensated(uncompensated)?, "Measured response to the texture sent directly: unscaled, and attenuated."))
        }
    })
}

/// What the transfer function says that would come of it.
pub(super) fn predicted(
    rendered: &Verification,
    predicted: &UncompensatedOutcome,
) -> Result<Markup, DrawError> {
    let title = "The texture sent directly to the device (computed, not measured)";
    let predicted = match predicted {
        UncompensatedOutcome::Predicted(predicted) => predicted,
        UncompensatedOutcome::NotComputed { not_computed } => {
            return Ok(
                html! { section { h2 { (title) } p.soft { "Not computed: " (not_computed) } } },
            );
        }
    };
    let row = |what: &str, band: &str, error_db: f64, correlation: f64| {
        html! {
            tr {
                td { (what) }
                td { (band) }
                td.n { (format!("{error_db:.2} dB")) }
                td.n { (format!("{correlation:.3}")) }
            }
        }
    };
    let band = predicted.judged_band(rendered);
    let measured_db = rendered
        .error_db_rms_achievable
        .unwrap_or(rendered.error_db_rms);
    Ok(html! {
        section {
            h2 { (title) }
            p { "The response expected if the texture itself were the drive: the texture filtered by the transfer function, \
                without noise, distortion or clipping. Texture and drive have no common scale, so the level is matched: the \
                mean error over the evaluated lines is subtracted." }
            table {
                tr { th { "strategy" } th { "evaluated band" } th.n { "spectrum error, rms" } th.n { "waveform correlation" } }
                (row("measured, rendered through the transfer \
                    function", &rendered.judged_band(), measured_db, rendered.waveform_correlation))
                (row("sent directly, computed, level-matched", &band, predicted.error_db_rms_level_matched, predicted.waveform_correlation))
            }
            (figure(
                &figures::predicted(rendered, predicted)?,
                &format!(
                    "PSDs of the target and of the target filtered by the transfer function ({} dB subtracted to match the \
                        level). Shaded: the evaluated band.",
                    digits(predicted.level_difference_db).replace('-', "−")
                ),
            ))
        }
    })
}
