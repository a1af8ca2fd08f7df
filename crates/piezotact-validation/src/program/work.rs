//! Our side of the benchmark: one piece of work in a process of its own, as `bench/peers.py` does for others.

mod blocks;
mod eeg;
mod files;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use cpu_time::ProcessTime;
use num_complex::Complex;
use piezotact::feature::{FeatureConfig, FeaturePlan, band_power};
use piezotact::manipulate::textures_of_strokes;
use piezotact::prepare::{common_level, typical_stroke};
use piezotact::quantity::{
    Acceleration, Band, Decibels, Degrees, Drive, Hertz, Newtons, SampleRate, Seconds, Unit,
};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::render::{Inverse, InverseConfig, InversePlan, PhaseForm, RenderConfig, render};
use piezotact::resample::Resampler;
use piezotact::score::with_perceptible_difference;
use piezotact::spectrum::{WelchConfig, WelchPlan};
use piezotact::statistics::peak;
use piezotact::stroke::{ForceRule, Judging, Signals, segment_by_force};
use piezotact::study::{Naming, Recorded, Stated, cut};
use piezotact::transfer::{CrossPlan, Estimator, TransferFunction};
use piezotact::verify::{Measured, VerifyConfig, verify};
use piezotact_bench::{Placement, RunPlan, StopHandle, Until};
use piezotact_dataset::wav::{SampleFormat, write_wav};
use piezotact_twin::{
    ActTouch, ActiveProtocol, Pace, Participant, SlidingDirection, TwinParameters,
};
use serde_json::json;

/// Runs the work `name` on the inputs in `folder`, once uncounted and then `repetitions` times, and prints
/// its times and memory.
#[allow(clippy::print_stdout, reason = "its result is one line of JSON")]
pub(crate) fn run(name: &str, folder: &Path, repetitions: usize) -> Result<()> {
    if name == "W4" {
        return blocks::w4(folder, repetitions);
    }
    let Prepared {
        input_bytes,
        mut work,
    } = match name {
        "W1a" => w1a(folder)?,
        "W1b" => w1b(folder)?,
        "W2a" => w2a(folder)?,
        "W2b" => w2b(folder, 1)?,
        "W2b2" => w2b(folder, 2)?,
        "W3" => w3(folder)?,
        "W5" => w5(folder, Judging::ContactOnly)?,
        "W5j" => w5(folder, Judging::Sliding)?,
        "W6" => w6(folder)?,
        "W9a" => files::recording(folder, "W9a.csv")?,
        "W9b" => files::recording(folder, "W9b.mat")?,
        "W9c" => files::recording(folder, "W9c.tdms")?,
        "W9d" => files::recording(folder, "W9d.uff")?,
        "W9e" => files::eeg(folder, "W9e.edf")?,
        "E1" => eeg::e1(folder)?,
        "E2" => eeg::e2(folder)?,
        "T1" => t1()?,
        _ => bail!("no work is called {name}"),
    };
    let mut result = work()?;
    let mut cpu_s = Vec::with_capacity(repetitions);
    let mut wall_s = Vec::with_capacity(repetitions);
    for _ in 0..repetitions {
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        result = work()?;
        cpu_s.push(cpu.elapsed().as_secs_f64());
        wall_s.push(wall.elapsed().as_secs_f64());
    }
    keep(folder, name, &result)?;
    println!(
        "{}",
        json!({ "cpu_s": cpu_s, "wall_s": wall_s, "peak_mb": peak_memory_mb()?, "input_mb": input_bytes as f64 / f64::from(1 << 20) })
    );
    Ok(())
}

/// Keeps our result of the work `name`.
fn keep(folder: &Path, name: &str, result: &[f64]) -> Result<()> {
    let bytes: Vec<u8> = result.iter().flat_map(|v| v.to_le_bytes()).collect();
    Ok(std::fs::write(
        folder.join(format!("{name}-piezotact.f64")),
        bytes,
    )?)
}

struct Prepared {
    input_bytes: usize,
    work: Box<dyn FnMut() -> Result<Vec<f64>>>,
}

