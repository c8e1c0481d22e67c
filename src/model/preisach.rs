//! A Preisach operator with a smooth density: the effect of voltage sweeps on its relays, and the
//! past extremes that determine its state.
//!
//! Relays of half width `h` \[V\] with their centre at `c` \[V\] have the weight `f(h) g(c)`,
//!
//! `f = exp(-(q h)^2 / 2) (1 + k h / v_ref)`,  `g = 1 + b1' c + b2 (c/v_ref)^2 + b4 (c/v_ref)^4`.
//!
//! The state depends on those extremes of the voltage that no later extreme has exceeded. A sweep
//! from `b` up to `a` switches all relays between. This changes the output by Everett's function
//!
//! `E(a, b) = int_0^((a-b)/2) f(h) (G(a - h) - G(b + h)) dh`,  `G' = g`.
//!
//! The first sweep, from zero to `v`, changes it by `E(v, -v) / 2`. Source: Mayergoyz,
//! Mathematical Models of Hysteresis, 1991.

/// Largest number of extremes that are stored. Beyond it the innermost ones are dropped.
pub const MEMORY: usize = 12;
/// Voltages that differ by less than this are equal \[V\].
pub const EQUAL: f64 = 1e-9;
/// Number of moments of the density. `G` is a polynomial of degree 5.
const MOMENT_COUNT: usize = 6;
/// Distance of the half widths with tabulated moments, as a share of the reference amplitude.
const MOMENT_STEP: f64 = 1.0 / 160.0;
/// The same as a share of `1/q`. The smaller distance is used.
const NARROW_MOMENT_STEP: f64 = 0.125;
/// Number of such intervals. They suffice for sweeps up to 7.5 times the reference; larger half
/// widths have a table of their own.
const MOMENT_CELLS: usize = 600;
/// Half widths above this over `q` have no weight: it is no number above zero.
const WIDEST_COUNTED: f64 = 39.0;
/// Nodes and weights of the Gauss-Legendre rule with 4 points on -1 to 1.
static NODES: [(f64, f64); 4] = [
    (-0.8611363115940526, 0.34785484513745374),
    (-0.3399810435848563, 0.6521451548625464),
    (0.3399810435848563, 0.6521451548625464),
    (0.8611363115940526, 0.34785484513745374),
];

/// An end of a sweep \[V\], and `G` around it as a polynomial. The coefficients are zero where the
/// density is uniform in `h`.
type End = (f64, [f64; MOMENT_COUNT]);

/// The relays, with constants of their cycle between plus and minus the reference.
#[derive(Debug, Clone)]
pub struct Relays {
    narrow: f64,
    wider: f64,
    /// Coefficients of `c`, `c^2` and `c^4` in `g`.
    uneven: [f64; 3],
    /// Half the height of the cycle at 0 V.
    half_height: f64,
    /// Ends of the cycle: minus and plus the reference.
    ends: [End; 2],
    /// Distance of the half widths with tabulated moments \[V\].
    step: f64,
    /// `int_0^h f(h') h'^n dh'` at every `step` of `h`. Empty where the density is
    /// uniform in `h`.
    moments: Vec<[f64; MOMENT_COUNT]>,
    /// `f` at the same half widths, times `step`.
    densities: Vec<f64>,
    /// The moments at larger half widths, see [`Relays::integrate_tail`].
    tail: Vec<[f64; MOMENT_COUNT]>,
}

