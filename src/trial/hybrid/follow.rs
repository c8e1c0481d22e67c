//! Integration of one stretch with its phase kept, without looking for events.

use super::integrator::{State, Stepper};
use super::{LONGEST_STEP, RunError, SHORTEST_STEP, Stretch};
use crate::trial::device::Device;
use crate::trial::voltage::Piece;

/// The motion from `stretch`'s state with the phase kept, read at `times` within it.
/// Returns the proof mass's and the cantilever's readings.
///
/// # Errors
/// [`RunError`] if the motion diverges.
pub fn follow(
    device: &Device,
    pieces: &[Piece],
    stretch: &Stretch,
    times: &[f64],
    tolerance: f64,
) -> Result<[Vec<f64>; 2], RunError> {
    let tolerances = device.tolerances(tolerance);
    let mut out = [
        Vec::with_capacity(times.len()),
        Vec::with_capacity(times.len()),
    ];
    let (mut t, mut y) = (stretch.start, stretch.state);
    let mut h = 1e-6;
    let mut stepper = Stepper::new(device.dimension());
    let first = pieces.partition_point(|piece| piece.end <= t);
    for piece in &pieces[first.min(pieces.len())..] {
        let end = piece.end.min(stretch.end);
        let mut rhs =
            |t: f64, y: &State, out: &mut State| device.flow(t, y, piece, stretch.phase, out);
        stepper.restart(t, &y, &mut rhs);
        while end - t > 1e-15 {
            let last = h >= end - t;
            let step = if last { end - t } else { h };
            let error = stepper.attempt(t, &y, step, &tolerances, &mut rhs);
            if !(error <= 1.0) {
                h = 0.3 * step;
                if h < SHORTEST_STEP {
                    return Err(RunError::Stalled { time: t });
                }
                continue;
            }
            stepper.prepare(&y, step);
            let to = if last { end } else { t + step };
            while let Some(time) = times.get(out[0].len()).filter(|time| **time <= to) {
                let (xp, xc) = device.readings(&stepper.at(((time - t) / step).clamp(0.0, 1.0)));
                out[0].push(xp);
                out[1].push(xc);
            }
            y = stepper.end;
            t = to;
            stepper.go_on();
            h = (step * (0.9 * error.max(1e-10).powf(-0.2)).clamp(0.3, 4.0))
                .clamp(1e-8, LONGEST_STEP);
        }
        if piece.end >= stretch.end {
            break;
        }
    }
    let (xp, xc) = device.readings(&y);
    out[0].resize(times.len(), xp);
    out[1].resize(times.len(), xc);
    Ok(out)
}
