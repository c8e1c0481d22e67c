//! Initial position and velocity from the first samples of a recording.

use nalgebra::{DMatrix, DVector};

use crate::app::setup::current_setup::Setup;
use crate::app::setup::overlay::OverlayId;
use crate::model::parameter::ParameterId;
use crate::recording::Recording;

/// Sets `x0`, `v0` and `offset_p` so that the simulation starts like the recording, and
/// shifts the recording to start at t = 0. Locked parameters keep their values. Does nothing
/// if the recording has fewer than three valid samples.
pub fn start_from_recording(setup: &mut Setup, id: OverlayId) {
    let frequency = setup.preset.model.parameters[ParameterId::F1];
    let Some(overlay) = setup.overlays.iter_mut().find(|o| o.id == id) else {
        return;
    };
    let Some(mut start) = first_motion(&overlay.recording, frequency) else {
        return;
    };
    let alignment = &mut overlay.alignment;
    alignment.time_shift = -overlay.recording.span().0;
    start.position *= alignment.xp_scale;
    start.velocity *= alignment.xp_scale;
    start.mean = alignment.xp_scale * start.mean + alignment.xp_offset;
    if frequency == 0.0 {
        // Without a spring there is no rest position, so the mean is displacement too.
        start.position += start.mean;
        start.mean = 0.0;
    }
    for (id, value) in [
        (ParameterId::X0, start.position),
        (ParameterId::V0, start.velocity),
        (ParameterId::OffsetP, start.mean),
    ] {
        if !setup.locked.contains(id.spec().id) {
            setup.preset.model.parameters.set(id, value);
        }
    }
}

/// Motion at the start of a recording: position relative to the mean \[m\], velocity [m/s] and
/// mean \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
struct FirstMotion {
    position: f64,
    velocity: f64,
    mean: f64,
}

/// Fits the first half period with a sine of `frequency` \[Hz\], or the first samples with
/// a parabola if it is 0.
fn first_motion(recording: &Recording, frequency: f64) -> Option<FirstMotion> {
    let samples: Vec<(f64, f64)> = recording
        .time
        .iter()
        .zip(&recording.proof_mass)
        .filter(|(_, x)| x.is_finite())
        .map(|(t, x)| (t - recording.time[0], *x))
        .collect();
    if samples.len() < 3 {
        return None;
    }
    let mean = samples.iter().map(|(_, x)| x).sum::<f64>() / samples.len() as f64;
    let count = if frequency > 0.0 {
        samples.partition_point(|(t, _)| *t <= 0.5 / frequency)
    } else {
        samples.len() / 3
    };
    let count = count.clamp(6, 20_000).min(samples.len());
    let rows = &samples[..count];
    let omega = std::f64::consts::TAU * frequency;
    let columns = if frequency > 0.0 { 2 } else { 3 };
    // Times are scaled by the fitted span, so that the columns have similar norms.
    let unit = rows.last().map_or(1.0, |(t, _)| t.max(f64::MIN_POSITIVE));
    let matrix = DMatrix::from_fn(count, columns, |i, k| {
        let t = rows[i].0;
        match (frequency > 0.0, k) {
            (true, 0) => (omega * t).cos(),
            (true, _) => (omega * t).sin(),
            (false, k) => (t / unit).powi(k as i32),
        }
    });
    let values = DVector::from_fn(count, |i, _| rows[i].1 - mean);
    let solution = matrix.svd(true, true).solve(&values, 1e-12).ok()?;
    let velocity = solution[1] * if frequency > 0.0 { omega } else { 1.0 / unit };
    Some(FirstMotion {
        position: solution[0],
        velocity,
        mean,
    })
}

#[cfg(test)]
mod tests {
    use super::super::start::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_start_of_a_sine_is_found() {
        let time: Vec<f64> = (0..2000).map(|i| 3.0 + 0.01 * f64::from(i)).collect();
        let omega = std::f64::consts::TAU;
        let x = |t: f64| 0.02 + 0.1 * (omega * t).cos() + 0.05 * (omega * t).sin();
        let values = time.iter().map(|t| x(t - 3.0)).collect();
        let recording = Recording::new("r", time, None, values, None).unwrap();
        let start = first_motion(&recording, 1.0).unwrap();
        assert_relative_eq!(start.mean, 0.02, max_relative = 1e-2);
        assert_relative_eq!(start.position, 0.1, max_relative = 1e-2);
        assert_relative_eq!(start.velocity, 0.05 * omega, max_relative = 1e-2);
    }

    #[test]
    fn the_start_of_a_free_fall_is_found() {
        let time: Vec<f64> = (0..30).map(|i| f64::from(i) / 15.0).collect();
        let values = time.iter().map(|t| 20.0 - 1.5 * t - 4.9 * t * t).collect();
        let recording = Recording::new("r", time, None, values, None).unwrap();
        let start = first_motion(&recording, 0.0).unwrap();
        assert_relative_eq!(start.position + start.mean, 20.0, max_relative = 1e-9);
        assert_relative_eq!(start.velocity, -1.5, max_relative = 1e-9);
    }
}
