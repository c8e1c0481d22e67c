//! Where simulation and recordings differ: residuals sample by sample, summed over time, regime,
//! and the quantities that the mismatch may depend on.

use rayon::prelude::*;

use crate::diagnose::diagnosis::{Distance, Marginal, Mismatch, Regime};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{
    HOP_MAX_TIME, MISMATCH_MIN_EXCESS, MISMATCH_MIN_Z, SAME_PLACE_SEGMENTS,
};
use crate::fit::problem::{Data, Problem};
use crate::fit::residual::coloured_noise::Colour;
use crate::fit::residual::residual_rows::SegmentContext;
use crate::fit::residual::simulate_segment;
use crate::fit::segment::Segment;
use crate::recording::quantile_in_place;
use crate::sim::{SimError, Stretcher};

/// Heights below this share of the travel count as near the ground.
const NEAR_GROUND_SHARE: f64 = 0.15;
/// Bins of a marginal.
const MARGINAL_BINS: usize = 24;

/// Most mismatches reported.
const MAX_MISMATCHES: usize = 40;

/// A sample with its residuals.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Index of the recording.
    pub recording: usize,
    /// Index of the segment it lies in.
    pub segment: usize,
    /// Time \[s\].
    pub time: f64,
    /// Reading of the proof mass \[m\].
    pub xp: f64,
    /// Its velocity \[m/s\].
    pub vp: f64,
    /// Voltage \[V\]; NaN if not recorded.
    pub voltage: f64,
    /// Time since the last event, or since the recording began \[s\].
    pub since: f64,
    /// Measured minus simulated, proof mass \[m\]; NaN if not read.
    pub miss_p: f64,
    /// The same of the cantilever \[m\].
    pub miss_c: f64,
    /// Whitened residuals of both, in units of the noise.
    pub white: (f64, f64),
    /// Regime of the motion.
    pub regime: Regime,
}

/// All samples of a fit's segments.
///
/// # Errors
/// [`SimError`] if the model makes no sense.
pub fn samples(fitted: &Fitted) -> Result<Vec<Sample>, SimError> {
    let (problem, point) = (&fitted.problem, &fitted.point);
    let simulator = problem.simulator(&point.x)?;
    let states = problem.states(&point.x, &simulator, &point.segments);
    let heights = near_ground_heights(problem);
    let undisturbed = event_free_since(problem, &point.segments);
    let one = |(i, segment): (usize, &Segment)| -> Vec<Sample> {
        if !point.used[i] {
            return Vec::new();
        }
        let context: SegmentContext<'_> = problem.context(segment, &states[i]);
        let nuisances = problem.nuisances_of(&point.x, segment.recording);
        let mut stretcher = Stretcher::new(&simulator);
        let locals = &segment.locals;
        let Ok(run) = simulate_segment::simulate_segment(
            segment,
            &context,
            &mut stretcher,
            &nuisances,
            locals,
        ) else {
            return Vec::new();
        };
        let data = &problem.data[segment.recording];
        let r = &data.recording;
        let step = 4.0 * r.interval();
        let miss = |values: Option<&[f64]>, sim: &[f64], scale: f64, offset: f64| -> Vec<f64> {
            let own = segment.samples.clone().zip(sim);
            own.map(|(k, x)| values.map_or(f64::NAN, |v| v[k] - scale * x - offset))
                .collect()
        };
        let p = miss(
            Some(&r.proof_mass),
            &run.xp,
            nuisances.scale_p,
            nuisances.offset_p,
        );
        let c = miss(
            r.cantilever.as_deref(),
            &run.xc,
            nuisances.scale_c,
            nuisances.offset_c,
        );
        let white = |miss: &[f64], sigma: f64| whitened(miss, sigma, &data.sigmas.colour);
        let (wp, wc) = (white(&p, data.sigmas.xp), white(&c, data.sigmas.xc));
        let near = heights[segment.recording];
        segment
            .samples
            .clone()
            .enumerate()
            .map(|(n, k)| {
                let (a, b) = (k.saturating_sub(2), (k + 2).min(r.len() - 1));
                let vp = (r.proof_mass[b] - r.proof_mass[a]) / (step * (b - a) as f64 / 4.0);
                let xp = r.proof_mass[k];
                let regime = if segment.starts_held {
                    Regime::Contact
                } else {
                    flight_regime(fitted.model.has_ground && xp < near, vp)
                };
                Sample {
                    recording: segment.recording,
                    segment: i,
                    time: r.time[k],
                    xp,
                    vp,
                    voltage: r.voltage.as_ref().map_or(f64::NAN, |v| v[k]),
                    since: r.time[k] - undisturbed[i].0,
                    miss_p: p[n],
                    miss_c: c[n],
                    white: (wp[n], wc[n]),
                    regime,
                }
            })
            .collect()
    };
    Ok(point
        .segments
        .par_iter()
        .enumerate()
        .flat_map_iter(one)
        .collect())
}

