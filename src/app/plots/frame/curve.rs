//! A curve against time: its series, its alignment and its style.

use std::sync::Arc;

use eframe::egui::Color32;

use super::style::THIN_LINE;
use crate::app::plots::event_corners::EventCorners;
use crate::app::setup::overlay::OverlayId;
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::recording::Channel;
use crate::recording::align::Alignment;

/// How a series is drawn: at `time + shift`, with `value * scale + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    shift: f64,
    scale: f64,
    offset: f64,
}

impl Placed {
    /// Without shift and scale.
    pub const IDENTITY: Self = Self {
        shift: 0.0,
        scale: 1.0,
        offset: 0.0,
    };

    /// The alignment of a recording's channel.
    pub fn aligned(alignment: &Alignment, channel: Channel) -> Self {
        let offset = alignment.value(channel, 0.0);
        Self {
            shift: alignment.time_shift,
            scale: alignment.value(channel, 1.0) - offset,
            offset,
        }
    }

    /// Multiplied by `scale`.
    pub fn scaled(scale: f64) -> Self {
        Self {
            scale,
            ..Self::IDENTITY
        }
    }

    /// Value as it is drawn.
    pub fn value(self, value: f64) -> f64 {
        value * self.scale + self.offset
    }
}

/// The key of all lines of a kept curve in `View::switched_curves`.
pub fn kept_key(name: &str) -> String {
    format!("kept: {name}")
}

/// One curve of a picture against time; SI.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Its name in the readout.
    pub name: String,
    /// The series.
    pub pyramid: Arc<Pyramid>,
    /// Points of the line at events between the samples.
    pub corners: Option<Arc<EventCorners>>,
    /// Its shift and scale.
    pub placed: Placed,
    /// Its colour.
    pub color: Color32,
    /// Its width \[points\].
    pub width: f32,
    /// Whether it is dashed, unless it is too dense.
    pub dashed: bool,
    /// Whether its samples are drawn as dots where they are far enough apart.
    pub dots: bool,
    /// Whether only its name is shown, in the readout.
    pub hidden: bool,
    /// The recording it belongs to.
    pub owner: Option<OverlayId>,
    /// The kept curve it belongs to. All lines of one are shown and hidden together.
    pub kept: Option<String>,
    /// Whether it is drawn beyond the moment that a picture has come to.
    pub is_whole: bool,
}

impl Curve {
    /// A thin, solid curve without shift and scale.
    pub fn new(name: impl Into<String>, pyramid: Arc<Pyramid>, color: Color32) -> Self {
        Self {
            name: name.into(),
            pyramid,
            corners: None,
            placed: Placed::IDENTITY,
            color,
            width: THIN_LINE,
            dashed: false,
            dots: false,
            hidden: false,
            owner: None,
            kept: None,
            is_whole: false,
        }
    }

    /// Drawn whole, also where a picture shows a run only up to a moment.
    pub fn whole(mut self) -> Self {
        self.is_whole = true;
        self
    }

    /// Through the events of its run.
    pub fn through(mut self, corners: Arc<EventCorners>) -> Self {
        self.corners = Some(corners);
        self
    }

    /// With another width.
    pub fn width(mut self, width: f32) -> Self {
        self.width = width;
        self
    }

    /// Dashed.
    pub fn dashed(mut self) -> Self {
        self.dashed = true;
        self
    }

    /// With dots for samples.
    pub fn dots(mut self) -> Self {
        self.dots = true;
        self
    }

    /// Hidden until the person shows it.
    pub fn hidden(mut self) -> Self {
        self.hidden = true;
        self
    }

    /// Belonging to a recording.
    pub fn owned(mut self, owner: OverlayId) -> Self {
        self.owner = Some(owner);
        self
    }

    /// A line of the kept curve of this name, dashed.
    pub fn of_kept(mut self, name: &str) -> Self {
        self.kept = Some(name.to_owned());
        self.dashed()
    }

    /// With a shift and scale.
    pub fn placed(mut self, placed: Placed) -> Self {
        self.placed = placed;
        self
    }

