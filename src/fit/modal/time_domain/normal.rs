//! Normal equations of a stretch, block by block, with the unknowns of the stretch alone eliminated.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::data::{Data, Stretch};
use super::kernel::{Columns, Oscillator, Pole};

/// Rows that are worked on at once.
pub(super) const BLOCK_ROWS: usize = 2048;
/// Added to the scaled diagonal, so that unknowns which a short stretch does not tell stay finite.
pub(super) const RIDGE: f64 = 1e-13;

/// The linear unknowns for given poles.
#[derive(Debug, Clone)]
pub struct Linear {
    /// Static displacement per input of each mode, then that of the modes above \[m\]; by reading.
    pub shared: [Option<DVector<f64>>; 2],
    /// Decays (cosine and sine of each mode) and offset \[m\]; by stretch and reading.
    pub locals: Vec<[Option<DVector<f64>>; 2]>,
    /// Sum of squared residuals [m^2], by reading.
    pub squares: [f64; 2],
    /// Samples, by reading.
    pub rows: [usize; 2],
}

/// What poles act with.
#[derive(Debug, Clone, Copy)]
pub struct Setup<'a> {
    /// Poles.
    pub poles: &'a [Pole],
    /// Film force per input that acts with the same residue, of each pole [1/N]; empty without a film.
    pub film_shares: &'a [f64],
}

impl Setup<'_> {
    pub(super) fn oscillators(&self, stretch: &Stretch) -> Vec<Oscillator> {
        let share = |r: usize| self.film_shares.get(r).copied().unwrap_or(0.0);
        let poles = self.poles.iter().enumerate();
        poles
            .map(|(r, p)| Oscillator::new(*p, share(r), stretch))
            .collect()
    }

    pub(super) fn locals(&self) -> usize {
        2 * self.poles.len() + 1
    }

    pub(super) fn shared(&self) -> usize {
        self.poles.len() + 1
    }
}

/// Normal equations of a reading of a stretch: `[locals | poles and skew | shared | target]`.
struct Normal {
    gram: DMatrix<f64>,
    rows: usize,
}

/// Accumulates the normal equations of a stretch. With `around`, the derivatives by the poles are
/// included and the target is the residual; else the target is the reading.
fn normal(
    setup: &Setup<'_>,
    stretch: &Stretch,
    around: Option<(&Linear, usize)>,
) -> [Option<Normal>; 2] {
    let modes = setup.poles.len();
    let moved = if around.is_some() { 2 * modes + 1 } else { 0 };
    let (locals, shared) = (setup.locals(), setup.shared());
    let width = locals + moved + shared + 1;
    let mut found = [0, 1].map(|c: usize| {
        stretch.readings[c].as_ref().map(|_| Normal {
            gram: DMatrix::zeros(width, width),
            rows: 0,
        })
    });
    let mut oscillators = setup.oscillators(stretch);
    let mut columns = vec![Columns::default(); modes];
    let mut from = 0;
    while from < stretch.samples() {
        let to = (from + BLOCK_ROWS).min(stretch.samples());
        for (oscillator, own) in oscillators.iter_mut().zip(&mut columns) {
            oscillator.fill(stretch, from, to, around.is_some(), own);
        }
        for (c, normal) in found.iter_mut().enumerate() {
            let (Some(normal), Some(reading)) = (normal.as_mut(), stretch.readings[c].as_ref())
            else {
                continue;
            };
            let mut x = DMatrix::zeros(to - from, width);
            fill_linear(&mut x, &columns, stretch, from, locals + moved);
            let target = width - 1;
            for (k, i) in (from..to).enumerate() {
                x[(k, target)] = reading[i];
            }
            if let Some((linear, index)) = around {
                let own = linear.locals.get(index).and_then(|l| l[c].as_ref());
                if let (Some(own), Some(common)) = (own, linear.shared[c].as_ref()) {
                    fill_moved(&mut x, &columns, own, common, locals);
                    let sum =
                        x.columns(0, locals) * own + x.columns(locals + moved, shared) * common;
                    for k in 0..to - from {
                        x[(k, target)] -= sum[k];
                    }
                }
            }
            for (k, i) in (from..to).enumerate() {
                if reading[i].is_finite() {
                    normal.rows += 1;
                } else {
                    x.row_mut(k).fill(0.0);
                }
            }
            normal.gram += x.transpose() * &x;
        }
        from = to;
    }
    found
}

