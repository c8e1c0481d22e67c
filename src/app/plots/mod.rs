//! The pictures of the Tune workspace, stacked; each has a file.

pub mod device;
mod drive_loop;
mod event_corners;
pub(crate) mod explore;
mod forces;
pub mod frame;
mod multiples;
mod phase_portrait;
mod residual;
pub(crate) mod stage;
#[cfg(test)]
mod tests;
mod trajectory;
pub(crate) mod value_range;
mod voltage;

use eframe::egui::{Id, Key, Popup, Rect, RichText, ScrollArea, Ui, Vec2, vec2};

use self::frame::readout::Readout;
use self::frame::time_plot::{Common, TIME_AXIS_HEIGHT, TimePlot};
use self::multiples::Multiples;
use super::setup::view::Picture;
use super::state::{Cursors, State};

/// Space between two pictures \[points\].
const PICTURE_SPACING: f32 = 6.0;
/// Height of the line of text that replaces an empty picture \[points\].
const MESSAGE_HEIGHT: f32 = 20.0;
/// Smallest height of the pictures without a time axis \[points\].
const MIN_XY_HEIGHT: f32 = 190.0;

/// Smallest height of the device \[points\]: five lines of text.
const MIN_DEVICE_HEIGHT: f32 = 110.0;

/// What is drawn in a frame.
struct Content {
    /// Pictures against time, one above the other.
    plots: Vec<TimePlot>,
    /// In their place: a panel for each recording.
    multiples: Option<Multiples>,
    /// Pictures in a plane.
    planes: Vec<Picture>,
    /// Texts in place of empty pictures.
    lines: Vec<String>,
    readout: Readout,
}

/// Heights of what is drawn \[points\].
struct Layout {
    /// Device and pictures against time.
    heights: Vec<(Picture, f32)>,
    /// All panels of the recordings.
    panels: f32,
    /// Each picture in a plane.
    plane: f32,
}

impl Content {
    fn of(ui: &Ui, state: &State) -> Self {
        let multiples = multiples::describe(ui, state);
        let (plots, lines) = match &multiples {
            Some(multiples) => (Vec::new(), multiples.lines.clone()),
            None => describe(ui, state),
        };
        let readout = match &multiples {
            Some(multiples) => Readout::of(ui, state, &multiples.plots()),
            None => Readout::of(ui, state, &plots),
        };
        let driven = state.setup.preset.model.piezo.is_some();
        let planes = [Picture::PhasePortrait, Picture::DriveLoop]
            .into_iter()
            .filter(|picture| state.view.pictures.contains(picture))
            .filter(|&picture| driven || picture != Picture::DriveLoop)
            .collect::<Vec<_>>();
        Self {
            plots,
            multiples,
            planes,
            lines,
            readout,
        }
    }

    /// Whether something is drawn against time.
    fn has_times(&self) -> bool {
        !self.plots.is_empty() || self.multiples.is_some()
    }

    /// How it shares a place of `space` points.
    fn layout(&self, ui: &Ui, has_device: bool, space: Vec2) -> Layout {
        // With pictures below the time plots there is less room for the device.
        let tallest = if self.planes.is_empty() { 200.0 } else { 150.0 };
        let is_alone = !self.has_times() && self.planes.is_empty();
        let texts = self.lines.len() as f32 * (MESSAGE_HEIGHT + PICTURE_SPACING);
        let mut rest = space.y - texts - 2.0 * PICTURE_SPACING;
        let device_height = match has_device {
            false => 0.0,
            true if is_alone => rest.max(MIN_DEVICE_HEIGHT),
            true => (0.24 * space.y).clamp(MIN_DEVICE_HEIGHT, tallest),
        };
        if has_device {
            rest -= device_height + PICTURE_SPACING;
        }
        if self.has_times() {
            rest -= self.readout.height(space.x);
        }
        if !self.plots.is_empty() {
            rest -= TIME_AXIS_HEIGHT;
        }
        let in_plots = self.plots.iter().any(|p| p.picture == Picture::Residual);
        let in_panels = self.multiples.as_ref().and_then(Multiples::residual_range);
        if in_plots || in_panels.is_some() {
            rest -= residual::header_height(space.x);
        }
        let plane = if self.has_times() {
            (0.26 * space.y).clamp(MIN_XY_HEIGHT, 300.0)
        } else {
            rest.clamp(MIN_XY_HEIGHT, 600.0)
        };
        if !self.planes.is_empty() {
            rest -= plane + PICTURE_SPACING;
        }
        let mut own: Vec<(Picture, f32)> = heights(&self.plots, rest);
        if has_device {
            own.insert(0, (Picture::Device, device_height));
        }
        let heights = own
            .iter()
            .map(|&(picture, _)| picture)
            .zip(frame::split::heights(ui, &own))
            .collect();
        Layout {
            heights,
            panels: rest,
            plane,
        }
    }
}

