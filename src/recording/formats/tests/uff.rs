//! Universal files as pyuff writes them.

use super::helpers::{
    INTERVAL, clock, names, notes_say, refusal, t, table, tables, test_file, unit, v, values, xp,
};

const DRIVE: &str = "Drive Beam 0+Z";
const DISPLACEMENT: &str = "Displacement Beam 7+Z";

#[test]
fn even_functions_as_text_and_binary() {
    for file in [
        test_file!("uff/ascii_even.uff"),
        test_file!("uff/ascii_even_single.uff"),
        test_file!("uff/binary_little.uff"),
        test_file!("uff/binary_big.uff"),
    ] {
        let read = table(file);
        assert_eq!(read.columns.len(), 2, "{}", file.0);
        assert_eq!(read.columns[0].values, v(), "{}", file.0);
        assert_eq!(values(&read, DISPLACEMENT), xp(), "{}", file.0);
        assert_eq!(unit(&read, DISPLACEMENT), Some("um"));
        assert_eq!(read.clock, clock(0.0, INTERVAL));
    }
}

#[test]
fn uneven_functions_share_their_times() {
    for file in [
        test_file!("uff/ascii_uneven.uff"),
        test_file!("uff/binary_uneven.uff"),
    ] {
        let read = table(file);
        assert_eq!(read.columns.len(), 3, "{:?}", names(&read));
        assert_eq!(read.columns[1].values, v());
        assert_eq!(read.columns[2].values, xp());
        for (read, t) in values(&read, "time").iter().zip(t()) {
            // Text has six digits of the abscissa.
            assert!((read - t.powf(1.5)).abs() <= 1e-5 * t);
        }
        assert_eq!(read.clock, None);
        // pyuff states the bytes of the ordinate alone.
        if file.0.contains("binary") {
            assert!(notes_say(&read, &["header says 96 bytes", "192 are there"]));
        }
    }
}

#[test]
fn spectra_are_left_out_or_refused() {
    let read = table(test_file!("uff/with_spectrum.uff"));
    assert_eq!(read.columns[1].values, xp());
    assert!(notes_say(
        &read,
        &["Left out: FRF Beam 3+Z (complex: a spectrum)"]
    ));
    let refused = refusal(test_file!("uff/only_spectrum.uff"));
    assert!(refused.contains("no time histories"), "{refused}");
}

/// Found by fuzzing: a function whose header gives no number of values made a table without rows.
#[test]
fn functions_without_values_are_left_out() {
    let read = tables(test_file!("uff/no_values.uff"));
    assert!(read.iter().all(|table| table.rows() > 0));
    assert!(
        read.iter()
            .all(|table| notes_say(table, &["Left out", "no values"]))
    );
}

#[test]
fn units_of_the_file() {
    let read = table(test_file!("uff/units_164.uff"));
    let metres: Vec<f64> = xp().iter().map(|x| x / 1000.0).collect();
    assert_eq!(read.columns[0].values, metres);
    assert_eq!(read.columns[0].unit.as_deref(), Some("m"));
    assert!(notes_say(&read, &["divided by 1000", "MM: mm"]));
}

#[test]
fn traps_of_other_writers() {
    let (_, text) = test_file!("uff/ascii_even.uff");
    let text = std::str::from_utf8(text).unwrap();
    // Numbers that touch, D exponents, a delimiter with spaces, Windows line ends.
    let edited = text
        .replace("-8.00000000000e+00  -8", "-8.00000000000D+00-8")
        .replace("    -1\n", "    -1          \n")
        .replace('\n', "\r\n");
    assert_ne!(edited.replace("\r\n", "\n"), text);
    let read = table(("a.unv", edited.as_bytes()));
    assert_eq!(read.columns[0].values, v());
    assert_eq!(read.columns[1].values, xp());
    // A newline between binary data and the delimiter.
    let (_, bytes) = test_file!("uff/binary_little.uff");
    let at = bytes
        .windows(13)
        .position(|w| w == b"    -1\n    -1")
        .unwrap();
    let edited = [&bytes[..at], b"\n", &bytes[at..]].concat();
    let read = table(("a.uff", &edited));
    assert_eq!(read.columns[1].values, xp());
    // Cut in the middle of the data.
    assert!(refusal(("a.uff", &bytes[..at - 20])).contains("ends at byte"));
    assert!(refusal(("a.uff", &text.as_bytes()[..1100])).contains("ends at byte"));
    let first = text.replacen("8.00000000000e+00", "8.00000000000x+00", 1);
    let error = refusal(("a.uff", first.as_bytes()));
    assert!(
        error.contains("line 14") && error.contains("not a number"),
        "{error}"
    );
    // A file without functions.
    assert!(refusal(("a.uff", b"    -1\n    15\n 1 2\n    -1\n")).contains("dataset 58"));
    assert_eq!(
        tables(test_file!("uff/ascii_even.uff"))[0].columns[0].name,
        DRIVE
    );
}
