//! The drive editor: the waveform with its values, a table of points, and a preview. It is
//! shown in the left panel or in a panel of its own beside the plots.

pub mod editor;
pub(super) mod place;
pub(super) mod preview;
pub(super) mod table;
