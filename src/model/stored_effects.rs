//! Active effects in a file: their ids with their values in the order of the catalogue's
//! parameters.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::effects::{ActiveEffect, find};

#[derive(Serialize, Deserialize)]
struct Entry {
    id: String,
    values: Vec<f64>,
}

/// Writes effects.
///
/// # Errors
/// Those of the writer.
pub fn serialize<S: Serializer>(effects: &[ActiveEffect], writer: S) -> Result<S::Ok, S::Error> {
    writer.collect_seq(effects.iter().map(|effect| Entry {
        id: effect.spec.id.to_owned(),
        values: effect.values.clone(),
    }))
}

/// Reads effects.
///
/// # Errors
/// Those of the reader, and an effect that the catalogue has not, or not with so many values. An
/// effect that has got parameters since has their defaults.
pub fn deserialize<'de, D: Deserializer<'de>>(reader: D) -> Result<Vec<ActiveEffect>, D::Error> {
    let effect = |Entry { id, values }: Entry| {
        let spec =
            find(&id).ok_or_else(|| D::Error::custom("an effect is not in the catalogue"))?;
        if values.len() > spec.parameters.len() || values.is_empty() {
            let text = format!("{id} has {} values", values.len());
            return Err(D::Error::custom(text));
        }
        let mut effect = ActiveEffect::new(spec);
        effect.values[..values.len()].copy_from_slice(&values);
        Ok(effect)
    };
    let entries = Vec::<Entry>::deserialize(reader)?;
    entries.into_iter().map(effect).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Model;
    use super::super::effects::{ActiveEffect, CATALOGUE};

    #[test]
    fn an_effect_stored_with_fewer_parameters_has_the_defaults_of_the_others() {
        let longest = CATALOGUE.iter().max_by_key(|e| e.parameters.len());
        let spec = *longest.unwrap();
        let mut model = Model::default();
        model.effects.push(ActiveEffect::new(spec));
        model.effects[0].values[0] = 0.5 * spec.parameters[0].default;
        let stored = serde_json::to_value(&model).unwrap();
        let with = |values: serde_json::Value| {
            let mut stored = stored.clone();
            stored["effects"][0]["values"] = values;
            serde_json::from_value::<Model>(stored)
        };
        let first = model.effects[0].values[0];
        assert_eq!(with(serde_json::json!([first])).unwrap(), model);
        assert!(with(serde_json::json!([])).is_err());
        let more = vec![0.1; spec.parameters.len() + 1];
        assert!(with(serde_json::json!(more)).is_err());
    }
}
