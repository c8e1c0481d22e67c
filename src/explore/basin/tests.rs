use std::sync::atomic::AtomicBool;

use super::super::basin::*;
use crate::explore::map::Axis;
use crate::explore::orbit::{self, OrbitRequest};
use crate::explore::test_support::{amplitude, hardening, linear, natural_frequency};
use crate::model::drive::Waveform;
use crate::model::preset::Preset;

static NEVER: AtomicBool = AtomicBool::new(false);

fn plane(x: f64, v: f64, count: usize) -> Beginnings {
    Beginnings::Plane {
        displacement: (-x, x),
        velocity: (-v, v),
        count: (count, count),
        switched_on: 0.0,
    }
}

#[test]
fn a_linear_device_has_one_response() {
    let drive = Waveform::parse("sine:1Hz:1V", 1.0).unwrap();
    let request = BasinRequest::new(linear(0.1), drive, plane(0.1, 1.0, 7));
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    assert_eq!(map.responses.len(), 1);
    assert_eq!((map.responses[0].count, map.responses[0].share), (49, 1.0));
}

/// The responses of Duffing's oscillator are those that the sweeps up and down come to.
#[test]
fn coexisting_responses_are_those_of_the_orbit_diagram() {
    let zeta = 0.02;
    let plain = linear(zeta);
    let f1 = natural_frequency(&plain);
    let size = amplitude(&plain, f1, 1.0);
    let model = hardening(zeta, size, 0.32);
    let drive = Waveform::parse("sine:1Hz:1V", 1.0).unwrap();
    let axis = Axis::new("f", (&model, &drive), (0.98 * f1, 1.18 * f1), 41).unwrap();
    let mut sweep = OrbitRequest::new(model.clone(), drive.clone(), axis.clone());
    sweep.lyapunov_periods = 0;
    let diagram = orbit::compute(&sweep, &NEVER, &mut |_| {}).unwrap();
    let both = diagram.coexisting(0.05);
    let index = both[both.len() / 2];
    let drive = crate::explore::waveform::set(&drive, "f", axis.value(index)).unwrap();
    let speed = std::f64::consts::TAU * f1 * size;
    let request = BasinRequest::new(model, drive, plane(1.5 * size, 1.5 * speed, 9));
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    assert!(map.holes.is_empty(), "{:?}", map.holes);
    assert_eq!(map.responses.len(), 2, "{:?}", map.responses);
    let shares: f64 = map.responses.iter().map(|own| own.share).sum();
    assert!((shares - 1.0).abs() < 1e-12);
    for slices in [&diagram.up, &diagram.down] {
        let slice = slices.iter().find(|slice| slice.index == index).unwrap();
        let strobe = slice.answer.as_ref().unwrap().strobes[0];
        let near = map
            .responses
            .iter()
            .filter(|own| (own.strobes[0].displacement - strobe.displacement).abs() < 2e-3 * size);
        assert_eq!(near.count(), 1, "{strobe:?} {:?}", map.responses);
    }
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(
        alone.install(|| compute(&request, &NEVER, &|_| {}).unwrap()),
        map
    );
}

#[test]
fn beginnings_in_the_ground_are_holes() {
    let drive = Waveform::parse("square:50Hz:7V", 0.02).unwrap();
    let model = Preset::default().model;
    let request = BasinRequest::new(model.clone(), drive.clone(), plane(80e-6, 0.05, 3));
    let map = compute(&request, &NEVER, &|_| {}).unwrap();
    // The ground is at -58 um.
    assert_eq!(map.holes.keys().copied().collect::<Vec<_>>(), [0, 3, 6]);
    assert!(map.holes[&0].contains("ground"), "{:?}", map.holes);
    assert_eq!(map.points[0], BasinPoint::Hole);
    let wrong = BasinRequest::new(model, drive, Beginnings::Phases { count: 1 });
    assert!(wrong.check().unwrap_err().to_string().contains("no axis"));
}

#[test]
fn a_cancelled_basin_says_what_is_pending() {
    let drive = Waveform::parse("square:50Hz:7V", 0.02).unwrap();
    let request = BasinRequest::new(Preset::default().model, drive, plane(50e-6, 0.05, 5));
    let map = compute(&request, &AtomicBool::new(true), &|_| {}).unwrap();
    assert!(map.points.iter().all(|point| *point == BasinPoint::Pending));
}
