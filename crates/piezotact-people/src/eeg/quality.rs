//! Electrodes that stand apart from the others: noisy, nearly silent, bridged by gel; and amplitudes that are none of EEG.

use piezotact::Warning;
use piezotact::number::digits;
use piezotact::quantity::{SampleRate, Seconds};
use piezotact::statistics::median;

use super::{EegWarning, ElectrodesFault};

/// Changes over this time are looked at: they hold alpha and what is faster, and neither offsets nor drifts.
const OVER: Seconds = Seconds(0.05);
/// Of a long recording so many changes are looked at, evenly spread.
const MOST: usize = 8192;
/// From fewer electrodes their scatter is not known: one stands apart by a factor alone.
const FEWEST: usize = 8;
/// Of fewer electrodes none stands apart.
const FEWEST_APART: usize = 3;
/// Fewer changes say nothing.
const FEWEST_CHANGES: usize = 8;
/// How far an electrode stands apart from the median, in robust standard deviations of the logarithm, and by which factor at least.
const DEVIATIONS: f64 = 5.0;
const FACTOR: f64 = 4.0;
/// One that is so many times above or below the median stands apart however the others scatter.
const FAR: f64 = 10.0;
/// Two electrodes are bridged where what tells them apart is less than this part of either.
const BRIDGED: f64 = 0.05;
/// The median electrode of scalp EEG changes by no less and no more than these, V.
const FAINTEST_V: f64 = 0.1e-6;
const STRONGEST_V: f64 = 500e-6;

/// The warnings about electrodes called `names`, from their `signals` at `rate`, V: those whose robust deviation lies more than five robust standard
/// deviations (a factor of four at least, of ten at most; of ten among fewer than eight, and nothing of fewer than three) from the median of all,
/// pairs that record the same, and amplitudes that are none of EEG.
///
/// Formula: 0.7413 times the interquartile range of x(t + 50 ms) − x(t), over √2; pairs after the mean of all electrodes was taken away.
///
/// Source: N. Bigdely-Shamlo et al. (2015), Front. Neuroinform. 9:16 (robust deviation, z above 5), on changes in the place of a high-pass;
/// for bridges D. M. Tucker's electrical distance, relative.
pub(super) fn warnings(names: &[String], signals: &[&[f64]], rate: SampleRate) -> Vec<Warning> {
    let changes: Vec<Vec<f64>> = signals.iter().map(|one| changes(one, rate)).collect();
    let enough = changes.iter().all(|one| one.len() >= FEWEST_CHANGES);
    if names.is_empty() || changes.len() != names.len() || !enough {
        return Vec::new();
    }
    let deviations: Vec<f64> = changes.iter().map(|one| deviation(one)).collect();
    let middle_v = median(&mut deviations.clone()).unwrap_or_default();
    let mut warnings = Vec::new();
    if !(FAINTEST_V..=STRONGEST_V).contains(&middle_v) {
        warnings.push(
            EegWarning::Electrodes {
                names: String::new(),
                fault: ElectrodesFault::Amplitude { median_v: middle_v },
            }
            .into(),
        );
    }
    if middle_v <= 0.0 || names.len() < FEWEST_APART {
        return warnings;
    }
    let levels: Vec<f64> = deviations.iter().map(|own| (own / middle_v).ln()).collect();
    let sizes: Vec<f64> = levels.iter().map(|level| level.abs()).collect();
    // 1.4826: the standard deviation of a normal distribution, re the median distance from its middle.
    let limit = match names.len() < FEWEST {
        true => FAR.ln(),
        false => (DEVIATIONS * 1.4826 * median(&mut sizes.clone()).unwrap_or_default())
            .clamp(FACTOR.ln(), FAR.ln()),
    };
    let beyond = |sign: f64| {
        let own = names.iter().zip(&levels).zip(&deviations);
        let own = own.filter(|((_, level), _)| sign * **level > limit);
        let named = own.map(|((name, _), own_v)| format!("{name} ({} µV)", digits(1e6 * own_v)));
        let named: Vec<String> = named.collect();
        (!named.is_empty()).then(|| named.join(", "))
    };
    let noisy = beyond(1.0).map(|names| EegWarning::Electrodes {
        names,
        fault: ElectrodesFault::Noisy { middle_v },
    });
    let quiet = beyond(-1.0).map(|names| EegWarning::Electrodes {
        names,
        fault: ElectrodesFault::Quiet { middle_v },
    });
    warnings.extend(noisy.into_iter().chain(quiet).map(Warning::from));
    let pairs = bridged(names, &changes);
    if !pairs.is_empty() {
        let pairs = pairs.join(", ");
        warnings.push(
            EegWarning::Electrodes {
                names: pairs,
                fault: ElectrodesFault::Bridged,
            }
            .into(),
        );
    }
    warnings
}

/// The changes of a signal over 50 ms, those of a long one at evenly spread times.
fn changes(signal: &[f64], rate: SampleRate) -> Vec<f64> {
    let lag = rate.samples_in(OVER).max(1);
    let count = signal.len().saturating_sub(lag);
    let every = count.div_ceil(MOST).max(1);
    let at = (0..count).step_by(every);
    at.map(|i| signal[i + lag] - signal[i])
        .filter(|change| change.is_finite())
        .collect()
}

