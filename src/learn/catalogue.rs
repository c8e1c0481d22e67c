//! The lessons that come with the program, one data file each, in the order in which they are
//! offered.

use super::lesson::Lesson;

/// File names and texts.
pub const EMBEDDED: [(&str, &str); 1] = [(
    "bouncing-ball.toml",
    include_str!("../../assets/lessons/bouncing-ball.toml"),
)];

/// The lessons. A test reads every one of them.
pub fn lessons() -> Vec<Lesson> {
    let read = EMBEDDED
        .iter()
        .filter_map(|(name, text)| Lesson::parse(name, text).ok());
    read.collect()
}
