//! What commands do, and what happens to files that have been read or saved. Everything
//! here acts on `Services`.

pub(super) mod diagnosis;
pub(super) mod intake;
pub(super) mod menus;
pub(super) mod reference_curve;
pub mod run;
pub(super) mod save;
