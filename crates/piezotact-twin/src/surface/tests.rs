use std::f64::consts::{FRAC_PI_2, PI, TAU};

use num_complex::Complex;
use piezotact::surface::HeightMap;
use piezotact_fourier::ComplexPlanner;

use super::*;

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
/// Height, diameter and wavelength, µm: *thesis* Table 2.
const DOTS_UM: [(f64, f64, f64); 12] = [
    (27.0, 107.0, 120.0),
    (24.0, 107.0, 160.0),
    (19.0, 22.0, 50.0),
    (38.0, 107.0, 218.0),
    (55.0, 208.0, 317.0),
    (18.0, 71.0, 184.0),
    (14.0, 207.0, 318.0),
    (18.0, 106.0, 716.0),
    (14.0, 207.0, 524.0),
    (27.0, 502.0, 616.0),
    (29.0, 797.0, 913.0),
    (15.0, 12.0, 138.0),
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

fn dots((height_um, diameter_um, wavelength_um): (f64, f64, f64)) -> Relief {
    Relief::Dots {
        height_m: height_um * 1e-6,
        diameter_m: diameter_um * 1e-6,
        wavelength_m: wavelength_um * 1e-6,
        edge_m: 2e-6,
        roughness_m: 0.1e-6,
    }
}

fn ridges() -> Relief {
    Relief::Ridges {
        wavelength_m: 0.5e-3,
        depth_m: 0.1e-3,
        roughness_m: 2e-6,
    }
}

fn usual(relief: &Relief, sample: &str) -> HeightMap {
    relief.height_map(&relief.usual_patch(), 7, sample).unwrap()
}

/// The heights above their mean, m.
fn centred(map: &HeightMap) -> Vec<f64> {
    let mean_m = mean(map.heights_m().iter().copied());
    map.heights_m().iter().map(|z| z - mean_m).collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

fn sa_m(map: &HeightMap) -> f64 {
    mean(centred(map).iter().map(|z| z.abs()))
}

fn sq_m(map: &HeightMap) -> f64 {
    mean(centred(map).iter().map(|z| z * z)).sqrt()
}

fn sz_m(map: &HeightMap) -> f64 {
    let heights = || map.heights_m().iter().copied();
    heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min)
}

#[test]
fn isotropic_samples_have_their_ra() {
    for (i, (ra_um, grain_um)) in ISOTROPIC_UM.into_iter().enumerate() {
        let relief = isotropic(ra_um, grain_um, 0.5);
        let map = usual(&relief, &format!("S{}", i + 1));
        let mean_m = map.heights_m().iter().sum::<f64>() / map.heights_m().len() as f64;
        // the rounding of a million sums
        assert!(mean_m.abs() < 1e-12 * ra_um, "{mean_m}");
        let off = sa_m(&map) / (ra_um * 1e-6) - 1.0;
        assert!(off.abs() < 1e-9, "S{}: {off:e}", i + 1);
    }
}

#[test]
fn heights_are_gaussian_or_skewed_as_asked() {
    let gaussian = usual(&isotropic(10.0, 100.0, 0.0), "even");
    // Sq/Sa of n Gaussian heights has the relative deviation 0.27/√n: with 10³ and more, 1 % and less.
    let ratio = sq_m(&gaussian) / sa_m(&gaussian);
    assert!((ratio / FRAC_PI_2.sqrt() - 1.0).abs() < 0.01, "{ratio}");
    for asked in [-1.0, 0.0, 0.3, 0.6, 1.0, 2.0] {
        let map = usual(&isotropic(10.0, 100.0, asked), "skewed");
        let rms_m = sq_m(&map);
        let found = mean(centred(&map).iter().map(|z| (z / rms_m).powi(3)));
        // The standard error √(6/n) is 0.03 of 10⁴ Gaussian heights, and grows with the tail.
        let within = 0.1 + 0.1 * asked.abs();
        assert!((found - asked).abs() < within, "{asked}: {found}");
    }
}

/// The slope of the logarithm of the radially averaged PSD between 8 and 48 waves per correlation length.
fn psd_slope(map: &HeightMap, correlation_m: f64) -> f64 {
    let n = map.columns();
    assert_eq!(map.rows(), n);
    // a Hann window both ways, or the edges of the patch would add waves of all lengths
    let window = |i: usize| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / n as f64).cos();
    let value = |i: usize, z: &f64| Complex::from(z * window(i % n) * window(i / n));
    let heights = map.heights_m().iter().enumerate();
    let mut bins: Vec<_> = heights.map(|(i, z)| value(i, z)).collect();
    let plan = ComplexPlanner::new().plan_fft_forward(n);
    for _ in 0..2 {
        plan.process(&mut bins);
        bins = (0..n * n).map(|i| bins[i % n * n + i / n]).collect();
    }
    let mut rings = vec![(0.0, 0.0); n];
    for (i, bin) in bins.iter().enumerate() {
        let signed = |k: usize| k.min(n - k) as f64;
        let ring = signed(i % n).hypot(signed(i / n)).round() as usize;
        rings[ring].0 += bin.norm_sqr();
        rings[ring].1 += 1.0;
    }
    let lengths = map.length_x_m() / correlation_m;
    let range = (8.0 * lengths) as usize..(48.0 * lengths) as usize;
    let points: Vec<(f64, f64)> = range
        .map(|k| ((k as f64).ln(), (rings[k].0 / rings[k].1).ln()))
        .collect();
    let count = points.len() as f64;
    let mean_x = points.iter().map(|p| p.0).sum::<f64>() / count;
    let mean_y = points.iter().map(|p| p.1).sum::<f64>() / count;
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (x, y) in points {
        covariance += (x - mean_x) * (y - mean_y);
        variance += (x - mean_x).powi(2);
    }
    covariance / variance
}

