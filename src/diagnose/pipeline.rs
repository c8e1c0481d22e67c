//! A diagnosis of recordings that are read one way, from beginning to end.

use std::time::Instant;

use super::answer::assemble::{misread, shown_alike};
use super::answer::candidate_table::candidates;
use super::answer::effect_size;
use super::answer::events_seen::events_seen;
use super::answer::named_effects::names;
use super::answer::next_experiment::next;
use super::answer::proof::{SplitSamples, strips};
use super::comparison::trial::ModelState;
use super::contact::decide::Rules;
use super::contact::event_readings;
use super::contact::law_test::LawTest;
use super::data::reading_assumptions::ContactAmbiguity;
use super::data::screening::screen;
use super::diagnosis::{BeforeAfter, Diagnosis, Distance, Inadequacy, Verdict};
use super::discrepancy::residual_map::Sample;
use super::discrepancy::{law_form, missing_force, probes, residual_map};
use super::hypotheses::raised_level::raised_recordings;
use super::hypotheses::vibration_clock::VibrationClock;
use super::options::{
    DiagnoseControl, DiagnoseError, DiagnoseOptions, DiagnoseProgress, remaining,
};
use super::selection::forward;
use super::shooting::fitted::{Fitted, excess_chi2};
use super::shooting::workspace::Workspace;
use super::thresholds::{
    ADEQUATE_MAX_CHI2, FORM_EXPLAINS_SHARE, JOINS_MAX_Z, NOISE_MAX_Z, TRAIN_GAIN,
};
use super::verdict::abstention::{AbstentionEvidence, attraction_reaches_far, of_displacement};
use super::verdict::adequacy::{breaks, fails_held_out, whats_left};
use crate::fit::Part;
use crate::model::effects::EffectSpec;
use crate::model::{Model, with_effect};
use crate::recording::quantile_in_place;
use crate::sim::SimError;

/// How recordings were read.
#[derive(Debug, Clone)]
pub struct Reading {
    /// Where the mass might hover in some of them: chi2 per value of the others at the end of the
    /// search, or by the baseline where only that tells; not a number if there are none.
    pub beside_doubted: Option<f64>,
    /// How they are to be read where nothing explains them and that is in doubt.
    pub otherwise: ContactAmbiguity,
    /// Share of the rows that were set aside, of both sides together.
    pub aside: f64,
}

