//! The weak form's equations of one recording, one row a window: columns and the covariance of their
//! noise.

use nalgebra::{DMatrix, DVector};

use super::least_squares::banded_cholesky::BandedCholesky;
use super::least_squares::gram::Gram;
use super::measured_run::MeasuredRun;
use super::slow_mode::SlowMode;
use super::test_function::bump;
use super::windows::{FlightWindows, Window};
use crate::sim::ActingForces;

/// Prior standard deviation of the skew between the clocks of voltage and readings, in intervals
/// between samples.
const SKEW_SIGMA_INTERVALS: f64 = 0.5;

/// Equations of one recording.
#[derive(Debug, Clone)]
pub struct Equations<'a> {
    /// The recording.
    pub run: &'a MeasuredRun,
    flights: Vec<FlightWindows>,
    roots: Vec<BandedCholesky>,
    mode: SlowMode,
}

impl<'a> Equations<'a> {
    /// Those of `run` in `flights`, whose noise is that of readings of `mode` and of the instants
    /// at which `drive` \[at the nodes, N\] jumps.
    pub fn new(
        run: &'a MeasuredRun,
        flights: Vec<FlightWindows>,
        mode: &SlowMode,
        drive: &[f64],
    ) -> Self {
        let roots = flights.iter().map(|f| noise_root(run, f, mode, drive));
        Self {
            run,
            roots: roots.collect(),
            mode: *mode,
            flights,
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.flights.iter().map(Vec::len).sum()
    }

    /// All windows in the order of their rows.
    pub fn windows(&self) -> impl Iterator<Item = &Window> {
        self.flights.iter().flatten()
    }

    /// A column from what each window gives.
    fn column(&self, of: impl Fn(&Window) -> f64) -> Vec<f64> {
        self.windows().map(of).collect()
    }

    /// The accelerations \[m/s\]: the right-hand side.
    pub fn accelerations(&self) -> Vec<f64> {
        self.column(|w| w.of_reading(2, &self.run.readings[0]))
    }

    /// Columns of damping and stiffness.
    pub fn structure_columns(&self) -> [Vec<f64>; 2] {
        let x = &self.run.readings[0];
        [
            self.column(|w| w.of_reading(1, x)),
            self.column(|w| -w.of_reading(0, x)),
        ]
    }

    /// A column of so many derivatives of `values` \[at the nodes\]: by parts, so that none is taken of
    /// the values.
    pub fn of_values(&self, order: usize, values: &[f64]) -> Vec<f64> {
        let sign = if order % 2 == 1 { -1.0 } else { 1.0 };
        self.column(|w| sign * w.of_nodes(order, self.run, values))
    }

    /// What `acting` \[at the nodes\] gives.
    pub fn of_forces(&self, acting: &[ActingForces]) -> Vec<f64> {
        let s = &self.mode;
        let series = |f: &dyn Fn(&ActingForces) -> f64| -> Option<Vec<f64>> {
            let all: Vec<f64> = acting.iter().map(f).collect();
            all.iter().any(|v| *v != 0.0).then_some(all)
        };
        let force = series(&|a| s.drive * a.drive + s.mass * a.on_mass - a.base);
        let shown = series(&|a| a.reading_p);
        self.column(|w| {
            let of = |values: &Option<Vec<f64>>, order: usize| {
                let values = values.as_ref();
                values.map_or(0.0, |v| w.of_nodes(order, self.run, v))
            };
            of(&force, 0) + of(&shown, 2) - s.damping * of(&shown, 1) + s.stiffness * of(&shown, 0)
        })
    }

    /// The recording's own unknowns: columns with the standard deviations of their coefficients
    /// around 0. `drive` is the force of the drive at the nodes \[N\].
    pub fn nuisances(&self, drive: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let s = &self.mode;
        let (mut columns, mut errors) = (Vec::new(), Vec::new());
        if s.is_sprung {
            columns.push(self.column(|w| w.weights[0].iter().sum()));
            errors.push(f64::INFINITY);
        }
        if drive.iter().any(|d| *d != 0.0) {
            // A reading of another scale is a drive of another one; last, a skew of the clocks.
            columns.push(self.column(|w| s.drive * w.of_nodes(0, self.run, drive)));
            errors.push(self.run.scale_sigma);
            let time = &self.run.time;
            let interval = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
            columns.push(self.column(|w| s.drive * w.of_nodes(1, self.run, drive)));
            errors.push(SKEW_SIGMA_INTERVALS * interval);
        }
        (columns, errors)
    }

    /// Products of `columns` and the right-hand side, whitened, with the recording's own unknowns
    /// removed.
    pub fn gram(&self, columns: &[Vec<f64>], right: &[f64], drive: &[f64]) -> Gram {
        let (own, errors) = self.nuisances(drive);
        let all: Vec<&Vec<f64>> = columns.iter().chain(&own).collect();
        let mut matrix = DMatrix::zeros(self.rows(), all.len());
        for (j, column) in all.iter().enumerate() {
            matrix.column_mut(j).copy_from_slice(&self.whitened(column));
        }
        let right = DVector::from_vec(self.whitened(right));
        Gram::of(&matrix, &right).without_nuisances(&errors)
    }

    /// The recording's own unknowns where `left` is what the others leave.
    pub fn own_unknowns(&self, left: &[f64], drive: &[f64]) -> Vec<f64> {
        let (own, errors) = self.nuisances(drive);
        let left = DVector::from_vec(self.whitened(left));
        let mut matrix = DMatrix::zeros(left.len(), own.len());
        for (j, column) in own.iter().enumerate() {
            matrix.column_mut(j).copy_from_slice(&self.whitened(column));
        }
        let mut inner = matrix.tr_mul(&matrix);
        for (i, error) in errors.iter().enumerate() {
            inner[(i, i)] += error.powi(-2);
        }
        let slope = matrix.tr_mul(&left);
        let values = inner.cholesky().map(|root| root.solve(&slope));
        values.map_or_else(|| vec![0.0; own.len()], |v| v.as_slice().to_vec())
    }

    /// What `left` is in units of its rows' noise once the recording's own unknowns are removed.
    pub fn misfits(&self, left: &[f64], drive: &[f64]) -> Vec<f64> {
        let values = self.own_unknowns(left, drive);
        let (own, _) = self.nuisances(drive);
        let mut left = left.to_vec();
        for (column, value) in own.iter().zip(values) {
            for (l, c) in left.iter_mut().zip(column) {
                *l -= value * c;
            }
        }
        self.unweighted(&left)
    }

    /// A column in units of its rows' noise, with neighbours' correlation removed, each row with its
    /// weight.
    pub fn whitened(&self, column: &[f64]) -> Vec<f64> {
        let mut out = self.unweighted(column);
        for (value, window) in out.iter_mut().zip(self.windows()) {
            *value *= window.trust.sqrt();
        }
        out
    }

    /// The same with equal weights.
    fn unweighted(&self, column: &[f64]) -> Vec<f64> {
        let mut out = column.to_vec();
        let mut first = 0;
        for (windows, root) in self.flights.iter().zip(&self.roots) {
            let end = first + windows.len();
            root.whiten(&mut out[first..end]);
            first = end;
        }
        out
    }
}

/// The inverse root of the covariance of the rows of a flight: noise of the readings through the same
/// integrals, and what an uncertain instant of a jump of `drive` makes.
fn noise_root(
    run: &MeasuredRun,
    windows: &FlightWindows,
    mode: &SlowMode,
    drive: &[f64],
) -> BandedCholesky {
    let rows: Vec<NoiseRow> = windows
        .iter()
        .map(|w| NoiseRow::new(run, w, mode, drive))
        .collect();
    let reach = (0..rows.len()).map(|a| {
        let before = rows[..a].iter().rev();
        before.take_while(|b| rows[a].overlaps(b)).count()
    });
    let band = reach.max().unwrap_or(0);
    let element = |row: usize, column: usize| rows[row].covariance(&rows[column]);
    BandedCholesky::new(rows.len(), band, element)
}

/// What independent noises give to one row.
struct NoiseRow {
    /// First sample.
    first: usize,
    /// Per unit of each sample's own noise.
    white: Vec<f64>,
    /// Per unit of each step of the noise with a memory; they begin before the row's own samples. Empty
    /// without such noise.
    remembered: Vec<f64>,
    /// Per jump of the drive, by its number: what one standard deviation of its instant gives.
    jumps: Vec<(usize, f64)>,
}

impl NoiseRow {
    fn new(run: &MeasuredRun, w: &Window, mode: &SlowMode, drive: &[f64]) -> Self {
        let share = run.colour.share;
        let [value, slope, bend] = &w.weights;
        let one = |s: usize| bend[s] - mode.damping * slope[s] + mode.stiffness * value[s];
        let whole: Vec<f64> = (0..w.samples.len()).map(|s| run.noise * one(s)).collect();
        let scaled = |row: &[f64], by: f64| row.iter().map(|v| by * v).collect::<Vec<f64>>();
        let remembered = if share > 0.0 {
            scaled(&steps_of_memory(&whole, run.colour.keep), share.sqrt())
        } else {
            Vec::new()
        };
        let jumps = w.jumps.iter().map(|(edge, _)| {
            let e = &run.edges[*edge];
            let value = bump(e.time - w.centre, w.half_width)[0];
            (*edge, e.sigma * mode.drive * run.jump(*edge, drive) * value)
        });
        Self {
            first: w.samples.start,
            jumps: jumps.collect(),
            remembered,
            white: scaled(&whole, (1.0 - share).sqrt()),
        }
    }

