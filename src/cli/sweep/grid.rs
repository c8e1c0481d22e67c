//! The texts of `--grid`, `--over`, `--measure` and `--want`.

use anyhow::{Context, anyhow, bail};

use crate::explore::map::Axis;
use crate::explore::measures::{MEASURES, MeasureId, Regime};
use crate::explore::robustness::{CoefficientRange, MeasureBound, Wish};
use crate::explore::waveform;
use crate::model::Model;
use crate::model::drive::Waveform;
use crate::model::unit::parse_quantity;

/// Sign of a multiple of the device's value.
const MULTIPLE_SIGN: char = 'x';
/// Mark of a logarithmic axis.
const LOGARITHMIC: &str = "log";
/// Mark of a range in which equal differences are equally likely.
const LINEAR: &str = "linear";
/// Largest code of a regime and more.
const REGIME_CODES: std::ops::Range<u32> = 0..64;

/// Axes of `--grid`.
pub fn axes(text: &str, model: &Model, drive: &Waveform) -> anyhow::Result<Vec<Axis>> {
    let parts = text
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty());
    let axes = parts.map(|part| axis(part, model, drive).with_context(|| format!("--grid {part}")));
    axes.collect()
}

/// `f=5:100:20Hz`, with `:log` if it is logarithmic.
fn axis(text: &str, model: &Model, drive: &Waveform) -> anyhow::Result<Axis> {
    let form = || anyhow!("write ID=FROM:TO:COUNT[UNIT][:log], for example f=5:100:20Hz");
    let (id, range) = text.split_once('=').ok_or_else(form)?;
    let fields: Vec<&str> = range.split(':').map(str::trim).collect();
    let (from, to, count, is_logarithmic) = match fields.as_slice() {
        [from, to, count] => (*from, *to, *count, false),
        [from, to, count, LOGARITHMIC] => (*from, *to, *count, true),
        _ => return Err(form()),
    };
    let digits = count.trim_start_matches(|c: char| c.is_ascii_digit());
    let (count, unit) = count.split_at(count.len() - digits.len());
    let count = count.parse().map_err(|_| {
        anyhow!("\"{count}{unit}\" has no number of points; write for example 20Hz for 20 points")
    })?;
    // Ranges that are offered pass the check; the id decides on the unit.
    let mut axis = Axis::offered(id.trim(), (model, drive), count)?;
    let own = waveform::get(drive, &axis.id).or_else(|| model.get(&axis.id));
    let value = |text| value(text, unit.trim(), &axis.unit, own);
    (axis.from, axis.to) = (value(from)?, value(to)?);
    axis.is_logarithmic = is_logarithmic;
    axis.check()?;
    Ok(axis)
}

/// `0.5x` as a multiple of `own`, or a quantity in `unit` or its own one.
fn value(text: &str, unit: &str, base: &str, own: Option<f64>) -> anyhow::Result<f64> {
    if let Some(factor) = multiple(text) {
        return match own {
            Some(own) if own != 0.0 => Ok(factor * own),
            _ => bail!("{text} is a multiple of 0; write a value"),
        };
    }
    let is_plain = text.parse::<f64>().is_ok();
    let text = if is_plain {
        format!("{text}{unit}")
    } else {
        text.to_owned()
    };
    Ok(parse_quantity(&text, base)?)
}

fn multiple(text: &str) -> Option<f64> {
    let factor = text
        .trim()
        .strip_suffix(MULTIPLE_SIGN)?
        .parse::<f64>()
        .ok()?;
    factor.is_finite().then_some(factor)
}

/// Ranges of `--over`, each option with one or several.
pub fn ranges(texts: &[String], model: &Model) -> anyhow::Result<Vec<CoefficientRange>> {
    let parts = texts.iter().flat_map(|text| text.split(','));
    let parts = parts.map(str::trim).filter(|part| !part.is_empty());
    let ranges = parts.map(|part| range(part, model).with_context(|| format!("--over {part}")));
    ranges.collect()
}

