//! Contact laws: bounces, releases and stays as read by a model of flight, and what they say about
//! restitution, adhesion and the compliance of the ground.

pub(super) mod adhesion;
pub(super) mod bounce_readings;
pub(super) mod compliance;
pub(super) mod decide;
pub mod event_readings;
pub(super) mod free_flights;
pub(super) mod law_test;
pub(super) mod nominal;
pub mod restitution;
pub(super) mod robust_curve;
