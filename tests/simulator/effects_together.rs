//! Effects together, switched on and off while the device runs, at the ends of their
//! ranges, in files, and what they do to energy.

use crate::support::device::{add, with};
use impactscope::model::Model;
use impactscope::model::drive::Waveform;
use impactscope::model::effects::{ActiveEffect, CATALOGUE, EffectSpec};
use impactscope::model::parameter::ParameterId;
use impactscope::model::preset::Preset;
use impactscope::model::unit::parse_quantity;
use impactscope::sim::{EventKind, Options, Runner, SimError, Trace, simulate};

fn bounded(name: &str, model: &Model, drive: &Waveform, duration: f64) -> Trace {
    let trace = simulate(model, drive, duration, &Options::default())
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let far = trace.proof_mass.iter().fold(0.0f64, |a, x| a.max(x.abs()));
    assert!(far < 1e-3, "{name}: {far} m");
    trace
}

#[test]
fn every_pair_runs_and_stays_bounded() {
    let drive = Waveform::parse("square:50Hz:8V", 0.03).unwrap();
    for (i, a) in CATALOGUE.iter().enumerate() {
        for b in &CATALOGUE[..=i] {
            let mut model = Preset::default().model;
            add(&mut model, a.id, &[]);
            if a != b {
                add(&mut model, b.id, &[]);
            }
            let name = format!("{} and {}", a.id, b.id);
            bounded(&name, &model, &drive, 0.03);
        }
    }
}

#[test]
fn all_at_once_run_and_stay_bounded() {
    let mut model = Preset::default().model;
    for effect in CATALOGUE {
        add(&mut model, effect.id, &[]);
    }
    for drive in ["square:50Hz:8V", "sine:30Hz:6V", "triangle:40Hz:8V"] {
        let drive = Waveform::parse(drive, 0.1).unwrap();
        bounded("all", &model, &drive, 0.1);
    }
}

/// Corners of an effect's ranges: each parameter at either end, the others at default.
fn corners(effect: &'static EffectSpec) -> Vec<ActiveEffect> {
    let mut all = Vec::new();
    for parameter in effect.parameters {
        for value in [parameter.range.0, parameter.range.1] {
            let mut active = ActiveEffect::new(effect);
            active.set(parameter.id, value);
            all.push(active);
        }
    }
    all
}

#[test]
fn the_ends_of_all_ranges_run() {
    for effect in CATALOGUE {
        for active in corners(effect) {
            let mut model = Preset::default().model;
            let name = format!("{} {:?}", effect.id, active.values);
            let softest = effect.id == "cubic_stiffness" && active.values[0] == -1e5;
            model.effects.push(active);
            for drive in ["square:50Hz:8V", "sine:50Hz:6V"] {
                let waveform = Waveform::parse(drive, 0.03).unwrap();
                if softest && drive.starts_with("square") {
                    // Beyond its crest a softening spring drives the mass away for good.
                    let run = simulate(&model, &waveform, 0.03, &Options::default());
                    assert!(matches!(run, Err(SimError::Diverged { .. })), "{run:?}");
                } else {
                    bounded(&name, &model, &waveform, 0.03);
                }
            }
        }
    }
}

#[test]
fn effects_are_switched_while_the_device_runs() {
    let drive = Waveform::parse("square:50Hz:8V", 1.0).unwrap();
    let plain = Preset::default().model;
    let mut runner = Runner::new(&plain, &drive, &Options::default()).unwrap();
    let mut trace = runner.new_trace();
    // Every 3.1 ms another effect, in flight and on the ground, alone and on top of others.
    let mut model = plain.clone();
    for round in 0..3 {
        for effect in CATALOGUE {
            if round == 0 {
                model = plain.clone();
            } else if round == 2 {
                model.effects.retain(|active| active.spec != *effect);
            }
            if round < 2 {
                model.effects.retain(|active| active.spec != *effect);
                add(&mut model, effect.id, &[]);
            }
            runner.set_model(&model).unwrap();
            let until = runner.time() + 3.1e-3;
            runner
                .advance(until, &mut trace)
                .unwrap_or_else(|error| panic!("{}: {error}", effect.id));
        }
    }
    let far = trace.proof_mass.iter().fold(0.0f64, |a, x| a.max(x.abs()));
    assert!(far < 1e-3, "{far}");
    let changes = trace.events.len();
    assert!(changes < 5000, "{changes}");
}

