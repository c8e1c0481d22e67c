//! The command line. Progress goes to stderr, results to files and stdout; the exit
//! code is 0 when done, 1 when the work failed, 2 when the command was wrong, 130 when
//! Ctrl-C was pressed twice.

mod demo;
mod design;
mod device;
mod diagnose;
mod fit;
mod interrupt;
mod output;
mod recordings;
mod simulate;
mod sweep;
mod terminal;
mod trial;
mod validate;
mod watch;

use std::path::Path;
#[cfg(feature = "gui")]
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[cfg(feature = "gui")]
use crate::app;

/// Exit code of a wrong command.
const WRONG_COMMAND_EXIT_CODE: u8 = 2;

/// Simulate, fit and diagnose the impact dynamics of piezoelectric micro-cantilevers
#[derive(Debug, Parser)]
#[command(version, about, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[cfg(feature = "gui")]
    #[command(flatten)]
    window: WindowArgs,
}

#[cfg(feature = "gui")]
#[derive(Debug, clap::Args)]
struct WindowArgs {
    /// Recordings (CSV), presets (.toml) or a session (.impactscope.toml) to open
    files: Vec<PathBuf>,
    /// Preset to open: paper, paper-as-printed, oscillator, faller, bouncing-ball, or a file
    #[arg(long)]
    preset: Option<String>,
    /// Workspace to open
    #[arg(long, value_parser = crate::app::setup::workspace_id::WorkspaceId::NAMES)]
    workspace: Option<String>,
    /// Save a picture of the settled window (PNG) and exit
    #[arg(long, value_name = "OUT.png")]
    screenshot: Option<PathBuf>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate a device and write the trace as CSV
    Simulate(simulate::Arguments),
    /// Fit parameters to recordings, and report the error on held-out recordings
    Fit(fit::Arguments),
    /// Compare with the 16 cases of the paper's Table A.1, with the statistics of its Table 3
    Validate(validate::Arguments),
    /// Find the physics that the model leaves out: where, what and how much, checked on held-out recordings
    Diagnose(diagnose::Arguments),
    /// Conceal an effect in synthetic recordings, diagnose them, reveal it and score
    Trial(trial::Arguments),
    /// Measure the steady response over axes of drive and device, as CSV; in shards, too
    Sweep(sweep::Arguments),
    /// Say what recordings hold: channels, units, rate, noise, the drive, contacts, and what is odd
    Inspect(recordings::inspect::Arguments),
    /// Make a preset for a device of one's own: from geometry, a table of modes, or a swept sine
    Device(design::Arguments),
    /// Diagnose recordings that come with the program, and write a report
    Demo(demo::Arguments),
}

/// Runs the program.
pub fn main() -> ExitCode {
    terminal::start_log();
    interrupt::survive_size_limit();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(answer) => return parser_answer(&answer),
    };
    let result = match cli.command {
        Some(Command::Simulate(arguments)) => simulate::run(&arguments),
        Some(Command::Fit(arguments)) => fit::run(&arguments),
        Some(Command::Validate(arguments)) => validate::run(&arguments),
        Some(Command::Diagnose(arguments)) => diagnose::run(&arguments),
        Some(Command::Trial(arguments)) => trial::run(&arguments),
        Some(Command::Sweep(arguments)) => sweep::run(&arguments),
        Some(Command::Device(arguments)) => design::run(&arguments),
        Some(Command::Inspect(arguments)) => recordings::inspect::run(&arguments),
        Some(Command::Demo(arguments)) => demo::run(&arguments),
        #[cfg(not(feature = "gui"))]
        None => Err(no_window()),
        #[cfg(feature = "gui")]
        None => app::run(crate::app::shell::options::WindowOptions {
            files: cli.window.files,
            preset: cli.window.preset,
            workspace: cli.window.workspace,
            screenshot: cli.window.screenshot,
        })
        .map_err(Failure::from),
    };
    end(result)
}

/// Says what the parser of the command line has to say instead of a command: help, or what is wrong.
fn parser_answer(answer: &clap::Error) -> ExitCode {
    if answer.use_stderr() {
        // Without its colours: they are control characters, as are those of a wrong argument.
        terminal::line(answer.render().to_string().trim_end());
        return ExitCode::from(WRONG_COMMAND_EXIT_CODE);
    }
    let mut results = output::Results::default();
    results.stream(Path::new(output::STDOUT), |out| {
        answer.print()?;
        Ok(out.flush()?)
    });
    end(results.end())
}

/// The exit code, after an error is said.
fn end(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            terminal::error(&said_once(&failure.error));
            ExitCode::from(failure.code)
        }
    }
}

/// An error with its causes, each once: many messages contain their cause.
fn said_once(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// An error with its exit code.
#[derive(Debug)]
struct Failure {
    code: u8,
    error: anyhow::Error,
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self {
            code: 1,
            error: error.into(),
        }
    }
}

/// What a build without the window says where no command is given.
#[cfg(not(feature = "gui"))]
fn no_window() -> Failure {
    use clap::CommandFactory;
    let program = Cli::command();
    let names: Vec<&str> = program.get_subcommands().map(|c| c.get_name()).collect();
    wrong_command(anyhow::anyhow!(
        "this build has no window; it has the commands {} (see impactscope --help)",
        names.join(", ")
    ))
}

/// Marks an error as one of the command line (exit code 2).
fn wrong_command(error: anyhow::Error) -> Failure {
    Failure {
        code: WRONG_COMMAND_EXIT_CODE,
        error,
    }
}
