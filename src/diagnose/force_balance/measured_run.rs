//! One recording as a force balance sees it: the motion at each sample and on both sides of each
//! jump of the drive, and the flights in it.

use std::ops::Range;

use super::local_polynomial::smooth_motion;
use crate::diagnose::score_test::reading_scales::OWN_SCALE_SIGMA;
use crate::fit::inspect::recording_summary::RecordingSummary;
use crate::fit::problem::Data;
use crate::fit::problem::prepare::Prepared;
use crate::fit::residual::coloured_noise::Colour;
use crate::fit::segment::voltage_track::Track;
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
    /// The node just before it; the next one is just after it.
    pub before: usize,
    /// Standard deviation of the time \[s\].
    pub sigma: f64,
}

/// A recording with its motion.
#[derive(Debug, Clone)]
pub struct MeasuredRun {
    /// Times of the samples \[s\].
    pub time: Vec<f64>,
    /// Readings of the proof mass and, where read, of the cantilever \[m\], the proof mass's with
    /// the ground where the model has it.
    pub readings: Vec<Vec<f64>>,
    /// Standard deviation of the noise of the proof mass's \[m\].
    pub noise: f64,
    /// Prior standard deviation of the scale of its readings, relative to the other recordings.
    pub scale_sigma: f64,
    /// Flights without events, as samples.
    pub flights: Vec<Range<usize>>,
    /// Colour of their noise.
    pub colour: Colour,
    /// The drive as read.
    track: Track,
    /// By how much it acts later \[s\].
    pub skew: f64,
    /// Over which the motion is smoothed \[s\].
    smoothing: f64,
    /// The drive that acts.
    pub drive: Vec<Segment>,
    /// Jumps of the drive, in order of time.
    pub edges: Vec<EdgeNodes>,
    /// Times at which forces are evaluated \[s\]: some samples, and both sides of each jump.
    pub nodes: Vec<f64>,
    /// Those samples.
    pub thinned: Vec<usize>,
    /// The nodes of these.
    pub thinned_nodes: Vec<usize>,
    /// One sample in so many is a node.
    stride: usize,
    /// The motion there.
    pub motion: Vec<Points>,
}

impl MeasuredRun {
    /// The recordings that have flights, from their event-free segments, their motion smoothed over
    /// `smoothing` \[s\] and forces evaluated about every `spacing` \[s\].
    pub fn of_recordings(
        prepared: &Prepared,
        summaries: &[RecordingSummary],
        model: &Model,
        (smoothing, spacing): (f64, f64),
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
            let stride = ((spacing / data.recording.interval()) as usize).max(1);
            let run = Self::new(data, summary, flights, (model, smoothing, stride));
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
        (model, smoothing, stride): (&Model, f64, usize),
    ) -> Self {
        let recording = &data.recording;
        // Laws of height act at the distance from the ground, wherever the zero is.
        let zero = match &summary.level {
            Ok(level) if model.has_ground => level + model.parameters[ParameterId::Dp],
            _ => 0.0,
        };
        let mut readings: Vec<Vec<f64>> =
            vec![recording.proof_mass.iter().map(|x| x - zero).collect()];
        readings.extend(recording.cantilever.clone());
        let finite = |i: usize| readings[0][i].is_finite();
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
        let mut run = Self {
            time: recording.time.clone(),
            readings,
            noise: data.sigmas.xp,
            colour: data.sigmas.colour,
            scale_sigma: OWN_SCALE_SIGMA,
            flights,
            track: data.track.clone(),
            skew: 0.0,
            smoothing,
            drive: Vec::new(),
            edges: Vec::new(),
            nodes: Vec::new(),
            thinned: Vec::new(),
            thinned_nodes: Vec::new(),
            stride,
            motion: Vec::new(),
        };
        run.delay_drive(0.0);
        run
    }

    /// Lets the drive act later than it was read by `skew` \[s\].
    pub fn delay_drive(&mut self, skew: f64) {
        let time = &self.time;
        let near = EDGE_NODE_SHARE * (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
        let ends = self.flights.iter().flat_map(|f| [f.start, f.end - 1]);
        let mut thinned: Vec<usize> = (0..time.len()).step_by(self.stride).chain(ends).collect();
        thinned.sort_unstable();
        thinned.dedup();
        let (mut nodes, mut thinned_nodes) = (Vec::new(), Vec::with_capacity(thinned.len()));
        let mut edges: Vec<EdgeNodes> = Vec::new();
        let mut ahead = self.track.edges.iter().peekable();
        for &sample in &thinned {
            let t = time[sample];
            while let Some(edge) = ahead.next_if(|e| e.time + skew <= t) {
                let at = edge.time + skew;
                let last = nodes.last().copied();
                if last.is_some_and(|last: f64| at - near > last) {
                    edges.push(EdgeNodes {
                        time: at,
                        before: nodes.len(),
                        sigma: edge.sigma,
                    });
                    nodes.extend([at - near, (at + near).min(t)]);
                }
            }
            thinned_nodes.push(nodes.len());
            nodes.push(t);
        }
        self.motion = smooth_motion(time, &self.readings, &self.flights, self.smoothing, &nodes);
        let pieces = self.track.pieces.iter();
        self.drive = pieces.map(|p| p.shifted(skew)).collect();
        (self.skew, self.edges) = (skew, edges);
        (self.nodes, self.thinned, self.thinned_nodes) = (nodes, thinned, thinned_nodes);
    }

    /// By how much `values` \[at the nodes\] jump with the drive.
    pub fn jump(&self, edge: usize, values: &[f64]) -> f64 {
        let before = self.edges[edge].before;
        values[before + 1] - values[before]
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
