//! `piezotact sound calibrate`: volts at full scale, sensitivities, cables and the level of the loopback of a sound device.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::quantity::{Hertz, Seconds};
use piezotact::sound::{
    CalibrationFault, Exciter, InputCalibration, LoopbackLevel, MadeOn, OutputCalibration,
    SensorMethod, SoundCalibration, SoundWarning, VoltsMethod,
};
use piezotact_audio::{
    Measures, RecordedChannel, RunningStreams, SoundSetup, VOLTMETER_TONE, check_level_hz,
    measured_loopback, play_tone, record_tone, wires,
};

use super::keep;
use crate::benches::audio::{SoundDevice, calibration_path};
use crate::deliver::{Outputs, deliver_and};
use crate::failure::{Outcome, usage};
use crate::invocation::{day, today};
use crate::output::say;
use crate::places::outputs;
use piezotact::number::digits_that_count;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The set-up of the sound device.
    setup: PathBuf,
    /// Only plays a tone for so many seconds, to read a voltmeter at the output; nothing is written.
    #[arg(long, value_name = "SECONDS", group = "volts")]
    tone: Option<f64>,
    /// What the voltmeter read at the output during --tone, V rms.
    #[arg(long, value_name = "V_RMS", group = "volts")]
    voltmeter: Option<f64>,
    /// The potential of the inputs at full scale, V peak: the loopback then gives that of the output, and stated sensitivities hold.
    #[arg(long, value_name = "V_PEAK")]
    input_volts: Option<f64>,
    /// The input whose sensor is mounted on a vibration calibrator now.
    #[arg(long, value_name = "CHANNEL")]
    exciter: Option<u32>,
    /// The frequency of the calibrator, Hz.
    #[arg(long, value_name = "HZ", default_value_t = 159.2, requires = "exciter")]
    exciter_frequency: f64,
    /// The level of the calibrator, rms, in the unit of the sensor.
    #[arg(long, value_name = "RMS", default_value_t = 10.0, requires = "exciter")]
    exciter_rms: f64,
    /// Sends a pulse through each output and says on which input it arrives.
    #[arg(long)]
    wires: bool,
    /// Writes the calibration here; default: beside the set-up, where the bench finds it.
    #[arg(long, value_name = "OUT.json")]
    out: Option<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let device = SoundDevice::read(&args.setup)?;
    if let Some(seconds) = args.tone {
        return tone(&device, seconds);
    }
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| calibration_path(&args.setup));
    let written: Vec<&Path> = std::iter::once(out.as_path())
        .chain(args.outputs.files())
        .collect();
    outputs(&[&args.setup], &written)?;
    let mut found = begun(&device)?;
    if args.wires {
        find_wires(&device, &mut found)?;
    }
    let mut streams = device.setup.open_streams(device.io(None)?.as_mut())?;
    if device.setup.loopback().is_some() {
        found.loopback = Some(LoopbackLevel {
            frequency_hz: check_level_hz(),
            gain: measured_loopback(&mut streams, &device.setup)?.gain,
        });
    }
    output(args, &mut found)?;
    inputs(args, &device, &mut found)?;
    if let Some(channel) = args.exciter {
        exciter(args, channel, &device, &mut streams, &mut found)?;
    }
    keep((&out, "the earlier calibration"), &found)?;
    deliver_and(&args.outputs, &found, &[&out])
}

/// Plays a tone as long as a voltmeter is read.
fn tone(device: &SoundDevice, seconds: f64) -> Outcome {
    if !(0.5..=600.0).contains(&seconds) {
        return Err(usage(anyhow!(
            "--tone: expected 0.5 to 600 s, found {seconds}"
        )));
    }
    let mut streams = device.setup.open_streams(device.io(None)?.as_mut())?;
    let (hz, rms) = VOLTMETER_TONE;
    say(&format!(
        "{} Hz at {} rms of full scale for {seconds} s: read the potential at the output, V rms, and give it with --voltmeter",
        hz.0,
        digits_that_count(rms, 4)
    ));
    play_tone(&mut streams, Seconds(seconds))?;
    Ok(())
}

/// The calibration of before, where there is one of this device, with the date of today.
fn begun(device: &SoundDevice) -> Outcome<SoundCalibration> {
    let (called, rate_hz) = (device.setup.called(), device.setup.rate()?);
    let before = device.calibration.clone();
    let before = before.filter(|before| before.holds_for(&called, rate_hz).is_ok());
    let (made_on_day, made_on) = (day(), today());
    Ok(match before {
        Some(before) => before.renewed(MadeOn {
            day: made_on_day,
            date: made_on,
        }),
        None => SoundCalibration {
            device: called,
            made_on_day,
            made_on,
            rate_hz,
            output: None,
            loopback: None,
            inputs: Vec::new(),
            wires: Vec::new(),
            warnings: Vec::new(),
        },
    })
}

