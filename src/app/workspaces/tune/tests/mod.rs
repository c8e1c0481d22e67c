//! The workspace by its accessibility tree, without a GPU.

mod support;

pub(super) use support::state;
