//! What the events at the ground say: bounces, releases, the height of the ground.

use super::super::svg::{Axis, Dot, Plot};
use super::{HALF, Page};
use crate::diagnose::result::{Diagnosis, EventsSeen};
use crate::model::Model;
use crate::model::effects::{Action, Surroundings};
use crate::model::ground::Ground;

/// Points of a law's curve.
const CURVE: usize = 80;
const SIZE: [f64; 2] = [HALF, 220.0];

/// Writes the figures for which there are events.
pub fn write(page: &mut Page, d: &Diagnosis) {
    let EventsSeen {
        bounces,
        releases,
        levels,
    } = &d.events;
    if bounces.is_empty() && releases.is_empty() && levels.is_empty() {
        return;
    }
    page.heading("The events at the ground");
    page.raw("<div class=\"legend\"><span><i class=\"dash\" style=\"color:var(--before)\"></i>law of the re-tuned model</span>");
    if !d.named.is_empty() {
        page.raw(
            "<span><i class=\"rule\" style=\"color:var(--law)\"></i>with what was left out</span>",
        );
    }
    page.raw("</div>\n<div class=\"grid2\">\n");
    let laws = Laws::of(d);
    if !bounces.is_empty() {
        page.figure(
            &restitution(d, &laws),
            "Bounces: speed kept against speed of approach.",
        );
        page.figure(
            &dwell(d),
            "Bounces: time below the ground's level; 0 for a rigid ground.",
        );
    }
    if !releases.is_empty() {
        page.figure(
            &pull_off(d, &laws),
            "Releases: pull-off force against time on the ground.",
        );
    }
    if !levels.is_empty() {
        page.figure(
            &level(d),
            "Stays: reading minus the ground's level in the model.",
        );
    }
    page.raw("</div>\n");
}

/// The laws of the ground, before and after.
struct Laws {
    before: ModelLaws,
    after: Option<ModelLaws>,
}

impl Laws {
    fn of(d: &Diagnosis) -> Self {
        Self {
            before: ModelLaws::of(&d.baseline),
            after: (!d.named.is_empty()).then(|| ModelLaws::of(&d.model)),
        }
    }

    /// Draws a law as the re-tuned model has it and, if anything is named, as it then is.
    fn draw(&self, plot: &mut Plot, at: &[f64], law: impl Fn(&ModelLaws, f64) -> f64) {
        let points = |laws: &ModelLaws| at.iter().map(|x| (*x, law(laws, *x))).collect::<Vec<_>>();
        plot.line("was", points(&self.before));
        if let Some(after) = &self.after {
            plot.line("law", points(after));
        }
    }

    fn values(&self, at: &[f64], law: impl Fn(&ModelLaws, f64) -> f64) -> Vec<f64> {
        let all = std::iter::once(&self.before).chain(&self.after);
        all.flat_map(|laws| at.iter().map(|x| law(laws, *x)).collect::<Vec<_>>())
            .collect()
    }
}

/// The laws of one model's ground.
struct ModelLaws {
    ground: Ground,
    actions: Vec<Box<dyn Action>>,
}

impl ModelLaws {
    fn of(model: &Model) -> Self {
        let structure = model.structure();
        let around = Surroundings {
            structure: &structure,
            parameters: &model.parameters,
            piezo: model.piezo,
        };
        let build = |e: &crate::model::effects::ActiveEffect| (e.spec.build)(&e.values, &around);
        Self {
            ground: Ground::new(&model.parameters),
            actions: model.effects.iter().map(build).collect(),
        }
    }

    fn restitution(&self, speed: f64) -> f64 {
        let all = self.actions.iter();
        all.fold(self.ground.alpha, |alpha, a| a.restitution(alpha, speed))
    }

    fn adhesion(&self, contact: f64) -> f64 {
        let start = self.ground.adhesion_start;
        let line = self.ground.adhesion(contact);
        let all = self.actions.iter();
        all.fold(line, |f, a| a.adhesion(f, start, contact))
    }
}

fn grid(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        });
    if low >= high {
        return Vec::new();
    }
    let step = (high - low) / (CURVE - 1) as f64;
    (0..CURVE).map(|i| low + i as f64 * step).collect()
}

fn with_errors(values: impl Iterator<Item = (f64, f64)>) -> Vec<f64> {
    values
        .flat_map(|(v, e)| {
            let e = if e.is_finite() { e } else { 0.0 };
            [v - e, v + e]
        })
        .collect()
}

fn restitution(d: &Diagnosis, laws: &Laws) -> String {
    let bounces = &d.events.bounces;
    let at = grid(bounces.iter().map(|b| b.speed));
    let seen = with_errors(bounces.iter().map(|b| (b.ratio, b.ratio_error.min(0.3))));
    let law = laws.values(&at, ModelLaws::restitution);
    let range = seen.into_iter().chain(law);
    let mut plot = Plot::new(
        SIZE,
        Axis::linear("speed of approach", "m/s", bounces.iter().map(|b| b.speed)),
        Axis::linear("restitution", "", range),
    );
    let dots = bounces.iter().map(|b| Dot {
        x: b.speed,
        y: b.ratio,
        error: b.ratio_error,
    });
    plot.dots("seen", 2.2, dots);
    laws.draw(&mut plot, &at, ModelLaws::restitution);
    plot.finish()
}

fn dwell(d: &Diagnosis) -> String {
    let bounces = &d.events.bounces;
    let range = with_errors(bounces.iter().map(|b| (b.dwell, b.dwell_error)));
    let mut plot = Plot::new(
        SIZE,
        Axis::linear("speed of approach", "m/s", bounces.iter().map(|b| b.speed)),
        Axis::linear("time below the level", "s", range.into_iter().chain([0.0])),
    );
    plot.level("axis", 0.0, "");
    let dots = bounces.iter().map(|b| Dot {
        x: b.speed,
        y: b.dwell,
        error: b.dwell_error,
    });
    plot.dots("seen", 2.2, dots);
    plot.finish()
}

fn pull_off(d: &Diagnosis, laws: &Laws) -> String {
    let releases = &d.events.releases;
    let at = grid(releases.iter().map(|r| r.contact));
    let seen = with_errors(releases.iter().map(|r| (r.force, r.force_error)));
    let law = laws.values(&at, ModelLaws::adhesion);
    let range = seen.into_iter().chain(law).chain([0.0]);
    let mut plot = Plot::new(
        SIZE,
        Axis::linear(
            "time on the ground",
            "s",
            releases.iter().map(|r| r.contact),
        ),
        Axis::linear("pull-off force", "N", range),
    );
    let dots = releases.iter().map(|r| Dot {
        x: r.contact,
        y: r.force,
        error: r.force_error,
    });
    plot.dots("seen", 2.2, dots);
    laws.draw(&mut plot, &at, ModelLaws::adhesion);
    plot.finish()
}

fn level(d: &Diagnosis) -> String {
    let levels = &d.events.levels;
    let range = with_errors(levels.iter().map(|l| (l.miss, l.error)));
    let mut plot = Plot::new(
        SIZE,
        Axis::linear("time", "s", levels.iter().map(|l| l.time)),
        Axis::linear(
            "height above the model's ground",
            "m",
            range.into_iter().chain([0.0]),
        ),
    );
    plot.level("axis", 0.0, "");
    let dots = levels.iter().map(|l| Dot {
        x: l.time,
        y: l.miss,
        error: l.error,
    });
    plot.dots("seen", 2.2, dots);
    plot.finish()
}
