//! Our estimators against what established programs give on the same samples (SciPy 1.17.1, pyFRF 1.5.0,
//! NumPy 2.4.6, a commercial analyser). The files lie beside the checkout, in `../shared`; without them a
//! test says that it was skipped, and with `CI=true` it fails.
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test that reads reference files, and fails where they cannot be read"
)]

use crate::shared_data::shared;
use num_complex::Complex;
use piezotact::Warning;
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, SampleRate};
use piezotact::render::{Inverse, InverseConfig, PhaseForm, invert};
use piezotact::resample::Resampler;
use piezotact::series::Series;
use piezotact::spectrum::{Averaging, Scaling, Symmetry, WelchConfig, WelchPlan, welch};
use piezotact::transfer::{
    CrossPlan, CrossSpectra, Estimator, StoredFault, TransferFunction, TransferWarning,
};
use piezotact::warning::{Few, FewWarning};

/// PSDs: other programs agree with each other to 1e-14, FFT orders of summation differ.
const SPECTRUM_RTOL: f64 = 1e-10;

/// H1, H2 and coherence on excited lines: at the weakest of them SciPy is 1e-10 away from extended precision
/// and this program 4e-11 (`golden/precision.py`), not always to the same side.
const TRANSFER_RTOL: f64 = 2e-10;

struct Npz(zip::ZipArchive<std::fs::File>);

impl Npz {
    fn open(path: &str) -> Option<Self> {
        let file = std::fs::File::open(shared(path)?).unwrap();
        Some(Self(zip::ZipArchive::new(file).unwrap()))
    }

    fn real(&mut self, key: &str) -> Vec<f64> {
        let file = self
            .0
            .by_name(&format!("{key}.npy"))
            .unwrap_or_else(|_| panic!("no {key}"));
        npyz::NpyFile::new(file).unwrap().into_vec::<f64>().unwrap()
    }

    fn complex(&mut self, key: &str) -> Vec<Complex<f64>> {
        let file = self.0.by_name(&format!("{key}.npy")).unwrap();
        let npy = npyz::NpyFile::new(file).unwrap();
        npy.into_vec::<Complex<f64>>().unwrap()
    }
}

fn rate() -> SampleRate {
    SampleRate::new(5000.0).unwrap()
}

fn assert_close(what: &str, got: &[f64], expected: &[f64], rtol: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let worst = got
        .iter()
        .zip(expected)
        .map(|(g, e)| (g - e).abs() / e.abs().max(f64::MIN_POSITIVE))
        .enumerate()
        .fold((0, 0.0), |worst, (k, error)| {
            if error > worst.1 || error.is_nan() {
                (k, error)
            } else {
                worst
            }
        });
    eprintln!(
        "{what}: worst relative error {:.2e} at line {}",
        worst.1, worst.0
    );
    assert!(
        worst.1 <= rtol,
        "{what}: {:.3e} at line {}: {} against {}",
        worst.1,
        worst.0,
        got[worst.0],
        expected[worst.0]
    );
}

fn assert_close_complex(what: &str, got: &[Complex<f64>], expected: &[Complex<f64>], rtol: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let worst = got
        .iter()
        .zip(expected)
        .map(|(g, e)| (g - e).norm() / e.norm())
        .fold(0.0, f64::max);
    eprintln!("{what}: worst relative error {worst:.2e}");
    assert!(got.iter().all(|g| g.is_finite()), "{what} holds NaN");
    assert!(worst <= rtol, "{what}: {worst:.3e}");
}

/// Compares lines one by one. The drive of these references ends at 1 kHz; up to Nyquist its power falls to
/// 1e-16 of its largest, which is the rounding of every double-precision FFT: there SciPy itself is 1e-7
/// to 1e-6 away from the same sum in extended precision (`golden/precision.py`), and 2e-6 is asked instead. On lines 90 to
/// 100 dB below the strongest SciPy is up to 9.6e-11 away from it, and 2e-10 is asked; above, 1e-10.
fn assert_driven_lines(
    what: &str,
    spectra: &CrossSpectra<Drive, Acceleration>,
    got: &[Complex<f64>],
    expected: &[Complex<f64>],
) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let strongest = spectra.drive_power.iter().copied().fold(0.0, f64::max);
    let tiers = [(1e-9, SPECTRUM_RTOL), (1e-10, TRANSFER_RTOL), (0.0, 2e-6)];
    let mut worst = [(0.0f64, 0usize); 3];
    let mut counted = [0; 3];
    for (k, power) in spectra.drive_power.iter().enumerate() {
        let of = |(share, _): &(f64, f64)| *power >= share * strongest;
        let tier = tiers.iter().position(of).unwrap();
        let error = (got[k] - expected[k]).norm() / expected[k].norm();
        counted[tier] += 1;
        if error > worst[tier].0 || error.is_nan() {
            worst[tier] = (error, k);
        }
    }
    for (((_, rtol), worst), count) in tiers.iter().zip(worst).zip(counted) {
        eprintln!(
            "{what}: worst relative error {:.1e} on {count} lines",
            worst.0
        );
        assert!(worst.0 <= *rtol, "{what}: {worst:?}");
    }
}