/// Residuals in units of `sigma`, decorrelated by the colour of the noise. Missing values stay
/// missing and do not enter the filter.
fn whitened(residuals: &[f64], sigma: f64, colour: &Colour) -> Vec<f64> {
    let mut present: Vec<f64> = residuals
        .iter()
        .filter(|m| m.is_finite())
        .map(|m| m / sigma)
        .collect();
    colour.whiten(&mut present);
    let mut present = present.into_iter();
    let back = |m: &f64| {
        if m.is_finite() {
            present.next().unwrap_or(f64::NAN)
        } else {
            f64::NAN
        }
    };
    residuals.iter().map(back).collect()
}

/// Regime of a mass in flight with velocity `vp` \[m/s\].
fn flight_regime(near_ground: bool, vp: f64) -> Regime {
    if !near_ground {
        Regime::FarFlight
    } else if vp < 0.0 {
        Regime::NearGroundApproach
    } else {
        Regime::NearGroundDeparture
    }
}

/// For each segment, when the event-free interval that it is part of began \[s\], and whether with
/// an event: a recording may begin within one.
pub(crate) fn event_free_since(problem: &Problem, segments: &[Segment]) -> Vec<(f64, bool)> {
    let mut out: Vec<(f64, bool)> = Vec::with_capacity(segments.len());
    for (i, s) in segments.iter().enumerate() {
        let own = problem.data[s.recording].recording.time[s.samples.start];
        let before = i.checked_sub(1).map(|k| (&segments[k], out[k]));
        out.push(match before {
            Some((b, began)) if b.recording == s.recording => {
                let goes_on = b.samples.end == s.samples.start && b.starts_held == s.starts_held;
                if goes_on { began } else { (own, true) }
            }
            _ => (own, false),
        });
    }
    out
}

/// Height of each recording below which the mass is near the ground \[m\].
pub(crate) fn near_ground_heights(problem: &Problem) -> Vec<f64> {
    let of = |data: &Data| {
        let mut x = data.recording.proof_mass.clone();
        x.retain(|x| x.is_finite());
        let low = quantile_in_place(&mut x, 0.002);
        low + NEAR_GROUND_SHARE * (quantile_in_place(&mut x, 0.998) - low)
    };
    problem.data.iter().map(of).collect()
}

/// Sum of squares and number of the finite values.
pub(crate) fn sum_of_squares(values: impl Iterator<Item = f64>) -> (f64, usize) {
    let (mut sum, mut n) = (0.0, 0);
    for v in values.filter(|v| v.is_finite()) {
        sum += v * v;
        n += 1;
    }
    (sum, n)
}

/// Rms residual of the proof mass, and chi2 per value of the fit.
pub fn distance(fitted: &Fitted, samples: &[Sample]) -> Distance {
    let (sum, n) = sum_of_squares(samples.iter().map(|s| s.miss_p));
    Distance {
        rms: (sum / n.max(1) as f64).sqrt(),
        chi2: fitted.cost / fitted.point.rows.max(1) as f64,
    }
}

/// Segments that differ by more than noise allows.
pub fn mismatches(fitted: &Fitted, samples: &[Sample]) -> Vec<Mismatch> {
    let mut out: Vec<(f64, Mismatch)> = Vec::new();
    let mut total = 0.0;
    let mut from = 0;
    while from < samples.len() {
        let key = |s: &Sample| (s.segment, s.regime);
        let len = samples[from..]
            .iter()
            .take_while(|s| key(s) == key(&samples[from]))
            .count();
        let group = &samples[from..from + len];
        from += len;
        for (channel, pick) in [("xp", 0), ("xc", 1)] {
            let values = group
                .iter()
                .map(|s| if pick == 0 { s.white.0 } else { s.white.1 });
            let (sum, n) = sum_of_squares(values);
            if n < 4 {
                continue;
            }
            let excess = sum - n as f64;
            total += excess.max(0.0);
            if excess > MISMATCH_MIN_Z * (2.0 * n as f64).sqrt() + MISMATCH_MIN_EXCESS * n as f64 {
                out.push((
                    excess,
                    Mismatch {
                        recording: fitted.problem.data[group[0].recording]
                            .recording
                            .name
                            .clone(),
                        start: group[0].time,
                        end: group[len - 1].time,
                        channel,
                        regime: group[0].regime,
                        share: 0.0,
                    },
                ));
            }
        }
    }
    out.sort_by(|a, b| b.0.total_cmp(&a.0));
    out.truncate(MAX_MISMATCHES);
    out.into_iter()
        .map(|(excess, m)| Mismatch {
            share: excess / total.max(1e-300),
            ..m
        })
        .collect()
}

