//! Several transfer functions of one kind: their spread and their average.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::{TransferError, TransferFunction};
use crate::quantity::{Band, Quantity};
use crate::recording::Provenance;
use crate::statistics::standard_deviation;

/// The spread of transfer functions over a band, line by line in dB re 1 unit of `O` per `I`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Ensemble {
    /// The number of transfer functions.
    pub count: usize,
    /// The lines of the band, Hz.
    pub frequencies_hz: Vec<f64>,
    /// The lowest magnitude of every line, dB.
    pub lowest_db: Vec<f64>,
    /// The highest, dB.
    pub highest_db: Vec<f64>,
    /// The standard deviation of the magnitudes, dB.
    pub spread_db: Vec<f64>,
    /// The largest distance between highest and lowest, dB.
    pub max_deviation_db: f64,
    /// Where it is, Hz.
    pub max_deviation_at_hz: f64,
}

/// How transfer functions are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum BundleAverage {
    /// The mean of the complex values: its magnitude is reduced where phases differ.
    Complex,
    /// The mean of the logarithms of the magnitudes and of the phases: its magnitude does not depend on the phases.
    LogMagnitude,
}

impl BundleAverage {
    /// Which average, in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Complex => "complex mean",
            Self::LogMagnitude => "mean of log magnitudes",
        }
    }
}

pub(super) fn same_lines<I: Quantity, O: Quantity>(
    functions: &[&TransferFunction<I, O>],
    least: usize,
) -> Result<(), TransferError> {
    let Some(first) = functions.first().filter(|_| functions.len() >= least) else {
        return Err(TransferError::Few {
            expected: least,
            found: functions.len(),
        });
    };
    let one_hz = first.resolution_hz;
    let differs = |f: &&&TransferFunction<I, O>| {
        (f.resolution_hz / one_hz - 1.0).abs() > 1e-9 || f.response.len() != first.response.len()
    };
    match functions.iter().find(differs) {
        Some(other) => Err(TransferError::OtherLines {
            one_hz,
            other_hz: other.resolution_hz,
        }),
        None => Ok(()),
    }
}

/// A magnitude in dB; finite (very low) for 0.
pub(crate) fn level_db(h: Complex<f64>) -> f64 {
    20.0 * h.norm().max(f64::MIN_POSITIVE).log10()
}

impl Ensemble {
    /// The spread of `curves`, levels in dB at `frequencies_hz`: lowest, highest and standard deviation at every line, in dB.
    ///
    /// Formula: max over lines of max − min over curves.
    ///
    /// Source: L. Felicetti's thesis (2024), section 5.1: the maximum deviation of a bundle of curves.
    #[must_use]
    pub fn of(frequencies_hz: &[f64], curves: &[&[f64]]) -> Self {
        let mut bundle = Self {
            count: curves.len(),
            frequencies_hz: frequencies_hz.to_vec(),
            lowest_db: Vec::new(),
            highest_db: Vec::new(),
            spread_db: Vec::new(),
            max_deviation_db: 0.0,
            max_deviation_at_hz: f64::NAN,
        };
        for (line, frequency_hz) in frequencies_hz.iter().enumerate() {
            let levels: Vec<f64> = curves.iter().map(|curve| curve[line]).collect();
            let lowest = levels.iter().copied().fold(f64::INFINITY, f64::min);
            let highest = levels.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if highest - lowest > bundle.max_deviation_db || line == 0 {
                bundle.max_deviation_db = highest - lowest;
                bundle.max_deviation_at_hz = *frequency_hz;
            }
            bundle.lowest_db.push(lowest);
            bundle.highest_db.push(highest);
            // The sample's, n − 1 in the denominator.
            let n = levels.len() as f64;
            let spread = standard_deviation(&levels) * (n / (n - 1.0)).sqrt();
            bundle.spread_db.push(spread);
        }
        bundle
    }
}

