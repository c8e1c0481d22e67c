//! The simulator: against an independent integrator, closed forms, the device written
//! again, and the properties that must hold whatever the parameters.

#[path = "../../examples/simulate.rs"]
mod example;
#[path = "../oracle/mod.rs"]
mod oracle;
mod support;
mod twin;

mod absurd;
mod accuracy;
mod bouncing;
mod closed_forms;
mod convergence;
mod damping;
mod effects;
mod effects_off;
mod effects_together;
mod forces;
mod properties;
mod random_devices;
mod reference;

#[test]
fn the_example_runs() {
    example::main().unwrap();
}