/// Mean squares against each quantity, before and after.
pub fn marginals(before: &[Sample], after: &[Sample]) -> Vec<Marginal> {
    type Pick = fn(&Sample) -> f64;
    let picks: [(&'static str, &'static str, Pick); 4] = [
        ("xp", "m", |s| s.xp),
        ("xp'", "m/s", |s| s.vp),
        ("V", "V", |s| s.voltage),
        ("time since the last event", "s", |s| s.since),
    ];
    let mut out = Vec::new();
    for (against, unit, pick) in picks {
        let mut all: Vec<f64> = before.iter().map(pick).filter(|v| v.is_finite()).collect();
        if all.len() < 100 {
            continue;
        }
        let low = quantile_in_place(&mut all, 0.002);
        let high = quantile_in_place(&mut all, 0.998);
        if high <= low {
            continue;
        }
        let bins = |samples: &[Sample]| -> Vec<f64> {
            let mut sums = vec![(0.0, 0usize); MARGINAL_BINS];
            for s in samples {
                let at = (pick(s) - low) / (high - low) * MARGINAL_BINS as f64;
                if at >= 0.0 && at < MARGINAL_BINS as f64 {
                    let bin = &mut sums[at as usize];
                    for w in [s.white.0, s.white.1] {
                        if w.is_finite() {
                            bin.0 += w * w;
                            bin.1 += 1;
                        }
                    }
                }
            }
            let mean = |(sum, n): (f64, usize)| if n > 10 { sum / n as f64 } else { f64::NAN };
            sums.into_iter().map(mean).collect()
        };
        let width = (high - low) / MARGINAL_BINS as f64;
        out.push(Marginal {
            against,
            unit,
            at: (0..MARGINAL_BINS)
                .map(|i| low + (i as f64 + 0.5) * width)
                .collect(),
            before: bins(before),
            after: bins(after),
        });
    }
    out
}

/// How far the worst segments of each recording are above the typical one of all, in units of the
/// scatter expected by chance: the worst, and the worst that is not in the same place.
pub fn segment_excesses(fitted: &Fitted) -> Vec<(f64, f64)> {
    let mut worst = vec![(0.0, 0.0); fitted.problem.data.len()];
    let Ok(samples) = samples(fitted) else {
        return worst;
    };
    let mut all: Vec<(f64, f64, usize)> = Vec::new();
    for group in samples.chunk_by(|a, b| a.segment == b.segment) {
        let white = group.iter().flat_map(|s| [s.white.0, s.white.1]);
        let (sum, n) = sum_of_squares(white.map(|w| w.clamp(-6.0, 6.0)));
        // In a short contact the mass may still hop, too low to be resolved.
        let lands = group
            .last()
            .is_some_and(|s| s.regime == Regime::Contact && s.since < HOP_MAX_TIME);
        if n > 30 && !lands {
            all.push((sum / n as f64, n as f64, group[0].segment));
        }
    }
    let mut means: Vec<f64> = all.iter().map(|a| a.0).collect();
    let usual = quantile_in_place(&mut means, 0.5);
    let off = |(mean, n, _): &(f64, f64, usize)| {
        (mean - usual) / usual.max(f64::MIN_POSITIVE) * (0.5 * n).sqrt()
    };
    let mut deviations: Vec<f64> = all.iter().map(off).collect();
    // The scatter is measured on the segments themselves.
    let spread = quantile_in_place(&mut deviations, 0.84).max(1.0);
    all.sort_unstable_by(|a, b| off(b).total_cmp(&off(a)));
    for (k, worst) in worst.iter_mut().enumerate() {
        let mut own = all
            .iter()
            .filter(|a| fitted.point.segments[a.2].recording == k);
        let Some(first) = own.next() else { continue };
        let elsewhere = own.find(|a| a.2.abs_diff(first.2) > SAME_PLACE_SEGMENTS);
        let excess = |a: &(f64, f64, usize)| off(a).max(0.0) / spread;
        *worst = (excess(first), elsewhere.map_or(0.0, excess));
    }
    log::debug!("segments farthest off, in units of {spread:.2}: {worst:.1?}");
    worst
}
