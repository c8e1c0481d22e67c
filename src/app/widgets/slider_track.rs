//! The track of a slider: a position between 0 and 1 that can be dragged, changed by keys and
//! read by screen readers. The caller maps it to a value.

use eframe::egui::accesskit::{Action, ActionData};
use eframe::egui::{
    Event, EventFilter, Id, Key, Response, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo, pos2, vec2,
};

/// Share of the track that one press of an arrow key moves.
const KEY_STEP: f64 = 0.01;
/// Factor on every movement while Shift is held.
const FINE_FACTOR: f64 = 0.1;

/// A track to be shown.
pub struct SliderTrack<'a> {
    /// Identity, stable over frames.
    pub id: Id,
    /// Name for screen readers.
    pub label: &'a str,
    /// The value as text, for screen readers.
    pub text: &'a str,
    /// Value, minimum and maximum in the unit of the caller, for screen readers.
    pub numeric: (f64, f64, f64),
    /// Position; outside 0..1 it is shown at the end of the track.
    pub fraction: f64,
    /// Position of the default, marked with a tick.
    pub mark: Option<f64>,
    /// Positions from which on values are extrapolated, shaded; 1 or more shades nothing.
    pub extrapolated_from: f64,
    /// A locked track is shown but does not move.
    pub enabled: bool,
    /// Whether it is drawn in the colour of errors.
    pub error: bool,
    /// Width and height \[points\].
    pub size: Vec2,
}

/// What a person did with a [`SliderTrack`].
pub struct TrackOutput {
    /// The whole track.
    pub response: Response,
    /// New position, 0..1.
    pub fraction: Option<f64>,
    /// New value set by a screen reader, in the unit of the caller.
    pub value: Option<f64>,
    /// Whether it was a fine movement.
    pub fine: bool,
    /// Double click, Backspace or Delete: back to the default.
    pub reset: bool,
}

/// A drag in progress: its unclamped position, and the last x of the pointer \[points\].
#[derive(Debug, Clone, Copy)]
struct Drag {
    fraction: f64,
    pointer: f32,
}

