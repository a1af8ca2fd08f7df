//! Transfer functions that an analyser stored in a MATLAB file, with the spectra they came from.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use num_complex::Complex;
use piezotact::Warning;
use piezotact::quantity::{Acceleration, Force, SampleRate, Uncalibrated};
use piezotact::transfer::{
    CrossSpectra, Estimator, StoredFault, TransferFunction, TransferWarning,
};
use piezotact_dataset::{read_transfer, stored_transfer};

use crate::matlab::{numbers, parse};
use crate::shared_data;

/// The columns of an analyser's export.
struct Case1 {
    h: Vec<Complex<f64>>,
    gxx: Vec<f64>,
    gyy: Vec<f64>,
    gxy: Vec<Complex<f64>>,
    coherence: Vec<f64>,
}

fn case1() -> Option<Case1> {
    let path = shared_data::shared("data/frf/vibrationtesting/case1.mat")?;
    let file = parse(&path).unwrap();
    let real = |name: &str| file.get(name).unwrap().vector().unwrap().to_vec();
    let complex = |name: &str| -> Vec<Complex<f64>> {
        let numbers = numbers(file.get(name).unwrap());
        let pairs = numbers.real.iter().zip(numbers.imaginary.as_ref().unwrap());
        pairs.map(|(re, im)| Complex::new(*re, *im)).collect()
    };
    assert_eq!(real("Freq_domain").len(), 1601);
    assert!((real("Freq_domain")[1] - 0.3125).abs() < 1e-12);
    Some(Case1 {
        h: complex("Hf_chan_2"),
        gxx: real("MagSpec_chan_1"),
        gyy: real("MagSpec_chan_2"),
        gxy: complex("Hf_Cross_Spec_chan_2"),
        coherence: real("Hf_coh_chan_2"),
    })
}

/// An analyser stores singles: half of their last place is 6e-8. H·Gxx is rounded once; the coherence has the roundings
/// of two spectra in it, less than a whole last place.
#[test]
fn an_analyser_s_columns_fit_each_other_and_its_impossible_coherence_is_said() {
    let Some(case) = case1() else { return };
    let spectra = CrossSpectra::<Uncalibrated, Uncalibrated>::from_parts(
        case.gxx.clone(),
        case.gyy.clone(),
        case.gxy.clone(),
        0.3125,
        // More than one; the file does not state how many.
        2,
    )
    .unwrap();
    let (mut worst_h, mut worst_coherence) = (0.0_f64, 0.0_f64);
    let computed = spectra.coherence();
    for (k, coherence) in computed.iter().enumerate() {
        let h = (case.h[k] * case.gxx[k] - case.gxy[k]).norm() / case.gxy[k].norm();
        worst_h = worst_h.max(h);
        worst_coherence = worst_coherence.max((coherence / case.coherence[k] - 1.0).abs());
    }
    assert!(worst_h < 6e-8, "{worst_h:e}");
    assert!(worst_coherence < 1.2e-7, "{worst_coherence:e}");
    assert!(
        (case.coherence[0] - 1.246_222_6).abs() < 1e-6,
        "{}",
        case.coherence[0]
    );
    let rate = SampleRate::new(1280.0).unwrap();
    let impossible = |warnings: &[Warning]| {
        warnings.iter().any(|warning| {
            matches!(warning.kind(), Some(TransferWarning::Stored { fault: StoredFault::Coherence { found, lines: 5, .. } }) if found > 1.2)
        })
    };
    let stored = TransferFunction::<Force, Acceleration>::from_lines(
        case.h,
        case.coherence,
        0.3125,
        rate,
        Estimator::H1,
        0,
    )
    .unwrap();
    assert!(
        impossible(&stored.about.warnings),
        "{:?}",
        stored.about.warnings
    );
    let estimated = TransferFunction::from_spectra(&spectra, Estimator::H1, rate).unwrap();
    assert!(
        impossible(&estimated.about.warnings),
        "{:?}",
        estimated.about.warnings
    );
}

/// The function that an analyser stored is read, and agrees with its own spectra within the rounding of singles.
#[test]
fn a_stored_function_is_read_and_checked_with_its_own_spectra() {
    let Some(path) = shared_data::shared("data/frf/vibrationtesting/case1.mat") else {
        return;
    };
    let stored = stored_transfer(&path).unwrap().unwrap();
    let case = case1().unwrap();
    assert_eq!(stored.frequency_hz.len(), 1601);
    assert!((stored.frequency_hz[1] - 0.3125).abs() < 1e-12);
    for (k, h) in case.h.iter().enumerate() {
        let ratio = case.gxy[k] / case.gxx[k];
        let read = Complex::new(stored.real[k], stored.imaginary[k]);
        assert!(
            (read - ratio).norm() < 1.1e-7 * ratio.norm() && read == *h,
            "{k}"
        );
        assert_eq!(stored.coherence[k], case.coherence[k]);
    }
    let found = stored.identities.as_ref().unwrap();
    assert_eq!(
        (found.estimator, found.conjugate, found.lines),
        (Estimator::H1, false, 1601)
    );
    assert!(found.response_difference < 1.1e-7 && found.coherence_difference.unwrap() < 1e-6);
    let function = stored.function::<Uncalibrated, Uncalibrated>(&path);
    // Without units it is read as what it says it is.
    drop(function);
    assert_eq!(read_transfer(&path).unwrap(), stored);

    // A line that does not follow from the stored spectra gives a warning.
    let bytes = std::fs::read(&path).unwrap();
    let needle: Vec<u8> = case.h[800].re.to_le_bytes().to_vec();
    let at = bytes
        .windows(8)
        .position(|window| window == needle)
        .unwrap();
    let mut damaged = bytes.clone();
    damaged[at..at + 8].copy_from_slice(&(case.h[800].re * 3.0).to_le_bytes());
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("damaged.mat");
    std::fs::write(&other, damaged).unwrap();
    let warnings = stored_transfer(&other).unwrap().unwrap().about.warnings;
    assert!(
        warnings.iter().any(|warning| matches!(
            warning.kind(),
            Some(TransferWarning::Stored {
                fault: StoredFault::Spectra { at_hz: 250.0, .. }
            })
        )),
        "{warnings:?}"
    );
}

/// A function of half the size is compared with its own spectra, and their coherence still agrees with the stored one.
#[test]
fn a_function_of_another_size_is_not_called_equal() {
    let Some(path) = shared_data::shared("data/frf/vibrationtesting/case1.mat") else {
        return;
    };
    let case = case1().unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    let parts: [Vec<f64>; 2] = [
        case.h.iter().map(|h| h.re).collect(),
        case.h.iter().map(|h| h.im).collect(),
    ];
    for part in parts {
        let needle: Vec<u8> = part[..4].iter().flat_map(|v| v.to_le_bytes()).collect();
        let at = bytes
            .windows(32)
            .position(|window| window == needle)
            .unwrap();
        for (k, value) in part.iter().enumerate() {
            bytes[at + 8 * k..at + 8 * k + 8].copy_from_slice(&(0.5 * value).to_le_bytes());
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let half = folder.path().join("half.mat");
    std::fs::write(&half, bytes).unwrap();
    let found = stored_transfer(&half).unwrap().unwrap().identities.unwrap();
    assert!(!found.is_equal() && found.warning().is_some());
    assert!((found.response_difference - 0.5).abs() < 1e-6, "{found:?}");
    assert!(found.coherence_difference.unwrap() < 1e-6, "{found:?}");
}
