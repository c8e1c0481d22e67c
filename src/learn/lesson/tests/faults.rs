//! What is refused, and what it says.

use super::super::*;

const SOUND: &str = r#"format = 1
id = "mine"
title = "Mine"
about = "A lesson of one step."
[setup]
preset = "bouncing-ball"
[[step]]
title = "One"
text = "It falls from {0.3 m = x0 + dp}."
alt = "A ball falls and bounces."
[step.explore]
task = "Move it."
controls = ["alpha"]
"#;

#[test]
fn a_faulty_lesson_is_refused_with_its_line_and_a_reason() {
    assert!(Lesson::parse("mine.toml", SOUND).is_ok());
    for (from, to, line, reason) in [
        ("format = 1", "format = 7", 1, "format 7 is not known"),
        ("title = \"Mine\"\n", "titel = \"Mine\"\n", 3, "titel"),
        ("id = \"mine\"", "id = \"My lesson\"", 2, "small letters"),
        (
            "bouncing-ball",
            "bouncing-bal",
            6,
            "there is no preset \"bouncing-bal\"; write one of paper",
        ),
        ("[[step]]", "duration = -1\n[[step]]", 7, "duration"),
        (
            "[[step]]",
            "drive = \"sine:10Hz:1V\"\n[[step]]",
            7,
            "no drive",
        ),
        (
            "[[step]]",
            "pictures = [\"devise\"]\n[[step]]",
            7,
            "there is no picture \"devise\"",
        ),
        ("[[step]]", "set = { Cs = \"3 kg\" }\n[[step]]", 7, "kg"),
        ("[[step]]", "set = { eta = 1.0 }\n[[step]]", 7, "no bearing"),
        (
            "[[step]]",
            "[setup.effects.gravitty]\ng = 1\n[[step]]",
            7,
            "there is no effect \"gravitty\"",
        ),
        (
            "[[step]]",
            "[setup.effects.gravity]\nh = 1\n[[step]]",
            8,
            "no parameter \"h\"",
        ),
        (
            "\"alpha\"",
            "\"alfa\"",
            13,
            "no control \"alfa\"; write one of",
        ),
        ("\"alpha\"", "\"drive.frequency\"", 13, "no control"),
        ("{0.3 m = x0 + dp}", "0.3 m", 9, "0.3 is not computed"),
        (
            "{0.3 m = x0 + dp}",
            "{impact_sped}",
            9,
            "no measure \"impact_sped\"",
        ),
        ("{0.3 m = x0 + dp}", "{x0:parsec}", 9, "parsec"),
        ("{0.3 m = x0 + dp}", "{x0 +}", 9, "cannot be read"),
        ("{0.3 m = x0 + dp}", "{x0", 9, "does not end"),
        ("A ball falls and bounces.", " ", 10, "alternative text"),
        ("[step.explore]", "[step.explor]", 11, "explor"),
        (
            "controls",
            "goal = \"impacts\"\ncontrols",
            13,
            "compares two",
        ),
        ("controls", "contrls", 13, "contrls"),
        ("title = \"One\"", "title = ", 8, ""),
    ] {
        let text = SOUND.replacen(from, to, 1);
        assert_ne!(text, SOUND, "{from}");
        let error = Lesson::parse("mine.toml", &text).unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.column >= 1 && error.to_string().starts_with("mine.toml, line "));
        assert!(
            error.reason.contains(reason),
            "{error} (expected: {reason})"
        );
        assert!(!error.reason.contains('\n'), "{error}");
    }
    let no_step = SOUND.split("[[step]]").next().unwrap();
    let error = Lesson::parse("mine.toml", no_step).unwrap_err();
    assert!(error.reason.contains("there is no step"), "{error}");
}

#[test]
fn a_stated_number_that_does_not_hold_is_refused() {
    let text = SOUND.replace("0.3 m =", "0.4 m =");
    let lesson = Lesson::parse("mine.toml", &text).unwrap();
    let step = &lesson.steps[0];
    let run = step.scene.run(&|| true).unwrap().unwrap();
    let error = step.written(&run).unwrap_err().to_string();
    assert!(
        error.contains("0.4 m") && error.contains("0.3 m"),
        "{error}"
    );
    let text = SOUND.replace("{0.3 m = x0 + dp}", "{contact_time(400)}");
    let lesson = Lesson::parse("mine.toml", &text).unwrap();
    let error = lesson.steps[0].written(&run).unwrap_err().to_string();
    assert!(error.contains("contact_time number 400"), "{error}");
}

#[test]
fn numbers_are_written_with_their_units_and_of_changed_scenes() {
    let text = SOUND.replace(
        "{0.3 m = x0 + dp}",
        "{x0 + dp:mm}, {alpha:%:2}, {arrival_time}, {rebound_height:mm @ alpha=1.0}, {{x0}}",
    );
    let lesson = Lesson::parse("mine.toml", &text).unwrap();
    let step = &lesson.steps[0];
    let run = step.scene.run(&|| true).unwrap().unwrap();
    let written = step.written(&run).unwrap().text;
    // A fall of 0.3 m under standard gravity takes sqrt(0.6 / g) = 247.35 ms.
    assert_eq!(written, "It falls from 300 mm, 70 %, 247 ms, 300 mm, {x0}.");
}
