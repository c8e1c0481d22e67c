//! The hysteretic piezo drive: two polynomial branches, eqs (6)-(9).

use serde::{Deserialize, Serialize};

/// Largest `gc` of the paper's transducer, in its unit.
pub(in crate::model) const LARGEST_GAIN: f64 = 5.0;

/// Voltage up to which the branches `gc(V)` were measured \[V\]: eq (9) of the paper.
pub const MEASURED_VOLTAGE: f64 = 8.0;

/// Frequency up to which the drive was measured \[Hz\]: the fastest of the paper's experiments
/// (Table A.1).
pub const MEASURED_FREQUENCY: f64 = 100.0;

/// Which of the two branches of the hysteresis loop is in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Branch {
    /// The voltage rises, or has risen last.
    Rising,
    /// The voltage falls, or has fallen last.
    Falling,
    /// No voltage since poling: the zero position, no force.
    Poled,
}

/// Polynomials `gc(V)`, coefficients in rising powers of V (constant first).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Piezo {
    /// For V' > 0.
    pub rising: [f64; 4],
    /// For V' < 0.
    pub falling: [f64; 4],
}

impl Default for Piezo {
    /// Eq (9) with the branches chosen by the sign of V'.
    fn default() -> Self {
        Self {
            rising: [1.4796, -0.7057, -0.0255, 0.0016],
            falling: [-0.6350, -0.6062, 0.0076, 0.0],
        }
    }
}

impl Piezo {
    /// A drive without hysteresis: one polynomial for both directions of the voltage.
    #[must_use]
    pub fn without_hysteresis(gain: [f64; 4]) -> Self {
        Self {
            rising: gain,
            falling: gain,
        }
    }

    /// Whether both branches are the same, so that the force follows the voltage at once.
    #[must_use]
    pub fn has_hysteresis(&self) -> bool {
        self.rising != self.falling
    }

    /// `gc(V)` on a branch; dimensionless.
    #[inline]
    pub fn gain(&self, voltage: f64, branch: Branch) -> f64 {
        let c = match branch {
            Branch::Rising => &self.rising,
            Branch::Falling => &self.falling,
            Branch::Poled => return 0.0,
        };
        c[0] + voltage * (c[1] + voltage * (c[2] + voltage * c[3]))
    }
}

#[cfg(test)]
mod tests {
    use super::super::piezo::*;

    #[test]
    fn branches_meet_at_eight_volts() {
        let piezo = Piezo::default();
        for (voltage, value) in [(MEASURED_VOLTAGE, -4.98), (-MEASURED_VOLTAGE, 4.69)] {
            for branch in [Branch::Rising, Branch::Falling] {
                let gain = piezo.gain(voltage, branch);
                assert!((gain - value).abs() < 0.02, "{voltage} V: {gain}");
            }
        }
    }
}
