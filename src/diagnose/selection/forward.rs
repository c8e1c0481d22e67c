//! Naming: hypotheses are promised by the scan, refitted, judged on the recordings kept
//! out, and added one by one as long as both sides improve beyond chance.

use super::evaluate::{is_asked, weigh};
use super::law_shape::{plainer, shaped};
use super::{choose, prune, self_ringing};
use crate::diagnose::comparison::significance;
use crate::diagnose::comparison::significance::{HELD_GAIN, by_chance};
use crate::diagnose::data::side::Side;
use crate::diagnose::discrepancy::law_form;
use crate::diagnose::hypotheses::propose::Hypothesis;
use crate::diagnose::options::{DiagnoseControl, DiagnoseError, DiagnoseOptions};
use crate::diagnose::shooting::fitted::Fitted;
use crate::diagnose::shooting::workspace::Bench;
use crate::diagnose::verdict::adequacy::is_beyond;
use crate::model::effects::EffectSpec;
use crate::model::effects::extra_mode::EFFECT;
/// Where other forms of the laws named would bring so many times what a further name brings,
/// it is one of those forms that is wrong, in a way that is not known.
const OUTWEIGHED: f64 = 2.0;
/// Chi2 per value up to which a law leaves nothing.
const WHOLE: f64 = 1.1;
/// Times that, of what leaves nothing, from which another one leaves much.
pub const APART: f64 = 1.2;
/// A further name must explain this share of what the first ones explained.
const SHARE: f64 = 0.004;
/// Least chi2 per value that a fit may reach, the noise known as well as it is.
const LEAST: f64 = 0.9;
/// Share of the rows set aside as misread from which they are looked at again.
const ASIDE: f64 = 0.03;
/// Or any, where chi2 per value is so many times larger on recordings kept out, and than 1.
const ODD: f64 = 1.3;
/// A name must bring back this share of them.
const BACK: f64 = 0.5;
/// Fall of chi2 per value from which what is misread is looked after anew.
const CLEARER: f64 = 1.5;

/// A hypothesis after a fit with it.
#[derive(Debug, Clone)]
pub struct Weighed {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// Fall of chi2 promised.
    pub promise: f64,
    /// The fit, if it was worth one.
    pub trial: Option<Trial>,
    /// Frequency of a further mode that is not named though its fit is good, for it rings by
    /// itself \[Hz\].
    pub by_itself: Option<f64>,
}

/// A fit with one more effect, judged.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Of the fitted recordings.
    pub train: Fitted,
    /// Of those kept out.
    pub held_out: Option<Fitted>,
    /// Fall of chi2 on the fitted recordings.
    pub gain: f64,
    /// Fall on those kept out; 0 if there are none.
    pub held_gain: f64,
    /// The hypothesis.
    pub hypothesis: Hypothesis,
}

impl Trial {
    /// Both gains.
    pub fn worth(&self) -> f64 {
        self.gain + self.held_gain
    }

    /// Whether the fitted recordings improve by far more than chance lets them, and those kept
    /// out, if there are any, do not.
    pub fn unproved(&self) -> bool {
        self.held_out.is_some()
            && significance::unproved(&self.hypothesis, self.gain, self.held_gain)
    }

    /// Whether either side improves by no more than the beginnings of its own let it that the
    /// hypothesis has in each stretch, beside those that `stand` has.
    fn by_beginnings(&self, stand: &Stand) -> bool {
        let more = |before: &Fitted, after: &Fitted| {
            after.beginnings().saturating_sub(before.beginnings())
        };
        let side = |before, after, gain| significance::by_beginnings(more(before, after), gain);
        let held_out = stand.held_out.as_ref().zip(self.held_out.as_ref());
        side(&stand.train, &self.train, self.gain)
            || held_out.is_some_and(|(before, after)| side(before, after, self.held_gain))
    }

    /// Whether the fitted recordings improve by no more than chance lets them.
    pub fn by_chance(&self) -> bool {
        by_chance(&self.hypothesis, self.gain, self.held_gain)
    }

    /// Whether the effect leaves nothing of the fitted recordings.
    pub fn leaves_nothing(&self) -> bool {
        self.train.per_value() < WHOLE
    }

    /// Whether it leaves nothing of them where `other` leaves much: no other form of its law is
    /// needed then, however large the shares are that both bring.
    pub fn excels(&self, other: &Self) -> bool {
        self.leaves_nothing() && other.train.per_value() > APART * self.train.per_value()
    }
}

/// Where the search stands: a model with the effects named so far.
#[derive(Debug, Clone)]
pub struct Stand {
    /// Fit to the recordings to be fitted.
    pub train: Fitted,
    /// Those kept out, judged.
    pub held_out: Option<Fitted>,
    /// The effects named, in the order found.
    pub named: Vec<Named>,
    /// Whether stretches that were misread for the baseline are in it.
    pub misread: bool,
}

