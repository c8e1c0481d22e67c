//! Signals. Ctrl-C during long work: the work stops soon, and its best result so far is kept.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{Failure, terminal};

/// Exit code of a program that was ended by Ctrl-C, as shells have it.
const INTERRUPTED_EXIT_CODE: i32 = 130;

/// Set by the first Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);
static LISTENING: Once = Once::new();

/// Installs the handler: the first Ctrl-C sets the returned flag, the second ends the program. Only
/// for work that checks the flag.
pub fn flag() -> &'static AtomicBool {
    LISTENING.call_once(|| {
        let listening = ctrlc::set_handler(|| {
            if STOP.swap(true, Ordering::Relaxed) {
                std::process::exit(INTERRUPTED_EXIT_CODE);
            }
            terminal::line(
                "\nstopping; the best result so far is kept. Ctrl-C again quits at once",
            );
        });
        if let Err(error) = listening {
            terminal::warning(format_args!(
                "Ctrl-C will discard the results so far: {error}"
            ));
        }
    });
    &STOP
}

/// Makes a write beyond the limit on the size of files (`ulimit -f`) an error of that write. Without
/// it the system ends the program, and the other results are lost.
pub fn survive_size_limit() {
    #[cfg(unix)]
    {
        use signal_hook::consts::SIGXFSZ;
        use std::sync::Arc;

        // Nobody needs the flag: the write itself fails.
        let reached = Arc::new(AtomicBool::new(false));
        if let Err(error) = signal_hook::flag::register(SIGXFSZ, reached) {
            terminal::warning(format_args!(
                "a file beyond the limit on sizes will end the program: {error}"
            ));
        }
    }
}

/// Whether Ctrl-C was pressed.
pub fn stopped() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// The error of a cancelled command, after it has written what there is.
pub fn cancelled() -> Failure {
    anyhow::anyhow!("cancelled; the best result so far was written").into()
}
