//! `inspect` and the reading options, as others run them.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};

/// A synthetic recording of the `paper` device.
const RECORDING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/made-up-paper.csv");

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_impactscope"))
        .args(arguments)
        .output()
        .unwrap()
}

fn json(arguments: &[&str]) -> serde_json::Value {
    let all = [arguments, &["--json", "-"]].concat();
    let output = run(&all);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn text_of(path: &Path) -> String {
    path.display().to_string()
}

#[test]
fn inspect_says_what_a_recording_holds() {
    let found = json(&["inspect", RECORDING]);
    let [one] = &found.as_array().unwrap()[..] else {
        panic!("{found}");
    };
    assert!((one["rate_hz"].as_f64().unwrap() / 50e3 - 1.0).abs() < 1e-6);
    assert!((one["duration_s"].as_f64().unwrap() / 0.2 - 1.0).abs() < 1e-3);
    assert_eq!(one["trial"], serde_json::Value::Null);
    let xp = &one["channels"]["xp"];
    assert_eq!(xp["unit"], "um");
    assert!(xp["column"].as_str().unwrap().starts_with("xp"));
    // SI: some tens of micrometres, noise of 20 nm.
    assert!((-1e-4..-1e-5).contains(&xp["min"].as_f64().unwrap()));
    assert!((1e-8..4e-8).contains(&xp["noise"].as_f64().unwrap()));
    assert!(
        one["drive"]["text"]
            .as_str()
            .unwrap()
            .starts_with("square:15Hz")
    );
    assert!(one["warnings"].is_array());
    let text = run(&["inspect", RECORDING]);
    let text = String::from_utf8(text.stdout).unwrap();
    for part in ["50 kHz", "xp", "noise", "contact level"] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
}

#[test]
fn one_file_that_cannot_be_read_leaves_the_others() {
    let output = run(&["inspect", "/no/such.csv", RECORDING]);
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("/no/such.csv") && !error.contains("panicked"));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("made-up-paper.csv"), "{text}");
}

#[test]
fn reading_options_decide_what_a_file_leaves_open() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::File::create(&path)
            .and_then(|mut file| file.write_all(text.as_bytes()))
            .unwrap();
        text_of(&path)
    };
    let rows = |f: &dyn Fn(usize) -> String| (0..40).map(f).collect::<String>();
    // No column of times, and volts for a displacement.
    let meter = rows(&|i| format!("{},{}\n", 7 - 14 * (i / 20) as i32, 0.1 * (i % 20) as f64));
    let meter = write("meter.csv", &format!("V [V],xp [V]\n{meter}"));
    let refused = run(&["inspect", &meter]);
    assert_eq!(refused.status.code(), Some(1));
    let error = String::from_utf8_lossy(&refused.stderr);
    assert!(error.contains("--"), "no option is named: {error}");
    let found = json(&[
        "inspect",
        &meter,
        "--rate",
        "10kHz",
        "--scale",
        "xp=0.5um/V",
    ]);
    assert!((found[0]["rate_hz"].as_f64().unwrap() / 1e4 - 1.0).abs() < 1e-9);
    let highest = found[0]["channels"]["xp"]["max"].as_f64().unwrap();
    assert!((highest / 0.95e-6 - 1.0).abs() < 1e-9, "{highest}");
    // Two columns that could be the voltage.
    let two = rows(&|i| format!("{i},{},{},{}\n", i % 7, i % 5, 0.5 * i as f64));
    let header = "t [ms],command [V],monitor [V],xp [um]\n";
    let two = write("two.csv", &format!("{header}{two}"));
    let chosen = json(&["inspect", &two, "--column", "V=3"]);
    assert_eq!(chosen[0]["channels"]["V"]["max"], 4.0);
    let turned = json(&["inspect", &two, "--column", "V=command", "--sign", "xp=-1"]);
    assert_eq!(turned[0]["channels"]["V"]["max"], 6.0);
    assert!(turned[0]["channels"]["xp"]["min"].as_f64().unwrap() < -1.9e-5);
    let wrong = run(&["inspect", &two, "--sign", "xp=2"]);
    assert_eq!(wrong.status.code(), Some(2));
}
