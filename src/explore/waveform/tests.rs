//! Drawn waveforms: order of handles, limits, the table of numbers, files.

use std::fs;
use std::sync::Arc;

use proptest::prelude::*;

use super::*;
use crate::model::Model;
use crate::model::drive::{
    Burst, Handle, Handles, Interpolation, PeriodicDrive, VoltageTable, Waveform,
};
use crate::model::effects;
use crate::model::preset::Preset;
use crate::sim::{Options, simulate};

fn drive(text: &str) -> Waveform {
    Waveform::parse(text, 1.0).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn drawn(points: &[(f64, f64)], kind: Interpolation) -> EditableWaveform {
    let points = points.iter();
    let points = points.map(|&(time, voltage)| Handle { time, voltage });
    EditableWaveform::new("test", Handles::new(points.collect(), kind).unwrap(), 10.0)
}

#[test]
fn lines_and_steps_become_handles_exactly() {
    for text in [
        "square:15Hz:8V:duty=30%:offset=1V:phase=77deg",
        "square:15Hz:8V:duty=100%",
        "triangle:7Hz:3V",
        "triangle:7Hz:3V:asymmetry=90%:burst=2/3",
        "triangle:7Hz:3V:asymmetry=0",
        "ramped:5Hz:8V:0.25:duty=40%",
        "drawn:15Hz:smooth:0/-8,0.25/8,0.5/8,0.5/-2",
    ] {
        let waveform = drive(text);
        let edited = EditableWaveform::from_waveform(&waveform, 16).unwrap();
        assert!(
            edited.handles().len() <= 6,
            "{text}: {:?}",
            edited.handles()
        );
        let again = edited.waveform().unwrap();
        let period = waveform.period().unwrap();
        assert_eq!(again.period(), Some(period));
        for k in 0..997 {
            let t = period * (1.0 + (f64::from(k) + 0.37) / 997.0);
            let off = (again.voltage(t) - waveform.voltage(t)).abs();
            assert!(off < 1e-8, "{text} at {t}: {off}");
            let branch = |w: &Waveform| w.segment(w.index_at(t)).branch;
            assert_eq!(branch(&again), branch(&waveform), "{text} at {t}");
        }
    }
    // Two corners, without handles where the slope does not change.
    let triangle = EditableWaveform::from_waveform(&drive("triangle:7Hz:3V"), 16).unwrap();
    assert_eq!(triangle.handles().len(), 2);
    // A table that repeats.
    let table = VoltageTable::new("table", vec![0.0, 0.03, 0.1], vec![1.0, 4.0, -2.0]).unwrap();
    let table = Waveform::Table(Arc::new(table.repeating(0.1).unwrap()));
    let edited = EditableWaveform::from_waveform(&table, 16).unwrap();
    for k in 0..50 {
        let t = 0.1 + 0.00199 * f64::from(k);
        let off = edited.waveform().unwrap().voltage(t) - table.voltage(t);
        assert!(off.abs() < 1e-8, "{t}: {off}");
    }
    for text in ["rest", "chirp:1Hz:9Hz:2V"] {
        let error = EditableWaveform::from_waveform(&drive(text), 16).unwrap_err();
        assert!(
            error.to_string().contains("has no period; draw on a sine"),
            "{error}"
        );
    }
}

#[test]
fn a_sine_of_handles_converges() {
    let sine = drive("sine:10Hz:8V:offset=1V:phase=30deg");
    let error = |count| {
        let edited = EditableWaveform::from_waveform(&sine, count).unwrap();
        let own = edited.waveform().unwrap();
        (0..500)
            .map(|k| 0.1 + f64::from(k) * 2e-4)
            .map(|t| (own.voltage(t) - sine.voltage(t)).abs())
            .fold(0.0, f64::max)
    };
    let errors = [16, 32, 64, 128].map(error);
    // Of second order: where the curve turns its slope is 0, elsewhere better.
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.35 * pair[0], "{errors:?}");
    }
    assert!(errors[0] < 0.2, "{errors:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn whatever_is_dragged_stays_a_drive(
        moves in prop::collection::vec(
            (0..4u8, 0..9usize, -0.2..1.2f64, -12.0..12.0f64), 1..60),
        is_snapped in prop::bool::ANY,
        is_smooth in prop::bool::ANY,
    ) {
        let kind = if is_smooth { Interpolation::Smooth } else { Interpolation::Linear };
        let mut edited = drawn(&[(0.0, -8.0), (0.5, 8.0)], kind);
        if is_snapped {
            edited.grid = SnapGrid { time: Some(0.1), voltage: Some(0.5) };
        }
        for (action, index, time, voltage) in moves {
            let count = edited.handles().len();
            let point = Handle { time, voltage };
            match action {
                0 => {
                    if let Ok(new) = edited.insert(point) {
                        prop_assert_eq!(edited.handles().len(), count + 1);
                        let snapped = edited.grid.snapped(point);
                        prop_assert_eq!(edited.handles()[new].voltage, snapped.voltage);
                    }
                }
                1 => prop_assert_eq!(edited.remove(index).is_ok(), index < count && count > 1),
                _ => {
                    let moved = edited.move_to(index, point);
                    prop_assert_eq!(moved.is_ok(), index < count);
                    if let Ok(at) = moved {
                        prop_assert_eq!(edited.handles()[index], at);
                        prop_assert_eq!(at.voltage, edited.grid.snapped(point).voltage);
                    }
                }
            }
            let times: Vec<f64> = edited.handles().iter().map(|p| p.time).collect();
            prop_assert!(times.is_sorted());
            prop_assert!(edited.waveform().is_ok());
        }
    }

    #[test]
    fn excesses_are_what_sampling_finds(
        heights in prop::collection::vec(-10.0..10.0f64, 1..8),
        is_smooth in prop::bool::ANY,
        voltage in 0.5..9.0f64,
        slew in 10.0..2e3f64,
    ) {
        let n = heights.len() as f64;
        let points: Vec<(f64, f64)> = heights.iter().enumerate()
            .map(|(i, v)| ((i as f64 + 0.3) / n, *v)).collect();
        let kind = if is_smooth { Interpolation::Smooth } else { Interpolation::Linear };
        let mut edited = drawn(&points, kind);
        edited.offset = 1.0;
        edited.limits = DriveLimits { voltage: Some(voltage), slew: Some(slew) };
        let found = edited.excesses().unwrap();
        let waveform = edited.waveform().unwrap();
        for k in 0..2000 {
            let share = (f64::from(k) + 0.5) / 2000.0;
            let t = 0.1 * (1.0 + share);
            let slope = waveform.segment(waveform.index_at(t)).shape.slope(t).abs();
            for (kind, value, limit) in [
                (ExcessKind::Voltage, waveform.voltage(t).abs(), voltage),
                (ExcessKind::Slew, slope, slew),
            ] {
                let place = found.iter()
                    .find(|e| e.kind == kind && e.from <= share && share <= e.to);
                if value > limit * (1.0 + 1e-6) {
                    prop_assert!(place.is_some_and(|e| e.value >= value * (1.0 - 1e-9)),
                        "{:?} {} at {}: {:?}", kind, value, share, found);
                } else if value < limit * (1.0 - 1e-6) {
                    prop_assert!(place.is_none(), "{:?} {} at {}: {:?}", kind, value, share, place);
                }
            }
        }
    }
}

