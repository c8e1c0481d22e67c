//! LVM files of the shapes that LabVIEW writes, after the samples of `lvm_read`.

use super::helpers::{clock, names, notes_say, refusal, table, tables, unit, values};

/// A file of the headers and rows given; `file` are lines of the file's header.
fn lvm(file: &[&str], rest: &[&str]) -> Vec<u8> {
    let mut lines = vec![
        "LabVIEW Measurement\t",
        "Writer_Version\t2",
        "Reader_Version\t2",
    ];
    lines.extend(file);
    lines.push("***End_of_Header***\t");
    lines.extend(rest);
    lines.join("\r\n").into_bytes()
}

const POINT: &str = "Decimal_Separator\t.";

#[test]
fn no_times_decimal_comma() {
    let rows = ["\t0,914018\t1,204792", "\t0,537321\t1,208403"];
    let segment = [
        "\t",
        "Channels\t2\t\t",
        "Samples\t2\t2\t",
        "Y_Unit_Label\tNewtons\tm/s^2\t",
        "X_Dimension\tTime\tTime\t",
        "X0\t0,5000000000000000E+0\t0,5000000000000000E+0\t",
        "Delta_X\t3,906250E-5\t3,906250E-5\t",
        "***End_of_Header***\t\t\t",
        "X_Value\tExcitation (Trigger)\tResponse (Trigger)\tComment",
        rows[0],
        rows[1],
        "",
    ];
    let bytes = lvm(
        &["Separator\tTab", "Decimal_Separator\t,", "X_Columns\tNo"],
        &segment,
    );
    let read = table(("short.lvm", &bytes));
    assert_eq!(names(&read), ["Excitation (Trigger)", "Response (Trigger)"]);
    assert_eq!(values(&read, "Response (Trigger)"), [1.204_792, 1.208_403]);
    assert_eq!(unit(&read, "Excitation (Trigger)"), Some("Newtons"));
    assert_eq!(read.clock, clock(0.5, 3.906_25e-5));
}

#[test]
fn one_time_column_with_empty_fields_and_comments() {
    let segment = [
        "",
        "Notes\tX values guaranteed valid only for Ai0",
        "Channels\t3",
        "Samples\t3\t0\t3",
        "X_Dimension\tTime\tTime\tTime",
        "X0\t0.0\t0.0\t0.0",
        "Delta_X\t0.001\t1.0\t0.001",
        "***End_of_Header***",
        "X_Value\tAi0\tUntitled\tTemperatura (\u{b0}C)\tComment",
        "0.000000\t-0.5\t\t7.25\tLOST COMMUNICATION",
        "0.001000\tbroken\t\t7.50",
        "0.002000\t-0.75\t\t7.75\tOK",
    ];
    let bytes = lvm(&[POINT, "X_Columns\tOne"], &segment);
    // Once more as a Western Windows writes it.
    let latin: Vec<u8> = String::from_utf8(bytes.clone())
        .unwrap()
        .chars()
        .map(|c| c as u8)
        .collect();
    for bytes in [bytes, latin] {
        let read = table(("a.lvm", &bytes));
        assert_eq!(
            names(&read),
            ["X_Value", "Ai0", "Untitled", "Temperatura (\u{b0}C)"]
        );
        assert_eq!(values(&read, "X_Value"), [0.0, 0.001, 0.002]);
        assert_eq!(unit(&read, "X_Value"), Some("s"));
        assert!(values(&read, "Untitled").iter().all(|v| v.is_nan()));
        assert!(values(&read, "Ai0")[1].is_nan());
        assert!(notes_say(
            &read,
            &["1 cells are no numbers", "broken", "line 17, column 2"]
        ));
        assert!(notes_say(
            &read,
            &["2 rows have a comment", "LOST COMMUNICATION"]
        ));
        assert!(notes_say(&read, &["valid only for Ai0"]));
    }
}

