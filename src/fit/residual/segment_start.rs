//! The state in which a segment begins: modes, the effects' states, and the sensor's memory.

use super::residual_rows::{Nuisances, SegmentContext};
use super::segment_joints::free_modes;
use crate::fit::segment::Segment;
use crate::fit::thresholds::MAX_SENSOR_FADE;
use crate::model::drive::Segment as Piece;
use crate::sim::{Points, SimError, StretchSimulator, StretchState, Stretcher};

/// Share of a lag over which accelerations are estimated by differences.
const ACCELERATION_LAG_SHARE: f64 = 0.1;

/// Whether the readings lag by so much that a segment begins with the sensor at its first reading.
pub fn begins_from_reading(segment: &Segment, sim: &StretchSimulator) -> bool {
    sim.reading_states()
        .is_some_and(|at| sim.state_rates()[at] * segment.interval < MAX_SENSOR_FADE)
}

fn points_of(sim: &StretchSimulator, held: Option<f64>, state: &StretchState) -> Points {
    match held {
        Some(level) => sim.held_points(level, state),
        None => sim.flight_points(state),
    }
}

/// Output of a first-order lag of `tau` \[s\] for a motion that has always been as at `start`.
/// For a harmonic motion of frequency w about a middle it is `x - (tau v - tau^2 a) / (1 +
/// w^2 tau^2)` mode by mode, with the accelerations of the next moment.
fn lagged_points(
    stretcher: &mut Stretcher<'_>,
    pieces: &[Piece],
    (held, start): (Option<f64>, f64),
    state: &StretchState,
    tau: f64,
) -> Result<Points, SimError> {
    let sim = stretcher.simulator();
    let moment = ACCELERATION_LAG_SHARE * tau;
    let mut later = state.clone();
    stretcher.propagate(
        pieces,
        held,
        start,
        start + moment,
        &mut later,
        &[],
        |_, _, _| {},
    )?;
    let omega2: Vec<f64> = match held {
        Some(_) => sim.held_omega2().collect(),
        None => sim.flight_omega2().collect(),
    };
    let mut behind = state.clone();
    for (k, w2) in omega2.into_iter().enumerate() {
        let a = (later.v[k] - state.v[k]) / moment;
        behind.q[k] -= (tau * state.v[k] - tau * tau * a) / (1.0 + w2 * tau * tau);
    }
    Ok(points_of(sim, held, &behind))
}

/// State in which a segment begins: modes from its unknowns, the effects' states from the
/// context, the sensor's memory from the reading where it lasts longer than a sample.
///
/// # Errors
/// [`SimError`] if the motion just after the start cannot be simulated.
pub(super) fn initial_state(
    segment: &Segment,
    context: &SegmentContext<'_>,
    stretcher: &mut Stretcher<'_>,
    nuisances: &Nuisances,
    locals: &[f64],
    (pieces, start, level): (&[Piece], f64, f64),
) -> Result<StretchState, SimError> {
    let sim = stretcher.simulator();
    let r = context.recording;
    let value = |i: usize| segment.value(locals, i);
    let n = free_modes(segment, sim);
    let mut state = StretchState {
        q: (0..n).map(value).collect(),
        v: (n..2 * n).map(value).collect(),
        z: if context.states.is_empty() {
            sim.rest_state(pieces, start, None).z
        } else {
            context.states.to_vec()
        },
    };
    if let Some(at) = sim.reading_states() {
        // A lag longer than a sample goes on from what was read. A shorter one is where the
        // motion has brought it, and must not take over the noise.
        let lasting = begins_from_reading(segment, sim);
        let on = segment.starts_held.then_some(level);
        let points = if lasting {
            points_of(sim, on, &state)
        } else {
            let tau = 1.0 / sim.state_rates()[at];
            lagged_points(stretcher, pieces, (on, start), &state, tau)?
        };
        let n = nuisances;
        let i = segment.samples.start;
        let begun = |x: f64, shown: Option<f64>, offset: f64, scale: f64| match shown {
            Some(shown) if lasting && shown.is_finite() => (shown - offset) / scale,
            _ => x,
        };
        let xc = r.cantilever.as_ref().map(|xc| xc[i]);
        state.z[at] = begun(points.xp, Some(r.proof_mass[i]), n.offset_p, n.scale_p);
        state.z[at + 1] = begun(points.xc, xc, n.offset_c, n.scale_c);
    }
    Ok(state)
}
