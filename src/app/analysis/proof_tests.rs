//! After a diagnosis is accepted, Tune shows the numbers of its proof.

use std::sync::atomic::AtomicBool;

use eframe::egui::Context;

use crate::app::flows::load_example;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::View;
use crate::app::simulation::stretch_misfits::stretch_misfits;
use crate::app::state::State;
use crate::model::drive::Waveform;

/// Largest relative difference of the two numbers.
const MAX_DIFFERENCE: f64 = 0.01;

#[test]
fn the_accepted_device_has_the_misfits_of_the_proof_in_tune() {
    let _ = env_logger::builder()
        .is_test(true)
        .filter_level(log::LevelFilter::Debug)
        .try_init();
    let mut state = State::new(crate::app::files::built_in::setup(), View::default());
    load_example::load(&mut state, &mut 0).unwrap();
    let context = Context::default();
    state.diagnosing.start(&state.setup, None, &context);
    while !state.diagnosing.take() {
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert_eq!(state.diagnosing.error, None);
    let answer = state.diagnosing.shown().unwrap().clone();
    let diagnosis = &answer.diagnosis;
    assert!(!diagnosis.named.is_empty());
    // What Tune computes for the recordings in view.
    let overlays: Vec<Overlay> = answer
        .asked
        .recordings
        .iter()
        .map(|used| {
            let all = state.setup.overlays.iter();
            all.clone().find(|o| o.id == used.id).unwrap().clone()
        })
        .collect();
    let cancel = AtomicBool::new(false);
    let shown = stretch_misfits(&diagnosis.model, &overlays, Some(&Waveform::Rest), &cancel);
    let mut off = Vec::new();
    for (used, shown) in answer.asked.recordings.iter().zip(shown) {
        let mut proofs = diagnosis.proof.iter();
        let proof = proofs.find(|p| p.recording == used.recording.name).unwrap();
        let (shown, after) = (shown.unwrap(), proof.distance.after);
        println!(
            "{}: proof {:.4e} of {:.4e}, Tune {:.4e} of {:.4e}, chi2 {:.4} {:.4}, {} samples, proof {} of {}",
            proof.recording,
            after.rms,
            proof.noise,
            shown.distance.rms,
            shown.noise,
            after.chi2,
            shown.distance.chi2,
            shown.samples,
            proof.covered,
            used.recording.len(),
        );
        let times = (shown.distance.rms / shown.noise) / (after.rms / proof.noise) - 1.0;
        let rms = shown.distance.rms / after.rms - 1.0;
        if rms.abs() > MAX_DIFFERENCE || times.abs() > MAX_DIFFERENCE {
            off.push(format!(
                "{}: rms {rms:.4}, times noise {times:.4}",
                proof.recording
            ));
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}
