//! Residuals of a segment: (measured - simulated) in units of the standard deviation, one for each
//! of [`rows`](super::residual_rows::rows).

use super::residual_rows::{Encounter, Nuisances, SegmentContext, SegmentRun, Sigmas};
use super::simulate_segment::simulate_segment;
use crate::fit::segment::{JointKind, Segment};
use crate::fit::thresholds::{SHORT_STAY_FORCE_FACTOR, SHORT_STAY_SAMPLES};
use crate::sim::{SimError, StretchSimulator, Stretcher};

/// Residuals of one event against the laws of the ground, in standard deviations.
fn law(
    encounter: &Encounter,
    sim: &StretchSimulator,
    s: &Sigmas,
    interval: f64,
    out: &mut Vec<f64>,
) {
    match *encounter {
        Encounter::Meeting {
            miss, speed, after, ..
        } => {
            out.push(miss / s.height);
            if let Some(after) = after {
                out.push((after - sim.restitution(speed) * speed) / s.velocity);
            }
        }
        Encounter::PullOff(Some(pull)) if pull.informative => {
            // The force at the end of a stay of a few samples rests on instants that few
            // samples show: it gets a lower weight.
            let stay = pull.contact / (SHORT_STAY_SAMPLES * interval);
            let sigma = s.force * (1.0 + SHORT_STAY_FORCE_FACTOR * (-stay * stay).exp());
            out.push((pull.force - sim.adhesion(pull.contact)) / sigma);
        }
        Encounter::PullOff(_) => out.push(0.0),
    }
}

/// Simulates `segment` with the unknowns `locals`, and writes its residuals to `out`.
///
/// # Errors
/// [`SimError`] where no simulation is possible.
pub fn residuals(
    segment: &Segment,
    context: &SegmentContext<'_>,
    stretcher: &mut Stretcher<'_>,
    nuisances: &Nuisances,
    locals: &[f64],
    out: &mut Vec<f64>,
) -> Result<(), SimError> {
    out.clear();
    let SegmentRun {
        xp,
        xc,
        encounters,
        priors,
        rest,
    } = simulate_segment(segment, context, stretcher, nuisances, locals)?;
    let sim = stretcher.simulator();
    let (r, s) = (context.recording, context.sigmas);
    let samples = segment.samples.clone();
    for (i, x) in samples.clone().zip(&xp) {
        if r.proof_mass[i].is_finite() {
            let shown = nuisances.scale_p * x + nuisances.offset_p;
            out.push((r.proof_mass[i] - shown) / s.xp);
        }
    }
    s.colour.whiten(out);
    let first = out.len();
    if let Some(measured) = &r.cantilever {
        for (i, x) in samples.zip(&xc) {
            if measured[i].is_finite() {
                let shown = nuisances.scale_c * x + nuisances.offset_c;
                out.push((measured[i] - shown) / s.xc);
            }
        }
    }
    s.colour.whiten(&mut out[first..]);
    let mut encounters = encounters.iter();
    for (joint, prior) in segment.joints.iter().zip(priors) {
        if let JointKind::Event(_) = joint.what
            && let Some(encounter) = encounters.next()
        {
            law(encounter, sim, s, r.interval(), out);
        }
        out.push(prior);
    }
    if let Some(rest) = rest {
        let held = sim.held_structure();
        let n = held.omega2.len();
        // Without a reading, the cantilever is known only where it has come to rest.
        let loose = r.cantilever.is_some() || !segment.settled;
        let sigma = if loose { 1e4 * s.rest } else { s.rest };
        for j in 0..n {
            let shape = held.cantilever[j].abs().max(1e-300);
            out.push((state_at(segment, locals, j) - rest.q[j]) * shape / sigma);
        }
        for j in 0..n {
            let shape = held.cantilever[j].abs().max(1e-300) / held.omega2[j].sqrt().max(1e-300);
            out.push((state_at(segment, locals, n + j) - rest.v[j]) * shape / sigma);
        }
    }
    Ok(())
}

fn state_at(segment: &Segment, locals: &[f64], i: usize) -> f64 {
    segment.value(locals, i)
}