#[test]
fn effects_stand_in_presets() {
    let mut preset = Preset::default();
    for (i, effect) in CATALOGUE.iter().enumerate() {
        let mut active = ActiveEffect::new(effect);
        for value in &mut active.values {
            *value *= 1.0 + 1e-3 * (1.0 + i as f64) / 20.0;
        }
        // Shares do not exceed one.
        for (value, parameter) in active.values.iter_mut().zip(effect.parameters) {
            *value = value.min(parameter.limits.1);
        }
        preset.model.effects.push(active);
    }
    let text = preset.to_toml();
    let read = Preset::parse("all effects", &text).unwrap();
    assert_eq!(read.model.effects.len(), CATALOGUE.len());
    for active in &preset.model.effects {
        assert!(read.model.effects.contains(active), "{}", active.spec.id);
    }
}

#[test]
fn every_parameter_can_be_typed_with_its_unit() {
    for effect in CATALOGUE {
        for parameter in effect.parameters {
            for text in [
                format!("{}", parameter.default),
                format!("{} {}", parameter.default, parameter.unit),
            ] {
                let value = parse_quantity(&text, parameter.unit).unwrap();
                assert_eq!(value, parameter.default, "{} {text}", effect.id);
            }
        }
    }
}

/// Kinetic and elastic energy of the two modes [J].
fn energies(model: &Model, trace: &Trace) -> Vec<f64> {
    let [a, b] = model.structure().modes[..] else {
        panic!("two modes");
    };
    let det = a.phi_c * b.phi_p - b.phi_c * a.phi_p;
    let modal = |c: f64, p: f64| {
        [
            (b.phi_p * c - b.phi_c * p) / det,
            (a.phi_c * p - a.phi_p * c) / det,
        ]
    };
    (0..trace.len())
        .map(|i| {
            let q = modal(trace.cantilever[i], trace.proof_mass[i]);
            let v = modal(trace.cantilever_velocity[i], trace.proof_mass_velocity[i]);
            (0..2)
                .map(|k| 0.5 * (v[k] * v[k] + [a, b][k].omega().powi(2) * q[k] * q[k]))
                .sum()
        })
        .collect()
}

/// The device without drive and adhesion, let go 45 um up: contact included.
fn undriven(id: &str, values: &[(&str, f64)]) -> Model {
    let mut model = with(id, values);
    for (parameter, value) in [
        (ParameterId::X0, 57e-6),
        (ParameterId::V0, -0.4),
        (ParameterId::Ca, 0.0),
        (ParameterId::Ca0, 0.0),
    ] {
        model.parameters.set(parameter, value);
    }
    model
}

#[test]
fn what_dissipates_never_raises_the_energy() {
    /// Effect, its values, and whether its energy counts while it touches too.
    type Case<'a> = (&'a str, &'a [(&'a str, f64)], bool);
    let cases: [Case<'_>; 6] = [
        ("quadratic_drag", &[("cd", 1e-7)], true),
        ("dry_friction", &[("fc", 10e-9)], true),
        ("dry_friction", &[("fc", 50e-9)], true),
        // In the ground part of the energy is the ground's.
        ("compliant_ground", &[("k", 1e4), ("chi", 10.0)], false),
        ("compliant_ground", &[("k", 1e7), ("chi", 0.0)], false),
        ("velocity_restitution", &[("n", 0.5), ("v0", 0.01)], true),
    ];
    for (id, values, at_all_times) in cases {
        let model = undriven(id, values);
        let trace = simulate(&model, &Waveform::Rest, 0.02, &Options::default()).unwrap();
        let energy = energies(&model, &trace);
        assert!(!trace.events.is_empty(), "{id} never touches");
        let slack = 1e-9 * energy[0];
        let mut lowest = energy[0];
        for (i, &now) in energy.iter().enumerate() {
            let t = trace.time(i);
            let touching = trace.contacts.iter().any(|c| c.0 <= t && t <= c.1);
            if at_all_times || !touching {
                assert!(
                    now <= lowest + slack,
                    "{id} at {t}: {now:e} J after {lowest:e} J"
                );
                lowest = now;
            }
        }
        assert!(
            lowest < 0.9 * energy[0],
            "{id}: {lowest:e} of {:e}",
            energy[0]
        );
    }
}

