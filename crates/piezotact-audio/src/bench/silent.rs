//! Silent parts of a signal that comes in pieces.

/// So many zeros in a row are a silent part.
pub(super) const SILENT_SAMPLES: usize = 16;

/// Counts silent parts of a signal that comes in pieces.
#[derive(Clone, Debug, Default)]
pub(super) struct SilentParts {
    /// Zeros at the end of what came, after something else.
    zeros: Option<usize>,
    pub(super) parts: usize,
    pub(super) samples: usize,
}

impl SilentParts {
    pub(super) fn take(&mut self, samples: &[f64]) {
        for sample in samples {
            if *sample == 0.0 {
                self.zeros = self.zeros.map(|zeros| zeros + 1);
                continue;
            }
            if let Some(zeros) = self.zeros
                && zeros >= SILENT_SAMPLES
            {
                self.parts += 1;
                self.samples += zeros;
            }
            self.zeros = Some(0);
        }
    }
}
