//! Every variant of the binary topography formats, made here byte by byte from their definitions, and SDF text.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use piezotact::recording::RecordingWarning;
use piezotact_surface::{HeightsFault, SurfaceWarning};
use std::io::{Cursor, Write as _};

use crate::support::{Lcg, NOTHING, STATED, assert_heights, assert_refused, attack, map, parse};
use md5::{Digest as _, Md5};
use piezotact::Warning;
use piezotact::surface::HeightMap;
use piezotact_surface::Topography;
use piezotact_surface::{TopographyKind, read_topography, write_sur};

fn put(file: &mut [u8], at: usize, bytes: &[u8]) {
    file[at..at + bytes.len()].copy_from_slice(bytes);
}

/// A SUR header of 3 × 2 points of `bits` bits: steps of 2 and 4 µm, heights in steps of 10 nm above 1 µm.
fn sur(bits: u16) -> Vec<u8> {
    let mut file = vec![0; 512];
    put(&mut file, 0, b"DIGITAL SURF");
    for (at, value) in [(14, 1_u16), (18, 2), (86, 1), (98, bits), (334, 5)] {
        put(&mut file, at, &value.to_le_bytes());
    }
    for (at, value) in [(100, 0_i32), (108, 3), (112, 2), (116, 6)] {
        put(&mut file, at, &value.to_le_bytes());
    }
    for (at, value) in [(120, 2.0_f32), (124, 0.004), (128, 10.0), (474, 1.0)] {
        put(&mut file, at, &value.to_le_bytes());
    }
    for (at, unit) in [
        (180, &b"\xB5m"[..]),
        (196, b"mm"),
        (212, b"nm"),
        (228, b"um"),
        (244, b"um"),
        (260, b"\xE6m"),
    ] {
        put(&mut file, at, &[b' '; 16]);
        put(&mut file, at, unit);
    }
    file.extend(b"hello");
    file
}

const STORED: [i32; 6] = [-2, 0, 100, 200, 300, 400];
const SUR_M: [f64; 6] = [f64::NAN, 1e-6, 2e-6, 3e-6, 4e-6, 5e-6];

#[test]
fn sur_has_16_and_32_bits_and_either_order_of_bytes() {
    for bits in [16, 32] {
        let mut file = sur(bits);
        for z in STORED {
            file.extend(&z.to_le_bytes()[..usize::from(bits / 8)]);
        }
        let read = parse(&file, &NOTHING).unwrap();
        assert_heights(&read, &SUR_M);
        assert_eq!(read.kind, TopographyKind::Sur);
        assert_eq!(
            read.warnings,
            [Warning::from(SurfaceWarning::Heights {
                fault: HeightsFault::Missing { share: 1.0 / 6.0 }
            })]
        );
        let map = map(&read);
        assert_eq!((map.rows(), map.columns()), (2, 3));
        assert!((map.step_x_m() - 2e-6).abs() < 1e-12);
        assert!((map.step_y_m() - 4e-6).abs() < 1e-12);

        // The same with every number turned round.
        let mut turned = file.clone();
        for at in [14, 18, 86, 98, 334] {
            turned[at..at + 2].reverse();
        }
        for at in [100, 108, 112, 116, 120, 124, 128, 474] {
            turned[at..at + 4].reverse();
        }
        for z in turned[517..].chunks_exact_mut(usize::from(bits / 8)) {
            z.reverse();
        }
        assert_heights(&parse(&turned, &NOTHING).unwrap(), &SUR_M);
    }
}

