//! TODO-doc

pub mod load_example;
