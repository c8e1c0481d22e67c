//! How visible a concealed effect is: a Cramer-Rao bound on its own recordings.
//!
//! Each stretch between events is followed once more by the device without the effect,
//! from the true state at its start. What differs, in units of the noise, is the
//! effect's trace; what the baseline's parameters, the instruments and the state at the start
//! of every stretch could absorb is projected out with the generator's own
//! sensitivities. Restitution, contact level and pull-off force at the events are rows
//! of their own. The readings' noise has the colour that it is made with; events are
//! judged by its total rms. An effect is called smallest visible where what is left has
//! five standard deviations in all.

pub(crate) mod events;
mod normal_equations;
pub(crate) mod stretch;
mod tunings;

pub use self::normal_equations::CaseRun;

use nalgebra::{DMatrix, DVector};

use self::events::add_events;
use self::normal_equations::NormalEquations;
use self::stretch::add_stretch;
use self::tunings::tunings;
use super::hybrid::{RunError, Stretch};
use super::instrument::Instruments;

/// Standard deviations at which an effect counts as just visible.
pub const JUST_VISIBLE: f64 = 5.0;
/// Columns of each recording: zeros of both readings, errors of both scales.
const OF_A_RECORDING: usize = 4;
/// Time that is followed \[s\]; of longer recordings only some of the stretches are used.
const FOLLOWED_TIME: f64 = 0.2;

/// Standard deviations by which the effect stands out of what re-tuning can absorb.
///
/// # Errors
/// [`RunError`] if the device without the effect cannot be followed.
pub fn deviations(cases: &[CaseRun<'_>], instruments: &Instruments) -> Result<f64, RunError> {
    let Some(n) = cases.first().map(|m| m.plain.structure.n) else {
        return Ok(0.0);
    };
    let tunings = tunings(n);
    // After the tunings: dp, alpha, Ca, Ca0, skew, two scales; of each recording two zeros and the
    // errors of both scales.
    let base = tunings.len();
    let size = base + 7 + OF_A_RECORDING * cases.len();
    let mut normal = NormalEquations {
        matrix: DMatrix::zeros(size, size),
        right: DVector::zeros(size),
        energy: 0.0,
    };
    // What is known of the instruments beforehand, in the columns' units.
    for (column, sigma) in [(base + 4, 5e-6), (base + 5, 0.01), (base + 6, 0.01)] {
        normal.matrix[(column, column)] += 1.0 / (sigma * sigma);
    }
    let all: f64 = cases
        .iter()
        .flat_map(|m| &m.run.stretches)
        .map(length)
        .sum();
    let every = (all / FOLLOWED_TIME).ceil().max(1.0) as usize;
    for (number, recording) in cases.iter().enumerate() {
        let zeros = base + 7 + OF_A_RECORDING * number;
        let spread = instruments.imperfections.scale_spread;
        if spread > 0.0 {
            for column in [zeros + 2, zeros + 3] {
                normal.matrix[(column, column)] += 1.0 / (spread * spread);
            }
        }
        for stretch in recording
            .run
            .stretches
            .iter()
            .skip(number % every)
            .step_by(every)
        {
            add_stretch(
                &mut normal,
                recording,
                stretch,
                &tunings,
                zeros,
                every as f64,
                instruments,
            )?;
        }
        add_events(&mut normal, recording, base, zeros, instruments);
    }
    // Columns of unit length, so that one small ridge serves all.
    let scale: Vec<f64> = (0..size)
        .map(|i| 1.0 / normal.matrix[(i, i)].max(1e-300).sqrt())
        .collect();
    let matrix = DMatrix::from_fn(size, size, |i, j| {
        normal.matrix[(i, j)] * scale[i] * scale[j] + if i == j { 1e-9 } else { 0.0 }
    });
    let right = DVector::from_fn(size, |i, _| normal.right[i] * scale[i]);
    let explained = matrix
        .cholesky()
        .map_or(0.0, |factor| right.dot(&factor.solve(&right)));
    Ok((normal.energy - explained).max(0.0).sqrt())
}

fn length(stretch: &Stretch) -> f64 {
    stretch.end - stretch.start
}
