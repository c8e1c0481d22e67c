//! Caches what is derived from results and recordings for drawing. A value is made once and
//! kept while its source is in view.

use std::sync::{Arc, Weak};

use eframe::egui::{Id, Ui};

use crate::app::setup::overlay::Overlay;
use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::recording::velocity::differentiate;
use crate::recording::{Channel, Recording};
use crate::sim::Trace;

/// The value cached under `id`; made again when `key` differs.
pub fn cached<K, V>(ui: &Ui, id: Id, key: K, make: impl FnOnce() -> V) -> Arc<V>
where
    K: PartialEq + Clone + Send + Sync + 'static,
    V: Send + Sync + 'static,
{
    if let Some((known, value)) = ui.data(|data| data.get_temp::<(K, Arc<V>)>(id))
        && known == key
    {
        return value;
    }
    let value = Arc::new(make());
    ui.data_mut(|data| data.insert_temp(id, (key, Arc::clone(&value))));
    value
}

/// Identifies shared data without keeping it alive. Two are equal only if they refer to the
/// same data.
#[derive(Debug)]
pub struct Source<T>(Weak<T>);

impl<T> Source<T> {
    /// The identity of shared data.
    pub fn of(shared: &Arc<T>) -> Self {
        Self(Arc::downgrade(shared))
    }
}

impl<T> Clone for Source<T> {
    fn clone(&self) -> Self {
        Self(Weak::clone(&self.0))
    }
}

impl<T> PartialEq for Source<T> {
    fn eq(&self, other: &Self) -> bool {
        self.0.ptr_eq(&other.0)
    }
}

/// A column of a simulated run.
pub fn column(
    ui: &Ui,
    name: &'static str,
    trace: &Arc<Trace>,
    values: impl FnOnce(&Trace) -> &[f64],
) -> Arc<Pyramid> {
    let id = Id::unique(("plot column", name));
    cached(ui, id, Source::of(trace), || {
        Pyramid::new(trace.t0, trace.dt, values(trace))
    })
}

/// Velocity of a recording's proof mass by smoothed differences [m/s], and its range
/// over time.
pub fn velocity(ui: &Ui, overlay: &Overlay) -> Arc<(Vec<f64>, Pyramid)> {
    let recording: &Arc<Recording> = &overlay.recording;
    let id = Id::unique(("plot velocity", overlay.id));
    cached(ui, id, Source::of(recording), || {
        let velocity = differentiate(&recording.time, &recording.proof_mass);
        let pyramid = Pyramid::xy(&recording.time, &velocity);
        (velocity, pyramid)
    })
}

/// A channel of a recording, without its alignment; `None` if it was not recorded.
pub fn channel(ui: &Ui, overlay: &Overlay, channel: Channel) -> Option<Arc<Pyramid>> {
    let recording: &Arc<Recording> = &overlay.recording;
    recording.channel(channel)?;
    let id = Id::unique(("plot channel", overlay.id, channel));
    Some(cached(ui, id, Source::of(recording), || {
        Pyramid::xy(
            &recording.time,
            recording.channel(channel).unwrap_or_default(),
        )
    }))
}
