//! Tests of what is linearized against what is simulated.

use crate::fit::inspect::recording_summary::summarize;
use crate::fit::options::FitOptions;
use crate::fit::problem::linearize::*;
use crate::fit::problem::parameter_space::Space;
use crate::fit::problem::prepare::{Prepared, prepare};
use crate::fit::residual::coloured_noise::Colour;
use crate::fit::solve::point::settle;
use crate::fit::tests::{made, paper, part};

const LOSS: Huber = Huber(6.0);

/// A noisy flight with both points, and the unknowns of the device that made it.
fn flight() -> (Prepared, Vec<f64>) {
    let model = paper();
    let parts = [part(made(&model, "sine:50Hz:1V", 0.04, 1))];
    let options = FitOptions::for_model(&model);
    let space = Space::new(&model, &options.free).unwrap();
    let summaries = summarize(&model, &parts);
    let mut prepared = prepare(&model, &space, &parts, &summaries, &options).unwrap();
    prepared.problem.data[0].sigmas.colour = Colour::with_memory(0.4, 0.9);
    let mut x = space.coordinates(&model);
    x.extend_from_slice(&prepared.nuisances);
    (prepared, x)
}

#[test]
fn columns_of_offsets_and_scales_match_changed_readings() {
    let (prepared, x) = flight();
    let problem = &prepared.problem;
    let used = vec![true; prepared.segments.len()];
    let point = settle(problem, &x, &prepared.segments, &used, LOSS, 3).unwrap();
    let all = problem
        .jacobians(&x, &point.segments, &used, Huber(1e9))
        .unwrap();
    let simulator = problem.simulator(&x).unwrap();
    let first = problem.space.len();
    let mut seen = 0;
    for (segment, jacobian) in point.segments.iter().zip(all) {
        let jacobian = jacobian.unwrap();
        let residuals = |x: &[f64]| {
            let near = problem.nuisances_of(x, segment.recording);
            let mut stretcher = Stretcher::new(&simulator);
            stretcher.replay_steps(&jacobian.pace);
            let mut r = Vec::new();
            assert!(problem.evaluate(segment, &[], &mut stretcher, &near, &segment.locals, &mut r));
            r
        };
        let before = residuals(&x);
        for (k, column) in jacobian.columns.iter().enumerate() {
            let Some(nuisance) = column.checked_sub(first).map(|i| &problem.nuisances[i]) else {
                continue;
            };
            if nuisance.what == Nuisance::Skew {
                continue;
            }
            let mut there = x.clone();
            there[*column] += 1.0;
            for (row, (after, before)) in residuals(&there).iter().zip(&before).enumerate() {
                let slope = jacobian.matrix[(row, jacobian.locals + k)];
                assert!((slope - (after - before)).abs() < 1e-6, "{nuisance:?}");
            }
            seen += 1;
        }
    }
    assert!(seen >= 4, "{seen}");
}

#[test]
fn locked_unknowns_have_no_columns_and_the_others_are_the_same() {
    let (prepared, x) = flight();
    let problem = &prepared.problem;
    let used = vec![true; prepared.segments.len()];
    let locked: Vec<usize> = (0..problem.space.len()).collect();
    let linear = |locked: &[usize]| {
        problem
            .linearize(&x, &prepared.segments, &used, LOSS, locked)
            .unwrap()
    };
    for (all, some) in linear(&[]).into_iter().zip(linear(&locked)) {
        let (all, some) = (all.unwrap(), some.unwrap());
        let own: Vec<usize> = (0..problem.unknowns())
            .filter(|i| all.columns.contains(i) && !locked.contains(i))
            .collect();
        assert_eq!(some.columns, own);
        for (k, column) in some.columns.iter().enumerate() {
            let there = all.columns.iter().position(|c| c == column).unwrap();
            let (a, b) = (all.s.column(there).norm(), some.s.column(k).norm());
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }
}

#[test]
fn a_correction_reaches_the_cost_of_a_separate_fit() {
    let (prepared, x) = flight();
    let problem = &prepared.problem;
    let used = vec![true; prepared.segments.len()];
    let point = settle(problem, &x, &prepared.segments, &used, LOSS, 5).unwrap();
    let near = problem
        .linearize(&x, &point.segments, &used, LOSS, &[])
        .unwrap();
    // Another device, by half a per cent of its drive: all but a twentieth of what can be gained.
    let mut there = x.clone();
    there[problem.space.position("eta").unwrap()] += 5e-3;
    let simulator = problem.simulator(&there).unwrap();
    for (segment, near) in point.segments.iter().zip(near) {
        let nuisances = problem.nuisances_of(&there, segment.recording);
        let starts = [segment.locals.clone(), segment.locals.clone()];
        let corrected = problem.correct(
            segment,
            &[],
            &simulator,
            &nuisances,
            starts,
            near.as_ref(),
            (LOSS, 0),
        );
        let corrected = corrected.cost;
        let start = segment.locals.clone();
        let whole = problem.refine(segment, &[], &simulator, &nuisances, start, LOSS, 8);
        let whole = whole.cost;
        let begun = problem.cost(segment, &[], &simulator, &nuisances, &segment.locals, LOSS);
        assert!(
            corrected < whole + 0.05 * (begun - whole),
            "{begun} {corrected} {whole}"
        );
    }
}