impl Stand {
    /// The effects named.
    pub fn specs(&self) -> Vec<&'static EffectSpec> {
        self.named.iter().map(|n| n.spec).collect()
    }

    /// What the effects named have explained that may be of a somewhat other form. The law of a
    /// mode is of no uncertain form: what it leaves is no matter of that.
    fn explained(&self) -> f64 {
        let formed = self.named.iter().filter(|n| *n.spec != EFFECT);
        formed.map(|n| n.gain.0 + n.gain.1).sum()
    }

    /// Fall of chi2 that no further effect could exceed.
    fn most_left(&self) -> f64 {
        let sides = std::iter::once(&self.train).chain(&self.held_out);
        sides
            .map(|fitted| (fitted.cost - LEAST * fitted.point.rows as f64).max(0.0))
            .sum()
    }
}

/// An effect that was named.
#[derive(Debug, Clone)]
pub struct Named {
    /// The effect.
    pub spec: &'static EffectSpec,
    /// Its freedoms.
    pub hypothesis: Hypothesis,
    /// Fall of chi2 that it brought on either side.
    pub gain: (f64, f64),
    /// Others that did as well.
    pub alike: Vec<&'static str>,
    /// Why one that does as well in flight is not among those.
    pub told: Option<String>,
}

/// What the search found.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// The re-tuned baseline.
    pub baseline: Stand,
    /// With the effects named.
    pub stand: Stand,
    /// Everything weighed against the baseline.
    pub weighed: Vec<Weighed>,
}

/// Looks for what `baseline` lacks: first with what was set aside as misread, if it is much,
/// for an effect that spoils some stretches only hides in them.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
pub fn explain(
    bench: &Bench,
    baseline: Stand,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
    report: &dyn Fn(&str, f64),
) -> Result<Explanation, DiagnoseError> {
    let aside = baseline.train.aside();
    log::debug!("{:.1} % of the rows are set aside", 100.0 * aside);
    // What spoils recordings kept out may have been set aside in those fitted.
    let odd = baseline.held_out.as_ref().is_some_and(|held| {
        held.per_value() > ODD && held.per_value() > ODD * baseline.train.per_value()
    });
    let look = aside > ASIDE || (aside > 0.0 && odd);
    // Where it has lost its way in the others too, they tell what it lacks.
    if look
        && !baseline.train.is_lost()
        && options.by_hand.is_none()
        && let Some(found) = among_aside(bench, &baseline, options, control, report)?
    {
        return Ok(found);
    }
    let from = Explanation {
        stand: baseline.clone(),
        baseline,
        weighed: Vec::new(),
    };
    search(bench, from, options, control, report)
}

/// Looks for an effect that tells most of what was set aside as misread, and for others
/// beside it; `None` if there is none.
fn among_aside(
    bench: &Bench,
    baseline: &Stand,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
    report: &dyn Fn(&str, f64),
) -> Result<Option<Explanation>, DiagnoseError> {
    let all = |side: &Side, fitted: &Fitted| bench.with_all(side, fitted);
    let held_out = bench.held_out.as_ref().zip(baseline.held_out.as_ref());
    let whole = Stand {
        train: all(&bench.train, &baseline.train)?,
        held_out: held_out
            .map(|(side, fitted)| all(side, fitted))
            .transpose()?,
        named: Vec::new(),
        misread: true,
    };
    let once = DiagnoseOptions {
        most: options.most.min(1),
        ..options.clone()
    };
    let from = Explanation {
        baseline: baseline.clone(),
        stand: whole,
        weighed: Vec::new(),
    };
    let mut found = search(bench, from, &once, control, report)?;
    if found.stand.named.is_empty() {
        return Ok(None);
    }
    let stand = &mut found.stand;
    let series = stand.named.iter().any(|n| n.hypothesis.series);
    let bench = if series {
        bench.in_series()
    } else {
        bench.clone()
    };
    look_after(&bench, stand, control)?;
    stand.misread = false;
    let left = stand.train.aside();
    log::debug!("{:.1} % of the rows are set aside after that", 100.0 * left);
    // An effect that shows as well in the rest may have been fitted astray by them.
    let astray = stand.train.per_value() > ODD * baseline.train.per_value().max(1.0);
    if astray || left > (1.0 - BACK) * baseline.train.aside() {
        return Ok(None);
    }
    search(&bench, found, options, control, report).map(Some)
}

/// Sets aside what is misread for the model of `stand`.
fn look_after(
    bench: &Bench,
    stand: &mut Stand,
    control: &DiagnoseControl<'_>,
) -> Result<(), DiagnoseError> {
    stand.train = bench.healed(&bench.train, stand.train.clone(), false, control)?;
    if let (Some(side), Some(held_out)) = (&bench.held_out, stand.held_out.take()) {
        let near = (&stand.train, Some(&held_out));
        let judged = bench.judge(&stand.train.model, near, control)?;
        stand.held_out = judged
            .map(|judged| bench.healed(side, judged, true, control))
            .transpose()?;
    }
    Ok(())
}

