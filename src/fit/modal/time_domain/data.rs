//! The recordings as stretches in which the device is free of the ground, and the input over them.

use std::sync::Arc;

use super::input::{Input, MOMENTS};
use crate::fit::inspect::recording_summary::summarize;
use crate::fit::modal::error::ModalError;
use crate::fit::modal::thresholds::CLEAR_OF_GROUND;
use crate::fit::options::Part;
use crate::model::Model;
use crate::model::film::SqueezeFilm;
use crate::model::parameter::ParameterId;
use crate::model::piezo::Piezo;
use crate::recording::Recording;
use crate::recording::measured_drive::MeasuredDrive;

/// Samples before and after a contact that are left out: the instant of the impact lies between two.
const CONTACT_MARGIN: usize = 2;

/// A run of samples without gap or contact.
#[derive(Debug, Clone)]
pub struct Stretch {
    /// Index of its recording.
    pub recording: usize,
    /// Time of the first sample \[s\].
    pub start: f64,
    /// Interval to the next sample \[s\], one fewer than samples.
    pub intervals: Intervals,
    /// Readings of the proof mass and of the cantilever, NaN where missing.
    pub readings: [Option<Vec<f64>>; 2],
    /// Moments of the input over each interval.
    pub moments: Vec<[f64; MOMENTS]>,
    /// Moments of the film's force over each interval \[N s\]; empty without a film.
    pub film: Vec<[f64; MOMENTS]>,
    /// The input at each sample.
    pub input: Vec<f64>,
}

/// Intervals between samples \[s\].
#[derive(Debug, Clone)]
pub enum Intervals {
    /// The same everywhere.
    Even(f64),
    /// One by one.
    Each(Vec<f64>),
}

impl Intervals {
    /// The interval after sample `i`.
    #[must_use]
    pub fn after(&self, i: usize) -> f64 {
        match self {
            Self::Even(h) => *h,
            Self::Each(all) => all.get(i).copied().unwrap_or(0.0),
        }
    }
}

impl Stretch {
    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.input.len()
    }
}

/// A recording with its drive.
#[derive(Debug, Clone)]
pub struct Source {
    /// The usable readings.
    pub recording: Arc<Recording>,
    /// What drove it.
    pub drive: Arc<MeasuredDrive>,
}

/// All data of an identification.
#[derive(Debug, Clone)]
pub struct Data {
    /// The recordings.
    pub sources: Vec<Source>,
    /// What of them is used.
    pub stretches: Vec<Stretch>,
    /// The drive's branches; `None` for the voltage itself.
    pub piezo: Option<Piezo>,
    /// By how much the readings lag behind the voltage \[s\].
    pub skew: f64,
    /// Samples left out because the mass touched the ground, or in between.
    pub left_out: usize,
    /// Samples in all.
    pub samples: usize,
    /// Median interval \[s\].
    pub interval: f64,
}

impl Data {
    /// Reads the recordings. `piezo` is the input's law; `None` for the voltage itself.
    ///
    /// # Errors
    /// [`ModalError`] if there is no recording, or one has no voltage.
    pub fn new(
        model: &Model,
        recordings: &[Arc<Recording>],
        piezo: Option<Piezo>,
    ) -> Result<Self, ModalError> {
        let mut sources = Vec::with_capacity(recordings.len());
        for recording in recordings {
            let usable = recording.usable();
            let drive = usable.own_drive().ok_or_else(|| ModalError::NoVoltage {
                recording: recording.name.clone(),
            })?;
            let drive = drive.map_err(|error| ModalError::Drive {
                recording: recording.name.clone(),
                reason: error.to_string(),
            })?;
            sources.push(Source {
                recording: usable,
                drive,
            });
        }
        let interval = sources
            .iter()
            .map(|s| s.recording.interval())
            .fold(f64::INFINITY, f64::min);
        if !interval.is_finite() {
            return Err(ModalError::NoRecording);
        }
        let mut data = Self {
            sources,
            stretches: Vec::new(),
            piezo,
            skew: 0.0,
            left_out: 0,
            samples: 0,
            interval,
        };
        data.cut(model);
        data.refresh_input();
        Ok(data)
    }

    /// Samples of the longest stretch.
    #[must_use]
    pub fn longest_stretch(&self) -> usize {
        let samples = self.stretches.iter().map(Stretch::samples);
        samples.max().unwrap_or(0)
    }

    /// Cuts the recordings at gaps and contacts.
    fn cut(&mut self, model: &Model) {
        for (index, source) in self.sources.iter().enumerate() {
            let recording = &source.recording;
            self.samples += recording.len();
            let banned = contacts(model, recording);
            self.left_out += banned.iter().filter(|b| **b).count();
            let mut from = 0;
            for i in 0..recording.len() {
                let ends = recording.is_gap(i) || banned.get(i + 1).copied().unwrap_or(true);
                if banned.get(i).copied().unwrap_or(true) {
                    from = i + 1;
                } else if ends {
                    self.stretches
                        .extend(stretch(index, recording, from, i + 1));
                    from = i + 1;
                }
            }
        }
    }

    /// Leaves out stretches shorter than `least` \[s\].
    pub fn drop_short(&mut self, least: f64) {
        let interval = self.interval;
        let mut dropped = 0;
        self.stretches.retain(|s| {
            let keep = s.samples() as f64 * interval >= least;
            dropped += if keep { 0 } else { s.samples() };
            keep
        });
        self.left_out += dropped;
    }

