//! Whether the channels are connected as their names say: voltage and readings with the right sign,
//! the readings not exchanged, the voltage not that of a monitor, the displacement in the right unit.
//!
//! What a recording shows of slow motion is compared with the model's own run under the same
//! voltage. Means over some periods of the first mode leave what a static device does: how far
//! the mass moves for a volt, on which side the ground holds it, and how much of it the cantilever
//! moves. Of these only signs and orders of magnitude count, which a device with parameters far off
//! has too. Devices without a drive say nothing here.

use crate::fit::error::FitError;
use crate::fit::inspect::channel_noise::noise_of;
use crate::fit::options::Part;
use crate::fit::thresholds::{
    CONNECTION_BLOCK_PERIODS, CONNECTION_MAX_PERIODS, CONNECTION_MAX_RECORDINGS,
    CONNECTION_MIN_BLOCKS, CONNECTION_MIN_CORRELATION, CONNECTION_MIN_SLOW_SHARE,
    CONNECTION_STEPS_PER_PERIOD, EXCHANGED_MARGIN, HYSTERESIS_VOLTAGE_PARTS, KNOWN_VOLTAGE,
    KNOWN_VOLTAGE_MARGIN, MAX_MONITOR_MISFIT, MIN_MONITOR_RATIO, MONITOR_FACTORS,
    OTHER_UNIT_FACTOR,
};
use crate::model::Model;
use crate::model::drive::{VoltageTable, Waveform};
use crate::model::parameter::ParameterId;
use crate::recording::level::estimate_contact_level;
use crate::recording::{Channel, Recording, extremes};
use crate::sim::{Options, simulate};

/// What is wrong with the connections of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    /// The voltage has the wrong sign.
    VoltageInverted,
    /// Displacements are positive downwards.
    ReadingInverted {
        /// Whether those of the cantilever are, too.
        both: bool,
    },
    /// One of both: without contact they are the same.
    OneInverted,
    /// The cantilever's displacement alone is positive downwards.
    CantileverInverted,
    /// The columns of the displacements are exchanged.
    Exchanged,
    /// The voltage is smaller than that at the device by this factor.
    Monitor(f64),
    /// The displacement is too large by this factor.
    Unit(f64),
}

impl Fault {
    /// What was seen, and the option that mends it.
    fn words(self) -> (String, String) {
        let of = |what: &str, remedy: &str| (what.to_owned(), remedy.to_owned());
        match self {
            Self::VoltageInverted => of(
                "the mass moves away from the ground where the device would move towards it, so the voltage is inverted",
                "give --sign V=-1",
            ),
            Self::ReadingInverted { both } => of(
                "the ground holds the mass at its highest reading, so displacements are positive downwards",
                if both {
                    "give --sign xp=-1 --sign xc=-1"
                } else {
                    "give --sign xp=-1"
                },
            ),
            Self::OneInverted => of(
                "the mass follows the voltage in the wrong direction, so the voltage or the displacement is inverted",
                "give --sign V=-1, or --sign xp=-1 (and --sign xc=-1)",
            ),
            Self::CantileverInverted => of(
                "in slow motion xc goes against xp, so it is inverted",
                "give --sign xc=-1",
            ),
            Self::Exchanged => of(
                "in slow motion xc moves more than xp, so the two columns are exchanged",
                "exchange the names xp and xc in the header",
            ),
            Self::Monitor(factor) => (
                format!(
                    "the mass moves as if the voltage were {factor} times larger, so V is that of a 1/{factor} monitor"
                ),
                format!("give --scale V={factor}"),
            ),
            Self::Unit(factor) => (
                format!(
                    "displacements are about {factor} times those that the voltage can cause, so the unit of xp is wrong"
                ),
                format!(
                    "correct the unit in the header, or give --scale xp={}",
                    1.0 / factor
                ),
            ),
        }
    }
}

/// Checks the connections of driven recordings, of a few of them together: a fault counts if each
/// that shows anything shows it.
///
/// # Errors
/// [`FitError::Connection`].
pub fn check_connections(model: &Model, parts: &[Part]) -> Result<(), FitError> {
    let f1 = model.parameters[ParameterId::F1];
    if model.piezo.is_none() || !model.uses(ParameterId::F1) || f1.is_nan() || f1 <= 0.0 {
        return Ok(());
    }
    let mut seen: Option<(&Part, Fault)> = None;
    let judged = parts
        .iter()
        .filter_map(|part| Some((part, judge(model, part, f1)?)));
    for (part, judged) in judged.take(CONNECTION_MAX_RECORDINGS) {
        let kind = std::mem::discriminant::<Fault>;
        match (judged, seen) {
            (None, _) => return Ok(()),
            (Some(fault), Some((_, first))) if kind(&fault) != kind(&first) => return Ok(()),
            (Some(fault), None) => seen = Some((part, fault)),
            (Some(_), Some(_)) => {}
        }
    }
    seen.map_or(Ok(()), |(part, fault)| {
        let (what, remedy) = fault.words();
        Err(FitError::Connection {
            recording: part.recording.name.clone(),
            what,
            remedy,
        })
    })
}

