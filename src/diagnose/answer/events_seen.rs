//! Contact events as measured, for the figures, and where they miss a named contact law.

use super::proof::SplitSamples;
use crate::diagnose::comparison::trial::ModelState;
use crate::diagnose::contact::bounce_readings::at_once;
use crate::diagnose::contact::event_readings::Ground;
use crate::diagnose::contact::law_test::LawTest;
use crate::diagnose::diagnosis::{
    BounceSeen, EventsSeen, LevelSeen, Mismatch, Regime, ReleaseSeen,
};
use crate::model::effects::ContactLaw;

/// Half width of the span that is shown around an event \[s\].
const EVENT_HALF_WIDTH: f64 = 1e-4;

/// Where a named contact law is missed: at its events.
pub fn mismatches(named: &[LawTest], ground: &Ground, baseline: &ModelState) -> Vec<Mismatch> {
    let data = &baseline.train.problem.data;
    let mut out = Vec::new();
    for test in named {
        let at: Vec<(usize, f64, Regime)> = if test.law() == Some(ContactLaw::Adhesion) {
            let releases = ground.train.releases.iter();
            releases
                .map(|r| (r.recording, r.time, Regime::Release))
                .collect()
        } else {
            let bounces = ground.train.bounces.iter();
            bounces
                .map(|b| (b.recording, b.time, Regime::Impact))
                .collect()
        };
        let share = 1.0 / at.len().max(1) as f64;
        for (recording, time, regime) in at.into_iter().take(20) {
            out.push(Mismatch {
                recording: data[recording].recording.name.clone(),
                start: time - EVENT_HALF_WIDTH,
                end: time + EVENT_HALF_WIDTH,
                channel: "xp",
                regime,
                share,
            });
        }
    }
    out
}

/// The events at the ground as measured against the baseline.
pub fn events_seen(ground: &Ground, baseline: &ModelState, sides: &SplitSamples) -> EventsSeen {
    let mut seen = EventsSeen::default();
    let shift = baseline.train.problem.data.len();
    for (readings, first) in [(&ground.train, 0), (&ground.held_out, shift)] {
        seen.bounces.extend(readings.bounces.iter().map(|b| {
            // As the law of restitution is fitted to them.
            let (ratio, ratio_error) = at_once(&readings.bounces, b);
            BounceSeen {
                recording: first + b.recording,
                time: b.time,
                speed: b.approach,
                ratio,
                ratio_error,
                dwell: -b.miss / b.approach.max(1e-12),
                dwell_error: b.miss_error / b.approach.max(1e-12),
            }
        }));
        seen.releases
            .extend(readings.releases.iter().map(|r| ReleaseSeen {
                recording: first + r.recording,
                time: r.time,
                contact: r.contact,
                force: r.force,
                force_error: r.error,
            }));
    }
    for (samples, first, fitted) in [
        (&sides.train, 0, Some(&baseline.train)),
        (&sides.held_out, shift, baseline.held_out.as_ref()),
    ] {
        let Some(fitted) = fitted else { continue };
        for group in samples.chunk_by(|a, b| a.segment == b.segment) {
            let held = &fitted.point.segments[group[0].segment].starts_held;
            let misses: Vec<f64> = group
                .iter()
                .map(|s| s.miss_p)
                .filter(|m| m.is_finite())
                .collect();
            if !held || misses.len() < 8 {
                continue;
            }
            let n = misses.len() as f64;
            seen.levels.push(LevelSeen {
                recording: first + group[0].recording,
                time: 0.5 * (group[0].time + group[group.len() - 1].time),
                miss: misses.iter().sum::<f64>() / n,
                error: fitted.problem.data[group[0].recording].sigmas.xp / n.sqrt(),
            });
        }
    }
    seen
}
