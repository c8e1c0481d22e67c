//! Trials on one clock, their mean and how they spread.

use std::sync::Arc;

use super::error::CombineError;
use super::interpolate::at_instants;
use super::misfit::Laid;
use super::spread::TrialSpread;
use crate::recording::{Channel, Recording};

/// Names of files in the name of an average.
const MAX_NAMES: usize = 6;
/// Fewest samples that all trials have in common.
const MIN_COMMON_SAMPLES: usize = 16;

/// The trials that are used, at the samples of the reference at which all of them are.
#[derive(Debug)]
pub(super) struct Stack {
    /// Indices of the trials.
    pub members: Vec<usize>,
    /// Samples of the reference.
    range: std::ops::Range<usize>,
    /// Readings by channel and member; `None` for a channel that a member lacks.
    values: [Option<Vec<Vec<f64>>>; 3],
}

/// The mean of the trials.
#[derive(Debug)]
pub(super) struct Mean {
    channels: [Option<Vec<f64>>; 3],
    spread: TrialSpread,
    /// How far the zero of each member's proof mass lies above that of the mean \[m\].
    pub zeros: Vec<f64>,
    /// Root mean square of what each member differs beyond that \[m\].
    pub rms: Vec<f64>,
}

/// One channel of it.
struct ChannelMean {
    mean: Vec<f64>,
    /// Deviation between the trials as they are averaged, and with one zero.
    deviations: Vec<f64>,
    around_zero: Vec<f64>,
    zeros: Vec<f64>,
    rms: Vec<f64>,
}

impl Stack {
    /// # Errors
    /// [`CombineError::NoOverlap`].
    pub fn new(reference: &Recording, laid: &[Laid]) -> Result<Self, CombineError> {
        let used = || laid.iter().enumerate().filter(|(_, trial)| trial.is_used);
        let lag = |trial: &Laid| trial.overlay.as_ref().map_or(0.0, |o| o.lag);
        let slack = 1e-6 * reference.interval();
        let (mut from, mut to) = (0, reference.len());
        for (_, trial) in used() {
            let (first, last) = trial.recording.span();
            let (first, last) = (first + lag(trial) - slack, last + lag(trial) + slack);
            from = from.max(reference.time.partition_point(|t| *t < first));
            to = to.min(reference.time.partition_point(|t| *t <= last));
            if to.saturating_sub(from) < MIN_COMMON_SAMPLES {
                return Err(CombineError::NoOverlap {
                    name: trial.recording.name.clone().into(),
                    reference: reference.name.clone().into(),
                });
            }
        }
        let range = from..to;
        let time = reference.time.get(range.clone()).unwrap_or_default();
        let values = Channel::ALL.map(|channel| {
            let of = |(_, trial): (usize, &Laid)| {
                let (first, last) = trial.recording.span();
                let instants: Vec<f64> = time
                    .iter()
                    .map(|t| (t - lag(trial)).clamp(first, last))
                    .collect();
                at_instants(trial.recording, channel, &instants)
            };
            used().map(of).collect::<Option<Vec<Vec<f64>>>>()
        });
        Ok(Self {
            members: used().map(|(i, _)| i).collect(),
            range,
            values,
        })
    }

    /// The proof mass of each member.
    pub fn motions(&self) -> Vec<&[f64]> {
        let values = self.values[Channel::ProofMass as usize].as_ref();
        let all = values.into_iter().flatten();
        all.map(Vec::as_slice).collect()
    }

    /// The mean; with `match_zeros` of displacements whose zeros are those of the first.
    pub fn mean(&self, match_zeros: bool) -> Mean {
        let found = Channel::ALL.map(|channel| {
            let values = self.values[channel as usize].as_ref()?;
            let matched = match_zeros && channel != Channel::Voltage;
            Some(ChannelMean::of(values, matched))
        });
        let motion = found[Channel::ProofMass as usize].as_ref();
        let zeros = motion.map_or_else(Vec::new, |m| m.zeros.clone());
        let rms = motion.map_or_else(Vec::new, |m| m.rms.clone());
        let mut channels = [None, None, None];
        let mut deviations = [None, None, None];
        let mut around_zero = [None, None, None];
        for (i, own) in found.into_iter().enumerate() {
            if let Some(own) = own {
                channels[i] = Some(own.mean);
                deviations[i] = Some(own.deviations);
                around_zero[i] = Some(own.around_zero);
            }
        }
        let spread = TrialSpread::new(self.members.len(), deviations, &around_zero);
        Mean {
            channels,
            spread,
            zeros,
            rms,
        }
    }

