//! Sentences and numbers that the summary and the page share.

use crate::diagnose::diagnosis::{
    Candidate, Diagnosis, Estimate, Mismatch, NextExperiment, Quantity, Regime, Verdict,
};
use crate::model::effects::find;
use crate::model::unit::{format_number, format_quantity, prefix_for};

impl Regime {
    /// For people.
    pub fn text(self) -> &'static str {
        match self {
            Self::FarFlight => "far flight",
            Self::NearGroundApproach => "near the ground, coming down",
            Self::NearGroundDeparture => "near the ground, going up",
            Self::Impact => "impact",
            Self::Contact => "contact",
            Self::Release => "release",
        }
    }

    /// Where in the motion, as the end of a sentence.
    pub fn place(self) -> &'static str {
        match self {
            Self::FarFlight => "in far flight",
            Self::NearGroundApproach => "near the ground, coming down",
            Self::NearGroundDeparture => "near the ground, going up",
            Self::Impact => "at impacts",
            Self::Contact => "in contact",
            Self::Release => "at releases",
        }
    }
}

impl Verdict {
    /// For people.
    pub fn text(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::MissingPhysics => "missing physics",
            Self::PartlyExplained => "partly explained",
            Self::Unexplained => "unexplained",
        }
    }
}

impl Quantity {
    /// For people.
    pub fn text(self) -> &'static str {
        match self {
            Self::Displacement => "the displacement xp",
            Self::Velocity => "the velocity xp'",
            Self::Voltage => "the voltage V",
            Self::Time => "time",
        }
    }
}

/// What the curves with the named effects are called.
pub fn with_named(d: &Diagnosis) -> &'static str {
    if d.named.len() > 1 {
        "with the new effects"
    } else {
        "with the new effect"
    }
}

