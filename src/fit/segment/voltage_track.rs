//! The drive of a recording as smooth pieces and edges.
//!
//! An edge's instant is known from the voltage to within a part of a sample at best, so a fit leaves
//! it free within that.

use crate::fit::error::FitError;
use crate::model::Model;
use crate::model::drive::{Segment, Waveform};
use crate::recording::Recording;
pub use crate::recording::measured_drive::DriveEdge as Edge;
use crate::sim::SimError;

/// The drive of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Smooth pieces in order of time, without gaps.
    pub pieces: Vec<Segment>,
    /// Jumps of the drive's force.
    pub edges: Vec<Edge>,
}

impl Track {
    /// The drive of `recording`, delayed by `lag` \[s\], for a driven `model`; rest for one
    /// without drive.
    ///
    /// # Errors
    /// [`FitError::NoDrive`] if the device is driven and no voltage was recorded.
    pub fn new(model: &Model, recording: &Recording, lag: f64) -> Result<Self, FitError> {
        if model.piezo.is_none() && recording.own_drive().is_none() {
            return Ok(Self {
                pieces: vec![Waveform::Rest.segment(0)],
                edges: Vec::new(),
            });
        }
        let Some(drive) = recording.own_drive() else {
            return Err(FitError::NoDrive {
                recording: recording.name.clone(),
            });
        };
        let drive = drive.map_err(|e| FitError::Start(SimError::from(e)))?;
        let edge = |e: &Edge| Edge {
            time: e.time + lag,
            ..*e
        };
        Ok(Self {
            pieces: drive.pieces.iter().map(|p| p.shifted(lag)).collect(),
            edges: drive.edges.iter().map(edge).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::voltage_track::*;
    use crate::model::preset::Preset;

    fn recording(drive: &str, duration: f64) -> (Waveform, Recording) {
        let drive = Waveform::parse(drive, duration).unwrap();
        let time: Vec<f64> = (0..(duration * 50e3) as usize)
            .map(|i| i as f64 / 50e3)
            .collect();
        let volts: Vec<f64> = time.iter().map(|&t| drive.voltage(t)).collect();
        let xp = time.clone();
        let recording = Recording::new("test", time, Some(volts), xp, None).unwrap();
        (drive, recording)
    }

    #[test]
    fn slow_turns_are_located_between_the_samples() {
        let model = Preset::embedded("paper").unwrap().model;
        for frequency in [3.0, 15.0, 47.0] {
            // Sampling that is not synchronous with the drive.
            let lag = 7.3e-6;
            let time: Vec<f64> = (0..20_000).map(|i| i as f64 / 50e3).collect();
            let turn = std::f64::consts::TAU * frequency;
            let volts: Vec<f64> = time
                .iter()
                .map(|t| 8.0 * (turn * (t - lag)).sin())
                .collect();
            let recording = Recording::new("test", time.clone(), Some(volts), time, None).unwrap();
            let track = Track::new(&model, &recording, 0.0).unwrap();
            assert!(track.edges.len() >= (2.0 * 0.4 * frequency) as usize - 1);
            for edge in &track.edges {
                let quarters = (edge.time - lag) * frequency * 4.0;
                let off = (quarters - quarters.round()) / (frequency * 4.0);
                assert!(off.abs() < 1e-6, "{frequency} Hz: {off:e} s off");
                assert_eq!(track.pieces[edge.piece].start, edge.time);
            }
        }
    }

    #[test]
    fn pieces_follow_the_voltage_and_edges_are_found() {
        let model = Preset::embedded("paper").unwrap().model;
        for (text, pieces, edges) in [
            ("square:15Hz:8V", 20, 5),
            ("sine:50Hz:8V", 400, 19),
            ("ramped:5Hz:8V:0.25", 60, 1),
        ] {
            let (drive, recording) = recording(text, 0.19);
            let track = Track::new(&model, &recording, 0.0).unwrap();
            assert!(
                track.pieces.len() < pieces,
                "{text}: {}",
                track.pieces.len()
            );
            assert_eq!(track.edges.len(), edges, "{text}: {:?}", track.edges);
            for pair in track.pieces.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
            }
            for edge in &track.edges {
                assert_eq!(track.pieces[edge.piece].start, edge.time, "{text}");
            }
            for &t in &recording.time {
                let near = track.edges.iter().any(|e| (e.time - t).abs() < 3e-5);
                let i = track.pieces.partition_point(|p| p.end <= t);
                let error = track.pieces[i].shape.voltage(t) - drive.voltage(t);
                assert!(near || error.abs() < 1e-4, "{text} {t}: {error}");
            }
        }
    }
}