/// Slow motion of both points against the voltage.
struct Slow {
    voltage: Vec<f64>,
    xp: Vec<f64>,
    xc: Option<Vec<f64>>,
}

/// The fault of one recording, `Some(None)` if it is connected rightly, `None` if it says nothing.
fn judge(model: &Model, part: &Part, f1: f64) -> Option<Option<Fault>> {
    let r = &part.recording;
    let range = part.samples.clone();
    let (t0, block) = (r.time[range.start], CONNECTION_BLOCK_PERIODS / f1);
    let end = r.time[range.end - 1].min(t0 + CONNECTION_MAX_PERIODS / f1);
    let count = ((end - t0) / block).floor() as usize;
    let volts = r.voltage.as_deref()?;
    let (low, high) = extremes(&volts[range.clone()]);
    let most = high.max(-low);
    // Another unit of the voltage is said elsewhere.
    if count < CONNECTION_MIN_BLOCKS || most <= KNOWN_VOLTAGE / OTHER_UNIT_FACTOR {
        return None;
    }
    let means = |values: &[f64]| block_means(&r.time, values, (t0, block, count));
    let measured = Slow {
        voltage: means(volts),
        xp: means(&r.proof_mass),
        xc: r.cantilever.as_deref().map(means),
    };
    let spread = deviation(&measured.voltage) / deviation(&volts[range]);
    if spread.is_nan() || spread <= CONNECTION_MIN_SLOW_SHARE {
        return None;
    }
    let table = voltage_table(r, t0, end, f1);
    let run = |scale: f64| simulated(model, &table, scale, (end - t0, f1), (block, count));
    let own = run(1.0)?;
    let (shown, expected) = (
        line(&measured.voltage, &measured.xp)?,
        line(&measured.voltage, &own.xp)?,
    );
    let points = points_fault(model, &measured, &own);
    if let Some(Some(fault @ Fault::Exchanged)) = points {
        return Some(Some(fault));
    }
    let weak = |l: &Line| l.correlation.abs() < CONNECTION_MIN_CORRELATION;
    if weak(&shown) {
        return points;
    }
    let ratio = shown.slope / expected.slope;
    // At a small voltage the film's hysteresis blurs the slow motion or turns it over, so that a
    // monitor's voltage may seem inverted.
    if weak(&expected) || !(0.0..MIN_MONITOR_RATIO).contains(&ratio) {
        let slope_of = |factor: f64| Some(line(&measured.voltage, &run(factor)?.xp)?.slope);
        if let Some(factor) = monitor_factor(shown.slope, most, slope_of) {
            return Some(Some(Fault::Monitor(factor)));
        }
    }
    if weak(&expected) {
        return points;
    }
    if ratio < 0.0 {
        let both = points != Some(Some(Fault::CantileverInverted));
        let strong = most > KNOWN_VOLTAGE / HYSTERESIS_VOLTAGE_PARTS;
        return strong.then(|| Some(inversion(model, r, both)));
    }
    if let Some(Some(fault)) = points {
        return Some(Some(fault));
    }
    let is_unit = |unit: &f64| (ratio / unit).ln().abs() < (1e3 / OTHER_UNIT_FACTOR).ln();
    let unit = [1e3, 1e-3, 1e6, 1e-6].into_iter().find(is_unit);
    Some(unit.map(Fault::Unit))
}

/// The factor by which a voltage up to `most` \[V\] must be larger for the slow motion to have this
/// `slope`, if the factor of a monitor does it. `slope_of` is that of the model.
fn monitor_factor(slope: f64, most: f64, slope_of: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    MONITOR_FACTORS
        .into_iter()
        .filter(|factor| factor * most <= KNOWN_VOLTAGE_MARGIN * KNOWN_VOLTAGE)
        .filter_map(|factor| Some((factor, (slope / slope_of(factor)?).ln().abs())))
        // False for another sign, whose logarithm is no number.
        .filter(|(_, misfit)| *misfit < MAX_MONITOR_MISFIT.ln())
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(factor, _)| factor)
}

/// Whether voltage or displacement is inverted, by the side on which the ground holds the mass.
fn inversion(model: &Model, r: &Recording, both: bool) -> Fault {
    let both = both && r.cantilever.is_some();
    if !model.has_ground {
        return Fault::OneInverted;
    }
    let noise = noise_of(r, Channel::ProofMass).ok();
    let held = |xp: &[f64]| estimate_contact_level(r.axis(), None, xp, noise).is_ok();
    let down: Vec<f64> = r.proof_mass.iter().map(|x| -x).collect();
    match (held(&r.proof_mass), held(&down)) {
        (true, false) => Fault::VoltageInverted,
        (false, true) => Fault::ReadingInverted { both },
        _ => Fault::OneInverted,
    }
}

