//! Lays out and draws a page of pictures with legends, axes and lines.

use eframe::egui::Color32;
use plotters::prelude::DrawingBackend;

use super::canvas::{Anchor, Canvas, Frame, Place, text_width};
use super::error::ExportError;
use super::sheet::{Line, Panel, Sheet};
use crate::app::plots::frame::layer::Mark;

/// Text size of axes and legends \[points\].
const TEXT_SIZE: f64 = 12.0;
/// Space around the page \[points\].
const PAGE_MARGIN: f64 = 14.0;
/// Width for ticks and label of a vertical axis \[points\].
const AXIS_WIDTH: f64 = 72.0;
/// Height for ticks and label of a horizontal axis \[points\].
const AXIS_HEIGHT: f64 = 44.0;
/// Height of one row of a legend \[points\].
const LEGEND_ROW: f64 = 18.0;
/// Space between pictures \[points\].
const PICTURE_GAP: f64 = 12.0;

/// The sign next to a name in a legend.
enum Sign {
    Line(Color32, f64, bool),
    Area(Color32),
    Mark(Mark, Color32),
}

/// A name in a legend, with its position \[points\].
struct Entry {
    sign: Sign,
    name: String,
    at: Place,
}

/// A picture with its position on the page.
struct Placed<'a> {
    panel: &'a Panel,
    frame: Frame,
    legend: Vec<Entry>,
    /// Whether its horizontal axis is drawn.
    has_x_axis: bool,
}

/// A laid-out page.
pub struct Page<'a> {
    sheet: &'a Sheet,
    pictures: Vec<Placed<'a>>,
    /// Width and height \[points\].
    pub size: [f64; 2],
}

impl<'a> Page<'a> {
    /// Lays out a sheet whose axes are `width` points wide.
    pub fn new(sheet: &'a Sheet, width: f64) -> Result<Self, ExportError> {
        let mut pictures = Vec::new();
        let mut top = PAGE_MARGIN;
        let left = PAGE_MARGIN + AXIS_WIDTH;
        let last = sheet.stacked.len().saturating_sub(1);
        for (i, panel) in sheet.stacked.iter().enumerate() {
            let picture = place(panel, [left, top], width, None, i == last)?;
            top = picture.frame.max[1] + PICTURE_GAP + if i == last { AXIS_HEIGHT } else { 0.0 };
            pictures.push(picture);
        }
        let count = sheet.row.len().max(1) as f64;
        let part = (width - (count - 1.0) * (AXIS_WIDTH + PICTURE_GAP)) / count;
        let mut rows = 0;
        for panel in &sheet.row {
            rows = rows.max(legend(panel, [0.0, 0.0], part)?.1);
        }
        for (i, panel) in sheet.row.iter().enumerate() {
            let corner = [left + i as f64 * (part + AXIS_WIDTH + PICTURE_GAP), top];
            pictures.push(place(panel, corner, part, Some(rows), true)?);
        }
        if let Some(picture) = pictures.last().filter(|_| !sheet.row.is_empty()) {
            top = picture.frame.max[1] + AXIS_HEIGHT + PICTURE_GAP;
        }
        let height = (top - PICTURE_GAP + PAGE_MARGIN).ceil();
        Ok(Self {
            sheet,
            pictures,
            size: [(left + width + PAGE_MARGIN + 10.0).ceil(), height],
        })
    }

    /// Draws it.
    pub fn draw<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Result<(), ExportError> {
        let whole = Frame {
            min: [0.0, 0.0],
            max: self.size,
        };
        canvas.fill(whole, self.sheet.background)?;
        for picture in &self.pictures {
            picture.draw(canvas, self.sheet)?;
        }
        canvas.finish()
    }
}

/// Places a picture with its legend at a corner. The legend has `rows` rows if given.
fn place(
    panel: &Panel,
    corner: Place,
    width: f64,
    rows: Option<usize>,
    has_x_axis: bool,
) -> Result<Placed<'_>, ExportError> {
    let (legend, own) = legend(panel, corner, width)?;
    let top = corner[1] + rows.unwrap_or(own) as f64 * LEGEND_ROW;
    Ok(Placed {
        panel,
        frame: Frame {
            min: [corner[0], top],
            max: [corner[0] + width, top + panel.height],
        },
        legend,
        has_x_axis,
    })
}

