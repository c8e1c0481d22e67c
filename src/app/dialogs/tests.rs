//! The dialogs by their accessibility tree, without a GPU.

use std::path::Path;

use eframe::egui::accesskit::{Role, Toggled};
use eframe::egui::{Key, Modifiers, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::app::dialogs::*;
use crate::recording::csv::{Decimal, Delimiter, TimeZero, import as read, preview};

const CSV: &str = "time, a [um], b [um]\n0, 8, 1\n0.001, 8, 2\n0.002, 8, 3\n";

#[derive(Default)]
struct World {
    dialogs: Dialogs,
    answers: Vec<Answer>,
}

fn harness(open: impl FnOnce(&mut Dialogs)) -> Harness<'static, World> {
    let mut world = World::default();
    open(&mut world.dialogs);
    let mut harness = Harness::builder()
        .with_size([1280.0, 720.0])
        .with_step_dt(1.0 / 60.0)
        .build_ui_state(
            |ui, world: &mut World| {
                let answer = world.dialogs.show(ui);
                world.answers.extend(answer);
            },
            world,
        );
    harness.run_steps(4);
    harness
}

fn import(folder: &Path, text: &str) -> Harness<'static, World> {
    let path = folder.join("a.csv");
    std::fs::write(&path, text).unwrap();
    let preview = preview(&path).unwrap();
    harness(|dialogs| dialogs.ask_import(path, preview, None))
}

/// Waits until a thread has made `done` true.
fn wait(harness: &mut Harness<'_, World>, done: impl Fn(&Harness<'_, World>) -> bool) {
    for _ in 0..500 {
        harness.run_steps(2);
        if done(harness) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    panic!("it never came");
}

fn shows(harness: &Harness<'_, World>, part: &str) -> bool {
    harness.query_all_by_label_contains(part).next().is_some()
}

fn combobox(harness: &mut Harness<'_, World>, name: &str, choice: &str) {
    settle(harness, |h| {
        h.get_by_role_and_label(Role::ComboBox, name).rect()
    });
    harness.get_by_role_and_label(Role::ComboBox, name).click();
    harness.run_steps(3);
    settle(harness, |h| {
        h.get_by_role_and_label(Role::Button, choice).rect()
    });
    harness.get_by_role_and_label(Role::Button, choice).click();
    harness.run_steps(3);
}

/// Waits until what `place` says stays: curves that a thread has read move what lies below them.
fn settle(harness: &mut Harness<'_, World>, place: impl Fn(&Harness<'_, World>) -> Rect) {
    let mut still = 0;
    for _ in 0..200 {
        let before = place(harness);
        std::thread::sleep(std::time::Duration::from_millis(5));
        harness.run_steps(2);
        still = if place(harness) == before {
            still + 1
        } else {
            0
        };
        if still == 6 {
            return;
        }
    }
}

fn field<'a>(harness: &'a Harness<'_, World>, role: Role, name: &'a str) -> egui_kittest::Node<'a> {
    harness.get_by_role_and_label(role, name)
}

fn retype(harness: &mut Harness<'_, World>, name: &str, text: &str) {
    field(harness, Role::TextInput, name).focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.run_steps(1);
    field(harness, Role::TextInput, name).type_text(text);
    harness.run_steps(3);
}

#[test]
fn columns_are_chosen_and_imported_with_enter() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = import(folder.path(), CSV);
    assert!(shows(&harness, "Choose a column for the proof mass"));
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert!(harness.state().answers.is_empty(), "nothing is chosen yet");
    combobox(&mut harness, "proof mass column", "b [um]");
    combobox(&mut harness, "time unit", "ms");
    field(&harness, Role::CheckBox, "proof mass inverted").click();
    harness.run_steps(3);
    retype(&mut harness, "time offset", "-2 ms");
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    let [Answer::Import(path, settings)] = &harness.state().answers[..] else {
        panic!("{:?}", harness.state().answers);
    };
    assert!(path.ends_with("a.csv"));
    let mass = settings.proof_mass.as_ref().unwrap();
    assert_eq!((mass.index, mass.unit.as_str()), (2, "um"));
    assert_eq!(settings.time.as_ref().unwrap().unit, "ms");
    assert_eq!(settings.xp_scale, -1.0);
    assert!((settings.time_offset + 2e-3).abs() < 1e-12);
    assert!(!harness.state().dialogs.is_open());
}

