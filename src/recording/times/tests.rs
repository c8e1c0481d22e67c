use crate::recording::times::clock::{Judgement, judge_rows, judge_steps};
use crate::recording::times::exact_time::ExactTime;
use crate::recording::times::rounding::Printed;
use crate::recording::times::short_number::Interval;
use crate::recording::{GAP_FACTOR, WarningKind};

/// Times that follow each other by `steps` \[s\].
fn summed(steps: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut t = 0.0;
    let later = steps.map(move |step| {
        t += step;
        t
    });
    [0.0].into_iter().chain(later).collect()
}

/// Independent numbers of a bell curve, without a crate: a sum of twelve.
fn bell(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        let uniform = |state: &mut u64| {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform(&mut state)).sum::<f64>() - 6.0
    }
}

/// Nanoseconds are written.
const PRINTED: Printed = Printed {
    last_place: -9,
    most_digits: 999_999_999,
    unit: 0,
    factor: 1.0,
};

fn kind(time: &[f64], readings: &[f64]) -> Option<WarningKind> {
    judge_steps(time, readings, 0.0, PRINTED, GAP_FACTOR).map(|found| found.kind)
}

#[test]
fn exact_times_add_up_without_rounding() {
    let t = |seconds: f64| ExactTime::from_seconds(seconds);
    let far = t(1_732_752_000.0).plus(&t(2e-5));
    assert_eq!(far.to_string(), "1732752000.00002");
    assert_eq!(far.minus(&t(1_732_752_000.0)), t(2e-5));
    assert_eq!(t(-0.01).plus(&t(0.01)), ExactTime::default());
    assert_eq!(
        t(1.0).minus(&t(1e-30)).to_string(),
        format!("0.{}", "9".repeat(30))
    );
    for (value, text) in [
        (0.0, "0"),
        (-0.0, "0"),
        (-0.01, "-0.01"),
        (1.5, "1.5"),
        (100.0, "100"),
        (2e-9, "2e-9"),
        (-1.25e30, "-1.25e30"),
    ] {
        assert_eq!(t(value).to_string(), text);
        assert_eq!(t(value).seconds(), value);
    }
    assert_eq!(t(f64::NAN), ExactTime::default());
    assert_eq!(t(1e300).minus(&t(5e-324)).seconds(), 1e300);
}

#[test]
fn an_interval_is_the_shortest_number_that_fits() {
    let within = |low: f64, high: f64| Interval::within(low, high);
    assert_eq!(within(1.99999e-5, 2.00002e-5).seconds(), 2e-5);
    assert_eq!(
        within(1.99999e-5, 2.00002e-5).times(3),
        6e-5,
        "rounded once"
    );
    assert_eq!(
        within(2.083333e-5, 2.083334e-5).times(48_000),
        1.0,
        "48 kHz"
    );
    assert_eq!(within(0.03333333, 0.03333334).times(30), 1.0, "30 Hz");
    assert_eq!(within(2e-5, 2e-5).seconds(), 2e-5);
}

