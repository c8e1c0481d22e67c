//! One step: forces as polynomials through the Lobatto points, the linear structure's
//! answer exact, forces and answer iterated until they agree (exponential collocation).
//! Flight and held structure are both a [`Step`] over independent oscillators; they
//! differ in what forces act.

// The indices are those of the method's matrices; iterators would hide them.
#![allow(clippy::needless_range_loop)]

mod contact_step;
mod dense;
mod effects;
mod elimination;
mod flight;
mod follow_readings;
mod readings;
mod stick_slip;
pub(crate) mod tables;

use self::elimination::eliminate;
use self::readings::Readings;
use self::tables::Table;
use super::device::{Device, dot};
use super::linear::{Oscillator, Swing};
use super::nodes::{NODES, S, top_coefficient};
use crate::model::drive::Segment;
use crate::model::effects::Kinematics;

/// The step cannot be taken: the film becomes singular within it, or the iteration does not
/// converge. A shorter step may work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Reject;

/// Error of a force's mean over a step, as a share of its highest polynomial coefficient, where
/// the five points resolve the force. The highest polynomial itself has a mean of zero.
const RESOLVED_FORCE_ERROR: f64 = 0.02;
/// The same where a mode vibrates through periods between the points. Averaged over the phase,
/// five points of a vibration give a highest coefficient of 0.63 and a mean of 0.37 times its
/// amplitude (rms), hence 0.37 / 0.63.
const UNRESOLVED_FORCE_ERROR: f64 = 0.6;
/// An extra state below this share of its largest value counts as decayed: its further decay
/// does not matter.
const NEGLIGIBLE_STATE_SHARE: f64 = 1e-3;