#[test]
fn a_sur_is_compressed_inverted_a_profile_or_refused() {
    let heights: Vec<u8> = STORED.iter().flat_map(|z| z.to_le_bytes()).collect();
    let pack = |bytes: &[u8]| {
        let mut encoder =
            flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    };
    let mut file = sur(32);
    put(&mut file, 0, b"DSCOMPRESSED");
    let pieces = [&heights[..7], &heights[7..]];
    file.extend(2_u32.to_le_bytes());
    for piece in pieces {
        file.extend((piece.len() as u32).to_le_bytes());
        file.extend((pack(piece).len() as u32).to_le_bytes());
    }
    for piece in pieces {
        file.extend(pack(piece));
    }
    let read = parse(&file, &NOTHING).unwrap();
    assert_eq!(read.kind, TopographyKind::SurCompressed);
    assert_heights(&read, &SUR_M);
    attack(&file);
    assert_refused(&file[..file.len() - 9], "compressed");
    let mut bomb = sur(32);
    put(&mut bomb, 0, b"DSCOMPRESSED");
    let packed = pack(&vec![0; 10_000_000]);
    bomb.extend(1_u32.to_le_bytes());
    bomb.extend(24_u32.to_le_bytes());
    bomb.extend((packed.len() as u32).to_le_bytes());
    bomb.extend(packed);
    assert_refused(&bomb, "more");

    let mut plain = sur(32);
    plain.extend(&heights);
    for (flag, order) in [
        (1, [0, 1, 2, 3, 4, 5]),
        (2, [2, 1, 0, 5, 4, 3]),
        (3, [3, 4, 5, 0, 1, 2]),
    ] {
        let mut inverted = plain.clone();
        put(&mut inverted, 290, &[flag]);
        let read = parse(&inverted, &NOTHING).unwrap();
        assert_heights(&read, &order.map(|at: usize| -SUR_M[at]));
        assert!(matches!(
            read.warnings[0].kind(),
            Some(RecordingWarning::Guessed { .. })
        ));
    }
    for (at, bytes, part) in [
        (18, &[5_u8, 0][..], "type 5"),
        (98, &[24, 0], "16 or 32 bits"),
        (108, &1_000_000_000_i32.to_le_bytes(), "1000000000 × 2"),
        (108, &(-3_i32).to_le_bytes(), "0 × 2"),
        (116, &[7], "states 7"),
        (212, b"V ", "units of length"),
        (128, &[0; 4], "step of the heights"),
        (120, &[0; 4], "step between heights"),
        (120, &f32::MAX.to_le_bytes(), "unit of the steps"),
    ] {
        let mut wrong = plain.clone();
        put(&mut wrong, at, bytes);
        assert_refused(&wrong, part);
    }
    // Many points in a small file are refused before memory is set aside for them.
    let mut large = plain.clone();
    put(&mut large, 108, &10_000_i32.to_le_bytes());
    put(&mut large, 112, &10_000_i32.to_le_bytes());
    put(&mut large, 116, &100_000_000_u32.to_le_bytes());
    assert_refused(&large, "400000000 bytes");

    let mut profile = sur(16);
    put(&mut profile, 18, &[1]);
    put(&mut profile, 86, &[0]);
    for (at, value) in [(108, 9_i32), (112, 1), (116, 9)] {
        put(&mut profile, at, &value.to_le_bytes());
    }
    profile.extend([0; 18]);
    assert_heights(&parse(&profile, &NOTHING).unwrap(), &[1e-6; 9]);
}

/// Fields of an X3P that the tests change.
#[derive(Clone)]
struct X3p<'a> {
    feature: &'a str,
    sizes: [usize; 3],
    z_type: &'a str,
    z_more: &'a str,
    links: &'a str,
    data: Vec<u8>,
    more: &'a [(&'a str, Vec<u8>)],
}

impl X3p<'_> {
    fn bytes(&self) -> Vec<u8> {
        self.zip(self.main().as_bytes())
    }

    fn main(&self) -> String {
        let [x, y, z] = self.sizes;
        format!(
            "<p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\"><Record1><FeatureType>{}</FeatureType>\
             <Axes><CX><AxisType>I</AxisType><Increment>2e-6</Increment></CX>\
             <CY><AxisType>I</AxisType><Increment>4E-006</Increment></CY>\
             <CZ><AxisType>A</AxisType><DataType>{}</DataType>{}</CZ></Axes></Record1>\
             <Record3><MatrixDimension><SizeX>{x}</SizeX><SizeY>{y}</SizeY><SizeZ>{z}</SizeZ></MatrixDimension>\
             <DataLink><PointDataLink>bindata/data.bin</PointDataLink>{}</DataLink></Record3>\
             <Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4></p:ISO5436_2>",
            self.feature, self.z_type, self.z_more, self.links
        )
    }

    fn zip(&self, main: &[u8]) -> Vec<u8> {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        let mut add = |name: &str, bytes: &[u8]| {
            zip.start_file(name, zip::write::SimpleFileOptions::default())
                .unwrap();
            zip.write_all(bytes).unwrap();
        };
        add("main.xml", main);
        add("bindata/data.bin", &self.data);
        for (name, bytes) in self.more {
            add(name, bytes);
        }
        zip.finish().unwrap().into_inner()
    }
}

fn hex(bytes: &[u8]) -> String {
    Md5::digest(bytes)
        .iter()
        .map(|b| format!("{b:02X}"))
        .collect()
}

