//! The import settings of a recording: columns, units, offset, scale and sign, and what it is put together
//! with; with the beginning of the file as a table, and the recording as curves.

pub(super) mod columns;
mod live;
mod put_together;
mod sample;
mod table;

use std::path::PathBuf;

use eframe::egui::{
    Align2, Button, ComboBox, Grid, Id, RichText, ScrollArea, TextEdit, Ui, Window,
};

use self::columns::{
    Names, chooser, drift, interval, lines_before, micrometres, pick, scale, sensitivity,
};
use self::live::Live;
use self::put_together::PutTogether;
use self::sample::{Cells, Sample};
use self::table::Roles;
use super::{Answer, enter, escape};
use crate::app::files::recent::{Sensitivity, sensitivities_for};
use crate::app::theme;
use crate::model::unit::{format_quantity, parse_quantity};
use crate::recording::combine::Combination;
use crate::recording::csv::{
    ColumnChoice, Decimal, Delimiter, Encoding, ImportSettings, Preview, Quantity, TimeZero,
};

/// Units offered for each quantity.
const TIME_UNITS: [&str; 9] = ["s", "ms", "us", "ns", "min", "h", "days", "clock", "sample"];
const VOLTAGE_UNITS: [&str; 2] = ["V", "mV"];
const MOTION_UNITS: [&str; 11] = [
    "m", "cm", "mm", "um", "nm", "m/s", "mm/s", "um/s", "m/s^2", "V", "mV",
];

/// Height of the dialog's title and buttons, and of what stays free around it \[points\].
const FRAME_HEIGHT: f32 = 110.0;
/// What the choice of t = 0 means.
const ZERO_HELP: &str = "The first row: times count from the first sample, where the simulation \
     starts. The file's own zero: times stay as in the file; choose it if its zero means something, \
     for example a trigger. The time offset is added to either.";
/// What using the times as written means.
const AS_WRITTEN_HELP: &str = "Off: where the times are those of an even sampling clock except \
     for rounding or jitter, the clock's times are used, and a notice says so. On: every time is \
     used exactly as it is in the file.";

/// The open dialog.
#[derive(Debug)]
pub struct ImportDialog {
    path: PathBuf,
    preview: Preview,
    settings: ImportSettings,
    offset: String,
    offset_error: Option<String>,
    /// The beginning of the file, read once another delimiter is chosen.
    sample: Option<Sample>,
    /// The table shown.
    cells: Cells,
    /// What else the recording is made of.
    together: PutTogether,
    /// The recording as it is read now.
    live: Live,
    /// Sensitivities given before for this folder.
    known: Vec<Sensitivity>,
    /// Whether a value was being edited; Escape then ends only the edit.
    editing: bool,
    is_new: bool,
}

impl ImportDialog {
    /// A dialog that starts with `known` settings, else with the guessed ones; `runs` are the recordings that
    /// are open.
    pub fn new(
        path: PathBuf,
        preview: Preview,
        known: Option<ImportSettings>,
        runs: &[PathBuf],
    ) -> Self {
        let settings = known.unwrap_or_else(|| preview.settings.clone());
        Self {
            together: PutTogether::new(&path, settings.combine.as_ref(), runs),
            live: Live::default(),
            known: sensitivities_for(&path),
            offset: format_quantity(settings.time_offset, "s", 9),
            offset_error: None,
            settings,
            path,
            cells: Cells {
                header: preview.header.clone(),
                columns: preview.columns,
                rows: preview.rows.clone(),
            },
            preview,
            sample: None,
            editing: false,
            is_new: true,
        }
    }

    /// The settings as they stand.
    #[cfg(test)]
    pub(super) fn settings(&self) -> &ImportSettings {
        &self.settings
    }

