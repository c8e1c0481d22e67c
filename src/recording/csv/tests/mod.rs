#[cfg(test)]
pub(super) mod properties;
mod scopes;
mod time_properties;
mod times;
mod variants;

use crate::recording::csv::*;
use crate::recording::{Channel, ImportError, Recording, WarningKind};

pub(super) fn auto(text: &str) -> Recording {
    import_bytes_auto("test.csv", text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn fails(bytes: &[u8]) -> ImportError {
    import_bytes_auto("test.csv", bytes).unwrap_err()
}

fn kinds(recording: &Recording) -> Vec<WarningKind> {
    recording.warnings.iter().map(|w| w.kind).collect()
}

pub(super) const PLAIN: &str =
    "t [s],V [V],xp [um],xc [um]\n0,8,-58,1\n2e-5,8,-57.5,1.5\n4e-5,-8,0.25,2\n";

pub(super) fn same(a: &Recording, b: &Recording) {
    assert_eq!(a.time, b.time);
    assert_eq!(a.voltage, b.voltage);
    assert_eq!(a.proof_mass, b.proof_mass);
    assert_eq!(a.cantilever, b.cantilever);
}

#[test]
fn reads_the_plain_form() {
    let r = auto(PLAIN);
    assert_eq!(r.time, [0.0, 2e-5, 4e-5]);
    assert_eq!(r.voltage.as_deref(), Some(&[8.0, 8.0, -8.0][..]));
    assert_eq!(r.proof_mass, [-58e-6, -57.5e-6, 0.25e-6]);
    assert_eq!(r.cantilever.as_deref(), Some(&[1e-6, 1.5e-6, 2e-6][..]));
    assert!(r.warnings.is_empty(), "{:?}", r.warnings);
    assert_eq!(
        r.sha256.as_deref().map(str::len),
        Some(64),
        "the hash of the bytes is kept"
    );
    assert!(!preview_bytes("x", PLAIN.as_bytes()).unwrap().needs_dialog());
}

#[test]
fn equivalent_forms_give_the_same_recording() {
    let plain = auto(PLAIN);
    for text in [
        // byte-order mark, CRLF, comments, blank lines
        "\u{feff}# made by hand\r\n% and\r\n// more\r\n\r\nt [s],V [V],xp [um],xc [um]\r\n0,8,-58,1\r\n2e-5,8,-57.5,1.5\r\n4e-5,-8,0.25,2\r\n",
        // semicolons, decimal commas, other units and order
        "xc (mm);xp [nm];t / ms;V/mV\n0,001;-58000;0;8000\n0,0015;-57500;0,02;8000\n0,002;250;0,04;-8000\n",
        // tabs, micro sign, other names, capitals
        "TIME [us]\tProof Mass (\u{b5}m)\tCantilever [\u{3bc}m]\tVoltage [V]\n0\t-58\t1\t8\n20\t-57.5\t1.5\t8\n40\t0.25\t2\t-8\n",
        // tabs with decimal commas
        "t [s]\tV [V]\txp [um]\txc [um]\n0\t8\t-58\t1\n0,00002\t8\t-57,5\t1,5\n0,00004\t-8\t0,25\t2\n",
        // quoted header with a comma, quoted numbers with decimal commas
        "\"t, measured [s]\",\"V [V]\",\"xp [um]\",\"xc [um]\"\n\"0\",8,-58,1\n\"0,00002\",8,\"-57,5\",1.5\n4e-5,-8,.25,2\n",
        // a commented header, as numpy writes it; spaces
        "# t [s], V [V], xp [um], xc [um]\n 0.0 , 8 ,-58.0 , 1\n2e-05, 8.0, -5.75e1,1.5\n 4.0E-5,-8,+0.25,2\n",
        // names above units, free text above
        "Recorder,5\nmade on Monday\nt,V,xp,xc\ns,V,um,um\n0,8,-58,1\n2e-5,8,-57.5,1.5\n4e-5,-8,0.25,2\n",
        // old line ends
        "t [s],V [V],xp [um],xc [um]\r0,8,-58,1\r2e-5,8,-57.5,1.5\r4e-5,-8,0.25,2\r",
        // trailing delimiter, empty lines, comments between rows, no last line end
        "t [s],V [V],xp [um],xc [um],\n0,8,-58,1,\n\n2e-5,8,-57.5,1.5,\n# pause\n,,,,\n4e-5,-8,0.25,2,",
        // unneeded columns
        "n,t [s],V [V],rate [Hz],xp [um],xc [um],remark\n1,0,8,5,-58,1,a\n2,2e-5,8,5,-57.5,1.5,\"b,c\"\n3,4e-5,-8,5,0.25,2,d\n",
    ] {
        same(&auto(text), &plain);
    }
}

#[test]
fn x_alone_is_the_proof_mass() {
    let r = auto("t [s],x [m]\n0,47.7\n0.1,47.6\n0.2,47\n");
    assert_eq!(r.proof_mass, [47.7, 47.6, 47.0]);
    assert!(r.voltage.is_none() && r.cantilever.is_none() && r.warnings.is_empty());
}

#[test]
fn names_and_units_written_otherwise() {
    for header in [
        "time_ms,tip_um",
        "t/ms,x/um",
        "Zeit (ms),Position (\u{b5}m)",
        "t (MS),X (microns)",
        "t [ms],xp [um] (laser)",
    ] {
        let r = auto(&format!("{header}\n0,1\n1,2\n2,3\n"));
        assert_eq!((r.time[1], r.proof_mass[1]), (1e-3, 2e-6), "{header}");
    }
}

#[test]
fn bad_cells_are_counted_and_become_nan() {
    let r = auto(
        "t [s],V [V],xp [um]\n0,1,1\n1e-5,,2\n2e-5,x,n/a\n3e-5,1,\n4e-5,1,1e999\n5e-5,1\n6e-5,1,5\n",
    );
    assert_eq!(r.len(), 7);
    assert_eq!(r.proof_mass.iter().filter(|x| x.is_nan()).count(), 4);
    let warning = |symbol: &str| {
        r.warnings
            .iter()
            .find(|w| w.message.contains(&format!("of {symbol} ")))
            .unwrap()
    };
    assert_eq!(
        (warning("xp").count, warning("xp").first_line),
        (4, Some(4))
    );
    assert_eq!((warning("V").count, warning("V").first_line), (2, Some(3)));
    assert_eq!(
        warning("xp").message,
        "4 cells of xp are not numbers (first in line 4); they are left out of comparisons"
    );
}

#[test]
fn rows_without_increasing_time_are_dropped_and_counted() {
    let text = "t [ms],x [m]\n0,0\n1,1\n1,2\n0.5,3\n2,4\n,5\n3,6\n900,7\n4,8\n5,9\n6,10\n";
    // Three of eleven rows are more than are lost without asking.
    let error = fails(text.as_bytes()).to_string();
    assert!(
        error.contains("3 of 11 rows") && error.contains("--accept-losses"),
        "{error}"
    );
    let choices = ReadingChoices {
        accept_losses: true,
        ..ReadingChoices::default()
    };
    let r = import_bytes_chosen("test.csv", text.as_bytes(), &choices).unwrap();
    // The row at 0.5 ms stood out of order.
    assert_eq!(r.proof_mass, [0.0, 3.0, 1.0, 4.0, 6.0, 8.0, 9.0, 10.0]);
    let find = |kind| r.warnings.iter().find(|w| w.kind == kind).unwrap();
    let back = find(WarningKind::TimeNotIncreasing);
    assert_eq!((back.count, back.first_line), (2, Some(4)));
    assert_eq!(find(WarningKind::RowsReordered).count, 1);
    assert_eq!(find(WarningKind::TimeNotANumber).count, 1);
    assert!(
        find(WarningKind::TimeNotANumber)
            .message
            .contains("1 row has no time that is a number (first in line 7) and is left out")
    );
    let error = fails(b"t [s],x [m]\n5,0\n4,0\n6,0\n3,0\n5.5,1\n2,0\n4.5,0\n1,0\n");
    assert!(
        matches!(
            error,
            ImportError::TimeBackwards {
                line: 3,
                column: 1,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_cut_last_line_is_dropped() {
    for tail in ["4e-5", "4e-5,", "4e-5,0.", "4e-5,1.0e-", "4e-5,1.0"] {
        let mut text = String::from("t [s],xp [um]\n");
        for i in 0..10 {
            text.push_str(&format!("{i}e-6,1.0{i}\n"));
        }
        text.push_str(tail);
        let r = auto(&text);
        assert_eq!(r.len(), 10, "{tail}");
        assert_eq!(kinds(&r), [WarningKind::CutLastLine], "{tail}");
        assert_eq!(r.warnings[0].first_line, Some(12));
    }
    assert!(auto("t [s],x [m]\n0,1\n1,2\n0.2e1,3").warnings.is_empty());
}

#[test]
fn gaps_and_unlikely_units_give_warnings() {
    let mut text = String::from("t [s],xp [um]\n");
    for i in 0..50 {
        let t = i + if i > 20 { 30 } else { 0 };
        text.push_str(&format!("{t}e-5,{i}\n"));
    }
    let r = auto(&text);
    assert_eq!(kinds(&r), [WarningKind::Gap]);
    assert_eq!(r.warnings[0].first_line, Some(22));
    assert_eq!(r.gaps().len(), 1);
    assert_eq!(r.value_at(Channel::ProofMass, 30e-5), None);
    // Milliseconds under a header that says seconds.
    let r = auto("t [s],xp [um]\n0,1\n0.02,2\n0.04,3\n");
    assert_eq!(kinds(&r), [WarningKind::UnlikelyTimeUnit]);
}

#[test]
fn headers_with_doubts() {
    for header in [
        "t [s],xp [um],xp [um]",
        "t [s],xp [nm],xp [um]",
        "t [s],x [um],xp [um]",
    ] {
        // Two columns of one quantity, whatever their units or names: only a person knows.
        let text = format!("{header}\n0,1,2\n1e-5,3,4\n");
        let error = fails(text.as_bytes()).to_string();
        assert!(
            error.contains("columns 2 (") && error.contains("and 3 ("),
            "{error}"
        );
        assert!(error.contains("--column xp="), "{error}");
        let choices = ReadingChoices {
            columns: vec![("xp".into(), "3".into())],
            ..ReadingChoices::default()
        };
        let r = import_bytes_chosen("x", text.as_bytes(), &choices).unwrap();
        assert_eq!(r.proof_mass[0], 2e-6);
    }
    for text in ["0,8,1\n1e-5,8,2\n", "0\t1e-6\n1e-5\t2e-6\n"] {
        let error = fails(text.as_bytes()).to_string();
        assert!(
            error.contains("no header") && error.contains("--column t=1"),
            "{error}"
        );
    }
    let choices = ReadingChoices {
        columns: vec![
            ("t".into(), "1".into()),
            ("V".into(), "2".into()),
            ("xp".into(), "3".into()),
        ],
        units: vec![("xp".into(), "um".into())],
        ..ReadingChoices::default()
    };
    let r = import_bytes_chosen("x", b"0,8,1\n1e-5,8,2\n", &choices).unwrap();
    assert_eq!(
        (r.proof_mass[0], r.voltage.as_ref().unwrap()[0]),
        (1e-6, 8.0)
    );
    let r = auto("t,x\n0,1e-6\n1e-5,2e-6\n");
    assert_eq!(r.proof_mass[1], 2e-6);
    assert_eq!(
        kinds(&r),
        [WarningKind::AssumedUnit, WarningKind::AssumedUnit]
    );
    let r = auto("clock [ms],laser [um]\n0,1\n0.01,2\n");
    assert_eq!(
        kinds(&r),
        [WarningKind::GuessedColumn, WarningKind::GuessedColumn]
    );
    let r = auto("t [s],V [A],xp [um]\n0,1,1\n1e-5,1,2\n");
    assert_eq!(
        (kinds(&r), r.voltage),
        (vec![WarningKind::IgnoredColumn], None)
    );
    assert!(
        preview_bytes("x", b"t,x\n0,1e-6\n1,2e-6\n")
            .unwrap()
            .needs_dialog()
    );
}

#[test]
fn each_failure_names_place_and_remedy() {
    let cases: [(&[u8], &str); 12] = [
        (b"", "the file is empty"),
        (b"\n \n", "the file is empty"),
        (b"\xff\xfet\0,\0", "line 1: no rows of numbers"),
        (
            b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x01\0\0\0\x01\x08\x06",
            "line 3: binary data",
        ),
        (
            b"t [s],x [m]\n0,1\n1,2\n\0\0\0\0\n2,3\n",
            "line 4: binary data (byte 0x00 at offset 20)",
        ),
        (b"hello\nworld\n", "line 1: no rows of numbers"),
        (
            b"\na [Hz],x [m]\n0,1\n1,2\n",
            "line 2: no time column among \"a [Hz]\", \"x [m]\"",
        ),
        (b"t [s],F [N]\n0,1\n1,2\n", "no position column"),
        (
            b"t [kg],x [m]\n0,1\n1,2\n",
            "line 1, column 1: \"kg\" is not a unit for time; write s, ms or us",
        ),
        (
            b"t [s],V [V],x [m]\n0,1,\n1,2,\n",
            "line 2, column 3: xp has no cell that is a number",
        ),
        (
            b"t [s],x [m]\n0,1\n",
            "line 2, column 1: only 1 usable rows",
        ),
        (
            b"t [s],x [m]\n0,0,1,5\n0,1,1,6\n0,2,1,7\n",
            "line 2: rows have 4 cells but the header names 2",
        ),
    ];
    for (bytes, part) in cases {
        let message = fails(bytes).to_string();
        assert!(message.starts_with("test.csv"), "{message}");
        assert!(message.contains(part), "{message}\nlacks {part}");
        assert!(
            message.contains(';') || message.contains("save it"),
            "no remedy: {message}"
        );
    }
}

#[test]
fn paths_that_are_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let gone = folder.path().join("gone.csv");
    assert!(matches!(
        import_auto(folder.path(), None),
        Err(ImportError::IsDirectory { .. })
    ));
    assert!(matches!(
        import_auto(&gone, None),
        Err(ImportError::NotFound { .. })
    ));
    assert!(matches!(preview(&gone), Err(ImportError::NotFound { .. })));
    let file = folder.path().join("here.csv");
    std::fs::write(&file, PLAIN).unwrap();
    let r = import_auto(&file, Some(&|_| true)).unwrap();
    assert_eq!(
        (r.name.as_str(), r.path.as_deref()),
        ("here.csv", Some(file.as_path()))
    );
    assert_eq!(preview(&file).unwrap().rows.len(), 3);
    let stopped = import_auto(&file, Some(&|_| false)).unwrap_err();
    assert!(matches!(stopped, ImportError::Cancelled { .. }));
}

#[test]
fn settings_decide_and_are_remembered() {
    let mut settings = preview_bytes("x", PLAIN.as_bytes()).unwrap().settings;
    assert_eq!(settings.skip_lines, 1);
    settings.xp_scale = -2.0;
    settings.xp_offset = 1e-6;
    settings.time_offset = 1.0;
    settings.voltage = None;
    settings.cantilever = Some(ColumnChoice::new(2, "mm"));
    let text = toml::to_string(&settings).unwrap();
    let settings: ImportSettings = toml::from_str(&text).unwrap();
    let r = import_bytes("x", PLAIN.as_bytes(), &settings).unwrap();
    assert_eq!(r.time[0], 1.0);
    assert_eq!(r.proof_mass[0], -58e-6 * -2.0 + 1e-6);
    assert_eq!(r.cantilever.as_ref().unwrap()[0], -58e-3);
    assert!(r.voltage.is_none());

    settings_fail(&settings, |s| s.xp_scale = f64::NAN, "xp_scale is NaN");
    settings_fail(&settings, |s| s.time = None, "no time column");
    settings_fail(
        &settings,
        |s| s.proof_mass = Some(ColumnChoice::new(2, "V")),
        "xp is in \"V\"",
    );
    settings_fail(
        &settings,
        |s| s.proof_mass = Some(ColumnChoice::new(usize::MAX, "um")),
        "xp is to be read from column 18446744073709551615, but there are only 4 columns",
    );
    settings_fail(
        &settings,
        |s| s.skip_lines = usize::MAX,
        "only 0 usable rows",
    );
}

fn settings_fail(settings: &ImportSettings, change: impl Fn(&mut ImportSettings), part: &str) {
    let mut settings = settings.clone();
    change(&mut settings);
    let error = import_bytes("x", PLAIN.as_bytes(), &settings)
        .unwrap_err()
        .to_string();
    assert!(error.contains(part), "{error}");
}

#[test]
fn many_pieces_keep_rows_and_lines_in_order() {
    let rows = 300_000;
    let mut text = String::from("t [s];xp [um]\n");
    for i in 0..rows {
        use std::fmt::Write;
        if i == 250_000 {
            text.push_str("# pause\n");
        }
        let bad = if i == 260_000 { "?" } else { "" };
        writeln!(
            text,
            "{:.6};{}{bad}",
            f64::from(i) * 1e-5,
            f64::from(i) * 0.5
        )
        .unwrap();
    }
    let r = auto(&text);
    assert_eq!(r.len(), rows as usize);
    assert!(
        (0..rows as usize)
            .all(|i| i == 260_000 || (r.proof_mass[i] - i as f64 * 0.5e-6).abs() < 1e-12)
    );
    assert_eq!(r.warnings[0].first_line, Some(260_000 + 3));
}

/// A file whose rows are whole numbers for long shows its decimal comma late.
#[test]
fn a_late_decimal_comma_is_found() {
    let mut text = String::from("t [us];xp [um]\n");
    for i in 0..60_000 {
        text.push_str(&format!("{i};{}\n", if i < 40_000 { "0" } else { "0,5" }));
    }
    assert_eq!(auto(&text).proof_mass[59_999], 0.5e-6);
}
