//! The frequency at which the mass rings while it flies, from data alone: what two
//! recordings of one device have in common whatever drove them.
//!
//! A flight is cut where the voltage jumps. In each piece a ring that dies away is fitted
//! together with what follows the voltage slowly (a polynomial in time and voltage), and the
//! pieces that show a ring clearly are put together. The film slows and damps the ring
//! near the ground, so that the frequency is good to some percent.

use nalgebra::{DMatrix, DVector};

use super::{Recording, extremes, median_in_place};

/// Damping ratios that are tried.
const TRIED_DAMPING_RATIOS: [f64; 6] = [0.0, 0.01, 0.02, 0.04, 0.08, 0.16];
/// Fewest periods of a piece.
const MIN_PERIODS: f64 = 2.5;
/// Most periods of a piece: later the ring has decayed.
const MAX_PERIODS: f64 = 20.0;
/// Fewest samples of a piece, and most that are used of it.
const SAMPLE_LIMITS: (usize, usize) = (24, 300);
/// Fewest samples to a period.
const MIN_SAMPLES_PER_PERIOD: f64 = 6.0;
/// A voltage that changes by this share of its range from one sample to the next jumps.
const JUMP_SHARE: f64 = 0.02;
/// Samples that are not used after a jump or a release, and before a touch.
const GUARD_SAMPLES: usize = 3;
/// A ring is clear if at most this share of the motion's power is unexplained ...
const MAX_UNEXPLAINED_POWER: f64 = 0.15;
/// ... and its deviation is this many times the noise.
const ABOVE_NOISE: f64 = 8.0;
/// Most pieces that are analysed: those with the largest motion.
const MAX_PIECES: usize = 5;
/// Step of the search, as a share of the frequency resolution of a piece.
const SEARCH_STEP_SHARE: f64 = 0.1;

/// A ring in flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Its frequency \[Hz\].
    pub frequency: f64,
    /// Its uncertainty \[Hz\]: scatter among the pieces, or what one of them resolves.
    pub error: f64,
}

/// The ring in the `flights` of a recording (begin and end in s) whose frequency is
/// within `band` \[Hz\]; `noise` is that of the proof mass \[m\]. `None` if none is clear.
#[must_use]
pub fn ring_in(
    recording: &Recording,
    flights: &[(f64, f64)],
    noise: f64,
    band: (f64, f64),
) -> Option<Ring> {
    let (low, high) = (
        band.0,
        band.1
            .min(recording.sampling_rate() / MIN_SAMPLES_PER_PERIOD),
    );
    if !(low > 0.0 && low < high) {
        return None;
    }
    let mut pieces: Vec<Piece> = flights
        .iter()
        .flat_map(|flight| cut(recording, *flight, low))
        .filter(|piece| piece.duration() * high >= MIN_PERIODS)
        .collect();
    pieces.sort_by(|a, b| b.power.total_cmp(&a.power));
    pieces.truncate(MAX_PIECES);
    let rings: Vec<(f64, f64)> = pieces
        .iter()
        .filter_map(|piece| piece.ring((low, high), noise))
        .collect();
    log::debug!("{}: rings {rings:?}", recording.name);
    let mut found: Vec<f64> = rings.iter().map(|r| r.0).collect();
    if found.is_empty() {
        return None;
    }
    let frequency = median_in_place(&mut found);
    let mut off: Vec<f64> = found.iter().map(|f| (f - frequency).abs()).collect();
    let scatter = 1.5 * median_in_place(&mut off);
    let resolved = rings.iter().map(|r| r.1).fold(f64::INFINITY, f64::min);
    Some(Ring {
        frequency,
        error: (scatter / (rings.len() as f64).sqrt()).max(resolved),
    })
}

/// A piece of a flight during which the voltage does not jump.
struct Piece {
    /// Since its begin \[s\].
    time: Vec<f64>,
    /// The reading \[m\].
    xp: Vec<f64>,
    /// The voltage between -1 and 1, if it moves.
    voltage: Option<Vec<f64>>,
    /// Mean square of the reading about its mean \[m^2\].
    power: f64,
}

