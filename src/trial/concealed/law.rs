//! A concealed law, how it enters a device, and how it grows.

use serde::Serialize;

use super::hidden_forces::Term;
use super::preisach::{Preisach, SATURATION};
use crate::trial::device::structure::Mode;
use crate::trial::device::{Adhesion, Device, Film, Gain, Ground, Restitution};
use crate::trial::rng::TrialRng;
use crate::trial::voltage::{Amplifier, Piece, remember};

/// How the zero of a reading wanders, as a share of its amplitude against time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Drift {
    /// A straight line that reaches the amplitude after the time given \[s\].
    Line(f64),
    /// Saturating exponential with the time given \[s\].
    Exponential(f64),
    /// `log(1 + t/tau)`, a warm instrument.
    Logarithm(f64),
}

/// One law in one formulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// Between source and piezo.
    Amplifier(Amplifier),
    /// Relays in place of the branches.
    Relays {
        coercive: f64,
        spread: f64,
        reach: f64,
        height: f64,
        blend: f64,
    },
    /// Voltages around zero are lost \[V\].
    DeadZone(f64),
    /// A force or a state.
    Term(Term),
    /// One more oscillator.
    Mode(Mode),
    /// Dry friction \[N\].
    Friction(f64),
    /// Elastic gas.
    Film { tau: f64, power: i32 },
    /// Adhesion in place of the line.
    Adhesion(Adhesion),
    /// Restitution in place of the constant.
    Restitution(Restitution),
    /// Compliant ground.
    Ground(Ground),
    /// The ground steps by `rise` \[m\] at `time` \[s\]: in every recording, or in one
    /// recording of the series and for good.
    GapStep {
        rise: f64,
        time: f64,
        once_in: Option<usize>,
    },
    /// The zero of both readings wanders by `amplitude` \[m\].
    Drift { amplitude: f64, course: Drift },
    /// Both readings are delayed \[s\].
    Delay(f64),
    /// The gain walks at random with this rms per second^(1/2).
    Wander { rate: f64, seed: u64 },
    /// Bursts of force at random times.
    Bursts {
        a: f64,
        frequency: f64,
        tau: f64,
        per_second: f64,
        seed: u64,
    },
}

impl Law {
    /// The same law `s` times as strong.
    #[must_use]
    pub fn scaled(&self, s: f64) -> Self {
        let mut law = self.clone();
        match &mut law {
            Law::Amplifier(Amplifier::Ladder { first, second }) => {
                *first *= s;
                *second *= s;
            }
            Law::Amplifier(Amplifier::Slew { rate, lag }) => {
                *rate /= s;
                *lag *= s;
            }
            Law::Relays { blend, .. } => *blend = (*blend * s).min(1.0),
            Law::DeadZone(x) | Law::Friction(x) | Law::Delay(x) => *x *= s,
            Law::Term(term) => scale_term(term, s),
            Law::Mode(mode) => {
                let root = s.sqrt();
                mode.phi_p *= root;
                mode.phi_c *= root;
                mode.drive *= root;
                mode.base *= root;
            }
            Law::Film { tau, .. } => *tau *= s,
            Law::Adhesion(
                Adhesion::Stretched { blend, .. } | Adhesion::Logarithm { blend, .. },
            )
            | Law::Restitution(Restitution::Plastic { blend, .. }) => {
                *blend = (*blend * s).min(1.0)
            }
            Law::Restitution(Restitution::Viscoelastic { c, .. }) => *c *= s,
            Law::Adhesion(Adhesion::Line)
            | Law::Restitution(Restitution::Constant)
            | Law::Ground(Ground::Rigid) => {}
            // A softer ground is the larger effect; the restitution stays as it is.
            Law::Ground(Ground::Bonded { stiffness, damping }) => {
                *stiffness /= s;
                *damping /= s.sqrt();
            }
            Law::Ground(Ground::Hertz { stiffness, damping }) => {
                *stiffness /= s;
                *damping /= s.sqrt();
            }
            Law::GapStep { rise, .. } => *rise *= s,
            Law::Drift { amplitude, .. } => *amplitude *= s,
            Law::Wander { rate, .. } => *rate *= s,
            Law::Bursts { a, .. } => *a *= s,
        }
        law
    }

    /// Puts the law into a device for recording number `recording` of `duration` \[s\].
    pub fn install(&self, device: &mut Device, recording: usize, duration: f64) {
        match self {
            Law::Amplifier(_) | Law::Drift { .. } | Law::Delay(_) => {}
            Law::Relays {
                coercive,
                spread,
                reach,
                height,
                blend,
            } => {
                device.gain = Gain::Relays {
                    sum: Box::new(Preisach::new(*coercive, *spread, *reach)),
                    blend: *blend,
                    height: *height,
                };
            }
            Law::DeadZone(width) => device.gain = Gain::DeadZone { width: *width },
            Law::Term(term) => device.terms.push(term.clone()),
            Law::Mode(mode) => device.structure.append(mode),
            Law::Friction(f) => device.friction = *f,
            Law::Film { tau, power } => {
                device.film = Film::Elastic {
                    tau: *tau,
                    gap: 12e-6 + device.gp - device.dp,
                    power: *power,
                };
            }
            Law::Adhesion(law) => device.adhesion = *law,
            Law::Restitution(law) => device.restitution = *law,
            Law::Ground(law) => device.ground = *law,
            Law::GapStep {
                rise,
                time,
                once_in,
            } => match once_in {
                Some(one) if recording < *one => {}
                Some(one) if recording > *one => device.dp -= rise,
                _ => {
                    device.ground_rise = *rise;
                    device.rise_time = (*time).min(0.9 * duration);
                }
            },
            Law::Wander { rate, seed } => {
                let step = 2e-3;
                let mut rng = TrialRng::new(*seed, recording as u64);
                let count = (duration / step).ceil() as usize + 3;
                let mut level = 0.0;
                let knots = (0..count)
                    .map(|_| {
                        level += rate * step.sqrt() * rng.normal();
                        level
                    })
                    .collect();
                device.terms.push(Term::Wander { step, knots });
            }
            Law::Bursts {
                a,
                frequency,
                tau,
                per_second,
                seed,
            } => {
                let mut rng = TrialRng::new(*seed, recording as u64);
                let count = (per_second * duration).ceil() as usize;
                let times = (0..count).map(|_| rng.between(0.0, duration)).collect();
                device.terms.push(Term::Bursts {
                    a: *a,
                    frequency: *frequency,
                    tau: *tau,
                    times,
                });
            }
        }
    }

