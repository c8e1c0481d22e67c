use proptest::prelude::*;

use crate::model::preset::*;

#[test]
fn embedded_presets_are_sound_and_come_back_from_text() {
    for (name, text) in EMBEDDED {
        let preset = Preset::parse(name, text).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(preset.model.name, name);
        let again = Preset::parse("again", &preset.to_toml()).unwrap();
        assert_eq!(preset, again);
    }
    let default = Preset::default().model;
    for (id, value) in default.parameters.iter() {
        assert_eq!(value, id.spec().default, "{}", id.spec().id);
    }
    let oscillator = Preset::embedded("oscillator").unwrap().model;
    assert!((oscillator.parameters[ParameterId::F1] - 1.36916).abs() < 1e-4);
    assert!((oscillator.structure().mobility() - 1.0 / 0.2016).abs() < 1e-9);
}

#[test]
fn known_values_are_read_in_either_form_and_come_back_from_text() {
    let text = EMBEDDED[0].1;
    let one_line = text.replacen(
        "format = 1\n",
        "format = 1\nknown = { zeta1 = [0.026, 1e-3], Cs = [1.7e-21, 2e-22] }\n",
        1,
    );
    let section = format!("{text}\n[known]\nzeta1 = [0.026, 1e-3]\nCs = [1.7e-21, 2e-22]\n");
    let (a, b) = (
        Preset::parse("a", &one_line).unwrap(),
        Preset::parse("b", &section).unwrap(),
    );
    assert_eq!(a, b);
    assert_eq!(a.known.len(), 2);
    assert_eq!(
        (a.known[0].id.as_str(), a.known[0].std_error),
        ("Cs", 2e-22)
    );
    assert_eq!(Preset::parse("again", &a.to_toml()).unwrap(), a);
    // Gravity is known where a preset comes with it.
    let faller = Preset::embedded("faller").unwrap();
    let g = &faller.known[0];
    assert_eq!((g.id.as_str(), g.value), ("gravity.g", 9.80665));
    assert!((g.std_error / g.value - 0.005).abs() < 1e-4);
}

#[test]
fn faults_of_known_values_are_named_with_their_line() {
    let text = EMBEDDED[0].1;
    let last = text.lines().count() + 3;
    for (line, key, part) in [
        ("zeta3 = [0.1, 0.1]", "zeta3", "no such parameter"),
        ("zeta1 = [0.026, 0.0]", "zeta1", "above 0"),
        ("alpha = [1.5, 0.1]", "alpha", "is above"),
        ("noise = [1e-8, 1e-9]", "noise", "belongs to the recording"),
        (
            "\"gravity.g\" = [9.81, 0.05]",
            "gravity.g",
            "no such parameter",
        ),
    ] {
        let section = format!("{text}\n[known]\n{line}\n");
        let said = Preset::parse("bad.toml", &section).unwrap_err().to_string();
        let place = format!("line {last}: {key}: ");
        assert!(said.contains(&place) && said.contains(part), "{said}");
        let one_line = text.replacen(
            "format = 1\n",
            &format!("format = 1\nknown = {{ {line} }}\n"),
            1,
        );
        let said = Preset::parse("bad.toml", &one_line)
            .unwrap_err()
            .to_string();
        assert!(said.contains("known: ") && said.contains(part), "{said}");
        assert!(!said.contains("line 1:"), "{said}");
    }
    let no_error = format!("{text}\n[known]\nzeta1 = 0.026\n");
    assert!(Preset::parse("bad.toml", &no_error).is_err());
}

#[test]
fn a_fault_in_a_line_of_half_a_megabyte_is_said_in_a_short_line() {
    let long = "x".repeat(467_000);
    let text = EMBEDDED[0].1;
    let cases = [
        long.clone(),
        format!("format = 1 {long}"),
        format!("{text}\n[effects.{long}]\n"),
        text.replacen("[parameters]\n", &format!("[parameters]\n{long} = 1\n"), 1),
        text.replacen(
            "[parameters]\n",
            &format!("[parameters]\ngp = \"{long}\"\n"),
            1,
        ),
        text.replacen("drive = \"", &format!("drive = \"{long}"), 1),
        format!("\"\\u001b[31m{long}\" = 2\n{text}"),
    ];
    for (i, case) in cases.iter().enumerate() {
        assert_ne!(case, text, "{i}");
        let said = Preset::parse("bad.toml", case).unwrap_err().to_string();
        assert!(said.len() < 1500, "{i}: {} bytes", said.len());
        assert!(said.contains("bad.toml, line "), "{i}: {said}");
        assert!(!said.contains(char::is_control), "{i}: {said:?}");
    }
}

