//! Every lesson that comes with the program.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use super::super::*;
use crate::learn::catalogue::{EMBEDDED, lessons};
use crate::learn::prediction::{Prediction, score};
use crate::learn::run::Run;

/// The lessons with the runs of their steps, computed once for all tests.
fn all() -> &'static [(Lesson, Vec<Run>)] {
    static ALL: OnceLock<Vec<(Lesson, Vec<Run>)>> = OnceLock::new();
    ALL.get_or_init(|| {
        let with_runs = |lesson: Lesson| {
            let runs = lesson.steps.iter().map(|step| {
                let run = step.scene.run(&|| true);
                run.unwrap_or_else(|error| panic!("{}: {error}", lesson.id))
                    .unwrap()
            });
            let runs = runs.collect();
            (lesson, runs)
        };
        lessons().into_iter().map(with_runs).collect()
    })
}

fn steps() -> impl Iterator<Item = (&'static Lesson, &'static Step, &'static Run)> {
    all().iter().flat_map(|(lesson, runs)| {
        let steps = lesson.steps.iter().zip(runs);
        steps.map(move |(step, run)| (lesson, step, run))
    })
}

#[test]
fn every_lesson_that_comes_with_the_program_can_be_read() {
    for (name, text) in EMBEDDED {
        if let Err(error) = Lesson::parse(name, text) {
            panic!("{error}");
        }
    }
    let ids: BTreeSet<String> = lessons().into_iter().map(|lesson| lesson.id).collect();
    assert_eq!(ids.len(), EMBEDDED.len());
    assert!((8..=10).contains(&ids.len()), "{ids:?}");
    for (lesson, _) in all() {
        let tasks = lesson.steps.iter().map(|step| &step.task);
        let asks = tasks.clone().filter(|t| t.is_prediction()).count();
        let is_game = tasks
            .clone()
            .any(|t| matches!(t, Task::Concealed(_) | Task::Fit(_)));
        assert!(asks > 0 || is_game, "{} asks nothing", lesson.id);
        let last = lesson.steps.last().unwrap();
        let is_free = matches!(
            last.task,
            Task::Explore(_) | Task::Fit(_) | Task::Concealed(_)
        );
        assert!(is_free, "{} ends without something to explore", lesson.id);
    }
}

#[test]
fn every_number_that_a_lesson_states_is_computed() {
    for (lesson, step, run) in steps() {
        let written = step
            .written(run)
            .unwrap_or_else(|error| panic!("{}, {}: {error}", lesson.id, step.title));
        println!("## {} / {}\n{written:#?}", lesson.title, step.title);
        for text in [
            &written.text,
            &written.alt,
            &written.question,
            &written.because,
        ] {
            assert!(!text.contains(['{', '}']), "{}: {text}", lesson.id);
        }
    }
}

#[test]
fn every_step_says_in_words_what_its_pictures_show() {
    for (lesson, step, run) in steps() {
        let alt = step.written(run).unwrap().alt;
        let words = alt.split_whitespace().count();
        assert!(words >= 8, "{}, {}: \"{alt}\"", lesson.id, step.title);
        assert!(!step.pictures.is_empty(), "{}, {}", lesson.id, step.title);
    }
}

#[test]
fn the_right_answer_of_every_choice_is_what_the_simulation_does() {
    for (lesson, step, run) in steps() {
        let Task::Choice(choice) = &step.task else {
            continue;
        };
        let holds = choice.check.holds(run).unwrap();
        assert!(
            holds,
            "{}, {}: {}",
            lesson.id, step.title, choice.check.source
        );
    }
}

#[test]
fn every_mark_and_curve_can_be_right_and_its_start_is_not() {
    for (lesson, step, run) in steps() {
        let at = format!("{}, {}", lesson.id, step.title);
        match &step.task {
            Task::Mark(mark) => {
                let found = mark.simulated(run).unwrap();
                assert!(
                    found > mark.range.0 && found < mark.range.1,
                    "{at}: {found}"
                );
                let right = score(&step.task, &Prediction::Mark(found), run, &[]).unwrap();
                assert_eq!((right.score, right.stars()), (1.0, 3), "{at}");
                let middle = 0.5 * (mark.range.0 + mark.range.1);
                let start = score(&step.task, &Prediction::Mark(middle), run, &[]).unwrap();
                assert!(start.score < 1.0, "{at}: the start is right already");
            }
            Task::Curve(task) => {
                let (low, high) = crate::recording::extremes(&run.trace.proof_mass);
                let slack = 0.02 * (high - low);
                let fits = low >= task.range.0 - slack && high <= task.range.1 + slack;
                assert!(fits, "{at}: {low} to {high}");
                let last = run.trace.len() - 1;
                let right = (0..task.points).map(|i| {
                    let place = last * i / (task.points - 1);
                    run.trace.proof_mass[place]
                });
                let right = Prediction::Curve(right.collect());
                let right = score(&step.task, &right, run, &[]).unwrap();
                assert!(right.stars() >= 2, "{at}: {right:?}");
                let level = vec![0.5 * (task.range.0 + task.range.1); task.points];
                let level = score(&step.task, &Prediction::Curve(level), run, &[]).unwrap();
                assert!(level.stars() <= 1, "{at}: {level:?}");
            }
            _ => {}
        }
    }
}

/// Steps of a slider that are tried first.
const COARSE_STEPS: u32 = 8;
/// Steps of the keys over a slider: what a pupil reaches without a pointer.
const KEY_STEPS: u32 = 100;

