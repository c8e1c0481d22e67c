//! TODO-doc

use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::thresholds::{
    HOVER_MIN_CHI2_RATIO, HOVER_MIN_MISREAD_SHARE, HOVER_MIN_STAYS, LOST_TRACK_CHI2,
};
use crate::fit::segment::Segment;
use crate::recording::quantile_in_place;
use crate::sim::SimError;

/// How far a stretch is from the model.
struct SegmentDistance {
    recording: usize,
    /// Whether it is a stay on the ground.
    stays: bool,
    rows: usize,
    /// Chi2 per value.
    mean: f64,
}

impl Fitted {
    /// How far each stretch is that is not set aside.
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

    /// Cost of each recording's stretches that are not set aside, residuals clipped.
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

    /// Cost and number of the values of all recordings but `these`, residuals clipped.
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

    /// Recordings in whose stays on the ground the mass may be elsewhere: most of them were set
    /// aside as misread, or are farther from the model than those of other recordings.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub(super) fn ambiguous_recordings(&self) -> Result<Vec<usize>, SimError> {
        let distances = self.segment_distances()?;
        let told: Vec<(usize, f64)> = distances
            .iter()
            .filter(|s| s.stays)
            .map(|s| (s.recording, s.mean))
            .collect();
        let doubtful = |&k: &usize| {
            let stays = self.point.segments.iter();
            let all = stays.filter(|s| s.recording == k && s.starts_held).count();
            let used = told.iter().filter(|s| s.0 == k).count();
            let aside = all - used;
            let misread =
                aside >= HOVER_MIN_STAYS && aside as f64 > HOVER_MIN_MISREAD_SHARE * all as f64;
            misread || (used >= HOVER_MIN_STAYS && is_far_off(&told, k, &[k]))
        };
        let all: Vec<usize> = (0..self.problem.data.len()).filter(doubtful).collect();
        // Where the others are far off too, something is missing that says nothing of stays.
        let beside = |k| !all.contains(&k);
        let told: Vec<(usize, f64)> = distances.iter().map(|s| (s.recording, s.mean)).collect();
        Ok(if median_distance(&told, beside) > LOST_TRACK_CHI2 {
            Vec::new()
        } else {
            all
        })
    }

    /// Whether `other`, for which recordings are `flown` through, sets no more aside, and comes
    /// as near to those as to others.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub(super) fn is_beaten_by(&self, other: &Self, flown: &[usize]) -> Result<bool, SimError> {
        let told = other.segment_distances()?;
        let told: Vec<(usize, f64)> = told.iter().map(|s| (s.recording, s.mean)).collect();
        let far = flown
            .iter()
            .filter(|&&k| is_far_off(&told, k, flown))
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

/// Whether the stretches of recording `k` are farther off than those of all but `these`, of
/// which each has its recording and its distance.
fn is_far_off(told: &[(usize, f64)], k: usize, these: &[usize]) -> bool {
    let usual = median_distance(told, |r| !these.contains(&r));
    median_distance(told, |r| r == k) > HOVER_MIN_CHI2_RATIO * if usual > 1.0 { usual } else { 1.0 }
}

/// The median distance of stretches, of which each has its recording and its distance, of some
/// recordings.
fn median_distance(told: &[(usize, f64)], which: impl Fn(usize) -> bool) -> f64 {
    let mut own: Vec<f64> = told.iter().filter(|s| which(s.0)).map(|s| s.1).collect();
    quantile_in_place(&mut own, 0.5)
}
