//! Pictures of the Explore workspace, one file each; `plane.rs` is the frame that they share.

pub mod cycle;
pub mod drawing;
pub mod gait;
pub mod plane;
