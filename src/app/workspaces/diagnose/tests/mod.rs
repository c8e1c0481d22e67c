//! The workspace by its accessibility tree, without a GPU.