/// An hour of active touch on the twin, four channels at 5 kHz, chunk by chunk as a journal takes it; the sums of the
/// channels are its result.
fn t1() -> Result<Prepared> {
    const HOUR: usize = 3_600 * 5_000;
    let parameters = TwinParameters::built_in();
    let run = RunPlan {
        label: "bench".into(),
        load: Some(Newtons(0.2)),
        angle: Degrees(20.0),
        placement: Placement::New,
        until: Until::Stopped,
    };
    let work = move || -> Result<Vec<f64>> {
        let protocol = ActiveProtocol {
            // More than an hour of strokes of 1.9 s: the run is left when the hour is over.
            strokes: 2_000,
            movement: SlidingDirection::Proximal,
            pace: Pace::Metronome {
                speed_m_s: 0.03,
                stroke_s: None,
            },
        };
        let person = Participant::of(1, 1, &parameters);
        let bench = ActTouch::new(&parameters, person, parameters.sample("S1")?, protocol)?;
        let mut acquirer = bench.into_acquirer();
        acquirer.ready(&run, &StopHandle::new())?;
        acquirer.start()?;
        let (mut made, mut sums) = (0, vec![0.0; 4]);
        while made < HOUR {
            let chunk = acquirer.next_chunk()?.context("less than an hour")?;
            made += chunk.channels[0].len();
            for (sum, channel) in sums.iter_mut().zip(&chunk.channels) {
                *sum += channel.iter().sum::<f64>();
            }
        }
        Ok(sums)
    };
    Ok(Prepared {
        input_bytes: 0,
        work: Box::new(work),
    })
}

fn load(folder: &Path, name: &str) -> Result<Vec<f64>> {
    use std::io::Read as _;
    let path = folder.join(format!("{name}.f64"));
    let mut file = std::io::BufReader::with_capacity(
        1 << 16,
        std::fs::File::open(&path).with_context(|| path.display().to_string())?,
    );
    // Block by block, so that the peak memory is that of the numbers.
    let mut numbers = Vec::with_capacity(std::fs::metadata(&path)?.len() as usize / 8);
    let mut number = [0; 8];
    while file.read_exact(&mut number).is_ok() {
        numbers.push(f64::from_le_bytes(number));
    }
    Ok(numbers)
}

fn peak_memory_mb() -> Result<f64> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status
        .lines()
        .find(|line| line.starts_with("VmHWM"))
        .context("no VmHWM")?;
    let kilobytes: f64 = line
        .split_whitespace()
        .nth(1)
        .context("no number")?
        .parse()?;
    Ok(kilobytes / 1024.0)
}

fn rate(hz: f64) -> Result<SampleRate> {
    Ok(SampleRate::new(hz)?)
}

fn w1a(folder: &Path) -> Result<Prepared> {
    let x = load(folder, "W1a")?;
    let mut plan = WelchPlan::new(&WelchConfig::thesis_2024(), rate(5000.0)?)?;
    let input_bytes = x.len() * 8;
    Ok(Prepared {
        input_bytes,
        work: Box::new(move || Ok(plan.estimate::<Acceleration>(&[&x])?.values)),
    })
}

fn w1b(folder: &Path) -> Result<Prepared> {
    let x = load(folder, "W1b")?;
    let mut plan = WelchPlan::new(&WelchConfig::thesis_2024(), rate(5000.0)?)?;
    let input_bytes = x.len() * 8;
    Ok(Prepared {
        input_bytes,
        work: Box::new(move || {
            let mut spectra = Vec::new();
            for channel in x.chunks_exact(1000 * 5000) {
                let strokes: Vec<&[f64]> = channel.chunks_exact(5000).collect();
                spectra.extend(plan.estimate::<Acceleration>(&strokes)?.values);
            }
            Ok(spectra)
        }),
    })
}

/// H1 and H2 in magnitude, and coherence, one after the other.
fn transfer(plan: &mut CrossPlan, drive: &[f64], answer: &[f64], out: &mut Vec<f64>) -> Result<()> {
    let spectra = plan.estimate::<Drive, Acceleration>(drive, answer)?;
    out.extend(spectra.h1().iter().map(|h| h.norm_sqr().sqrt()));
    out.extend(spectra.h2().iter().map(|h| h.norm_sqr().sqrt()));
    out.extend(spectra.coherence());
    Ok(())
}

fn w2a(folder: &Path) -> Result<Prepared> {
    let both = load(folder, "W2a")?;
    let mut plan = CrossPlan::new(&WelchConfig::hann(2048), rate(5000.0)?)?;
    let input_bytes = both.len() * 8;
    Ok(Prepared {
        input_bytes,
        work: Box::new(move || {
            let (drive, answer) = both.split_at(both.len() / 2);
            let mut out = Vec::new();
            transfer(&mut plan, drive, answer, &mut out)?;
            Ok(out)
        }),
    })
}

