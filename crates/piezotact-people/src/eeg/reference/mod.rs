//! References, and values between electrodes.

mod positions;
mod spline;

use piezotact::Warning;
use piezotact::statistics::median;

use super::epochs::{Epochs, EpochsError};
use super::source::is_lettered;
use super::{EegWarning, PositionsFault};
use positions::{OF_OTHER_CAPS, POSITIONS};

pub use spline::Interpolation;

/// Fewer positions fit no sphere.
pub const FEWEST_OF_A_SPHERE: usize = 8;
/// An electrode further than this from a position says little about it, degrees.
const FAR_DEG: f64 = 30.0;

/// Positions of channels on a sphere of radius 1: x to the right, y to the front, z up.
#[derive(Clone, Debug, PartialEq)]
pub struct Montage {
    /// The names of the channels.
    pub channels: Vec<String>,
    /// The position of each, of length 1.
    pub positions: Vec<[f64; 3]>,
}

impl Montage {
    /// The names of the 64 positions of a cap that are built in.
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        POSITIONS.iter().map(|(name, _)| *name).collect()
    }

    /// The positions of `channels` by their names in the extended 10-20 system, upper or lower case. The old names T3, T4, T5 and T6 are
    /// those of T7, T8, P7 and P8.
    ///
    /// # Errors
    /// [`EpochsError::NoPosition`] for a name that is not built in; [`Montage::new`] takes positions of any channel.
    pub fn ten_ten(channels: &[String]) -> Result<Self, EpochsError> {
        let known = Self::known(channels).into_iter().zip(channels);
        let positions = known
            .map(|(position, name)| {
                position.ok_or_else(|| EpochsError::NoPosition { name: name.clone() })
            })
            .collect::<Result<_, _>>()?;
        Self::new(channels.to_vec(), positions)
    }

    /// The position of each of `channels` by its name, as [`Self::ten_ten`]; none of any where they are called by letters and numbers
    /// ([`is_lettered`]).
    ///
    /// Source: as [`Self::ten_ten`].
    #[must_use]
    pub fn known(channels: &[String]) -> Vec<Option<[f64; 3]>> {
        if is_lettered(channels) {
            return vec![None; channels.len()];
        }
        let position = |name: &String| {
            let own = match name.to_ascii_uppercase().as_str() {
                "T3" => "T7".to_owned(),
                "T4" => "T8".to_owned(),
                "T5" => "P7".to_owned(),
                "T6" => "P8".to_owned(),
                other => other.to_owned(),
            };
            let mut all = POSITIONS.iter().chain(&OF_OTHER_CAPS);
            let found = all.find(|(known, _)| known.eq_ignore_ascii_case(&own));
            found.map(|(_, position)| *position)
        };
        channels.iter().map(position).collect()
    }

    /// The position of each of `channels`, where it is in this montage.
    ///
    /// Source: none; a lookup.
    #[must_use]
    pub fn of(&self, channels: &[String]) -> Vec<Option<[f64; 3]>> {
        let at = |name| self.channels.iter().position(|own| own == name);
        let of = |name| at(name).map(|own| self.positions[own]);
        channels.iter().map(of).collect()
    }

    /// The median angle between positions of this montage and those of the same names in the 10-10 system, degrees; `None` for fewer than
    /// three such names. Other axes (x to the front) show as 90°.
    ///
    /// Source: house rule.
    #[must_use]
    pub fn off_ten_ten_deg(&self) -> Option<f64> {
        let known = Self::known(&self.channels).into_iter().zip(&self.positions);
        let angles = known.filter_map(|(known, own)| Some(dot(&known?, own).acos().to_degrees()));
        let mut angles: Vec<f64> = angles.collect();
        median(&mut angles).filter(|_| angles.len() > 2)
    }

    /// Channels at measured positions, relative to the centre of a sphere, in any unit: they are set to length 1.
    ///
    /// # Errors
    /// [`EpochsError::Positions`] unless there is one position for each channel, of finite length above 0, no two of them the same.
    pub fn new(channels: Vec<String>, positions: Vec<[f64; 3]>) -> Result<Self, EpochsError> {
        let unit: Vec<[f64; 3]> = positions
            .iter()
            .map(|position| on_sphere(*position))
            .collect();
        let broken = unit.iter().flatten().any(|v| !v.is_finite());
        let same = |i: usize| {
            unit[..i]
                .iter()
                .any(|other| dot(other, &unit[i]) > 1.0 - 1e-9)
        };
        if channels.is_empty()
            || positions.len() != channels.len()
            || broken
            || (0..unit.len()).any(same)
        {
            return Err(EpochsError::Positions {
                channels: channels.len(),
                found: positions.len(),
            });
        }
        Ok(Self {
            channels,
            positions: unit,
        })
    }

    /// Channels at positions measured in coordinates of the head (x to the right, y to the front, z up, in any unit): seen from the centre of
    /// the sphere that fits them best.
    ///
    /// Formula: least squares of |p|² = 2·c·p + k.
    ///
    /// Source: as MNE-Python fits a sphere to digitised points.
    ///
    /// # Errors
    /// [`EpochsError::Sphere`] for fewer than 8 positions or those that lie on no sphere, and [`EpochsError::Positions`] as
    /// [`Self::new`].
    pub fn measured(channels: Vec<String>, positions: &[[f64; 3]]) -> Result<Self, EpochsError> {
        let centre = centre_of(positions).ok_or(EpochsError::Sphere {
            found: positions.len(),
        })?;
        let seen = positions
            .iter()
            .map(|p| [0, 1, 2].map(|i| p[i] - centre[i]));
        Self::new(channels, seen.collect())
    }

    /// The pairs of channels that are neighbours: at most `angle_deg` apart as seen from the centre of the sphere.
    ///
    /// MNE-Python's `find_ch_adjacency` triangulates instead, and also joins far channels at the rim of a cap.
    #[must_use]
    pub fn neighbours(&self, angle_deg: f64) -> Vec<[usize; 2]> {
        let least = angle_deg.to_radians().cos();
        let pairs = (0..self.positions.len()).flat_map(|i| (0..i).map(move |j| [j, i]));
        pairs
            .filter(|[i, j]| dot(&self.positions[*i], &self.positions[*j]) >= least)
            .collect()
    }
}