fn cut(recording: &Recording, (from, to): (f64, f64), low: f64) -> Vec<Piece> {
    let time = &recording.time;
    let volts = recording.voltage.as_deref();
    let (least, most) = extremes(volts.unwrap_or_default());
    let jump = JUMP_SHARE * (most - least);
    let first = time.partition_point(|t| *t < from) + GUARD_SAMPLES;
    let end = time
        .partition_point(|t| *t <= to)
        .saturating_sub(GUARD_SAMPLES);
    let breaks = (first + 1..end).filter(|&i| {
        let jumps = volts.is_some_and(|v| jump > 0.0 && (v[i] - v[i - 1]).abs() > jump);
        jumps || recording.is_gap(i - 1)
    });
    let mut pieces = Vec::new();
    let mut begin = first;
    for stop in breaks.chain([end]) {
        if begin + SAMPLE_LIMITS.0 <= stop {
            pieces.extend(Piece::new(recording, begin..stop, low));
        }
        begin = stop + GUARD_SAMPLES;
    }
    pieces
}

impl Piece {
    fn new(recording: &Recording, range: std::ops::Range<usize>, low: f64) -> Option<Self> {
        let begin = recording.time[range.start];
        let long = |i: &usize| recording.time[*i] - begin <= MAX_PERIODS / low;
        let whole: Vec<usize> = range.take_while(long).collect();
        let step = whole.len().div_ceil(SAMPLE_LIMITS.1);
        let seen = |i: &usize| {
            let volts = recording.voltage.as_deref();
            recording.proof_mass[*i].is_finite() && volts.is_none_or(|v| v[*i].is_finite())
        };
        let used: Vec<usize> = whole.into_iter().step_by(step).filter(seen).collect();
        if used.len() < SAMPLE_LIMITS.0 {
            return None;
        }
        let of = |values: &[f64]| -> Vec<f64> { used.iter().map(|i| values[*i]).collect() };
        let xp = of(&recording.proof_mass);
        let mean = xp.iter().sum::<f64>() / xp.len() as f64;
        let power = xp.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / xp.len() as f64;
        Some(Self {
            time: used.iter().map(|i| recording.time[*i] - begin).collect(),
            voltage: recording.voltage.as_deref().and_then(|v| scaled(&of(v))),
            xp,
            power,
        })
    }

    fn duration(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    /// Frequency of the ring in `band` \[Hz\] and how well it is resolved, if it is clear.
    fn ring(&self, (low, high): (f64, f64), noise: f64) -> Option<(f64, f64)> {
        let long = self.duration();
        let spacing = long / self.time.len() as f64;
        let (low, high) = (
            low.max(MIN_PERIODS / long),
            high.min(1.0 / (MIN_SAMPLES_PER_PERIOD * spacing)),
        );
        let slow = self.slow();
        let without = left(&slow, &self.xp)?;
        let step = SEARCH_STEP_SHARE / long;
        let count = ((high - low) / step).floor();
        if count.is_nan() || count < 2.0 {
            return None;
        }
        let tried = |f: f64| -> Option<f64> {
            let each = TRIED_DAMPING_RATIOS
                .iter()
                .filter_map(|z| left(&self.design_with_ring(&slow, f, *z), &self.xp));
            each.min_by(f64::total_cmp)
        };
        let costs: Vec<f64> = (0..=count as usize)
            .map(|k| tried(low + k as f64 * step).unwrap_or(f64::INFINITY))
            .collect();
        let best = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
        // At an end of the band nothing says that it is a ring.
        if best == 0 || best + 1 == costs.len() {
            return None;
        }
        let n = self.xp.len() as f64;
        let explained = without - costs[best];
        let clear = costs[best] < MAX_UNEXPLAINED_POWER * without
            && explained > n * (ABOVE_NOISE * noise).powi(2);
        if !clear {
            return None;
        }
        let (a, b, c) = (costs[best - 1], costs[best], costs[best + 1]);
        let bend = a - 2.0 * b + c;
        let shift = if bend > 0.0 {
            0.5 * (a - c) / bend
        } else {
            0.0
        };
        let variance = (costs[best] / n).max(noise * noise);
        let error = if bend > 0.0 {
            (2.0 * variance / bend).sqrt() * step
        } else {
            step
        };
        let frequency = low + (best as f64 + shift.clamp(-1.0, 1.0)) * step;
        Some((frequency, error.max(0.1 * step)))
    }

    /// Columns of what follows slowly: time to the second power, voltage to the third.
    fn slow(&self) -> DMatrix<f64> {
        let long = self.duration();
        let powers = if self.voltage.is_some() { 6 } else { 3 };
        DMatrix::from_fn(self.time.len(), powers, |i, j| {
            let tau = 2.0 * self.time[i] / long - 1.0;
            match (j, &self.voltage) {
                (0..3, _) => tau.powi(j as i32),
                (_, Some(v)) => v[i].powi(j as i32 - 2),
                _ => 0.0,
            }
        })
    }

    fn design_with_ring(&self, slow: &DMatrix<f64>, frequency: f64, damping: f64) -> DMatrix<f64> {
        let omega = std::f64::consts::TAU * frequency;
        let n = slow.ncols();
        let mut all = slow.clone().resize_horizontally(n + 2, 0.0);
        for (i, t) in self.time.iter().enumerate() {
            let (sin, cos) = (omega * t).sin_cos();
            let decay = (-damping * omega * t).exp();
            all[(i, n)] = decay * cos;
            all[(i, n + 1)] = decay * sin;
        }
        all
    }
}

/// Sum of squares that the best combination of `columns` leaves of `values`.
fn left(columns: &DMatrix<f64>, values: &[f64]) -> Option<f64> {
    let y = DVector::from_column_slice(values);
    let mut normal = columns.tr_mul(columns);
    for i in 0..normal.nrows() {
        // Columns may say the same, as powers of a voltage of two values do.
        normal[(i, i)] *= 1.0 + 1e-10;
        normal[(i, i)] += f64::MIN_POSITIVE;
    }
    let found = normal.cholesky()?.solve(&columns.tr_mul(&y));
    let rest = (y - columns * found).norm_squared();
    rest.is_finite().then_some(rest)
}

/// Values between -1 and 1; `None` if they do not move.
fn scaled(values: &[f64]) -> Option<Vec<f64>> {
    let (low, high) = extremes(values);
    let half = 0.5 * (high - low);
    (half > 0.0).then(|| values.iter().map(|v| (v - low) / half - 1.0).collect())
}

#[cfg(test)]
mod tests {
    use super::super::ring::*;

