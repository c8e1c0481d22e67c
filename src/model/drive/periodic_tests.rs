//! Periodic drives against closed forms, SciPy, and what must not change them.

use std::f64::consts::TAU;

use proptest::prelude::*;

use crate::model::drive::*;

/// The drives of these tests: every cycle with every modifier.
const TEXTS: [&str; 13] = [
    "sine:50Hz:8V:offset=-1V:phase=90deg",
    "sine:50Hz:-8V:burst=3/5:phase=-30deg",
    "square:15Hz:8V:duty=30%",
    "square:15Hz:-8V:offset=20V:duty=0.9:burst=1/4",
    "square:15Hz:8V:duty=100%",
    "triangle:7Hz:3V:asymmetry=90%",
    "triangle:7Hz:3V:asymmetry=0:phase=10deg",
    "triangle:7Hz:3V:asymmetry=1:burst=2/3",
    "ramped:5Hz:8V:0.25:duty=40%:offset=1V",
    "ramped:5Hz:8V:0:duty=0.7:phase=271deg",
    "drawn:15Hz:linear:0/-8,0.25/8,0.5/8,0.5/-2,100%/4V",
    "drawn:15Hz:smooth:0.1/-2,0.25/1,0.3/5,0.55/5.5,0.6/-1,0.9/-6:phase=100deg",
    "drawn:15Hz:smooth:0.5/3:offset=1V:burst=1/2",
];

