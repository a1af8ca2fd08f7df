//! Ways of confusing stimuli: each is refused with the difference named. What changes nothing that a participant feels is accepted.

use piezotact::lineage::{Level, Operation, Step};
use piezotact::quantity::Decibels;

use super::super::super::protocol::read;
use super::*;
use crate::campaign::protocol::LIBRARY;

/// The drives of `plan` as `prepare --protocol` makes them.
fn made(protocol: &Protocol, plan: &Plan) -> Vec<RenderingFacts> {
    let mut drives = fits(protocol, plan);
    for facts in &mut drives {
        with_texture(
            facts,
            &texture_of(&protocol.stimulus(&facts.stimulus).unwrap()),
        );
    }
    drives
}

/// `facts` of a drive that was rendered from `texture`.
fn with_texture(facts: &mut RenderingFacts, texture: &Texture<Acceleration>) {
    facts.texture = texture.series.clone();
    facts.target_lineage = Some(texture.lineage.clone());
    facts.lineage = Some(rendered(texture.lineage.clone(), "tf.json"));
    facts.samples = Checksum::of(texture.series.samples().iter().copied());
}

fn rendered(lineage: Lineage, transfer: &str) -> Lineage {
    let step = Operation::Rendered {
        transfer: transfer.to_owned(),
        gain: Some("B3".to_owned()),
        level_db: -1.5,
        band_hz: "20..1000".parse().unwrap(),
        aim: None,
    };
    let level = stroke("S2").series.rms_about_mean();
    lineage.then(Step::between(step, level.clone(), level))
}

/// What is said of the stimuli of a protocol after `change`.
fn said_of(protocol: &Protocol, change: &dyn Fn(&mut [RenderingFacts])) -> Vec<String> {
    said_after(protocol, &BTreeMap::new(), change)
}

/// What is said of them where the session played drives before.
fn said_after(
    protocol: &Protocol,
    played: &BTreeMap<String, Sha>,
    change: &dyn Fn(&mut [RenderingFacts]),
) -> Vec<String> {
    let plan = planned(protocol, "discrimination");
    let mut drives = made(protocol, &plan);
    change(&mut drives);
    let here = on(BenchKind::Twin, Some("P01"));
    let known = Known {
        renderings: &drives,
        incomplete: &[],
        played,
        earlier: &[],
        panels: &[],
        bench: Some(&here),
        sensor: None,
        now_ms: NOW,
    };
    let found = not_ready(protocol, &plan, known).into_iter();
    let found = found.filter(|one| one.stimulus().is_some());
    found.map(|one| one.to_string()).collect()
}

fn library(name: &str) -> Protocol {
    from_library(name).unwrap().unwrap()
}

fn named<'a>(drives: &'a mut [RenderingFacts], stimulus: &str) -> &'a mut RenderingFacts {
    let mut drives = drives.iter_mut();
    drives.find(|one| one.stimulus == stimulus).unwrap()
}

/// All files of `from` under the name of `to`: what a person who copies or renames them leaves.
fn copied(drives: &mut [RenderingFacts], from: &str, to: &str) {
    let one = named(drives, from).clone();
    let place = named(drives, to);
    *place = RenderingFacts {
        stimulus: place.stimulus.clone(),
        file: place.file.clone(),
        target_file: place.target_file.clone(),
        ..one
    };
}

/// `facts` of the stimulus that `with` describes in place of its own.
fn made_otherwise(drives: &mut [RenderingFacts], stimulus: &str, with: &Stimulus) {
    with_texture(named(drives, stimulus), &texture_of(with));
}

/// The stroke on `sample`, `times` as strong.
fn louder(sample: &str, times: f64) -> Texture<Acceleration> {
    let touched = stroke(sample);
    let samples = touched.series.samples().iter().map(|x| times * x);
    let series = Series::new(samples.collect(), touched.series.rate()).unwrap();
    Texture::of(format!("{sample}.parquet"), series)
}

/// `S2 INVERTED` with the level of `other`, cut as a stroke once more.
fn cut_again(drives: &mut [RenderingFacts], other: &Texture<Acceleration>) {
    let texture = stroke("S2");
    let done = piezotact::manipulate::rms_of(&texture.series, other, Level::Whole).unwrap();
    let mut texture = texture.then(done);
    let level = texture.series.rms_about_mean();
    for number in [1, 2] {
        let cut = Operation::Stroke {
            number,
            from_s: 0.0,
            to_s: 1.0,
            high_pass_hz: 5.0,
        };
        let step = Step::between(cut, level.clone(), level.clone());
        texture.lineage.steps.push(step);
    }
    with_texture(named(drives, INVERTED), &texture);
}

