//! Straight lines that repeat.
//!
//! [`tie`] finds which knots repeat, [`estimate`] the numbers of the waveform under which all samples
//! together are likeliest ([`likelihood`], by the free [`numbers`]), [`settings`] those that a person
//! would have set, [`spread`] what stays open.

mod estimate;
mod likelihood;
mod numbers;
mod open_numbers;
mod settings;
pub mod spread;
mod tie;
mod waveform;

use self::tie::find_cycle;
pub use self::waveform::Cycle;
use super::knots::Knots;
use super::samples::Samples;

/// The cycle that `knots`, found in `part`, are, if it is all there is in `samples`.
pub fn cycle_of(samples: &Samples<'_>, part: &Samples<'_>, knots: &Knots) -> Option<Cycle> {
    let is_all = |cycle: &Cycle| cycle.expand(samples.in_time()).are_all_of(samples);
    let tied = find_cycle(part, knots)?;
    let mut likeliest = spread::likeliest(part, &tied);
    if part.len() < samples.len()
        && let Some(estimate) = likeliest.as_ref().filter(|e| is_all(&e.cycle))
    {
        likeliest = spread::likeliest(samples, &estimate.cycle).or(likeliest);
    }
    let Some(mut exact) = likeliest else {
        return Some(tied).filter(is_all);
    };
    exact.cycle.spread = spread::of(part, knots, &exact);
    let rounded = settings::rounded(samples, part, knots, &exact);
    exact.set_bounds(spread::reach_sigmas(samples, &exact.cycle));
    [rounded, exact.cycle, tied].into_iter().find(is_all)
}
