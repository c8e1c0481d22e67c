//! Lessons: what a pupil reads, predicts and sees, computed from the simulation.
//!
//! A lesson is one text file ([`lesson`]). Every number in its text is an expression over
//! measures of its own run ([`expression`], [`measures`]), so that no text can disagree with the
//! simulation. A pupil predicts by choosing, by drawing a curve or by moving a mark; the
//! prediction is scored against the run ([`prediction`]).
//!
//! | part | what it does |
//! |---|---|
//! | [`lesson`] | the format of a file, read and checked |
//! | [`catalogue`] | the lessons that come with the program |
//! | [`expression`], [`measures`], [`text`] | numbers of a run, and texts that state them |
//! | [`run`], [`energy`] | a scene simulated, and where its energy goes |
//! | [`prediction`] | what a pupil predicts, and its score |
//! | [`playback`] | the moment that is shown, with slow motion at impacts |
//! | [`target`] | recordings to fit by hand, and concealed effects |
//! | [`pupil`] | progress and answers |

pub mod catalogue;
pub mod controls;
pub mod energy;
pub mod expression;
pub mod lesson;
pub mod measures;
pub mod playback;
pub mod prediction;
pub mod pupil;
pub mod run;
pub mod target;
pub mod text;
