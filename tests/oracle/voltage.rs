//! The drive, written again: pieces on which the voltage is smooth and its direction
//! does not change, and the two branches of the piezo polynomial.

use std::f64::consts::TAU;

/// A waveform; Hz and V.
#[derive(Debug, Clone, Copy)]
pub enum Drive {
    /// No voltage since poling, no force.
    Rest,
    Square {
        hz: f64,
        volt: f64,
    },
    Sine {
        hz: f64,
        volt: f64,
    },
    Ramped {
        hz: f64,
        volt: f64,
        lambda: f64,
    },
}

/// A stretch of the drive; times in ms.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    pub start: f64,
    pub end: f64,
    form: Form,
    branch: Branch,
}

#[derive(Debug, Clone, Copy)]
enum Form {
    Line { from: f64, slope: f64 },
    Wave { volt: f64, omega: f64, phase: f64 },
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Branch {
    Up,
    Down,
    None,
}

impl Piece {
    /// Voltage [V] and its rate [V/ms], `tau` ms into the piece.
    pub fn voltage(&self, tau: f64) -> (f64, f64) {
        match self.form {
            Form::Line { from, slope } => (from + slope * tau, slope),
            Form::Wave { volt, omega, phase } => {
                let (sin, cos) = (omega * tau + phase).sin_cos();
                (volt * sin, volt * omega * cos)
            }
        }
    }

    /// Value and rate [1/ms] of the polynomial, eq (9).
    pub fn gain(&self, tau: f64) -> (f64, f64) {
        let (v, rate) = self.voltage(tau);
        match self.branch {
            Branch::Up => (
                0.0016 * v.powi(3) - 0.0255 * v.powi(2) - 0.7057 * v + 1.4796,
                (3.0 * 0.0016 * v * v - 2.0 * 0.0255 * v - 0.7057) * rate,
            ),
            Branch::Down => (
                0.0076 * v.powi(2) - 0.6062 * v - 0.6350,
                (2.0 * 0.0076 * v - 0.6062) * rate,
            ),
            Branch::None => (0.0, 0.0),
        }
    }
}

impl Drive {
    /// Pieces that cover 0 .. `end` ms.
    pub fn pieces(&self, end: f64) -> Vec<Piece> {
        let mut pieces: Vec<Piece> = Vec::new();
        let mut k = 0_u32;
        while pieces.last().is_none_or(|p| p.end < end) {
            self.half(k, &mut pieces);
            k += 1;
        }
        pieces.retain(|p| p.start < end);
        if let Some(last) = pieces.last_mut() {
            last.end = end;
        }
        pieces
    }

    /// Appends the `k`th half period.
    fn half(&self, k: u32, pieces: &mut Vec<Piece>) {
        let even = k.is_multiple_of(2);
        let branch = if even { Branch::Up } else { Branch::Down };
        let count = f64::from(k);
        match *self {
            Drive::Rest => pieces.push(Piece {
                start: 0.0,
                end: f64::INFINITY,
                form: Form::Line {
                    from: 0.0,
                    slope: 0.0,
                },
                branch: Branch::None,
            }),
            Drive::Square { hz, volt } => {
                let half = 500.0 / hz;
                let from = if even { volt } else { -volt };
                pieces.push(Piece {
                    start: count * half,
                    end: (count + 1.0) * half,
                    form: Form::Line { from, slope: 0.0 },
                    branch,
                });
            }
            Drive::Sine { hz, volt } => {
                // Cut at the peaks; the 0th half is only a quarter long.
                let half = 500.0 / hz;
                let omega = TAU * hz * 1e-3;
                pieces.push(Piece {
                    start: (count - 0.5).max(0.0) * half,
                    end: (count + 0.5) * half,
                    form: Form::Wave {
                        volt: if even { volt } else { -volt },
                        omega,
                        phase: if k == 0 { 0.0 } else { -TAU / 4.0 },
                    },
                    branch,
                });
            }
            Drive::Ramped { hz, volt, lambda } => {
                let half = 500.0 / hz;
                let ramp = 2.0 * half * lambda;
                let to = if even { volt } else { -volt };
                let start = count * half;
                pieces.push(Piece {
                    start,
                    end: start + ramp,
                    form: Form::Line {
                        from: -to,
                        slope: 2.0 * to / ramp,
                    },
                    branch,
                });
                pieces.push(Piece {
                    start: start + ramp,
                    end: (count + 1.0) * half,
                    form: Form::Line {
                        from: to,
                        slope: 0.0,
                    },
                    branch,
                });
            }
        }
    }
}