#[test]
fn short_waves_fall_as_the_hurst_exponent_says() {
    for (hurst, skewness) in [(0.6, 0.0), (0.8, 0.0), (0.9, 0.0), (0.8, 0.5)] {
        let correlation_m = 600e-6;
        let relief = Relief::Isotropic {
            ra_m: 20e-6,
            grain_m: 400e-6,
            correlation_per_grain: 1.5,
            hurst,
            skewness,
        };
        // 128 steps to Lc: waves of two steps are 64 times shorter than Lc
        let patch = Patch {
            width_m: 8.0 * correlation_m,
            height_m: 8.0 * correlation_m,
            step_m: correlation_m / 128.0,
        };
        let map = relief.height_map(&patch, 7, "slope").unwrap();
        let slope = psd_slope(&map, correlation_m);
        // At 8 waves per Lc the roll-off still takes 1/65 off the slope, at 48 nothing; chance of 10⁵ bins about
        // 0.01; skewed heights have products of waves besides.
        let asked = -2.0 * (1.0 + hurst);
        assert!((slope - asked).abs() < 0.06, "{hurst} {skewness}: {slope}");
    }
}

/// The autocorrelation of every eighth row at a lag of `lag` points, over its value at 0.
fn along_x(map: &HeightMap, lag: usize) -> f64 {
    let mean = map.heights_m().iter().sum::<f64>() / map.heights_m().len() as f64;
    let (mut products, mut squares) = ((0.0, 0.0), (0.0, 0.0));
    for line in map.heights_m().chunks_exact(map.columns()).step_by(8) {
        for (a, b) in line.iter().zip(&line[lag..]) {
            products = (products.0 + (a - mean) * (b - mean), products.1 + 1.0);
        }
        for z in line {
            squares = (squares.0 + (z - mean).powi(2), squares.1 + 1.0);
        }
    }
    products.0 / products.1 / (squares.0 / squares.1)
}

/// The lag of the highest autocorrelation along x from half to one and a half wavelengths, in wavelengths.
fn period(map: &HeightMap, wavelength_m: f64) -> f64 {
    let points = wavelength_m / map.step_x_m();
    let lags = (0.5 * points) as usize..=(1.5 * points) as usize;
    let correlation = lags.map(|lag| (lag, along_x(map, lag)));
    let best = correlation.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    // The pattern is regular; its roughness and the rounding of the lag to a step cost little.
    assert!(best.1 > 0.8, "{best:?}");
    best.0 as f64 / points
}

#[test]
fn dots_stand_as_drawn() {
    for (i, dot_um) in DOTS_UM.into_iter().enumerate() {
        let (height_um, diameter_um, wavelength_um) = dot_um;
        let name = format!("M{}", i + 1);
        let map = usual(&dots(dot_um), &name);
        // A million heights of 0.1 µm rms lie within ±5 rms on either end.
        let sz_um = sz_m(&map) * 1e6;
        assert!(
            sz_um > height_um && sz_um < height_um + 1.1,
            "{name}: {sz_um}"
        );
        let heights = map.heights_m().iter();
        let above = heights.filter(|z| **z > 0.5e-6 * height_um).count();
        let share = above as f64 / map.heights_m().len() as f64;
        let asked = PI / (2.0 * 3f64.sqrt()) * (diameter_um / wavelength_um).powi(2);
        assert!(
            (share / asked - 1.0).abs() < 0.02,
            "{name}: {share} for {asked}"
        );
        // half a step of at least 64 to a wavelength
        let period = period(&map, wavelength_um * 1e-6);
        assert!((period - 1.0).abs() < 0.01, "{name}: {period}");
    }
}

