//! The drive: beside the texture that it was made of, and below what the device can do.

use super::super::{DriveSource, Verification};
use super::{ShownDrive, figures};
use crate::number::digits;
use crate::page::Block;
use crate::quantity::Band;
use crate::render::Rendering;

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
pub(super) fn beside_texture(v: &Verification, shown: &ShownDrive<'_>) -> Vec<Block> {
    let both = match &shown.beside.found {
        Ok(both) => both,
        Err(error) => return vec![Block::note(format!("Not shown: {error}"))],
    };
    let (lead_ms, why) = (shown.beside.lead.0 * 1e3, reason(shown.beside.lead_from));
    let spectra = figures::beside_spectra(v, both).captioned(format!(
        "PSDs of the texture and of the drive computed from it, each divided by its own mean square within {}, since their units \
         differ: {} m/s² rms and {} of full scale rms.",
        v.band_hz,
        digits(both.target_rms),
        digits(both.drive_rms)
    ));
    let waveforms = figures::beside_waveforms(v, both).captioned(format!(
        "The same 150 ms as above, both band-limited to {} and divided by their rms. The drive is shifted earlier by {lead_ms:.1} ms: \
         {why}.",
        v.band_hz
    ));
    vec![
        Block::text(
            "Where the device responds strongly, the drive is weak; where it responds weakly, the drive is strong. The spectrum of the \
             drive therefore has a different shape from that of the texture.",
        ),
        spectra.into(),
        waveforms.into(),
    ]
}

/// The drive below its limit.
pub(super) fn headroom(shown: &ShownDrive<'_>, rendering: Option<&Rendering>) -> Vec<Block> {
    let as_it_was = match shown.beside.source {
        DriveSource::Recorded => "as it was played",
        DriveSource::Rendered => "as it was rendered",
    };
    let mut blocks = Vec::new();
    if let Some(rendering) = rendering {
        let list = |bands: &[Band]| {
            let bands: Vec<String> = bands.iter().map(ToString::to_string).collect();
            bands.join(", ")
        };
        let given_up = match rendering.given_up_band_hz.as_slice() {
            [] => String::new(),
            bands => format!(" Given up: {}.", list(bands)),
        };
        blocks.push(Block::text(format!(
            "The drive as computed: {}.",
            rendering.headroom.text()
        )));
        blocks.push(Block::text(format!(
            "Reached: {}.{given_up}",
            list(&rendering.achievable_band_hz)
        )));
    }
    let figure = figures::drive(shown.series, shown.limit);
    let caption = format!("The drive {as_it_was}. Red: where the device clips.");
    blocks.push(figure.captioned(caption).into());
    blocks
}
