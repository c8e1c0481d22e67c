//! Forces and states that a trial device may conceal, each as a law of its own.

use std::f64::consts::TAU;

use serde::Serialize;

/// Permittivity of vacuum \[F/m\].
const EPSILON_0: f64 = 8.854e-12;

/// The device at one instant, SI.
#[derive(Debug, Clone, Copy)]
pub struct Now {
    /// Time.
    pub t: f64,
    /// Proof mass.
    pub xp: f64,
    /// Its velocity.
    pub vp: f64,
    /// Cantilever.
    pub xc: f64,
    /// Its velocity.
    pub vc: f64,
    /// Voltage behind the amplifier.
    pub v: f64,
    /// Piezo response.
    pub gc: f64,
    /// Height of the mass over the ground.
    pub height: f64,
    /// Newton of drive per unit of `gc`.
    pub newton_per_gc: f64,
}

/// What acts on the structure.
#[derive(Debug, Clone, Copy, Default)]
pub struct Load {
    /// On the proof mass \[N\].
    pub p: f64,
    /// On the cantilever \[N\].
    pub c: f64,
    /// Drive in units of `gc`.
    pub gc: f64,
    /// Acceleration of the base \[m/s^2\].
    pub base: f64,
}

/// One law.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Term {
    /// Kelvin-Voigt elements in a chain: relative compliance and time \[s\] of each.
    Creep { compliance: [f64; 3], tau: [f64; 3] },
    /// Plate capacitor with a fringe: area \[m^2\], gap at zero \[m\], fringe length \[m\].
    Capacitor { area: f64, gap: f64, fringe: f64 },
    /// Spring that hardens (or softens) and levels off: `k3 x^3 / (1 + (x/limit)^2)`.
    Hardening { k3: f64, limit: f64 },
    /// Drag of a wake: `cd v sqrt(v^2 + v0^2)`.
    Drag { cd: f64, v0: f64 },
    /// Attraction by a power of the height, `a (h0/(h + h0))^power`.
    PowerAttraction { a: f64, h0: f64, power: i32 },
    /// Attraction of charged patches, `a exp(-h/h0)`.
    PatchAttraction { a: f64, h0: f64 },
    /// The base moves: `a sin(2 pi f t + phase)`.
    Base { a: f64, frequency: f64, phase: f64 },
    /// A sensor with a first-order lag \[s\].
    SensorLag { tau: f64 },
    /// A constant weight \[N\].
    Weight { force: f64 },
    /// Force proportional to velocity and voltage \[N s/(m V)\].
    VoltageDamping { c: f64 },
    /// A spring that comes and goes: `k sin(2 pi f t)` \[N/m\].
    Pumped { k: f64, frequency: f64 },
    /// A second spring beyond `from` \[m\].
    Bilinear { k: f64, from: f64 },
    /// The piezo's gain wanders: knots every `step` \[s\] of relative change.
    Wander { step: f64, knots: Vec<f64> },
    /// Friction by load: `mu k |xc|` against the motion.
    LoadFriction { k: f64, v0: f64 },
    /// Bursts of a ringing force at the times given.
    Bursts {
        a: f64,
        frequency: f64,
        tau: f64,
        times: Vec<f64>,
    },
    /// Damping below zero around one position.
    Swing { c: f64, at: f64, width: f64 },
    /// Force on the mass by the product of both displacements \[N/m^2\].
    Product { k: f64 },
}

impl Term {
    /// Extra states.
    #[must_use]
    pub fn states(&self) -> usize {
        match self {
            Term::Creep { .. } => 3,
            Term::SensorLag { .. } => 2,
            _ => 0,
        }
    }

    /// Local error bound of its states.
    #[must_use]
    pub fn state_tolerance(&self, position: f64) -> f64 {
        match self {
            Term::SensorLag { .. } => position,
            // One unit of gc moves the mass by some 16 um.
            _ => position / 1.6e-5,
        }
    }

    /// Adds its load and writes its states' rates.
    pub fn act(&self, now: &Now, z: &[f64], load: &mut Load, rates: &mut [f64]) {
        match self {
            Term::Creep { compliance, tau } => {
                for k in 0..3 {
                    load.gc += compliance[k] * z[k];
                    rates[k] = (now.gc - z[k]) / tau[k];
                }
            }
            Term::Capacitor { area, gap, fringe } => {
                let h = (now.xp + gap).max(1e-7);
                load.p -= 0.5 * EPSILON_0 * area * now.v * now.v / (h * h) * (1.0 + h / fringe);
            }
            Term::Hardening { k3, limit } => {
                let r = now.xp / limit;
                load.p -= k3 * now.xp.powi(3) / (1.0 + r * r);
            }
            Term::Drag { cd, v0 } => load.p -= cd * now.vp * now.vp.hypot(*v0),
            Term::PowerAttraction { a, h0, power } => {
                load.p -= a * (h0 / (now.height.max(0.0) + h0)).powi(*power);
            }
            Term::PatchAttraction { a, h0 } => load.p -= a * (-now.height.max(0.0) / h0).exp(),
            Term::Base {
                a,
                frequency,
                phase,
            } => load.base += a * (TAU * frequency * now.t + phase).sin(),
            Term::SensorLag { tau } => {
                rates[0] = (now.xp - z[0]) / tau;
                rates[1] = (now.xc - z[1]) / tau;
            }
            Term::Weight { force } => load.p -= force,
            Term::VoltageDamping { c } => load.p -= c * now.vp * now.v,
            Term::Pumped { k, frequency } => {
                load.p -= k * (TAU * frequency * now.t).sin() * now.xp;
            }
            Term::Bilinear { k, from } => load.p -= k * (now.xp - from).max(0.0),
            Term::Wander { step, knots } => {
                let u = (now.t / step).clamp(0.0, (knots.len() - 1) as f64);
                let i = (u as usize).min(knots.len() - 2);
                let s = u - i as f64;
                load.gc += now.gc * (knots[i] * (1.0 - s) + knots[i + 1] * s);
            }
            Term::LoadFriction { k, v0 } => {
                load.p -= k * now.xc.abs() * (now.vp / v0).tanh();
            }
            Term::Bursts {
                a,
                frequency,
                tau,
                times,
            } => {
                for start in times {
                    let age = now.t - start;
                    // Rises and falls smoothly: the solver meets no corner.
                    let u = age / tau;
                    if u > 0.0 && u < 40.0 {
                        load.p += a * u * (1.0 - u).exp() * (TAU * frequency * age).sin();
                    }
                }
            }
            Term::Swing { c, at, width } => {
                let u = (now.xp - at) / width;
                load.p += c * now.vp * (-u * u).exp();
            }
            Term::Product { k } => load.p -= k * now.xp * now.xc,
        }
    }
}
