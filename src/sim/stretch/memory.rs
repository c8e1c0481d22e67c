//! States that the drive leaves behind: at rest under it, and the effects' extra states
//! over all of it.

use super::{Points, StretchSimulator, StretchState, segment_at};
use crate::model::drive::Segment;
use crate::model::effects::Kinematics;

/// A decaying state is forgotten after so many of its time constants.
const FORGETTING_TIMES: f64 = 15.0;
/// Largest step over the shortest time constant.
const MAX_STEP_SHARE: f64 = 0.2;
/// Longest step \[s\].
const MAX_STEP: f64 = 2e-4;
/// Longest step of states that depend on the motion, which turns within a tenth of a
/// millisecond \[s\].
const MAX_STEP_WITH_MOTION: f64 = 1e-5;
/// Shortest step \[s\].
const MIN_STEP: f64 = 2e-6;

impl StretchSimulator {
    /// The static state under the drive at `t`: where the modes come to rest, the extra
    /// states too. In flight, or held at a level \[m\]. A free mass stays at zero.
    pub fn rest_state(&self, drive: &[Segment], t: f64, held: Option<f64>) -> StretchState {
        let d = &self.device;
        let segment = segment_at(drive, t);
        let voltage = segment.shape.voltage(t);
        let mut at = Kinematics {
            t,
            voltage,
            ..Kinematics::default()
        };
        let z = d.settled_states(&at);
        let force = d.drive_force(&mut at, segment.branch, &z);
        let q: Vec<f64> = match held {
            None => (0..d.flight.len())
                .map(|i| (d.phi_d[i] * force, d.flight[i].omega2))
                .map(|(f, k)| if k > 0.0 { f / k } else { 0.0 })
                .collect(),
            Some(level) => (0..d.held_modes.len())
                .map(|k| {
                    (d.held.drive[k] * force + d.held.level_force[k] * level)
                        / d.held_modes[k].omega2
                })
                .collect(),
        };
        StretchState {
            v: vec![0.0; q.len()],
            q,
            z,
        }
    }

    /// The effects' extra states over the whole drive, from its first instant on, at
    /// increasing `times` \[s\]; row-major `[time][state]`. `motion` gives the points'
    /// displacements and velocities where they matter, from the data or zero. States that are
    /// readings are for recordings to tell: here they are not followed.
    pub fn states_from_drive(
        &self,
        drive: &[Segment],
        times: &[f64],
        motion: &dyn Fn(f64) -> Points,
    ) -> Vec<f64> {
        let d = &self.device;
        let count = d.rates.len();
        let mut out = Vec::with_capacity(times.len() * count);
        let Some(&first) = times.first().filter(|_| count > 0) else {
            return out;
        };
        let begin = drive
            .first()
            .map_or(first, |s| if s.start.is_finite() { s.start } else { s.end })
            .min(first);
        let mut t = begin;
        let mut z = self.rest_state(drive, begin, None).z;
        let mut u = vec![0.0; count];
        let mut rates = d.rates.clone();
        // A quicker state than the shortest step is where its input has been all along it.
        // Powers of two: two devices whose rates differ by a hair are followed in the same
        // steps, each choice of which has an error of its own.
        let longest = |of_all: bool, most: f64| {
            let step = (MAX_STEP_SHARE / d.fastest_rate(of_all).max(1.0)).clamp(MIN_STEP, most);
            step.log2().floor().exp2()
        };
        let (without_motion, with_motion) = (
            longest(false, MAX_STEP),
            longest(true, MAX_STEP_WITH_MOTION),
        );
        // What decays is forgotten, unless an effect keeps a memory of its own.
        let memory = |slowest: f64, step: f64| {
            if slowest > 0.0 {
                (FORGETTING_TIMES / slowest / step).log2().ceil().exp2() * step
            } else {
                f64::INFINITY
            }
        };
        let feeling = d.feeling_rate();
        let all = memory(
            d.slowest_rate(),
            feeling.map_or(without_motion, |_| with_motion),
        );
        // The motion matters no longer ago than what feels it remembers.
        let recent = feeling.map_or(f64::NEG_INFINITY, |rate| memory(rate, with_motion));
        let mut before = None;
        for &target in times {
            if target - t > all {
                t = target - all;
                before = None;
            }
            let near = target - recent;
            while t < target {
                let segment = d.piece(segment_at(drive, t), t, &z);
                let feels = t >= near;
                let step = if feels { with_motion } else { without_motion };
                let turn = if feels { target } else { target.min(near) };
                let end = turn.min(segment.end).min(t + step).max(t + 1e-12);
                let h = end - t;
                let middle = t + 0.5 * h;
                let (from, after) = if feels {
                    (before.unwrap_or_else(|| motion(t)), motion(end))
                } else {
                    (Points::default(), Points::default())
                };
                before = feels.then_some(after);
                let mean = |a: f64, b: f64| 0.5 * (a + b);
                let mut at = Kinematics {
                    t: middle,
                    xp: mean(from.xp, after.xp),
                    vp: mean(from.vp, after.vp),
                    xc: mean(from.xc, after.xc),
                    vc: mean(from.vc, after.vc),
                    voltage: segment.shape.voltage(middle),
                    gain: 0.0,
                    // What the film does before a blow it all but takes back after it: only
                    // where the mass is tells what remains.
                    film: d.film_impulse(from.xp, after.xp) / h,
                };
                d.drive_force(&mut at, segment.branch, &z);
                d.state_inputs(&at, &z, &mut u);
                rates.copy_from_slice(&d.rates);
                d.paces(&at, |i, pace| {
                    rates[i] *= pace;
                    u[i] *= pace;
                });
                decay(&mut z, &u, &rates, h);
                t = end;
                if t >= segment.end {
                    d.end_piece(&segment, t, &mut z);
                }
            }
            out.extend_from_slice(&z);
        }
        out
    }
}

/// Advances states by `h` \[s\] under `z' = -rate z + u` with constant inputs: exact.
fn decay(z: &mut [f64], inputs: &[f64], rates: &[f64], h: f64) {
    for ((z, u), rate) in z.iter_mut().zip(inputs).zip(rates) {
        let decay = (-rate * h).exp();
        let gain = if *rate > 0.0 {
            -(-rate * h).exp_m1() / rate
        } else {
            h
        };
        *z = *z * decay + u * gain;
    }
}
