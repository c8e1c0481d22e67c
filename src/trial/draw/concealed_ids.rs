//! Which effects a trial conceals, and how large they are to be.

use super::settings::{Mix, Settings};
use crate::trial::rng::TrialRng;
use crate::trial::truth::Class;

/// Class and ids of what is concealed. `effects` are those of the catalogue that the rig can have,
/// `outside` the laws that the catalogue does not have.
pub(super) fn conceal(
    mix: &Mix,
    effects: &[&str],
    outside: &[&str],
    rng: &mut TrialRng,
) -> (Class, Vec<String>) {
    let lot = rng.between(0.0, 1.0);
    let class = match mix {
        Mix::Only(class) => *class,
        Mix::Effect(id) if id.starts_with("outside_") => Class::Outside,
        Mix::Effect(_) => Class::One,
        Mix::Standard if lot < 0.25 => Class::Nothing,
        Mix::Standard if lot < 0.75 => Class::One,
        // A device with one effect at most has no second.
        Mix::Standard if lot < 0.9 && effects.len() < 2 => Class::One,
        Mix::Standard if lot < 0.9 => Class::Two,
        Mix::Standard => Class::Outside,
    };
    let shown = effects.len();
    let ids = match (mix, class) {
        (Mix::Effect(id), _) => vec![id.clone()],
        (_, Class::Nothing) => Vec::new(),
        (_, Class::One) => vec![effects[rng.below(shown)].to_owned()],
        (_, Class::Two) => {
            let first = rng.below(shown);
            let second = (first + 1 + rng.below(shown.saturating_sub(1))) % shown;
            vec![effects[first].to_owned(), effects[second].to_owned()]
        }
        (_, Class::Outside) => vec![outside[rng.below(outside.len())].to_owned()],
    };
    (class, ids)
}

/// Size over the smallest visible that an effect is to have.
pub(super) fn target_size(settings: &Settings, class: Class, rng: &mut TrialRng) -> f64 {
    let (low, high) = settings.sizes.unwrap_or(match class {
        Class::One => (0.5, 30.0),
        _ => (3.0, 30.0),
    });
    rng.log_between(low, high)
}