#[test]
fn x3p_has_four_data_types_a_mask_and_checksums() {
    let whole = [1_i32, 2, 3, 4, 5, 6];
    let metres = whole.map(|z| f64::from(z) * 1e-6 + 1e-3);
    let scale = "<Increment>1e-6</Increment><Offset>0.001</Offset>";
    let types: [(&str, &str, Vec<u8>); 4] = [
        (
            "I",
            scale,
            whole
                .iter()
                .flat_map(|z| (*z as i16).to_le_bytes())
                .collect(),
        ),
        (
            "L",
            scale,
            whole.iter().flat_map(|z| z.to_le_bytes()).collect(),
        ),
        (
            "F",
            "",
            metres
                .iter()
                .flat_map(|z| (*z as f32).to_le_bytes())
                .collect(),
        ),
        (
            "D",
            "",
            metres.iter().flat_map(|z| z.to_le_bytes()).collect(),
        ),
    ];
    for (z_type, z_more, data) in types {
        let stated = format!(
            "<MD5ChecksumPointData>{}</MD5ChecksumPointData>",
            hex(&data)
        );
        let mut file = X3p {
            feature: "SUR",
            sizes: [3, 2, 1],
            z_type,
            z_more,
            links: &stated,
            data,
            more: &[],
        };
        let read = parse(&file.bytes(), &NOTHING).unwrap();
        assert_heights(&read, &metres);
        assert_eq!(
            (read.kind, read.warnings.as_slice()),
            (TopographyKind::X3p, &[][..])
        );
        assert!((map(&read).step_y_m() - 4e-6).abs() < 1e-15);

        // Points 0 and 4 were not measured.
        let mask = [("bindata/valid.bin", vec![0b10_1110_u8])];
        file.more = &mask;
        file.links = "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>";
        let mut masked = metres;
        masked[0] = f64::NAN;
        masked[4] = f64::NAN;
        assert_heights(&parse(&file.bytes(), &NOTHING).unwrap(), &masked);

        file.links =
            "<MD5ChecksumPointData>0123456789abcdef0123456789abcdef</MD5ChecksumPointData>";
        assert_refused(&file.bytes(), "not the heights that were written");

        let other = [(
            "md5checksum.hex",
            b"0123456789abcdef0123456789abcdef *main.xml".to_vec(),
        )];
        file.more = &other;
        file.links = "";
        let read = parse(&file.bytes(), &NOTHING).unwrap();
        assert!(
            matches!(read.warnings.as_slice(), [warning] if matches!(warning.kind(), Some(RecordingWarning::Guessed { .. })))
        );

        for (feature, sizes, part) in [
            ("PCL", [3, 2, 1], "PCL"),
            ("SUR", [3, 2, 2], "one layer"),
            ("SUR", [3, 3, 1], "bytes of heights"),
            ("SUR", [2, 2, 1], "more"),
            ("SUR", [usize::MAX, 2, 1], "points"),
            ("SUR", [30_000, 30_000, 1], "points"),
        ] {
            let bytes = X3p {
                feature,
                sizes,
                ..file.clone()
            }
            .bytes();
            assert_refused(&bytes, part);
        }
    }
    let profile = X3p {
        feature: "PRF",
        sizes: [8, 1, 1],
        z_type: "F",
        z_more: "",
        links: "",
        data: vec![0; 32],
        more: &[],
    };
    assert_heights(&parse(&profile.bytes(), &NOTHING).unwrap(), &[0.0; 8]);
    attack(&profile.bytes());
    let (main, mut random) = (profile.main(), Lcg(5));
    for _ in 0..2000 {
        let mut damaged = main.clone().into_bytes();
        let at = random.below(damaged.len());
        damaged[at] ^= 1 + random.below(255) as u8;
        let _ = parse(&profile.zip(&damaged), &STATED);
    }
    let deep = profile.zip("<a>".repeat(200_000).as_bytes());
    assert_refused(&deep, "main.xml");
    assert_refused(b"PK\x03\x04 and nothing more", "X3P");
}

/// A zip archive of these files.
fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, zip::write::SimpleFileOptions::default())
            .unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// As ISO 5436-2 has them in its samples, R writes them, and an Alicona marks what it did not measure.
