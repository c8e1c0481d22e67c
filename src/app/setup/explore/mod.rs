//! What a person chose in the Explore workspace: undo covers it, and a session keeps it.

pub mod choices;
pub mod panel;

pub use self::choices::{AxisChoice, DriveSource, ExploreChoices, FootChoice, GaitChoices};
pub use self::panel::ExplorePanel;
