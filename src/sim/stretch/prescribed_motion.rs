//! What acts on the device along a motion that is given, as measured: no equation of motion is
//! solved. A force balance compares it with the accelerations of that motion.

use super::{Points, StretchSimulator, segment_at};
use crate::model::drive::Segment;
use crate::model::sensor::Point;

/// What acts at one instant of a given motion. SI.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ActingForces {
    /// Force where the piezo drives the cantilever \[N\].
    pub drive: f64,
    /// Force on the proof mass \[N\]: film, friction and effects.
    pub on_mass: f64,
    /// Acceleration of the base \[m/s^2\].
    pub base: f64,
    /// What the sensor adds to the displacement of the proof mass \[m\].
    pub reading_p: f64,
    /// The same of the cantilever \[m\].
    pub reading_c: f64,
}

impl ActingForces {
    /// What acts here and does not in `other`.
    #[must_use]
    pub fn beyond(&self, other: &Self) -> Self {
        Self {
            drive: self.drive - other.drive,
            on_mass: self.on_mass - other.on_mass,
            base: self.base - other.base,
            reading_p: self.reading_p - other.reading_p,
            reading_c: self.reading_c - other.reading_c,
        }
    }
}

/// Where a lagging reading `z` comes to in `h` \[s\] while what it reads goes straight from one value
/// to another: exact for `z' = rate (x - z)`.
fn lagging(z: f64, (from, to): (f64, f64), rate: f64, h: f64) -> f64 {
    if h <= 0.0 {
        return z;
    }
    let behind = (to - from) / (rate * h);
    to - behind + (z - from + behind) * (-rate * h).exp()
}

impl StretchSimulator {
    /// What acts under `drive` at increasing `times` \[s\] along `motion`, in flight. Effects'
    /// own states follow from the drive and the motion since the drive's beginning.
    ///
    /// A reading that lags or is late is taken from the motion itself: for one that changes little
    /// within the lag, what is read and what is there may change places.
    pub fn acting_forces(
        &self,
        drive: &[Segment],
        times: &[f64],
        motion: &dyn Fn(f64) -> Points,
    ) -> Vec<ActingForces> {
        let d = &self.device;
        let count = d.rates.len();
        let states = self.states_from_drive(drive, times, motion);
        let delay = d.reading_delay();
        let lagged = d.reading_states();
        let mut out = Vec::with_capacity(times.len());
        // A lag of the reading is followed sample by sample: the states that are readings are for
        // recordings to tell elsewhere.
        let mut lag = (0.0, 0.0);
        let mut before: Option<(f64, Points)> = None;
        for (i, &t) in times.iter().enumerate() {
            let points = motion(t);
            let mut z = states[i * count..(i + 1) * count].to_vec();
            if let Some(first) = lagged {
                lag = before.map_or((points.xp, points.xc), |(from, old)| {
                    let follow = |z, from_x, x| lagging(z, (from_x, x), d.rates[first], t - from);
                    (
                        follow(lag.0, old.xp, points.xp),
                        follow(lag.1, old.xc, points.xc),
                    )
                });
                (z[first], z[first + 1]) = lag;
            }
            before = Some((t, points));
            let segment = d.piece(segment_at(drive, t), t, &z);
            let mut at = crate::model::effects::Kinematics {
                t,
                xp: points.xp,
                vp: points.vp,
                xc: points.xc,
                vc: points.vc,
                voltage: segment.shape.voltage(t),
                gain: 0.0,
                film: d.film_force(points.xp, points.vp),
            };
            let force = d.drive_force(&mut at, segment.branch, &z);
            let friction = if points.vp == 0.0 {
                0.0
            } else {
                -d.friction(points.xp) * points.vp.signum()
            };
            let late = if delay > 0.0 {
                motion(t - delay)
            } else {
                points
            };
            let shown = |x: f64, from: f64, point: Point| d.apparent(from, point, t, &z) - x;
            out.push(ActingForces {
                drive: force,
                on_mass: d.altered_film_force(&at, &z) + d.effect_force(&at, &z) + friction,
                base: d.base_acceleration(t),
                reading_p: shown(points.xp, late.xp, Point::ProofMass),
                reading_c: shown(points.xc, late.xc, Point::Cantilever),
            });
        }
        out
    }

    /// Velocity of the proof mass per impulse on it \[1/kg\], and that of the cantilever per
    /// impulse on the proof mass \[1/kg\].
    pub fn mass_response(&self) -> (f64, f64) {
        let d = &self.device;
        let both = d.phi_p.iter().zip(&d.phi_c);
        (d.mobility, both.map(|(p, c)| p * c).sum())
    }

    /// Acceleration of the proof mass and of the cantilever per force of the drive \[1/kg\].
    pub fn drive_response(&self) -> (f64, f64) {
        let d = &self.device;
        let by = |phi: &[f64]| super::super::device::dot(phi, &d.phi_d);
        (by(&d.phi_p), by(&d.phi_c))
    }
}
