use crate::model::drive::Waveform;
use crate::model::effects;
use crate::model::effects::{ActiveEffect, find};
use crate::model::parameter::ParameterId;
use crate::model::preset::Preset;
use crate::sim::stretch::*;
use crate::sim::trace::EventKind;
use crate::sim::{StepSequence, Stretcher, simulate};

pub(super) fn segments(drive: &Waveform, until: f64) -> Vec<Segment> {
    (0..)
        .map(|i| drive.segment(i))
        .take_while(|s| s.start < until)
        .collect()
}

/// An effect with those values.
pub(super) fn with_values(id: &str, values: &[f64]) -> ActiveEffect {
    ActiveEffect {
        spec: find(id).unwrap(),
        values: values.to_vec(),
    }
}

/// A further mode at `f` \[Hz\].
pub(super) fn mode(f: f64) -> ActiveEffect {
    let values = [f, 0.01, 4e3, 3e3, 5e3, f, 0.01, 0.0, 0.0, 0.0];
    with_values("extra_mode", &values)
}

/// Carries the state of a full run from event to event and compares all samples, which are to
/// agree as they do where both take the same steps.
fn compare(model: &Model, drive: &str, duration: f64) {
    compare_within(model, drive, duration, 1e-11);
}

/// The same within so much \[m\], and pull-off forces within a thousandth of it [N].
fn compare_within(model: &Model, drive: &str, duration: f64, within: f64) {
    let drive = Waveform::parse(drive, duration).unwrap();
    let options = Options {
        tolerance: 1e-13,
        ..Options::default()
    };
    let trace = simulate(model, &drive, duration, &options).unwrap();
    let simulator = StretchSimulator::new(model, &options).unwrap();
    let mut stretcher = Stretcher::new(&simulator);
    let drive = segments(&drive, duration);
    let level = simulator.ground_level(0.0);
    let mut state = StretchState {
        q: vec![0.0; simulator.modes()],
        v: vec![0.0; simulator.modes()],
        z: vec![0.0; simulator.state_rates().len()],
    };
    let (mut t, mut held) = (0.0, None);
    let mut worst = 0.0f64;
    let mut sample = 0;
    let ends = trace
        .events
        .iter()
        .filter(|e| e.kind != EventKind::DriveStep);
    let ends: Vec<_> = ends
        .map(|e| (e.time, Some(*e)))
        .chain([(duration, None)])
        .collect();
    for (end, event) in ends {
        let times: Vec<f64> = (sample..trace.len())
            .map(|i| trace.time(i))
            .take_while(|&s| s <= end)
            .collect();
        let first = sample;
        let out = |i: usize, xp: f64, xc: f64| {
            worst = worst.max((xp - trace.proof_mass[first + i]).abs());
            worst = worst.max((xc - trace.cantilever[first + i]).abs());
        };
        stretcher
            .propagate(&drive, held, t, end, &mut state, &times, out)
            .unwrap();
        sample += times.len();
        t = end;
        let Some(event) = event else { continue };
        match event.kind {
            EventKind::Impact => simulator.kick(level, event.velocity_after, &mut state),
            EventKind::Stick => {
                simulator.kick(level, 0.0, &mut state);
                simulator.land(level, &mut state);
                held = Some(level);
            }
            EventKind::Release => {
                let pull = simulator.pull_off(&drive, t, level, &state);
                let off = (pull - event.pull_off_force).abs();
                assert!(off < 1e-3 * within, "{off:e}");
                simulator.lift(level, &mut state);
                held = None;
            }
            EventKind::DriveStep => {}
        }
    }
    assert!(sample + 1 >= trace.len());
    assert!(worst < within, "{worst:e}");
}

#[test]
fn agrees_with_the_simulator_between_events() {
    let model = Preset::embedded("paper").unwrap().model;
    compare(&model, "sine:50Hz:8V", 0.06);
    compare(&model, "square:300Hz:6V", 0.03);
    compare(&model, "ramped:20Hz:8V:0.25", 0.06);
}