fn of(sample: &str) -> Stimulus {
    Stimulus {
        of: sample.to_owned(),
        ..Stimulus::default()
    }
}

const INVERTED: &str = "S2 INVERTED";

type Change = fn(&mut [RenderingFacts]);

#[test]
fn twenty_ways_of_confusing_stimuli_are_refused_with_the_difference_named() {
    let ways: [(&str, Change, &str); 32] = [
        (
            "copies of the plain texture",
            |d| copied(d, "S2", INVERTED),
            "S2 INVERTED: expected a drive of its own in drives/S2 INVERTED.wav, found that of S2 in drives/S2.wav",
        ),
        (
            "the plain texture, rendered under another name",
            |d| made_otherwise(d, INVERTED, &of("S2")),
            "S2 INVERTED: expected a drive of its own",
        ),
        (
            "the plain texture, a little louder so that its bytes differ",
            |d| {
                let gain_db = Some(0.5);
                made_otherwise(
                    d,
                    INVERTED,
                    &Stimulus {
                        gain_db,
                        ..of("S2")
                    },
                );
            },
            "S2 INVERTED: expected the level of S13, found its own level +0.500 dB by the lineage of drives/S2 INVERTED.wav",
        ),
        (
            "another manipulated one under its name",
            |d| copied(d, "S5 INVERTED", INVERTED),
            "S5 INVERTED: expected a drive of its own",
        ),
        (
            "a swap of two",
            |d| {
                let own = named(d, INVERTED).clone();
                copied(d, "S13 INVERTED", INVERTED);
                *named(d, "S13 INVERTED") = RenderingFacts {
                    stimulus: "S13 INVERTED".to_owned(),
                    ..own
                };
            },
            "S2 INVERTED: expected a texture of S2, found one of S13",
        ),
        (
            "a swap of two plain ones",
            |d| {
                let own = named(d, "S6").clone();
                copied(d, "S8", "S6");
                *named(d, "S8") = RenderingFacts {
                    stimulus: "S8".to_owned(),
                    ..own
                };
            },
            "S6: expected a texture of S6, found one of S8",
        ),
        (
            "the level of another sample",
            |d| {
                let level_of = Some("S6".to_owned());
                made_otherwise(
                    d,
                    INVERTED,
                    &Stimulus {
                        level_of,
                        ..of("S2")
                    },
                );
            },
            "expected the level of S13, found the level of S6.parquet by the lineage",
        ),
        (
            "the spectrum instead of the level",
            |d| {
                let spectrum_of = Some("S13".to_owned());
                made_otherwise(
                    d,
                    INVERTED,
                    &Stimulus {
                        spectrum_of,
                        ..of("S2")
                    },
                );
            },
            "expected its own spectrum, found spectrum of S13.parquet by the lineage",
        ),
        (
            "a spectrum that nobody stated beside the level",
            |d| {
                let with = Stimulus {
                    level_of: Some("S13".to_owned()),
                    shift_hz: Some(20.0),
                    ..of("S2")
                };
                made_otherwise(d, INVERTED, &with);
            },
            "expected its own spectrum, found shift +20 Hz by the lineage",
        ),
        (
            "a warp of a plain one",
            |d| {
                let warp = Some(1.25);
                made_otherwise(d, "S8", &Stimulus { warp, ..of("S8") });
            },
            "S8: expected its own spectrum, found warp × 1.25",
        ),
        (
            "an edited lineage: another level in it",
            |d| {
                let gain_db = Some(6.0);
                let louder = texture_of(&Stimulus {
                    gain_db,
                    ..of("S2")
                });
                let facts = named(d, INVERTED);
                let own = facts.lineage.clone();
                with_texture(facts, &louder);
                (facts.lineage, facts.target_lineage) = (own.clone(), own);
            },
            "m/s² rms, as its lineage ends, found",
        ),
        (
            "an edited sample: another texture under an edited lineage",
            |d| {
                let facts = named(d, INVERTED);
                let other = Stimulus {
                    level_of: Some("S13".to_owned()),
                    ..of("S6")
                };
                let (own, level) = (facts.lineage.clone(), facts.texture.rms_about_mean());
                with_texture(facts, &texture_of(&other));
                let ratio = level.value / facts.texture.rms_about_mean().value;
                facts.texture = facts
                    .texture
                    .clone()
                    .amplified(Decibels::from_amplitude_ratio(ratio));
                (facts.lineage, facts.target_lineage) = (own.clone(), own);
            },
            "expected the stroke in targets/S2.wav, found another one by the samples of targets/S2 INVERTED.wav",
        ),
        (
            "another stroke of the same sample",
            |d| {
                let facts = named(d, INVERTED);
                let mut samples = facts.texture.samples().to_vec();
                samples.reverse();
                facts.texture = Series::new(samples, facts.texture.rate()).unwrap();
            },
            "expected the stroke in targets/S2.wav, found another one",
        ),
        (
            "the drive of another target",
            |d| named(d, "S6").lineage = named(d, "S8").lineage.clone(),
            "S6: expected a drive rendered from its target, S6.parquet, found one rendered from S8.parquet by the lineage of drives/S6.wav",
        ),
        (
            "a sidecar that was edited after the measurement",
            |d| named(d, INVERTED).changed_since_measured = Some("another level".to_owned()),
            "expected what the drive stated when it was measured, found another level by drives/S2 INVERTED.wav",
        ),
        (
            "another gain of the rendering",
            |d| named(d, INVERTED).level_db = -4.5,
            "expected the level of S13, found the level of S13.parquet, rendered -3.000 dB re drives/S11.wav",
        ),
        (
            "a plain texture that was rendered alone at another level",
            |d| named(d, "S6").level_db = 0.0,
            "S6: expected the level of S6 itself, found its own level, rendered +1.500 dB re drives/S11.wav by the lineage of drives/S6.wav",
        ),
        (
            "another band of the rendering",
            |d| {
                let lineage = named(d, "S6").lineage.as_mut().unwrap();
                let last = &mut lineage.steps.last_mut().unwrap().operation;
                let Operation::Rendered { band_hz, .. } = last else {
                    panic!("{last:?}");
                };
                *band_hz = "20..200".parse().unwrap();
            },
            "S6: expected a drive over 20–1000 Hz as drives/S11.wav, found one over 20–200 Hz by the lineage of drives/S6.wav",
        ),
        (
            "the level of another recording of that sample, and cut once more",
            |d| cut_again(d, &louder("S13", 1.7)),
            "expected the level of S13, found +4.690 dB re targets/S13.wav by the samples of targets/S2 INVERTED.wav",
        ),
        (
            "the level of that sample with a gain, and cut once more",
            |d| {
                let other = stroke("S13");
                let done = piezotact::manipulate::gain(&other.series, Decibels(6.0)).unwrap();
                cut_again(d, &other.then(done));
            },
            "expected the level of S13, found the level of S13.parquet by the lineage",
        ),
        (
            "another stroke of its recording, by the lineage alone",
            |d| {
                cut_again(d, &stroke("S13"));
                let of = |number: usize| Operation::Stroke {
                    number,
                    from_s: number as f64,
                    to_s: number as f64 + 0.5,
                    high_pass_hz: 5.0,
                };
                for (name, number) in [("S2", 4), (INVERTED, 3)] {
                    let facts = named(d, name);
                    for lineage in [&mut facts.lineage, &mut facts.target_lineage] {
                        let steps = &mut lineage.as_mut().unwrap().steps;
                        let level = facts.texture.rms_about_mean();
                        steps.insert(0, Step::between(of(number), level.clone(), level));
                    }
                }
            },
            "S2 INVERTED: expected the stroke in targets/S2.wav, found another one by the lineage of drives/S2 INVERTED.wav",
        ),
        (
            "a drive that is too long for the protocol",
            |d| named(d, INVERTED).drive_s = 31.5,
            "S2 INVERTED: expected a drive of at most 31.0 s for a texture that is played for 30.0 s, found 31.5 s",
        ),
        (
            "an edited sample in the sidecar of a target",
            |d| {
                copied(d, "S6", "S8");
                let facts = named(d, "S8");
                facts.sample = Some("S8".to_owned());
                facts.samples = Checksum::of([0.25]);
                facts.lineage.as_mut().unwrap().sample = Some("S6".to_owned());
            },
            "S8: expected a texture of S8, found one of S6 by the lineage of drives/S8.wav",
        ),
        (
            "the level of another sample under the name of a file",
            |d| {
                let facts = named(d, INVERTED);
                for lineage in [&mut facts.lineage, &mut facts.target_lineage] {
                    for step in &mut lineage.as_mut().unwrap().steps {
                        if let Operation::RmsOf { of, .. } = &mut step.operation {
                            of.sample = Some("S6".to_owned());
                        }
                    }
                }
            },
            "S2 INVERTED: expected the level of S13, found the level of S13.parquet (S6) by the lineage",
        ),
        (
            "a lineage of another sample in drive and target",
            |d| {
                let facts = named(d, INVERTED);
                for lineage in [&mut facts.lineage, &mut facts.target_lineage] {
                    lineage.as_mut().unwrap().sample = Some("S5".to_owned());
                }
            },
            "S2 INVERTED: expected a texture of S2, found one of S5 by the lineage of drives/S2 INVERTED.wav",
        ),
        (
            "another transfer function of the same person",
            |d| named(d, INVERTED).made_with = vec![Checksum::of([2.0])],
            "S2 INVERTED: expected the transfer function that drives/S11.wav was rendered with, found another one by the checksum",
        ),
        (
            "a level that the bench did not reach",
            |d| named(d, INVERTED).level_error_db = Some(-1.5),
            "expected the level of S13 within ±1 dB, found -1.70 dB from it by its measurement on the bench",
        ),
        (
            "another person",
            |d| named(d, INVERTED).strokes.condition.participant = Some("P02".to_owned()),
            "S2 INVERTED: expected strokes of P01, found those of P02",
        ),
        (
            "the transfer function of another person, or an average",
            |d| named(d, INVERTED).rendered_with = Whose::Average,
            "expected the transfer function of P01, found an averaged transfer function",
        ),
        (
            "another day",
            |d| named(d, INVERTED).strokes.at_ms = Some(NOW - 800 * HOUR),
            "S2 INVERTED: expected strokes of the last 720 h, found an age of 800.0 h",
        ),
        (
            "verified on another bench",
            |d| named(d, INVERTED).measurement.bench = Some(BenchKind::Hardware),
            "S2 INVERTED: expected a measurement of the drive on the digital twin, found real devices",
        ),
        (
            "not verified",
            |d| named(d, INVERTED).verified = Outcome::NotDecided,
            "S2 INVERTED: its verification is not decided",
        ),
    ];
    let protocol = library("amplitude_inversion");
    for (way, change, part) in ways {
        let said = said_of(&protocol, &change);
        assert!(
            said.iter().any(|one| one.contains(part)),
            "{way}: {said:#?}"
        );
        assert!(said.len() <= 2, "{way}: {said:#?}");
    }
    // The protocol was edited after the drives were made: its stimuli are others then.
    let edited = |from: &str, to: &str| {
        let (_, toml) = LIBRARY[2];
        assert!(toml.contains(from), "{from}");
        let edited = read(&toml.replacen(from, to, 1)).unwrap();
        let plan = planned(&edited, "discrimination");
        let drives = made(&protocol, &plan);
        said_of(&edited, &|found| found.clone_from_slice(&drives))
    };
    let said = edited(
        "of = \"S2\", level_of = \"S13\"",
        "of = \"S2\", level_of = \"S6\"",
    );
    assert!(
        said.len() == 1
            && said[0]
                .contains("S2 INVERTED: expected the level of S6, found the level of S13.parquet"),
        "{said:?}"
    );
    let said = edited(
        "{ whose = \"own\" }",
        "{ whose = \"average\", panel = \"panel of 20\" }",
    );
    assert!(
        said.iter()
            .all(|one| one.contains("expected an averaged transfer function"))
    );
    assert_eq!(said.len(), 10);
}

