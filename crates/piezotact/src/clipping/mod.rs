//! Clipping: the share of a signal at a limit of a sensor, a converter or a drive.

mod histogram;
mod limit;
mod pass;
mod warning;

use crate::quantity::{Drive, Quantity};
use crate::series::Series;
use crate::warning::Warning;
pub use warning::{ClippedAt, ClippingWarning};

pub(crate) use limit::Rails;
pub use limit::{Limited, limited};
pub(crate) use pass::step;

/// How much of a measurement stood at a limit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clipping {
    /// The largest of the shares found, 0–1.
    pub fraction: f64,
    /// The share of the drive alone, 0–1.
    pub of_the_drive: f64,
    /// One for each place where something clipped.
    pub warnings: Vec<Warning>,
}

/// The clipping during the measurement of `response`, as shares 0–1 at the rate of the acquisition: of the sensor (samples at its
/// limits), of the recorded drive (beyond the limit, full scale = 1), and the share of the rendered drive beyond
/// the limit.
///
/// Source: [`flat_top_fraction`]; the share of a rendered drive is that of its headroom.
#[must_use]
pub fn clipping<Q: Quantity>(
    response: &Series<Q>,
    drive: Option<(&Series<Drive>, f64)>,
    rendered_fraction: Option<f64>,
) -> Clipping {
    let played = drive.map_or(0.0, |(drive, limit)| {
        let beyond = drive
            .samples()
            .iter()
            .filter(|sample| sample.abs() > limit)
            .count();
        beyond as f64 / drive.samples().len() as f64
    });
    let device = rendered_fraction.unwrap_or(0.0).max(played);
    let sensor = flat_top_fraction(response.samples());
    let of_sensor = ClippingWarning::Clipped {
        signal: format!("the measured {}", Q::NAME),
        at: ClippedAt::Recorded { fraction: sensor },
    };
    let of_drive = ClippingWarning::Clipped {
        signal: "the played drive".into(),
        at: ClippedAt::Played { fraction: device },
    };
    let found = [(sensor, of_sensor), (device, of_drive)];
    Clipping {
        fraction: sensor.max(device),
        of_the_drive: device,
        warnings: found
            .into_iter()
            .filter(|(fraction, _)| *fraction > 0.0)
            .map(|(_, warning)| warning.into())
            .collect(),
    }
}

/// The share of samples at a limit, 0–1, in plateaus or as single samples.
///
/// Source: [`limited`].
#[must_use]
pub fn flat_top_fraction(samples: &[f64]) -> f64 {
    limited(samples).share()
}
