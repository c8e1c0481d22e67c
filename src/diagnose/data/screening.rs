//! Screening before anything is computed: whether the recordings can be used at all, and which of
//! their samples must not be believed.

use std::sync::Arc;

use crate::diagnose::findings::Remark;
use crate::diagnose::options::DiagnoseError;
use crate::diagnose::thresholds::{SATURATION_MIN_RUN, SHORT_RECORDING_SAMPLES};
use crate::fit::inspect::preconditions::check;
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::inspect::same_device::check_ring_frequency;
use crate::fit::{FitError, FitOptions, Part};
use crate::model::Model;
use crate::recording::{Channel, Recording};

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
    let mut unclip = |parts: &[Part]| -> Vec<Part> {
        parts
            .iter()
            .map(|p| without_clipped_samples(p, &mut remarks))
            .collect()
    };
    let (train, mut held_out) = (unclip(train), unclip(held_out));
    let options = FitOptions::for_model(model);
    let mut may_name = true;
    for part in train.iter().chain(&held_out) {
        let one = std::slice::from_ref(part);
        match check(model, one, &summarize(model, one), &options) {
            Ok(()) | Err(FitError::NoContact { .. } | FitError::IrrelevantParameter { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    let all: Vec<Part> = train.iter().chain(&held_out).cloned().collect();
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
    Ok(ScreenedRecordings {
        train,
        held_out,
        remarks,
        may_name,
    })
}

/// The part without samples at the end of the sensor's range.
fn without_clipped_samples(part: &Part, remarks: &mut Vec<Remark>) -> Part {
    let r = &part.recording;
    let mut clean: Option<Recording> = None;
    for channel in [Channel::ProofMass, Channel::Cantilever] {
        let Some(values) = r.channel(channel) else {
            continue;
        };
        let clipped = clipped_samples(values);
        if clipped.is_empty() {
            continue;
        }
        remarks.push(Remark::ClippedSamples {
            recording: r.name.clone(),
            channel: channel.symbol(),
            clipped: clipped.len(),
            samples: values.len(),
        });
        let copy = clean.get_or_insert_with(|| (**r).clone());
        let target = match channel {
            Channel::Cantilever => copy.cantilever.as_mut(),
            _ => Some(&mut copy.proof_mass),
        };
        if let Some(target) = target {
            for i in clipped {
                target[i] = f64::NAN;
            }
        }
    }
    match clean {
        Some(clean) => Part {
            recording: Arc::new(clean),
            samples: part.samples.clone(),
        },
        None => part.clone(),
    }
}

/// Samples in runs at the exact highest or lowest value. A mass at rest on the ground gives such
/// runs too; they are no clipping unless everything else is noisy.
fn clipped_samples(values: &[f64]) -> Vec<usize> {
    let finite = values.iter().copied().filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    let mut equal = 0usize;
    let mut pairs = 0usize;
    for pair in values.windows(2) {
        if pair[0].is_finite() && pair[0] != high && pair[0] != low {
            pairs += 1;
            equal += usize::from(pair[0] == pair[1]);
        }
    }
    // Where neighbours are equal everywhere, the reading is noiseless or coarse, and equal
    // extremes mean nothing.
    if pairs == 0 || equal as f64 > 0.05 * pairs as f64 {
        return Vec::new();
    }
    let mut out = Vec::new();
    for extreme in [low, high] {
        let mut start = 0;
        while start < values.len() {
            let run = values[start..]
                .iter()
                .take_while(|v| **v == extreme)
                .count();
            if run >= SATURATION_MIN_RUN {
                out.extend(start..start + run);
            }
            start += run.max(1);
        }
    }
    out
}
