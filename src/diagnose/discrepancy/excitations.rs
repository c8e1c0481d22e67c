//! What excites modes: impacts, and jumps of the drive; and the ring that follows.

use nalgebra::Complex;

use super::residual_spectrum::SegmentResiduals;
use crate::diagnose::data::side::Split;
use crate::diagnose::shooting::fitted::Fitted;
use crate::fit::segment::{Joint, JointKind, Segment};
use crate::model::drive::Segment as Piece;
use crate::recording::events::Impact;

/// A ring is neglected after this many of its time constants.
const DECAYED_TIME_CONSTANTS: f64 = 8.0;

/// An excitation of a mode and its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Kick {
    /// Time by the reading's clock \[s\].
    pub time: f64,
    /// Change of velocity \[m/s\], or of the drive's gain.
    pub size: f64,
}

/// Excitations in one recording, in order of time: impacts by their change of velocity \[m/s\],
/// jumps of the drive by that of its gain.
pub(super) type Kicks = [Vec<Kick>; 2];

/// Excitations in each recording of `side`, to which `fitted` is a fit.
pub(super) fn kicks_of(side: &Split, fitted: &Fitted) -> Vec<Kicks> {
    let impacts = side.impacts().into_iter().enumerate();
    let kicks = impacts.map(|(k, own)| {
        let kick = |impact: &Impact| Kick {
            time: impact.time,
            size: impact.v_after - impact.v_before,
        };
        [own.iter().map(kick).collect(), drive_jumps(fitted, k)]
    });
    kicks.collect()
}

/// Jumps of the drive in recording number `index`, at their fitted times.
fn drive_jumps(fitted: &Fitted, index: usize) -> Vec<Kick> {
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
                    .find_map(|s| fitted_edge_time(s, edge.time))
                    .unwrap_or(edge.time - skew),
                size: gain(after, edge.time) - gain(before, edge.time),
            }
        })
        .collect();
    all.sort_by(|a, b| a.time.total_cmp(&b.time));
    all
}

/// Fitted time of the jump of the drive guessed at `guess` \[s\] in `segment`, by the reading's
/// clock \[s\]; `None` if it lies elsewhere.
fn fitted_edge_time(segment: &Segment, guess: f64) -> Option<f64> {
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

/// A ring excited by `kicks` with the complex rate `rate` \[1/s\], at the samples of `own`.
pub(super) fn ring_course<'a>(
    own: &'a SegmentResiduals,
    kicks: &'a [Kick],
    rate: Complex<f64>,
) -> impl Iterator<Item = Complex<f64>> + 'a {
    let since = move |at: f64, kick: &Kick| (rate * (at - kick.time)).exp() * kick.size;
    let first = kicks.partition_point(|k| (own.start - k.time) * -rate.re > DECAYED_TIME_CONSTANTS);
    let mut next = kicks.partition_point(|k| k.time < own.start).max(first);
    let mut state: Complex<f64> = kicks[first..next].iter().map(|k| since(own.start, k)).sum();
    let turn = (rate * own.interval).exp();
    (0..own.channels[0].len()).map(move |i| {
        let now = state;
        state *= turn;
        let then = own.start + (i + 1) as f64 * own.interval;
        while let Some(kick) = kicks.get(next).filter(|k| k.time < then) {
            state += since(then, kick);
            next += 1;
        }
        now
    })
}
