//! A voltage of straight lines: levels with edges, ramps, triangles, tables of few points.
//!
//! The samples are cut at jumps. Between them the longest runs that one line follows are found by
//! doubling; where two runs meet, the corner is the intersection of their lines.

mod corners;
mod jumps;
mod line;

use self::corners::lines_of;
pub use self::jumps::jump_blocks;
use self::jumps::{find_jumps, refine_double_jumps};
pub use self::line::{Line, Lines, Node, cursor};
use super::samples::Samples;
use super::thresholds::MIN_SAMPLES_PER_LINE;

/// The lines that `samples` follow; `None` if they are not lines.
pub fn find_lines(samples: &Samples<'_>) -> Option<Lines> {
    let most = samples.len() / MIN_SAMPLES_PER_LINE + 1;
    let jumps = find_jumps(samples);
    if jumps.len() > most {
        return None;
    }
    let mut found = Lines {
        lines: Vec::new(),
        nodes: Vec::new(),
    };
    let mut from = 0;
    for k in 0..=jumps.len() {
        let end = jumps.get(k).map_or(samples.len(), |j| j.last + 1);
        let (lines, corners) = lines_of(samples, from, end, most)?;
        found.nodes.extend(corners);
        found.lines.extend(lines);
        if found.lines.len() > most {
            return None;
        }
        if let Some(jump) = jumps.get(k) {
            // The level after the jump is known only from what follows.
            found.nodes.push(jump.node(samples));
            from = jump.first;
        }
    }
    refine_double_jumps(samples, &jumps, &mut found);
    let are_all = {
        let (curve, at_corner) = (cursor(&found), found.near_corner());
        samples.are_where_known(|t| (!at_corner(t)).then(|| curve(t)))
    };
    are_all.then_some(found)
}
