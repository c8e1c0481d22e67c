//! Wrappers, and the catalogue itself.

use proptest::prelude::*;

use super::helpers::{read, refusal, test_file};
use crate::recording::formats::{FORMATS, FormatContent, recognise};

#[test]
fn one_file_in_a_wrapper() {
    for (file, expected) in [
        (test_file!("wrapped/run.csv.gz"), "run.csv"),
        (test_file!("wrapped/phyphox.zip"), "Raw Data.csv"),
    ] {
        let Ok(FormatContent::Inner { name, bytes }) = read(file) else {
            panic!("{}", file.0);
        };
        assert_eq!(name, expected);
        assert!(bytes.starts_with(b"t [s],V [V],xp [um]\n0.0,8.0,0.0\n"));
        assert_eq!(bytes.iter().filter(|b| **b == b'\n').count(), 13);
    }
}

#[test]
fn several_files_in_a_wrapper() {
    let Ok(FormatContent::Several(files)) = read(test_file!("wrapped/two.zip")) else {
        panic!("not several");
    };
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["b/run 1.csv", "run 2.csv"]);
}

#[test]
fn known_formats_that_are_not_read() {
    assert!(refusal(("a.parquet", b"PAR1....")).contains("to_csv"));
    let xls = [0xd0, 0xcf, 0x11, 0xe0, 0xa1, 0xb1, 0x1a, 0xe1, 0];
    assert!(refusal(("a.xls", &xls)).contains(".xlsx"));
    assert!(refusal(("a.opju", b"CPYUA 4.3")).contains("Origin"));
    assert!(recognise(b"CPYUA 4.3", "a.csv").is_none());
}

#[test]
fn text_is_no_format_of_these() {
    for text in [
        "t,V\n0,1\n",
        "-1\n0.5\n",
        "-1 2\n58 3\n",
        "",
        "#",
        "LabVIEW",
        "PK",
    ] {
        assert!(recognise(text.as_bytes(), "a.csv").is_none(), "{text:?}");
    }
    let mut ids: Vec<&str> = FORMATS.iter().map(|format| format.id()).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), FORMATS.len());
}

proptest! {
    #[test]
    fn packed_text_is_unpacked(text in "[ -~\n]{0,3000}") {
        use std::io::Write;
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(text.as_bytes()).unwrap();
        let bytes = packer.finish().unwrap();
        let expected = FormatContent::Inner { name: "a.csv".to_owned(), bytes: text.into_bytes() };
        prop_assert_eq!(read(("a.csv.gz", &bytes)), Ok(expected));
    }
}