#[test]
fn welch_equals_scipy() {
    let Some(mut npz) = Npz::open("reference/welch.npz") else {
        return;
    };
    let x = Series::<Acceleration>::new(npz.real("x"), rate()).unwrap();
    let config = WelchConfig::thesis_2024();
    let psd = welch(&x, &config).unwrap();
    assert_close("psd", &psd.values, &npz.real("psd"), SPECTRUM_RTOL);
    assert_close("f", &psd.frequencies_hz()[1..], &npz.real("f")[1..], 1e-15);
    let median = welch(
        &x,
        &WelchConfig {
            averaging: Averaging::Median,
            ..config.clone()
        },
    )
    .unwrap();
    assert_close(
        "psd_median",
        &median.values,
        &npz.real("psd_median"),
        SPECTRUM_RTOL,
    );
    let power = welch(
        &x,
        &WelchConfig {
            scaling: Scaling::Spectrum,
            ..config.clone()
        },
    )
    .unwrap();
    assert_close(
        "power_spectrum",
        &power.values,
        &npz.real("power_spectrum"),
        SPECTRUM_RTOL,
    );
    let short = WelchPlan::new(&config, rate())
        .unwrap()
        .estimate::<Acceleration>(&[&x.samples()[..1500]])
        .unwrap();
    assert_close(
        "psd_short1500",
        &short.values,
        &npz.real("psd_short1500"),
        SPECTRUM_RTOL,
    );
    assert_eq!(
        short.warnings,
        [Warning::from(FewWarning::Few {
            found: 1,
            recommended: 10,
            what: Few::Segments
        })]
    );
}

#[test]
fn transfer_functions_equal_scipy_and_pyfrf() {
    let Some(mut npz) = Npz::open("reference/transfer.npz") else {
        return;
    };
    let (x, y) = (npz.real("x"), npz.real("y"));
    for n in [2048, 4096] {
        let spectra: CrossSpectra<Drive, Acceleration> =
            CrossPlan::new(&WelchConfig::hann(n), rate())
                .unwrap()
                .estimate(&x, &y)
                .unwrap();
        assert_driven_lines(
            &format!("H1_{n}"),
            &spectra,
            &spectra.h1(),
            &npz.complex(&format!("H1_{n}")),
        );
        assert_driven_lines(
            &format!("H2_{n}"),
            &spectra,
            &spectra.h2(),
            &npz.complex(&format!("H2_{n}")),
        );
        let real = |values: Vec<f64>| -> Vec<Complex<f64>> {
            values.into_iter().map(Complex::from).collect()
        };
        let coherence = real(npz.real(&format!("coh_{n}")));
        assert_driven_lines(
            &format!("coh_{n}"),
            &spectra,
            &real(spectra.coherence()),
            &coherence,
        );
        let truth = npz.complex(&format!("H_true_{n}"));
        let worst_db = spectra
            .h1()
            .iter()
            .zip(&truth)
            .enumerate()
            .filter(|(k, _)| (20.0..=1000.0).contains(&(*k as f64 * 5000.0 / n as f64)))
            .map(|(_, (h, t))| (20.0 * (h.norm() / t.norm()).log10()).abs())
            .fold(0.0, f64::max);
        let limit = if n == 2048 { 0.30 } else { 0.44 };
        assert!(
            worst_db <= limit + 0.005,
            "H1 at {n} is {worst_db:.3} dB from the truth, the index says {limit}"
        );
    }
}

