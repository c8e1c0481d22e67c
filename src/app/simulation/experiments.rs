//! Each visible recording as an experiment of its own: simulated under its own drive and compared
//! with that run.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::min_max_pyramid::Pyramid;
use super::snapshot::{OverlayComparison, OwnRun};
use crate::app::setup::overlay::{Overlay, OverlayId};
use crate::app::setup::own_drive::OwnDrive;
use crate::fit::FreeNuisances;
use crate::fit::experiment::{Experiment, ExperimentResult, InstrumentPriors, improve_drive};
use crate::model::Model;
use crate::model::drive::{DriveReading, Waveform};
use crate::recording::Recording;
use crate::recording::measured_drive::MeasuredDrive;
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

/// The runs of the recordings as they were last simulated, and what the readings decided of their
/// drives.
#[derive(Debug, Default)]
pub struct ExperimentCache {
    model: Option<Arc<Model>>,
    runs: Vec<(OverlayId, Waveform, Arc<Trace>)>,
    /// Values of the freedoms of each recording's measured drive, and how it is read.
    improved: HashMap<OverlayId, (DriveReading, Vec<f64>)>,
}

impl ExperimentCache {
    /// Compares every visible recording with its own run of `model`, several at once; `None` if
    /// `go_on` said no. A change of what belongs to the instrument alone needs no new run.
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
        let (runs, improved) = (&self.runs, &self.improved);
        let compared: Vec<Option<OverlayComparison>> = visible
            .par_iter()
            .map(|overlay| {
                let known = |drive: &Waveform| {
                    let same = |(id, of, _): &&(OverlayId, Waveform, Arc<Trace>)| {
                        *id == overlay.id && of == drive
                    };
                    runs.iter().find(same).map(|(_, _, run)| Arc::clone(run))
                };
                let values = improved.get(&overlay.id);
                compare_one(shared, overlay, values, known, &go_on)
            })
            .collect();
        let compared: Vec<OverlayComparison> = compared.into_iter().collect::<Option<_>>()?;
        self.keep(&compared);
        Some(compared)
    }

    /// Lets the readings decide what the voltages leave open, each recording for itself; `None` if
    /// `go_on` said no or nothing is open. Where a recording's misfit does not fall, it is not in the
    /// result.
    pub fn improve(
        &mut self,
        model: &Model,
        overlays: &[Overlay],
        compared: &[OverlayComparison],
        go_on: impl Fn() -> bool + Sync,
    ) -> Option<Vec<OverlayComparison>> {
        let open: Vec<(&Overlay, Arc<MeasuredDrive>, DriveReading)> = overlays
            .iter()
            .filter(|o| o.visible && o.estimates.clock && model.piezo.is_some())
            .filter_map(|overlay| {
                let OwnDrive::Measured(reading) = overlay.drive else {
                    return None;
                };
                let drive = overlay.recording.drive(reading)?.ok()?;
                (!drive.freedoms.is_empty()).then_some((overlay, drive, reading))
            })
            .collect();
        if open.is_empty() {
            return None;
        }
        let before = |id: OverlayId| {
            let own = compared.iter().find(|c| c.id == id)?;
            own.comparison.as_ref().ok().map(|c| c.rms)
        };
        let known = &self.improved;
        let better: Vec<Option<(DriveReading, Vec<f64>, OverlayComparison)>> = open
            .par_iter()
            .map(|(overlay, drive, reading)| {
                let start = known
                    .get(&overlay.id)
                    .filter(|(of, _)| of == reading)
                    .map_or(&[][..], |(_, values)| values);
                let experiment = experiment_of(overlay, Waveform::Rest, drive.reach());
                let improved = improve_drive(&experiment, drive, model, start, &go_on).ok()??;
                let rms = improved.result.proof_mass.rms;
                before(overlay.id).filter(|before| rms < *before)?;
                let text = Some(drive.text.clone());
                let own = &improved.experiment;
                let result = Ok::<_, String>(improved.result.clone());
                let comparison = finished(overlay, own, result, text);
                Some((*reading, improved.values, comparison))
            })
            .collect();
        let mut result = Vec::new();
        for (reading, values, comparison) in better.into_iter().flatten() {
            self.improved.insert(comparison.id, (reading, values));
            result.push(comparison);
        }
        self.keep(&result);
        (!result.is_empty()).then_some(result)
    }

    /// Keeps the runs of `compared` in place of older ones of the same recordings.
    fn keep(&mut self, compared: &[OverlayComparison]) {
        for c in compared {
            self.runs.retain(|(id, _, _)| *id != c.id);
            if let Some(own) = &c.own {
                self.runs
                    .push((c.id, own.drive.clone(), Arc::clone(&own.trace)));
            }
        }
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

/// What drives a recording's own run, by how much it may be shifted \[s\], and in words; `None` if it
/// has none of its own. `improved` are values of the freedoms of its measured drive.
///
/// # Errors
/// Why its voltage is no drive.
pub fn own_drive(
    model: &Model,
    overlay: &Overlay,
    improved: Option<&(DriveReading, Vec<f64>)>,
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
                let waveform = match improved {
                    Some((of, values)) if of == reading => {
                        drive.changed(values).waveform(&recording.name, -first)
                    }
                    _ => drive.waveform(&recording.name, -first),
                };
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

/// The experiment of a recording as it was compared last, under its own drive or else `shared`, that
/// of the simulation; `None` without either.
pub fn shown_experiment(
    overlay: &Overlay,
    compared: &OverlayComparison,
    shared: Option<&Waveform>,
) -> Option<Experiment> {
    match &compared.own {
        Some(own) => Some(experiment_of(overlay, own.drive.clone(), own.drive_reach)),
        None => Some(experiment_of(overlay, shared?.clone(), 0.0)),
    }
}

fn compare_one(
    shared: SharedRun<'_>,
    overlay: &Overlay,
    improved: Option<&(DriveReading, Vec<f64>)>,
    known: impl Fn(&Waveform) -> Option<Arc<Trace>>,
    go_on: &(impl Fn() -> bool + Sync),
) -> Option<OverlayComparison> {
    let own = match own_drive(shared.model, overlay, improved) {
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
        own: drive_text.is_some().then(|| {
            let reach = experiment.priors.map_or(0.0, |priors| priors.drive_reach);
            OwnRun::new(experiment.drive.clone(), &result.trace).known_to(reach)
        }),
        drive_text,
        comparison: Ok(Arc::new(result.proof_mass)),
    }
}
