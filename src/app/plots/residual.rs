//! Simulation minus recording against time, as a length or in units of each recording's noise.

mod header;

use std::sync::Arc;

use eframe::egui::{Color32, Id, Ui};

pub use self::header::{height as header_height, show as show_header};

use super::frame::cache;
use super::frame::cache::Source;
use super::frame::curve::{Curve, Placed};
use super::frame::style;
use super::frame::style::THICK_LINE;
use super::frame::time_plot::{Level, TimePlot};
use crate::app::setup::command::Command;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::overlay::Overlay;
use crate::app::setup::view::{Picture, ResidualUnit};
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::app::simulation::snapshot::OverlayComparison;
use crate::app::state::State;

/// Lines of the residual in units of the noise: one standard deviation, and what a reading hardly
/// ever is beyond.
const NOISE_LINES: [f64; 2] = [1.0, 3.0];
/// Smallest range that is shown: as a length \[m\], and in units of the noise.
const LEAST_RANGE: (f64, f64) = (1e-10, 0.1);

/// The picture of all visible recordings, or a line of text that says why it is empty.
///
/// # Errors
/// Why it is empty.
pub fn describe(ui: &Ui, state: &State) -> Result<TimePlot, String> {
    let visible = state.setup.overlays.iter().filter(|o| o.visible);
    describe_some(ui, state, &visible.collect::<Vec<_>>())
}

/// The picture of some recordings.
///
/// # Errors
/// Why it is empty.
pub fn describe_some(ui: &Ui, state: &State, overlays: &[&Overlay]) -> Result<TimePlot, String> {
    let unit = state.view.residual_unit;
    let quantity = "simulation \u{2212} recording";
    let mut plot = TimePlot::new(Picture::Residual, quantity, unit.base());
    plot.short_quantity = Some("sim \u{2212} rec");
    plot.scale = unit.scale_name().to_owned();
    plot.least = match unit {
        ResidualUnit::Length => LEAST_RANGE.0,
        ResidualUnit::Noise => LEAST_RANGE.1,
    };
    let mut reason = None;
    for overlay in overlays {
        let Some(compared) = comparison(state, overlay) else {
            continue;
        };
        if let Err(why) = &compared.comparison {
            reason.get_or_insert_with(|| format!("{}: {why}", overlay.recording.name));
        }
        let Some(pyramid) = &compared.residual_pyramid else {
            continue;
        };
        let scale = match (unit, compared.noise) {
            (ResidualUnit::Length, _) => 1.0,
            (ResidualUnit::Noise, Some(noise)) => 1.0 / noise,
            (ResidualUnit::Noise, None) => {
                reason.get_or_insert_with(|| without_noise(overlay));
                continue;
            }
        };
        let color = style::overlay_color(ui, overlay.color);
        let name = format!("residual {}", overlay.recording.name);
        let curve = Curve::new(name, Arc::clone(pyramid), color);
        let curve = curve.placed(Placed::scaled(scale));
        plot.curves.push(curve.owned(overlay.id));
        if let (ResidualUnit::Length, Some(noise)) = (unit, compared.noise) {
            plot.bands.push((noise, color.gamma_multiply(0.18)));
        }
        plot.curves.extend(explained(ui, state, overlay, compared));
    }
    // Under the present residuals, which have to become flat.
    let present = std::mem::replace(&mut plot.curves, kept(ui, state, overlays));
    plot.curves.extend(present);
    if plot.curves.is_empty() {
        return Err(reason.unwrap_or_else(|| why_empty(state, overlays.is_empty())));
    }
    if unit == ResidualUnit::Noise {
        noise_lines(&mut plot, style::palette(ui).text);
    }
    Ok(plot)
}

/// What is said of a recording that has no noise to divide by.
fn without_noise(overlay: &Overlay) -> String {
    let name = &overlay.recording.name;
    format!("{name} has no noise: its residual is drawn as a length only")
}

