//! Sound devices: which there are, their calibration, their latency.

#[cfg(feature = "audio")]
pub(super) mod calibrate;
#[cfg(feature = "audio")]
pub(super) mod devices;
#[cfg(feature = "audio")]
pub(super) mod latency;
#[cfg(feature = "audio")]
pub(crate) mod plant;

#[cfg(not(feature = "audio"))]
super::lacking::lacking! {
    calibrate(Arguments), "calibrate";
    devices(Arguments), "devices";
    latency(Arguments), "latency";
    plant(Arguments), "twin plant";
}

/// Writes what was measured at a place, and keeps what stood there under a free name.
#[cfg(feature = "audio")]
fn keep<T: piezotact::document::Content>(
    (out, earlier): (&std::path::Path, &'static str),
    found: &T,
) -> crate::failure::Outcome {
    let earlier = crate::keeping::Earlier::at(out, earlier)?;
    let text = crate::output::document_text(found, Some(out))?;
    crate::output::write_text(out, &text)?;
    earlier.settle()
}
