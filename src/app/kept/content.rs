//! What stands in a part, as bytes. CBOR holds every number to the last bit, also those that
//! are not finite.

use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::thin::thinned;
use crate::app::analysis::diagnosis_answer::Answer;
use crate::app::analysis::fit::Finished;
use crate::fit::paper_steps::outcome::StepResult;

/// The content of a part. Large results are shared and never change.
#[derive(Debug, Clone)]
pub(super) enum Content {
    /// What is small, as bytes.
    Small(Vec<u8>),
    /// A fit.
    Fit(Finished),
    /// A diagnosis.
    Answer(Arc<Answer>),
    /// The result of a step of the identification.
    Step(StepResult),
}

impl Content {
    /// Where a large result lies: the same place is the same result.
    fn address(&self) -> *const () {
        match self {
            Self::Small(_) => std::ptr::null(),
            Self::Fit(finished) => Arc::as_ptr(&finished.result).cast(),
            Self::Answer(answer) => Arc::as_ptr(answer).cast(),
            Self::Step(StepResult::Modal(found)) => Arc::as_ptr(found).cast(),
            Self::Step(StepResult::Drive(found)) => Arc::as_ptr(found).cast(),
            Self::Step(StepResult::Restitution(found)) => Arc::as_ptr(found).cast(),
            Self::Step(StepResult::Adhesion(found)) => Arc::as_ptr(found).cast(),
            Self::Step(StepResult::Film(found)) => Arc::as_ptr(found).cast(),
            Self::Step(StepResult::Sensitivity(found)) => Arc::as_ptr(found).cast(),
        }
    }

    /// Its bytes; `None`, noted in the log, if it cannot be written.
    pub(super) fn bytes(&self) -> Option<Vec<u8>> {
        match self {
            Self::Small(bytes) => Some(bytes.clone()),
            Self::Fit(Finished { result, asked }) => bytes(&(result, asked)),
            Self::Answer(answer) => bytes(&*thinned(answer)),
            Self::Step(found) => bytes(found),
        }
    }
}

impl PartialEq for Content {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Small(a), Self::Small(b)) => a == b,
            (Self::Small(_), _) | (_, Self::Small(_)) => false,
            _ => std::ptr::eq(self.address(), other.address()),
        }
    }
}

/// A value as bytes; `None`, noted in the log, if it cannot be written.
pub(super) fn bytes(value: &impl Serialize) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    match ciborium::into_writer(value, &mut bytes) {
        Ok(()) => Some(bytes),
        Err(error) => {
            log::error!("a result cannot be written to the session: {error}");
            None
        }
    }
}

/// The value in bytes; `None`, noted in the log, if they are of another version.
pub(super) fn value<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let value = ciborium::from_reader(bytes);
    value
        .inspect_err(|error| log::warn!("a result of the session cannot be read: {error}"))
        .ok()
}
