//! Which textures cannot be told apart by their vibration.

use serde::{Deserialize, Serialize};

/// What is compared: a name, the rms, and a one-sided PSD with lines `resolution_hz` apart from 0 Hz.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The name.
    pub name: String,
    /// The rms of the vibration.
    pub rms: f64,
    /// Its mean PSD.
    pub psd: Vec<f64>,
    /// The step between its lines, Hz.
    pub resolution_hz: f64,
}

/// How far apart two vibrations must be to be told apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Discrimination {
    /// One just-noticeable difference in level, dB.
    pub level_jnd_db: f64,
    /// One just-noticeable difference in the level of an octave band, dB.
    pub band_jnd_db: f64,
    /// Textures of one group differ by this or less, in JND.
    pub threshold_jnd: f64,
}

impl Discrimination {
    /// 1.5 dB in level (a Weber fraction of 19 %), 2.5 dB in an octave band, and a threshold of one JND.
    ///
    /// Source: A. Israr, H. Z. Tan and C. M. Reed (2006), J. Acoust. Soc. Am. 120(5): 2.2–2.5 dB for isolated
    /// bands; 1.5 dB for broadband textures is this program's choice.
    #[must_use]
    pub fn usual() -> Self {
        Self {
            level_jnd_db: 1.5,
            band_jnd_db: 2.5,
            threshold_jnd: 1.0,
        }
    }

    /// The distance of two textures in JND.
    ///
    /// Formula: √((ΔL/level JND)² + mean over octave bands of (ΔB/band JND)²), where L is the rms level and B the
    /// level of a band relative to the whole; bands from 16 to 500 Hz in which either texture holds 1 % of
    /// its power or more.
    ///
    /// Source: the cue combination of independent differences (Pythagorean sum), N. A. Macmillan and C. D. Creelman,
    /// *Detection Theory*, 2nd ed., chapter 6.
    #[must_use]
    pub fn distance_jnd(&self, a: &Texture, b: &Texture) -> f64 {
        let level = 20.0 * (a.rms / b.rms).log10() / self.level_jnd_db;
        let (a, b) = (shares(a), shares(b));
        let bands: Vec<f64> = a
            .iter()
            .zip(&b)
            .filter(|(a, b)| a.max(**b) >= 0.01)
            .map(|(a, b)| {
                let ratio = a.max(1e-6) / b.max(1e-6);
                (10.0 * ratio.log10() / self.band_jnd_db).powi(2)
            })
            .collect();
        let shape = bands.iter().sum::<f64>() / bands.len().max(1) as f64;
        (level * level + shape).sqrt()
    }
}

/// The share of a texture's power in the octave bands around 16, 31.5, 63, 125, 250 and 500 Hz.
fn shares(texture: &Texture) -> [f64; 6] {
    let mut shares = [0.0; 6];
    for (k, value) in texture.psd.iter().enumerate() {
        let octave = (k as f64 * texture.resolution_hz / (1000.0 / 64.0))
            .log2()
            .round();
        if (0.0..6.0).contains(&octave) {
            shares[octave as usize] += value;
        }
    }
    let sum: f64 = shares.iter().sum();
    shares.map(|share| if sum > 0.0 { share / sum } else { 0.0 })
}

/// Textures and which of them cannot be told apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Groups {
    /// The names, in the order of rows and columns.
    pub names: Vec<String>,
    /// The distance of every pair, JND.
    pub distance_jnd: Vec<Vec<f64>>,
    /// The groups, as indices of names: within one, every pair differs by the threshold or less.
    pub groups: Vec<Vec<usize>>,
    /// What decided.
    pub discrimination: Discrimination,
}

impl Groups {
    /// The groups of two textures and more, by name.
    #[must_use]
    pub fn confusable(&self) -> Vec<Vec<&str>> {
        self.groups
            .iter()
            .filter(|group| group.len() > 1)
            .map(|group| group.iter().map(|i| self.names[*i].as_str()).collect())
            .collect()
    }
}

/// The groups of `textures` that cannot be told apart by their vibration: the closest are joined first, and two
/// groups become one only while every pair across them stays within the threshold.
///
/// Source: agglomerative clustering with complete linkage, T. Sørensen (1948), Biol. Skr. Dan. Vid. Selsk. 5(4).
#[must_use]
pub fn indistinguishable(textures: &[Texture], discrimination: Discrimination) -> Groups {
    let distance_jnd: Vec<Vec<f64>> = textures
        .iter()
        .map(|a| {
            textures
                .iter()
                .map(|b| discrimination.distance_jnd(a, b))
                .collect()
        })
        .collect();
    let mut groups: Vec<Vec<usize>> = (0..textures.len()).map(|i| vec![i]).collect();
    loop {
        let widest = |a: &[usize], b: &[usize]| {
            a.iter()
                .flat_map(|i| b.iter().map(move |j| (*i, *j)))
                .map(|(i, j)| distance_jnd[i][j])
                .fold(0.0, f64::max)
        };
        let closest = (0..groups.len())
            .flat_map(|a| (a + 1..groups.len()).map(move |b| (a, b)))
            .map(|(a, b)| (widest(&groups[a], &groups[b]), a, b))
            .min_by(|x, y| x.0.total_cmp(&y.0));
        match closest {
            Some((distance, a, b)) if distance <= discrimination.threshold_jnd => {
                let joined = groups.remove(b);
                groups[a].extend(joined);
                groups[a].sort_unstable();
            }
            _ => break,
        }
    }
    Groups {
        names: textures.iter().map(|t| t.name.clone()).collect(),
        distance_jnd,
        groups,
        discrimination,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(name: &str, rms: f64, corner_hz: f64) -> Texture {
        Texture {
            name: name.into(),
            rms,
            psd: (0..200)
                .map(|k| 1.0 / (1.0 + (f64::from(k) * 5.0 / corner_hz).powi(2)))
                .collect(),
            resolution_hz: 5.0,
        }
    }

    #[test]
    fn level_and_shape_both_tell_textures_apart() {
        let textures = [
            texture("a", 1.0, 100.0),
            texture("b", 1.05, 100.0),
            texture("c", 1.5, 100.0),
            texture("d", 1.0, 400.0),
        ];
        let found = indistinguishable(&textures, Discrimination::usual());
        assert_eq!(found.confusable(), [["a", "b"]]);
        // 1.5 dB in level and nothing else is one JND.
        let louder = texture("e", 10f64.powf(1.5 / 20.0), 100.0);
        let distance = found.discrimination.distance_jnd(&textures[0], &louder);
        assert!((distance - 1.0).abs() < 1e-9, "{distance}");
    }

    #[test]
    fn a_chain_of_small_steps_is_not_one_group() {
        let chain: Vec<Texture> = (0..5)
            .map(|i| texture(&i.to_string(), 10f64.powf(f64::from(i) * 1.2 / 20.0), 100.0))
            .collect();
        let found = indistinguishable(&chain, Discrimination::usual());
        assert!(
            found.groups.iter().all(|group| group.len() <= 2),
            "{:?}",
            found.groups
        );
    }
}
