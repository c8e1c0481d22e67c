use std::sync::atomic::{AtomicBool, Ordering};

use super::super::orbit::*;
use crate::explore::map::Axis;
use crate::explore::test_support::{amplitude, hardening, linear, natural_frequency};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;

static NEVER: AtomicBool = AtomicBool::new(false);

fn request(
    model: Model,
    drive: &str,
    (id, from, to, count): (&str, f64, f64, usize),
) -> OrbitRequest {
    let drive = Waveform::parse(drive, 1.0).unwrap();
    let axis = Axis::new(id, (&model, &drive), (from, to), count).unwrap();
    OrbitRequest::new(model, drive, axis)
}

#[test]
fn neighbours_on_a_linear_device_come_together_as_the_transient_dies() {
    let zeta = 0.1;
    let model = linear(zeta);
    let f1 = natural_frequency(&model);
    let request = request(model, "sine:1Hz:1V", ("f", 0.7 * f1, 2.0 * f1, 4));
    let diagram = compute(&request, &NEVER, &mut |_| {}).unwrap();
    for slice in diagram.up.iter().chain(&diagram.down) {
        let answer = slice.answer.as_ref().unwrap();
        let exact = -std::f64::consts::TAU * zeta * f1 / slice.value;
        let found = answer.lyapunov.unwrap();
        // A neighbour's distance wobbles over a turn; 60 periods leave some percent of it.
        assert!((found / exact - 1.0).abs() < 0.05, "{found} {exact}");
        assert_eq!((answer.strobes.len(), answer.multiple), (1, Some(1)));
    }
    assert!(diagram.coexisting(1e-3).is_empty());
}

/// Duffing's oscillator: the branch of large responses ends where harmonic balance says.
#[test]
fn a_hardening_spring_jumps_down_later_than_up() {
    let (zeta, shift) = (0.02, 0.32);
    let plain = linear(zeta);
    let f1 = natural_frequency(&plain);
    let size = amplitude(&plain, f1, 1.0);
    let model = hardening(zeta, size, shift);
    let axis = ("f", 0.97 * f1, 1.2 * f1, 47);
    let mut request = request(model, "sine:1Hz:1V", axis);
    request.lyapunov_periods = 0;
    let mut seen = 0;
    let diagram = compute(&request, &NEVER, &mut |_| seen += 1).unwrap();
    assert_eq!(seen, 94);
    // At the fold the response lags by a quarter: a = 1/w, and w^2 = 1 + shift a^2.
    let fold = (0.5 * (1.0 + (1.0 + 4.0 * shift).sqrt())).sqrt();
    let jump = |slices: &[OrbitSlice]| {
        let size =
            |slice: &OrbitSlice| slice.answer.as_ref().unwrap().strobes[0].displacement.abs();
        let change = |k: &usize| (size(&slices[*k + 1]) - size(&slices[*k])).abs();
        let last = slices.len() - 1;
        let at = (0..last)
            .max_by(|a, b| change(a).total_cmp(&change(b)))
            .unwrap();
        0.5 * (slices[at].value + slices[at + 1].value) / f1
    };
    let (up, down) = (jump(&diagram.up), jump(&diagram.down));
    assert!((up / fold - 1.0).abs() < 0.02, "{up} {fold}");
    assert!(down < up - 0.03, "{down} {up}");
    let coexisting = diagram.coexisting(0.05);
    assert!(!coexisting.is_empty());
    for index in coexisting {
        let share = request.map.axes[0].value(index) / f1;
        assert!(share > down - 0.01 && share < up + 0.01, "{share}");
    }
}

#[test]
fn holes_and_new_beginnings_have_reasons() {
    // The ground rises past the mass that rests on it, and then past gp.
    let mut request = request(
        Preset::default().model,
        "square:50Hz:7V",
        ("gp", 50e-6, 75e-6, 3),
    );
    request.lyapunov_periods = 0;
    let diagram = compute(&request, &NEVER, &mut |_| {}).unwrap();
    let first = diagram.up[0].answer.as_ref().unwrap_err();
    assert!(first.contains("must exceed dp"), "{first}");
    assert!(diagram.up[2].answer.is_ok());
    let two = OrbitRequest {
        map: crate::explore::map::MapRequest {
            axes: vec![request.map.axes[0].clone(); 2],
            ..request.map.clone()
        },
        ..request
    };
    assert!(two.check().is_err());
}

#[test]
fn cancelling_keeps_the_values_done() {
    let request = request(
        Preset::default().model,
        "square:50Hz:7V",
        ("V", 2.0, 8.0, 30),
    );
    let cancel = AtomicBool::new(false);
    let diagram = compute(&request, &cancel, &mut |slice| {
        cancel.store(slice.index == 4, Ordering::Relaxed);
    });
    let diagram = diagram.unwrap();
    assert_eq!((diagram.up.len(), diagram.down.len()), (5, 0));
}
