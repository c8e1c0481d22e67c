//! The missing force as a curve over one quantity `u`: displacement, velocity, voltage or time.
//!
//! The curve is `F(u) = sum c_k hat_k(u)`, linear between its knots and beyond the outer ones. Each
//! hat along the measured motion, times the mode's `mass`, is a column of the regression next to the
//! known ones; its coefficient is the force at its knot \[N\].
//!
//! The known columns take a part of any curve: the zero of a spring its constant, stiffness, damping
//! and the gain of the drive its slope over `xp`, `vp` and `V`. What they take is not determined. A
//! curve therefore has directions only that are orthogonal to these, weighted by the time that the
//! motion spends near each knot: it is the force less its own constant or best line. A free mass has
//! neither spring nor damping, and its curves over `xp` and `vp` are the whole force. The law of the
//! named effects passes through the same regression, as if it were the measurement, so that both can
//! be compared.

use nalgebra::{DMatrix, DVector};

use super::equations::Equations;
use super::least_squares::gram::{Gram, Solution};
use super::measured_run::MeasuredRun;
use super::regression::{Devices, Knowledge, Runs, along, difference, sum_over};
use super::selection::{Balance, is_significant};
use crate::diagnose::diagnosis::{Absorbed, BalanceCurve, BalanceForces, ForceCurve, Quantity};
use crate::model::Model;
use crate::sim::{Options, SimError, StretchSimulator};

/// Knots of a curve, evenly over the values that occur.
const MAX_KNOTS: usize = 12;
/// Knots below which there is no curve: two say a line, which is absorbed.
const MIN_KNOTS: usize = 5;
/// Share of the time at either end of the values that no knot needs to reach.
const TAIL_TIME_SHARE: f64 = 1e-3;
/// Share of the time that must be spent near a knot, or it is left out: its neighbours reach over.
const MIN_KNOT_TIME_SHARE: f64 = 3e-3;
/// Standard errors of a knot, in median ones, above which it is not shown.
const MAX_ERROR_RATIO: f64 = 12.0;

/// The curves before and with the effects that are known, as strong as these are; the law of these in
/// the former.
///
/// # Errors
/// [`SimError`] if a model makes no sense.
pub fn missing_forces(balance: &Balance, known: &Knowledge) -> Result<BalanceForces, SimError> {
    if known.effects.is_empty() {
        return Ok(BalanceForces {
            before: curves(balance, known, None)?,
            after: Vec::new(),
        });
    }
    let (mut without, mut with) = (known.clone(), known.clone());
    without.effects.clear();
    // Beside a law whose parameters are fitted, what is like that law would not be determined.
    with.effects.iter_mut().for_each(|e| e.free.clear());
    let named = known.whole_model();
    Ok(BalanceForces {
        before: curves(balance, &without, Some(&named))?,
        after: curves(balance, &with, None)?,
    })
}

/// The curves of what is missing beyond what is `known`, with what `named` does more.
fn curves(
    balance: &Balance,
    known: &Knowledge,
    named: Option<&Model>,
) -> Result<Vec<BalanceCurve>, SimError> {
    let shapes: Vec<CurveShape> = Quantity::ALL
        .into_iter()
        .filter_map(|quantity| CurveShape::of(quantity, &balance.train, known))
        .collect();
    let (train, first) = products(&balance.train, known, &shapes, named)?;
    let (mut held_out, _) = products(&balance.held_out, known, &shapes, named)?;
    let has_held_out = !balance.held_out.runs.is_empty();
    if !has_held_out {
        held_out = Gram::new(train.slopes.len());
    }
    let without = train.solve(&(0..first).collect::<Vec<_>>());
    let mut out = Vec::new();
    let mut begin = first;
    for shape in &shapes {
        let end = begin + shape.directions.ncols();
        let columns: Vec<usize> = (0..first).chain(begin..end).collect();
        let with = train.solve(&columns);
        let gain = (
            without.chi2 - with.chi2,
            held_out.chi2_at(&without) - held_out.chi2_at(&with),
        );
        let excess = (
            with.chi2 / (train.freedom - with.rank as f64).max(1.0),
            held_out.chi2_at(&with) / held_out.freedom.max(1.0),
        );
        let law = named.map(|_| law_solution(&train, &columns));
        out.push(BalanceCurve {
            quantity: shape.quantity,
            curve: shape.curve(first, (&with, excess.0), law.as_ref()),
            absorbed: shape.absorbed,
            gain,
            by_chance: with.rank - without.rank,
            is_significant: is_significant(gain, excess, has_held_out),
        });
        begin = end;
    }
    Ok(out)
}

/// What the curve's regression makes of the law, whose column is the last one.
fn law_solution(train: &Gram, columns: &[usize]) -> Solution {
    let last = train.slopes.len() - 1;
    let of_law = Gram {
        slopes: train.products.column(last).into_owned(),
        square: train.products[(last, last)],
        ..train.clone()
    };
    of_law.solve(columns)
}

