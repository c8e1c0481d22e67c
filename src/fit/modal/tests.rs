//! Sweeps made here by Runge-Kutta steps between the turns of the voltage, without the simulator: what
//! is found must be the device that made them.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::*;
use crate::fit::solve::levenberg_marquardt::Control;
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::piezo::Piezo;
use crate::model::sensor::gaussian;
use crate::model::structure::Mode;
use crate::recording::Recording;

/// Steps between two samples. At 40 kHz they move the frequency of a mode at 6.4 kHz by 4e-7 of itself,
/// less than half its standard error.
const SUBSTEPS: usize = 12;
/// Noise of both readings \[m\].
const NOISE: f64 = 20e-9;

/// A sweep at constant rate.
#[derive(Clone, Copy)]
struct Sweep {
    from: f64,
    to: f64,
    duration: f64,
    amplitude: f64,
    rate: f64,
}

const SWEEP: Sweep = Sweep {
    from: 100.0,
    to: 9000.0,
    duration: 0.6,
    amplitude: 1.0,
    rate: 40e3,
};

impl Sweep {
    fn slope(&self) -> f64 {
        (self.to - self.from) / self.duration
    }

    fn voltage(&self, t: f64) -> f64 {
        self.amplitude * (TAU * (self.from * t + 0.5 * self.slope() * t * t)).sin()
    }

    /// Times at which the voltage turns: odd quarters of the phase.
    fn turns(&self) -> Vec<f64> {
        let at = |k: usize| {
            let cycles = 0.5 * k as f64 + 0.25;
            let root = (self.from * self.from + 2.0 * self.slope() * cycles).sqrt();
            (root - self.from) / self.slope()
        };
        (0..).map(at).take_while(|t| *t < self.duration).collect()
    }
}

/// `q'' + 2 zeta w q' + w^2 q = phi_drive eta gc` for each mode, by steps that end at each turn.
fn readings(modes: &[Mode], eta: f64, piezo: &Piezo, sweep: &Sweep) -> [Vec<f64>; 3] {
    let turns = sweep.turns();
    let samples = (sweep.duration * sweep.rate) as usize;
    let mut state = vec![[0.0; 2]; modes.len()];
    let (mut turn, mut time) = (0, 0.0);
    let mut out = [Vec::new(), Vec::new(), Vec::new()];
    for i in 0..samples {
        let end = i as f64 / sweep.rate;
        while time < end {
            let next = turns.get(turn).copied().unwrap_or(f64::INFINITY);
            let to = end.min(next);
            let rising = turn % 2 == 0;
            let h = (to - time) / SUBSTEPS as f64;
            for _ in 0..SUBSTEPS {
                for (own, mode) in state.iter_mut().zip(modes) {
                    *own = runge_kutta(*own, time, h, |t, [q, v]| {
                        let w = TAU * mode.frequency;
                        let law = if rising { piezo.rising } else { piezo.falling };
                        let volts = sweep.voltage(t);
                        let gc = law.iter().rev().fold(0.0, |sum, c| sum * volts + c);
                        let force = mode.phi_drive * eta * gc;
                        [v, force - 2.0 * mode.zeta * w * v - w * w * q]
                    });
                }
                time += h;
            }
            time = to;
            turn += usize::from(to == next);
        }
        let sum = |shape: fn(&Mode) -> f64| -> f64 {
            modes.iter().zip(&state).map(|(m, q)| shape(m) * q[0]).sum()
        };
        out[0].push(sweep.voltage(end));
        out[1].push(sum(|m| m.phi_p));
        out[2].push(sum(|m| m.phi_c));
    }
    out
}

fn runge_kutta(y: [f64; 2], t: f64, h: f64, f: impl Fn(f64, [f64; 2]) -> [f64; 2]) -> [f64; 2] {
    let along = |k: [f64; 2], h: f64| [y[0] + h * k[0], y[1] + h * k[1]];
    let a = f(t, y);
    let b = f(t + 0.5 * h, along(a, 0.5 * h));
    let c = f(t + 0.5 * h, along(b, 0.5 * h));
    let d = f(t + h, along(c, h));
    [0, 1].map(|i: usize| y[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]))
}

/// A recording of it, with noise on both readings.
fn recording(
    modes: &[Mode],
    model: &Model,
    sweep: &Sweep,
    with_cantilever: bool,
) -> Arc<Recording> {
    let eta = model.parameters[ParameterId::Eta];
    let [volts, xp, xc] = readings(modes, eta, &model.piezo.unwrap(), sweep);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut noisy = |x: Vec<f64>| -> Vec<f64> {
        x.into_iter()
            .map(|x| x + NOISE * gaussian(&mut rng))
            .collect()
    };
    let time = (0..volts.len()).map(|i| i as f64 / sweep.rate).collect();
    let (xp, xc) = (noisy(xp), with_cantilever.then(|| noisy(xc)));
    Arc::new(Recording::new("sweep.csv", time, Some(volts), xp, xc).unwrap())
}

fn mode(frequency: f64, zeta: f64, phi_c: f64, phi_p: f64) -> Mode {
    Mode {
        frequency,
        zeta,
        phi_c,
        phi_p,
        phi_drive: phi_c,
    }
}

/// The paper's device far above its ground: the film is another step's.
fn device() -> Model {
    Model {
        has_ground: false,
        ..Model::default()
    }
}

fn identified(model: &Model, recording: Arc<Recording>) -> Result<ModalFit, ModalError> {
    let cancel = AtomicBool::new(false);
    let control = Control {
        cancel: &cancel,
        progress: &|_| {},
    };
    identify(model, &[recording], &ModalOptions::default(), &control)
}