#[test]
fn a_compressible_film_gives_back_no_more_than_it_took() {
    // It stores energy for a while; from crest to crest the whole falls.
    let model = undriven("film_spring", &[("tau", 100e-6)]);
    let trace = simulate(&model, &Waveform::Rest, 0.02, &Options::default()).unwrap();
    let energy = energies(&model, &trace);
    let v = &trace.proof_mass_velocity;
    let crests: Vec<f64> = (1..v.len())
        .filter(|&i| v[i - 1] > 0.0 && v[i] <= 0.0 && trace.proof_mass[i] > 0.0)
        .map(|i| energy[i])
        .collect();
    assert!(crests.len() > 5);
    assert!(
        crests.windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-9)),
        "{crests:?}"
    );
}

#[test]
fn friction_takes_the_same_from_every_swing_and_then_holds() {
    // Den Hartog: each half swing loses 2 fc / k; it ends within fc / k of zero.
    let mut model = Preset::embedded("oscillator").unwrap().model;
    model.parameters.set(ParameterId::Zeta1, 0.0);
    let fc = 0.02;
    add(&mut model, "dry_friction", &[("fc", fc)]);
    let options = Options {
        rate: 1e4,
        ..Options::default()
    };
    let trace = simulate(&model, &Waveform::Rest, 20.0, &options).unwrap();
    let mode = model.structure().modes[0];
    let stiffness = (mode.omega() / mode.phi_p).powi(2);
    let lost = 2.0 * fc / stiffness;
    let (mut x, mut half_swings) = (0.1f64, 0);
    while x > 0.5 * lost {
        let t = half_swings as f64 * 0.5 / mode.frequency;
        let sign = if half_swings % 2 == 0 { 1.0 } else { -1.0 };
        // Around a crest the motion is flat: half a sample is 1e-7 of the swing.
        let read = trace.proof_mass[(t * 1e4).round() as usize];
        assert!(
            (read - sign * x).abs() < 3e-7 * 0.1,
            "{half_swings}: {read} {x}"
        );
        x -= lost;
        half_swings += 1;
    }
    assert!(half_swings > 20, "{half_swings}");
    let rest = trace.proof_mass[trace.len() - 1];
    assert!((rest.abs() - x.abs()).abs() < 1e-9, "{rest} {x}");
    assert_eq!(rest, trace.proof_mass[trace.len() - 2]);
}

