//! What the window shows at a time: one workspace a folder.

pub mod tune;