#[test]
fn x3p_has_its_heights_in_the_xml_in_a_folder_and_infinite() {
    let binary = X3p {
        feature: "SUR",
        sizes: [3, 2, 1],
        z_type: "I",
        z_more: "<Increment>1e-6</Increment><Offset>0.001</Offset>",
        links: "",
        data: [1_i16, 2, 3, 4, 5, 6].map(i16::to_le_bytes).concat(),
        more: &[],
    };
    let link = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>";
    let with = |list: &str| {
        let main = binary.main().replace(link, list);
        archive(&[("main.xml", main.as_bytes())])
    };
    let listed = with(
        "<DataList><Datum>1</Datum><Datum> 2 </Datum><Datum/><Datum>4</Datum><Datum></Datum><Datum>6</Datum></DataList>",
    );
    let mut expected = [1e-6, 2e-6, f64::NAN, 4e-6, f64::NAN, 6e-6].map(|z| z + 1e-3);
    assert_heights(&parse(&listed, &NOTHING).unwrap(), &expected);
    assert_refused(&with("<DataList><Datum>1</Datum></DataList>"), "6 heights");
    assert_refused(&with(""), "found 0 in `main.xml`");
    assert_refused(&with(&"<Datum>1;2;3</Datum>".repeat(6)), "`1;2;3`");

    let folder = archive(&[
        ("land/bindata/data.bin", &binary.data),
        ("land/main.xml", binary.main().as_bytes()),
        ("__MACOSX/land/._main.xml", b"litter"),
        ("__MACOSX/land/main.xml", b"litter"),
    ]);
    expected[2] = 3e-6 + 1e-3;
    expected[4] = 5e-6 + 1e-3;
    assert_heights(&parse(&folder, &NOTHING).unwrap(), &expected);
    let two = archive(&[("a/main.xml", b""), ("b/main.xml", b"")]);
    assert_refused(&two, "a/main.xml, b/main.xml");
    assert_refused(&archive(&[("xl/workbook.xml", b"")]), "an Excel workbook");
    assert_refused(&archive(&[("a.txt", b"")]), "1 files: a.txt");

    let measured = [1e-6_f32, f32::INFINITY, 3e-6, f32::NEG_INFINITY, 5e-6, 6e-6];
    let alicona = X3p {
        z_type: "F",
        z_more: "",
        data: measured.map(f32::to_le_bytes).concat(),
        ..binary.clone()
    };
    let heights = measured.map(|z| {
        if z.is_finite() {
            f64::from(z)
        } else {
            f64::NAN
        }
    });
    assert_heights(&parse(&alicona.bytes(), &NOTHING).unwrap(), &heights);
    attack(&listed);
}

#[test]
fn bcr_has_whole_numbers_floats_and_wide_headers() {
    let header = |format: &str, more: &str| {
        let text = format!(
            "fileformat = {format}\n% a remark\nxpixels = 3\nypixels = 2\nxlength = 6000\nylength = 8000\n{more}"
        );
        format!("{text:<2048}")
    };
    let stored = [1_i16, 2, 3, i16::MAX, 5, 6];
    let metres = [0.5e-9, 1e-9, 1.5e-9, f64::NAN, 2.5e-9, 3e-9];
    let mut big = header("bcrstm", "intelmode = 0\nbit2nm = 0.5\n").into_bytes();
    big.extend(stored.iter().flat_map(|z| z.to_be_bytes()));
    let mut little = header("bcrstm", "bit2nm = 0.5\n").into_bytes();
    little.extend(stored.iter().flat_map(|z| z.to_le_bytes()));
    // Floats are in the unit that the header names, whatever `bit2nm` says.
    let floats = metres.map(|z| if z.is_nan() { 3.4e38 } else { (z * 1e6) as f32 });
    let wide_text = header("bcrf_unicode", "intelmode = 1\nbit2nm = 7\nzunit = um\n");
    let mut wide: Vec<u8> = wide_text
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    wide.extend(floats.iter().flat_map(|z| z.to_le_bytes()));
    for (bytes, kind) in [
        (&big, TopographyKind::BcrStm),
        (&little, TopographyKind::BcrStm),
        (&wide, TopographyKind::Bcrf),
    ] {
        let read = parse(bytes, &NOTHING).unwrap();
        assert_eq!(read.kind, kind);
        assert_heights(&read, &metres);
        let map = map(&read);
        assert!((map.step_x_m() - 2e-6).abs() < 1e-15 && (map.step_y_m() - 4e-6).abs() < 1e-15);
        assert_refused(&bytes[..bytes.len() - 1], "heights");
        attack(bytes);
    }
    let volts = header("bcrf", "zunit = V\n") + &" ".repeat(24);
    assert_refused(volts.as_bytes(), "unit of length");
    assert_refused(
        header("bcrf", "headersize = 99999999999\n").as_bytes(),
        "header",
    );
    assert_refused(header("bcrx", "").as_bytes(), "bcrx");
}

