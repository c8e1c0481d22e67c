//! Finding the physics that was left out.

pub mod trial;
