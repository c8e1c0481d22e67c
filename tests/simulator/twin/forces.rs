//! Forces, and the rates of the state that follow from them.

use std::f64::consts::TAU;

use super::{DP, Machine, Memory, PLAYS, Phase, State};

const ETA: f64 = 3.819e-7;
const CS: f64 = 1.747e-21;
const GP: f64 = 70e-6;
const CA: f64 = 1.7e-6;
const CA0: f64 = 0.02743e-6;

fn branch(volt: f64, rising: bool) -> f64 {
    if rising {
        0.0016 * volt.powi(3) - 0.0255 * volt * volt - 0.7057 * volt + 1.4796
    } else {
        0.0076 * volt * volt - 0.6062 * volt - 0.6350
    }
}

/// Half width of a play operator; no voltage exceeds the widest.
pub(super) fn width_of(i: usize) -> f64 {
    (i as f64 + 0.5) * 10.0 / PLAYS as f64
}

impl Machine<'_> {
    /// gc and the voltage of the film.
    fn gain(&self, t: f64, s: &State) -> f64 {
        let Some(rising) = self.piece.rising else {
            return self.creep(s);
        };
        let volt = if self.e().amplifier_tau > 0.0 {
            s[6]
        } else {
            self.piece.voltage(t)
        };
        let Memory {
            share,
            width,
            reference,
            middle: (bend, twist),
            ..
        } = self.e().memory;
        let mut gc = branch(volt, rising);
        if share > 0.0 {
            let own = bend * (volt / reference).powi(2) + twist * (volt / reference).powi(3);
            let mean = 0.5 * (branch(volt, true) + branch(volt, false)) + own;
            let half = 0.5 * (1.4796 + 0.6350);
            gc += share * (mean + width * half * self.loops(volt) - gc);
        }
        gc + self.creep(s)
    }

    /// What creep adds to gc.
    fn creep(&self, s: &State) -> f64 {
        let [own, further] = self.e().creep;
        own.0 * s[7] + further.0 * s[11]
    }

    /// The plays' sum below the middle of its own cycle between plus and minus the reference,
    /// over half the height of that cycle at 0 V.
    fn loops(&self, volt: f64) -> f64 {
        let Memory {
            reference, q, k, ..
        } = self.e().memory;
        let (mut sum, mut height) = (0.0, 0.0);
        for i in 0..PLAYS {
            let r = width_of(i);
            let weight = (-0.5 * (q * r).powi(2)).exp() * (1.0 + k * r / reference);
            let mut middle = 0.0;
            if r < reference {
                let rising = (volt - r).max(r - reference);
                let falling = (volt + r).min(reference - r);
                middle = 0.5 * (rising + falling);
                height += weight * r.min(reference - r);
            }
            sum += weight * (middle - self.play(i, volt));
        }
        sum / height
    }

    pub(super) fn play(&self, i: usize, volt: f64) -> f64 {
        let r = width_of(i);
        self.plays[i].clamp(volt - r, volt + r)
    }

    fn reaction(&self, t: f64, xp: f64, vp: f64) -> f64 {
        let (k, chi) = self.e().ground;
        self.touch.map_or(0.0, |since| {
            let depth = (self.level(t) - xp).max(0.0);
            k * depth.powf(1.5) * (1.0 - chi * vp) - self.adhesion(t - since)
        })
    }

    pub(super) fn adhesion(&self, time: f64) -> f64 {
        let (growth, tau, share, line) = self.e().adhesion;
        if growth > 0.0 {
            let s = time / tau;
            let bend = (1.0 - share) * (1.0 - (-s).exp()) + share * (1.0 + s).ln();
            CA0 + growth * bend + line * CA * time
        } else {
            CA0 + CA * time
        }
    }

    /// Coulomb friction at a displacement.
    pub(super) fn friction(&self, xp: f64) -> f64 {
        let e = self.e();
        let (linear, square) = e.load;
        (e.fc + linear * xp.abs() + square * xp * xp).max(0.0)
    }

    /// Whether there is any.
    pub(super) fn rubs(&self) -> bool {
        self.e().fc > 0.0 || self.e().load != (0.0, 0.0)
    }

    fn film(&self, xp: f64, vp: f64) -> f64 {
        if self.twin.has_film && self.twin.has_ground {
            -CS * vp / (xp + GP).powi(3)
        } else {
            0.0
        }
    }

    /// Rates, and the force that holds the mass where it is held (else 0).
    pub(super) fn rates(&self, t: f64, s: &State) -> (State, f64) {
        let e = self.e();
        let (xp, vp, xc, _) = self.points(s);
        let volt = self.piece.voltage(t);
        let [hz, zeta, _, phi_p, phi_d] = e.mode;
        let gain = self.gain(t, s);
        let drive = ETA * gain;
        let film = self.film(xp, vp);
        let mut on_mass = if e.film_tau > 0.0 { s[8] } else { film };
        if self.phase != Phase::Flight && e.film_tau == 0.0 {
            on_mass = 0.0;
        }
        let cube = if e.sine_length > 0.0 {
            let l = e.sine_length;
            6.0 * l * l * (xp - l * (xp / l).sin())
        } else {
            xp.powi(3)
        };
        on_mass -= e.k2 * xp * xp + e.k3 * cube + e.k5 * xp.powi(5);
        on_mass -= e.cd * vp * vp.abs() + 3.495e-10 * e.gravity;
        if e.electrostatic.0 > 0.0 {
            let distance = xp + e.electrostatic.1;
            on_mass -= 0.5 * 8.8541878128e-12 * e.electrostatic.0 * volt * volt / distance.powi(2);
        }
        if e.attraction.0 > 0.0 {
            let (force, range, exponent) = e.attraction;
            on_mass -= force * (1.0 + (xp + DP).max(0.0) / range).powf(-exponent);
        }
        on_mass += self.reaction(t, xp, vp) - self.friction(xp) * self.sliding;
        let (a, f, phase) = e.base;
        let base = a * (TAU * f * t + phase).sin();
        let row = |i: usize| -> f64 {
            -self.b[i][0] * s[2]
                - self.b[i][1] * s[3]
                - self.k[i][0] * s[0]
                - self.k[i][1] * s[1]
                - (self.m[i][0] + self.m[i][1]) * base
        };
        let (fc, fp) = (row(0) + drive, row(1) + on_mass);
        let m = &self.m;
        let det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        let w = TAU * hz;
        let mut ac = (m[1][1] * fc - m[0][1] * fp) / det;
        let mut ap = (m[0][0] * fp - m[1][0] * fc) / det;
        let mut aq = phi_d * drive + phi_p * on_mass - 2.0 * zeta * w * s[5] - w * w * s[4];
        let mut hold = 0.0;
        if self.phase != Phase::Flight {
            let [kc, kp, kq] = self.kick();
            hold = -(ap + phi_p * aq) / (kp + phi_p * kq);
            (ac, ap, aq) = (ac + kc * hold, ap + kp * hold, aq + kq * hold);
        }
        let lag = |tau: f64, input: f64, z: f64| if tau > 0.0 { (input - z) / tau } else { 0.0 };
        let rates = [
            s[2],
            s[3],
            ac,
            ap,
            s[5],
            aq,
            lag(e.amplifier_tau, volt, s[6]),
            // Creep answers to gc without itself.
            lag(e.creep[0].1, gain - self.creep(s), s[7]),
            lag(
                e.film_tau
                    * (2e5 * e.film_tau)
                        .clamp(9.0, 50.0)
                        .recip()
                        .max(((GP - DP) / (xp + GP)).powf(e.film_growth)),
                if self.phase == Phase::Flight {
                    film
                } else {
                    0.0
                },
                s[8],
            ),
            lag(e.sensor_tau, xp, s[9]),
            lag(e.sensor_tau, xc, s[10]),
            lag(e.creep[1].1, gain - self.creep(s), s[11]),
        ];
        (rates, hold)
    }

    /// Velocities of `yc`, `yp` and `q` per impulse on the mass.
    pub(super) fn kick(&self) -> [f64; 3] {
        let m = &self.m;
        let det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        [-m[0][1] / det, m[0][0] / det, self.e().mode[3]]
    }
}