impl Relays {
    /// Relays with `v_ref` \[V\], `q` \[1/V\] and `k`, and the coefficients `b1'` \[1/V\], `b2` and
    /// `b4`.
    pub fn new([reference, narrow, wider]: [f64; 3], [slant, b2, b4]: [f64; 3]) -> Self {
        let mut relays = Self {
            narrow,
            wider: wider / reference,
            uneven: [slant, b2 / reference.powi(2), b4 / reference.powi(4)],
            half_height: 1.0,
            ends: [(0.0, [0.0; MOMENT_COUNT]); 2],
            step: (MOMENT_STEP * reference).min(NARROW_MOMENT_STEP / narrow),
            moments: Vec::new(),
            densities: Vec::new(),
            tail: Vec::new(),
        };
        if narrow != 0.0 || wider != 0.0 || b2 != 0.0 || b4 != 0.0 {
            relays.moments = relays.integrate();
            let at = |cell: usize| relays.step * relays.density(relays.step * cell as f64);
            relays.densities = (0..=MOMENT_CELLS).map(at).collect();
            relays.tail = relays.integrate_tail();
        }
        relays.ends = [-reference, reference].map(|v| relays.end(v));
        let e = |a: f64, b: f64| relays.everett(a, b);
        let half = 0.5 * (e(reference, -reference) - e(reference, 0.0) - e(0.0, -reference));
        // Weights that cancel give no loop.
        relays.half_height = if half.abs() > 1e-12 * reference * reference {
            half
        } else {
            f64::INFINITY
        };
        relays
    }

    /// Weight of relays of half width `h` \[V\].
    fn density(&self, h: f64) -> f64 {
        (-0.5 * (self.narrow * h).powi(2)).exp() * (1.0 + self.wider * h)
    }

    /// Table of the moments over half widths.
    fn integrate(&self) -> Vec<[f64; MOMENT_COUNT]> {
        let mut sum = [0.0; MOMENT_COUNT];
        let mut all = vec![sum];
        for cell in 0..MOMENT_CELLS {
            self.add(&mut sum, self.step * cell as f64, self.step);
            all.push(sum);
        }
        all
    }

    /// Adds the contribution of half widths from `h` to `h + step` to the moments.
    fn add(&self, sum: &mut [f64; MOMENT_COUNT], h: f64, step: f64) {
        for (x, weight) in NODES {
            let h = h + step * (0.5 + 0.5 * x);
            let mut term = 0.5 * step * weight * self.density(h);
            for moment in &mut *sum {
                *moment += term;
                term *= h;
            }
        }
    }

    /// The moments up to `h` \[V\]: cubic interpolation by values and slopes of the table.
    fn moments(&self, h: f64) -> [f64; MOMENT_COUNT] {
        let place = h / self.step;
        if place > MOMENT_CELLS as f64 {
            return self.tail_moments(h);
        }
        let cell = (place as usize).min(MOMENT_CELLS - 1);
        let (low, high) = (&self.moments[cell], &self.moments[cell + 1]);
        let at = [cell, cell + 1].map(|i| self.step * i as f64);
        let mut slope = [self.densities[cell], self.densities[cell + 1]];
        let t = place - cell as f64;
        let r = 1.0 - t;
        let mut out = [0.0; MOMENT_COUNT];
        for n in 0..MOMENT_COUNT {
            out[n] = r * r * ((1.0 + 2.0 * t) * low[n] + t * slope[0])
                + t * t * ((1.0 + 2.0 * r) * high[n] - r * slope[1]);
            slope = [slope[0] * at[0], slope[1] * at[1]];
        }
        out
    }

    /// The moments up to `h` \[V\] beyond the table.
    fn tail_moments(&self, h: f64) -> [f64; MOMENT_COUNT] {
        let last = self.step * MOMENT_CELLS as f64;
        let part = self.tail_part();
        let whole = ((h - last) / part) as usize;
        let known = whole.min(self.tail.len() - 1);
        let mut sum = self.tail[known];
        // Beyond the widest that counts there is nothing to add.
        if known == whole {
            let from = last + if known > 0 { part * known as f64 } else { 0.0 };
            self.add(&mut sum, from, h - from);
        }
        sum
    }

    /// Half widths beyond the table over which the rule is exact enough \[V\]: any for a weight that
    /// is a polynomial.
    fn tail_part(&self) -> f64 {
        NARROW_MOMENT_STEP / self.narrow
    }

    /// The moments at every such part beyond the table, the table's last first.
    fn integrate_tail(&self) -> Vec<[f64; MOMENT_COUNT]> {
        let last = self.step * MOMENT_CELLS as f64;
        let part = self.tail_part();
        let mut sum = self.moments[MOMENT_CELLS];
        let mut all = vec![sum];
        let mut from = last;
        while self.narrow * from < WIDEST_COUNTED && part.is_finite() {
            self.add(&mut sum, from, part);
            all.push(sum);
            from = last + part * (all.len() - 1) as f64;
        }
        all
    }

