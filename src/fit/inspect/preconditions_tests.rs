//! Tests of what is refused before a fit begins.

use std::sync::atomic::AtomicBool;

use crate::fit::inspect::preconditions::check;
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::tests::{made, off, options, paper, part, run};
use crate::fit::{Control, FitOptions, Part, Progress, fit};
use crate::model::drive::Waveform;
use crate::recording::Recording;
use crate::sim::{Options, simulate};

#[test]
fn bad_input_is_refused_before_any_computation() {
    let model = paper();
    let good = || made(&model, "sine:50Hz:8V", 0.03, 1);
    let all = FitOptions::for_model(&model);
    let says = |parts: Vec<Part>, options: &FitOptions, words: &str| {
        let error = run(&model, &parts, options).unwrap_err().to_string();
        assert!(error.contains(words), "\"{error}\" should say \"{words}\"");
    };
    says(
        vec![part(good())],
        &options(&[]),
        "all parameters are locked",
    );
    says(
        vec![part(good())],
        &options(&["foo"]),
        "there is no parameter foo",
    );
    says(Vec::new(), &all, "no recording");
    let r = good();
    let few = Recording::new(
        "few",
        r.time[..15].to_vec(),
        None,
        r.proof_mass[..15].to_vec(),
        None,
    );
    says(vec![part(few.unwrap())], &all, "too few");
    let mut none = good();
    none.voltage = None;
    says(vec![part(none)], &all, "no drive channel");
    let mut constant = good();
    constant.proof_mass.fill(1e-5);
    says(vec![part(constant)], &all, "constant");
    let mut saturated = good();
    saturated
        .proof_mass
        .iter_mut()
        .for_each(|x| *x = x.min(40e-6));
    says(vec![part(saturated)], &all, "saturated");
    // Only the highest swings reach the end of the range: these samples are left out.
    let mut clipped = good();
    let top = clipped.proof_mass.iter().copied().fold(f64::MIN, f64::max);
    let most = 0.97 * top;
    clipped.proof_mass.iter_mut().for_each(|x| *x = x.min(most));
    let clipped = [part(clipped)];
    assert!(clipped[0].recording.proof_mass.iter().any(|x| x.is_nan()));
    assert_eq!(
        check(&model, &clipped, &summarize(&model, &clipped), &all),
        Ok(())
    );
    let air = made(&model, "sine:50Hz:1V", 0.03, 1);
    says(vec![part(air)], &all, "no contact");
    let mut other = model.clone();
    other.set("dp", 35e-6).unwrap();
    other.set("gp", 47e-6).unwrap();
    let other = made(&other, "sine:50Hz:8V", 0.03, 2);
    says(vec![part(good()), part(other)], &all, "another device");
    let held = part(made(&model, "sine:50Hz:1V", 0.03, 1));
    assert!(run(&model, &[held], &options(&["eta", "zeta1"])).is_ok());
}

#[test]
fn impossible_fits_are_refused_before_they_begin() {
    let model = paper();
    let good = || made(&model, "sine:50Hz:8V", 0.03, 1);
    let cancel = AtomicBool::new(false);
    let never = |_: &Progress| panic!("it has begun");
    let control = Control {
        cancel: &cancel,
        progress: &never,
    };
    let says = |train: &[Part], held_out: &[Part], free: &[&str], words: &str| {
        let error = fit(&model, train, held_out, &options(free), &control).unwrap_err();
        let error = error.to_string();
        assert!(error.contains(words), "\"{error}\" should say \"{words}\"");
    };
    let usual = ["eta", "dp"];
    // The same recording twice, also under another name and as held out.
    let mut renamed = good();
    renamed.name = "another".to_owned();
    says(&[part(good()), part(renamed)], &[], &usual, "same samples");
    says(&[part(good())], &[part(good())], &usual, "same samples");
    let mut still = good();
    still.voltage.as_mut().unwrap().fill(0.0);
    says(&[part(still)], &[], &usual, "voltage does not move");
    let deep = off(paper(), &[("dp", 72.0 / 58.0), ("gp", 84.0 / 70.0)]);
    let deep = part(made(&deep, "sine:50Hz:8V", 0.03, 1));
    says(
        std::slice::from_ref(&deep),
        &[],
        &usual,
        "ground lies at -72",
    );
    let mut millimetres = good();
    let values = millimetres.proof_mass.iter_mut();
    values.for_each(|x| *x *= 1e3);
    says(&[part(millimetres)], &[], &usual, "check the unit");
    let shallow = off(paper(), &[("dp", 48.0 / 58.0), ("gp", 60.0 / 70.0)]);
    let shallow = part(made(&shallow, "sine:50Hz:8V", 0.03, 2));
    says(&[part(good())], &[shallow], &usual, "another device");
    // The end of the range below, and readings that are missing too often.
    let mut cut = good();
    cut.proof_mass.iter_mut().for_each(|x| *x = x.max(-40e-6));
    says(&[part(cut)], &[], &usual, "lowest value");
    let mut half = good();
    let volts = half.voltage.as_mut().unwrap();
    volts.iter_mut().for_each(|v| *v = v.min(5.0));
    says(&[part(half)], &[], &usual, "V stays at its highest value");
    let mut broken = good();
    let values = broken.proof_mass.iter_mut().enumerate();
    values
        .filter(|(i, _)| i % 6 < 2)
        .for_each(|(_, x)| *x = f64::NAN);
    says(
        &[part(broken)],
        &[],
        &usual,
        "noise of xp cannot be estimated",
    );
}

#[test]
fn noiseless_rest_on_the_ground_is_not_saturation() {
    let model = paper();
    for rate in [20e3, 50e3] {
        let drive = Waveform::parse("square:15Hz:8V", 0.1).unwrap();
        let how = Options {
            rate,
            ..Options::default()
        };
        let trace = simulate(&model, &drive, 0.1, &how).unwrap();
        let (volts, xc) = (trace.voltage.clone(), trace.cantilever.clone());
        let xp = trace.proof_mass.clone();
        let r = Recording::new("clean", trace.times(), Some(volts), xp, Some(xc)).unwrap();
        let parts = [part(r)];
        let summaries = summarize(&model, &parts);
        check(&model, &parts, &summaries, &options(&["eta", "dp"])).unwrap();
    }
}