#[test]
fn faults_are_named_with_line_and_key() {
    let text = EMBEDDED[0].1;
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        Preset::parse("bad.toml", &text.replacen(from, to, 1)).unwrap_err()
    };
    let cases = [
        (changed("gp = 70e-6", "gp = 50e-6"), "gp", "must exceed dp"),
        (
            changed("gp = 70e-6", "gpp = 70e-6"),
            "gpp",
            "no such parameter",
        ),
        (changed("gp = 70e-6", "gp = nan"), "gp", "finite"),
        (changed("alpha = 0.378", "alpha = 1.5"), "alpha", "above"),
        (
            changed("proof_mass = 3.495e-10", "proof_mass = -1.0"),
            "proof_mass",
            "above 0",
        ),
        (changed("format = 1", "format = 9"), "format", "not known"),
        (
            changed("ground = true", "grund = true"),
            "grund",
            "unknown field",
        ),
        (changed("square:15Hz:8V", "square:15Hz"), "drive", "needs 2"),
        (
            changed("proof_mass = 3.495e-10", "prof_mass = 1e-9"),
            "prof_mass",
            "unknown field",
        ),
        (changed("gp = 70e-6", "gp = \"wide\""), "gp", "invalid type"),
        (changed("gp = 70e-6", "gp = "), "gp", ""),
    ];
    for (error, key, reason) in cases {
        let PresetError::Invalid {
            line, key: found, ..
        } = &error
        else {
            panic!("{error}");
        };
        assert!(*line > 1, "{error}");
        assert_eq!(found, key, "{error}");
        assert!(error.to_string().contains(reason), "{error}");
    }
    // A stray key is said although something is missing before it.
    let both = text.replacen("proof_mass = 3.495e-10", "", 1);
    let both = both.replacen("drive = ", "drivee = ", 1);
    let error = Preset::parse("bad.toml", &both).unwrap_err().to_string();
    for part in ["drivee", "no such key", "missing field `proof_mass`"] {
        assert!(error.contains(part), "{error}");
    }
    let negative = EMBEDDED[2].1.replacen("mass = 0.2016", "mass = -0.2016", 1);
    let error = Preset::parse("bad.toml", &negative).unwrap_err();
    assert!(error.to_string().contains("mass"), "{error}");
    assert!(Preset::load("no/such/file.toml").is_err());
}

#[test]
fn the_rule_of_bounces_is_read_and_written() {
    let text = EMBEDDED[4].1;
    let line = "bounce = \"restitution\"";
    assert!(text.contains(line));
    let with = |lines: &str| Preset::parse("ball.toml", &text.replacen(line, lines, 1));
    let rule = |lines: &str| with(lines).unwrap().model.bounce;
    assert_eq!(rule(""), BounceRule::PullOff);
    assert_eq!(rule("bounce = \"pull-off\""), BounceRule::PullOff);
    let restitution = BounceRule::Restitution;
    assert_eq!(rule(line), restitution(StickSpeed::AdhesionOver(0.0)));
    let speed = format!("{line}\nstick_speed = 0.02");
    assert_eq!(rule(&speed), restitution(StickSpeed::Given(0.02)));
    let reach = format!("{line}\nadhesion_reach = 1e-6");
    assert_eq!(rule(&reach), restitution(StickSpeed::AdhesionOver(1e-6)));
    for lines in ["", line, speed.as_str(), reach.as_str()] {
        let preset = with(lines).unwrap();
        assert_eq!(Preset::parse("again", &preset.to_toml()).unwrap(), preset);
        // A session keeps the device in another form; without the rule it is as it was before.
        let stored = serde_json::to_value(&preset.model).unwrap();
        assert_eq!(stored.get("bounce").is_some(), !lines.is_empty());
        let again: Model = serde_json::from_value(stored).unwrap();
        assert_eq!(again, preset.model);
    }
    for (lines, key, reason) in [
        (
            "bounce = \"rubber\"".to_owned(),
            "bounce",
            "pull-off, restitution",
        ),
        ("stick_speed = 0.1".to_owned(), "stick_speed", "belongs to"),
        (
            "adhesion_reach = 0.1".to_owned(),
            "adhesion_reach",
            "belongs to",
        ),
        (
            format!("{speed}\nadhesion_reach = 1.0"),
            "adhesion_reach",
            "not both",
        ),
        (
            format!("{line}\nstick_speed = -0.1"),
            "stick_speed",
            "between 0",
        ),
        (
            format!("{line}\nadhesion_reach = nan"),
            "adhesion_reach",
            "between 0",
        ),
        ("bounce = 1".to_owned(), "bounce", "invalid type"),
    ] {
        let error = with(&lines).unwrap_err();
        let PresetError::Invalid {
            line, key: found, ..
        } = &error
        else {
            panic!("{error}");
        };
        assert!(*line > 1 && found == key, "{error}");
        assert!(error.to_string().contains(reason), "{error}");
    }
    let bare = EMBEDDED[2].1.replacen(
        "ground = false",
        "ground = false\nbounce = \"restitution\"",
        1,
    );
    let error = Preset::parse("bare.toml", &bare).unwrap_err().to_string();
    assert!(error.contains("without a ground"), "{error}");
}

