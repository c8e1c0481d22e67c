//! The window. Nothing below this floor knows egui.

pub mod actions;
pub mod analysis;
pub mod dialogs;
pub mod export;
pub mod files;
pub mod flows;
pub(crate) mod kept;
pub mod plots;
pub(crate) mod services;
pub mod setup;
pub mod shell;
pub mod simulation;
pub mod state;
pub mod theme;
pub mod widgets;
pub mod workspaces;

use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui::{Vec2, ViewportBuilder};

use self::shell::options::{AppError, WindowOptions};
use crate::model::preset::Preset;

/// Opens the window and runs it to its end.
///
/// # Errors
/// [`AppError`].
pub fn run(options: WindowOptions) -> Result<(), AppError> {
    #[cfg(target_os = "linux")]
    if ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"]
        .iter()
        .all(|name| std::env::var_os(name).is_none_or(|value| value.is_empty()))
    {
        return Err(AppError::NoWindow("there is no display".to_owned()));
    }
    let preset = options.preset.as_deref().map(Preset::load).transpose()?;
    let picture = options.screenshot.is_some();
    // Outcome of the picture, handed out of the event loop.
    let outcome = Arc::new(Mutex::new(None));
    let of_shell = Arc::clone(&outcome);
    let native = eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("impactscope")
            .with_app_id("impactscope")
            .with_inner_size(Vec2::new(1440.0, 900.0))
            // A screen of 1600 x 1000 pixels at 200 % has 800 x 500 points.
            .with_min_inner_size(Vec2::new(640.0, 400.0))
            .with_drag_and_drop(true),
        ..eframe::NativeOptions::default()
    };
    eframe::run_native(
        "impactscope",
        native,
        Box::new(move |context| {
            Ok(Box::new(shell::window::Shell::new(
                &context.egui_ctx,
                options,
                preset,
                of_shell,
            )?))
        }),
    )
    .map_err(|error| AppError::NoWindow(reason(&error)))?;
    let saved = outcome
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .take();
    match saved {
        Some(Err(error)) => Err(error),
        None if picture => Err(AppError::Screenshot(
            "the window was closed first".to_owned(),
        )),
        _ => Ok(()),
    }
}

/// Why the system gives no window. What the libraries say of a display is where in their
/// own source it failed: that is for the log.
fn reason(error: &eframe::Error) -> String {
    log::debug!("{error}");
    match error {
        eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => {
            let named = |name| std::env::var(name).ok().filter(|value| !value.is_empty());
            let display = named("WAYLAND_DISPLAY").or_else(|| named("DISPLAY"));
            let display = display.unwrap_or_default();
            format!("the display {display} cannot be used")
        }
        error => error.to_string(),
    }
}
