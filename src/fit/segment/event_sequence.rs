//! Events at the ground as the samples show them: the order of touches, bounces and releases,
//! with first guesses of their instants. A fit keeps the order and leaves the instants free.

use crate::fit::thresholds::{LONG_STAY_SAMPLES, MIN_BOUNCE_RATIO, MIN_STAY_SAMPLES};
use crate::recording::TimeAxis;
use crate::recording::events::{EventOptions, find_events};

/// What happens at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GroundEvent {
    /// The mass hits the ground and leaves it with this velocity \[m/s\].
    Bounce {
        /// First guess.
        v_after: f64,
    },
    /// It hits the ground and stays.
    Touch,
    /// It leaves the ground after a stay.
    Release {
        /// Whether it determines the pull-off force.
        informative: bool,
    },
}

/// One event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// First guess of the instant \[s\].
    pub time: f64,
    /// What happens.
    pub kind: GroundEvent,
}

/// Events in order of time. A stay that began before the recording has no touch, one that ends
/// after it no release.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Timeline {
    /// The events.
    pub marks: Vec<Mark>,
    /// Whether the mass is on the ground at the first sample.
    pub starts_held: bool,
}

impl Timeline {
    /// Finds the events in `xp` for a contact level and a noise \[m\].
    pub fn new(time: &[f64], xp: &[f64], level: f64, noise: f64) -> Self {
        let interval = crate::recording::median_interval(time);
        let tolerance = (4.5 * noise).max(1e-12);
        let stays = stays(xp, level, tolerance);
        let options = EventOptions::for_travel(level, noise, xp);
        let impacts = find_events(TimeAxis::Samples(time), xp, &options).impacts;
        let mut marks = Vec::new();
        let mut starts_held = false;
        let mut next_impact = 0;
        // Impacts between stays, then the stay with its own impact.
        for (k, stay) in stays.iter().map(Some).chain([None]).enumerate() {
            let first = stay.map_or(usize::MAX, |s| s.0);
            let begin = time.get(first).copied().unwrap_or(f64::INFINITY);
            let mut arrival = None;
            while let Some(impact) = impacts.get(next_impact) {
                if impact.time > begin + 1.5 * interval {
                    break;
                }
                next_impact += 1;
                if impact.time > begin - 1.5 * interval {
                    arrival = Some(impact.time.min(begin));
                    continue;
                }
                let after_stay = k > 0 && impact.time <= time[stays[k - 1].1] + 0.5 * interval;
                if after_stay {
                    continue;
                }
                let ratio = -impact.v_after / impact.v_before;
                if ratio > MIN_BOUNCE_RATIO {
                    marks.push(Mark {
                        time: impact.time,
                        kind: GroundEvent::Bounce {
                            v_after: impact.v_after,
                        },
                    });
                } else {
                    marks.push(Mark {
                        time: impact.time,
                        kind: GroundEvent::Touch,
                    });
                    marks.push(Mark {
                        time: impact.time + 0.5 * interval,
                        kind: GroundEvent::Release { informative: false },
                    });
                }
            }
            let Some(&(first, last)) = stay else { break };
            // Impacts seen inside a stay are noise of its own.
            while impacts
                .get(next_impact)
                .is_some_and(|i| i.time <= time[last])
            {
                next_impact += 1;
            }
            if first == 0 {
                starts_held = true;
            } else {
                marks.push(Mark {
                    time: arrival.unwrap_or(begin - 0.3 * interval),
                    kind: GroundEvent::Touch,
                });
            }
            if last + 1 < xp.len() {
                marks.push(Mark {
                    time: (time[last] - 0.5 * interval).max(begin),
                    kind: GroundEvent::Release {
                        informative: last - first >= 2,
                    },
                });
            }
        }
        Self { marks, starts_held }
    }
}

/// Runs of samples at the level, as (first, last). A single sample off ends a run only
/// where it may be a hop: not in the midst of a long stay.
fn stays(xp: &[f64], level: f64, tolerance: f64) -> Vec<(usize, usize)> {
    let at = |i: usize| {
        xp.get(i)
            .is_some_and(|x| x.is_nan() || (x - level).abs() <= tolerance)
    };
    let stray = |i: usize| {
        xp.get(i)
            .is_some_and(|x| (x - level).abs() < 2.0 * tolerance)
            && i >= LONG_STAY_SAMPLES
            && (1..=LONG_STAY_SAMPLES).all(|k| at(i - k) && at(i + k))
    };
    let mut found = Vec::new();
    let mut i = 0;
    while i < xp.len() {
        if !(at(i) && xp[i].is_finite()) {
            i += 1;
            continue;
        }
        let first = i;
        let mut last = i;
        while at(last + 1) || stray(last + 1) {
            last += 1;
        }
        if last - first + 1 >= MIN_STAY_SAMPLES {
            found.push((first, last));
        }
        i = last + 1;
    }
    found
}
