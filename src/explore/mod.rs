//! Explore: how the steady response of a device depends on its drive and its coefficients.
//!
//! | part | what it does |
//! |---|---|
//! | [`steady_state`] | the periodic response under a periodic drive, its stability, and whether there is one |
//! | [`measures`] | numbers and categories of one steady cycle |

pub mod measures;
pub mod steady_state;