/// Products over `runs`: the known columns, how many there are, the directions of all curves, and the
/// force of what `named` does more.
fn products(
    runs: &Runs,
    known: &Knowledge,
    shapes: &[CurveShape],
    named: Option<&Model>,
) -> Result<(Gram, usize), SimError> {
    let devices = Devices::of(known)?;
    let named = named.map(|model| StretchSimulator::new(model, &Options::default()));
    let named = named.transpose()?;
    Ok(sum_over(runs, |run, windows| {
        let mut own = devices.equations(run, windows, known);
        let count = own.columns.len();
        for shape in shapes {
            let columns = shape.columns(&own.equations, known.mode.mass);
            own.columns.extend(columns);
        }
        let law = named.as_ref();
        let force = law.map(|law| difference(&along(run, law), &own.acting.whole));
        let law = force.map(|force| own.equations.of_forces(&force));
        own.columns.extend(law);
        (own.gram(), count)
    }))
}

/// The form of a curve over a quantity.
struct CurveShape {
    quantity: Quantity,
    /// Where its hats stand, SI.
    knots: Vec<f64>,
    /// What is fitted: forces at the knots \[1\], knots x directions.
    directions: DMatrix<f64>,
    absorbed: Absorbed,
}

impl CurveShape {
    /// That over the values of `quantity` in the flights of `runs`; `None` where too few occur, or
    /// where there is no drive for it.
    fn of(quantity: Quantity, runs: &Runs, known: &Knowledge) -> Option<Self> {
        let is_driven = known.model.piezo.is_some();
        let is_sprung = known.mode.is_sprung;
        let absorbed = match quantity {
            Quantity::Displacement | Quantity::Velocity => Absorbed {
                constant: is_sprung,
                slope: is_sprung,
            },
            _ if !is_driven => return None,
            Quantity::Voltage => Absorbed {
                constant: is_sprung,
                slope: true,
            },
            Quantity::Time => Absorbed {
                constant: is_sprung,
                slope: false,
            },
        };
        let seen = values_in_flight(quantity, &runs.runs);
        let knots = knots(&seen)?;
        let time = time_near(&knots, &seen);
        Some(Self {
            quantity,
            directions: directions(&knots, &time, absorbed)?,
            knots,
            absorbed,
        })
    }

    /// The column of each direction.
    fn columns(&self, equations: &Equations<'_>, mass: f64) -> Vec<Vec<f64>> {
        let at: Vec<(usize, f64)> = values_at_nodes(self.quantity, equations.run)
            .map(|u| place(&self.knots, u))
            .collect();
        let directions = self.directions.column_iter();
        let one = |direction: nalgebra::DVectorView<'_, f64>| {
            let force =
                |(k, s): &(usize, f64)| mass * ((1.0 - s) * direction[*k] + s * direction[k + 1]);
            let values: Vec<f64> = at.iter().map(force).collect();
            equations.of_values(0, &values)
        };
        directions.map(one).collect()
    }

    /// The curve from what was found, its columns from `first` on. What a row is off by beyond its noise
    /// widens the band.
    fn curve(
        &self,
        first: usize,
        (found, excess): (&Solution, f64),
        law: Option<&Solution>,
    ) -> ForceCurve {
        let count = self.directions.ncols();
        let forces = |s: &Solution| &self.directions * s.values.rows(first, count);
        let covariance = found.covariance.view((first, first), (count, count));
        let errors: Vec<f64> = self
            .directions
            .row_iter()
            .map(|row| {
                let variance = (row * covariance * row.transpose())[(0, 0)];
                let error = (variance * excess.max(1.0)).sqrt();
                if error.is_finite() {
                    error
                } else {
                    f64::INFINITY
                }
            })
            .collect();
        let mut sorted = errors.clone();
        sorted.sort_by(f64::total_cmp);
        let usual = sorted[sorted.len() / 2];
        let shown: Vec<usize> = (0..errors.len())
            .filter(|&k| errors[k].is_finite() && errors[k] <= MAX_ERROR_RATIO * usual)
            .collect();
        let pick = |all: &[f64]| shown.iter().map(|&k| all[k]).collect::<Vec<f64>>();
        let law = law.map(|law| pick(forces(law).as_slice()));
        ForceCurve {
            against: self.quantity.symbol(),
            unit: self.quantity.unit(),
            at: pick(&self.knots),
            force: pick(forces(found).as_slice()),
            std_error: pick(&errors),
            law: law
                .filter(|law| law.iter().any(|f| *f != 0.0))
                .unwrap_or_default(),
        }
    }
}

/// A quantity at the nodes of a recording, SI.
fn values_at_nodes(quantity: Quantity, run: &MeasuredRun) -> Box<dyn Iterator<Item = f64> + '_> {
    match quantity {
        Quantity::Displacement => Box::new(run.motion.iter().map(|m| m.xp)),
        Quantity::Velocity => Box::new(run.motion.iter().map(|m| m.vp)),
        Quantity::Voltage => Box::new(run.nodes.iter().map(|t| voltage(run, *t))),
        Quantity::Time => Box::new(run.nodes.iter().copied()),
    }
}

