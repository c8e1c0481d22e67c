//! Screening before anything is computed: whether the recordings can be used at all, and what is wrong with
//! their readings. Samples that are no readings of the device are missing in a [`Part`] already.

use std::sync::Arc;

use super::rest_level::from_rest;
use crate::diagnose::findings::Remark;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::thresholds::SHORT_RECORDING_SAMPLES;
use crate::fit::inspect::connections::check_connections;
use crate::fit::inspect::motion::{check_motion, sampling_doubts};
use crate::fit::inspect::preconditions::{check, or_connections};
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::inspect::same_device::check_ring_frequency;
use crate::fit::{FitError, FitOptions, Part};
use crate::model::Model;
use crate::recording::Recording;

/// Recordings fit to be diagnosed.
#[derive(Debug, Clone)]
pub struct ScreenedRecordings {
    /// To fit.
    pub train: Vec<Part>,
    /// Held-out recordings.
    pub held_out: Vec<Part>,
    /// What limits the answer, and what was done.
    pub remarks: Vec<Remark>,
    /// Whether an effect may be named at all.
    pub may_name: bool,
}

/// Checks recordings before a diagnosis.
///
/// # Errors
/// [`DiagnoseError`] where no answer is possible.
pub fn screen(
    model: &Model,
    train: &[Part],
    held_out: &[Part],
) -> Result<ScreenedRecordings, DiagnoseError> {
    if train.is_empty() {
        return Err(DiagnoseError::NoRecording);
    }
    let mut remarks = Vec::new();
    let (train, mut held_out) = (train.to_vec(), held_out.to_vec());
    remarks.extend(faults_of(train.iter().chain(&held_out)));
    check_motion(&train)?;
    let options = FitOptions::for_model(model);
    let mut may_name = true;
    for part in train.iter().chain(&held_out) {
        let one = std::slice::from_ref(part);
        match check(model, one, &summarize(model, one), &options) {
            Ok(()) | Err(FitError::NoContact { .. } | FitError::IrrelevantParameter { .. }) => {}
            Err(error) => or_connections(Err(error), model, &train)?,
        }
    }
    check_connections(model, &train)?;
    let all: Vec<Part> = train.iter().chain(&held_out).cloned().collect();
    let seldom = sampling_doubts(model, &all).into_iter();
    remarks.extend(seldom.map(|said| Remark::CoarseSampling { said }));
    let findings = summarize(model, &all);
    let of_one = check(model, &all, &findings, &options)
        .and_then(|()| check_ring_frequency(model, &all, &findings).map(|_| ()));
    match of_one {
        Err(FitError::NoContact { reason, .. }) if model.has_ground => {
            remarks.push(Remark::NoContact { reason })
        }
        Err(error @ FitError::DifferentDevices { .. }) => {
            may_name = false;
            let error = error.to_string();
            remarks.push(Remark::DifferentDevices { error });
        }
        _ => {}
    }
    let samples: usize = train.iter().map(|p| p.samples.len()).sum();
    if samples < SHORT_RECORDING_SAMPLES {
        remarks.push(Remark::FewSamples(samples));
    }
    if train.iter().all(|p| p.recording.cantilever.is_none()) && model.has_cantilever {
        remarks.push(Remark::ProofMassOnly);
    }
    if train.len() == 1 && model.piezo.is_some() {
        remarks.push(Remark::SingleExcitation);
    }
    // Held-out recordings of other points of the device would test another device.
    let lone = |p: &Part| p.recording.cantilever.is_none();
    if train.iter().all(lone) != held_out.iter().all(lone) && !held_out.is_empty() {
        let with_both = held_out.len();
        held_out.retain(|p| lone(p) == train.iter().all(lone));
        remarks.push(Remark::HeldOutReadOtherPoints(with_both - held_out.len()));
    }
    let counted = |parts: Vec<Part>| parts.iter().map(|p| from_rest(model, p)).collect();
    Ok(ScreenedRecordings {
        train: counted(train),
        held_out: counted(held_out),
        remarks,
        may_name,
    })
}

/// What is wrong with the readings of the recordings, each once: a recording may be on both sides.
fn faults_of<'a>(parts: impl Iterator<Item = &'a Part>) -> Vec<Remark> {
    let mut seen: Vec<&Arc<Recording>> = Vec::new();
    let mut out = Vec::new();
    for part in parts {
        let r = &part.recording;
        if seen.iter().any(|known| Arc::ptr_eq(known, r)) {
            continue;
        }
        seen.push(r);
        let faults = r.instrument_faults().faults.iter().cloned();
        out.extend(faults.map(|fault| Remark::InstrumentFault {
            recording: r.name.clone(),
            fault,
        }));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::screening::*;
    use crate::diagnose::report::sentences;
    use crate::diagnose::test_support::parts_of;
    use crate::model::preset::Preset;

    #[test]
    fn faults_and_seldom_samples_are_remarks_and_nothing_read_is_an_error() {
        let model = Preset::embedded("paper").unwrap().model;
        let drives = [("square:15Hz:8V", 0.2)];
        let made = parts_of(&model, &drives, 50e3, 20e-9).remove(0);
        let mut r = (*made.recording).clone();
        r.proof_mass[2500] += 5e-6;
        let (train, held_out) = Part::split(Arc::new(r));
        let screened = screen(&model, &[train], &[held_out]).unwrap();
        let said = sentences::remarks(&screened.remarks);
        let spikes = said.iter().filter(|text| text.contains("1 spike in xp"));
        assert_eq!(spikes.count(), 1, "{said:?}");
        let seldom = parts_of(&model, &drives, 10e3, 20e-9);
        let said = sentences::remarks(&screen(&model, &seldom, &[]).unwrap().remarks);
        assert!(said.iter().any(|text| text.contains("mode 2")), "{said:?}");
        let still = parts_of(&model, &[("rest", 0.1)], 50e3, 20e-9);
        let error = screen(&model, &still, &[]).unwrap_err().to_string();
        assert!(error.contains("nothing but noise"), "{error}");
    }
}
