//! Topographies: the files of instruments, roughness after the standards, and its report.
//!
//! [`read_topography`] reads a file into heights in m. A profile goes through [`evaluated_profile`] or [`profile_roughness`], a map
//! through [`areal_roughness`]; an [`EvaluatedSurface`] or a [`RoughnessSet`] is `Shown`.

mod roughness;
pub mod topography;

pub use roughness::*;
pub use topography::{
    TopographyFile, TopographyKind, TopographyOptions, read_topography, topography_formats,
    write_sur,
};
