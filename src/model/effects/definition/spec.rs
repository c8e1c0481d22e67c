//! What an effect is: one [`EffectSpec`] for each file of the catalogue.

use std::fmt;

use super::action::{Action, Inert, Surroundings};
use super::facts::{ContactLaw, EvidenceFigure, Facts};
use super::search::{FoundBy, Search};
use crate::model::parameter::ParameterSpec;

/// What an effect is, what is known of it, how a fit finds it and where it shows. A file of the
/// catalogue states what is its own and takes the rest from [`EffectSpec::DEFAULT`].
pub struct EffectSpec {
    /// Fixed id, as typed on the command line.
    pub id: &'static str,
    /// The term of the field.
    pub name: &'static str,
    /// One plain sentence for the window.
    pub sentence: &'static str,
    /// Its law, as written in the window.
    pub law: &'static str,
    /// Where the law is from.
    pub source: &'static str,
    /// What a device must have for it to do anything.
    pub needs: Need,
    /// Its parameters, with defaults and ranges.
    pub parameters: &'static [ParameterSpec],
    /// Builds the action for values in the order of `parameters`.
    pub build: fn(&[f64], &Surroundings<'_>) -> Box<dyn Action>,
    /// Properties of its law.
    pub facts: Facts,
    /// How a fit finds it and refines its law.
    pub search: Search,
    /// The picture in which it shows best.
    pub figure: EvidenceFigure,
}

impl EffectSpec {
    /// An effect without a name, without parameters and without an action: the values of all
    /// that an effect does not state.
    pub const DEFAULT: Self = Self {
        id: "",
        name: "",
        sentence: "",
        law: "",
        source: "",
        needs: Need::Nothing,
        parameters: &[],
        build: |_, _| Box::new(Inert),
        facts: Facts::DEFAULT,
        search: Search::DEFAULT,
        figure: EvidenceFigure::Time,
    };

    /// The law of the ground that it changes, if it changes one.
    pub fn contact_law(&self) -> Option<ContactLaw> {
        match self.search.found_by {
            FoundBy::ContactEvents(law) => Some(law),
            _ => None,
        }
    }

    /// Whether it adds vibration modes, of which each has an initial state of its own in every
    /// segment that is fitted.
    pub fn adds_modes(&self) -> bool {
        self.facts.modes.is_some()
    }

    /// Whether it is a step of the ground's level, which leaves the flight unchanged.
    pub fn is_level_step(&self) -> bool {
        matches!(self.search.found_by, FoundBy::StepTime)
    }

    /// Whether it is a steady sinusoidal vibration of the base.
    pub fn is_base_sinusoid(&self) -> bool {
        matches!(self.search.found_by, FoundBy::Frequency)
    }
}

/// What a device must have for an effect to do anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// Any device will do.
    Nothing,
    /// A ground: contact, adhesion or a film over it.
    Ground,
    /// A drive.
    Drive,
}

impl fmt::Debug for EffectSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "EffectSpec({})", self.id)
    }
}

impl PartialEq for EffectSpec {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// An effect with values for its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct ActiveEffect {
    /// Which effect.
    pub spec: &'static EffectSpec,
    /// Values in the order of `spec.parameters`, SI.
    pub values: Vec<f64>,
}

impl ActiveEffect {
    /// The effect at its defaults.
    pub fn new(spec: &'static EffectSpec) -> Self {
        Self {
            spec,
            values: spec.parameters.iter().map(|p| p.default).collect(),
        }
    }

    /// Sets a parameter by id; false if the effect has none of that id.
    pub fn set(&mut self, id: &str, value: f64) -> bool {
        let place = self.spec.parameters.iter().position(|p| p.id == id);
        if let Some(i) = place {
            self.values[i] = value;
        }
        place.is_some()
    }

    /// Whether parameter number `i` bears on anything while the others are as they are: a
    /// further mode that has no shape is none, nor is an element of creep without a share, and
    /// a fit that moved it would change what there is to fit.
    pub fn bears(&self, i: usize) -> bool {
        (self.spec.facts.is_felt)(&self.values, i)
    }

    /// Whether moving parameter number `i` alone can change anything.
    pub fn is_moved_by(&self, i: usize) -> bool {
        let mut moved = self.clone();
        if moved.values[i] == 0.0 {
            moved.values[i] = 1.0;
        }
        moved.bears(i)
    }
}

/// Ids of some parameters of an effect, as `effect.parameter`.
pub fn own_ids(spec: &EffectSpec, which: &[usize]) -> Vec<String> {
    let name = |&i: &usize| format!("{}.{}", spec.id, spec.parameters[i].id);
    which.iter().map(name).collect()
}
