//! The protocols that come with the program: those of the thesis, and two of thresholds.

use super::{Protocol, ProtocolError, read};

/// The protocols by name, as TOML.
pub const LIBRARY: [(&str, &str); 7] = [
    (
        "periodic_pilot",
        include_str!("../../../protocols/periodic_pilot.toml"),
    ),
    (
        "isotropic_triplets",
        include_str!("../../../protocols/isotropic_triplets.toml"),
    ),
    (
        "amplitude_inversion",
        include_str!("../../../protocols/amplitude_inversion.toml"),
    ),
    (
        "averaged_transfer_function",
        include_str!("../../../protocols/averaged_transfer_function.toml"),
    ),
    (
        "touch_control_imagery",
        include_str!("../../../protocols/touch_control_imagery.toml"),
    ),
    (
        "roughness_jnd",
        include_str!("../../../protocols/roughness_jnd.toml"),
    ),
    (
        "detection_threshold",
        include_str!("../../../protocols/detection_threshold.toml"),
    ),
];

/// The protocol called `name`, or `None`.
///
/// # Errors
/// [`ProtocolError`]; not for those of [`LIBRARY`], which a test reads.
///
/// Source: thesis 2.6, 4.3, 4.4, 5.3, 6.2; `roughness_jnd`, `detection_threshold`: docs/decisions/campaigns.md.
pub fn from_library(name: &str) -> Result<Option<Protocol>, ProtocolError> {
    LIBRARY
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, toml)| read(toml))
        .transpose()
}
