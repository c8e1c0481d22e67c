//! Tests of what a fit says of itself.

use std::sync::Arc;

use crate::fit::inspect::recording_summary::summarize;
use crate::fit::options::{FitOptions, Part};
use crate::fit::problem::huber::Huber;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::prepare;
use crate::fit::solve::point::settle;
use crate::fit::uncertainty::fit_result::*;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::recording::Recording;
use crate::sim::{Options, simulate};

#[test]
fn segments_that_cannot_be_simulated_are_counted_as_set_aside() {
    let model = Preset::default().model;
    let drive = Waveform::parse("sine:50Hz:1V", 0.04).unwrap();
    let trace = simulate(&model, &drive, 0.04, &Options::default()).unwrap();
    let (volts, xc) = (trace.voltage.clone(), trace.cantilever.clone());
    let xp = trace.proof_mass.clone();
    let r = Recording::new("air", trace.times(), Some(volts), xp, Some(xc)).unwrap();
    let parts = [Part::whole(Arc::new(r))];
    let options = FitOptions::for_model(&model);
    let space = Space::new(&model, &options.free).unwrap();
    let summaries = summarize(&model, &parts);
    let prepared = prepare(&model, &space, &parts, &summaries, &options).unwrap();
    let mut x = space.coordinates(&model);
    x.extend_from_slice(&prepared.nuisances);
    let used = vec![true; prepared.segments.len()];
    let segments = &prepared.segments;
    let problem = &prepared.problem;
    let mut point = settle(problem, &x, segments, &used, Huber(3.0), 3).unwrap();
    let whole = misfits(&prepared, &point).unwrap().0;
    assert_eq!(whole.set_aside, 0.0);
    point.segments[0].locals[0] = f64::NAN;
    let broken = misfits(&prepared, &point).unwrap().0;
    let lost = whole.samples - broken.samples;
    assert!(lost > 0 && broken.rms.is_finite());
    let share = lost as f64 / whole.samples as f64;
    assert!((broken.set_aside - share).abs() < 1e-12, "{broken:?}");
}

#[test]
fn the_recording_that_would_determine_a_parameter_is_named() {
    for (id, record) in [
        ("alpha", Some("300 Hz square")),
        ("Ca0", Some("ramped squares of 8 V with several lambda")),
        ("eta", None),
    ] {
        let unknown = FittedParameter {
            id: id.to_owned(),
            value: 1.0,
            std_error: f64::INFINITY,
            unit: "",
            start: 1.0,
            at_bound: false,
        };
        let said = remarks(&[unknown], &DMatrix::identity(1, 1), &[1.0], &[false]);
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].starts_with(id), "{said:?}");
        match record {
            Some(text) => assert!(
                said[0].contains("record") && said[0].contains(text),
                "{said:?}"
            ),
            None => assert!(!said[0].contains("to determine it"), "{said:?}"),
        }
    }
}
