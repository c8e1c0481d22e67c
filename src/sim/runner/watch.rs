//! What is noted of a run without samples: where the mass turns, how it arrives at the ground, and
//! on request what the forces do.

// The indices are those of the points of a step.
#![allow(clippy::needless_range_loop)]

use super::Runner;
use super::notes::{Arrival, Integrals, Notes, Turn};
use crate::model::MAX_MODES;
use crate::sim::device::dot;
use crate::sim::nodes::{NODES, S, gauss};

/// Above this many radians of the fastest mode a part of a step is integrated with the long rule.
const SHORT_PART_PHASE: f64 = 0.5;
/// Weights of the Lobatto points on [0, 1].
const LOBATTO_WEIGHTS: [f64; S] = [
    1.0 / 20.0,
    49.0 / 180.0,
    16.0 / 45.0,
    49.0 / 180.0,
    1.0 / 20.0,
];
/// Corrections of the instant of a turn; each squares its error.
const TURN_CORRECTIONS: usize = 3;
/// A turn is known within this share of a step: its displacement goes by the square.
const TURN_SHARE: f64 = 1e-7;

impl Runner {
    /// Takes notes from now on, with integrals of the forces if `integrals`.
    pub fn start_notes(&mut self, integrals: bool) {
        self.watch = Some(Box::new(Notes::new(integrals)));
    }

    /// The notes since the last call; others begin.
    pub fn take_notes(&mut self) -> Notes {
        let Some(notes) = &mut self.watch else {
            return Notes::new(false);
        };
        let fresh = Notes::new(notes.integrals.is_some());
        std::mem::replace(&mut **notes, fresh)
    }

    /// Ends the notes.
    pub fn stop_notes(&mut self) {
        self.watch = None;
    }

    /// Notes a step of flight up to fraction `s`.
    pub(super) fn note_flight(&mut self, h: f64, s: f64) {
        let Some(mut notes) = self.watch.take() else {
            return;
        };
        let step = &self.flight;
        let mut points = [(0.0, step.xp[0], step.vp[0]); S + 1];
        let mut count = 1;
        for k in 1..S {
            if NODES[k] < s || (k == S - 1 && s >= 1.0) {
                points[count] = (NODES[k], step.xp[k], step.vp[k]);
                count += 1;
            }
        }
        if s < 1.0 {
            let (x, v) = self.mass_at(s);
            points[count] = (s, x, v);
            count += 1;
        }
        let fastest = points[..count].iter().fold(0.0f64, |a, p| a.max(p.2.abs()));
        notes.fastest_since_arrival = notes.fastest_since_arrival.max(fastest);
        notes.top_speed = notes.top_speed.max(fastest);
        for pair in points[..count].windows(2) {
            let (from, to) = (pair[0].2, pair[1].2);
            let is_low = from < 0.0 && to >= 0.0;
            if is_low || (from > 0.0 && to <= 0.0) {
                let (at, displacement) = self.turn_between(pair[0], pair[1], h);
                notes.turns.push(Turn {
                    time: self.t + at * h,
                    displacement,
                    is_low,
                });
            }
        }
        if let Some(integrals) = &mut notes.integrals {
            self.integrate_flight(h, s, integrals);
        }
        self.watch = Some(notes);
    }

    /// Displacement and velocity of the mass at fraction `s` of the step of flight.
    fn mass_at(&self, s: f64) -> (f64, f64) {
        let (mut q, mut v) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        let n = self.q.len();
        self.flight.modal_at(s, &mut q[..n], &mut v[..n]);
        (
            dot(&self.device.phi_p, &q[..n]),
            dot(&self.device.phi_p, &v[..n]),
        )
    }

    /// Fraction of the step and displacement where the velocity changes sign between two points,
    /// each a fraction, a displacement and a velocity.
    fn turn_between(&self, low: (f64, f64, f64), high: (f64, f64, f64), h: f64) -> (f64, f64) {
        let (mut a, mut b) = ((low.0, low.2), (high.0, high.2));
        let mut at = hermite_turn(low, high, h);
        let mut displacement = low.1;
        for _ in 0..TURN_CORRECTIONS {
            let (x, v) = self.mass_at(at);
            displacement = x;
            if (v < 0.0) == (a.1 < 0.0) {
                a = (at, v);
            } else {
                b = (at, v);
            }
            let next = a.0 - a.1 * (b.0 - a.0) / (b.1 - a.1);
            let moved = (next - at).abs();
            if !next.is_finite() || moved < TURN_SHARE {
                // What is left of the way goes by the mean velocity, half of that here.
                return (at, x + 0.5 * v * (next - at) * h);
            }
            at = next;
        }
        (at, displacement)
    }

    /// Notes the arrival of the mass with velocity `v` [m/s]; see [`Arrival::decision_share`].
    pub(super) fn note_arrival(&mut self, v: f64, decision_share: f64) {
        let time = self.t;
        if let Some(notes) = &mut self.watch {
            notes.arrivals.push(Arrival {
                time,
                speed: v.abs(),
                fastest: notes.fastest_since_arrival.max(v.abs()),
                decision_share,
            });
            notes.fastest_since_arrival = 0.0;
        }
    }