#[test]
fn what_changes_nothing_that_is_felt_is_accepted() {
    let ways: [(&str, Change); 7] = [
        ("as prepared", |_| ()),
        ("a renamed folder, a moved study", |d| {
            for facts in d {
                facts.file = format!("/elsewhere/{}", facts.file);
                facts.target_file = format!("/elsewhere/{}", facts.target_file);
            }
        }),
        ("the same stroke rendered again", |d| {
            let again = stroke("S2");
            with_texture(named(d, "S2"), &again);
            named(d, "S2").samples = Checksum::of([0.5]);
        }),
        ("a renamed file of the transfer function", |d| {
            let facts = named(d, INVERTED);
            let target = facts.target_lineage.clone().unwrap();
            facts.lineage = Some(rendered(target, "tf-of-P01.json"));
        }),
        ("numbers that were rounded in a file", |d| {
            let facts = named(d, INVERTED);
            let rounded = facts.texture.samples().iter().map(|x| f64::from(*x as f32));
            facts.texture = Series::new(rounded.collect(), facts.texture.rate()).unwrap();
        }),
        (
            "a measurement that is as far from its target as that of the sample",
            |d| {
                for facts in d {
                    facts.level_error_db = Some(1.1);
                }
            },
        ),
        ("what other systems do not state", |d| {
            for facts in d {
                facts.sample = None;
                facts.made_with = Vec::new();
                facts.target_lineage = None;
                facts.level_error_db = None;
            }
        }),
    ];
    for name in ["amplitude_inversion", "roughness_jnd"] {
        let protocol = library(name);
        for (way, change) in &ways {
            if name == "amplitude_inversion" || *way == "as prepared" {
                assert_eq!(said_of(&protocol, change), [""; 0], "{name}: {way}");
            }
        }
    }
}

