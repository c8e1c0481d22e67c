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
/// Those of the reader, and an effect that the catalogue has not, or not with so many values.
pub fn deserialize<'de, D: Deserializer<'de>>(reader: D) -> Result<Vec<ActiveEffect>, D::Error> {
    let effect = |Entry { id, values }: Entry| {
        let spec =
            find(&id).ok_or_else(|| D::Error::custom("an effect is not in the catalogue"))?;
        if values.len() != spec.parameters.len() {
            let text = format!("{id} has {} values", values.len());
            return Err(D::Error::custom(text));
        }
        Ok(ActiveEffect { spec, values })
    };
    let entries = Vec::<Entry>::deserialize(reader)?;
    entries.into_iter().map(effect).collect()
}
