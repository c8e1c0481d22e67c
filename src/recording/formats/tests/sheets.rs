//! Workbooks as openpyxl writes them.

use super::helpers::{column, names, notes_say, tables, test_file, unit, v, values, xp};

#[test]
fn sheets_headers_dates_and_text() {
    let read = tables(test_file!("xlsx/sheets.xlsx"));
    let of: Vec<&str> = read.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(of, ["run", "second", "settings"]);
    let run = &read[0];
    assert_eq!(names(run), ["t", "V", "xp", "when", "german"]);
    assert_eq!((unit(run, "t"), unit(run, "xp")), (Some("s"), Some("um")));
    assert_eq!(values(run, "V"), v());
    assert_eq!(values(run, "german"), xp());
    let displacement = values(run, "xp");
    assert!(displacement[3].is_nan());
    assert_eq!(displacement[4..], xp()[4..]);
    // 2026-01-01 is day 46023.
    let when = column(run, "when");
    assert_eq!(when.unit.as_deref(), Some("d"));
    assert!((when.values[6] - (46_023.5 + 6.0 / 86400.0)).abs() < 1e-9);
    for words in [
        &["\"xp\": 1 cells", "OL", "row 7"][..],
        &["12 numbers are stored as text", "decimal comma"],
        &["\"when\"", "86400 s since 1899-12-30"],
        &["Text above the table: Made up"],
        &["Sheets without a table of numbers: empty"],
    ] {
        assert!(notes_say(run, words), "{words:?}: {:?}", run.notes);
    }
    assert_eq!(names(&read[1]), ["Column A", "Column B"]);
    assert_eq!(values(&read[1], "Column B"), [0.0, 1.0, 4.0]);
    // Settings above the table are no rows of it.
    assert_eq!(names(&read[2]), ["t [s]", "x"]);
    assert_eq!(values(&read[2], "x"), [0.5, 1.5, 2.5]);
    assert!(notes_say(&read[2], &["\"x\": 2 numbers above the table"]));
}
