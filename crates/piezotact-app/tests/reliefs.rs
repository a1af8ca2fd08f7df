//! The reliefs of the twin's samples, by the roughness that an instrument would find.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use piezotact_surface::{ArealConfig, ArealRoughness, Form, areal_roughness};
use piezotact_twin::Relief;

/// Ra and grain, µm: *thesis* Table 3 with the grains of its papers; the last is the plain plate.
const ISOTROPIC_UM: [(f64, f64); 14] = [
    (74.6, 425.0),
    (43.7, 269.0),
    (33.6, 201.0),
    (14.4, 125.0),
    (11.7, 82.0),
    (6.6, 58.5),
    (5.2, 35.0),
    (5.2, 25.8),
    (4.6, 21.8),
    (4.5, 5.5),
    (4.4, 10.3),
    (4.3, 8.8),
    (3.8, 18.3),
    (0.1, 20.0),
];
fn isotropic(ra_um: f64, grain_um: f64, skewness: f64) -> Relief {
    Relief::Isotropic {
        ra_m: ra_um * 1e-6,
        grain_m: grain_um * 1e-6,
        correlation_per_grain: 1.5,
        hurst: 0.8,
        skewness,
    }
}

fn roughness(relief: &Relief, sample: &str) -> ArealRoughness {
    let map = relief.height_map(&relief.usual_patch(), 7, sample).unwrap();
    let config = ArealConfig {
        form: Form::Mean,
        s_nesting_m: None,
        l_nesting_m: None,
    };
    areal_roughness(&map, &config).unwrap()
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_isotropic_samples_have_no_direction() {
    for (i, (ra_um, grain_um)) in ISOTROPIC_UM.into_iter().enumerate() {
        let sample = format!("S{}", i + 1);
        let found = roughness(&isotropic(ra_um, grain_um, 0.5), &sample);
        // The contour of the map's thousands of independent patches is nearly round.
        let round = found.str_ratio.unwrap();
        assert!(round > 0.8, "{sample}: Str {round}");
        // The autocorrelation is x^H·K_H(x)·2^(1−H)/Γ(H), x = 2πr/Lc: 0.2 at x = 2.124 for H = 0.8. Chance moves the
        // nearest point of the contour by a few percent; the skewing and the cut at 2 µm do less.
        let per_length = found.sal_m.unwrap() / (1.5 * grain_um * 1e-6);
        let off = per_length / (2.124 / TAU) - 1.0;
        assert!(off.abs() < 0.08, "{sample}: Sal is off by {off}");
    }
}

#[test]
fn ridges_never_end() {
    let ridges = Relief::Ridges {
        wavelength_m: 0.5e-3,
        depth_m: 0.1e-3,
        roughness_m: 2e-6,
    };
    assert_eq!(roughness(&ridges, "plate").str_ratio, None);
}
