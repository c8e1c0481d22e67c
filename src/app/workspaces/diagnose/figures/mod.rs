//! The figures of the Diagnose workspace: one file each, on a common plot frame. They only
//! draw what the diagnosis has computed.

pub(super) mod before_after_bars;
pub(super) mod contact_events;
pub(super) mod evidence;
pub(super) mod force;
pub(super) mod force_balance;
pub(super) mod frame;
pub(super) mod marginal;
pub(super) mod recording_preview;
pub(super) mod residual_strip;
pub(super) mod words;
pub(super) mod zoom;
