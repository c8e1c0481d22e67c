//! Axes: units by magnitude, round ticks, ranges with some room.

use eframe::egui::{Rangef, RichText, Ui};
use egui_plot::{AxisHints, GridInput, GridMark, Plot};

use super::style;
use super::style::{AXIS_TEXT, AXIS_WIDTH};
use crate::model::unit::prefix_for;

/// Smallest distance of two grid lines that the plot library draws \[points\].
const MIN_GRID_SPACING: f32 = 8.0;
/// Height of the numbers of a horizontal axis with the quantity beneath them \[points\].
const TIME_AXIS_THICKNESS: f32 = 34.0;

/// The unit in which values are shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Its text, for example `µm`.
    pub text: String,
    /// SI value of one.
    pub factor: f64,
}

impl Unit {
    /// For values of `base` between `low` and `high`.
    pub fn of_range(base: &str, low: f64, high: f64) -> Self {
        Self::of_magnitude(base, low.abs().max(high.abs()))
    }

    fn of_magnitude(base: &str, magnitude: f64) -> Self {
        let (prefix, factor) = prefix_for(magnitude, base);
        Self {
            text: format!("{prefix}{base}"),
            factor,
        }
    }

    /// For times: chosen by the span in view, but with few digits before the decimal point.
    pub fn of_times(from: f64, to: f64) -> Self {
        let latest = from.abs().max(to.abs());
        Self::of_magnitude("s", (to - from).max(2.5e-3 * latest))
    }

    /// `quantity [unit]`.
    pub fn label(&self, quantity: &str) -> String {
        format!("{quantity} [{}]", self.text)
    }
}

