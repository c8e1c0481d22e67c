//! The diagnosis: what was concealed in made-up recordings is found, or said to be unknown.

mod choices;
mod diagnose;
#[path = "../../examples/diagnose.rs"]
mod example;
mod invariance;

#[test]
fn the_example_runs() {
    example::main().unwrap();
}
