//! Times as digits, and what they say of the clock, from text to recording.

use std::fmt::Display;

use super::{auto, fails, kinds};
use crate::recording::csv::*;
use crate::recording::{Channel, ImportError, Recording, WarningKind};

/// A file of these times, with a motion.
fn file<T: Display>(header: &str, times: impl Iterator<Item = T>) -> String {
    let mut text = format!("{header},xp [um]\n");
    for (i, t) in times.enumerate() {
        text.push_str(&format!("{t},{:.4}\n", 100.0 * (0.01 * i as f64).sin()));
    }
    text
}

fn bits(r: &Recording) -> Vec<u64> {
    r.time.iter().map(|t| t.to_bits()).collect()
}

#[test]
fn a_file_from_1970_is_the_same_file_from_zero() {
    let n = 3000u64;
    let zero = auto(&file("t [s]", (0..n).map(|i| format!("0.{:05}", 2 * i))));
    assert_eq!(zero.time[1], 2e-5);
    assert_eq!(zero.time[2999], 0.05998);
    assert!(zero.warnings.is_empty());
    let others = [
        file("t [s]", (0..n).map(|i| format!("1732752000.{:05}", 2 * i))),
        file(
            "t [ms]",
            (0..n).map(|i| format!("1732752000{:03}.{:02}", 2 * i / 100, 2 * i % 100)),
        ),
        file(
            "t [us]",
            (0..n).map(|i| format!("{}", 1_732_752_000_000_000 + 20 * i)),
        ),
        file(
            "t [ns]",
            (0..n).map(|i| format!("{}", 1_732_752_000_000_000_000 + 20_000 * i)),
        ),
        file(
            "t [s]",
            (0..n).map(|i| format!("{}e-5", 173_275_200_000_000 + 2 * i)),
        ),
        file("t [s]", (0..n).map(|i| format!("-0.{:05}", 6000 - 2 * i))),
        file(
            "t [s]",
            (0..n).map(|i| format!("+1'732'752'000.{:05}", 2 * i)),
        ),
        file(
            "t [s]",
            (0..n).map(|i| format!("\"1732752000,{:05}\"", 2 * i)),
        ),
    ];
    for text in others {
        let r = auto(&text);
        assert_eq!(bits(&r), bits(&zero), "{}", &text[..60]);
        assert_eq!(r.proof_mass, zero.proof_mass);
        assert_eq!(kinds(&r), [WarningKind::TimeOrigin], "{}", &text[..60]);
    }
}

#[test]
fn the_first_rows_time_is_kept_said_and_written() {
    let text = "t [s],xp [um]\n-0.01000,1\n-0.00998,2\n-0.00996,4\n";
    let r = auto(text);
    assert_eq!(r.time, [0.0, 2e-5, 4e-5]);
    assert_eq!(r.origin.to_string(), "-0.01");
    assert_eq!(r.origin.seconds(), -0.01);
    assert!(r.warnings[0].message.contains("is at -0.01 s in the file"));
    let mut out = Vec::new();
    write_recording(&mut out, &r).unwrap();
    let written = String::from_utf8(out.clone()).unwrap();
    assert!(written.contains("\n-0.00998,2\n"), "{written}");
    let again = import_bytes_auto("again", &out).unwrap();
    assert_eq!((again.time, again.origin), (r.time, r.origin));

    // The file's zero, for those who know what it means.
    let mut settings = preview_bytes("x", text.as_bytes()).unwrap().settings;
    assert_eq!(settings.time_zero, TimeZero::FirstRow);
    settings.time_zero = TimeZero::File;
    let r = import_bytes("x", text.as_bytes(), &settings).unwrap();
    assert_eq!(r.time, [-0.01, -0.00998, -0.00996]);
    assert!(r.origin.is_zero() && r.warnings.is_empty());
    settings.time_offset = 0.25;
    let r = import_bytes("x", text.as_bytes(), &settings).unwrap();
    assert_eq!((r.time[0], r.origin.to_string().as_str()), (0.24, "-0.25"));
    settings.time_offset = 1e200;
    let error = import_bytes("x", text.as_bytes(), &settings).unwrap_err();
    assert!(error.to_string().contains("smaller offset"), "{error}");
}

