//! The search: differential evolution over numbers of the drive.
//!
//! Each waveform of a generation is moved by differences of others towards one of the best (current
//! to best of the p best, J. Zhang, A. C. Sanderson, IEEE Trans. Evol. Comput. 13 (2009) 945) and
//! replaced if the new one is no worse. All see the same ensemble. What it returns is judged anew by a
//! fresh ensemble, because the best of many is best by luck as well.

use std::sync::atomic::{AtomicBool, Ordering};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::ensemble::{Ensemble, Member};
use super::error::RobustnessError;
use super::evaluate::Cases;
use super::result::Robustness;
use super::search_setup::{SearchedNumber, WaveformSearch};
use crate::model::drive::Waveform;
use crate::model::unit::format_number;

/// Weight of the shortfall against the probability: it guides where no member keeps the wish, and
/// parts equals.
const SHORTFALL_WEIGHT: f64 = 0.2;
/// Share of a generation towards whose members the others move.
const LEADING_SHARE: f64 = 0.2;
/// Shares of a difference that is added, drawn for each waveform.
const STEP_SHARES: (f64, f64) = (0.4, 0.9);
/// Chance that a number is moved.
const CROSSOVER_CHANCE: f64 = 0.9;
/// Waveforms are set to steps of at most this share of the bounds of a number.
const SETTING_STEP: f64 = 1e-3;
/// Waveforms nearer than this, as a share of the bounds, are one.
const SAME_WAVEFORM_SHARE: f64 = 0.05;
/// The seed of the fresh ensemble is the ensemble's with these bits changed.
const FRESH_SEED_BITS: u64 = 0x5851_f42d_4c95_7f2d;
/// Members of the fresh ensemble over those of the search's.
const FRESH_MEMBER_FACTOR: usize = 4;
/// Most members of the fresh ensemble: the probability is then known to 0.5 %.
const FRESH_MEMBERS: usize = 10_000;
/// The same after the search was cancelled, so that it ends soon.
const FRESH_MEMBERS_OF_CANCELLED: usize = 64;

/// How far the search is.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchProgress {
    /// Generations done.
    pub generation: usize,
    /// Generations in all.
    pub generations: usize,
    /// Probability of the best so far, over the search's ensemble.
    pub probability: f64,
    /// The best so far.
    pub drive: Waveform,
}

/// A waveform that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundWaveform {
    /// The drive.
    pub drive: Waveform,
    /// Values of the searched numbers, in their order.
    pub values: Vec<f64>,
    /// Probability over the search's ensemble: optimistic.
    pub searched_probability: f64,
    /// What a fresh ensemble says.
    pub fresh: Robustness,
    /// Probability less that of the start, both over the fresh ensemble.
    pub gain: f64,
    /// Why it is among the best, in a sentence or two.
    pub why: String,
}

/// What the search found.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchResult {
    /// The best, by their probability over the fresh ensemble; empty if none is within the limits.
    pub best: Vec<FoundWaveform>,
    /// The start over the fresh ensemble; `None` if the start is impossible.
    pub start: Option<Robustness>,
    /// Whether the start is within the limits.
    pub start_is_within_limits: bool,
    /// Waveforms tried.
    pub tried: usize,
    /// Whether it was ended before its last generation.
    pub is_cancelled: bool,
}

/// A waveform of a generation.
#[derive(Debug, Clone)]
struct Candidate {
    values: Vec<f64>,
    /// `None` for a drive that is impossible.
    drive: Option<Waveform>,
    excess: f64,
    probability: f64,
    score: f64,
}

impl Candidate {
    /// Whether it is no worse: within limits before beyond them, then by score.
    fn is_no_worse_than(&self, other: &Self) -> bool {
        if self.excess > 0.0 || other.excess > 0.0 {
            self.excess <= other.excess
        } else {
            self.score >= other.score
        }
    }
}

