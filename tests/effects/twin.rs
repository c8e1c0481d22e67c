//! The paper's device with all the effects, written again: physical coordinates, reactions
//! from the condition that a held point does not accelerate, play operators one by one,
//! and a Runge-Kutta method of order 5 with short fixed steps. SI.

use std::f64::consts::TAU;

/// Modes of the device: Hz, damping, shapes at cantilever and mass.
const MODES: [[f64; 4]; 2] = [
    [623.0, 0.0262, 13381.005, 50145.332],
    [6424.0, 0.0257, 74486.762, -12923.177],
];
const ETA: f64 = 3.819e-7;
const CS: f64 = 1.747e-21;
const GP: f64 = 70e-6;
const DP: f64 = 58e-6;
const CA: f64 = 1.7e-6;
const CA0: f64 = 0.02743e-6;
const ALPHA: f64 = 0.378;
/// Play operators of the hysteresis with memory.
const PLAYS: usize = 800;

/// Parameters of the effects; zero is off.
#[derive(Debug, Clone, Copy, Default)]
pub struct Effects {
    pub amplifier_tau: f64,
    pub creep: (f64, f64),
    /// Share, width, reference amplitude.
    pub memory: (f64, f64, f64),
    /// Area, gap.
    pub electrostatic: (f64, f64),
    /// Frequency, damping, shapes at cantilever, mass and drive.
    pub mode: [f64; 5],
    pub k3: f64,
    pub cd: f64,
    pub fc: f64,
    pub film_tau: f64,
    /// Force, range, exponent.
    pub attraction: (f64, f64, f64),
    /// Growth, time, share of the logarithm.
    pub adhesion: (f64, f64, f64),
    /// Exponent, speed.
    pub restitution: (f64, f64),
    /// Stiffness, damping.
    pub ground: (f64, f64),
    /// Height, time.
    pub step: (f64, f64),
    /// Amplitude, frequency, phase.
    pub base: (f64, f64, f64),
    /// End, time, rate.
    pub drift: (f64, f64, f64),
    pub sensor_tau: f64,
    pub gravity: f64,
}

/// A drive and what the device is like.
#[derive(Debug, Clone)]
pub struct Twin {
    pub effects: Effects,
    pub drive: Drive,
    /// Displacement and velocity of the mass at the start, by a static force and an impulse.
    pub start: (f64, f64),
    pub has_ground: bool,
    pub has_film: bool,
    /// Step in flight and in a compliant ground [s].
    pub steps: (f64, f64),
}

#[derive(Debug, Clone)]
pub enum Drive {
    Rest,
    Sine {
        hz: f64,
        volt: f64,
    },
    Square {
        hz: f64,
        volt: f64,
    },
    /// Straight lines through times and voltages.
    Lines(Vec<(f64, f64)>),
}

/// A stretch on which the drive is smooth; `rising` is `None` where there is no force.
#[derive(Debug, Clone, Copy)]
struct Piece {
    end: f64,
    rising: Option<bool>,
    form: Form,
}

#[derive(Debug, Clone, Copy)]
enum Form {
    Line { t: f64, volt: f64, slope: f64 },
    Sine { hz: f64, volt: f64 },
}

impl Piece {
    fn voltage(&self, t: f64) -> f64 {
        match self.form {
            Form::Line {
                t: from,
                volt,
                slope,
            } => volt + slope * (t - from),
            Form::Sine { hz, volt } => volt * (TAU * hz * t).sin(),
        }
    }
}

impl Drive {
    fn pieces(&self, end: f64) -> Vec<Piece> {
        let mut pieces = Vec::new();
        let mut push = |until: f64, rising, form| {
            pieces.push(Piece {
                end: until,
                rising,
                form,
            });
            until < end
        };
        let flat = |volt| Form::Line {
            t: 0.0,
            volt,
            slope: 0.0,
        };
        match self {
            Drive::Rest => {
                push(end, None, flat(0.0));
            }
            &Drive::Square { hz, volt } => {
                let mut k = 0_u32;
                while push(
                    f64::from(k + 1) * 0.5 / hz,
                    Some(k.is_multiple_of(2)),
                    flat(if k.is_multiple_of(2) { volt } else { -volt }),
                ) {
                    k += 1;
                }
            }
            &Drive::Sine { hz, volt } => {
                let mut k = 0_u32;
                while push(
                    (f64::from(k) + 0.5) * 0.5 / hz,
                    Some(k.is_multiple_of(2)),
                    Form::Sine { hz, volt },
                ) {
                    k += 1;
                }
            }
            Drive::Lines(points) => {
                for pair in points.windows(2) {
                    let ((t, volt), (until, to)) = (pair[0], pair[1]);
                    let slope = (to - volt) / (until - t);
                    push(until, Some(to > volt), Form::Line { t, volt, slope });
                }
            }
        }
        pieces
    }
}

