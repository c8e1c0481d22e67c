//! Forces against time: drive, film, effects, and in contact the pull-off force against
//! the adhesion, as in the paper's figure 7.

use std::sync::Arc;

use eframe::egui::{Id, Ui};

use super::frame::cache::Source;
use super::frame::curve::Curve;
use super::frame::time_plot::TimePlot;
use super::frame::{cache, style};
use crate::app::setup::view::Picture;
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::app::state::State;
use crate::model::Model;
use crate::sim::{Event, EventKind, ForceTraces, Trace};

/// Name of the drive force. It follows the voltage and is so large that the other forces
/// look flat next to it, so it is hidden at first.
const DRIVE_FORCE: &str = "drive";

type Column = fn(&ForceTraces) -> &[f64];

/// The role of a force in a release.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    None,
    /// It causes the release.
    PullOff,
    /// It holds the mass until the release.
    Adhesion,
}

/// Name, role in a release, samples.
const FORCES: [(&str, Part, Column); 6] = [
    (DRIVE_FORCE, Part::None, |forces| &forces.drive),
    ("film", Part::None, |forces| &forces.film),
    ("effects", Part::None, |forces| &forces.effects),
    ("ground", Part::None, |forces| &forces.ground),
    ("pull-off", Part::PullOff, |forces| &forces.pull_off),
    ("adhesion", Part::Adhesion, |forces| &forces.adhesion),
];

/// The picture.
pub fn describe(ui: &Ui, state: &State) -> TimePlot {
    let mut plot = TimePlot::new(Picture::Forces, "force", "N");
    plot.least = 1e-12;
    let snapshot = state.snapshot.as_ref();
    if let Some(trace) = snapshot.map(|snapshot| &snapshot.trace) {
        if trace.forces.is_some() {
            plot.curves = curves(ui, trace);
            if plot.curves.is_empty() && !trace.proof_mass.is_empty() {
                plot.message = Some(why_none(&state.setup.preset.model));
            }
            plot.contacts = Some(Arc::clone(trace));
        } else {
            plot.message = Some("Forces are being computed.".to_owned());
        }
    }
    plot
}

/// Why no force is shown.
fn why_none(model: &Model) -> String {
    if model.piezo.is_none() && !model.has_ground && model.effects.is_empty() {
        let device = &model.name;
        return format!("No forces to show: {device} has no drive, no ground and no effects.");
    }
    "No forces to show: all are zero in this run.".to_owned()
}

fn curves(ui: &Ui, trace: &Arc<Trace>) -> Vec<Curve> {
    let palette = style::palette(ui);
    let mut curves: Vec<Curve> = FORCES
        .into_iter()
        .zip(palette.forces)
        .filter_map(|((name, part, values), color)| {
            let pyramid = if part == Part::None {
                cache::column(ui, name, trace, |trace| {
                    trace.forces.as_ref().map_or(&[], values)
                })
            } else {
                let id = Id::unique(("plot force", name));
                cache::cached(ui, id, Source::of(trace), || {
                    let samples = trace.forces.as_ref().map_or(&[][..], values);
                    up_to_release(trace, samples, part)
                })
            };
            // A device without effects has no curve for them.
            let (low, high) = pyramid.extremes()?;
            let curve = Curve::new(name, pyramid, color);
            let curve = match name {
                DRIVE_FORCE => curve.hidden(),
                _ => curve,
            };
            (low != 0.0 || high != 0.0).then(|| {
                if part == Part::None {
                    curve
                } else {
                    curve.width(style::THICK_LINE)
                }
            })
        })
        .collect();
    // The drive force is hidden so that the others can be seen; if it is alone, it is shown.
    if let [only] = curves.as_mut_slice() {
        only.hidden = false;
    }
    curves
}

/// One of the two forces that decide a release, drawn up to the exact time of the release.
/// The pull-off force reaches the adhesion there, between two samples.
fn up_to_release(trace: &Trace, values: &[f64], part: Part) -> Pyramid {
    /// Time between the end of a contact and the start of the flight [s].
    const RELEASE_GAP: f64 = 1e-12;
    let decisive = |event: &&Event| matches!(event.kind, EventKind::Stick | EventKind::Release);
    let count = trace.events.iter().filter(decisive).count();
    if count == 0 || count > values.len() {
        return Pyramid::new(trace.t0, trace.dt, values);
    }
    let (mut times, mut forces) = (Vec::new(), Vec::new());
    let mut add = |time: f64, force: f64| {
        if times.last().is_none_or(|last| time > *last) {
            times.push(time);
            forces.push(force);
        }
    };
    let (mut next, mut since) = (0, 0);
    for event in trace.events.iter().filter(decisive) {
        while next < values.len() && trace.time(next) < event.time {
            add(trace.time(next), values[next]);
            next += 1;
        }
        if event.kind == EventKind::Stick {
            since = next;
            add(event.time, 0.0);
        } else {
            // Adhesion grows slowly, so its last sample is used. A contact without a sample
            // takes the pull-off force, which is as large.
            let sampled = values[since..next].last().copied();
            let holding = sampled.filter(|_| part == Part::Adhesion);
            add(event.time, holding.unwrap_or(event.pull_off_force));
            add(event.time + RELEASE_GAP, 0.0);
        }
    }
    for (i, &value) in values.iter().enumerate().skip(next) {
        add(trace.time(i), value);
    }
    Pyramid::unbroken(&times, &forces)
}

#[cfg(test)]
mod tests {
    use super::super::forces::*;
    use crate::model::parameter::ParameterId;
    use crate::model::preset::Preset;
    use crate::sim::Options;
    use crate::sim::simulate;

    #[test]
    fn the_pull_off_force_reaches_the_adhesion_at_each_release() {
        let preset = Preset::embedded("paper").unwrap();
        let drive = crate::model::drive::Waveform::parse("square:15Hz:8V", 0.1).unwrap();
        let options = Options {
            forces: true,
            ..Options::default()
        };
        let trace = simulate(&preset.model, &drive, 0.1, &options).unwrap();
        let forces = trace.forces.as_ref().unwrap();
        let pull_off = up_to_release(&trace, &forces.pull_off, Part::PullOff);
        let adhesion = up_to_release(&trace, &forces.adhesion, Part::Adhesion);
        let releases = trace.events.iter().filter(|e| e.kind == EventKind::Release);
        let growth = 1.01 * preset.model.parameters[ParameterId::Ca] * trace.dt;
        let mut count = 0;
        for release in releases {
            let at = |curve: &Pyramid, t| curve.value_at(t).unwrap();
            let (pull, hold) = (at(&pull_off, release.time), at(&adhesion, release.time));
            // Adhesion has grown since its last sample.
            assert!(
                (-1e-15..growth).contains(&(pull - hold)),
                "{pull} {hold} {release:?}"
            );
            let free = release.time + 1e-11;
            assert!(at(&pull_off, free).abs() < 1e-3 * pull, "{release:?}");
            count += 1;
        }
        assert!(count > 3);
        // Nothing else has changed.
        for i in (0..trace.len()).step_by(97) {
            let shown = pull_off.value_at(trace.time(i)).unwrap();
            assert_eq!(shown, forces.pull_off[i], "sample {i}");
        }
    }
}
