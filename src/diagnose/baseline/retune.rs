//! The baseline re-tuned, with the recordings cut again where they turn out to have been misread:
//! readings that are late, or a mass that comes to rest above the ground without touching it.

use std::mem::replace;
use std::sync::Arc;

use super::guided::GuidedBaseline;
use crate::diagnose::data::reading_assumptions::{ContactAmbiguity, ReadingAssumptions};
use crate::diagnose::data::side::Split;
use crate::diagnose::findings::Remark;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::shooting::fitted::{Fitted, RequiredEffect};
use crate::diagnose::shooting::latency;
use crate::diagnose::shooting::workspace::Workspace;
use crate::model::Model;
use crate::model::effects::EffectSpec;

/// How often recordings are cut again for late readings.
const MAX_RECUTS: usize = 2;

/// The re-tuned baseline.
#[derive(Debug)]
pub struct RetunedBaseline {
    /// The recordings as cut for it.
    pub workspace: Workspace,
    /// Its fit.
    pub train: Fitted,
    /// The fit to the held-out recordings; `None` if there are none.
    pub held_out: Option<Fitted>,
    /// What was found out.
    pub remarks: Vec<Remark>,
    /// Recordings of either side in which the mass might hover.
    pub ambiguous: (Vec<usize>, Vec<usize>),
}

impl Workspace {
    /// Those of the `doubtful` recordings of `side` that may hover over the ground: not those
    /// whose ground clearly drifts or steps. None at all where the ground steps in a recording
    /// that is not doubtful, because others lie higher or lower for that.
    pub fn may_hover(&self, side: &Split, mut doubtful: Vec<usize>) -> Vec<usize> {
        let steps = |s: &Split| {
            let ambiguous = |k: usize| std::ptr::eq(s, side) && doubtful.contains(&k);
            let all = s.findings.iter().enumerate();
            let mut sure = all.filter(|(k, _)| !ambiguous(*k));
            sure.any(|(_, f)| f.change.is_some_and(|c| c.drift().is_none()))
        };
        let mut sides = std::iter::once(&self.train).chain(&self.held_out);
        if sides.any(steps) {
            return Vec::new();
        }
        doubtful.retain(|&k| side.findings[k].change.is_none());
        doubtful
    }

    /// The baseline re-tuned from `model`. The recordings are cut again where their readings turn
    /// out to be late by more than segments tolerate. Contact is left out of those in which
    /// flight throughout fits better (or worse, or of those that `hovering` lists). `judging` is
    /// called before the held-out recordings are looked at.
    ///
    /// # Errors
    /// [`DiagnoseError`] if a recording or the model cannot be used.
    pub fn retune_baseline(
        self,
        model: &Model,
        (options, hovering): (&DiagnoseOptions, &ContactAmbiguity),
        control: &DiagnoseControl<'_>,
        judging: &dyn Fn(),
    ) -> Result<RetunedBaseline, DiagnoseError> {
        let mut retuning = Retuning::begin(self, model, (options, hovering), control)?;
        let cut_first = retuning.recut_for_latency()?;
        retuning.add_lag(cut_first)?;
        retuning.resolve_hovering_train()?;
        judging();
        let held_out = retuning.resolve_hovering_held_out()?;
        Ok(RetunedBaseline {
            workspace: retuning.workspace,
            train: retuning.train,
            held_out,
            remarks: retuning.remarks,
            ambiguous: retuning.ambiguous,
        })
    }

    /// The same recordings cut again for `model` under other assumptions on the readings.
    fn recut(
        &self,
        model: &Model,
        options: &DiagnoseOptions,
        assumptions: &ReadingAssumptions,
    ) -> Result<Self, DiagnoseError> {
        let held_out = self.held_out.as_ref().map_or(&[][..], |s| &s.parts);
        Self::with_assumptions(model, (&self.train.parts, held_out), options, assumptions)
    }
}

/// A baseline being re-tuned, one step after the other.
struct Retuning<'a, 'c> {
    model: &'a Model,
    options: &'a DiagnoseOptions,
    hovering: &'a ContactAmbiguity,
    control: &'a DiagnoseControl<'c>,
    /// The recordings as they are cut now.
    workspace: Workspace,
    /// The baseline's fit to them.
    train: Fitted,
    /// The fit with a drift of the zero, if the level of the ground shows one.
    drift: Option<RequiredEffect>,
    assumptions: ReadingAssumptions,
    /// Recordings of either split in which the mass might hover.
    ambiguous: (Vec<usize>, Vec<usize>),
    remarks: Vec<Remark>,
}

