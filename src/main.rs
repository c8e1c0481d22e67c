//! The program: opens the window, or runs a command. Everything is in the library; see
//! `impactscope::cli` for the commands and their exit codes.

// They panic where the output fails.
#![deny(clippy::print_stdout, clippy::print_stderr)]

use std::process::ExitCode;

fn main() -> ExitCode {
    impactscope::cli::main()
}