/// `Cs:0.5x..2x`, with `:linear` if equal differences are equally likely.
fn range(text: &str, model: &Model) -> anyhow::Result<CoefficientRange> {
    let form = || anyhow!("write ID:LOW..HIGH, for example Cs:0.5x..2x");
    let (id, bounds) = text.split_once(':').ok_or_else(form)?;
    let (bounds, is_logarithmic) = match bounds.rsplit_once(':') {
        Some((bounds, LINEAR)) => (bounds, false),
        Some((bounds, LOGARITHMIC)) => (bounds, true),
        Some(_) => return Err(form()),
        None => (bounds, true),
    };
    let (low, high) = bounds.split_once("..").ok_or_else(form)?;
    // Finds the spelling of the table, or lists the ids.
    let found = Axis::offered(id.trim(), (model, &Waveform::Rest), 2)?;
    let is_relative = multiple(low).is_some();
    if is_relative != multiple(high).is_some() {
        bail!("one bound is a multiple, the other is not; write both with {MULTIPLE_SIGN} or none");
    }
    let bound = |text: &str| match multiple(text) {
        Some(factor) => Ok(factor),
        None => parse_quantity(text, &found.unit),
    };
    Ok(CoefficientRange {
        low: bound(low)?,
        high: bound(high)?,
        id: found.id.clone(),
        is_relative,
        is_logarithmic,
    })
}

/// Measures of `--measure`.
pub fn measures(text: &str) -> anyhow::Result<Vec<MeasureId>> {
    let ids = text.split(',').map(str::trim).filter(|id| !id.is_empty());
    let all: Vec<MeasureId> = ids
        .map(|id| measure(id).with_context(|| format!("--measure {id}")))
        .collect::<anyhow::Result<_>>()?;
    if all.is_empty() {
        bail!("--measure names no measure; write for example --measure contact,regime, or omit it");
    }
    Ok(all)
}

fn measure(id: &str) -> anyhow::Result<MeasureId> {
    let long = match id {
        "contact" => "contact_share",
        other => other,
    };
    MeasureId::from_id(long).ok_or_else(|| {
        let known: Vec<&str> = MEASURES.iter().map(|row| row.id).collect();
        anyhow!("there is no measure {id}; there are {}", known.join(", "))
    })
}

/// The wish of `--want`.
pub fn wish(texts: &[String]) -> anyhow::Result<Wish> {
    let mut wish = Wish::default();
    for text in texts {
        let option = || format!("--want {text}");
        let Some((id, wanted)) = text.split_once('=') else {
            bail!(
                "{}: write regime=sticks, or MEASURE=LOW..HIGH such as contact=0.3..0.4",
                option()
            );
        };
        let measure = measure(id.trim()).with_context(option)?;
        if measure == MeasureId::Regime {
            wish.regimes.push(regime(wanted).with_context(option)?);
            continue;
        }
        let Some((low, high)) = wanted.split_once("..") else {
            bail!("{}: write LOW..HIGH; one of them may be empty", option());
        };
        let unit = measure.spec().unit;
        let bound = |text: &str| match text.trim() {
            "" => Ok(None),
            text => parse_quantity(text, unit).map(Some).with_context(option),
        };
        wish.bounds.push(MeasureBound {
            measure,
            low: bound(low)?,
            high: bound(high)?,
        });
    }
    Ok(wish)
}

/// A regime by its label, without spaces and commas.
fn regime(text: &str) -> anyhow::Result<Regime> {
    let squeezed = |text: &str| {
        let letters = text.chars().filter(char::is_ascii_alphanumeric);
        letters.collect::<String>().to_ascii_lowercase()
    };
    let all: Vec<Regime> = REGIME_CODES.filter_map(Regime::from_code).collect();
    let found = all
        .iter()
        .find(|own| squeezed(&own.label()) == squeezed(text));
    found.copied().ok_or_else(|| {
        let known: Vec<String> = all
            .iter()
            .map(|own| format!("\"{}\"", own.label()))
            .collect();
        anyhow!(
            "there is no regime \"{text}\"; there are {}",
            known.join(", ")
        )
    })
}