    /// First sample whose noise counts, and the one after the last.
    fn span(&self) -> (isize, isize) {
        let end = (self.first + self.white.len()) as isize;
        let length = self.remembered.len().max(self.white.len());
        (end - length as isize, end)
    }

    fn overlaps(&self, other: &Self) -> bool {
        let ((a, b), (c, d)) = (self.span(), other.span());
        a < d && c < b
    }

    /// Covariance with another row.
    fn covariance(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        let begin = |row: &Self, v: &[f64]| row.span().1 - v.len() as isize;
        for (a, b) in [
            (&self.white, &other.white),
            (&self.remembered, &other.remembered),
        ] {
            let (from_a, from_b) = (begin(self, a), begin(other, b));
            let first = from_a.max(from_b);
            let a = a.get((first - from_a) as usize..).unwrap_or_default();
            let b = b.get((first - from_b) as usize..).unwrap_or_default();
            sum += a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        }
        for (edge, a) in &self.jumps {
            let same = other.jumps.iter().find(|(other, _)| other == edge);
            sum += same.map_or(0.0, |(_, b)| a * b);
        }
        sum
    }
}

/// What each independent step of a noise of variance 1 that keeps the share `keep` of itself from
/// sample to sample gives to sums weighted by `row`; its memory is followed over one length of the
/// row before it.
fn steps_of_memory(row: &[f64], keep: f64) -> Vec<f64> {
    let n = row.len();
    let mut out = vec![0.0; 2 * n];
    let size = (1.0 - keep * keep).sqrt();
    let mut sum = 0.0;
    for k in (0..2 * n).rev() {
        sum *= keep;
        if k >= n {
            sum += row[k - n];
        }
        out[k] = size * sum;
    }
    out
}