    /// Why the import cannot start yet.
    fn missing(&self) -> Option<String> {
        let settings = &self.settings;
        let choices = [
            ("time", &settings.time),
            ("proof mass", &settings.proof_mass),
            ("cantilever", &settings.cantilever),
            ("voltage", &settings.voltage),
        ];
        if settings.time.is_none() && settings.clock.is_none() {
            return Some("Choose a column for the time, or give the sampling interval.".to_owned());
        }
        let is_one_of_two = matches!(settings.combine, Some(Combination::Points { .. }));
        if settings.proof_mass.is_none() && !(is_one_of_two && settings.cantilever.is_some()) {
            return Some("Choose a column for the proof mass.".to_owned());
        }
        if let Some(missing) = self.together.missing() {
            return Some(missing);
        }
        for (name, choice) in &choices[1..3] {
            if let Some(choice) = choice
                && choice.is_in_foreign_unit()
                && choice.scale.is_none()
            {
                return Some(format!(
                    "Say what 1 {} of the {name} stands for, for example 0.5um/{}.",
                    choice.unit, choice.unit
                ));
            }
        }
        for (i, (name, choice)) in choices.iter().enumerate() {
            let Some(choice) = choice else {
                continue;
            };
            if choice.index >= self.cells.columns {
                return Some(format!(
                    "Choose another column for the {name}: with this delimiter there is no column {}.",
                    choice.index + 1
                ));
            }
            let same = choices[..i]
                .iter()
                .find(|(_, other)| other.as_ref().is_some_and(|o| o.index == choice.index));
            if let Some((other, _)) = same {
                return Some(format!("{other} and {name} are the same column."));
            }
        }
        let scales = [settings.voltage_scale, settings.xp_scale, settings.xc_scale];
        if scales.contains(&0.0) {
            return Some("A scale must not be zero.".to_owned());
        }
        self.offset_error
            .is_some()
            .then(|| "Correct the time offset.".to_owned())
    }

    /// Splits the file with the present settings.
    fn split(&mut self, ui: &Ui) {
        let (settings, guessed) = (&self.settings, &self.preview.settings);
        let split_by = |s: &ImportSettings| (s.encoding, s.delimiter, s.skip_lines);
        if split_by(settings) == split_by(guessed) || !self.preview.is_text {
            self.cells = Cells {
                header: self.preview.header.clone(),
                columns: self.preview.columns,
                rows: self.preview.rows.clone(),
            };
            return;
        }
        let sample = self
            .sample
            .get_or_insert_with(|| Sample::read(self.path.clone(), ui.ctx()));
        // Until the file is read, the earlier table stays.
        if let Some(cells) = sample.split(settings) {
            self.cells = cells;
        }
    }

