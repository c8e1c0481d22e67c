//! Modes of known devices from made-up sweeps.
