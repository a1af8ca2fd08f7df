//! Recordings that are too large to be held in memory, read part by part.

use std::path::Path;

use piezotact::integrity::InParts;
use piezotact::quantity::{SampleRate, Seconds};
use piezotact::recording::Recording;
use piezotact_dataset::{Contents, RecordingInBlocks, recording_in_blocks};

use crate::calls;
use crate::cli::Reading;
use crate::failure::Outcome;
use crate::progress::{Words, Work};
use crate::reading::{drive_limit, options_of};

/// A recording whose samples take more is read part by part, bytes. The guide and docs/decisions/files-of-others.md state it.
pub(crate) const LARGE_BYTES: u64 = 256 << 20;
/// What the samples of a part take, bytes.
const PART_BYTES: usize = 32 << 20;
/// No part is shorter, so that hum and rests show in it.
const SHORTEST: Seconds = Seconds(30.0);

const READING: Words = Words {
    doing: "reading",
    done: "read",
    item: "part",
    then: "computing",
};

/// A recording that is read part by part.
pub(crate) struct Large(RecordingInBlocks);

impl Large {
    /// The recording in `path` where its samples take more than `beyond_bytes` and its format is read in parts.
    pub(crate) fn open(path: &Path, reading: &Reading, beyond_bytes: u64) -> Outcome<Option<Self>> {
        if calls::is_given(path) {
            return Ok(None);
        }
        let found = recording_in_blocks(path, &options_of(reading)?, beyond_bytes)?;
        Ok(found.map(Self))
    }

    /// All that is known of it but its samples.
    pub(crate) fn contents(&self) -> &Contents {
        self.0.contents()
    }

    pub(crate) fn samples(&self) -> usize {
        self.0.samples()
    }

    /// The names of its channels.
    pub(crate) fn names(&self) -> Vec<&str> {
        let channels = self.contents().recording.channels().iter();
        channels.map(|channel| channel.name.as_str()).collect()
    }

    /// Gives the parts of the `channels` to `take`, with the number of their first sample.
    pub(crate) fn each(
        &self,
        channels: &[&str],
        mut take: impl FnMut(usize, &Recording) -> Outcome,
    ) -> Outcome {
        let rate = self.contents().recording.rate();
        let part = part(self.samples(), channels.len(), rate);
        let count = self.samples().div_ceil(part);
        let reading = Work::of_sizes(READING, vec![1.0; count]);
        self.0.each(channels, part, |first, recording| {
            take(first, recording)?;
            reading.one_more();
            Ok(())
        })
    }

    /// Gives the parts of all channels to `take`, and what is known of the recording with the warnings about what broke in them.
    pub(crate) fn inspected(
        &self,
        mut take: impl FnMut(&Recording) -> Outcome,
    ) -> Outcome<Contents> {
        let mut contents = self.contents().clone();
        let mut found = InParts::new(drive_limit(contents.setup.as_ref()));
        self.each(&self.names(), |_, part| {
            found.add(part);
            take(part)
        })?;
        contents.recording.about.add_warnings(found.warnings());
        Ok(contents)
    }
}

/// Samples of a part of a recording of so many `samples`: all parts are equally long, but for rounding.
fn part(samples: usize, channels: usize, rate: SampleRate) -> usize {
    let most = (PART_BYTES / 8 / channels.max(1)).max(rate.samples_in(SHORTEST));
    samples.div_ceil(samples.div_ceil(most.max(1)).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_equally_long_and_no_shorter_than_half_a_minute() {
        let rate = SampleRate::new(5000.0).unwrap();
        let of = |samples, channels| part(samples, channels, rate);
        // 24 hours of four channels: 412 parts of 32 MiB; of 400 channels parts of 30 s; less than a part is one.
        assert_eq!(of(432_000_000, 4), 1_048_544);
        assert_eq!(of(432_000_000, 400), 150_000);
        assert_eq!(of(450_001, 400), 112_501);
        assert_eq!(of(1000, 4), 1000);
    }
}