#[test]
fn a_linear_drive_is_given_once() {
    let text = EMBEDDED[0].1;
    let both =
        "rising = [1.4796, -0.7057, -0.0255, 0.0016]\nfalling = [-0.6350, -0.6062, 0.0076, 0.0]";
    assert!(text.contains(both));
    let with = |lines: &str| Preset::parse("linear.toml", &text.replacen(both, lines, 1));
    let linear = with("gain = [0.1, -0.7]").unwrap();
    let piezo = linear.model.piezo.unwrap();
    assert_eq!(piezo.rising, [0.1, -0.7, 0.0, 0.0]);
    assert_eq!(piezo.rising, piezo.falling);
    let written = linear.to_toml();
    assert!(
        written.contains("gain = ") && !written.contains("rising"),
        "{written}"
    );
    assert_eq!(Preset::parse("again", &written).unwrap(), linear);
    // Two branches that are the same are one.
    let twice = with("rising = [0.1, -0.7]\nfalling = [0.1, -0.7, 0.0]").unwrap();
    assert_eq!(twice, linear);
    for (lines, key, reason) in [
        ("gain = [1.0]\nrising = [1.0]", "gain", "either gain"),
        ("rising = [1.0]", "rising", "falling is missing"),
        ("falling = [1.0]", "falling", "rising is missing"),
        ("", "gain", "or leave [piezo] out"),
        ("gain = []", "gain", "0 coefficients"),
        ("gain = [1.0, 2.0, 3.0, 4.0, 5.0]", "gain", "5 coefficients"),
        ("gain = [nan]", "gain", "finite"),
        ("gian = [1.0]", "gian", "unknown field"),
    ] {
        let error = with(lines).unwrap_err();
        let PresetError::Invalid {
            line, key: found, ..
        } = &error
        else {
            panic!("{error}");
        };
        assert!(*line > 1 && found == key, "{lines}: {error}");
        assert!(error.to_string().contains(reason), "{lines}: {error}");
    }
}

#[test]
fn a_pendulum_is_read_in_radians() {
    let text = EMBEDDED[2].1;
    let line = "cantilever = false";
    let with = |more: &str| {
        Preset::parse(
            "p.toml",
            &text.replacen(line, &format!("{line}\n{more}"), 1),
        )
    };
    let pendulum = with("coordinate = \"angle\"").unwrap();
    assert_eq!(pendulum.model.coordinate, Coordinate::Angle);
    assert_eq!(pendulum.model.unit_of("x0"), Some("rad"));
    assert_eq!(pendulum.model.unit_of("v0"), Some("rad/s"));
    assert_eq!(
        Preset::parse("again", &pendulum.to_toml()).unwrap(),
        pendulum
    );
    let plain = with("coordinate = \"length\"").unwrap();
    assert_eq!(plain.model.unit_of("x0"), Some("m"));
    assert!(!plain.to_toml().contains("coordinate"));
    let stored = serde_json::to_value(&plain.model).unwrap();
    assert!(stored.get("coordinate").is_none());
    let again: Model =
        serde_json::from_value(serde_json::to_value(&pendulum.model).unwrap()).unwrap();
    assert_eq!(again, pendulum.model);
    let error = with("coordinate = \"degrees\"").unwrap_err().to_string();
    assert!(error.contains("length, angle"), "{error}");
}

proptest! {
    #[test]
    fn no_text_panics(text in "\\PC*") {
        let _ = Preset::parse("x", &text);
    }

    #[test]
    fn no_damage_panics(at in 0usize..2000, insert in "\\PC{0,8}") {
        let mut text = EMBEDDED[0].1.to_owned();
        let at = (0..=at.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
        text.insert_str(at, &insert);
        let _ = Preset::parse("x", &text);
    }
}