/// Searches. When `cancel` is set it ends soon with the best so far. The same search gives the same
/// answer, whatever the number of threads.
///
/// # Errors
/// [`RobustnessError`] before any work.
pub fn find_robust_waveform(
    search: &WaveformSearch,
    cancel: &AtomicBool,
    on_progress: &(dyn Fn(SearchProgress) + Sync),
) -> Result<SearchResult, RobustnessError> {
    search.check()?;
    let members = search.ensemble.draw()?;
    let mut rng = ChaCha8Rng::seed_from_u64(search.seed);
    let first = first_generation(search, &mut rng);
    let judge = |values: Vec<Vec<f64>>| {
        let all = values.into_par_iter();
        all.map(|own| judged(search, &members, own, cancel))
            .collect::<Option<Vec<_>>>()
    };
    let mut tried = 0;
    let mut population = Vec::new();
    let mut generation = 0;
    while generation < search.generations {
        let next = if population.is_empty() {
            first.clone()
        } else {
            moved(search, &population, &mut rng)
        };
        let Some(next) = judge(next) else { break };
        tried += next.len();
        if population.is_empty() {
            population = next;
        } else {
            for (own, new) in population.iter_mut().zip(next) {
                if new.is_no_worse_than(own) {
                    *own = new;
                }
            }
        }
        generation += 1;
        if let Some((best, drive)) = ranked(&population).first() {
            on_progress(SearchProgress {
                generation,
                generations: search.generations,
                probability: best.probability,
                drive: (*drive).clone(),
            });
        }
    }
    summed_up(search, &population, tried, generation < search.generations)
}

/// The start, and others evenly over the bounds.
fn first_generation(search: &WaveformSearch, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let n = search.population;
    let mut all = vec![Vec::new(); n];
    for number in &search.numbers {
        let mut parts: Vec<usize> = (0..n).collect();
        for i in (1..n).rev() {
            parts.swap(i, rng.random_range(0..=i));
        }
        for (own, part) in all.iter_mut().zip(parts) {
            let share = (part as f64 + rng.random::<f64>()) / n as f64;
            own.push(settable(
                number,
                number.low + share * (number.high - number.low),
            ));
        }
    }
    all[0] = search.start();
    all
}

/// New values for each waveform of a generation.
fn moved(search: &WaveformSearch, population: &[Candidate], rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let n = population.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| {
        let (a, b) = (&population[*a], &population[*b]);
        a.excess
            .total_cmp(&b.excess)
            .then(b.score.total_cmp(&a.score))
    });
    let leading = ((LEADING_SHARE * n as f64).ceil() as usize).clamp(1, n);
    let one = |rng: &mut ChaCha8Rng, k: usize| {
        let leader = &population[order[rng.random_range(0..leading)]].values;
        let (a, b) = loop {
            let (a, b) = (rng.random_range(0..n), rng.random_range(0..n));
            if a != b && a != k && b != k {
                break (&population[a].values, &population[b].values);
            }
        };
        let (least, most) = STEP_SHARES;
        let step = least + (most - least) * rng.random::<f64>();
        let own = &population[k].values;
        let moved_for_sure = rng.random_range(0..own.len());
        let numbers = search.numbers.iter().enumerate();
        numbers
            .map(|(i, number)| {
                let is_moved = rng.random::<f64>() < CROSSOVER_CHANCE || i == moved_for_sure;
                let to = own[i] + step * (leader[i] - own[i]) + step * (a[i] - b[i]);
                // What leaves the bounds stops halfway.
                let within = if to < number.low {
                    0.5 * (number.low + own[i])
                } else if to > number.high {
                    0.5 * (number.high + own[i])
                } else {
                    to
                };
                if is_moved {
                    settable(number, within)
                } else {
                    own[i]
                }
            })
            .collect()
    };
    (0..n).map(|k| one(rng, k)).collect()
}

/// The value as a person would set it: a whole number of steps, a thousandth of the bounds or less.
fn settable(number: &SearchedNumber, value: f64) -> f64 {
    let step = 10f64.powi(((number.high - number.low) * SETTING_STEP).log10().floor() as i32);
    // Division by the inverse where it is whole: 0.3 rather than 0.30000000000000004.
    let rounded = if step < 1.0 {
        let steps = (1.0 / step).round();
        (value * steps).round() / steps
    } else {
        (value / step).round() * step
    };
    rounded.clamp(number.low, number.high)
}

/// `None` if it was cancelled.
fn judged(
    search: &WaveformSearch,
    members: &[Member],
    values: Vec<f64>,
    cancel: &AtomicBool,
) -> Option<Candidate> {
    let go_on = || !cancel.load(Ordering::Relaxed);
    if !go_on() {
        return None;
    }
    let drive = search.drive_with(&values).ok();
    let excess = drive
        .as_ref()
        .map_or(f64::INFINITY, |own| search.excess(own));
    let mut candidate = Candidate {
        values,
        drive,
        excess,
        probability: 0.0,
        score: f64::NEG_INFINITY,
    };
    // One beyond the limits needs no steady state.
    if let Some(drive) = candidate.drive.as_ref().filter(|_| excess == 0.0) {
        let found = over(search, &search.ensemble, members, drive, &go_on)?;
        candidate.probability = found.probability;
        candidate.score = found.probability - SHORTFALL_WEIGHT * found.mean_shortfall;
    }
    Some(candidate)
}

