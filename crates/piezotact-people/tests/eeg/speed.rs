//! Times of the work that `bench` also gives to MNE-Python; it asserts nothing, as machines differ.

use cpu_time::ProcessTime;
use piezotact::quantity::{Band, Hertz, SampleRate};
use piezotact::statistics::random::Random;
use piezotact_people::eeg::cluster;
use piezotact_people::eeg::tfr::{TfrConfig, TfrPlan, Window};

use super::epochs;
use super::reference::Npz;

/// The median CPU time of `count` runs, s.
fn median_s(count: usize, mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..count)
        .map(|_| {
            let start = ProcessTime::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[count / 2]
}

/// W6a: 100 epochs × 64 channels × 2 s at 1 kHz, 37 frequencies; W6b: 10 people × 100 times × 64 channels, 512 sign flips.
#[test]
#[ignore = "a measurement: cargo test --release -p piezotact-people --test all measure_eeg -- --ignored --nocapture"]
fn measure_eeg_against_mne() {
    let (count, channels, samples) = (100, 64, 2000);
    let mut random = Random::stream(6, 0, "eeg");
    let volts: Vec<f64> = (0..channels * count * samples)
        .map(|_| 1e-6 * random.normal())
        .collect();
    let all: Vec<String> = (0..channels).map(|c| format!("E{c}")).collect();
    let given = epochs(&all, count, 1000.0, 0.0, volts);
    let rate = SampleRate::new(1000.0).unwrap();
    let frequencies_hz: Vec<f64> = (4..41).map(f64::from).collect();
    for decimation in [1, 2, 5, 10] {
        let config = TfrConfig {
            cycles: frequencies_hz.iter().map(|f| f / 2.0).collect(),
            frequencies_hz: frequencies_hz.clone(),
            decimation,
        };
        let window = |from, to| Window {
            band: Band::new(Hertz(8.0), Hertz(12.0)).unwrap(),
            extent_s: [from, to],
        };
        let windows = [window(0.2, 0.7), window(0.8, 1.3)];
        let mut time = [0.0; 2];
        time[0] = median_s(3, || {
            let plan = TfrPlan::plan(&config, rate, samples).unwrap();
            assert!(plan.average(&given).unwrap().values[0] > 0.0);
        });
        time[1] = median_s(3, || {
            let plan = TfrPlan::plan(&config, rate, samples).unwrap();
            assert!(plan.trials(&given, &windows).unwrap().values[0] > 0.0);
        });
        println!(
            "W6a every {decimation}: average {:.2} s, trials {:.2} s",
            time[0], time[1]
        );
    }
    let Some(mut npz) = Npz::open() else {
        return;
    };
    let (people, grid, config) = npz.cluster();
    let time = median_s(9, || {
        assert_eq!(cluster::test(&people, &grid, &config).unwrap().flips, 512);
    });
    println!("W6b: {time:.4} s");
}
