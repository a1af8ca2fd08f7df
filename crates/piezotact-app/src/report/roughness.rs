//! The report on a surface.

use crate::commands::roughness::Surface;
use crate::failure::Outcome;

pub(crate) fn render(_surface: &Surface) -> Outcome<String> {
    Ok(String::new())
}
