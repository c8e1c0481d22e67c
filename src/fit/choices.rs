//! What a person decides about the parameters before a fit or a diagnosis: which are free, which are
//! held and at which value, and which are known within an error.

use serde::{Deserialize, Serialize};

use super::error::FitError;
use crate::model::preset::Preset;
use crate::model::preset::known_value::{KnownValue, device_parameter};
use crate::model::{Model, ModelError};

/// A parameter that is held.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FixedParameter {
    /// Id, `Cs` or `effect.parameter`.
    pub id: String,
    /// At which value \[SI\]; `None` for that of the model.
    pub value: Option<f64>,
}

/// Which parameters are free, held, or known. The default decides nothing.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ParameterChoices {
    /// Ids of the free ones in place of the usual ones; may be empty.
    pub free: Option<Vec<String>>,
    /// Ids that are free besides the usual or listed ones.
    pub also_free: Vec<String>,
    /// Those that are held.
    pub fixed: Vec<FixedParameter>,
    /// Those that are known. They are free against that knowledge.
    pub known: Vec<KnownValue>,
}

impl ParameterChoices {
    /// The choices with ids as the model has them, and what the preset knows added: of parameters
    /// that are not known otherwise, not held, and not left out of a list of free ones.
    ///
    /// # Errors
    /// [`FitError`] for an unknown id, a value that is not allowed, or a parameter that is to be
    /// both held and free or known.
    ///
    /// # Examples
    /// ```
    /// use impactscope::fit::ParameterChoices;
    /// use impactscope::model::preset::Preset;
    ///
    /// let faller = Preset::load("faller")?;
    /// let usual = ParameterChoices::default().resolve(&faller)?;
    /// assert_eq!(usual.known[0].id, "gravity.g");
    /// let none = ParameterChoices { free: Some(Vec::new()), ..ParameterChoices::default() };
    /// assert!(none.resolve(&faller)?.known.is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn resolve(&self, preset: &Preset) -> Result<Self, FitError> {
        let mut all = self.of(&preset.model)?;
        for known in &preset.known {
            let is_listed = |ids: &Vec<String>| ids.contains(&known.id);
            let may_move = all.free.as_ref().is_none_or(is_listed);
            let is_known = all.known.iter().any(|own| own.id == known.id);
            // An effect of the preset may be off.
            let is_there = device_parameter(&preset.model, &known.id).is_ok();
            if may_move && is_there && !is_known && !all.is_fixed(&known.id) {
                all.known.push(known.clone());
            }
        }
        Ok(all)
    }

    /// The choices checked, with ids as `model` has them.
    ///
    /// # Errors
    /// Those of [`Self::resolve`].
    pub fn of(&self, model: &Model) -> Result<Self, FitError> {
        let find = |id: &str| device_parameter(model, id).map_err(refused);
        let canonical = |id: &str| Ok::<_, FitError>(find(id)?.0);
        let free = self.free.as_ref().map(|ids| {
            let each = ids.iter().map(|id| canonical(id));
            each.collect::<Result<Vec<_>, _>>()
        });
        let free = free.transpose()?;
        let more = self.also_free.iter().map(|id| canonical(id));
        let also_free = more.collect::<Result<Vec<_>, _>>()?;
        let mut fixed = Vec::new();
        for one in &self.fixed {
            let (id, spec) = find(&one.id)?;
            if let Some(reason) = one.value.and_then(|value| spec.refusal(value)) {
                return Err(FitError::Choice { id, reason });
            }
            let value = one.value;
            fixed.push(FixedParameter { id, value });
        }
        let known = self.known.iter().map(|known| {
            let value = (known.value, known.std_error);
            KnownValue::new(model, &known.id, value).map_err(refused)
        });
        let all = Self {
            free,
            also_free,
            fixed,
            known: known.collect::<Result<_, _>>()?,
        };
        all.check_agreement()?;
        Ok(all)
    }

    /// Refuses a parameter that is chosen twice.
    fn check_agreement(&self) -> Result<(), FitError> {
        let twice = |id: &String, what: &str| {
            Err(FitError::Choice {
                id: id.clone(),
                reason: format!("it is {what}; choose one"),
            })
        };
        for (i, one) in self.fixed.iter().enumerate() {
            let id = &one.id;
            let mut freed = self.free.iter().flatten().chain(&self.also_free);
            if freed.any(|free| free == id) {
                return twice(id, "both held and free");
            }
            if self.known.iter().any(|known| known.id == *id) {
                return twice(id, "both held and known within an error");
            }
            if self.fixed[..i].iter().any(|other| other.id == *id) {
                return twice(id, "held twice");
            }
        }
        for (i, one) in self.known.iter().enumerate() {
            if self.known[..i].iter().any(|other| other.id == one.id) {
                return twice(&one.id, "known twice");
            }
        }
        Ok(())
    }

    /// Whether a parameter is held by name.
    pub fn is_fixed(&self, id: &str) -> bool {
        self.fixed.iter().any(|one| one.id == id)
    }

    /// Whether a fit may give a parameter another value, as far as that was decided.
    pub fn may_change(&self, id: &str) -> bool {
        let listed = |free: &Vec<String>| free.iter().any(|own| own == id);
        let is_known = self.known.iter().any(|known| known.id == id);
        let is_named = is_known || listed(&self.also_free);
        !self.is_fixed(id) && (is_named || self.free.as_ref().is_none_or(listed))
    }

    /// The model to start from: held parameters at their values, known ones at theirs.
    ///
    /// # Errors
    /// [`FitError`] if the model makes no sense with them.
    pub fn start(&self, model: &Model) -> Result<Model, FitError> {
        let mut start = model.clone();
        let fixed = self.fixed.iter();
        let fixed = fixed.filter_map(|one| Some((&one.id, one.value?)));
        let known = self.known.iter().map(|known| (&known.id, known.value));
        for (id, value) in fixed.chain(known) {
            start.set(id, value)?;
        }
        start.check()?;
        Ok(start)
    }

    /// Ids of the free parameters, where `usual` ones are free if nothing is decided.
    pub fn free_ids(&self, usual: Vec<String>) -> Vec<String> {
        let mut ids = self.free.clone().unwrap_or(usual);
        let known = self.known.iter().map(|known| &known.id);
        for id in self.also_free.iter().chain(known) {
            if !ids.contains(id) {
                ids.push(id.clone());
            }
        }
        ids.retain(|id| !self.is_fixed(id));
        ids
    }
}

