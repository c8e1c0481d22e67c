//! Each visible recording as an experiment of its own: simulated under its own drive and compared
//! with that run.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::min_max_pyramid::Pyramid;
use super::snapshot::{OverlayComparison, OwnRun};
use crate::app::setup::overlay::{Estimates, Overlay, OverlayId};
use crate::app::setup::own_drive::OwnDrive;
use crate::diagnose::data::noise_model::pool_noise;
use crate::fit::experiment::{Experiment, ExperimentResult, InstrumentPriors, Questions, decide};
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::recording::measured_drive::MeasuredDrive;
use crate::recording::{Channel, Recording};
use crate::sim::{StartState, Trace};

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

/// A run with what it depends on besides the device.
#[derive(Debug, Clone)]
struct KnownRun {
    of: OverlayId,
    drive: Waveform,
    start: Option<StartState>,
    trace: Arc<Trace>,
}

/// What a state of a device is a state of: number of modes, whether there is a ground, ids of effects.
type DeviceKind = (usize, bool, Vec<&'static str>);

fn kind_of(model: &Model) -> DeviceKind {
    let modes = model.structure_with_effects().modes.len();
    let effects = model.effects.iter().map(|e| e.spec.id);
    (modes, model.has_ground, effects.collect())
}

/// What the readings of a recording decided of its experiment.
#[derive(Debug, Clone)]
struct Decided {
    /// Drive and ticks that it was decided under.
    under: (OwnDrive, Estimates),
    /// What kind of device it was decided for.
    kind: DeviceKind,
    /// Values of the freedoms of the measured drive.
    drive: Vec<f64>,
    /// The state in which it begins; `None` for that of the device.
    start: Option<StartState>,
}

/// The runs of the recordings as they were last simulated, and what the readings decided of their
/// drives and starts.
#[derive(Debug, Default)]
pub struct ExperimentCache {
    model: Option<Arc<Model>>,
    runs: Vec<KnownRun>,
    decided: HashMap<OverlayId, Decided>,
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
        let (this, kind) = (&*self, kind_of(model));
        let noise = common_noise(overlays);
        let compared: Vec<Option<OverlayComparison>> = visible
            .par_iter()
            .map(|overlay| {
                let known = |experiment: &Experiment| {
                    let same = |run: &&KnownRun| {
                        run.of == overlay.id
                            && run.drive == experiment.drive
                            && run.start == experiment.start
                    };
                    this.runs
                        .iter()
                        .find(same)
                        .map(|run| Arc::clone(&run.trace))
                };
                let decided = this.decided_of(overlay, &kind);
                compare_one(
                    shared,
                    (overlay, noise_of(overlay, &noise)),
                    decided,
                    known,
                    &go_on,
                )
            })
            .collect();
        let compared: Vec<OverlayComparison> = compared.into_iter().collect::<Option<_>>()?;
        self.keep(&compared);
        Some(compared)
    }

    /// What was decided of a recording as it is set up now, for a device of this kind.
    fn decided_of(&self, overlay: &Overlay, kind: &DeviceKind) -> Option<&Decided> {
        let same = |d: &&Decided| {
            d.under.0 == overlay.drive && d.under.1 == overlay.estimates && d.kind == *kind
        };
        self.decided.get(&overlay.id).filter(same)
    }

    /// Lets the readings decide how each recording begins and what its voltage leaves open; `None`
    /// if `go_on` said no or nothing is open. Recordings of which nothing changes are not in the
    /// result.
    pub fn improve(
        &mut self,
        model: &Model,
        overlays: &[Overlay],
        compared: &[OverlayComparison],
        go_on: impl Fn() -> bool + Sync,
    ) -> Option<Vec<OverlayComparison>> {
        let visible: Vec<&Overlay> = overlays.iter().filter(|o| o.visible).collect();
        let (this, kind) = (&*self, kind_of(model));
        let noise = common_noise(overlays);
        let better: Vec<Option<(Decided, OverlayComparison)>> = visible
            .par_iter()
            .map(|overlay| {
                let before = compared.iter().find(|c| c.id == overlay.id)?;
                let decided = this.decided_of(overlay, &kind);
                let overlay = (*overlay, noise_of(overlay, &noise));
                improve_one(model, overlay, decided, before, &go_on)
            })
            .collect();
        let mut result = Vec::new();
        for (decided, comparison) in better.into_iter().flatten() {
            self.decided.insert(comparison.id, decided);
            result.push(comparison);
        }
        self.keep(&result);
        (!result.is_empty()).then_some(result)
    }

    /// Keeps the runs of `compared` in place of older ones of the same recordings.
    fn keep(&mut self, compared: &[OverlayComparison]) {
        for c in compared {
            self.runs.retain(|run| run.of != c.id);
            if let Some(own) = &c.own {
                self.runs.push(KnownRun {
                    of: c.id,
                    drive: own.drive.clone(),
                    start: own.start.clone(),
                    trace: Arc::clone(&own.trace),
                });
            }
        }
    }
}

