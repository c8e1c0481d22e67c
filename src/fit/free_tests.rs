//! Tests of what is left free, and how far.

use super::options::FitOptions;
use super::tests::{made, off, options, paper, part, run};
use crate::model::effects::{ActiveEffect, find};

#[test]
fn a_further_mode_is_fitted_with_all_that_is_free_by_default() {
    let mut truth = paper();
    let mode = find("extra_mode").unwrap();
    truth.effects.push(ActiveEffect::new(mode));
    let parts = vec![part(made(&truth, "square:100Hz:8V", 0.02, 3))];
    let start = off(truth.clone(), &[("extra_mode.f", 1.002), ("eta", 0.9)]);
    let result = run(&start, &parts, &FitOptions::for_model(&truth)).unwrap();
    let of = |id: &str| result.parameters.iter().find(|p| p.id == id).unwrap();
    let f = of("extra_mode.f");
    let off = (f.value - 19175.0).abs();
    assert!(off < 4.0 * f.std_error, "{f:?}");
    assert!(off < 0.002 * 19175.0, "{f:?}");
    assert_eq!(result.model.get("extra_mode.phi_c2"), Some(0.0));
}

#[test]
fn values_stay_within_their_bounds() {
    // A ground that throws the mass off faster than it came.
    let mut truth = paper();
    truth.set("alpha", 1.0).unwrap();
    truth.set("Ca0", 0.0).unwrap();
    let parts = vec![part(made(&truth, "square:300Hz:6V", 0.02, 5))];
    let start = off(truth.clone(), &[("alpha", 0.6)]);
    let result = run(&start, &parts, &options(&["alpha", "eta", "dp"])).unwrap();
    let alpha = result.model.get("alpha").unwrap();
    assert!(alpha <= 1.0, "{alpha}");
    result.model.check().unwrap();
}
