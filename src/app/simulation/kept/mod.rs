//! Runs of the kept curves and their numbers, computed on a thread of their own: each is
//! simulated once and compared with the recordings like the present run.

mod runs;
mod worker;

pub use self::runs::{KeptRun, KeptRuns};
pub use self::worker::{KeptRequest, KeptTask, KeptWorker};
