//! One step: forces as polynomials through the Lobatto points, the linear structure's
//! answer exact, forces and answer iterated until they agree (exponential collocation).
//! Flight and held structure are both a [`Step`] over independent oscillators; they
//! differ in what forces act.

// The indices are those of the method's matrices; iterators would hide them.
#![allow(clippy::needless_range_loop)]

use std::sync::OnceLock;

use crate::model::MAX_MODES;
use crate::model::drive::Segment;

use super::crossing::first_below;
use super::device::{Device, dot};
use super::linear::{DecayPropagator, Oscillator, Propagator, Swing};
use super::nodes::{Dense, NODES, S, top_coefficient};

/// Finest step is the longest over 2 to this power.
pub(super) const LEVELS: usize = 48;

/// Propagators of all oscillators and decays for one step length.
#[derive(Debug, Clone)]
pub(super) struct Table {
    pub h: f64,
    modes: Vec<Propagator>,
    decays: Vec<DecayPropagator>,
    /// Proof mass per force on it and per drive force: `[displacement, velocity]`.
    p_from_p: [[[f64; S]; S - 1]; 2],
    p_from_d: [[[f64; S]; S - 1]; 2],
}

/// Tables for halved and halved again step lengths, made when first needed, and shared
/// by all threads that simulate the same device.
#[derive(Debug, Clone)]
pub(super) struct Tables {
    oscillators: Vec<Oscillator>,
    rates: Vec<f64>,
    phi_p: Vec<f64>,
    phi_d: Vec<f64>,
    lengths: [f64; LEVELS],
    levels: Vec<OnceLock<Box<Table>>>,
}

impl Tables {
    pub fn new(
        longest: f64,
        oscillators: &[Oscillator],
        rates: &[f64],
        phi_p: &[f64],
        phi_d: &[f64],
    ) -> Self {
        Self {
            lengths: std::array::from_fn(|level| longest * 0.5f64.powi(level as i32)),
            oscillators: oscillators.to_vec(),
            rates: rates.to_vec(),
            phi_p: phi_p.to_vec(),
            phi_d: phi_d.to_vec(),
            levels: vec![OnceLock::new(); LEVELS],
        }
    }

    /// Step length of a level [s].
    pub fn length(&self, level: usize) -> f64 {
        self.lengths[level]
    }

    fn get(&self, level: usize) -> &Table {
        let h = self.length(level);
        let (oscillators, rates) = (&self.oscillators, &self.rates);
        let (phi_p, phi_d) = (&self.phi_p, &self.phi_d);
        self.levels[level].get_or_init(|| {
            let modes: Vec<Propagator> =
                oscillators.iter().map(|&o| Propagator::new(o, h)).collect();
            let map = |of: &dyn Fn(&Propagator) -> [[f64; S]; S - 1], phi: &[f64]| {
                let mut sum = [[0.0; S]; S - 1];
                for (i, mode) in modes.iter().enumerate() {
                    let part = of(mode);
                    for k in 0..S - 1 {
                        for j in 0..S {
                            sum[k][j] += phi_p[i] * phi[i] * part[k][j];
                        }
                    }
                }
                sum
            };
            let both = |phi: &[f64]| [map(&|m| m.displacement, phi), map(&|m| m.velocity, phi)];
            Box::new(Table {
                h,
                p_from_p: both(phi_p),
                p_from_d: both(phi_d),
                decays: rates.iter().map(|&r| DecayPropagator::new(r, h)).collect(),
                modes,
            })
        })
    }
}

/// The film is singular on the way or the iteration does not settle: a shorter step
/// may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Reject;

/// Values of the extra states at one instant, without allocation.
#[derive(Debug, Clone, Copy)]
pub(super) struct StateValues {
    values: [f64; super::MAX_STATES],
    count: usize,
}

impl StateValues {
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

/// The mass in a compliant ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    /// Level at which the ground begins [m].
    pub level: f64,
    /// When contact began [s].
    pub since: f64,
}