#[test]
fn agrees_with_the_simulator_with_effects() {
    for (id, parameter, value) in [
        ("amplifier_lag", "tau", 1e-4),
        ("amplifier_lag", "r", 2e-5),
        ("piezo_creep", "c", 0.1),
        // Besides its default share of the other time.
        ("piezo_creep", "c2", 0.05),
        ("hysteresis_memory", "s", 1.0),
        ("dry_friction", "fc", 5e-9),
        ("dry_friction", "fc", 40e-9),
        ("film_spring", "tau", 5e-5),
        ("base_vibration", "a", 20.0),
        ("cubic_stiffness", "k3", 2e4),
        ("cubic_stiffness", "l", 4e-5),
        ("even_stiffness", "k2", 4.0),
        ("load_friction", "ml", 2e-4),
        // Besides its default linear part.
        ("load_friction", "mq", -1.0),
    ] {
        let mut model = Preset::embedded("paper").unwrap().model;
        let mut effect = ActiveEffect::new(effects::find(id).unwrap());
        assert!(effect.set(parameter, value));
        model.effects.push(effect);
        println!("{id}");
        compare(&model, "sine:50Hz:8V", 0.06);
        compare(&model, "square:50Hz:8V", 0.06);
    }
}

#[test]
fn agrees_with_the_simulator_where_more_modes_ring_and_readings_lag() {
    let lag = || with_values("sensor_lag", &[1.5e-5, 0.0]);
    let film = || with_values("film_spring", &[5e-5, 2.0]);
    for effects in [
        vec![lag()],
        vec![with_values("sensor_lag", &[2e-6, 0.0])],
        vec![mode(19e3)],
        vec![mode(2e3)],
        vec![mode(70e3), lag()],
        vec![mode(19e3), lag(), film()],
    ] {
        let mut model = Preset::embedded("paper").unwrap().model;
        model.effects = effects;
        println!("{:?}", model.effects);
        // Steps differ, and each bounce makes more of that.
        compare_within(&model, "sine:50Hz:8V", 0.03, 1e-9);
        compare_within(&model, "square:50Hz:8V", 0.03, 1e-9);
    }
}

#[test]
fn steps_hardly_exceed_their_tolerance() {
    let film = |p: f64| with_values("film_spring", &[5e-5, p]);
    for effects in [
        vec![],
        vec![film(0.0)],
        vec![film(2.0)],
        vec![mode(2e3)],
        vec![mode(19e3)],
        vec![mode(70e3)],
        vec![mode(19e3), film(0.0)],
        vec![mode(19e3), film(2.0)],
    ] {
        let mut model = Preset::embedded("paper").unwrap().model;
        model.effects = effects;
        let drive = segments(&Waveform::parse("square:50Hz:8V", 0.02).unwrap(), 0.02);
        // Flight that begins near the ground, with a kick that sets all modes ringing.
        let run = |tolerance: f64| {
            let options = Options {
                tolerance,
                ..Options::default()
            };
            let simulator = StretchSimulator::new(&model, &options).unwrap();
            let mut state = StretchState {
                q: vec![0.0; simulator.modes()],
                v: vec![0.0; simulator.modes()],
                z: vec![0.0; simulator.state_rates().len()],
            };
            let height = 0.98 * simulator.ground_level(0.0);
            state.q[0] = height / simulator.flight_shapes().0[0];
            simulator.kick(height, 0.05, &mut state);
            let times: Vec<f64> = (0..300).map(|i| 1e-3 + f64::from(i) * 1e-5).collect();
            let mut all = Vec::new();
            let (from, to) = (times[0], times[299]);
            Stretcher::new(&simulator)
                .propagate(&drive, None, from, to, &mut state, &times, |_, xp, xc| {
                    all.extend([xp, xc]);
                })
                .unwrap();
            all
        };
        let (rough, fine) = (run(1e-11), run(1e-15));
        let apart = rough.iter().zip(&fine).map(|(a, b)| (a - b).abs());
        let worst = apart.fold(0.0, f64::max);
        assert!(worst < 2e-11, "{worst:e} with {:?}", model.effects);
    }
}

