//! Pictures of the Explore workspace, one file each; `plane.rs` is the frame that they share.

pub mod basin;
pub mod cells;
pub mod colors;
pub mod cycle;
pub mod drawing;
pub mod gait;
pub mod legend;
pub mod map;
pub mod orbit;
pub mod plane;
pub mod robust;