#[test]
fn the_zero_of_time_and_the_use_of_its_digits_are_chosen_explained_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let text = "t [s], xp [um]\n5, 1\n5.0013, 2\n5.002, 3\n";
    let mut dialog = import(folder.path(), text);
    for (role, name, part) in [
        (Role::ComboBox, "zero of time", "for example a trigger"),
        (Role::CheckBox, "use times as written", "rounding or jitter"),
    ] {
        field(&dialog, role, name).hover();
        dialog.run_steps(60);
        assert!(shows(&dialog, part), "no hover text of {name}");
    }
    combobox(&mut dialog, "zero of time", "the file's own zero");
    field(&dialog, Role::CheckBox, "use times as written").click();
    dialog.run_steps(3);
    dialog.key_press(Key::Enter);
    dialog.run_steps(3);
    let [Answer::Import(path, settings)] = &dialog.state().answers[..] else {
        panic!("{:?}", dialog.state().answers);
    };
    assert_eq!(settings.time_zero, TimeZero::File);
    assert!(settings.times_as_written);
    let recording = read(path, settings, None).unwrap();
    assert_eq!(recording.time, [5.0, 5.0013, 5.002]);
    // The guessed settings count from the first row.
    let guessed = preview(path).unwrap();
    assert_eq!(guessed.settings.time_zero, TimeZero::FirstRow);
    assert!(!guessed.settings.times_as_written);
    // They are among the settings that are stored, and the dialog shows them again.
    let stored = toml::to_string(settings).unwrap();
    let known = toml::from_str(&stored).unwrap();
    assert_eq!(&known, &**settings);
    let again = harness(|dialogs| dialogs.ask_import(path.clone(), guessed, Some(known)));
    let zero = field(&again, Role::ComboBox, "zero of time");
    let shown = zero.accesskit_node().value();
    assert_eq!(shown.as_deref(), Some("the file's own zero"));
    let written = field(&again, Role::CheckBox, "use times as written");
    assert_eq!(written.accesskit_node().toggled(), Some(Toggled::True));
}

#[test]
fn invalid_values_and_duplicate_columns_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = import(folder.path(), CSV);
    combobox(&mut harness, "proof mass column", "time");
    assert!(shows(&harness, "time and proof mass are the same column"));
    combobox(&mut harness, "proof mass column", "a [um]");
    retype(&mut harness, "time offset", "soon");
    assert!(shows(&harness, "Correct the time offset"));
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert!(harness.state().answers.is_empty());
}

#[test]
fn another_delimiter_splits_the_table_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = import(folder.path(), CSV);
    combobox(&mut harness, "delimiter", "semicolon");
    wait(&mut harness, |harness| shows(harness, "0.001, 8, 2"));
    combobox(&mut harness, "proof mass column", "none");
    combobox(&mut harness, "delimiter", "comma");
    assert!(!shows(&harness, "0.001, 8, 2"));
    combobox(&mut harness, "decimal sign", "comma");
    let dialog = harness.state().dialogs.import.as_ref().unwrap();
    assert_eq!(dialog.settings().delimiter, Delimiter::Comma);
    assert_eq!(dialog.settings().decimal, Decimal::Comma);
}

#[test]
fn escape_and_cancel_close_without_an_answer() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = import(folder.path(), CSV);
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(!harness.state().dialogs.is_open() && harness.state().answers.is_empty());
    let mut harness = import(folder.path(), CSV);
    harness
        .get_by_role_and_label(Role::Button, "Cancel")
        .click();
    harness.run_steps(3);
    assert!(!harness.state().dialogs.is_open() && harness.state().answers.is_empty());
}

#[test]
fn escape_in_a_field_first_ends_the_edit() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = import(folder.path(), CSV);
    retype(&mut harness, "time offset", "1 s");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.state().dialogs.is_open());
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(!harness.state().dialogs.is_open());
}

#[test]
fn a_path_is_completed_and_opened() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("first.csv"), CSV).unwrap();
    std::fs::create_dir(folder.path().join("more")).unwrap();
    let start = folder.path().join("");
    let mut harness = harness(|dialogs| {
        dialogs.path = Some(PathDialog::starting_in(&start, None));
    });
    wait(&mut harness, |harness| shows(harness, "first.csv"));
    // The folder itself is not a file.
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert!(shows(&harness, "this is a folder"));
    let field = harness.get_by_role(Role::TextInput);
    assert!(field.is_focused(), "the next key goes on typing");
    field.type_text("firs");
    wait(&mut harness, |harness| !shows(harness, "more"));
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert!(shows(&harness, "there is no such file"));
    harness
        .get_by_role_and_label(Role::Button, "first.csv")
        .click();
    harness.run_steps(3);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    let opened = folder.path().join("first.csv");
    assert_eq!(harness.state().answers, [Answer::Open(opened)]);
    assert!(!harness.state().dialogs.is_open());
}

