//! Readings that are missing: empty cells, or cells that are no numbers.

use crate::recording::instrument_faults::fault::FaultKind;
use crate::recording::instrument_faults::signal::{Found, Signal, runs_where};

/// All samples that are no numbers. The size is the longest run. They are NaN already.
pub fn find(signal: &Signal<'_>) -> Option<Found> {
    let runs = runs_where(signal.values.len(), |i| !signal.values[i].is_finite());
    let longest = runs.iter().map(ExactSizeIterator::len).max()?;
    Some(Found {
        fault: signal.fault(FaultKind::MissingReadings, longest as f64, &runs)?,
        unusable: Vec::new(),
    })
}
