//! Reads lessons and shows what a pupil reads: every text with its computed numbers, whether the
//! right answers are right, and what marks and fits come to.
//!
//! `cargo run --example lesson -- FILE.toml...`

use std::process::ExitCode;

use impactscope::learn::lesson::{Lesson, Task};

fn main() -> ExitCode {
    let mut is_sound = true;
    for file in std::env::args().skip(1) {
        if let Err(error) = show(&file) {
            eprintln!("{error}");
            is_sound = false;
        }
    }
    if is_sound {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn show(file: &str) -> Result<(), Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(file)?;
    let lesson = Lesson::parse(file, &text)?;
    println!("# {} ({})", lesson.title, lesson.id);
    for (i, step) in lesson.steps.iter().enumerate() {
        println!("\n## {}. {}", i + 1, step.title);
        let Some(run) = step.scene.run(&|| true)? else {
            continue;
        };
        match step.written(&run) {
            Ok(written) => {
                println!("{}\n[{}]", written.text, written.alt);
                println!(
                    "Q: {}\n{:?}\nA: {}",
                    written.question, written.options, written.because
                );
            }
            Err(error) => println!("FAULT {error}"),
        }
        match &step.task {
            Task::Choice(choice) => {
                println!(
                    "check {}: {:?}",
                    choice.check.source,
                    choice.check.holds(&run)
                );
            }
            Task::Mark(mark) => {
                let found = mark.simulated(&run).map(|value| mark.text(value));
                println!("mark: {found:?}");
            }
            Task::Explore(explore) => {
                let goal = explore.goal.as_ref().map(|goal| goal.holds(&run));
                println!("goal reached at once: {goal:?}");
            }
            Task::Fit(fit) => {
                if let Some(target) = fit.target(&step.scene, 1, &|| true)? {
                    println!("misfit at the start: {:.2}", target.misfit(&run));
                }
            }
            Task::Concealed(game) => {
                for level in 0..game.levels.len() {
                    for seed in 0..12 {
                        let Some(round) = game.draw(level, seed) else {
                            continue;
                        };
                        let name = game.opened(&round).map(|c| c.name.clone());
                        if let Some(target) = game.target(&step.scene, &round, &|| true)? {
                            println!("level {}: {name:?} {:.2}", level + 1, target.misfit(&run));
                        }
                    }
                }
            }
            Task::Watch | Task::Curve(_) => {}
        }
        let (low, high) = (
            run.trace
                .proof_mass
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min),
            run.trace
                .proof_mass
                .iter()
                .copied()
                .fold(f64::NEG_INFINITY, f64::max),
        );
        println!(
            "range {low:.4e} .. {high:.4e}, {} events, {} contacts",
            run.trace.events.len(),
            run.trace.contacts.len()
        );
    }
    Ok(())
}
