//! NI TDMS files that were cut short, whose lengths lie, or that are no TDMS: an error or whole values, and bounded memory.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::io::Cursor;
use std::path::Path;

use crate::support::Lcg;
use crate::tdms::Holds::{Number, Text};
use crate::tdms::{
    META, RAW, object, parse, plain, said, samples, samples_of, segment, shared_files,
};
use piezotact_dataset::tdms::parse_tdms;
use piezotact_dataset::{ReadError, ReadOptions};
use proptest::prelude::*;

#[test]
fn lengths_that_lie_are_refused_with_their_place() {
    let put = |at: usize, bytes: &[u8]| {
        let mut file = plain();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let two = |at: usize, bytes: &[u8]| [put(at, bytes), plain()].concat();
    let whole = plain();
    let many = whole
        .windows(4)
        .position(|four| four == [0x14, 0, 0, 0])
        .unwrap()
        + 12;
    let huge = u64::MAX / 3;
    for (file, part) in [
        (two(12, &(huge).to_le_bytes()), "another segment at byte "),
        (put(12, &(u64::MAX - 5).to_le_bytes()), "at byte 12"),
        (put(20, &huge.to_le_bytes()), "at byte 20"),
        (put(12, &100_u64.to_le_bytes()), "at byte "),
        (put(28, &u32::MAX.to_le_bytes()), "before the end"),
        (put(32, &u32::MAX.to_le_bytes()), "a length of 4294967295"),
        (
            put(many, &huge.to_le_bytes()),
            "a possible number of samples",
        ),
        (put(many, &(1_u64 << 40).to_le_bytes()), "at byte "),
        (
            put(many - 8, &0x4F_u32.to_le_bytes()),
            "fixed-point numbers at byte ",
        ),
        (put(many - 4, &2_u32.to_le_bytes()), "2 dimensions at byte "),
        (put(8, &1_u32.to_le_bytes()), "version 1 at byte 4"),
        (
            segment(RAW, &[], &[]),
            "found none in the first segment at byte 0",
        ),
        (b"TDSm\x0e".to_vec(), "within its lead-in"),
        (
            [&whole[..], b"????????????????????????????????"].concat(),
            "found `????` at byte ",
        ),
    ] {
        let error = parse(&file, None).unwrap_err().to_string();
        assert!(error.contains(part), "{part}: {error}");
    }
}

/// Whole values and what is missing, or an error: never a panic, and never more samples than there were.
#[test]
fn a_file_that_was_cut_anywhere_says_so() {
    let mut files: Vec<Vec<u8>> = shared_files()
        .iter()
        .map(|f| std::fs::read(f).unwrap())
        .collect();
    files.push([plain(), plain()].concat());
    files.push(include_bytes!("golden/daqmx.tdms").to_vec());
    files.push(include_bytes!("golden/scales.tdms").to_vec());
    let mut random = Lcg(7);
    for file in &files {
        let Ok(whole) = parse(file, Some(1000.0)).or_else(|_| parse(file, None)) else {
            continue;
        };
        for _ in 0..200 {
            let length = random.below(file.len());
            // Long files are cut where it costs little.
            let length = if file.len() > 100_000 {
                length / 10
            } else {
                length
            };
            let Ok(cut) =
                parse(&file[..length], Some(1000.0)).or_else(|_| parse(&file[..length], None))
            else {
                continue;
            };
            let mut shorter = false;
            for channel in cut.channels() {
                let all = whole.channels().iter().find(|c| c.name == channel.name);
                let Some(all) = all else { continue };
                assert!(channel.samples.len() <= all.samples.len());
                // All samples were there, in this order; of scales that the rest of the file states the values may differ.
                shorter |= channel.samples.len() < all.samples.len();
                if channel.unit == all.unit && cut.channels().len() == whole.channels().len() {
                    let same = channel
                        .samples
                        .iter()
                        .zip(&all.samples)
                        .all(|(a, b)| a.to_bits() == b.to_bits());
                    assert!(same, "{length}: {}", channel.name);
                }
            }
            // At the end of a segment, nothing says that others followed.
            let is_cut = cut.about.provenance.losses.is_interrupted;
            assert!(
                !is_cut || said(&cut).contains("the file ends before"),
                "{}",
                said(&cut)
            );
            assert!(
                is_cut || !shorter || length == 0 || file[length..].starts_with(b"TDSm"),
                "{length}"
            );
        }
    }
    let cut = plain();
    let cut = parse(&cut[..cut.len() - 5], None).unwrap();
    let (a, b) = (samples(&cut, "a"), samples(&cut, "b"));
    assert_eq!((a, b), (&[1.0, 2.0][..], &[10.0, 20.0][..]));
    let text = said(&cut);
    assert!(text.contains("1 of 3 samples of `b`"), "{text}");
    // Where a channel is all but missing, the whole one stays.
    let cut = plain();
    let cut = parse(&cut[..cut.len() - 24], None).unwrap();
    assert_eq!(
        (cut.channels().len(), samples(&cut, "a")),
        (1, &[1.0, 2.0, 3.0][..])
    );
    assert!(
        said(&cut).contains("`b` (none of its 3 samples are in the file)"),
        "{}",
        said(&cut)
    );
    // LabVIEW did not end its last segment.
    let mut open = plain();
    open[12..20].fill(0xFF);
    let open = parse(&open, None).unwrap();
    assert_eq!(samples(&open, "b"), [10.0, 20.0, 30.0]);
    assert!(
        said(&open).contains("it was interrupted or is still running"),
        "{}",
        said(&open)
    );
}

#[test]
fn damage_is_an_error_and_no_panic() {
    let mut random = Lcg(9);
    let golden: [&[u8]; 2] = [
        include_bytes!("golden/daqmx.tdms"),
        include_bytes!("golden/scales.tdms"),
    ];
    for file in [&plain()[..], golden[0], golden[1]] {
        let mut damaged = file.to_vec();
        for round in 0..2000 {
            let at = random.below(damaged.len());
            damaged[at] = random.below(256) as u8;
            if let Err(error) = parse(&damaged, None) {
                assert!(
                    error.to_string().contains(';') || matches!(error, ReadError::Invalid { .. }),
                    "{error}"
                );
            }
            if round % 3 == 0 {
                damaged = file.to_vec();
            }
        }
    }
}

proptest! {
    /// No bytes behind a lead-in make more samples than they can hold: digital lines are the narrowest, of a bit each.
    #[test]
    fn any_bytes_are_samples_or_an_error(
        contents in prop::sample::select(vec![14_u32, 46, 78, 142, 206]),
        code in prop::sample::select(vec![1_u32, 2, 3, 9, 10, 0x20, 0x21, 0x44, 0xFFFF_FFFF]),
        header in prop::sample::select(vec![0_u32, 0x14, 0x1C, 0x1269, 0x126A, u32::MAX]),
        count in prop_oneof![0_u64..40, any::<u64>()],
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let index = [[header, code, 1].map(u32::to_le_bytes).concat(), count.to_le_bytes().to_vec()].concat();
        let index = if header == 0x14 || header == 0x1C { index } else { [&index[..], &bytes].concat() };
        let file = segment(contents, &[object("/'g'/'a'", &index, &[("wf_increment", Number(1.0))])], &bytes);
        if let Ok(read) = parse(&file, None) {
            let held: usize = read.channels().iter().map(|c| c.samples.len()).sum();
            prop_assert!(held <= 8 * file.len());
            prop_assert!(read.channels().iter().all(|c| c.samples.capacity() <= 8 * file.len()));
        }
    }
}

/// A reader that counts what is read of it.
struct Counted<R>(R, std::rc::Rc<std::cell::Cell<usize>>);

impl<R: std::io::Read> std::io::Read for Counted<R> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let count = self.0.read(to)?;
        self.1.set(self.1.get() + count);
        Ok(count)
    }
}

impl<R: std::io::Seek> std::io::Seek for Counted<R> {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.0.seek(to)
    }
}

/// The samples are read once, and stand in memory once.
#[test]
fn samples_are_reserved_and_read_once() {
    let count = 1_000_000_u64;
    let step = [("wf_increment", Number(1e-3)), ("unit_string", Text("N"))];
    let raw: Vec<u8> = (0..count).flat_map(|k| (k as f32).to_le_bytes()).collect();
    let file = segment(
        META | RAW,
        &[object("/'g'/'a'", &samples_of(9, count), &step)],
        &raw,
    );
    let read = std::rc::Rc::default();
    let counted = Counted(Cursor::new(&file[..]), std::rc::Rc::clone(&read));
    let recording = parse_tdms(Path::new("a.tdms"), counted, &ReadOptions::default()).unwrap();
    let channel = &recording.channels()[0].samples;
    assert_eq!(
        (channel.len(), channel.capacity(), channel[999_999]),
        (1_000_000, 1_000_000, 999_999.0)
    );
    // The structure is read twice, in blocks of 256 KiB.
    assert!(
        read.get() <= file.len() + (1 << 19),
        "{} of {}",
        read.get(),
        file.len()
    );
}