/// Looks for what the stand of `from` still lacks.
///
/// # Errors
/// [`DiagnoseError`] if a model cannot be simulated.
fn search(
    bench: &Bench,
    from: Explanation,
    options: &DiagnoseOptions,
    control: &DiagnoseControl<'_>,
    report: &dyn Fn(&str, f64),
) -> Result<Explanation, DiagnoseError> {
    let Explanation {
        mut baseline,
        mut stand,
        mut weighed,
    } = from;
    let plain = bench;
    let mut bench = plain.clone();
    let rounds = options.by_hand.as_ref().map_or(options.most, Vec::len);
    for round in stand.named.len()..rounds {
        if control.cancelled() {
            break;
        }
        let about = |detail: &str, share: f64| {
            report(detail, (round as f64 + share) / rounds as f64);
        };
        let only = options.by_hand.as_ref().map(|ids| ids[round].as_str());
        // Nothing could bring enough to be named, or all that could would not do.
        let little = stand.most_left() < SHARE * stand.explained();
        if only.is_none() && (little || is_beyond(&stand, rounds - round)?) {
            break;
        }
        let mut round_weighed = weigh(&bench, &stand, options, only, control, &about)?;
        let is_asked = |spec: &EffectSpec| is_asked(&stand, options, only, spec);
        choose::add_twin(&bench, &stand, &mut round_weighed, &is_asked, control)?;
        let best = choose::best(&bench, &stand, &mut round_weighed, control)?;
        let vibration = self_ringing::vibration(&round_weighed);
        if weighed.is_empty() {
            weighed = round_weighed;
        }
        let Some(mut best) = best else {
            // Asked for by hand, the next one may still be something.
            if only.is_some() {
                continue;
            }
            break;
        };
        let mut trial = shaped(&bench, &stand, best.trial, control)?;
        let held = bench.held_out.is_none() || trial.held_gain > HELD_GAIN;
        let little = trial.worth() < SHARE * stand.explained();
        let chance = trial.by_chance()
            || !held
            || little
            || significance::vanishes(&trial.hypothesis, &trial.train.model);
        if only.is_none() && (chance || formal(&stand, &trial)?) {
            break;
        }
        if only.is_none()
            && let Some(f) = self_ringing::rings_by_itself(&bench, &stand, &trial, control)?
        {
            if let Some(vibration) = vibration.filter(|v| self_ringing::as_well(v, &trial)) {
                (best.spec, trial) = (vibration.hypothesis.start.spec, vibration);
                best.alike.clear();
            } else {
                let mut own = weighed.iter_mut();
                if let Some(own) = own.find(|w| w.spec == best.spec)
                    && !trial.by_beginnings(&stand)
                {
                    own.by_itself = Some(f);
                }
                break;
            }
        }
        if trial.hypothesis.series {
            bench = bench.in_series();
        }
        stand.named.push(Named {
            spec: best.spec,
            hypothesis: trial.hypothesis,
            gain: (trial.gain, trial.held_gain),
            alike: best.alike,
            told: best.told,
        });
        // What was misread did not stand out while all was far off.
        let clears =
            |(before, after): (&Fitted, &Fitted)| before.per_value() > CLEARER * after.per_value();
        let kept_out = stand.held_out.as_ref().zip(trial.held_out.as_ref());
        let clearer = clears((&stand.train, &trial.train)) || kept_out.is_some_and(clears);
        stand.train = trial.train;
        stand.held_out = trial.held_out;
        if (clearer || stand.train.aside() > ASIDE) && !stand.misread {
            look_after(&bench, &mut stand, control)?;
        }
        if only.is_none() {
            prune::remove(&bench, &mut stand, control)?;
            if stand.named.is_empty() {
                // A name that turned out needless has led the re-tuning on: all is weighed anew.
                baseline = stand.clone();
                bench.clone_from(plain);
                weighed.clear();
            }
            plainer(&bench, &mut stand, control)?;
        }
    }
    Ok(Explanation {
        baseline,
        stand,
        weighed,
    })
}

/// Whether what `trial` brings is little more, or far less, than the effects named before would
/// bring if their laws were of somewhat other form.
fn formal(stand: &Stand, trial: &Trial) -> Result<bool, DiagnoseError> {
    let named = stand.specs();
    if named.is_empty() {
        return Ok(false);
    }
    let (before, after) = (
        law_form::gain(&stand.train, &named)?,
        law_form::gain(&trial.train, &named)?,
    );
    let own = 1.0 - (before - after).max(0.0) / trial.gain;
    log::debug!(
        "{}: kin of those named bring {before:.0} without it and {after:.0} with it, of {:.0}",
        trial.hypothesis.start.spec.id,
        trial.gain
    );
    let (gain, held_gain) = (own * trial.gain, own * trial.held_gain);
    let held = trial.held_out.is_some() && held_gain < HELD_GAIN;
    let outweighed = before > OUTWEIGHED * trial.gain;
    Ok(outweighed || by_chance(&trial.hypothesis, gain, held_gain) || held)
}
