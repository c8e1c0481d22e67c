//! The command line as others run it: output forms, exit codes, one clear line for
//! what is wrong.

use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_impactscope"))
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap()
}

fn error_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn simulate_starts_at_rest_at_time_zero() {
    let output = run(&["simulate", "--drive", "square:15Hz:8V", "--duration", "1ms"]);
    assert!(output.status.success(), "{}", error_of(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("t [s],V [V],xp [um],xc [um]"));
    let first: Vec<f64> = lines
        .next()
        .unwrap()
        .split(',')
        .map(|cell| cell.trim().parse().unwrap())
        .collect();
    assert_eq!(first[..2], [0.0, 8.0]);
    assert!(first[2..].iter().all(|um| um.abs() < 1e-12), "{first:?}");
    assert_eq!(lines.count(), 50);
}

#[test]
fn validate_reaches_the_papers_table_and_has_its_form() {
    let output = run(&["validate", "--json", "-"]);
    assert!(output.status.success(), "{}", error_of(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let cases = json["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 16);
    for case in cases {
        assert!(matches!(case["signal"].as_str(), Some("square" | "sine")));
        for key in ["f_hz", "v", "bounces", "peak_um", "contact_ms"] {
            assert!(case[key].is_number(), "{key} in {case}");
        }
    }
    let against = &json["statistics"]["against_paper_simulation"];
    assert!(against["peak_mean_absolute_error"].as_f64().unwrap() <= 0.03);
    assert!(against["contact_within_30_percent"].as_u64().unwrap() >= 13);
}

#[test]
fn wrong_commands_exit_with_2_and_failed_work_with_1() {
    for (arguments, code, part) in [
        (&["simulate", "--set", "Cs"][..], 2, "write ID=VALUE"),
        (&["simulate", "--set", "nonsense=1"], 2, "no such parameter"),
        (
            &["simulate", "--effect", "magic"],
            2,
            "there is no effect magic",
        ),
        (&["simulate", "--duration", "5 V"], 2, "--duration"),
        (
            &["simulate", "--preset", "/no/such.toml"],
            1,
            "/no/such.toml",
        ),
        (&["simulate", "--set", "gp=50um"], 2, "must exceed dp"),
        (&["simulate", "--set", "dp=-1"], 2, "below 1 nm"),
        (&["simulate", "--duration", "-1"], 2, "-1"),
        (&["simulate", "--drive", "square:15V:8Hz"], 2, "not a unit"),
        (
            &["validate", "--preset", "faller"],
            2,
            "no ground or no drive",
        ),
        (&["diagnose"], 2, "RECORDINGS"),
        (&["diagnose", "/no/such.csv"], 1, "/no/such.csv"),
        (&["trial"], 2, "--seed"),
        (
            &["trial", "--seed", "1", "--conceal", "magic"],
            2,
            "cannot be concealed",
        ),
        (&["trial", "--seed", "1", "--noise", "3 V"], 2, "--noise"),
        (&["demo", "--out", "/dev/null/x"], 1, "/dev/null/x"),
        (&["nonsense"], 1, "display"),
    ] {
        let output = run(arguments);
        let error = error_of(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
        assert!(error.contains(part), "{arguments:?}: {error}");
        assert!(!error.contains("panicked"), "{error}");
    }
}
