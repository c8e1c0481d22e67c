//! What the Diagnose workspace shows of an answer: recording, time span, figure, candidates.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::diagnosis_answer::Answer;
use crate::model::effects::{EventFigure, EvidenceFigure, find};
use crate::static_text::{self, StaticText};

/// A figure that shows the evidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Evidence {
    /// A part of a recording over time.
    #[default]
    Zoom,
    /// The force that the model is missing, against a quantity.
    Force,
    /// The residuals against a quantity.
    Marginal,
    /// The events at the ground.
    Events,
}

impl Evidence {
    /// All, in the order of their tabs.
    pub const ALL: [Self; 4] = [Self::Zoom, Self::Force, Self::Marginal, Self::Events];

    /// Title and description of its tab.
    pub fn text(self) -> (&'static str, &'static str) {
        match self {
            Self::Zoom => (
                "Over time",
                "A recording with its residual before and after",
            ),
            Self::Force => (
                "Missing force",
                "The force on the mass that the re-tuned model is missing, estimated from the recordings",
            ),
            Self::Marginal => (
                "Residual against",
                "The size of the residual against drive, position, speed and other quantities",
            ),
            Self::Events => (
                "Ground events",
                "Each bounce and release, and the height of the ground",
            ),
        }
    }
}

/// A plot of the events at the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum EventPlot {
    /// Restitution against speed.
    #[default]
    Restitution,
    /// Time below the ground against speed.
    Dwell,
    /// Pull-off force against time on the ground.
    Adhesion,
    /// Height of the ground against time.
    Level,
}

impl EventPlot {
    /// All.
    pub const ALL: [Self; 4] = [Self::Restitution, Self::Dwell, Self::Adhesion, Self::Level];

    /// Name of its button.
    pub fn text(self) -> &'static str {
        match self {
            Self::Restitution => "restitution",
            Self::Dwell => "time below ground",
            Self::Adhesion => "pull-off force",
            Self::Level => "ground level",
        }
    }
}

/// What is shown of an answer.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Look {
    /// The recording: its name, and whether its held-out part is shown.
    pub recording: Option<(String, bool)>,
    /// The time span in view \[s\]; `None` is all of it.
    pub window: Option<(f64, f64)>,
    /// The open figure.
    pub evidence: Evidence,
    /// What the missing force is drawn against.
    #[serde(deserialize_with = "static_text::optional")]
    pub force: Option<StaticText>,
    /// Whether the missing force is that of the balance of forces in flight.
    #[serde(default)]
    pub by_balance: bool,
    /// What the residual is drawn against.
    #[serde(deserialize_with = "static_text::optional")]
    pub marginal: Option<StaticText>,
    /// The plot of contact events.
    pub events: EventPlot,
    /// Candidates whose details are open.
    pub opened: BTreeSet<String>,
    /// Whether candidates that explain nothing are listed too.
    pub all_candidates: bool,
}

impl Look {
    /// Starts with a new answer: at its largest mismatch, with the named effects open.
    pub fn begin(&mut self, answer: &Answer) {
        let d = &answer.diagnosis;
        *self = Self::default();
        match d.mismatch.first() {
            Some(worst) => {
                let strip = d.strips.iter().find(|s| s.recording == worst.recording);
                self.recording = strip.map(|s| (s.recording.clone(), s.held_out));
            }
            None => self.recording = d.strips.first().map(|s| (s.recording.clone(), s.held_out)),
        }
        if let Some(first) = d.named.first() {
            self.opened.insert(first.id.clone());
            self.support(&first.id);
        }
    }

    /// Shows a time span of a recording with some margin.
    pub fn zoom(&mut self, recording: &str, held_out: bool, (start, end): (f64, f64)) {
        self.recording = Some((recording.to_owned(), held_out));
        let margin = 0.35 * (end - start).max(1e-4);
        self.window = Some((start - margin, end + margin));
        self.evidence = Evidence::Zoom;
    }

    /// Shows all of a recording.
    pub fn whole(&mut self, recording: &str, held_out: bool) {
        self.recording = Some((recording.to_owned(), held_out));
        self.window = None;
        self.evidence = Evidence::Zoom;
    }

    /// Opens the figure with the evidence for or against an effect.
    pub fn support(&mut self, id: &str) {
        match support(id) {
            Support::Force(against) => {
                self.evidence = Evidence::Force;
                self.force = Some(against);
            }
            Support::Marginal(against) => {
                self.evidence = Evidence::Marginal;
                self.marginal = Some(against);
            }
            Support::Events(plot) => {
                self.evidence = Evidence::Events;
                self.events = plot;
            }
            Support::Time => self.evidence = Evidence::Zoom,
        }
    }
}

/// The figure in which an effect is visible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// The missing force against a quantity.
    Force(&'static str),
    /// The residual against a quantity.
    Marginal(&'static str),
    /// Events at the ground.
    Events(EventPlot),
    /// A part of a recording over time.
    Time,
}

impl Support {
    /// Label of the button that opens it.
    pub fn text(self) -> &'static str {
        match self {
            Self::Force(_) => "Show the missing force",
            Self::Marginal(_) => "Show the residual",
            Self::Events(_) => "Show the events",
            Self::Time => "Show it over time",
        }
    }
}

/// The figure in which an effect of the catalogue is most visible.
pub fn support(id: &str) -> Support {
    match find(id).map_or(EvidenceFigure::Time, |effect| effect.figure) {
        EvidenceFigure::Force(over) => Support::Force(over.symbol()),
        EvidenceFigure::Residual(over) => Support::Marginal(over.symbol()),
        EvidenceFigure::RingDown => Support::Marginal("time since the last event"),
        EvidenceFigure::Events(figure) => Support::Events(match figure {
            EventFigure::Restitution => EventPlot::Restitution,
            EventFigure::Dwell => EventPlot::Dwell,
            EventFigure::Adhesion => EventPlot::Adhesion,
            EventFigure::Level => EventPlot::Level,
        }),
        EvidenceFigure::Time => Support::Time,
    }
}
