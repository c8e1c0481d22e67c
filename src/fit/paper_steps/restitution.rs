//! Step 2, restitution (fig. 5): the ratio of velocities at each bounce, its mean and
//! scatter, and whether it depends on the speed.

use std::fmt;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::StepError;
use super::line_fit::line;
use crate::fit::contact_readings::{Bounce, ContactReadings};
use crate::fit::thresholds::{MAX_RATIO_ERROR, MIN_BOUNCE_RATIO, MIN_BOUNCES};
use crate::model::unit::counted;

/// The coefficient of restitution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Restitution {
    /// Weighted mean of the ratios.
    pub mean: f64,
    /// Its standard error.
    pub error: f64,
    /// Standard deviation of the ratios from bounce to bounce.
    pub scatter: f64,
    /// Exponent of `ratio ~ speed^-n`, and its standard error.
    pub exponent: (f64, f64),
    /// p-value of so large an exponent if the restitution is constant (Student's t).
    pub constant: f64,
    /// The bounces that count.
    pub bounces: Vec<Bounce>,
    /// The landings that do not.
    pub aside: ExcludedBounces,
    /// Distance of the model from what was read, in units of the noise.
    pub off: f64,
}

/// Landings that were seen but give no ratio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ExcludedBounces {
    /// In segments that could not be followed, for example in chatter: the next impact comes
    /// before the speed after the last one shows.
    pub unread: usize,
    /// Hops so short or so noisy that the ratio is uncertain.
    pub vague: usize,
    /// Departures too slow for a bounce: the mass stayed on the ground.
    pub stayed: usize,
}

impl ExcludedBounces {
    /// All of them.
    pub fn count(self) -> usize {
        self.unread + self.vague + self.stayed
    }
}

/// One sentence about them; empty where there are none.
impl fmt::Display for ExcludedBounces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = [
            (self.vague, "the hop was too short or too slow"),
            (
                self.unread,
                "the motion could not be followed: the mass chatters, or the device does not fit yet",
            ),
            (self.stayed, "the mass stayed on the ground"),
        ];
        let kinds: Vec<String> = (kinds.iter().filter(|(n, _)| *n > 0))
            .map(|(n, why)| format!("{} not used: {why}", counted(*n, "landing")))
            .collect();
        if kinds.is_empty() {
            return Ok(());
        }
        write!(f, "{}.", kinds.join("; "))
    }
}

/// Mean, scatter and dependence on speed.
///
/// # Errors
/// [`StepError::Unsuited`] if too few bounces have a known ratio.
pub fn restitution(names: &str, readings: &ContactReadings) -> Result<Restitution, StepError> {
    let mut aside = ExcludedBounces {
        unread: readings.unread,
        ..ExcludedBounces::default()
    };
    let mut bounces: Vec<Bounce> = Vec::new();
    for b in &readings.bounces {
        if b.ratio <= MIN_BOUNCE_RATIO {
            aside.stayed += 1;
        } else if b.error < MAX_RATIO_ERROR * b.ratio.max(0.1) {
            bounces.push(*b);
        } else {
            aside.vague += 1;
        }
    }
    if bounces.len() < MIN_BOUNCES {
        let mut reason = format!("needs {MIN_BOUNCES} bounces, found {}", bounces.len());
        if aside.count() > 0 {
            reason += &format!(" ({})", aside.to_string().trim_end_matches('.'));
        }
        return Err(StepError::Unsuited {
            recording: names.to_owned(),
            reason,
            remedy: "record a 300 Hz square or sine that just begins to hit the ground",
        });
    }
    let n = bounces.len() as f64;
    // Scatter beyond the bounces' own errors is part of each weight.
    let plain = bounces.iter().map(|b| b.ratio).sum::<f64>() / n;
    let scatter2 = bounces
        .iter()
        .map(|b| (b.ratio - plain).powi(2))
        .sum::<f64>()
        / (n - 1.0);
    let noise2 = bounces.iter().map(|b| b.error * b.error).sum::<f64>() / n;
    let own2 = (scatter2 - noise2).max(0.0);
    let weight = |b: &Bounce| 1.0 / (b.error * b.error + own2).max(1e-12);
    let total: f64 = bounces.iter().map(weight).sum();
    let mean = bounces.iter().map(|b| weight(b) * b.ratio).sum::<f64>() / total;
    let points: Vec<[f64; 3]> = bounces
        .iter()
        .map(|b| {
            let relative = (b.error / b.ratio).powi(2) + own2 / (mean * mean);
            [b.approach.ln(), b.ratio.ln(), 1.0 / relative.max(1e-12)]
        })
        .collect();
    let line = line(&points);
    let exponent = line.map_or((0.0, f64::INFINITY), |l| (-l.slope, l.slope_error));
    let constant = match StudentsT::new(0.0, 1.0, (n - 2.0).max(1.0)) {
        Ok(t) if exponent.1.is_finite() && exponent.1 > 0.0 => {
            2.0 * (1.0 - t.cdf((exponent.0 / exponent.1).abs()))
        }
        _ => 1.0,
    };
    Ok(Restitution {
        mean,
        error: total.recip().sqrt(),
        scatter: scatter2.sqrt(),
        exponent,
        constant,
        bounces,
        aside,
        off: readings.off.read,
    })
}
