//! A bench simulated by a measured transfer function: the drive is filtered with it, and sensor noise is added. It serves to
//! rehearse a rendering for people who were measured before, or with published responses. Nobody is touched, and every
//! recording states that.

mod world;

use piezotact::device::DriveSetup;
use piezotact::panel::PlacementSpread;
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, Newtons, QuantityError, SampleRate};
use piezotact::recording::{BenchKind, Condition};
use piezotact::resample::Resampler;
use piezotact::statistics::rms;
use piezotact::transfer::TransferFunction;

use crate::error::DeviceError;
use crate::halves::halves;
use crate::plan::RunPlan;
use crate::random::Random;
use crate::traits::Bench;

/// The rate of the output, Hz: that of a sound card, as the twin's.
const OUTPUT_RATE_HZ: f64 = 48_000.0;
/// The range of supported acquisition rates, Hz.
const RATES_HZ: [f64; 2] = [200.0, 192_000.0];
/// The share of the narrower band that resampling leaves unchanged.
const PASSBAND_SHARE: f64 = 0.9;
/// The relative tolerance for equal loads and angles after reading them from a file.
const SAME_SHARE: f64 = 1e-6;

/// The simulated noise of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// White Gaussian noise on the acceleration over all of the acquisition's band, rms, m/s².
    pub rms_m_s2: f64,
    /// The seed of the noise, combined with the label of each run.
    pub seed: u64,
}

impl SensorNoise {
    /// The noise of a small piezoelectric accelerometer between 0 and 2.5 kHz, m/s² rms: 2 mm/s² of white and
    /// 1 mm/s² of slow noise combined, as for the twin.
    pub const USUAL_RMS_M_S2: f64 = 0.0022;
    /// The largest noise that can be set, m/s² rms: above any acceleration of a finger.
    pub const LARGEST_RMS_M_S2: f64 = 1_000.0;
}

/// A device with a finger on it, simulated by a measured transfer function.
#[derive(Clone, Debug)]
pub struct MeasuredBench {
    called: String,
    function: TransferFunction<Drive, Acceleration>,
    noise: SensorNoise,
    rate: SampleRate,
    answers: Band,
    to_acquisition: Resampler,
    /// From the earliest time to the latest.
    impulse: Vec<f64>,
    /// How the simulated placement differs from the measured one, as text; empty if it does not.
    placed: String,
}

impl MeasuredBench {
    /// The bench simulated by `function`, named `called` in texts.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] when its lines end where no acquisition of touch has its half rate, or at a frequency
    /// that has no simple ratio to 48 kHz, when it answers nothing where it was excited, or when the noise is not from 0 to
    /// [`SensorNoise::LARGEST_RMS_M_S2`].
    pub fn new(
        function: TransferFunction<Drive, Acceleration>,
        called: &str,
        noise: SensorNoise,
    ) -> Result<Self, DeviceError> {
        let wrong = |expected: String, found: String, todo: &str| DeviceError::Impossible {
            expected,
            found,
            todo: todo.into(),
        };
        if !(0.0..=SensorNoise::LARGEST_RMS_M_S2).contains(&noise.rms_m_s2) {
            return Err(wrong(
                format!(
                    "a noise from 0 to {} m/s² rms",
                    SensorNoise::LARGEST_RMS_M_S2
                ),
                noise.rms_m_s2.to_string(),
                "leave it out for the usual",
            ));
        }
        let rate_hz = 2.0 * function.highest_hz();
        let [lowest, highest] = RATES_HZ.map(|hz| hz / 2.0);
        if !(RATES_HZ[0]..=RATES_HZ[1]).contains(&rate_hz) {
            return Err(wrong(
                format!("a transfer function whose lines end from {lowest} to {highest} Hz"),
                format!("{} Hz in {called}", function.highest_hz()),
                "export it to half the rate of the recording that it comes from",
            ));
        }
        let rates = |error: &dyn std::fmt::Display| {
            wrong(
                format!(
                    "lines of {called} that end at a frequency of which 48 kHz is a simple multiple"
                ),
                error.to_string(),
                "export it on lines that end at a round frequency, such as 2500 Hz",
            )
        };
        let rate = SampleRate::new(rate_hz).map_err(|error| rates(&error))?;
        let output = output_rate().map_err(|error| rates(&error))?;
        let narrower = rate.nyquist().0.min(output.nyquist().0);
        let to_acquisition = Resampler::new(output, rate, Hertz(PASSBAND_SHARE * narrower))
            .map_err(|error| rates(&error))?;
        let mut impulse = function.impulse_response();
        if rms(&impulse) == 0.0 {
            return Err(wrong(
                "a transfer function that is not zero where it was excited".into(),
                format!("zeros in {called}"),
                "measure it again",
            ));
        }
        // The second half stands for negative times: it comes first.
        let middle = impulse.len() / 2;
        impulse.rotate_left(middle);
        let whole = Band::new(Hertz(0.0), Hertz(function.highest_hz()));
        let answers = whole.map_err(|error| rates(&error))?;
        let answers = function
            .excited
            .and_then(|excited| excited.common(answers))
            .unwrap_or(answers);
        Ok(Self {
            called: called.into(),
            function,
            noise,
            rate,
            answers,
            to_acquisition,
            impulse,
            placed: String::new(),
        })
    }