#[test]
fn a_step_exceeds_any_slew() {
    let limits = DriveLimits {
        voltage: Some(7.0),
        slew: Some(1e9),
    };
    let found = excesses(&drive("square:5Hz:8V:duty=30%"), &limits).unwrap();
    let slews: Vec<&Excess> = found
        .iter()
        .filter(|e| e.kind == ExcessKind::Slew)
        .collect();
    assert_eq!(slews.len(), 2, "{found:?}");
    for (excess, at) in slews.into_iter().zip([0.0, 0.3]) {
        assert!((excess.from - at).abs() < 1e-12 && excess.from == excess.to);
        assert_eq!(excess.value, f64::INFINITY);
    }
    assert_eq!(found[0].kind, ExcessKind::Voltage);
    assert!((found[0].to - 1.0).abs() < 1e-12, "{found:?}");
    assert!(excesses(&Waveform::Rest, &limits).unwrap().is_empty());
    assert!(excesses(&drive("chirp:1Hz:9Hz:2V"), &limits).is_err());
    // The slew of a sine is 2 pi f A at its zeros.
    let limits = DriveLimits {
        voltage: None,
        slew: Some(250.0),
    };
    let found = excesses(&drive("sine:5Hz:8V"), &limits).unwrap();
    let steepest = std::f64::consts::TAU * 5.0 * 8.0;
    assert!(
        found
            .iter()
            .all(|e| (e.value / steepest - 1.0).abs() < 1e-12)
    );
    let half = (250.0 / steepest).acos() / std::f64::consts::TAU;
    let ends: Vec<(f64, f64)> = found.iter().map(|e| (e.from, e.to)).collect();
    for ((a, b), (from, to)) in
        ends.iter()
            .zip([(0.0, half), (0.5 - half, 0.5 + half), (1.0 - half, 1.0)])
    {
        assert!((a - from).abs() < 1e-9 && (b - to).abs() < 1e-9, "{ends:?}");
    }
}

