//! What a person chose in the Explore workspace: undo covers it, and a session keeps it.

mod choices;
mod panel;
mod sweeps;

pub use self::choices::{ExploreChoices, FootChoice, GaitChoices};
pub use self::panel::ExplorePanel;
pub use self::sweeps::{
    AxisChoice, BasinChoices, DriveSource, MapChoices, OrbitChoices, OrbitQuantity,
    RobustnessChoices, UncertainCoefficient, WishChoices,
};