/// `yc yp yc' yp' q q'`, then lagged voltage, creep, film force, lagged readings p and c.
type State = [f64; 11];

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Flight,
    /// On the rigid ground since.
    Held(f64),
    /// By friction.
    Stuck,
}

/// What the twin did: readings of mass and cantilever at `i / rate`, times of all changes
/// of contact, and the work of friction, film and so on is in the trace of energies.
#[derive(Debug, Default)]
pub struct Run {
    pub proof_mass: Vec<f64>,
    pub cantilever: Vec<f64>,
    pub contacts: Vec<(f64, f64)>,
}

struct Machine<'a> {
    twin: &'a Twin,
    m: [[f64; 2]; 2],
    b: [[f64; 2]; 2],
    k: [[f64; 2]; 2],
    plays: Vec<f64>,
    piece: Piece,
    phase: Phase,
    sliding: f64,
    touch: Option<f64>,
}

fn matrices() -> [[[f64; 2]; 2]; 3] {
    let [a, c] = MODES;
    let det = a[2] * c[3] - c[2] * a[3];
    let inverse = [[c[3] / det, -c[2] / det], [-a[3] / det, a[2] / det]];
    let congruence = |d: [f64; 2]| -> [[f64; 2]; 2] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..2).map(|n| d[n] * inverse[n][i] * inverse[n][j]).sum())
        })
    };
    let w = MODES.map(|m| TAU * m[0]);
    [
        congruence([1.0, 1.0]),
        congruence([2.0 * a[1] * w[0], 2.0 * c[1] * w[1]]),
        congruence([w[0] * w[0], w[1] * w[1]]),
    ]
}

fn branch(volt: f64, rising: bool) -> f64 {
    if rising {
        0.0016 * volt.powi(3) - 0.0255 * volt * volt - 0.7057 * volt + 1.4796
    } else {
        0.0076 * volt * volt - 0.6062 * volt - 0.6350
    }
}