fn find_wires(device: &SoundDevice, found: &mut SoundCalibration) -> Outcome {
    let mut open = |alone: &SoundSetup| -> Outcome<RunningStreams> {
        Ok(alone.open_streams(device.io_of(alone, None)?.as_mut())?)
    };
    found.wires.clear();
    for wire in wires(&device.setup, &mut open)? {
        match wire {
            Ok(wire) => found.wires.push(wire),
            // An output to the amplifier arrives at the sensors, if it arrives at all.
            Err(error) => {
                let what = error.to_string();
                found.warnings.push(
                    SoundWarning::Calibration {
                        fault: CalibrationFault::WireNotFound { what },
                    }
                    .into(),
                );
            }
        }
    }
    let loopback = device.setup.loopback();
    let arrives = |input: u32| found.wires.iter().any(|wire| wire.input == input);
    match loopback {
        Some(loopback) if !arrives(loopback.channel) => Err(anyhow!(
            "expected the loopback cable on input {}, found {}; plug it there, or write its channel into the set-up",
            loopback.channel,
            match found.wires.first() {
                Some(wire) => format!("the pulse of output {} on input {}", wire.output, wire.input),
                None => "no pulse on any input alone".into(),
            }
        )
        .into()),
        _ => Ok(()),
    }
}

/// Volts at full scale of the output, by voltmeter or loopback.
fn output(args: &Arguments, found: &mut SoundCalibration) -> Outcome {
    let method = match (args.voltmeter, args.input_volts, found.loopback) {
        (Some(read_v_rms), _, _) => VoltsMethod::Voltmeter {
            read_v_rms,
            played_rms: VOLTMETER_TONE.1,
        },
        (None, Some(input_v_per_full_scale), Some(loopback)) => VoltsMethod::Loopback {
            input_v_per_full_scale,
            gain: loopback.gain,
        },
        _ => return Ok(()),
    };
    let output = OutputCalibration::by(method).map_err(usage)?;
    if let (Some(_), Some(volts), Some(loopback)) =
        (args.voltmeter, args.input_volts, found.loopback)
    {
        let other = volts * loopback.gain.abs();
        let ways = (
            ("the voltmeter", output.v_per_full_scale),
            ("the loopback with the stated volts of the input", other),
        );
        let warning =
            SoundCalibration::disagreement("volts at full scale of the output", ways.0, ways.1);
        found.warnings.extend(warning);
    }
    if let (Some(_), None, Some(loopback)) = (args.voltmeter, args.input_volts, found.loopback) {
        // What was stated for the inputs earlier, beside what the voltmeter says of them through the loopback.
        let by_loopback = output.v_per_full_scale / loopback.gain.abs();
        let stated = found.inputs.iter().find_map(|input| match input.method {
            SensorMethod::Stated {
                input_v_per_full_scale,
                ..
            } => Some(input_v_per_full_scale),
            SensorMethod::Exciter { .. } => None,
        });
        let warning = stated.and_then(|stated| {
            SoundCalibration::disagreement(
                "volts at full scale of the inputs",
                ("the volts stated earlier", stated),
                ("the voltmeter through the loopback", by_loopback),
            )
        });
        found.warnings.extend(warning);
    }
    found.output = Some(output);
    Ok(())
}

/// Sensitivities that the set-up states, where the potential of the inputs is known.
fn inputs(args: &Arguments, device: &SoundDevice, found: &mut SoundCalibration) -> Outcome {
    let Some(volts) = args.input_volts else {
        return Ok(());
    };
    for recorded in &device.setup.record {
        let Some(v_per_unit) = recorded.v_per_unit() else {
            continue;
        };
        let stated = InputCalibration::stated(of(recorded), v_per_unit, volts).map_err(usage)?;
        put(found, stated);
    }
    Ok(())
}

fn exciter(
    args: &Arguments,
    channel: u32,
    device: &SoundDevice,
    streams: &mut RunningStreams,
    found: &mut SoundCalibration,
) -> Outcome {
    let recorded = device
        .setup
        .record
        .iter()
        .find(|recorded| recorded.channel == channel);
    let Some(recorded) = recorded.filter(|recorded| recorded.measures != Measures::Drive) else {
        return Err(usage(anyhow!(
            "--exciter: expected an input with a sensor that the set-up names, found channel {channel}"
        )));
    };
    let exciter = Exciter {
        frequency_hz: Hertz(args.exciter_frequency),
        rms: args.exciter_rms,
    };
    let (tone, peak) = record_tone(streams, channel, Seconds(5.0), exciter.frequency_hz)?;
    let input = InputCalibration::by_exciter(of(recorded), exciter, &tone, peak)?;
    // What the data sheet would have given, where it is known.
    let stated = found.inputs.iter().find(|input| input.channel == channel);
    let stated = stated.filter(|input| matches!(input.method, SensorMethod::Stated { .. }));
    if let Some(stated) = stated {
        let what = format!("value at full scale of input {channel}");
        let warning = SoundCalibration::disagreement(
            &what,
            ("the calibrator", input.per_full_scale),
            ("the stated sensitivity", stated.per_full_scale),
        );
        found.warnings.extend(warning);
    }
    put(found, input);
    Ok(())
}

fn of(recorded: &RecordedChannel) -> (u32, &'static str, piezotact::quantity::Unit) {
    (
        recorded.channel,
        recorded.measures.name(),
        recorded.measures.unit(),
    )
}

/// Replaces what was known of an input.
fn put(found: &mut SoundCalibration, new: InputCalibration) {
    found.inputs.retain(|input| input.channel != new.channel);
    found.inputs.push(new);
    found.inputs.sort_by_key(|input| input.channel);
}
