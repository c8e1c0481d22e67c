//! The parts of which results in a session consist.

use crate::fit::paper_steps::guide::Step;

/// A part of the results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Fit,
    FitPanel,
    Guide,
    Found(Step),
    Answer,
    AnswerByHand,
    DiagnoseView,
    Trial,
    TrialSetup,
    TrialAnswer,
    TrialAnswerByHand,
    Lessons,
    Scenes,
}

impl Part {
    /// All, in the order in which they are written.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        [Self::Fit, Self::FitPanel, Self::Guide]
            .into_iter()
            .chain(Step::ALL.map(Self::Found))
            .chain([
                Self::Answer,
                Self::AnswerByHand,
                Self::DiagnoseView,
                Self::Trial,
                Self::TrialSetup,
                Self::TrialAnswer,
                Self::TrialAnswerByHand,
                Self::Lessons,
                Self::Scenes,
            ])
    }

    /// Its name in a file. A part whose meaning changes needs another one.
    pub(super) fn id(self) -> &'static str {
        match self {
            Self::Fit => "fit",
            Self::FitPanel => "fit-panel",
            Self::Guide => "identification",
            Self::Found(Step::Modal) => "identified-modal",
            Self::Found(Step::Drive) => "identified-drive",
            Self::Found(Step::Restitution) => "identified-restitution",
            Self::Found(Step::Adhesion) => "identified-adhesion",
            Self::Found(Step::Film) => "identified-film",
            Self::Found(Step::Sensitivity) => "identified-sensitivity",
            Self::Answer => "diagnosis",
            Self::AnswerByHand => "diagnosis-by-hand",
            Self::DiagnoseView => "diagnosis-view",
            Self::Trial => "trial",
            Self::TrialSetup => "trial-setup",
            Self::TrialAnswer => "trial-diagnosis",
            Self::TrialAnswerByHand => "trial-diagnosis-by-hand",
            Self::Lessons => "lessons",
            Self::Scenes => "presenter-scenes",
        }
    }

    pub(super) fn find(id: &str) -> Option<Self> {
        Self::all().find(|part| part.id() == id)
    }

    /// What a person calls it.
    pub(super) fn text(self) -> &'static str {
        match self {
            Self::Fit => "the fit",
            Self::FitPanel => "the choices of the fit panel",
            Self::Guide => "the state of the identification",
            Self::Found(_) => "a step of the identification",
            Self::Answer => "the diagnosis",
            Self::AnswerByHand => "the diagnosis by hand",
            Self::DiagnoseView => "the view of the diagnosis",
            Self::Trial => "the sealed trial",
            Self::TrialSetup => "the device tuned in the sealed trial",
            Self::TrialAnswer => "the diagnosis of the sealed trial",
            Self::TrialAnswerByHand => "the diagnosis by hand of the sealed trial",
            Self::Lessons => "the progress in the lessons",
            Self::Scenes => "the scenes of the presenter",
        }
    }
}