#[test]
fn times_of_single_precision_become_those_of_the_clock() {
    let n = 20_000;
    let exact = auto(&file(
        "t [s]",
        (0..n).map(|i| format!("{:.5}", f64::from(i) * 2e-5)),
    ));
    let single = |i: i32| (f64::from(i) * 2e-5) as f32;
    for text in [
        file("t [s]", (0..n).map(|i| f64::from(single(i)))),
        file("t [s]", (0..n).map(|i| i as f32 * 2e-5f32)),
        file(
            "t [ms]",
            (0..n).map(|i| f64::from((f64::from(i) * 2e-2) as f32)),
        ),
    ] {
        let r = auto(&text);
        assert_eq!(kinds(&r), [WarningKind::RoundedTimes], "{:?}", r.warnings);
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 4e-8;
        assert!(r.time.iter().zip(&exact.time).all(near));
        let dt = r.time[1];
        assert!(r.time.windows(2).all(|w| (w[1] - w[0] - dt).abs() < 1e-15));
        assert!(r.warnings[0].message.contains("single precision"));
        assert!(r.warnings[0].count > 1000 && r.warnings[0].first_line.is_some());
    }
    // Stored in single precision and printed in full, it is the clock bit for bit.
    let text = file("t [s]", (0..n).map(|i| f64::from(single(i))));
    assert_eq!(bits(&auto(&text)), bits(&exact));
    // Kept, if asked.
    let mut settings = preview_bytes("x", text.as_bytes()).unwrap().settings;
    settings.times_as_written = true;
    let r = import_bytes("x", text.as_bytes(), &settings).unwrap();
    assert_eq!(r.time[19_999], f64::from(single(19_999)));
    assert!(r.warnings.is_empty(), "{:?}", r.warnings);
}

#[test]
fn times_rounded_to_few_digits_become_those_of_the_clock() {
    let six_digits = |t: f64| {
        let places = (5 - t.log10().floor() as i32).clamp(0, 12) as usize;
        format!("{:.places$}", t)
    };
    // 48 kHz with six significant digits.
    let from = 0.2;
    let times = (0..20_000).map(|i| six_digits(from + f64::from(i) / 48_000.0));
    let r = auto(&file("t [s]", times));
    assert_eq!(
        kinds(&r),
        [WarningKind::RoundedTimes, WarningKind::TimeOrigin]
    );
    let even = |(i, t): (usize, &f64)| *t == i as f64 / 48_000.0;
    assert!(r.time.iter().enumerate().all(even));
    // Milliseconds at 10 kHz: ten rows with the same time, and none is lost.
    let r = auto(&file("t [ms]", (0..5000).map(|i| i / 10)));
    assert_eq!(r.len(), 5000);
    assert_eq!(kinds(&r)[0], WarningKind::RoundedTimes);
    assert!(
        (r.sampling_rate() - 1e4).abs() < 10.0,
        "{}",
        r.sampling_rate()
    );
    // Ten rows prove nothing: what repeats is dropped, as ever.
    let r = auto(&file("t [ms]", [0, 1, 1, 2, 3, 4, 5].into_iter()));
    assert_eq!((r.len(), kinds(&r)[0]), (6, WarningKind::TimeNotIncreasing));
}

#[test]
fn lost_rows_and_gaps_do_not_hide_the_rounding() {
    let ticks = (0..20_000).filter(|i| i % 1000 != 7 && i % 6000 > 100);
    let r = auto(&file(
        "t [s]",
        ticks
            .clone()
            .map(|i| format!("{:.6}", f64::from(i) / 48_000.0)),
    ));
    assert!(
        kinds(&r).contains(&WarningKind::RoundedTimes),
        "{:?}",
        r.warnings
    );
    let first = 101.0 / 48_000.0;
    let near = |(i, t): (i32, &f64)| {
        let file = t + r.origin.seconds();
        (file - f64::from(i) / 48_000.0).abs() < 6e-7 && file >= first - 6e-7
    };
    assert!(ticks.zip(&r.time).all(near));
}

#[test]
fn a_column_that_is_not_there_is_an_error_at_once() {
    let text = "t [s],V [V],xp [um]\n0,8,1\n1e-5,8,2\n2e-5,8,3\n";
    let settings = preview_bytes("x", text.as_bytes()).unwrap().settings;
    for (index, shown) in [
        (3, "column 4,"),
        (70_000, "column 70001,"),
        (1_000_000_000_000_000_000, "column 1000000000000000001,"),
        (usize::MAX, "column 18446744073709551615,"),
    ] {
        for channel in [None, Some(Channel::Voltage), Some(Channel::ProofMass)] {
            let mut settings = settings.clone();
            let slot = match channel {
                None => &mut settings.time,
                Some(Channel::Voltage) => &mut settings.voltage,
                Some(_) => &mut settings.proof_mass,
            };
            slot.as_mut().unwrap().index = index;
            let error = import_bytes("x", text.as_bytes(), &settings).unwrap_err();
            let message = error.to_string();
            assert!(
                matches!(error, ImportError::NoSuchColumn { cells: 3, .. }),
                "{message}"
            );
            assert!(message.contains(shown), "{message}");
        }
    }
}

