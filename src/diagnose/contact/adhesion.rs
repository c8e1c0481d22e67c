//! Pull-off force against contact time: a law that saturates, against a straight line.

use std::collections::BTreeSet;

use super::event_readings::Ground;
use super::law_test::LawTest;
use super::robust_curve::{Curve, Reading, cost, curve, scatter};
use crate::diagnose::findings::{Evidence, LawProof};
use crate::diagnose::thresholds::{
    ADHESION_BEND_MIN_GAIN, ADHESION_LEFT_OUT_MIN_GAIN, ADHESION_MAX_TIME, ADHESION_MIN_GAIN,
    CONTACT_TRAIN_GAIN, MIN_EVENTS, PRESSED_MAX_Z, RELEASE_MAX_ERROR_RATIO, RELEASE_MIN_SAMPLES,
    RELEASE_MIN_STAY, SHORT_STAYS_MIN,
};
use crate::fit::contact_readings::Release;
use crate::model::effects::{ActiveEffect, ContactLaw, of_contact_law};
use crate::model::parameter::ParameterId;
use crate::recording::quantile_in_place;

/// (contact time, force, error) of the releases that are used, with those after `short` stays or
/// without. Where the drive jumps, the pull exceeds the adhesion in one step. After a short stay the
/// force is known so poorly that its error is not known either. A mass that is pressed onto the
/// ground was not pulled off it.
fn pulls(releases: &[Release], short: bool) -> Vec<Reading> {
    let known = releases
        .iter()
        .filter(|r| pulled(r) && (short || r.contact > RELEASE_MIN_STAY))
        .filter(|r| r.error.is_finite() && r.force > -PRESSED_MAX_Z * r.error);
    let mut errors: Vec<f64> = known.clone().map(|r| r.error).collect();
    let good = quantile_in_place(&mut errors, 0.1);
    known
        .filter(|r| r.error < RELEASE_MAX_ERROR_RATIO * good)
        .map(|r| (r.contact, r.force, r.error))
        .collect()
}

/// Whether it was a stay from which adhesion let go, and no step of the drive tore the mass off.
fn pulled(release: &Release) -> bool {
    release.samples > RELEASE_MIN_SAMPLES && release.jump <= release.error
}

/// The same after long stays only.
pub fn long_pulls(releases: &[Release]) -> Vec<Reading> {
    pulls(releases, false)
}

/// Whether several of the releases came after short stays, of more than one recording: a single one
/// may be misread throughout.
fn several_short([train, held]: [&[Release]; 2]) -> bool {
    let short = |r: &&Release| pulled(r) && r.contact <= RELEASE_MIN_STAY;
    let of = |side: &[Release]| -> Vec<usize> {
        side.iter().filter(short).map(|r| r.recording).collect()
    };
    let (train, held) = (of(train), of(held));
    let recordings: BTreeSet<(bool, usize)> = train
        .iter()
        .map(|k| (false, *k))
        .chain(held.iter().map(|k| (true, *k)))
        .collect();
    train.len() + held.len() >= SHORT_STAYS_MIN && recordings.len() > 1
}

/// The straight line of the baseline through `points`: `Ca0` and `Ca`.
pub fn line(points: &[Reading]) -> Curve {
    curve(points, &[2e-8, 1e-6], &|t, p| p[0] + p[1] * t)
}

/// A form in which adhesion may bend.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Form {
    /// Logarithmic share: 0 or 1.
    share: f64,
    /// Whether the bend is on top of a straight line.
    on_line: bool,
}

impl Form {
    /// Force after contact of `t` for `[Ca0, dF, tau]` and, on a line, `Ca`.
    fn at(self, t: f64, p: &[f64]) -> f64 {
        let over = t / p[2].abs().max(1e-7);
        let bend = if self.share == 0.0 {
            -(-over).exp_m1()
        } else {
            over.ln_1p()
        };
        p[0] + p[1] * bend + p.get(3).map_or(0.0, |slope| slope * t)
    }

