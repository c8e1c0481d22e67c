//! The window's side of the simulator thread: sends what is to be shown, takes the
//! results, and shows at its slider which parameter is refused.

use std::sync::Arc;

use crate::app::services::Services;
use crate::app::setup::drive_choice::Mode;
use crate::app::setup::notice::Refusal;
use crate::app::setup::view::Picture;
use crate::app::simulation::request::SimulationRequest;
use crate::app::simulation::worker::{Worker, WorkerEvent};
use crate::app::workspaces::tune::usual_speed;
use crate::sim::SimError;

/// Connection to the simulator thread.
pub(super) struct Simulator {
    worker: Worker,
    /// The last request sent.
    sent: Option<SimulationRequest>,
    /// Whether the last request made the simulator panic.
    pub(super) is_broken: bool,
}

impl Simulator {
    /// Starts the thread. `repaint` is called when a result is there.
    ///
    /// # Errors
    /// The system's, if no thread can be started.
    pub(super) fn start(repaint: impl Fn() + Send + Clone + 'static) -> std::io::Result<Self> {
        Ok(Self {
            worker: Worker::start(repaint)?,
            sent: None,
            is_broken: false,
        })
    }

    /// Takes the results that have arrived.
    pub(super) fn receive(&mut self, services: &mut Services) {
        for event in self.worker.events() {
            match event {
                WorkerEvent::Snapshot(snapshot) => {
                    services.state.refusal = None;
                    services.state.snapshot = Some(snapshot);
                }
                WorkerEvent::Refused(error) => services.state.refusal = Some(refusal(&error)),
                WorkerEvent::Stopped(error) => {
                    services.state.paused = true;
                    services.state.refusal = Some(refusal(&error));
                    services.notice(true, format!("Live run paused: {error}"));
                }
                WorkerEvent::Broken(text) => {
                    self.is_broken = true;
                    services.notice(
                        true,
                        format!(
                            "Internal error in the simulator: {text}. Undo the last change to continue"
                        ),
                    );
                }
            }
        }
    }

    /// Sends what is to be shown, if that has changed.
    pub(super) fn request(&mut self, services: &mut Services) {
        let Some(request) = self.next_request(services) else {
            return;
        };
        let state = &mut services.state;
        if self.sent.as_ref() != Some(&request) {
            self.is_broken = false;
            self.worker.send(request.clone());
            self.sent = Some(request);
        } else if state.refusal.as_ref().is_some_and(|r| {
            // The values are good again and already shown.
            r.parameter != "drive"
                && (state.snapshot.as_ref())
                    .is_some_and(|shown| self.sent.as_ref().is_some_and(|s| s.model == shown.model))
        }) {
            state.refusal = None;
        }
    }

    /// The request for the present state. A drive or a device that cannot be simulated
    /// gives none, and is shown as refused.
    fn next_request(&self, services: &mut Services) -> Option<SimulationRequest> {
        let state = &mut services.state;
        let drive = match services.recorded_drive.resolve(&state.setup) {
            Ok(drive) => drive,
            Err(message) => {
                state.refusal = Some(Refusal {
                    parameter: "drive".to_owned(),
                    message,
                });
                return None;
            }
        };
        let preview = state.fitting.preview();
        let device = preview.as_ref().unwrap_or(&state.setup.preset.model);
        if let Err(error) = device.check() {
            state.refusal = Some(Refusal {
                parameter: error.parameter,
                message: error.reason,
            });
            return None;
        }
        let same_model = self
            .sent
            .as_ref()
            .filter(|sent| *sent.model == *device)
            .map(|sent| Arc::clone(&sent.model));
        let pictures = &state.view.pictures;
        Some(SimulationRequest {
            model: same_model.unwrap_or_else(|| Arc::new(device.clone())),
            drive,
            duration: state.setup.duration,
            forces: pictures.contains(&Picture::Forces) || pictures.contains(&Picture::Device),
            overlays: state.setup.overlays.clone(),
            mode: state.view.mode,
            from_steady: state.view.from_steady && state.view.mode == Mode::WholeSpan,
            slow_down: state.view.slow_down,
            paused: state.paused,
            scrub: state.scrub,
            restarts: services.restarts,
            steps: services.steps,
        })
    }
}

/// Another device is shown at its own usual live speed.
pub(super) fn set_usual_speed(services: &mut Services) {
    let setup = &services.state.setup;
    if services.speed_set_for != setup.preset.model.name {
        let name = &setup.preset.model.name;
        services.speed_set_for.clone_from(name);
        services.state.view.slow_down = usual_speed(setup);
    }
}

/// A simulator's error, at the parameter that it names.
fn refusal(error: &SimError) -> Refusal {
    Refusal {
        parameter: error.parameter().unwrap_or_default().to_owned(),
        message: error.to_string(),
    }
}
