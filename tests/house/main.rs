//! The house rules: what `docs/ARCHITECTURE.md` and `docs/CONTRIBUTING.md` promise about
//! `src` is read from the source itself and held here.
//!
//! Every rule is a function from a tree of files to the list of what breaks it, with a test
//! on a small made-up tree that breaks it.

mod circles;
mod constants;
mod effect_ids;
mod floors;
mod folders;
mod functions;
mod source;
mod uses;

/// Fails with one line per offence.
#[track_caller]
fn assert_none(rule: &str, offences: &[String]) {
    let n = offences.len();
    assert!(n == 0, "{rule}: {n} found\n  {}", offences.join("\n  "));
}
