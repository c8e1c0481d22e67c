//! Files: opening, importing, saving, sessions, recent files and what comes with the
//! program. All work on files runs on threads of its own.

pub(crate) mod atomic_write;
pub mod built_in;
pub(super) mod event;
pub(super) mod jobs;
pub mod open;
pub(super) mod reading;
pub(super) mod recent;
pub mod session;
pub(super) mod session_text;