/// The mass in a compliant ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    /// Level at which the ground begins \[m\].
    pub level: f64,
    /// When contact began \[s\].
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
    /// Forces at the points \[N\].
    pub force: [f64; S],
    pub drive: [f64; S],
    /// Acceleration of the base at the points [m/s^2].
    base: [f64; S],
    /// Voltage of the drive at the points \[V\].
    voltage: [f64; S],
    /// What effects see at the points.
    seen: [Kinematics; S],
    /// Extra states with which the drive's force was computed last, and its gain; `None` at points
    /// where it is not computed yet.
    drive_states: Vec<f64>,
    drive_gain: [Option<f64>; S],
    /// Direction in which the mass slides, which friction opposes: 1, -1, or 0.
    pub sliding: f64,
    /// Whether the mass of a step of flight is in a compliant ground.
    pub touch: Option<Touch>,
    inputs: Vec<f64>,
    /// The part of each input that is proportional to its own state [1/s]. A state that decays
    /// more slowly than its nominal rate gets the difference back through this input.
    back: Vec<f64>,
    /// Largest size of each extra state at the beginnings of steps, since [`Step::forget`].
    largest: Vec<f64>,
    rates: Vec<f64>,
    v_before: Vec<f64>,
    readings: Readings,
    /// Force on each mode at the points, per unit modal mass.
    mode_force: Vec<[f64; S]>,
    /// Each mode's motion between the points.
    pub swings: Vec<Swing>,
    modes: usize,
    /// Rounds in which forces and motion of the latest step were brought to agree.
    pub sweeps: u32,
    /// Estimated error of the step, as displacement of the proof mass \[m\].
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
            drive_states: vec![0.0; S * states],
            inputs: vec![0.0; S * states],
            back: vec![0.0; S * states],
            largest: vec![0.0; states],
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

    /// Error from the extra states, as displacement of the proof mass \[m\]: what their inputs
    /// leave beyond the polynomial. For a force on the mass it is the displacement that this
    /// causes while it lasts (`growth` \[m/N\] over a whole step), times the share `mean`. For a
    /// reading it is that displacement itself. Other states have units of their own: there it
    /// is a share of the state, applied to the displacement.
    fn state_error(&self, device: &Device, growth: f64, mean: f64) -> f64 {
        let states = self.z.len() / S;
        let size = self.xp.iter().fold(0.0f64, |a, x| a.max(x.abs()));
        (0..states).fold(0.0f64, |worst, i| {
            let input: [f64; S] = std::array::from_fn(|k| self.inputs[k * states + i]);
            if let Some(error) = self.reading_error(i, &input) {
                return worst.max(RESOLVED_FORCE_ERROR * error);
            }
            // A state that decays more slowly than its rate lasts longer.
            let back = (0..S).fold(0.0f64, |a, k| a.max(self.back[k * states + i]));
            let lasts = 1.0 / (self.rates[i] - back).max(1e-300);
            let within = self.h.min(lasts);
            let top = dot(top_coefficient(), &input).abs() * within;
            if top == 0.0 {
                return worst;
            }
            if device.force_states[i] {
                // With a rate that changes, the error of a force has a mean, too.
                let mean = if back > 0.0 {
                    UNRESOLVED_FORCE_ERROR
                } else {
                    mean
                };
                return worst.max(mean * growth * top * (lasts / self.h).max(1.0));
            }
            let scale = (0..S).fold(NEGLIGIBLE_STATE_SHARE * self.largest[i], |a, k| {
                a.max(self.z[k * states + i].abs())
                    .max(input[k].abs() * within)
            });
            worst.max(RESOLVED_FORCE_ERROR * size * top / scale)
        })
    }

    /// The same for the vibration of the base: its acceleration acts like a force of that
    /// acceleration over the mobility.
    fn base_error(&self, device: &Device, growth: f64) -> f64 {
        RESOLVED_FORCE_ERROR * growth / device.mobility * dot(top_coefficient(), &self.base).abs()
    }

    /// Prepares dense output once the forces have converged.
    fn settle(&mut self, table: &Table) {
        for i in 0..self.modes {
            self.swings[i] = table.modes[i].swing(self.q[i], self.v[i], &self.mode_force[i]);
        }
    }

    /// Starts from `(q, v, z)`; returns by how much a force over the step moves the mass
    /// \[m/N\].
    fn start(&mut self, device: &Device, table: &Table, state: (&[f64], &[f64], &[f64])) -> f64 {
        let (q, v, z) = state;
        self.sweeps = 0;
        self.h = table.h;
        self.q[..q.len()].copy_from_slice(q);
        self.v[..v.len()].copy_from_slice(v);
        self.z[..z.len()].copy_from_slice(z);
        for (largest, z) in self.largest.iter_mut().zip(z) {
            *largest = largest.max(z.abs());
        }
        device.mobility * table.h * device.time_scale.max(table.h)
    }

    /// Forgets how large the extra states were: what follows is another motion.
    pub fn forget(&mut self) {
        self.largest.fill(0.0);
    }

    /// Free motion of all modes plus the response to the forces at the points that `per_mode`
    /// gives for each.
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

    /// Whether a state is constant over the step: a memory changes only between pieces.
    fn keeps(&self, i: usize) -> bool {
        let states = self.rates.len();
        self.rates[i] == 0.0 && (0..S).all(|k| self.inputs[k * states + i] == 0.0)
    }

    fn propagate_states(&mut self, table: &Table) {
        let states = self.z.len() / S;
        for i in 0..states {
            let z0 = self.z[i];
            if self.keeps(i) {
                (1..S).for_each(|k| self.z[k * states + i] = z0);
                continue;
            }
            let decay = &table.decays[i];
            let mut z: [f64; S - 1] = std::array::from_fn(|k| {
                let mut z = decay.state[k] * z0;
                for j in 0..S {
                    z += decay.input[k][j] * self.inputs[j * states + i];
                }
                z
            });
            let at = |k: usize| (k + 1) * states + i;
            if (0..S - 1).any(|k| self.back[at(k)] != 0.0) {
                // The inputs depend on the states that they drive: solve for both together.
                let back: [f64; S - 1] = std::array::from_fn(|k| self.back[at(k)]);
                let mut own = [[0.0; S - 1]; S - 1];
                for k in 0..S - 1 {
                    own[k] = std::array::from_fn(|j| -decay.input[k][j + 1] * back[j]);
                    own[k][k] += 1.0;
                    z[k] -= self.z[at(k)];
                }
                eliminate(&mut own, &mut z);
                for k in 0..S - 1 {
                    self.inputs[at(k)] += back[k] * z[k];
                    z[k] += self.z[at(k)];
                }
            }
            (0..S - 1).for_each(|k| self.z[at(k)] = z[k]);
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
}
