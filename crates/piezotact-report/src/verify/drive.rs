//! The drive: beside the texture that it was made of, and below what the device can do.

use maud::{Markup, html};
use piezotact::quantity::Drive;
use piezotact::series::Series;
use piezotact::verify::{Beside, DriveBeside, DriveSource};

use super::Page;
use crate::{DrawError, figure, figures};
use piezotact::number::digits;

/// The drive that is shown.
#[derive(Clone, Debug)]
pub struct ShownDrive<'a> {
    /// Its samples, full scale = 1.
    pub series: &'a Series<Drive>,
    /// The level at which the device clips.
    pub limit: f64,
    /// The drive beside the texture.
    pub beside: DriveBeside,
}

/// Why a drive begins so long before the texture.
fn reason(source: DriveSource) -> &'static str {
    match source {
        DriveSource::Rendered => "the modelling delay that it was rendered with",
        DriveSource::Recorded => {
            "the delay of the measurement that it was recorded with: the modelling delay plus the start delay of the devices"
        }
    }
}

/// The texture and its drive: spectra and waveforms.
pub(super) fn beside_texture(page: &Page<'_>) -> Result<Markup, DrawError> {
    let Some(shown) = &page.drive else {
        return Ok(html! {});
    };
    let (lead, why) = (shown.beside.lead, reason(shown.beside.lead_from));
    let title = "Texture and drive";
    let both: &Beside = match &shown.beside.found {
        Ok(both) => both,
        Err(error) => {
            return Ok(html! { section { h2 { (title) } p.soft { "Not shown: " (error) } } });
        }
    };
    let v = page.verification;
    Ok(html! {
        section {
            h2 { (title) }
            p { "Where the device responds strongly, the drive is weak; where it responds weakly, the drive is strong. The \
                spectrum of the drive therefore has a different shape from that of the texture." }
            (figure(
                &figures::beside_spectra(v, both)?,
                &format!(
                    "PSDs of the texture and of the drive computed from it, each divided by its own mean square within {}, \
                        since their units differ: {} m/s² rms and {} of full scale rms.",
                    v.band_hz, digits(both.target_rms), digits(both.drive_rms)
                ),
            ))
            (figure(
                &figures::beside_waveforms(v, both)?,
                &format!(
                    "The same 150 ms as above, both band-limited to {} and divided by their rms. The drive is shifted earlier \
                        by {:.1} ms: {why}.",
                    v.band_hz, lead.0 * 1e3
                ),
            ))
        }
    })
}

/// The drive below its limit.
pub(super) fn headroom(page: &Page<'_>) -> Result<Markup, DrawError> {
    let Some(shown) = &page.drive else {
        return Ok(html! {});
    };
    let as_it_was = match shown.beside.source {
        DriveSource::Recorded => "as it was played",
        DriveSource::Rendered => "as it was rendered",
    };
    Ok(html! {
        section {
            h2 { "Drive and its headroom" }
            @if let Some(rendering) = page.rendering {
                @let headroom = &rendering.headroom;
                p { (format!(
                    "The drive as computed: {}.", headroom.text()
                )) }
                p {
                    "Reached: "
                    @for (i, band) in rendering.achievable_band_hz.iter().enumerate() { @if i > 0 { ", " } (band) }
                    "."
                    @if !rendering.given_up_band_hz.is_empty() {
                        " Given up: "
                        @for (i, band) in rendering.given_up_band_hz.iter().enumerate() { @if i > 0 { ", " } (band) }
                        "."
                    }
                }
            }
            (figure(&figures::drive(shown.series, shown.limit)?, &format!("The drive {as_it_was}. Red: where the device clips.")))
        }
    })
}