/// What is not drawn of the visible recordings, and why, in units of the noise.
pub fn left_out(state: &State) -> Vec<String> {
    if state.view.residual_unit == ResidualUnit::Length {
        return Vec::new();
    }
    let has_none = |overlay: &&Overlay| {
        let compared = comparison(state, overlay);
        compared.is_some_and(|c| c.comparison.is_ok() && c.noise.is_none())
    };
    let visible = state.setup.overlays.iter().filter(|o| o.visible);
    visible.filter(has_none).map(without_noise).collect()
}

fn noise_lines(plot: &mut TimePlot, color: Color32) {
    plot.bands.push((1.0, color.gamma_multiply(0.14)));
    for (i, size) in NOISE_LINES.into_iter().enumerate() {
        let color = color.gamma_multiply(if i == 0 { 0.35 } else { 0.7 });
        plot.levels.extend([size, -size].map(|value| Level {
            value,
            text: "",
            color,
        }));
    }
}

/// The part of a recording's residual that the slider looked at in the sensitivity tool could take
/// away.
fn explained(
    ui: &Ui,
    state: &State,
    overlay: &Overlay,
    compared: &OverlayComparison,
) -> Option<Curve> {
    let found = state.sensing.found_for(state.snapshot.as_ref()?)?;
    let influence = state.sensing.looked_at()?;
    let place = found.overlays.iter().position(|id| *id == overlay.id)?;
    let id = Id::unique(("explained residual", overlay.id));
    let key = (Source::of(found), influence.id.clone());
    let pyramid = cache::cached(ui, id, key, || {
        let times = &found.sensitivity.times[place];
        Pyramid::unbroken(times, &influence.explained(place))
    });
    let scale = match state.view.residual_unit {
        ResidualUnit::Length => compared.noise?,
        ResidualUnit::Noise => 1.0,
    };
    let name = format!("part by {} {}", influence.id, overlay.recording.name);
    let color = style::strong_overlay_color(ui, overlay.color);
    let curve = Curve::new(name, pyramid, color).width(THICK_LINE);
    Some(curve.placed(Placed::scaled(scale)).owned(overlay.id))
}

/// The residuals of the kept curves on the recordings shown, in the curves' colours.
fn kept(ui: &Ui, state: &State, overlays: &[&Overlay]) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (kept, run) in state.kept_in_view() {
        let color = style::kept_color(ui, kept.color);
        for overlay in overlays {
            let compared = run.comparisons.iter().find(|c| c.id == overlay.id);
            let scale = match (state.view.residual_unit, compared.and_then(|c| c.noise)) {
                (ResidualUnit::Length, _) => 1.0,
                (ResidualUnit::Noise, Some(noise)) => 1.0 / noise,
                (ResidualUnit::Noise, None) => continue,
            };
            let Some(pyramid) = compared.and_then(|c| c.residual_pyramid.as_ref()) else {
                continue;
            };
            let name = format!("{}: residual {}", kept.name, overlay.recording.name);
            let curve = Curve::new(name, Arc::clone(pyramid), color);
            let curve = curve.placed(Placed::scaled(scale));
            curves.push(curve.owned(overlay.id).of_kept(&kept.name));
        }
    }
    curves
}

/// The comparison of a recording with the run.
pub fn comparison<'a>(state: &'a State, overlay: &Overlay) -> Option<&'a OverlayComparison> {
    let comparisons = &state.snapshot.as_ref()?.comparisons;
    comparisons.iter().find(|c| c.id == overlay.id)
}

fn why_empty(state: &State, none_visible: bool) -> String {
    let live = state.snapshot.as_ref().is_some_and(|s| s.live.is_some());
    let whole_span = Command::SetMode(Mode::WholeSpan);
    let switch = whole_span.with_keys("recordings are compared in whole-span mode");
    let reason: &str = if state.setup.overlays.is_empty() {
        "open a recording to see its distance from the simulation"
    } else if none_visible {
        "make a recording visible to compare it with the simulation"
    } else if live {
        &switch
    } else {
        "the comparison is being computed"
    };
    format!("Residual: {reason}.")
}
