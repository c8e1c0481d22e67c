//! The real window, used as a person would: a recording is opened, the Cs slider is
//! dragged with the mouse, and the curve and the residual must change.
//!
//! Needs a display and `xdotool`. Without them the test says so and passes, unless
//! `IMPACTSCOPE_REQUIRE_DISPLAY` is set: then it fails.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// Ends the program whatever becomes of the test.
struct Window(Child);

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn xdotool(arguments: &[&str]) -> String {
    let output = Command::new("xdotool").args(arguments).output().unwrap();
    assert!(
        output.status.success(),
        "xdotool {arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// Time for the program to start or to compute on a busy machine.
const LONG: Duration = Duration::from_secs(90);
/// Time for it to react to the mouse.
const SOON: Duration = Duration::from_secs(10);

/// What the program says of itself, once `done` is content with it.
fn wait_for(
    file: &Path,
    what: &str,
    done: impl Fn(&Value) -> bool,
    patience: Duration,
) -> Result<Value, String> {
    let started = Instant::now();
    let mut last = Value::Null;
    while started.elapsed() < patience {
        if let Ok(text) = std::fs::read_to_string(file)
            && let Ok(value) = serde_json::from_str::<Value>(&text)
        {
            if done(&value) {
                return Ok(value);
            }
            last = value;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Err(format!(
        "waited in vain for {what}; the window says {last:#}"
    ))
}

/// Drags the Cs slider to the right, from the middle of the track, where its value stands,
/// with pauses of `pause` between.
fn drag_cs(layout: &Value, (x, y): (f64, f64), pause: Duration) {
    let place = &layout["widgets"]["slider Cs"];
    let at = |i: usize| place[i].as_f64().unwrap();
    let fraction = (cs(layout) / 1e-23).ln() / (1e-19f64 / 1e-23).ln();
    let px = |f: f64| (x + at(0) + f * (at(2) - at(0))).round().to_string();
    let py = (y + 0.5 * (at(1) + at(3))).round().to_string();
    xdotool(&["mousemove", &px(fraction), &py]);
    std::thread::sleep(5 * pause);
    xdotool(&["mousedown", "1"]);
    std::thread::sleep(pause);
    for step in 1..=10 {
        xdotool(&["mousemove", &px(fraction + 0.02 * f64::from(step)), &py]);
        std::thread::sleep(pause);
    }
    std::thread::sleep(2 * pause);
    xdotool(&["mouseup", "1"]);
}

fn rms(layout: &Value) -> Option<f64> {
    layout["residuals"][0]["rms"].as_f64()
}

fn cs(layout: &Value) -> f64 {
    layout["parameters"]["Cs"].as_f64().unwrap()
}

/// Position of the window's contents on the screen.
fn origin() -> (f64, f64) {
    let started = Instant::now();
    loop {
        let output = Command::new("xdotool")
            .args(["search", "--onlyvisible", "--name", "^impactscope$"])
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        if let Some(id) = text.lines().last() {
            let geometry = xdotool(&["getwindowgeometry", "--shell", id]);
            let read = |key: &str| -> f64 {
                geometry
                    .lines()
                    .find_map(|line| line.strip_prefix(key))
                    .unwrap()
                    .parse()
                    .unwrap()
            };
            return (read("X="), read("Y="));
        }
        assert!(started.elapsed() < Duration::from_secs(60), "no window");
        std::thread::sleep(Duration::from_millis(100));
    }
}

#[test]
fn dragging_cs_moves_the_curve_and_the_residual() {
    let display = std::env::var_os("DISPLAY").is_some_and(|display| !display.is_empty());
    let tool = Command::new("xdotool")
        .arg("version")
        .stdout(Stdio::null())
        .status()
        .is_ok();
    if !(display && tool) {
        assert!(
            std::env::var_os("IMPACTSCOPE_REQUIRE_DISPLAY").is_none(),
            "a display and xdotool are required"
        );
        println!("skipped: no display or no xdotool");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("recording.csv");
    let program = env!("CARGO_BIN_EXE_impactscope");
    let made = Command::new(program)
        .args(["simulate", "--drive", "square:15Hz:8V", "--duration", "0.2"])
        .args(["--set", "Cs=3e-21", "--out"])
        .arg(&recording)
        .status()
        .unwrap();
    assert!(made.success());
    let layout: PathBuf = folder.path().join("layout.json");
    let window = Window(
        Command::new(program)
            .arg(&recording)
            .env("IMPACTSCOPE_LAYOUT_FILE", &layout)
            .env("IMPACTSCOPE_DATA_DIR", folder.path().join("data"))
            .spawn()
            .unwrap(),
    );
    let residual = |l: &Value| rms(l).is_some();
    let before = wait_for(&layout, "the recording's residual", residual, LONG).unwrap();
    let (x, y) = origin();
    // A machine that draws a frame a second takes press and release as one: the drag is
    // then repeated, slower, as a person would.
    let changed = |l: &Value| cs(l) > 2.0 * cs(&before) && rms(l).is_some();
    for slowness in [1, 4, 12, 30] {
        let now = wait_for(&layout, "the window's layout", residual, SOON)
            .unwrap_or_else(|_| before.clone());
        drag_cs(&now, (x, y), Duration::from_millis(60 * slowness));
        if wait_for(&layout, "a changed Cs", changed, SOON).is_ok() {
            break;
        }
    }
    let after = wait_for(
        &layout,
        "another residual",
        |l| changed(l) && rms(l) != rms(&before),
        LONG,
    )
    .unwrap();
    println!(
        "Cs {:.3e} -> {:.3e} N m^2 s, rms {:.4e} -> {:.4e} m",
        cs(&before),
        cs(&after),
        rms(&before).unwrap(),
        rms(&after).unwrap()
    );
    let generation = |l: &Value| l["generation"].as_u64().unwrap();
    assert!(generation(&after) > generation(&before));
    // A larger film coefficient passes the recording's 3e-21 and goes on: the residual
    // is that of another curve, not noise of the same.
    let (r0, r1) = (rms(&before).unwrap(), rms(&after).unwrap());
    assert!((r1 / r0 - 1.0).abs() > 0.05, "{r0} {r1}");
    // The curve itself moved: the decay after break-off is faster under more film.
    let curve = |l: &Value| -> Vec<f64> {
        let values = l["curve"].as_array().unwrap();
        values.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let moved = curve(&before)
        .iter()
        .zip(curve(&after))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    println!("the curve moved by {moved:.3e} m");
    assert!(moved > 1e-7, "{moved}");
    drop(window);
}
