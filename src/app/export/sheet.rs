//! The visible pictures as plain data for export: the same ranges, units and curves as on
//! the screen, independent of the window, in the colours for white paper.

use eframe::egui::{Color32, Context, RawInput, Ui};

use crate::app::analysis::recording_noise;
use crate::app::plots::frame::axes::Unit;
use crate::app::plots::frame::layer::Mark;
use crate::app::plots::frame::style::Palette;
use crate::app::plots::frame::time_plot::TimePlot;
use crate::app::plots::frame::xy::XyPlot;
use crate::app::plots::frame::{axes, style, time_plot, time_window};
use crate::app::plots::{describe, plane};
use crate::app::setup::view::Picture;
use crate::app::state::State;
use crate::app::theme;

/// Longest wait for the noise of long recordings \[s\].
const MAX_NOISE_WAIT: f64 = 2.0;
/// Smallest space between two ticks, horizontal and vertical \[points\].
const TICK_SPACING: [f64; 2] = [80.0, 28.0];

/// All visible pictures except the device's.
#[derive(Debug, Clone, Default)]
pub struct Sheet {
    /// Pictures over the whole width with a common time axis, from top to bottom.
    pub stacked: Vec<Panel>,
    /// Pictures side by side below them.
    pub row: Vec<Panel>,
    /// Background.
    pub background: Color32,
    /// Axes and their text.
    pub text: Color32,
    /// Lines of the grid.
    pub grid: Color32,
}

/// An axis in the unit on its label.
#[derive(Debug, Clone)]
pub struct Scale {
    /// `quantity [unit]`.
    pub label: String,
    /// Smallest and largest value shown.
    pub range: (f64, f64),
    /// Positions and texts of the ticks.
    pub ticks: Vec<(f64, String)>,
}

/// A line with its name; `[NaN, NaN]` breaks it.
#[derive(Debug, Clone)]
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// In the units of the axes.
    pub points: Vec<[f64; 2]>,
    /// Its colour.
    pub color: Color32,
    /// Its width \[points\].
    pub width: f32,
    /// Whether it is dashed.
    pub dashed: bool,
}

/// One picture; all positions are in the units of its axes.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Which picture.
    pub picture: Picture,
    /// Horizontal axis.
    pub x: Scale,
    /// Vertical axis.
    pub y: Scale,
    /// Height inside its axes \[points\].
    pub height: f64,
    /// Lines, from back to front.
    pub lines: Vec<Line>,
    /// Named horizontal lines.
    pub levels: Vec<(f64, &'static str, Color32)>,
    /// Half heights of shaded bands around zero, with their colours.
    pub bands: Vec<(f64, Color32)>,
    /// Time spans in contact.
    pub contacts: Vec<(f64, f64)>,
    /// Their colour.
    pub contact_color: Color32,
    /// Events.
    pub marks: Vec<(Mark, Color32, [f64; 2])>,
    /// Text shown instead of curves.
    pub message: Option<String>,
}

impl Sheet {
    /// Whether there is no picture.
    pub fn is_empty(&self) -> bool {
        self.stacked.is_empty() && self.row.is_empty()
    }

