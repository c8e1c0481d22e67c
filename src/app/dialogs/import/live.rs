//! The recording as the present settings read it, drawn while they are chosen.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui::{Color32, Context, ScrollArea, Ui, Vec2b};
use egui_plot::{Line, Plot, PlotPoints};

use crate::app::simulation::min_max_pyramid::Pyramid;
use crate::app::theme;
use crate::model::unit::{counted, format_quantity};
use crate::recording::csv::ImportSettings;
use crate::recording::import::import;
use crate::recording::{Channel, Recording};

/// Files up to this size are read again at every change of a setting; it takes a third of a second.
const MAX_LIVE_BYTES: u64 = 32 << 20;
/// Points of a curve, enough for its width.
const MAX_POINTS: usize = 500;
/// Height of the pictures \[points\].
const PICTURE_HEIGHT: f32 = 96.0;
/// Height of what is said of the recording \[points\].
const SAID_HEIGHT: f32 = 48.0;
/// Steps between units of a length: name, and how many there are in a metre.
const LENGTH_UNITS: [(&str, f64); 4] = [("nm", 1e9), ("\u{b5}m", 1e6), ("mm", 1e3), ("m", 1.0)];

/// What reading gave.
#[derive(Debug)]
enum Outcome {
    Read(Box<Drawn>),
    Refused(String),
}

/// A recording as it is drawn.
#[derive(Debug)]
struct Drawn {
    summary: String,
    curves: Vec<(Channel, Vec<[f64; 2]>)>,
    said: Vec<String>,
}

/// Reading in a thread of its own.
#[derive(Debug)]
struct Job {
    coming: Receiver<Outcome>,
    is_unwanted: Arc<AtomicBool>,
}

impl Drop for Job {
    fn drop(&mut self) {
        self.is_unwanted.store(true, Ordering::Relaxed);
    }
}

/// The preview of the recording.
#[derive(Debug, Default)]
pub struct Live {
    /// The settings that were read last, or are being read.
    asked: Option<ImportSettings>,
    job: Option<Job>,
    shown: Option<Outcome>,
}

impl Live {
    /// Draws what `settings` read from the file; `can_read` says whether they are complete.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        path: &Path,
        size: u64,
        settings: &ImportSettings,
        can_read: bool,
        is_known: impl Fn(&str) -> bool,
    ) {
        if !can_read {
            (self.asked, self.job) = (None, None);
            ui.weak("The curves are drawn here once the columns are chosen.");
            return;
        }
        if self.asked.as_ref() != Some(settings) {
            let is_small = size <= MAX_LIVE_BYTES;
            if is_small || ui.button("Draw the recording").clicked() {
                self.job = start(path.to_owned(), settings.clone(), ui.ctx());
                self.asked = Some(settings.clone());
            }
        }
        if let Some(job) = &self.job {
            match job.coming.try_recv() {
                Ok(outcome) => (self.shown, self.job) = (Some(outcome), None),
                Err(TryRecvError::Disconnected) => self.job = None,
                Err(TryRecvError::Empty) => {}
            }
        }
        match &self.shown {
            None => {
                ui.weak("reading...");
            }
            Some(Outcome::Refused(message)) => {
                ui.colored_label(theme::error(ui.visuals().dark_mode), message);
            }
            Some(Outcome::Read(drawn)) => draw(ui, drawn, is_known),
        }
    }
}

/// Starts reading; `None` if there is no thread for it.
fn start(path: PathBuf, settings: ImportSettings, context: &Context) -> Option<Job> {
    let (send, coming) = channel();
    let is_unwanted = Arc::new(AtomicBool::new(false));
    let (unwanted, context) = (Arc::clone(&is_unwanted), context.clone());
    let started = std::thread::Builder::new()
        .name("import preview".to_owned())
        .spawn(move || {
            let go_on = |_: f32| !unwanted.load(Ordering::Relaxed);
            let outcome = match import(&path, &settings, Some(&go_on)) {
                Ok(recording) => Outcome::Read(Box::new(drawn(&recording))),
                Err(error) => Outcome::Refused(error.to_string()),
            };
            // The dialog may be closed meanwhile.
            let _ = send.send(outcome);
            context.request_repaint();
        });
    started.ok().map(|_| Job {
        coming,
        is_unwanted,
    })
}

