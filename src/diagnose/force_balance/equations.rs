//! The weak form's equations of one recording: rows, columns and the covariance of their noise.

use nalgebra::{DMatrix, DVector};

use super::banded_cholesky::BandedCholesky;
use super::gram::Gram;
use super::measured_run::MeasuredRun;
use super::structure::AccelerationModel;
use super::windows::{FlightWindows, Window};
use crate::sim::ActingForces;

/// Prior standard deviation of the scale of a reading in one recording, relative to the others.
const SCALE_SIGMA: f64 = 0.01;
/// Prior standard deviation of the skew between the clocks of voltage and readings, in intervals
/// between samples.
const SKEW_SIGMA_INTERVALS: f64 = 0.5;

/// Equations of one recording: for each window one row a reading.
#[derive(Debug, Clone)]
pub struct Equations<'a> {
    /// The recording.
    pub run: &'a MeasuredRun,
    flights: Vec<FlightWindows>,
    roots: Vec<BandedCholesky>,
    structure: AccelerationModel,
}

impl<'a> Equations<'a> {
    /// Those of `run` in `flights`, whose noise is that of readings in `structure`.
    pub fn new(
        run: &'a MeasuredRun,
        flights: Vec<FlightWindows>,
        structure: &AccelerationModel,
    ) -> Self {
        let roots = flights.iter().map(|f| noise_root(run, f, structure));
        Self {
            run,
            roots: roots.collect(),
            structure: structure.clone(),
            flights,
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        let windows: usize = self.flights.iter().map(Vec::len).sum();
        windows * self.structure.readings()
    }

    /// All windows in the order of their rows.
    pub fn windows(&self) -> impl Iterator<Item = &Window> {
        self.flights.iter().flatten()
    }

    /// A column from what a window gives to the equation of each reading.
    fn column(&self, of: impl Fn(&Window, usize) -> f64) -> Vec<f64> {
        let readings = self.structure.readings();
        let windows = self.windows();
        windows
            .flat_map(|w| (0..readings).map(|i| of(w, i)).collect::<Vec<_>>())
            .collect()
    }

    /// The accelerations \[m/s\]: the right-hand side.
    pub fn accelerations(&self) -> Vec<f64> {
        self.column(|w, i| w.of_reading(2, &self.run.readings[i]))
    }

    /// Columns of damping and stiffness: for each equation and reading one of each, in units of the
    /// model's fastest rate, so that their coefficients are of one size.
    pub fn structure_columns(&self) -> Vec<Vec<f64>> {
        let readings = self.structure.readings();
        let mut out = Vec::new();
        for order in [1, 0] {
            for row in 0..readings {
                for j in 0..readings {
                    let sign = if order == 1 { 1.0 } else { -1.0 };
                    out.push(self.column(|w, i| {
                        if i == row {
                            sign * w.of_reading(order, &self.run.readings[j])
                        } else {
                            0.0
                        }
                    }));
                }
            }
        }
        out
    }

    /// A column of `values` \[at the nodes\] in the equation of reading `row` alone.
    pub fn in_one_equation(&self, row: usize, values: &[f64]) -> Vec<f64> {
        self.column(|w, i| {
            if i == row {
                w.of_nodes(0, self.run, values)
            } else {
                0.0
            }
        })
    }

    /// A column of the rate of change of `values` \[at the nodes\] in the equation of reading `row`
    /// alone, by parts: no derivative of the values is needed.
    pub fn rate_in_one_equation(&self, row: usize, values: &[f64]) -> Vec<f64> {
        self.column(|w, i| {
            if i == row {
                -w.of_nodes(1, self.run, values)
            } else {
                0.0
            }
        })
    }

    /// What `acting` \[at the nodes\] gives to the equations.
    pub fn of_forces(&self, acting: &[ActingForces]) -> Vec<f64> {
        let s = &self.structure;
        let readings = s.readings();
        let series = |f: &dyn Fn(&ActingForces) -> f64| -> Option<Vec<f64>> {
            let all: Vec<f64> = acting.iter().map(f).collect();
            all.iter().any(|v| *v != 0.0).then_some(all)
        };
        let forces = (0..readings)
            .map(|i| series(&|a| s.drive[i] * a.drive + s.mass[i] * a.on_mass - a.base));
        let forces: Vec<Option<Vec<f64>>> = forces.collect();
        let shown = [
            series(&|a| a.reading_p),
            series(&|a| a.reading_c).filter(|_| readings > 1),
        ];
        self.column(|w, i| {
            let force = forces[i]
                .as_ref()
                .map_or(0.0, |f| w.of_nodes(0, self.run, f));
            let read = shown.iter().enumerate().map(|(j, values)| {
                let Some(values) = values else {
                    return 0.0;
                };
                let own = if i == j {
                    w.of_nodes(2, self.run, values)
                } else {
                    0.0
                };
                own - s.damping[(i, j)] * w.of_nodes(1, self.run, values)
                    + s.stiffness[(i, j)] * w.of_nodes(0, self.run, values)
            });
            force + read.sum::<f64>()
        })
    }

    /// The recording's own unknowns: columns with the standard deviations of their coefficients
    /// around 0. `drive` is the force of the drive at the nodes \[N\].
    pub fn nuisances(&self, drive: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let s = &self.structure;
        let readings = s.readings();
        let (mut columns, mut errors) = (Vec::new(), Vec::new());
        if s.is_sprung() {
            // A zero in each equation.
            for row in 0..readings {
                columns.push(self.column(|w, i| {
                    let all: f64 = w.weights[0].iter().sum();
                    if i == row { all } else { 0.0 }
                }));
                errors.push(f64::INFINITY);
            }
        }
        // A reading of another scale: what it alone gives to the equations.
        for j in 0..readings {
            let values = &self.run.readings[j];
            columns.push(self.column(|w, i| {
                let own = if i == j { w.of_reading(2, values) } else { 0.0 };
                own - s.damping[(i, j)] * w.of_reading(1, values)
                    + s.stiffness[(i, j)] * w.of_reading(0, values)
            }));
            errors.push(SCALE_SIGMA);
        }
        if drive.iter().any(|d| *d != 0.0) {
            let time = &self.run.time;
            let interval = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
            columns.push(self.column(|w, i| s.drive[i] * w.of_nodes(1, self.run, drive)));
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

    /// A column in units of its rows' noise, with neighbours' correlation removed.
    pub fn whitened(&self, column: &[f64]) -> Vec<f64> {
        let mut out = column.to_vec();
        let mut first = 0;
        for (windows, root) in self.flights.iter().zip(&self.roots) {
            let end = first + windows.len() * self.structure.readings();
            root.whiten(&mut out[first..end]);
            first = end;
        }
        out
    }
}

/// The inverse root of the covariance of the rows of a flight: white noise of the readings through
/// the same integrals.
fn noise_root(
    run: &MeasuredRun,
    windows: &FlightWindows,
    structure: &AccelerationModel,
) -> BandedCholesky {
    let readings = structure.readings();
    // What a sample of each reading gives to each row.
    let kernels: Vec<Vec<f64>> = windows
        .iter()
        .flat_map(|w| {
            (0..readings).map(move |i| {
                let own = (0..readings).flat_map(move |j| {
                    let damping = structure.damping[(i, j)];
                    let stiffness = structure.stiffness[(i, j)];
                    let sigma = run.noise[j];
                    (0..w.samples.len()).map(move |s| {
                        let [value, slope, bend] = [0, 1, 2].map(|o: usize| w.weights[o][s]);
                        let own = if i == j { bend } else { 0.0 };
                        sigma * (own - damping * slope + stiffness * value)
                    })
                });
                own.collect()
            })
        })
        .collect();
    let overlap = |a: usize, b: usize| windows[a].samples.start < windows[b].samples.end;
    let reach = (0..windows.len()).map(|a| (0..a).rev().take_while(|b| overlap(a, *b)).count());
    let band = (reach.max().unwrap_or(0) + 1) * readings - 1;
    let element = |row: usize, column: usize| {
        let (a, b) = (&windows[row / readings], &windows[column / readings]);
        let first = a.samples.start.max(b.samples.start);
        let end = a.samples.end.min(b.samples.end);
        if first >= end {
            return 0.0;
        }
        let mut sum = 0.0;
        for j in 0..readings {
            let of = |w: &Window, k: usize| j * w.samples.len() + first - w.samples.start + k;
            for k in 0..end - first {
                sum += kernels[row][of(a, k)] * kernels[column][of(b, k)];
            }
        }
        sum
    };
    BandedCholesky::new(windows.len() * readings, band, element)
}
