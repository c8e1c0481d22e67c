//! The keys that a preset may have, to find one that is misspelt.

const TOP_KEYS: &[&str] = &[
    "format",
    "name",
    "about",
    "start",
    "device",
    "piezo",
    "parameters",
    "ranges",
    "known",
    "effects",
    "mode",
];
const START_KEYS: &[&str] = &["drive", "duration"];
const DEVICE_KEYS: &[&str] = &[
    "proof_mass",
    "ground",
    "cantilever",
    "coordinate",
    "bounce",
    "stick_speed",
    "adhesion_reach",
];
const PIEZO_KEYS: &[&str] = &["gain", "rising", "falling"];
const MODE_KEYS: &[&str] = &[
    "frequency",
    "zeta",
    "phi_c",
    "phi_p",
    "phi_drive",
    "mass",
    "stiffness",
];

/// Section, which of that name, key, and the keys known there.
type Unknown = (String, usize, String, &'static [&'static str]);

/// The first key of a text that no preset has; none if the text is no TOML.
pub(super) fn unknown(text: &str) -> Option<Unknown> {
    let table: toml::Table = toml::from_str(text).ok()?;
    let stray = |table: &toml::Table, known: &'static [&'static str]| {
        let found = table.keys().find(|key| !known.contains(&key.as_str()));
        found.cloned()
    };
    for (section, known) in [
        ("start", START_KEYS),
        ("device", DEVICE_KEYS),
        ("piezo", PIEZO_KEYS),
    ] {
        let inner = table.get(section).and_then(toml::Value::as_table);
        if let Some(key) = inner.and_then(|inner| stray(inner, known)) {
            return Some((section.to_owned(), 0, key, known));
        }
    }
    let modes = table.get("mode").and_then(toml::Value::as_array);
    for (nth, mode) in modes.into_iter().flatten().enumerate() {
        if let Some(key) = mode.as_table().and_then(|mode| stray(mode, MODE_KEYS)) {
            return Some(("mode".to_owned(), nth, key, MODE_KEYS));
        }
    }
    let key = stray(&table, TOP_KEYS)?;
    // A stray section stands where its name does.
    let section = if table[&key].is_table() {
        key.clone()
    } else {
        String::new()
    };
    Some((section, 0, key, TOP_KEYS))
}
