//! TODO-doc

use super::overlay::OverlayId;

/// A parameter that the simulator or the model refused, shown at its slider while the
/// last good curve stays.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// Id of the parameter, `effect.parameter` for an effect's.
    pub parameter: String,
    /// What is wrong and what to do.
    pub message: String,
}

/// What a notice is about, and so what its button does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// How a recording was read: its import can be looked at again.
    Recording(OverlayId),
    /// A session's recording that is not where it was: it can be looked for.
    Lost(OverlayId),
}

/// Something said over the window.
#[derive(Debug, Clone)]
pub struct Notice {
    /// Errors are drawn in their colour and stay until they are dismissed.
    pub is_error: bool,
    /// What, where, what to do.
    pub text: String,
    /// What it is about, if something can be done. Such a notice stays too.
    pub about: Option<About>,
    /// Since when it has been shown, on the window's clock [s].
    pub since: Option<f64>,
}

impl Notice {
    /// Says it once it is drawn.
    pub fn new(is_error: bool, text: impl Into<String>) -> Self {
        Self {
            is_error,
            text: text.into(),
            about: None,
            since: None,
        }
    }

    /// Whether it goes by itself.
    pub fn is_timed(&self) -> bool {
        !self.is_error && self.about.is_none()
    }

    /// How long it stays [s], if it goes by itself: long enough to be read twice.
    pub fn seconds(&self) -> Option<f64> {
        self.is_timed()
            .then(|| 4.0 + 0.08 * self.text.chars().count() as f64)
    }

    /// Whether it says the same.
    pub fn says(&self, other: &Self) -> bool {
        (self.is_error, self.about, &self.text) == (other.is_error, other.about, &other.text)
    }
}
