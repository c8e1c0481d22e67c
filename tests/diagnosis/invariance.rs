//! The same recordings in other units, later, turned over, at half the rate: the same answer.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use impactscope::diagnose::{DiagnoseControl, DiagnoseOptions, Diagnosis, diagnose};
use impactscope::fit::Part;
use impactscope::model::Model;
use impactscope::model::preset::Preset;
use impactscope::recording::Recording;
use impactscope::trial::rescale::UnitFactors;
use impactscope::trial::{Case, Mix, Settings};

/// Readings as a file holds them: times \[s\], volts \[V\] and lengths \[m\].
#[derive(Clone)]
struct Readings {
    time: Vec<f64>,
    volts: Option<Vec<f64>>,
    xp: Vec<f64>,
    xc: Option<Vec<f64>>,
}

impl Readings {
    fn map(&self, times: impl Fn(f64) -> f64, lengths: impl Fn(f64) -> f64) -> Self {
        let of = |x: &Vec<f64>| x.iter().map(|x| lengths(*x)).collect();
        Self {
            time: self.time.iter().map(|t| times(*t)).collect(),
            volts: self.volts.clone(),
            xp: of(&self.xp),
            xc: self.xc.as_ref().map(of),
        }
    }

    fn part(&self, k: usize) -> Part {
        let (time, volts) = (self.time.clone(), self.volts.clone());
        let (xp, xc) = (self.xp.clone(), self.xc.clone());
        let recording = Recording::new(format!("run {k}"), time, volts, xp, xc);
        Part::whole(Arc::new(recording.expect("a recording")))
    }
}

/// The answer to all but the last of `readings`, judged on the last.
fn answer(model: &Model, readings: &[Readings]) -> Diagnosis {
    let parts: Vec<Part> = readings
        .iter()
        .enumerate()
        .map(|(k, r)| r.part(k))
        .collect();
    let (held_out, train) = parts.split_last().expect("a recording");
    let (cancel, quiet) = (AtomicBool::new(false), |_: &_| {});
    let control = DiagnoseControl {
        cancel: &cancel,
        progress: &quiet,
    };
    let held_out = std::slice::from_ref(held_out);
    diagnose(
        model,
        train,
        held_out,
        &DiagnoseOptions::default(),
        &control,
    )
    .expect("an answer")
}

/// Whether `other` says what `first` says, its lengths `factor` times as long; `within` is the
/// relative tolerance of the rms.
fn assert_same(what: &str, first: &Diagnosis, other: &Diagnosis, (factor, within): (f64, f64)) {
    assert_eq!(other.verdict, first.verdict, "{what}: {:?}", other.remarks);
    let names = |d: &Diagnosis| d.named.iter().map(|n| n.id.clone()).collect::<Vec<_>>();
    assert_eq!(names(other), names(first), "{what}");
    for (a, b) in first.named.iter().zip(&other.named) {
        let off = (a.probability - b.probability).abs();
        assert!(
            off < 0.01,
            "{what}: {} and {}",
            a.probability,
            b.probability
        );
    }
    for (a, b) in [
        (first.held_out.before.rms, other.held_out.before.rms),
        (first.held_out.after.rms, other.held_out.after.rms),
    ] {
        let ratio = b / (factor * a);
        assert!(
            (ratio - 1.0).abs() < within,
            "{what}: rms {a:e}, then {b:e}"
        );
    }
}

/// A mass on a spring that is let go at `start` \[m\], with a drag that grows with the square of the
/// speed, by a solver of this test's own, 20 um of noise.
fn swings(start: f64, seed: u64) -> Readings {
    let (omega, zeta, drag): (f64, f64, f64) = (8.6, 0.002, 0.6);
    let acceleration =
        |x: f64, v: f64| -omega * omega * x - 2.0 * zeta * omega * v - drag * v * v.abs();
    let (step, every, count) = (5e-4, 20, 2000);
    let (mut x, mut v) = (start, 0.0);
    let mut noise = seed;
    let mut normal = || {
        // Twelve even numbers make a normal one.
        let sum: f64 = (0..12)
            .map(|_| {
                noise = noise
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (noise >> 11) as f64 / (1u64 << 53) as f64
            })
            .sum();
        sum - 6.0
    };
    let (mut time, mut xp) = (Vec::new(), Vec::new());
    for k in 0..count * every {
        if k % every == 0 {
            time.push(f64::from(k) * step);
            xp.push(x + 20e-6 * normal());
        }
        // Runge and Kutta's classical step.
        let (k1x, k1v) = (v, acceleration(x, v));
        let (k2x, k2v) = half(step, (x, v), (k1x, k1v), &acceleration);
        let (k3x, k3v) = half(step, (x, v), (k2x, k2v), &acceleration);
        let (k4x, k4v) = half(2.0 * step, (x, v), (k3x, k3v), &acceleration);
        x += step / 6.0 * (k1x + 2.0 * k2x + 2.0 * k3x + k4x);
        v += step / 6.0 * (k1v + 2.0 * k2v + 2.0 * k3v + k4v);
    }
    Readings {
        time,
        volts: None,
        xp,
        xc: None,
    }
}

