//! Where a voltage jumps.

use super::line::{Lines, Node};
use crate::recording::measured_drive::samples::Samples;
use crate::recording::measured_drive::thresholds::{JUMP_STEEPNESS, MIN_JUMP_REACHES};

/// Two neighbouring samples, or three, between which the voltage jumps.
#[derive(Debug, Clone, Copy)]
pub struct Jump {
    /// Last sample before.
    pub last: usize,
    /// First sample after.
    pub first: usize,
}

pub fn find_jumps(samples: &Samples<'_>) -> Vec<Jump> {
    let (v, n) = (samples.volts, samples.len());
    let least = MIN_JUMP_REACHES * 2.0 * samples.reach();
    let rise = |i: isize| {
        if i < 0 || i + 1 >= n as isize {
            // Nothing tells a jump at the end of the samples from the start of a ramp.
            f64::INFINITY
        } else {
            v[i as usize + 1] - v[i as usize]
        }
    };
    let steep = |whole: f64, before: f64, after: f64| {
        // The neighbours' noise must not make a steep slope a jump.
        whole.abs() > least + JUMP_STEEPNESS * before.abs().max(after.abs())
    };
    let mut jumps = Vec::new();
    let mut i = 0;
    while i + 1 < n {
        let k = i as isize;
        let one = rise(k);
        if one.abs() > 0.3 * least {
            if steep(one, rise(k - 1), rise(k + 1)) {
                jumps.push(Jump {
                    last: i,
                    first: i + 1,
                });
                i += 1;
                continue;
            }
            // A sample that was taken during the jump.
            let two = one + rise(k + 1);
            if i + 2 < n && one * rise(k + 1) > 0.0 && steep(two, rise(k - 1), rise(k + 2)) {
                jumps.push(Jump {
                    last: i,
                    first: i + 2,
                });
                i += 2;
                continue;
            }
        }
        i += 1;
    }
    jumps
}

impl Jump {
    pub fn node(&self, samples: &Samples<'_>) -> Node {
        let (low, high) = (samples.time[self.last], samples.time[self.first]);
        Node {
            time: 0.5 * (low + high),
            low,
            high,
            jumps: true,
        }
    }
}

/// A sample taken during a jump tells where between its neighbours it was: an averaging digitiser
/// weighs the levels before and after, a fast ramp is half way at its middle.
pub fn refine_double_jumps(samples: &Samples<'_>, jumps: &[Jump], found: &mut Lines) {
    let mut of_jump = jumps.iter();
    for k in 0..found.nodes.len() {
        if !found.nodes[k].jumps {
            continue;
        }
        let Some(jump) = of_jump.next() else { return };
        if jump.first == jump.last + 2 {
            let t = samples.time[jump.last + 1];
            let before = found.lines[k].voltage(t);
            let after = found.lines[k + 1].voltage(t);
            let share = ((after - samples.volts[jump.last + 1]) / (after - before)).clamp(0.0, 1.0);
            let node = &mut found.nodes[k];
            node.time = t + (share - 0.5) * 0.5 * (node.high - node.low);
        }
    }
}

/// The ranges of samples between jumps.
pub fn jump_blocks(samples: &Samples<'_>) -> Vec<std::ops::Range<usize>> {
    let mut from = 0;
    let mut blocks = Vec::new();
    for jump in find_jumps(samples) {
        blocks.push(from..jump.last + 1);
        from = jump.first;
    }
    blocks.push(from..samples.len());
    blocks
}