fn drawn(recording: &Recording) -> Drawn {
    let (first, last) = recording.span();
    let curve = |channel: Channel| {
        let values = recording.channel(channel)?;
        let points = Pyramid::xy(&recording.time, values).draw(first, last, MAX_POINTS);
        Some((channel, points))
    };
    let channels = [Channel::ProofMass, Channel::Cantilever, Channel::Voltage];
    Drawn {
        summary: format!(
            "{} at {}, {} long",
            counted(recording.len(), "row"),
            format_quantity(recording.sampling_rate(), "Hz", 4),
            format_quantity(recording.duration(), "s", 4)
        ),
        curves: channels.into_iter().filter_map(curve).collect(),
        said: recording
            .warnings
            .iter()
            .map(|w| w.message.clone())
            .collect(),
    }
}

fn draw(ui: &mut Ui, drawn: &Drawn, is_known: impl Fn(&str) -> bool) {
    ui.label(&drawn.summary);
    let motion = |c: &&(Channel, Vec<[f64; 2]>)| c.0 != Channel::Voltage;
    let lengths: Vec<_> = drawn.curves.iter().filter(motion).collect();
    let volts: Vec<_> = drawn.curves.iter().filter(|c| !motion(c)).collect();
    let largest = lengths
        .iter()
        .flat_map(|(_, points)| points)
        .map(|[_, x]| x.abs())
        .filter(|x| x.is_finite())
        .fold(0.0, f64::max);
    let mut units = LENGTH_UNITS.into_iter();
    let unit = units.find(|(_, per_metre)| largest * per_metre < 5000.0);
    let (unit, per_metre) = unit.unwrap_or(("m", 1.0));
    let width = ui.available_width();
    ui.horizontal(|ui| {
        let share = if volts.is_empty() { 1.0 } else { 0.5 };
        let names: Vec<&str> = lengths.iter().map(|(c, _)| c.symbol()).collect();
        let label = format!("{} [{unit}]", names.join(", "));
        picture(
            ui,
            "import motion",
            &label,
            width * share - 6.0,
            &lengths,
            per_metre,
        );
        if !volts.is_empty() {
            picture(
                ui,
                "import voltage",
                "V [V]",
                width * share - 6.0,
                &volts,
                1.0,
            );
        }
    });
    let said: Vec<&String> = drawn.said.iter().filter(|text| !is_known(text)).collect();
    if !said.is_empty() {
        ScrollArea::vertical()
            .id_salt("import remarks")
            .max_height(SAID_HEIGHT)
            .show(ui, |ui| {
                for text in said {
                    ui.label(text);
                }
            });
    }
}

fn picture(
    ui: &mut Ui,
    id: &str,
    label: &str,
    width: f32,
    curves: &[&(Channel, Vec<[f64; 2]>)],
    factor: f64,
) {
    let colors = [ui.visuals().hyperlink_color, ui.visuals().warn_fg_color];
    let fixed = Vec2b::new(false, false);
    Plot::new(id)
        .width(width)
        .height(PICTURE_HEIGHT)
        .allow_drag(fixed)
        .allow_zoom(fixed)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_x(false)
        .show_y(false)
        .x_axis_label("t [s]")
        .y_axis_label(label.to_owned())
        .show(ui, |plot| {
            for (i, (channel, points)) in curves.iter().enumerate() {
                let color: Color32 = colors.get(i).copied().unwrap_or(Color32::GRAY);
                // Where readings are missing the line is broken.
                for piece in points.split(|[_, x]| x.is_nan()).filter(|p| !p.is_empty()) {
                    let scaled = piece.iter().map(|[t, x]| [*t, factor * x]);
                    let scaled: Vec<[f64; 2]> = scaled.collect();
                    plot.line(Line::new(channel.symbol(), PlotPoints::from(scaled)).color(color));
                }
            }
        });
}
