//! `film_spring`: the gas of the film is compressed before it flows away.
//!
//! Equation: `tau ((gp - dp) / (xp + gp))^p F' + F = -Cs xp' / (xp + gp)^3`.
//! Source: squeeze number: Blech, J. Lubrication Technol. 105, 615 (1983).

use super::{
    Action, EffectSpec, EvidenceFigure, Facts, FormError, FoundBy, Kinematics, Motion, Need,
    Quantity, Search, Start, followed_time_constant,
};
use crate::model::parameter::{ParameterId, ParameterSpec, Rank, Scale};

/// Bounds of the largest ratio of the film's time at contact to that far off. Between them the
/// ratio follows from [`MAX_RATE`]. Far off the film is so weak that its delay does not matter.
const MAX_TIME_RATIO_BOUNDS: (f64, f64) = (9.0, 50.0);
/// Fastest rate that a simulation follows in few steps [1/s].
const MAX_RATE: f64 = 2e5;
/// Thinnest film, as a share of that at contact.
const MIN_THICKNESS_SHARE: f64 = 0.1;

/// The effect.
pub static EFFECT: EffectSpec = EffectSpec {
    id: "film_spring",
    name: "compressible film",
    sentence: "The gas under the mass is compressed before it flows away, so that the film's force comes late.",
    law: "tau ((gp - dp) / (xp + gp))^p F' + F = -Cs xp' / (xp + gp)^3",
    source: "squeeze number: Blech, J. Lubrication Technol. 105, 615 (1983)",
    needs: Need::Ground,
    parameters: &[
        ParameterSpec {
            id: "tau",
            symbol: "τ",
            name: "time of the film",
            unit: "s",
            default: 50e-6,
            range: (0.0, 1e-3),
            limits: (0.0, 1e3),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "time in which trapped gas flows away, at contact; 0 is the film of eq (10)",
            equation: "tau F' + F = -Cs xp' / (xp + gp)^3",
        },
        ParameterSpec {
            id: "p",
            symbol: "p",
            name: "growth as the gap closes",
            unit: "",
            default: 0.0,
            range: (0.0, 3.0),
            limits: (0.0, 10.0),
            scale: Scale::Linear,
            rank: Rank::Advanced,
            meaning: "0: the same time at any height; 2: as the inverse square of the gap, like the squeeze number",
            equation: "tau(xp) = tau ((gp - dp) / (xp + gp))^p",
        },
    ],
    build: |values, around| {
        let (tau, growth) = (values[0], values[1]);
        let max_time_ratio = if growth > 0.0 {
            (MAX_RATE * tau).clamp(MAX_TIME_RATIO_BOUNDS.0, MAX_TIME_RATIO_BOUNDS.1)
        } else {
            1.0
        };
        let parameters = around.parameters;
        Box::new(FilmSpring {
            rates: if tau > 0.0 {
                vec![max_time_ratio / followed_time_constant(tau)]
            } else {
                Vec::new()
            },
            growth,
            max_time_ratio,
            far: max_time_ratio.powf(1.0 / growth),
            gap: parameters[ParameterId::Gp],
            thinnest: parameters[ParameterId::Gp] - parameters[ParameterId::Dp],
        })
    },
    facts: Facts {
        strengths: &["tau"],
        ..Facts::DEFAULT
    },
    search: Search {
        found_by: FoundBy::Starts(starts),
        form_errors: |values, tolerance| vec![FormError::Everywhere(tolerance.scaled(values, 0))],
        ..Search::DEFAULT
    },
    figure: EvidenceFigure::Force(Quantity::Displacement),
};

/// A time that is the same at any height, and one that grows as the gap closes.
fn starts(motion: &Motion) -> Vec<Start> {
    if !motion.has_ground {
        return Vec::new();
    }
    let constant = [1.6e-6, 8e-6, 4e-5, 2e-4].map(|tau| [tau, 0.0]);
    let growing = [1.6e-6, 8e-6, 4e-5, 2e-4, 1e-3].map(|tau| [tau, 2.0]);
    let all = constant.into_iter().chain(growing);
    all.map(|values| Start::positive(&values, 0, &[0]))
        .collect()
}

/// State: the film's force \[N\]. While the mass is held the gas goes on flowing away, and
/// its force on the mass counts in the balance.
#[derive(Debug)]
struct FilmSpring {
    /// The fastest rate [1/s]; none without the effect.
    rates: Vec<f64>,
    growth: f64,
    /// Largest ratio of the rate far off to that at contact.
    max_time_ratio: f64,
    /// Thickness over that at contact from which the rate is the fastest.
    far: f64,
    /// Thickness of the film where the mass is at zero, and at contact \[m\].
    gap: f64,
    thinnest: f64,
}

impl Action for FilmSpring {
    fn does_nothing(&self) -> bool {
        self.rates.is_empty()
    }

    fn state_rates(&self) -> &[f64] {
        &self.rates
    }

    fn lasting(&self) -> f64 {
        self.max_time_ratio
    }

    fn states_are_forces(&self) -> bool {
        true
    }

    fn pace(&self, at: &Kinematics) -> f64 {
        if self.growth == 0.0 {
            return 1.0;
        }
        let wider = (at.xp + self.gap).max(MIN_THICKNESS_SHARE * self.thinnest) / self.thinnest;
        if wider >= self.far {
            return 1.0;
        }
        // The usual case: a square is faster than a general power.
        let grown = if self.growth == 2.0 {
            wider * wider
        } else {
            wider.powf(self.growth)
        };
        (grown / self.max_time_ratio).min(1.0)
    }

    fn state_inputs(&self, at: &Kinematics, _z: &[f64], inputs: &mut [f64]) {
        for (input, rate) in inputs.iter_mut().zip(&self.rates) {
            *input = rate * at.film;
        }
    }

    fn film_force(&self, film: f64, z: &[f64]) -> f64 {
        z.first().copied().unwrap_or(film)
    }
}