#[test]
fn a_session_goes_on_with_the_drives_that_it_played() {
    let protocol = library("amplitude_inversion");
    let sha = |name: &str| (name.to_owned(), Sha::of(name.as_bytes()));
    let played = BTreeMap::from(["S2", INVERTED].map(sha));
    assert_eq!(said_after(&protocol, &played, &|_| ()), [""; 0]);
    let said = said_after(&protocol, &played, &|drives| {
        named(drives, INVERTED).sha = Sha::of(b"prepared again");
        named(drives, "S6").sha = Sha::of(b"not played yet");
    });
    let part = "S2 INVERTED: expected the drive that this session played before, found another one in drives/S2 INVERTED.wav; go on without giving drives";
    assert!(said.len() == 1 && said[0].contains(part), "{said:?}");
}

#[test]
fn increments_of_one_texture_are_told_apart() {
    let protocol = library("roughness_jnd");
    let step = "S8 increment -26";
    let with = |gains: &[f64]| {
        let mut texture = stroke("S8");
        for gain_db in gains {
            let done = piezotact::manipulate::gain(&texture.series, Decibels(*gain_db)).unwrap();
            texture = texture.then(done);
        }
        said_of(&protocol, &|drives| {
            with_texture(named(drives, step), &texture)
        })
    };
    for (gains, refused) in [
        (&[0.664][..], 1),
        (&[0.6], 1),
        (&[], 1),
        (&[0.43], 0),
        (&[0.4, 0.025], 0),
    ] {
        let said = with(gains);
        assert_eq!(said.len(), refused, "{gains:?}: {said:?}");
    }
    let said = with(&[0.52]);
    let part = "expected the level of S8 itself +0.425 dB, found its own level +0.520 dB";
    assert!(said.iter().any(|one| one.contains(part)), "{said:?}");
    let all_one = |drives: &mut [RenderingFacts]| {
        let names: Vec<String> = drives.iter().map(|one| one.stimulus.clone()).collect();
        for name in names.iter().filter(|name| *name != "S8") {
            copied(drives, "S8", name);
        }
    };
    assert_eq!(said_of(&protocol, &all_one).len(), 14);
}