/// The centre of the sphere through `positions`, by least squares.
fn centre_of(positions: &[[f64; 3]]) -> Option<[f64; 3]> {
    if positions.len() < FEWEST_OF_A_SPHERE {
        return None;
    }
    // In units of their extent, about their mean: no digit is lost in any unit.
    let n = positions.len() as f64;
    let mean = [0, 1, 2].map(|i| positions.iter().map(|p| p[i]).sum::<f64>() / n);
    let from_mean = |p: &[f64; 3]| [0, 1, 2].map(|i| p[i] - mean[i]);
    let size = positions
        .iter()
        .map(|p| from_mean(p).iter().map(|v| v * v).sum::<f64>().sqrt())
        .fold(0.0, f64::max);
    let mut normal = [0.0; 16];
    let mut right = [0.0; 4];
    for position in positions {
        let p = from_mean(position).map(|v| v / size);
        let row = [p[0], p[1], p[2], 1.0];
        let square: f64 = p.iter().map(|v| v * v).sum();
        for i in 0..4 {
            right[i] += row[i] * square;
            for j in 0..4 {
                normal[4 * i + j] += row[i] * row[j];
            }
        }
    }
    let inverted = super::linear::inverse(&normal, 4)?;
    let half = |i: usize| {
        let own: f64 = (0..4).map(|j| inverted[4 * i + j] * right[j]).sum();
        mean[i] + 0.5 * size * own
    };
    let centre = [0, 1, 2].map(half);
    centre.iter().all(|v| v.is_finite()).then_some(centre)
}

fn on_sphere(position: [f64; 3]) -> [f64; 3] {
    let length = position.iter().map(|v| v * v).sum::<f64>().sqrt();
    position.map(|v| v / length)
}