/// Scratch of one step: everything at the five points. Row-major `[point][mode]`.
#[derive(Debug, Clone, Default)]
pub(super) struct Step {
    pub h: f64,
    /// Modal coordinates and velocities at the points.
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    /// Extra states at the points.
    pub z: Vec<f64>,
    /// Proof mass at the points.
    pub xp: [f64; S],
    pub vp: [f64; S],
    /// Forces at the points [N].
    pub force: [f64; S],
    pub drive: [f64; S],
    /// Acceleration of the base at the points [m/s^2].
    base: [f64; S],
    /// Direction in which the mass slides, which friction opposes: 1, -1, or 0.
    pub sliding: f64,
    /// Whether the mass of a step of flight is in a compliant ground.
    pub touch: Option<Touch>,
    inputs: Vec<f64>,
    rates: Vec<f64>,
    v_before: Vec<f64>,
    /// Force on each mode at the points, per unit modal mass.
    mode_force: Vec<[f64; S]>,
    /// Each mode's motion between the points.
    pub swings: Vec<Swing>,
    modes: usize,
    /// Estimated error of the step, as displacement of the proof mass [m].
    pub error: f64,
}

impl Step {
    /// Scratch for so many modes, and extra states that decay at `rates` [1/s].
    pub fn new(modes: usize, rates: &[f64]) -> Self {
        let states = rates.len();
        Self {
            rates: rates.to_vec(),
            q: vec![0.0; S * modes],
            v: vec![0.0; S * modes],
            z: vec![0.0; S * states],
            inputs: vec![0.0; S * states],
            v_before: vec![0.0; S * modes],
            mode_force: vec![[0.0; S]; modes],
            swings: vec![Swing::new(Oscillator::default(), 0.0, 0.0, 0.0, &[0.0; S]); modes],
            modes,
            ..Self::default()
        }
    }

    /// Modal coordinates at a point.
    pub fn q_at(&self, point: usize) -> &[f64] {
        &self.q[point * self.modes..(point + 1) * self.modes]
    }

    /// Modal velocities at a point.
    pub fn v_at(&self, point: usize) -> &[f64] {
        &self.v[point * self.modes..(point + 1) * self.modes]
    }

    /// Extra states at a point.
    pub fn z_at(&self, point: usize) -> &[f64] {
        let states = self.z.len() / S;
        &self.z[point * states..(point + 1) * states]
    }

    /// Extra states at fraction `s` of the step.
    pub fn states_at(&self, s: f64) -> StateValues {
        let count = self.rates.len();
        let mut values = [0.0; super::MAX_STATES];
        for (i, value) in values[..count].iter_mut().enumerate() {
            let input: [f64; S] = std::array::from_fn(|k| self.inputs[k * count + i]);
            *value = if self.rates[i] * self.h > super::linear::QUICK_DECAY {
                super::linear::decay_at(self.rates[i], self.h, self.z[i], &input, s)
            } else {
                let z: [f64; S] = std::array::from_fn(|k| self.z[k * count + i]);
                let slopes = std::array::from_fn(|k| input[k] - self.rates[i] * z[k]);
                Dense::new(&z, &slopes, self.h).value(s)
            };
        }
        StateValues { values, count }
    }

    /// Modal state at fraction `s` of the step, written to `q` and `v`.
    pub fn modal_at(&self, s: f64, q: &mut [f64], v: &mut [f64]) {
        let m = self.modes;
        for (i, swing) in self.swings.iter().enumerate() {
            let mut dense = if swing.fast {
                Dense::default()
            } else {
                Dense::new(
                    &std::array::from_fn(|k| self.q[k * m + i]),
                    &std::array::from_fn(|k| self.v[k * m + i]),
                    self.h,
                )
            };
            dense.add(1.0, &swing.particular);
            (q[i], v[i]) = dense.value_and_slope(s, self.h);
            if swing.fast {
                let (x, dx) = swing.free(s * self.h);
                q[i] += x;
                v[i] += dx;
            }
        }
    }