/// Largest difference of the proof mass's readings \[m\] under two drives, and its largest reading.
fn differences(model: &Model, a: &Waveform, b: &Waveform) -> (f64, f64) {
    let run = |drive| simulate(model, drive, 0.2, &Options::default()).unwrap();
    let (a, b) = (run(a), run(b));
    assert_eq!(a.contacts.len(), b.contacts.len());
    let pairs = a.proof_mass.iter().zip(&b.proof_mass);
    pairs.fold((0.0, 0.0), |(off, most), (x, y)| {
        (f64::max(off, (x - y).abs()), f64::max(most, x.abs()))
    })
}

#[test]
fn the_simulator_moves_alike_under_one_voltage_in_two_forms() {
    let model = Preset::embedded("paper").unwrap().model;
    let mut slow = model.clone();
    let lag = effects::find("amplifier_lag").unwrap();
    slow.effects.push(effects::ActiveEffect::new(lag));
    for text in ["square:15Hz:8V", "triangle:40Hz:8V", "ramped:20Hz:7V:0.2"] {
        let plain = drive(text);
        let drawn = EditableWaveform::from_waveform(&plain, 16).unwrap();
        let drawn = drawn.waveform().unwrap();
        assert!(matches!(drawn, Waveform::Periodic(_)));
        for model in [&model, &slow] {
            let (off, most) = differences(model, &plain, &drawn);
            assert!(off < 1e-10 && most > 5e-5, "{text}: {off} of {most}");
        }
    }
    // Cubic pieces against many straight lines.
    let smooth = drive("drawn:20Hz:smooth:0.1/-7,0.25/1,0.3/5,0.55/7.5,0.6/-1,0.9/-8");
    let times: Vec<f64> = (0..4000).map(|i| 0.05 * f64::from(i) / 4000.0).collect();
    let volts = times.iter().map(|t| smooth.voltage(*t)).collect();
    let table = VoltageTable::new("dense", times, volts).unwrap();
    let table = Waveform::Table(Arc::new(table.repeating(0.05).unwrap()));
    let (off, most) = differences(&model, &smooth, &table);
    // The lines cut corners of some 8 V / 4000^2 each; the device moves 16.5 um a unit of drive.
    assert!(off < 2e-8 && most > 5e-5, "{off} of {most}");
}

