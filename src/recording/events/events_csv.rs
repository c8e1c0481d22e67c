//! Events of a simulated run as CSV.

use std::io::Write;
use std::path::Path;

use crate::sim::Event;

/// Writes the events to a file, one a row, SI.
///
/// # Errors
/// The system's, if the file cannot be written.
pub fn write(path: &Path, events: &[Event]) -> std::io::Result<()> {
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    writeln!(
        out,
        "t [s],event,velocity before [m/s],velocity after [m/s],pull-off force [N],contact duration [s]"
    )?;
    for event in events {
        writeln!(
            out,
            "{},{},{},{},{},{}",
            event.time,
            event.kind.name(),
            event.velocity_before,
            event.velocity_after,
            event.pull_off_force,
            event.contact_duration
        )?;
    }
    out.flush()
}
