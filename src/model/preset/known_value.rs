//! What is known of a parameter beforehand: a value with its standard error.

use serde::{Deserialize, Serialize};

use crate::model::parameter::{ParameterId, ParameterSpec};
use crate::model::unit::format_quantity;
use crate::model::{Model, ModelError};

/// A parameter that is known beforehand within an error. A fit moves it against that knowledge: the
/// prior is Gaussian in the value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KnownValue {
    /// Id, `Cs` or `effect.parameter`.
    pub id: String,
    /// The value \[SI\].
    pub value: f64,
    /// Its standard error \[SI\], above 0.
    pub std_error: f64,
}

impl KnownValue {
    /// Of a parameter of `model`, checked. A parameter of an effect may be named without it where only one
    /// active effect has such a one.
    ///
    /// # Errors
    /// [`ModelError`] for an unknown id, one of the instrument, a value that is not allowed, or an
    /// error that is not above 0.
    ///
    /// # Examples
    /// ```
    /// use impactscope::model::preset::Preset;
    /// use impactscope::model::preset::known_value::KnownValue;
    ///
    /// let faller = Preset::load("faller")?.model;
    /// assert_eq!(KnownValue::new(&faller, "g", (9.81, 0.05))?.id, "gravity.g");
    /// assert!(KnownValue::new(&faller, "g", (9.81, 0.0)).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        model: &Model,
        id: &str,
        (value, std_error): (f64, f64),
    ) -> Result<Self, ModelError> {
        let (id, spec) = device_parameter(model, id)?;
        if let Some(reason) = spec.refusal(value) {
            return Err(ModelError::new(id, reason));
        }
        if !(std_error > 0.0 && std_error.is_finite()) {
            let reason = format!(
                "the error of a known value must be a number above 0, not {std_error}; to hold the parameter, fix it"
            );
            return Err(ModelError::new(id, reason));
        }
        Ok(Self {
            id,
            value,
            std_error,
        })
    }

    /// The value with its error, `9.81 m/s^2 +- 0.05 m/s^2`.
    pub fn text(&self, unit: &str) -> String {
        with_error(self.value, self.std_error, unit)
    }
}

/// A value with its error as text.
pub fn with_error(value: f64, std_error: f64, unit: &str) -> String {
    format!(
        "{} +- {}",
        format_quantity(value, unit, 4),
        format_quantity(std_error, unit, 2)
    )
}

/// The canonical id and the table row of a parameter of the device or of an active effect. A parameter
/// of an effect may be named without it where only one active effect has such a one.
///
/// # Errors
/// [`ModelError`] with the ids there are.
pub fn device_parameter(model: &Model, id: &str) -> Result<(String, ParameterSpec), ModelError> {
    use crate::model::parameter::ParameterId as P;
    if let Some(parameter) = ParameterId::from_id(id) {
        let spec = *parameter.spec();
        if matches!(
            parameter,
            P::OffsetP | P::OffsetC | P::Noise | P::X0 | P::V0
        ) {
            let reason = "it belongs to the recording, and is estimated for each".to_owned();
            return Err(ModelError::new(spec.id, reason));
        }
        if !model.uses(parameter) {
            let reason = format!("it has no effect on the device {}", model.name);
            return Err(ModelError::new(spec.id, reason));
        }
        return Ok((spec.id.to_owned(), spec));
    }
    let own = model.effects.iter().flat_map(|active| {
        let all = active.spec.parameters.iter();
        all.map(move |spec| (format!("{}.{}", active.spec.id, spec.id), spec))
    });
    let mut fitting = own.filter(|(whole, spec)| whole == id || spec.id == id);
    match (fitting.next(), fitting.next()) {
        (Some((whole, spec)), None) => Ok((whole, *spec)),
        (Some((a, _)), Some((b, _))) => {
            let reason = format!("several effects have it; write {a} or {b}");
            Err(ModelError::new(id, reason))
        }
        (None, _) => {
            let reason = format!(
                "there is no such parameter; there are {}",
                device_ids(model).join(", ")
            );
            Err(ModelError::new(id, reason))
        }
    }
}

/// Ids of the parameters of the device and of its active effects, without those of a recording.
pub fn device_ids(model: &Model) -> Vec<String> {
    use crate::model::parameter::ParameterId as P;
    let of_device = |p: &ParameterId| {
        model.uses(*p) && !matches!(p, P::OffsetP | P::OffsetC | P::Noise | P::X0 | P::V0)
    };
    let own = ParameterId::ALL.iter().filter(|p| of_device(p));
    let mut all: Vec<String> = own.map(|p| p.spec().id.to_owned()).collect();
    all.extend(model.effect_ids());
    all
}

#[cfg(test)]
mod tests {
    use super::super::known_value::*;
    use crate::model::effects::{ActiveEffect, find};
    use crate::model::preset::Preset;

    #[test]
    fn faults_of_known_values_name_the_parameter() {
        let mut model = Preset::embedded("faller").unwrap().model;
        let refused = |model: &Model, id: &str, value: (f64, f64)| {
            KnownValue::new(model, id, value).unwrap_err().to_string()
        };
        for (id, value, part) in [
            ("gg", (1.0, 0.1), "there are f1, gravity.g"),
            ("g", (9.81, 0.0), "above 0"),
            ("g", (9.81, -1.0), "above 0"),
            ("g", (9.81, f64::NAN), "above 0"),
            ("gravity.g", (1e9, 1.0), "is above"),
            ("x0", (0.1, 0.1), "belongs to the recording"),
            ("Cs", (1e-21, 1e-22), "no effect on the device faller"),
        ] {
            let said = refused(&model, id, value);
            assert!(said.contains(part), "{id}: {said}");
        }
        // The gap of the electrodes is called g, too.
        let other = ActiveEffect::new(find("electrostatic").unwrap());
        model.effects.push(other);
        let said = refused(&model, "g", (9.81, 0.05));
        assert!(
            said.contains("write gravity.g or electrostatic.g"),
            "{said}"
        );
        let known = KnownValue::new(&model, "gravity.g", (9.81, 0.05)).unwrap();
        assert_eq!(known.text("m/s^2"), "9.81 m/s^2 +- 0.05 m/s^2");
    }
}