/// The cosine of the angle between two positions of length 1.
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| a * b)
        .sum::<f64>()
        .clamp(-1.0, 1.0)
}

/// `epochs` less the mean of all channels at each sample, V.
///
/// Source: the average reference, D. Lehmann and W. Skrandies (1980), Electroencephalogr. Clin. Neurophysiol. 48.
#[must_use]
pub fn average(epochs: &Epochs) -> Epochs {
    let n = epochs.channels().len();
    let share = 1.0 / n as f64;
    let weights: Vec<f64> = (0..n * n)
        .map(|i| f64::from(u8::from(i / n == i % n)) - share)
        .collect();
    epochs.mixed(epochs.channels().to_vec(), &weights)
}

/// `epochs` less the mean of the channels named `references` at each sample, V: of both mastoids (M1 and M2, or TP9 and TP10), or of one
/// electrode. The references are left in; with several of them they do not become 0.
///
/// Source: as MNE-Python's `set_eeg_reference(ref_channels=…)`.
///
/// # Errors
/// [`EpochsError`] without a reference, or for a name that no channel has.
pub fn to_channels(epochs: &Epochs, references: &[&str]) -> Result<Epochs, EpochsError> {
    if references.is_empty() {
        return Err(EpochsError::NoReference);
    }
    let indices = epochs.indices(references)?;
    let n = epochs.channels().len();
    let share = 1.0 / indices.len() as f64;
    let weights: Vec<f64> = (0..n * n)
        .map(|i| {
            let own = f64::from(u8::from(i / n == i % n));
            own - if indices.contains(&(i % n)) {
                share
            } else {
                0.0
            }
        })
        .collect();
    Ok(epochs.mixed(epochs.channels().to_vec(), &weights))
}

/// Positions on the sphere of a square map of `side` × `side` points seen from above, row after row from the front left, and the index of
/// each point; only points inside the circle of 110° from the top are there.
///
/// Formula: azimuthal equidistant projection, the edge of the circle at 110°.
///
/// Source: J. P. Snyder (1987), *Map Projections*, USGS Professional Paper 1395, chapter 25.
#[must_use]
pub fn map_positions(side: usize) -> Vec<(usize, [f64; 3])> {
    let at = |i: usize| match side {
        0 | 1 => 0.0,
        side => 2.0 * i as f64 / (side - 1) as f64 - 1.0,
    };
    let mut positions = Vec::new();
    for row in 0..side {
        for column in 0..side {
            let (x, y) = (at(column), -at(row));
            let radius = x.hypot(y);
            if radius > 1.0 + 1e-12 {
                continue;
            }
            let angle = radius * 110f64.to_radians();
            let share = if radius > 0.0 {
                angle.sin() / radius
            } else {
                0.0
            };
            positions.push((row * side + column, [x * share, y * share, angle.cos()]));
        }
    }
    positions
}