impl<'a, 'c> Retuning<'a, 'c> {
    /// The first fit: without the effect that the force balance calls for, else with a lag of the
    /// readings if the data show one.
    fn begin(
        workspace: Workspace,
        model: &'a Model,
        (options, hovering): (&'a DiagnoseOptions, &'a ContactAmbiguity),
        control: &'a DiagnoseControl<'c>,
    ) -> Result<Self, DiagnoseError> {
        let asked = |spec: &EffectSpec| options.asks(spec.id);
        let guide = workspace.balance_guide(model, &asked)?;
        let mut assumptions = ReadingAssumptions {
            own_scales: guide.scales_differ,
            ..ReadingAssumptions::default()
        };
        let workspace = if guide.scales_differ {
            workspace.with_own_scales()
        } else {
            workspace
        };
        let guided = workspace.guided_baseline(guide.rivals, control)?;
        let recut = |workspace: &Workspace, assumptions: &ReadingAssumptions| {
            workspace.recut(model, options, assumptions)
        };
        let (workspace, train, drift) = match guided {
            GuidedBaseline::Astray(astray, train) => (*astray, train, None),
            // A drift that the level shows is fitted with everything else.
            GuidedBaseline::Plain(train) if workspace.unmodelled_drift(model).is_none() => {
                (workspace, train, None)
            }
            GuidedBaseline::Plain(_) | GuidedBaseline::Unknown => {
                let lag = workspace.sensor_lag_baseline(model, options, control, &recut)?;
                if let Some((cut_again, train, lag)) = lag {
                    assumptions.lag = lag;
                    (cut_again, train, None)
                } else {
                    let start = guide.tuned.as_ref().unwrap_or(model);
                    let (train, drift) = workspace.with_and_without_drift(start, control)?;
                    (workspace, train, drift)
                }
            }
        };
        Ok(Self {
            model,
            options,
            hovering,
            control,
            workspace,
            train,
            drift,
            assumptions,
            ambiguous: (Vec::new(), Vec::new()),
            remarks: Vec::new(),
        })
    }

    /// Cuts the recordings again while their clocks agree that the readings are late. Returns
    /// what was there before the first cut.
    fn recut_for_latency(&mut self) -> Result<Option<(Workspace, Fitted)>, DiagnoseError> {
        let mut first = None;
        for _ in 0..MAX_RECUTS {
            // A known lag of the readings explains their latency.
            let go_on = self.workspace.required_effect.is_none() && !self.control.cancelled();
            let Some(late) = latency::common_latency(&self.train).filter(|_| go_on) else {
                break;
            };
            self.assumptions.latency += late;
            log::debug!("readings are {:.1} us late", 1e6 * self.assumptions.latency);
            let (model, options) = (self.model, self.options);
            let cut_again = self.workspace.recut(model, options, &self.assumptions)?;
            let (fit, drift) = cut_again.with_and_without_drift(model, self.control)?;
            self.drift = drift;
            let before = (
                replace(&mut self.workspace, cut_again),
                replace(&mut self.train, fit),
            );
            first.get_or_insert(before);
        }
        Ok(first)
    }

    /// Requires a lag of the amplifier or the sensor if that explains the data better than late
    /// readings: in the recordings as first cut, `cut_first`, or where the clocks disagree.
    fn add_lag(&mut self, cut_first: Option<(Workspace, Fitted)>) -> Result<(), DiagnoseError> {
        let (options, control) = (self.options, self.control);
        let tuned = (&self.workspace, &self.train);
        if let Some((cut_first, fit)) = cut_first.filter(|_| !control.cancelled()) {
            let late = self.assumptions.latency;
            if let Some(lag) = cut_first.best_lag(late, tuned, options, control)? {
                (self.workspace, self.train) = (cut_first, fit);
                self.workspace.required_effect = Some(Arc::new(lag));
                self.assumptions.latency = 0.0;
            }
        } else if self.workspace.required_effect.is_none()
            && !control.cancelled()
            && let Some(late) = latency::clock_disagreement(&self.train)
            && let Some(lag) = self.workspace.best_lag(late, tuned, options, control)?
        {
            self.workspace.required_effect = Some(Arc::new(lag));
        }
        Ok(())
    }

