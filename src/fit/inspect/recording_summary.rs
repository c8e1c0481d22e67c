//! Summary of each recording without a model of the motion: noise, ground level and its changes,
//! lag of the readings.

use std::borrow::Cow;

use super::channel_noise::noise_of;
use crate::fit::options::Part;
use crate::fit::segment::event_sequence::Timeline;
use crate::fit::thresholds::{
    MIN_NOISE_SHARE, MIN_SHOWN_DRIFT_SHARE, MIN_STAYS, SAME_LEVEL_DISTANCE,
};
use crate::model::Model;
use crate::recording::events::turning_points::level_of_turns;
use crate::recording::events::{EventOptions, Events, Impact, find_events};
use crate::recording::features::Missing;
use crate::recording::lag::{before_lag, find_lag, noise_before_lag};
use crate::recording::level::estimate_contact_level;
use crate::recording::level_change::{LevelChange, LevelDrift, find_level_drift, find_level_step};
use crate::recording::noise::NoiseEstimate;
use crate::recording::{Channel, Recording, quantile_in_place};

/// Summary of one part.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSummary {
    /// Noise of the proof mass and of the cantilever \[m\].
    pub noise: (f64, Option<f64>),
    /// Contact level in the reading \[m\], or why there is none.
    pub level: Result<f64, String>,
    /// Change of that level during the recording, if any; `level` is the one before.
    pub change: Option<LevelChange>,
    /// Lag of the readings \[s\], 0 without one. Events are searched for in the readings with the
    /// lag removed.
    pub lag: f64,
}

impl RecordingSummary {
    /// Events at the ground in `recording`, whose noise is `noise` \[m\].
    pub fn timeline(&self, recording: &Recording, noise: f64) -> Timeline {
        match self.level {
            Ok(level) => {
                let xp = self.as_moved(recording);
                let noise = self.noise_of(noise, recording);
                Timeline::new(&recording.time, &xp, level, noise)
            }
            Err(_) => Timeline::default(),
        }
    }

    /// Contacts and impacts in `recording`; empty if the ground level is unknown.
    pub fn events(&self, recording: &Recording) -> Events {
        let Ok(contact_level) = self.level else {
            return Events::default();
        };
        let xp = self.as_moved(recording);
        let noise = self.noise_of(self.noise.0, recording);
        let options = EventOptions::for_travel(contact_level, noise, &xp);
        find_events(recording.axis(), &xp, &options)
    }

    /// Reading of the proof mass with the lag and changes of the ground's level removed \[m\].
    pub fn as_moved<'a>(&self, recording: &'a Recording) -> Cow<'a, [f64]> {
        as_moved(recording, self.change, self.lag)
    }

    /// Noise of that, if the noise of the readings is `sigma` \[m\].
    pub fn noise_of(&self, sigma: f64, recording: &Recording) -> f64 {
        noise_before_lag(sigma, recording.interval(), self.lag)
    }
}

/// Lag that the readings of `parts` show \[s\]; `summaries` were made without one.
pub fn lag_of(parts: &[Part], summaries: &[RecordingSummary]) -> Option<f64> {
    let both = || parts.iter().zip(summaries);
    let readings: Vec<_> = both().map(|(p, f)| f.as_moved(&p.recording)).collect();
    let all: Vec<_> = both()
        .zip(&readings)
        .map(|((p, f), xp)| (&*p.recording, &**xp, f.noise.0))
        .collect();
    find_lag(&all)
}

/// Summarizes parts without a model of the motion.
pub fn summarize(model: &Model, parts: &[Part]) -> Vec<RecordingSummary> {
    summarize_with_lag(model, parts, 0.0)
}

