//! How far the segments of each recording are from a fit, and in which recordings the mass may
//! hover over the ground.

use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{
    HOVER_MIN_CHI2_RATIO, HOVER_MIN_MISREAD_SHARE, HOVER_MIN_STAYS, LOST_TRACK_CHI2,
};
use crate::fit::segment::Segment;
use crate::recording::quantile_in_place;
use crate::sim::SimError;

/// How far a segment is from the model.
struct SegmentDistance {
    recording: usize,
    /// Whether it is a contact.
    stays: bool,
    rows: usize,
    /// Chi2 per value.
    mean: f64,
}

impl Fitted {
    /// Distance of each segment that is not set aside.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    fn segment_distances(&self) -> Result<Vec<SegmentDistance>, SimError> {
        let one = |(segment, mean): (&Segment, Option<(usize, f64)>)| {
            mean.map(|(rows, mean)| SegmentDistance {
                recording: segment.recording,
                stays: segment.starts_held,
                rows,
                mean,
            })
        };
        let all = self.point.segments.iter().zip(self.segment_chi2()?);
        Ok(all.filter_map(one).collect())
    }

    /// Cost of each recording's segments that are not set aside, residuals clipped.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn recording_costs(&self) -> Result<Vec<f64>, SimError> {
        let mut costs = vec![0.0; self.problem.data.len()];
        for s in self.segment_distances()? {
            costs[s.recording] += s.mean * s.rows as f64;
        }
        Ok(costs)
    }

    /// Cost and number of values of all recordings but `these`, residuals clipped.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn cost_without(&self, these: &[usize]) -> Result<(f64, usize), SimError> {
        let others = self.segment_distances()?.into_iter();
        let others = others.filter(|s| !these.contains(&s.recording));
        Ok(others.fold((0.0, 0), |(cost, rows), s| {
            (cost + s.mean * s.rows as f64, rows + s.rows)
        }))
    }

    /// Recordings whose contacts may be none: most of them were set aside as misread, or are
    /// farther from the model than those of other recordings.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub(super) fn ambiguous_recordings(&self) -> Result<Vec<usize>, SimError> {
        let distances = self.segment_distances()?;
        let distances_by_recording: Vec<(usize, f64)> = distances
            .iter()
            .filter(|s| s.stays)
            .map(|s| (s.recording, s.mean))
            .collect();
        let doubtful = |&k: &usize| {
            let stays = self.point.segments.iter();
            let all = stays.filter(|s| s.recording == k && s.starts_held).count();
            let used = distances_by_recording.iter().filter(|s| s.0 == k).count();
            let aside = all - used;
            let misread =
                aside >= HOVER_MIN_STAYS && aside as f64 > HOVER_MIN_MISREAD_SHARE * all as f64;
            misread || (used >= HOVER_MIN_STAYS && is_far_off(&distances_by_recording, k, &[k]))
        };
        let all: Vec<usize> = (0..self.problem.data.len()).filter(doubtful).collect();
        // Where the other segments are far off too, what is missing has nothing to do with
        // contacts.
        let is_other = |k| !all.contains(&k);
        let distances_by_recording: Vec<(usize, f64)> =
            distances.iter().map(|s| (s.recording, s.mean)).collect();
        Ok(
            if median_distance(&distances_by_recording, is_other) > LOST_TRACK_CHI2 {
                Vec::new()
            } else {
                all
            },
        )
    }

    /// Whether `other`, for which the recordings `flown` have no contacts, sets no more
    /// segments aside and describes those recordings as well as the others.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub(super) fn is_beaten_by(&self, other: &Self, flown: &[usize]) -> Result<bool, SimError> {
        let segments = other.segment_distances()?;
        let distances_by_recording: Vec<(usize, f64)> =
            segments.iter().map(|s| (s.recording, s.mean)).collect();
        let far = flown
            .iter()
            .filter(|&&k| is_far_off(&distances_by_recording, k, flown))
            .count();
        log::debug!(
            "flown through: {:.1} % aside in place of {:.1} %, {far} of {} far off",
            100.0 * other.set_aside_share(),
            100.0 * self.set_aside_share(),
            flown.len()
        );
        Ok(other.set_aside_share() <= self.set_aside_share() && far == 0)
    }
}

/// Whether the segments of recording `k` are farther off than those of all but `these`. Each
/// distance is given with its recording.
fn is_far_off(distances: &[(usize, f64)], k: usize, these: &[usize]) -> bool {
    let usual = median_distance(distances, |r| !these.contains(&r));
    median_distance(distances, |r| r == k)
        > HOVER_MIN_CHI2_RATIO * if usual > 1.0 { usual } else { 1.0 }
}

/// Median of the distances, each given with its recording, over the recordings that satisfy
/// `which`.
fn median_distance(distances: &[(usize, f64)], which: impl Fn(usize) -> bool) -> f64 {
    let mut own: Vec<f64> = distances
        .iter()
        .filter(|s| which(s.0))
        .map(|s| s.1)
        .collect();
    quantile_in_place(&mut own, 0.5)
}
