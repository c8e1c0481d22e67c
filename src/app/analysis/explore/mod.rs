//! Work of the Explore workspace on threads of its own, and what its panels remember.

pub mod drawing;
pub mod feet;
pub mod latest;
pub mod mapping;
pub mod path_play;
pub mod robust;
pub mod run;
pub mod source;
pub mod steady;
pub mod sweeping;

use std::collections::BTreeMap;
use std::sync::Arc;

use self::drawing::Drawing;
use self::feet::FeetWork;
use self::latest::Latest;
use self::mapping::Mapping;
use self::path_play::PathPlay;
use self::robust::Robusting;
use self::sweeping::{Basins, Orbiting};
use crate::model::Model;

/// State of the gait panel.
#[derive(Debug, Clone, Default)]
pub struct GaitBench {
    /// Responses of the feet.
    pub feet: Latest<FeetWork>,
    /// Whether the feet move.
    pub plays: bool,
    /// The moment shown, as a share of the common cycle.
    pub moment: f64,
    /// Devices of the embedded presets that feet have, by the preset's name.
    pub devices: BTreeMap<String, Arc<Model>>,
}

/// State of the workspace that neither undo nor a session covers.
#[derive(Debug, Clone, Default)]
pub struct Exploring {
    /// The present device, shared with the threads.
    pub device: Option<Arc<Model>>,
    /// The waveform editor.
    pub drawing: Drawing,
    /// The gait panel.
    pub gait: GaitBench,
    /// The map panel.
    pub map: Mapping,
    /// The orbit panel.
    pub orbit: Orbiting,
    /// The basin panel.
    pub basins: Basins,
    /// The robustness panel.
    pub robust: Robusting,
    /// A path through the map that is being played in Tune.
    pub playing: Option<PathPlay>,
}

impl Exploring {
    /// The present device behind a pointer, the same one as long as it does not change.
    pub fn device(&mut self, model: &Model) -> Arc<Model> {
        match &self.device {
            Some(same) if **same == *model => Arc::clone(same),
            _ => Arc::clone(self.device.insert(Arc::new(model.clone()))),
        }
    }

    /// Whether an answer is still to come.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        let robust = &self.robust;
        self.map.run.job().is_some()
            || self.orbit.run.job().is_some()
            || self.basins.run.job().is_some()
            || robust.map.job().is_some()
            || robust.search.job().is_some()
            || self.map.steady.is_waiting()
            || self.drawing.steady.is_waiting()
            || self.gait.feet.is_waiting()
            || robust.point.is_waiting()
    }

    /// Ends the work in progress.
    pub fn stop(&self) {
        self.map.run.stop();
        self.orbit.run.stop();
        self.basins.run.stop();
        self.robust.map.stop();
        self.robust.search.stop();
    }
}
