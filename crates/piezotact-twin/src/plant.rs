//! The PIEZOTACT device with a finger on it as a stream, sample for sample at the rate of a sound device.
//!
//! It is the device of [`TwinBench`](crate::TwinBench) with the same parameters, person, placement and streams of random numbers. Three
//! things differ. Its answer comes [`TwinPlant::delay_s`] after the drive, and its phase departs from that of the bench where
//! ripples of the response would be acausal (see `causal.rs`). Its band reaches up to half the rate, where the bench acquires
//! up to 2.2 kHz. The response follows the held force by a parabola in the logarithm of the load, where the bench takes
//! frames of 0.2 s.

use piezotact::device::{DeviceAtGain, DriveSetup};
use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, FORCE_CHANNEL};
use piezotact_bench::random::Random;
use piezotact_bench::{DeviceError, Plant, RunPlan};

use super::causal::CausalDevice;
use super::finger::Placement;
use super::output::{OutputStage, OutputStream};
use super::parameters::TwinParameters;
use super::participant::Participant;
use super::partitions::Partitions;
use super::protocol::{ANGLES_DEG, load_possible, within};
use super::sensors::{Accelerometer, ForceCell, SlowHand};

/// The rates at which it runs, Hz.
const RATES_HZ: [f64; 2] = [8_000.0, 200_000.0];
/// The delays that it can have besides that of the actuator, s.
const DELAYS_S: [f64; 2] = [0.0, 0.2];
/// The usual one, s: longer than a twentieth of a segment of 0.5 s, an estimate of the transfer function would be late by too much.
const USUAL_DELAY: Seconds = Seconds(0.02);
/// The length of a part of the impulse response, s.
const PART_S: f64 = 1.4e-3;
/// The loads of the outer two of the three responses, in standard deviations of the held force.
const LOADS_SD: f64 = 3.0;
/// Their logarithms are at least this far from that of the middle one.
const LEAST_SPAN: f64 = 5e-3;

/// The device with a finger on it, as what stands between an output and two inputs: acceleration in m/s² and force in N.
#[derive(Debug)]
pub struct TwinPlant {
    rate: SampleRate,
    setup: DriveSetup,
    /// Beyond that of the actuator.
    delay: Seconds,
    delay_s: f64,
    output: OutputStream,
    noise: Random,
    response: Partitions<3>,
    /// The logarithm of the middle load, N, and how far those of the outer two are from it.
    middle: f64,
    span: f64,
    hand: SlowHand,
    accelerometer: Accelerometer,
    cell: ForceCell,
}

impl TwinPlant {
    /// The finger of `participant` on the device with the settings `set`, with load, angle and placement of `run`, at `rate` (8 to
    /// 200 kHz). Its answer comes 20 ms later than that of the bench.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] for a rate, load or angle that cannot be.
    pub fn new(
        parameters: &TwinParameters,
        participant: &Participant,
        set: &DeviceAtGain,
        run: &RunPlan,
        rate: SampleRate,
    ) -> Result<Self, DeviceError> {
        Self::delayed(parameters, participant, set, run, rate, USUAL_DELAY)
    }