    /// Motion of a point of the structure over the step, but for the free motion of
    /// fast modes.
    pub fn smooth(&self, shape: &[f64]) -> Dense {
        let m = self.modes;
        let slow = |values: &[f64], k: usize| -> f64 {
            (0..m)
                .filter(|&i| !self.swings[i].fast)
                .map(|i| shape[i] * values[k * m + i])
                .sum()
        };
        let mut dense = if self.swings.iter().all(|swing| swing.fast) {
            Dense::default()
        } else {
            Dense::new(
                &std::array::from_fn(|k| slow(&self.q, k)),
                &std::array::from_fn(|k| slow(&self.v, k)),
                self.h,
            )
        };
        for (weight, swing) in shape.iter().zip(&self.swings) {
            dense.add(*weight, &swing.particular);
        }
        dense
    }

    /// Velocity of a point of the structure at fraction `s`; `smooth` is its motion but for
    /// the free motion of fast modes.
    pub fn velocity_at(&self, smooth: &Dense, shape: &[f64], s: f64) -> f64 {
        let fast = |(weight, swing): (&f64, &Swing)| {
            if swing.fast {
                weight * swing.free(s * self.h).1
            } else {
                0.0
            }
        };
        let free: f64 = shape.iter().zip(&self.swings).map(fast).sum();
        smooth.value_and_slope(s, self.h).1 + free
    }

    /// Free motion of the fast modes at a point of the structure at fraction `s`.
    pub fn fast_at(&self, shape: &[f64], s: f64) -> f64 {
        shape
            .iter()
            .zip(&self.swings)
            .filter(|(_, swing)| swing.fast)
            .map(|(weight, swing)| weight * swing.free(s * self.h).0)
            .sum()
    }

    /// Fraction of the step, up to `end`, at which the mass no longer slides the way it did;
    /// `shape` is the structure's at the mass.
    pub fn first_turn(&self, shape: &[f64], end: f64) -> Option<f64> {
        let smooth = self.smooth(shape);
        let fastest = self.vp.iter().fold(0.0f64, |a, v| a.max(v.abs()));
        let speed = |s: f64| self.sliding * self.velocity_at(&smooth, shape, s);
        first_below(speed, end, 1e-12 * fastest)
    }

    /// Pull-off force at fraction `s` of a held step from `t`, with the mass at `level`.
    pub fn held_pull(&self, device: &Device, segment: &Segment, t: f64, s: f64, level: f64) -> f64 {
        let (mut r, mut dr) = ([0.0; MAX_MODES], [0.0; MAX_MODES]);
        let (r, dr) = (&mut r[..self.modes], &mut dr[..self.modes]);
        self.modal_at(s, r, dr);
        let t = t + s * self.h;
        let voltage = segment.shape.voltage(t);
        let mut at = device.held_kinematics(t, voltage, level, r, dr);
        let states = self.states_at(s);
        let z = states.as_slice();
        let drive = device.drive_force(&mut at, segment.branch, z);
        device.pull_held(r, dr, level, drive, device.force_on_held(&at, z))
    }

    /// What the inputs of the extra states leave beyond the polynomial, as a share of the
    /// state and of the displacement: states have units of their own.
    fn state_error(&self) -> f64 {
        let states = self.z.len() / S;
        let size = self.xp.iter().fold(0.0f64, |a, x| a.max(x.abs()));
        let worst = (0..states).fold(0.0f64, |worst, i| {
            let input: [f64; S] = std::array::from_fn(|k| self.inputs[k * states + i]);
            let within = self.h.min(1.0 / self.rates[i].max(1e-300));
            let scale = (0..S).fold(0.0f64, |a, k| {
                a.max(self.z[k * states + i].abs())
                    .max(input[k].abs() * within)
            });
            let top = dot(top_coefficient(), &input).abs() * within;
            if top > 0.0 {
                worst.max(top / scale)
            } else {
                worst
            }
        });
        0.02 * worst * size
    }

