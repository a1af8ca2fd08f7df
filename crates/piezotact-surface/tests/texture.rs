//! The period of textured maps, and maps that look like one and have none.

#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use crate::support::noise;
use piezotact::criterion::Outcome;
use piezotact::surface::HeightMap;
use piezotact_surface::{
    ArealConfig, Form, PeriodicTexture, Texture, TextureKind, areal_roughness,
};

const STEP_M: f64 = 2e-6;

/// A map of `columns` × `rows` heights by their place in m.
fn map_of(columns: usize, rows: usize, height_m: impl Fn(f64, f64) -> f64) -> HeightMap {
    let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let heights = places.map(|(x, y)| height_m(x as f64 * STEP_M, y as f64 * STEP_M));
    HeightMap::new(heights.collect(), columns, STEP_M, STEP_M).unwrap()
}

/// `map` with Gaussian noise of this standard deviation.
fn noisy(map: &HeightMap, seed: u64, deviation_m: f64) -> HeightMap {
    let heights = map.heights_m().iter().zip(noise(seed));
    map.with_heights(heights.map(|(z, w)| z + deviation_m * w).collect())
}

fn texture_of(map: &HeightMap) -> Texture {
    let config = ArealConfig {
        form: Form::Level,
        s_nesting_m: None,
        l_nesting_m: None,
    };
    areal_roughness(map, &config).unwrap().texture.unwrap()
}

#[track_caller]
fn periodic(map: &HeightMap) -> PeriodicTexture {
    let found = texture_of(map);
    assert!(found.criteria.iter().all(|c| c.outcome == Outcome::Met));
    found.periodic.unwrap()
}

#[track_caller]
fn check(what: &str, found: f64, expected: f64, share: f64) {
    assert!(
        (found / expected - 1.0).abs() <= share,
        "{what}: {found:e} for {expected:e}"
    );
}

/// Dots as high as a cosine bell of 10 µm, their diameter at half height 30 µm, on a lattice of two neighbours.
fn bells(x_m: f64, y_m: f64, a: (f64, f64), b: (f64, f64)) -> f64 {
    let area = a.0 * b.1 - a.1 * b.0;
    let (u, v) = (
        (x_m * b.1 - y_m * b.0) / area,
        (y_m * a.0 - x_m * a.1) / area,
    );
    let near = |t: f64| [t.floor(), t.ceil()];
    let distances = near(u).into_iter().flat_map(|i| near(v).map(|j| (i, j)));
    let nearest = distances
        .map(|(i, j)| (x_m - i * a.0 - j * b.0).hypot(y_m - i * a.1 - j * b.1))
        .fold(f64::MAX, f64::min);
    5e-6 * (1.0 + (nearest / 60e-6 * TAU).min(TAU / 2.0).cos())
}

fn turned(length_m: f64, degrees: f64) -> (f64, f64) {
    let angle = degrees.to_radians();
    (length_m * angle.cos(), length_m * angle.sin())
}

#[test]
fn oblique_ridges_have_their_period_height_and_width() {
    for degrees in [0.0, 17.0, 52.0, 90.0, -35.0] {
        let (x, y) = turned(1.0, degrees);
        // Flat ridges of 12 of 40 µm, 10 µm high, with flanks of one step on each side.
        let map = map_of(300, 260, |x_m, y_m| {
            let phase = ((x_m * x + y_m * y) / 40e-6).rem_euclid(1.0) * 40e-6;
            10e-6 * ((6e-6 - (phase - 20e-6).abs()) / STEP_M + 0.5).clamp(0.0, 1.0)
        });
        let found = periodic(&noisy(&map, 3, 1e-6));
        assert_eq!(found.kind, TextureKind::Ridges, "{degrees}");
        check("period", found.period_m, 40e-6, 0.002);
        check("height", found.height_m, 10e-6, 0.1);
        check("width", found.width_m, 12e-6, 0.1);
        let off = (found.direction_deg - degrees).rem_euclid(180.0);
        assert!(
            off.min(180.0 - off) < 0.3,
            "{degrees}: {}",
            found.direction_deg
        );
        assert!(found.dots.is_none() && found.second_period_m.is_none());
    }
}

