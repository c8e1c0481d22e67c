//! Steps that change the state and the recordings together: the example, and the sealed
//! trial from start to end.

pub mod load_example;
pub mod open_case;
pub(super) mod sealed_trial;