/// The smallest 1, 2 or 5 times a power of ten that is not below `least`.
pub fn round_step(least: f64) -> f64 {
    if !(least.is_finite() && least > 0.0) {
        return 1.0;
    }
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|digit| digit * power)
        .find(|&step| step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

/// Range of an axis with some margin around the values. It is rounded, so that it stays the
/// same while a live curve moves a little.
pub fn room(range: Option<(f64, f64)>, least: f64) -> (f64, f64) {
    let (low, high) = range.unwrap_or((-least, least));
    let floor = least.max(1e-6 * low.abs().max(high.abs()));
    let missing = (floor - (high - low)).max(0.0) / 2.0;
    let (low, high) = (low - missing, high + missing);
    let margin = 0.06 * (high - low);
    let step = round_step((high - low) / 25.0);
    (
        ((low - margin) / step).floor() * step,
        ((high + margin) / step).ceil() * step,
    )
}

/// Union of ranges.
pub fn union(ranges: impl IntoIterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    ranges
        .into_iter()
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Round marks at least `spacing` points apart. In a low picture they may be closer, because
/// a single mark shows no scale.
fn marks(input: &GridInput, spacing: f64) -> Vec<GridMark> {
    /// The next smaller round step is at least this share of a round step.
    const NEXT_STEP_RATIO: f64 = 0.4;
    let (from, to) = input.bounds;
    let every = |step: f64| -> Vec<GridMark> {
        let first = (from / step).ceil();
        let count = ((to - from) / step).ceil().clamp(0.0, 200.0) as usize;
        (0..=count)
            .map(|i| (first + i as f64) * step)
            .filter(|value| (from..=to).contains(value))
            .map(|value| GridMark {
                value,
                step_size: step,
            })
            .collect()
    };
    let step = round_step(input.base_step_size / f64::from(MIN_GRID_SPACING) * spacing);
    let marks = every(step);
    if marks.len() < 2 {
        every(round_step(NEXT_STEP_RATIO * step))
    } else {
        marks
    }
}

/// Round ticks from `from` to `to`, at most `most`, with their texts.
pub fn ticks(from: f64, to: f64, most: f64) -> Vec<(f64, String)> {
    let step_size = round_step((to - from) / most.max(1.0));
    let first = (from / step_size).ceil();
    (0..200)
        .map(|i| (first + f64::from(i)) * step_size)
        .take_while(|&value| value <= to)
        .map(|value| (value, tick(GridMark { value, step_size })))
        .collect()
}

/// A tick's text with the digits its step needs.
pub fn tick(mark: GridMark) -> String {
    let decimals = (-(mark.step_size.log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
    // No negative zero.
    let value = if mark.value.abs() < 1e-9 * mark.step_size {
        0.0
    } else {
        mark.value
    };
    format!("{value:.decimals$}")
}

/// Gives a plot of `height` points its axes; without `x_label` it has no horizontal axis.
/// The caller moves the view.
pub fn dress<'a>(
    plot: Plot<'a>,
    ui: &Ui,
    height: f32,
    x_label: Option<String>,
    y_label: String,
) -> Plot<'a> {
    let palette = style::palette(ui);
    let font = eframe::egui::FontId::proportional(AXIS_TEXT);
    let text = |text: String| RichText::new(text).size(AXIS_TEXT).color(palette.text);
    let has_x = x_label.is_some();
    let x = AxisHints::new_x()
        // From the first frame on: the library finds the room for itself only in the second.
        .min_thickness(if has_x { TIME_AXIS_THICKNESS } else { 0.0 })
        .label(text(x_label.unwrap_or_default()))
        .label_spacing(Rangef::new(1.0, 2.0))
        .tick_label_font(font.clone())
        .tick_label_color(palette.text)
        .formatter(|mark, _| tick(mark));
    let y = AxisHints::new_y()
        .label(text(y_label))
        .label_spacing(Rangef::new(1.0, 2.0))
        .tick_label_font(font)
        .tick_label_color(palette.text)
        .min_thickness(AXIS_WIDTH)
        .formatter(move |mark, range| {
            // A label at the edge would reach into the next picture.
            let edge = 7.0 / f64::from(height.max(1.0)) * (range.end() - range.start());
            let inside = mark.value > range.start() + edge && mark.value < range.end() - edge;
            if inside { tick(mark) } else { String::new() }
        });
    plot.height(height)
        .custom_x_axes(vec![x])
        .custom_y_axes(vec![y])
        .show_axes([has_x, true])
        .x_grid_spacer(|input| marks(&input, 80.0))
        .y_grid_spacer(|input| marks(&input, 24.0))
        .grid_spacing(Rangef::new(MIN_GRID_SPACING, 2.0 * MIN_GRID_SPACING))
        .grid_color(palette.grid.gamma_multiply(0.35))
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_axis_zoom_drag(false)
        .allow_double_click_reset(false)
        .show_x(false)
        .show_y(false)
        .label_formatter(|_| None)
}

#[cfg(test)]
mod tests {
    use super::super::axes::*;

    #[test]
    fn steps_and_ranges_are_round() {
        assert_eq!(round_step(0.3), 0.5);
        assert_eq!(round_step(2.0), 2.0);
        assert_eq!(round_step(7.0), 10.0);
        assert_eq!(round_step(0.0), 1.0);
        let (low, high) = room(Some((0.0, 100.0)), 1e-3);
        assert!(low < 0.0 && high > 100.0 && high < 120.0);
        assert!(room(Some((5.0, 5.0)), 1e-3).0 < 5.0);
        assert!(room(None, 1.0).1 > 0.0);
    }

    #[test]
    fn a_low_picture_shows_its_scale() {
        let values = |half: f64, height: f64| -> Vec<f64> {
            let input = GridInput {
                bounds: (-half, half),
                base_step_size: 2.0 * half / height * f64::from(MIN_GRID_SPACING),
            };
            marks(&input, 24.0).iter().map(|mark| mark.value).collect()
        };
        assert_eq!(values(19.0, 80.0), [-10.0, 0.0, 10.0]);
        assert_eq!(values(21.0, 80.0), [-20.0, 0.0, 20.0]);
        assert_eq!(values(8.5, 60.0), [-5.0, 0.0, 5.0]);
    }

    #[test]
    fn times_have_short_units() {
        assert_eq!(Unit::of_times(0.0, 0.4).text, "ms");
        assert_eq!(Unit::of_times(0.4, 0.4005).text, "ms");
        assert_eq!(Unit::of_times(12.3, 12.301).text, "ms");
        assert_eq!(Unit::of_times(0.0, 4e-4).text, "\u{b5}s");
        assert_eq!(Unit::of_times(0.0, 3.0).text, "s");
    }

    #[test]
    fn ticks_have_the_digits_they_need() {
        let mark = |value, step_size| GridMark { value, step_size };
        assert_eq!(tick(mark(0.25, 0.05)), "0.25");
        assert_eq!(tick(mark(-0.0, 10.0)), "0");
        assert_eq!(tick(mark(1500.0, 500.0)), "1500");
    }
}
