//! Events of a simulated run as CSV.

use std::path::Path;

use crate::atomic_write::write_atomically;
use crate::sim::Event;

/// The events as CSV, one a row, SI.
pub fn text(events: &[Event]) -> String {
    let mut text = String::from(
        "t [s],event,velocity before [m/s],velocity after [m/s],pull-off force [N],contact duration [s]\n",
    );
    for event in events {
        text += &format!(
            "{},{},{},{},{},{}\n",
            event.time,
            event.kind.name(),
            event.velocity_before,
            event.velocity_after,
            event.pull_off_force,
            event.contact_duration
        );
    }
    text
}

/// Writes the events to a file as [`text`] has them; the file is complete or unchanged.
///
/// # Errors
/// The system's, if the file cannot be written.
pub fn write(path: &Path, events: &[Event]) -> std::io::Result<()> {
    write_atomically(path, text(events).as_bytes())
}
