//! What the tests of topographies share.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::Path;

use piezotact::surface::HeightMap;
use piezotact_dataset::ReadError;
use piezotact_surface::Topography;
use piezotact_surface::topography::parse_topography;
use piezotact_surface::{TopographyFile, TopographyOptions};

pub(crate) const STATED: TopographyOptions = TopographyOptions {
    step_m: Some(2e-6),
    coordinate_unit_m: Some(1e-3),
    height_unit_m: Some(1e-6),
};
pub(crate) const NOTHING: TopographyOptions = TopographyOptions {
    step_m: None,
    coordinate_unit_m: None,
    height_unit_m: None,
};

pub(crate) fn parse(
    bytes: &[u8],
    options: &TopographyOptions,
) -> Result<TopographyFile, ReadError> {
    parse_topography(Path::new("t"), bytes, options)
}

pub(crate) fn map(file: &TopographyFile) -> &HeightMap {
    match &file.topography {
        Topography::Map(map) => map,
        Topography::Profile(_) => unreachable!("a map"),
    }
}

pub(crate) fn assert_heights(file: &TopographyFile, expected: &[f64]) {
    let heights = match &file.topography {
        Topography::Map(map) => map.heights_m(),
        Topography::Profile(profile) => profile.heights_m(),
    };
    assert_eq!(heights.len(), expected.len());
    for (got, expected) in heights.iter().zip(expected) {
        assert_eq!(got.is_nan(), expected.is_nan(), "{heights:?}");
        assert!(
            got.is_nan() || (got - expected).abs() <= 1e-6 * expected.abs().max(1e-9),
            "{got} {expected}"
        );
    }
}

pub(crate) fn assert_refused(bytes: &[u8], part: &str) {
    let error = parse(bytes, &NOTHING).unwrap_err().to_string();
    assert!(error.contains(part), "{part}: {error}");
    assert!(error.contains("expected") && error.contains(';'), "{error}");
}

/// Every truncation, and 2000 flipped bytes: an error or heights, never a panic.
pub(crate) fn attack(bytes: &[u8]) {
    for length in 0..bytes.len() {
        let _ = parse(&bytes[..length], &STATED);
    }
    let mut damaged = bytes.to_vec();
    let mut random = Lcg(11);
    for _ in 0..2000 {
        let (at, mask) = (random.below(bytes.len()), 1 + random.below(255) as u8);
        damaged[at] ^= mask;
        if let Err(error) = parse(&damaged, &STATED) {
            assert!(error.to_string().contains(';'), "{error}");
        }
        damaged[at] ^= mask;
    }
}

/// Numbers that look random, the same on every machine.
pub(crate) struct Lcg(pub(crate) u64);

impl Lcg {
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit.max(1)
    }
}

/// Sums of twelve uniform numbers less six, from Knuth's linear congruential generator.
pub(crate) fn noise(seed: u64) -> impl Iterator<Item = f64> {
    let mut state = seed;
    std::iter::from_fn(move || {
        let mut total = 0.0;
        for _ in 0..12 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            total += (state >> 11) as f64 / (1u64 << 53) as f64;
        }
        Some(total - 6.0)
    })
}
