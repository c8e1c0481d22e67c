//! Tests of the step "drive".

use crate::fit::paper_steps::drive::*;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::sim::{Options, simulate};

fn recording(drive: &str, duration: f64) -> Arc<Recording> {
    let mut model = Preset::default().model;
    model.parameters.set(ParameterId::Noise, 20e-9);
    let drive = Waveform::parse(drive, duration).unwrap();
    let trace = simulate(&model, &drive, duration, &Options::default()).unwrap();
    let mut xp = trace.proof_mass.clone();
    crate::model::sensor::Sensor::new(&model.parameters).add_noise(&mut xp, 3);
    let volts = Some(trace.voltage.clone());
    Arc::new(Recording::new("cycle", trace.times(), volts, xp, None).unwrap())
}

#[test]
fn both_branches_are_recovered_from_slow_cycles() {
    let model = Preset::default().model;
    let (wide, free) = (recording("sine:5Hz:8V", 0.8), recording("sine:5Hz:6V", 0.8));
    let fit = fit_drive(&model, &[wide, free]).unwrap();
    let truth = Piezo::default();
    let (mut worst, piezo) = (0.0f64, fit.piezo());
    for (branch, own) in [
        (Branch::Rising, &fit.rising),
        (Branch::Falling, &fit.falling),
    ] {
        let (low, high) = own.seen;
        assert!(high - low > 6.0, "{branch:?} seen from {low} to {high} V");
        for i in 0..=20 {
            let v = low + (high - low) * f64::from(i) / 20.0;
            worst = worst.max((piezo.gain(v, branch) - truth.gain(v, branch)).abs());
        }
    }
    println!("{:?}: worst {worst}", fit.piezo());
    // How far the branches are apart at the ends is said of the voltages there.
    for (v, gap) in fit.open_ends {
        let apart = truth.gain(v, Branch::Rising) - truth.gain(v, Branch::Falling);
        assert!((gap - apart).abs() < 0.01, "{gap} for {apart} at {v} V");
    }
    assert!(fit.open_ends[0].0 < fit.open_ends[1].0);
    // The loop is 9.7 high; what the ring leaves of its mean is what is left.
    assert!(worst < 0.005, "{worst}");
}

#[test]
fn fast_cycles_are_refused() {
    let model = Preset::default().model;
    let error = fit_drive(&model, &[recording("square:100Hz:8V", 0.1)]).unwrap_err();
    assert!(
        error.to_string().contains("record whole slow cycles"),
        "{error}"
    );
    let still = Recording::new("mute", vec![0.0, 1.0, 2.0], None, vec![0.0; 3], None).unwrap();
    let still = [Arc::new(still)];
    let error = fit_drive(&model, &still).unwrap_err();
    assert!(error.to_string().contains("has no V"), "{error}");
    let faller = Preset::embedded("faller").unwrap().model;
    let error = fit_drive(&faller, &still).unwrap_err();
    assert!(error.to_string().contains("has no drive"), "{error}");
}
#[test]
fn unreadable_recordings_are_refused_before_blocks_are_counted() {
    let model = Preset::default().model;
    let time: Vec<f64> = (0..400).map(|i| 1e-4 * f64::from(i)).collect();
    let volts = |n: usize| Some(time[..n].iter().map(|t| 8.0 * (31.4 * t).sin()).collect());
    let made = |xp: Vec<f64>| {
        let n = xp.len();
        let own = Recording::new("r", time[..n].to_vec(), volts(n), xp, None);
        fit_drive(&model, &[Arc::new(own.unwrap())])
            .unwrap_err()
            .to_string()
    };
    let constant = made(vec![1e-6; 400]);
    assert!(constant.contains("xp is constant"), "{constant}");
    let short = made(vec![1e-6, 2e-6, 3e-6]);
    assert!(short.contains("too few"), "{short}");
    let none = fit_drive(&model, &[]).unwrap_err().to_string();
    assert!(none.contains("no recording"), "{none}");
}
