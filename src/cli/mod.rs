//! The command line. Progress goes to stderr, results to stdout or files; the exit
//! code is 0 when done, 1 when the work failed, 2 when the command was wrong.

mod fit;
mod shared;
mod simulate;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use crate::app;
use shared::Failure;

/// Impact dynamics of piezoelectric micro-cantilevers: simulation live over recordings.
#[derive(Debug, Parser)]
#[command(version, about, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    window: WindowArgs,
}

#[derive(Debug, Args)]
struct WindowArgs {
    /// Recordings (CSV), presets (.toml) or a session (.impactscope.toml) to open
    files: Vec<PathBuf>,
    /// Preset to open: paper, paper-as-printed, oscillator, faller, or a file
    #[arg(long)]
    preset: Option<String>,
    /// Workspace to open
    #[arg(long, value_parser = app::workspaces::NAMES)]
    workspace: Option<String>,
    /// Save a picture of the settled window (PNG) and exit
    #[arg(long, value_name = "OUT.png")]
    screenshot: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate a device and write the trace as CSV
    Simulate(simulate::SimulateArgs),
    /// Fit parameters to recordings, and measure what is left on recordings kept out
    Fit(fit::FitArgs),
}

/// Runs the program.
pub fn main() -> ExitCode {
    // clap exits with 2 by itself where the command is wrong.
    let cli = Cli::parse();
    let result = match cli.command {
        Some(Command::Simulate(args)) => simulate::simulate(&args),
        Some(Command::Fit(args)) => fit::fit(&args),
        None => app::run(app::WindowOptions {
            files: cli.window.files,
            preset: cli.window.preset,
            workspace: cli.window.workspace,
            screenshot: cli.window.screenshot,
        })
        .map_err(Failure::from),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("impactscope: {:#}", failure.error);
            ExitCode::from(failure.code)
        }
    }
}
