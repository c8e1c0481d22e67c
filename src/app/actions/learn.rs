//! The commands of lessons and of the presenter.

use eframe::egui::{Ui, ViewportCommand};

use crate::app::analysis::learning::presenting::{Presenting, SavedScene, Shows};
use crate::app::export::film::FilmRequest;
use crate::app::files::event::Purpose;
use crate::app::services::Services;
use crate::app::setup::command::{Command, LearnCommand};
use crate::app::setup::view::Picture;
use crate::app::setup::workspace_id::WorkspaceId;
use crate::app::simulation::recorded_drive::RecordedDriveCache;
use crate::app::state::State;
use crate::app::workspaces::present::{PRESENTER_ZOOM, welcome};
use crate::learn::controls::Control;
use crate::learn::lesson::LessonPicture;
use crate::learn::run::Scene;
use crate::model::parameter::{ParameterId, Rank};

/// Most sliders of a presenter that was not begun from a lesson.
const MAX_SLIDERS: usize = 4;

/// Whether a lesson, or the presenter, takes the keys.
pub fn takes_keys(state: &State) -> bool {
    state.presenting.is_some() || is_learning(state)
}

fn is_learning(state: &State) -> bool {
    state.view.workspace == WorkspaceId::Learn.name()
}

/// Whether a command of lessons would do anything now.
pub fn is_possible(state: &State, command: LearnCommand) -> bool {
    let learning = &state.learning;
    match command {
        LearnCommand::OpenLesson => true,
        LearnCommand::ExportAnswers => !learning.pupil.is_new(),
        LearnCommand::Back => learning.open.as_ref().is_some_and(|open| open.index > 0),
        _ => learning.open.is_some(),
    }
}

/// Runs a command of lessons or of the presenter.
pub fn run(services: &mut Services, ui: &Ui, command: Command) {
    let state = &mut services.state;
    match command {
        Command::Learn(command) => {
            if !matches!(
                command,
                LearnCommand::OpenLesson | LearnCommand::ExportAnswers
            ) {
                WorkspaceId::Learn
                    .name()
                    .clone_into(&mut state.view.workspace);
            }
            lesson(services, command);
        }
        Command::Present => toggle_presenter(services, ui),
        Command::ExportFilm => {
            services.film = film(&services.state, &mut services.recorded_drive);
            if services.film.is_some() {
                services.dialogs.ask_path(Some(Purpose::Film));
            } else {
                services.fail(
                    "There is no run to make a film of; wait for the first result".to_owned(),
                );
            }
        }
        _ => {}
    }
}

fn lesson(services: &mut Services, command: LearnCommand) {
    let learning = &mut services.state.learning;
    match command {
        LearnCommand::Next => {
            if let Some(finished) = learning.go_on() {
                let (earned, offered) = learning.pupil.stars(&finished);
                let text = format!(
                    "\"{}\" is done: {earned} of {offered} points.",
                    finished.title
                );
                services.notice(false, text);
            }
        }
        LearnCommand::Back => learning.back(),
        LearnCommand::Predict => {
            if let Some(open) = &mut learning.open {
                open.predict();
            }
        }
        LearnCommand::Reset => learning.reset(),
        LearnCommand::NextLesson => learning.go_to_lesson(1),
        LearnCommand::PreviousLesson => learning.go_to_lesson(-1),
        LearnCommand::OpenLesson => services.files.open_dialog(),
        LearnCommand::ExportAnswers => services.dialogs.ask_path(Some(Purpose::Answers)),
    }
}

/// Space, R and the point in a lesson.
pub fn play(state: &mut State, command: Command) {
    let Some(open) = &mut state.learning.open else {
        return;
    };
    match command {
        Command::TogglePause => open.toggle(),
        Command::Restart => open.replay(),
        _ => {
            /// Pictures a second of a single step.
            const STEP_RATE: f64 = 30.0;
            let by = open.playback.speed / STEP_RATE;
            open.playback.step(by, open.scene.duration);
        }
    }
}