    /// Notes a step with the mass held at `level` up to fraction `s`; on the ground since `since`
    /// \[s\], or held by friction. `freed` if it ended in a release.
    pub(super) fn note_held(
        &mut self,
        h: f64,
        s: f64,
        since: Option<f64>,
        level: f64,
        freed: bool,
    ) {
        let Some(mut notes) = self.watch.take() else {
            return;
        };
        if let (Some(since), false) = (since, freed) {
            for (node, pull) in NODES.iter().zip(&self.held.force) {
                let threshold = self.threshold(self.t + node * h - since, level);
                if *node <= s && threshold > 0.0 {
                    let share = (threshold - pull) / threshold;
                    notes.least_hold_share = notes.least_hold_share.min(share);
                }
            }
        }
        if let Some(integrals) = &mut notes.integrals {
            self.integrate_held(h, s, since, level, integrals);
        }
        self.watch = Some(notes);
    }

    /// Calls `of` with each fraction of a rule over `[0, s]` of a step, and its weight in time.
    fn quadrature(&self, h: f64, s: f64, held: bool, mut of: impl FnMut(f64, f64)) {
        let fastest = self.mode_omega2(held).fold(0.0, f64::max).sqrt();
        if fastest * s * h < SHORT_PART_PHASE {
            for (node, weight) in NODES.iter().zip(&LOBATTO_WEIGHTS) {
                of(node * s, weight * s * h);
            }
        } else {
            for (node, weight) in gauss() {
                of(node * s, weight * s * h);
            }
        }
    }

    fn integrate_flight(&self, h: f64, s: f64, sum: &mut Integrals) {
        let device = &self.device;
        let n = self.q.len();
        let (mut q, mut v) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        self.quadrature(h, s, false, |at, weight| {
            self.flight.modal_at(at, &mut q[..n], &mut v[..n]);
            let states = self.flight.states_at(at);
            let z = states.as_slice();
            let t = self.t + at * h;
            let voltage = self.segment.shape.voltage(t);
            let mut seen = device.flight_kinematics(t, voltage, &q[..n], &v[..n]);
            let drive = device.drive_force(&mut seen, self.segment.branch, z);
            let v = &v[..n];
            sum.drive_work += weight * drive * dot(&device.phi_d, v);
            sum.film_loss -= weight * device.altered_film_force(&seen, z) * seen.vp;
            for (mode, v) in device.flight.iter().zip(v) {
                sum.structure_loss += weight * mode.damping * v * v;
            }
            let base = device.base_acceleration(t) * dot(&device.flight_base, v);
            sum.effect_work += weight * (device.effect_force(&seen, z) * seen.vp + base);
            let friction = device.friction(seen.xp) * self.sliding;
            sum.friction_loss += weight * friction * seen.vp;
            let reaction = self.reaction(seen.xp, seen.vp, t);
            sum.ground_loss -= weight * reaction * seen.vp;
            sum.ground_impulse += weight * reaction;
            sum.displacement += weight * seen.xp;
        });
    }

    fn integrate_held(&self, h: f64, s: f64, since: Option<f64>, level: f64, sum: &mut Integrals) {
        let device = &self.device;
        let held = &device.held;
        let m = self.r.len();
        let (mut r, mut dr) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        self.quadrature(h, s, true, |at, weight| {
            self.held.modal_at(at, &mut r[..m], &mut dr[..m]);
            let (r, dr) = (&r[..m], &dr[..m]);
            let states = self.held.states_at(at);
            let z = states.as_slice();
            let t = self.t + at * h;
            let voltage = self.segment.shape.voltage(t);
            let mut seen = device.held_kinematics(t, voltage, level, r, dr);
            let drive = device.drive_force(&mut seen, self.segment.branch, z);
            sum.drive_work += weight * drive * dot(&held.drive, dr);
            for (i, mode) in device.held_modes.iter().enumerate() {
                let cross = match held.cross_damping.get(i * m..(i + 1) * m) {
                    Some(row) => dot(row, dr),
                    None => 0.0,
                };
                sum.structure_loss += weight * dr[i] * (mode.damping * dr[i] + cross);
            }
            sum.effect_work += weight * device.base_acceleration(t) * dot(&device.held_base, dr);
            let on_mass = device.force_on_held(&seen, z);
            let reaction = match since {
                Some(_) => -device.pull_held(r, dr, level, drive, on_mass),
                None => self.reaction(level, 0.0, t),
            };
            sum.ground_impulse += weight * reaction;
            sum.displacement += weight * level;
        });
    }
}

/// Fraction at which the cubic through two displacements with their velocities turns, between the
/// two points of a step of `h` \[s\].
fn hermite_turn(a: (f64, f64, f64), b: (f64, f64, f64), h: f64) -> f64 {
    let width = b.0 - a.0;
    let (va, vb) = (a.2 * width * h, b.2 * width * h);
    let rise = b.1 - a.1;
    // Slope of the cubic over u in [0, 1]: va + 2 (3 rise - 2 va - vb) u + 3 (va + vb - 2 rise) u^2.
    let (half, square) = (3.0 * rise - 2.0 * va - vb, 3.0 * (va + vb - 2.0 * rise));
    let root = (half * half - va * square).max(0.0).sqrt();
    // The root between the points, in the form that does not cancel.
    let candidates = [-va / (half + root), -va / (half - root)];
    let inside = candidates.into_iter().find(|u| (0.0..=1.0).contains(u));
    a.0 + width * inside.unwrap_or(va / (va - vb))
}
