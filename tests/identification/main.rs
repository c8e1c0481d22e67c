//! The identification: parameters fitted to recordings of known devices.

#[path = "../../examples/fit.rs"]
mod example;
#[path = "../oracle/mod.rs"]
mod oracle;

mod fit;

#[test]
fn the_example_runs() {
    example::main().unwrap();
}
