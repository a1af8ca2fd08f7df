//! Which textures cannot be told apart by their vibration.

use serde::{Deserialize, Serialize};

/// What is compared: a name, and a one-sided PSD with lines `resolution_hz` apart from 0 Hz.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The name.
    pub name: String,
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

    /// The distance of two textures in JND, 0 for two silent ones.
    ///
    /// Formula: √((ΔL/level JND)² + (largest ΔB/band JND)²), where L is the level within the octave bands together and
    /// B that of one band relative to them; bands around 1 to 500 Hz in which either texture holds 1 % of its power
    /// or more.
    ///
    /// Source: the cue combination of independent differences (Pythagorean sum), N. A. Macmillan and C. D. Creelman,
    /// *Detection Theory*, 2nd ed., chapter 6; of bands the one that differs most decides, as in profile analysis.
    #[must_use]
    pub fn distance_jnd(&self, a: &Texture, b: &Texture) -> f64 {
        let (a, b) = (band_powers(a), band_powers(b));
        let total = |bands: &[f64; 10]| bands.iter().sum::<f64>().max(SILENCE);
        let (all_a, all_b) = (total(&a), total(&b));
        let level = 10.0 * (all_a / all_b).log10() / self.level_jnd_db;
        let shape = a
            .iter()
            .zip(&b)
            .map(|(a, b)| (a / all_a, b / all_b))
            .filter(|(a, b)| a.max(*b) >= 0.01)
            .map(|(a, b)| (10.0 * (a.max(1e-6) / b.max(1e-6)).log10() / self.band_jnd_db).abs())
            .fold(0.0, f64::max);
        level.hypot(shape)
    }
}

/// Power below this is silence, u².
const SILENCE: f64 = 1e-30;

/// The power of a texture in the octave bands around 1, 2, 4, 8, 16, 31.5, 63, 125, 250 and 500 Hz, u².
fn band_powers(texture: &Texture) -> [f64; 10] {
    let mut powers = [0.0; 10];
    for (k, value) in texture.psd.iter().enumerate() {
        let octave = (k as f64 * texture.resolution_hz / (1000.0 / 1024.0))
            .log2()
            .round();
        if (0.0..10.0).contains(&octave) {
            powers[octave as usize] += value * texture.resolution_hz;
        }
    }
    powers
}

/// Textures and which of them cannot be told apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Groups {
    /// The names, in the order of rows and columns.
    pub names: Vec<String>,
    /// The distance of every pair, JND.
    pub distance_jnd: Vec<Vec<f64>>,
    /// The groups, as indices of names: within one, every pair differs by the threshold or less, and no other texture
    /// could join it.
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

/// The groups of `textures` that cannot be told apart by their vibration: the largest sets in which every pair is
/// within the threshold. A texture may stand in several of them, and every close pair in one at least.
///
/// Source: maximal cliques of the graph of close pairs, C. Bron and J. Kerbosch (1973), Commun. ACM 16(9).
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
    let near: Vec<Vec<usize>> = distance_jnd
        .iter()
        .enumerate()
        .map(|(i, row)| {
            let close = |j: &usize| *j != i && row[*j] <= discrimination.threshold_jnd;
            (0..row.len()).filter(close).collect()
        })
        .collect();
    let mut groups = Vec::new();
    maximal(
        &near,
        &mut Vec::new(),
        (0..textures.len()).collect(),
        Vec::new(),
        &mut groups,
    );
    groups.sort();
    Groups {
        names: textures.iter().map(|t| t.name.clone()).collect(),
        distance_jnd,
        groups,
        discrimination,
    }
}

/// All maximal sets in which everyone is near everyone: `chosen` with any of `open`, none of `done`.
fn maximal(
    near: &[Vec<usize>],
    chosen: &mut Vec<usize>,
    mut open: Vec<usize>,
    mut done: Vec<usize>,
    found: &mut Vec<Vec<usize>>,
) {
    if open.is_empty() && done.is_empty() {
        let mut group = chosen.clone();
        group.sort_unstable();
        found.push(group);
        return;
    }
    // Sets that leave out one neighbour of a pivot hold the pivot, or another of its strangers.
    let shared = |i: &usize| open.iter().filter(|j| near[*i].contains(j)).count();
    let pivot = open.iter().chain(&done).copied().max_by_key(shared);
    let strangers: Vec<usize> = open
        .iter()
        .copied()
        .filter(|i| pivot.is_none_or(|pivot| !near[pivot].contains(i)))
        .collect();
    for i in strangers {
        let of = |all: &[usize]| {
            all.iter()
                .copied()
                .filter(|j| near[i].contains(j))
                .collect()
        };
        chosen.push(i);
        maximal(near, chosen, of(&open), of(&done), found);
        chosen.pop();
        open.retain(|j| *j != i);
        done.push(i);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(name: &str, rms: f64, corner_hz: f64) -> Texture {
        Texture {
            name: name.into(),
            psd: (0..200)
                .map(|k| rms * rms / (1.0 + (f64::from(k) * 5.0 / corner_hz).powi(2)))
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
        assert_eq!(found.groups.len(), 4);
        assert!(
            found.groups.iter().all(|group| group.len() == 2),
            "{:?}",
            found.groups
        );
    }
}