/// A warning where positions of a map lie far from every electrode.
fn far(montage: &Montage, positions: &[[f64; 3]]) -> Vec<Warning> {
    let nearest = |position: &[f64; 3]| {
        let closest = montage.positions.iter().map(|own| dot(own, position));
        closest.fold(-1.0, f64::max).acos().to_degrees()
    };
    let angles: Vec<f64> = positions
        .iter()
        .map(nearest)
        .filter(|a| *a > FAR_DEG)
        .collect();
    let angle_deg = angles.iter().copied().fold(0.0, f64::max);
    let warning = EegWarning::Positions {
        fault: PositionsFault::Far {
            positions: angles.len(),
            angle_deg,
        },
    };
    (!angles.is_empty())
        .then(|| warning.into())
        .into_iter()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::SampleRate;

    fn epochs(names: &[&str], volts: Vec<f64>) -> Epochs {
        let names = names.iter().map(|s| (*s).to_owned()).collect();
        Epochs::new(
            names,
            vec!["a".into()],
            SampleRate::new(100.0).unwrap(),
            0.0,
            volts,
        )
        .unwrap()
    }

    #[test]
    fn references_take_away_what_they_say() {
        let given = epochs(&["C3", "M1", "M2"], vec![10.0, 20.0, 2.0, 4.0, 4.0, 0.0]);
        let found = to_channels(&given, &["M1", "M2"]).unwrap();
        assert_eq!(found.volts(), [7.0, 18.0, -1.0, 2.0, 1.0, -2.0]);
        assert!(to_channels(&given, &[]).is_err() && to_channels(&given, &["TP9"]).is_err());
        let mean = average(&given);
        for sample in 0..2 {
            let sum: f64 = (0..3).map(|c| mean.signal(c, 0)[sample]).sum();
            assert!(sum.abs() < 1e-12);
        }
    }

    #[test]
    fn positions_are_where_they_should_be() {
        let all: Vec<String> = Montage::names().into_iter().map(str::to_owned).collect();
        let montage = Montage::ten_ten(&all).unwrap();
        let at = |name: &str| montage.positions[all.iter().position(|n| n == name).unwrap()];
        assert!(at("C3")[0] < -0.5 && at("C4")[0] > 0.5);
        assert!(at("Fpz")[1] > 0.9 && at("Oz")[1] < -0.8 && at("Cz")[2] > 0.9);
        // Each has neighbours, and the relation has no channel twice.
        let pairs = montage.neighbours(30.0);
        for (i, name) in all.iter().enumerate() {
            let count = pairs.iter().filter(|pair| pair.contains(&i)).count();
            assert!((2..=9).contains(&count), "{name}: {count}");
        }
        // Those of other caps lie below their neighbours, on the same side.
        for (name, [x, y, z]) in OF_OTHER_CAPS {
            let found = Montage::ten_ten(&[name.to_lowercase()]).unwrap().positions[0];
            // Positions are stored with six digits.
            assert!(dot(&found, &[x, y, z]) > 1.0 - 1e-5);
            let above = at(&name.replace("10", "8").replace('9', "7"));
            assert!(z < above[2] - 0.2 && x * above[0] > 0.0, "{name}");
            assert!((0.5..0.98).contains(&dot(&found, &above)), "{name}");
        }
        assert!(Montage::ten_ten(&["EOG".to_owned()]).is_err());
        assert_eq!(
            Montage::ten_ten(&["t3".to_owned()]).unwrap().positions,
            Montage::ten_ten(&["T7".to_owned()]).unwrap().positions
        );
        assert!(Montage::new(vec!["a".into()], vec![[0.0; 3]]).is_err());
        // Measured in mm around another centre.
        let digitised: Vec<[f64; 3]> = montage
            .positions
            .iter()
            .map(|p| [95.0 * p[0] + 3.0, 95.0 * p[1] - 7.0, 95.0 * p[2] + 40.0])
            .collect();
        let fitted = Montage::measured(all.clone(), &digitised).unwrap();
        for (a, b) in fitted.positions.iter().zip(&montage.positions) {
            assert!(
                a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5),
                "{a:?} {b:?}"
            );
        }
        assert!(matches!(
            Montage::measured(all[..3].to_vec(), &digitised[..3]),
            Err(EpochsError::Sphere { found: 3 })
        ));
        // Axes as EEGLAB has them, x to the front.
        let turned = montage.positions.iter().map(|[x, y, z]| [*y, -x, *z]);
        let turned = Montage::new(all.clone(), turned.collect()).unwrap();
        assert!(turned.off_ten_ten_deg().unwrap() > 40.0);
        assert!(montage.off_ten_ten_deg().unwrap() < 1.0);
        // In any unit.
        let far = Montage::new(vec!["a".into()], vec![[30.0, 0.0, 40.0]]).unwrap();
        assert_eq!(far.positions, [[0.6, 0.0, 0.8]]);
        let map = map_positions(5);
        assert!(map.iter().all(|(_, p)| (dot(p, p) - 1.0).abs() < 1e-12));
        assert!(map.contains(&(12, [0.0, 0.0, 1.0])));
    }
}
