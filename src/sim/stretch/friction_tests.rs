//! Stretches with friction away from the ground.

use super::tests::{mode, segments, with_values};
use crate::model::drive::Waveform;
use crate::model::preset::Preset;
use crate::sim::Stretcher;
use crate::sim::error::Options;
use crate::sim::step::Step;
use crate::sim::stretch::*;

/// 10 ms of flight with friction of `force` \[N\] and a further mode at `f` \[Hz\], which begins with
/// a velocity of `ring` \[kg^1/2 m/s\]: readings of the proof mass, the number of steps, and how many
/// it takes if all are short enough to follow that mode.
fn rubbed((force, f, ring): (f64, f64, f64), tolerance: f64) -> (Vec<f64>, usize, f64) {
    const SPAN: (f64, f64) = (1e-3, 1.1e-2);
    let mut model = Preset::embedded("paper").unwrap().model;
    model.effects.push(mode(f));
    model.effects.push(with_values("dry_friction", &[force]));
    let options = Options {
        tolerance,
        ..Options::default()
    };
    let simulator = StretchSimulator::new(&model, &options).unwrap();
    let mut stretcher = Stretcher::new(&simulator);
    stretcher.record_steps();
    let drive = segments(&Waveform::parse("sine:50Hz:8V", 0.02).unwrap(), 0.02);
    let times: Vec<f64> = (0..500).map(|i| SPAN.0 + f64::from(i) * 2e-5).collect();
    let mut state = StretchState {
        q: vec![1e-10, 1e-12, 1e-12],
        v: vec![1e-6, 1e-8, ring],
        z: Vec::new(),
    };
    let mut xp = Vec::new();
    let read = |_, x: f64, _| xp.push(x);
    stretcher
        .propagate(&drive, None, SPAN.0, SPAN.1, &mut state, &times, read)
        .unwrap();
    let steps = stretcher.recorded_steps().0[0].len();
    let short = (SPAN.1 - SPAN.0) / simulator.device.longest_step();
    (xp, steps, short)
}

#[test]
fn friction_stops_and_turns_the_mass_at_the_same_places_in_long_and_short_steps() {
    // Held again and again; sliding on; sliding on with a quick mode; turned by one that rings.
    let cases = [
        (4e-8, 21e3, 1e-8),
        (1e-9, 21e3, 1e-8),
        (1e-10, 80e3, 1e-8),
        (3e-8, 80e3, 2e-6),
    ];
    for (i, case) in cases.into_iter().enumerate() {
        let (short, ..) = rubbed(case, 1e-14);
        let apart = |tolerance: f64| {
            let (long, steps, all_short) = rubbed(case, tolerance);
            let each = long.iter().zip(&short).map(|(a, b)| (a - b).abs());
            (each.fold(0.0, f64::max), steps as f64 / all_short)
        };
        let (worst, share) = apart(1e-11);
        assert!(worst < 1e-10, "{case:?}: {worst}");
        let at_rest = short.windows(2).filter(|w| w[0] == w[1]).count();
        if [0, 3].contains(&i) {
            assert!(at_rest > 50, "{case:?}: {at_rest}");
            // Where steps are as long as they may be, too.
            let (worst, _) = apart(1e-6);
            assert!(worst < 1.5e-8, "{case:?}: {worst}");
        } else {
            assert_eq!(at_rest, 0, "{case:?}");
        }
        if i == 2 {
            assert!(share < 0.6, "{case:?}: {share}");
        }
    }
}

#[test]
fn bounds_that_hold_all_over_a_step_do() {
    let mut model = Preset::embedded("paper").unwrap().model;
    model.effects.push(mode(9e3));
    model.effects.push(mode(2.1e4));
    model.effects.push(with_values("dry_friction", &[1e-9]));
    let simulator = StretchSimulator::new(&model, &Options::default()).unwrap();
    let device = &simulator.device;
    let m = device.held_modes.len();
    let drive = segments(&Waveform::parse("sine:50Hz:8V", 0.02).unwrap(), 0.02);
    let segment = segment_at(&drive, 0.0);
    let mut step = Step::new(m, &device.rates);
    let (mut held, mut predicted) = (0, 0);
    for i in 0..400 {
        let level = i % 4 + simulator.coarsest.saturating_sub(2);
        let swing = 3e-11 * f64::from(i as u32 % 7);
        let phase = |k: usize| (1.7 * k as f64 + 0.9 * i as f64).sin();
        let omega = |k: usize| device.held_modes[k].omega2.sqrt();
        let r: Vec<f64> = (0..m).map(|k| swing * phase(k) / omega(k)).collect();
        let dr: Vec<f64> = (0..m).map(|k| swing * phase(k + 5)).collect();
        let t = 4e-5 * i as f64;
        let from = (&r[..], &dr[..], &[][..]);
        step.held_step(
            device,
            &simulator.held,
            level,
            &segment,
            t,
            from,
            0.0,
            1e-11,
        )
        .unwrap();
        let pull = |s: f64| step.held_pull(device, &segment, t, s, 0.0).abs();
        let most = (0..=500)
            .map(|s| pull(f64::from(s) / 500.0))
            .fold(0.0, f64::max);
        for share in [0.7, 1.0, 1.3, 2.0, 4.0] {
            let holds = most < share * 1e-7;
            let plain = step.stays_below(device, share * 1e-7);
            assert!(holds || !plain, "{i}: {most} of {}", share * 1e-7);
            held += usize::from(holds);
            predicted += usize::from(plain);
        }
    }
    assert!(held > 100 && predicted > held / 3, "{predicted} of {held}");
}
