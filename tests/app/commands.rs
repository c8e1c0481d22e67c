//! The command line as others run it: output forms, exit codes, one clear line for
//! what is wrong.

use std::process::{Command, Output};

/// A synthetic recording of the `paper` device.
const RECORDING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/made-up-paper.csv");
/// Its voltage as a drive.
const TABLE: &str = concat!(
    "table:",
    env!("CARGO_MANIFEST_DIR"),
    "/assets/made-up-paper.csv"
);

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
        (
            &["fit", RECORDING, "--free", ",,"],
            2,
            "--free names no parameter",
        ),
        (
            &["fit", RECORDING, "--free", "dp,eta", "--profile", "Cs"],
            2,
            "there are dp, eta",
        ),
        (&["diagnose", RECORDING, "--fix", "gpp=1"], 2, "--fix gpp=1"),
        (
            &["diagnose", RECORDING, "--known", "Cs=2e-21"],
            2,
            "write ID=VALUE+-ERROR",
        ),
        (
            &["diagnose", RECORDING, "--free", "Css"],
            2,
            "there is no such parameter; there are Cs, gp",
        ),
        (
            &["diagnose", RECORDING, "--fix", "Cs", "--free", "Cs"],
            2,
            "both held and free",
        ),
        (
            &["diagnose", RECORDING, "--candidates", "drag"],
            2,
            "there is no effect drag; there are",
        ),
        (
            &["diagnose", RECORDING, "--budget", "0"],
            2,
            "--budget 0: the time must be above 0 s",
        ),
        (
            &["fit", RECORDING, "--candidates", "gravity"],
            2,
            "a fit compares no effects",
        ),
        (
            &["fit", RECORDING, "--free", "none"],
            2,
            "all parameters are locked",
        ),
        (
            &["fit", RECORDING, "--held-out", RECORDING],
            2,
            "has not seen",
        ),
        (&["fit", RECORDING, RECORDING], 2, "name it once"),
        (
            &["fit", RECORDING, "--json", RECORDING],
            2,
            "is an input file",
        ),
        (
            &["fit", RECORDING, "--out", "/no/such/fitted.toml"],
            1,
            "cannot write /no/such/fitted.toml",
        ),
        (
            &["diagnose", RECORDING, "--report", RECORDING],
            2,
            "is an input file",
        ),
        (
            &["fit", RECORDING, "--step", "guide", "--out", "x.toml"],
            2,
            "finds no parameter values",
        ),
        (
            &["simulate", "--drive", TABLE, "--out", RECORDING],
            2,
            "is an input file",
        ),
        (
            &["simulate", "--out", "x.csv", "--events", "./x.csv"],
            2,
            "--out and --events name the same file",
        ),
        (&["trial"], 2, "--seed"),
        (
            &["trial", "--seed", "1", "--conceal", "magic"],
            2,
            "cannot be concealed",
        ),
        (&["trial", "--seed", "1", "--noise", "3 V"], 2, "--noise"),
        (
            &["trial", "--seed", "1", "--rig", "swing"],
            2,
            "there is no rig \"swing\"; there are both-points,",
        ),
        (
            &[
                "trial",
                "--seed",
                "1",
                "--rig",
                "ball",
                "--conceal",
                "gap_step",
            ],
            2,
            "the rig ball cannot conceal gap_step",
        ),
        (
            &["trial", "--seed", "1", "--sizes", "9:1"],
            2,
            "sizes 9 to 1",
        ),
        (&["demo", "--out", "/dev/null/x"], 1, "/dev/null/x"),
        #[cfg(feature = "gui")]
        (&["nonsense"], 1, "display"),
        #[cfg(not(feature = "gui"))]
        (&["nonsense"], 2, "nonsense"),
    ] {
        let output = run(arguments);
        let error = error_of(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
        assert!(error.contains(part), "{arguments:?}: {error}");
        assert!(!error.contains("panicked"), "{error}");
    }
}

#[cfg(not(feature = "gui"))]
#[test]
fn without_a_window_the_commands_are_named_in_one_line() {
    let output = run(&[]);
    let error = error_of(&output);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    for part in [
        "no window",
        "simulate, fit, validate, diagnose, trial, demo",
    ] {
        assert!(error.contains(part), "no {part} in {error}");
    }
}

#[test]
fn what_the_reader_left_out_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.csv");
    std::fs::write(
        &path,
        "t [s],V [V],xp [um]\n0,1,1\n1,1,oops\n2,1,3\n3,1,4\n",
    )
    .unwrap();
    let output = run(&["fit", path.to_str().unwrap()]);
    let error = error_of(&output);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.contains("warning: ") && error.contains("first in line 3"),
        "{error}"
    );
    assert!(error.contains("too few"), "{error}");
}

#[test]
fn a_step_hands_its_device_to_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.toml");
    let device = path.to_str().unwrap();
    // Another film to begin with: the step must find the one of the recording.
    let output = run(&[
        "fit", "--step", "film", RECORDING, "--set", "Cs=1e-21", "--out", device, "--json", "-",
    ]);
    assert!(output.status.success(), "{}", error_of(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let found = json["parameters"][0]["value"].as_f64().unwrap();
    assert_eq!(json["parameters"][0]["id"], "Cs");
    let kept: toml::Table = std::fs::read_to_string(&path).unwrap().parse().unwrap();
    let kept = kept["parameters"]["Cs"].as_float().unwrap();
    assert!((kept / found - 1.0).abs() < 1e-9 && (kept / 1e-21 - 1.0).abs() > 0.1);
    let output = run(&[
        "fit",
        "--step",
        "restitution",
        RECORDING,
        "--preset",
        device,
    ]);
    assert_ne!(output.status.code(), Some(2), "{}", error_of(&output));
}

#[cfg(unix)]
#[test]
fn interrupted_work_keeps_the_best_so_far() {
    use std::io::{BufRead, BufReader, Read};
    use std::process::Stdio;

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fitted.toml");
    let mut child = Command::new(env!("CARGO_BIN_EXE_impactscope"))
        .args([
            "fit",
            RECORDING,
            "--starts",
            "50",
            "--out",
            path.to_str().unwrap(),
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    // The first iteration is done: there is something to keep.
    while !line.contains("iteration 1,") {
        line.clear();
        assert!(
            errors.read_line(&mut line).unwrap() > 0,
            "it ended too soon"
        );
    }
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    let mut rest = String::new();
    errors.read_to_string(&mut rest).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{rest}");
    assert!(
        rest.contains("cancelled; the best result so far was written"),
        "{rest}"
    );
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.starts_with("Ended early: this is the best so far."),
        "{text}"
    );
    assert!(
        std::fs::read_to_string(&path)
            .unwrap()
            .contains("[parameters]")
    );
}
