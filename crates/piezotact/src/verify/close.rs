//! What counts as close to a target.

use super::Verification;

/// What counts as close, dB: the rms over what the inverse reaches, and the largest of its lines.
pub const CLOSE_DB: (f64, f64) = (1.0, 3.0);

impl Verification {
    /// Whether the measurement came close to its target over what is reached, in rms and in every line.
    #[must_use]
    pub fn is_close(&self) -> bool {
        self.judged_error_db() <= CLOSE_DB.0 && self.error_db_max_achievable() <= CLOSE_DB.1
    }
}
