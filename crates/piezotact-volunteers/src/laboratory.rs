//! A laboratory on the twin: who sits at the device, and what is measured there first.

use crate::VolunteerError;
use piezotact::device::DeviceDescription;
use piezotact::quantity::{Acceleration, Band, Degrees, Drive, Hertz, Newtons, Seconds};
use piezotact::run::Discard;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact_bench::procedure::{CharacteriseConfig, characterise};
use piezotact_bench::{Bench, Excitation, ExcitationConfig, Placement, RunPlan, Until};
use piezotact_twin::{Participant, TwinBench, TwinParameters};

/// A laboratory on the twin: everything in it follows from the parameters and the seed.
#[derive(Clone, Debug)]
pub struct Laboratory {
    pub parameters: TwinParameters,
    /// Draws people, surfaces, movements and noise.
    pub seed: u64,
}

impl Laboratory {
    /// The PIEZOTACT bench with one participant at it.
    #[must_use]
    pub fn device(&self, participant: u64) -> Bench {
        let participant = Participant::of(participant, self.seed, &self.parameters);
        TwinBench::new(
            &self.parameters,
            participant,
            &DeviceDescription::drv2667().at_usual_gain(),
        )
        .into_bench()
    }
}

/// A run on the device.
#[must_use]
pub fn resting(label: &str, load_n: f64, angle_deg: f64) -> RunPlan {
    RunPlan {
        label: label.into(),
        load: Some(Newtons(load_n)),
        angle: Degrees(angle_deg),
        placement: Placement::New,
        until: Until::PlaybackEnded,
    }
}

/// The transfer function of the device with the finger on it, from `seconds` of random drive to 1.2 kHz.
///
/// # Errors
/// [`VolunteerError`] where the bench refuses.
pub fn characterised(
    bench: &mut Bench,
    run: RunPlan,
    seconds: f64,
    seed: u64,
) -> Result<TransferFunction<Drive, Acceleration>, VolunteerError> {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: Band::new(Hertz(2.0), Hertz(1200.0))?,
            duration: Seconds(seconds),
            peak: 0.8,
            seed,
        },
        welch: WelchConfig::hann(2_048),
        estimator: Estimator::H1,
        run,
    };
    Ok(characterise(bench, &config, &mut Discard)?.function)
}
