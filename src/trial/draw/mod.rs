//! Drawing a trial: device, instruments, what is concealed and at which size, recordings.

mod actuator_attempt;
pub(crate) mod case;
mod concealed_ids;
mod drawing;
mod one_mode_attempt;
mod parts;
pub(crate) mod settings;
pub(crate) mod size;

pub use self::case::{Case, Recordings, TrialError};
pub use self::settings::{Mix, RigChoice, Settings};
