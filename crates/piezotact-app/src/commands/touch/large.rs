//! A recording of touch that is larger than memory: read twice, part by part.

use piezotact::study::{
    AnalysedRecording, Cutting, InSections, MEMORY_BYTES_A_SAMPLE, SECTION_BYTES, StudyAnalysis,
    StudyError, StudySettings, label_by,
};

use super::{failed, named, stated};
use crate::cli::{By, Takes};
use crate::failure::Outcome;
use crate::large::{LARGE_BYTES, Large};
use crate::memory::fits;

/// A recording larger than memory, cut in sections.
pub(super) struct Cut {
    large: Large,
    sections: InSections,
}

impl Cut {
    /// The only recording of `args` with its strokes, where it is larger than memory; `None` elsewhere, where a person cut it (cuts are of
    /// whole recordings), and where memory suffices for all of it and it cannot be divided, or its motion was measured: spectra along the way
    /// are of whole recordings.
    pub(super) fn of(args: &Takes) -> Outcome<Option<Self>> {
        let [path] = args.recordings.as_slice() else {
            return Ok(None);
        };
        let Some(large) = Large::open(path, &args.reading, LARGE_BYTES)? else {
            return Ok(None);
        };
        let recorded = named(path, args, large.contents().recording.clone())?;
        if recorded.cuts.is_some() {
            return Ok(None);
        }
        let mut cutting = Cutting::new(recorded, &stated(args)?, SECTION_BYTES).map_err(failed)?;
        let mut is_undivided = false;
        let inspected = large.inspected(|part| {
            cutting.add(part).map_err(|error| {
                is_undivided = matches!(error, StudyError::Undivided { .. });
                failed(error)
            })
        });
        let whole_bytes = 2 * size_of::<f64>() * large.names().len() + MEMORY_BYTES_A_SAMPLE;
        let fits_whole = || fits("it", large.samples(), whole_bytes).is_ok();
        let contents = match inspected {
            Err(_) if is_undivided && fits_whole() => return Ok(None),
            inspected => inspected?,
        };
        let sections = cutting.cut(contents.recording.about.warnings);
        let sections = sections.map_err(failed)?;
        if sections.take.segmentation.roles.motion.is_some() && fits_whole() {
            return Ok(None);
        }
        Ok(Some(Self { large, sections }))
    }

    /// The recording with its strokes.
    pub(super) fn take(&self) -> AnalysedRecording {
        self.sections.cuts()
    }

    /// What its strokes say.
    pub(super) fn analysed(
        self,
        by: Option<&By>,
        settings: &StudySettings,
    ) -> Outcome<StudyAnalysis> {
        let Self {
            large,
            mut sections,
        } = self;
        if let Some(By::Label(name)) = by {
            label_by(std::slice::from_mut(&mut sections.take), name).map_err(failed)?;
        }
        let mut measuring = sections.measuring(settings).map_err(failed)?;
        large.each(&large.names(), |_, part| {
            measuring.add(part).map_err(failed)
        })?;
        measuring.finish().map_err(failed)
    }
}
