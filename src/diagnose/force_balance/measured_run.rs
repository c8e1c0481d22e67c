//! One recording as a force balance sees it: the motion at each sample and on both sides of each
//! jump of the drive, and the flights in it.

use std::ops::Range;

use super::local_polynomial::smooth_motion;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::problem::Data;
use crate::fit::problem::prepare::Prepared;
use crate::model::Model;
use crate::model::drive::Segment;
use crate::model::parameter::ParameterId;
use crate::sim::Points;

/// Distance of the two nodes at a jump of the drive from it, in intervals between samples.
const EDGE_NODE_SHARE: f64 = 1e-6;

/// A jump of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeNodes {
    /// When \[s\].
    pub time: f64,
    /// The first sample after it.
    pub sample: usize,
    /// The node just before it; the next one is just after it.
    pub before: usize,
}

/// A recording with its motion.
#[derive(Debug, Clone)]
pub struct MeasuredRun {
    /// Name of the recording.
    pub name: String,
    /// Times of the samples \[s\].
    pub time: Vec<f64>,
    /// Readings of the proof mass and, where read, of the cantilever \[m\], the proof mass's with
    /// the ground where the model has it.
    pub readings: Vec<Vec<f64>>,
    /// Standard deviations of their noise \[m\].
    pub noise: Vec<f64>,
    /// Flights without events, as samples.
    pub flights: Vec<Range<usize>>,
    /// The drive.
    pub drive: Vec<Segment>,
    /// Jumps of the drive, in order of time.
    pub edges: Vec<EdgeNodes>,
    /// Times at which forces are evaluated \[s\]: samples, and both sides of each jump.
    pub nodes: Vec<f64>,
    /// The node of each sample.
    pub sample_nodes: Vec<usize>,
    /// The motion there.
    pub motion: Vec<Points>,
}

impl MeasuredRun {
    /// The recordings that have flights, from their event-free segments, their motion smoothed over
    /// `smoothing` \[s\].
    pub fn of_recordings(
        prepared: &Prepared,
        summaries: &[RecordingSummary],
        model: &Model,
        smoothing: f64,
    ) -> Vec<Self> {
        let data = prepared.problem.data.iter().zip(summaries);
        let mut out = Vec::new();
        for (index, (data, summary)) in data.enumerate() {
            let mut flights: Vec<Range<usize>> = Vec::new();
            let own = prepared.segments.iter();
            for s in own.filter(|s| s.recording == index && !s.starts_held) {
                // Segments of one flight follow one another.
                match flights.last_mut() {
                    Some(last) if s.samples.start <= last.end => last.end = s.samples.end,
                    _ => flights.push(s.samples.clone()),
                }
            }
            let run = Self::new(data, summary, flights, (model, smoothing));
            if !run.flights.is_empty() {
                out.push(run);
            }
        }
        out
    }

    fn new(
        data: &Data,
        summary: &RecordingSummary,
        flights: Vec<Range<usize>>,
        (model, smoothing): (&Model, f64),
    ) -> Self {
        let recording = &data.recording;
        // Laws of height act at the distance from the ground, wherever the zero is.
        let zero = match &summary.level {
            Ok(level) if model.has_ground => level + model.parameters[ParameterId::Dp],
            _ => 0.0,
        };
        let mut readings = vec![recording.proof_mass.iter().map(|x| x - zero).collect()];
        let mut noise = vec![data.sigmas.xp];
        if let Some(xc) = &recording.cantilever {
            readings.push(xc.clone());
            noise.push(data.sigmas.xc);
        }
        let finite = |i: usize| readings.iter().all(|r: &Vec<f64>| r[i].is_finite());
        let flights: Vec<Range<usize>> = flights
            .into_iter()
            .flat_map(|f| {
                let indices: Vec<usize> = f.collect();
                let runs = indices.chunk_by(|a, b| finite(*a) && finite(*b));
                let whole = runs.filter(|run| finite(run[0]) && run.len() > 1);
                whole
                    .map(|run| run[0]..run[run.len() - 1] + 1)
                    .collect::<Vec<_>>()
            })
            .collect();
        let time = recording.time.clone();
        let near = EDGE_NODE_SHARE * recording.interval();
        let (mut nodes, mut sample_nodes) = (Vec::new(), Vec::with_capacity(time.len()));
        let mut edges: Vec<EdgeNodes> = Vec::new();
        let mut ahead = data.track.edges.iter().peekable();
        for (sample, &t) in time.iter().enumerate() {
            while let Some(edge) = ahead.next_if(|e| e.time <= t) {
                let last = nodes.last().copied();
                if sample > 0 && last.is_none_or(|last: f64| edge.time - near > last) {
                    edges.push(EdgeNodes {
                        time: edge.time,
                        sample,
                        before: nodes.len(),
                    });
                    nodes.extend([edge.time - near, (edge.time + near).min(t)]);
                }
            }
            sample_nodes.push(nodes.len());
            nodes.push(t);
        }
        let motion = smooth_motion(&time, &readings, &flights, smoothing, &nodes);
        Self {
            name: recording.name.clone(),
            time,
            readings,
            noise,
            flights,
            drive: data.track.pieces.clone(),
            edges,
            nodes,
            sample_nodes,
            motion,
        }
    }

    /// The motion at any time: cubic between the nodes, at rest beyond them.
    pub fn motion_at(&self, t: f64) -> Points {
        let after = self.nodes.partition_point(|n| *n < t);
        let (Some(b), Some(to)) = (self.motion.get(after), self.nodes.get(after)) else {
            return resting(self.motion.last());
        };
        let Some(before) = after.checked_sub(1) else {
            return if *to == t { *b } else { resting(Some(b)) };
        };
        let (a, from) = (self.motion[before], self.nodes[before]);
        let h = to - from;
        if h <= 0.0 || *to == t {
            return *b;
        }
        let s = (t - from) / h;
        let point = |x: (f64, f64), v: (f64, f64)| {
            let (d, v) = (x.1 - x.0, (v.0 * h, v.1 * h));
            let (c2, c3) = (3.0 * d - 2.0 * v.0 - v.1, v.0 + v.1 - 2.0 * d);
            (
                x.0 + s * (v.0 + s * (c2 + s * c3)),
                (v.0 + s * (2.0 * c2 + s * 3.0 * c3)) / h,
            )
        };
        let (xp, vp) = point((a.xp, b.xp), (a.vp, b.vp));
        let (xc, vc) = point((a.xc, b.xc), (a.vc, b.vc));
        Points { xp, vp, xc, vc }
    }
}

/// The same place at rest.
fn resting(last: Option<&Points>) -> Points {
    Points {
        vp: 0.0,
        vc: 0.0,
        ..last.copied().unwrap_or_default()
    }
}
