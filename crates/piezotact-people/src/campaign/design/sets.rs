//! Sets of samples that are presented together, checked.

use std::collections::{BTreeMap, BTreeSet};

use super::error::DesignError;

/// `sets` of `samples` by name on a tray that holds `tray` samples, as indices of samples.
///
/// # Errors
///
/// Fewer than two samples, one named twice, a set with an unknown sample, the same one twice, fewer than two or more than the tray holds.
pub(super) fn indexed(
    samples: &[String],
    sets: &[Vec<String>],
    tray: usize,
) -> Result<Vec<Vec<usize>>, DesignError> {
    let index = index(samples)?;
    let numbered = sets.iter().enumerate();
    numbered
        .map(|(i, set)| one_set(&index, set, i + 1, tray))
        .collect()
}

fn index(samples: &[String]) -> Result<BTreeMap<&str, usize>, DesignError> {
    let mut index = BTreeMap::new();
    for (i, sample) in samples.iter().enumerate() {
        if index.insert(sample.as_str(), i).is_some() {
            return Err(DesignError::SampleTwice {
                sample: sample.clone(),
            });
        }
    }
    if samples.len() < 2 {
        return Err(DesignError::TooFewSamples {
            found: samples.len(),
            expected: 2,
        });
    }
    Ok(index)
}

fn one_set(
    index: &BTreeMap<&str, usize>,
    set: &[String],
    number: usize,
    tray: usize,
) -> Result<Vec<usize>, DesignError> {
    let found = set.len();
    if found < 2 {
        return Err(DesignError::SetTooSmall { set: number, found });
    }
    if found > tray {
        return Err(DesignError::SetTooLarge {
            set: number,
            found,
            tray,
        });
    }
    let mut seen = BTreeSet::new();
    let mut known = Vec::with_capacity(found);
    for sample in set {
        let Some(i) = index.get(sample.as_str()) else {
            return Err(DesignError::UnknownSample {
                set: number,
                sample: sample.clone(),
            });
        };
        if !seen.insert(*i) {
            return Err(DesignError::SampleTwiceInSet {
                set: number,
                sample: sample.clone(),
            });
        }
        known.push(*i);
    }
    Ok(known)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(of: &str) -> Vec<String> {
        of.split(' ')
            .filter(|n| !n.is_empty())
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn bad_sets_are_refused_by_name() {
        let samples = names("a b c d");
        let of = |sets: &[&str]| {
            let sets: Vec<Vec<String>> = sets.iter().map(|set| names(set)).collect();
            indexed(&samples, &sets, 3)
        };
        assert_eq!(of(&["a b", "d c b"]), Ok(vec![vec![0, 1], vec![3, 2, 1]]));
        assert_eq!(
            of(&["a b", ""]),
            Err(DesignError::SetTooSmall { set: 2, found: 0 })
        );
        assert_eq!(
            of(&["a b c d"]),
            Err(DesignError::SetTooLarge {
                set: 1,
                found: 4,
                tray: 3
            })
        );
        assert!(
            matches!(of(&["a x"]), Err(DesignError::UnknownSample { sample, .. }) if sample == "x")
        );
        assert!(matches!(
            of(&["a a"]),
            Err(DesignError::SampleTwiceInSet { .. })
        ));
        assert!(matches!(
            indexed(&names("a b a"), &[names("a b")], 3),
            Err(DesignError::SampleTwice { .. })
        ));
    }
}
