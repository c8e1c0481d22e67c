//! The program from outside: the command line, and the window where there is a display.

mod commands;
mod inspect;
#[cfg(target_os = "linux")]
mod outputs;
#[cfg(unix)]
mod sweep;
#[cfg(feature = "gui")]
mod window;