/// Fills the columns of the linear unknowns.
pub(super) fn fill_linear(
    x: &mut DMatrix<f64>,
    columns: &[Columns],
    stretch: &Stretch,
    from: usize,
    shared_at: usize,
) {
    let rows = x.nrows();
    let modes = columns.len();
    for (r, own) in columns.iter().enumerate() {
        for k in 0..rows {
            x[(k, 2 * r)] = own.decay[0][k];
            x[(k, 2 * r + 1)] = own.decay[1][k];
            x[(k, shared_at + r)] = own.response[k];
        }
    }
    for k in 0..rows {
        x[(k, 2 * modes)] = 1.0;
        x[(k, shared_at + modes)] = stretch.input[from + k];
    }
}

/// Fills the derivatives by the poles and the skew, at the linear unknowns found.
fn fill_moved(
    x: &mut DMatrix<f64>,
    columns: &[Columns],
    own: &DVector<f64>,
    common: &DVector<f64>,
    at: usize,
) {
    let rows = x.nrows();
    let modes = columns.len();
    for (r, columns) in columns.iter().enumerate() {
        for by in 0..2 {
            for k in 0..rows {
                x[(k, at + 2 * r + by)] = common[r] * columns.response_slopes[by][k]
                    + own[2 * r] * columns.decay_slopes[by][0][k]
                    + own[2 * r + 1] * columns.decay_slopes[by][1][k];
            }
        }
        for k in 0..rows {
            x[(k, at + 2 * modes)] -= common[r] * columns.rate[k];
        }
    }
}

/// A symmetric positive system, scaled by its diagonal.
pub(super) struct Scaled {
    scale: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl Scaled {
    pub(super) fn new(matrix: &DMatrix<f64>, ridge: f64) -> Option<Self> {
        let scale = matrix
            .diagonal()
            .map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 1.0 });
        let n = matrix.nrows();
        let mut scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
        for i in 0..n {
            scaled[(i, i)] = scaled[(i, i)].max(f64::MIN_POSITIVE) * (1.0 + ridge) + ridge;
        }
        if scaled.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let factor = Cholesky::new(scaled)?;
        Some(Self { scale, factor })
    }

    pub(super) fn solve(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        let mut scaled = right.clone();
        for (mut row, s) in scaled.row_iter_mut().zip(self.scale.iter()) {
            row *= *s;
        }
        let mut found = self.factor.solve(&scaled);
        for (mut row, s) in found.row_iter_mut().zip(self.scale.iter()) {
            row *= *s;
        }
        found
    }
}

/// The locals' part of normal equations, eliminated.
pub(super) struct Eliminated {
    /// Normal equations of what is left.
    pub(super) reduced: DMatrix<f64>,
    /// Locals per unit of each of the others: `L^-1 L_other`.
    pub(super) follow: DMatrix<f64>,
}

fn eliminate(normal: &Normal, locals: usize) -> Option<Eliminated> {
    let n = normal.gram.nrows() - locals;
    let own = normal.gram.view((0, 0), (locals, locals)).into_owned();
    let cross = normal.gram.view((0, locals), (locals, n)).into_owned();
    let follow = Scaled::new(&own, RIDGE)?.solve(&cross);
    let rest = normal.gram.view((locals, locals), (n, n));
    let reduced = rest - cross.transpose() * &follow;
    Some(Eliminated { reduced, follow })
}

/// The readings of a stretch, locals eliminated, each with its number of rows.
pub(super) type StretchNormal = [Option<(Eliminated, usize)>; 2];

/// All readings of all stretches, locals eliminated.
pub(super) fn all_normal(
    setup: &Setup<'_>,
    data: &Data,
    around: Option<&Linear>,
) -> Option<Vec<StretchNormal>> {
    let locals = setup.locals();
    data.stretches
        .par_iter()
        .enumerate()
        .map(|(i, stretch)| {
            let found = normal(setup, stretch, around.map(|l| (l, i)));
            let mut out = [None, None];
            for (out, normal) in out.iter_mut().zip(found) {
                if let Some(normal) = normal.filter(|n| n.rows > locals) {
                    let rows = normal.rows;
                    *out = Some((eliminate(&normal, locals)?, rows));
                }
            }
            Some(out)
        })
        .collect()
}
