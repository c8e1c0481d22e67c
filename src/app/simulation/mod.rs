//! TODO-doc

pub(super) mod features;
pub(super) mod live;
pub mod min_max_pyramid;
pub mod request;
pub mod snapshot;
pub mod worker;