/// What is wrong with the two displacements against each other; `None` if they say nothing.
fn points_fault(model: &Model, measured: &Slow, own: &Slow) -> Option<Option<Fault>> {
    let (xc, simulated) = (measured.xc.as_ref()?, own.xc.as_ref()?);
    if !model.has_cantilever {
        return None;
    }
    let (shown, expected) = (line(&measured.xp, xc)?, line(&own.xp, simulated)?);
    let least = CONNECTION_MIN_CORRELATION;
    if shown.correlation.abs() < least || expected.correlation.abs() < least {
        return None;
    }
    if shown.slope * expected.slope < 0.0 {
        return Some(Some(Fault::CantileverInverted));
    }
    let (shown, expected) = (shown.slope.abs().ln(), expected.slope.abs().ln());
    let exchanged = (shown + expected).abs() + EXCHANGED_MARGIN.ln() < (shown - expected).abs();
    Some((exchanged && shown > 0.0 && expected < 0.0).then_some(Fault::Exchanged))
}

/// The model's slow motion under `scale` times the voltage; `None` if it cannot be simulated.
fn simulated(
    model: &Model,
    (time, volts): &(Vec<f64>, Vec<f64>),
    scale: f64,
    (duration, f1): (f64, f64),
    (block, count): (f64, usize),
) -> Option<Slow> {
    let scaled = volts.iter().map(|v| scale * v).collect();
    let table = VoltageTable::new("connections", time.clone(), scaled).ok()?;
    let options = Options {
        rate: CONNECTION_STEPS_PER_PERIOD * f1,
        ..Options::default()
    };
    let drive = Waveform::Table(std::sync::Arc::new(table));
    let trace = simulate(model, &drive, duration, &options).ok()?;
    let times = trace.times();
    let means = |values: &[f64]| block_means(&times, values, (0.0, block, count));
    Some(Slow {
        voltage: means(&trace.voltage),
        xp: means(&trace.proof_mass),
        xc: model.has_cantilever.then(|| means(&trace.cantilever)),
    })
}

/// The voltage from `from` to `to` \[s\] at some instants a period of the first mode, counted from
/// its beginning.
fn voltage_table(r: &Recording, from: f64, to: f64, f1: f64) -> (Vec<f64>, Vec<f64>) {
    let step = 1.0 / (CONNECTION_STEPS_PER_PERIOD * f1);
    let count = ((to - from) / step) as usize;
    let at = |k: usize| {
        let t = k as f64 * step;
        Some((t, r.value_at(Channel::Voltage, from + t)?))
    };
    (0..=count).filter_map(at).unzip()
}

/// Means over blocks of time, NaN where there is no sample.
fn block_means(time: &[f64], values: &[f64], (t0, block, count): (f64, f64, usize)) -> Vec<f64> {
    let mut sums = vec![(0.0, 0usize); count];
    for (t, value) in time.iter().zip(values).filter(|(_, v)| v.is_finite()) {
        let at = (t - t0) / block;
        // Also false before the first block.
        if at >= 0.0
            && let Some((sum, n)) = sums.get_mut(at as usize)
        {
            *sum += value;
            *n += 1;
        }
    }
    sums.into_iter().map(|(sum, n)| sum / n as f64).collect()
}

/// A straight line through values against others.
struct Line {
    slope: f64,
    correlation: f64,
}

/// The line of `y` over `x` where both are numbers; `None` for too few or constant ones.
fn line(x: &[f64], y: &[f64]) -> Option<Line> {
    let known: Vec<(f64, f64)> = x
        .iter()
        .zip(y)
        .map(|(x, y)| (*x, *y))
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    if known.len() < CONNECTION_MIN_BLOCKS {
        return None;
    }
    let n = known.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| known.iter().map(of).sum::<f64>() / n;
    let (x0, y0) = (mean(|p| p.0), mean(|p| p.1));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in &known {
        xx += (x - x0) * (x - x0);
        xy += (x - x0) * (y - y0);
        yy += (y - y0) * (y - y0);
    }
    let found = Line {
        slope: xy / xx,
        correlation: xy / (xx * yy).sqrt(),
    };
    (found.slope.is_finite() && found.correlation.is_finite()).then_some(found)
}

/// Standard deviation of those that are numbers, 0 if there are none.
fn deviation(values: &[f64]) -> f64 {
    let finite = || values.iter().filter(|v| v.is_finite());
    let n = finite().count().max(1) as f64;
    let mean = finite().sum::<f64>() / n;
    (finite().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
#[path = "connections_tests.rs"]
mod tests;
