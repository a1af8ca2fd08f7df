//! Mean, spread and middle of many values.

use serde::{Deserialize, Serialize};

/// Mean, standard deviation and median of something over a stroke, in its unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Statistics {
    /// The mean.
    pub mean: f64,
    /// The standard deviation, n − 1 in the denominator.
    pub sd: f64,
    /// The median.
    pub median: f64,
}

impl Statistics {
    /// The statistics of `values`; `None` for none. The order of `values` changes.
    ///
    /// Source: sample mean, √(Σ(x − x̄)²/(n − 1)), middle value (the mean of the middle two for an even count).
    #[must_use]
    pub fn of(values: &mut [f64]) -> Option<Self> {
        let median = crate::statistics::median(values)?;
        let Moments { mean, sd } = Moments::of(values)?;
        Some(Self { mean, sd, median })
    }
}

/// Mean and standard deviation of something over a stroke, in its unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Moments {
    /// The mean.
    pub mean: f64,
    /// The standard deviation, n − 1 in the denominator.
    pub sd: f64,
}

impl Moments {
    /// The moments of `values`; `None` for none.
    ///
    /// Source: sample mean, √(Σ(x − x̄)²/(n − 1)).
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len();
        if n == 0 {
            return None;
        }
        let mean = crate::statistics::mean(values);
        let (squares, _) = squares_and_peak(values, mean);
        Some(Self {
            mean,
            sd: (squares / (n.max(2) - 1) as f64).sqrt(),
        })
    }
}

/// The sum of squared departures from `mean`, and the largest of them, in independent lanes.
pub(super) fn squares_and_peak(samples: &[f64], mean: f64) -> (f64, f64) {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || squares_and_peak_in_lanes(samples, mean),
    )
}

#[inline(always)]
fn squares_and_peak_in_lanes(samples: &[f64], mean: f64) -> (f64, f64) {
    const LANES: usize = 8;
    let (mut sums, mut tops) = ([0.0; LANES], [0.0f64; LANES]);
    let (chunks, rest) = samples.as_chunks::<LANES>();
    for chunk in chunks {
        for ((sum, top), value) in sums.iter_mut().zip(&mut tops).zip(chunk) {
            let off = value - mean;
            *sum += off * off;
            *top = top.max(off.abs());
        }
    }
    let rest = rest.iter().map(|v| v - mean);
    (
        sums.iter().sum::<f64>() + rest.clone().map(|v| v * v).sum::<f64>(),
        tops.into_iter()
            .chain(rest.map(f64::abs))
            .fold(0.0, f64::max),
    )
}
