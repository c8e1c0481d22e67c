//! Steps that change the state and the recordings together: the example, and the sealed
//! trial from start to end.

pub mod load_example;
pub(super) mod sealed_trial;