#[test]
fn a_time_column_for_each_channel() {
    let header = [
        "\t",
        "Channels\t2\t\t\t",
        "Y_Unit_Label\tVolts\t\tg\t",
        "X0\t0.0\t\t0.0\t",
        "Delta_X\t0.5\t\t0.5\t",
        "***End_of_Header***\t\t\t\t",
        "X_Value\tVoltage\tX_Value\tAcceleration\tComment",
    ];
    let same = ["0.0\t1\t0.0\t2", "0.5\t3\t0.5\t4", "", ""];
    let bytes = lvm(&[POINT, "X_Columns\tMulti"], &[&header[..], &same].concat());
    let read = table(("a.lvm", &bytes));
    assert_eq!(names(&read), ["X_Value", "Voltage", "Acceleration"]);
    assert_eq!(unit(&read, "Acceleration"), Some("g"));
    assert_eq!(values(&read, "Acceleration"), [2.0, 4.0]);
    // Different rates, and the header does not say the decimal mark.
    let differ = ["0.0\t1\t0.0\t2", "0.5\t3\t1.0\t4", "1.0\t5\t\t"];
    let bytes = lvm(&["X_Columns\tMulti"], &[&header[..], &differ].concat());
    let read = tables(("a.lvm", &bytes));
    assert_eq!(values(&read[0], "Voltage"), [1.0, 3.0, 5.0]);
    assert_eq!(values(&read[1], "X_Value"), [0.0, 1.0]);
    assert_eq!(values(&read[1], "Acceleration"), [2.0, 4.0]);
    assert!(notes_say(&read[1], &["decimal mark", "\".\""]));
}

/// A segment without times, of two samples.
fn segment(time: &str, start: &str) -> Vec<String> {
    let lines = [
        "\t".to_owned(),
        "Channels\t1\t".to_owned(),
        "Date\t2026/02/28\t".to_owned(),
        format!("Time\t{time}\t"),
        format!("X0\t{start}\t"),
        "Delta_X\t0.5\t".to_owned(),
        "***End_of_Header***\t\t".to_owned(),
        "X_Value\tV\tComment".to_owned(),
        "\t1".to_owned(),
        "\t2".to_owned(),
    ];
    lines.to_vec()
}

#[test]
fn segments_that_go_on_are_joined() {
    let joined = |first: [&str; 2], second: [&str; 2]| {
        let lines = [segment(first[0], first[1]), segment(second[0], second[1])].concat();
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        tables((
            "a.lvm",
            &lvm(&[POINT, "Multi_Headings\tYes", "X_Columns\tNo"], &lines),
        ))
    };
    let by_start = joined(["12:00:00", "0.0"], ["12:00:00", "1.0"]);
    assert_eq!(values(&by_start[0], "V"), [1.0, 2.0, 1.0, 2.0]);
    assert!(notes_say(&by_start[0], &["2 segments", "joined"]));
    let by_stamp = joined(["12:00:00.25", "0.0"], ["12:00:01.25", "0.0"]);
    assert_eq!(by_stamp.len(), 1);
    let apart = joined(["12:00:00", "0.0"], ["12:00:09", "0.0"]);
    assert_eq!(apart.len(), 2);
    assert_eq!(values(&apart[1], "V"), [1.0, 2.0]);
}

#[test]
fn what_is_no_recording() {
    let spectrum: Vec<String> = segment("12:00:00", "0.0");
    let mut lines: Vec<&str> = spectrum.iter().map(String::as_str).collect();
    lines.insert(2, "X_Dimension\tFrequency\t");
    let bytes = lvm(&[POINT, "X_Columns\tNo"], &lines);
    assert!(refusal(("a.lvm", &bytes)).contains("spectrum"));
    assert!(refusal(("a.lvm", b"LabVIEW Measurement\t\nDate\t2026")).contains("header"));
    let bytes = lvm(&[POINT], &["", "Channels\t1"]);
    assert!(refusal(("a.lvm", &bytes)).contains("ends at byte"));
}
