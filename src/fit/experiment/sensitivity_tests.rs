//! The suggested value of one changed parameter is the true one, and at the truth nothing is gained.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::super::sensitivity::*;
use crate::fit::experiment::{Experiment, ExperimentError, ExperimentResult};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::parameter::{ParameterId, Scale};
use crate::model::preset::Preset;
use crate::model::sensor::gaussian;
use crate::recording::Recording;
use crate::recording::align::Alignment;
use crate::sim::{Options, simulate};

/// The motion of `model` as read at `rate` \[Hz\] with white noise \[m\].
fn experiment(model: &Model, drive: &Waveform, rate: f64, duration: f64, noise: f64) -> Experiment {
    let options = Options {
        rate,
        ..Options::default()
    };
    let trace = simulate(model, drive, duration, &options).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let readings = trace.proof_mass.iter();
    let readings = readings.map(|x| x + noise * gaussian(&mut rng)).collect();
    let time = (0..trace.len()).map(|i| i as f64 / rate).collect();
    let recording = Recording::new("test", time, None, readings, None).unwrap();
    let alignment = Alignment::default();
    let mut experiment = Experiment::new(Arc::new(recording), drive.clone(), alignment);
    experiment.noise = (noise, None);
    experiment
}

type Ran = Result<Option<ExperimentResult>, ExperimentError>;

fn probe(model: &Model, id: &str, share: f64) -> Probe {
    let value = model.get(id).unwrap();
    let spec = ParameterId::from_id(id).unwrap().spec();
    Probe {
        id: id.to_owned(),
        step: share * value.abs(),
        scale: spec.scale,
        limits: spec.limits,
    }
}

fn found(model: &Model, experiment: &Experiment, probes: &[Probe]) -> Sensitivity {
    let all = std::slice::from_ref(experiment);
    let run = |_, model: &Model| experiment.run(model, || true);
    sensitivity(model, all, probes, &run, &|| {})
        .unwrap()
        .unwrap()
}

/// A mass on a spring that rings down, read for 5 s with noise of 20 um.
fn ringing() -> (Model, Experiment) {
    let model = Preset::embedded("oscillator").unwrap().model;
    let mut experiment = experiment(&model, &Waveform::Rest, 100.0, 5.0, 20e-6);
    experiment.priors = None;
    (model, experiment)
}

#[test]
fn one_changed_parameter_of_a_linear_device_is_found_within_two_percent_of_the_change() {
    let (truth, experiment) = ringing();
    for (id, factor) in [("zeta1", 1.1), ("f1", 1.0005), ("x0", 0.98)] {
        let mut model = truth.clone();
        let value = truth.get(id).unwrap();
        model.set(id, factor * value).unwrap();
        // The motion is linear in the value itself, not in its logarithm.
        let probe = Probe {
            scale: Scale::Linear,
            ..probe(&model, id, 0.01)
        };
        let result = found(&model, &experiment, &[probe]);
        let influence = &result.influences[0];
        let suggestion = influence.suggestion.unwrap();
        let change = (factor - 1.0) * value;
        let error = (suggestion.value - value) / change;
        assert!(error.abs() < 0.02, "{id}: {error}: {suggestion:?}");
        assert!(suggestion.is_linear, "{id}: {suggestion:?}");
        // What is gained is nearly all that was lost, and was simulated.
        let truth = found(&truth, &experiment, &[]);
        assert!(influence.gain > 0.9 * (result.chi2 - truth.chi2), "{id}");
        assert!(suggestion.chi2 < truth.chi2 + 0.05 * (result.chi2 - truth.chi2));
        assert!(result.misfit() > 1.2 && truth.misfit() < 1.1, "{id}");
    }
}

#[test]
fn at_the_truth_nothing_is_gained() {
    let (truth, experiment) = ringing();
    let probes = ["zeta1", "f1", "x0"].map(|id| probe(&truth, id, 0.01));
    let result = found(&truth, &experiment, &probes);
    assert_eq!(result.influences.len(), 3);
    for influence in &result.influences {
        // Chi squared of one degree of freedom.
        assert!(
            influence.gain < 16.0,
            "{}: {}",
            influence.id,
            influence.gain
        );
    }
    assert!((result.misfit() - 1.0).abs() < 0.15, "{}", result.misfit());
}

#[test]
fn a_column_is_the_change_for_the_stated_step() {
    let (truth, experiment) = ringing();
    let result = found(&truth, &experiment, &[probe(&truth, "x0", 0.01)]);
    let column = &result.influences[0].columns[0];
    assert_eq!(column.len(), result.times[0].len());
    // 1 % of 0.1 m is 1 mm, 50 times the noise; the mass starts there.
    assert!((column[0] - 50.0).abs() < 0.5, "{}", column[0]);
    let squares: f64 = column.iter().map(|j| j * j).sum();
    let rms = (squares / column.len() as f64).sqrt();
    assert!((result.influences[0].rms - rms).abs() < 1e-9 * rms);
}

