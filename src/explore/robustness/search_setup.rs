//! What a search for a robust waveform is asked for.

use super::ensemble::Ensemble;
use super::error::RobustnessError;
use super::wish::Wish;
use crate::explore::map::MapRequest;
use crate::explore::waveform::{self, DriveLimits};
use crate::model::Model;
use crate::model::drive::Waveform;

/// Fewest waveforms of a generation: each is moved by differences of three others.
const SMALLEST_POPULATION: usize = 6;
/// Most steady states of one generation.
const MOST_STATES_OF_GENERATION: usize = 10_000_000;

/// A number of the drive that is searched.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchedNumber {
    /// Id of [`waveform::parameters`], such as `amplitude` or `h3`.
    pub id: String,
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
}

/// A search for the waveform that keeps a wish with the highest probability.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveformSearch {
    /// The device.
    pub model: Model,
    /// The drive from which it starts; what is not searched stays as it is here.
    pub drive: Waveform,
    /// Numbers that are searched.
    pub numbers: Vec<SearchedNumber>,
    /// What is wanted.
    pub wish: Wish,
    /// What the drive must not exceed.
    pub limits: DriveLimits,
    /// The devices for which it shall hold.
    pub ensemble: Ensemble,
    /// Waveforms of a generation.
    pub population: usize,
    /// Generations.
    pub generations: usize,
    /// Seed of the search.
    pub seed: u64,
    /// How many different waveforms are returned at most.
    pub kept: usize,
    /// Start, options and bounds of each steady state, and measures whose quantiles are returned; its
    /// axes do not count.
    pub point: MapRequest,
}

impl WaveformSearch {
    /// With usual sizes: 24 waveforms, 20 generations, three returned.
    #[must_use]
    pub fn new(
        (model, drive): (Model, Waveform),
        numbers: Vec<SearchedNumber>,
        wish: Wish,
        ensemble: Ensemble,
    ) -> Self {
        let measures = wish.bounds.iter().map(|bound| bound.measure).collect();
        Self {
            point: MapRequest::new(model.clone(), drive.clone(), Vec::new(), measures),
            model,
            drive,
            numbers,
            wish,
            limits: DriveLimits::default(),
            ensemble,
            population: 24,
            generations: 20,
            seed: 0,
            kept: 3,
        }
    }

    /// Checks it.
    ///
    /// # Errors
    /// [`RobustnessError`].
    pub fn check(&self) -> Result<(), RobustnessError> {
        self.ensemble.check(&self.model)?;
        self.wish.check()?;
        let refuse = |reason: String| Err(RobustnessError::Search(reason));
        if self.population < SMALLEST_POPULATION || self.generations == 0 || self.kept == 0 {
            return refuse(format!(
                "a population of {}, {} generations and {} returned make no search; give at least {SMALLEST_POPULATION}, 1 and 1",
                self.population, self.generations, self.kept
            ));
        }
        let states = self.population.saturating_mul(self.ensemble.members);
        if states > MOST_STATES_OF_GENERATION {
            return refuse(format!(
                "{states} steady states a generation are more than {MOST_STATES_OF_GENERATION}; take fewer members or a smaller population"
            ));
        }
        if self.numbers.is_empty() {
            return refuse("no number of the drive is searched; name at least one".to_owned());
        }
        let known = waveform::parameters(&self.drive);
        for (k, number) in self.numbers.iter().enumerate() {
            let id = &number.id;
            if !known.iter().any(|own| own.id == *id) {
                let ids: Vec<&str> = known.iter().map(|own| own.id.as_str()).collect();
                return refuse(format!(
                    "the drive {} has no \"{id}\"; it has {}",
                    self.drive,
                    if ids.is_empty() {
                        "no number that could vary".to_owned()
                    } else {
                        ids.join(", ")
                    }
                ));
            }
            if self.numbers[..k].iter().any(|own| own.id == *id) {
                return refuse(format!("{id} is named twice; name it once"));
            }
            if !(number.low < number.high && number.low.is_finite() && number.high.is_finite()) {
                return refuse(format!(
                    "{id} from {} to {} is an empty range; give a lower and a higher bound",
                    number.low, number.high
                ));
            }
        }
        Ok(())
    }

    /// The drive with values of the searched numbers, in their order.
    ///
    /// # Errors
    /// Why it is impossible.
    pub fn drive_with(&self, values: &[f64]) -> Result<Waveform, String> {
        let mut own = self.numbers.iter().zip(values);
        let set = own.try_fold(self.drive.clone(), |drive, (number, value)| {
            waveform::set(&drive, &number.id, *value)
        });
        set.map_err(|error| error.to_string())
    }

    /// Present values of the searched numbers, within their bounds.
    pub(super) fn start(&self) -> Vec<f64> {
        let own = self.numbers.iter();
        own.map(|number| {
            let value = waveform::get(&self.drive, &number.id);
            value
                .unwrap_or(0.5 * (number.low + number.high))
                .clamp(number.low, number.high)
        })
        .collect()
    }

    /// By how much a drive exceeds the limits: shares of them, and 1 for each step under a limit of
    /// slew.
    pub(super) fn excess(&self, drive: &Waveform) -> f64 {
        let Ok(places) = waveform::excesses(drive, &self.limits) else {
            return f64::INFINITY;
        };
        let own = places.iter().map(|place| {
            let limit = match place.kind {
                waveform::ExcessKind::Voltage => self.limits.voltage,
                waveform::ExcessKind::Slew => self.limits.slew,
            };
            let over = place.value / limit.unwrap_or(f64::INFINITY) - 1.0;
            if over.is_finite() { over.max(0.0) } else { 1.0 }
        });
        own.sum()
    }
}
