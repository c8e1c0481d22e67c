//! Each rig's recordings have the properties that it claims, and tell nothing else.

mod instruments;
mod one_mode;
mod trials;

use crate::recording::Recording;
use crate::trial::*;

/// The trial of a rig with nothing concealed: it is made quickly.
pub(super) fn plain(rig: &str, seed: u64) -> Case {
    let settings = Settings {
        mix: Mix::Only(Class::Nothing),
        ..Settings::of_rig(rig)
    };
    Case::draw(seed, &settings).unwrap()
}

pub(super) fn all(case: &Case) -> Vec<&Recording> {
    let recordings = case.recordings();
    let both = recordings.train.iter().chain(&recordings.held_out);
    both.map(|r| &**r).collect()
}

pub(super) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(n, s), v| (n + 1.0, s + v * v));
    (sum / f64::max(count, 1.0)).sqrt()
}