    /// The bench for another, simulated placement of the finger: `function` times a random factor of level and phase, drawn
    /// from the spread between placements in a panel with the seed of the noise and the placement's `number`.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn at_another_placement(
        function: TransferFunction<Drive, Acceleration>,
        called: &str,
        noise: SensorNoise,
        spread: &PlacementSpread,
        number: u64,
    ) -> Result<Self, DeviceError> {
        let mut random = Random::stream(noise.seed, number, "another placement");
        let normals: Vec<f64> = (0..spread.draws()).map(|_| random.normal()).collect();
        let mut bench = Self::new(function.times(spread.factor(&normals)), called, noise)?;
        if let Some((level_db, phase_rad)) = spread.rms_difference_over(bench.answers) {
            bench.placed = format!(
                "another placement of the finger, number {number} of seed {}, drawn from the differences between {} for {} \
                    combinations of participant and condition ({level_db:.2} dB and {:.1}° rms): ",
                noise.seed,
                spread.of.name(),
                spread.groups,
                phase_rad.to_degrees()
            );
        }
        Ok(bench)
    }

    /// Its two halves.
    #[must_use]
    pub fn into_bench(self) -> Bench {
        halves(self)
    }

    fn name(&self) -> String {
        format!(
            "measured transfer function {} (no finger was involved)",
            self.called
        )
    }

    /// The transfer function with where it comes from.
    fn through(&self) -> String {
        let provenance = &self.function.about.provenance;
        let on = match provenance.bench {
            Some(BenchKind::Twin) => "measured on a digital twin",
            Some(BenchKind::Hardware) => "measured on hardware",
            Some(BenchKind::Scripted) => "from a scripted fake, not a measurement of a finger",
            Some(BenchKind::Measured) => "itself a rehearsal, not a measurement of a finger",
            None => "the file does not state whether a finger was measured",
        };
        match provenance.source.as_str() {
            "" => format!("{}the transfer function {}, {on}", self.placed, self.called),
            source => format!(
                "{}the transfer function {} (from {source}), {on}",
                self.placed, self.called
            ),
        }
    }

    /// The drive (full scale = 1) at which the first limit that is known is reached: that of the converter, or of the
    /// amplifier behind it.
    fn limit(&self) -> f64 {
        let setup = self.function.drive.as_ref();
        setup.map_or(1.0, DriveSetup::drive_limit)
    }

    fn noise(&self, what: &str) -> impl FnMut() -> f64 + Send + 'static {
        let SensorNoise { rms_m_s2, seed } = self.noise;
        let mut random = Random::stream(seed, 0, &format!("measured {what}"));
        move || rms_m_s2 * random.normal()
    }

    /// Refuses a load or angle other than that of the transfer function.
    fn answers_as(&self, run: &RunPlan) -> Result<(), DeviceError> {
        let Condition {
            load_n, angle_deg, ..
        } = self.function.about.condition;
        let pairs = [
            (
                "load",
                "N",
                load_n.map(|n| n.0),
                run.load.map(|Newtons(n)| n),
            ),
            ("angle", "°", angle_deg.map(|a| a.0), Some(run.angle.0)),
        ];
        let same =
            |measured: f64, asked: f64| (asked - measured).abs() <= SAME_SHARE * measured.abs();
        for (what, unit, measured, asked) in pairs {
            if let (Some(measured), Some(asked)) = (measured, asked)
                && !same(measured, asked)
            {
                return Err(DeviceError::Impossible {
                    expected: format!(
                        "the {what} of {measured} {unit} at which {} was measured",
                        self.called
                    ),
                    found: format!("{asked} {unit}"),
                    todo: format!(
                        "leave --{what} out, or use a transfer function measured at {asked} {unit}"
                    ),
                });
            }
        }
        Ok(())
    }
}

fn output_rate() -> Result<SampleRate, QuantityError> {
    SampleRate::new(OUTPUT_RATE_HZ)
}