#[test]
fn agrees_with_the_simulator_behind_an_amplifier_that_slews_and_settles() {
    let mut model = Preset::embedded("paper").unwrap().model;
    let mut effect = ActiveEffect::new(effects::find("amplifier_lag").unwrap());
    effect.values = vec![8e-5, 1e-4];
    model.effects.push(effect);
    // The sines outrun it where they are steep: by 15 and 13 kV/s.
    for drive in ["square:50Hz:8V", "sine:300Hz:8V", "chirp:50Hz:300Hz:7V"] {
        println!("{drive}");
        compare(&model, drive, 0.03);
    }
}

#[test]
fn rest_states_stay_at_rest() {
    let model = Preset::embedded("paper").unwrap().model;
    let simulator = StretchSimulator::new(&model, &Options::default()).unwrap();
    let drive = segments(&Waveform::parse("square:1Hz:3V", 1.0).unwrap(), 1.0);
    for held in [None, Some(-58e-6)] {
        let mut state = simulator.rest_state(&drive, 0.1, held);
        let before = state.clone();
        let mut stretcher = Stretcher::new(&simulator);
        stretcher
            .propagate(&drive, held, 0.1, 0.2, &mut state, &[], |_, _, _| {})
            .unwrap();
        for (a, b) in state.q.iter().zip(&before.q) {
            assert!((a - b).abs() < 1e-12 * b.abs().max(1e-9), "{a} {b}");
        }
    }
}

/// A piece of the drive may be as short as the difference of two neighbouring numbers.
#[test]
fn a_piece_of_no_length_changes_nothing() {
    let model = Preset::embedded("paper").unwrap().model;
    let simulator = StretchSimulator::new(&model, &Options::default()).unwrap();
    let whole = segments(&Waveform::parse("sine:50Hz:8V", 0.02).unwrap(), 0.02);
    let motion = |drive: &[Segment]| {
        let times: Vec<f64> = (0..40).map(|i| 1e-5 * f64::from(i)).collect();
        let (mut state, mut out) = (simulator.rest_state(drive, 0.0, None), Vec::new());
        Stretcher::new(&simulator)
            .propagate(drive, None, 0.0, 4e-4, &mut state, &times, |_, x, _| {
                out.push(x);
            })
            .unwrap();
        out
    };
    let plain = motion(&whole);
    for ulps in [1, 3, 100, 1_000_000] {
        let at = 1e-4f64;
        let later = f64::from_bits(at.to_bits() + ulps);
        let part = |start, end| Segment {
            start,
            end,
            ..whole[0]
        };
        let mut cut = vec![
            part(whole[0].start, at),
            part(at, later),
            part(later, whole[0].end),
        ];
        cut.extend_from_slice(&whole[1..]);
        for (a, b) in plain.iter().zip(motion(&cut)) {
            assert!((a - b).abs() < 1e-11, "{ulps} ulps: {a} {b}");
        }
    }
}

/// Readings of 10 ms of flight, with so many small steps in how the drive is shared out.
fn flown(steps: f64, lag: f64, follow: Option<&StepSequence>) -> (Vec<f64>, StepSequence) {
    let mut model = Preset::embedded("paper").unwrap().model;
    model.set("drive_p", 4e-6 * steps).unwrap();
    if lag > 0.0 {
        let mut effect = ActiveEffect::new(effects::find("amplifier_lag").unwrap());
        effect.values = vec![lag, 0.0];
        model.effects.push(effect);
    }
    let options = Options {
        tolerance: 1e-11,
        ..Options::default()
    };
    let simulator = StretchSimulator::new(&model, &options).unwrap();
    let mut stretcher = Stretcher::new(&simulator);
    match follow {
        Some(pace) => stretcher.replay_steps(pace),
        None => stretcher.record_steps(),
    }
    let drive = segments(&Waveform::parse("sine:50Hz:8V", 0.02).unwrap(), 0.02);
    let mut state = StretchState {
        q: vec![1e-10, 1e-12],
        v: vec![1e-6, 1e-8],
        z: vec![0.0; simulator.state_rates().len()],
    };
    let times: Vec<f64> = (0..500).map(|i| 1e-3 + f64::from(i) * 2e-5).collect();
    let mut xp = Vec::new();
    let read = |_, x: f64, _| xp.push(x);
    stretcher
        .propagate(&drive, None, 1e-3, 1.1e-2, &mut state, &times, read)
        .unwrap();
    (xp, stretcher.recorded_steps())
}

