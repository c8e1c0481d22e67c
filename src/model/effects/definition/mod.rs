//! The definition of an effect: what it is, what it does, what is known of it.

mod action;
mod facts;
mod search;
mod spec;

pub use action::{Action, Kinematics, Surroundings, followed_time_constant};
pub use facts::{
    ContactLaw, EdgeLag, EventFigure, EvidenceFigure, Facts, FallOff, LagKind, ModeLayout, Quantity,
};
pub use search::{
    ColdStart, FormError, FormTolerance, FoundBy, Motion, RefinedBounds, Refinement, Search, Start,
};
pub use spec::{ActiveEffect, EffectSpec, Need, own_ids};