/// Draws all pictures that are switched on and reacts to mouse and keys over them.
pub fn show(ui: &mut Ui, state: &mut State) {
    let typing = ui.ctx().memory(|memory| memory.focused().is_some());
    if !typing && !menu_open(ui) && ui.input(|input| input.key_pressed(Key::Escape)) {
        state.cursors = Cursors::default();
    }
    multiples::header(ui, state);
    let device = state.view.pictures.contains(&Picture::Device);
    let content = Content::of(ui, state);
    let mut layout = content.layout(ui, device, ui.available_size());
    ScrollArea::vertical()
        .id_salt("plots")
        .auto_shrink([false, false])
        .show(ui, |ui| {
            // Handles fill the space between pictures.
            ui.spacing_mut().item_spacing.y = 0.0;
            if device {
                let this = layout.heights.remove(0);
                let size = vec2(ui.available_width(), this.1);
                ui.allocate_ui(size, |ui| {
                    ui.set_min_size(size);
                    device::show(ui, state, device_time(state));
                });
                match layout.heights.first() {
                    Some(&below) => frame::split::handle(ui, this, below, PICTURE_SPACING),
                    None => ui.add_space(PICTURE_SPACING),
                }
            }
            stacked(ui, state, content, &layout);
            state.reveal = None;
        });
}

/// Draws all but the device.
fn stacked(ui: &mut Ui, state: &mut State, content: Content, layout: &Layout) {
    let readout = &content.readout;
    if content.has_times() {
        let switched = &mut state.view.switched_curves;
        for key in readout.show(ui) {
            if !switched.remove(&key) {
                switched.insert(key);
            }
        }
    }
    if let Some(multiples) = content.multiples {
        if let Some(range) = multiples.residual_range() {
            residual::show_header(ui, state, range);
        }
        if let Some(plot) = multiples.show(ui, state, layout.panels) {
            readout.show_differences(ui, plot);
        }
    }
    if let Some(plot) = time_plots(ui, state, content.plots, &layout.heights) {
        readout.show_differences(ui, plot);
    }
    for line in content.lines {
        ui.add_space(PICTURE_SPACING);
        ui.label(RichText::new(line).size(12.0).weak());
    }
    let planes = &content.planes;
    if !planes.is_empty() {
        ui.add_space(PICTURE_SPACING);
        side_by_side(ui, state, planes, layout.plane);
        if state
            .reveal
            .is_some_and(|picture| planes.contains(&picture))
        {
            ui.scroll_to_cursor(None);
        }
    }
}

/// Whether a menu or a list is open, or was before this frame: Escape closes it first.
fn menu_open(ui: &Ui) -> bool {
    let key = Id::unique("menu open before");
    let now = Popup::is_any_open(ui.ctx());
    let before = ui.data(|data| data.get_temp(key)).unwrap_or(false);
    ui.data_mut(|data| data.insert_temp(key, now));
    now || before
}

/// The pictures against time that are switched on, and a line of text for those that have
/// nothing to show.
pub(crate) fn describe(ui: &Ui, state: &State) -> (Vec<TimePlot>, Vec<String>) {
    let (mut plots, mut lines) = (Vec::new(), Vec::new());
    for picture in &state.view.pictures {
        match picture {
            // A device without drive has no voltage to show.
            Picture::Voltage if state.setup.preset.model.piezo.is_none() => {}
            Picture::Voltage => plots.push(voltage::describe(ui, state)),
            Picture::Trajectory => plots.push(trajectory::describe(ui, state)),
            Picture::Residual => match residual::describe(ui, state) {
                Ok(plot) => {
                    plots.push(plot);
                    lines.extend(residual::left_out(state));
                }
                Err(line) => lines.push(line),
            },
            Picture::Forces => plots.push(forces::describe(ui, state)),
            Picture::PhasePortrait | Picture::DriveLoop | Picture::Device => {}
        }
    }
    for plot in &mut plots {
        value_range::choose(plot, state);
        for i in 0..plot.curves.len() {
            let key = plot.key(&plot.curves[i]);
            plot.curves[i].hidden ^= state.view.switched_curves.contains(&key);
        }
    }
    (plots, lines)
}

