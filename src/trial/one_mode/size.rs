//! How strong a law must be to show: a Cramer-Rao bound, as for the actuators.
//!
//! The trace of the law in the recordings that are fitted, in units of the readings' noise, with
//! frequency, damping, scale, and start and zero of every run projected out. Five standard deviations
//! of what is left are the smallest visible size. It is taken where the law is weak; sizes above are
//! the strength over that strength.

use nalgebra::{DMatrix, DVector};

use super::apparatus::Apparatus;
use super::law::OneModeLaw;
use super::motion::motion;
use crate::trial::visibility::JUST_VISIBLE;

/// Standard deviation of a reading's scale, known beforehand.
const SCALE_SIGMA: f64 = 0.01;
/// Standard deviation of gravity, known beforehand, as a share: it differs by that from place to
/// place.
const GRAVITY_SIGMA: f64 = 3e-3;
/// Ridge that serves columns which say the same, over columns of unit length.
const RIDGE: f64 = 1e-10;
/// How often the strength is brought nearer the smallest visible one.
const MAX_SEARCHES: usize = 12;
/// Powers of the strength by which deviations may grow from one strength to the next.
const POWERS: (f64, f64) = (0.3, 3.0);
/// Distance from the smallest visible size at which the search ends, as a share.
const SEARCH_TOLERANCE: f64 = 0.02;

/// How a freedom is changed, by an amount in its own unit.
type Change = Box<dyn Fn(&mut Apparatus, f64)>;

/// The bound of one apparatus.
pub struct Bound<'a> {
    apparatus: &'a Apparatus,
    /// Number of each run that is fitted, with its times.
    fitted: Vec<(usize, Vec<f64>)>,
    /// All readings without any law, in units of their noise.
    plain: DVector<f64>,
    columns: Vec<DVector<f64>>,
    /// What is known beforehand of each column \[1/sigma^2\].
    priors: Vec<f64>,
}

impl<'a> Bound<'a> {
    /// Prepares the bound; `None` if a run cannot be followed.
    #[must_use]
    pub fn new(apparatus: &'a Apparatus) -> Option<Self> {
        let fitted: Vec<(usize, Vec<f64>)> = (apparatus.runs.iter().enumerate())
            .filter(|(_, run)| !run.held_out)
            .map(|(i, run)| (i, apparatus.times(run)))
            .collect();
        let mut bound = Self {
            apparatus,
            fitted,
            plain: DVector::zeros(0),
            columns: Vec::new(),
            priors: Vec::new(),
        };
        bound.plain = bound.readings(apparatus, &[])?;
        bound.add_columns()?;
        Some(bound)
    }

    /// Readings of the fitted runs in units of their noise.
    fn readings(&self, apparatus: &Apparatus, laws: &[&OneModeLaw]) -> Option<DVector<f64>> {
        let sigma = self.apparatus.reading_sigma();
        let mut all = Vec::new();
        for (run, times) in &self.fitted {
            let x = motion(apparatus, laws, *run, times)?;
            all.extend(x.into_iter().map(|x| x / sigma));
        }
        Some(DVector::from_vec(all))
    }

    fn add_columns(&mut self) -> Option<()> {
        let (plain, apparatus) = (self.plain.clone(), self.apparatus);
        let device = &apparatus.device;
        let mut changes: Vec<(Change, f64, f64)> = Vec::new();
        if device.frequency > 0.0 {
            changes.push((Box::new(|a, s| a.device.frequency *= 1.0 + s), 1e-6, 0.0));
            changes.push((Box::new(|a, s| a.device.zeta += s), 1e-6, 0.0));
        } else {
            let prior = GRAVITY_SIGMA.powi(-2);
            changes.push((Box::new(|a, s| a.device.gravity *= 1.0 + s), 1e-5, prior));
        }
        let reach = apparatus.amplitude().max(1e-12);
        let speed = reach * apparatus.omega().max(1.0 / longest(apparatus));
        let fitted: Vec<usize> = self.fitted.iter().map(|(run, _)| *run).collect();
        for run in fitted {
            changes.push((Box::new(move |a, s| a.runs[run].x += s * reach), 1e-5, 0.0));
            changes.push((Box::new(move |a, s| a.runs[run].v += s * speed), 1e-5, 0.0));
        }
        let mut made = vec![(plain.clone(), SCALE_SIGMA.powi(-2))];
        for (change, step, prior) in changes {
            let mut other = apparatus.clone();
            change(&mut other, step);
            made.push(((self.readings(&other, &[])? - &plain) / step, prior));
        }
        let mut first = 0;
        for (_, times) in &self.fitted {
            let own = first..first + times.len();
            first = own.end;
            let zero = DVector::from_fn(plain.len(), |i, _| f64::from(u8::from(own.contains(&i))));
            made.push((zero, 0.0));
        }
        for (column, prior) in made {
            self.columns.push(column);
            self.priors.push(prior);
        }
        Some(())
    }

    /// Standard deviations by which a law stands out of what re-tuning can absorb.
    #[must_use]
    pub fn deviations(&self, law: &OneModeLaw) -> Option<f64> {
        let trace = self.readings(self.apparatus, &[law])? - &self.plain;
        let n = self.columns.len();
        let length = |i: usize| {
            let squared = self.columns[i].norm_squared() + self.priors[i];
            1.0 / squared.max(f64::MIN_POSITIVE).sqrt()
        };
        let scale: Vec<f64> = (0..n).map(length).collect();
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            let own = if i == j { self.priors[i] } else { 0.0 };
            let ridge = if i == j { RIDGE } else { 0.0 };
            (self.columns[i].dot(&self.columns[j]) + own) * scale[i] * scale[j] + ridge
        });
        let right = DVector::from_fn(n, |i, _| self.columns[i].dot(&trace) * scale[i]);
        let explained = matrix
            .cholesky()
            .map_or(0.0, |factor| right.dot(&factor.solve(&right)));
        Some((trace.norm_squared() - explained).max(0.0).sqrt())
    }

    /// By what the strength of `law` must be multiplied to be just visible.
    #[must_use]
    pub fn just_visible(&self, law: &OneModeLaw) -> Option<f64> {
        let mut factor = 1.0f64;
        // How fast the deviations grow, as a power of the strength: of a law whose leading part is
        // absorbed (a friction by load is nearly a viscous damping) faster than in proportion.
        let (mut power, mut before): (f64, Option<(f64, f64)>) = (1.0, None);
        for _ in 0..MAX_SEARCHES {
            let deviations = self.deviations(&law.scaled(factor))?.max(1e-9);
            let ratio = JUST_VISIBLE / deviations;
            if let Some((strength, found)) = before {
                let slope = (deviations / found).ln() / (factor / strength).ln();
                if slope.is_finite() {
                    power = slope.clamp(POWERS.0, POWERS.1);
                }
            }
            before = Some((factor, deviations));
            factor *= ratio.powf(1.0 / power);
            // Weaker than visible at full strength: the law is weak, the bound near its leading part.
            if (ratio - 1.0).abs() < SEARCH_TOLERANCE || factor > 1.0 {
                break;
            }
        }
        Some(factor)
    }
}

fn longest(apparatus: &Apparatus) -> f64 {
    let durations = apparatus.runs.iter().map(|run| run.duration);
    durations.fold(f64::MIN_POSITIVE, f64::max)
}
