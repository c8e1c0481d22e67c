//! The lessons gone through with keys alone, from the first step to the last.

use std::sync::Arc;
use std::time::Duration;

use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::super::window::Shell;
use super::{harness_in_steps, preset, read_all, wait};
use crate::app::actions::save::save;
use crate::app::analysis::learning::{Learning, OpenStep, Phase, built_in};
use crate::app::files::event::Purpose;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::shell::options::WindowOptions;
use crate::learn::lesson::{Choice, Lesson, Mark, Step, Task};

/// Length of a frame \[s\]: a run plays in a hundred of them.
const FRAME: f32 = 0.1;

fn learning<'a>(harness: &'a Harness<'_, Shell>) -> &'a Learning {
    &harness.state().services.state.learning
}

fn open<'a>(harness: &'a Harness<'_, Shell>) -> &'a OpenStep {
    learning(harness).open.as_ref().unwrap()
}

/// A window in which the lessons were opened by their key.
fn pupil() -> Harness<'static, Shell> {
    let mut harness = harness_in_steps(preset("paper"), WindowOptions::default(), FRAME);
    wait(&mut harness, |_| true);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num4);
    harness.run_steps(3);
    let state = &harness.state().services.state;
    assert_eq!(state.view.workspace, WorkspaceId::Learn.name());
    harness
}

fn until(harness: &mut Harness<'_, Shell>, what: &str, done: impl Fn(&OpenStep) -> bool) {
    for _ in 0..6000 {
        if done(open(harness)) {
            return harness.run_steps(2);
        }
        if open(harness).result().is_none() {
            std::thread::sleep(Duration::from_millis(5));
        }
        harness.run_steps(1);
    }
    let step = open(harness);
    panic!("{}, step {}: {what}", step.lesson.id, step.index + 1);
}

fn press(harness: &mut Harness<'_, Shell>, key: Key, times: usize) {
    for _ in 0..times {
        harness.key_press(key);
    }
    harness.run_steps(2);
}

/// Goes on with Tab until a control of this role, whose name has `part` in it, has the focus.
fn focus(harness: &mut Harness<'_, Shell>, role: Role, part: &str) {
    for _ in 0..200 {
        harness.key_press(Key::Tab);
        harness.run_steps(1);
        let here = harness.query_all_by_role(role).any(|node| {
            let name = node.accesskit_node().label().unwrap_or_default();
            node.is_focused() && name.contains(part)
        });
        if here {
            return;
        }
    }
    let step = open(harness);
    panic!(
        "{}, step {}: \"{part}\" is not reached by Tab",
        step.lesson.id,
        step.index + 1
    );
}

/// Moves the focused slider.
fn move_slider(harness: &mut Harness<'_, Shell>, steps: i32) {
    let key = if steps < 0 {
        Key::ArrowLeft
    } else {
        Key::ArrowRight
    };
    press(harness, key, steps.unsigned_abs() as usize);
}

/// Drops the focus, as a person does who has finished with a control.
fn leave_control(harness: &mut Harness<'_, Shell>) {
    press(harness, Key::Escape, 1);
}

fn is_seen(step: &OpenStep) -> bool {
    step.phase == Phase::Seen && step.scored.is_some()
}

fn choose(harness: &mut Harness<'_, Shell>, choice: &Choice) {
    let keys = [Key::Num1, Key::Num2, Key::Num3, Key::Num4];
    press(harness, keys[choice.right], 1);
    press(harness, Key::Enter, 1);
    assert_eq!(open(harness).phase, Phase::Watching);
    until(harness, "the run does not end", is_seen);
}

fn mark(harness: &mut Harness<'_, Shell>, mark: &Mark) {
    let found = mark
        .simulated(&open(harness).result().unwrap().run)
        .unwrap();
    // Without a control in focus, the first arrow key moves the mark, too.
    press(harness, Key::ArrowRight, 1);
    assert_ne!(
        open(harness).draft.mark,
        0.5 * (mark.range.0 + mark.range.1)
    );
    let steps = (found - open(harness).draft.mark) / mark.step();
    move_slider(harness, steps.round() as i32);
    press(harness, Key::Enter, 1);
    until(harness, "the run does not end", is_seen);
}

fn curve(harness: &mut Harness<'_, Shell>) {
    focus(harness, Role::Slider, "height of the point");
    let middle = open(harness).draft.curve[0];
    move_slider(harness, 12);
    assert!(open(harness).draft.curve[0] > middle);
    press(harness, Key::Period, 1);
    assert_eq!(open(harness).draft.point, 1);
    press(harness, Key::Comma, 1);
    assert_eq!(open(harness).draft.point, 0);
    focus(harness, Role::Button, "Next point");
    press(harness, Key::Enter, 1);
    assert_eq!(open(harness).draft.point, 1);
    focus(harness, Role::Slider, "height of the point");
    move_slider(harness, 7);
    move_slider(harness, -13);
    assert!(open(harness).draft.curve[1] < middle);
    press(harness, Key::Enter, 1);
    until(harness, "the run does not end", is_seen);
}

