//! A reading in steps that are coarser than its noise.

use crate::recording::channel::Channel;
use crate::recording::instrument_faults::fault::FaultKind;
use crate::recording::instrument_faults::signal::{Found, Signal};
use crate::recording::instrument_faults::thresholds::{
    MAX_COARSE_STEPS, MIN_BENT_SHARE, MIN_BENT_VOLTAGE_SHARE,
};

/// The whole channel, if its steps are coarse. No sample is unusable: the noise of the channel is at least
/// the step over `sqrt(12)`, and its weights follow from that. The size is the step.
pub fn find(signal: &Signal<'_>) -> Option<Found> {
    let noise = signal.noise.filter(|n| n.quantised)?;
    let step = noise.step?;
    if signal.span() > MAX_COARSE_STEPS * step {
        return None;
    }
    // Equal steps in a row are a ramp, and steps that grow evenly a fall: every sample of these
    // lies on a lattice, rounded or not. A rounded reading bends up and down all the time.
    let bends = || signal.values.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]);
    let up = bends().filter(|bend| *bend > 0.5 * step).count();
    let down = bends().filter(|bend| *bend < -0.5 * step).count();
    let needed = match signal.channel {
        Channel::Voltage => MIN_BENT_VOLTAGE_SHARE,
        Channel::ProofMass | Channel::Cantilever => MIN_BENT_SHARE,
    };
    if (up.min(down) as f64) < 0.5 * needed * signal.values.len() as f64 {
        return None;
    }
    let whole = 0..signal.values.len();
    Some(Found {
        fault: signal.fault(FaultKind::Quantised, step, std::slice::from_ref(&whole))?,
        unusable: Vec::new(),
    })
}
