//! Outputs that fail: no finished result is lost, no file is half written, and the exit code says
//! what happened.

use std::path::Path;
use std::process::{Command, Output, Stdio};

/// A synthetic recording of the `paper` device.
const RECORDING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/made-up-paper.csv");
/// A simulation whose trace is larger than a pipe holds.
const LONG_TRACE: &str = "simulate --drive square:15Hz:8V --duration 500ms";
/// Length of the longest name of a file \[bytes\]: no name of a second file begins with it.
const MAX_NAME_LENGTH: usize = 255;

/// Runs a line of the shell in a folder; `$P` is the program, `$R` the recording.
fn shell(folder: &Path, line: &str) -> Output {
    Command::new("sh")
        .args(["-c", line])
        .current_dir(folder)
        .env("P", env!("CARGO_BIN_EXE_impactscope"))
        .env("R", RECORDING)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

/// Runs the program with a standard output whose reader has gone.
fn without_reader(folder: &Path, arguments: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_impactscope"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    child.wait_with_output().unwrap()
}

fn error_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The one line with which a command ends that failed, without its progress and warnings.
fn last_error(output: &Output) -> String {
    let text = error_of(output);
    assert!(!text.contains("panicked"), "{text}");
    let errors: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with("impactscope: ") && !line.contains(": warning: "))
        .collect();
    assert_eq!(errors.len(), 1, "{text}");
    errors[0].to_owned()
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn assert_whole_events(text: &str) {
    assert!(text.starts_with("t [s],event,"), "{text}");
    assert!(text.lines().count() > 2 && text.ends_with('\n'), "{text}");
}

fn assert_whole_report(text: &str) {
    assert!(text.trim_end().ends_with("</html>"), "{} bytes", text.len());
}

fn assert_whole_json(text: &str) {
    let value: serde_json::Value = serde_json::from_str(text).unwrap();
    assert!(value.is_object());
}

#[test]
fn a_reader_that_has_gone_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut arguments: Vec<&str> = LONG_TRACE.split(' ').collect();
    arguments.extend(["--events", "events.csv"]);
    let output = without_reader(folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", error_of(&output));
    assert_eq!(error_of(&output), "");
    assert_whole_events(&read(folder, "events.csv"));
    let output = without_reader(
        folder,
        &[
            "diagnose", RECORDING, "--report", "r.html", "--json", "d.json",
        ],
    );
    assert_eq!(output.status.code(), Some(0), "{}", error_of(&output));
    assert_whole_report(&read(folder, "r.html"));
    assert_whole_json(&read(folder, "d.json"));
    let output = without_reader(folder, &["--help"]);
    assert_eq!(output.status.code(), Some(0), "{}", error_of(&output));
}

#[test]
fn a_full_standard_output_takes_no_file_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for line in [
        format!("\"$P\" {LONG_TRACE} --events events.csv > /dev/full"),
        "\"$P\" diagnose \"$R\" --report r.html --json d.json > /dev/full".to_owned(),
        "\"$P\" fit \"$R\" --free eta --out fitted.toml --json f.json > /dev/full".to_owned(),
        "\"$P\" validate --json v.json > /dev/full".to_owned(),
        "\"$P\" --help > /dev/full".to_owned(),
        "\"$P\" --version > /dev/full".to_owned(),
    ] {
        let output = shell(folder, &line);
        let error = last_error(&output);
        assert_eq!(output.status.code(), Some(1), "{line}: {error}");
        for part in ["standard output", "No space left"] {
            assert!(error.contains(part), "{line}: {error}");
        }
    }
    assert_whole_events(&read(folder, "events.csv"));
    assert_whole_report(&read(folder, "r.html"));
    assert!(read(folder, "fitted.toml").contains("[parameters]"));
    for name in ["d.json", "f.json", "v.json"] {
        assert_whole_json(&read(folder, name));
    }
    assert_eq!(names_in(folder).len(), 6, "{:?}", names_in(folder));
}

#[test]
fn a_trial_is_scored_though_its_report_and_standard_output_fail() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let trial = folder.join("files").join("seed-3");
    // A folder has the report's name.
    std::fs::create_dir_all(trial.join("report.html")).unwrap();
    let output = shell(
        folder,
        "\"$P\" trial --seed 3 --conceal none --json t.json --files files > /dev/full",
    );
    let error = last_error(&output);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("standard output"), "{error}");
    let lines = error_of(&output);
    assert!(
        lines.contains("seed 3: cannot write files/seed-3/report.html"),
        "{lines}"
    );
    let json: serde_json::Value = serde_json::from_str(&read(folder, "t.json")).unwrap();
    assert_eq!(json["cases"].as_array().unwrap().len(), 1);
    assert!(json["failed"].as_array().unwrap().is_empty());
    assert_whole_json(&read(&trial, "truth.json"));
}

