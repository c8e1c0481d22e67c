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
