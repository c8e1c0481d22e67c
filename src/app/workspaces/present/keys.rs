//! The keys of the presenter. No menu is on the screen.

use eframe::egui::{Event, Key, Modifiers, Ui};

use crate::app::analysis::learning::presenting::{Presenting, SavedScenes};
use crate::app::setup::command::Command;
use crate::learn::playback::Playback;

/// Keys and what they do, as they are listed.
pub const PRESENTER_KEYS: [(&str, &str); 20] = [
    ("Space", "run or pause"),
    ("R", "from the beginning"),
    (". and ,", "a picture forward, a picture back"),
    ("+ and -", "faster, slower"),
    ("Up, Down", "choose a slider"),
    ("Left, Right", "move it (Shift: finely)"),
    ("0", "all values as at the beginning"),
    ("K and J", "pull the mass up or down and let it go"),
    ("B", "a second device beside it, or one alone"),
    ("X", "sliders and pulls act on the other one"),
    ("F", "values at the arrows of forces"),
    ("E", "bars of energies"),
    ("P", "plots"),
    ("Z", "go near at impacts"),
    ("M", "slow motion at impacts"),
    ("S, then 1 to 9", "save this scene on a key"),
    ("1 to 9", "show the scene of that key"),
    ("[ and ]", "beginning and end of a film"),
    ("V", "export the film as GIF or PNG"),
    ("Escape or F11", "leave"),
];

/// Steps of a slider over its range.
const SLIDER_STEP: f64 = 0.01;
/// The same with Shift.
const FINE_STEP: f64 = 0.001;
/// Faster or slower by this factor.
const SPEED_FACTOR: f64 = 1.25;
/// Slowest and fastest play, simulated seconds per second.
const SPEED_RANGE: (f64, f64) = (1e-5, 10.0);
/// Pictures a second of a single step.
const STEP_RATE: f64 = 30.0;
/// Share of the range of the motion by which a key pulls the mass.
const PULL_SHARE: f64 = 0.25;
/// The keys of scenes.
const DIGITS: [Key; 9] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];

/// Carries out what was typed. Returns a command for the window.
pub(super) fn handle(
    ui: &Ui,
    presenting: &mut Presenting,
    scenes: &mut SavedScenes,
) -> Option<Command> {
    if ui.ctx().text_edit_focused() {
        return None;
    }
    let mut asked = None;
    for event in ui.input(|input| input.events.clone()) {
        let Event::Key {
            key,
            pressed: true,
            modifiers,
            ..
        } = event
        else {
            continue;
        };
        if modifiers.ctrl || modifiers.alt || modifiers.command {
            continue;
        }
        if let Some(i) = DIGITS.iter().position(|digit| *digit == key) {
            digit(presenting, scenes, i as u8 + 1);
        } else if key == Key::Escape && (presenting.is_saving || presenting.shows.keys) {
            presenting.is_saving = false;
            presenting.shows.keys = false;
        } else {
            asked = asked.or(one(presenting, key, modifiers));
        }
    }
    asked
}

/// Saves a scene on a digit, or shows the one that is there.
fn digit(presenting: &mut Presenting, scenes: &mut SavedScenes, digit: u8) {
    if std::mem::take(&mut presenting.is_saving) {
        if let Some(saved) = presenting.saved() {
            scenes.insert(digit, saved);
            presenting.remark = format!("Saved as scene {digit}.");
        }
        return;
    }
    match scenes.get(&digit) {
        Some(saved) => {
            presenting.show_saved(saved.clone());
            presenting.remark = format!("Scene {digit}.");
        }
        None => presenting.remark = format!("There is no scene {digit}; S and {digit} saves one."),
    }
}

/// One key. Returns a command for the window.
fn one(presenting: &mut Presenting, key: Key, modifiers: Modifiers) -> Option<Command> {
    let duration = presenting.duration();
    let step = presenting.playback.speed / STEP_RATE;
    let play: &mut Playback = &mut presenting.playback;
    presenting.remark.clear();
    match key {
        Key::Space => play.toggle(duration),
        Key::R => play.start(),
        Key::Period => play.step(step, duration),
        Key::Comma => play.step(-step, duration),
        Key::Plus | Key::Equals => change_speed(play, SPEED_FACTOR),
        Key::Minus => change_speed(play, 1.0 / SPEED_FACTOR),
        Key::ArrowUp => choose(presenting, -1),
        Key::ArrowDown => choose(presenting, 1),
        Key::ArrowLeft => move_control(presenting, -1.0, modifiers.shift),
        Key::ArrowRight => move_control(presenting, 1.0, modifiers.shift),
        Key::Num0 => restore(presenting),
        Key::K => pull(presenting, PULL_SHARE),
        Key::J => pull(presenting, -PULL_SHARE),
        Key::B => presenting.toggle_second(),
        Key::X => presenting.switch_side(),
        Key::M => play.slows_at_impacts = !play.slows_at_impacts,
        Key::OpenBracket => {
            presenting.film.0 = Some(play.time);
            presenting.remark = "The film begins here.".to_owned();
        }
        Key::CloseBracket => {
            presenting.film.1 = Some(play.time);
            presenting.remark = "The film ends here.".to_owned();
        }
        Key::S => presenting.is_saving = true,
        Key::F => presenting.shows.forces = !presenting.shows.forces,
        Key::E => presenting.shows.energies = !presenting.shows.energies,
        Key::P => presenting.shows.plots = !presenting.shows.plots,
        Key::Z => presenting.shows.zoom = !presenting.shows.zoom,
        Key::H | Key::Questionmark => presenting.shows.keys = !presenting.shows.keys,
        Key::V => return Some(Command::ExportFilm),
        Key::Escape | Key::F11 => return Some(Command::Present),
        _ => {}
    }
    None
}

fn change_speed(play: &mut Playback, factor: f64) {
    play.speed = (play.speed * factor).clamp(SPEED_RANGE.0, SPEED_RANGE.1);
}

fn choose(presenting: &mut Presenting, by: isize) {
    let count = presenting.controls.len().max(1);
    let next = presenting.control.checked_add_signed(by);
    presenting.control = next.unwrap_or(count - 1) % count;
}

fn move_control(presenting: &mut Presenting, steps: f64, is_fine: bool) {
    let Some(control) = presenting.controls.get(presenting.control).cloned() else {
        return;
    };
    let by = steps * if is_fine { FINE_STEP } else { SLIDER_STEP };
    if let Some(side) = presenting.side_mut()
        && let Some(spec) = control.spec(&side.scene)
        && let Some(value) = side.scene.control_value(&control.id)
    {
        let fraction = (spec.fraction(value).clamp(0.0, 1.0) + by).clamp(0.0, 1.0);
        let moved = spec.value_at(fraction);
        side.scene.set_control(&control.id, moved);
    }
}

fn restore(presenting: &mut Presenting) {
    if let Some(side) = presenting.side_mut() {
        side.scene = side.original.clone();
    }
    presenting.let_go_at = None;
    presenting.playback.start();
}

/// Pulls the mass by a share of the range of its motion, and lets it go.
fn pull(presenting: &mut Presenting, share: f64) {
    let Some(result) = presenting.side().and_then(|side| side.result().cloned()) else {
        return;
    };
    let (low, high) = crate::recording::extremes(&result.run.trace.proof_mass);
    presenting.let_go(share * (high - low));
}