#[test]
fn a_symmetric_window_gives_pyfrf() {
    let Some(mut npz) = Npz::open("reference/transfer.npz") else {
        return;
    };
    let (x, y) = (npz.real("x"), npz.real("y"));
    let config = WelchConfig {
        symmetry: Symmetry::Symmetric,
        ..WelchConfig::hann(2048)
    };
    let spectra: CrossSpectra<Drive, Acceleration> = CrossPlan::new(&config, rate())
        .unwrap()
        .estimate(&x, &y)
        .unwrap();
    assert_driven_lines(
        "pyfrf H1",
        &spectra,
        &spectra.h1(),
        &npz.complex("pyfrf_H1_2048"),
    );
    assert_driven_lines(
        "pyfrf H2",
        &spectra,
        &spectra.h2(),
        &npz.complex("pyfrf_H2_2048"),
    );
}

type Lines = Vec<Complex<f64>>;

/// Within the drive's own band, 20–1000 Hz, rounding has nothing to feed on: 1e-12 for SciPy and for pyFRF.
#[test]
fn transfer_functions_equal_scipy_and_pyfrf_closely_where_they_are_excited() {
    let Some(mut npz) = Npz::open("reference/transfer.npz") else {
        return;
    };
    let (x, y) = (npz.real("x"), npz.real("y"));
    for n in [2048, 4096] {
        for (program, symmetry) in [("", Symmetry::Periodic), ("pyfrf_", Symmetry::Symmetric)] {
            let config = WelchConfig {
                symmetry,
                ..WelchConfig::hann(n)
            };
            let spectra: CrossSpectra<Drive, Acceleration> = CrossPlan::new(&config, rate())
                .unwrap()
                .estimate(&x, &y)
                .unwrap();
            let coherence = |values: Vec<f64>| values.into_iter().map(Complex::from).collect();
            let all: [(String, Lines, Lines); 3] = [
                (
                    format!("{program}H1_{n}"),
                    spectra.h1(),
                    npz.complex(&format!("{program}H1_{n}")),
                ),
                (
                    format!("{program}H2_{n}"),
                    spectra.h2(),
                    npz.complex(&format!("{program}H2_{n}")),
                ),
                (
                    format!("{program}coh_{n}"),
                    coherence(spectra.coherence()),
                    coherence(npz.real(&format!("{program}coh_{n}"))),
                ),
            ];
            for (what, got, expected) in all {
                let worst = got
                    .iter()
                    .zip(&expected)
                    .enumerate()
                    .filter(|(k, _)| (20.0..=1000.0).contains(&(*k as f64 * spectra.resolution_hz)))
                    .map(|(_, (a, b))| (a - b).norm() / b.norm())
                    .fold(0.0, f64::max);
                eprintln!("{what}: worst relative error {worst:.1e} within 20–1000 Hz");
                assert!(worst <= 1e-12, "{what}: {worst:e}");
            }
        }
    }
}

/// `golden/transfer.py`: pyFRF 1.5.0, whose ratio of noise powers is 1.
#[test]
fn hv_equals_pyfrf() {
    let Some(mut npz) = Npz::open("reference/transfer.npz") else {
        return;
    };
    let config = WelchConfig {
        symmetry: Symmetry::Symmetric,
        ..WelchConfig::hann(2048)
    };
    let spectra: CrossSpectra<Drive, Acceleration> = CrossPlan::new(&config, rate())
        .unwrap()
        .estimate(&npz.real("x"), &npz.real("y"))
        .unwrap();
    let found = spectra.hv_for(1.0);
    for (line, re, im) in [
        (10, 1.659_076_379_468_274_4, -0.226_835_576_400_272_52),
        (41, 1.737_324_301_377_832, -1.176_677_904_137_629_6),
        (100, -0.428_123_222_077_803_84, 0.238_081_376_966_623_63),
        (200, -1.295_422_328_951_892_2, -0.640_376_504_617_945_4),
        (400, -0.037_453_950_779_440_34, -0.390_040_787_581_334_5),
    ] {
        let expected = Complex::new(re, im);
        let error = (found[line] - expected).norm() / expected.norm();
        // pyFRF adds two nearly opposite numbers where the response is the weaker; ours does not.
        assert!(error < 1e-10, "line {line}: {} {error:e}", found[line]);
    }
    // The form without units is the geometric mean of H1 and H2.
    for ((hv, h1), h2) in spectra
        .hv()
        .iter()
        .zip(spectra.h1())
        .zip(spectra.h2())
        .skip(10)
        .take(390)
    {
        assert!((hv.norm() / (h1.norm() * h2.norm()).sqrt() - 1.0).abs() < 1e-12);
        assert!((hv / hv.norm() - h1 / h1.norm()).norm() < 1e-12);
    }
}

