//! The reference curve (A): set, discarded, and computed again for an opened session.

use crate::app::files::event::FileEvent;
use crate::app::services::{ReferenceCurveStage, Services};
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::app::setup::reference_curve::ReferenceCurve;
use crate::app::simulation::recorded_drive::recorded_drive;
use crate::app::simulation::reference_run;
use crate::app::simulation::snapshot::Snapshot;
use crate::app::state::State;
use crate::model::drive::Waveform;

/// Makes the present curve the reference, or discards the reference there is.
pub fn toggle(services: &mut Services) {
    let state = &mut services.state;
    let had = state.reference.is_some() || state.view.reference_curve.is_some();
    state.reference = None;
    state.view.reference_curve = None;
    if let (false, Some(snapshot)) = (had, services.state.snapshot.clone()) {
        services.state.view.reference_curve = origin(services, &snapshot);
        services.state.reference = Some(snapshot);
    }
}

/// What a session needs to compute the curve again. `None` for a live run, which cannot be
/// repeated, and for a sealed trial, which is no part of a session.
fn origin(services: &Services, snapshot: &Snapshot) -> Option<ReferenceCurve> {
    let (drive, duration) = snapshot.run_of.clone()?;
    let State {
        setup, diagnosing, ..
    } = &services.state;
    if diagnosing.trial.sealed.is_some() {
        return None;
    }
    let mut preset = setup.preset.clone();
    preset.model = snapshot.model.as_ref().clone();
    let recorded = match &setup.drive {
        DriveChoice::Recorded(id) => {
            let shift = services.recorded_drive.shift_of(*id, &drive);
            shift.map(|shift| (*id, shift))
        }
        DriveChoice::Waveform(_) => None,
    };
    let (drive, shift) = match recorded {
        Some((id, shift)) => (DriveChoice::Recorded(id), shift),
        None => (DriveChoice::Waveform(drive), 0.0),
    };
    Some(ReferenceCurve {
        preset,
        drive,
        shift,
        duration,
    })
}

/// Computes a session's reference curve once its recordings are read.
pub fn restore(services: &mut Services) {
    if services.state.reference.is_some()
        || services.reference_stage == ReferenceCurveStage::Requested
    {
        return;
    }
    let Some(curve) = services.state.view.reference_curve.clone() else {
        return;
    };
    let overlays = &services.state.setup.overlays;
    let drive = match &curve.drive {
        DriveChoice::Waveform(waveform) => Ok(waveform.clone()),
        DriveChoice::Recorded(id) => voltage_of(overlays, *id, curve.shift),
    };
    match drive {
        Ok(drive) => {
            services.reference_stage = ReferenceCurveStage::Requested;
            let overlays = overlays.clone();
            let name = "the reference curve".into();
            services.files.work("computing", name, move |_| {
                let run = reference_run::run(&curve, drive, &overlays);
                Some(FileEvent::ReferenceCurve {
                    curve: Box::new(curve),
                    run,
                })
            });
        }
        Err(reason) if services.reference_stage == ReferenceCurveStage::NotRequested => {
            services.reference_stage = ReferenceCurveStage::RecordingMissing;
            let text = format!("The reference curve (A) cannot be shown: {reason}");
            services.notice(true, text);
        }
        Err(_) => {}
    }
}

fn voltage_of(overlays: &[Overlay], id: OverlayId, shift: f64) -> Result<Waveform, String> {
    match overlays.iter().find(|o| o.id == id) {
        Some(overlay) => recorded_drive(overlay, shift),
        None => Err(
            "the recording that supplied its drive is missing; load it again, or discard the curve with G"
                .to_owned(),
        ),
    }
}
