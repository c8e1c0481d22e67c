//! What the fuzz targets do with their bytes. `tests/files/fuzz.rs` runs the same bodies for some
//! seconds with every `cargo test`.

pub mod bodies;