#[test]
fn the_drive_equals_numpy() {
    let Some(mut npz) = Npz::open("reference/render.npz") else {
        return;
    };
    let (fiv, f_tf, h, z) = (
        npz.real("fiv"),
        npz.real("f_tf"),
        npz.complex("H"),
        npz.real("z"),
    );
    let eps = npz.real("eps")[0];
    let function = TransferFunction::<Drive, Acceleration>::from_lines(
        h.clone(),
        vec![1.0; h.len()],
        f_tf[1] - f_tf[0],
        rate(),
        Estimator::H1,
        100,
    )
    .unwrap();
    let config = InverseConfig {
        band: Band::new(Hertz(20.0), Hertz(1000.0)).unwrap(),
        edge_ratio: 0.1,
        regularisation: eps,
        inverse: Inverse::Constant,
        phase: PhaseForm::Linear,
    };
    let drive = invert(&fiv, rate(), &function, &config).unwrap();
    let largest = z.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let worst = drive
        .iter()
        .zip(&z)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    eprintln!("z: worst error {:.2e} of its maximum", worst / largest);
    assert!(worst <= 1e-10 * largest);

    // Two resamplers are compared where both must agree: on the band, away from the ends.
    let z48 = npz.real("z48_poly");
    let ours = Resampler::new(rate(), SampleRate::new(48_000.0).unwrap(), Hertz(1100.0))
        .unwrap()
        .process(&z[..10_000]);
    let middle = 4800..z48.len().min(ours.len()) - 4800;
    let worst = middle.map(|m| (ours[m] - z48[m]).abs()).fold(0.0, f64::max);
    eprintln!(
        "z48: worst difference {:.2e} of the maximum",
        worst / largest
    );
    // resample_poly's Kaiser window (beta 5) has 1e-3 of passband ripple; ours has 1e-5.
    assert!(worst < 3e-3 * largest, "{}", worst / largest);
}

#[test]
fn a_commercial_analyser_is_reproduced_and_its_impossible_coherence_reported() {
    let Some(path) = shared("data/frf/vibrationtesting/case1.mat") else {
        return;
    };
    let mat = matfile::MatFile::parse(std::fs::File::open(path).unwrap()).unwrap();
    let real = |name: &str| -> Vec<f64> {
        match mat.find_by_name(name).unwrap().data() {
            matfile::NumericData::Single { real, .. } => {
                real.iter().map(|v| f64::from(*v)).collect()
            }
            matfile::NumericData::Double { real, .. } => real.clone(),
            other => panic!("{name}: {other:?}"),
        }
    };
    let complex = |name: &str| -> Vec<Complex<f64>> {
        match mat.find_by_name(name).unwrap().data() {
            matfile::NumericData::Double {
                real,
                imag: Some(imag),
            } => real
                .iter()
                .zip(imag)
                .map(|(re, im)| Complex::new(*re, *im))
                .collect(),
            matfile::NumericData::Single {
                real,
                imag: Some(imag),
            } => real
                .iter()
                .zip(imag)
                .map(|(re, im)| Complex::new(f64::from(*re), f64::from(*im)))
                .collect(),
            other => panic!("{name}: {other:?}"),
        }
    };
    let (gxx, gyy, gxy) = (
        real("MagSpec_chan_1"),
        real("MagSpec_chan_2"),
        complex("Hf_Cross_Spec_chan_2"),
    );
    let (stored_h, stored_coherence, f) = (
        complex("Hf_chan_2"),
        real("Hf_coh_chan_2"),
        real("Freq_domain"),
    );
    let spectra =
        CrossSpectra::<Drive, Acceleration>::from_parts(gxx, gyy, gxy, f[1] - f[0], 10).unwrap();
    // Single precision in the file: 6e-8 a value.
    assert_close_complex("H·Gxx = Gxy", &spectra.h1(), &stored_h, 1e-6);
    assert_close("coherence", &spectra.coherence(), &stored_coherence, 1e-6);
    let function = TransferFunction::<Drive, Acceleration>::from_lines(
        stored_h,
        stored_coherence,
        f[1] - f[0],
        SampleRate::new(2.0 * f[f.len() - 1]).unwrap(),
        Estimator::H1,
        10,
    )
    .unwrap();
    let dc = function
        .about
        .warnings
        .iter()
        .find_map(|warning| match warning.kind() {
            Some(TransferWarning::Stored {
                fault:
                    StoredFault::Coherence {
                        at_hz: 0.0, found, ..
                    },
            }) => Some(found),
            _ => None,
        });
    assert!((dc.unwrap() - 1.246).abs() < 5e-4, "{dc:?}");
}