#[test]
fn sdf_has_all_data_types() {
    let header = |data_type: u8| {
        let mut file = b"bISO-1.0Maker     010120260000010120260000".to_vec();
        file.extend(3_u16.to_le_bytes());
        file.extend(2_u16.to_le_bytes());
        for value in [2e-6_f64, 4e-6, 1e-9, 0.0] {
            file.extend(value.to_le_bytes());
        }
        file.extend([0, data_type, 0]);
        assert_eq!(file.len(), 81);
        file
    };
    let low: [u8; 5] = [1, 2, 3, 4, 5];
    type Encode = fn(u8) -> Vec<u8>;
    let kinds: [(Encode, Option<Vec<u8>>); 8] = [
        (|z| vec![z], None),
        (|z| u16::from(z).to_le_bytes().into(), Some(vec![0xFF; 2])),
        (|z| u32::from(z).to_le_bytes().into(), Some(vec![0xFF; 4])),
        (
            |z| f32::from(z).to_le_bytes().into(),
            Some(f32::NAN.to_le_bytes().into()),
        ),
        (|z| vec![z], None),
        (|z| i16::from(z).to_le_bytes().into(), Some(vec![0, 0x80])),
        (
            |z| i32::from(z).to_le_bytes().into(),
            Some(vec![0, 0, 0, 0x80]),
        ),
        (
            |z| f64::from(z).to_le_bytes().into(),
            Some(f64::NAN.to_le_bytes().into()),
        ),
    ];
    for (data_type, (encode, missing)) in kinds.into_iter().enumerate() {
        let mut file = header(data_type as u8);
        file.extend(low.iter().flat_map(|z| encode(*z)));
        let last = if missing.is_some() { f64::NAN } else { 6e-9 };
        file.extend(missing.unwrap_or_else(|| encode(6)));
        let read = parse(&file, &NOTHING).unwrap();
        assert_eq!(read.kind, TopographyKind::SdfBinary);
        assert_heights(&read, &[1e-9, 2e-9, 3e-9, 4e-9, 5e-9, last]);
        assert_refused(&file[..file.len() - 1], "heights");
        attack(&file);
    }
    assert_refused(&header(8), "data type");
    let text = "aISO-1.0\nNumPoints = 3\nNumProfiles=2\nXscale = 2e-6\nYscale=4e-6\nZscale = 1e-6\nDataType = 3\n*\n1 2 BAD\n4 5 6\n*\n";
    let read = parse(text.as_bytes(), &NOTHING).unwrap();
    assert_heights(&read, &[1e-6, 2e-6, f64::NAN, 4e-6, 5e-6, 6e-6]);
    for (from, to, part) in [
        ("BAD", "bid", "`bid`"),
        ("5 6", "5", "6 heights"),
        ("NumPoints = 3", "NumPoints = 1000000000", "points"),
        (
            "DataType = 3",
            "DataType = 3\nCompression = 1",
            "compressed",
        ),
        ("Zscale = 1e-6", "Zscale = 0", "scale"),
        ("*", "-", "`*`"),
    ] {
        assert_refused(text.replace(from, to).as_bytes(), part);
    }
}

#[test]
fn a_written_sur_keeps_what_was_not_measured() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.sur");
    for heights in [
        vec![0.0; 6],
        vec![-1e-3, 1e-9, f64::NAN, 5e-6, 0.0, 1e-3],
        vec![9.0, 9.0 + 1e-9, 9.0 + 2e-9, 9.0, 9.0, 9.0],
    ] {
        let map = HeightMap::new(heights.clone(), 3, 1e-6, 3e-6).unwrap();
        write_sur(&path, &map).unwrap();
        let read = read_topography(&path, &NOTHING).unwrap();
        let Topography::Map(back) = &read.topography else {
            unreachable!("a map");
        };
        assert_eq!((back.rows(), back.columns()), (2, 3));
        let measured = || heights.iter().copied().filter(|z| !z.is_nan());
        let lowest = measured().fold(f64::INFINITY, f64::min);
        let range = measured().fold(f64::NEG_INFINITY, f64::max) - lowest;
        // The offset is a 32-bit float below the lowest height: that much more is divided into 2³⁰ steps.
        let step = (range + 1.2e-7 * lowest.abs()) / f64::from(1 << 30);
        for (a, b) in heights.iter().zip(back.heights_m()) {
            let near = (a - b).abs() <= step + 1e-15 * a.abs() + 1e-40;
            assert!(near || a.is_nan() && b.is_nan(), "{a} {b}");
        }
    }
    let error = write_sur(
        folder.path(),
        &HeightMap::new(vec![0.0; 4], 2, 1.0, 1.0).unwrap(),
    );
    assert!(error.unwrap_err().to_string().contains("folder"));
}