fn parse(text: &str) -> Waveform {
    Waveform::parse(text, 1.0).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn branch(waveform: &Waveform, t: f64) -> Branch {
    waveform.segment(waveform.index_at(t)).branch
}

#[test]
fn what_is_read_is_written_and_read_again() {
    for text in TEXTS {
        let waveform = parse(text);
        assert_eq!(parse(&waveform.to_string()), waveform, "{text}");
    }
    // Plain forms are what they were.
    for text in ["sine:50Hz:8V", "square:15Hz:8V", "ramped:5Hz:8V:0.25"] {
        assert_eq!(parse(text).to_string(), text);
        assert!(!matches!(parse(text), Waveform::Periodic(_)));
        assert_eq!(parse(&format!("{text}:offset=0V:burst=2/2")), parse(text));
    }
    let square = parse("square:15Hz:8V:duty=30%:offset=1V:phase=90deg");
    assert_eq!(
        square.to_string(),
        "square:15Hz:8V:offset=1V:duty=30%:phase=90deg"
    );
}

#[test]
fn segments_follow_one_another_and_repeat() {
    for text in TEXTS {
        let waveform = parse(text);
        let period = waveform.period().unwrap();
        assert_eq!(waveform.index_at(0.0), 0, "{text}");
        for index in 0..60 {
            let (a, b) = (waveform.segment(index), waveform.segment(index + 1));
            assert_eq!(a.end, b.start, "{text} {index}");
            assert!(b.end > b.start, "{text} {index}: {b:?}");
            let middle = 0.5 * (b.start + b.end);
            assert_eq!(waveform.index_at(middle), index + 1, "{text}");
            assert_eq!(waveform.index_at(b.start), index + 1, "{text}");
            for turns in [1.0, 7.0, 1e5] {
                let later = middle + turns * period;
                let off = waveform.voltage(later) - waveform.voltage(middle);
                assert!(off.abs() < 1e-7, "{text} at {middle} + {turns}: {off}");
                assert_eq!(branch(&waveform, later), b.branch, "{text} at {middle}");
            }
        }
        for t in [1e15, 1e300, f64::MAX, f64::INFINITY] {
            assert!(waveform.index_at(t) > 0, "{text}");
        }
    }
}

#[test]
fn branches_turn_where_the_voltage_turns() {
    for text in TEXTS {
        let waveform = parse(text);
        let mut seen = 0;
        for k in 1..5000 {
            let t = f64::from(k) * 1.2345e-4;
            let segment = waveform.segment(waveform.index_at(t));
            let slope = segment.shape.slope(t);
            if slope.abs() > 1e-3 {
                let expected = segments::direction(slope > 0.0);
                assert_eq!(segment.branch, expected, "{text} at {t}");
                seen += 1;
            }
            // A level keeps the branch of what led to it.
            if slope == 0.0 && segment.start.is_finite() {
                let before = waveform.segment(waveform.index_at(t) - 1);
                let step = segment.shape.voltage(t) - before.shape.voltage(before.end);
                let expected = if step.abs() > 1e-6 {
                    segments::direction(step > 0.0)
                } else {
                    before.branch
                };
                assert_eq!(segment.branch, expected, "{text} at {t}");
                seen += 1;
            }
        }
        assert!(seen > 1000, "{text}: {seen}");
    }
}

#[test]
fn values_by_closed_forms() {
    let at = |text: &str, t: f64| parse(text).voltage(t);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
    for k in 0..200 {
        let t = f64::from(k) * 1.37e-3;
        near(
            at("sine:5Hz:8V:offset=1V:phase=90deg", t),
            1.0 + 8.0 * (TAU * 5.0 * t).cos(),
        );
        let u = (5.0 * t).rem_euclid(1.0);
        near(
            at("square:5Hz:8V:duty=30%:offset=2V", t),
            if u < 0.3 { 10.0 } else { -6.0 },
        );
        let rising = at("triangle:5Hz:8V:asymmetry=100%:phase=180deg", t);
        near(rising, 16.0 * u - 8.0);
        let falling = at("triangle:5Hz:8V:asymmetry=0%", t);
        near(falling, 8.0 - 16.0 * u);
    }
    // Two periods of five: 0.4 s of each second.
    assert_eq!(at("square:5Hz:8V:burst=2/5:offset=1V", 0.35), -7.0);
    assert_eq!(at("square:5Hz:8V:burst=2/5:offset=1V", 0.45), 1.0);
    assert_eq!(at("square:5Hz:8V:burst=2/5:offset=1V", 1.05), 9.0);
    assert_eq!(parse("square:5Hz:8V:burst=2/5").period(), Some(1.0));
    assert_eq!(parse("sine:5Hz:8V:offset=-3V").amplitude(), 11.0);
}

/// `PchipInterpolator(t, v)` of SciPy 1.17.1; the closed one over seven periods.
#[test]
fn the_smooth_curve_is_scipys() {
    let closed = parse("drawn:1Hz:smooth:0.1/-2,0.25/1,0.3/5,0.55/5.5,0.6/-1,0.9/-6");
    let known = [
        (0.0, -4.5),
        (0.13, -1.4746666666666668),
        (0.27, 2.6402474226804147),
        (0.4, 5.354144329896907),
        (0.58, 1.5486896551724216),
        (0.75, -4.857758620689656),
        (0.95, -5.562500000000002),
    ];
    let open = parse("drawn:1Hz:smooth:0/-8,0.2/-7,0.3/3,0.7/4,1/8");
    let of_open = [
        (0.05, -7.943014705882353),
        (0.1, -7.764705882352941),
        (0.25, -1.942948263642807),
        (0.5, 3.5835882389662275),
        (0.9, 6.260739644159334),
        (0.99, 7.820387867697453),
    ];
    for (waveform, points) in [(closed, &known[..]), (open, &of_open[..])] {
        for &(t, v) in points {
            let own = waveform.voltage(t + 3.0);
            assert!((own - v).abs() < 1e-12, "{t}: {own} {v}");
        }
    }
}

/// Handles in order, at least 1e-6 apart, some of them steps.
fn handles() -> impl Strategy<Value = Vec<Handle>> {
    let gaps = prop::collection::vec((1e-6..1.0f64, prop::bool::ANY, -10.0..10.0f64), 1..12);
    gaps.prop_map(|gaps| {
        let total: f64 = gaps.iter().map(|g| g.0).sum();
        let (mut t, mut after_step) = (0.0, true);
        let mut points: Vec<Handle> = Vec::new();
        for (gap, is_step, voltage) in gaps {
            if !is_step || after_step {
                t += 0.9 * gap / total;
            }
            after_step = is_step;
            points.push(Handle { time: t, voltage });
            after_step |= points.len() > 1 && points[points.len() - 2].time == t;
        }
        points
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn drawn_curves_meet_their_handles_and_never_overshoot(
        points in handles(),
        is_smooth in prop::bool::ANY,
        phase in -720.0..720.0f64,
    ) {
        let kind = if is_smooth { Interpolation::Smooth } else { Interpolation::Linear };
        let drawn = Handles::new(points.clone(), kind).unwrap();
        let drive = PeriodicDrive::new(Cycle::Drawn(Arc::new(drawn)), 1.0);
        let waveform = drive.clone().waveform().unwrap();
        let n = points.len();
        for (i, a) in points.iter().enumerate() {
            let b = points[(i + 1) % n];
            let end = if i + 1 < n { b.time } else { b.time + 1.0 };
            // The later of two at a step is in force from then on.
            if i + 1 == n || b.time > a.time {
                let v = waveform.voltage(a.time + 2.0 + 1e-13);
                prop_assert!((v - a.voltage).abs() < 1e-4, "{} {:?}", v, a);
            }
            let (low, high) = (a.voltage.min(b.voltage) - 1e-9, a.voltage.max(b.voltage) + 1e-9);
            for k in 1..20 {
                let t = a.time + (end - a.time) * f64::from(k) / 20.0;
                if t > a.time && t < end {
                    let v = waveform.voltage(t + 1.0);
                    prop_assert!((low..=high).contains(&v), "{} at {} outside {}..{}", v, t, low, high);
                }
            }
        }
        // A phase is a shift in time.
        let ahead = PeriodicDrive { phase, ..drive }.waveform().unwrap();
        for k in 0..50 {
            let t = 0.0137 + 0.0713 * f64::from(k);
            let (a, b) = (ahead.voltage(t), waveform.voltage(t + 2.0 + phase / 360.0));
            let near_step = points.iter().any(|p| {
                let off = (t + phase / 360.0 - p.time).rem_euclid(1.0);
                off.min(1.0 - off) < 1e-4
            });
            prop_assert!(near_step || (a - b).abs() < 1e-6, "{} {}", a, b);
        }
        let text = waveform.to_string();
        prop_assert_eq!(Waveform::parse(&text, 1.0), Ok(waveform));
    }

    #[test]
    fn a_general_cycle_is_the_plain_waveform(
        frequency in 0.1..1e3f64, amplitude in -10.0..10.0f64, lambda in 1e-3..0.5f64,
        t in 0.0..100.0f64,
    ) {
        let all = [
            Waveform::Sine { frequency, amplitude },
            Waveform::Square { frequency, amplitude },
            Waveform::Triangle { frequency, amplitude },
            Waveform::Ramped { frequency, amplitude, lambda },
        ];
        for plain in all {
            let drive = PeriodicDrive::of(&plain).unwrap();
            prop_assert_eq!(&drive.clone().waveform().unwrap(), &plain);
            // By way of the general pieces: no offset that can be seen.
            let general = PeriodicDrive { offset: 1e-300, ..drive }.waveform().unwrap();
            prop_assert!(matches!(general, Waveform::Periodic(_)));
            // Shares and halves of a period round differently.
            let own = plain.segment(plain.index_at(t));
            let off = (t - own.start).abs().min((own.end - t).abs());
            if off > 1e-9 {
                let steep = own.shape.slope(t).abs();
                let off = (plain.voltage(t) - general.voltage(t)).abs();
                prop_assert!(off < 1e-9 + steep * 1e-11, "{} at {}: {}", plain, t, off);
                prop_assert_eq!(own.branch, branch(&general, t), "{} at {}", plain, t);
            }
        }
    }
}

#[test]
fn what_is_wrong_is_said() {
    for (text, words) in [
        (
            "square:15Hz:8V:dutty=30%",
            "there is no dutty= here; square takes offset=",
        ),
        (
            "sine:15Hz:8V:duty=30%",
            "there is no duty= here; sine takes offset=, phase= and burst=",
        ),
        ("square:15Hz:8V:duty=130%", "duty 1.3 is outside 0 .. 1"),
        ("square:15Hz:8V:offset=1Hz", "not a unit"),
        (
            "square:15Hz:8V:offset=1V:offset=2V",
            "offset= is given twice",
        ),
        (
            "square:15Hz:offset=1V:8V",
            "\"8V\" comes after a named field",
        ),
        (
            "square:15Hz:8V:frequency=3Hz",
            "is set by the values without a name already",
        ),
        ("square:15Hz:8V:offset=nan", "not a number"),
        ("square:15Hz:8V:burst=5/3", "a burst of 5 periods of 3"),
        ("square:15Hz:8V:burst=0/3", "a burst of 0 periods of 3"),
        (
            "square:15Hz:8V:burst=1/99999999999",
            "is no burst; write burst=3/5",
        ),
        (
            "ramped:5Hz:8V:0.4:duty=30%",
            "lambda 0.4 is outside 0 .. 0.3",
        ),
        ("chirp:1Hz:2Hz:3V:offset=1V", "chirp takes no named fields"),
        ("rest:offset=1V", "rest takes no named fields"),
        ("drawn:15Hz:cubic:0/1", "write linear or smooth"),
        ("drawn:15Hz:linear:0", "is not a handle; write its share"),
        ("drawn:15Hz:linear:0.5/1,0.2/3", "put them in order of time"),
        ("drawn:15Hz:linear:0/1,0/2,1/3", "three handles at 0"),
        (
            "drawn:15Hz:linear:0/1,1e-12/2",
            "of a period before the next one",
        ),
        (
            "drawn:15Hz:linear:0/1,1.5/2",
            "time of handle 2 1.5 is outside 0 .. 1",
        ),
        (
            "drawn:15Hz:linear",
            "has 2 values after the name; drawn:F:linear",
        ),
    ] {
        let error = Waveform::parse(text, 1.0).unwrap_err().to_string();
        assert!(error.contains(words), "{text}: {error}");
    }
}