    /// The input over all stretches anew, after a change of the skew.
    pub fn refresh_input(&mut self) {
        for stretch in &mut self.stretches {
            let Some(source) = self.sources.get(stretch.recording) else {
                continue;
            };
            let input = Input {
                pieces: &source.drive.pieces,
                piezo: self.piezo,
                skew: self.skew,
            };
            let count = stretch.readings.iter().flatten().next().map_or(0, Vec::len);
            let mut piece = input.piece_at(stretch.start);
            let mut at = stretch.start;
            stretch.moments.clear();
            stretch.input.clear();
            for i in 0..count {
                let time = match &stretch.intervals {
                    Intervals::Even(h) => stretch.start + i as f64 * h,
                    Intervals::Each(_) => at,
                };
                stretch.input.push(input.at(time, &mut piece));
                if i + 1 < count {
                    let next = match &stretch.intervals {
                        Intervals::Even(h) => stretch.start + (i + 1) as f64 * h,
                        Intervals::Each(all) => at + all.get(i).copied().unwrap_or(0.0),
                    };
                    stretch.moments.push(input.moments(time, next, &mut piece));
                    at = next;
                }
            }
        }
    }

    /// The film's force over all stretches from the measured motion. `offset` is the reading at the
    /// zero position \[m\].
    pub fn refresh_film(&mut self, film: SqueezeFilm, offset: f64) {
        for stretch in &mut self.stretches {
            stretch.film = match &stretch.readings[0] {
                Some(xp) => film_moments(film, xp, offset, &stretch.intervals),
                None => Vec::new(),
            };
        }
    }
}

/// Whether the mass stays clear of the ground of `model` all along.
#[must_use]
pub fn stays_clear_of_ground(model: &Model, recording: &Recording) -> bool {
    let xp = recording.proof_mass.iter().copied();
    let lowest = xp.fold(f64::INFINITY, f64::min);
    !model.has_ground || lowest > -CLEAR_OF_GROUND * model.parameters[ParameterId::Dp]
}

/// Which samples are in contact, or next to it.
fn contacts(model: &Model, recording: &Arc<Recording>) -> Vec<bool> {
    let mut banned = vec![false; recording.len()];
    if stays_clear_of_ground(model, recording) {
        return banned;
    }
    let part = [Part::whole(Arc::clone(recording))];
    let Some(summary) = summarize(model, &part).into_iter().next() else {
        return banned;
    };
    let events = summary.events(recording);
    let spans = events.contacts.iter().map(|c| (c.start, c.end));
    for (start, end) in spans.chain(events.impacts.iter().map(|i| (i.time, i.time))) {
        let from = recording
            .time
            .partition_point(|&t| t < start)
            .saturating_sub(CONTACT_MARGIN);
        let to = recording.time.partition_point(|&t| t <= end) + CONTACT_MARGIN;
        let to = to.min(banned.len());
        if let Some(own) = banned.get_mut(from..to) {
            own.fill(true);
        }
    }
    banned
}

fn stretch(index: usize, recording: &Recording, from: usize, to: usize) -> Option<Stretch> {
    let time = recording.time.get(from..to).filter(|t| t.len() >= 8)?;
    let (first, last) = (*time.first()?, *time.last()?);
    let mean = (last - first) / (time.len() - 1) as f64;
    let is_even = time
        .windows(2)
        .all(|w| (w[1] - w[0] - mean).abs() <= 0.01 * mean)
        && time
            .iter()
            .enumerate()
            .all(|(i, t)| (t - first - i as f64 * mean).abs() <= 0.02 * mean);
    let intervals = if is_even {
        Intervals::Even(mean)
    } else {
        Intervals::Each(time.windows(2).map(|w| w[1] - w[0]).collect())
    };
    let cantilever = recording.cantilever.as_ref().and_then(|c| c.get(from..to));
    Some(Stretch {
        recording: index,
        start: first,
        intervals,
        readings: [
            Some(recording.proof_mass.get(from..to)?.to_vec()),
            cantilever.map(<[f64]>::to_vec),
        ],
        moments: Vec::new(),
        film: Vec::new(),
        input: Vec::new(),
    })
}

/// Moments of the film's force, a straight line between samples.
fn film_moments(
    film: SqueezeFilm,
    xp: &[f64],
    offset: f64,
    intervals: &Intervals,
) -> Vec<[f64; MOMENTS]> {
    let n = xp.len();
    let value = |i: usize| {
        xp.get(i.min(n.saturating_sub(1)))
            .copied()
            .unwrap_or(f64::NAN)
    };
    let force: Vec<f64> = (0..n)
        .map(|i| {
            let h = intervals.after(i.min(n.saturating_sub(2)));
            let speed = if i >= 2 && i + 2 < n {
                // Of fourth order; noise of 20 nm gives a force far below any other.
                (8.0 * (value(i + 1) - value(i - 1)) - (value(i + 2) - value(i - 2))) / (12.0 * h)
            } else {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(n.saturating_sub(1)));
                (value(b) - value(a)) / (h * (b - a).max(1) as f64)
            };
            let found = film.force(value(i) - offset, speed);
            if found.is_finite() { found } else { 0.0 }
        })
        .collect();
    force
        .windows(2)
        .enumerate()
        .map(|(i, pair)| {
            let h = intervals.after(i);
            let mut moments = [0.0; MOMENTS];
            moments[0] = 0.5 * h * (pair[0] + pair[1]);
            moments[1] = h * (pair[1] - pair[0]) / 6.0;
            moments
        })
        .collect()
}
