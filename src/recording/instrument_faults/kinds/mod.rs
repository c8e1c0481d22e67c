//! The kinds of faults, one file each. A new one is a file and a line in [`KINDS`].

mod ac_coupling;
mod clipping;
mod fringe_jumps;
mod held;
mod missing;
mod quantised;
mod quiet;
mod spikes;
mod steady_line;

use super::signal::{Found, Signal};

/// Looks for one kind of fault in a channel.
pub type FindFault = fn(&Signal<'_>) -> Option<Found>;

/// All kinds, in the order in which they are looked for: what one makes unusable, the next does not
/// see.
pub const KINDS: [FindFault; 8] = [
    missing::find,
    clipping::find,
    held::find,
    spikes::find,
    fringe_jumps::find,
    steady_line::find,
    ac_coupling::find,
    quantised::find,
];
