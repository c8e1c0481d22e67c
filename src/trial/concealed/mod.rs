//! TODO-doc

pub mod concealed_effects;
pub mod hidden_forces;
pub mod law;
pub mod preisach;
