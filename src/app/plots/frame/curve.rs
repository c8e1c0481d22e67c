//! A curve against time: its series, its alignment and its style.

use std::sync::Arc;

use eframe::egui::Color32;

use super::style::THIN_LINE;
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

    /// Value as it is drawn.
    pub fn value(self, value: f64) -> f64 {
        value * self.scale + self.offset
    }
}

/// One curve of a picture against time; SI.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Its name in the readout.
    pub name: String,
    /// The series.
    pub pyramid: Arc<Pyramid>,
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
}

impl Curve {
    /// A thin, solid curve without shift and scale.
    pub fn new(name: impl Into<String>, pyramid: Arc<Pyramid>, color: Color32) -> Self {
        Self {
            name: name.into(),
            pyramid,
            placed: Placed::IDENTITY,
            color,
            width: THIN_LINE,
            dashed: false,
            dots: false,
            hidden: false,
            owner: None,
        }
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

    /// With a shift and scale.
    pub fn placed(mut self, placed: Placed) -> Self {
        self.placed = placed;
        self
    }

    /// Value at `t` \[s\].
    pub fn value_at(&self, t: f64) -> Option<f64> {
        let value = self.pyramid.value_at(t - self.placed.shift)?;
        Some(self.placed.value(value))
    }

    /// Least and greatest value from `from` to `to` \[s\].
    pub fn value_range(&self, from: f64, to: f64) -> Option<(f64, f64)> {
        let shift = self.placed.shift;
        let (low, high) = self.pyramid.value_range(from - shift, to - shift)?;
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
        let mut points = self.pyramid.draw(from - shift, to - shift, pixels);
        for [t, value] in &mut points {
            *t = (*t + shift) / time_unit;
            *value = self.placed.value(*value) / unit;
        }
        points
    }
}
