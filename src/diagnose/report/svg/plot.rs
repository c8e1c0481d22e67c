//! One pair of axes with what is drawn between them.

use super::axis::Axis;
use super::{Anchor, Svg};

/// Space for the labels of the y axis, and that of the x axis with its title.
const LEFT: f64 = 54.0;
const BOTTOM: f64 = 36.0;
/// Space for the title of the y axis, which stands above it.
const TOP: f64 = 24.0;
const RIGHT: f64 = 14.0;

/// A measured point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Where on the x axis.
    pub x: f64,
    /// Where on the y axis.
    pub y: f64,
    /// Standard error of `y`; no bar where it is not finite.
    pub error: f64,
}

/// A figure with one pair of axes.
#[derive(Debug)]
pub struct Plot {
    svg: Svg,
    x: Axis,
    y: Axis,
    from: [f64; 2],
    to: [f64; 2],
}

impl Plot {
    /// Axes with ticks, grid and titles in a figure of `size` pixels.
    pub fn new(size: [f64; 2], x: Axis, y: Axis) -> Self {
        let label = format!("{} against {}", y.title(), x.title());
        let mut svg = Svg::new(size[0], size[1], &label);
        let from = [LEFT, TOP];
        let to = [size[0] - RIGHT, size[1] - BOTTOM];
        svg.text("title", [2.0, 13.0], Anchor::Start, &y.title());
        let middle = 0.5 * (from[0] + to[0]);
        svg.text("title", [middle, size[1] - 5.0], Anchor::Middle, &x.title());
        let mut plot = Self {
            svg,
            x,
            y,
            from,
            to,
        };
        plot.grid();
        plot
    }

    fn grid(&mut self) {
        let ([left, top], [right, bottom]) = (self.from, self.to);
        for (value, label) in self.y.ticks(((bottom - top) / 34.0) as usize) {
            let y = self.y_of(value);
            self.svg.segment("grid", [left, y], [right, y]);
            self.svg
                .text("tick", [left - 6.0, y + 4.0], Anchor::End, &label);
        }
        for (value, label) in self.x.ticks(((right - left) / 64.0) as usize) {
            let x = self.x_of(value);
            self.svg.segment("axis", [x, bottom], [x, bottom + 4.0]);
            self.svg
                .text("tick", [x, bottom + 16.0], Anchor::Middle, &label);
        }
        self.svg.segment("axis", [left, bottom], [right, bottom]);
        self.svg.segment("axis", [left, top], [left, bottom]);
    }

    fn x_of(&self, value: f64) -> f64 {
        self.from[0] + self.x.place(value) * (self.to[0] - self.from[0])
    }

    fn y_of(&self, value: f64) -> f64 {
        self.to[1] - self.y.place(value) * (self.to[1] - self.from[1])
    }

    /// A line through `(x, y)`.
    pub fn line(&mut self, class: &str, points: impl IntoIterator<Item = (f64, f64)>) {
        let places: Vec<[f64; 2]> = points
            .into_iter()
            .map(|(x, y)| [self.x_of(x), self.y_of(y)])
            .collect();
        self.svg.line(class, places);
    }

    /// The area within one standard error of points in order; those without an error are left out.
    pub fn band(&mut self, class: &str, dots: &[Dot]) {
        let known = dots
            .iter()
            .filter(|d| d.y.is_finite() && d.error.is_finite());
        let known: Vec<&Dot> = known.collect();
        if known.len() < 2 {
            return;
        }
        let upper = known.iter().map(|d| (d.x, d.y + d.error));
        let lower = known.iter().rev().map(|d| (d.x, d.y - d.error));
        let ends: Vec<(f64, f64)> = upper.chain(lower).collect();
        self.line(class, ends);
    }

    /// Points with error bars of one standard error each way.
    pub fn dots(&mut self, class: &str, radius: f64, dots: impl IntoIterator<Item = Dot>) {
        for dot in dots {
            let at = [self.x_of(dot.x), self.y_of(dot.y)];
            if !(at[0].is_finite() && at[1].is_finite()) {
                continue;
            }
            if dot.error.is_finite() && dot.error > 0.0 {
                let ends = [dot.y - dot.error, dot.y + dot.error].map(|y| [at[0], self.y_of(y)]);
                self.svg.segment(&format!("bar {class}"), ends[0], ends[1]);
            }
            self.svg.dot(class, at, radius);
        }
    }

    /// A level across the figure, if it lies within.
    pub fn level(&mut self, class: &str, y: f64) {
        if (self.y.from()..=self.y.to()).contains(&y) {
            let at = self.y_of(y);
            self.svg
                .segment(class, [self.from[0], at], [self.to[0], at]);
        }
    }

    /// The whole figure.
    pub fn finish(self) -> String {
        self.svg.finish()
    }
}