/// Smallest height \[points\], and share of the remaining height.
fn demand(picture: Picture) -> (f32, f32) {
    match picture {
        Picture::Trajectory => (96.0, 3.0),
        Picture::Forces => (80.0, 2.0),
        Picture::Residual => (60.0, 1.2),
        _ => (48.0, 0.8),
    }
}

fn heights(plots: &[TimePlot], space: f32) -> Vec<(Picture, f32)> {
    let demands: Vec<(f32, f32)> = plots.iter().map(|plot| demand(plot.picture)).collect();
    let least: f32 = demands.iter().map(|d| d.0 + PICTURE_SPACING).sum();
    let shares: f32 = demands.iter().map(|d| d.1).sum();
    let remaining = (space - least).max(0.0);
    demands
        .iter()
        .zip(plots)
        .map(|((least, share), plot)| (plot.picture, (least + remaining * share / shares).floor()))
        .collect()
}

/// Time at which the device is drawn \[s\]. A live run moves the device wherever the pointer and
/// the cursors are; while it stands still, the pointer chooses the time.
fn device_time(state: &State) -> Option<f64> {
    let snapshot = state.snapshot.as_ref()?;
    match snapshot.live {
        Some(live) if state.scrub.is_none() && !live.paused => Some(live.time),
        Some(live) => state.cursors.hover.or(state.scrub).or(Some(live.time)),
        None => frame::readout::time(state).or_else(|| {
            let end = frame::time_window::in_view(state).1;
            Some(end.min(snapshot.trace.end()))
        }),
    }
}

/// Draws the pictures against time. Returns where the first one is.
fn time_plots(
    ui: &mut Ui,
    state: &mut State,
    plots: Vec<TimePlot>,
    heights: &[(Picture, f32)],
) -> Option<Rect> {
    let mut first = None;
    let common = Common {
        window: frame::time_window::in_view(state),
        cursors: state.cursors,
    };
    let last = plots.len().saturating_sub(1);
    if !plots.is_empty() {
        state.cursors.hover = None;
    }
    for (i, mut plot) in plots.into_iter().enumerate() {
        value_range::hold(ui, &mut plot, common.window);
        if plot.picture == Picture::Residual {
            residual::show_header(ui, state, plot.range(common.window));
        }
        let lowest = i == last;
        let height = heights[i].1 + if lowest { TIME_AXIS_HEIGHT } else { 0.0 };
        let name = format!("plot {}", plot.picture.name());
        let reveal = state.reveal == Some(plot.picture);
        let reply = plot.show(ui, &common, height, lowest);
        if reveal {
            let mut rect = reply.response.rect;
            rect.max.y += TIME_AXIS_HEIGHT;
            ui.scroll_to_rect(rect, None);
        }
        self::frame::layout_note::note(ui.ctx(), &name, reply.response.rect);
        value_range::react(ui, state, &reply);
        frame::time_window::react(ui, state, &reply);
        first.get_or_insert(reply.response.rect);
        if !lowest {
            frame::split::handle(ui, heights[i], heights[i + 1], PICTURE_SPACING);
        }
    }
    first
}

/// The pictures without a time axis in a row.
fn side_by_side(ui: &mut Ui, state: &State, planes: &[Picture], height: f32) {
    let width = ui.available_width() / planes.len() as f32 - 14.0;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 14.0;
        for picture in planes {
            plane(ui, state, *picture, [width, height]).show(ui);
        }
    });
}

/// One picture without a time axis, `size` points big.
pub(crate) fn plane(ui: &Ui, state: &State, picture: Picture, size: [f32; 2]) -> frame::xy::XyPlot {
    match picture {
        Picture::PhasePortrait => phase_portrait::describe(ui, state, size),
        _ => drive_loop::describe(ui, state, size),
    }
}