#[test]
fn runs_in_the_same_steps_differ_smoothly() {
    // A third difference of what is smooth in the parameter is nothing; what is left is
    // that each choice of steps errs in its own way.
    const STEPS: u8 = 12;
    let rough = |all: &[Vec<f64>]| {
        let third = |w: &[Vec<f64>], i: usize| w[3][i] - 3.0 * w[2][i] + 3.0 * w[1][i] - w[0][i];
        let sum = |w: &[Vec<f64>]| (0..w[0].len()).map(|i| third(w, i).powi(2)).sum::<f64>();
        let count = (all.len() - 3) * all[0].len();
        (all.windows(4).map(sum).sum::<f64>() / count as f64).sqrt()
    };
    for lag in [0.0, 3e-6] {
        let (_, pace) = flown(0.0, lag, None);
        let later = |k: u8| flown(f64::from(k), lag, Some(&pace)).0;
        let own = |k: u8| flown(f64::from(k), lag, None).0;
        let followed = rough(&(0..STEPS).map(later).collect::<Vec<_>>());
        let free = rough(&(0..STEPS).map(own).collect::<Vec<_>>());
        assert!(
            followed < 1e-12 && followed < 0.01 * free,
            "{followed:e} {free:e}"
        );
        // The same answer, all but the discretisation.
        let (a, b) = (later(STEPS), own(STEPS));
        let apart = a
            .iter()
            .zip(&b)
            .fold(0.0f64, |w, (a, b)| w.max((a - b).abs()));
        assert!(apart < 2e-9, "{apart:e}");
    }
}

#[test]
fn steps_with_too_large_an_error_are_not_replayed() {
    // Those of a slow drive are far too long for an edge's lag.
    let (_, pace) = flown(0.0, 0.0, None);
    let (own, _) = flown(0.0, 3e-6, None);
    let (followed, _) = flown(0.0, 3e-6, Some(&pace));
    let apart = own
        .iter()
        .zip(&followed)
        .fold(0.0f64, |w, (a, b)| w.max((a - b).abs()));
    assert!(apart < 2e-9, "{apart:e}");
}

/// Bounces of 1.2 ms that the mass comes to at 0.2 m/s: height \[m\] and velocity.
fn bounces(level: f64, t: f64) -> (f64, f64) {
    const TIME: f64 = 1.2e-3;
    const SPEED: f64 = 0.2;
    let since = t.rem_euclid(TIME);
    let slowing = 2.0 * SPEED / TIME;
    (
        level + SPEED * since - 0.5 * slowing * since * since,
        SPEED - slowing * since,
    )
}

#[test]
fn a_slow_film_follows_each_bounce() {
    let mut model = Preset::embedded("paper").unwrap().model;
    let [cs, gp, dp] =
        [ParameterId::Cs, ParameterId::Gp, ParameterId::Dp].map(|id| model.parameters[id]);
    let tau = 1e-3;
    let mut film = ActiveEffect::new(find("film_spring").unwrap());
    assert!(film.set("tau", tau));
    model.effects.push(film);
    let sim = StretchSimulator::new(&model, &Options::default()).unwrap();
    let at = |t: f64| {
        let (xp, vp) = bounces(-dp, t);
        Points {
            xp,
            vp,
            ..Points::default()
        }
    };
    let drive = [Segment {
        start: 0.0,
        ..Waveform::Rest.segment(0)
    }];
    let times: Vec<f64> = (1..40).map(|k| 0.31e-3 * f64::from(k)).collect();
    let found = sim.states_from_drive(&drive, &times, &at);
    // The law in steps of 20 ns.
    let (mut force, mut t, h) = (0.0, 0.0, 2e-8);
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for (time, found) in times.iter().zip(&found) {
        while t < *time {
            let (xp, vp) = bounces(-dp, t + 0.5 * h);
            force += h / tau * (-cs * vp / (xp + gp).powi(3) - force);
            t += h;
        }
        worst = worst.max((force - found).abs());
        largest = largest.max(force.abs());
    }
    assert!(worst < 0.01 * largest, "{worst} of {largest}");
}

