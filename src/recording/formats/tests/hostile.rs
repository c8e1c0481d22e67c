//! Cut and changed files: an error or tables, never a panic, and no memory that the bytes do not
//! justify.

use proptest::prelude::*;

use super::helpers::test_file;
use crate::recording::formats::{FORMATS, FormatContent};

const LVM: &[u8] = b"LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nMulti_Headings\tYes\n\
X_Columns\tMulti\n***End_of_Header***\t\n\t\nChannels\t2\nDate\t2026/01/01\t\t2026/01/01\nTime\t12:00:00,5\n\
Y_Unit_Label\tV\t\tm\nX0\t0,0\t\t0,0\nDelta_X\t0,5\t\t0,5\n***End_of_Header***\t\n\
X_Value\tV\tX_Value\tx\tComment\n0,0\t1,5\t0,0\t2,5\tnote\n0,5\t3,5\t0,5\t4,5\n\nChannels\t2\n\
***End_of_Header***\nX_Value\tV\tX_Value\tx\n0,0\t1,5\t0,0\t2,5\n0,5\t3,5\n";

const FILES: [(&str, &[u8]); 28] = [
    ("joined.lvm", LVM),
    test_file!("hdf5/attributes.h5"),
    test_file!("hdf5/compound.h5"),
    test_file!("hdf5/latest.h5"),
    test_file!("hdf5/lzf.h5"),
    test_file!("hdf5/matlab_73.mat"),
    test_file!("hdf5/plain.h5"),
    test_file!("mat5/columns_packed.mat"),
    test_file!("mat5/nested.mat"),
    test_file!("mat5/rows.mat"),
    test_file!("mat5/struct_array.mat"),
    test_file!("mat5/version_4.mat"),
    test_file!("npy/columns_f8.npy"),
    test_file!("npy/structured.npy"),
    test_file!("npz/packed.npz"),
    test_file!("npz/plain.npz"),
    test_file!("tdms/scaled.tdms"),
    test_file!("tdms/segments.tdms"),
    test_file!("uff/ascii_uneven.uff"),
    test_file!("uff/binary_uneven.uff"),
    test_file!("uff/units_164.uff"),
    test_file!("uff/with_spectrum.uff"),
    test_file!("wav/float.wav"),
    test_file!("wav/pcm24.wav"),
    test_file!("wav/pcm8.wav"),
    test_file!("wrapped/run.csv.gz"),
    test_file!("wrapped/two.zip"),
    test_file!("xlsx/sheets.xlsx"),
];

/// Reads by every format that takes the bytes for its own.
fn read_all(name: &str, bytes: &[u8]) {
    for format in FORMATS
        .iter()
        .filter(|format| format.recognises(bytes, name))
    {
        match format.read(name, bytes) {
            Ok(FormatContent::Tables(tables)) => {
                assert!(!tables.is_empty());
                for table in tables {
                    let rows = table.rows();
                    assert!(rows > 0);
                    assert!(table.columns.iter().all(|c| c.values.len() == rows));
                }
            }
            Ok(_) => {}
            Err(error) => assert!(error.to_string().contains(name)),
        }
    }
}

/// An archive with one of its files changed.
fn repacked(bytes: &[u8], which: prop::sample::Index, change: impl Fn(&mut Vec<u8>)) -> Vec<u8> {
    use std::io::{Cursor, Read, Write};
    let mut from = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let which = which.index(from.len());
    for index in 0..from.len() {
        let mut entry = from.by_index(index).unwrap();
        let mut part = Vec::new();
        entry.read_to_end(&mut part).unwrap();
        if index == which {
            change(&mut part);
        }
        to.start_file(
            entry.name().unwrap(),
            zip::write::SimpleFileOptions::default(),
        )
        .unwrap();
        to.write_all(&part).unwrap();
    }
    to.finish().unwrap().into_inner()
}

#[test]
fn every_cut_of_the_small_files() {
    for (name, bytes) in FILES {
        let step = 1 + bytes.len() / 400;
        for end in (0..bytes.len()).step_by(step) {
            read_all(name, &bytes[..end]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]
    #[test]
    fn changed_bytes(
        which in 0..FILES.len(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in proptest::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let (name, bytes) = FILES[which];
        let mut bytes = bytes.to_vec();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        read_all(name, &bytes);
    }

    /// Checksums hide the inside of an archive: its parts are changed before they are packed.
    #[test]
    fn changed_sheets(
        part in any::<prop::sample::Index>(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let (name, bytes) = test_file!("xlsx/sheets.xlsx");
        let bytes = repacked(bytes, part, |part| {
            for (at, value) in &changes {
                let at = at.index(part.len());
                part[at] = *value;
            }
        });
        read_all(name, &bytes);
    }

    /// Lengths in a file are four or eight bytes: put large ones anywhere.
    #[test]
    fn large_lengths(
        which in 0..FILES.len(),
        at in any::<prop::sample::Index>(),
        value in prop::sample::select(vec![u32::MAX, 0x7fff_ffff, 0x8000_0000, 0x00ff_ffff, 0]),
        is_big in any::<bool>(),
    ) {
        let (name, bytes) = FILES[which];
        let mut bytes = bytes.to_vec();
        let at = at.index(bytes.len().saturating_sub(4).max(1));
        let value = if is_big { value.to_be_bytes() } else { value.to_le_bytes() };
        for (to, from) in bytes.iter_mut().skip(at).zip(value) {
            *to = from;
        }
        read_all(name, &bytes);
    }
}