    /// `G(c + h)` as a polynomial in `h`.
    fn around(&self, c: f64) -> [f64; MOMENT_COUNT] {
        let [slant, square, fourth] = self.uneven;
        let mut g = [0.0, 1.0, 0.5 * slant, square / 3.0, 0.0, 0.2 * fourth];
        // Shift of the polynomial: Horner's scheme once for each power.
        for first in 0..MOMENT_COUNT {
            for n in (first..MOMENT_COUNT - 1).rev() {
                g[n] += c * g[n + 1];
            }
        }
        g
    }

    /// Change of the output by a sweep from `b` to `a` \[V\].
    fn everett(&self, a: f64, b: f64) -> f64 {
        self.between(&self.end(a), &self.end(b))
    }

    /// An end of a sweep at `c` \[V\].
    fn end(&self, c: f64) -> End {
        let around = if self.moments.is_empty() {
            [0.0; MOMENT_COUNT]
        } else {
            self.around(c)
        };
        (c, around)
    }

    /// Change of the output by a sweep from the end `b` to the end `a`.
    fn between(&self, a: &End, b: &End) -> f64 {
        let u = a.0 - b.0;
        if self.moments.is_empty() {
            return 0.25 * u * u.abs() * (1.0 + 0.5 * self.uneven[0] * (a.0 + b.0));
        }
        let (sign, a, b) = if u < 0.0 { (-1.0, b, a) } else { (1.0, a, b) };
        let moments = self.moments(0.5 * u.abs());
        let mut sum = 0.0;
        let mut odd = 1.0;
        for (moment, (to, from)) in moments.iter().zip(a.1.iter().zip(&b.1)) {
            sum += (odd * to - from) * moment;
            odd = -odd;
        }
        sign * sum
    }

    /// Output at `voltage` \[V\] after the extremes `past`. The middle line of the cycle between
    /// plus and minus the reference is subtracted, and half the height of that cycle at 0 V is the
    /// unit. The falling branch is positive.
    pub fn loops(&self, past: &[f64], voltage: f64) -> f64 {
        let past = standing(past, voltage, 0.0);
        let last = self.end(voltage);
        let moved = match past.split_first() {
            None => 0.5 * self.between(&last, &self.end(-voltage)),
            Some((first, rest)) => {
                let mut from = self.end(*first);
                let mut moved = 0.5 * self.between(&from, &self.end(-first));
                for to in rest {
                    let to = self.end(*to);
                    moved += self.between(&to, &from);
                    from = to;
                }
                moved + self.between(&last, &from)
            }
        };
        let [up, down] = &self.ends;
        let middle = 0.5 * (self.between(&last, up) + self.between(&last, down));
        (middle - moved) / self.half_height
    }
}

/// Past extremes of the voltage, first to last.
#[derive(Debug, Clone, Copy)]
pub struct Past {
    all: [f64; 1 + MEMORY],
    count: usize,
    /// Whether the first extreme is from before the drive began. The states do not contain it.
    pub older: bool,
}

impl Past {
    /// The extremes stored in the states `z`: their number, then their values. An extreme of
    /// `before` \[V\] comes first; 0 means none.
    pub fn new(before: f64, z: &[f64]) -> Self {
        let own = z.split_first().map_or(&[][..], |(count, rest)| {
            // Dense output may change the number by a rounding error.
            &rest[..(count.round().max(0.0) as usize).min(rest.len())]
        });
        let mut all = [0.0; 1 + MEMORY];
        // A larger first extreme has exceeded the one from before.
        let older = before != 0.0 && own.first().is_none_or(|v| v.abs() < before.abs() - EQUAL);
        all[0] = before;
        let at = usize::from(older);
        let kept = own.len().min(all.len() - at);
        all[at..at + kept].copy_from_slice(&own[..kept]);
        Self {
            all,
            count: at + kept,
            older,
        }
    }

    /// The extremes \[V\].
    pub fn extremes(&self) -> &[f64] {
        &self.all[..self.count]
    }
}

