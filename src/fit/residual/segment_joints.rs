//! A segment's joints: the drive's edges and the events at the instants that its unknowns give them.

use crate::fit::segment::event_sequence::GroundEvent;
use crate::fit::segment::{Joint, JointKind, Segment};
use crate::model::drive::Segment as Piece;
use crate::sim::{SimError, StretchSimulator};

/// A segment's joints at the instants that its unknowns give them.
pub(super) struct Joints {
    /// The drive with its edges moved.
    pub(super) pieces: Vec<Piece>,
    /// Instant \[s\], velocity after \[m/s\] and kind of each event.
    pub(super) instants: Vec<(f64, f64, GroundEvent)>,
    /// Distance of each joint from its first guess, in its standard deviations.
    pub(super) priors: Vec<f64>,
}

/// Number of modes that are free where the segment begins: a held mass takes one away.
pub(super) fn free_modes(segment: &Segment, sim: &StretchSimulator) -> usize {
    if segment.starts_held {
        sim.modes() - 1
    } else {
        sim.modes()
    }
}

/// Reads the joints' instants from the unknowns and keeps each within its reach.
///
/// # Errors
/// [`SimError::Options`] if the simulator has another number of modes than the segment: that is
/// another problem, not a step in this one.
pub(super) fn place_joints(
    segment: &Segment,
    sim: &StretchSimulator,
    locals: &[f64],
    skew: f64,
) -> Result<Joints, SimError> {
    let value = |i: usize| segment.value(locals, i);
    let mut pieces = segment.pieces.clone();
    let modes = sim.modes();
    let n = free_modes(segment, sim);
    let own: usize = segment.joints.iter().map(Joint::unknowns).sum();
    if segment.units.len() != 2 * n + own {
        return Err(SimError::Options {
            what: "modes",
            reason: format!(
                "the device has {modes} modes, but the segment was prepared for another number"
            ),
        });
    }
    let mut k = 2 * n;
    let mut instants = Vec::with_capacity(segment.joints.len());
    let mut priors = Vec::with_capacity(segment.joints.len());
    for joint in &segment.joints {
        // Both kinds are shifted by the reading's clock. If edges went by the drive's clock, a
        // skew could hardly be distinguished from a shift of all edges of a recording.
        let away = match joint.what {
            JointKind::Event(_) => value(k),
            JointKind::Edge(_) => value(k) + skew,
        };
        priors.push(away / joint.sigma);
        let away = away.clamp(-joint.reach, joint.reach);
        k += 1;
        let v_after = match joint.what {
            JointKind::Event(GroundEvent::Bounce { .. }) => {
                k += 1;
                value(k - 1)
            }
            _ => 0.0,
        };
        match joint.what {
            JointKind::Edge(piece) => {
                let low = pieces[piece - 1].start;
                let high = pieces[piece].end;
                let at = (joint.time + away).clamp(low + 1e-12, (high - 1e-12).max(low + 1e-12));
                pieces[piece - 1].end = at;
                pieces[piece].start = at;
            }
            JointKind::Event(kind) => instants.push((joint.time + away + skew, v_after, kind)),
        }
    }
    Ok(Joints {
        pieces,
        instants,
        priors,
    })
}
