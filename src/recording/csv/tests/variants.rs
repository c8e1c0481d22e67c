//! The forms in which laboratories have their recordings, on small texts made here: each must give the
//! numbers of the plain form, or ask, and say what it did.

use super::{auto, fails, kinds, same};
use crate::recording::csv::*;
use crate::recording::{Recording, WarningKind};

/// Rows of t [us], V [V], xp [nm].
fn rows() -> Vec<(u32, i32, i32)> {
    (0..40)
        .map(|i: u32| {
            let x = (f64::from(i) * 0.4).sin() * 58_052.0;
            (250 * i, if i % 10 < 5 { 8 } else { -8 }, x as i32)
        })
        .collect()
}

/// The plain form of [`rows`].
fn plain() -> Recording {
    let mut text = String::from("t [us],V [V],xp [nm]\n");
    for (t, v, x) in rows() {
        text += &format!("{t},{v},{x}\n");
    }
    auto(&text)
}

/// A header and the rows as `line` writes them.
fn text(header: &str, line: impl Fn(u32, i32, i32) -> String) -> String {
    let lines: Vec<String> = rows().iter().map(|(t, v, x)| line(*t, *v, *x)).collect();
    format!("{header}\n{}\n", lines.join("\n"))
}

/// A whole number with marks between thousands.
fn grouped(n: i32, mark: &str) -> String {
    let digits = n.unsigned_abs().to_string();
    let sign = if n < 0 { "-" } else { "" };
    match digits.len() {
        0..=3 => format!("{sign}{digits}"),
        n => format!("{sign}{}{mark}{}", &digits[..n - 3], &digits[n - 3..]),
    }
}

