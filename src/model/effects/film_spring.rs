//! `film_spring`: the gas of the film is compressed before it flows away.

use super::{Action, EffectSpec, Kinematics, Need};
use crate::model::parameter::{ParameterSpec, Rank, Scale};

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "film_spring",
    name: "compressible film",
    sentence: "The gas under the mass is compressed before it flows away, so that the film's force comes late.",
    law: "tau F' + F = -Cs xp' / (xp + gp)^3",
    source: "squeeze number: Blech, J. Lubrication Technol. 105, 615 (1983)",
    needs: Need::Ground,
    parameters: &[ParameterSpec {
        id: "tau",
        symbol: "τ",
        name: "time of the film",
        unit: "s",
        default: 50e-6,
        range: (0.0, 1e-3),
        limits: (0.0, 1e3),
        scale: Scale::Linear,
        rank: Rank::Advanced,
        meaning: "time in which trapped gas flows away; 0 is the film of eq (10)",
        equation: "tau F' + F = -Cs xp' / (xp + gp)^3",
    }],
    build: |values, _| {
        Box::new(FilmSpring {
            rates: if values[0] > 0.0 {
                vec![1.0 / values[0]]
            } else {
                Vec::new()
            },
        })
    },
};

/// State: the film's force [N]. While the mass is held the gas goes on flowing away, and
/// its force on the mass counts in the balance.
#[derive(Debug)]
struct FilmSpring {
    rates: Vec<f64>,
}

impl Action for FilmSpring {
    fn does_nothing(&self) -> bool {
        self.rates.is_empty()
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn state_inputs(&self, at: &Kinematics, _z: &[f64], inputs: &mut [f64]) {
        if let ([rate], [input]) = (self.rates.as_slice(), inputs) {
            *input = rate * at.film;
        }
    }

    fn film_force(&self, film: f64, z: &[f64]) -> f64 {
        z.first().copied().unwrap_or(film)
    }
}
