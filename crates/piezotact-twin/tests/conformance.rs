//! The twin's benches keep to the contract of a bench.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::device::{DeviceDescription, GainName};
use piezotact::quantity::{SampleRate, Seconds};
use piezotact_bench::conformance::{Subject, of_acquirer, of_bench};
use piezotact_twin::{
    ActTouch, ActiveProtocol, Pace, Participant, ShakerBench, ShakerExcitation, ShakerMount,
    SlidingDirection, TriboAir, TwinBench, TwinParameters,
};

fn subject() -> Subject {
    Subject::with_tone(0.1, SampleRate::new(48_000.0).unwrap()).unwrap()
}

fn person(parameters: &TwinParameters) -> Participant {
    Participant::of(2, 7, parameters)
}

#[test]
fn the_twin_keeps_to_the_contract() {
    let parameters = TwinParameters::built_in();
    let set = DeviceDescription::drv2667()
        .at(&GainName::new("B3"))
        .unwrap();
    let make = move || TwinBench::new(&parameters, person(&parameters), &set).into_bench();
    assert_eq!(of_bench(make, &subject()), []);
}

/// Whoever touches something is done after a few strokes.
#[test]
fn touching_keeps_to_the_contract() {
    let parameters = TwinParameters::built_in();
    let touching = Subject {
        goes_on_for: Seconds(1.0),
        ..subject()
    };
    let (active, air) = (parameters.clone(), parameters.clone());
    let acttouch = move || {
        let protocol = ActiveProtocol {
            strokes: 2,
            movement: SlidingDirection::Proximal,
            pace: Pace::Metronome {
                speed_m_s: 0.03,
                stroke_s: None,
            },
        };
        let sample = active.sample("S8").unwrap();
        let bench = ActTouch::new(&active, person(&active), sample, protocol);
        bench.unwrap().into_acquirer()
    };
    assert_eq!(of_acquirer(acttouch, &touching), []);
    let triboair = move || {
        let sample = air.sample("S8").unwrap();
        let bench = TriboAir::new(&air, person(&air), sample, 2, 0.03);
        bench.unwrap().into_acquirer()
    };
    assert_eq!(of_acquirer(triboair, &touching), []);
    let shaker = move || {
        let drive = ShakerExcitation::thesis(Seconds(2.0), 7);
        ShakerBench::new(&parameters, person(&parameters), ShakerMount::Finger, drive)
            .into_acquirer()
    };
    assert_eq!(of_acquirer(shaker, &touching), []);
}