    /// The same for the shaking of the base, whose acceleration acts like a force of that
    /// over the mobility.
    fn base_error(&self, device: &Device, growth: f64) -> f64 {
        0.02 * growth / device.mobility * dot(top_coefficient(), &self.base).abs()
    }

    /// Acceleration of the base at the points of a step from `t`.
    fn shake(&mut self, device: &Device, t: f64) {
        for k in 0..S {
            self.base[k] = device.base_acceleration(t + NODES[k] * self.h);
        }
    }

    /// Makes ready what dense output needs, once the forces have settled.
    fn settle(&mut self, table: &Table) {
        for i in 0..self.modes {
            let oscillator = table.modes[i].oscillator;
            self.swings[i] = Swing::new(
                oscillator,
                self.h,
                self.q[i],
                self.v[i],
                &self.mode_force[i],
            );
        }
    }

    fn start(&mut self, q: &[f64], v: &[f64], z: &[f64]) {
        self.q[..q.len()].copy_from_slice(q);
        self.v[..v.len()].copy_from_slice(v);
        self.z[..z.len()].copy_from_slice(z);
    }

    /// Free motion of all modes plus the answer to the forces at the points that
    /// `per_mode` gives for each.
    fn propagate(&mut self, table: &Table, per_mode: impl Fn(usize) -> [f64; S]) {
        let m = self.modes;
        for i in 0..m {
            let (q0, v0) = (self.q[i], self.v[i]);
            let force = per_mode(i);
            self.mode_force[i] = force;
            let mode = &table.modes[i];
            for k in 0..S - 1 {
                let e = &mode.state[k];
                self.q[(k + 1) * m + i] =
                    e[0] * q0 + e[1] * v0 + dot(&mode.displacement[k], &force);
                self.v[(k + 1) * m + i] = e[2] * q0 + e[3] * v0 + dot(&mode.velocity[k], &force);
            }
        }
    }

    fn propagate_states(&mut self, table: &Table) {
        let states = self.z.len() / S;
        for i in 0..states {
            let z0 = self.z[i];
            let decay = &table.decays[i];
            for k in 0..S - 1 {
                let mut z = decay.state[k] * z0;
                for j in 0..S {
                    z += decay.input[k][j] * self.inputs[j * states + i];
                }
                self.z[(k + 1) * states + i] = z;
            }
        }
    }

    /// Drive force at the points without effects; true if it is the same at all.
    fn plain_drive(&mut self, device: &Device, segment: &Segment, t: f64) -> bool {
        use crate::model::drive::Shape;
        if let Shape::Constant { voltage } = segment.shape {
            self.drive = [device.piezo_force(voltage, segment.branch); S];
            return true;
        }
        for (k, c) in NODES.iter().enumerate() {
            let voltage = segment.shape.voltage(t + c * self.h);
            self.drive[k] = device.piezo_force(voltage, segment.branch);
        }
        false
    }

    /// A step of flight from `(q, v, z)` at `t`.
    ///
    /// `tolerance` [m] bounds the iteration's remaining error; the discretisation's is
    /// left in `self.error` for the caller to judge.
    #[allow(clippy::too_many_arguments)]
    pub fn flight(
        &mut self,
        device: &Device,
        tables: &Tables,
        level: usize,
        segment: &Segment,
        t: f64,
        state: (&[f64], &[f64], &[f64]),
        tolerance: f64,
    ) -> Result<(), Reject> {
        let table = tables.get(level);
        self.h = table.h;
        let (q0, v0, z0) = state;
        self.start(q0, v0, z0);
        let growth = device.mobility * table.h * device.time_scale.max(table.h);
        if device.has_effects() {
            self.flight_with_effects(device, table, segment, t, tolerance / growth)?;
        } else {
            self.flight_plain(device, table, segment, t, tolerance / growth)?;
        }
        self.settle(table);
        let top = dot(top_coefficient(), &self.force).abs();
        let drive_top = dot(top_coefficient(), &self.drive).abs();
        // A residual Legendre part of degree 4 moves the end by a small share of its
        // size: its mean over the step is zero.
        self.error = 0.02 * growth * (top + drive_top * device.drive_ratio);
        self.error += self.state_error() + self.base_error(device, growth);
        if self.error.is_finite() && self.xp.iter().all(|x| device.is_inside_film(*x)) {
            Ok(())
        } else {
            Err(Reject)
        }
    }

