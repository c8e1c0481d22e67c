//! Channels that are connected wrongly are recognised, and those that are not are left alone.

use std::sync::Arc;

use crate::fit::inspect::connections::check_connections;
use crate::fit::tests::{made, off, paper, part};
use crate::fit::{FitError, Part};
use crate::model::Model;
use crate::model::preset::Preset;
use crate::recording::Recording;

const SLOW_DRIVES: [&str; 4] = [
    "square:15Hz:8V",
    "sine:10Hz:8V",
    "triangle:8Hz:7V",
    "square:20Hz:4V",
];

/// The recording with each of its channels multiplied.
fn scaled(r: &Recording, (v, xp, xc): (f64, f64, f64)) -> Part {
    let by = |values: &[f64], k: f64| values.iter().map(|x| k * x).collect::<Vec<f64>>();
    let volts = r.voltage.as_deref().map(|values| by(values, v));
    let cantilever = r.cantilever.as_deref().map(|values| by(values, xc));
    let made = Recording::new(
        &*r.name,
        r.time.clone(),
        volts,
        by(&r.proof_mass, xp),
        cantilever,
    );
    part(made.unwrap())
}

fn said(model: &Model, parts: &[Part]) -> String {
    match check_connections(model, parts) {
        Err(error @ FitError::Connection { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn each_mistake_is_named_with_its_remedy() {
    for (i, drive) in SLOW_DRIVES.into_iter().enumerate() {
        let r = made(&paper(), drive, 0.4, i as u64);
        let of = |factors| said(&paper(), &[scaled(&r, factors)]);
        let voltage = of((-1.0, 1.0, 1.0));
        assert!(voltage.contains("--sign V=-1"), "{drive}: {voltage}");
        let reading = of((1.0, -1.0, -1.0));
        assert!(reading.contains("--sign xp=-1"), "{drive}: {reading}");
        let cantilever = of((1.0, 1.0, -1.0));
        assert!(cantilever.contains("--sign xc=-1"), "{drive}: {cantilever}");
        let unit = of((1.0, 1e3, 1e3));
        assert!(unit.contains("--scale xp=0.001"), "{drive}: {unit}");
        let mut exchanged = r.clone();
        let xc = exchanged.cantilever.replace(r.proof_mass.clone()).unwrap();
        exchanged.proof_mass = xc;
        let exchanged = said(&paper(), &[part(exchanged)]);
        assert!(exchanged.contains("exchanged"), "{drive}: {exchanged}");
    }
}

#[test]
fn a_monitor_of_the_voltage_is_named_with_its_factor() {
    for (drive, factor) in [
        ("square:15Hz:8V", 20.0),
        ("sine:10Hz:8V", 20.0),
        ("square:15Hz:8V", 100.0),
    ] {
        let r = made(&paper(), drive, 0.4, 3);
        let text = said(&paper(), &[scaled(&r, (1.0 / factor, 1.0, 1.0))]);
        assert!(
            text.contains(&format!("--scale V={factor}")),
            "{drive}: {text}"
        );
    }
}

#[test]
fn devices_with_parameters_far_off_are_connected_rightly() {
    let ids = ["eta", "dp", "Cs", "zeta1", "f1", "Ca", "alpha", "shape_c1"];
    let mut seed = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let drives = [
        "square:15Hz:8V",
        "sine:50Hz:6V",
        "square:100Hz:8V",
        "sine:300Hz:5V",
        "triangle:10Hz:8V",
    ];
    for round in 0..20 {
        // Off by up to 60 %, the gap with the distance so that the film stays behind the ground.
        let mut changes: Vec<(&str, f64)> = ids
            .iter()
            .map(|id| (*id, 1.0 + 1.2 * (next() - 0.5)))
            .collect();
        changes.push(("gp", changes[1].1));
        let Some(alpha) = changes.iter_mut().find(|c| c.0 == "alpha") else {
            continue;
        };
        alpha.1 = alpha.1.min(1.2);
        let device = off(paper(), &changes);
        if device.check().is_err() {
            continue;
        }
        let parts: Vec<Part> = drives
            .iter()
            .enumerate()
            .map(|(i, drive)| part(made(&device, drive, 0.2, 10 * round + i as u64)))
            .collect();
        assert_eq!(check_connections(&paper(), &parts), Ok(()), "{changes:?}");
        for one in &parts {
            let alone = std::slice::from_ref(one);
            assert_eq!(check_connections(&paper(), alone), Ok(()), "{changes:?}");
        }
    }
}

#[test]
fn a_device_without_a_drive_says_nothing_of_connections() {
    for name in ["oscillator", "faller"] {
        let model = Preset::load(name).unwrap().model;
        let time: Vec<f64> = (0..2000).map(|i| 1e-3 * f64::from(i)).collect();
        let swing = |k: f64| {
            time.iter()
                .map(|t| k * (9.0 * t).sin())
                .collect::<Vec<f64>>()
        };
        for k in [-1e3, -1.0, 1e-6, 1.0] {
            let r = Recording::new("free", time.clone(), Some(swing(1.0)), swing(k), None);
            let parts = [Part::whole(Arc::new(r.unwrap()))];
            assert_eq!(check_connections(&model, &parts), Ok(()), "{name}, {k}");
        }
    }
}
