//! Stand-in until branch `recording` lands.
