use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::recording::{Channel, Recording, WarningKind};

const DT: f64 = 2e-5;

/// A drive that never repeats: a sweep between the levels of a square wave.
fn volts(t: f64) -> f64 {
    let sweep = (400.0 * t + 9e3 * t * t).sin();
    8.0 * sweep.signum() + 0.5 * sweep
}

/// A motion under it, with a ring near an eighth of the rate.
fn motion(t: f64) -> f64 {
    let slow = (400.0 * t + 9e3 * t * t - 0.7).sin();
    20e-6 * slow + 1e-6 * (2.0 * std::f64::consts::PI * 6e3 * t).sin()
}

struct Run {
    /// Time on the drive's clock at its first sample \[s\].
    start: f64,
    rows: usize,
    dt: f64,
    noise: f64,
    zero: f64,
    seed: u64,
    level: f64,
}

const PLAIN: Run = Run {
    start: 0.0,
    rows: 6000,
    dt: DT,
    noise: 20e-9,
    zero: 0.0,
    seed: 1,
    level: 1.0,
};

impl Run {
    fn times(&self) -> Vec<f64> {
        (0..self.rows).map(|i| i as f64 * self.dt).collect()
    }

    fn recording(&self, name: &str, motion: impl Fn(f64) -> f64) -> Recording {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let time = self.times();
        let at = |t: &f64| t + self.start;
        let v = time
            .iter()
            .map(|t| self.level * volts(at(t)) + 2e-3 * normal())
            .collect();
        let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
        let x = time
            .iter()
            .map(|t| motion(at(t)) + self.zero + self.noise * normal())
            .collect();
        Recording::new(name, time.clone(), Some(v), x, None).unwrap()
    }
}

fn said(recording: &Recording) -> String {
    let all: Vec<&str> = recording
        .warnings
        .iter()
        .map(|w| w.message.as_str())
        .collect();
    all.join("\n")
}

