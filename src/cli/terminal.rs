//! What goes to standard error: errors, warnings, progress and the log. All of it goes through here, because
//! a failure of standard error must not end the work, and because names and cells of files can hold
//! control characters, which a terminal would obey.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{IsTerminal, Write};

/// A text with its control characters, line ends and tabs excepted, in their written form.
pub fn shown(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(2 * text.len());
    for c in text.chars() {
        if obeyed(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// Begins the log, as far as `RUST_LOG` asks for it; errors without it.
pub fn start_log() {
    let level = env_logger::Env::default().default_filter_or("error");
    // There is one already where another program calls this library.
    let _ = env_logger::Builder::from_env(level)
        .format(|out, record| {
            let style = out.default_level_style(record.level());
            let text = record.args().to_string();
            let (level, target) = (record.level(), record.target());
            writeln!(
                out,
                "[{style}{level:<5}{style:#} {target}] {}",
                shown(&text)
            )
        })
        .try_init();
}

/// Says an error.
pub fn error(text: &str) {
    line(&format!("impactscope: {text}"));
}

/// Says a warning.
pub fn warning(text: impl Display) {
    line(&format!("impactscope: warning: {text}"));
}

/// Says a text and ends the line.
pub fn line(text: &str) {
    put(&format!("{}\n", shown(text)));
}

/// Shows how far the work is: on a terminal as one line that changes, in a log as a line of its
/// own, if it is `new` there.
pub fn progress(text: &str, new: bool) {
    if std::io::stderr().is_terminal() {
        put(&format!("\r\x1b[K{}", shown(text)));
    } else if new {
        line(text);
    }
}

/// Clears the progress line, if standard error is a terminal.
pub fn end_of_progress() {
    if std::io::stderr().is_terminal() {
        put("\r\x1b[K");
    }
}

fn put(text: &str) {
    // There is no one left to tell that this failed.
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

#[cfg(test)]
mod tests {
    use super::super::terminal::*;

    #[test]
    fn control_characters_are_written_out() {
        assert_eq!(
            shown("a\u{1b}[2J\r\u{7}\u{9b}b\u{0}"),
            "a\\u{1b}[2J\\r\\u{7}\\u{9b}b\\u{0}"
        );
        let harmless = "\u{b5}m\tone\ntwo \\ \"three\"";
        assert!(matches!(shown(harmless), Cow::Borrowed(same) if same == harmless));
    }
}