/// Fills the screen with the present device, or gives it back.
fn toggle_presenter(services: &mut Services, ui: &Ui) {
    let state = &mut services.state;
    let context = ui.ctx();
    if let Some(presenting) = state.presenting.take() {
        context.set_zoom_factor(presenting.zoom_before);
        context.send_viewport_cmd(ViewportCommand::Fullscreen(false));
        return;
    }
    let Some(saved) = scene_of(state, &mut services.recorded_drive) else {
        services.fail("The presenter needs a device and a drive that can be simulated".to_owned());
        return;
    };
    let zoom = context.zoom_factor();
    let mut presenting = Presenting::new(saved, zoom, state.view.less_motion);
    presenting.remark = welcome();
    state.presenting = Some(presenting);
    context.set_zoom_factor(zoom * PRESENTER_ZOOM);
    context.send_viewport_cmd(ViewportCommand::Fullscreen(true));
}

/// What the presenter begins with: the open step in Learn, the device of Tune elsewhere.
fn scene_of(state: &State, drives: &mut RecordedDriveCache) -> Option<SavedScene> {
    if is_learning(state)
        && let Some(open) = &state.learning.open
    {
        let step = open.step()?;
        let own = step.task.controls();
        // A step without controls has those of the lesson's exploration.
        let last = open.lesson.steps.last();
        let controls = match own.is_empty() {
            true => last.map_or(own, |step| step.task.controls()),
            false => own,
        };
        return Some(SavedScene {
            scene: open.scene.clone(),
            controls: controls.to_vec(),
            pictures: step.pictures.clone(),
            speed: step.speed,
            shows: Shows::default(),
        });
    }
    let drive = drives.resolve(&state.setup).ok()?;
    let scene = Scene {
        preset: state.setup.preset.clone(),
        drive,
        duration: state.setup.duration,
    };
    let pictures = state
        .view
        .pictures
        .iter()
        .filter_map(|picture| match picture {
            Picture::Voltage => Some(LessonPicture::Voltage),
            Picture::Trajectory => Some(LessonPicture::Trajectory),
            Picture::Forces => Some(LessonPicture::Forces),
            Picture::PhasePortrait => Some(LessonPicture::PhasePortrait),
            Picture::DriveLoop => Some(LessonPicture::DriveLoop),
            Picture::Residual | Picture::Device => None,
        });
    Some(SavedScene {
        controls: main_controls(&scene),
        pictures: pictures.collect(),
        speed: state.view.slow_down,
        scene,
        shows: Shows::default(),
    })
}

/// The sliders that are moved most on a device.
fn main_controls(scene: &Scene) -> Vec<Control> {
    let control = |id: &str| Control {
        id: id.to_owned(),
        range: None,
    };
    let primary = ParameterId::ALL
        .into_iter()
        .filter(|id| id.spec().rank == Rank::Primary);
    let others = [ParameterId::Zeta1, ParameterId::F1, ParameterId::X0];
    let ids = primary.chain(others).map(|id| control(id.spec().id));
    ids.filter(|control| control.spec(scene).is_some())
        .take(MAX_SLIDERS)
        .collect()
}

/// A film of what is shown: of the presenter's span, of a lesson's run, or of Tune between its
/// two cursors.
fn film(state: &State, drives: &mut RecordedDriveCache) -> Option<FilmRequest> {
    if let Some(presenting) = &state.presenting {
        let side = presenting.side()?;
        let mut saved = presenting.saved()?;
        let duration = side.scene.duration;
        let span = (
            presenting.film.0.unwrap_or(0.0),
            presenting.film.1.unwrap_or(duration),
        );
        let fixed = [LessonPicture::Device, LessonPicture::Energy];
        saved.pictures.retain(|picture| !fixed.contains(picture));
        saved.pictures.insert(0, LessonPicture::Device);
        if saved.shows.energies {
            saved.pictures.push(LessonPicture::Energy);
        }
        return Some(
            FilmRequest::new(saved, span, state.view.dark)
                .slow_at_impacts(presenting.playback.slows_at_impacts),
        );
    }
    let saved = scene_of(state, drives)?;
    let cursors = state.cursors.first.zip(state.cursors.second);
    let chosen = cursors.filter(|_| !is_learning(state));
    let span = chosen.unwrap_or((0.0, saved.scene.duration));
    let mut saved = saved;
    if !saved.pictures.contains(&LessonPicture::Device) {
        saved.pictures.insert(0, LessonPicture::Device);
    }
    Some(FilmRequest::new(saved, span, state.view.dark))
}