    /// Fit to `points` from `values`.
    fn fit(self, points: &[Reading], values: &[f64]) -> Curve {
        curve(points, values, &|t, p| self.at(t, p))
    }
}

/// A bent law through some points.
struct Bend {
    curve: Curve,
    form: Form,
}

impl Bend {
    fn at(&self, t: f64) -> f64 {
        self.form.at(t, &self.curve.values)
    }
}

/// The best bent law through the points, `None` if none makes sense: one that rises, over a
/// time that is neither shorter than any contact nor longer than all of them by far. It is on
/// top of the `straight` line only where that suits the points better by far.
fn bend(points: &[Reading], straight: &Curve) -> Option<Bend> {
    let (start, slope) = (straight.values[0].max(1e-9), straight.values[1].max(1e-9));
    let mut best: Option<Bend> = None;
    for on_line in [false, true] {
        let least = best.as_ref().map_or(f64::INFINITY, |b| b.curve.cost);
        let asked = if on_line {
            least - ADHESION_BEND_MIN_GAIN
        } else {
            least
        };
        for share in [0.0, 1.0] {
            let form = Form { share, on_line };
            for tau in [3e-4, 1e-3, 4e-3, 15e-3] {
                let values = [start, 30e-9, tau, slope];
                let curve = form.fit(points, &values[..if on_line { 4 } else { 3 }]);
                let [_, growth, time, ..] = curve.values[..] else {
                    continue;
                };
                let climbs = curve.values.get(3).is_none_or(|slope| *slope > 0.0);
                let sound = growth > 0.0 && climbs && time.abs() < ADHESION_MAX_TIME;
                let better = best.as_ref().is_none_or(|b| curve.cost < b.curve.cost);
                if sound && better && curve.cost < asked {
                    best = Some(Bend { curve, form });
                }
            }
        }
    }
    best
}

