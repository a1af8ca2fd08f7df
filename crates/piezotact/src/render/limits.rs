//! The demands of a drive on the device, checked before it is played.

use super::{Overload, RenderError, floored};
use crate::fourier::RealTransform;
use crate::render::RenderWarning;
use serde::{Deserialize, Serialize};

use crate::device::{DriveSetup, GainName};
use crate::number::digits;
use crate::quantity::{Band, Decibels, Drive, Quantity, SampleRate, Unit};
use crate::series::Series;
use crate::statistics::{peak, rms};
use crate::warning::Warning;

/// The name of the limit where no device is described.
pub(super) const FULL_SCALE: &str = "the digital full scale";

/// Half a step of a 24-bit converter, full scale = 1: smaller values are not played.
const SMALLEST: f64 = 1.0 / (1_u32 << 24) as f64;

/// The demands of a drive re the limits of the device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Headroom {
    /// The largest sample of the drive as computed, full scale = 1.
    pub peak: f64,
    /// Its root mean square, the silence before and after the texture included.
    pub rms: f64,
    /// The drive at which the first limit is reached, full scale = 1.
    pub limit: f64,
    /// The name of the limit that is the tightest for this drive: of amplitude, of slope, of current, or of excursion.
    pub limited_by: String,
    /// How far the drive is below the tightest limit, dB; negative when it does not fit. Absent for a drive below half a 24-bit step, which
    /// no converter plays: the headroom of silence is undefined.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub headroom_db: Option<f64>,
    /// The share of samples beyond the limit, 0–1.
    pub clipped_fraction: f64,
    /// The steepest slope at the actuator, V/s; absent when the device is not described.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope_v_per_s: Option<f64>,
}

impl Headroom {
    /// How far the drive stays below what limits it, in words.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn text(&self) -> String {
        let Some(headroom_db) = self.headroom_db else {
            return "the drive is silent: it is below the resolution of any converter".into();
        };
        let side = if headroom_db >= 0.0 { "below" } else { "above" };
        let reach = headroom_db.abs();
        if headroom_db < self.amplitude_db() - 1e-9 {
            return format!(
                "peak {} of full scale, {reach:.1} dB {side} the limit of {}",
                digits(self.peak),
                self.limited_by
            );
        }
        format!(
            "peak {} of full scale, {reach:.1} dB {side} the limit of {} ({:.3})",
            digits(self.peak),
            self.limited_by,
            self.limit
        )
    }

    /// With the share `taken` of the excursion of the actuator, where that is the tightest limit.
    pub(super) fn with_excursion(mut self, taken: f64) -> Self {
        let left_db = Decibels::from_amplitude_ratio(1.0 / taken).0;
        if taken > 0.0 && self.headroom_db.is_some_and(|db| left_db < db) {
            self.headroom_db = Some(left_db);
            self.limited_by = "the excursion of the actuator".into();
        }
        self
    }

    /// How far the peak alone is below its limit, dB.
    fn amplitude_db(&self) -> f64 {
        Decibels::from_amplitude_ratio(self.limit / self.peak.max(f64::MIN_POSITIVE)).0
    }

    /// The slope at the actuator and what the amplifier of `setup` follows, V/s, where the slope is beyond it.
    #[must_use]
    pub fn too_steep(&self, setup: Option<&DriveSetup>) -> Option<(f64, f64)> {
        let (asked, limit) = (self.slope_v_per_s?, setup?.slew_limit_v_per_s()?);
        (asked > limit).then_some((asked, limit))
    }

    /// The warning about a slope that the amplifier of `setup` cannot follow, if there is one.
    #[must_use]
    pub fn slew_warning(&self, setup: Option<&DriveSetup>) -> Option<Warning> {
        let (asked_v_per_s, limit_v_per_s) = self.too_steep(setup)?;
        let slow = RenderWarning::SlewLimited {
            asked_v_per_s,
            limit_v_per_s,
        };
        Some(slow.into())
    }
}