/// The same for readings that lag by `lag` \[s\].
pub fn summarize_with_lag(model: &Model, parts: &[Part], lag: f64) -> Vec<RecordingSummary> {
    let mut summaries: Vec<RecordingSummary> = parts
        .iter()
        .map(|p| summarize_part(model, p, lag))
        .collect();
    if !model.has_ground {
        return summaries;
    }
    let mut known: Vec<f64> = summaries
        .iter()
        .filter_map(|f| f.level.clone().ok())
        .collect();
    let common = quantile_in_place(&mut known, 0.5);
    let mut drifts: Vec<LevelDrift> = summaries.iter().filter_map(|f| f.change?.drift()).collect();
    drifts.sort_by(|a, b| a.shown().0.total_cmp(&b.shown().0));
    for (summary, part) in summaries.iter_mut().zip(parts) {
        if summary.level.is_ok() {
            continue;
        }
        let r = &part.recording;
        // A zero that drifts in one recording may drift in the same way in another that is too
        // short to show it.
        let (begin, end) = r.span();
        let lasts = |drift: &&LevelDrift| {
            drift.begin() <= begin
                && drift.shown().1 - begin >= MIN_SHOWN_DRIFT_SHARE * (end - begin)
        };
        let alike = drifts.iter().filter(lasts);
        let changes: Vec<Option<LevelChange>> = alike
            .map(|drift| Some(LevelChange::Drift(*drift)))
            .collect();
        let estimate = noise_of(r, Channel::ProofMass).ok();
        let rest = |change: &Option<LevelChange>| {
            let level = level_in(r, estimate, *change, lag).ok()?;
            Some((level, *change))
        };
        let turns = |change: Option<LevelChange>| {
            // Levels of other recordings apply where the zero stays.
            let known = if change.is_none() { common } else { f64::NAN };
            let xp = as_moved(r, change, lag);
            let noise = summary.noise_of(summary.noise.0, r);
            let (level, count) = level_of_impacts(r, &xp, noise, known)?;
            Some((count, level, change))
        };
        let found = changes.iter().find_map(rest).or_else(|| {
            let all = changes.iter().copied().chain([None]);
            // `max_by_key` takes the last of equals, which assumes a constant zero.
            let most = all.filter_map(turns).max_by_key(|(count, ..)| *count);
            most.map(|(_, level, change)| (level, change))
        });
        if let Some((level, change)) = found {
            summary.level = Ok(level);
            summary.change = change;
        }
    }
    summaries
}

fn summarize_part(model: &Model, part: &Part, lag: f64) -> RecordingSummary {
    let r = &part.recording;
    let estimate = |channel: Channel| noise_of(r, channel).ok();
    let noise = |channel: Channel, estimate: Option<NoiseEstimate>| {
        // A part whose noise cannot be estimated is refused by the check.
        let sigma = estimate.map_or(0.0, |n| n.sigma);
        let values = r.channel(channel).unwrap_or_default();
        let mut finite: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
        let low = quantile_in_place(&mut finite, 0.01);
        let span = quantile_in_place(&mut finite, 0.99) - low;
        sigma.max(MIN_NOISE_SHARE * span).max(f64::MIN_POSITIVE)
    };
    let of_xp = estimate(Channel::ProofMass);
    let (level, change) = if model.has_ground {
        ground_of(r, of_xp, lag)
    } else {
        (Err("the device has no ground".to_owned()), None)
    };
    let xc = model.has_cantilever && r.cantilever.is_some();
    log::debug!("{}: ground at {level:?}, {change:?}", r.name);
    RecordingSummary {
        noise: (
            noise(Channel::ProofMass, of_xp),
            xc.then(|| noise(Channel::Cantilever, estimate(Channel::Cantilever))),
        ),
        level,
        change,
        lag,
    }
}

/// Contact level and how it changes. The end of a drift may pass for a steady level.
fn ground_of(
    recording: &Recording,
    noise: Option<NoiseEstimate>,
    lag: f64,
) -> (Result<f64, String>, Option<LevelChange>) {
    let step = find_level_step(recording, noise).map(LevelChange::Step);
    let drift = || find_level_drift(recording, noise).map(LevelChange::Drift);
    let change = step.or_else(drift);
    let level = level_in(recording, noise, change, lag);
    (level.map_err(|missing| missing.to_string()), change)
}