/// Manipulations of the spectrum, of thesis 7.2, with which no protocol of the library is made.
#[test]
fn a_stimulus_of_another_spectrum_is_compared_with_what_the_protocol_states() {
    let (_, toml) = LIBRARY[2];
    let from = "name = \"S2 INVERTED\", of = \"S2\", level_of = \"S13\"";
    for (stated, found) in [
        ("spectrum_of = \"S13\"", "spectrum of S13"),
        (
            "spectrum_of = \"S13\", level_of = \"S13\"",
            "spectrum of S13",
        ),
        ("warp = 1.25, gain_db = 2", "warp × 1.25"),
        ("shift_hz = -10", "shift -10 Hz"),
        ("band = { hz = [100, 300] }", "100–300 Hz removed"),
        (
            "band = { hz = [100, 300], gain_db = -6 }",
            "100–300 Hz -6 dB",
        ),
    ] {
        assert!(toml.contains(from));
        let to = format!("name = \"S2 INVERTED\", of = \"S2\", {stated}");
        let protocol = read(&toml.replacen(from, &to, 1)).unwrap();
        assert_eq!(said_of(&protocol, &|_| ()), [""; 0], "{stated}");
        let plain = |drives: &mut [RenderingFacts]| {
            let inverted = library("amplitude_inversion");
            let inverted = inverted.stimulus(INVERTED).unwrap().into_owned();
            made_otherwise(drives, INVERTED, &inverted);
        };
        let said = said_of(&protocol, &plain);
        let part = format!("expected {found}, found its own spectrum");
        assert!(
            said.len() == 1 && said[0].contains(&part),
            "{stated}: {said:?}"
        );
    }
    let refused = |stated: &str| {
        let to = format!("name = \"S2 INVERTED\", of = \"S2\", {stated}");
        read(&toml.replacen(from, &to, 1)).unwrap_err().to_string()
    };
    assert!(refused("level_of = \"S2\"").contains("name another sample than S2"));
    assert!(refused("warp = 99").contains("warp: expected 0.1 to 10, found 99"));
    assert!(refused("shift_hz = nan").contains("shift_hz"));
    assert!(refused("spectrum_of = \"S99\"").contains("sample `S99` is not declared"));
}

