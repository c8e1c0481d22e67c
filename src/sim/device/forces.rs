//! Forces: of the film, of effects, of the drive and of the base, and the pull-off force,
//! eq (13).

use super::{Attached, Device};
use crate::model::effects::Kinematics;
use crate::model::piezo::Branch;

impl Device {
    /// Acceleration of the base [m/s^2].
    pub fn base_acceleration(&self, t: f64) -> f64 {
        self.effects
            .iter()
            .map(|e| e.action.base_acceleration(t))
            .sum()
    }

    /// Lets the film grow no thinner than half of what it is at contact: a stretch that
    /// is not stopped by the ground may then reach below it.
    pub fn bound_film(&mut self) {
        if let (Some(film), Some(ground)) = (&self.film, &self.ground) {
            self.thinnest_film = 0.5 * (film.gap + ground.level);
        }
    }

    /// Film force on the proof mass \[N\].
    #[inline]
    pub fn film_force(&self, xp: f64, vp: f64) -> f64 {
        self.film.map_or(0.0, |film| {
            film.force(xp.max(self.thinnest_film - film.gap), vp)
        })
    }

    /// Impulse of the film force on the proof mass on its way from height `from` to `to`,
    /// however fast it goes and whatever turns it around in between \[N s\].
    pub fn film_impulse(&self, from: f64, to: f64) -> f64 {
        self.film.map_or(0.0, |film| {
            let all = |xp: f64| {
                let thickness = (xp + film.gap).max(self.thinnest_film);
                let below = (thickness - film.gap - xp).max(0.0);
                film.coefficient * (0.5 + below / thickness) / (thickness * thickness)
            };
            all(to) - all(from)
        })
    }

    /// Change of the film force per displacement and per velocity.
    #[inline]
    pub fn film_slopes(&self, xp: f64, vp: f64) -> (f64, f64) {
        self.film.map_or((0.0, 0.0), |film| {
            let thickness = (xp + film.gap).max(self.thinnest_film);
            let per_velocity = -film.coefficient / (thickness * thickness * thickness);
            let thins = xp + film.gap > self.thinnest_film;
            let per_height = -3.0 * per_velocity * vp / thickness;
            (if thins { per_height } else { 0.0 }, per_velocity)
        })
    }

    /// Whether the film is singular at `xp`.
    #[inline]
    pub fn is_inside_film(&self, xp: f64) -> bool {
        self.film.is_none_or(|film| {
            film.coefficient == 0.0 || self.thinnest_film > 0.0 || xp > -film.gap
        })
    }

    /// All effects' forces on the proof mass \[N\], but for friction and what they make of
    /// the film.
    pub fn effect_force(&self, at: &Kinematics, z: &[f64]) -> f64 {
        self.effects
            .iter()
            .map(|e| {
                e.action
                    .force_on_proof_mass(at, &z[e.first..e.first + e.count])
            })
            .sum()
    }

    /// Film force on the proof mass with what effects make of it \[N\].
    pub fn altered_film_force(&self, at: &Kinematics, z: &[f64]) -> f64 {
        self.effects.iter().fold(at.film, |film, e| {
            e.action.film_force(film, &z[e.first..e.first + e.count])
        })
    }

    /// What pulls the held mass besides structure and drive \[N\]: effects' forces, the
    /// film that they alter, and the base.
    pub fn force_on_held(&self, at: &Kinematics, z: &[f64]) -> f64 {
        if self.effects.is_empty() {
            return 0.0;
        }
        let film = self.altered_film_force(at, z);
        self.effect_force(at, z) + film - self.base_acceleration(at.t) / self.mobility
    }

    /// Voltage that the piezo film sees \[V\].
    pub(super) fn film_voltage(&self, at: &Kinematics, z: &[f64]) -> f64 {
        self.effects.iter().fold(at.voltage, |voltage, e| {
            let own = &z[e.first..e.first + e.count];
            e.action.drive_voltage(voltage, at, own)
        })
    }

    /// Force where the piezo drives the cantilever \[N\]; notes the gain in `at`.
    pub fn drive_force(&self, at: &mut Kinematics, branch: Branch, z: &[f64]) -> f64 {
        let Some(piezo) = self.piezo else {
            return 0.0;
        };
        let own = |e: &Attached| e.first..e.first + e.count;
        let voltage = self.film_voltage(at, z);
        let branches = piezo.gain(voltage, branch);
        let gain = self.effects.iter().fold(branches, |gain, e| {
            e.action.hysteresis(gain, voltage, branch, &z[own(e)])
        });
        at.gain = self
            .effects
            .iter()
            .fold(gain, |gain, e| e.action.drive_gain(gain, at, &z[own(e)]));
        self.eta * at.gain
    }

    /// Whether the drive's force is the same with extra states `a` and `b`, at one voltage and one
    /// time.
    pub fn drives_alike(&self, a: &[f64], b: &[f64]) -> bool {
        let mut own = self.drive_states.iter().cloned();
        own.all(|own| a[own.clone()] == b[own])
    }

    /// The piezo's force at a voltage \[N\], without effects.
    #[inline]
    pub fn piezo_force(&self, voltage: f64, branch: Branch) -> f64 {
        self.piezo
            .map_or(0.0, |piezo| self.eta * piezo.gain(voltage, branch))
    }

    /// Pull-off force, eq (13), of the held mass from held coordinates.
    #[inline]
    pub fn pull_held(&self, r: &[f64], dr: &[f64], level: f64, drive: f64, on_mass: f64) -> f64 {
        let mut pull = on_mass + self.pull.per_level * level + self.pull.per_drive * drive;
        for k in 0..r.len() {
            pull += self.pull.per_position[k] * r[k] + self.pull.per_velocity[k] * dr[k];
        }
        pull
    }

    /// Pull-off force per displacement \[N/(kg^1/2 m)\] and per velocity of a held coordinate.
    pub fn pull_per_motion(&self, mode: usize) -> (f64, f64) {
        (self.pull.per_position[mode], self.pull.per_velocity[mode])
    }

    /// Pull-off force, eq (13), as if the mass were held, from modal coordinates in flight.
    pub fn pull_flight(&self, q: &[f64], dq: &[f64], drive: f64, on_mass: f64) -> f64 {
        let structure: f64 = (0..q.len())
            .map(|i| {
                self.phi_p[i] * (self.flight[i].omega2 * q[i] + self.flight[i].damping * dq[i])
            })
            .sum();
        on_mass + self.pull.per_drive * drive - structure / self.mobility
    }
}