    const BAND: (f64, f64) = (250.0, 1500.0);

    /// Flights of 30 ms between jumps of the voltage, which also sways slowly; `ring` is what
    /// the mass does besides, at a time since the jump.
    fn flying(ring: impl Fn(f64) -> f64) -> Recording {
        let time: Vec<f64> = (0..6000).map(|i| 2e-5 * f64::from(i)).collect();
        let sway = |t: f64| 1.5 * (40.0 * t).sin();
        let jumps = |t: f64| {
            if ((t / 30e-3) as usize).is_multiple_of(2) {
                4.0
            } else {
                -4.0
            }
        };
        let volts: Vec<f64> = time.iter().map(|t| sway(*t) + jumps(*t)).collect();
        let noise = |i: usize| 20e-9 * ((i * i) as f64 * 0.7).sin();
        let xp = time
            .iter()
            .enumerate()
            .map(|(i, t)| 5e-6 * volts[i] + 0.1e-6 * volts[i].powi(2) + ring(t % 30e-3) + noise(i));
        Recording::new(
            "flying",
            time.clone(),
            Some(volts.clone()),
            xp.collect(),
            None,
        )
        .unwrap()
    }

    fn found(recording: &Recording) -> Option<Ring> {
        ring_in(recording, &[(0.0, 1.0)], 20e-9, BAND)
    }

    #[test]
    fn the_frequency_of_the_ring_does_not_depend_on_the_voltage() {
        for (f, zeta) in [(623.0, 0.026), (500.0, 0.005), (900.0, 0.1)] {
            let omega = std::f64::consts::TAU * f;
            let r = flying(|t| 8e-6 * (-zeta * omega * t).exp() * (omega * t + 0.4).cos());
            let ring = found(&r).unwrap();
            println!("{f} {ring:?}");
            assert!((ring.frequency / f - 1.0).abs() < 5e-3, "{ring:?}");
            assert!(ring.error < 5e-3 * f, "{ring:?}");
        }
    }

    #[test]
    fn motion_without_a_ring_in_the_band_gives_no_ring() {
        assert_eq!(found(&flying(|_| 0.0)), None);
        let slow = std::f64::consts::TAU * 100.0;
        assert_eq!(found(&flying(|t| 8e-6 * (slow * t).cos())), None);
        let r = flying(|_| 0.0);
        assert_eq!(ring_in(&r, &[], 20e-9, BAND), None);
        assert_eq!(ring_in(&r, &[(0.0, 1.0)], 20e-9, (f64::NAN, 1.0)), None);
    }
}
