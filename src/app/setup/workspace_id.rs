//! The workspaces by name: the command line, sessions, menus and tabs all use this list.
//! What a workspace draws is listed in `workspaces`.

/// A workspace of the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorkspaceId {
    /// Sliders, curves and recordings.
    Tune,
    /// What the model is missing.
    Diagnose,
    /// How the steady response depends on drive and coefficients.
    Explore,
    /// Lessons.
    Learn,
}

impl WorkspaceId {
    /// All, in the order of the tabs. A window without a known name shows the first.
    pub const ALL: [WorkspaceId; 4] = [
        WorkspaceId::Tune,
        WorkspaceId::Diagnose,
        WorkspaceId::Explore,
        WorkspaceId::Learn,
    ];
    /// Their names, as on the command line.
    pub const NAMES: [&str; 4] = [
        WorkspaceId::Tune.name(),
        WorkspaceId::Diagnose.name(),
        WorkspaceId::Explore.name(),
        WorkspaceId::Learn.name(),
    ];

    /// Name on the command line and in session files.
    pub const fn name(self) -> &'static str {
        match self {
            WorkspaceId::Tune => "tune",
            WorkspaceId::Diagnose => "diagnose",
            WorkspaceId::Explore => "explore",
            WorkspaceId::Learn => "learn",
        }
    }

    /// Title of its tab.
    pub fn title(self) -> &'static str {
        match self {
            WorkspaceId::Tune => "Tune",
            WorkspaceId::Diagnose => "Diagnose",
            WorkspaceId::Explore => "Explore",
            WorkspaceId::Learn => "Learn",
        }
    }

    /// What it is for, in one line.
    pub fn help(self) -> &'static str {
        match self {
            WorkspaceId::Tune => "Simulate with sliders, compare with recordings, fit parameters",
            WorkspaceId::Diagnose => {
                "Find the effects that the model is missing, with evidence from recordings"
            }
            WorkspaceId::Learn => "Short lessons: predict, play, and see what happens",
            WorkspaceId::Explore => {
                "See how the steady response depends on drive and coefficients, draw waveforms"
            }
        }
    }
}