/// Values of a control over its slider.
fn values(control: &Control, scene: &Scene, steps: u32) -> Vec<f64> {
    let spec = control.spec(scene).unwrap();
    let all = (0..=steps).map(|i| spec.value_at(f64::from(i) / f64::from(steps)));
    all.filter(|value| spec.refusal(*value).is_none()).collect()
}

#[test]
fn every_control_that_a_lesson_names_exists_and_moves_the_run() {
    let quick = |_: &Scene, run: &Run| run.trace.proof_mass.clone();
    for (lesson, step, run) in steps() {
        for control in step.task.controls() {
            let spec = control.spec(&step.scene);
            assert!(spec.is_some(), "{}: {}", lesson.id, control.id);
            let before = quick(&step.scene, run);
            let moves = values(control, &step.scene, COARSE_STEPS)
                .into_iter()
                .any(|value| {
                    let mut scene = step.scene.clone();
                    scene.set_control(&control.id, value);
                    let set = scene.control_value(&control.id).unwrap();
                    assert!((set - value).abs() <= 1e-9 * value.abs(), "{}", control.id);
                    let changed = scene.run(&|| true);
                    changed.is_ok_and(|run| quick(&scene, &run.unwrap()) != before)
                });
            assert!(moves, "{}: {} moves nothing", lesson.id, control.id);
        }
    }
}

#[test]
fn every_goal_is_reached_with_the_controls_of_its_step_and_not_before() {
    for (lesson, step, run) in steps() {
        let Task::Explore(explore) = &step.task else {
            continue;
        };
        let Some(goal) = &explore.goal else {
            continue;
        };
        let at = format!("{}, {}", lesson.id, step.title);
        assert!(!goal.holds(run).unwrap_or(false), "{at}: reached at once");
        let reaches = |scene: &Scene| {
            let run = scene.run(&|| true);
            run.is_ok_and(|run| goal.holds(&run.unwrap()).unwrap_or(false))
        };
        let with = |changes: &[(&Control, f64)]| {
            let mut scene = step.scene.clone();
            for (control, value) in changes {
                scene.set_control(&control.id, *value);
            }
            reaches(&scene)
        };
        let one = |steps: u32| {
            explore.controls.iter().any(|control| {
                let values = values(control, &step.scene, steps);
                values.into_iter().any(|value| with(&[(control, value)]))
            })
        };
        let two = || {
            explore.controls.iter().enumerate().any(|(i, a)| {
                explore.controls.iter().skip(i + 1).any(|b| {
                    values(a, &step.scene, COARSE_STEPS).into_iter().any(|va| {
                        let of_b = values(b, &step.scene, COARSE_STEPS);
                        of_b.into_iter().any(|vb| with(&[(a, va), (b, vb)]))
                    })
                })
            })
        };
        let found = one(COARSE_STEPS) || one(KEY_STEPS) || two();
        assert!(found, "{at}: {} is never reached", goal.source);
    }
}

#[test]
fn a_fit_by_hand_ends_at_the_noise_and_begins_far_from_it() {
    for (lesson, step, run) in steps() {
        let Task::Fit(fit) = &step.task else { continue };
        let target = fit.target(&step.scene, 1, &|| true).unwrap().unwrap();
        let before = target.misfit(run);
        assert!(before > 5.0, "{}: {before}", lesson.id);
        let mut scene = step.scene.clone();
        for (id, value) in &fit.truth {
            scene.set_control(id, *value);
        }
        let after = target.misfit(&scene.run(&|| true).unwrap().unwrap());
        assert!((after - 1.0).abs() < 0.05, "{}: {after}", lesson.id);
    }
}

#[test]
fn concealed_effects_are_seen_and_differ_from_each_other() {
    for (lesson, step, run) in steps() {
        let Task::Concealed(game) = &step.task else {
            continue;
        };
        for (i, level) in game.levels.iter().enumerate() {
            let mut drawn = BTreeMap::new();
            for seed in 0..60 {
                let round = game.draw(i, seed).unwrap();
                assert!(game.seal_holds(&round));
                drawn
                    .entry(game.opened(&round).unwrap().name.clone())
                    .or_insert(round);
            }
            assert_eq!(drawn.len(), level.candidates.len(), "{}", level.name);
            let mut targets = Vec::new();
            for (name, round) in &drawn {
                let target = game.target(&step.scene, round, &|| true).unwrap().unwrap();
                let misfit = target.misfit(run);
                println!("{}: {} {misfit:.2} x noise", level.name, name);
                if game.opened(round).unwrap().effect.is_some() {
                    assert!(misfit > 2.0, "{}: {name} is not seen: {misfit}", lesson.id);
                }
                targets.push((name, target));
            }
            for (a, b) in targets.iter().zip(targets.iter().skip(1)) {
                let pairs = a.1.readings.iter().zip(&b.1.readings);
                let sum: f64 = pairs.map(|(x, y)| (x - y).powi(2)).sum();
                let rms = (sum / a.1.readings.len() as f64).sqrt();
                assert!(rms > 2.0 * game.noise, "{} and {} look alike", a.0, b.0);
            }
        }
    }
}

#[test]
fn energies_of_every_step_add_up() {
    for (lesson, step, run) in steps() {
        let first = run.energies.points[0].1;
        let scale = run.energies.largest();
        for (t, now) in &run.energies.points {
            let left = now.imbalance(&first) / scale;
            // Effects that change a law (drive, contact, structure) are not forces of their own.
            let is_plain = step
                .scene
                .preset
                .model
                .effects
                .iter()
                .all(|e| e.spec == crate::model::effects::weight());
            if is_plain {
                let at = format!("{}, {} at {t}", lesson.id, step.title);
                assert!(left.abs() < 2e-3, "{at}: {left}");
            }
        }
    }
}
