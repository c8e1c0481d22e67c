use super::segments::direction;
use crate::model::drive::*;

fn all() -> Vec<Waveform> {
    [
        "sine:50Hz:8V",
        "square:15Hz:8V",
        "triangle:7Hz:3V",
        "ramped:5Hz:8V:0.25",
        "ramped:5Hz:8V:0",
        "ramped:5Hz:8V:0.5",
        "chirp:10Hz:200Hz:4V",
        "chirp:200Hz:10Hz:4V",
    ]
    .iter()
    .map(|text| Waveform::parse(text, 0.5).unwrap())
    .collect()
}

#[test]
fn segments_follow_one_another() {
    for waveform in all() {
        for i in 0..40 {
            let (a, b) = (waveform.segment(i), waveform.segment(i + 1));
            if a.end.is_infinite() {
                break;
            }
            assert!(
                (a.end - b.start).abs() < 1e-12 * b.start.abs().max(1.0),
                "{waveform} {i}: {a:?} {b:?}"
            );
            assert!(a.end >= a.start, "{waveform} {i}");
            let middle = if a.start.is_finite() {
                0.5 * (a.start + a.end)
            } else {
                0.5 * a.end
            };
            if a.end > a.start + 1e-12 {
                assert_eq!(
                    waveform.segment(waveform.index_at(middle)),
                    a,
                    "{waveform} {i}"
                );
            }
        }
    }
}

#[test]
fn branch_is_the_sign_of_the_slope() {
    for waveform in all() {
        let mut last = Branch::Rising;
        for k in 1..4000 {
            let t = k as f64 * 1.2345e-4;
            let segment = waveform.segment(waveform.index_at(t));
            let slope = segment.shape.voltage(t + 1e-9) - segment.shape.voltage(t - 1e-9);
            if slope.abs() > 1e-10 {
                last = direction(slope > 0.0);
            } else if !matches!(segment.shape, Shape::Constant { .. }) {
                continue;
            }
            if !matches!(waveform, Waveform::Square { .. }) && segment.end.is_finite() {
                assert!(
                    segment.branch == last || matches!(segment.shape, Shape::Constant { .. }),
                    "{waveform} at {t}"
                );
            }
        }
    }
}

#[test]
fn values_of_the_waveforms() {
    let at = |text: &str, t: f64| Waveform::parse(text, 1.0).unwrap().voltage(t);
    assert_eq!(at("square:5Hz:8V", 0.0), 8.0);
    assert_eq!(at("square:5Hz:8V", 0.15), -8.0);
    assert!((at("sine:5Hz:8V", 0.05) - 8.0).abs() < 1e-12);
    assert!((at("sine:5Hz:8V", 100.025) - 8.0 * (TAU * 5.0 * 0.025).sin()).abs() < 1e-9);
    assert!((at("triangle:5Hz:8V", 0.025) - 4.0).abs() < 1e-12);
    assert!((at("ramped:5Hz:8V:0.25", 0.0) + 8.0).abs() < 1e-12);
    assert!((at("ramped:5Hz:8V:0.25", 0.025)).abs() < 1e-12);
    assert_eq!(at("ramped:5Hz:8V:0.25", 0.07), 8.0);
    assert!((at("chirp:1Hz:3Hz:2V", 0.5) - 2.0 * (TAU * 0.75f64).sin()).abs() < 1e-9);
}

#[test]
fn table_holds_its_branch_on_plateaus() {
    let time: Vec<f64> = (0..9).map(f64::from).collect();
    let voltage = vec![0.0, 4.0, 8.0, 8.0, 8.0, 4.0, 0.0, 0.0, 1.0];
    let table = VoltageTable::new("test", time, voltage).unwrap();
    use crate::model::piezo::Branch::{Falling as F, Rising as R};
    let waveform = Waveform::Table(Arc::new(table));
    let branches: Vec<_> = (0..=9).map(|i| waveform.segment(i).branch).collect();
    assert_eq!(branches, [R, R, R, R, R, F, F, F, R, R]);
}

#[test]
fn a_table_that_repeats_comes_again() {
    let points =
        || VoltageTable::new("test", vec![0.5, 1.0, 2.0, 2.5], vec![1.0, 4.0, -2.0, -2.0]).unwrap();
    assert!(points().repeating(1.9).is_err());
    assert!(points().repeating(f64::NAN).is_err());
    for period in [2.0, 2.6] {
        let once = Waveform::Table(Arc::new(points()));
        let waveform = Waveform::Table(Arc::new(points().repeating(period).unwrap()));
        assert_eq!(waveform.period(), Some(period));
        for k in 0..40 {
            let t = 0.5 + (0.01 + 0.0497 * f64::from(k)).min(1.99);
            for turn in [0.0, 1.0, 17.0, 1e6] {
                let off = waveform.voltage(t + turn * period) - once.voltage(t);
                assert!(off.abs() < 1e-8, "{period} {t} {turn}: {off}");
                let branch = |w: &Waveform, t: f64| w.segment(w.index_at(t)).branch;
                assert_eq!(branch(&waveform, t + turn * period), branch(&once, t));
            }
        }
        for i in 0..30 {
            let (a, b) = (waveform.segment(i), waveform.segment(i + 1));
            assert_eq!(a.end, b.start);
        }
    }
    // Between the last point and the first one's next time a line leads back.
    let waveform = Waveform::Table(Arc::new(points().repeating(2.6).unwrap()));
    assert!((waveform.voltage(2.8) + 0.5).abs() < 1e-12);
}

#[test]
fn the_latest_instants_are_reached_at_once() {
    for waveform in all() {
        for t in [1e15, 1e300, f64::MAX] {
            assert!(waveform.index_at(t) > 0, "{waveform}");
        }
    }
}

#[test]
fn bad_drives_are_refused_with_a_reason() {
    for text in [
        "",
        "sine",
        "sine:5Hz",
        "sine:5s:8V",
        "square:-5Hz:8V",
        "square:0Hz:8V",
        "sine:nan:8V",
        "ramped:5Hz:8V:0.7",
        "noise:1:2",
        "sine:1e30:1",
    ] {
        let error = Waveform::parse(text, 1.0).unwrap_err();
        assert!(error.to_string().len() > 10, "{text}");
    }
    assert!(VoltageTable::new("x", vec![0.0, 0.0], vec![1.0, 2.0]).is_err());
    assert!(VoltageTable::new("x", vec![0.0, f64::NAN], vec![1.0, 2.0]).is_err());
    assert!(VoltageTable::new("x", vec![], vec![]).is_err());
}