#[test]
fn dots_are_as_high_as_asked_and_round_at_the_edge() {
    let tall = Dot {
        height_m: 20e-6,
        edge_m: 2e-6,
    };
    let height_um = |dot: &Dot, from_um: f64| dot.mean_height_m(from_um * 1e-6, 1e-9) * 1e6;
    for (from_um, asked_um) in [
        (-5.0, 20.0),
        // 1 µm inside: ρ·(1 − √3/2) below the top
        (-1.0, 20.0 - 2.0 * (1.0 - 0.75f64.sqrt())),
        (0.0, 10.0),
        (1.0, 2.0 * (1.0 - 0.75f64.sqrt())),
        (2.5, 0.0),
    ] {
        let found_um = height_um(&tall, from_um);
        // the mean over 1 nm is the point, but for the arc's curvature
        assert!((found_um - asked_um).abs() < 1e-3, "{from_um}: {found_um}");
    }
    // Two arcs of 2 µm that meet half way up, 1 µm: √(1·(4 − 1)) µm from their ends.
    let low = Dot {
        height_m: 2e-6,
        edge_m: 2e-6,
    };
    for (from_um, asked_um) in [(-1.74, 2.0), (0.0, 1.0), (1.74, 0.0)] {
        let found_um = height_um(&low, from_um);
        assert!((found_um - asked_um).abs() < 1e-3, "{from_um}: {found_um}");
    }
    // no edge: a pixel that lies three quarters inside
    let sharp = Dot {
        height_m: 1e-6,
        edge_m: 0.0,
    };
    assert!((sharp.mean_height_m(-1e-6, 4e-6) - 0.75e-6).abs() < 1e-15);
}

#[test]
fn the_nearest_centre_is_the_nearest_of_all() {
    for i in 0..2000 {
        let (x, y) = (f64::from(i).sin() * 3.0, (f64::from(i) * 0.7).cos() * 3.0);
        let mut nearest = f64::INFINITY;
        for (a, b) in (-9..=9).flat_map(|a| (-9..=9).map(move |b| (f64::from(a), f64::from(b)))) {
            let centre = (a + 0.5 * b, 0.5 * 3f64.sqrt() * b);
            nearest = nearest.min((x - centre.0).hypot(y - centre.1));
        }
        assert!((from_centre(x, y) - nearest).abs() < 1e-12, "{x} {y}");
    }
}

#[test]
fn ridges_have_their_period_and_depth() {
    let map = usual(&ridges(), "plate");
    let period = period(&map, 0.5e-3);
    assert!((period - 1.0).abs() < 0.01, "{period}");
    // a cosine of 0.1 mm, and 2 µm of roughness
    let asked_m = (0.05e-3f64.powi(2) / 2.0 + 2e-6f64.powi(2)).sqrt();
    assert!((sq_m(&map) / asked_m - 1.0).abs() < 0.01, "{}", sq_m(&map));
    assert!(sz_m(&map) > 0.1e-3 && sz_m(&map) < 0.1e-3 + 20e-6);
}

#[test]
fn one_seed_one_map() {
    for relief in [isotropic(5.2, 25.8, 0.5), dots(DOTS_UM[7]), ridges()] {
        let usual = relief.usual_patch();
        let patch = Patch {
            width_m: 0.2 * usual.width_m,
            height_m: 0.15 * usual.height_m,
            ..usual
        };
        let map = |seed, sample| relief.height_map(&patch, seed, sample).unwrap();
        let bits =
            |map: &HeightMap| -> Vec<u64> { map.heights_m().iter().map(|z| z.to_bits()).collect() };
        let first = map(3, "S8");
        assert_eq!(bits(&first), bits(&map(3, "S8")));
        assert_ne!(first, map(4, "S8"));
        assert_ne!(first, map(3, "S9"));
        let points = |side_m: f64| (side_m / patch.step_m).round() as usize;
        assert_eq!(
            (first.columns(), first.rows()),
            (points(patch.width_m), points(patch.height_m))
        );
    }
}

/// The seed's first heights must mean the same for ever, up to the last bits of a transform.
#[test]
fn stored_seeds_mean_the_same() {
    let relief = isotropic(5.2, 25.8, 0.5);
    let map = usual(&relief, "S8");
    for (z, stored_um) in map.heights_m().iter().zip(GOLDEN_UM) {
        assert!(
            (z * 1e6 - stored_um).abs() < 1e-9,
            "{:?}",
            &map.heights_m()[..3]
        );
    }
}