/// Compares every visible recording, once.
#[cfg(test)]
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

/// The drive of a recording's own run.
struct OwnRunDrive {
    waveform: Waveform,
    /// The measured drive that it is of, if it is of one.
    measured: Option<Arc<MeasuredDrive>>,
    /// In words.
    text: String,
}

/// What drives a recording's own run; `None` if it has none of its own.
///
/// # Errors
/// Why its voltage is no drive.
fn own_drive(
    model: &Model,
    overlay: &Overlay,
    decided: Option<&Decided>,
) -> Result<Option<OwnRunDrive>, String> {
    let known = |waveform: Waveform, text: String| {
        let measured = None;
        Ok(Some(OwnRunDrive {
            waveform,
            measured,
            text,
        }))
    };
    if model.piezo.is_none() {
        // Only its start can be its own.
        let own = decided.is_some_and(|d| d.start.is_some());
        return if own {
            known(Waveform::Rest, "none".to_owned())
        } else {
            Ok(None)
        };
    }
    let recording: &Recording = &overlay.recording;
    let (first, _) = recording.span();
    match &overlay.drive {
        OwnDrive::Shared => Ok(None),
        OwnDrive::Chosen(waveform) => known(waveform.clone(), waveform.to_string()),
        OwnDrive::Measured(reading) => match recording.drive(*reading) {
            None => Ok(None),
            Some(drive) => {
                let drive = drive.map_err(|error| error.to_string())?;
                let values = decided.map_or(&[][..], |d| &d.drive);
                let own = if values.is_empty() {
                    None
                } else {
                    Some(drive.changed(values))
                };
                let waveform = own
                    .as_ref()
                    .unwrap_or(&drive)
                    .waveform(&recording.name, -first);
                Ok(Some(OwnRunDrive {
                    waveform,
                    text: drive.text.clone(),
                    measured: Some(drive),
                }))
            }
        },
    }
}

/// Noise of the readings of xp and xc \[m\].
type ReadingNoise = (f64, Option<f64>);

/// The noise of all recordings: one instrument has one, and quick motion passes for noise in a
/// recording alone. Synthetic recordings are of another instrument than a person's own.
fn common_noise(overlays: &[Overlay]) -> HashMap<OverlayId, ReadingNoise> {
    let mut all = HashMap::new();
    for made_up in [false, true] {
        let these: Vec<&Overlay> = overlays.iter().filter(|o| o.made_up == made_up).collect();
        let mut sigmas = [Channel::ProofMass, Channel::Cantilever].map(|channel| {
            let of = |o: &&Overlay| o.recording.noise(channel).map_or(f64::NAN, |n| n.sigma);
            these.iter().map(of).collect::<Vec<f64>>()
        });
        for channel in &mut sigmas {
            let counted = these.iter().map(|o| o.recording.len());
            let mut estimates: Vec<(usize, &mut f64)> = counted.zip(channel).collect();
            estimates.retain(|(_, sigma)| sigma.is_finite());
            pool_noise(&mut estimates);
        }
        let [xp, xc] = sigmas;
        for ((overlay, xp), xc) in these.iter().zip(xp).zip(xc) {
            let xp = if xp.is_finite() { xp } else { 0.0 };
            all.insert(overlay.id, (xp, xc.is_finite().then_some(xc)));
        }
    }
    all
}

fn noise_of(overlay: &Overlay, all: &HashMap<OverlayId, ReadingNoise>) -> ReadingNoise {
    all.get(&overlay.id).copied().unwrap_or_default()
}