/// The drive attenuated (full scale = 1) to 1 dB below the first limit of the device, or below the digital full scale if the
/// device is not described; unchanged when it already fits.
///
/// Source: [`DriveSetup::drive_limit`].
#[must_use]
pub fn fitting(drive: &Series<Drive>, setup: Option<&DriveSetup>) -> Series<Drive> {
    let limit = setup.map_or(1.0, DriveSetup::drive_limit);
    let room = Decibels::from_amplitude_ratio(limit / drive.peak().max(f64::MIN_POSITIVE));
    drive.clone().amplified(Decibels((room.0 - 1.0).min(0.0)))
}

/// The limits of a device for drives at one rate: amplitude and slope, full scale = 1.
pub(super) struct DriveLimits {
    limit: f64,
    /// Per second; absent where nothing limits it.
    slope: Option<f64>,
    /// Over the loudest second; absent where nothing limits it.
    rms: Option<f64>,
    rate_hz: f64,
}

impl DriveLimits {
    pub(super) fn of(setup: Option<&DriveSetup>, rate: SampleRate) -> Self {
        Self {
            limit: setup.map_or(1.0, DriveSetup::drive_limit),
            slope: setup.and_then(DriveSetup::slew_limit_per_s),
            rms: setup.and_then(DriveSetup::rms_limit),
            rate_hz: rate.hz(),
        }
    }

    /// The peak, the steepest slope and the rms of `drive` re their limits; more than 1 does not fit.
    pub(super) fn taken(&self, drive: &[f64]) -> [f64; 3] {
        let slope = self.slope.map_or(0.0, |slope| {
            steepest(drive) * self.rate_hz / slope.max(f64::MIN_POSITIVE)
        });
        let second = (self.rate_hz as usize).max(1);
        let rms = self
            .rms
            .map_or(0.0, |limit| loudest_rms(drive, second) / limit);
        [peak(drive) / self.limit, slope, rms]
    }

    pub(super) fn holds(&self, drive: &[f64]) -> bool {
        self.taken(drive).iter().all(|taken| *taken <= 1.0)
    }

    /// Why `drive` is refused for the device of `setup`; `None` where it is not.
    pub(super) fn refused(
        &self,
        drive: &[f64],
        setup: Option<&DriveSetup>,
        overload: Overload,
    ) -> Option<RenderError> {
        let taken = self.taken(drive);
        let [loud, steep, warm] = taken;
        let fits_at = self.fits_at(drive);
        let is_refused = overload == Overload::Refuse;
        let tightest = |own: f64| own > 1.0 && taken.iter().all(|other| *other <= own);
        if is_refused && tightest(loud) {
            return Some(RenderError::ExceedsFullScale {
                peak: peak(drive),
                limit: self.limit,
                limited_by: setup.map_or(FULL_SCALE, DriveSetup::limited_by).into(),
                fits_at,
            });
        }
        let limit_v_per_s = setup.and_then(DriveSetup::slew_limit_v_per_s);
        if let Some(limit_v_per_s) = limit_v_per_s.filter(|_| is_refused && tightest(steep)) {
            return Some(RenderError::ExceedsSlew {
                asked_v_per_s: steep * limit_v_per_s,
                limit_v_per_s,
                fits_at,
            });
        }
        let limit_a = setup.and_then(|setup| setup.device().actuator().limit_current_rms_a);
        limit_a
            .filter(|_| warm > 1.0)
            .map(|limit_a| RenderError::ExceedsCurrent {
                asked_a: warm * limit_a,
                limit_a,
                fits_at,
            })
    }

    /// The share of samples of `drive` beyond the limit of amplitude, or reached by a slope beyond that of slope, 0–1.
    pub(super) fn beyond(&self, drive: &[f64]) -> f64 {
        let step = self
            .slope
            .map_or(f64::INFINITY, |slope| slope / self.rate_hz);
        let before = std::iter::once(&0.0).chain(drive);
        let is_beyond =
            |(x, before): &(&f64, &f64)| x.abs() > self.limit || (*x - *before).abs() > step;
        drive.iter().zip(before).filter(is_beyond).count() as f64 / drive.len().max(1) as f64
    }

