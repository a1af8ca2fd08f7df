//! FLAC of instruments and recorders, against libsndfile and `flac` (`expected.json` beside the files); other sound files by name.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use crate::shared_data;
use crate::support::Lcg;
use piezotact::quantity::Unit;
use piezotact_dataset::{ReadOptions, read_recording};

/// A FLAC file of one block: 16-bit samples of one channel, stored as they are (no prediction).
fn flac(samples: &[i16], promised: u64, rate_code: u8) -> Vec<u8> {
    numbered(samples, promised, rate_code, 0)
}

fn numbered(samples: &[i16], promised: u64, rate_code: u8, number: u8) -> Vec<u8> {
    let count = samples.len() as u16;
    let mut bytes = b"fLaC\x80\x00\x00\x22".to_vec();
    // Lengths of blocks, unknown lengths in bytes; 1000 Hz, one channel, 16 bits, the number of samples; no checksum.
    bytes.extend([count.to_be_bytes(), count.to_be_bytes()].concat());
    bytes.extend([0; 6]);
    bytes.extend(((1000_u64 << 44) | (15 << 36) | promised).to_be_bytes());
    bytes.extend([0; 16]);
    let mut frame = vec![0xFF, 0xF8, 0x70 | rate_code, 0x08, number];
    frame.extend((count - 1).to_be_bytes());
    frame.push(crc(&frame, 8, 0x07) as u8);
    frame.push(0x02);
    frame.extend(samples.iter().flat_map(|sample| sample.to_be_bytes()));
    let check = crc(&frame, 16, 0x8005);
    frame.extend(check.to_be_bytes());
    bytes.extend(frame);
    bytes
}

fn crc(bytes: &[u8], width: u32, polynomial: u16) -> u16 {
    let top = 1_u32 << (width - 1);
    let mask = (1_u32 << width) - 1;
    let step = |crc: u32, _| match crc & top {
        0 => (crc << 1) & mask,
        _ => ((crc << 1) ^ u32::from(polynomial)) & mask,
    };
    let byte = |crc: u32, byte: &u8| (0..8).fold(crc ^ (u32::from(*byte) << (width - 8)), step);
    bytes.iter().fold(0, byte) as u16
}

/// A small file of one block.
pub(crate) fn small() -> Vec<u8> {
    let samples: Vec<i16> = (0..300).map(|k| (k * 997 % 4001) as i16).collect();
    flac(&samples, 300, 0)
}

#[test]
fn flac_is_read_as_wav_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.flac");
    let samples: Vec<i16> = (0..64).map(|k| k * 500 - 16_000).collect();
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read_recording(&path, &ReadOptions::default()).map_err(|error| error.to_string())
    };
    let contents = read(&flac(&samples, 64, 0)).unwrap();
    let expected: Vec<f64> = samples.iter().map(|s| f64::from(*s) / 32_768.0).collect();
    assert_eq!(contents.recording.channels()[0].samples, expected);
    assert_eq!(contents.recording.rate().hz(), 1000.0);
    assert_eq!(contents.kind.to_string(), "FLAC, 16-bit integer");
    // The sidecar gives the scale, as beside a WAV file.
    let sidecar = folder.path().join("a.flac.json");
    std::fs::write(
        &sidecar,
        r#"{"full_scale": {"value": 200, "unit": "m/s2"}}"#,
    )
    .unwrap();
    let scaled = read(&flac(&samples, 64, 0)).unwrap().recording;
    assert_eq!(scaled.channels()[0].unit, Unit::MetrePerSecondSquared);
    assert_eq!(scaled.channels()[0].samples[0], 200.0 * expected[0]);
    std::fs::remove_file(sidecar).unwrap();
    // An unknown number of samples is none; more than promised are said, fewer refused.
    assert_eq!(read(&flac(&samples, 0, 0)).unwrap().recording.len(), 64);
    let longer = read(&flac(&samples, 60, 0)).unwrap().recording;
    let said = longer.about.warnings.iter().map(ToString::to_string);
    assert!(
        said.into_iter()
            .any(|said| said.contains("60 samples and 64 follow"))
    );
    let whole = flac(&samples, 64, 0);
    // A second block of 8000 Hz.
    let mut changing = flac(&samples, 0, 0);
    changing.extend(&numbered(&samples, 0, 4, 1)[42..]);
    let mut damaged = whole.clone();
    damaged[100] ^= 1;
    // Two blocks of which the second is cut, and a promise of more: whole blocks are read, and it is said.
    let mut two = flac(&samples, 128, 0);
    two.extend(&numbered(&samples, 0, 0, 1)[42..]);
    for bytes in [flac(&samples, 65, 0), two[..two.len() - 9].to_vec()] {
        let cut = read(&bytes).unwrap().recording;
        assert_eq!(cut.channels()[0].samples, expected);
        let said = cut.about.warnings.iter().map(ToString::to_string);
        assert!(
            said.into_iter()
                .any(|said| said.contains("it was cut short"))
        );
    }
    for (bytes, part) in [
        (flac(&samples, 64, 4), "no block that fits its header"),
        (changing, "its rate, channels or bits change"),
        (damaged, "a FLAC file"),
        (whole[..90].to_vec(), "a FLAC file"),
        (whole[..20].to_vec(), "no STREAMINFO"),
    ] {
        let refused = read(&bytes).unwrap_err();
        assert!(
            refused.contains(part) && refused.contains("WAV"),
            "{part}: {refused}"
        );
    }
}