#[test]
fn trials_of_a_rig_are_sealed_diagnosed_from_their_own_preset_and_scored_by_rig() {
    use sha2::{Digest, Sha256};
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let line = "\"$P\" trial --seed 5 --count 2 --rig ball --sizes 20:30 --conceal quadratic_drag \
                --json t.json --files files";
    let output = shell(folder, line);
    assert_eq!(output.status.code(), Some(0), "{}", error_of(&output));
    let said = String::from_utf8(output.stdout).unwrap();
    for part in ["rig (from 3 x", "false names", "worst s", "ball"] {
        assert!(said.contains(part), "{part}:\n{said}");
    }
    let json: serde_json::Value = serde_json::from_str(&read(folder, "t.json")).unwrap();
    let row = &json["table"]["by_rig"][0];
    assert_eq!(row["label"], "ball");
    assert!(row["seconds"][1].as_f64().unwrap() > 0.0);
    assert_eq!(json["cases"][0]["outcome"]["rig"], "ball");
    let case = folder.join("files").join("seed-5");
    // The seal was said first, and the truth that it seals is the file.
    let digest = Sha256::digest(std::fs::read(case.join("truth.json")).unwrap());
    let hex: String = digest.iter().map(|b| format!("{b:02x}")).collect();
    assert!(
        said.starts_with(&format!("seed 5: sealed, SHA-256 {hex}\n")),
        "{said}"
    );
    // Anybody can ask again, with the preset that the trial's diagnosis was given.
    let again = "\"$P\" diagnose --preset preset.toml train-1.csv train-2.csv --held-out held-out-1.csv \
                 --json d.json";
    let output = shell(&case, again);
    assert_eq!(output.status.code(), Some(0), "{}", error_of(&output));
}

#[test]
fn a_full_standard_error_changes_no_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (line, code) in [
        // A warning.
        (
            "\"$P\" simulate --drive square:15Hz:30V --duration 10ms --out warned.csv",
            0,
        ),
        // Progress.
        ("\"$P\" fit \"$R\" --free eta --out fitted.toml", 0),
        ("\"$P\" diagnose \"$R\" --json d.json", 0),
        // Errors, ours and the parser's.
        ("\"$P\" fit none.csv", 1),
        ("\"$P\" simulate --set nonsense=1", 2),
        ("\"$P\" simulate --nonsense", 2),
    ] {
        for closed in ["2> /dev/full", "2>&-"] {
            let output = shell(folder, &format!("{line} {closed}"));
            assert_eq!(output.status.code(), Some(code), "{line} {closed}");
        }
    }
    // Not lost silently: the same drive does warn.
    let output = shell(
        folder,
        "\"$P\" simulate --drive square:15Hz:30V --duration 10ms --out warned.csv",
    );
    assert!(error_of(&output).contains("warning: the drive reaches"));
    assert!(read(folder, "warned.csv").lines().count() > 100);
    assert!(read(folder, "fitted.toml").contains("[parameters]"));
    assert_whole_json(&read(folder, "d.json"));
}

#[test]
fn a_closed_standard_output_loses_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let line = format!("\"$P\" {LONG_TRACE} --events events.csv >&-");
    let output = shell(folder, &line);
    assert_eq!(output.status.code(), Some(0), "{}", error_of(&output));
    assert_whole_events(&read(folder, "events.csv"));
}

#[test]
fn a_file_that_cannot_be_written_whole_stays_as_it_was() {
    let longest = "x".repeat(MAX_NAME_LENGTH);
    let old = "an old line\n".repeat(300);
    // The second is written in place: there is no name for a second file.
    for name in ["trace.csv", &longest] {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let line = format!("ulimit -f 1; exec \"$P\" {LONG_TRACE} --out {name}");
        for before in [Some(&old), None] {
            match before {
                Some(old) => std::fs::write(folder.join(name), old).unwrap(),
                None => std::fs::remove_file(folder.join(name)).unwrap(),
            }
            let output = shell(folder, &line);
            let error = last_error(&output);
            assert_eq!(output.status.code(), Some(1), "{error}");
            assert!(
                error.contains(name) && error.contains("File too large"),
                "{error}"
            );
            match before {
                Some(old) => {
                    assert_eq!(&read(folder, name), old);
                    assert_eq!(names_in(folder), [name]);
                }
                None => assert!(names_in(folder).is_empty(), "{:?}", names_in(folder)),
            }
        }
    }
}