    /// Draws it; returns whether it stays open, and the answer.
    pub fn show(&mut self, ui: &mut Ui) -> (bool, Option<Answer>) {
        if std::mem::take(&mut self.is_new) {
            // The dialog takes the keys, not the widget that was focused behind it.
            ui.memory_mut(|memory| {
                if let Some(focused) = memory.focused() {
                    memory.surrender_focus(focused);
                }
            });
        }
        let mut open = self.editing || !escape(ui);
        let field = Id::unique("import time offset");
        let mut accepted = enter(ui, field);
        let mut again = None;
        self.split(ui);
        Window::new("Import a recording")
            .collapsible(false)
            .default_width(760.0)
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ui, |ui| {
                // The buttons stay in sight in a low window.
                let most = ui.ctx().content_rect().height() - FRAME_HEIGHT;
                ScrollArea::vertical()
                    .id_salt("import settings")
                    .max_height(most.max(200.0))
                    .show(ui, |ui| {
                        self.findings(ui);
                        again = self.trials(ui);
                        self.together.show(ui, self.preview.trials.len());
                        self.settings.combine = self.together.combination();
                        ui.separator();
                        self.columns(ui, field);
                        self.clock(ui);
                        ui.separator();
                        if self.preview.is_text {
                            self.text(ui);
                            ui.separator();
                        }
                        table::show(ui, &self.cells, self.settings.decimal, &self.roles());
                        ui.separator();
                        let missing = self.missing();
                        let said =
                            |text: &str| self.preview.warnings.iter().any(|w| w.message == text);
                        let (path, size) = (&self.path, self.preview.size);
                        self.live
                            .show(ui, path, size, &self.settings, missing.is_none(), said);
                    });
                ui.separator();
                let missing = self.missing();
                ui.horizontal(|ui| {
                    let import = ui.add_enabled(missing.is_none(), Button::new("Import"));
                    accepted |= import.clicked();
                    if ui.button("Cancel").clicked() {
                        open = false;
                    }
                    if let Some(missing) = missing {
                        let color = theme::error(ui.visuals().dark_mode);
                        ui.label(RichText::new(missing).color(color));
                    }
                });
            });
        self.editing = ui.ctx().text_edit_focused();
        if let Some(trial) = again {
            return (false, Some(Answer::Trial(self.path.clone(), trial)));
        }
        // The field may have changed in this frame.
        if open && accepted && self.missing().is_none() {
            let answer = Answer::Import(self.path.clone(), Box::new(self.settings.clone()));
            return (false, Some(answer));
        }
        (open, None)
    }

    /// What was found in the file.
    fn findings(&self, ui: &mut Ui) {
        ui.strong(&self.preview.name)
            .on_hover_text(self.path.to_string_lossy());
        let color = theme::error(ui.visuals().dark_mode);
        let mut open: Vec<String> = self.preview.open_points().collect();
        open.dedup();
        for point in &open {
            ui.colored_label(color, point);
        }
        let is_said = |line: &String| open.iter().any(|point| point.contains(line));
        for line in self
            .preview
            .ambiguities
            .iter()
            .filter(|line| !is_said(line))
        {
            ui.colored_label(color, line);
        }
        let is_shown = |text: &String| self.preview.ambiguities.contains(text);
        for warning in &self.preview.warnings {
            if !is_shown(&warning.message) {
                ui.label(&warning.message);
            }
        }
    }

    /// Which recording of several; returns another one that was chosen.
    fn trials(&self, ui: &mut Ui) -> Option<usize> {
        let all = &self.preview.trials;
        if all.len() < 2 {
            return None;
        }
        let now = self.settings.trial.unwrap_or(1);
        let mut chosen = now;
        ui.horizontal(|ui| {
            ui.label("recording");
            let label = |n: usize| {
                all.get(n - 1)
                    .map_or_else(String::new, |t| format!("{n}: {}", t.name))
            };
            let response = ComboBox::from_id_salt("recording of several")
                .selected_text(label(now))
                .width(320.0)
                .show_ui(ui, |ui| {
                    for n in 1..=all.len() {
                        ui.selectable_value(&mut chosen, n, label(n));
                    }
                })
                .response;
            columns::name(
                &response,
                eframe::egui::Role::ComboBox,
                "recording of several",
            );
            ui.weak(format!(
                "of {} in the file; open it again for another one",
                all.len()
            ));
        });
        (chosen != now).then_some(chosen)
    }

    fn roles(&self) -> Roles {
        let settings = &self.settings;
        let choices = [
            ("time", &settings.time),
            ("proof mass", &settings.proof_mass),
            ("cantilever", &settings.cantilever),
            ("voltage", &settings.voltage),
        ];
        choices
            .into_iter()
            .filter_map(|(name, choice)| choice.as_ref().map(|choice| (choice.index, name)))
            .collect()
    }

    fn columns(&mut self, ui: &mut Ui, field: Id) {
        let names: Names = (0..self.cells.columns)
            .map(|i| table::column_name(&self.cells, i))
            .collect();
        let settings = &mut self.settings;
        let before = [settings.proof_mass.clone(), settings.cantilever.clone()];
        Grid::new("import columns").num_columns(6).show(ui, |ui| {
            for title in ["quantity", "column", "unit", "scale", "sign", "offset"] {
                ui.weak(title);
            }
            ui.end_row();
            chooser(ui, "time", &names, &mut settings.time, &TIME_UNITS);
            ui.label("");
            ui.label("");
            let text = TextEdit::singleline(&mut self.offset)
                .id(field)
                .desired_width(90.0);
            let text = ui
                .add(text)
                .on_hover_text("added to all times, for example -1 s");
            columns::name(&text, eframe::egui::Role::TextInput, "time offset");
            if text.changed() {
                match parse_quantity(&self.offset, "s") {
                    Ok(offset) => {
                        settings.time_offset = offset;
                        self.offset_error = None;
                    }
                    Err(error) => self.offset_error = Some(error.to_string()),
                }
            }
            ui.end_row();
            let lengths = &MOTION_UNITS;
            chooser(ui, "proof mass", &names, &mut settings.proof_mass, lengths);
            scale(ui, "proof mass", &mut settings.xp_scale);
            micrometres(ui, "proof mass offset", &mut settings.xp_offset);
            ui.end_row();
            chooser(ui, "cantilever", &names, &mut settings.cantilever, lengths);
            scale(ui, "cantilever", &mut settings.xc_scale);
            micrometres(ui, "cantilever offset", &mut settings.xc_offset);
            ui.end_row();
            chooser(ui, "voltage", &names, &mut settings.voltage, &VOLTAGE_UNITS);
            scale(ui, "voltage", &mut settings.voltage_scale);
            ui.end_row();
        });
        take_known(&self.known, &before[0], "xp", &mut settings.proof_mass);
        take_known(&self.known, &before[1], "xc", &mut settings.cantilever);
        sensitivity(ui, "proof mass", &mut settings.proof_mass);
        sensitivity(ui, "cantilever", &mut settings.cantilever);
        let is_rate = |choice: &ColumnChoice| choice.kind != Quantity::Displacement;
        let motions = [&settings.proof_mass, &settings.cantilever];
        if motions.into_iter().flatten().any(is_rate) {
            drift(ui, &mut settings.drift);
        }
        if let Some(error) = &self.offset_error {
            ui.colored_label(theme::error(ui.visuals().dark_mode), error);
        }
    }

    /// Which instant is t = 0, and whether the clock is judged.
    fn clock(&mut self, ui: &mut Ui) {
        let settings = &mut self.settings;
        let counts = settings
            .time
            .as_ref()
            .is_none_or(|time| time.unit == "sample");
        if counts {
            interval(ui, &mut settings.clock);
        }
        ui.horizontal_wrapped(|ui| {
            ui.label("t = 0 is");
            let zeros = [
                (TimeZero::FirstRow, "the first row"),
                (TimeZero::File, "the file's own zero"),
            ];
            pick(ui, "zero of time", &mut settings.time_zero, &zeros).on_hover_text(ZERO_HELP);
            ui.separator();
            ui.checkbox(&mut settings.times_as_written, "use times as written")
                .on_hover_text(AS_WRITTEN_HELP);
        });
    }

    fn text(&mut self, ui: &mut Ui) {
        let settings = &mut self.settings;
        ui.horizontal_wrapped(|ui| {
            ui.label("cells separated by");
            let delimiters = Delimiter::ALL.map(|delimiter| (delimiter, delimiter.label()));
            pick(ui, "delimiter", &mut settings.delimiter, &delimiters);
            ui.separator();
            ui.label("decimal sign");
            let signs = [(Decimal::Point, "point"), (Decimal::Comma, "comma")];
            pick(ui, "decimal sign", &mut settings.decimal, &signs);
            ui.separator();
            lines_before(ui, &mut settings.skip_lines);
            ui.separator();
            ui.label("encoding");
            let recognised = std::iter::once((None, "recognised"));
            let all = Encoding::ALL.map(|encoding| (Some(encoding), encoding.label()));
            let all: Vec<_> = recognised.chain(all).collect();
            pick(ui, "encoding", &mut settings.encoding, &all);
        });
    }
}

/// Fills in the sensitivity that was given before for this folder, where a column was just chosen whose unit is
/// the instrument's.
fn take_known(
    known: &[Sensitivity],
    before: &Option<ColumnChoice>,
    channel: &str,
    choice: &mut Option<ColumnChoice>,
) {
    let Some(own) = choice.as_mut().filter(|own| own.is_in_foreign_unit()) else {
        return;
    };
    let is_new = before
        .as_ref()
        .is_none_or(|before| (before.index, &before.unit) != (own.index, &own.unit));
    if is_new && own.scale.is_none() {
        let mut fitting = known.iter();
        let found = fitting.find(|k| k.channel == channel && k.unit == own.unit);
        own.scale = found.map(|k| k.scale.clone());
    }
}
