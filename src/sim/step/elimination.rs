//! Small systems of linear equations.

// The indices are those of the matrix; iterators would hide them.
#![allow(clippy::needless_range_loop)]

/// Turns the right-hand side `b` into the answer to `a x = b`, by elimination with row
/// pivoting. A singular system leaves an answer that is not finite, for the caller to reject.
pub(super) fn eliminate<const N: usize>(a: &mut [[f64; N]; N], b: &mut [f64; N]) {
    for i in 0..N {
        let pivot = (i..N)
            .max_by(|&x, &y| a[x][i].abs().total_cmp(&a[y][i].abs()))
            .unwrap_or(i);
        a.swap(i, pivot);
        b.swap(i, pivot);
        for r in i + 1..N {
            let factor = a[r][i] / a[i][i];
            for c in i..N {
                a[r][c] -= factor * a[i][c];
            }
            b[r] -= factor * b[i];
        }
    }
    for i in (0..N).rev() {
        for c in i + 1..N {
            b[i] -= a[i][c] * b[c];
        }
        b[i] /= a[i][i];
    }
}

#[cfg(test)]
mod tests {
    use super::super::elimination::*;

    #[test]
    fn elimination_solves_the_system() {
        let a = [[0.0, 2.0, -1.0], [4.0, 1e-3, 3.0], [-7.0, 5.0, 0.5]];
        let x = [1.5, -2.0, 0.25];
        let mut b: [f64; 3] = std::array::from_fn(|k| (0..3).map(|j| a[k][j] * x[j]).sum());
        eliminate(&mut a.clone(), &mut b);
        for (found, x) in b.iter().zip(x) {
            assert!((found - x).abs() < 1e-12, "{found} {x}");
        }
        let mut none = [1.0, 1.0];
        eliminate(&mut [[1.0, 2.0], [2.0, 4.0]], &mut none);
        assert!(none.iter().any(|x| !x.is_finite()));
    }
}
