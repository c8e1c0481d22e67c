//! View 3: a further mode that is too weak for a hump of its own shows in step with what sets it
//! ringing. Each impact does so by as much as the speed of the mass jumps there, each jump of the
//! drive by its force: the phase is known in every stretch, and few numbers tell the ring in all
//! of them.

use std::f64::consts::TAU;

use nalgebra::{Complex, Matrix2, SymmetricEigen, Vector2};
use rayon::prelude::*;

use super::bench::{Fitted, Side};
use super::ring::{self, LOWEST, Left, Ring};
use crate::fit::segment::{Joint, JointKind, Segment};
use crate::model::drive::Segment as Piece;
use crate::recording::events::Impact;
use crate::sim::SimError;

/// Dampings that are tried, as shares of critical damping.
const DAMPINGS: [f64; 4] = [0.002, 0.005, 0.012, 0.03];
/// Distance of the frequencies that are tried, in units of the damping: half of what passes for
/// the same.
const STEP: f64 = 1.0;
/// Fall of chi2 by three numbers at the best of some thousand frequencies and dampings from which
/// it is no chance.
const SURE: f64 = 25.0;
/// Times what most frequencies promise: what is left of something else is broad.
const OUTSTANDING: f64 = 4.0;
/// Share of the frequencies that most are.
const MOST: f64 = 0.8;
/// A frequency that is known is looked for within this factor.
const NEAR: f64 = 1.03;
/// A ring is over after so many of its times.
const OVER: f64 = 8.0;

/// What a ring that begins with impacts would bring.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Promise {
    frequency: f64,
    zeta: f64,
    /// Fall of chi2.
    gain: f64,
    /// How the two readings share in it.
    shape: (f64, f64),
}

/// What sets a mode ringing, and by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kick {
    /// When, by the reading's clock \[s\].
    time: f64,
    size: f64,
}

/// Of one recording: impacts by their change of speed \[m/s\], jumps of the drive by that of its
/// gain; each in order of time.
type Kicks = [Vec<Kick>; 2];

/// The ring in what `fitted`, of the recordings of `side`, leaves that begins with impacts and
/// jumps of the drive, if one stands out.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn find(side: &Side, fitted: &Fitted) -> Result<Option<Ring>, SimError> {
    let rates = fitted.problem.data.iter();
    let rate = rates.map(|d| d.recording.sampling_rate()).reduce(f64::min);
    let Some(rate) = rate else {
        return Ok(None);
    };
    let all = promises(side, fitted, (LOWEST, 0.48 * rate))?;
    Ok(outstanding(all).map(|best| Ring {
        frequency: best.frequency,
        rate,
        shape: best.shape,
        significance: best.gain.sqrt(),
        gain: best.gain,
    }))
}

/// Fall of chi2 by a ring near `frequency` \[Hz\] that begins with impacts and jumps of the drive,
/// in what `fitted`, of the recordings of `side`, leaves.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn in_step(side: &Side, fitted: &Fitted, frequency: f64) -> Result<f64, SimError> {
    let all = promises(side, fitted, (frequency / NEAR, frequency * NEAR))?;
    Ok(all.iter().map(|p| p.gain).fold(0.0, f64::max))
}

/// The best of `all` if it stands out.
fn outstanding(mut all: Vec<Promise>) -> Option<Promise> {
    let best = *all.iter().max_by(|a, b| a.gain.total_cmp(&b.gain))?;
    all.retain(|p| p.zeta == best.zeta);
    let mut gains: Vec<f64> = all.iter().map(|p| p.gain).collect();
    let usual = crate::recording::quantile_in_place(&mut gains, MOST);
    log::debug!("{best:?} where {usual:.1} is usual");
    (best.gain > SURE && best.gain > OUTSTANDING * usual).then_some(best)
}

/// Rings between those frequencies \[Hz\] in what `fitted`, of the recordings of `side`, leaves.
fn promises(side: &Side, fitted: &Fitted, span: (f64, f64)) -> Result<Vec<Promise>, SimError> {
    let impacts = side.impacts().into_iter().enumerate();
    let kicks: Vec<Kicks> = impacts
        .map(|(k, own)| {
            let kick = |impact: &Impact| Kick {
                time: impact.time,
                size: impact.v_after - impact.v_before,
            };
            [own.iter().map(kick).collect(), jumps(fitted, k)]
        })
        .collect();
    Ok(rings(&ring::residuals(fitted)?, &kicks, span))
}