#[test]
fn two_runs_are_merged_by_their_voltage() {
    let first = PLAIN.recording("tip.csv", motion);
    for (late, rate) in [(1.2345e-3, 1.0), (-0.0, 1.0), (-3.21e-3, 1.0), (4e-4, 1.25)] {
        let centre = |t: f64| 0.3 * motion(t);
        let second = Run {
            start: late,
            seed: 2,
            dt: DT / rate,
            ..PLAIN
        };
        let second = second.recording("centre.csv", centre);
        let both = merge_points(&first, &second, None).unwrap();
        let text = said(&both);
        assert!(
            text.contains("the voltages of the two runs differ by"),
            "{text}"
        );
        assert!(text.contains("centre.csv is laid over tip.csv"), "{text}");
        let xc = both.cantilever.as_ref().unwrap();
        let rms = |shift: usize| {
            let pairs = both.time.iter().zip(xc).skip(shift);
            let squares: Vec<f64> = pairs.map(|(t, x)| (x - centre(*t)).powi(2)).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        // The noise of the readings, and what the edges leave open of the lag.
        assert!(rms(0) < 60e-9, "{late}: {}", rms(0));
        // The rows of xp are those of its file.
        let skip = first.time.iter().position(|t| *t == both.time[0]).unwrap();
        assert_eq!(
            both.proof_mass[..],
            first.proof_mass[skip..skip + both.len()]
        );
        assert!((both.len() as f64) < first.len() as f64 - (late.abs() / DT) * 0.9 + 2.0);
        assert!(both.warnings.iter().all(|w| w.kind == WarningKind::Merged));
    }
}

#[test]
fn runs_that_do_not_belong_together_are_refused() {
    let first = PLAIN.recording("tip.csv", motion);
    let weak = Run {
        level: 0.8,
        ..PLAIN
    }
    .recording("weak.csv", motion);
    let error = merge_points(&first, &weak, None).unwrap_err();
    assert!(
        matches!(error, CombineError::VoltagesDiffer { .. }),
        "{error}"
    );
    let text = error.to_string();
    assert!(
        text.contains("0.8") && text.contains("--scale V="),
        "{text}"
    );
    let mut silent = PLAIN.recording("silent.csv", motion);
    silent.voltage = None;
    let error = merge_points(&first, &silent, None).unwrap_err();
    assert!(matches!(error, CombineError::NoVoltage { .. }), "{error}");
    // With a lag that is given it needs none.
    let both = merge_points(&first, &silent, Some(0.0)).unwrap();
    assert!(said(&both).contains("taken on trust"), "{}", said(&both));
    let mut still = PLAIN.recording("still.csv", motion);
    still.voltage = Some(vec![5.0; still.len()]);
    let error = merge_points(&first, &still, None).unwrap_err();
    assert!(
        matches!(error, CombineError::ConstantVoltage { .. }),
        "{error}"
    );
    let mut other = PLAIN.recording("other.csv", motion);
    other.voltage = Some(other.time.iter().map(|t| 8.0 * (9e3 * t).sin()).collect());
    let error = merge_points(&first, &other, None).unwrap_err();
    assert!(matches!(error, CombineError::NoMatch { .. }), "{error}");
    let both = merge_points(&first, &PLAIN.recording("x", motion), None).unwrap();
    let error = merge_points(&both, &first, None).unwrap_err();
    assert!(
        matches!(error, CombineError::HasBothPoints { .. }),
        "{error}"
    );
}

#[test]
fn trials_are_averaged_and_their_spread_is_the_noise() {
    let starts = [0.0, 3.3e-4, -7.77e-4, 1e-3, 2e-5];
    let trials: Vec<Recording> = starts
        .iter()
        .enumerate()
        .map(|(i, start)| {
            Run {
                start: *start,
                seed: i as u64,
                rows: 6000 - 100 * i,
                ..PLAIN
            }
            .recording(&format!("run {i}"), motion)
        })
        .collect();
    let all: Vec<&Recording> = trials.iter().collect();
    let found = average(&all, AverageOptions::default()).unwrap();
    let mean = &found.recording;
    for (trial, start) in found.trials.iter().zip(starts) {
        let lag = trial.lag.unwrap();
        assert!((lag - start).abs() < 0.1 * DT, "{lag} {start}");
        assert!(trial.is_used && trial.misfit.is_none(), "{trial:?}");
    }
    let pairs = mean.time.iter().zip(&mean.proof_mass);
    let squares: Vec<f64> = pairs.map(|(t, x)| (x - motion(*t)).powi(2)).collect();
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    // 20 nm of noise over the root of five, and what is open of the lags.
    assert!(rms < 20e-9, "{rms}");
    let spread = mean.spread.as_ref().unwrap();
    assert_eq!(spread.trials, 5);
    assert_eq!(
        spread.deviations(Channel::ProofMass).unwrap().len(),
        mean.len()
    );
    let noise = mean.noise(Channel::ProofMass).unwrap().sigma;
    assert!((7e-9..14e-9).contains(&noise), "{noise}");
    let text = said(mean);
    for part in [
        "the mean of 5 trials",
        "laid over run 0",
        "long, run 0 is",
        "the trials differ in",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn without_a_voltage_the_motion_says_the_lag() {
    let mut trials: Vec<Recording> = [0.0, 5.5e-4]
        .iter()
        .map(|start| {
            Run {
                start: *start,
                ..PLAIN
            }
            .recording("run", motion)
        })
        .collect();
    trials.iter_mut().for_each(|r| r.voltage = None);
    let all: Vec<&Recording> = trials.iter().collect();
    let found = average(&all, AverageOptions::default()).unwrap();
    assert!((found.trials[1].lag.unwrap() - 5.5e-4).abs() < 0.05 * DT);
    assert!(said(&found.recording).contains("by their motion"));
}

#[test]
fn what_does_not_belong_is_named_and_left_out_by_choice() {
    let run = |name: &str, seed: u64| Run { seed, ..PLAIN }.recording(name, motion);
    let other =
        Run { seed: 9, ..PLAIN }.recording("other", |t| motion(t) + 8e-6 * (300.0 * t).sin());
    let weak = Run {
        level: 0.7,
        seed: 8,
        ..PLAIN
    }
    .recording("weak", motion);
    let (a, b, c) = (run("a", 1), run("b", 2), run("c", 3));
    // The first may be the one that does not belong.
    for trials in [[&a, &b, &weak], [&weak, &a, &b]] {
        let error = average(&trials, AverageOptions::default()).unwrap_err();
        assert!(
            matches!(error, CombineError::DoNotBelong { count: 1, .. }),
            "{error}"
        );
        let text = error.to_string();
        assert!(
            text.contains("(weak)") && text.contains("--leave-out-misfits"),
            "{text}"
        );
        let leave = AverageOptions {
            leave_out_misfits: true,
            ..AverageOptions::default()
        };
        let found = average(&trials, leave).unwrap();
        let used: Vec<&str> = found
            .trials
            .iter()
            .filter(|t| t.is_used)
            .map(|t| t.name.as_str())
            .collect();
        assert_eq!(used, ["a", "b"]);
        assert!(said(&found.recording).contains("it is left out"));
    }
    let trials = [&a, &other, &b, &c];
    let kept = average(&trials, AverageOptions::default()).unwrap();
    assert!(matches!(
        kept.trials[1].misfit,
        Some(Misfit::OtherMotion { .. })
    ));
    assert!(kept.trials.iter().all(|t| t.is_used));
    assert!(said(&kept.recording).contains("trial 2 (other) does not belong"));
    let leave = AverageOptions {
        leave_out_misfits: true,
        ..AverageOptions::default()
    };
    let left = average(&trials, leave).unwrap();
    assert!(!left.trials[1].is_used);
    assert_eq!(left.recording.spread.as_ref().unwrap().trials, 3);
    let error = average(&[&a], leave).unwrap_err();
    assert!(
        matches!(error, CombineError::TooFew { found: 1 }),
        "{error}"
    );
    let error = average(&[&a, &weak], leave).unwrap_err();
    assert!(
        matches!(error, CombineError::NothingLeft { left: 1, .. }),
        "{error}"
    );
}

#[test]
fn zeros_are_said_and_matched_by_choice() {
    let trials: Vec<Recording> = [(1, 0.0), (2, 3e-6), (3, -1.5e-6)]
        .map(|(seed, zero)| {
            Run {
                seed,
                zero,
                ..PLAIN
            }
            .recording("run", motion)
        })
        .into();
    let all: Vec<&Recording> = trials.iter().collect();
    let as_is = average(&all, AverageOptions::default()).unwrap();
    let zeros: Vec<f64> = as_is.trials.iter().map(|t| t.zero.unwrap()).collect();
    for (found, zero) in zeros.iter().zip([-0.5e-6, 2.5e-6, -2e-6]) {
        assert!((found - zero).abs() < 5e-9, "{found}");
    }
    let deviation = |a: &Average| {
        let spread = a.recording.spread.clone().unwrap();
        spread.mean_deviation(Channel::ProofMass).unwrap()
    };
    assert!(
        (deviation(&as_is) / 2.291e-6 - 1.0).abs() < 0.01,
        "{}",
        deviation(&as_is)
    );
    // A zero is no noise.
    assert!(as_is.recording.noise(Channel::ProofMass).unwrap().sigma < 20e-9);
    let matching = AverageOptions {
        match_zeros: true,
        ..AverageOptions::default()
    };
    let matched = average(&all, matching).unwrap();
    assert!(deviation(&matched) < 30e-9);
    let shift = as_is.recording.proof_mass[100] - matched.recording.proof_mass[100];
    assert!((shift - 0.5e-6).abs() < 5e-9, "{shift}");
    assert!(said(&matched.recording).contains("was made that of the first"));
}

#[test]
fn missing_samples_and_clocks_that_drift_apart() {
    let mut trials: Vec<Recording> = (0..3)
        .map(|seed| Run { seed, ..PLAIN }.recording("run", motion))
        .collect();
    trials[0].proof_mass[2000] = f64::NAN;
    trials[1].proof_mass[3000] = f64::NAN;
    trials[2].proof_mass[3000] = f64::NAN;
    let all: Vec<&Recording> = trials.iter().collect();
    let mean = average(&all, AverageOptions::default()).unwrap().recording;
    // Two of three have it; one has not more than half.
    assert!((mean.proof_mass[2000] - motion(2000.0 * DT)).abs() < 60e-9);
    assert!(mean.proof_mass[3000].is_nan());
    // A clock that runs 200 ppm fast: 24 us over 0.12 s.
    let first = PLAIN.recording("first", motion);
    let mut second = PLAIN.recording("second", motion);
    second.time.iter_mut().for_each(|t| *t *= 1.0 + 1e-3);
    let overlay = lay_over(&first, &second, false).unwrap();
    let found = overlay.clock_difference.unwrap();
    assert!((found / 1e-3 - 1.0).abs() < 0.2, "{found}");
}