/// The entries of a legend, row by row, and the number of rows.
fn legend(panel: &Panel, corner: Place, width: f64) -> Result<(Vec<Entry>, usize), ExportError> {
    let line = |line: &Line| Sign::Line(line.color, f64::from(line.width), line.dashed);
    let mut all: Vec<(Sign, String)> = panel
        .lines
        .iter()
        .map(|l| (line(l), l.name.clone()))
        .collect();
    if let Some(&(_, color)) = panel.bands.first() {
        all.push((Sign::Area(color), "\u{b1} noise".to_owned()));
    }
    if !panel.contacts.is_empty() {
        all.push((Sign::Area(panel.contact_color), "in contact".to_owned()));
    }
    for (kind, name) in [
        (Mark::Impact, "bounce"),
        (Mark::Stick, "stick"),
        (Mark::Release, "release"),
    ] {
        if let Some(&(_, color, _)) = panel.marks.iter().find(|mark| mark.0 == kind) {
            all.push((Sign::Mark(kind, color), name.to_owned()));
        }
    }
    let (mut x, mut row) = (0.0, 0);
    let mut entries = Vec::new();
    for (sign, name) in all {
        let length = 24.0 + text_width(&name, TEXT_SIZE)? + 18.0;
        if x > 0.0 && x + length > width {
            (x, row) = (0.0, row + 1);
        }
        let at = [corner[0] + x, corner[1] + (row as f64 + 0.4) * LEGEND_ROW];
        entries.push(Entry { sign, name, at });
        x += length;
    }
    let rows = if entries.is_empty() { 0 } else { row + 1 };
    Ok((entries, rows))
}

/// Corners of a marker.
fn corners(mark: Mark, [x, y]: Place) -> Vec<Place> {
    /// Half width of a marker [points].
    const R: f64 = 4.0;
    let corners: &[Place] = match mark {
        Mark::Impact => &[[-R, -R], [R, -R], [0.0, R]],
        Mark::Release => &[[-R, R], [0.0, -R], [R, R]],
        Mark::Stick => &[[-R, -R], [R, -R], [R, R], [-R, R]],
    };
    corners.iter().map(|c| [x + c[0], y + c[1]]).collect()
}