/// The extremes that `voltage` has not exceeded. An extreme counts as exceeded from `slack` \[V\]
/// before it. The last one is exceeded only by a voltage beyond it.
pub fn standing(mut past: &[f64], voltage: f64, slack: f64) -> &[f64] {
    // Distance of the voltage beyond `a`, in the direction from `b` to `a`.
    let past_by = |a: f64, b: f64| (voltage - a) * if a > b { 1.0 } else { -1.0 };
    loop {
        let n = past.len();
        // The first extreme follows its mirror image.
        let (before, last) = match *past {
            [] => return past,
            [first] => (-first, first),
            [.., before, last] => (before, last),
        };
        let overtaken = if past_by(before, last) >= -slack {
            2
        } else if past_by(last, before) > 0.0 {
            1
        } else {
            return past;
        };
        past = &past[..n.saturating_sub(overtaken)];
    }
}

#[cfg(test)]
mod tests {
    use super::super::preisach::*;

    /// Weight of relays of half width `h` around `c`.
    fn weight(q: f64, h: f64, c: f64) -> f64 {
        let r: f64 = c / 8.0;
        let g = 1.0 + 0.05 * c - 0.8 * r * r + 0.5 * r.powi(4);
        (-0.5 * (q * h).powi(2)).exp() * (1.0 + 3.0 * h / 8.0) * g
    }

    /// Change of the output by a sweep from `b` to `a`: a sum over single relays. Each switches up
    /// at c + h and down at c - h.
    fn by_relays(q: f64, a: f64, b: f64) -> f64 {
        if a < b {
            return -by_relays(q, b, a);
        }
        let n = 1000;
        let mut sum = 0.0;
        let dh = 0.5 * (a - b) / f64::from(n);
        for i in 0..n {
            let h = dh * (f64::from(i) + 0.5);
            let dc = (a - b - 2.0 * h) / f64::from(n);
            for j in 0..n {
                sum += dh * dc * weight(q, h, b + h + dc * (f64::from(j) + 0.5));
            }
        }
        sum
    }

    #[test]
    fn everetts_function_is_the_integral_over_the_relays() {
        // The last two lie beyond the table of moments.
        for (q, a, b) in [
            (0.4, 8.0, -8.0),
            (0.4, 3.0, -5.5),
            (0.4, 0.31, 0.0),
            (0.4, 6.0, 5.0),
            (0.02, 34.0, -30.0),
            (0.05, 64.0, -50.0),
        ] {
            let relays = Relays::new([8.0, q, 3.0], [0.05, -0.8, 0.5]);
            let (own, other) = (relays.everett(a, b), by_relays(q, a, b));
            assert!((own / other - 1.0).abs() < 1e-5, "{a} {b}: {own} {other}");
            assert!((relays.everett(b, a) + own).abs() < 1e-12 * own);
        }
    }

    #[test]
    fn loops_of_uneven_relays_are_sums_over_the_relays_that_each_sweep_moves() {
        const Q: f64 = 0.4;
        let relays = Relays::new([8.0, Q, 3.0], [0.05, -0.8, 0.5]);
        let e = |a: f64, b: f64| by_relays(Q, a, b);
        let half = 0.5 * (e(8.0, -8.0) - e(8.0, 0.0) - e(0.0, -8.0));
        let pasts: [&[f64]; 4] = [&[], &[-6.0], &[7.0, -4.0], &[8.0, -6.0, 3.0, -1.0]];
        for (past, voltage) in pasts.into_iter().zip([2.5, 2.0, 1.0, 0.5]) {
            let mut at = past.first().copied().unwrap_or(voltage);
            let mut moved = 0.5 * e(at, -at);
            for to in past.iter().skip(1).chain([&voltage]) {
                moved += e(*to, at);
                at = *to;
            }
            let other = (0.5 * (e(voltage, -8.0) + e(voltage, 8.0)) - moved) / half;
            let own = relays.loops(past, voltage);
            assert!(
                (own - other).abs() < 1e-4,
                "{past:?} {voltage}: {own} {other}"
            );
        }
    }
}
