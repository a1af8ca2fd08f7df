//! Labels: names of people, sessions, tasks and samples as BIDS allows them in the names of files.

use std::collections::BTreeMap;

use super::error::BidsError;

/// `text` as a label: its ASCII letters and digits. `None` where none is left.
///
/// ```
/// use piezotact_study::bids::label_of;
/// assert_eq!(label_of("S2 INVERTED").as_deref(), Some("S2INVERTED"));
/// assert_eq!(label_of("velours côtelé").as_deref(), Some("velourscotele"));
/// assert_eq!(label_of("—"), None);
/// ```
#[must_use]
pub fn label_of(text: &str) -> Option<String> {
    let kept: String = text.chars().filter_map(plain).collect();
    (!kept.is_empty()).then_some(kept)
}

/// An ASCII letter or digit; of a Latin letter with a mark the letter without it.
fn plain(sign: char) -> Option<char> {
    if sign.is_ascii_alphanumeric() {
        return Some(sign);
    }
    let lower = sign.to_lowercase().next()?;
    let base = match lower {
        'à' | 'á' | 'â' | 'ã' | 'ä' | 'å' => 'a',
        'ç' => 'c',
        'è' | 'é' | 'ê' | 'ë' => 'e',
        'ì' | 'í' | 'î' | 'ï' => 'i',
        'ñ' => 'n',
        'ò' | 'ó' | 'ô' | 'õ' | 'ö' | 'ø' => 'o',
        'ù' | 'ú' | 'û' | 'ü' => 'u',
        'ý' | 'ÿ' => 'y',
        _ => return None,
    };
    Some(match sign.is_uppercase() {
        true => base.to_ascii_uppercase(),
        false => base,
    })
}

/// The labels of one kind of names, each for one name.
#[derive(Clone, Debug)]
pub(super) struct Labels {
    what: &'static str,
    /// By the label in small letters: some file systems know no others.
    of: BTreeMap<String, (String, String)>,
}

impl Labels {
    /// Labels of "participant", "session", "task" or "sample".
    pub(super) fn of(what: &'static str) -> Self {
        Self {
            what,
            of: BTreeMap::new(),
        }
    }

    /// The label of `name`.
    ///
    /// # Errors
    /// [`BidsError::NoLabel`], and [`BidsError::Clash`] where another name has the same.
    pub(super) fn label(&mut self, name: &str) -> Result<String, BidsError> {
        let Some(label) = label_of(name) else {
            return Err(BidsError::NoLabel {
                what: self.what,
                name: name.to_owned(),
            });
        };
        let known = self
            .of
            .entry(label.to_lowercase())
            .or_insert_with(|| (name.to_owned(), label.clone()));
        match known.0 == name {
            true => Ok(known.1.clone()),
            false => Err(BidsError::Clash {
                what: self.what,
                label,
                names: [known.0.clone(), name.to_owned()],
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_would_share_a_label_are_refused_with_both() {
        let mut labels = Labels::of("participant");
        assert_eq!(labels.label("P-01").unwrap(), "P01");
        assert_eq!(labels.label("P-01").unwrap(), "P01");
        for other in ["P01", "p01", "P_01"] {
            let said = labels.label(other).unwrap_err().to_string();
            assert!(said.contains("P-01") && said.contains(other), "{said}");
        }
        let said = labels.label("___").unwrap_err().to_string();
        assert!(
            said.contains("letter or digit") && said.contains("___"),
            "{said}"
        );
    }
}