#[test]
fn a_film_is_followed_alike_together_with_a_long_memory() {
    let paper = Preset::embedded("paper").unwrap().model;
    let dp = paper.parameters[ParameterId::Dp];
    let effect = |id: &str, parameter: &str, value: f64| {
        let mut effect = ActiveEffect::new(find(id).unwrap());
        assert!(effect.set(parameter, value));
        effect
    };
    let film = effect("film_spring", "tau", 5e-5);
    let at = |t: f64| {
        let (xp, vp) = bounces(-dp, t);
        Points {
            xp,
            vp,
            ..Points::default()
        }
    };
    let drive = segments(&Waveform::parse("square:50Hz:8V", 0.1).unwrap(), 0.1);
    let times: Vec<f64> = (1..24).map(|k| 4.1e-3 * f64::from(k)).collect();
    let followed = |effects: &[&ActiveEffect]| {
        let mut model = paper.clone();
        model.effects.extend(effects.iter().map(|e| (*e).clone()));
        let sim = StretchSimulator::new(&model, &Options::default()).unwrap();
        sim.states_from_drive(&drive, &times, &at)
    };
    let alone = followed(&[&film]);
    let largest = alone.iter().fold(0.0f64, |a, z| a.max(z.abs()));
    assert!(largest > 1e-9, "{largest}");
    // Behind an amplifier pieces end at instants of its own, and steps with them, each of which
    // has the error that the film's own test allows.
    for (other, film_off) in [
        (effect("amplifier_lag", "r", 2e-5), 1e-2),
        (effect("piezo_creep", "c", 0.1), 1e-4),
    ] {
        let (own, both) = (followed(&[&other]), followed(&[&film, &other]));
        let count = own.len() / times.len();
        for (k, together) in both.chunks(1 + count).enumerate() {
            let off = (together[0] - alone[k]).abs();
            assert!(off < film_off * largest, "{off} of {largest}: {together:?}");
            for (a, b) in together[1..].iter().zip(&own[count * k..]) {
                assert!((a - b).abs() < 1e-4 * b.abs().max(1e-9), "{a} {b}");
            }
        }
    }
}

#[test]
fn a_film_that_is_quick_and_goes_slower_near_the_ground_takes_few_steps() {
    let count = |effects: &[(f64, f64)], held: Option<f64>| {
        let mut model = Preset::embedded("paper").unwrap().model;
        for (tau, growth) in effects {
            let mut film = ActiveEffect::new(find("film_spring").unwrap());
            film.values = vec![*tau, *growth];
            model.effects.push(film);
        }
        let simulator = StretchSimulator::new(&model, &Options::default()).unwrap();
        let mut stretcher = Stretcher::new(&simulator);
        stretcher.record_steps();
        let drive = segments(&Waveform::parse("sine:50Hz:8V", 0.02).unwrap(), 0.02);
        let mut state = StretchState {
            q: vec![1e-10, 1e-12],
            v: vec![1e-6, 1e-8],
            // The film of a blow, that goes.
            z: vec![1e-7; simulator.state_rates().len()],
        };
        if let Some(level) = held {
            simulator.kick(level, 0.0, &mut state);
            simulator.land(level, &mut state);
        }
        stretcher
            .propagate(&drive, held, 1e-3, 1.1e-2, &mut state, &[], |_, _, _| ())
            .unwrap();
        stretcher.recorded_steps().0[0].len()
    };
    let level = -Preset::embedded("paper").unwrap().model.parameters[ParameterId::Dp];
    for held in [None, Some(level)] {
        let plain = count(&[], held);
        for tau in [2e-6, 8e-6, 3e-5] {
            let with = count(&[(tau, 2.0)], held);
            assert!(with < 4 * plain + 100, "{tau} {held:?}: {with} of {plain}");
        }
    }
}
