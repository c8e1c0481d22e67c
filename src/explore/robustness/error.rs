//! Why robustness is not computed.

use thiserror::Error;

use crate::explore::map::MapError;

/// What is wrong, and what would be right.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RobustnessError {
    /// The map's request.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A coefficient of the ensemble.
    #[error("coefficient {id}: {reason}")]
    Coefficient { id: String, reason: String },
    /// Members, covariance.
    #[error("ensemble: {0}")]
    Ensemble(String),
    /// The wish.
    #[error("wish: {0}")]
    Wish(String),
    /// The search.
    #[error("search: {0}")]
    Search(String),
}