fn chosen(text: &str, choices: &ReadingChoices) -> Recording {
    import_bytes_chosen("x", text.as_bytes(), choices).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn asks(text: &str, words: &[&str]) {
    let error = fails(text.as_bytes()).to_string();
    for word in words {
        assert!(error.contains(word), "{error}\nlacks {word}");
    }
    let preview = preview_bytes("x", text.as_bytes()).unwrap();
    assert!(preview.needs_dialog(), "{text}");
}

fn pair(a: &str, b: &str) -> (String, String) {
    (a.to_owned(), b.to_owned())
}

#[test]
fn delimiters_of_all_kinds() {
    let expected = plain();
    for text in [
        text("t [us]|V [V]|xp [nm]", |t, v, x| format!("{t}|{v}|{x}")),
        text("t[us] V[V] xp[nm]", |t, v, x| format!("{t} {v}  {x}")),
        text("  t [us]  V [V]   xp [nm]", |t, v, x| {
            format!("{t:>8} {v:>6} {x:>10}")
        }),
        text("   time us  volts V     tip nm", |t, v, x| {
            format!("{t:>10} {v:>8} {x:>10}")
        }),
        text("# t [us] V [V] xp [nm]", |t, v, x| {
            format!("{t}.0e0 {v}.0D+00 {x}.0d0")
        }),
    ] {
        same(&auto(&text), &expected);
    }
    let labels = text("boot", |t, v, x| format!("t:{t},V:{v},xp:{x}"));
    asks(&labels, &["--unit t="]);
    let choices = ReadingChoices {
        units: vec![pair("t", "us"), pair("xp", "nm")],
        ..ReadingChoices::default()
    };
    same(&chosen(&labels, &choices), &expected);
}

#[test]
fn thousands_marks_are_taken_out_and_said() {
    let expected = plain();
    let forms = [
        text("t [us];V [V];xp [nm]", |t, v, x| {
            format!("{};{v},0;{}", grouped(t as i32, "."), grouped(x, "."))
        }),
        text("t [us],V [V],xp [nm]", |t, v, x| {
            format!("\"{}\",{v},\"{}\"", grouped(t as i32, ","), grouped(x, ","))
        }),
        text("t [us]\tV [V]\txp [nm]", |t, v, x| {
            format!("{}.0\t{v}\t{}.0", grouped(t as i32, ","), grouped(x, ","))
        }),
        text("t [us];V [V];xp [nm]", |t, v, x| {
            format!("{};{v};{},0", grouped(t as i32, "."), grouped(x, "."))
        }),
    ];
    for text in forms {
        let r = auto(&text);
        same(&r, &expected);
        assert!(kinds(&r).contains(&WarningKind::ThousandsMarks), "{text}");
    }
}

#[test]
fn encodings_are_read() {
    let german = text("t [us];V [V];xp [\u{b5}m]", |t, v, x| {
        format!(
            "{t};{v},5;{}{},{:03}",
            if x < 0 { "-" } else { "" },
            x.abs() / 1000,
            x.abs() % 1000
        )
    });
    let expected = auto(&german);
    assert!((expected.proof_mass[1] - plain().proof_mass[1]).abs() < 1e-18);
    let (western, _, _) = encoding_rs::WINDOWS_1252.encode(&german);
    let wide: Vec<u8> = german.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [western.into_owned(), wide] {
        let r = import_bytes_auto("x", &bytes).unwrap();
        same(&r, &expected);
        assert_eq!(kinds(&r)[0], WarningKind::TextEncoding);
    }
    let mut zeros = german.into_bytes();
    zeros.extend([0; 600]);
    let r = import_bytes_auto("x", &zeros).unwrap();
    same(&r, &expected);
    assert!(kinds(&r).contains(&WarningKind::TextEncoding));
}

#[test]
fn times_of_all_kinds() {
    let expected = plain();
    let clock = |t: u32| {
        format!(
            "14:03:{:02}.{:06}",
            12 + (500_000 + t) / 1_000_000,
            (500_000 + t) % 1_000_000
        )
    };
    for text in [
        text("Time,V [V],xp [nm]", |t, v, x| {
            format!("{},{v},{x}", clock(t))
        }),
        text("Time,V [V],xp [nm]", |t, v, x| {
            format!("2026-01-01T{}Z,{v},{x}", clock(t))
        }),
        text("Date;Time;V [V];xp [nm]", |t, v, x| {
            format!("01.01.2026;{};{v};{x}", clock(t))
        }),
        text("timestamp,V [V],xp [nm]", |t, v, x| {
            format!("{},{v},{x}", 1_767_276_012_500_000u64 + u64::from(t))
        }),
        text("# Sample rate: 4 kHz\nV [V],xp [nm]", |_, v, x| {
            format!("{v},{x}")
        }),
        text("# dt = 250us\nSample,V [V],xp [nm]", |t, v, x| {
            format!("{},{v},{x}", t / 250)
        }),
    ] {
        let r = auto(&text);
        assert_eq!(r.proof_mass, expected.proof_mass, "{text}");
        for (a, b) in r.time.iter().zip(&expected.time) {
            assert!((a - b).abs() < 1e-12, "{a} {b}\n{text}");
        }
    }
    let counted = text("n,V [V],xp [nm]", |t, v, x| format!("{},{v},{x}", t / 250));
    asks(&counted, &["counts samples", "--rate"]);
    let choices = ReadingChoices {
        interval: Some(250e-6),
        ..ReadingChoices::default()
    };
    same(&chosen(&counted, &choices), &expected);
    let minutes = text("Time (min),V (V),xp (nm)", |t, v, x| {
        format!("{:.12},{v},{x}", f64::from(t) / 60e6)
    });
    let r = auto(&minutes);
    assert!((r.interval() - 250e-6).abs() < 1e-10);
    let days = text("Time,V [V],xp [nm]", |t, v, x| {
        format!("{:.10},{v},{x}", 46_023.5 + f64::from(t) / 86_400e6)
    });
    let r = auto(&days);
    assert!(kinds(&r).contains(&WarningKind::ConvertedTime));
    assert!(
        (r.interval() - 250e-6).abs() < 1e-9,
        "{:e} {:?}",
        r.interval(),
        r.warnings
    );
}

#[test]
fn rows_in_any_order() {
    let expected = plain();
    let mut lines: Vec<String> = rows()
        .iter()
        .map(|(t, v, x)| format!("{t},{v},{x}"))
        .collect();
    let header = "t [us],V [V],xp [nm]\n";
    lines.reverse();
    let r = auto(&format!("{header}{}\n", lines.join("\n")));
    same(&r, &expected);
    assert_eq!(kinds(&r), [WarningKind::RowsReordered]);
    lines.reverse();
    lines[10..15].reverse();
    let r = auto(&format!("{header}{}\n", lines.join("\n")));
    same(&r, &expected);
    assert_eq!(
        (r.warnings[0].kind, r.warnings[0].count),
        (WarningKind::RowsReordered, 4)
    );
    let wrapped = text("t [us],V [V],xp [nm]", |t, v, x| {
        format!("{},{v},{x}", (60_000 + t) % 65_536)
    });
    let r = auto(&wrapped);
    assert_eq!(r.proof_mass, expected.proof_mass);
    let apart = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-15;
    assert!(r.time.iter().zip(&expected.time).all(apart), "{:?}", r.time);
    assert!(kinds(&r).contains(&WarningKind::CounterWrap));
    let mixed = text("T [ms],V [V],xp [nm]", |t, v, x| {
        if t < 1000 {
            format!("{t},{v},{x}")
        } else {
            format!("{:.4},{v},{x}", f64::from(t) / 1000.0)
        }
    });
    asks_nothing_but(&mixed, "unit of time changes");
}

fn asks_nothing_but(text: &str, word: &str) {
    let error = fails(text.as_bytes()).to_string();
    assert!(error.contains(word), "{error}");
}

#[test]
fn several_recordings_are_told_apart() {
    let header = "t [us],V [V],xp [nm]\n";
    let one: Vec<String> = rows()
        .iter()
        .map(|(t, v, x)| format!("{t},{v},{x}\n"))
        .collect();
    let two: Vec<String> = rows()
        .iter()
        .map(|(t, v, x)| format!("{t},{v},{}\n", x + 1000))
        .collect();
    let shift = |r: &Recording| r.proof_mass[0];
    for between in ["", header, "Trial 2\n"] {
        let text = format!("{header}{}{between}{}", one.concat(), two.concat());
        asks(&text, &["2 recordings", "--trial N"]);
        let found = trials("x", text.as_bytes()).unwrap();
        assert_eq!(found.len(), 2);
        for (trial, first) in [(1, 0.0), (2, 1e-6)] {
            let choices = ReadingChoices {
                trial: Some(trial),
                ..ReadingChoices::default()
            };
            let r = chosen(&text, &choices);
            assert_eq!((r.len(), shift(&r)), (40, first), "{between}");
        }
        let mut settings = preview_bytes("x", text.as_bytes()).unwrap().settings;
        settings.trial = Some(3);
        let error = import_bytes("x", text.as_bytes(), &settings).unwrap_err();
        assert!(error.to_string().contains("holds 2"), "{error}");
    }
    for text in [
        text("t1 [us],xp1 [nm],t2 [us],xp2 [nm]", |t, _, x| {
            format!("{t},{x},{t},{}", x + 1000)
        }),
        text("t [us],trial 1 [nm],trial 2 [nm]", |t, _, x| {
            format!("{t},{x},{}", x + 1000)
        }),
        text("up,,down,\nt [us],xp [nm],t [us],xp [nm]", |t, _, x| {
            format!("{t},{x},{t},{}", x + 1000)
        }),
    ] {
        asks(&text, &["2 recordings", "--trial N"]);
        let choices = ReadingChoices {
            trial: Some(2),
            ..ReadingChoices::default()
        };
        assert_eq!(shift(&chosen(&text, &choices)), 1e-6, "{text}");
    }
}

#[test]
fn what_has_two_readings_is_asked() {
    asks(
        &text("Time [us],Command [V],Monitor [V],xp [nm]", |t, v, x| {
            format!("{t},{v},{v},{x}")
        }),
        &["Command", "Monitor", "--column V="],
    );
    asks(
        &text("t [us],V [V],x", |t, v, x| format!("{t},{v},{x}")),
        &["no unit of length", "--unit xp="],
    );
    let volts = text("t [us],Drive [V],Displacement [V]", |t, v, x| {
        format!("{t},{v},{x}")
    });
    asks(&volts, &["xp is in \"V\"", "--scale xp=0.5um/V"]);
    let choices = ReadingChoices {
        scales: vec![pair("xp", "1nm/V")],
        signs: vec![("xp".to_owned(), -1.0)],
        ..ReadingChoices::default()
    };
    let r = chosen(&volts, &choices);
    let (a, b) = (r.proof_mass[1], plain().proof_mass[1]);
    assert!((a + b).abs() < 1e-18, "{a} {b}");
    let wrong = ReadingChoices {
        columns: vec![pair("xp", "nothing")],
        ..ReadingChoices::default()
    };
    let error = import_bytes_chosen("x", volts.as_bytes(), &wrong).unwrap_err();
    assert!(
        error.to_string().contains("\"Displacement [V]\""),
        "{error}"
    );
}

#[test]
fn a_column_that_is_added_midway_is_not_passed_over() {
    let mut lines = String::from("t [us],V [V],xp [nm]\n");
    for (i, (t, v, x)) in rows().into_iter().enumerate() {
        lines += &if i < 20 {
            format!("{t},{v},{x}\n")
        } else {
            format!("{t},23,{v},{x}\n")
        };
    }
    let error = fails(lines.as_bytes()).to_string();
    assert!(
        error.contains("line 22: from here on rows have 4 cells, before 3"),
        "{error}"
    );
    // The header is written again, and the column stands at the end.
    let mut lines = String::from("t [us],V [V],xp [nm]\n");
    for (i, (t, v, x)) in rows().into_iter().enumerate() {
        if i == 20 {
            lines += "t [us],V [V],xp [nm],T [degC]\n";
        }
        lines += &if i < 20 {
            format!("{t},{v},{x}\n")
        } else {
            format!("{t},{v},{x},23\n")
        };
    }
    let r = auto(&lines);
    same(&r, &plain());
    assert!(kinds(&r).contains(&WarningKind::ColumnsChange));
}

#[test]
fn overrange_marks_are_missing_and_said() {
    for mark in [
        "9.9E+37",
        "-9.91E37",
        "OL",
        "----",
        "inf",
        "-\u{221e}",
        "Overflow",
    ] {
        let text = text("t [us],V [V],xp [nm]", |t, v, x| {
            if t == 1000 {
                format!("{t},{v},{mark}")
            } else {
                format!("{t},{v},{x}")
            }
        });
        let r = auto(&text);
        assert!(r.proof_mass[4].is_nan(), "{mark}");
        let over = r.warnings.iter().find(|w| w.kind == WarningKind::Overrange);
        assert_eq!(over.map(|w| w.count), Some(1), "{mark}");
    }
}

#[test]
fn units_rows_and_footers() {
    let r = auto(&text(
        "Time,Drive voltage,Tip,Mood\n(us),(V),(nm),(furlong)",
        |t, v, x| format!("{t},{v},{x},1"),
    ));
    same(&r, &plain());
    assert!(r.warnings.iter().any(|w| w.message.contains("\"furlong\"")));
    let r = auto(
        &(text("t [us],V [V],xp [nm]", |t, v, x| format!("{t},{v},{x}"))
            + "End of data\nSamples,40\n"),
    );
    same(&r, &plain());
    assert_eq!(kinds(&r), [WarningKind::TextRows]);
}

#[test]
fn velocities_are_integrated_and_accelerations_asked_for() {
    let w = 400.0;
    let line = |i: u32| {
        let t = f64::from(i) * 250e-6;
        format!("{t:.6},{:.9}\n", 1e-3 * w * (w * t).cos())
    };
    let rows: String = (0..400).map(line).collect();
    let r = auto(&format!("t [s],Velocity [m/s]\n{rows}"));
    let shape = 0.5 * w * 250e-6 / (0.5 * w * 250e-6f64).tan();
    for (t, x) in r.time.iter().zip(&r.proof_mass) {
        assert!((x - shape * 1e-3 * (w * t).sin()).abs() < 1e-9);
    }
    assert_eq!(
        kinds(&r)
            .iter()
            .filter(|k| **k == WarningKind::Integrated)
            .count(),
        2
    );
    let text = format!("t [s],a [m/s^2]\n{rows}");
    asks(&text, &["is an acceleration", "--column xp=2"]);
    let choices = ReadingChoices {
        columns: vec![pair("xp", "a")],
        ..ReadingChoices::default()
    };
    assert_eq!(chosen(&text, &choices).len(), 400);
}

#[test]
fn stored_settings_still_load() {
    let old = "delimiter = \"semicolon\"\ndecimal = \"comma\"\nskip_lines = 1\n\
        time_offset = 0.0\n[time]\nindex = 0\nunit = \"s\"\n[proof_mass]\nindex = 1\nunit = \"um\"\n";
    let settings: ImportSettings = toml::from_str(old).unwrap();
    assert!(settings.accept_losses && settings.clock.is_none());
    assert_eq!(settings.time_zero, TimeZero::File);
    let r = import_bytes("x", b"t;x\n0;1,5\n1;2,5\n", &settings).unwrap();
    assert_eq!(r.proof_mass, [1.5e-6, 2.5e-6]);
    let mut full = settings;
    full.clock = Some(SampleClock {
        start: -0.1,
        interval: 2e-5,
    });
    full.encoding = Some(Encoding::Windows1252);
    full.trial = Some(2);
    let again: ImportSettings = toml::from_str(&toml::to_string(&full).unwrap()).unwrap();
    assert_eq!(again, full);
}