    /// The visible pictures, for a sheet whose axes are `width` points wide.
    pub fn of(state: &State, width: f64) -> Self {
        // The pictures are described to a hidden window of its own.
        let context = Context::default();
        // Exports go into documents, so they are light whatever the theme of the window.
        theme::apply(&context, false);
        let started = std::time::Instant::now();
        loop {
            let (mut sheet, mut waiting) = (Self::default(), false);
            let mut output = context.run_ui(RawInput::default(), |ui| {
                waiting = is_waiting(ui, state);
                sheet = Self::described(ui, state, width);
            });
            // Nobody draws its text.
            output.textures_delta.clear();
            if !waiting || started.elapsed().as_secs_f64() > MAX_NOISE_WAIT {
                return sheet;
            }
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
    }

    fn described(ui: &Ui, state: &State, width: f64) -> Self {
        let palette = style::palette(ui);
        let window = time_window::in_view(state);
        let (plots, _) = describe(ui, state);
        let stacked = plots
            .into_iter()
            .map(|plot| Panel::of_time(plot, window, width, palette))
            .collect();
        let planes: Vec<Picture> = [Picture::PhasePortrait, Picture::DriveLoop]
            .into_iter()
            .filter(|picture| state.view.pictures.contains(picture))
            .collect();
        let part = width / planes.len().max(1) as f64;
        let row = planes
            .into_iter()
            .map(|picture| {
                let size = [part as f32, PLANE_HEIGHT as f32];
                Panel::of_plane(plane(ui, state, picture, size), part, palette)
            })
            .collect();
        Self {
            stacked,
            row,
            background: ui.visuals().extreme_bg_color,
            text: palette.text,
            grid: palette.grid,
        }
    }
}

/// Height of pictures without a time axis \[points\].
const PLANE_HEIGHT: f64 = 320.0;

/// Whether the noise of a visible recording is still being estimated.
fn is_waiting(ui: &Ui, state: &State) -> bool {
    if !state.view.pictures.contains(&Picture::Residual) {
        return false;
    }
    let visible = state.setup.overlays.iter().filter(|o| o.visible);
    // The first question starts the estimate, so every recording must be asked.
    visible
        .filter(|o| recording_noise::is_pending(ui, o))
        .count()
        > 0
}

impl Scale {
    fn new(label: String, range: (f64, f64), points: f64, spacing: f64) -> Self {
        Self {
            label,
            range,
            ticks: axes::ticks(range.0, range.1, points / spacing),
        }
    }
}

impl Panel {
    fn of_time(plot: TimePlot, window: (f64, f64), width: f64, palette: &Palette) -> Self {
        let time = Unit::of_times(window.0, window.1);
        let (low, high) = plot.range(window);
        let unit = Unit::of_range(plot.base, low, high);
        let columns = (2.0 * width) as usize;
        let at = |[t, value]: [f64; 2]| [t / time.factor, value / unit.factor];
        let lines = plot.drawn().map(|curve| Line {
            name: curve.name.clone(),
            points: curve.draw(window, columns, (time.factor, unit.factor)),
            color: curve.color,
            width: curve.width,
            dashed: curve.dashed,
        });
        let contacts = plot.contacts.iter().flat_map(|trace| {
            time_plot::contact_stretches(trace, window, columns)
                .into_iter()
                .map(|(a, b)| (a / time.factor, b / time.factor))
        });
        let marks = plot.events.iter().flat_map(|(trace, curve)| {
            time_plot::event_marks(trace, curve, window, width as usize, palette)
                .into_iter()
                .map(|(mark, color, place)| (mark, color, at(place)))
        });
        let height = match plot.picture {
            Picture::Trajectory => 320.0,
            Picture::Forces => 240.0,
            Picture::Residual => 180.0,
            _ => 110.0,
        };
        Self {
            picture: plot.picture,
            x: Scale::new(
                time.label("time t"),
                (window.0 / time.factor, window.1 / time.factor),
                width,
                TICK_SPACING[0],
            ),
            y: Scale::new(
                unit.label(plot.quantity),
                (low / unit.factor, high / unit.factor),
                height,
                TICK_SPACING[1],
            ),
            height,
            lines: lines.collect(),
            levels: (plot.levels.iter())
                .map(|level| (level.value / unit.factor, level.text, level.color))
                .collect(),
            bands: (plot.bands.iter())
                .map(|&(half, color)| (half / unit.factor, color))
                .collect(),
            contacts: contacts.collect(),
            contact_color: palette.contact,
            marks: marks.collect(),
            message: plot.message.clone(),
        }
    }

    fn of_plane(plot: XyPlot, width: f64, palette: &Palette) -> Self {
        let units = plot
            .axes
            .map(|axis| Unit::of_range(axis.base, axis.range.0, axis.range.1));
        let scale = |i: usize, points, spacing| {
            let (axis, unit): (_, &Unit) = (plot.axes[i], &units[i]);
            let range = (axis.range.0 / unit.factor, axis.range.1 / unit.factor);
            Scale::new(unit.label(axis.quantity), range, points, spacing)
        };
        let lines = plot.lines.iter().map(|line| Line {
            name: line.name.clone(),
            points: (line.points.iter())
                .map(|p| [p[0] / units[0].factor, p[1] / units[1].factor])
                .collect(),
            color: line.stroke.color,
            width: line.stroke.width,
            dashed: line.dashed,
        });
        Self {
            picture: plot.picture,
            x: scale(0, width, TICK_SPACING[0]),
            y: scale(1, PLANE_HEIGHT, TICK_SPACING[1]),
            height: PLANE_HEIGHT,
            lines: lines.collect(),
            levels: Vec::new(),
            bands: Vec::new(),
            contacts: Vec::new(),
            contact_color: palette.contact,
            marks: Vec::new(),
            message: None,
        }
    }
}
