//! Recordings: files read as they are, and what is measured in them.

mod features_of_recordings;
mod features_of_simulation;
mod forms;
mod fuzz;
mod recordings;