/// One diagnosis of the fitted recordings and those kept out: where it is in doubt whether the mass
/// hovers in a recording, `hovering` says how that is decided.
///
/// # Errors
/// [`DiagnoseError`] if a recording or the model cannot be used.
pub fn read(
    model: &Model,
    (train, held_out): (&[Part], &[Part]),
    (options, hovering): (&DiagnoseOptions, &ContactAmbiguity),
    control: &DiagnoseControl<'_>,
) -> Result<(Diagnosis, Reading), DiagnoseError> {
    let begun = Instant::now();
    let say = |stage: &'static str, detail: &str, done: f64| {
        (control.progress)(&DiagnoseProgress {
            stage,
            detail: detail.to_owned(),
            done,
            remaining: remaining(done, begun.elapsed()),
        });
    };
    let again = match hovering {
        ContactAmbiguity::AsFitted => "",
        ContactAmbiguity::Opposite | ContactAmbiguity::HoveringIn(..) => {
            "once more, where the mass may hover"
        }
    };
    say("recordings", again, 0.0);
    let ready = screen(model, train, held_out)?;
    let mut remarks = ready.remarks;
    let workspace = Workspace::new(model, &ready.train, &ready.held_out, options)?;
    if workspace.held_out.is_none() {
        remarks.push("nothing was kept out, so that no improvement can be proved".to_owned());
    }
    say("baseline", "re-tuning", 0.05);
    let judging = || say("baseline", "recordings kept out", 0.25);
    let mut tuned = workspace.retune_baseline(model, (options, hovering), control, &judging)?;
    let mut clocks = None;
    // A baseline that is lost without what the re-tuning has found tells no clocks.
    let told = tuned.workspace.required_effect.is_none() && ready.may_name;
    if options.asks("base_vibration") && told && !control.cancelled() {
        clocks = VibrationClock::of(&tuned.train, tuned.held_out.as_ref())?;
    }
    if let Some(clocks) = &clocks {
        remarks.push("the base shakes in another phase in each recording; the phase that is given is that of the first one".to_owned());
        let (train, held_out) = clocks.shift_recordings(&ready.train, &ready.held_out);
        let workspace = Workspace::new(model, &train, &held_out, options)?;
        tuned = workspace.retune_baseline(model, (options, hovering), control, &judging)?;
    }
    let workspace = tuned.workspace;
    remarks.extend(tuned.remarks);
    let baseline = ModelState {
        train: tuned.train,
        held_out: tuned.held_out,
        named: Vec::new(),
        misread: false,
    };

    say("ground", "bounces and releases", 0.3);
    let mut seen = event_readings::read(
        &workspace,
        &baseline.train,
        baseline.held_out.as_ref(),
        None,
        control,
    )?;
    let mut tests = super::contact::decide::tests(&seen);
    let rules = Rules {
        by_hand: options.by_hand.as_deref(),
        held_out: workspace.held_out.is_some(),
    };

    say("naming", "", 0.35);
    let mut chosen = options.clone();
    if !ready.may_name {
        chosen.most = 0;
    }
    let report = |detail: &str, share: f64| say("naming", detail, 0.35 + 0.4 * share);
    let first_cost = baseline.train.cost;
    let mut found = forward::select_effects(&workspace, baseline, &chosen, control, &report)?;

    let beside_doubted = beside(&found.stand, &tuned.ambiguous)?;

    // A name that turned out needless may have led the re-tuning on.
    if found.baseline.train.cost < first_cost {
        let (t, h) = (&found.baseline.train, found.baseline.held_out.as_ref());
        seen = event_readings::read(&workspace, t, h, Some(&seen), control)?;
        tests = super::contact::decide::tests(&seen);
    }
    let mut named_laws: Vec<LawTest> = Vec::new();
    if ready.may_name {
        let first = tests.clone();
        if !found.stand.named.is_empty() {
            say("ground", "bounces and releases again", 0.78);
            let (t, h) = (&found.stand.train, found.stand.held_out.as_ref());
            tests = super::contact::decide::tests(&event_readings::read(
                &workspace,
                t,
                h,
                Some(&seen),
                control,
            )?);
        }
        named_laws = rules.named(&first, &tests, &found.stand.specs());
    }

    say("evidence", "", 0.8);
    let evidence = missing_force::measure(&found.baseline.train)?;
    let some = !found.stand.named.is_empty();
    let after_evidence = if some {
        missing_force::measure(&found.stand.train)?
    } else {
        evidence.clone()
    };
    // Chi2 goes as the inverse square of the noise.
    let floor = ADEQUATE_MAX_CHI2 + 2.0 * NOISE_MAX_Z * workspace.noise_error;
    let broken = breaks(&found.stand)?;
    let rings = || found.weighed.iter().find_map(|w| w.by_itself);
    // A fit that was broken off proves nothing either way.
    let may_doubt = !some && named_laws.is_empty() && !control.cancelled();
    let mut left = whats_left(&found.stand, &after_evidence, broken.sigmas, floor)
        .or_else(|| rings().map(Inadequacy::Ring))
        .or_else(|| fails_held_out(&found.weighed).filter(|_| may_doubt));
    if !some && left.is_some() && options.by_hand.is_none() {
        // What the events say rests on a model of flight that does not hold. Only a ground
        // that gives way shows in stays as well.
        named_laws.retain(|t| t.id == "compliant_ground");
    }
    let mut verdict = if some || !named_laws.is_empty() {
        Verdict::MissingPhysics
    } else if left.is_some() {
        Verdict::Unexplained
    } else {
        Verdict::Adequate
    };
    if some && options.by_hand.is_none() {
        let named = &found.stand.named;
        let carried: f64 = named.iter().map(|n| n.gain.0).sum();
        // What a law would bring that goes with more, and what those named do in whose place it is.
        let other_than = |which: &dyn Fn(&&'static EffectSpec) -> bool,
                          gain: fn(&Fitted) -> Result<f64, SimError>|
         -> Result<(f64, f64), SimError> {
            let own = named.iter().filter(|n| which(&n.spec));
            let beside: f64 = own.map(|n| n.gain.0).sum();
            let other = if beside > 0.0 {
                gain(&found.stand.train)?
            } else {
                0.0
            };
            Ok((other, beside))
        };
        // What laws of somewhat other form would carry is not missing.
        let formal = if left.is_some() {
            law_form::form_error_gain(&found.stand.train, &found.stand.specs())?
        } else {
            0.0
        };
        let rest = after_evidence.joint.max(0.0) + excess_chi2(&found.stand.train);
        let mut share = carried / (carried + (rest - formal).max(0.0));
        if let Some(held) = &found.stand.held_out {
            let held_carried: f64 = named.iter().map(|n| n.gain.1).sum();
            let formal = formal * (held_carried / carried).clamp(0.0, 1.0);
            let rest = (excess_chi2(held) - formal).max(0.0);
            share = share.min(held_carried / (held_carried + rest));
        }
        let explained = share;
        // What is left for the form of a law also breaks the flight.
        if broken.sigmas > JOINS_MAX_Z && formal < FORM_EXPLAINS_SHARE * rest {
            // A baseline that sets aside what it cannot tell may look unbroken.
            let before = breaks(&found.baseline)?.rise.max(broken.rise);
            let own = (1.0 - broken.rise / before).max(0.0);
            // Where it is all that is left, the stretches themselves are told.
            let alone = matches!(left, Some(Inadequacy::Joins(_)));
            share = if alone { own } else { share.min(own) };
        }
        let rest = AbstentionEvidence {
            left,
            names: found.stand.specs().iter().map(|s| s.name).collect(),
            displaced: found
                .stand
                .specs()
                .into_iter()
                .filter(of_displacement)
                .collect(),
            far: attraction_reaches_far(&found.stand.train.model),
            over_xp: after_evidence
                .strongest
                .is_some_and(|s| s.0.symbol() == "xp"),
            joint: after_evidence.joint,
            formal,
            swings: probes::swinging_stiffness_gain(&found.stand.train)?,
            rubs: other_than(
                &|spec| spec.id == "dry_friction",
                probes::friction_at_height_gain,
            )?,
            product: other_than(&of_displacement, probes::displacement_product_gain)?,
            share,
            explained,
        };
        log::debug!("{rest:?}");
        if rest.swings > TRAIN_GAIN {
            left = left.or(Some(Inadequacy::Force("xp", rest.swings)));
        }
        if rest.goes_with_both() {
            left = left.or(Some(Inadequacy::Force("xp", rest.product.0)));
        }
        if let Some(reason) = rest.refusal() {
            verdict = Verdict::Unexplained;
            remarks.push(reason);
            found.stand = found.baseline.clone();
            // What the events say rests on a model of flight that does not hold.
            named_laws.clear();
        }
    }
    say("proof", "", 0.92);
    let model_of = |stand: &ModelState, laws_too: bool| {
        let mut m = super::contact::nominal::baseline(&stand.train.model, &seen.train);
        for test in named_laws.iter().filter(|_| laws_too) {
            m = with_effect(&m, test.effect.clone());
            for (id, value) in &test.sets {
                m.parameters.set(*id, *value);
            }
        }
        m
    };
    let (bare, full) = (
        model_of(&found.baseline, false),
        model_of(&found.stand, true),
    );
    // Both are shown by the same stretches, also where one of them set some aside.
    let shown = shown_alike(&workspace, &found.baseline, &found.stand)?;
    remarks.extend(misread(&shown.0));
    let held_aside = found
        .stand
        .held_out
        .as_ref()
        .map_or(0.0, Fitted::set_aside_share);
    let aside = found.stand.train.set_aside_share() + held_aside;
    let (before, after) = (SplitSamples::look(&shown.0)?, SplitSamples::look(&shown.1)?);
    let named = names(&found, &named_laws, &after, &full)?;
    let candidates = candidates(&found, &tests, &named_laws, verdict);
    let noise = {
        let mut all: Vec<f64> = found
            .baseline
            .train
            .problem
            .data
            .iter()
            .map(|d| d.sigmas.xp)
            .collect();
        quantile_in_place(&mut all, 0.5)
    };
    let volts = found
        .baseline
        .train
        .problem
        .data
        .iter()
        .filter_map(|d| d.recording.voltage.as_ref())
        .flat_map(|v| v.iter())
        .filter(|v| v.is_finite())
        .fold(0.0f64, |a, v| a.max(v.abs()));
    let next_experiment = next(&found, &named, volts, noise, &bare);
    let mut mismatch = residual_map::mismatches(&shown.0.train, &before.train);
    mismatch.extend(super::answer::events_seen::mismatches(
        &named_laws,
        &seen,
        &found.baseline,
    ));
    let (mut along, mut proof) = strips((&shown.0.train, &before.train), &after.train, false);
    if let Some(held) = &shown.0.held_out {
        let (s, p) = strips((held, &before.held_out), &after.held_out, true);
        along.extend(s);
        proof.extend(p);
    }
    let mut forces = evidence.curves;
    for curve in &mut forces {
        curve.law = effect_size::law_on(curve, &found, &before.train);
    }
    let distances =
        |pick: fn(&ModelState) -> Option<&Fitted>, b: &[Sample], a: &[Sample]| BeforeAfter {
            before: pick(&shown.0).map_or(Distance::default(), |f| residual_map::distance(f, b)),
            after: pick(&shown.1).map_or(Distance::default(), |f| residual_map::distance(f, a)),
        };
    say("done", "", 1.0);
    let mut diagnosis = Diagnosis {
        verdict,
        named,
        candidates,
        mismatch,
        marginals: residual_map::marginals(&before.train, &after.train),
        forces,
        strips: along,
        events: events_seen(&seen, &found.baseline, &before),
        noise,
        train: distances(|s| Some(&s.train), &before.train, &after.train),
        held_out: distances(|s| s.held_out.as_ref(), &before.held_out, &after.held_out),
        proof,
        next_experiment,
        baseline: bare,
        model: full,
        remarks,
        cancelled: control.cancelled(),
        left,
    };
    if let Some(clocks) = clocks {
        clocks.undo(&mut diagnosis);
    }
    let mut reading = Reading {
        beside_doubted,
        otherwise: ContactAmbiguity::Opposite,
        aside,
    };
    // Asked by hand, nothing is ambiguous.
    let asks = *hovering == ContactAmbiguity::AsFitted
        && options.by_hand.is_none()
        && !control.cancelled();
    if asks && verdict == Verdict::Unexplained && beside_doubted.is_none() {
        let higher = raised_recordings(&workspace, &found.baseline)?;
        reading.beside_doubted = beside(&found.baseline, &higher)?;
        reading.otherwise = ContactAmbiguity::HoveringIn(higher.0, higher.1);
    }
    Ok((diagnosis, reading))
}

/// Chi2 per value of all but the `ambiguous` recordings of either side; `None` if there are no such
/// ones.
fn beside(
    stand: &ModelState,
    ambiguous: &(Vec<usize>, Vec<usize>),
) -> Result<Option<f64>, DiagnoseError> {
    if ambiguous.0.is_empty() && ambiguous.1.is_empty() {
        return Ok(None);
    }
    let (mut cost, mut rows) = stand.train.cost_without(&ambiguous.0)?;
    if let Some(held_out) = &stand.held_out {
        let own = held_out.cost_without(&ambiguous.1)?;
        (cost, rows) = (cost + own.0, rows + own.1);
    }
    Ok(Some(cost / rows as f64))
}
