use crate::model::effects::*;

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
