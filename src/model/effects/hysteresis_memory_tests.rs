use super::super::hysteresis_memory::*;
use crate::model::drive::Shape;

fn end(law: &HysteresisMemory, extreme: f64, z: &mut [f64]) {
    law.end_piece(&Kinematics::default(), extreme, z);
}

fn law() -> HysteresisMemory {
    HysteresisMemory {
        share: 1.0,
        width: 1.0,
        reference: 8.0,
        middle: [0.0; 2],
        relays: Relays::new([8.0, 0.0, 0.0], [slant(&Piezo::default()), 0.0, 0.0]),
        before: 0.0,
        piezo: Piezo::default(),
        rates: [0.0; 1 + MEMORY],
    }
}

#[test]
fn at_the_reference_amplitude_the_loop_is_that_of_the_branches() {
    let (law, mut z) = (law(), [0.0; 1 + MEMORY]);
    for extreme in [8.0, -8.0] {
        end(&law, extreme, &mut z);
    }
    for branch in [Branch::Rising, Branch::Falling] {
        for step in 0..=16 {
            let up = -8.0 + f64::from(step);
            let voltage = if branch == Branch::Rising { up } else { -up };
            let expected = law.piezo.gain(voltage, branch);
            let gain = law.hysteresis(0.0, voltage, branch, &z);
            // The branches of the paper meet at +-8 V but for 0.02.
            assert!(
                (gain - expected).abs() < 0.03,
                "{voltage}: {gain} {expected}"
            );
        }
        end(
            &law,
            if branch == Branch::Rising { 8.0 } else { -8.0 },
            &mut z,
        );
    }
}

#[test]
fn loops_close_at_every_amplitude() {
    let (law, mut z) = (law(), [0.0; 1 + MEMORY]);
    for extreme in [8.0, -8.0, 3.0] {
        end(&law, extreme, &mut z);
    }
    let before = law.hysteresis(0.0, 5.0, Branch::Rising, &z);
    // A minor loop leaves no trace, nor do a hundred nested ones more than a small one.
    for extreme in [-1.0, 3.0] {
        end(&law, extreme, &mut z);
    }
    assert_eq!(law.hysteresis(0.0, 5.0, Branch::Rising, &z), before);
    for i in 0..100 {
        let size = 3.0 / (1.0 + f64::from(i));
        end(&law, if i % 2 == 0 { -size } else { size }, &mut z);
    }
    assert_eq!(law.hysteresis(0.0, 5.0, Branch::Rising, &z), before);
}

#[test]
fn a_past_counts_until_it_is_overtaken() {
    let mut older = law();
    older.before = -6.0;
    let (fresh, mut z, mut y) = (law(), [0.0; 1 + MEMORY], [0.0; 1 + MEMORY]);
    let gain = |law: &HysteresisMemory, z: &[f64]| law.hysteresis(0.0, 1.0, Branch::Falling, z);
    for extreme in [4.0, 7.0] {
        end(&older, extreme, &mut z);
        end(&fresh, extreme, &mut y);
        let apart = (gain(&older, &z) - gain(&fresh, &y)).abs();
        assert_eq!(apart > 1e-3, extreme < 6.0, "{extreme}: {apart}");
    }
}

/// A sweep that ends where it would close a loop does not pass that point.
#[test]
fn a_sweep_that_ends_at_an_extreme_is_not_cut() {
    let (law, mut z) = (law(), [0.0; 1 + MEMORY]);
    for extreme in [8.0, -6.0] {
        end(&law, extreme, &mut z);
    }
    for (end, cut) in [(-8.000000000000002, false), (-8.5, true)] {
        let sweep = Segment {
            start: 0.0,
            end: 1.0,
            shape: Shape::Line {
                voltage: -6.0,
                slope: end + 6.0,
                at: 0.0,
            },
            branch: Branch::Falling,
        };
        assert_eq!(law.piece(sweep, 0.0, &z).end < 1.0, cut, "{end}");
    }
}
