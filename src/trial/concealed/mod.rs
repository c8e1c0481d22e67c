//! What a trial conceals: the laws, how they are drawn, and the forces that they exert.

mod catalogue_draws;
pub mod concealed_effects;
mod drawn;
pub mod hidden_forces;
pub mod law;
mod outside_draws;
pub mod preisach;
