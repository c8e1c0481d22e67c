//! The curve kept for comparison: kept, dropped, and computed again for a session that
//! has one.

use super::drive::recorded_drive;
use super::window::Shell;
use crate::app::files::event::FileEvent;
use crate::app::setup::drive_choice::DriveChoice;
use crate::app::setup::overlay::OverlayId;
use crate::app::setup::reference_curve::Kept;
use crate::app::simulation::snapshot::Snapshot;
use crate::app::state::State;
use crate::model::drive::Waveform;

/// Whether the curve of a session is being brought back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Return {
    /// Not asked for yet.
    #[default]
    Open,
    /// It was said that its recording is missing.
    Missing,
    /// It is being computed, or could not be.
    Asked,
}

impl Shell {
    /// Keeps the present curve, or drops the kept one.
    pub(in crate::app) fn toggle_kept(&mut self) {
        let had = self.state.ghost.is_some() || self.state.view.kept.is_some();
        self.state.ghost = None;
        self.state.view.kept = None;
        if let (false, Some(snapshot)) = (had, self.state.snapshot.clone()) {
            self.state.view.kept = self.origin(&snapshot);
            self.state.ghost = Some(snapshot);
        }
    }

    /// What a session needs to bring a curve back. A live run cannot be repeated, and a
    /// trial is no part of a session.
    fn origin(&self, snapshot: &Snapshot) -> Option<Kept> {
        let (drive, duration) = snapshot.run_of.clone()?;
        let State {
            setup, diagnosing, ..
        } = &self.state;
        if diagnosing.trial.sealed.is_some() {
            return None;
        }
        let mut preset = setup.preset.clone();
        preset.model = snapshot.model.as_ref().clone();
        let recorded = match (&setup.drive, &self.recorded) {
            (DriveChoice::Recorded(id), Some(((known, shift), Ok(made))))
                if id == known && *made == drive =>
            {
                Some((*id, *shift))
            }
            _ => None,
        };
        let (drive, shift) = match recorded {
            Some((id, shift)) => (DriveChoice::Recorded(id), shift),
            None => (DriveChoice::Waveform(drive), 0.0),
        };
        Some(Kept {
            preset,
            drive,
            shift,
            duration,
        })
    }

    /// Computes a session's kept curve once its recordings are read.
    pub(super) fn bring_back_kept(&mut self) {
        if self.state.ghost.is_some() || self.kept == Return::Asked {
            return;
        }
        let Some(kept) = self.state.view.kept.clone() else {
            return;
        };
        let drive = match &kept.drive {
            DriveChoice::Waveform(waveform) => Ok(waveform.clone()),
            DriveChoice::Recorded(id) => self.voltage_of(*id, kept.shift),
        };
        match drive {
            Ok(drive) => {
                self.kept = Return::Asked;
                let overlays = self.state.setup.overlays.clone();
                self.files
                    .work("computing", "the kept curve".into(), move |_| {
                        let run = kept.run(drive, &overlays);
                        Some(FileEvent::Kept {
                            kept: Box::new(kept),
                            run,
                        })
                    });
            }
            Err(reason) if self.kept == Return::Open => {
                self.kept = Return::Missing;
                self.notice(true, format!("The kept curve (A/B) is not shown: {reason}"));
            }
            Err(_) => {}
        }
    }

    fn voltage_of(&self, id: OverlayId, shift: f64) -> Result<Waveform, String> {
        let overlay = self.state.setup.overlays.iter().find(|o| o.id == id);
        match overlay {
            Some(overlay) => recorded_drive(overlay, shift),
            None => Err(
                "the recording that drove it is gone; load it again, or drop the curve with G"
                    .to_owned(),
            ),
        }
    }
}