/// The robust standard deviation of one of two uncorrelated values, from their differences.
fn deviation(changes: &[f64]) -> f64 {
    let mut sorted = changes.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: usize| sorted[share * (sorted.len() - 1) / 4];
    0.7413 * (at(3) - at(1)) / std::f64::consts::SQRT_2
}

/// The pairs of electrodes that record the same, against the mean of all.
fn bridged(names: &[String], changes: &[Vec<f64>]) -> Vec<String> {
    let length = changes.iter().map(Vec::len).min().unwrap_or_default();
    let mut mean = vec![0.0; length];
    for own in changes {
        for (sum, value) in mean.iter_mut().zip(own) {
            *sum += value / changes.len() as f64;
        }
    }
    let referred: Vec<Vec<f64>> = changes
        .iter()
        .map(|own| own.iter().zip(&mean).map(|(v, m)| v - m).collect())
        .collect();
    let power = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
    let powers: Vec<f64> = referred.iter().map(|own| power(own)).collect();
    let mut pairs = Vec::new();
    for i in 0..names.len() {
        for j in i + 1..names.len() {
            let most = BRIDGED * BRIDGED * powers[i].min(powers[j]);
            let mut apart = 0.0;
            for (a, b) in referred[i].chunks(256).zip(referred[j].chunks(256)) {
                apart += a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
                if apart > most {
                    break;
                }
            }
            if apart <= most && most > 0.0 {
                pairs.push(format!("{} and {}", names[i], names[j]));
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::statistics::random::Random;

    const RATE_HZ: f64 = 250.0;

    /// Noise that neighbours share, with offsets of 20 mV and drifts.
    fn cap(seed: u64) -> Vec<Vec<f64>> {
        let mut random = Random::stream(seed, 0, "quality");
        let mut noise = || -> Vec<f64> { (0..20_000).map(|_| 1e-5 * random.normal()).collect() };
        let own: Vec<Vec<f64>> = (0..17).map(|_| noise()).collect();
        (0..16)
            .map(|c| {
                let size = 0.6 + 0.1 * c as f64;
                let sum = |i: usize| own[c][i] + own[c + 1][i];
                let drift = |i: usize| 0.02 * (c as f64 - 7.0) + 1e-8 * (c * i) as f64;
                (0..20_000).map(|i| size * sum(i) + drift(i)).collect()
            })
            .collect()
    }

    fn said(signals: &[Vec<f64>]) -> Vec<EegWarning> {
        let names: Vec<String> = (0..signals.len()).map(|i| format!("E{i}")).collect();
        let signals: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let found = warnings(&names, &signals, rate);
        found.iter().filter_map(|warning| warning.kind()).collect()
    }

    #[test]
    fn electrodes_that_stand_apart_are_named_and_others_are_not() {
        for seed in 0..20 {
            let clean = cap(seed);
            assert_eq!(said(&clean), [], "{seed}");
            let mut noisy = clean.clone();
            let mut random = Random::stream(seed, 1, "quality");
            noisy[3]
                .iter_mut()
                .for_each(|v| *v += 4e-4 * random.normal());
            assert!(
                matches!(&said(&noisy)[..], [EegWarning::Electrodes { names, fault: ElectrodesFault::Noisy { .. }, .. }] if names.starts_with("E3 (")),
                "{:?}",
                said(&noisy)
            );
            let mut quiet = clean.clone();
            quiet[5].iter_mut().for_each(|v| *v *= 5e-3);
            assert!(
                matches!(&said(&quiet)[..], [EegWarning::Electrodes { names, fault: ElectrodesFault::Quiet { .. }, .. }] if names.starts_with("E5 ("))
            );
            let mut bridge = clean.clone();
            bridge[9] = bridge[8].iter().map(|v| 1.01 * v).collect();
            assert_eq!(
                said(&bridge),
                [EegWarning::Electrodes {
                    names: "E8 and E9".into(),
                    fault: ElectrodesFault::Bridged
                }]
            );
            let faint: Vec<Vec<f64>> = clean
                .iter()
                .map(|own| own.iter().map(|v| 1e-6 * v).collect())
                .collect();
            assert!(matches!(
                said(&faint)[..],
                [EegWarning::Electrodes {
                    fault: ElectrodesFault::Amplitude { .. },
                    ..
                }]
            ));
            // Of few electrodes what can be said.
            assert_eq!(said(&clean[..7]), []);
            assert_eq!(said(&clean[..1]), []);
            let few = said(&noisy[2..6]);
            assert!(
                matches!(&few[..], [EegWarning::Electrodes { names, fault: ElectrodesFault::Noisy { .. } }] if names.starts_with("E1 (")),
                "{few:?}"
            );
            assert_eq!(
                said(&bridge[7..10]),
                [EegWarning::Electrodes {
                    names: "E1 and E2".into(),
                    fault: ElectrodesFault::Bridged
                }]
            );
            assert!(matches!(
                said(&faint[..2])[..],
                [EegWarning::Electrodes {
                    fault: ElectrodesFault::Amplitude { .. },
                    ..
                }]
            ));
        }
    }
}
