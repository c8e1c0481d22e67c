//! A recorded voltage as few smooth pieces.
//!
//! A recorder gives the voltage at instants; a simulation that stopped at each of them would take
//! many times the steps. Here, runs of samples that one cubic follows to within the voltage's noise
//! become one piece. Where the voltage jumps between two samples, or the hysteresis branch changes,
//! there is an *edge*. Its instant is known to about a sample only, so a fit leaves it free within
//! that.

use nalgebra::{Matrix4, Vector4};

use crate::fit::error::FitError;
use crate::fit::thresholds::{
    JUMP_STEEPNESS, MAX_TURN_ASYMMETRY, MIN_JUMP_SHARE, TURN_DEPTH_TOLERANCES,
};
use crate::model::Model;
use crate::model::drive::{Segment, Shape, VoltageTable, Waveform};
use crate::model::piezo::Branch;
use crate::recording::noise::recording_noise;
use crate::recording::{Channel, Recording};
use crate::sim::SimError;

/// Most samples in a piece.
const MAX_PIECE_SAMPLES: usize = 4096;

/// Most samples on either side of a turn from which its instant is read.
const MAX_TURN_HALF_WINDOW: usize = 60;

/// An instant at which the drive's force jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// Index of the piece that begins there.
    pub piece: usize,
    /// Best guess \[s\].
    pub time: f64,
    /// Standard deviation of the guess \[s\].
    pub sigma: f64,
    /// Farthest from the guess \[s\].
    pub reach: f64,
}

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
        if model.piezo.is_none() && recording.voltage.is_none() {
            return Ok(Self {
                pieces: vec![Waveform::Rest.segment(0)],
                edges: Vec::new(),
            });
        }
        let Some((mut time, volts)) = recording.drive_table() else {
            return Err(FitError::NoDrive {
                recording: recording.name.clone(),
            });
        };
        time.iter_mut().for_each(|t| *t += lag);
        let low = volts.iter().copied().fold(f64::INFINITY, f64::min);
        let high = volts.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let span = high - low;
        let noise = recording_noise(recording, Channel::Voltage).ok();
        let sigma = noise.map_or(0.0, |n| n.sigma);
        let step = noise
            .and_then(|n| n.step.filter(|_| n.quantised))
            .unwrap_or(0.0);
        // The branch must not follow the noise, but must change where the voltage turns.
        let deadband = (6.0 * sigma).max(1.5 * step).max(1e-6 * span);
        let table = VoltageTable::new(&recording.name, time, volts, deadband)
            .map_err(|e| FitError::Start(SimError::from(e)))?;
        let tolerance = (3.0 * sigma).max(step).max(2e-6 * span).max(1e-12);
        Ok(Self::compact(&table, recording.interval(), tolerance, span))
    }

    fn compact(table: &VoltageTable, interval: f64, tolerance: f64, span: f64) -> Self {
        let (time, volts) = table.samples();
        let n = time.len();
        let waveform = Waveform::Table(std::sync::Arc::new(table.clone()));
        // Branch on the interval that ends at sample i; number 0 lies before the first.
        let branch = |i: usize| waveform.segment(i).branch;
        let rise = |i: usize| {
            if i == 0 || i >= n {
                0.0
            } else {
                (volts[i] - volts[i - 1]).abs()
            }
        };
        let jumps = |i: usize| {
            let around = rise(i - 1).max(rise(i + 1));
            rise(i)
                > (JUMP_STEEPNESS * around)
                    .max(MIN_JUMP_SHARE * span)
                    .max(3.0 * tolerance)
        };
        let mut track = Self {
            pieces: vec![Segment {
                start: f64::NEG_INFINITY,
                end: time[0],
                shape: Shape::Constant { voltage: volts[0] },
                branch: branch(1.min(n - 1)),
            }],
            edges: Vec::new(),
        };
        let mut from = 0;
        let mut jumped = None;
        while from + 1 < n {
            if jumps(from + 1) {
                // The next piece reaches back to the jump.
                let middle = 0.5 * (time[from] + time[from + 1]);
                let width = time[from + 1] - time[from];
                track.edge(middle, 0.6 * width, 1.5 * width);
                jumped = Some(middle);
                from += 1;
                continue;
            }
            let own = branch(from + 1);
            let mut turned = None;
            if jumped.is_none() && track.pieces.last().is_some_and(|p| p.branch != own) {
                // The voltage turned here, or stayed within the noise for a while.
                let near = |i: &usize| (volts[*i] - volts[from]).abs() <= tolerance;
                let linger = (from..n).take_while(near).count().min(50) as f64 * interval;
                let sigma = if tolerance > 1e-5 * span {
                    0.5 * linger
                } else {
                    0.3 * interval
                };
                let begun = track.pieces.last().map_or(f64::INFINITY, |p| p.start);
                let at = parabola_vertex((time, volts), from, own == Branch::Rising, tolerance)
                    .filter(|t| *t > begun && (t - time[from]).abs() < linger + 2.0 * interval)
                    .unwrap_or(time[from]);
                track.edge(at, sigma.max(0.3 * interval), (2.0 * sigma).max(interval));
                turned = Some(at);
            }
            let most = (from + 1..n.min(from + MAX_PIECE_SAMPLES))
                .take_while(|&i| branch(i) == own && !jumps(i))
                .last()
                .unwrap_or(from + 1);
            let (to, shape) = longest(time, volts, from, most, tolerance);
            let start = jumped.take().or(turned).unwrap_or(time[from]);
            if let Some(before) = track.pieces.last_mut() {
                before.end = start;
            }
            track.push(start, time[to], own, shape);
            from = to;
        }
        let end = jumped.unwrap_or(time[n - 1]);
        let last = track.pieces.last_mut().map_or(Branch::Poled, |last| {
            last.end = end;
            last.branch
        });
        // After a jump in the very last interval the voltage went the other way.
        let last = match (jumped, volts[n - 1] > volts[n.saturating_sub(2)]) {
            (None, _) => last,
            (Some(_), true) => Branch::Rising,
            (Some(_), false) => Branch::Falling,
        };
        track.push(end, f64::INFINITY, last, constant(volts[n - 1]));
        track
    }

    fn push(&mut self, start: f64, end: f64, branch: Branch, shape: Shape) {
        self.pieces.push(Segment {
            start,
            end,
            shape,
            branch,
        });
    }

    /// Notes that the next piece begins with a jump.
    fn edge(&mut self, time: f64, sigma: f64, reach: f64) {
        self.edges.push(Edge {
            piece: self.pieces.len(),
            time,
            sigma,
            reach,
        });
    }
}

