//! The lessons that come with the program, one data file each, in the order in which they are
//! offered.

use super::lesson::Lesson;

/// File names and texts.
pub const EMBEDDED: [(&str, &str); 10] = [
    (
        "bouncing-ball.toml",
        include_str!("../../assets/lessons/bouncing-ball.toml"),
    ),
    (
        "squeeze-film.toml",
        include_str!("../../assets/lessons/squeeze-film.toml"),
    ),
    (
        "bounce-or-stick.toml",
        include_str!("../../assets/lessons/bounce-or-stick.toml"),
    ),
    (
        "stiction.toml",
        include_str!("../../assets/lessons/stiction.toml"),
    ),
    (
        "hysteresis-loop.toml",
        include_str!("../../assets/lessons/hysteresis-loop.toml"),
    ),
    (
        "resonance.toml",
        include_str!("../../assets/lessons/resonance.toml"),
    ),
    (
        "ring-down.toml",
        include_str!("../../assets/lessons/ring-down.toml"),
    ),
    (
        "walking-waveform.toml",
        include_str!("../../assets/lessons/walking-waveform.toml"),
    ),
    (
        "fit-by-hand.toml",
        include_str!("../../assets/lessons/fit-by-hand.toml"),
    ),
    (
        "concealed-effect.toml",
        include_str!("../../assets/lessons/concealed-effect.toml"),
    ),
];

/// The lessons. A test reads every one of them.
pub fn lessons() -> Vec<Lesson> {
    let read = EMBEDDED
        .iter()
        .filter_map(|(name, text)| Lesson::parse(name, text).ok());
    read.collect()
}