    /// Value at `t` \[s\].
    pub fn value_at(&self, t: f64) -> Option<f64> {
        let t = t - self.placed.shift;
        let at_event = self.corners.as_ref().and_then(|c| c.value_at(t));
        let value = at_event.or_else(|| self.pyramid.value_at(t))?;
        Some(self.placed.value(value))
    }

    /// Least and greatest value from `from` to `to` \[s\].
    pub fn value_range(&self, from: f64, to: f64) -> Option<(f64, f64)> {
        let shift = self.placed.shift;
        let (mut low, mut high) = self.pyramid.value_range(from - shift, to - shift)?;
        if let Some(corners) = &self.corners {
            for [_, value] in corners.events(from - shift, to - shift) {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        let (a, b) = (self.placed.value(low), self.placed.value(high));
        Some((a.min(b), a.max(b)))
    }

    /// The line from `from` to `to` \[s\] in units of `time_unit` \[s\] and `unit`.
    pub fn draw(
        &self,
        (from, to): (f64, f64),
        pixels: usize,
        (time_unit, unit): (f64, f64),
    ) -> Vec<[f64; 2]> {
        let shift = self.placed.shift;
        let points = self.pyramid.draw(from - shift, to - shift, pixels);
        let mut points = self.with_corners(points, (from - shift, to - shift), pixels);
        for [t, value] in &mut points {
            *t = (*t + shift) / time_unit;
            *value = self.placed.value(*value) / unit;
        }
        points
    }

    /// The line with the points at events. With more events than pixels they cannot be seen.
    fn with_corners(
        &self,
        points: Vec<[f64; 2]>,
        (from, to): (f64, f64),
        pixels: usize,
    ) -> Vec<[f64; 2]> {
        let Some(corners) = &self.corners else {
            return points;
        };
        let events: Vec<[f64; 2]> = corners.events(from, to).take(pixels + 1).collect();
        if events.is_empty() || events.len() > pixels {
            return points;
        }
        let mut events = events.into_iter().peekable();
        let mut line: Vec<[f64; 2]> = Vec::with_capacity(points.len() + events.len());
        for point in points {
            // `[NaN, NaN]` breaks the line, and nothing is drawn in a break.
            while let Some(event) = events.next_if(|event| event[0] <= point[0]) {
                let is_between = line.last().is_some_and(|last| last[0] < event[0]);
                if is_between && event[0] < point[0] {
                    line.push(event);
                }
            }
            line.push(point);
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::*;
    use crate::sim::{Event, EventKind, Trace};

    #[test]
    fn an_impact_between_two_samples_is_drawn_at_its_time() {
        let event = Event {
            time: 24e-6,
            kind: EventKind::Impact,
            velocity_before: -1e-3,
            velocity_after: 5e-4,
            pull_off_force: 0.0,
            contact_duration: 0.0,
        };
        let trace = Trace {
            dt: 20e-6,
            proof_mass: vec![24e-9, 4e-9, 8e-9, 18e-9],
            proof_mass_velocity: vec![-1e-3, -1e-3, 5e-4, 5e-4],
            events: vec![event],
            ..Trace::default()
        };
        let pyramid = Arc::new(Pyramid::new(trace.t0, trace.dt, &trace.proof_mass));
        let curve = Curve::new("xp", pyramid, Color32::WHITE);
        let whole = (0.0, 60e-6);
        let blunt = curve.draw(whole, 1000, (1.0, 1.0));
        let lowest = |line: &[[f64; 2]]| line.iter().map(|p| p[1]).fold(f64::MAX, f64::min);
        assert_eq!(lowest(&blunt), 4e-9);
        let sharp = curve.through(Arc::new(EventCorners::of(&trace)));
        let line = sharp.draw(whole, 1000, (1.0, 1.0));
        assert_eq!(line.len(), blunt.len() + 1);
        assert!(line.windows(2).all(|p| p[0][0] < p[1][0]), "{line:?}");
        assert!(lowest(&line).abs() < 1e-18, "{line:?}");
        assert!(sharp.value_at(24e-6).unwrap().abs() < 1e-18);
        assert!(sharp.value_range(0.0, 60e-6).unwrap().0.abs() < 1e-18);
    }
}