/// Frequencies within 0.1 %, damping within 2 %, shapes within 1 %, and each within 5 of its own
/// standard errors: errors that are too small would mislead.
fn assert_found(fit: &ModalFit, modes: &[Mode]) {
    let found: Vec<_> = fit.identified().collect();
    assert_eq!(found.len(), modes.len(), "{:#?}", fit.modes);
    for (own, truth) in found.iter().zip(modes) {
        let shape = own.shape.expect("a shape");
        let values = [
            ("frequency", Some(own.frequency), truth.frequency, 1e-3),
            ("zeta", Some(own.zeta), truth.zeta, 0.02),
            ("phi_c", shape.phi_c, truth.phi_c, 0.01),
            ("phi_p", Some(shape.phi_p), truth.phi_p, 0.01),
        ];
        for (name, estimate, truth, tolerance) in values {
            let Some(estimate) = estimate else { continue };
            let off = (estimate.value - truth).abs();
            assert!(
                off < tolerance * truth.abs() && off < 5.0 * estimate.std_error,
                "{name} of the mode at {} Hz: {} +- {} for {truth}",
                own.frequency.value,
                estimate.value,
                estimate.std_error,
            );
        }
    }
}

#[test]
fn the_papers_device_is_found_through_its_hysteresis() {
    let model = device();
    let modes = model.structure().modes;
    let fit = identified(&model, recording(&modes, &model, &SWEEP, true)).unwrap();
    assert_found(&fit, &modes);
    assert!(fit.follows_sweep());
    // What the modes leave is the noise that was put in.
    for misfit in fit.misfit {
        assert!((misfit.unwrap() / NOISE - 1.0).abs() < 0.03, "{misfit:?}");
    }
    // The device takes them, and keeps none of its own beside them.
    let mut changed = device();
    changed.parameters.set(ParameterId::F1, 500.0);
    fit.apply(&mut changed);
    let now = changed.structure().modes;
    assert_eq!(now.len(), modes.len());
    assert!((now[0].frequency / modes[0].frequency - 1.0).abs() < 1e-3);
}

#[test]
fn close_modes_are_told_apart_and_a_heavily_damped_one_is_found() {
    let model = Model {
        piezo: Some(Piezo::without_hysteresis([0.0, -1.0, 0.0, 0.0])),
        ..device()
    };
    let close = [
        mode(1000.0, 0.010, 1.5e4, 5.0e4),
        mode(1030.0, 0.012, 2.5e4, -2.0e4),
    ];
    let slow = Sweep {
        from: 400.0,
        to: 2500.0,
        rate: 20e3,
        ..SWEEP
    };
    let fit = identified(&model, recording(&close, &model, &slow, true)).unwrap();
    assert_found(&fit, &close);
    let damped = [
        mode(500.0, 0.1, 1.5e4, 5.0e4),
        mode(2400.0, 0.1, 6.0e4, -1.2e4),
    ];
    let fit = identified(&model, recording(&damped, &model, &SWEEP, true)).unwrap();
    assert_found(&fit, &damped);
}

/// Without xc only the product of the shapes is measured: said, and not made up.
#[test]
fn one_point_tells_the_product_of_the_shapes() {
    let model = device();
    let modes = model.structure().modes;
    let fit = identified(&model, recording(&modes, &model, &SWEEP, false)).unwrap();
    for (own, truth) in fit.identified().zip(&modes) {
        let shape = own.shape.unwrap();
        assert!(shape.phi_c.is_none());
        let product = shape.phi_p.value * shape.phi_drive;
        assert!((product / (truth.phi_p * truth.phi_drive) - 1.0).abs() < 0.01);
    }
    assert_eq!(fit.identified().count(), 2);
    assert!(
        fit.remarks
            .iter()
            .any(|r| r.starts_with("xc was not recorded"))
    );
}

/// Readings a thousand times larger and a hundred times slower give the same damping and ratios.
#[test]
fn scales_of_length_and_time_change_nothing() {
    let model = device();
    let modes = model.structure().modes;
    let first = recording(&modes, &model, &SWEEP, true);
    let scaled = |x: &[f64], by: f64| -> Vec<f64> { x.iter().map(|x| x * by).collect() };
    let second = Recording::new(
        "slow.csv",
        scaled(&first.time, 100.0),
        first.voltage.clone(),
        scaled(&first.proof_mass, 1e3),
        first.cantilever.as_ref().map(|x| scaled(x, 1e3)),
    );
    let fits = [first, Arc::new(second.unwrap())].map(|r| identified(&model, r).unwrap());
    let [a, b] = &fits;
    assert_eq!(a.identified().count(), b.identified().count());
    for (a, b) in a.identified().zip(b.identified()) {
        assert!((a.frequency.value / b.frequency.value / 100.0 - 1.0).abs() < 1e-6);
        assert!((a.zeta.value / b.zeta.value - 1.0).abs() < 1e-4);
        let ratio = |m: &IdentifiedMode| m.ratio.unwrap().value;
        assert!((ratio(a) / ratio(b) - 1.0).abs() < 1e-4);
    }
}

#[test]
fn what_is_no_sweep_is_refused() {
    let model = device();
    let modes = model.structure().modes;
    let sine = Sweep {
        to: SWEEP.from + 1e-9,
        duration: 0.2,
        ..SWEEP
    };
    let error = identified(&model, recording(&modes, &model, &sine, true)).unwrap_err();
    assert!(matches!(error, ModalError::NoSweep { .. }), "{error}");
    let mute = recording(&modes, &model, &SWEEP, true);
    let mut mute = mute.as_ref().clone();
    mute.voltage = None;
    let error = identified(&model, Arc::new(mute)).unwrap_err();
    assert!(matches!(error, ModalError::NoVoltage { .. }), "{error}");
}