    fn flight_plain(
        &mut self,
        device: &Device,
        table: &Table,
        segment: &Segment,
        t: f64,
        force_tolerance: f64,
    ) -> Result<(), Reject> {
        let constant = self.plain_drive(device, segment, t);
        let m = self.modes;
        self.xp[0] = dot(&device.phi_p, self.q_at(0));
        self.vp[0] = dot(&device.phi_p, self.v_at(0));
        // Motion of the proof mass without force on it.
        let (mut base_x, mut base_v) = ([0.0; S - 1], [0.0; S - 1]);
        for k in 0..S - 1 {
            for i in 0..m {
                let e = &table.modes[i].state[k];
                base_x[k] += device.phi_p[i] * (e[0] * self.q[i] + e[1] * self.v[i]);
                base_v[k] += device.phi_p[i] * (e[2] * self.q[i] + e[3] * self.v[i]);
            }
            let (wx, wv) = (&table.p_from_d[0][k], &table.p_from_d[1][k]);
            if constant {
                base_x[k] += self.drive[0] * wx.iter().sum::<f64>();
                base_v[k] += self.drive[0] * wv.iter().sum::<f64>();
            } else {
                base_x[k] += dot(wx, &self.drive);
                base_v[k] += dot(wv, &self.drive);
            }
        }
        self.force = [device.film_force(self.xp[0], self.vp[0]); S];
        let mut previous = f64::INFINITY;
        let mut settled = false;
        for sweep in 0..24 {
            for k in 0..S - 1 {
                self.xp[k + 1] = base_x[k] + dot(&table.p_from_p[0][k], &self.force);
                self.vp[k + 1] = base_v[k] + dot(&table.p_from_p[1][k], &self.force);
            }
            let mut residual = [0.0; S - 1];
            let mut change = 0.0f64;
            for k in 0..S - 1 {
                if !device.is_inside_film(self.xp[k + 1]) {
                    return Err(Reject);
                }
                residual[k] = device.film_force(self.xp[k + 1], self.vp[k + 1]) - self.force[k + 1];
                change = change.max(residual[k].abs());
            }
            if !change.is_finite() {
                return Err(Reject);
            }
            if change > 0.3 * previous && change > force_tolerance {
                // The film is stiff over this step: Newton's method instead.
                self.newton(device, table, &mut residual);
            }
            for k in 0..S - 1 {
                self.force[k + 1] += residual[k];
            }
            if change <= 0.02 * force_tolerance
                || change <= 4.0 * f64::EPSILON * self.force[0].abs()
            {
                settled = true;
                break;
            }
            if sweep > 1 && change > 10.0 * previous {
                return Err(Reject);
            }
            previous = change;
        }
        if !settled {
            return Err(Reject);
        }
        let (force, drive) = (self.force, self.drive);
        self.propagate(table, |i| {
            std::array::from_fn(|j| device.phi_p[i] * force[j] + device.phi_d[i] * drive[j])
        });
        Ok(())
    }