/// Moves every slider of the step, one after the other.
fn explore(harness: &mut Harness<'_, Shell>, step: &Step) {
    for control in step.task.controls() {
        let before = open(harness).scene.clone();
        focus(harness, Role::Slider, &control.id);
        let spec = control.spec(&before).unwrap();
        let fraction = spec.fraction(before.control_value(&control.id).unwrap());
        move_slider(harness, if fraction > 0.5 { -3 } else { 3 });
        assert_ne!(open(harness).scene, before, "{} does not move", control.id);
        until(harness, "no run of the moved scene", |open| !open.is_busy());
    }
}

fn step_through(harness: &mut Harness<'_, Shell>, lesson: &Lesson, step: &Step) {
    until(harness, "no run", |open| {
        open.result().is_some() && !open.is_busy()
    });
    assert_eq!(open(harness).problem, None, "{}, {}", lesson.id, step.title);
    let written = Arc::clone(&open(harness).result().unwrap().written);
    // What the pictures show is said in words to those who do not see them.
    let words = harness.query_all_by_role(Role::Image);
    let is_said = words
        .map(|node| node.accesskit_node().label().unwrap_or_default())
        .any(|label| label == written.alt);
    assert!(is_said, "{}, {}: {}", lesson.id, step.title, written.alt);
    match &step.task {
        Task::Watch => {
            press(harness, Key::Space, 1);
            until(harness, "the run does not end", |open| {
                open.phase == Phase::Seen
            });
        }
        Task::Choice(task) => choose(harness, task),
        Task::Mark(task) => mark(harness, task),
        Task::Curve(_) => curve(harness),
        Task::Explore(_) => explore(harness, step),
        Task::Fit(_) => {
            explore(harness, step);
            focus(harness, Role::Button, "Hand in");
            press(harness, Key::Enter, 1);
        }
        Task::Concealed(game) => {
            explore(harness, step);
            focus(harness, Role::Button, &game.levels[0].candidates[0].name);
            press(harness, Key::Enter, 1);
            assert_eq!(open(harness).guess, Some(0));
        }
    }
    leave_control(harness);
}

/// Goes through the lessons of a range, from the list's beginning, and checks what is kept.
fn go_through(range: std::ops::Range<usize>) {
    let mut harness = pupil();
    for _ in 0..range.start {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::PageDown);
        harness.run_steps(2);
    }
    for lesson in &built_in()[range] {
        assert_eq!(open(&harness).lesson.id, lesson.id);
        for (i, step) in lesson.steps.iter().enumerate() {
            assert_eq!((open(&harness).index, &open(&harness).lesson), (i, lesson));
            step_through(&mut harness, lesson, step);
            press(&mut harness, Key::PageDown, 1);
        }
        let pupil = &learning(&harness).pupil;
        let progress = pupil.progress(&lesson.id);
        assert!(progress.is_done, "{}", lesson.id);
        for (i, step) in lesson.steps.iter().enumerate() {
            let answer = progress.answers.get(&i);
            match &step.task {
                // A right choice and a mark moved to its place earn all points.
                Task::Choice(_) | Task::Mark(_) => {
                    assert_eq!(answer.unwrap().scored.stars(), 3, "{}, {i}", lesson.id);
                }
                Task::Watch | Task::Explore(_) => assert_eq!(answer, None),
                _ => assert!(answer.is_some(), "{}, {i}", lesson.id),
            }
        }
    }
}

#[test]
fn the_first_lessons_are_gone_through_by_keys_alone() {
    go_through(0..3);
}

#[test]
fn the_next_lessons_are_gone_through_by_keys_alone() {
    go_through(3..6);
}

#[test]
fn the_last_lessons_are_gone_through_by_keys_alone() {
    assert_eq!(built_in().len(), 10);
    go_through(6..10);
}

#[test]
fn answers_are_written_as_a_table_and_forgotten_by_a_reset() {
    let mut harness = pupil();
    let lesson = Arc::clone(&built_in()[2]);
    let asks = |step: &Step| matches!(step.task, Task::Choice(_));
    let place = lesson.steps.iter().position(asks).unwrap();
    let state = &mut harness.state_mut().services.state;
    state.learning.open_step(&lesson, place);
    step_through(&mut harness, &lesson, &lesson.steps[place]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("answers.csv");
    save(
        &mut harness.state_mut().services,
        Purpose::Answers,
        path.clone(),
    );
    read_all(&mut harness);
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines = text.lines();
    let head = "lesson,step,title,task,predicted,simulated,difference,score,tries";
    assert_eq!(lines.next(), Some(head));
    let row = lines.next().unwrap();
    let begin = format!(
        "{},{},{},choice,",
        lesson.id,
        place + 1,
        lesson.steps[place].title
    );
    assert!(row.starts_with(&begin), "{row}");
    assert!(row.ends_with(",1.00,1"), "{row}");
    assert_eq!(lines.next(), None);
    harness.state_mut().services.state.learning.reset();
    harness.run_steps(2);
    assert!(
        learning(&harness)
            .pupil
            .progress(&lesson.id)
            .answers
            .is_empty()
    );
    assert_eq!(open(&harness).index, 0);
}