    /// Whether the reading that fits better is taken; the other one is only where contact is
    /// ambiguous `first`.
    fn follows_fit(&self, first: bool) -> bool {
        !first || *self.hovering == ContactAmbiguity::AsFitted
    }

    /// Leaves contact out of the fitted recordings in which the mass hovers, and requires the
    /// drift where the baseline has lost its way without it.
    fn resolve_hovering_train(&mut self) -> Result<(), DiagnoseError> {
        let lags = self.workspace.required_effect.is_some();
        let lost = |train: &Fitted| !lags && train.is_lost();
        self.drift = self.drift.take().filter(|_| lost(&self.train));
        let fit = self.drift.as_ref();
        let fit = fit.map_or(&self.train, |drift| &drift.fitted);
        let (candidates, is_given) = match self.hovering {
            ContactAmbiguity::HoveringIn(these, _) => (these.clone(), true),
            _ => (fit.ambiguous_recordings()?, false),
        };
        let hovering = self.workspace.may_hover(&self.workspace.train, candidates);
        // Where the drive lags, that is why the baseline is far off.
        if !hovering.is_empty() && !lags && !self.control.cancelled() {
            self.ambiguous.0.clone_from(&hovering);
            let mut assumptions = self.assumptions.clone();
            assumptions.hovering.0 = hovering;
            let (model, options) = (self.model, self.options);
            let other = self.workspace.recut(model, options, &assumptions)?;
            let (other_fit, drift) = other.retune_from(model, &self.train, self.control)?;
            let drift = drift.filter(|_| lost(&other_fit));
            let with = drift.as_ref().map_or(&other_fit, |drift| &drift.fitted);
            let flown = &assumptions.hovering.0;
            if is_given || fit.is_beaten_by(with, flown)? == self.follows_fit(true) {
                self.remarks.extend(hovering_remarks(&other.train, flown));
                self.workspace = other;
                self.train = other_fit;
                self.assumptions = assumptions;
                self.drift = drift;
            }
        }
        if let Some(drift) = self.drift.take() {
            self.workspace.required_effect = Some(Arc::new(drift));
        }
        Ok(())
    }

    /// The fit to the held-out recordings, contact left out of those in which the mass hovers.
    fn resolve_hovering_held_out(&mut self) -> Result<Option<Fitted>, DiagnoseError> {
        let (model, train) = (&self.train.model, (&self.train, None));
        let held_out = self.workspace.fit_held_out(model, train, self.control)?;
        let (Some(fit), Some(split)) = (&held_out, &self.workspace.held_out) else {
            return Ok(held_out);
        };
        let candidates = match self.hovering {
            ContactAmbiguity::HoveringIn(_, these) => these.clone(),
            _ => fit.ambiguous_recordings()?,
        };
        let hovering = self.workspace.may_hover(split, candidates);
        if hovering.is_empty() || self.control.cancelled() {
            return Ok(held_out);
        }
        self.ambiguous.1.clone_from(&hovering);
        let mut assumptions = self.assumptions.clone();
        assumptions.hovering.1 = hovering;
        let mut other = self
            .workspace
            .recut(self.model, self.options, &assumptions)?;
        other
            .required_effect
            .clone_from(&self.workspace.required_effect);
        let other_fit = other.fit_held_out(model, train, self.control)?;
        let flown = &assumptions.hovering.1;
        let better = match &other_fit {
            Some(after) => fit.is_beaten_by(after, flown)?,
            None => false,
        };
        let is_given = matches!(self.hovering, ContactAmbiguity::HoveringIn(..));
        if !is_given && better != self.follows_fit(self.ambiguous.0.is_empty()) {
            return Ok(held_out);
        }
        let split = other.held_out.as_ref();
        let remarks = split.into_iter().flat_map(|s| hovering_remarks(s, flown));
        self.remarks.extend(remarks);
        self.workspace = other;
        Ok(other_fit)
    }
}

/// Remarks that the mass hovers in some recordings of a split.
fn hovering_remarks(side: &Split, hovers: &[usize]) -> Vec<Remark> {
    let one = |&k: &usize| Remark::RestsAboveGround {
        recording: side.parts[k].recording.name.clone(),
    };
    hovers.iter().map(one).collect()
}
