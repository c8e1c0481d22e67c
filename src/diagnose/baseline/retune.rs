//! The baseline re-tuned, with the recordings cut again for it where they turn out to have been
//! misread: readings that are late, a mass that rests over the ground without touching it.

use std::mem::replace;
use std::sync::Arc;

use crate::diagnose::data::reading_assumptions::{ContactAmbiguity, ReadingAssumptions};
use crate::diagnose::data::side::Split;
use crate::diagnose::findings::Remark;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::latency;
use crate::diagnose::shooting::workspace::Workspace;
use crate::diagnose::thresholds::{
    HOVER_MIN_CHI2_RATIO, HOVER_MIN_MISREAD_SHARE, HOVER_MIN_STAYS, LOST_TRACK_CHI2,
};
use crate::fit::segment::Segment;
use crate::model::Model;
use crate::recording::quantile_in_place;
use crate::sim::SimError;

/// How often recordings are cut again for readings that are late.
const AGAIN: usize = 2;

/// Why a recording has no stays on the ground that seems to have some.
pub(crate) const HOVERS: &str = "the mass comes to rest over the ground without touching it";

/// How far a stretch is from the model.
struct Distance {
    recording: usize,
    /// Whether it is a stay on the ground.
    stays: bool,
    rows: usize,
    /// Chi2 per value.
    mean: f64,
}

/// The re-tuned baseline.
#[derive(Debug)]
pub struct Tuned {
    /// The recordings as cut for it.
    pub workspace: Workspace,
    /// Its fit.
    pub train: Fitted,
    /// Those kept out, judged; `None` if there are none.
    pub held_out: Option<Fitted>,
    /// What was found out.
    pub remarks: Vec<Remark>,
    /// Recordings of either side in which the mass might hover.
    pub doubted: (Vec<usize>, Vec<usize>),
}

