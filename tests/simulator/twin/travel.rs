//! The way through the drive in fixed steps, and the readings on it.

use super::{Machine, Phase, Run, State};

impl Machine<'_> {
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
        let mut k = [[0.0; 12]; 6];
        for stage in 0..6 {
            let mut at = *s;
            for (a, k) in A[stage].iter().zip(&k) {
                for (at, k) in at.iter_mut().zip(k) {
                    *at += h * a * k;
                }
            }
            k[stage] = self.rates(t + C[stage] * h, &at).0;
        }
        let mut next = *s;
        for (b, k) in B.iter().zip(&k) {
            for (next, k) in next.iter_mut().zip(k) {
                *next += h * b * k;
            }
        }
        next
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

    pub(super) fn run(&mut self, mut s: State, duration: f64, rate: f64) -> Run {
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
            if t == 0.0 && self.rubs() {
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
}