    pub(super) fn is_steeper_than_loud(&self, drive: &[f64]) -> bool {
        let [loud, steep, warm] = self.taken(drive);
        steep > loud.max(warm)
    }

    /// The level, re `drive`, at which it fits, to the tenth of a decibel.
    pub(super) fn fits_at(&self, drive: &[f64]) -> Decibels {
        let most = self.taken(drive).into_iter().fold(0.0, f64::max);
        floored(Decibels::from_amplitude_ratio(1.0 / most))
    }
}

/// Refuses a vibration `target` (at a rate, within a band, as long as a transform) that moves the actuator of `setup` beyond its
/// excursion, where that is stated and the vibration is an acceleration; otherwise the share of the excursion that it takes.
///
/// Formula: x = a/(2πf)², line by line.
pub(super) fn excursion_within_limit<O: Quantity>(
    target: &[f64],
    (rate, band): (SampleRate, Band),
    setup: Option<&DriveSetup>,
) -> Result<f64, RenderError> {
    let limit_m = setup.and_then(|setup| setup.device().actuator().limit_excursion_m);
    let Some(limit_m) = limit_m.filter(|_| O::UNIT == Unit::MetrePerSecondSquared) else {
        return Ok(0.0);
    };
    let mut transform = RealTransform::new(target.len());
    let mut lines = transform.forward(target);
    for (k, line) in lines.iter_mut().enumerate() {
        let hz = k as f64 * rate.hz() / target.len() as f64;
        *line *= match band.contains(hz) {
            true => (std::f64::consts::TAU * hz).powi(-2),
            false => 0.0,
        };
    }
    let asked_m = peak(&transform.inverse(lines));
    match asked_m > limit_m {
        true => Err(RenderError::ExceedsExcursion {
            asked_m,
            limit_m,
            fits_at: floored(Decibels::from_amplitude_ratio(limit_m / asked_m)),
        }),
        false => Ok(asked_m / limit_m),
    }
}

/// The rms of the loudest `window` samples.
fn loudest_rms(drive: &[f64], window: usize) -> f64 {
    let window = window.min(drive.len()).max(1);
    let (mut sum, mut most) = (0.0, 0.0f64);
    for (i, sample) in drive.iter().enumerate() {
        sum += sample * sample;
        if i >= window {
            sum -= drive[i - window].powi(2);
        }
        most = most.max(sum);
    }
    (most / window as f64).sqrt()
}

/// The largest change from one sample to the next.
fn steepest(drive: &[f64]) -> f64 {
    let changes = drive.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    changes.fold(0.0, f64::max)
}

/// Clips `drive` at `limit`, both full scale = 1: at the largest 32-bit float that does not exceed it, the resolution of a
/// file.
pub(crate) fn cut(drive: &mut [f64], limit: f64) {
    let nearest = limit as f32;
    let held = match f64::from(nearest) > limit {
        true => nearest.next_down(),
        false => nearest,
    };
    let held = f64::from(held);
    for sample in drive {
        *sample = sample.clamp(-held, held);
    }
}

/// The demands of `drive` (full scale = 1) at `rate` re the limits of a device; without a description of the
/// device only the digital full scale counts.
///
/// Formula: headroom = the smallest of 20·log10(limit/peak) and the same of the slope and of the rms over the loudest second; slope = max|Δ|·rate·gain·volts per full scale.
///
/// Source: the description of the device for the limits, see [`DriveSetup`].
#[must_use]
pub fn headroom(drive: &[f64], rate: SampleRate, setup: Option<&DriveSetup>) -> Headroom {
    let limit = setup.map_or(1.0, DriveSetup::drive_limit);
    let peak = peak(drive);
    let beyond = drive.iter().filter(|sample| sample.abs() > limit).count();
    let taken = DriveLimits::of(setup, rate).taken(drive);
    let tighter = taken.into_iter().fold(0.0, f64::max);
    Headroom {
        peak,
        rms: rms(drive),
        limit,
        limited_by: match taken {
            [loud, steep, warm] if steep > loud.max(warm) => "the slope that the amplifier follows",
            [loud, _, warm] if warm > loud => "the rms current of the actuator",
            _ => setup.map_or(FULL_SCALE, DriveSetup::limited_by),
        }
        .into(),
        headroom_db: (peak >= SMALLEST).then(|| Decibels::from_amplitude_ratio(1.0 / tighter).0),
        clipped_fraction: beyond as f64 / drive.len().max(1) as f64,
        slope_v_per_s: setup.map(|setup| {
            let input = setup.volts_per_full_scale * setup.device().input().divider;
            steepest(drive) * rate.hz() * setup.gain.voltage_ratio() * input
        }),
    }
}

