//! How the recording is put together with others: repeated trials averaged, the points of two runs merged.

use std::path::{Path, PathBuf};

use eframe::egui::{ComboBox, Role, TextEdit, Ui};

use super::columns::{name, pick};
use crate::app::theme;
use crate::model::unit::{format_quantity, parse_quantity};
use crate::recording::combine::Combination;

/// What the recording is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Alone,
    MeanOfFile,
    MeanOfFiles,
    TwoPoints,
}

const MISFITS_HELP: &str = "Off: a trial under another drive is an error, and one with another motion is named. \
     On: both are left out, and a notice says which.";
const ZEROS_HELP: &str =
    "On: each trial is shifted to the zero of the first one before the mean is taken.";
const LAG_HELP: &str =
    "Added to the times of the cantilever's run. Empty: as the common voltage shows.";

/// The choice, and its fields as they are edited.
#[derive(Debug)]
pub struct PutTogether {
    kind: Kind,
    /// Recordings that are open, other than this one.
    runs: Vec<PathBuf>,
    /// The files that are averaged with this one.
    files: Vec<PathBuf>,
    leave_out_misfits: bool,
    match_zeros: bool,
    /// A file that is typed.
    typed: String,
    other: Option<PathBuf>,
    other_is_proof_mass: bool,
    lag: String,
    lag_error: Option<String>,
}

impl PutTogether {
    /// Starts from `known`, with the recordings that are open besides `path`.
    pub fn new(path: &Path, known: Option<&Combination>, runs: &[PathBuf]) -> Self {
        let runs = runs.iter().filter(|run| *run != path).cloned().collect();
        let mut own = Self {
            kind: Kind::Alone,
            runs,
            files: Vec::new(),
            leave_out_misfits: false,
            match_zeros: false,
            typed: String::new(),
            other: None,
            other_is_proof_mass: false,
            lag: String::new(),
            lag_error: None,
        };
        match known {
            None => {}
            Some(Combination::Average {
                files,
                leave_out_misfits,
                match_zeros,
                ..
            }) => {
                own.kind = if files.is_empty() {
                    Kind::MeanOfFile
                } else {
                    Kind::MeanOfFiles
                };
                own.files.clone_from(files);
                (own.leave_out_misfits, own.match_zeros) = (*leave_out_misfits, *match_zeros);
            }
            Some(Combination::Points {
                other,
                other_is_proof_mass,
                lag,
            }) => {
                own.kind = Kind::TwoPoints;
                own.other = Some(other.clone());
                own.other_is_proof_mass = *other_is_proof_mass;
                own.lag = lag.map_or_else(String::new, |lag| format_quantity(lag, "s", 9));
            }
        }
        for file in own.files.iter().chain(&own.other) {
            if !own.runs.contains(file) {
                own.runs.push(file.clone());
            }
        }
        own
    }

    /// What is to be stored with the settings.
    pub fn combination(&self) -> Option<Combination> {
        let average = |files: Vec<PathBuf>| Combination::Average {
            trials: Vec::new(),
            files,
            leave_out_misfits: self.leave_out_misfits,
            match_zeros: self.match_zeros,
        };
        match self.kind {
            Kind::Alone => None,
            Kind::MeanOfFile => Some(average(Vec::new())),
            Kind::MeanOfFiles => Some(average(self.files.clone())),
            Kind::TwoPoints => Some(Combination::Points {
                other: self.other.clone()?,
                other_is_proof_mass: self.other_is_proof_mass,
                lag: parse_quantity(&self.lag, "s").ok(),
            }),
        }
    }

    /// What is missing.
    pub fn missing(&self) -> Option<String> {
        match self.kind {
            Kind::MeanOfFiles if self.files.is_empty() => {
                Some("Choose the files of the other trials.".to_owned())
            }
            Kind::TwoPoints if self.other.is_none() => {
                Some("Choose the file of the other point.".to_owned())
            }
            Kind::TwoPoints if self.lag_error.is_some() => Some("Correct the lag.".to_owned()),
            _ => None,
        }
    }