#[test]
fn a_device_that_bounces_comes_nearer_and_is_checked_by_a_run() {
    let truth = Preset::embedded("paper").unwrap().model;
    let drive = Waveform::parse("square:15Hz:8V", 0.2).unwrap();
    let experiment = experiment(&truth, &drive, 50e3, 0.2, 20e-9);
    let value = truth.get("eta").unwrap();
    let mut model = truth.clone();
    model.set("eta", 1.001 * value).unwrap();
    let ids = ["eta", "alpha", "Cs"];
    let at = |model: &Model| {
        let probes = ids.map(|id| probe(model, id, 0.01));
        found(model, &experiment, &probes)
    };
    let off = at(&model);
    let eta = &off.influences[0];
    let suggestion = eta.suggestion.expect("a better value is on the way");
    let error = (suggestion.value - value) / (1e-3 * value);
    assert!(error.abs() < 0.5, "{error}: {suggestion:?}");
    assert!(suggestion.chi2 < off.chi2);
    let right = at(&truth);
    for (before, after) in off.influences.iter().zip(&right.influences) {
        assert!(after.gain < 25.0, "{}: {}", after.id, after.gain);
        assert!(after.id != "eta" || before.gain > 100.0 * after.gain.max(1.0));
    }
}

#[test]
fn what_the_instrument_takes_up_and_what_does_nothing_has_no_influence() {
    let (model, mut experiment) = ringing();
    let mut probes: Vec<Probe> = ["noise", "offset_p"]
        .map(|id| Probe {
            id: id.to_owned(),
            step: 1e-3,
            scale: Scale::Linear,
            limits: (-1.0, 1.0),
        })
        .into();
    probes[0].limits.0 = 0.0;
    experiment.priors = Some(Default::default());
    let result = found(&model, &experiment, &probes);
    assert_eq!(result.without_influence, ["noise", "offset_p"]);
    assert!(result.influences.is_empty() && result.failed.is_empty());
}

#[test]
fn at_a_limit_the_difference_is_one_sided_and_the_suggestion_keeps_to_it() {
    let (truth, experiment) = ringing();
    let value = truth.get("zeta1").unwrap();
    let mut model = truth.clone();
    model.set("zeta1", 1.1 * value).unwrap();
    let mut probe = probe(&model, "zeta1", 0.01);
    probe.limits = (1.1 * value, 1.0);
    let result = found(&model, &experiment, std::slice::from_ref(&probe));
    assert!(result.influences[0].steps_to_best < 0.0);
    assert_eq!(result.influences[0].suggestion, None);
    probe.limits = (1.05 * value, 1.1 * value);
    let result = found(&model, &experiment, &[probe]);
    let suggestion = result.influences[0].suggestion.unwrap();
    assert!((suggestion.value - 1.05 * value).abs() < 1e-12 * value);
    assert!(!suggestion.is_linear);
}

#[test]
fn what_cannot_be_moved_is_named_and_a_stop_gives_nothing() {
    let (model, experiment) = ringing();
    let unknown = Probe {
        id: "none_such".to_owned(),
        step: 1.0,
        scale: Scale::Linear,
        limits: (0.0, 1.0),
    };
    let probes = [unknown, probe(&model, "zeta1", 0.01)];
    let heard = AtomicUsize::new(0);
    let all = std::slice::from_ref(&experiment);
    let done = || {
        heard.fetch_add(1, Ordering::Relaxed);
    };
    let run = |_, model: &Model| experiment.run(model, || true);
    let result = sensitivity(&model, all, &probes, &run, &done)
        .unwrap()
        .unwrap();
    assert_eq!(heard.load(Ordering::Relaxed), 2);
    assert_eq!(result.failed.len(), 1);
    assert_eq!(result.failed[0].0, "none_such");
    assert_eq!(result.influences.len(), 1);
    let stopped = |_: usize, _: &Model| -> Ran { Ok(None) };
    let result = sensitivity(&model, all, &probes, &stopped, &|| {});
    assert_eq!(result.unwrap(), None);
}

#[test]
fn columns_of_one_shape_are_twins_whatever_their_sign_and_size() {
    let influence = |id: &str, column: Vec<f64>| Influence {
        id: id.to_owned(),
        value: 1.0,
        step: 0.01,
        columns: vec![column],
        rms: 1.0,
        gain: 0.0,
        steps_to_best: -2.0,
        suggestion: None,
    };
    let wave: Vec<f64> = (0..100).map(|i| (0.3 * f64::from(i)).sin()).collect();
    let against = wave.iter().map(|j| -3.0 * j).collect();
    let mut gap = wave.clone();
    gap[7] = f64::NAN;
    let other = (0..100).map(|i| (0.3 * f64::from(i)).cos()).collect();
    let influences = vec![
        influence("a", wave.clone()),
        influence("b", against),
        influence("c", other),
    ];
    let mut all = Sensitivity {
        strides: vec![1],
        influences,
        ..Sensitivity::default()
    };
    let twins = all.twins(0.95);
    assert_eq!(twins.len(), 1, "{twins:?}");
    assert_eq!((twins[0].0, twins[0].1), (0, 1));
    assert!((twins[0].2 + 1.0).abs() < 1e-9);
    // A sample that was not compared does not spoil it.
    all.influences[0] = influence("a", gap);
    assert_eq!(all.twins(0.95).len(), 1);
    // The part that is taken away is what the present residual has of the column.
    assert_eq!(all.influences[1].explained(0)[5], 2.0 * -3.0 * wave[5]);
}
