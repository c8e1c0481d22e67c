//! The two places of the drive editor.

/// Where the editor is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// As a section of the left panel.
    Panel,
    /// As a panel of its own beside the plots.
    Window,
}

impl Place {
    /// Prefix of the widget ids, so that the two places do not share state.
    pub(crate) fn scope(self) -> &'static str {
        match self {
            Place::Panel => "drive",
            Place::Window => "drive window",
        }
    }
}
