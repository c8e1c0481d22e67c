//! TODO-doc

/// Where the editor is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// As a section of the left panel.
    Panel,
    /// As a window of its own.
    Window,
}

impl Place {
    /// Keeps the widgets of the two places apart.
    pub(crate) fn scope(self) -> &'static str {
        match self {
            Place::Panel => "drive",
            Place::Window => "drive window",
        }
    }
}
