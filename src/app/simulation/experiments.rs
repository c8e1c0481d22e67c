//! Each visible recording as an experiment of its own: simulated under its own drive and compared
//! with that run.

use std::sync::Arc;

use rayon::prelude::*;

use super::min_max_pyramid::Pyramid;
use super::snapshot::{OverlayComparison, OwnRun};
use crate::app::setup::drive_choice::OwnDrive;
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::fit::FreeNuisances;
use crate::fit::experiment::{Experiment, ExperimentResult, InstrumentPriors};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::recording::Recording;
use crate::sim::Trace;

/// Standard deviation of the scale of a reading around 1, where it is estimated.
const SCALE_SIGMA: f64 = 0.01;

/// The simulation that recordings without a drive of their own are compared with.
#[derive(Debug, Clone, Copy)]
pub struct SharedRun<'a> {
    /// Its device.
    pub model: &'a Model,
    /// Its drive.
    pub drive: &'a Waveform,
    /// Its run.
    pub trace: &'a Arc<Trace>,
}

/// The runs of the recordings as they were last simulated. A change of what belongs to the
/// instrument alone needs no new one.
#[derive(Debug, Default)]
pub struct ExperimentCache {
    model: Option<Arc<Model>>,
    runs: Vec<(OverlayId, Waveform, Arc<Trace>)>,
}

impl ExperimentCache {
    /// Compares every visible recording with its own run of `model`, several at once; `None` if
    /// `go_on` said no.
    pub fn compare(
        &mut self,
        model: &Arc<Model>,
        shared: SharedRun<'_>,
        overlays: &[Overlay],
        go_on: impl Fn() -> bool + Sync,
    ) -> Option<Vec<OverlayComparison>> {
        if self.model.as_ref() != Some(model) {
            self.runs.clear();
            self.model = Some(Arc::clone(model));
        }
        let visible: Vec<&Overlay> = overlays.iter().filter(|o| o.visible).collect();
        let runs = &self.runs;
        let compared: Vec<Option<OverlayComparison>> = visible
            .par_iter()
            .map(|overlay| {
                let known = |drive: &Waveform| {
                    let same = |(id, of, _): &&(OverlayId, Waveform, Arc<Trace>)| {
                        *id == overlay.id && of == drive
                    };
                    runs.iter().find(same).map(|(_, _, run)| Arc::clone(run))
                };
                compare_one(shared, overlay, known, &go_on)
            })
            .collect();
        let compared: Vec<OverlayComparison> = compared.into_iter().collect::<Option<_>>()?;
        self.runs = compared
            .iter()
            .filter_map(|c| {
                let own = c.own.as_ref()?;
                Some((c.id, own.drive.clone(), Arc::clone(&own.trace)))
            })
            .collect();
        Some(compared)
    }
}

/// Compares every visible recording, once.
pub fn compare_all(
    model: &Arc<Model>,
    drive: &Waveform,
    trace: &Arc<Trace>,
    overlays: &[Overlay],
) -> Vec<OverlayComparison> {
    let shared = SharedRun {
        model,
        drive,
        trace,
    };
    let compared = ExperimentCache::default().compare(model, shared, overlays, || true);
    compared.unwrap_or_default()
}

/// What drives a recording's own run, and in words; `None` if it has none of its own.
///
/// # Errors
/// Why its voltage is no drive.
pub fn own_drive(
    model: &Model,
    overlay: &Overlay,
) -> Result<Option<(Waveform, f64, String)>, String> {
    if model.piezo.is_none() {
        return Ok(None);
    }
    let recording: &Recording = &overlay.recording;
    let (first, _) = recording.span();
    match &overlay.drive {
        OwnDrive::Shared => Ok(None),
        OwnDrive::Chosen(waveform) => Ok(Some((waveform.clone(), 0.0, waveform.to_string()))),
        OwnDrive::Measured(reading) => match recording.drive(*reading) {
            None => Ok(None),
            Some(drive) => {
                let drive = drive.map_err(|error| error.to_string())?;
                let waveform = drive.waveform(&recording.name, -first);
                Ok(Some((waveform, drive.reach(), drive.text.clone())))
            }
        },
    }
}

/// The experiment of a recording under `drive`, whose instants are known to `reach` \[s\].
pub fn experiment_of(overlay: &Overlay, drive: Waveform, reach: f64) -> Experiment {
    let estimates = overlay.estimates;
    let nuisances = FreeNuisances::default();
    let any = estimates.zeros || estimates.clock || estimates.scales;
    let recording = Arc::clone(&overlay.recording);
    let mut experiment = Experiment::new(recording, drive, overlay.alignment);
    experiment.priors = any.then_some(InstrumentPriors {
        zeros: estimates.zeros,
        clock: nuisances.skew.filter(|_| estimates.clock),
        scale: estimates.scales.then_some(SCALE_SIGMA),
        drive_reach: if estimates.clock { reach } else { 0.0 },
    });
    experiment
}

fn compare_one(
    shared: SharedRun<'_>,
    overlay: &Overlay,
    known: impl Fn(&Waveform) -> Option<Arc<Trace>>,
    go_on: &(impl Fn() -> bool + Sync),
) -> Option<OverlayComparison> {
    let own = match own_drive(shared.model, overlay) {
        Ok(own) => own,
        Err(error) => return Some(failed(overlay, error)),
    };
    let Some((drive, reach, text)) = own else {
        let experiment = experiment_of(overlay, shared.drive.clone(), 0.0);
        let result = experiment.compare(Arc::clone(shared.trace));
        return Some(finished(overlay, &experiment, result, None));
    };
    let experiment = experiment_of(overlay, drive, reach);
    let result = match known(&experiment.drive) {
        Some(trace) => experiment.compare(trace),
        None => match experiment.run(shared.model, go_on) {
            Ok(None) => return None,
            Ok(Some(result)) => Ok(result),
            Err(error) => Err(error),
        },
    };
    Some(finished(overlay, &experiment, result, Some(text)))
}

fn failed(overlay: &Overlay, error: String) -> OverlayComparison {
    OverlayComparison {
        id: overlay.id,
        comparison: Err(error),
        residual_pyramid: None,
        features: None,
        alignment: overlay.alignment,
        noise: None,
        drive_text: None,
        own: None,
    }
}

fn finished(
    overlay: &Overlay,
    experiment: &Experiment,
    result: Result<ExperimentResult, impl ToString>,
    drive_text: Option<String>,
) -> OverlayComparison {
    let result = match result {
        Ok(result) => result,
        Err(error) => return failed(overlay, error.to_string()),
    };
    let recording = &overlay.recording;
    let alignment = result.alignment;
    let compared = &result.proof_mass;
    let range = compared.first..compared.first + compared.residual.len();
    let times: Vec<f64> = recording.time[range]
        .iter()
        .map(|&t| alignment.time(t))
        .collect();
    let noise = experiment.noise.0 * alignment.xp_scale.abs();
    OverlayComparison {
        id: overlay.id,
        residual_pyramid: Some(Arc::new(Pyramid::xy(&times, &compared.residual))),
        features: None,
        alignment,
        noise: (noise > 0.0).then_some(noise),
        own: drive_text
            .is_some()
            .then(|| OwnRun::new(experiment.drive.clone(), &result.trace)),
        drive_text,
        comparison: Ok(Arc::new(result.proof_mass)),
    }
}
