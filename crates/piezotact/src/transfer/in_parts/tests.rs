//! Parts against the whole recording.

use super::*;
use crate::quantity::Volts;
use crate::recording::{Channel, Condition, Provenance};
use crate::spectrum::WelchConfig;
use crate::statistics::random::Random;
use crate::transfer::{Estimator, ImpactConfig, between_channels};

const LENGTH: usize = 150_000;

fn config(lost_s: Vec<[f64; 2]>) -> BetweenConfig<'static> {
    BetweenConfig {
        drive: "drive",
        response: "acceleration",
        welch: WelchConfig::hann(512),
        excitation: Excitation::Found,
        impact: ImpactConfig::usual(),
        estimator: Estimator::H1,
        known_input: true,
        volts_per_full_scale: Some(Volts(10.0)),
        setup: None,
        lost_s,
    }
}

/// Noise, what a device of three taps makes of it read at the places `place`, and a force.
fn recording(place: impl Fn(f64) -> f64, change: impl Fn(usize, &mut [f64; 3])) -> Recording {
    let mut random = Random::stream(11, 0, "parts");
    let drive: Vec<f64> = (0..LENGTH).map(|_| random.normal()).collect();
    let taps = |i: usize| 2.0 * drive[i] - drive[i.saturating_sub(1)];
    let answer: Vec<f64> = (0..LENGTH).map(taps).collect();
    let answer = at_places(&answer, LENGTH, |i| place(i as f64));
    let mut samples: [Vec<f64>; 3] = Default::default();
    for i in 0..LENGTH {
        let noise = 0.3 * random.normal();
        let mut all = [
            drive[i],
            answer[i] + noise + 9.81,
            1.0 + 0.1 * random.normal(),
        ];
        change(i, &mut all);
        samples.iter_mut().zip(all).for_each(|(to, v)| to.push(v));
    }
    let names = ["drive", "acceleration", "fz"];
    let units = [Unit::Volt, Unit::MetrePerSecondSquared, Unit::Newton];
    let channels = names.into_iter().zip(units).zip(samples);
    of(channels
        .map(|((name, unit), samples)| Channel {
            name: name.into(),
            unit,
            samples,
        })
        .collect())
}

fn of(channels: Vec<Channel>) -> Recording {
    let rate = SampleRate::new(5000.0).unwrap();
    Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap()
}

/// The channels called `names`, from one sample up to another.
fn part(recording: &Recording, names: &[&str], range: Range<usize>) -> Recording {
    let channels = recording.channels().iter();
    let channels = channels.filter(|channel| names.contains(&channel.name.as_str()));
    of(channels
        .map(|channel| Channel {
            samples: channel.samples[range.clone()].to_vec(),
            ..channel.clone()
        })
        .collect())
}

fn in_parts(
    recording: &Recording,
    config: &BetweenConfig<'_>,
    length: usize,
) -> Result<Option<BetweenChannels>, TransferError> {
    let names: Vec<&str> = recording.channels().iter().map(|c| &*c.name).collect();
    let mut empty = part(recording, &names, 0..0);
    empty.about = recording.about.clone();
    let mut each = |names: &[&str], take: &mut dyn FnMut(&Recording)| {
        for from in (0..LENGTH).step_by(length) {
            take(&part(recording, names, from..(from + length).min(LENGTH)));
        }
        Ok::<(), std::convert::Infallible>(())
    };
    between_in_parts(&empty, LENGTH, config, &mut each).unwrap()
}

/// Where the clocks agree, all of the result is that of the whole recording, with lost stretches and a change too.
#[test]
fn parts_of_any_length_give_the_whole_result() {
    for (lost_s, from) in [
        (vec![], LENGTH),
        (vec![[3.0, 3.5], [11.0, 11.02]], LENGTH),
        (vec![], 2 * LENGTH / 3),
    ] {
        let recording = recording(
            |i| i,
            |i, all| {
                if i >= from {
                    all[1] *= 0.3;
                    all[2] = 0.2;
                }
            },
        );
        let config = config(lost_s);
        let whole = between_channels(&recording, &config).unwrap();
        assert_eq!(whole.function.change.is_some(), from < LENGTH);
        for length in [37_507, 49_999, LENGTH] {
            let found = in_parts(&recording, &config, length).unwrap().unwrap();
            let bits = |of: &BetweenChannels| {
                let lines = of.function.response.iter();
                lines
                    .flat_map(|h| [h.re.to_bits(), h.im.to_bits()])
                    .collect::<Vec<_>>()
            };
            assert!(bits(&found) == bits(&whole), "{length}");
            assert_eq!(found.function.coherence, whole.function.coherence);
            assert_eq!(found.spectra, whole.spectra, "{length}");
            let change = |of: &BetweenChannels| {
                (of.function.change.as_ref()).map(|c| (c.from_s, c.to_s, c.by_db))
            };
            assert_eq!(change(&found), change(&whole));
            if from == LENGTH {
                let (found, whole) = (&found.function, &whole.function);
                assert_eq!(found.about, whole.about, "{length}");
            }
        }
    }
}

/// A clock that drifts, with samples missing in the middle, is followed over all parts.
#[test]
fn clocks_are_brought_together_over_all_parts() {
    let place = |i: f64| i * (1.0 + 60e-6) + if i > 70_000.0 { 7.0 } else { 0.0 };
    let recording = recording(place, |_, _| ());
    let config = config(Vec::new());
    let whole = between_channels(&recording, &config).unwrap();
    let codes = |of: &BetweenChannels| {
        let all = of.function.about.warnings.iter();
        all.map(|warning| warning.code.clone()).collect::<Vec<_>>()
    };
    assert!(codes(&whole).contains(&"clocks_differ".to_owned()));
    for length in [20_011, 75_000] {
        let found = in_parts(&recording, &config, length).unwrap().unwrap();
        assert_eq!(codes(&found), codes(&whole), "{length}");
        let apart = (found.function.response.iter().zip(&whole.function.response))
            .map(|(a, b)| (a - b).norm() / b.norm())
            .fold(0.0, f64::max);
        // Places are differences of large numbers: they are rounded otherwise.
        assert!(apart < 1e-8, "{apart}");
    }
}

#[test]
fn what_is_refused_of_the_whole_is_refused_in_parts() {
    let quiet = recording(|i| i, |_, all| all[1] = 0.5);
    let hits = recording(
        |i| i,
        |i, all| {
            all[0] = f64::from(u8::from(i % 10_000 < 8));
            all[1] = all[0];
        },
    );
    let usual = config(Vec::new());
    let wrong = |recording: &Recording, config: &BetweenConfig<'_>| {
        let whole = between_channels(recording, config).unwrap_err();
        assert_eq!(in_parts(recording, config, 40_000).unwrap_err(), whole);
    };
    wrong(&quiet, &usual);
    for (drive, response) in [("drive", "drive"), ("drive", "fx"), ("fz", "acceleration")] {
        let config = BetweenConfig {
            drive,
            response,
            ..usual.clone()
        };
        wrong(&hits, &config);
    }
    let long = BetweenConfig {
        welch: WelchConfig::hann(LENGTH + 1),
        ..usual.clone()
    };
    wrong(&recording(|i| i, |_, _| ()), &long);
    // Hits need the whole recording.
    assert!(in_parts(&hits, &usual, 40_000).unwrap().is_none());
}