#[test]
fn a_stated_level_is_compared_with_that_of_the_samples() {
    let protocol = library("detection_threshold");
    let at = |level_db: f64, change: &dyn Fn(&mut [RenderingFacts])| {
        said_of(&protocol, &|drives| {
            drives.iter_mut().for_each(|one| one.level_db = level_db);
            change(drives);
        })
    };
    assert_eq!(at(0.0, &|_| {}), [""; 0]);
    let lowered = at(-2.5, &|_| {});
    assert!(
        lowered.iter().any(|one| one.contains(
            "S8 at -30 dB: expected -30 dB re 1 m/s², found -32.500 dB re 1 m/s², rendered at -2.5 dB"
        )),
        "{lowered:?}"
    );
    let louder = at(0.0, &|drives| {
        let rms_db = Some(-28.5);
        made_otherwise(drives, "S8 at -30 dB", &Stimulus { rms_db, ..of("S8") });
    });
    assert!(
        louder.len() == 1 && louder[0].contains("found -28.500 dB"),
        "{louder:?}"
    );
    let measured = at(0.0, &|drives| {
        named(drives, "S8 at -30 dB").level_error_db = Some(1.5)
    });
    assert!(
        measured.len() == 1 && measured[0].contains("+1.50 dB from it"),
        "{measured:?}"
    );
}

/// Nothing below the band is played: the level of another sample is that in the band. Over all frequencies it may be many dB off.
#[test]
fn a_level_is_that_in_the_band_that_is_rendered() {
    let said = |hum: f64, measured: Level| {
        let change = |drives: &mut [RenderingFacts]| {
            let touched = stroke("S13");
            let hummed = touched.series.samples().iter().enumerate();
            let hummed = hummed
                .map(|(i, x)| x + hum * (std::f64::consts::TAU * 8.0 * i as f64 / 4000.0).sin());
            let series = Series::new(hummed.collect(), touched.series.rate()).unwrap();
            let other = Texture::of("S13.parquet", series);
            with_texture(named(drives, "S13"), &other);
            let own = stroke("S2");
            let done = piezotact::manipulate::rms_of(&own.series, &other, measured).unwrap();
            with_texture(named(drives, INVERTED), &own.then(done));
        };
        let said = said_of(
            &from_library("amplitude_inversion").unwrap().unwrap(),
            &change,
        );
        said.into_iter().find(|line| line.starts_with(INVERTED))
    };
    let within = Level::Within("20..1000".parse().unwrap());
    assert_eq!(said(0.2, within), None);
    assert_eq!(said(0.01, Level::Whole), None);
    let refused = said(0.2, Level::Whole).unwrap();
    assert!(
        refused.contains("expected the level of S13, found +"),
        "{refused}"
    );
}