#[test]
fn an_absolute_path_typed_after_the_folder_replaces_it() {
    let (start, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let file = elsewhere.path().join("first.csv");
    std::fs::write(&file, CSV).unwrap();
    let mut harness = harness(|dialogs| {
        dialogs.path = Some(PathDialog::starting_in(start.path(), None));
    });
    harness.run_steps(2);
    harness
        .get_by_role(Role::TextInput)
        .type_text(&file.to_string_lossy());
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(harness.state().answers, [Answer::Open(file)]);
}

#[test]
fn an_existing_file_is_replaced_only_when_confirmed() {
    let folder = tempfile::tempdir().unwrap();
    let taken = folder.path().join("mine.impactscope.toml");
    std::fs::write(&taken, "old").unwrap();
    let save = || {
        harness(|dialogs| {
            let purpose = Some(Purpose::Session);
            dialogs.path = Some(PathDialog::starting_in(folder.path(), purpose));
        })
    };
    let type_path = |harness: &mut Harness<'_, World>, name: &str| {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
        harness.run_steps(1);
        let text = folder.path().join(name);
        harness
            .get_by_role(Role::TextInput)
            .type_text(&text.to_string_lossy());
        harness.run_steps(2);
    };
    let mut harness = save();
    type_path(&mut harness, "mine");
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert!(harness.state().answers.is_empty() && shows(&harness, "exists: press Replace"));
    harness
        .get_by_role_and_label(Role::Button, "Replace")
        .click();
    harness.run_steps(3);
    assert_eq!(
        harness.state().answers,
        [Answer::Save(Purpose::Session, taken.clone())]
    );
    // Another name after the question needs its own confirmation.
    let mut harness = save();
    type_path(&mut harness, "mine");
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    type_path(&mut harness, "no/such/folder/x");
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert!(shows(&harness, "there is no such folder"));
    type_path(&mut harness, "new.toml");
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(
        harness.state().answers,
        [Answer::Save(
            Purpose::Session,
            folder.path().join("new.toml")
        )]
    );
    assert_eq!(std::fs::read_to_string(&taken).unwrap(), "old");
}

#[test]
fn the_palette_finds_and_returns_a_command() {
    let mut harness = harness(Dialogs::open_palette);
    harness.get_by_role(Role::TextInput).type_text("plot");
    harness.run_steps(3);
    harness.key_press(Key::ArrowDown);
    harness.run_steps(2);
    harness.get_by_role(Role::TextInput).type_text(": force");
    harness.run_steps(3);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    let forces = Command::TogglePicture(crate::app::setup::view::Picture::Forces);
    assert_eq!(harness.state().answers, [Answer::Command(forces)]);
    assert!(!harness.state().dialogs.is_open());
}

#[test]
fn the_palette_moves_by_arrows_and_closes_by_escape() {
    let mut harness = harness(Dialogs::open_palette);
    for key in [Key::ArrowDown, Key::ArrowDown, Key::ArrowUp] {
        harness.key_press(key);
        harness.run_steps(2);
    }
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    let second = Answer::Command(Command::all()[1]);
    assert_eq!(harness.state().answers, [second]);
    harness.state_mut().dialogs.open_palette();
    harness.run_steps(3);
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(!harness.state().dialogs.is_open() && harness.state().answers.len() == 1);
}

#[test]
fn help_lists_every_command_with_a_key() {
    let mut harness = harness(Dialogs::toggle_help);
    let labels: Vec<String> = harness
        .query_all_by_role(Role::Label)
        .filter_map(|node| node.accesskit_node().value())
        .collect();
    let mut count = 0;
    for command in Command::all() {
        if let Some(keys) = command.keys() {
            count += 1;
            for text in [command.text().0.to_owned(), keys] {
                assert!(labels.contains(&text), "{text} is not among {labels:?}");
            }
        }
    }
    assert!(count > 10);
    assert!(labels.iter().any(|text| text.contains("double-click")));
    harness.key_press(Key::Escape);
    harness.run_steps(30);
    assert!(!harness.state().dialogs.help);
}

#[test]
fn about_names_version_paper_and_licence() {
    let mut harness = harness(Dialogs::open_about);
    for part in [env!("CARGO_PKG_VERSION"), "Oldham", "Licence"] {
        assert!(shows(&harness, part), "{part}");
    }
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(!harness.state().dialogs.about);
}