const GOLDEN_UM: [f64; 3] = [
    -1.933_564_864_186_615,
    -5.391_392_297_147_547,
    -4.709_684_523_364_814,
];

#[test]
fn a_patch_has_no_period() {
    let map = usual(&isotropic(10.0, 100.0, 0.0), "edges");
    let (mut products, mut squares) = (0.0, 0.0);
    for line in map.heights_m().chunks_exact(map.columns()) {
        products += line[0] * line[map.columns() - 1];
        squares += line[0] * line[0];
    }
    // A periodic map has 0.9 and more; edges of 32 correlation lengths that know nothing of each other have
    // 1/√64 at chance.
    assert!((products / squares).abs() < 0.4, "{}", products / squares);
}

/// The mean along a line holds the waves across it only: both directions must have them in full.
#[test]
fn long_waves_are_the_same_both_ways() {
    let grid = Grid {
        columns: 64,
        rows: 64,
        step_m: 10e-6,
    };
    let field = SelfAffine {
        correlation_m: 160e-6,
        hurst: 0.8,
    };
    let (mut of_rows, mut of_columns) = (0.0, 0.0);
    for seed in 0..400 {
        let heights = field.heights(grid, &mut Random::stream(seed, 0, "lines"));
        for line in 0..64 {
            let row = &heights[64 * line..64 * line + 64];
            of_rows += row.iter().sum::<f64>().powi(2);
            let column = heights[line..].iter().step_by(64);
            of_columns += column.sum::<f64>().powi(2);
        }
    }
    // 400 maps of four correlation lengths: some 2000 independent lines each way, 3 % each
    let ratio: f64 = of_rows / of_columns;
    assert!((ratio - 1.0).abs() < 0.13, "{ratio}");
}

#[test]
fn usual_patches_fit() {
    let isotropic = ISOTROPIC_UM.map(|(ra_um, grain_um)| isotropic(ra_um, grain_um, 0.5));
    let all = isotropic
        .into_iter()
        .chain(DOTS_UM.map(dots))
        .chain([ridges()]);
    for relief in all {
        let patch = relief.usual_patch();
        assert!(patch.step_m >= 0.1e-6, "{patch:?}");
        let grid = relief.grid(&patch).unwrap();
        assert!((256..=1024).contains(&grid.columns), "{grid:?}");
        assert!((256..=1024).contains(&grid.rows), "{grid:?}");
    }
}

/// That `relief` on `patch` is refused with a text that holds `text`, what was found, and what to do.
fn refused(relief: Relief, patch: Patch, text: &str) {
    let error = relief.height_map(&patch, 7, "no").unwrap_err().to_string();
    assert!(error.contains(text), "{error}");
    for part in ["expected ", ", found ", "; "] {
        assert!(error.contains(part), "{error}");
    }
}

const BAD: [f64; 4] = [0.0, -1e-6, f64::NAN, f64::INFINITY];

/// A rough relief with one number changed.
fn changed(change: impl Fn(&mut [f64; 5])) -> Relief {
    let mut numbers = [5e-6, 50e-6, 1.5, 0.8, 0.5];
    change(&mut numbers);
    let [ra_m, grain_m, correlation_per_grain, hurst, skewness] = numbers;
    Relief::Isotropic {
        ra_m,
        grain_m,
        correlation_per_grain,
        hurst,
        skewness,
    }
}

#[test]
fn rough_reliefs_that_cannot_be_are_refused() {
    let patch = changed(|_| ()).usual_patch();
    assert!(changed(|_| ()).height_map(&patch, 7, "yes").is_ok());
    for bad in BAD {
        refused(
            changed(|n| n[0] = bad),
            patch,
            "a roughness Ra: expected above zero",
        );
        refused(
            changed(|n| n[1] = bad),
            patch,
            "a grain: expected above zero",
        );
        refused(
            changed(|n| n[2] = bad),
            patch,
            "a correlation length in grains: expected above zero",
        );
    }
    for bad in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        refused(
            changed(|n| n[3] = bad),
            patch,
            "a Hurst exponent: expected 0 to 1",
        );
    }
    for bad in [-3.1, 3.1, f64::NAN, f64::INFINITY] {
        refused(
            changed(|n| n[4] = bad),
            patch,
            "a skewness: expected -3 to 3",
        );
    }
    let fine = changed(|n| n[1] = 2e-6);
    refused(
        fine,
        patch,
        "from 4 µm, twice the shortest wave, found 3 µm",
    );
    let overflow = changed(|n| (n[1], n[2]) = (1e300, 1e300));
    refused(
        overflow,
        patch,
        "a correlation length: expected above zero and finite",
    );
}