/// Adhesion that saturates, against one that grows in proportion to contact time.
///
/// A few excitations have few contact times. Two of them lie on any straight line, and only together
/// with those of held-out recordings there is a bend. Held-out releases are scored by their
/// predictive likelihood: what the fitted ones leave open of the law is averaged over.
pub fn test(ground: &Ground) -> Option<LawTest> {
    let sides = [&ground.train.releases, &ground.held_out.releases];
    let short = several_short(sides.map(Vec::as_slice));
    let [train, held] = sides.map(|releases| pulls(releases, short));
    let spec = of_contact_law(ContactLaw::Adhesion)?;
    if train.len() < MIN_EVENTS {
        return None;
    }
    let all = [train.as_slice(), held.as_slice()].concat();
    let (straight, straight_all) = (line(&train), line(&all));
    let of_all = bend(&all, &straight_all)?;
    let scale = scatter(&all, of_all.curve.values.len(), &|t| of_all.at(t));
    // All forms of the bend are one hypothesis: the form that fits all releases is fitted to the
    // first ones.
    let same = of_all.form.fit(&train, &of_all.curve.values);
    let predicted = same.predictive_log_loss(&of_all.curve, scale);
    let of_train = bend(&train, &straight).unwrap_or_else(|| Bend {
        curve: same.clone(),
        form: of_all.form,
    });
    let mut held_gain = straight.predictive_log_loss(&straight_all, scale) - predicted;
    let gain = (straight.cost - of_train.curve.cost) / scale;
    let together = gain <= CONTACT_TRAIN_GAIN && held_gain > 0.0;
    if together {
        // A single recording whose releases were misread must not decide.
        let without = |k: usize| {
            let others = ground.held_out.releases.iter();
            let others: Vec<Release> = others.filter(|r| r.recording != k).copied().collect();
            let all = [train.as_slice(), pulls(&others, short).as_slice()].concat();
            let bent = of_all.form.fit(&all, &of_all.curve.values);
            straight.predictive_log_loss(&line(&all), scale)
                - same.predictive_log_loss(&bent, scale)
        };
        let recordings: BTreeSet<usize> = ground
            .held_out
            .releases
            .iter()
            .map(|r| r.recording)
            .collect();
        let least = recordings.into_iter().map(without);
        let least = least.fold(f64::INFINITY, f64::min);
        if least < ADHESION_LEFT_OUT_MIN_GAIN {
            held_gain = held_gain.min(least);
        }
    }
    let (best_bend, times) = if together {
        (of_all, &all)
    } else {
        (of_train, &train)
    };
    let after = cost(&held, &|t| best_bend.at(t));
    let root = scale.sqrt();
    let Bend { curve, form } = best_bend;
    let proof = if together {
        LawProof::WithHeldOut
    } else {
        LawProof::Alone
    };
    let line_share = if form.on_line { 1.0 } else { 0.0 };
    let mut sets = vec![(ParameterId::Ca0, curve.values[0].max(0.0))];
    sets.extend(curve.values.get(3).map(|slope| (ParameterId::Ca, *slope)));
    Some(LawTest {
        id: spec.id,
        gain,
        held_gain,
        min_predictive_gain: Some(ADHESION_MIN_GAIN),
        held_chi2: after / held.len().max(1) as f64,
        effect: ActiveEffect {
            spec,
            values: vec![
                curve.values[1],
                curve.values[2].abs(),
                form.share,
                line_share,
            ],
        },
        errors: vec![
            curve.errors[1] * root,
            curve.errors[2] * root,
            f64::INFINITY,
            f64::INFINITY,
        ],
        sets,
        evidence: Evidence::Releases {
            count: times.len(),
            from_s: times.iter().fold(f64::INFINITY, |a, p| a.min(p.0)),
            to_s: times.iter().fold(0.0f64, |a, p| a.max(p.0)),
            logarithmic: form.share > 0.0,
            proof,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::super::adhesion::*;
    use crate::fit::contact_readings::ContactReadings;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Standard error of the forces \[N\].
    const ERROR: f64 = 0.3e-9;

    /// Releases after contacts of about `times` \[s\], pulled off by `law`.
    fn releases(seed: u64, times: &[(f64, usize)], law: &dyn Fn(f64) -> f64) -> ContactReadings {
        let mut dice = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { (0..12).map(|_| dice.random_range(-0.5..0.5)).sum() };
        let mut out = ContactReadings::default();
        for (k, (time, count)) in times.iter().enumerate() {
            for i in 0..*count {
                let contact = time * (1.0 + 1e-3 * normal());
                out.releases.push(Release {
                    recording: k,
                    time: 0.1 * i as f64,
                    contact,
                    samples: contact * 5e4,
                    force: law(contact) + ERROR * normal(),
                    jump: 0.0,
                    error: ERROR,
                });
            }
        }
        out
    }

    /// The law through releases after contacts as short and long as those of a few excitations.
    fn tested(seed: u64, law: &dyn Fn(f64) -> f64) -> LawTest {
        let ground = Ground {
            train: releases(seed, &[(6.3e-3, 6), (78e-3, 2)], law),
            held_out: releases(seed + 1000, &[(22e-3, 3), (42e-3, 3)], law),
            mass: 3.5e-7,
            ..Ground::default()
        };
        test(&ground).expect("enough releases")
    }

    #[test]
    fn no_saturation_is_found_on_a_straight_line() {
        for seed in 0..40 {
            let test = tested(seed, &|t| 29e-9 + 1.4e-6 * t);
            let both = test.gain + test.held_gain;
            assert!(both < 10.0, "seed {seed}: {} {}", test.gain, test.held_gain);
        }
    }

    #[test]
    fn saturation_in_place_of_the_line_is_found_with_its_parameters() {
        let law = |t: f64| 30e-9 - 120e-9 * (-t / 20e-3).exp_m1();
        let test = tested(7, &law);
        assert!(test.gain + test.held_gain > 1000.0, "{test:?}");
        let [growth, tau, share, on_line] = test.effect.values[..] else {
            panic!("{test:?}");
        };
        assert!((share, on_line) == (0.0, 0.0), "{test:?}");
        assert!((growth - 120e-9).abs() < 3.0 * test.errors[0], "{test:?}");
        assert!((tau - 20e-3).abs() < 3.0 * test.errors[1], "{test:?}");
    }

    #[test]
    fn a_bend_on_top_of_the_line_is_found() {
        let law = |t: f64| 29e-9 + 1.25e-6 * t - 13e-9 * (-t / 4e-3).exp_m1();
        let test = tested(8, &law);
        assert!(
            test.gain + test.held_gain > ADHESION_MIN_GAIN && test.held_gain > 0.0,
            "{test:?}"
        );
        assert_eq!(test.effect.values[3], 1.0, "{test:?}");
        let slope = test.sets.iter().find(|s| s.0 == ParameterId::Ca);
        let slope = slope.expect("the line goes on").1;
        assert!((slope - 1.25e-6).abs() < 0.1e-6, "{slope}");
    }

    #[test]
    fn one_held_out_recording_does_not_prove_a_bend() {
        let law = |t: f64| 29e-9 + 1.4e-6 * t;
        let mut held_out = releases(11, &[(22e-3, 3), (42e-3, 3), (2e-3, 3)], &law);
        // Hops that were taken for contacts of some milliseconds.
        for r in held_out.releases.iter_mut().filter(|r| r.recording == 2) {
            r.force = 2e-9;
        }
        let mut ground = Ground {
            train: releases(10, &[(6.3e-3, 6), (78e-3, 2)], &law),
            held_out,
            mass: 3.5e-7,
            ..Ground::default()
        };
        let both = |ground: &Ground| test(ground).map_or(0.0, |t| t.gain + t.held_gain);
        assert!(both(&ground) < ADHESION_MIN_GAIN, "{}", both(&ground));
        // Two that agree do.
        let others = ground.held_out.releases.clone().into_iter();
        let others = others.filter(|r| r.recording == 2);
        let again = others.map(|r| Release { recording: 3, ..r });
        ground.held_out.releases.extend(again);
        assert!(both(&ground) > ADHESION_MIN_GAIN, "{}", both(&ground));
    }

    #[test]
    fn several_short_stays_count_if_they_are_longer_than_a_hop() {
        let law = |t: f64| 29e-9 + 1.4e-6 * t;
        let short = |samples: f64, sides: [usize; 2]| {
            let stays = |count| releases(12, &[(6e-3, 6), (samples / 5e4, count)], &law).releases;
            let [train, held] = sides.map(stays);
            several_short([&train, &held])
        };
        assert!(!short(8.0, [1, 1]));
        assert!(short(8.0, [2, 1]));
        assert!(!short(8.0, [SHORT_STAYS_MIN, 0]), "one recording");
        assert!(!short(4.5, [8, 8]));
        // What is over before a millisecond shows in them alone.
        let ground = |stays: &[(f64, usize)]| Ground {
            train: releases(13, stays, &|t| law(t) - 60e-9 * (-t / 4e-4).exp_m1()),
            held_out: releases(14, stays, &|t| law(t) - 60e-9 * (-t / 4e-4).exp_m1()),
            mass: 3.5e-7,
            ..Ground::default()
        };
        let bends = |stays: &[(f64, usize)]| {
            let test = test(&ground(stays));
            test.is_some_and(|t| t.gain > CONTACT_TRAIN_GAIN && t.held_gain > ADHESION_MIN_GAIN)
        };
        assert!(!bends(&[(6e-3, 6), (40e-3, 4)]));
        assert!(bends(&[(6e-3, 6), (40e-3, 4), (2e-4, 4)]));
    }

    #[test]
    fn releases_at_jumps_of_the_drive_are_not_used() {
        let mut readings = releases(9, &[(6e-3, 6), (40e-3, 4)], &|t| 29e-9 + 1.4e-6 * t);
        assert_eq!(long_pulls(&readings.releases).len(), 10);
        for r in readings.releases.iter_mut().take(6) {
            r.jump = 300e-9;
        }
        assert_eq!(long_pulls(&readings.releases).len(), 4);
    }
}