impl Placed<'_> {
    /// Position of a point given in the units of the axes.
    fn at(&self, [x, y]: [f64; 2]) -> Place {
        let (Frame { min, max }, panel) = (self.frame, self.panel);
        let share = |value: f64, (low, high): (f64, f64)| (value - low) / (high - low);
        [
            min[0] + share(x, panel.x.range) * (max[0] - min[0]),
            max[1] - share(y, panel.y.range) * (max[1] - min[1]),
        ]
    }

    fn draw<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        sheet: &Sheet,
    ) -> Result<(), ExportError> {
        self.areas(canvas)?;
        self.axes(canvas, sheet)?;
        for (value, name, color) in &self.panel.levels {
            self.level(canvas, *value, name, *color)?;
        }
        for line in &self.panel.lines {
            self.line(canvas, line)?;
        }
        for &(mark, color, point) in &self.panel.marks {
            let at = self.at(point);
            if self.frame.clip(at, at).is_some() {
                canvas.polygon(&corners(mark, at), color)?;
            }
        }
        if let Some(message) = &self.panel.message {
            let Frame { min, max } = self.frame;
            let middle = [0.5 * (min[0] + max[0]), 0.5 * (min[1] + max[1])];
            canvas.text(message, middle, TEXT_SIZE, sheet.text, Anchor::Middle)?;
        }
        for entry in &self.legend {
            entry.draw(canvas, sheet.text)?;
        }
        Ok(())
    }

    /// Shades contacts and noise.
    fn areas<B: DrawingBackend>(&self, canvas: &mut Canvas<B>) -> Result<(), ExportError> {
        let Frame { min, max } = self.frame;
        for &(start, end) in &self.panel.contacts {
            let x = [start, end].map(|t| self.at([t, 0.0])[0].clamp(min[0], max[0]));
            let frame = Frame {
                min: [x[0], min[1]],
                max: [x[1].max(x[0] + 0.5), max[1]],
            };
            canvas.fill(frame, self.panel.contact_color)?;
        }
        for &(half, color) in &self.panel.bands {
            let y = [half, -half].map(|v| self.at([0.0, v])[1].clamp(min[1], max[1]));
            let frame = Frame {
                min: [min[0], y[0]],
                max: [max[0], y[1]],
            };
            canvas.fill(frame, color)?;
        }
        Ok(())
    }

    fn axes<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        sheet: &Sheet,
    ) -> Result<(), ExportError> {
        let Frame { min, max } = self.frame;
        let grid = sheet.grid.gamma_multiply(0.35);
        for (value, text) in &self.panel.x.ticks {
            let x = self.at([*value, 0.0])[0];
            canvas.line(&[[x, min[1]], [x, max[1]]], grid, 0.6)?;
            if self.has_x_axis {
                let at = [x, max[1] + 11.0];
                canvas.text(text, at, TEXT_SIZE, sheet.text, Anchor::Middle)?;
            }
        }
        for (value, text) in &self.panel.y.ticks {
            let y = self.at([0.0, *value])[1];
            canvas.line(&[[min[0], y], [max[0], y]], grid, 0.6)?;
            let at = [min[0] - 6.0, y];
            canvas.text(text, at, TEXT_SIZE, sheet.text, Anchor::Right)?;
        }
        let outline = [min, [max[0], min[1]], max, [min[0], max[1]], min];
        canvas.line(&outline, sheet.grid, 0.8)?;
        if self.has_x_axis {
            let at = [0.5 * (min[0] + max[0]), max[1] + 30.0];
            canvas.text(
                &self.panel.x.label,
                at,
                TEXT_SIZE,
                sheet.text,
                Anchor::Middle,
            )?;
        }
        let at = [min[0] - AXIS_WIDTH + 12.0, 0.5 * (min[1] + max[1])];
        canvas.text(
            &self.panel.y.label,
            at,
            TEXT_SIZE,
            sheet.text,
            Anchor::Upwards,
        )
    }

    fn level<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        value: f64,
        name: &str,
        color: Color32,
    ) -> Result<(), ExportError> {
        let Frame { min, max } = self.frame;
        let y = self.at([0.0, value])[1];
        if !(min[1]..=max[1]).contains(&y) {
            return Ok(());
        }
        canvas.line(&[[min[0], y], [max[0], y]], color, 1.0)?;
        if name.is_empty() {
            return Ok(());
        }
        // Below the line if there is room, above it otherwise.
        let shift = if max[1] - y > 17.0 { 8.0 } else { -8.0 };
        let at = [max[0] - 6.0, y + shift];
        canvas.text(name, at, TEXT_SIZE, color, Anchor::Right)
    }

    /// Draws the parts of a line that lie inside the frame.
    fn line<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        line: &Line,
    ) -> Result<(), ExportError> {
        let mut pieces: Vec<Vec<Place>> = Vec::new();
        for piece in line.points.split(|point| point[0].is_nan()) {
            if let [only] = piece {
                let [x, y] = self.at(*only);
                if self.frame.clip([x, y], [x, y]).is_some() {
                    pieces.push(vec![[x - 1.0, y], [x + 1.0, y]]);
                }
            }
            for pair in piece.windows(2) {
                let Some((a, b)) = self.frame.clip(self.at(pair[0]), self.at(pair[1])) else {
                    continue;
                };
                match pieces.last_mut() {
                    Some(last) if last.last() == Some(&a) => last.push(b),
                    _ => pieces.push(vec![a, b]),
                }
            }
        }
        let width = f64::from(line.width);
        for piece in pieces {
            if line.dashed {
                canvas.dashed(&piece, line.color, width)?;
            } else {
                canvas.line(&piece, line.color, width)?;
            }
        }
        Ok(())
    }
}

impl Entry {
    fn draw<B: DrawingBackend>(
        &self,
        canvas: &mut Canvas<B>,
        text: Color32,
    ) -> Result<(), ExportError> {
        let [x, y] = self.at;
        let ends = [[x, y], [x + 18.0, y]];
        match self.sign {
            Sign::Line(color, width, false) => canvas.line(&ends, color, width.max(1.5))?,
            Sign::Line(color, width, true) => canvas.dashed(&ends, color, width.max(1.5))?,
            Sign::Area(color) => {
                let frame = Frame {
                    min: [x, y - 5.0],
                    max: [x + 18.0, y + 5.0],
                };
                canvas.fill(frame, color)?;
            }
            Sign::Mark(mark, color) => canvas.polygon(&corners(mark, [x + 9.0, y]), color)?,
        }
        canvas.text(&self.name, [x + 24.0, y], TEXT_SIZE, text, Anchor::Left)
    }
}
