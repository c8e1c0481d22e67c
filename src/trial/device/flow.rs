//! The forces on the device, and the time derivative of its state.

use super::laws::Film;
use super::structure::{Dofs, MAX_DOF, dot};
use super::{Device, Phase};
use crate::trial::concealed::hidden_forces::{Load, Now};
use crate::trial::hybrid::integrator::{MAX_STATE, State};
use crate::trial::voltage::Piece;

impl Device {
    /// Accelerations by all forces except the one that holds the mass. Returns the force on the
    /// mass without that of the structure \[N\].
    fn free(
        &self,
        t: f64,
        y: &State,
        piece: &Piece,
        phase: Phase,
        acceleration: &mut Dofs,
        rates: &mut State,
    ) -> f64 {
        let s = &self.structure;
        let n = s.n;
        let [xp, vp, xc, vc] = self.points(y);
        let v = piece.shape.at(t);
        let gc = self.gc(piece, v);
        let now = Now {
            t,
            xp,
            vp,
            xc,
            vc,
            v,
            gc,
            height: xp - self.level(t),
            newton_per_gc: self.eta,
        };
        let mut load = Load {
            gc,
            ..Load::default()
        };
        let flying = !phase.in_contact();
        let mut k = 2 * n;
        let gap = xp + self.gp;
        let viscous = self.cs * vp / (gap * gap * gap);
        match self.film {
            Film::Viscous => {
                if flying {
                    load.p -= viscous;
                }
            }
            Film::Elastic {
                tau,
                gap: reference,
                power,
            } => {
                let tau = (tau * (reference / gap.max(1e-7)).powi(power)).clamp(1e-6, 1.0);
                let drive = if flying { viscous } else { 0.0 };
                if flying {
                    load.p -= y[k];
                }
                rates[k] = (drive - y[k]) / tau;
                k += 1;
            }
        }
        for term in &self.terms {
            let end = k + term.states();
            term.act(&now, &y[k..end], &mut load, &mut rates[k..end]);
            k = end;
        }
        if let Phase::Flight { direction } = phase {
            load.p -= self.friction * direction;
        }
        if let Phase::Touching { since } = phase {
            load.p += self.ground_force(t, -now.height, -vp, since);
        }
        let drive = self.eta * load.gc;
        for i in 0..n {
            let mut a = s.push_drive[i] * drive + s.push_p[i] * load.p + s.push_c[i] * load.c
                - s.push_base[i] * load.base;
            for j in 0..n {
                a -= s.stiffness[i][j] * y[j] + s.damping[i][j] * y[n + j];
            }
            acceleration[i] = a;
        }
        load.p
    }

    /// Time derivative of the state.
    pub fn flow(&self, t: f64, y: &State, piece: &Piece, phase: Phase, out: &mut State) {
        let s = &self.structure;
        let n = s.n;
        let mut acceleration = [0.0; MAX_DOF];
        self.free(t, y, piece, phase, &mut acceleration, out);
        if matches!(phase, Phase::Held { .. } | Phase::Jammed) {
            let hold = -dot(n, &s.read_p, &acceleration) / s.mobility;
            for i in 0..n {
                acceleration[i] += hold * s.push_p[i];
            }
        }
        for i in 0..n {
            out[i] = y[n + i];
            out[n + i] = acceleration[i];
        }
    }

    /// Force that would hold the mass at rest, and the force on the mass without that of the
    /// structure \[N\].
    #[must_use]
    pub fn hold(&self, t: f64, y: &State, piece: &Piece, phase: Phase) -> (f64, f64) {
        let s = &self.structure;
        let mut acceleration = [0.0; MAX_DOF];
        let mut rates = [0.0; MAX_STATE];
        let load = self.free(t, y, piece, phase, &mut acceleration, &mut rates);
        (-dot(s.n, &s.read_p, &acceleration) / s.mobility, load)
    }
}