/// The pairs in equal parts, each on a thread with a plan of its own.
fn w2b(folder: &Path, threads: usize) -> Result<Prepared> {
    const N: usize = 150_000;
    let rolled = |base: &[f64], i: usize| {
        let signal = &base[(i % 6) * N..(i % 6 + 1) * N];
        [&signal[N - i..], &signal[..N - i]].concat()
    };
    let base = load(folder, "W2b")?;
    let (drives, answers) = base.split_at(6 * N);
    let pairs: Vec<[Vec<f64>; 2]> = (0..360)
        .map(|i| [rolled(drives, i), rolled(answers, i)])
        .collect();
    let mut plan = CrossPlan::new(&WelchConfig::hann(2048), rate(5000.0)?)?;
    let mut others = vec![plan.clone(); threads - 1];
    let each = pairs.len().div_ceil(threads);
    let part = move |plan: &mut CrossPlan, pairs: &[[Vec<f64>; 2]]| -> Result<Vec<f64>> {
        let mut out = Vec::with_capacity(pairs.len() * 3 * 1025);
        for [drive, answer] in pairs {
            transfer(plan, drive, answer, &mut out)?;
        }
        Ok(out)
    };
    Ok(Prepared {
        input_bytes: 2 * 360 * N * 8,
        work: Box::new(move || {
            let (own, rest) = pairs.split_at(each);
            std::thread::scope(|scope| {
                let running: Vec<_> = rest
                    .chunks(each)
                    .zip(&mut others)
                    .map(|(pairs, plan)| scope.spawn(move || part(plan, pairs)))
                    .collect();
                let mut out = part(&mut plan, own)?;
                for thread in running {
                    // What it panicked with is no error value; it has printed it.
                    let done = thread.join().ok().context("a thread panicked")?;
                    out.extend(done?);
                }
                Ok(out)
            })
        }),
    })
}

/// The texture and the transfer function of W3.
fn texture_and_function(
    folder: &Path,
) -> Result<(Vec<f64>, TransferFunction<Drive, Acceleration>)> {
    let mut data = load(folder, "W3")?;
    let h = data.split_off(50_000);
    let (re, im) = h.split_at(1025);
    let lines = re.iter().zip(im);
    let response = lines.map(|(re, im)| Complex::new(*re, *im)).collect();
    let function = TransferFunction::from_lines(
        response,
        vec![1.0; 1025],
        5000.0 / 2048.0,
        rate(5000.0)?,
        Estimator::H1,
        100,
    )?;
    Ok((data, function))
}

/// What `piezotact prepare` computes for three textures of a minute each, the first minutes of W5: strokes, the typical one of
/// each, one level, the drives, and the comparison with a response that is the stroke at that level.
fn w6(folder: &Path) -> Result<Prepared> {
    const MINUTE: usize = 60 * 5000;
    let data = load(folder, "W5")?;
    let quarter = data.len() / 4;
    let units = ["nail", "fx", "fy", "fz"];
    let recording = |texture: usize| -> Result<Recorded> {
        let part = |channel: usize| {
            let from = channel * quarter + texture * MINUTE;
            data[from..from + MINUTE].to_vec()
        };
        let channels = units.iter().enumerate().map(|(i, name)| Channel {
            name: (*name).into(),
            unit: if i == 0 {
                Unit::MetrePerSecondSquared
            } else {
                Unit::Newton
            },
            samples: part(i),
        });
        let recording = Recording::new(
            channels.collect(),
            rate(5000.0)?,
            Condition::default(),
            Provenance::default(),
        )?;
        Ok(Recorded {
            file: format!("{texture}"),
            name: format!("{texture}"),
            recording,
            naming: Naming::default(),
            cuts: None,
            cuts_are_looked_for_in: String::new(),
        })
    };
    let recordings = (0..3).map(recording).collect::<Result<Vec<_>>>()?;
    let (_, function) = texture_and_function(folder)?;
    let band = Band::new(Hertz(20.0), Hertz(1000.0))?;
    let config = RenderConfig::over(band, rate(48_000.0)?);
    let input_bytes = data.len() * 8;
    Ok(Prepared {
        input_bytes,
        work: Box::new(move || {
            let stated = Stated {
                condition: Condition {
                    load_n: Some(Newtons(0.5)),
                    ..Condition::default()
                },
                judging: Judging::ContactOnly,
                ..Stated::nothing()
            };
            let mut targets = Vec::new();
            for recorded in &recordings {
                let take = cut(recorded.clone(), &stated)?;
                let whole = take.recording.series::<Acceleration>(Some("nail"))?;
                let strokes = textures_of_strokes(&whole, (&take.recording, &take.segmentation))?;
                let mut strokes: Vec<_> = strokes.into_iter().map(|cut| cut.series).collect();
                let typical = typical_stroke(&strokes, band)?;
                targets.push(strokes.swap_remove(typical.index));
            }
            let level = common_level(&targets, &function, &config, Decibels(0.0));
            let mut results = vec![level.level_db];
            for target in &targets {
                let softer = target.clone().amplified(Decibels(level.level_db));
                let drive = render(&softer, &function, &config)?;
                results.push(drive.headroom.peak);
                let compared = VerifyConfig {
                    level: Decibels(level.level_db),
                    ..VerifyConfig::over(band, 5000.0)
                };
                let found = verify(target, Measured::alone(&softer), &compared)?;
                results.push(with_perceptible_difference(found).error_db_rms);
            }
            Ok(results)
        }),
    })
}