    /// Turns the residual of the film force at the points into the Newton correction.
    fn newton(&self, device: &Device, table: &Table, residual: &mut [f64; S - 1]) {
        const N: usize = S - 1;
        let mut a = [[0.0; N]; N];
        for k in 0..N {
            let (mut dx, mut dv) = if device.film_is_plain {
                device.film_slopes(self.xp[k + 1], self.vp[k + 1])
            } else {
                (0.0, 0.0)
            };
            if let Some(touch) = self.touch {
                let depth = touch.level - self.xp[k + 1];
                let ground = device.contact_slopes(depth, -self.vp[k + 1]);
                (dx, dv) = (dx + ground.0, dv + ground.1);
            }
            for j in 0..N {
                a[k][j] = -dx * table.p_from_p[0][k][j + 1] - dv * table.p_from_p[1][k][j + 1];
            }
            a[k][k] += 1.0;
        }
        // Elimination with row pivoting; a singular system leaves a non-finite
        // correction, which the caller rejects.
        for i in 0..N {
            let pivot = (i..N)
                .max_by(|&x, &y| a[x][i].abs().total_cmp(&a[y][i].abs()))
                .unwrap_or(i);
            a.swap(i, pivot);
            residual.swap(i, pivot);
            for r in i + 1..N {
                let factor = a[r][i] / a[i][i];
                for c in i..N {
                    a[r][c] -= factor * a[i][c];
                }
                residual[r] -= factor * residual[i];
            }
        }
        for i in (0..N).rev() {
            for c in i + 1..N {
                residual[i] -= a[i][c] * residual[c];
            }
            residual[i] /= a[i][i];
        }
    }

    fn flight_with_effects(
        &mut self,
        device: &Device,
        table: &Table,
        segment: &Segment,
        t: f64,
        force_tolerance: f64,
    ) -> Result<(), Reject> {
        let mut residual = [0.0; S];
        self.shake(device, t);
        self.evaluate(device, segment, t, 0..1, None, &mut residual);
        self.force = [residual[0]; S];
        self.drive = [self.drive[0]; S];
        let states = self.z.len() / S;
        for k in 1..S {
            self.inputs.copy_within(0..states, k * states);
        }
        // Forces and states settle in turn: every other change may be far smaller.
        let (mut previous, mut older) = (f64::INFINITY, f64::INFINITY);
        for sweep in 0..40 {
            let (force, drive, base) = (self.force, self.drive, self.base);
            self.propagate(table, |i| {
                std::array::from_fn(|j| {
                    device.phi_p[i] * force[j]
                        + device.phi_d[i] * drive[j]
                        + device.flight_base[i] * base[j]
                })
            });
            self.propagate_states(table);
            self.evaluate(device, segment, t, 1..S, None, &mut residual);
            let mut change = 0.0f64;
            for k in 1..S {
                if !device.is_inside_film(self.xp[k]) {
                    return Err(Reject);
                }
                residual[k] -= force[k];
                change = change
                    .max(residual[k].abs())
                    .max((self.drive[k] - drive[k]).abs() * device.drive_ratio);
            }
            if !change.is_finite() {
                return Err(Reject);
            }
            let mut correction: [f64; S - 1] = std::array::from_fn(|k| residual[k + 1]);
            if change > 0.3 * previous && change > force_tolerance {
                self.newton(device, table, &mut correction);
            }
            for k in 0..S - 1 {
                self.force[k + 1] += correction[k];
            }
            let size = self.force[0].abs().max(self.drive[0].abs());
            if change <= 0.02 * force_tolerance || change <= 8.0 * f64::EPSILON * size {
                // States that nothing feels are not judged by the forces.
                self.propagate_states(table);
                return Ok(());
            }
            if sweep > 1 && change > 10.0 * previous.max(older) {
                return Err(Reject);
            }
            (older, previous) = (previous, change);
        }
        Err(Reject)
    }