/// Reading of the proof mass with a change of the ground's level and a lag removed \[m\].
fn as_moved(recording: &Recording, change: Option<LevelChange>, lag: f64) -> Cow<'_, [f64]> {
    let (time, xp) = (&recording.time, &recording.proof_mass);
    let moved = if lag > 0.0 {
        Cow::Owned(before_lag(time, xp, lag))
    } else {
        Cow::Borrowed(&xp[..])
    };
    match change {
        Some(change) => Cow::Owned(change.taken_out(time, &moved)),
        None => moved,
    }
}

/// Contact level at the beginning of a recording in which it changes so.
fn level_in(
    recording: &Recording,
    noise: Option<NoiseEstimate>,
    change: Option<LevelChange>,
    lag: f64,
) -> Result<f64, Missing> {
    let xp = as_moved(recording, change, lag);
    let noise = noise.map(|n| NoiseEstimate {
        sigma: noise_before_lag(n.sigma, recording.interval(), lag),
        ..n
    });
    estimate_contact_level(recording.axis(), recording.voltage.as_deref(), &xp, noise)
}

/// Level of a ground on which the mass never rests for long, with the number of sudden turns there.
/// If the mass stays lowest for two samples repeatedly, that is the ground. Otherwise the lowest
/// sample may be above the ground, and a level known from another recording is used if it is near
/// and has as many turns; else the height at which the parabolas before and after the turns meet.
fn level_of_impacts(
    recording: &Recording,
    xp: &[f64],
    noise: f64,
    common: f64,
) -> Option<(f64, usize)> {
    let mut finite: Vec<f64> = xp.iter().copied().filter(|x| x.is_finite()).collect();
    let bottom = quantile_in_place(&mut finite, 0.0);
    let at = |contact_level: f64| EventOptions::for_travel(contact_level, noise, xp);
    let turns = |level: f64| -> usize {
        let impacts = find_events(recording.axis(), xp, &at(level)).impacts;
        let sudden = |i: &&Impact| i.v_after - i.v_before > 2.0 * i.v_error;
        impacts.iter().filter(sudden).count()
    };
    // Twice the distance by which noise puts the lowest of many readings below the ground.
    let low = |x: &f64| *x < bottom + 2.0 * at(bottom).tolerance();
    let runs = xp.chunk_by(|a, b| low(a) && low(b));
    let stays: Vec<&[f64]> = runs.filter(|run| run.len() > 1).collect();
    let stayed = stays.len() >= MIN_STAYS;
    let own = if stayed {
        quantile_in_place(&mut stays.concat(), 0.5)
    } else {
        bottom
    };
    let own = (own, turns(own));
    let near = !stayed && (bottom - common).abs() < SAME_LEVEL_DISTANCE;
    let known = near.then(|| (common, turns(common)));
    let known = known.filter(|known| known.1 >= own.1);
    // The lowest reading lies above a ground that the mass leaves within a sample, where the sides of
    // its turns meet.
    let met = || {
        let met = level_of_turns(recording.axis(), xp, noise).filter(|_| !stayed)?;
        (2 * met.turns >= own.1).then_some((met.level, met.turns))
    };
    let (level, count) = known.or_else(met).unwrap_or(own);
    (count >= 2).then_some((level, count))
}

#[cfg(test)]
mod tests {
    use super::super::preconditions::check_summaries;
    use super::super::recording_summary::*;
    use crate::fit::FitOptions;
    use crate::fit::tests::{made, paper, part};

