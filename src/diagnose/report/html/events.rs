//! Contact events: bounces, releases, the height of the ground.

use super::{HALF, Page};
use crate::diagnose::diagnosis::{BounceSeen, Diagnosis, EventsSeen};
use crate::diagnose::report::ground::{GroundLaws, Seen, grid, without_large_errors};
use crate::diagnose::report::svg::axis::Axis;
use crate::diagnose::report::svg::plot::{Dot, Plot};
use crate::diagnose::report::words::with_named;

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
    page.heading("Contact events");
    page.raw("<div class=\"legend\"><span><i class=\"dash\" style=\"color:var(--before)\"></i>law of the re-tuned model</span>");
    if !d.named.is_empty() {
        page.raw(&format!(
            "<span><i class=\"rule\" style=\"color:var(--law)\"></i>{}</span>",
            with_named(d)
        ));
    }
    page.raw("</div>\n<div class=\"grid2\">\n");
    let laws = Laws::of(d);
    let of_bounces =
        |value: fn(&BounceSeen) -> (f64, f64)| dots(bounces.iter().map(|b| (b.speed, value(b))));
    let all = [
        Scatter {
            dots: of_bounces(|b| (b.ratio, b.ratio_error)),
            x: ("speed of approach", "m/s"),
            y: ("restitution", ""),
            from_zero: false,
            law: Some(GroundLaws::restitution),
            caption: "Bounces: ratio of the speeds after and before, against the speed of approach.",
        },
        Scatter {
            dots: of_bounces(|b| (b.dwell, b.dwell_error)),
            x: ("speed of approach", "m/s"),
            y: ("time below the level", "s"),
            from_zero: true,
            law: None,
            caption: "Bounces: time below the ground's level; 0 for a rigid ground.",
        },
        Scatter {
            dots: dots(
                releases
                    .iter()
                    .map(|r| (r.contact, (r.force, r.force_error))),
            ),
            x: ("time on the ground", "s"),
            y: ("pull-off force", "N"),
            from_zero: true,
            law: Some(GroundLaws::adhesion),
            caption: "Releases: pull-off force against time on the ground.",
        },
        Scatter {
            dots: dots(levels.iter().map(|l| (l.time, (l.miss, l.error)))),
            x: ("time", "s"),
            y: ("height above the model's ground", "m"),
            from_zero: true,
            law: None,
            caption: "Stays on the ground: reading minus the ground's level in the model.",
        },
    ];
    for scatter in all.iter().filter(|s| !s.dots.0.is_empty()) {
        let (figure, caption) = scatter.draw(&laws);
        page.figure(&figure, &caption);
    }
    page.raw("</div>\n");
}

/// The points that are drawn, and how many are not because of their large errors.
fn dots(points: impl Iterator<Item = (f64, (f64, f64))>) -> (Vec<Dot>, usize) {
    let seen = points.map(|(x, (y, error))| Seen { x, y, error });
    let (kept, left) = without_large_errors(seen);
    let dot = |Seen { x, y, error }| Dot { x, y, error };
    (kept.into_iter().map(dot).collect(), left)
}

/// Points of one kind of event with the law that they should follow.
struct Scatter {
    dots: (Vec<Dot>, usize),
    x: (&'static str, &'static str),
    y: (&'static str, &'static str),
    /// Whether the vertical axis holds zero.
    from_zero: bool,
    law: Option<fn(&GroundLaws, f64) -> f64>,
    caption: &'static str,
}

impl Scatter {
    /// The figure and its caption.
    fn draw(&self, laws: &Laws) -> (String, String) {
        let (dots, left) = &self.dots;
        let at = grid(dots.iter().map(|d| d.x));
        let mut range: Vec<f64> = dots
            .iter()
            .flat_map(|d| {
                let error = if d.error.is_finite() { d.error } else { 0.0 };
                [d.y - error, d.y + error]
            })
            .collect();
        if let Some(law) = self.law {
            range.extend(laws.values(&at, law));
        }
        if self.from_zero {
            range.push(0.0);
        }
        let mut plot = Plot::new(
            SIZE,
            Axis::linear(self.x.0, self.x.1, dots.iter().map(|d| d.x)),
            Axis::linear(self.y.0, self.y.1, range),
        );
        if self.from_zero {
            plot.level("axis", 0.0);
        }
        plot.dots("seen", 2.2, dots.iter().copied());
        if let Some(law) = self.law {
            laws.draw(&mut plot, &at, law);
        }
        let caption = match left {
            0 => self.caption.to_owned(),
            n => format!(
                "{} {n} points with large errors are not drawn.",
                self.caption
            ),
        };
        (plot.finish(), caption)
    }
}

/// The laws of the ground, before and after.
struct Laws {
    before: GroundLaws,
    after: Option<GroundLaws>,
}

impl Laws {
    fn of(d: &Diagnosis) -> Self {
        Self {
            before: GroundLaws::of(&d.baseline),
            after: (!d.named.is_empty()).then(|| GroundLaws::of(&d.model)),
        }
    }

    /// Draws a law as the re-tuned model has it and, if anything is named, as it then is.
    fn draw(&self, plot: &mut Plot, at: &[f64], law: fn(&GroundLaws, f64) -> f64) {
        let points = |laws: &GroundLaws| at.iter().map(|x| (*x, law(laws, *x))).collect::<Vec<_>>();
        plot.line("was", points(&self.before));
        if let Some(after) = &self.after {
            plot.line("law", points(after));
        }
    }

    fn values(&self, at: &[f64], law: fn(&GroundLaws, f64) -> f64) -> Vec<f64> {
        let all = std::iter::once(&self.before).chain(&self.after);
        all.flat_map(|laws| at.iter().map(|x| law(laws, *x)).collect::<Vec<_>>())
            .collect()
    }
}