impl Fitted {
    /// How far each stretch is that is not set aside.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    fn distances(&self) -> Result<Vec<Distance>, SimError> {
        let one = |(segment, mean): (&Segment, Option<(usize, f64)>)| {
            mean.map(|(rows, mean)| Distance {
                recording: segment.recording,
                stays: segment.starts_held,
                rows,
                mean,
            })
        };
        let all = self.point.segments.iter().zip(self.means()?);
        Ok(all.filter_map(one).collect())
    }

    /// Cost of each recording's stretches that are not set aside, residuals clipped.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn costs(&self) -> Result<Vec<f64>, SimError> {
        let mut costs = vec![0.0; self.problem.data.len()];
        for s in self.distances()? {
            costs[s.recording] += s.mean * s.rows as f64;
        }
        Ok(costs)
    }

    /// Cost and number of the values of all recordings but `these`, residuals clipped.
    ///
    /// # Errors
    /// [`SimError`] if the model makes no sense.
    pub fn cost_beside(&self, these: &[usize]) -> Result<(f64, usize), SimError> {
        let others = self.distances()?.into_iter();
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
    fn doubtful(&self) -> Result<Vec<usize>, SimError> {
        let distances = self.distances()?;
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
            misread || (used >= HOVER_MIN_STAYS && apart(&told, k, &[k]))
        };
        let all: Vec<usize> = (0..self.problem.data.len()).filter(doubtful).collect();
        // Where the others are far off too, something is missing that says nothing of stays.
        let beside = |k| !all.contains(&k);
        let told: Vec<(usize, f64)> = distances.iter().map(|s| (s.recording, s.mean)).collect();
        Ok(if median(&told, beside) > LOST_TRACK_CHI2 {
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
    fn yields_to(&self, other: &Self, flown: &[usize]) -> Result<bool, SimError> {
        let told = other.distances()?;
        let told: Vec<(usize, f64)> = told.iter().map(|s| (s.recording, s.mean)).collect();
        let far = flown.iter().filter(|&&k| apart(&told, k, flown)).count();
        log::debug!(
            "flown through: {:.1} % aside in place of {:.1} %, {far} of {} far off",
            100.0 * other.aside(),
            100.0 * self.aside(),
            flown.len()
        );
        Ok(other.aside() <= self.aside() && far == 0)
    }
}

/// Whether the stretches of recording `k` are farther off than those of all but `these`, of
/// which each has its recording and its distance.
fn apart(told: &[(usize, f64)], k: usize, these: &[usize]) -> bool {
    let usual = median(told, |r| !these.contains(&r));
    median(told, |r| r == k) > HOVER_MIN_CHI2_RATIO * if usual > 1.0 { usual } else { 1.0 }
}

/// The median distance of stretches, of which each has its recording and its distance, of some
/// recordings.
fn median(told: &[(usize, f64)], which: impl Fn(usize) -> bool) -> f64 {
    let mut own: Vec<f64> = told.iter().filter(|s| which(s.0)).map(|s| s.1).collect();
    quantile_in_place(&mut own, 0.5)
}

impl Workspace {
    /// The baseline re-tuned from `model`, with the recordings cut for it again where their
    /// readings turn out to be late by more than stretches bear, and without stays in those
    /// in which flight through suits better (or less, or in those it names, as `hovering` asks).
    /// `judging` is called before those kept out are looked at.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a recording or the model cannot be used.
    pub fn tuned(
        self,
        model: &Model,
        (options, hovering): (&DiagnoseOptions, &ContactAmbiguity),
        control: &DiagnoseControl<'_>,
        judging: &dyn Fn(),
    ) -> Result<Tuned, DiagnoseError> {
        let mut known = ReadingAssumptions::default();
        let mut doubted = (Vec::new(), Vec::new());
        // The other way only where it is in doubt first.
        let as_told = |first: bool| !first || *hovering == ContactAmbiguity::AsTold;
        let mut workspace = self;
        let again = |workspace: &Self, known: &ReadingAssumptions| {
            let held_out = workspace.held_out.as_ref().map_or(&[][..], |s| &s.parts);
            Self::of_known(model, (&workspace.train.parts, held_out), options, known)
        };
        let (mut train, mut drift) = match workspace.behind(model, options, control, &again)? {
            Some((other, fit, lag)) => {
                workspace = other;
                known.lag = lag;
                (fit, None)
            }
            None => workspace.with_and_without_drift(model, control)?,
        };
        let mut first = None;
        for _ in 0..AGAIN {
            // Readings that are known to lag are late for that.
            let go_on = workspace.found.is_none() && !control.cancelled();
            let Some(late) = latency::late(&train).filter(|_| go_on) else {
                break;
            };
            known.late += late;
            log::debug!("readings are {:.1} us late", 1e6 * known.late);
            let cut_again = again(&workspace, &known)?;
            let (fit, own) = cut_again.with_and_without_drift(model, control)?;
            drift = own;
            let before = (replace(&mut workspace, cut_again), replace(&mut train, fit));
            first.get_or_insert(before);
        }
        if let Some((cut_first, fit)) = first.filter(|_| !control.cancelled()) {
            if let Some(lagging) =
                cut_first.lagging(known.late, (&workspace, &train), options, control)?
            {
                (workspace, train) = (cut_first, fit);
                workspace.found = Some(Arc::new(lagging));
                known.late = 0.0;
            }
        } else if workspace.found.is_none()
            && !control.cancelled()
            && let Some(late) = latency::disagreement(&train)
            && let Some(lagging) =
                workspace.lagging(late, (&workspace, &train), options, control)?
        {
            workspace.found = Some(Arc::new(lagging));
        }
        let lags = workspace.found.is_some();
        let lost = |train: &Fitted| !lags && train.is_lost();
        let mut drift = drift.filter(|_| lost(&train));
        let mut remarks = Vec::new();
        // With a drift without which the baseline is lost.
        let told = drift.as_ref().map_or(&train, |drift| &drift.fitted);
        let (doubtful, over) = match hovering {
            ContactAmbiguity::Over(these, _) => (these.clone(), true),
            _ => (told.doubtful()?, false),
        };
        let hovers = workspace.may_hover(&workspace.train, doubtful);
        // Where the drive lags the baseline is far off for that.
        if !hovers.is_empty() && !lags && !control.cancelled() {
            doubted.0.clone_from(&hovers);
            let mut flown = known.clone();
            flown.hovers.0 = hovers;
            let other = again(&workspace, &flown)?;
            let (fit, own) = other.baseline_again(model, &train, control)?;
            let own = own.filter(|_| lost(&fit));
            let with = own.as_ref().map_or(&fit, |own| &own.fitted);
            if over || told.yields_to(with, &flown.hovers.0)? == as_told(true) {
                remarks.extend(said(&other.train, &flown.hovers.0));
                (workspace, train, known, drift) = (other, fit, flown, own);
            }
        }
        if let Some(drift) = drift {
            workspace.found = Some(Arc::new(drift));
        }
        judging();
        let mut held_out = workspace.judge(&train.model, (&train, None), control)?;
        let hovers = match (&held_out, &workspace.held_out) {
            (Some(judged), Some(side)) => {
                let doubtful = match hovering {
                    ContactAmbiguity::Over(_, these) => these.clone(),
                    _ => judged.doubtful()?,
                };
                workspace.may_hover(side, doubtful)
            }
            _ => Vec::new(),
        };
        if !hovers.is_empty() && !control.cancelled() {
            doubted.1.clone_from(&hovers);
            let mut flown = known;
            flown.hovers.1 = hovers;
            let mut other = again(&workspace, &flown)?;
            other.found.clone_from(&workspace.found);
            let judged = other.judge(&train.model, (&train, None), control)?;
            let better = match (&held_out, &judged) {
                (Some(before), Some(after)) => before.yields_to(after, &flown.hovers.1)?,
                _ => false,
            };
            if over || better == as_told(doubted.0.is_empty()) {
                let side = other.held_out.as_ref();
                remarks.extend(side.into_iter().flat_map(|s| said(s, &flown.hovers.1)));
                (workspace, held_out) = (other, judged);
            }
        }
        Ok(Tuned {
            workspace,
            train,
            held_out,
            remarks,
            doubted,
        })
    }
}

/// That the mass rests above the ground in some recordings of a side.
fn said(side: &Split, hovers: &[usize]) -> Vec<Remark> {
    let one = |&k: &usize| Remark::RestsAboveGround {
        recording: side.parts[k].recording.name.clone(),
    };
    hovers.iter().map(one).collect()
}