#[test]
fn damage_of_flac_is_an_error_and_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.flac");
    let whole = small();
    let mut random = Lcg(9);
    for round in 0..600 {
        let mut damaged = whole.clone();
        for _ in 0..=round % 3 {
            let at = 4 + random.below(whole.len() - 4);
            damaged[at] ^= 1 << random.below(8);
        }
        damaged.truncate(whole.len() - round % 2 * random.below(whole.len()));
        std::fs::write(&path, &damaged).unwrap();
        if let Err(error) = read_recording(&path, &ReadOptions::default()) {
            assert!(error.to_string().contains(';'), "{error}");
        }
    }
}

#[test]
fn files_of_others_have_the_values_of_libsndfile() {
    for (file, rate, frames, rms) in [
        (
            "flac/subset_21_-_samplerate_22050Hz.flac",
            22_050.0,
            109_266,
            &[0.085_671_631_349_646_67, 0.088_004_217_818_762_33][..],
        ),
        (
            "flac/subset_23_-_8_bit_per_sample.flac",
            44_100.0,
            339_973,
            &[0.056_576_734_039_475_41, 0.059_137_949_378_753_316],
        ),
        (
            "flac/subset_38_-_3_channels_(3.0).flac",
            44_100.0,
            168_210,
            &[
                0.021_724_126_978_240_797,
                0.022_984_620_873_342_708,
                0.021_369_348_469_756_435,
            ],
        ),
        (
            "flac/subset_60_-_mono_audio.flac",
            44_100.0,
            227_247,
            &[0.108_985_306_048_970_72],
        ),
        (
            "flac/subset_64_-_rice_partitions_with_escape_code_zero.flac",
            44_100.0,
            187_998,
            &[0.046_761_124_784_919_01],
        ),
        (
            "recorders/pcm24.flac",
            48_000.0,
            48_000,
            &[0.353_553_387_983_474_2, 0.049_819_275_491_073_79],
        ),
    ] {
        let Some(path) = shared_data::shared(&format!("data/daq/{file}")) else {
            continue;
        };
        let recording = read_recording(&path, &ReadOptions::default())
            .unwrap()
            .recording;
        assert_eq!(
            (recording.rate().hz(), recording.len()),
            (rate, frames),
            "{file}"
        );
        let found: Vec<f64> = (recording.channels().iter())
            .map(|channel| {
                let squares: f64 = channel.samples.iter().map(|x| x * x).sum();
                (squares / frames as f64).sqrt()
            })
            .collect();
        assert_eq!(found.len(), rms.len(), "{file}");
        for (found, expected) in found.iter().zip(rms) {
            // The order of summation.
            assert!((found / expected - 1.0).abs() < 1e-9, "{file}: {found}");
        }
    }
}

#[test]
fn a_rate_that_changes_and_a_header_that_is_missing_are_refused() {
    for (file, part) in [
        (
            "uncommon_01_-_changing_samplerate.flac",
            "its rate, channels or bits change",
        ),
        (
            "faulty_03_-_wrong_bit_depth.flac",
            "no block that fits its header",
        ),
        (
            "faulty_06_-_missing_streaminfo_metadata_block.flac",
            "no STREAMINFO",
        ),
    ] {
        let Some(path) = shared_data::shared(&format!("data/daq/flac/{file}")) else {
            continue;
        };
        let refused = read_recording(&path, &ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(refused.contains(part), "{refused}");
    }
    // The checksum of the samples says that all of them are there, and the number in the header is wrong.
    if let Some(path) =
        shared_data::shared("data/daq/flac/faulty_05_-_wrong_total_number_of_samples.flac")
    {
        let recording = read_recording(&path, &ReadOptions::default())
            .unwrap()
            .recording;
        assert_eq!(recording.len(), 109_487);
        let mut said = recording.about.warnings.iter().map(ToString::to_string);
        assert!(said.any(|said| said.contains("39842 samples and 109487 follow")));
    }
}

#[test]
fn other_sound_files_are_named_by_their_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    for (bytes, name) in [
        (&b"FORM\0\0\0\x08AIFFCOMM"[..], "AIFF;"),
        (b"FORM\0\0\0\x08AIFCFVER", "AIFF-C;"),
        (b"caff\0\x01\0\0desc", "CAF;"),
        (b"riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb", "Wave64 (W64);"),
        (b"BW64\xff\xff\xff\xffWAVEds64", "BW64;"),
    ] {
        std::fs::write(&path, bytes).unwrap();
        let refused = read_recording(&path, &ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(
            refused.contains(name) && refused.contains("convert it to WAV"),
            "{refused}"
        );
    }
}