#[test]
fn a_diagnosis_is_said_whatever_its_files_do() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["r.html", "d.json"] {
        std::fs::write(folder.join(name), "old").unwrap();
    }
    let output = shell(
        folder,
        "ulimit -f 1; exec \"$P\" diagnose \"$R\" --report r.html --json d.json",
    );
    let error = last_error(&output);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.contains("r.html") && error.contains("d.json"),
        "{error}"
    );
    let plain = shell(folder, "\"$P\" diagnose \"$R\"");
    assert!(plain.status.success() && !plain.stdout.is_empty());
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&plain.stdout)
    );
    assert_eq!(names_in(folder), ["d.json", "r.html"]);
    for name in ["r.html", "d.json"] {
        assert_eq!(read(folder, name), "old");
    }
    // One that fails takes the other not with it.
    let output = shell(
        folder,
        "exec \"$P\" diagnose \"$R\" --report /dev/full --json d.json",
    );
    assert_eq!(output.status.code(), Some(1));
    assert!(last_error(&output).contains("/dev/full"));
    assert_whole_json(&read(folder, "d.json"));
    assert_eq!(output.stdout, plain.stdout);
}

#[test]
fn a_hyphen_is_standard_output_for_every_output_but_for_one_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for line in [
        "\"$P\" simulate --out - --events -",
        "\"$P\" simulate --events -",
        "\"$P\" diagnose \"$R\" --report - --json -",
        "\"$P\" fit \"$R\" --out - --json -",
        // The same by the name of the file: the second would replace the first.
        "\"$P\" simulate --events both.csv > both.csv",
    ] {
        let output = shell(folder, line);
        let error = last_error(&output);
        assert_eq!(output.status.code(), Some(2), "{line}: {error}");
        assert!(error.contains("both go to standard output"), "{error}");
        assert!(output.stdout.is_empty(), "{line}");
    }
    let output = shell(
        folder,
        &format!("\"$P\" {LONG_TRACE} --out t.csv --events -"),
    );
    assert!(output.status.success(), "{}", error_of(&output));
    assert_whole_events(&String::from_utf8_lossy(&output.stdout));
    let trace = read(folder, "t.csv");
    let output = shell(folder, &format!("\"$P\" {LONG_TRACE} --out -"));
    assert_eq!(String::from_utf8_lossy(&output.stdout), trace);
    let output = shell(
        folder,
        &format!("\"$P\" {LONG_TRACE} --out t2.csv > t2.csv"),
    );
    assert!(output.status.success(), "{}", error_of(&output));
    assert_eq!(read(folder, "t2.csv"), trace);
    let output = shell(folder, "\"$P\" diagnose \"$R\" --report -");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.starts_with("<!") || text.starts_with("<html"),
        "no report alone"
    );
    assert_whole_report(&text);
    let output = shell(folder, "\"$P\" fit \"$R\" --free eta --out -");
    let device: toml::Table = String::from_utf8_lossy(&output.stdout).parse().unwrap();
    assert!(device.contains_key("parameters"));
    assert!(!folder.join("-").exists());
}

#[test]
fn no_control_character_of_a_name_reaches_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let harmful = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        text.chars().any(|c| c.is_control() && !"\n\t".contains(c))
    };
    let name = "a\u{1b}[2J\u{7}\r\u{9b}.csv";
    let text = std::fs::read_to_string(RECORDING).unwrap();
    std::fs::write(folder.join(name), text + "0.9,oops,1,1\n").unwrap();
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_impactscope"))
            .args(arguments)
            .current_dir(folder)
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .unwrap()
    };
    for (arguments, written_out) in [
        (&["fit", name, "--free", "eta"][..], true),
        (&["fit", "none\u{1b}[2J.csv"], true),
        (&["simulate", "--drive", "table:none\u{1b}[2J.csv"], true),
        (&["simulate", "--preset", "none\u{1b}[2J"], true),
        // The parser of the command line leaves out what it knows as a colour.
        (&["simulate", "--\u{1b}[2J\u{7}"], false),
    ] {
        let output = run(arguments);
        let error = error_of(&output);
        assert!(!harmful(&output.stderr), "{arguments:?}: {error:?}");
        assert!(!harmful(&output.stdout), "{arguments:?}");
        assert!(
            !written_out || error.contains("\\u{1b}[2J"),
            "{arguments:?}: {error}"
        );
    }
}

/// A million samples take less than 200 MB, whatever the parameters and however long the text.
#[cfg(target_os = "linux")]
#[test]
fn a_million_samples_take_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // A run that changes the voltage at each sample, one of steps of 10^5 s, one whose readings
    // begin long before it, and one from contact to contact.
    let cases = [
        "--duration 20",
        "--duration 20 --drive square:24kHz:1V",
        "--duration 20 --preset oscillator --set f1=1e-5",
        "--duration 20 --effect sensor_lag:delay=1000",
        "--duration 20 --set alpha=1 --set Ca=0 --set Ca0=0",
    ];
    // Two threads: each one more would add its stack.
    const LIMITED: &str = "export RAYON_NUM_THREADS=2; ulimit -d 204800 && exec \"$P\" simulate";
    for case in cases {
        let output = shell(folder, &format!("{LIMITED} {case} --out t.csv"));
        assert!(output.status.success(), "{case}: {}", error_of(&output));
        assert_eq!(read(folder, "t.csv").lines().count(), 1_000_002, "{case}");
    }
}
