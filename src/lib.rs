//! `impactscope`: simulator, fit and diagnosis of the impact dynamics of micro-cantilevers.
//!
//! The code has floors; each imports only from those below it.
//!
//! | floor | what it does | begin reading at |
//! |---|---|---|
//! | [`cli`] | the commands `simulate`, `fit`, `validate`, `diagnose`, `trial`, `demo`, `sweep`, `inspect`, `device` | `cli/mod.rs` |
//! | [`app`] | the window: workspaces, plots, files, undo | [`app::state`] |
//! | [`learn`] | lessons: texts with computed numbers, predictions and their scores | [`learn::lesson`] |
//! | [`trial`] | sealed benchmark: devices with a concealed effect, by another solver | [`trial::Case`] |
//! | [`diagnose`] | what a model leaves out: where, what, how much, and the proof | `diagnose/pipeline.rs` |
//! | [`explore`](mod@explore) | drive waveforms found by eye: steady states, maps, robustness, drawn waveforms, gaits | [`explore::steady_state`] |
//! | [`fit`](mod@fit) | parameters with standard errors from recordings | [`fit::fit()`] |
//! | [`recording`] | measurements: files, noise, events, features; no model | [`recording::Recording`] |
//! | [`sim`] | the hybrid simulator: flight, events, contact | [`sim::simulate`] |
//! | [`model`] | the device: parameters, structure, drive, effects, presets | [`model::Model`] |
//!
//! Where to find what:
//! - a physical effect: [`model::effects`], one file each, one line in its catalogue;
//! - a device file: [`model::preset`] and the folder `presets`;
//! - how a file is understood: [`recording::import`](mod@recording::import), [`recording::csv`];
//! - numbers that decide an answer: [`fit::thresholds`], [`diagnose::thresholds`];
//! - a workspace of the window: [`app::workspaces`].
//!
//! `docs/ARCHITECTURE.md` lists the modules and shows how a value travels through them;
//! `docs/method.md` explains the model, the simulator, the fit and the diagnosis.

// They panic where the output fails; `cli/output.rs` and `cli/terminal.rs` do not.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

#[cfg(feature = "gui")]
pub mod app;
mod atomic_write;
pub mod cli;
pub mod diagnose;
pub mod explore;
pub mod fit;
#[cfg(feature = "gui")]
pub mod learn;
pub mod model;
#[cfg(feature = "gui")]
mod part_files;
pub mod recording;
pub mod sim;
mod static_text;
pub mod trial;
