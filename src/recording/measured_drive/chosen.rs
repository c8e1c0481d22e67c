//! A waveform that a person chose for a recording, in the form of a measured one.

use super::pieces::turn_edge;
use super::{Found, MeasuredDrive, Span};
use crate::model::drive::{DriveError, Segment, Waveform};

/// Most pieces that a waveform may have within a recording.
const MAX_CHOSEN_PIECES: usize = 4_000_000;
/// Jump between pieces that join smoothly, as a share of the voltage: rounding.
const MAX_ROUNDING_SHARE: f64 = 1e-9;

impl MeasuredDrive {
    /// `waveform`, whose t = 0 is at `start` \[s\], over the `(first, last, interval)` \[s\] of a
    /// recording. Its edges are known.
    ///
    /// # Errors
    /// [`DriveError::Value`] if the recording holds too many of its pieces.
    pub fn of_waveform(
        waveform: &Waveform,
        start: f64,
        (first, last, interval): (f64, f64, f64),
    ) -> Result<Self, DriveError> {
        let mut index = waveform.index_at(first - start);
        let mut pieces: Vec<Segment> = Vec::new();
        let mut edges = Vec::new();
        loop {
            let mut piece = waveform.segment(index).shifted(start);
            if let Some(before) = pieces.last() {
                let (old, new) = (
                    before.shape.voltage(piece.start),
                    piece.shape.voltage(piece.start),
                );
                let rounding = MAX_ROUNDING_SHARE * old.abs().max(new.abs());
                if (new - old).abs() > rounding || piece.branch != before.branch {
                    edges.push(turn_edge(interval, pieces.len(), piece.start, 0.0));
                }
            } else {
                piece.start = f64::NEG_INFINITY;
            }
            let end = piece.end;
            pieces.push(piece);
            if end > last {
                break;
            }
            if pieces.len() >= MAX_CHOSEN_PIECES {
                return Err(DriveError::Value(format!(
                    "{waveform} has more than {MAX_CHOSEN_PIECES} pieces within {} s of recording; choose a lower frequency or a shorter recording",
                    last - first
                )));
            }
            index += 1;
        }
        if let Some(piece) = pieces.last_mut() {
            piece.end = f64::INFINITY;
        }
        Ok(Self {
            pieces,
            edges,
            noise: 0.0,
            text: waveform.to_string(),
            command: Some(waveform.to_string()),
            recognised: true,
            freedoms: Vec::new(),
            span: Span {
                first,
                last,
                interval,
            },
            found: Found::Chosen(waveform.period()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;

    #[test]
    fn a_chosen_waveform_acts_as_typed() {
        let drive = Waveform::parse("square:15Hz:8V", 1.0).unwrap();
        let made = MeasuredDrive::of_waveform(&drive, 0.01, (0.01, 0.11, 2e-5)).unwrap();
        assert_eq!(made.edges.len(), 3);
        assert!((made.edges[0].time - (0.01 + 0.5 / 15.0)).abs() < 1e-15);
        assert_eq!(made.period(), Some(1.0 / 15.0));
        let again = made.waveform("x", -0.01);
        for k in 0..1000 {
            let t = 1e-4 * f64::from(k) + 1e-7;
            assert_eq!(again.voltage(t), drive.voltage(t), "{t}");
        }
    }

    #[test]
    fn pieces_that_join_have_no_edge_between_them() {
        for (text, edges) in [("ramped:5Hz:8V:0.25", 1), ("triangle:20Hz:7.3V", 8)] {
            let drive = Waveform::parse(text, 1.0).unwrap();
            let made = MeasuredDrive::of_waveform(&drive, 0.0, (0.0, 0.19, 2e-5)).unwrap();
            let found = made.edges.len();
            // Where the voltage turns its hysteresis branch changes; corners are none.
            assert!(found.abs_diff(edges) <= 1, "{text}: {found}");
        }
    }

    #[test]
    fn a_waveform_of_too_many_pieces_is_refused() {
        let drive = Waveform::parse("square:1MHz:8V", 1.0).unwrap();
        let error = MeasuredDrive::of_waveform(&drive, 0.0, (0.0, 10.0, 1e-5)).unwrap_err();
        assert!(error.to_string().contains("lower frequency"), "{error}");
    }
}
