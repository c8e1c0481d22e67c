//! Numbers of a run that a lesson may state or ask for.

mod motion;
mod table;
mod value;

pub use self::table::{RUN_MEASURES, RunMeasure, find, names};