impl Machine<'_> {
    fn e(&self) -> &Effects {
        &self.twin.effects
    }

    fn points(&self, s: &State) -> (f64, f64, f64, f64) {
        let [_, _, c, p, _] = self.e().mode;
        (
            s[1] + p * s[4],
            s[3] + p * s[5],
            s[0] + c * s[4],
            s[2] + c * s[5],
        )
    }

    fn level(&self, t: f64) -> f64 {
        let (height, time) = self.e().step;
        if t >= time { height - DP } else { -DP }
    }

    /// gc and the voltage of the film.
    fn gain(&self, t: f64, s: &State) -> f64 {
        let Some(rising) = self.piece.rising else {
            return self.e().creep.0 * s[7];
        };
        let volt = if self.e().amplifier_tau > 0.0 {
            s[6]
        } else {
            self.piece.voltage(t)
        };
        let (share, width, reference) = self.e().memory;
        let mut gc = branch(volt, rising);
        if share > 0.0 {
            let mean = 0.5 * (branch(volt, true) + branch(volt, false));
            let slope = 0.5 * (-0.7057 + 0.6062);
            let half = 0.5 * (1.4796 + 0.6350) + slope * volt;
            let top = self.widest();
            let weight = top / PLAYS as f64;
            let stops: f64 = (0..PLAYS).map(|i| volt - self.play(i, volt)).sum();
            let loops =
                4.0 / (reference * reference) * (weight * stops - volt * (top - 0.5 * reference));
            gc += share * (mean + width * half * loops - gc);
        }
        gc + self.e().creep.0 * s[7]
    }

    /// Widest of the play operators: no voltage exceeds it.
    fn widest(&self) -> f64 {
        10.0
    }

    fn play(&self, i: usize, volt: f64) -> f64 {
        let r = (i as f64 + 0.5) * self.widest() / PLAYS as f64;
        self.plays[i].clamp(volt - r, volt + r)
    }

    fn reaction(&self, t: f64, xp: f64, vp: f64) -> f64 {
        let (k, chi) = self.e().ground;
        self.touch.map_or(0.0, |since| {
            let depth = (self.level(t) - xp).max(0.0);
            k * depth.powf(1.5) * (1.0 - chi * vp) - self.adhesion(t - since)
        })
    }

    fn adhesion(&self, time: f64) -> f64 {
        let (growth, tau, share) = self.e().adhesion;
        if growth > 0.0 {
            let s = time / tau;
            CA0 + growth * ((1.0 - share) * (1.0 - (-s).exp()) + share * (1.0 + s).ln())
        } else {
            CA0 + CA * time
        }
    }

    fn film(&self, xp: f64, vp: f64) -> f64 {
        if self.twin.has_film && self.twin.has_ground {
            -CS * vp / (xp + GP).powi(3)
        } else {
            0.0
        }
    }

    /// Rates, and the force that holds the mass where it is held (else 0).
    fn rates(&self, t: f64, s: &State) -> (State, f64) {
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
        on_mass -= e.k3 * xp.powi(3) + e.cd * vp * vp.abs() + 3.495e-10 * e.gravity;
        if e.electrostatic.0 > 0.0 {
            let distance = xp + e.electrostatic.1;
            on_mass -= 0.5 * 8.8541878128e-12 * e.electrostatic.0 * volt * volt / distance.powi(2);
        }
        if e.attraction.0 > 0.0 {
            let (force, range, exponent) = e.attraction;
            on_mass -= force * (1.0 + (xp + DP) / range).powf(-exponent);
        }
        on_mass += self.reaction(t, xp, vp) - e.fc * self.sliding;
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
            lag(e.creep.1, gain - e.creep.0 * s[7], s[7]),
            lag(
                e.film_tau,
                if self.phase == Phase::Flight {
                    film
                } else {
                    0.0
                },
                s[8],
            ),
            lag(e.sensor_tau, xp, s[9]),
            lag(e.sensor_tau, xc, s[10]),
        ];
        (rates, hold)
    }

    /// Velocities of `yc`, `yp` and `q` per impulse on the mass.
    fn kick(&self) -> [f64; 3] {
        let m = &self.m;
        let det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        [-m[0][1] / det, m[0][0] / det, self.e().mode[3]]
    }

    fn set_velocity(&self, s: &mut State, to: f64) {
        let [kc, kp, kq] = self.kick();
        let phi = self.e().mode[3];
        let impulse = (to - s[3] - phi * s[5]) / (kp + phi * kq);
        s[2] += kc * impulse;
        s[3] += kp * impulse;
        s[5] += kq * impulse;
    }

    fn shift(&self, s: &mut State, to: f64) {
        let [kc, kp, kq] = self.kick();
        let phi = self.e().mode[3];
        let way = (to - s[1] - phi * s[4]) / (kp + phi * kq);
        s[0] += kc * way;
        s[1] += kp * way;
        s[4] += kq * way;
    }

    /// Dormand and Prince's fifth-order step.
    fn step(&self, t: f64, s: &State, h: f64) -> State {
        const A: [&[f64]; 6] = [
            &[],
            &[1.0 / 5.0],
            &[3.0 / 40.0, 9.0 / 40.0],
            &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
            &[
                19372.0 / 6561.0,
                -25360.0 / 2187.0,
                64448.0 / 6561.0,
                -212.0 / 729.0,
            ],
            &[
                9017.0 / 3168.0,
                -355.0 / 33.0,
                46732.0 / 5247.0,
                49.0 / 176.0,
                -5103.0 / 18656.0,
            ],
        ];
        const C: [f64; 6] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];
        const B: [f64; 6] = [
            35.0 / 384.0,
            0.0,
            500.0 / 1113.0,
            125.0 / 192.0,
            -2187.0 / 6784.0,
            11.0 / 84.0,
        ];
        let mut k = [[0.0; 11]; 6];
        for stage in 0..6 {
            let mut at = *s;
            for (a, k) in A[stage].iter().zip(&k) {
                for i in 0..11 {
                    at[i] += h * a * k[i];
                }
            }
            k[stage] = self.rates(t + C[stage] * h, &at).0;
        }
        let mut next = *s;
        for (b, k) in B.iter().zip(&k) {
            for i in 0..11 {
                next[i] += h * b * k[i];
            }
        }
        next
    }

    /// Not negative while the phase lasts.
    fn guard(&self, t: f64, s: &State) -> f64 {
        let (xp, vp, _, _) = self.points(s);
        let fc = self.e().fc;
        match self.phase {
            Phase::Held(since) => {
                let pull = -self.rates(t, s).1;
                self.adhesion(t - since) + fc - pull
            }
            Phase::Stuck => fc - self.rates(t, s).1.abs(),
            Phase::Flight => {
                let gap = match (self.twin.has_ground, self.touch) {
                    (false, _) => f64::INFINITY,
                    (true, None) => xp - self.level(t),
                    (true, Some(_)) => self.level(t) - xp,
                };
                // Both as shares of what is small.
                if fc > 0.0 {
                    (gap / 1e-6).min(self.sliding * vp / 1e-3)
                } else {
                    gap / 1e-6
                }
            }
        }
    }

    fn event(&mut self, t: f64, s: &mut State, run: &mut Run) {
        let (xp, vp, _, _) = self.points(s);
        let level = self.level(t);
        let fc = self.e().fc;
        match self.phase {
            Phase::Held(since) => {
                run.contacts.push((since, t));
                self.phase = Phase::Flight;
                self.sliding = 1.0;
            }
            Phase::Stuck => {
                // Slides against the force that held it.
                self.sliding = -self.rates(t, s).1.signum();
                self.phase = Phase::Flight;
            }
            Phase::Flight if fc > 0.0 && self.sliding * vp < 1e-9 => {
                self.set_velocity(s, 0.0);
                self.halt(t, s);
            }
            Phase::Flight if self.touch.is_some() => {
                run.contacts.push((self.touch.take().unwrap(), t));
            }
            Phase::Flight if self.e().ground.0 > 0.0 => self.touch = Some(t),
            Phase::Flight => {
                let _ = xp;
                self.shift(s, level);
                let (n, v0) = self.e().restitution;
                let alpha = if n == 0.0 {
                    ALPHA
                } else {
                    (ALPHA * (-vp / v0).powf(-n)).min(1.0)
                };
                self.set_velocity(s, -alpha * vp);
                let pull = self.pull(t, s);
                if pull > self.adhesion(0.0) + fc {
                    self.sliding = 1.0;
                } else {
                    self.set_velocity(s, 0.0);
                    self.phase = Phase::Held(t);
                    self.sliding = 0.0;
                }
            }
        }
    }

    /// The force that must be exerted downward to keep the mass from accelerating, with no
    /// friction in it, as if its velocity were zero but the modes moved as they do.
    fn pull(&mut self, t: f64, s: &State) -> f64 {
        let (phase, sliding) = (self.phase, self.sliding);
        (self.phase, self.sliding) = (Phase::Stuck, 0.0);
        let pull = -self.rates(t, s).1;
        (self.phase, self.sliding) = (phase, sliding);
        pull
    }

    /// At rest with friction: held, or off in the direction of the force.
    fn halt(&mut self, t: f64, s: &State) {
        let pull = self.pull(t, s);
        if pull.abs() > self.e().fc {
            self.sliding = pull.signum();
            self.phase = Phase::Flight;
        } else {
            self.sliding = 0.0;
            self.phase = Phase::Stuck;
        }
    }

    fn read(&self, t: f64, s: &State, run: &mut Run) {
        let e = self.e();
        let (xp, _, xc, _) = self.points(s);
        let (end, tau, rate) = e.drift;
        let drift = rate * t
            + if end != 0.0 {
                end * (1.0 - (-t / tau).exp())
            } else {
                0.0
            };
        let lagged = e.sensor_tau > 0.0;
        run.proof_mass.push(drift + if lagged { s[9] } else { xp });
        run.cantilever.push(drift + if lagged { s[10] } else { xc });
    }

    fn run(&mut self, mut s: State, duration: f64, rate: f64) -> Run {
        let mut run = Run::default();
        let count = (duration * rate + 0.5) as usize;
        let mut t = 0.0;
        let (height, step_time) = self.e().step;
        let mut pieces = self.twin.drive.pieces(duration);
        if height != 0.0 {
            let at = pieces.partition_point(|p| p.end <= step_time);
            let mut first = pieces[at];
            first.end = step_time;
            pieces.insert(at, first);
        }
        for piece in pieces {
            self.piece = piece;
            if height != 0.0 && t == step_time {
                self.follow(t, &mut s, &mut run);
            }
            if t == 0.0 && self.e().fc > 0.0 {
                let v = self.points(&s).1;
                self.sliding = v.signum();
                if v == 0.0 {
                    self.halt(t, &s);
                }
            }
            while t < piece.end.min(duration) {
                // The drive may have stepped; pushed from the ground it leaves at once.
                if self.phase != Phase::Flight && self.guard(t, &s) < 0.0 {
                    self.event(t, &mut s, &mut run);
                }
                let next_sample = run.proof_mass.len() as f64 / rate;
                if next_sample <= t {
                    self.read(t, &s, &mut run);
                    continue;
                }
                let longest = if self.touch.is_some() {
                    self.twin.steps.1
                } else {
                    self.twin.steps.0
                };
                let target = next_sample.min(piece.end);
                let h = longest.min(target - t);
                let next = self.step(t, &s, h);
                if self.guard(t + h, &next) < 0.0 {
                    let (mut low, mut high) = (0.0, h);
                    for _ in 0..60 {
                        let middle = 0.5 * (low + high);
                        let there = self.step(t, &s, middle);
                        if self.guard(t + middle, &there) < 0.0 {
                            high = middle;
                        } else {
                            low = middle;
                        }
                    }
                    s = self.step(t, &s, high);
                    t += high;
                    self.event(t, &mut s, &mut run);
                } else {
                    s = next;
                    t = if h == target - t { target } else { t + h };
                }
            }
            let end = piece.voltage(piece.end);
            self.plays = (0..self.plays.len()).map(|i| self.play(i, end)).collect();
        }
        while run.proof_mass.len() <= count {
            self.read(t, &s, &mut run);
        }
        run
    }

    /// The ground has stepped.
    fn follow(&mut self, t: f64, s: &mut State, run: &mut Run) {
        let level = self.level(t);
        let (xp, vp, _, _) = self.points(s);
        match self.phase {
            Phase::Held(since) if level < xp => {
                run.contacts.push((since, t));
                self.phase = Phase::Flight;
            }
            Phase::Held(_) => self.shift(s, level),
            _ if xp < level => {
                self.shift(s, level);
                self.set_velocity(s, vp.max(0.0));
            }
            _ => {}
        }
    }
}

impl Twin {
    /// The device from rest under `drive`.
    pub fn new(effects: Effects, drive: Drive) -> Self {
        Self {
            effects,
            drive,
            start: (0.0, 0.0),
            has_ground: true,
            has_film: true,
            steps: (1e-6, 2e-8),
        }
    }

    /// Runs for `duration` [s] with `rate` samples per second.
    pub fn run(&self, duration: f64, rate: f64) -> Run {
        let [m, b, k] = matrices();
        let mut machine = Machine {
            twin: self,
            m,
            b,
            k,
            plays: vec![
                0.0;
                if self.effects.memory.0 > 0.0 {
                    PLAYS
                } else {
                    0
                }
            ],
            piece: self.drive.pieces(duration)[0],
            phase: Phase::Flight,
            sliding: 0.0,
            touch: None,
        };
        // Bent by a force on the mass: K y = [0, F].
        let (x, v) = self.start;
        let mut s = [0.0; 11];
        (s[0], s[1]) = (-k[0][1] / k[0][0] * x, x);
        machine.set_velocity(&mut s, v);
        (s[9], s[10]) = (s[1], s[0]);
        machine.run(s, duration, rate)
    }
}