    #[test]
    fn a_drift_is_transferred_to_a_recording_too_short_to_show_it() {
        let drifting = |drive: &str, seconds: f64, seed: u64| {
            let mut recording = made(&paper(), drive, seconds, seed);
            let times = recording.time.iter();
            for (x, t) in recording.proof_mass.iter_mut().zip(times) {
                *x += 5e-6 * (1.0 - (-t / 0.08).exp());
            }
            part(recording)
        };
        let parts = [
            drifting("square:15Hz:8V", 0.2, 1),
            drifting("square:300Hz:6V", 0.05, 2),
        ];
        let dp = paper().parameters[crate::model::parameter::ParameterId::Dp];
        for (found, part) in summarize(&paper(), &parts).iter().zip(&parts) {
            let level = found.level.clone().expect("a level");
            assert!((level + dp).abs() < 0.4e-6, "{level}");
            let moved = found.change.expect("a drift");
            let end = part.recording.span().1;
            let rise = -moved.taken_out(&[end], &[0.0])[0];
            let whole = 5e-6 * (1.0 - (-end / 0.08).exp());
            assert!((rise - whole).abs() < 0.2e-6, "{rise}");
        }
    }

    #[test]
    fn a_ground_on_which_nothing_rests_is_found_from_turning_points() {
        use crate::model::drive::Waveform;
        use crate::model::preset::Preset;
        use crate::model::sensor::Sensor;
        use crate::sim::{Options, simulate};

        // A ball filmed with 200 frames a second, in two recordings that end before it rests. Their
        // zeros differ by a millimetre.
        let filmed = |alpha: f64, zero: f64, seed: u64| {
            let mut model = Preset::embedded("bouncing-ball").unwrap().model;
            model.set("alpha", alpha).unwrap();
            let options = Options {
                rate: 200.0,
                ..Options::default()
            };
            let trace = simulate(&model, &Waveform::Rest, 0.99, &options).unwrap();
            let time: Vec<f64> = (0..trace.len()).map(|i| trace.time(i)).collect();
            let mut xp: Vec<f64> = trace.proof_mass.iter().map(|x| x + zero).collect();
            let sensor = Sensor {
                noise: 3e-5,
                ..Sensor::default()
            };
            sensor.add_noise(&mut xp, seed);
            part(Recording::new("ball", time, None, xp, None).unwrap())
        };
        let model = Preset::embedded("bouncing-ball").unwrap().model;
        let parts = [filmed(0.7, 0.0, 1), filmed(0.75, 1e-3, 2)];
        for (found, (part, zero)) in summarize(&model, &parts)
            .iter()
            .zip(parts.iter().zip([0.0, 1e-3]))
        {
            let level = found.level.clone().expect("a level");
            assert!((level + 0.05 - zero).abs() < 5e-4, "{level}");
            // The bounces at 0.25, 0.59 and 0.84 s, or a little later.
            let impacts = found.events(&part.recording).impacts;
            assert!(impacts.len() >= 3, "{impacts:?}");
            for impact in &impacts {
                let ratio = -impact.v_after / impact.v_before;
                assert!((0.67..0.78).contains(&ratio), "{impact:?}");
            }
        }
        // They may be of one device.
        check_summaries(
            &model,
            &parts,
            &summarize(&model, &parts),
            &FitOptions::for_model(&model),
        )
        .unwrap();
    }

    #[test]
    fn repeated_lowest_stays_are_the_ground_whatever_the_zeros() {
        let parts = [
            part(made(&paper(), "square:15Hz:8V", 0.2, 1)),
            part({
                let mut recording = made(&paper(), "square:300Hz:6V", 0.05, 2);
                for x in &mut recording.proof_mass {
                    *x += 1.5e-6;
                }
                recording
            }),
        ];
        let dp = paper().parameters[crate::model::parameter::ParameterId::Dp];
        let found = summarize(&paper(), &parts);
        let alone = summarize(&paper(), &parts[1..]);
        for (found, zero) in [(&found[0], 0.0), (&found[1], 1.5e-6), (&alone[0], 1.5e-6)] {
            let level = found.level.clone().expect("a level");
            assert!((level + dp - zero).abs() < 0.15e-6, "{level}");
        }
    }
}
