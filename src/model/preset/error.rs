//! What can be wrong with a preset, and the line of the file where it is.

use thiserror::Error;

use super::toml_fault::{short_key, short_reason};

/// A preset that cannot be used: file, line, key and reason.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PresetError {
    /// The file cannot be read.
    #[error(
        "{file}: {reason}; give one of the presets paper, paper-as-printed, oscillator, faller, bouncing-ball, or a preset file"
    )]
    Unreadable { file: String, reason: String },
    /// The text is no preset, or a value in it makes no sense.
    #[error("{file}, line {line}: {key}: {reason}")]
    Invalid {
        file: String,
        line: usize,
        key: String,
        reason: String,
    },
}

/// Text of a preset with the means to say where something in it stands.
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    /// Whether there is such a section.
    pub(super) fn has_section(&self, section: &str) -> bool {
        let head = format!("[{section}]");
        self.text.lines().any(|line| line.trim().starts_with(&head))
    }

    /// Line of `key = ...` inside `[section]` (the `nth` of that name, from 0), or of
    /// the section, or 1.
    fn line(&self, section: &str, nth: usize, key: &str) -> usize {
        let mut current = String::new();
        let mut seen = 0;
        let mut fallback = 1;
        for (i, line) in self.text.lines().enumerate() {
            let line = line.trim();
            if line.starts_with('[') {
                current = line
                    .trim_start_matches('[')
                    .split(']')
                    .next()
                    .unwrap_or_default()
                    .trim()
                    .to_owned();
                if current == section {
                    seen += 1;
                    if seen == nth + 1 {
                        fallback = i + 1;
                    }
                }
            }
            let named = line
                .split_once('=')
                .is_some_and(|(name, _)| name.trim().trim_matches('"') == key);
            if current == section && named && (section.is_empty() || seen == nth + 1) {
                return i + 1;
            }
        }
        fallback
    }

    pub(super) fn invalid(
        &self,
        section: &str,
        nth: usize,
        key: &str,
        reason: String,
    ) -> PresetError {
        PresetError::Invalid {
            file: self.file.to_owned(),
            line: self.line(section, nth, key),
            key: short_key(key),
            reason: short_reason(&reason),
        }
    }
}
