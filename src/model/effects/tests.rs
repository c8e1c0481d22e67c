use crate::model::effects::*;
use crate::model::piezo::Branch;
use crate::model::sensor::Point;

#[test]
fn catalogue_is_sound() {
    for (i, effect) in CATALOGUE.iter().enumerate() {
        assert_eq!(find(effect.id), Some(*effect));
        assert!(CATALOGUE[..i].iter().all(|other| other.id != effect.id));
        assert!(effect.sentence.ends_with('.'), "{}", effect.id);
        for parameter in effect.parameters {
            assert!(
                parameter.refusal(parameter.default).is_none(),
                "{} {}",
                effect.id,
                parameter.id
            );
        }
    }
}

#[test]
fn properties_refer_to_parameters_and_effects_that_exist() {
    let motion = Motion {
        is_driven: true,
        has_ground: true,
        is_sprung: true,
        contact_distance: 58e-6,
        length: 60e-6,
        speed: 0.2,
        force: 1e-6,
        interval: 2e-5,
    };
    for effect in CATALOGUE {
        let id = effect.id;
        let count = effect.parameters.len();
        let (facts, search) = (&effect.facts, &effect.search);
        let has = |parameter: &str| effect.parameters.iter().any(|p| p.id == parameter);
        assert!(facts.feature_strength.is_none_or(has), "{id}");
        assert!(facts.strengths.iter().all(|p| has(p)), "{id}");
        assert!(search.deferred.iter().all(|p| has(p)), "{id}");
        let indices = [facts.friction_force, facts.reading_delay];
        assert!(indices.into_iter().flatten().all(|i| i < count), "{id}");
        assert!(
            facts.edge_lags.iter().all(|lag| lag.parameter < count),
            "{id}"
        );
        assert!(search.bounds.iter().all(|(i, _)| *i < count), "{id}");
        if let Some(twin) = facts.twin_in_flight {
            let back = twin_in_flight(twin);
            assert_eq!(twin_in_flight(id).map(|e| e.id), Some(twin));
            assert_eq!(back.map(|e| e.id), Some(id));
        }
        if let FoundBy::Starts(starts) = search.found_by {
            let sprung = starts(&motion);
            let falling = starts(&Motion {
                is_sprung: false,
                ..motion
            });
            assert!(!(sprung.is_empty() && falling.is_empty()), "{id}");
            for start in sprung.iter().chain(&falling) {
                assert_eq!(start.values.len(), count, "{id}");
                let all = start.free.iter().chain(start.shape);
                assert!(all.chain([&start.strength]).all(|i| *i < count), "{id}");
            }
        }
    }
    for law in [
        ContactLaw::Restitution,
        ContactLaw::Adhesion,
        ContactLaw::Compliance,
    ] {
        assert!(of_contact_law(law).is_some(), "{law:?}");
    }
}

#[test]
fn first_guesses_of_laws_of_displacement_are_as_large_on_any_device() {
    let around = |act: &dyn Fn(&Surroundings<'_>)| {
        let model = crate::model::preset::Preset::default().model;
        act(&Surroundings {
            structure: &model.structure(),
            parameters: &model.parameters,
            piezo: None,
        });
    };
    let mut seen = 0;
    for (length, force) in [(60e-6, 4e-7), (0.3, 4.5), (1.2, 46.0)] {
        let motion = Motion {
            is_driven: false,
            has_ground: false,
            is_sprung: true,
            contact_distance: 1.0,
            length,
            speed: 1.0,
            force,
            interval: 0.01,
        };
        for id in ["even_stiffness", "cubic_stiffness", "load_friction"] {
            let spec = find(id).unwrap();
            let FoundBy::Starts(starts) = spec.search.found_by else {
                panic!("{id}");
            };
            for start in starts(&motion) {
                around(&|around| {
                    let action = (spec.build)(&start.values, around);
                    let at = Kinematics {
                        xp: length,
                        ..Kinematics::default()
                    };
                    let size = action.force_on_proof_mass(&at, &[]).abs() + action.friction(length);
                    // The sine form lags behind the cubic at the largest displacement.
                    let share = size / (1e-3 * force);
                    assert!((0.3..1.01).contains(&share), "{id} {start:?}: {share}");
                });
                seen += 1;
            }
        }
    }
    assert_eq!(seen, 3 * 6);
}

#[test]
fn what_an_effect_says_it_leaves_alone_it_leaves_alone() {
    let model = crate::model::preset::Preset::embedded("paper")
        .unwrap()
        .model;
    let around = Surroundings {
        structure: &model.structure(),
        parameters: &model.parameters,
        piezo: model.piezo,
    };
    let one = Kinematics {
        t: 0.1,
        xp: -3e-6,
        vp: 2e-3,
        xc: 1e-6,
        vc: -1e-3,
        voltage: 3.0,
        gain: 2.0,
        film: 1e-9,
    };
    // The same instant of another motion.
    let other = Kinematics {
        xp: 5e-6,
        vp: -7e-3,
        xc: 2e-6,
        vc: 4e-3,
        film: -3e-9,
        ..one
    };
    let (mut driving, mut reading) = (0, 0);
    for spec in CATALOGUE {
        let own = spec.parameters.iter();
        let values: Vec<f64> = own.map(|p| 0.5 * (p.range.0 + p.range.1)).collect();
        let action = (spec.build)(&values, &around);
        let z = vec![0.3; action.state_rates().len()];
        let drive = |at: &Kinematics| {
            (
                action.drive_voltage(3.0, at, &z),
                action.hysteresis(2.0, 3.0, Branch::Rising, &z),
                action.drive_gain(2.0, at, &z),
            )
        };
        let moves = action.force_on_proof_mass(&one, &z) != 0.0
            || action.film_force(1e-9, &z) != 1e-9
            || action.base_acceleration(0.1) != 0.0;
        if action.acts_on_drive() {
            driving += 1;
            assert!(!moves && drive(&one) == drive(&other), "{}", spec.id);
            let inputs = |at: &Kinematics| {
                let mut inputs = vec![0.0; z.len()];
                action.state_inputs(at, &z, &mut inputs);
                inputs
            };
            assert_eq!(inputs(&one), inputs(&other), "{}", spec.id);
        } else {
            assert_eq!(drive(&one), (3.0, 2.0, 2.0), "{}", spec.id);
        }
        if !action.acts_on_motion() {
            assert!(!moves && !action.acts_on_drive(), "{}", spec.id);
        }
        if action.acts_on_readings() {
            reading += 1;
        } else {
            let read = action.reading(1e-6, Point::ProofMass, 0.1, &z);
            assert_eq!(read, 1e-6, "{}", spec.id);
        }
    }
    assert_eq!((driving, reading), (3, 2));
}
