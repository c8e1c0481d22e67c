//! What a session keeps of the panels around results: choices, views, and the profile.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::app::analysis::diagnosis::Diagnosing;
use crate::app::analysis::diagnosis_view::Look;
use crate::app::analysis::fit::Fitting;
use crate::fit::ProfilePoint;

/// The fit panel without the fit's result.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct FitPanel {
    open: bool,
    free: Option<BTreeSet<String>>,
    error: Option<String>,
    shown: bool,
    profile_id: Option<String>,
    profile: Option<(String, Result<Vec<ProfilePoint>, String>)>,
    is_incomplete: bool,
}

impl FitPanel {
    pub(super) fn of(fitting: &Fitting) -> Self {
        Self {
            open: fitting.open,
            free: fitting.free.clone(),
            error: fitting.error.clone(),
            shown: fitting.shown && fitting.job.is_none(),
            profile_id: fitting.profile.id.clone(),
            profile: fitting.profile.result.clone(),
            is_incomplete: fitting.profile.is_incomplete,
        }
    }

    /// Gives it to a panel that has its result already. A profile without its fit is gone.
    pub(super) fn restore(self, fitting: &mut Fitting) {
        fitting.open = self.open;
        fitting.free = self.free;
        fitting.error = self.error;
        fitting.profile.id = self.profile_id;
        if fitting.result.is_some() {
            fitting.shown = self.shown;
            fitting.profile.result = self.profile;
            fitting.profile.is_incomplete = self.is_incomplete;
        }
    }
}

/// What is shown of diagnoses.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct DiagnoseView {
    hand_shown: bool,
    picked: Option<BTreeSet<String>>,
    look: Look,
    error: Option<String>,
}

impl DiagnoseView {
    pub(super) fn of(diagnosing: &Diagnosing) -> Self {
        Self {
            hand_shown: diagnosing.hand_shown,
            picked: diagnosing.picked.clone(),
            look: diagnosing.look.clone(),
            error: diagnosing.error.clone(),
        }
    }

    pub(super) fn restore(self, diagnosing: &mut Diagnosing) {
        diagnosing.hand_shown = self.hand_shown;
        diagnosing.picked = self.picked;
        diagnosing.look = self.look;
        diagnosing.error = self.error;
    }
}