#[test]
fn a_hard_compliant_ground_keeps_the_speed_that_hunt_and_crossley_give() {
    // Without adhesion and film, and with contact too short for the spring to matter:
    // ln((1 + chi v) / (1 - chi u)) = chi (v + u), u the speed of the rebound.
    for (chi, v0) in [(10.0, -0.3), (3.0, -0.2), (1.0, -0.4)] {
        let mut model = undriven("compliant_ground", &[("k", 1e9), ("chi", chi)]);
        model.parameters.set(ParameterId::Cs, 0.0);
        model.parameters.set(ParameterId::V0, v0);
        let trace = simulate(&model, &Waveform::Rest, 2e-3, &Options::default()).unwrap();
        let kinds: Vec<_> = trace.events.iter().map(|e| e.kind).collect();
        assert_eq!(kinds[..2], [EventKind::Stick, EventKind::Release]);
        let (touch, leave) = (trace.events[0], trace.events[1]);
        let (v, u) = (-touch.velocity_before, leave.velocity_before);
        assert!(v > 0.1 && leave.contact_duration < 1e-6, "{v}");
        let (mut low, mut high) = (0.0, (1.0 / chi).min(v));
        for _ in 0..60 {
            let u = 0.5 * (low + high);
            let apart = ((1.0 + chi * v) / (1.0 - chi * u)).ln() - chi * (v + u);
            if apart < 0.0 {
                low = u;
            } else {
                high = u;
            }
        }
        println!("{chi}: {v} {u} {low}");
        assert!((u / low - 1.0).abs() < 0.01, "{chi}: {v} {u} {low}");
    }
}

#[test]
fn the_stiffer_the_ground_the_more_it_is_the_rigid_one() {
    // Held down at 8 V the mass sinks in until k d^1.5 is adhesion less pull-off force.
    let drive = Waveform::parse("square:15Hz:8V", 0.03).unwrap();
    let options = Options {
        forces: true,
        ..Options::default()
    };
    let rigid = simulate(&Preset::default().model, &drive, 0.03, &options).unwrap();
    let forces = rigid.forces.as_ref().unwrap();
    let i = 1400;
    // At 1e3 the depth, a third of a micrometre, itself unloads the structure by 1 %.
    for (k, share) in [(1e3, 2e-2), (1e5, 1e-3), (1e7, 1e-3)] {
        let soft = with("compliant_ground", &[("k", k)]);
        let trace = simulate(&soft, &drive, 0.03, &options).unwrap();
        let depth = rigid.proof_mass[i] - trace.proof_mass[i];
        // Adhesion counts from the touch after which it did not leave again.
        let since = trace.contacts.last().unwrap().0;
        let adhesion = 27.43e-9 + 1.7e-6 * (trace.time(i) - since);
        let expected = ((adhesion - forces.pull_off[i]) / k).powf(2.0 / 3.0);
        println!("{k}: {depth:e} {expected:e} {} steps", trace.steps);
        assert!(
            (depth / expected - 1.0).abs() < share,
            "{k}: {depth} {expected}"
        );
        // What the ground exerts balances the pull.
        let ground = trace.forces.as_ref().unwrap().ground[i];
        assert!((ground / forces.ground[i] - 1.0).abs() < share, "{ground}");
    }
}

#[test]
fn events_and_order_survive_effects() {
    // Halving a fixed step lowers the error by the method's order, friction's turns and
    // the kinks of symmetric hysteresis included. With lopsided loops (b1 = 1) all effects
    // together stay at some 3e-12 m for steps of 40 us and less, and each alone does not.
    let drive = Waveform::parse("triangle:50Hz:4V", 0.02).unwrap();
    let mut model = Preset::default().model;
    add(&mut model, "hysteresis_memory", &[("b1", 0.0)]);
    add(&mut model, "dry_friction", &[]);
    add(&mut model, "base_vibration", &[("a", 60.0), ("f", 300.0)]);
    add(&mut model, "quadratic_drag", &[("cd", 1e-6)]);
    add(&mut model, "cubic_stiffness", &[]);
    add(&mut model, "film_spring", &[]);
    let at = |step: Option<f64>| {
        let options = Options {
            rate: 10e3,
            tolerance: 1e-15,
            fixed_step: step,
            ..Options::default()
        };
        simulate(&model, &drive, 0.02, &options).unwrap().proof_mass
    };
    let fine = at(None);
    let error = |step: f64| {
        let coarse = at(Some(step));
        coarse
            .iter()
            .zip(&fine)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    };
    let errors = [160e-6, 80e-6, 40e-6].map(error);
    println!("{errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1] < pair[0] / 16.0, "{errors:?}");
    }
    assert!(errors[0] < 1e-9, "{errors:?}");
}
