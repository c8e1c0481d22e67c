//! The device drawn, moving with the run: a cantilever with its proof mass over the
//! ground, a mass on a spring, or a free mass.
//!
//! Heights are to scale, lengths are not. The scale stays the same while the motion fits it, over
//! runs as well, so that only the device moves. The length of an arrow is relative to the largest drive force of
//! the run, or to the largest force on the mass.

mod column;
mod look;
mod moment;
mod paint;
mod parts;
#[cfg(test)]
mod tests;

use eframe::egui::{Id, Pos2, Rect, Role, Ui, WidgetInfo, pos2, vec2};

pub use self::look::{DeviceLook, DevicePlace};

use self::moment::{Extremes, Moment};
use self::paint::{Colors, text};
use crate::app::simulation::snapshot::Snapshot;
use crate::app::state::State;
use crate::model::parameter::ParameterId;
use crate::model::unit::format_quantity;

/// Smallest height of the picture \[points\]. It takes all the room it is given.
const MIN_HEIGHT: f32 = 110.0;

/// Shown on hovering: what is to scale.
const SCALE_NOTE: &str = "Heights are to scale (see the bar), lengths are not. The length of \
     an arrow is relative to the largest drive force of this run, or to the largest force on \
     the mass. The scale stays while the motion fits; double-click to fit it to the motion.";

/// What kind of device is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A clamped beam with the mass at its end.
    Cantilever,
    /// A mass on a spring.
    Spring,
    /// A free mass.
    Free,
}

impl Kind {
    fn of(snapshot: &Snapshot) -> Self {
        if snapshot.model.has_cantilever {
            Kind::Cantilever
        } else if snapshot.model.parameters[ParameterId::F1] > 0.0 {
            Kind::Spring
        } else {
            Kind::Free
        }
    }
}

/// Positions in the picture, fixed for a run and a size.
#[derive(Debug, Clone, Copy)]
struct Layout {
    /// Where the device moves.
    area: Rect,
    /// Upper left corner of the column of text.
    column: Pos2,
    /// Horizontal centre of the mass.
    mass_x: f32,
    /// Width and height of the mass.
    mass: eframe::egui::Vec2,
    /// The level of the ground as drawn, if there is one \[m\].
    ground: Option<f64>,
    low: f64,
    low_y: f32,
    /// Points per metre.
    scale: f64,
}

impl Layout {
    fn new(rect: Rect, kind: Kind, ground: Option<f64>, extremes: &Extremes) -> Self {
        // In a narrow picture the text takes at most half of the width.
        let widest = (0.5 * rect.width()).clamp(110.0, 210.0);
        let column_width = (0.22 * rect.width()).clamp(164.0_f32.min(widest), widest);
        let area = Rect::from_min_max(
            rect.min,
            pos2(
                (rect.right() - column_width).max(rect.left() + 60.0),
                rect.bottom(),
            ),
        );
        let h = area.height();
        let mass = vec2(
            (0.14 * area.width()).clamp(30.0, 140.0),
            (0.13 * h).clamp(14.0, 60.0),
        );
        let below = if ground.is_some() { 24.0 } else { 8.0 };
        let above = match kind {
            Kind::Cantilever => 22.0 + mass.y,
            // The spring keeps some length when the mass is at its highest.
            Kind::Spring => 20.0 + mass.y + 0.22 * h,
            Kind::Free => 8.0 + mass.y,
        };
        let room = f64::from((h - below - above).max(10.0));
        let low_y = area.bottom() - below;
        let across = match kind {
            Kind::Cantilever => 0.68,
            Kind::Spring | Kind::Free => 0.5,
        };
        Self {
            area,
            column: pos2(area.right() + 8.0, rect.top() + 6.0),
            mass_x: area.left() + across * area.width(),
            mass,
            ground,
            low: extremes.low,
            low_y,
            scale: room / (extremes.high - extremes.low),
        }
    }

    /// Height on screen of a displacement \[m\].
    fn y(&self, x: f64) -> f32 {
        self.low_y - ((x - self.low) * self.scale) as f32
    }