impl SliderTrack<'_> {
    /// Draws the track and reads pointer, keys, wheel (only with focus) and screen reader.
    pub fn show(self, ui: &mut Ui) -> TrackOutput {
        let (rect, _) = ui.allocate_exact_size(self.size, Sense::hover());
        let response = ui.interact(rect, self.id, Sense::click_and_drag());
        let mut output = TrackOutput {
            response,
            fraction: None,
            value: None,
            fine: ui.input(|i| i.modifiers.shift),
            reset: false,
        };
        if self.enabled {
            self.pointer(ui, &mut output);
            self.keys(ui, &mut output);
            self.screen_reader(ui, &mut output);
        } else if output.response.is_pointer_button_down_on() {
            output.response.request_focus();
        }
        output.response.widget_info(|| WidgetInfo {
            current_text_value: Some(self.text.to_owned()),
            ..WidgetInfo::slider(self.enabled, self.numeric.0, self.label)
        });
        if ui.is_rect_visible(rect) {
            self.paint(ui, &output);
        }
        output
    }

    fn radius(&self) -> f32 {
        (0.36 * self.size.y).min(8.5)
    }

    fn travel(&self, response: &Response) -> (f32, f32) {
        let range = response.rect.x_range().shrink(self.radius() + 1.0);
        (range.min, range.span().max(1.0))
    }

    fn x_at(&self, response: &Response, fraction: f64) -> f32 {
        let (left, span) = self.travel(response);
        let fraction = if fraction.is_finite() {
            fraction.clamp(0.0, 1.0)
        } else {
            0.0
        };
        left + span * fraction as f32
    }

    fn pointer(&self, ui: &Ui, output: &mut TrackOutput) {
        let response = &output.response;
        let key = self.id.with("drag");
        let down = response.is_pointer_button_down_on() && ui.input(|i| i.pointer.primary_down());
        let Some(pointer) = response.interact_pointer_pos().filter(|_| down) else {
            let dragged = ui.data(|data| data.get_temp::<Drag>(key)).is_some();
            ui.data_mut(|data| data.remove::<Drag>(key));
            if response.clicked()
                && !dragged
                && !output.fine
                && let Some(pointer) = response.interact_pointer_pos()
            {
                // A tap so short that press and release arrive in one frame.
                let (left, span) = self.travel(response);
                output.fraction = Some(f64::from((pointer.x - left) / span).clamp(0.0, 1.0));
                response.request_focus();
            }
            output.reset |= response.double_clicked() || response.triple_clicked();
            return;
        };
        let (left, span) = self.travel(response);
        let started: Option<Drag> = ui.data(|data| data.get_temp(key));
        let mut drag = match started {
            Some(drag) => drag,
            None => {
                response.request_focus();
                let handle = self.x_at(response, self.fraction);
                let near = (pointer.x - handle).abs() <= self.radius() + 2.0;
                let fraction = if near || output.fine {
                    self.fraction.clamp(0.0, 1.0)
                } else {
                    let fraction = f64::from((pointer.x - left) / span).clamp(0.0, 1.0);
                    output.fraction = Some(fraction);
                    fraction
                };
                Drag {
                    fraction,
                    pointer: pointer.x,
                }
            }
        };
        let moved = f64::from((pointer.x - drag.pointer) / span);
        if moved != 0.0 {
            drag.fraction += if output.fine {
                FINE_FACTOR * moved
            } else {
                moved
            };
            output.fraction = Some(drag.fraction.clamp(0.0, 1.0));
        }
        drag.pointer = pointer.x;
        ui.data_mut(|data| data.insert_temp(key, drag));
    }

    fn keys(&self, ui: &Ui, output: &mut TrackOutput) {
        if !output.response.has_focus() {
            return;
        }
        ui.memory_mut(|memory| {
            memory.set_focus_lock_filter(
                self.id,
                EventFilter {
                    horizontal_arrows: true,
                    vertical_arrows: true,
                    ..EventFilter::default()
                },
            );
        });
        let mut fraction = self.fraction.clamp(0.0, 1.0);
        let mut step = |by: f64, fine: bool| {
            if by != 0.0 {
                fraction += by * KEY_STEP * if fine { FINE_FACTOR } else { 1.0 };
                output.fraction = Some(fraction.clamp(0.0, 1.0));
                output.fine |= fine;
            }
        };
        let mut jump = None;
        // Each event carries its own modifiers, which may change within a frame.
        for event in ui.input(|i| i.events.clone()) {
            let Event::Key {
                key,
                pressed: true,
                modifiers,
                ..
            } = event
            else {
                continue;
            };
            match key {
                Key::ArrowRight | Key::ArrowUp => step(1.0, modifiers.shift),
                Key::ArrowLeft | Key::ArrowDown => step(-1.0, modifiers.shift),
                Key::PageUp => step(10.0, false),
                Key::PageDown => step(-10.0, false),
                Key::Home => jump = Some(0.0),
                Key::End => jump = Some(1.0),
                Key::Backspace | Key::Delete => output.reset = true,
                _ => {}
            }
        }
        if output.response.hovered() {
            // The wheel moves the focused slider instead of scrolling the panel.
            let wheel = ui.input_mut(|i| std::mem::take(&mut i.smooth_scroll_delta));
            step(f64::from(wheel.y + wheel.x) / 40.0, false);
        }
        if jump.is_some() {
            output.fraction = jump;
        }
    }

    fn screen_reader(&self, ui: &Ui, output: &mut TrackOutput) {
        let (steps, value) = ui.input(|i| {
            let count = |action| i.num_accesskit_action_requests(self.id, action) as f64;
            let value = i
                .accesskit_action_requests(self.id, Action::SetValue)
                .filter_map(|request| match request.data {
                    Some(ActionData::NumericValue(value)) => Some(value),
                    _ => None,
                })
                .last();
            (count(Action::Increment) - count(Action::Decrement), value)
        });
        if steps != 0.0 {
            output.fraction = Some((self.fraction + steps * KEY_STEP).clamp(0.0, 1.0));
        }
        output.value = value;
        let (_, minimum, maximum) = self.numeric;
        ui.ctx().accesskit_node_builder(self.id, |node| {
            node.set_min_numeric_value(minimum);
            node.set_max_numeric_value(maximum);
            node.add_action(Action::SetValue);
            node.add_action(Action::Increment);
            node.add_action(Action::Decrement);
        });
    }

    fn paint(&self, ui: &Ui, output: &TrackOutput) {
        let (response, visuals, painter) = (&output.response, ui.visuals(), ui.painter());
        let rect = response.rect;
        let (radius, y) = (self.radius(), rect.center().y);
        let accent = if self.error {
            super::text::error_color(ui)
        } else if self.enabled {
            visuals.hyperlink_color
        } else {
            visuals.weak_text_color()
        };
        let half = if radius > 7.0 { 3.0 } else { 2.0 };
        let bar = |from: f32, to: f32| {
            eframe::egui::Rect::from_min_max(
                pos2(from.min(to), y - half),
                pos2(from.max(to), y + half),
            )
        };
        let (left, span) = self.travel(response);
        let groove = if visuals.dark_mode {
            visuals.widgets.inactive.bg_fill
        } else {
            visuals.widgets.inactive.bg_fill.gamma_multiply(0.9)
        };
        painter.rect_filled(bar(left - half, left + span + half), half, groove);
        if self.extrapolated_from < 1.0 {
            let from = self.x_at(response, self.extrapolated_from);
            let shade = visuals.warn_fg_color.gamma_multiply(0.55);
            painter.rect_filled(bar(from, left + span + half), half, shade);
        }
        let x = self.x_at(response, self.fraction);
        // The filled part shows the distance from the default.
        let from = self
            .mark
            .map_or(left - half, |mark| self.x_at(response, mark));
        painter.rect_filled(bar(from, x), half, accent);
        if let Some(mark) = self.mark {
            let x = self.x_at(response, mark);
            // Longer than the handle, so that it shows behind it.
            let reach = (radius + 3.0).min(0.5 * rect.height());
            let tick = Stroke::new(2.0, visuals.text_color());
            painter.line_segment([pos2(x, y - reach), pos2(x, y + reach)], tick);
        }
        let look = if self.enabled {
            ui.style().interact(response)
        } else {
            &visuals.widgets.noninteractive
        };
        let fill = if self.error { accent } else { look.bg_fill };
        let outline = if response.has_focus() {
            Stroke::new(2.0, visuals.selection.stroke.color)
        } else {
            Stroke::new(1.0, look.fg_stroke.color)
        };
        let outside = if self.fraction < -1e-9 {
            -1.0
        } else if self.fraction > 1.0 + 1e-9 {
            1.0
        } else {
            0.0
        };
        if outside == 0.0 {
            painter.circle(pos2(x, y), radius, fill, outline);
        } else {
            // An arrow head that points towards the value outside the track.
            let tip = pos2(x + outside * (radius + 1.0), y);
            let back = tip.x - outside * 1.7 * radius;
            painter.add(Shape::convex_polygon(
                vec![tip, pos2(back, y + radius), pos2(back, y - radius)],
                fill,
                outline,
            ));
        }
        if response.has_focus() {
            let ring = rect.expand2(vec2(0.0, 1.0));
            painter.rect_stroke(
                ring,
                3.0,
                Stroke::new(1.0, visuals.selection.stroke.color.gamma_multiply(0.6)),
                eframe::egui::StrokeKind::Inside,
            );
        }
    }
}