#[test]
fn stamps_that_jitter_are_told_from_uneven_samples() {
    let (n, dt, jitter) = (20_000, 2e-5, 3e-6);
    let mut random = bell(1);
    let even: Vec<f64> = (0..n).map(|i| f64::from(i) * dt).collect();
    let off: Vec<f64> = even.iter().map(|_| jitter * random()).collect();
    let stamps: Vec<f64> = even.iter().zip(&off).map(|(t, o)| t + o - off[0]).collect();
    let motion = |t: &f64| 1e-4 * (600.0 * t).sin();
    let noise: Vec<f64> = even.iter().map(|_| 20e-9 * random()).collect();
    let read = |time: &[f64]| -> Vec<f64> {
        time.iter()
            .map(motion)
            .zip(&noise)
            .map(|(x, e)| x + e)
            .collect()
    };

    // The clock is even and is read with jitter.
    let found = judge_steps(&stamps, &read(&even), 0.0, PRINTED, GAP_FACTOR).unwrap();
    assert_eq!(found.kind, WarningKind::TimeJitter);
    let times = found.times.unwrap();
    assert_eq!(times.interval, dt);
    assert!((times.first_shift + off[0]).abs() < 0.1 * jitter);
    let nearest = |(t, e): (&f64, &f64)| (t - e).abs() < 1e-12;
    assert!(times.time.iter().zip(&even).all(nearest), "the even times");
    assert!(found.count > n as usize * 9 / 10 && times.changed == found.count);
    assert!(found.message.contains("jitter by") && found.message.contains("readings are smoother"));

    // A sampler that is late and says so: the readings belong to the stamps.
    assert_eq!(
        kind(&stamps, &read(&stamps)),
        Some(WarningKind::UnevenSampling)
    );
    // Readings that show nothing.
    let still = vec![0.0; n as usize];
    assert_eq!(kind(&stamps, &still), Some(WarningKind::TimeJitter));

    // Intervals that are uneven by themselves add up.
    let walk = summed((1..n).map(|_| dt + jitter * random()));
    assert_eq!(kind(&walk, &read(&walk)), Some(WarningKind::UnevenSampling));
    assert_eq!(kind(&walk, &still), Some(WarningKind::UnevenSampling));
    // Few rows prove nothing.
    assert_eq!(kind(&stamps[..60], &still[..60]), None);
}

#[test]
fn jitter_is_seen_across_gaps_and_lost_rows() {
    let mut random = bell(5);
    let ticks = (0..30_000).filter(|i| i % 5000 < 4000 && i % 97 != 5);
    let (mut even, mut stamps) = (Vec::new(), Vec::new());
    for i in ticks {
        even.push(f64::from(i) * 2e-5);
        stamps.push(f64::from(i) * 2e-5 + 1e-6 * random());
    }
    let first = stamps[0];
    stamps.iter_mut().for_each(|t| *t -= first);
    let still = vec![0.0; stamps.len()];
    let found = judge_steps(&stamps, &still, 0.0, PRINTED, GAP_FACTOR).unwrap();
    assert_eq!(found.kind, WarningKind::TimeJitter);
    let times = found.times.unwrap();
    // Where a gap ends is known from the stamps alone.
    let near = |(t, e): (&f64, &f64)| (t + times.first_shift - (e - first)).abs() < 2e-7;
    assert!(times.time.iter().zip(&even).all(near));
}

#[test]
fn even_times_stay_bit_for_bit_as_they_are() {
    let time: Vec<f64> = (0..5000).map(|i| f64::from(i) * 2e-5).collect();
    assert!(matches!(
        judge_rows(&time, 0.0, PRINTED),
        Judgement::Settled(None)
    ));
    // Rows that are lost, and gaps, are no rounding.
    let some: Vec<f64> = time
        .iter()
        .enumerate()
        .filter(|(i, _)| i % 700 != 5)
        .map(|t| *t.1)
        .collect();
    assert!(matches!(judge_rows(&some, 0.0, PRINTED), Judgement::Open));
    assert_eq!(kind(&some, &some), None);
    let gaps: Vec<f64> = time
        .iter()
        .enumerate()
        .filter(|(i, _)| i % 700 > 50)
        .map(|t| *t.1)
        .collect();
    assert_eq!(kind(&gaps, &gaps), None);
}

#[test]
fn single_precision_must_be_single_precision() {
    // Far from zero every time is within a step of single precision of anything.
    let mut random = bell(3);
    let walk = summed((1..3000).map(|_| 2e-5 + 3e-6 * random()));
    let still = vec![0.0; walk.len()];
    let found = judge_steps(&walk, &still, 1_732_752_000.0, PRINTED, GAP_FACTOR);
    assert_eq!(found.map(|f| f.kind), Some(WarningKind::UnevenSampling));
}