fn w3(folder: &Path) -> Result<Prepared> {
    let (target, function) = texture_and_function(folder)?;
    let band = Band::new(Hertz(20.0), Hertz(1000.0))?;
    let config = InverseConfig {
        band,
        edge_ratio: 0.1,
        regularisation: 1e-3,
        inverse: Inverse::Constant,
        phase: PhaseForm::Linear,
    };
    let resampler = Resampler::new(rate(5000.0)?, rate(48_000.0)?, Hertz(1100.0))?;
    let mut plan = InversePlan::new(target.len());
    let path = folder.join("W3-piezotact.wav");
    Ok(Prepared {
        input_bytes: target.len() * 8,
        work: Box::new(move || {
            let mut drive =
                resampler.process(&plan.invert(&target, rate(5000.0)?, &function, &config)?);
            let level = 0.9 / peak(&drive);
            for sample in &mut drive {
                *sample *= level;
            }
            write_wav(&path, &[&drive], 48_000, SampleFormat::Pcm24)
                .map_err(|error| anyhow!(error))?;
            Ok(drive)
        }),
    })
}

/// Contacts by hysteresis without landing or take-off, above a zero that may drift, and the features of every
/// stroke; with or without judging how the finger slides, which the peer does not.
fn w5(folder: &Path, judging: Judging) -> Result<Prepared> {
    let data = load(folder, "W5")?;
    let input_bytes = data.len() * 8;
    let rate = rate(5000.0)?;
    let band = |low, high| Band::new(Hertz(low), Hertz(high));
    let bands = [
        band(5.0, 30.0)?,
        band(30.0, 100.0)?,
        band(100.0, 300.0)?,
        band(300.0, 600.0)?,
        band(600.0, 1000.0)?,
    ];
    let rule = ForceRule {
        on_n: Newtons(0.2),
        off_n: Newtons(0.1),
        smoothing_s: Seconds(0.0502),
        landing_s: Seconds(0.0),
        take_off_s: Seconds(0.0),
        longest_gap_s: Seconds(0.0),
        shortest_s: Seconds(0.5),
        load_n: Some(Newtons(0.5)),
        tolerance_share: 1.0,
        judging,
    };
    let config = FeatureConfig {
        high_pass: None,
        welch: WelchConfig::thesis_2024(),
        band: band(20.0, 1000.0)?,
    };
    let mut plan = FeaturePlan::new(&config, rate, Unit::MetrePerSecondSquared)?;
    let resolution_hz = 5000.0 / 1024.0;
    Ok(Prepared {
        input_bytes,
        work: Box::new(move || {
            let quarter = data.len() / 4;
            let channel = |i: usize| &data[i * quarter..(i + 1) * quarter];
            let signals = Signals {
                rate,
                vibration: Some(channel(0)),
                normal_force_n: Some(channel(3)),
                tangential_force_n: vec![channel(1), channel(2)],
                motion: None,
                contact_sign: None,
            };
            let segmentation = segment_by_force(&signals, &rule)?;
            let mut columns = vec![Vec::new(); 11];
            for stroke in &segmentation.strokes {
                let (f, psd) = plan.of(&[channel(0)], &signals, &segmentation, stroke)?;
                let friction = f.friction_coefficient.context("friction")?.median;
                let strongest = (f.strongest_hz / resolution_hz).round() as usize;
                let shape = [psd[strongest], f.centroid_hz];
                let level = [friction, f.rms, f.peak, f.crest_factor];
                let powers = bands.map(|band| band_power(&psd, resolution_hz, band));
                let all = level.into_iter().chain(shape).chain(powers);
                for (column, value) in columns.iter_mut().zip(all) {
                    column.push(value);
                }
            }
            Ok(columns.concat())
        }),
    })
}
