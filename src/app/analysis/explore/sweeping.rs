//! The orbit diagram and the basins: what is asked of them, and their growth.

use eframe::egui::Context;

use super::mapping::axis_of;
use super::run::Run;
use crate::app::setup::explore::{BasinChoices, OrbitChoices};
use crate::explore::basin::{self, BasinMap, BasinPoint, BasinRequest, Beginnings};
use crate::explore::map::MapError;
use crate::explore::orbit::{self, Direction, OrbitDiagram, OrbitRequest};
use crate::model::Model;
use crate::model::drive::Waveform;

/// State of the orbit panel.
#[derive(Debug, Clone, Default)]
pub struct Orbiting {
    /// The diagram.
    pub run: Run<OrbitRequest, OrbitDiagram>,
    /// Whether it was stopped by hand.
    pub is_stopped: bool,
}

/// State of the basin panel.
#[derive(Debug, Clone, Default)]
pub struct Basins {
    /// The basins.
    pub run: Run<BasinRequest, BasinMap>,
    /// Whether it was stopped by hand.
    pub is_stopped: bool,
}

/// What is asked of an orbit diagram.
///
/// # Errors
/// [`MapError`].
pub fn orbit_request(
    choices: &OrbitChoices,
    of: (&Model, &Waveform),
) -> Result<OrbitRequest, MapError> {
    let axis = axis_of(&choices.axis, of, choices.points)?;
    let request = OrbitRequest::new(of.0.clone(), of.1.clone(), axis);
    request.check()?;
    Ok(request)
}

/// What is asked of basins.
///
/// # Errors
/// [`MapError`].
pub fn basin_request(
    choices: &BasinChoices,
    (model, drive): (&Model, &Waveform),
) -> Result<BasinRequest, MapError> {
    let beginnings = if choices.over_phase {
        Beginnings::Phases {
            count: choices.points,
        }
    } else {
        Beginnings::Plane {
            displacement: choices.displacement,
            velocity: choices.velocity,
            count: (choices.points, choices.points),
            switched_on: choices.switched_on,
        }
    };
    let request = BasinRequest::new(model.clone(), drive.clone(), beginnings);
    request.check()?;
    Ok(request)
}

impl Orbiting {
    /// Begins the diagram anew if its question has changed, or if `again` says so.
    pub fn update(
        &mut self,
        request: Result<OrbitRequest, String>,
        again: bool,
        context: &Context,
    ) {
        self.run.poll();
        let request = match request {
            Ok(request) => request,
            Err(reason) => return self.run.refuse(reason),
        };
        if !(again || self.run.is_outdated(&request)) {
            return;
        }
        self.is_stopped = false;
        let axis = request.map.axes[0].clone();
        let ways = if request.is_swept_back { 2 } else { 1 };
        let slices = (axis.count * ways).max(1) as f64;
        let empty = OrbitDiagram {
            axis,
            up: Vec::new(),
            down: Vec::new(),
        };
        self.run.start(
            "orbit diagram",
            request,
            empty,
            context,
            move |request, parts| {
                let mut done = 0.0;
                let found = orbit::compute(request, parts.cancel, &mut |slice| {
                    done += 1.0;
                    parts.add(done / slices, |diagram| match slice.direction {
                        Direction::Up => diagram.up.push(slice.clone()),
                        Direction::Down => diagram.down.push(slice.clone()),
                    });
                });
                found.map(|_| ()).map_err(|error| error.to_string())
            },
        );
    }
}

impl Basins {
    /// Begins the basins anew if their question has changed, or if `again` says so.
    pub fn update(
        &mut self,
        request: Result<BasinRequest, String>,
        again: bool,
        context: &Context,
    ) {
        self.run.poll();
        let request = match request {
            Ok(request) => request,
            Err(reason) => return self.run.refuse(reason),
        };
        if !(again || self.run.is_outdated(&request)) {
            return;
        }
        self.is_stopped = false;
        let shape = request.shape();
        let empty = BasinMap {
            shape,
            points: vec![BasinPoint::Pending; shape.0 * shape.1],
            responses: Vec::new(),
            holes: std::collections::BTreeMap::new(),
        };
        self.run
            .start("basins", request, empty, context, |request, parts| {
                let found = basin::compute(request, parts.cancel, &|map| {
                    let pending = map.points.iter().filter(|p| **p == BasinPoint::Pending);
                    let share = 1.0 - pending.count() as f64 / map.points.len().max(1) as f64;
                    parts.add(share, |own| own.clone_from(map));
                });
                let map = found.map_err(|error| error.to_string())?;
                parts.add(1.0, |own| *own = map);
                Ok(())
            });
    }
}
