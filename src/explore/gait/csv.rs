//! A gait as CSV.

use std::fmt::Write;

use super::timeline::Gait;

/// A field with commas or quotes in quotes (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

/// The contacts over the common cycle, one row each: foot, delay, share of the time down, begin
/// and end \[s\]. A contact that goes on over the end of the cycle ends after it. A foot that
/// never touches has a row without times.
#[must_use]
pub fn contacts_csv(gait: &Gait) -> String {
    let mut text = String::from("foot,delay,duty factor,start [s],end [s]\n");
    for (i, bars) in gait.bars.iter().enumerate() {
        let (name, delay, duty) = (quoted(&gait.names[i]), gait.delays[i], gait.duty_factors[i]);
        let mut row = |times: &str| {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name},{delay},{duty},{times}");
        };
        if bars.is_empty() {
            row(",");
        }
        let is_whole = |start: f64, end: f64| start <= 0.0 && end >= 1.0;
        let wrapped = bars
            .first()
            .filter(|b| b.is_from_before && !is_whole(b.start, b.end));
        for bar in bars {
            if wrapped == Some(bar) {
                // It is written where it begins.
                continue;
            }
            let over_the_end = wrapped
                .filter(|_| bar.goes_on)
                .map_or(0.0, |first| first.end);
            let (start, end) = (bar.start, bar.end + over_the_end);
            row(&format!("{},{}", start * gait.cycle, end * gait.cycle));
        }
    }
    text
}

/// How many feet are down over the common cycle: begin and end \[s\], feet.
#[must_use]
pub fn support_csv(gait: &Gait) -> String {
    let mut text = String::from("start [s],end [s],feet down\n");
    for part in &gait.support {
        let (start, end) = (part.start * gait.cycle, part.end * gait.cycle);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{start},{end},{}", part.feet);
    }
    text
}