/// The experiment of a recording under `drive`, whose instants are known to `reach` \[s\].
pub fn experiment_of(overlay: &Overlay, drive: Waveform, reach: f64) -> Experiment {
    let estimates = overlay.estimates;
    let unknown = estimates.unknowns(0.0);
    let any = estimates.zeros || estimates.clock || estimates.scales;
    let recording = Arc::clone(&overlay.recording);
    let mut experiment = Experiment::new(recording, drive, overlay.alignment);
    experiment.priors = any.then_some(InstrumentPriors {
        zeros: unknown.zeros,
        clock: unknown.clock,
        scale: unknown.scale,
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
    let mut experiment = match &compared.own {
        Some(own) => {
            let mut experiment = experiment_of(overlay, own.drive.clone(), own.drive_reach);
            experiment.start.clone_from(&own.start);
            experiment
        }
        None => experiment_of(overlay, shared?.clone(), 0.0),
    };
    if let Some(noise) = compared.noise {
        experiment.noise.0 = noise / compared.alignment.xp_scale.abs();
    }
    Some(experiment)
}

fn compare_one(
    shared: SharedRun<'_>,
    (overlay, noise): (&Overlay, ReadingNoise),
    decided: Option<&Decided>,
    known: impl Fn(&Experiment) -> Option<Arc<Trace>>,
    go_on: &(impl Fn() -> bool + Sync),
) -> Option<OverlayComparison> {
    let own = match own_drive(shared.model, overlay, decided) {
        Ok(own) => own,
        Err(error) => return Some(failed(overlay, error)),
    };
    let Some(own) = own else {
        let mut experiment = experiment_of(overlay, shared.drive.clone(), 0.0);
        experiment.noise = noise;
        let result = experiment.compare(Arc::clone(shared.trace));
        return Some(finished(overlay, &experiment, result, None));
    };
    let reach = own.measured.as_ref().map_or(0.0, |m| m.reach());
    let mut experiment = experiment_of(overlay, own.waveform, reach);
    experiment.noise = noise;
    experiment.start = decided.and_then(|d| d.start.clone());
    let result = match known(&experiment) {
        Some(trace) => experiment.compare(trace),
        None => match experiment.run(shared.model, go_on) {
            Ok(None) => return None,
            Ok(Some(result)) => Ok(result),
            Err(error) => Err(error),
        },
    };
    Some(finished(overlay, &experiment, result, Some(own.text)))
}

/// What the readings decide of one recording, and its comparison by that; `None` if nothing is open,
/// nothing changes for the better, or `go_on` said no.
fn improve_one(
    model: &Model,
    (overlay, noise): (&Overlay, ReadingNoise),
    decided: Option<&Decided>,
    before: &OverlayComparison,
    go_on: &(impl Fn() -> bool + Sync),
) -> Option<(Decided, OverlayComparison)> {
    let estimates = overlay.estimates;
    let own = own_drive(model, overlay, decided).ok()?;
    let own = match own {
        Some(own) => own,
        // Without a drive a start of its own makes the run its own.
        None if model.piezo.is_none() => OwnRunDrive {
            waveform: Waveform::Rest,
            measured: None,
            text: "none".to_owned(),
        },
        None => return None,
    };
    let reach = own.measured.as_ref().map_or(0.0, |m| m.reach());
    let measured = own
        .measured
        .filter(|m| estimates.clock && !m.freedoms.is_empty());
    if measured.is_none() && !estimates.start && decided.is_none() {
        return None;
    }
    let mut experiment = experiment_of(overlay, own.waveform, reach);
    experiment.noise = noise;
    let values = decided.map_or(&[][..], |d| &d.drive);
    let questions = Questions {
        drive: measured.as_deref().map(|m| (m, values)),
        start: estimates.start,
    };
    let found = decide(&experiment, questions, model, go_on).ok()??;
    let had_start = before.own.as_ref().is_some_and(|own| own.start.is_some());
    let old = before.comparison.as_ref().map_or(f64::INFINITY, |c| c.rms);
    let start = found.experiment.start.clone();
    // Without a drive and a start of its own it stays with the simulation's run.
    let is_shared = model.piezo.is_none() && start.is_none() && !had_start;
    if is_shared || (had_start == start.is_some() && found.result.proof_mass.rms >= old) {
        return None;
    }
    let result = Ok::<_, String>(found.result);
    let comparison = finished(overlay, &found.experiment, result, Some(own.text));
    let now = Decided {
        under: (overlay.drive.clone(), estimates),
        kind: kind_of(model),
        drive: found.drive,
        start,
    };
    Some((now, comparison))
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
        stretches: None,
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
        stretches: None,
        alignment,
        noise: (noise > 0.0).then_some(noise),
        own: drive_text.is_some().then(|| {
            let reach = experiment.priors.map_or(0.0, |priors| priors.drive_reach);
            let (drive, start) = (experiment.drive.clone(), experiment.start.clone());
            OwnRun::new(drive, start, &result.trace).known_to(reach)
        }),
        drive_text,
        comparison: Ok(Arc::new(result.proof_mass)),
    }
}