    /// Length of the longest arrow \[points\].
    fn arrow(&self) -> f32 {
        (0.3 * self.area.height()).clamp(26.0, 140.0)
    }
}

/// Draws the device at `time` \[s\] (held within the run; the run's last sample if `None`)
/// in the room that `ui` has.
pub fn show(ui: &mut Ui, state: &State, time: Option<f64>) {
    let look = DeviceLook::default();
    if let Some(place) = show_as(ui, state, time, look) {
        place.response.on_hover_text(SCALE_NOTE);
    }
}

/// Draws the device as [`show`] does, in another look. Returns where heights are; `None` without a
/// device to show.
pub fn show_as(
    ui: &mut Ui,
    state: &State,
    time: Option<f64>,
    look: DeviceLook,
) -> Option<DevicePlace> {
    let room = ui.available_size();
    let height = if room.y.is_finite() { room.y } else { 220.0 };
    let size = vec2(room.x.max(240.0), height.max(MIN_HEIGHT));
    let (rect, response) = ui.allocate_exact_size(size, look.sense());
    let seen = state
        .snapshot
        .as_deref()
        .map(|snapshot| (snapshot, Moment::new(state, snapshot, time)));
    response.widget_info(|| {
        let label = match &seen {
            Some((_, Some(moment))) => label(moment),
            _ => "Device, nothing to draw".to_owned(),
        };
        WidgetInfo::labeled(Role::Image, true, label)
    });
    if !ui.is_rect_visible(rect) {
        return None;
    }
    let colors = Colors::of(ui.visuals());
    let painter = ui.painter_at(rect);
    let (snapshot, moment) = match seen {
        Some((snapshot, Some(moment))) => (snapshot, moment),
        other => {
            let why = if other.is_some() {
                "no motion at this time"
            } else {
                "the device appears here after the first simulation"
            };
            text(&painter, rect.center(), "cc", why, 13.0, colors.weak);
            return None;
        }
    };
    let mut extremes = extremes(ui, snapshot, response.double_clicked());
    let kind = Kind::of(snapshot);
    let ground = snapshot
        .trace
        .ground_level
        .map(|level| level - snapshot.model.parameters[ParameterId::OffsetP])
        .filter(|level| level.is_finite());
    look.zoom_in(&mut extremes, ground);
    let layout = Layout::new(rect, kind, ground, &extremes);
    let scene = parts::Scene {
        painter: &painter.with_clip_rect(layout.area.intersect(painter.clip_rect())),
        layout: &layout,
        colors: &colors,
        moment: &moment,
        extremes: &extremes,
        look,
    };
    match kind {
        Kind::Cantilever => scene.cantilever(),
        Kind::Spring => scene.spring(),
        Kind::Free => scene.free(),
    }
    scene.scale_bar();
    column::show(&painter, &layout, &colors, &moment, &extremes, kind);
    let offset = snapshot.model.parameters[ParameterId::OffsetP];
    Some(DevicePlace::new(response, &layout, &moment, offset))
}

/// The text for screen readers.
fn label(moment: &Moment) -> String {
    let mut label = format!(
        "Device, {}, xp = {}",
        moment.regime(),
        format_quantity(moment.reading, "m", 3)
    );
    if let Some(voltage) = moment.voltage {
        label.push_str(&format!(", V = {}", format_quantity(voltage, "V", 3)));
    }
    label
}

/// The extremes of a run, computed once per run. The scale is that of the run before while the
/// motion fits, unless it is to be `fitted` again.
fn extremes(ui: &Ui, snapshot: &Snapshot, fitted: bool) -> Extremes {
    let id = Id::unique("device picture extremes");
    let known = ui.data(|data| data.get_temp::<Extremes>(id));
    if let Some(known) = known.filter(|known| !fitted && known.are_of(snapshot)) {
        return known;
    }
    let new = Extremes::new(snapshot, known.as_ref().filter(|_| !fitted));
    ui.data_mut(|data| data.insert_temp(id, new));
    new
}