/// `a`, `a and b`, `a, b and c`.
pub fn listed(items: &[&str]) -> String {
    match items {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// The text with its first letter in upper case.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}

/// A probability in percent, with no more certainty than the digits show.
pub fn probability(p: f64) -> String {
    if !p.is_finite() {
        return "-".to_owned();
    }
    match 100.0 * p {
        p if p >= 99.95 => "> 99.9 %".to_owned(),
        p if p <= 0.0 => "0 %".to_owned(),
        p if p < 0.1 => "< 0.1 %".to_owned(),
        p if p < 10.0 => format!("{p:.1} %"),
        p if p > 99.0 => format!("{p:.1} %"),
        p => format!("{p:.0} %"),
    }
}

/// A parameter with its standard error: `102.3 ± 1.2 µs`.
pub fn with_error(estimate: &Estimate) -> String {
    let Estimate {
        value,
        std_error,
        unit,
        ..
    } = estimate;
    if !value.is_finite() {
        return "not determined by these recordings".to_owned();
    }
    if !(std_error.is_finite() && *std_error > 0.0) {
        return format!(
            "{} (error not determined)",
            format_quantity(*value, unit, 3)
        );
    }
    let largest = value.abs().max(*std_error);
    let (prefix, mut factor) = prefix_for(largest, unit);
    let mut power = 0;
    // Units that take no prefix get a power of ten that both numbers share.
    if !(1e-2..1e5).contains(&(largest / factor)) {
        power = largest.log10().floor() as i32;
        factor = 10f64.powi(power);
    }
    let (v, e) = (value / factor, std_error / factor);
    // Two digits of the error are enough.
    let decimals = (1.0 - e.log10().floor()).clamp(0.0, 9.0) as usize;
    let both = format!("{v:.decimals$} \u{b1} {e:.decimals$}");
    let unit = format!("{prefix}{unit}");
    let space = if unit.is_empty() { "" } else { " " };
    if power == 0 {
        format!("{both}{space}{unit}")
    } else {
        format!("({both})e{power}{space}{unit}")
    }
}

/// The largest force of an effect.
pub fn size(newton: f64) -> String {
    if newton.is_finite() {
        format_quantity(newton, "N", 3)
    } else {
        "none".to_owned()
    }
}

/// A distance, or a dash.
pub fn metres(value: f64) -> String {
    number_or_dash(value, |v| format_quantity(v, "m", 3))
}

/// A number between -1 and 1 to two digits, or a dash.
pub fn two_digits(value: f64) -> String {
    number_or_dash(value, |v| unsigned_zero(format!("{v:.2}")))
}

/// The text without the sign of a number that was rounded to zero.
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

/// Fall of chi2 on the fitted recordings; the predicted one if the effect was not fitted.
pub fn gain_where_fitted(c: &Candidate) -> String {
    if c.gain.is_finite() {
        gain(c.gain)
    } else if c.score.is_finite() {
        format!("about {}", gain(c.score))
    } else {
        "-".to_owned()
    }
}

/// A fall of chi2: whole numbers, for fractions of it mean nothing.
pub fn gain(value: f64) -> String {
    number_or_dash(value, |v| {
        if v.abs() < 1e5 {
            unsigned_zero(format!("{v:.0}"))
        } else {
            format_number(v, 3)
        }
    })
}

/// `length` in units of the noise: `15.6 x noise`.
pub fn in_noise(length: f64, noise: f64) -> String {
    number_or_dash(length / noise, |v| format!("{} x noise", ratio(v)))
}

/// A mean square in units of the noise's, or a dash.
pub fn chi2(value: f64) -> String {
    number_or_dash(value, ratio)
}

/// A ratio whose likeness to 1 matters: always two decimals near it.
fn ratio(value: f64) -> String {
    match value.abs() {
        v if v < 10.0 => format!("{value:.2}"),
        v if v < 100.0 => format!("{value:.1}"),
        v if v < 1e6 => format!("{value:.0}"),
        _ => format_number(value, 3),
    }
}

fn number_or_dash(value: f64, write: impl Fn(f64) -> String) -> String {
    if value.is_finite() {
        write(value)
    } else {
        "-".to_owned()
    }
}

/// The span of time of a mismatch, in milliseconds.
pub fn time_span(m: &Mismatch) -> String {
    // As many digits as the length of the span deserves.
    let decimals = if m.end - m.start < 1e-3 { 2 } else { 1 };
    format!(
        "{:.decimals$} to {:.decimals$} ms",
        1e3 * m.start,
        1e3 * m.end
    )
}

/// A share in percent; next to none and nearly all are not rounded to none and all.
pub fn share(value: f64) -> String {
    number_or_dash(value, |v| match 100.0 * v {
        p if p > 0.0 && p < 0.5 => "< 1 %".to_owned(),
        p if (99.5..100.0).contains(&p) => "> 99 %".to_owned(),
        p => format!("{p:.0} %"),
    })
}

/// The name of the effect with this id; the id itself if there is none.
pub fn effect_name(id: &str) -> &str {
    find(id).map_or(id, |spec| spec.name)
}

/// The effects that it cannot be distinguished from, as a sentence; they share its probability.
pub fn alike(ids: &[String]) -> Option<String> {
    let names: Vec<&str> = ids.iter().map(|id| effect_name(id)).collect();
    (!names.is_empty()).then(|| {
        format!(
            "These recordings cannot distinguish it from {}.",
            listed(&names)
        )
    })
}

/// What the next experiment would distinguish, as the end of a sentence.
pub fn would_distinguish(next: &NextExperiment) -> String {
    let name = |id: &str| find(id).map_or("the model without it", |spec| spec.name);
    format!(
        "{} s of it would distinguish {} from {}",
        NextExperiment::DURATION,
        name(&next.separates.0),
        name(&next.separates.1)
    )
}

/// Why no experiment is proposed.
pub fn no_experiment(d: &Diagnosis) -> &'static str {
    // An effect that was fitted and helps could be distinguished from another, or from nothing.
    let helps = d.candidates.iter().any(|c| c.gain > 0.0);
    if d.model.piezo.is_none() {
        "This device has no drive, so no experiment can be proposed."
    } else if d.remaining.is_some() {
        "No drive is known that shows what remains better: record other amplitudes and frequencies."
    } else if helps {
        "No further recording is needed to distinguish the candidates."
    } else {
        "No experiment is proposed: there are no two candidates to distinguish."
    }
}

#[cfg(test)]
mod tests {
    use super::super::words::*;

    fn estimate(value: f64, std_error: f64, unit: &'static str) -> String {
        with_error(&Estimate {
            id: "x".to_owned(),
            value,
            std_error,
            unit,
        })
    }

    #[test]
    fn errors_have_two_digits_and_values_as_many_as_they_deserve() {
        assert_eq!(
            estimate(102.34e-6, 1.23e-6, "s"),
            "102.3 \u{b1} 1.2 \u{b5}s"
        );
        assert_eq!(estimate(0.05, 0.0021, ""), "0.0500 \u{b1} 0.0021");
        assert_eq!(
            estimate(1.0234e-7, 1.2e-9, "N s^2/m^2"),
            "(1.023 \u{b1} 0.012)e-7 N s^2/m^2"
        );
        assert_eq!(estimate(-3.1e4, 220.0, "N/m^3"), "-31000 \u{b1} 220 N/m^3");
        assert_eq!(
            estimate(2.0, f64::INFINITY, "V"),
            "2 V (error not determined)"
        );
        assert_eq!(
            estimate(f64::NAN, 1.0, "V"),
            "not determined by these recordings"
        );
        // An error larger than the value is written as such.
        assert_eq!(estimate(1e-9, 5e-9, "N"), "1.0 \u{b1} 5.0 nN");
    }

    #[test]
    fn probabilities_do_not_boast() {
        for (p, text) in [
            (1.0, "> 99.9 %"),
            (0.9978, "99.8 %"),
            (0.5, "50 %"),
            (0.031, "3.1 %"),
            (2e-7, "< 0.1 %"),
            (f64::NAN, "-"),
        ] {
            assert_eq!(probability(p), text);
        }
    }

    #[test]
    fn shares_do_not_round_to_none_or_all() {
        let all = [0.0, 0.003, 0.18, 0.996, 1.0].map(share);
        assert_eq!(all, ["0 %", "< 1 %", "18 %", "> 99 %", "100 %"]);
    }

    #[test]
    fn nothing_has_no_sign() {
        assert_eq!(gain(-0.3), "0");
        assert_eq!(gain(-7.6), "-8");
        assert_eq!(two_digits(-0.001), "0.00");
        assert_eq!(two_digits(-0.012), "-0.01");
    }

    #[test]
    fn lists() {
        assert_eq!(listed(&["a", "b", "c"]), "a, b and c");
        assert_eq!(capitalised(&listed(&["late readings"])), "Late readings");
    }
}
