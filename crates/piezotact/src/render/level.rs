//! The level at which a drive fits its device.

use crate::quantity::Decibels;

/// What `render` makes of a target at its own level, 0 dB, or, where that is refused, at the level that `fits_at` finds in the
/// refusal; with that level, dB. It is refused where no level fits, or where a second attempt fails.
///
/// Source: house rule: one refusal names the level that fits, so that one more attempt is enough.
///
/// ```
/// use piezotact::quantity::Decibels;
/// use piezotact::render::at_fitting_level;
/// let softer = |level: Decibels| if level.0 <= -6.0 { Ok(level.0) } else { Err(Decibels(-6.0)) };
/// assert_eq!(at_fitting_level(softer, |fits| Some(*fits)), (Decibels(-6.0), Ok(-6.0)));
/// assert_eq!(at_fitting_level(softer, |_| None), (Decibels(0.0), Err(Decibels(-6.0))));
/// ```
pub fn at_fitting_level<T, E>(
    mut render: impl FnMut(Decibels) -> Result<T, E>,
    fits_at: impl Fn(&E) -> Option<Decibels>,
) -> (Decibels, Result<T, E>) {
    let own = Decibels(0.0);
    let first = render(own);
    match first.as_ref().err().and_then(fits_at) {
        Some(level) => (level, render(level)),
        None => (own, first),
    }
}