    /// Draws the choice; `trials` is the number of recordings in the file.
    pub fn show(&mut self, ui: &mut Ui, trials: usize) {
        let mut kinds = vec![(Kind::Alone, "as it is")];
        if trials > 1 || self.kind == Kind::MeanOfFile {
            kinds.push((Kind::MeanOfFile, "the mean of all in the file"));
        }
        kinds.push((Kind::MeanOfFiles, "the mean with other files"));
        kinds.push((Kind::TwoPoints, "one point, the other in another file"));
        ui.horizontal_wrapped(|ui| {
            ui.label("the recording is");
            pick(ui, "put together", &mut self.kind, &kinds);
            match self.kind {
                Kind::Alone => {}
                Kind::MeanOfFile | Kind::MeanOfFiles => self.trials_options(ui),
                Kind::TwoPoints => self.points(ui),
            }
        });
        if self.kind == Kind::MeanOfFiles {
            self.files(ui);
        }
        if let Some(error) = &self.lag_error {
            ui.colored_label(theme::error(ui.visuals().dark_mode), error);
        }
    }

    fn trials_options(&mut self, ui: &mut Ui) {
        ui.checkbox(
            &mut self.leave_out_misfits,
            "leave out what does not belong",
        )
        .on_hover_text(MISFITS_HELP);
        ui.checkbox(&mut self.match_zeros, "match zeros")
            .on_hover_text(ZEROS_HELP);
    }

    fn files(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for run in &self.runs {
                let mut is_in = self.files.contains(run);
                let response = ui
                    .checkbox(&mut is_in, shown(run))
                    .on_hover_text(run.to_string_lossy());
                if response.changed() && is_in {
                    self.files.push(run.clone());
                } else if response.changed() {
                    self.files.retain(|file| file != run);
                }
            }
            if let Some(file) = self.typed_file(ui) {
                self.files.push(file);
            }
        });
    }

    fn points(&mut self, ui: &mut Ui) {
        let points = [(false, "proof mass here"), (true, "cantilever here")];
        pick(
            ui,
            "point of this file",
            &mut self.other_is_proof_mass,
            &points,
        );
        let chosen = self
            .other
            .as_deref()
            .map_or_else(|| "choose".to_owned(), shown);
        let response = ComboBox::from_id_salt("file of the other point")
            .selected_text(chosen)
            .width(150.0)
            .show_ui(ui, |ui| {
                for run in &self.runs {
                    ui.selectable_value(&mut self.other, Some(run.clone()), shown(run));
                }
                if self.runs.is_empty() {
                    ui.weak("open the other run first, or type its path");
                }
            })
            .response;
        name(&response, Role::ComboBox, "file of the other point");
        if let Some(file) = self.typed_file(ui) {
            self.other = Some(file);
        }
        ui.label("lag");
        let field = TextEdit::singleline(&mut self.lag)
            .desired_width(70.0)
            .hint_text("by V");
        let field = ui.add(field).on_hover_text(LAG_HELP);
        name(&field, Role::TextInput, "lag of the cantilever");
        if field.changed() {
            let text = self.lag.trim();
            let parsed = parse_quantity(text, "s");
            self.lag_error = parsed
                .err()
                .filter(|_| !text.is_empty())
                .map(|e| e.to_string());
        }
    }

    /// A field for a path; the file once it is entered.
    fn typed_file(&mut self, ui: &mut Ui) -> Option<PathBuf> {
        let field = TextEdit::singleline(&mut self.typed)
            .desired_width(150.0)
            .hint_text("path of another file");
        let field = ui.add(field);
        name(&field, Role::TextInput, "path of another file");
        let path = PathBuf::from(self.typed.trim());
        let is_file = !self.typed.trim().is_empty() && field.lost_focus() && path.is_file();
        is_file.then(|| {
            self.typed.clear();
            let path = std::path::absolute(&path).unwrap_or(path);
            if !self.runs.contains(&path) {
                self.runs.push(path.clone());
            }
            path
        })
    }
}

/// The name of a file.
fn shown(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}
