//! What `docs/lessons.md` says of the format.

use super::super::*;
use crate::learn::catalogue::EMBEDDED;
use crate::learn::controls::drive_ids;
use crate::learn::measures::RUN_MEASURES;
use crate::learn::prediction::{Prediction, score};

const DOCUMENT: &str = include_str!("../../../../docs/lessons.md");

/// The lesson in the document.
fn example() -> &'static str {
    let from = DOCUMENT.split_once("```toml\n").unwrap().1;
    from.split_once("```").unwrap().0
}

#[test]
fn the_lesson_in_the_document_is_sound_and_its_answers_are_right() {
    let lesson = Lesson::parse("dropped-phone.toml", example()).unwrap();
    assert_eq!(lesson.steps.len(), 5);
    for step in &lesson.steps {
        let run = step.scene.run(&|| true).unwrap().unwrap();
        let written = step.written(&run);
        let written = written.unwrap_or_else(|error| panic!("{}: {error}", step.title));
        println!("{written:#?}");
        match &step.task {
            Task::Choice(choice) => assert!(choice.check.holds(&run).unwrap(), "{}", step.title),
            Task::Mark(mark) => {
                let middle = 0.5 * (mark.range.0 + mark.range.1);
                let start = score(&step.task, &Prediction::Mark(middle), &run, &[]).unwrap();
                assert!(start.score < 1.0, "{}: the start is right", step.title);
            }
            Task::Explore(explore) => {
                let goal = explore.goal.as_ref().unwrap();
                assert!(!goal.holds(&run).unwrap());
                let mut scene = step.scene.clone();
                scene.set_control("alpha", 0.2);
                let run = scene.run(&|| true).unwrap().unwrap();
                assert!(goal.holds(&run).unwrap());
            }
            _ => {}
        }
    }
}

#[test]
fn the_document_names_every_measure_picture_and_control_of_drives() {
    let names = RUN_MEASURES.iter().map(|measure| measure.id);
    let names = names.chain(LessonPicture::ALL.map(LessonPicture::name));
    for name in names.chain(drive_ids()) {
        let is_there =
            DOCUMENT.contains(&format!("`{name}`")) || DOCUMENT.contains(&format!("`\"{name}\"`"));
        assert!(is_there, "{name} is missing in docs/lessons.md");
    }
    for measure in RUN_MEASURES {
        assert!(DOCUMENT.contains(measure.meaning), "{}", measure.id);
    }
}

#[test]
fn the_document_names_every_key_that_the_lessons_use() {
    fn keys(value: &toml::Value, path: &str, all: &mut Vec<String>) {
        match value {
            toml::Value::Table(table) => {
                for (key, inner) in table {
                    // Names of effects and parameters are no keys of the format.
                    let is_own = ["set", "truth", "effects"].contains(&path);
                    if !is_own {
                        all.push(key.clone());
                        keys(inner, key, all);
                    }
                }
            }
            toml::Value::Array(array) => {
                for inner in array {
                    keys(inner, path, all);
                }
            }
            _ => {}
        }
    }
    let mut all = Vec::new();
    for (_, text) in EMBEDDED {
        keys(&toml::from_str(text).unwrap(), "", &mut all);
    }
    assert!(all.len() > 100);
    for key in all {
        let quoted = format!("`{key}`");
        assert!(
            DOCUMENT.contains(&quoted) || key == "id",
            "{key} is missing in docs/lessons.md"
        );
    }
}
