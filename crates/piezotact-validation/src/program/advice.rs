//! Warnings in words.

use piezotact::Warning;
use piezotact::document::Words;

/// The sentences of warnings, as they are.
pub(super) struct PlainWords;

impl Words for PlainWords {
    fn warning(&self, warning: &Warning) -> String {
        warning.to_string()
    }
}