/// When a voltage turned near sample `near`, from its lowest value if it `rises` after: the vertex
/// of the parabola through the extreme and two samples on its sides that are well off it. `None` if
/// it rested there or turned unevenly.
fn parabola_vertex(
    (time, volts): (&[f64], &[f64]),
    near: usize,
    rises: bool,
    tolerance: f64,
) -> Option<f64> {
    let up = |i: usize| if rises { -volts[i] } else { volts[i] };
    let e = (near.saturating_sub(MAX_TURN_HALF_WINDOW)..(near + 2).min(volts.len()))
        .max_by(|&a, &b| up(a).total_cmp(&up(b)))?;
    let below = |i: usize| up(e) - up(i);
    let inside = |m: &usize| *m <= e && e + m < volts.len();
    let m = (1..=MAX_TURN_HALF_WINDOW)
        .take_while(inside)
        .find(|m| below(e - m).min(below(e + m)) > TURN_DEPTH_TOLERANCES * tolerance)?;
    let (left, right) = (below(e - m), below(e + m));
    if left > MAX_TURN_ASYMMETRY * right || right > MAX_TURN_ASYMMETRY * left {
        return None;
    }
    let step = 0.5 * (time[e + m] - time[e - m]);
    Some(time[e] + 0.5 * step * (left - right) / (left + right))
}

fn constant(voltage: f64) -> Shape {
    Shape::Constant { voltage }
}

/// The longest run of samples from `from` on, up to `most`, that one shape follows.
fn longest(
    time: &[f64],
    volts: &[f64],
    from: usize,
    most: usize,
    tolerance: f64,
) -> (usize, Shape) {
    let line = |to: usize| Shape::Line {
        voltage: volts[from],
        slope: (volts[to] - volts[from]) / (time[to] - time[from]),
        at: time[from],
    };
    let mut best = (from + 1, line(from + 1));
    let mut size = 4;
    loop {
        let to = (from + size).min(most);
        if to <= best.0 {
            break;
        }
        let range = from..=to;
        let flat = range.clone().all(|i| volts[i] == volts[from]);
        let shape = if flat {
            Some(constant(volts[from]))
        } else {
            cubic(&time[from..=to], &volts[from..=to])
        };
        let follows = |shape: &Shape| {
            range
                .clone()
                .all(|i| (shape.voltage(time[i]) - volts[i]).abs() <= tolerance)
        };
        match shape.filter(|s| follows(s)) {
            Some(shape) => best = (to, shape),
            // After a failed doubling the search stops: half the length is good enough.
            None => break,
        }
        size *= 2;
    }
    best
}

/// The cubic of least squares; `None` if it is not determined.
fn cubic(time: &[f64], volts: &[f64]) -> Option<Shape> {
    let (first, last) = (*time.first()?, *time.last()?);
    let (at, unit) = (0.5 * (first + last), 0.5 * (last - first));
    let mut normal = Matrix4::zeros();
    let mut right = Vector4::zeros();
    for (t, v) in time.iter().zip(volts) {
        let u = (t - at) / unit;
        let row = Vector4::new(1.0, u, u * u, u * u * u);
        normal += row * row.transpose();
        right += row * *v;
    }
    let c = normal.cholesky()?.solve(&right);
    Some(Shape::Cubic {
        c: [c[0], c[1], c[2], c[3]],
        at,
        unit,
    })
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
