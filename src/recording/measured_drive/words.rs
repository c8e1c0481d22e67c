//! What was found, in words and as typed on the command line.

use super::cycle::Cycle;
use super::knots::Knots;
use super::samples::Samples;
use super::sinusoid::{Sinusoids, begin};
use super::thresholds::MIN_SAID_NOISE_SHARE;
use super::{DriveEdge, Found};
use crate::model::unit::{counted, format_quantity};

/// Digits of a setting.
const SETTING_DIGITS: usize = 6;
/// Digits of an uncertainty.
const ERROR_DIGITS: usize = 2;

/// The plain waveforms that have a name.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Named {
    Square,
    Triangle,
    /// Ramps of this share of a period.
    Ramped(f64),
}

/// The sentence a person reads.
pub fn describe(samples: &Samples<'_>, found: &Found, edges: &[DriveEdge]) -> String {
    let shape = match found {
        Found::Cycle(cycle) => cycle_text(cycle),
        Found::Lines(knots) => lines_text(knots),
        Found::Sinusoids(sinusoids) => sinusoids_text(samples, sinusoids),
        Found::Smooth => format!("no known waveform, smoothed, {}", range(samples)),
        Found::Points | Found::Chosen(_) => format!(
            "{} joined by straight lines, {}",
            counted(samples.len(), "point"),
            range(samples)
        ),
    };
    let mut text = shape;
    let known = edges.iter().map(|e| e.reach).fold(0.0, f64::max);
    if known > 0.0 && !matches!(found, Found::Points) {
        let what = match found {
            Found::Cycle(cycle) if cycle.knots.iter().any(|k| k.jumps()) => "edges",
            Found::Lines(knots) if knots.0.iter().any(|k| k.jumps()) => "edges",
            _ => "turns",
        };
        text += &format!(
            ", {what} known to {}",
            format_quantity(known, "s", ERROR_DIGITS)
        );
    }
    if samples.quantum > 0.0 {
        text += &format!(
            ", read in steps of {}",
            format_quantity(samples.quantum, "V", ERROR_DIGITS)
        );
    } else if samples.sigma > MIN_SAID_NOISE_SHARE * samples.span() {
        text += &format!(
            ", noise {}",
            format_quantity(samples.sigma, "V", ERROR_DIGITS)
        );
    }
    text
}

/// The form of the command line, where the waveform begins at t = 0 and has one.
pub fn command(found: &Found) -> Option<String> {
    match found {
        Found::Cycle(cycle) => {
            let (named, amplitude) = named(cycle)?;
            if cycle.offset != 0.0 || cycle.begin() != 0.0 {
                return None;
            }
            let frequency = 1.0 / cycle.period;
            let frequency = tidy(frequency);
            Some(match named {
                Named::Square => format!("square:{frequency}Hz:{amplitude}V"),
                Named::Triangle => format!("triangle:{frequency}Hz:{amplitude}V"),
                Named::Ramped(share) => {
                    format!("ramped:{frequency}Hz:{amplitude}V:{}", tidy(share))
                }
            })
        }
        Found::Sinusoids(s) => match s.parts[..] {
            [part] if part.rate == 0.0 && s.offset == 0.0 && begin(&part) == 0.0 => {
                Some(format!("sine:{}Hz:{}V", tidy(part.from), part.amplitude))
            }
            _ => None,
        },
        _ => None,
    }
}

/// Without what the last bits of a division leave.
fn tidy(value: f64) -> f64 {
    format!("{value:.12e}").parse().unwrap_or(value)
}