    /// Forces with effects at some of the points: on the mass into `force`, the drive's
    /// and the inputs of the extra states in place. Held at `ground`, or in flight.
    fn evaluate(
        &mut self,
        device: &Device,
        segment: &Segment,
        t: f64,
        points: std::ops::Range<usize>,
        ground: Option<f64>,
        force: &mut [f64; S],
    ) {
        let states = self.z.len() / S;
        for k in points {
            let (q, v) = (self.q_at(k), self.v_at(k));
            let t = t + NODES[k] * self.h;
            let voltage = segment.shape.voltage(t);
            let mut at = match ground {
                Some(ground) => device.held_kinematics(t, voltage, ground, q, v),
                None => device.flight_kinematics(t, voltage, q, v),
            };
            let z = &self.z[k * states..(k + 1) * states];
            force[k] = if ground.is_some() {
                device.force_on_held(&at, z)
            } else {
                let force = device.effect_force(&at, z) + device.altered_film_force(&at, z);
                force - device.friction * self.sliding
                    + self.touch.map_or(0.0, |touch| {
                        device.contact_force(touch.level - at.xp, -at.vp, t - touch.since)
                    })
            };
            self.drive[k] = device.drive_force(&mut at, segment.branch, z);
            (self.xp[k], self.vp[k]) = (at.xp, at.vp);
            device.state_inputs(&at, z, &mut self.inputs[k * states..(k + 1) * states]);
        }
    }

    /// A step with the proof mass held at `level` [m]. `q`, `v` are held coordinates.
    #[allow(clippy::too_many_arguments)]
    pub fn held(
        &mut self,
        device: &Device,
        tables: &Tables,
        level: usize,
        segment: &Segment,
        t: f64,
        state: (&[f64], &[f64], &[f64]),
        ground: f64,
        tolerance: f64,
    ) -> Result<(), Reject> {
        let table = tables.get(level);
        self.h = table.h;
        let (q0, v0, z0) = state;
        self.start(q0, v0, z0);
        let m = self.modes;
        let states = self.z.len() / S;
        let held = &device.held;
        let effects = device.has_effects();
        if effects {
            self.shake(device, t);
        } else {
            self.plain_drive(device, segment, t);
        }
        for k in 1..S {
            self.q.copy_within(0..m, k * m);
            self.v.copy_within(0..m, k * m);
            self.z.copy_within(0..states, k * states);
        }
        let growth = device.mobility * table.h * device.time_scale.max(table.h);
        // Without effects and damping between modes the first answer is exact.
        let sweeps = if effects || m > 1 { 40 } else { 1 };
        let mut on_mass = [0.0; S];
        let mut previous = [f64::INFINITY; S];
        for sweep in 0..=sweeps {
            if effects {
                self.evaluate(device, segment, t, 0..S, Some(ground), &mut on_mass);
            }
            let (drive, base) = (self.drive, self.base);
            self.v_before.copy_from_slice(&self.v);
            let v_before = std::mem::take(&mut self.v_before);
            self.propagate(table, |i| {
                std::array::from_fn(|j| {
                    let row = i * m..(i + 1) * m;
                    let cross = dot(&held.cross_damping[row], &v_before[j * m..(j + 1) * m]);
                    let shaken = if effects {
                        device.held_base[i] * base[j]
                    } else {
                        0.0
                    };
                    held.drive[i] * drive[j] + held.level_force[i] * ground + shaken - cross
                })
            });
            self.v_before = v_before;
            self.propagate_states(table);
            let pull: [f64; S] = std::array::from_fn(|k| {
                device.pull_held(
                    self.q_at(k),
                    self.v_at(k),
                    ground,
                    self.drive[k],
                    on_mass[k],
                )
            });
            let change = (0..S)
                .map(|k| (pull[k] - previous[k]).abs())
                .fold(0.0, f64::max);
            previous = pull;
            if sweeps == 1 || change * growth <= 0.02 * tolerance || change <= 1e-14 * pull[0].abs()
            {
                break;
            }
            if sweep == sweeps {
                return Err(Reject);
            }
        }
        self.settle(table);
        self.force = previous;
        let drive_top = dot(top_coefficient(), &self.drive).abs();
        self.error = 0.02 * growth * drive_top * device.drive_ratio;
        self.error += self.state_error() + self.base_error(device, growth);
        if self.error.is_finite() && self.q.iter().all(|q| q.is_finite()) {
            Ok(())
        } else {
            Err(Reject)
        }
    }
}