    /// The recording of the mean.
    ///
    /// # Errors
    /// [`CombineError::NoOverlap`] if it would have too few samples.
    pub fn recording(
        &self,
        reference: &Recording,
        laid: &[Laid],
        mean: &Mean,
    ) -> Result<Recording, CombineError> {
        let names: Vec<&str> = self
            .members
            .iter()
            .filter_map(|i| laid.get(*i))
            .map(|trial| trial.recording.name.as_str())
            .collect();
        let time = reference.time.get(self.range.clone()).unwrap_or_default();
        let [voltage, proof_mass, cantilever] = mean.channels.clone();
        let made = Recording::new(
            format!("average of {}", listed(&names)),
            time.to_vec(),
            voltage,
            proof_mass.unwrap_or_default(),
            cantilever,
        );
        let mut recording = made.map_err(|_| CombineError::NoOverlap {
            name: names.last().copied().unwrap_or_default().into(),
            reference: reference.name.clone().into(),
        })?;
        recording.origin = reference.origin.clone();
        recording.drive_source = reference.drive_source.clone();
        recording.instrument = reference.instrument;
        recording.spread = Some(Arc::new(mean.spread.clone()));
        Ok(recording)
    }
}

/// Names in a row; those of the trials of one file with the file's name once.
fn listed(names: &[&str]) -> String {
    let mut distinct: Vec<&str> = names.to_vec();
    distinct.dedup();
    if let [only] = distinct.as_slice() {
        return format!("{} trials of {only}", names.len());
    }
    let mut shown: Vec<&str> = distinct.iter().take(MAX_NAMES).copied().collect();
    if distinct.len() > MAX_NAMES {
        shown.push("...");
    }
    shown.join(", ")
}

impl ChannelMean {
    /// Of `values` by member, each of the same length.
    fn of(values: &[Vec<f64>], match_zeros: bool) -> Self {
        let n = values.len();
        let first = values.first().map_or(&[][..], Vec::as_slice);
        let rows = first.len();
        let above_first = |own: &Vec<f64>| {
            let pairs = own.iter().zip(first).map(|(x, f)| x - f);
            mean_of(pairs.filter(|d| d.is_finite()))
        };
        let above: Vec<f64> = values.iter().map(above_first).collect();
        let zero = if match_zeros {
            0.0
        } else {
            above.iter().sum::<f64>() / n.max(1) as f64
        };
        let zeros: Vec<f64> = above.iter().map(|z| z - zero).collect();
        let mut mean = Vec::with_capacity(rows);
        let mut deviations = Vec::with_capacity(rows);
        let mut around_zero = Vec::with_capacity(rows);
        let (mut squares, mut counts) = (vec![0.0; n], vec![0usize; n]);
        let mut own = Vec::with_capacity(n);
        for row in 0..rows {
            own.clear();
            let readings = values.iter().zip(&zeros).enumerate();
            own.extend(readings.filter_map(|(k, (x, zero))| {
                let x = x.get(row).copied().filter(|x| x.is_finite())?;
                Some((k, x - zero, *zero))
            }));
            // Of fewer it is the reading of some trials rather than their mean.
            if own.len() < 2 || 2 * own.len() <= n {
                mean.push(f64::NAN);
                deviations.push(f64::NAN);
                around_zero.push(f64::NAN);
                continue;
            }
            let centre = mean_of(own.iter().map(|(_, y, _)| *y));
            let freedom = (own.len() - 1) as f64;
            let sum: f64 = own.iter().map(|(_, y, _)| (y - centre).powi(2)).sum();
            let with_zeros = |(_, y, zero): &(usize, f64, f64)| y + zero;
            let centre_as_is = mean_of(own.iter().map(with_zeros));
            let sum_as_is: f64 = own
                .iter()
                .map(|one| (with_zeros(one) - centre_as_is).powi(2))
                .sum();
            for (k, y, _) in &own {
                squares[*k] += (y - centre).powi(2);
                counts[*k] += 1;
            }
            mean.push(centre);
            around_zero.push((sum / freedom).sqrt());
            let kept = if match_zeros { sum } else { sum_as_is };
            deviations.push((kept / freedom).sqrt());
        }
        let rms = squares.iter().zip(&counts);
        let rms = rms.map(|(s, c)| (s / (*c).max(1) as f64).sqrt()).collect();
        Self {
            mean,
            deviations,
            around_zero,
            zeros,
            rms,
        }
    }
}

fn mean_of(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, n), v| (sum + v, n + 1));
    sum / count.max(1) as f64
}