    /// The same with an answer that comes `delay` (0 to 0.2 s) later than that of the bench. The magnitude of the response does not
    /// depend on it; with a longer delay its phase is closer to that of the bench: from 20 Hz on within 12° without delay, 6°
    /// with 20 ms, 2° with 50 ms; from 100 Hz on within 1° with 20 ms.
    ///
    /// # Errors
    /// As [`Self::new`], and for a delay that cannot be.
    pub fn delayed(
        parameters: &TwinParameters,
        participant: &Participant,
        set: &DeviceAtGain,
        run: &RunPlan,
        rate: SampleRate,
        delay: Seconds,
    ) -> Result<Self, DeviceError> {
        within("a rate in Hz", rate.hz(), RATES_HZ)?;
        within("a delay in s", delay.0, DELAYS_S)?;
        load_possible(run)?;
        within("an angle in degrees", run.angle.0, ANGLES_DEG)?;
        let load_n = run.load.map_or(0.0, |load| load.0);
        let stage = OutputStage::new(&parameters.output, set);
        let delay_s = delay.0 + parameters.actuator.latency_s;
        let device = CausalDevice {
            finger: &participant.finger,
            placement: &Placement::of(
                parameters,
                participant.number,
                participant.seed,
                run.placed_for(),
            ),
            angle_deg: run.angle.0,
            delay_s,
            rate,
        };
        let reach_n = LOADS_SD * parameters.hand.force_spread_n;
        let low_n = (load_n - reach_n).max(parameters.hand.least_force_n.min(load_n));
        let (low, high) = (low_n.ln(), (load_n + reach_n).ln());
        let middle = 0.5 * (low + high);
        let span = (0.5 * (high - low)).max(LEAST_SPAN);
        let impulses =
            [middle - span, middle, middle + span].map(|load| device.impulse(load.exp()));
        let part = ((PART_S * rate.hz()) as usize + 1).next_power_of_two() / 2;
        let random = |name: &str| participant.random(&format!("{name} {}", run.label));
        Ok(Self {
            rate,
            delay,
            delay_s,
            output: stage.stream(rate),
            setup: stage.setup().clone(),
            noise: random("output"),
            response: Partitions::new(&impulses, part),
            middle,
            span,
            hand: SlowHand::new(&parameters.hand, load_n, rate.hz(), random("force")),
            accelerometer: Accelerometer::new(
                &parameters.accelerometer,
                rate.hz(),
                random("accelerometer"),
            )
            .calibrated(participant.seed),
            cell: ForceCell::new(&parameters.force_cell, rate.hz(), random("force cell")),
        })
    }

    /// The output stage and the amplifier, as a calibration finds them.
    #[must_use]
    pub fn setup(&self) -> &DriveSetup {
        &self.setup
    }

    /// The delay from the drive to the acceleration, s, that of the actuator included.
    #[must_use]
    pub fn delay_s(&self) -> f64 {
        self.delay_s
    }

    /// Acceleration, m/s², and force, N, at the next sample of the drive. What is no number is played as 0.
    fn next(&mut self, sample: f64) -> [f64; 2] {
        let sample = if sample.is_nan() { 0.0 } else { sample };
        let volts = self.output.next(sample, &mut self.noise);
        let [low, middle, high] = self.response.next(volts);
        let force_n = self.hand.next();
        // Beyond the outer loads the response stays as it is there.
        let u = ((force_n.ln() - self.middle) / self.span).clamp(-1.0, 1.0);
        let [of_low, of_middle, of_high] = weights(u);
        let acceleration = of_low * low + of_middle * middle + of_high * high;
        [
            self.accelerometer.read(acceleration),
            self.cell.read(force_n),
        ]
    }
}

/// The weights of values at −1, 0 and 1 in the parabola through them at `u`.
fn weights(u: f64) -> [f64; 3] {
    [
        0.5 * u * (u - 1.0),
        (1.0 - u) * (1.0 + u),
        0.5 * u * (u + 1.0),
    ]
}

impl Plant for TwinPlant {
    fn rate(&self) -> SampleRate {
        self.rate
    }

    fn channels(&self) -> Vec<(String, Unit)> {
        vec![
            (ACCELERATION_CHANNEL.into(), Unit::MetrePerSecondSquared),
            (FORCE_CHANNEL.into(), Unit::Newton),
        ]
    }

    fn delay(&self) -> Seconds {
        self.delay
    }

    fn process(&mut self, drive: &[f64], channels: &mut [Vec<f64>]) {
        for sample in drive {
            let read = self.next(*sample);
            for (channel, value) in channels.iter_mut().zip(read) {
                channel.push(value);
            }
        }
    }
}

#[cfg(test)]
mod tests;
