//! A standard waveform as handles.

use super::error::{WaveformError, named};
use crate::model::drive::{
    Cycle, Handle, Handles, Interpolation, MAX_HANDLES, PeriodicDrive, Segment, Shape, Waveform,
};

/// Instants that differ by less than this share of a period are one.
const SAME_INSTANT: f64 = 1e-9;

/// Fewest handles of a curved period: turning points and one between each two.
const FEWEST_OF_CURVE: usize = 4;

/// Offset, phase, bursts and frequency of a waveform, and its cycle as handles.
///
/// # Errors
/// [`WaveformError::NoPeriod`], or [`WaveformError::Drive`] if it has too many corners.
pub(super) fn drawn_drive(
    waveform: &Waveform,
    per_period: usize,
) -> Result<(PeriodicDrive, Handles), WaveformError> {
    let no_period = || WaveformError::NoPeriod {
        drive: named(waveform),
        action: "draw on",
    };
    let Some(drive) = PeriodicDrive::of(waveform) else {
        let period = waveform.period().ok_or_else(no_period)?;
        let handles = handles_of(waveform, period, per_period)?;
        // Only the frequency counts: a table has no other modifiers.
        let plain = PeriodicDrive::new(Cycle::Sine { amplitude: 0.0 }, 1.0 / period);
        return Ok((plain, handles));
    };
    if let Cycle::Drawn(handles) = &drive.cycle {
        let handles = Handles::clone(handles);
        return Ok((drive, handles));
    }
    let plain = PeriodicDrive::new(drive.cycle.clone(), 1.0).waveform()?;
    let handles = handles_of(&plain, 1.0, per_period)?;
    Ok((drive, handles))
}

fn handles_of(
    waveform: &Waveform,
    period: f64,
    per_period: usize,
) -> Result<Handles, WaveformError> {
    // The second period: the first one may be entered differently.
    let segments = segments_from(waveform, period, 2.0 * period);
    let is_curved = |s: &Segment| !matches!(s.shape, Shape::Constant { .. } | Shape::Line { .. });
    let curves = segments.iter().filter(|s| is_curved(s)).count();
    let parts = per_period.clamp(FEWEST_OF_CURVE, MAX_HANDLES) / curves.max(1);
    let (mut led_over, mut points) = (Vec::new(), Vec::new());
    for segment in &segments {
        let parts = if is_curved(segment) { parts.max(2) } else { 1 };
        for i in 0..=parts {
            let t = segment.start + (segment.end - segment.start) * i as f64 / parts as f64;
            let share = t / period - 1.0;
            let voltage = segment.shape.voltage(t);
            // What leads over the end belongs to the start, before what begins there.
            if share > 1.0 + SAME_INSTANT {
                let time = (share - 1.0).min(1.0);
                led_over.push(Handle { time, voltage });
            } else {
                let time = share.clamp(0.0, 1.0);
                points.push(Handle { time, voltage });
            }
        }
    }
    led_over.append(&mut points);
    led_over.sort_by(|a, b| {
        if (a.time - b.time).abs() < SAME_INSTANT {
            std::cmp::Ordering::Equal
        } else {
            a.time.total_cmp(&b.time)
        }
    });
    let kind = if curves > 0 {
        Interpolation::Smooth
    } else {
        Interpolation::Linear
    };
    Ok(Handles::new(without_repetitions(led_over), kind)?)
}

/// The segments that start from `from` until before `to` \[s\].
fn segments_from(waveform: &Waveform, from: f64, to: f64) -> Vec<Segment> {
    let slack = SAME_INSTANT * (to - from);
    let mut segments = Vec::new();
    let mut index = waveform.index_at(from).saturating_sub(1);
    // One more than allowed, so that too many are refused.
    while segments.len() <= MAX_HANDLES {
        let segment = waveform.segment(index);
        if segment.start >= to - slack || !segment.end.is_finite() {
            break;
        }
        if segment.start >= from - slack && segment.end > segment.start + slack {
            segments.push(segment);
        }
        index += 1;
    }
    segments
}

/// Ends and starts that fall together are one handle; so are the two ends of the period.
fn without_repetitions(points: Vec<Handle>) -> Vec<Handle> {
    let scale = points.iter().fold(0.0f64, |a, p| a.max(p.voltage.abs()));
    let is_same = |a: f64, b: f64| (a - b).abs() <= SAME_INSTANT * scale;
    let mut kept: Vec<Handle> = Vec::with_capacity(points.len());
    for mut point in points {
        if let Some(last) = kept.last()
            && point.time - last.time < SAME_INSTANT
        {
            point.time = last.time;
            if is_same(last.voltage, point.voltage) {
                continue;
            }
        }
        kept.push(point);
    }
    if let (Some(first), Some(last)) = (kept.first().copied(), kept.last().copied())
        && kept.len() > 1
        && last.time - first.time >= 1.0
        && is_same(first.voltage, last.voltage)
    {
        kept.pop();
    }
    kept
}
