//! What the window reports: notices over the window, and refused values at their slider.

use super::overlay::OverlayId;

/// A value that the simulator or the model refused. It is shown at its slider, while the last
/// valid curve stays.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// Id of the parameter; `effect.parameter` for a parameter of an effect.
    pub parameter: String,
    /// What is wrong and what to do.
    pub message: String,
}

/// What a notice is about. It decides what the notice's button does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum About {
    /// How a recording was read; the button opens its import settings.
    Recording(OverlayId),
    /// A session's recording whose file is missing; the button lets the person locate it.
    Lost(OverlayId),
}

/// A message over the window.
#[derive(Debug, Clone)]
pub struct Notice {
    /// Errors have their own colour and stay until they are dismissed.
    pub is_error: bool,
    /// What happened, where, and what to do.
    pub text: String,
    /// What it is about, if a button can help. Such a notice stays until it is dismissed.
    pub about: Option<About>,
    /// When it was first shown, on the window's clock \[s\].
    pub since: Option<f64>,
}

impl Notice {
    /// A notice that is not shown yet.
    pub fn new(is_error: bool, text: impl Into<String>) -> Self {
        Self {
            is_error,
            text: text.into(),
            about: None,
            since: None,
        }
    }

    /// Whether it disappears by itself.
    pub fn is_timed(&self) -> bool {
        !self.is_error && self.about.is_none()
    }

    /// How long it stays \[s\], if it disappears by itself: long enough to be read twice.
    pub fn seconds(&self) -> Option<f64> {
        self.is_timed()
            .then(|| 4.0 + 0.08 * self.text.chars().count() as f64)
    }

    /// Whether it is the same message.
    pub fn says(&self, other: &Self) -> bool {
        (self.is_error, self.about, &self.text) == (other.is_error, other.about, &other.text)
    }
}
