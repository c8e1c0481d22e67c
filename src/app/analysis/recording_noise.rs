//! The noise of each recording, estimated once.

use std::sync::{Arc, OnceLock};

use eframe::egui::{Id, Ui};

use crate::app::setup::overlay::Overlay;
use crate::diagnose::thresholds::OWN_NOISE_MIN_RATIO;
use crate::model::unit::format_quantity;
use crate::recording::noise::NoiseEstimate;
use crate::recording::{Channel, Recording};

/// Noise below this is reported as none \[m\]; it is far below any displacement sensor.
pub const NEGLIGIBLE_NOISE: f64 = 1e-13;
/// Recordings with more samples are estimated on a thread of their own, so that the window
/// does not stall.
const MAX_FOREGROUND_SAMPLES: usize = 200_000;

type Estimate = Arc<OnceLock<Result<NoiseEstimate, String>>>;

fn estimate(recording: &Recording) -> Result<NoiseEstimate, String> {
    recording
        .estimate_noise(Channel::ProofMass)
        .map_err(|error| error.to_string())
}

fn of(ui: &Ui, overlay: &Overlay) -> Estimate {
    let key = Id::unique((
        "noise",
        overlay.id,
        Arc::as_ptr(&overlay.recording) as usize,
    ));
    if let Some(known) = ui.data(|data| data.get_temp::<Estimate>(key)) {
        return known;
    }
    let result = Estimate::default();
    ui.data_mut(|data| data.insert_temp(key, result.clone()));
    if overlay.recording.len() <= MAX_FOREGROUND_SAMPLES {
        result.get_or_init(|| estimate(&overlay.recording));
    } else {
        let (context, recording, result) =
            (ui.ctx().clone(), overlay.recording.clone(), result.clone());
        std::thread::spawn(move || {
            result.get_or_init(|| estimate(&recording));
            context.request_repaint();
        });
    }
    result
}

/// Standard deviation of the noise of xp before its scale \[m\], once it is known.
pub fn sigma(ui: &Ui, overlay: &Overlay) -> Option<f64> {
    of(ui, overlay)
        .get()?
        .as_ref()
        .ok()
        .map(|estimate| estimate.sigma)
}

/// Whether the noise is still being estimated.
pub fn is_pending(ui: &Ui, overlay: &Overlay) -> bool {
    of(ui, overlay).get().is_none()
}

/// The smallest known noise of `overlays` \[m\].
pub fn quietest<'a>(ui: &Ui, overlays: impl IntoIterator<Item = &'a Overlay>) -> f64 {
    let known = overlays.into_iter().filter_map(|o| sigma(ui, o));
    known.fold(f64::INFINITY, f64::min)
}

/// The noise as text. If other recordings are as quiet as `quietest` \[m\], a larger estimate
/// is only an upper bound, because fast motion looks like noise.
pub fn text(ui: &Ui, overlay: &Overlay, quietest: f64) -> String {
    match of(ui, overlay).get() {
        None => "being estimated".to_owned(),
        Some(Ok(estimate)) if estimate.sigma <= NEGLIGIBLE_NOISE => "none".to_owned(),
        Some(Ok(estimate)) => {
            let size = format_quantity(estimate.sigma, "m", 2);
            if estimate.sigma > OWN_NOISE_MIN_RATIO * quietest {
                format!("below {size}")
            } else {
                size
            }
        }
        Some(Err(_)) => "unknown".to_owned(),
    }
}