/// The rates of change half a `step` on.
fn half(
    step: f64,
    (x, v): (f64, f64),
    (dx, dv): (f64, f64),
    acceleration: &impl Fn(f64, f64) -> f64,
) -> (f64, f64) {
    let (x, v) = (x + 0.5 * step * dx, v + 0.5 * step * dv);
    (v, acceleration(x, v))
}

#[test]
fn a_spring_with_drag_in_other_units_later_turned_over_and_at_half_the_rate() {
    let preset = Preset::embedded("oscillator").unwrap();
    let runs: Vec<Readings> = [(0.12, 1), (0.08, 2), (0.1, 3)]
        .map(|(a, s)| swings(a, s))
        .to_vec();
    let first = answer(&preset.model, &runs);
    let names: Vec<&str> = first.named.iter().map(|n| n.id.as_str()).collect();
    assert_eq!(names, ["quadratic_drag"], "{:?}", first.remarks);
    let all = |f: &dyn Fn(&Readings) -> Readings| runs.iter().map(f).collect::<Vec<_>>();

    let later = answer(&preset.model, &all(&|r| r.map(|t| t + 86_400.0, |x| x)));
    assert_same("a day later", &first, &later, (1.0, 0.01));

    let over = answer(&preset.model, &all(&|r| r.map(|t| t, |x| -x)));
    assert_same("turned over", &first, &over, (1.0, 0.01));

    let factors = UnitFactors {
        length: 1e-5,
        time: 1e-3,
        mass: 1e-9,
    };
    let small = factors.preset(&preset).unwrap();
    let tiny = all(&|r| r.map(|t| factors.time * t, |x| factors.length * x));
    let tiny = answer(&small.model, &tiny);
    assert_same("in other units", &first, &tiny, (factors.length, 0.01));

    let halved = all(&|r| Readings {
        time: r.time.iter().step_by(2).copied().collect(),
        xp: r.xp.iter().step_by(2).copied().collect(),
        ..r.clone()
    });
    // Half the samples have other noise: their rms is known to some 3 %.
    assert_same(
        "at half the rate",
        &first,
        &answer(&preset.model, &halved),
        (1.0, 0.1),
    );
}

#[test]
fn a_tapping_device_in_other_units_and_later() {
    let settings = Settings {
        rate: 25e3,
        mix: Mix::Effect("cubic_stiffness".to_owned()),
        ..Settings::default()
    };
    let is_large = |case: &Case| {
        let mut sizes = case
            .truth()
            .effects
            .iter()
            .map(|e| e.times_smallest_visible);
        sizes.all(|size| size > 10.0)
    };
    let drawn = (50..70).map(|seed| Case::draw(seed, &settings).expect("a trial"));
    let case = drawn.into_iter().find(is_large).expect("a large one");
    let of = |r: &Arc<Recording>| Readings {
        time: r.time.to_vec(),
        volts: r.voltage.as_ref().map(|v| v.to_vec()),
        xp: r.proof_mass.to_vec(),
        xc: r.cantilever.as_ref().map(|x| x.to_vec()),
    };
    let recordings = case.recordings();
    let mut runs: Vec<Readings> = [1, 2, 3].map(|k| of(&recordings.train[k])).to_vec();
    runs.push(of(&recordings.held_out[2]));
    let preset = Preset::embedded("paper").unwrap();
    let first = answer(&preset.model, &runs);
    let all = |f: &dyn Fn(&Readings) -> Readings| runs.iter().map(f).collect::<Vec<_>>();

    let later = answer(&preset.model, &all(&|r| r.map(|t| t + 1000.0, |x| x)));
    assert_same("later", &first, &later, (1.0, 0.01));

    let factors = UnitFactors {
        length: 4.0,
        time: 0.5,
        mass: 3.0,
    };
    let large = factors.preset(&preset).unwrap();
    let large_runs = all(&|r| r.map(|t| factors.time * t, |x| factors.length * x));
    let other = answer(&large.model, &large_runs);
    assert_same("in other units", &first, &other, (factors.length, 0.01));
}
