//! Which segments are looked at of recordings so long that reading all of them takes minutes.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::segment::event_sequence::GroundEvent;
use super::segment::{Joint, JointKind, Segment};

/// Up to so many segments all are read: some seconds.
const MAX_SEGMENTS_READ_WHOLE: usize = 1000;
/// Segments picked of each kind (with a release, with a bounce, with at most one event), all
/// recordings together.
const PICKED_OF_EACH_KIND: usize = 20;
/// Segments picked of each kind in a recording, however many recordings there are.
const MIN_PICKED_OF_RECORDING: usize = 4;
/// Fractional part of the golden ratio. Its multiples are spread evenly, so that picks do not
/// fall in step with a periodic drive.
const GOLDEN_FRACTION: f64 = 0.618_033_988_749_894_9;

/// How many of the segments were looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sampled {
    /// Segments looked at.
    pub picked: usize,
    /// All segments.
    pub all: usize,
}

/// One sentence.
impl fmt::Display for Sampled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "These recordings are long: the guide read bounces and releases in {} of {} segments, evenly picked. Each step reads all of them.",
            self.picked, self.all
        )
    }
}

/// Events at the ground in `segment` for which `is_meant` holds.
pub(super) fn count_events(segment: &Segment, is_meant: impl Fn(&GroundEvent) -> bool) -> usize {
    let seen = |j: &&Joint| matches!(&j.what, JointKind::Event(kind) if is_meant(kind));
    segment.joints.iter().filter(seen).count()
}

/// Keeps an even pick of many segments of `recordings` recordings; a kind that is rare is
/// kept whole. `None` if there are so few that all stay.
pub(crate) fn pick(segments: &mut Vec<Segment>, recordings: usize) -> Option<Sampled> {
    let all = segments.len();
    if all <= MAX_SEGMENTS_READ_WHOLE {
        return None;
    }
    let most = (PICKED_OF_EACH_KIND / recordings.max(1)).max(MIN_PICKED_OF_RECORDING);
    let release = |s: &Segment| count_events(s, |e| matches!(e, GroundEvent::Release { .. })) > 0;
    let bounce = |s: &Segment| count_events(s, |e| matches!(e, GroundEvent::Bounce { .. })) > 0;
    let quiet = |s: &Segment| count_events(s, |_| true) <= 1;
    let mut of_kind: Vec<[Vec<usize>; 3]> = vec![Default::default(); recordings];
    for (i, segment) in segments.iter().enumerate() {
        let kinds = [release(segment), bounce(segment), quiet(segment)];
        let Some(own) = of_kind.get_mut(segment.recording) else {
            continue;
        };
        for (list, is_of_kind) in own.iter_mut().zip(kinds) {
            if is_of_kind {
                list.push(i);
            }
        }
    }
    let mut is_picked = vec![false; all];
    for list in of_kind.iter().flatten() {
        for place in evenly(list.len(), most) {
            is_picked[list[place]] = true;
        }
    }
    let mut picks = is_picked.iter().copied();
    segments.retain(|_| picks.next().unwrap_or(false));
    Some(Sampled {
        picked: segments.len(),
        all,
    })
}

/// At most `most` places among `count`, one in each of as many equal spans.
fn evenly(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    let span = count as f64 / most as f64;
    let place = |k: usize| {
        let within = (k as f64 * GOLDEN_FRACTION).fract();
        (((k as f64 + within) * span) as usize).min(count - 1)
    };
    (0..most).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::super::contact_sample::*;

    #[test]
    fn places_are_spread_over_all_and_not_in_step() {
        assert_eq!(evenly(3, 5), [0, 1, 2]);
        assert!(evenly(0, 5).is_empty());
        let places = evenly(10_000, 50);
        assert_eq!(places.len(), 50);
        assert!(places.windows(2).all(|w| w[0] < w[1]));
        for (k, place) in places.iter().enumerate() {
            assert!((k * 200..(k + 1) * 200).contains(place), "{k} {place}");
        }
        // A drive that alternates is seen in all its phases.
        for period in [2, 3, 4, 5, 8] {
            for phase in 0..period {
                let seen = places.iter().filter(|p| *p % period == phase).count();
                assert!(2 * seen * period > places.len(), "{period} {phase}: {seen}");
            }
        }
    }
}