fn drawn(change: impl Fn(&mut [f64; 5])) -> Relief {
    let mut numbers = [20e-6, 60e-6, 100e-6, 2e-6, 0.1e-6];
    change(&mut numbers);
    let [height_m, diameter_m, wavelength_m, edge_m, roughness_m] = numbers;
    Relief::Dots {
        height_m,
        diameter_m,
        wavelength_m,
        edge_m,
        roughness_m,
    }
}

#[test]
fn patterns_that_cannot_be_are_refused() {
    let patch = drawn(|_| ()).usual_patch();
    assert!(
        drawn(|n| (n[3], n[4]) = (0.0, 0.0))
            .height_map(&patch, 7, "yes")
            .is_ok()
    );
    for bad in BAD {
        refused(
            drawn(|n| n[0] = bad),
            patch,
            "a dot's height: expected above zero",
        );
        refused(
            drawn(|n| n[1] = bad),
            patch,
            "a dot's diameter: expected above zero",
        );
        refused(
            drawn(|n| n[2] = bad),
            patch,
            "a wavelength: expected above zero",
        );
        for (wavelength_m, depth_m) in [(bad, 1e-4), (1e-3, bad)] {
            let ridges = Relief::Ridges {
                wavelength_m,
                depth_m,
                roughness_m: 0.0,
            };
            refused(ridges, patch, "above zero and finite");
        }
    }
    for bad in [-1e-9, f64::NAN, f64::INFINITY] {
        refused(
            drawn(|n| n[3] = bad),
            patch,
            "an edge radius: expected zero or more",
        );
        refused(
            drawn(|n| n[4] = bad),
            patch,
            "a roughness: expected zero or more",
        );
        let rough = Relief::Ridges {
            wavelength_m: 1e-3,
            depth_m: 1e-4,
            roughness_m: bad,
        };
        refused(rough, patch, "a roughness: expected zero or more");
    }
    for touching in [100e-6, 120e-6] {
        refused(drawn(|n| n[1] = touching), patch, "dots that do not touch");
    }
    refused(drawn(|n| n[3] = 21e-6), patch, "up to 20 µm");
}

#[test]
fn patches_that_do_not_show_the_relief_are_refused() {
    let (rough, dots) = (changed(|_| ()), drawn(|_| ()));
    let patch = |width_um: f64, height_um: f64, step_um: f64| Patch {
        width_m: width_um * 1e-6,
        height_m: height_um * 1e-6,
        step_m: step_um * 1e-6,
    };
    for bad in BAD.map(|bad| bad * 1e6) {
        refused(
            rough,
            patch(bad, 1000.0, 5.0),
            "a patch's width: expected above zero",
        );
        refused(
            rough,
            patch(1000.0, bad, 5.0),
            "a patch's height: expected above zero",
        );
        refused(
            rough,
            patch(1000.0, 1000.0, bad),
            "a step: expected above zero",
        );
    }
    refused(
        rough,
        patch(1000.0, 1000.0, 19.0),
        "to 18.75 µm (a quarter of the correlation length)",
    );
    refused(
        dots,
        patch(1000.0, 1000.0, 26.0),
        "to 25 µm (a quarter of the wavelength)",
    );
    refused(
        ridges(),
        patch(4000.0, 4000.0, 126.0),
        "to 125 µm (a quarter of the wavelength)",
    );
    refused(dots, patch(10.0, 10.0, 0.09), "a step from 0.1 µm");
    refused(
        rough,
        patch(35.0, 1000.0, 5.0),
        "a width of 8 to 4096 steps",
    );
    refused(
        rough,
        patch(1000.0, 35.0, 5.0),
        "a height of 8 to 4096 steps",
    );
    refused(
        dots,
        patch(4097.0, 100.0, 1.0),
        "a width of 8 to 4096 steps",
    );
    refused(
        dots,
        patch(100.0, 1e300, 1.0),
        "a height of 8 to 4096 steps",
    );
    refused(rough, patch(299.0, 100.0, 5.0), "a longer side from 300 µm");
    // a line is a patch, too
    assert!(
        rough
            .height_map(&patch(4000.0, 40.0, 5.0), 7, "strip")
            .is_ok()
    );
    assert!(dots.height_map(&patch(0.8, 0.8, 0.1), 7, "speck").is_ok());
}
