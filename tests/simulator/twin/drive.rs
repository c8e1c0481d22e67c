//! The drive, and the pieces on which it is smooth.

use std::f64::consts::TAU;

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
pub(super) struct Piece {
    pub(super) end: f64,
    pub(super) rising: Option<bool>,
    form: Form,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Form {
    Line { t: f64, volt: f64, slope: f64 },
    Sine { hz: f64, volt: f64 },
}

impl Piece {
    pub(super) fn voltage(&self, t: f64) -> f64 {
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
    pub(super) fn pieces(&self, end: f64) -> Vec<Piece> {
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