#[test]
fn column_70_000_is_column_70_000() {
    let wide = 70_010;
    let row = |t: &str, far: &str| {
        let mut cells = vec!["9"; wide];
        (cells[0], cells[65_536], cells[70_000]) = (t, "7", far);
        cells.join(",") + "\n"
    };
    let text = row("0", "1") + &row("1e-5", "2") + &row("2e-5", "3");
    let choice = |index| Some(ColumnChoice::new(index, ""));
    let settings = ImportSettings {
        time: choice(0),
        proof_mass: choice(70_000),
        ..ImportSettings::default()
    };
    let r = import_bytes("x", text.as_bytes(), &settings).unwrap();
    assert_eq!(r.proof_mass, [1.0, 2.0, 3.0]);
}

#[test]
fn rows_that_are_kept_must_hold_a_reading() {
    // The only numbers of xp stand in rows without a time, or in one that goes back.
    for text in [
        "t [s],xp [um]\n0,\nhm,1\n1e-5,\n,2\n2e-5,\n",
        "t [s],xp [um]\n0,\n1e-5,\n1e-5,1\n2e-5,\n3e-5,\n",
    ] {
        let error = fails(text.as_bytes());
        let message = error.to_string();
        assert!(
            matches!(
                error,
                ImportError::NoUsableRow {
                    line: 2,
                    column: 2,
                    ..
                }
            ),
            "{message}"
        );
    }
    // A voltage without any is left out.
    let r = auto("t [s],V [V],xp [um]\n0,,1\nhm,5,1\n1e-5,,2\n2e-5,,3\n");
    assert!(r.voltage.is_none());
    assert!(kinds(&r).contains(&WarningKind::IgnoredColumn));
    // A scale that leaves the range of numbers leaves no reading.
    let text = "t [s],xp [um]\n0,1\n1e-5,2\n2e-5,3\n";
    let mut settings = preview_bytes("x", text.as_bytes()).unwrap().settings;
    (settings.xp_scale, settings.xp_offset) = (f64::MAX, f64::MAX);
    settings.proof_mass.as_mut().unwrap().unit = "m".to_owned();
    assert!(import_bytes("x", text.as_bytes(), &settings).is_err());
}

#[test]
fn control_characters_of_a_file_are_written_out() {
    let name = "a\u{1b}[2Jb.csv";
    for text in [
        "t\u{1b}]0;x\u{7} [kg],x [m]\n0,1\n1,2\n",
        "t [s],V\u{1b}[31m [A\u{7f}],y\u{8} [N]\n0,1,1\n1,1,2\n",
        "t [s],xp [um]\n0,\u{1b}[1m\n1,\u{9b}2J\n",
        "clock\u{7} [ms],laser\u{1b} [um]\n0,1\n0.01,2\n0.02,3\n",
    ] {
        let seen = preview_bytes(name, text.as_bytes());
        let mut texts = Vec::new();
        if let Ok(seen) = &seen {
            texts.extend(
                seen.header
                    .iter()
                    .chain(seen.rows.iter().flatten())
                    .cloned(),
            );
            texts.extend(seen.ambiguities.iter().chain([&seen.name]).cloned());
            texts.extend(seen.comments.iter().cloned());
        }
        match import_bytes_auto(name, text.as_bytes()) {
            Ok(r) => {
                texts.extend(r.warnings.iter().map(|w| w.message.clone()));
                texts.push(r.name);
            }
            Err(error) => texts.push(error.to_string()),
        }
        assert!(!texts.is_empty());
        for text in texts {
            assert!(!text.contains(char::is_control), "{text:?}");
        }
    }
}

// TOML from here on.

#[test]
fn settings_stored_before_there_was_a_choice_keep_the_files_zero() {
    let old: ImportSettings = toml::from_str("time_offset = 0.5").unwrap();
    assert_eq!(
        (old.time_zero, old.times_as_written),
        (TimeZero::File, false)
    );
    let new = ImportSettings::default();
    let text = toml::to_string(&new).unwrap();
    assert_eq!(toml::from_str::<ImportSettings>(&text).unwrap(), new);
    assert_eq!(new.time_zero, TimeZero::FirstRow);
}
