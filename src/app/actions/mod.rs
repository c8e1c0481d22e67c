//! What commands do, and what happens to files that have been read or saved. Everything
//! here acts on `Services`.

pub(super) mod diagnosis;
pub(super) mod explore;
pub(super) mod intake;
pub(super) mod kept_curves;
pub(super) mod learn;
pub(super) mod menus;
pub mod run;
pub(super) mod save;