#[test]
fn every_number_is_set_and_read_back() {
    for text in [
        "sine:50Hz:8V",
        "square:15Hz:8V:burst=2/3",
        "triangle:7Hz:3V:offset=1V",
        "ramped:5Hz:8V:0.25",
        "drawn:15Hz:smooth:0/-8,0.25/8,0.5/8,0.5/-2",
    ] {
        let waveform = drive(text);
        let all = parameters(&waveform);
        assert!(all.len() >= 4);
        for parameter in &all {
            let (low, high) = parameter.range;
            let value = low + 0.37 * (high - low);
            let set = parameter.set(&waveform, value).unwrap();
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs().max(1.0);
            assert!(
                near(parameter.get(&set).unwrap(), value),
                "{text} {}",
                parameter.id
            );
            for other in all.iter().filter(|p| p.id != parameter.id) {
                // The amplitude of a drawn period is that of its handles.
                let is_scale = |id: &str| id == "amplitude" || id.starts_with('h');
                if is_scale(&parameter.id) && is_scale(&other.id) {
                    continue;
                }
                assert_eq!(other.get(&set), other.get(&waveform), "{text} {}", other.id);
            }
            assert_eq!(drive(&set.to_string()), set);
            assert!(
                parameter.set(&waveform, f64::NAN).is_err(),
                "{}",
                parameter.id
            );
        }
        assert_eq!(get(&waveform, "f"), get(&waveform, "frequency"));
        assert_eq!(get(&waveform, "V"), get(&waveform, "amplitude"));
    }
    let drawn = drive("drawn:15Hz:linear:0/-2,0.25/4");
    let doubled = set(&drawn, "V", 8.0).unwrap();
    assert_eq!(get(&doubled, "h1"), Some(-4.0));
    let says = |waveform: &Waveform, id: &str, value, words: &str| {
        let error = set(waveform, id, value).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    says(
        &drawn,
        "duty",
        0.3,
        "has no \"duty\" that could be varied; it has frequency",
    );
    says(&drawn, "t2", 1.2, "t2 = 1.2 is outside 0 .. 1");
    says(&drawn, "V", 0.0, "its form would be lost");
    says(&Waveform::Rest, "f", 3.0, "none; take a periodic waveform");
    says(
        &drive("ramped:5Hz:8V:0.25"),
        "lambda",
        0.6,
        "lambda 0.6 is outside 0 .. 0.5",
    );
}

#[test]
fn a_file_is_read_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a=b:step.toml");
    let mut edited = drawn(
        &[(0.1, -8.0), (1.0 / 3.0, 8.0), (1.0 / 3.0, 0.1)],
        Interpolation::Smooth,
    );
    save(&path, &edited).unwrap();
    assert_eq!(load(&path).unwrap(), edited);
    edited.offset = 0.1;
    edited.phase = -33.0;
    edited.burst = Some(Burst { on: 2, of: 7 });
    edited.grid = SnapGrid {
        time: Some(0.05),
        voltage: None,
    };
    edited.limits.slew = Some(1e5);
    save(&path, &edited).unwrap();
    assert_eq!(load(&path).unwrap(), edited);
    let name = path.to_str().unwrap();
    assert_eq!(read_drive_file(name).unwrap(), edited.waveform().unwrap());
    let other = read_drive_file(&format!("{name}:frequency=20Hz:amplitude=4V")).unwrap();
    let drive = PeriodicDrive::of(&other).unwrap();
    assert_eq!((drive.frequency, drive.cycle.amplitude()), (20.0, 4.0));
    assert_eq!(drive.burst, edited.burst);
    // A drive that is none is not written over one that is.
    edited.frequency = f64::NAN;
    assert!(save(&path, &edited).is_err());
    assert_eq!(load(&path).unwrap().offset, 0.1);
}

#[test]
fn a_bad_file_is_refused_with_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.toml");
    let head = "format = \"impactscope waveform\"\nversion = 1\nfrequency_hz = 15.0\n";
    for (text, words) in [
        (String::new(), "no drawn waveform; its first line"),
        ("[drive]\nx = 1\n".to_owned(), "no drawn waveform"),
        (head.replace("= 1\n", "= 2\n"), "version 2 of the format"),
        (
            head.replace("version = 1\n", ""),
            "no version that is known",
        ),
        (head.to_owned(), "missing field `handles`"),
        (format!("{head}handles = [[0, 1.0], [0.5]]\n"), "line 4"),
        (
            format!("{head}handles = [[0.0, 1.0], [0.5, nan]]\n"),
            "voltage of handle 2",
        ),
        (format!("{head}handles = []\n"), "0 handles"),
        (
            format!("{head}handles = [[0.0, 1.0]]\nhandle = 3\n"),
            "unknown field `handle`",
        ),
        (
            format!("{head}handles = [[0.0, 1.0]]\ngrid_v = -1.0\n"),
            "grid_v = -1 must be",
        ),
        (
            format!("{head}handles = [[0.0, 1.0]]\nburst = [3, 2]\n"),
            "a burst of 3",
        ),
        (
            head.replace("15.0", "-1.0") + "handles = [[0.0, 1.0]]\n",
            "frequency",
        ),
        ("x".repeat(2 << 20), "longer than"),
    ] {
        fs::write(&path, &text).unwrap();
        let error = load(&path).unwrap_err().to_string();
        assert!(
            error.contains("drive.toml") && error.contains(words),
            "{error}"
        );
    }
    fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    assert!(
        load(&path)
            .unwrap_err()
            .to_string()
            .contains("not a text file")
    );
    assert!(load(&folder.path().join("none")).is_err());
}
