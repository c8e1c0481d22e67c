//! What the guided identification does on its own, as the person asked.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::fit::paper_steps::guide::Step;
use crate::model::Model;

/// What the guide does on its own.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Course {
    /// Nothing: the person takes the steps.
    #[default]
    ByHand,
    /// It waits for a fit of the whole device, applies it and examines the recordings again.
    Fitting,
    /// It takes all steps that the recordings allow, and applies what each finds.
    Steps {
        /// The step that runs.
        running: Option<Step>,
        /// Those taken already.
        taken: Vec<Step>,
    },
}

/// A fit of the whole device.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct WholeFit {
    /// The ids that were free.
    pub free: Vec<String>,
    /// The device that it led to, with what the steps changed since.
    pub model: Arc<Model>,
}