    /// What the drive becomes.
    #[must_use]
    pub fn alter_drive(&self, pieces: Vec<Piece>) -> Vec<Piece> {
        match self {
            Law::Amplifier(amplifier) => amplifier.apply(&pieces),
            _ => pieces,
        }
    }

    /// Notes the history of the voltage where the law needs it; after
    /// [`Law::alter_drive`] of all laws.
    pub fn note_history(&self, pieces: &mut [Piece]) {
        if let Law::Relays { .. } = self {
            remember(pieces, -SATURATION);
        }
    }

    /// Delay of the readings \[s\].
    #[must_use]
    pub fn delay(&self) -> f64 {
        match self {
            Law::Delay(delay) => *delay,
            _ => 0.0,
        }
    }

    /// How far the zero has moved at `t` \[s\] \[m\].
    #[must_use]
    pub fn zero(&self, t: f64) -> f64 {
        let Law::Drift { amplitude, course } = self else {
            return 0.0;
        };
        let t = t.max(0.0);
        amplitude
            * match course {
                Drift::Line(span) => t / span,
                Drift::Exponential(tau) => 1.0 - (-t / tau).exp(),
                Drift::Logarithm(tau) => (t / tau).ln_1p(),
            }
    }

    /// Its largest force on this device \[N\], from its law at the usual extremes of the
    /// motion (60 um, 0.3 m/s, 8 V); `None` where it is no force.
    #[must_use]
    pub fn size(&self, device: &Device) -> Option<f64> {
        let span = 5.0 * device.eta;
        match self {
            Law::Amplifier(_) => None,
            Law::Relays { height, blend, .. } => Some(0.5 * blend * height * device.eta),
            Law::DeadZone(width) => Some(0.7 * width * device.eta),
            Law::Term(term) => term_size(term, device, span),
            Law::Mode(mode) => {
                let w = std::f64::consts::TAU * mode.frequency;
                let (xp, _) = device.structure.static_gain()?;
                Some(span * mode.phi_p * mode.drive / (w * w) / xp)
            }
            Law::Friction(f) => Some(*f),
            Law::Adhesion(Adhesion::Stretched { rise, blend, .. }) => Some(rise * blend),
            Law::Adhesion(Adhesion::Logarithm { rise, blend, tau }) => {
                Some(rise * blend * (0.03 / tau).ln_1p())
            }
            Law::Wander { rate, .. } => Some(rate * 0.2f64.sqrt() * span),
            Law::Bursts { a, .. } => Some(*a),
            _ => None,
        }
        .map(f64::abs)
    }
}

fn scale_term(term: &mut Term, s: f64) {
    match term {
        Term::Creep { compliance, .. } => compliance.iter_mut().for_each(|c| *c *= s),
        Term::Capacitor { area, .. } => *area *= s,
        Term::Hardening { k3, .. } => *k3 *= s,
        Term::Drag { cd, .. } => *cd *= s,
        Term::PowerAttraction { a, .. }
        | Term::PatchAttraction { a, .. }
        | Term::Base { a, .. }
        | Term::Bursts { a, .. } => *a *= s,
        Term::SensorLag { tau } => *tau *= s,
        Term::Weight { force } => *force *= s,
        Term::VoltageDamping { c } | Term::Swing { c, .. } => *c *= s,
        Term::Pumped { k, .. }
        | Term::Bilinear { k, .. }
        | Term::LoadFriction { k, .. }
        | Term::Product { k } => *k *= s,
        Term::Wander { knots, .. } => knots.iter_mut().for_each(|k| *k *= s),
    }
}

fn term_size(term: &Term, device: &Device, span: f64) -> Option<f64> {
    let x = 60e-6;
    Some(match term {
        Term::Creep { compliance, .. } => compliance.iter().sum::<f64>() * span,
        Term::Capacitor { area, gap, .. } => {
            let h = gap - device.dp;
            0.5 * 8.854e-12 * area * 64.0 / (h * h)
        }
        Term::Hardening { k3, .. } => k3 * x * x * x,
        Term::Drag { cd, .. } => cd * 0.09,
        Term::PowerAttraction { a, .. }
        | Term::PatchAttraction { a, .. }
        | Term::Bursts { a, .. } => *a,
        // On the mass that the first mode moves, about 4e-10 kg.
        Term::Base { a, .. } => 4e-10 * a,
        Term::SensorLag { .. } => return None,
        Term::Weight { force } => *force,
        Term::VoltageDamping { c } => c * 0.3 * 8.0,
        Term::Pumped { k, .. } => k * x,
        Term::Bilinear { k, from } => k * (x - from).max(0.0),
        Term::Wander { .. } => return None,
        Term::LoadFriction { k, .. } => k * 0.3 * x,
        Term::Swing { c, .. } => c * 0.3,
        Term::Product { k } => k * x * 0.3 * x,
    })
}