/// The average of `functions`, line by line, in units of `O` per `I`. The coherence is their mean, the number of averages
/// their sum, and the excited band the band common to all.
///
/// People differ more than estimates scatter, so the coherence does not give the uncertainty of the average over several: its
/// number of effective averages is unknown and it has no confidence limits. Condition and provenance are kept as far
/// as they agree.
///
/// Formula: complex: (1/n)·ΣH. Log-magnitude: exp(mean ln|H|)·exp(i·φ) with φ the phase of ΣH plus the mean of the
/// phases relative to it, each within ±π: phases need no unwrapping along the lines.
///
/// Source: L. Felicetti's thesis (2024), section 5.2, for the use; log-magnitude averaging as in J. S. Bendat and A. G.
/// Piersol, *Random Data*, 4th ed., chapter 9, for multiplicative scatter.
///
/// # Errors
/// [`TransferError::Few`] without functions, [`TransferError::OtherLines`] when their lines differ, [`TransferError::OtherDevice`] when
/// they were measured through different gains or output levels.
pub fn average<I: Quantity, O: Quantity>(
    functions: &[&TransferFunction<I, O>],
    averaging: BundleAverage,
) -> Result<TransferFunction<I, O>, TransferError> {
    same_lines(functions, 1)?;
    let first = functions[0];
    if let Some(other) = functions.iter().find(|f| f.drive != first.drive) {
        let told = |f: &TransferFunction<I, O>| match &f.drive {
            Some(setup) => format!(
                "gain {} and {:.3} V at full scale",
                setup.gain, setup.volts_per_full_scale
            ),
            None => "a device that is not described".into(),
        };
        return Err(TransferError::OtherDevice {
            one: told(first),
            other: told(other),
        });
    }
    let n = functions.len() as f64;
    let line_of = |line: usize| functions.iter().map(move |f| f.response[line]);
    let response = (0..first.response.len())
        .map(|line| {
            let sum: Complex<f64> = line_of(line).sum();
            match averaging {
                BundleAverage::Complex => sum / n,
                BundleAverage::LogMagnitude => {
                    let magnitude = line_of(line)
                        .map(|h| h.norm().max(f64::MIN_POSITIVE).ln())
                        .sum::<f64>()
                        / n;
                    let about = line_of(line).map(|h| (h * sum.conj()).arg()).sum::<f64>() / n;
                    Complex::from_polar(magnitude.exp(), sum.arg() + about)
                }
            }
        })
        .collect();
    let coherence = (0..first.coherence.len())
        .map(|line| functions.iter().map(|f| f.coherence[line]).sum::<f64>() / n)
        .collect();
    let mut averaged = TransferFunction::from_lines(
        response,
        coherence,
        first.resolution_hz,
        first.rate,
        first.estimator,
        functions
            .iter()
            .fold(0, |sum, f| sum.saturating_add(f.averages)),
    )
    .map_err(|error| match error {
        TransferError::Zero if functions.len() > 1 => TransferError::Cancel {
            count: functions.len(),
        },
        other => other,
    })?;
    let few = averaged.few_averages();
    averaged.about.warnings.extend(few);
    let people = people_of(functions);
    averaged.effective_averages = match people {
        0 | 1 => functions.iter().map(|f| f.effective_averages).sum(),
        _ => 0.0,
    };
    averaged.excited = excited_by_all(functions)?;
    averaged.known_input = functions.iter().all(|f| f.known_input);
    let told = match averaging {
        BundleAverage::Complex => "complex mean",
        BundleAverage::LogMagnitude => "mean of log magnitudes and phases",
    };
    averaged.drive.clone_from(&first.drive);
    averaged.about.condition = first.about.condition.clone();
    averaged.about.condition.participant = None;
    averaged.about.condition.twin_seed = None;
    averaged.about.provenance = in_common(functions, people)
        .then(format!("{told} of {} transfer functions", functions.len()));
    Ok(averaged)
}

/// How many participants are named.
fn people_of<I: Quantity, O: Quantity>(functions: &[&TransferFunction<I, O>]) -> usize {
    let mut people: Vec<String> = functions
        .iter()
        .filter_map(|f| f.about.condition.person())
        .collect();
    people.sort();
    people.dedup();
    people.len()
}

/// The band common to all functions whose excited band is known.
fn excited_by_all<I: Quantity, O: Quantity>(
    functions: &[&TransferFunction<I, O>],
) -> Result<Option<Band>, TransferError> {
    let mut common: Option<Band> = None;
    for excited in functions.iter().filter_map(|f| f.excited) {
        common = Some(match common {
            None => excited,
            Some(known) => known.common(excited).ok_or(TransferError::Excited {
                one: known,
                other: excited,
            })?,
        });
    }
    Ok(common)
}

