//! A path through a map that is played as a sweep.

use std::sync::Arc;

use crate::explore::map::{AxisOf, MapRequest};
use crate::explore::waveform;
use crate::model::Model;
use crate::model::drive::Waveform;

/// How long a path is played \[s\].
const PLAYED_PATH: f64 = 20.0;

/// A path that is being played.
#[derive(Debug, Clone)]
pub struct PathPlay {
    request: Arc<MapRequest>,
    path: Vec<[f64; 2]>,
    /// When it began, on the window's clock \[s\]; `None` before the first frame.
    begun: Option<f64>,
}

impl PathPlay {
    /// A path of at least two points through a map of two axes.
    #[must_use]
    pub fn new(request: Arc<MapRequest>, path: Vec<[f64; 2]>) -> Option<Self> {
        let is_path = path.len() >= 2 && request.axes.len() == 2;
        is_path.then_some(Self {
            request,
            path,
            begun: None,
        })
    }

    /// Device and drive at a time of the window's clock \[s\]; `None` after the end. Between the
    /// points of a map where neither refuses the values, an error where one does.
    pub fn at(&mut self, now: f64) -> Option<Result<(Model, Waveform), String>> {
        let share = (now - *self.begun.get_or_insert(now)) / PLAYED_PATH;
        (share <= 1.0).then(|| setting(&self.request, along(&self.path, share)))
    }
}

/// Device and drive between the points of a map.
fn setting(request: &MapRequest, place: [f64; 2]) -> Result<(Model, Waveform), String> {
    let mut model = request.model.clone();
    let mut drive = request.drive.clone();
    for (axis, value) in request.axes.iter().zip(place) {
        match axis.of {
            AxisOf::Model => model.set(&axis.id, value).map_err(|e| e.to_string())?,
            AxisOf::Drive => {
                drive = waveform::set(&drive, &axis.id, value).map_err(|e| e.to_string())?;
            }
        }
    }
    Ok((model, drive))
}

/// The point at a share of a path, each of its parts as long.
fn along(path: &[[f64; 2]], share: f64) -> [f64; 2] {
    let last = path.len() - 1;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let below = (at.floor() as usize).min(last.saturating_sub(1));
    let t = at - below as f64;
    let (a, b) = (path[below], path[(below + 1).min(last)]);
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

#[cfg(test)]
mod tests {
    use super::super::path_play::*;

    #[test]
    fn a_path_is_run_through_from_end_to_end() {
        let path = [[1.0, 0.0], [2.0, 0.0], [2.0, 4.0]];
        assert_eq!(along(&path, 0.0), [1.0, 0.0]);
        assert_eq!(along(&path, 0.75), [2.0, 2.0]);
        assert_eq!(along(&path, 1.0), [2.0, 4.0]);
    }
}