/// A choice that the model refuses.
fn refused(error: ModelError) -> FitError {
    FitError::Choice {
        id: error.parameter,
        reason: error.reason,
    }
}

#[cfg(test)]
mod tests {
    use super::super::choices::*;

    fn fixed(id: &str, value: Option<f64>) -> FixedParameter {
        let id = id.to_owned();
        FixedParameter { id, value }
    }

    fn known(id: &str, value: f64, std_error: f64) -> KnownValue {
        KnownValue {
            id: id.to_owned(),
            value,
            std_error,
        }
    }

    #[test]
    fn held_free_and_known_parameters_are_told_apart() {
        let preset = Preset::embedded("faller").unwrap();
        let asked = ParameterChoices {
            fixed: vec![fixed("g", Some(1.62))],
            ..ParameterChoices::default()
        };
        let all = asked.resolve(&preset).unwrap();
        // What the preset knows gives way to what is held.
        assert!(all.known.is_empty() && all.is_fixed("gravity.g"));
        assert!(!all.may_change("gravity.g"));
        assert_eq!(
            all.start(&preset.model).unwrap().get("gravity.g"),
            Some(1.62)
        );
        assert!(all.free_ids(vec!["gravity.g".to_owned()]).is_empty());
        let moon = ParameterChoices {
            known: vec![known("g", 1.62, 0.01)],
            ..ParameterChoices::default()
        };
        let moon = moon.resolve(&preset).unwrap();
        assert_eq!(moon.known, [known("gravity.g", 1.62, 0.01)]);
        assert_eq!(moon.free_ids(Vec::new()), ["gravity.g"]);
        let more = ParameterChoices {
            also_free: vec!["f1".to_owned()],
            ..ParameterChoices::default()
        };
        let more = more.resolve(&preset).unwrap();
        assert_eq!(
            more.free_ids(vec!["zeta1".to_owned()]),
            ["zeta1", "f1", "gravity.g"]
        );
        assert_eq!(
            moon.start(&preset.model).unwrap().get("gravity.g"),
            Some(1.62)
        );
    }

    #[test]
    fn what_is_known_of_an_effect_that_is_off_does_not_count() {
        let mut preset = Preset::embedded("faller").unwrap();
        preset.model.effects.clear();
        let all = ParameterChoices::default().resolve(&preset).unwrap();
        assert!(all.known.is_empty());
        // The text of such a preset can still be read.
        let again = Preset::parse("again", &preset.to_toml()).unwrap();
        assert!(again.known.is_empty() && again.model == preset.model);
    }

    #[test]
    fn faults_of_choices_name_the_parameter_and_the_remedy() {
        let preset = Preset::default();
        let said = |choices: ParameterChoices| choices.resolve(&preset).unwrap_err().to_string();
        let (cs, none) = (fixed("Cs", None), ParameterChoices::default());
        let free = Some(vec!["cs".to_owned()]);
        let cases = [
            (
                ParameterChoices {
                    free,
                    fixed: vec![cs.clone()],
                    ..none.clone()
                },
                "both held and free",
            ),
            (
                ParameterChoices {
                    fixed: vec![cs.clone()],
                    known: vec![known("Cs", 2e-21, 1e-22)],
                    ..none.clone()
                },
                "both held and known",
            ),
            (
                ParameterChoices {
                    fixed: vec![cs.clone(), cs],
                    ..none.clone()
                },
                "held twice",
            ),
            (
                ParameterChoices {
                    fixed: vec![fixed("alpha", Some(1.5))],
                    ..none.clone()
                },
                "above 1",
            ),
            (
                ParameterChoices {
                    free: Some(vec!["Css".to_owned()]),
                    ..none.clone()
                },
                "there are Cs, gp",
            ),
            (
                ParameterChoices {
                    known: vec![known("Cs", 2e-21, 0.0)],
                    ..none.clone()
                },
                "above 0",
            ),
        ];
        for (choices, part) in cases {
            let text = said(choices);
            assert!(text.contains(part), "{text}");
        }
        // A value that makes no sense with the others.
        let inside = ParameterChoices {
            fixed: vec![fixed("gp", Some(50e-6))],
            ..none
        };
        let resolved = inside.resolve(&preset).unwrap();
        let text = resolved.start(&preset.model).unwrap_err().to_string();
        assert!(text.contains("must exceed dp"), "{text}");
    }
}