/// The provenance common to all of them.
fn in_common<I: Quantity, O: Quantity>(
    functions: &[&TransferFunction<I, O>],
    people: usize,
) -> Provenance {
    let mut common = functions[0].about.provenance.clone();
    let all =
        |holds: &dyn Fn(&Provenance) -> bool| functions.iter().all(|f| holds(&f.about.provenance));
    if people > 1 {
        common.source = format!("average of {people} participants");
    } else if !all(&|p| p.source == common.source) {
        common.source = format!("average of {} measurements", functions.len());
    }
    common.answered_with = common
        .answered_with
        .filter(|one| all(&|p| p.answered_with == Some(*one)));
    common.bench = common.bench.filter(|kind| all(&|p| p.bench == Some(*kind)));
    common.measured_at =
        (common.measured_at).filter(|at| all(&|p| p.measured_at.as_ref() == Some(at)));
    common.seed = common.seed.filter(|seed| all(&|p| p.seed == Some(*seed)));
    common.steps.retain(|step| all(&|p| p.steps.contains(step)));
    common
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Acceleration, Force, Hertz, SampleRate};
    use crate::transfer::Estimator;

    type H = TransferFunction<Force, Acceleration>;

    fn function(values: &[Complex<f64>]) -> H {
        let rate = SampleRate::new(1_000.0).unwrap();
        let coherence = vec![0.9; values.len()];
        H::from_lines(values.to_vec(), coherence, 10.0, rate, Estimator::H1, 20).unwrap()
    }

    fn flat(levels_db: [f64; 5], phase: f64) -> H {
        let line = |db: f64| Complex::from_polar(10f64.powf(db / 20.0), phase);
        function(&levels_db.map(line))
    }

    #[test]
    fn a_bundle_has_its_widest_line() {
        let curves: [&[f64]; 3] = [&[0.0, 1.0, 2.0], &[3.0, 1.0, -4.0], &[0.0, 1.0, 0.0]];
        let bundle = Ensemble::of(&[10.0, 20.0, 30.0], &curves);
        assert!((bundle.max_deviation_db - 6.0).abs() < 1e-9);
        assert!((bundle.max_deviation_at_hz - 30.0).abs() < 1e-9);
        // Of 0, 3 and 0 dB.
        assert!((bundle.spread_db[0] - 3f64.sqrt()).abs() < 1e-9);
    }

    /// Two curves of 0 dB, 90° apart: the complex mean has −3 dB, the mean of logarithms 0; both lie between in phase.
    /// Beyond ±180° the phases do not jump.
    #[test]
    fn averages_differ_where_phases_do() {
        for turn in [0.0, 3.0] {
            let (a, b) = (
                flat([0.0; 5], turn - std::f64::consts::FRAC_PI_4),
                flat([0.0; 5], turn + std::f64::consts::FRAC_PI_4),
            );
            let complex = average(&[&a, &b], BundleAverage::Complex).unwrap();
            let log = average(&[&a, &b], BundleAverage::LogMagnitude).unwrap();
            assert!((level_db(complex.response[2]) + 3.0103).abs() < 1e-4);
            assert!(level_db(log.response[2]).abs() < 1e-9);
            for averaged in [complex, log] {
                let off = (averaged.response[2] * Complex::from_polar(1.0, -turn)).arg();
                assert!(off.abs() < 1e-9, "{off}");
            }
        }
    }

    /// What an average keeps of those that it is of: of one person all, of several what they have in common.
    #[test]
    fn an_average_says_what_it_is_of() {
        let of = |who: &str, seed: u64, excited: [f64; 2]| {
            let mut f = flat([0.0; 5], 0.0);
            f.about.condition.participant = Some(who.into());
            f.about.provenance.source = format!("bench with {who}");
            f.about.provenance.seed = Some(seed);
            f.about.provenance.steps = vec!["bench".into(), format!("of {who}")];
            f.effective_averages = 12.5;
            f.averages = usize::MAX;
            f.excited = Band::new(Hertz(excited[0]), Hertz(excited[1])).ok();
            f
        };
        let (a, again, b) = (
            of("a", 7, [10.0, 40.0]),
            of("a", 7, [0.0, 30.0]),
            of("b", 8, [10.0, 40.0]),
        );
        let log = BundleAverage::LogMagnitude;
        let own = average(&[&a, &again], log).unwrap();
        assert_eq!(own.averages, usize::MAX);
        assert!((own.effective_averages - 25.0).abs() < 1e-12 && own.confidence().is_some());
        assert_eq!(own.excited, Band::new(Hertz(10.0), Hertz(30.0)).ok());
        assert_eq!(own.about.provenance.source, "bench with a");
        assert_eq!(
            (own.about.provenance.seed, own.about.provenance.steps.len()),
            (Some(7), 3)
        );
        let both = average(&[&a, &b], log).unwrap();
        assert!(both.effective_averages == 0.0 && both.confidence().is_none());
        assert_eq!(both.about.provenance.source, "average of 2 participants");
        assert_eq!(
            (
                both.about.provenance.seed,
                both.about.provenance.steps.len()
            ),
            (None, 2)
        );
        let apart = average(&[&of("a", 7, [10.0, 20.0]), &of("a", 7, [30.0, 40.0])], log);
        assert!(matches!(apart, Err(TransferError::Excited { .. })));
        let turned = flat([0.0; 5], 0.0);
        let minus = function(&[Complex::from(-1.0); 5]);
        let none = average(&[&turned, &minus], BundleAverage::Complex)
            .unwrap_err()
            .to_string();
        assert!(
            none.contains("cancel") && none.contains("inverted"),
            "{none}"
        );
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let a = flat([0.0; 5], 0.0);
        let longer = function(&[Complex::from(1.0); 6]);
        let log = BundleAverage::LogMagnitude;
        let none: [&H; 0] = [];
        assert!(matches!(
            average(&none, log),
            Err(TransferError::Few { .. })
        ));
        assert!(matches!(
            average(&[&a, &longer], log),
            Err(TransferError::OtherLines { .. })
        ));
    }
}