/// Jumps of the drive in recording number `index`, where the fit has them.
fn jumps(fitted: &Fitted, index: usize) -> Vec<Kick> {
    let (problem, point) = (&fitted.problem, &fitted.point);
    let data = &problem.data[index];
    let Some(piezo) = fitted.model.piezo else {
        return Vec::new();
    };
    let own = || point.segments.iter().filter(|s| s.recording == index);
    let skew = problem.nuisances_of(&point.x, index).skew;
    let gain = |piece: &Piece, t: f64| piezo.gain(piece.shape.voltage(t), piece.branch);
    let edges = data.track.edges.iter().filter(|edge| edge.piece > 0);
    let mut all: Vec<Kick> = edges
        .map(|edge| {
            let pieces = &data.track.pieces;
            let [before, after] = [&pieces[edge.piece - 1], &pieces[edge.piece]];
            Kick {
                time: own()
                    .find_map(|s| instant(s, edge.time))
                    .unwrap_or(edge.time - skew),
                size: gain(after, edge.time) - gain(before, edge.time),
            }
        })
        .collect();
    all.sort_by(|a, b| a.time.total_cmp(&b.time));
    all
}

/// When a jump of the drive that was guessed at `guess` \[s\] is in `segment`, by the reading's
/// clock \[s\]; `None` if it is not in it.
fn instant(segment: &Segment, guess: f64) -> Option<f64> {
    let joints: usize = segment.joints.iter().map(Joint::unknowns).sum();
    let mut k = segment.locals.len() - joints;
    for joint in &segment.joints {
        if matches!(joint.what, JointKind::Edge(_)) && joint.time == guess {
            return Some(joint.time + segment.value(&segment.locals, k));
        }
        k += joint.unknowns();
    }
    None
}

/// Rings between those frequencies \[Hz\] that begin with `kicks`.
fn rings(left: &[Left], kicks: &[Kicks], (low, high): (f64, f64)) -> Vec<Promise> {
    let tried = DAMPINGS.iter().flat_map(|&zeta| {
        let count = ((high / low).ln() / (STEP * zeta)).ceil().max(0.0) as usize;
        (0..count).map(move |k| (low * (STEP * zeta * k as f64).exp(), zeta))
    });
    let tried: Vec<(f64, f64)> = tried.collect();
    tried
        .into_par_iter()
        .filter_map(|(frequency, zeta)| promise(left, kicks, frequency, zeta))
        .collect()
}

/// What a ring of that frequency \[Hz\] and damping would bring; `None` if nothing tells it.
fn promise(left: &[Left], kicks: &[Kicks], frequency: f64, zeta: f64) -> Option<Promise> {
    let omega = TAU * frequency;
    let rate = Complex::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt());
    let mut normal = [Matrix2::zeros(); 2];
    let mut slopes = [Vector2::zeros(); 2];
    for own in left {
        let mut courses = [0, 1].map(|which| {
            let mut course = course(own, &kicks[own.recording][which], rate);
            if which == 0 {
                // A blow sets the speed off, a jump of the drive the rest that it rings about.
                course.iter_mut().for_each(|c| *c = Complex::new(c.im, 0.0));
            }
            course.into_iter().map(|c| c.re).collect::<Vec<f64>>()
        });
        courses.iter_mut().for_each(|c| own.colour.whiten(c));
        let [struck, driven] = &courses;
        for (channel, values) in own.channels.iter().enumerate() {
            if values.len() != struck.len() {
                continue;
            }
            for ((a, b), r) in struck.iter().zip(driven).zip(values) {
                let row = Vector2::new(*a, *b);
                normal[channel] += row * row.transpose();
                slopes[channel] += row * *r;
            }
        }
    }
    // Both readings share in it alike, whatever has set it off.
    let whitened = [0, 1].map(|i| {
        let eigen = SymmetricEigen::new(normal[i]);
        let least = 1e-9 * eigen.eigenvalues.amax();
        let root = eigen
            .eigenvalues
            .map(|v| if v > least { v.powf(-0.5) } else { 0.0 });
        (eigen.eigenvectors * Matrix2::from_diagonal(&root)).tr_mul(&slopes[i])
    });
    let shared = Matrix2::from_fn(|i, j| whitened[i].dot(&whitened[j]));
    let eigen = SymmetricEigen::new(shared);
    let top = eigen.eigenvalues.imax();
    let gain = eigen.eigenvalues[top];
    let v = eigen.eigenvectors.column(top);
    gain.is_finite().then_some(Promise {
        frequency,
        zeta,
        gain,
        shape: (v[0], v[1]),
    })
}

/// A ring that begins with `kicks` and turns at `rate` \[1/s\], at the samples of `own`.
fn course(own: &Left, kicks: &[Kick], rate: Complex<f64>) -> Vec<Complex<f64>> {
    let since = |at: f64, kick: &Kick| (rate * (at - kick.time)).exp() * kick.size;
    let first = kicks.partition_point(|k| (own.start - k.time) * -rate.re > OVER);
    let mut next = kicks.partition_point(|k| k.time < own.start).max(first);
    let mut state: Complex<f64> = kicks[first..next].iter().map(|k| since(own.start, k)).sum();
    let turn = (rate * own.interval).exp();
    let count = own.channels[0].len();
    let mut out = Vec::with_capacity(count);
    for i in 0..count {
        out.push(state);
        state *= turn;
        let then = own.start + (i + 1) as f64 * own.interval;
        while let Some(kick) = kicks.get(next).filter(|k| k.time < then) {
            state += since(then, kick);
            next += 1;
        }
    }
    out
}
