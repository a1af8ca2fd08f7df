//! Stub.
/// Relief.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Relief {
    Isotropic {
        ra_m: f64,
        grain_m: f64,
        correlation_per_grain: f64,
        hurst: f64,
        skewness: f64,
    },
    Dots {
        height_m: f64,
        diameter_m: f64,
        wavelength_m: f64,
        edge_m: f64,
        roughness_m: f64,
    },
    Ridges {
        wavelength_m: f64,
        depth_m: f64,
        roughness_m: f64,
    },
}
/// Patch.
#[derive(Debug)]
pub struct Patch;
/// Error.
#[derive(Debug)]
pub struct SurfaceError;
