//! The trial's solver against itself, closed forms and the instrument's simulator.

use super::{Kind, Run, run};
use crate::model::Model;
use crate::model::drive::Waveform as ToolWaveform;
use crate::sim::{EventKind, Options, simulate};
use crate::trial::device::reference_device::{excitations, table_beam, table_device, table_modes};
use crate::trial::device::structure::Structure;
use crate::trial::device::{Device, TOLERANCE};
use crate::trial::voltage::pieces;

fn lumped() -> Device {
    table_device(Structure::lumped(&table_modes(), 0.0).unwrap())
}

fn sampled(device: &Device, which: usize, tolerance: f64) -> Run {
    let e = excitations()[which];
    let n = (e.duration * 50e3).round() as usize + 1;
    let times: Vec<f64> = (0..n).map(|i| i as f64 / 50e3).collect();
    let path = pieces(&e.waveform, e.duration);
    run(device, &path, e.duration, &times, tolerance).unwrap()
}

fn worst(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |w, (a, b)| (a - b).abs().max(w))
}

#[test]
fn agrees_with_the_instruments_simulator() {
    for (i, e) in excitations().iter().enumerate() {
        let started = std::time::Instant::now();
        let ours = sampled(&lumped(), i, TOLERANCE);
        let took = started.elapsed();
        let mut model = Model::default();
        // The preset's eta is a rounded 3.819e-7; both sides take the same number.
        model.set("eta", 3.819e-7).unwrap();
        let drive = ToolWaveform::parse(&e.waveform.text(), e.duration).unwrap();
        let theirs = simulate(&model, &drive, e.duration, &Options::default()).unwrap();
        let difference = worst(&ours.proof_mass, &theirs.proof_mass)
            .max(worst(&ours.cantilever, &theirs.cantilever));
        let count = |kind| theirs.events.iter().filter(|x| x.kind == kind).count();
        println!(
            "{}: {difference:.2e} m, {} steps {took:?}, {} events",
            e.waveform.text(),
            ours.steps,
            ours.events.len()
        );
        let own = |kind| ours.events.iter().filter(|x| x.kind == kind).count();
        assert_eq!(own(Kind::Release), count(EventKind::Release));
        assert_eq!(own(Kind::Impact), count(EventKind::Impact));
        assert_eq!(own(Kind::Stick), count(EventKind::Stick));
        assert!(difference < 1e-9);
    }
}

#[test]
fn a_tighter_tolerance_moves_nothing_visible() {
    let beam = table_device(table_beam().unwrap());
    for device in [lumped(), beam] {
        for which in [1, 2, 4] {
            let started = std::time::Instant::now();
            let a = sampled(&device, which, TOLERANCE);
            let took = started.elapsed();
            let b = sampled(&device, which, 0.01 * TOLERANCE);
            let moved = worst(&a.proof_mass, &b.proof_mass);
            println!("{which}: {moved:.2e} m, {} steps, {took:?}", a.steps);
            assert_eq!(a.events.len(), b.events.len());
            assert!(moved < 2e-9);
        }
    }
}