fn over(
    search: &WaveformSearch,
    ensemble: &Ensemble,
    members: &[Member],
    drive: &Waveform,
    go_on: &dyn Fn() -> bool,
) -> Option<Robustness> {
    let cases = Cases {
        request: &search.point,
        ensemble,
        members,
        wish: &search.wish,
    };
    let found = cases.answer(&[(search.model.clone(), drive.clone())], go_on)?;
    found.into_iter().next()
}

/// Those within the limits, the best first.
fn ranked(population: &[Candidate]) -> Vec<(&Candidate, &Waveform)> {
    let within = population.iter().filter(|own| own.excess == 0.0);
    let mut all: Vec<_> = within
        .filter_map(|own| Some((own, own.drive.as_ref()?)))
        .collect();
    all.sort_by(|(a, _), (b, _)| b.score.total_cmp(&a.score));
    all
}

/// The best that differ, over a fresh ensemble.
fn summed_up(
    search: &WaveformSearch,
    population: &[Candidate],
    tried: usize,
    is_cancelled: bool,
) -> Result<SearchResult, RobustnessError> {
    let mut chosen: Vec<(&Candidate, &Waveform)> = Vec::new();
    for own in ranked(population) {
        let differs = |other: &&Candidate| {
            distance(search, &own.0.values, &other.values) > SAME_WAVEFORM_SHARE
        };
        if chosen.len() < search.kept && chosen.iter().all(|(other, _)| differs(other)) {
            chosen.push(own);
        }
    }
    let most = if is_cancelled {
        FRESH_MEMBERS_OF_CANCELLED
    } else {
        FRESH_MEMBERS
    };
    let fresh = Ensemble {
        members: FRESH_MEMBER_FACTOR
            .saturating_mul(search.ensemble.members)
            .min(most),
        seed: search.ensemble.seed ^ FRESH_SEED_BITS,
        ..search.ensemble.clone()
    };
    let members = fresh.draw()?;
    let go_on = || true;
    let start_drive = search.drive_with(&search.start()).ok();
    let start = start_drive.as_ref();
    let start_is_within_limits = start.is_some_and(|own| search.excess(own) == 0.0);
    let start = start.and_then(|own| over(search, &fresh, &members, own, &go_on));
    let before = start.as_ref().map_or(0.0, |own| own.probability);
    let found = chosen.par_iter().filter_map(|(own, drive)| {
        let fresh = over(search, &fresh, &members, drive, &go_on)?;
        Some(FoundWaveform {
            drive: (*drive).clone(),
            values: own.values.clone(),
            searched_probability: own.probability,
            gain: fresh.probability - before,
            why: why(&fresh, before),
            fresh,
        })
    });
    let mut best: Vec<FoundWaveform> = found.collect();
    best.sort_by(|a, b| b.fresh.probability.total_cmp(&a.fresh.probability));
    Ok(SearchResult {
        best,
        start,
        start_is_within_limits,
        tried,
        is_cancelled,
    })
}

/// Largest difference of two waveforms' numbers as a share of their bounds.
fn distance(search: &WaveformSearch, a: &[f64], b: &[f64]) -> f64 {
    let own = search.numbers.iter().zip(a.iter().zip(b));
    let shares = own.map(|(number, (a, b))| (a - b).abs() / (number.high - number.low));
    shares.fold(0.0, f64::max)
}

fn why(fresh: &Robustness, before: f64) -> String {
    let percent = |share: f64| format_number(100.0 * share, 3);
    let mut text = format!(
        "keeps the wish in {} % of {} fresh devices (\u{b1} {} %), the start in {} %",
        percent(fresh.probability),
        fresh.members,
        percent(fresh.std_error()),
        percent(before)
    );
    for own in fresh.quantiles.iter().filter(|own| own.count > 0) {
        let spec = own.measure.spec();
        let unit = if spec.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", spec.unit)
        };
        text += &format!(
            "; {} {} to {}{unit} (5 to 95 %)",
            spec.name,
            format_number(own.low, 3),
            format_number(own.high, 3)
        );
    }
    if let Some((regime, share)) = fresh.regimes.first() {
        text += &format!("; {} in {} %", regime.label(), percent(*share));
    }
    text += &match &fresh.breaker {
        Some(own) if own.difference > 0.0 => format!("; a larger {} breaks it first", own.id),
        Some(own) => format!("; a smaller {} breaks it first", own.id),
        None if fresh.probability < 1.0 => "; no single coefficient breaks it".to_owned(),
        None => String::new(),
    };
    text
}