/// The name of a cycle and its amplitude \[V\].
fn named(cycle: &Cycle) -> Option<(Named, f64)> {
    if !cycle.mirrored {
        return None;
    }
    match cycle.knots[..] {
        [knot] if knot.jumps() && knot.before == -knot.after => {
            Some((Named::Square, knot.after.abs()))
        }
        [knot] if !knot.jumps() => Some((Named::Triangle, knot.after.abs())),
        [a, b] if !a.jumps() && !b.jumps() => {
            let half = 0.5 * cycle.period;
            // From the level's end to the next level's start.
            if a.after == b.before {
                Some((
                    Named::Ramped((half - (b.time - a.time)) / cycle.period),
                    a.after.abs(),
                ))
            } else if b.after == -a.before {
                Some((
                    Named::Ramped((b.time - a.time) / cycle.period),
                    b.after.abs(),
                ))
            } else {
                None
            }
        }
        _ => None,
    }
}

fn volts(value: f64) -> String {
    format_quantity(value, "V", SETTING_DIGITS)
}

fn range(samples: &Samples<'_>) -> String {
    format!("{} to {}", volts(samples.range.0), volts(samples.range.1))
}

fn offset_text(offset: f64) -> String {
    if offset == 0.0 {
        String::new()
    } else {
        format!(" about {}", volts(offset))
    }
}

fn begin_text(begin: f64) -> String {
    if begin == 0.0 {
        String::new()
    } else {
        format!(", rises at {}", format_quantity(begin, "s", SETTING_DIGITS))
    }
}

fn cycle_text(cycle: &Cycle) -> String {
    let frequency = format_quantity(1.0 / cycle.period, "Hz", SETTING_DIGITS);
    let begin = begin_text(cycle.begin());
    match named(cycle) {
        Some((named, amplitude)) => {
            let (name, ramp) = match named {
                Named::Square => ("square", String::new()),
                Named::Triangle => ("triangle", String::new()),
                Named::Ramped(share) => ("ramped", format!(", lambda {:.4}", tidy(share))),
            };
            let ramp = ramp.trim_end_matches('0');
            format!(
                "{name} {frequency} \u{b1}{}{}{ramp}{begin}",
                volts(amplitude),
                offset_text(cycle.offset)
            )
        }
        None => {
            let repeats = if cycle.mirrored { 2 } else { 1 };
            format!(
                "{frequency}, {} a period joined by straight lines{begin}",
                counted(repeats * cycle.knots.len(), "corner")
            )
        }
    }
}

fn lines_text(knots: &Knots) -> String {
    let inner = &knots.0[1..knots.0.len() - 1];
    let (first, last) = (knots.0[0], knots.0[knots.0.len() - 1]);
    if inner.is_empty() {
        return if first.after == last.before {
            format!("constant {}", volts(first.after))
        } else {
            format!("ramp from {} to {}", volts(first.after), volts(last.before))
        };
    }
    let levels = knots.0.windows(2).all(|w| w[0].after == w[1].before);
    if levels {
        format!(
            "{} joined by {}",
            counted(inner.len() + 1, "level"),
            counted(inner.len(), "edge")
        )
    } else {
        format!(
            "{} joined by straight lines",
            counted(knots.0.len(), "point")
        )
    }
}

fn sinusoids_text(samples: &Samples<'_>, sinusoids: &Sinusoids) -> String {
    let hertz = |f: f64| format_quantity(f.abs(), "Hz", SETTING_DIGITS);
    let offset = offset_text(sinusoids.offset);
    if let [part] = sinusoids.parts[..] {
        let size = volts(part.amplitude.abs());
        if part.rate == 0.0 {
            return format!(
                "sine {} \u{b1}{size}{offset}{}",
                hertz(part.from),
                begin_text(begin(&part))
            );
        }
        let last = samples.time[samples.len() - 1];
        return format!(
            "sweep from {} to {}, \u{b1}{size}{offset}",
            hertz(part.from + part.rate * samples.time[0]),
            hertz(part.from + part.rate * last)
        );
    }
    let parts: Vec<String> = sinusoids
        .parts
        .iter()
        .map(|p| format!("{} \u{b1}{}", hertz(p.from), volts(p.amplitude.abs())))
        .collect();
    format!("sum of sines {}{offset}", parts.join(" + "))
}
