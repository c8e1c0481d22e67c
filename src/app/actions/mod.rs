//! TODO-doc

pub(super) mod diagnosis;
pub(super) mod intake;
pub(super) mod menus;
pub mod run;
pub(super) mod save;