#[test]
fn dots_and_pits_on_any_lattice_have_theirs() {
    for (lattice, degrees, between, second) in [
        ("square", 0.0, 90.0, 1.0),
        ("square, turned", 15.0, 90.0, 1.0),
        ("hexagonal", 5.0, 60.0, 1.0),
        ("rectangular", 0.0, 90.0, 1.4),
    ] {
        let a = turned(80e-6, degrees);
        let b = turned(second * 80e-6, degrees + between);
        let map = map_of(300, 320, |x, y| bells(x, y, a, b));
        // Every 31st point was not measured.
        let gaps = map.heights_m().iter().enumerate();
        let gaps = gaps.map(|(i, z)| if i % 997 < 20 { f64::NAN } else { *z });
        let holed = map.with_heights(gaps.collect());
        for (map, kind) in [
            (noisy(&map, 5, 0.5e-6), TextureKind::Dots),
            (holed, TextureKind::Dots),
            (
                map.with_heights(map.heights_m().iter().map(|z| -z).collect()),
                TextureKind::Pits,
            ),
        ] {
            let found = periodic(&map);
            assert_eq!(found.kind, kind, "{lattice}");
            check(lattice, found.period_m, 80e-6, 0.005);
            check(
                lattice,
                found.second_period_m.unwrap(),
                second * 80e-6,
                0.005,
            );
            check(lattice, found.height_m, 10e-6, 0.05);
            check(lattice, found.width_m, 30e-6, 0.03);
        }
        let (count, spread_m) = periodic(&map).dots.unwrap();
        // 600 × 640 µm less the half dots at the borders.
        let expected = 0.6e-3 * 0.64e-3 / (80e-6 * 80e-6 * second * between.to_radians().sin());
        assert!(
            (count as f64) < expected && count as f64 > 0.6 * expected,
            "{lattice}: {count}"
        );
        assert!(spread_m < 1e-6, "{lattice}: {spread_m:e}");
    }
}

#[test]
fn maps_that_look_periodic_and_are_not_have_no_period() {
    let grooves = |seed: u64, reach: usize| {
        let white: Vec<f64> = noise(seed).take(200 + 4 * reach).collect();
        let line: Vec<f64> = (2 * reach..200 + 2 * reach)
            .map(|i| {
                let weight = |d: f64| (-0.5 * (d / reach as f64 * 2.0).powi(2)).exp();
                let near = i - reach..=i + reach;
                near.map(|j| weight(j as f64 - i as f64) * white[j]).sum()
            })
            .collect();
        map_of(200, 60, |x, _| 1e-6 * line[(x / STEP_M).round() as usize])
    };
    let found = |maps: &mut dyn Iterator<Item = HeightMap>| {
        maps.filter(|map| texture_of(map).periodic.is_some())
            .count()
    };
    // Grooves that are all alike along y, at random places: the hardest case.
    for reach in [6, 12, 24] {
        let mistaken = found(&mut (1..=40).map(|seed| grooves(seed, reach)));
        assert!(mistaken <= 1, "{reach}: {mistaken}");
    }
    let flat = map_of(100, 100, |_, _| 0.0);
    assert_eq!(found(&mut (1..=20).map(|seed| noisy(&flat, seed, 1e-6))), 0);
    // Three periods are too few.
    let three = map_of(100, 100, |x, _| 1e-6 * (x / 66e-6 * TAU).sin());
    let found = texture_of(&three);
    assert!(found.periodic.is_none(), "{found:?}");
    // A step, a scratch, and a slope.
    for of in [
        |x: f64| f64::from(x > 90e-6),
        |x: f64| f64::from((x - 90e-6).abs() < 4e-6),
    ] {
        assert!(
            texture_of(&map_of(100, 100, |x, _| 1e-6 * of(x)))
                .periodic
                .is_none()
        );
    }
    let constant = areal_roughness(
        &flat,
        &ArealConfig {
            form: Form::Level,
            s_nesting_m: None,
            l_nesting_m: None,
        },
    );
    assert!(constant.unwrap().texture.is_none());
}

/// Flat discs whose period is a whole number of points or not, on maps that hold no whole number of periods.
#[test]
fn flat_topped_dots_have_their_diameter() {
    for (diameter, period) in [
        (8.0, 16.0),
        (12.0, 19.2),
        (12.0, 30.0),
        (24.0, 60.0),
        (40.0, 64.0),
        (40.0, 100.0),
    ] {
        let map = map_of(400, 400, |x_m, y_m| {
            let from_next = |at_m: f64, shift: f64| {
                let periods = (at_m / STEP_M + shift) / period;
                (periods - periods.round()) * period
            };
            let inside = 0.5 * diameter - from_next(x_m, 0.37).hypot(from_next(y_m, 0.21));
            10e-6 * (inside + 0.5).clamp(0.0, 1.0)
        });
        let found = periodic(&map);
        let off = found.width_m / STEP_M - diameter;
        assert!(off.abs() < 0.1, "{diameter} of {period}: {off}");
        check("height", found.height_m, 10e-6, 0.002);
    }
}

/// The plane through 5.4 ridges is not level with them.
#[test]
fn ridges_on_a_tilted_plane_have_their_height() {
    for (periods, tilt) in [(5.4, 0.0), (5.4, 0.3), (7.5, 0.1), (10.5, 0.02)] {
        let period = 300.0 / periods;
        let map = map_of(300, 260, |x_m, y_m| {
            let phase = (x_m / STEP_M).rem_euclid(period) - 0.5 * period;
            let ridge = (0.2 * period - phase.abs() + 0.5).clamp(0.0, 1.0);
            10e-6 * ridge + tilt * (x_m + 0.5 * y_m)
        });
        let found = periodic(&map);
        check("height", found.height_m, 10e-6, 0.002);
        let off = found.width_m / STEP_M - 0.4 * period;
        assert!(off.abs() < 0.3, "{periods}, {tilt}: {off}");
    }
}