/// Whether a drive fits at one gain of the amplifier, and with which headroom.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct GainFit {
    /// The gain.
    pub gain: GainName,
    /// How far the drive's peak would stay below the first limit, dB; negative when it does not fit, absent for silence.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub headroom_db: Option<f64>,
    /// How far its steepest slope would stay below what the amplifier can charge the actuator with, dB; absent where it has none.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub slew_headroom_db: Option<f64>,
}

impl GainFit {
    /// Whether the drive fits at this gain.
    #[must_use]
    pub fn fits(&self) -> bool {
        let within = |headroom_db: Option<f64>| headroom_db.is_none_or(|db| db >= 0.0);
        within(self.headroom_db) && within(self.slew_headroom_db)
    }
}

/// For each gain of the amplifier, from the lowest, whether the voltage of a drive with `headroom` at the actuator of `setup`
/// fits (headroom in dB): the lowest that fits has the least noise. The transfer function has to be measured at the chosen gain.
///
/// Formula: the drive at another gain is the drive times the ratio of the gains; limits are those of [`DriveSetup`].
///
/// Source: the description of the device, see [`DriveSetup::device`].
#[must_use]
pub fn gains_for(headroom: &Headroom, setup: &DriveSetup) -> Vec<GainFit> {
    let below = |limit: f64, found: f64| Decibels::from_amplitude_ratio(limit / found).0;
    let silent = headroom.peak < SMALLEST;
    let mut gains: Vec<_> = setup.device().gains().iter().collect();
    gains.sort_by(|a, b| a.voltage_ratio().total_cmp(&b.voltage_ratio()));
    gains
        .into_iter()
        .filter_map(|gain| {
            let other = setup.with_gain(&gain.name).ok()?;
            let peak = headroom.peak * setup.gain.voltage_ratio() / gain.voltage_ratio();
            let slope = headroom.slope_v_per_s.unwrap_or(0.0);
            Some(GainFit {
                gain: gain.name.clone(),
                headroom_db: (!silent).then(|| below(other.drive_limit(), peak)),
                slew_headroom_db: (other.slew_limit_v_per_s())
                    .filter(|_| !silent && slope > 0.0)
                    .map(|limit| below(limit, slope)),
            })
        })
        .collect()
}

/// The share of a line that remains, 0–1, when lines are attenuated so that the rms attenuation in dB is the
/// least for the drive power saved; for a line whose drive power is `cost_ratio` times the price of a decibel.
///
/// Formula: minimising Σ x² + 2λ·Σ c·exp(−x), x the logarithm of the power taken from a line that costs c, gives
/// x·exp(x) = λ·c, so x = W(λ·c) with Lambert's W, and the share is exp(−x/2). `cost_ratio` is λ·c.
///
/// Source: R. M. Corless, G. H. Gonnet, D. E. G. Hare, D. J. Jeffrey and D. E. Knuth (1996), On the Lambert W function,
/// Advances in Computational Mathematics 5, for W.
#[must_use]
pub fn share_of_least_error(cost_ratio: f64) -> f64 {
    if cost_ratio <= 0.0 || cost_ratio.is_nan() {
        return 1.0;
    }
    // Newton's method from above, where x·exp(x) is convex.
    let mut x = cost_ratio.min(1e100).ln_1p();
    for _ in 0..64 {
        let step = (x - cost_ratio.min(1e100) * (-x).exp()) / (1.0 + x);
        x -= step;
        if step.abs() <= 1e-13 * x.max(1e-300) {
            break;
        }
    }
    (-0.5 * x).exp()
}