/// The voltage that acts at `t` \[V\].
fn voltage(run: &MeasuredRun, t: f64) -> f64 {
    let index = run.drive.partition_point(|s| s.end <= t);
    let piece = run.drive.get(index).or(run.drive.last());
    piece.map_or(0.0, |s| s.shape.voltage(t))
}

/// The values of a quantity in flight, SI, in order, each with the time for which it stands \[s\].
fn values_in_flight(quantity: Quantity, runs: &[MeasuredRun]) -> Vec<(f64, f64)> {
    let mut out = Vec::new();
    for run in runs {
        let all: Vec<f64> = values_at_nodes(quantity, run).collect();
        let time = &run.time;
        let step = (time[time.len() - 1] - time[0]) / run.thinned.len() as f64;
        let both = run.thinned.iter().zip(&run.thinned_nodes);
        let in_flight = both.filter(|(sample, _)| run.flights.iter().any(|f| f.contains(sample)));
        out.extend(in_flight.map(|(_, node)| (all[*node], step)));
    }
    out.retain(|(u, _)| u.is_finite());
    out.sort_by(|a, b| a.0.total_cmp(&b.0));
    out
}

/// Knots over the values `seen`, evenly but where hardly any time is spent; `None` if too few remain.
fn knots(seen: &[(f64, f64)]) -> Option<Vec<f64>> {
    let total: f64 = seen.iter().map(|s| s.1).sum();
    let (low, high) = (
        beyond_tail(seen.iter(), total)?,
        beyond_tail(seen.iter().rev(), total)?,
    );
    if low >= high {
        return None;
    }
    let step = (high - low) / (MAX_KNOTS - 1) as f64;
    let even: Vec<f64> = (0..MAX_KNOTS).map(|k| low + k as f64 * step).collect();
    let times = time_near(&even, seen);
    let enough = even.iter().zip(&times);
    let kept: Vec<f64> = enough
        .filter(|(_, time)| **time >= MIN_KNOT_TIME_SHARE * total)
        .map(|(u, _)| *u)
        .collect();
    (kept.len() >= MIN_KNOTS).then_some(kept)
}

/// The first of `values` that does not belong to the tail of values that are seldom.
fn beyond_tail<'a>(mut values: impl Iterator<Item = &'a (f64, f64)>, total: f64) -> Option<f64> {
    let mut sum = 0.0;
    let inner = values.find(|(_, time)| {
        sum += time;
        sum >= TAIL_TIME_SHARE * total
    });
    inner.map(|(u, _)| *u)
}

/// Time spent near each knot \[s\].
fn time_near(knots: &[f64], seen: &[(f64, f64)]) -> Vec<f64> {
    let mut out = vec![0.0; knots.len()];
    for (u, time) in seen {
        let (k, s) = place(knots, u.clamp(knots[0], knots[knots.len() - 1]));
        out[k] += (1.0 - s) * time;
        out[k + 1] += s * time;
    }
    out
}

/// Where `u` lies: the knot before it, and the share of the way to the next one; below 0 and above 1
/// beyond the outer knots, where a curve goes on as a line.
fn place(knots: &[f64], u: f64) -> (usize, f64) {
    let after = knots.partition_point(|k| *k <= u);
    let k = after.saturating_sub(1).min(knots.len() - 2);
    (k, (u - knots[k]) / (knots[k + 1] - knots[k]))
}

/// Orthonormal directions of the forces at `knots` without what is `absorbed`, by the `time` spent near
/// each; `None` if there is none.
fn directions(knots: &[f64], time: &[f64], absorbed: Absorbed) -> Option<DMatrix<f64>> {
    let count = knots.len();
    let weight = DVector::from_column_slice(time).normalize();
    let total: f64 = weight.sum();
    let middle = knots.iter().zip(weight.iter()).map(|(u, w)| u * w);
    let middle = middle.sum::<f64>() / total;
    let mut taken: Vec<DVector<f64>> = Vec::new();
    if absorbed.constant {
        taken.push(weight.clone());
    }
    if absorbed.slope {
        let reach = |k: usize| {
            if absorbed.constant {
                knots[k] - middle
            } else {
                knots[k]
            }
        };
        let mut slope = DVector::from_fn(count, |k, _| weight[k] * reach(k)).normalize();
        for other in &taken {
            slope -= other * other.dot(&slope);
        }
        taken.push(slope.normalize());
    }
    let mut left = DMatrix::identity(count, count);
    for own in &taken {
        left -= own * own.transpose();
    }
    let eigen = left.symmetric_eigen();
    let free: Vec<DVector<f64>> = (0..count)
        .filter(|&k| eigen.eigenvalues[k] > 0.5)
        .map(|k| eigen.eigenvectors.column(k).into_owned())
        .collect();
    (!free.is_empty()).then(|| DMatrix::from_columns(&free))
}
