//! Writes where the named widgets are and what the readouts show to the file named by the
//! environment variable `IMPACTSCOPE_LAYOUT_FILE`, for tests that use a real window.

use std::path::PathBuf;

use eframe::egui::{Context, Id, Rect};
use serde_json::{Map, Value, json};

use crate::app::files::atomic_write::write_atomically;
use crate::app::state::State;
use crate::diagnose::report::headline;

/// Writes the file when its contents change.
pub struct Layout {
    file: Option<PathBuf>,
    written: Value,
}

impl Layout {
    /// Reads the environment variable.
    pub fn new() -> Self {
        Self {
            file: std::env::var_os("IMPACTSCOPE_LAYOUT_FILE").map(PathBuf::from),
            written: Value::Null,
        }
    }

    /// Called at the end of each frame.
    pub fn update(&mut self, context: &Context, state: &State) {
        let Some(file) = &self.file else {
            return;
        };
        let scale = context.pixels_per_point();
        let places: Vec<(String, Rect)> =
            context.data(|data| data.get_temp(Id::unique("layout")).unwrap_or_default());
        let widgets: Map<String, Value> = places
            .into_iter()
            .map(|(name, r)| {
                let r = r * scale;
                (name, json!([r.min.x, r.min.y, r.max.x, r.max.y]))
            })
            .collect();
        let residuals: Vec<Value> = state
            .snapshot
            .iter()
            .flat_map(|snapshot| &snapshot.comparisons)
            .map(|c| json!({ "id": c.id, "rms": c.comparison.as_ref().map(|c| c.rms).ok() }))
            .collect();
        // Enough of the curve to see that it has changed.
        let curve: Vec<f64> = state
            .snapshot
            .iter()
            .flat_map(|snapshot| {
                let values = &snapshot.trace.proof_mass;
                (0..64).filter_map(move |i| values.get(i * values.len() / 64).copied())
            })
            .collect();
        let parameters =
            serde_json::to_value(state.setup.preset.model.parameters).unwrap_or(Value::Null);
        let mut contents = json!({
            "widgets": widgets,
            "residuals": residuals,
            "curve": curve,
            "parameters": parameters,
            "diagnosis": state.diagnosing.shown().map(|a| headline(&a.diagnosis)),
            "time_range": state.view.time_range,
            "generation": state.snapshot.as_ref().map(|s| s.generation),
            "notices": state.notices.iter().map(|n| n.text.clone()).collect::<Vec<_>>(),
        });
        if contents != self.written {
            self.written = contents.clone();
            // Number of frames so far. It changes in every frame, so it does not count as a
            // change.
            contents["frames"] = context.cumulative_frame_nr().into();
            if let Err(error) = write_atomically(file, contents.to_string().as_bytes()) {
                log::warn!("{error}");
            }
        }
    }
}
