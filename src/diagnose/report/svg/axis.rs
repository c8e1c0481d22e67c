//! Axes: range, ticks, units.

use crate::model::unit::{format_number, prefix_for};

/// A step above 1-2-5 for one that is a little too small.
const STEPS: [f64; 4] = [1.0, 2.0, 5.0, 10.0];

/// An axis, linear or logarithmic, in a unit with a prefix that suits its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    name: String,
    unit: String,
    /// SI per unit shown.
    factor: f64,
    from: f64,
    to: f64,
    log: bool,
}

impl Axis {
    /// A linear axis around the finite ones of `values`, SI, with a margin.
    pub fn linear(name: &str, unit: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let (mut from, mut to) = extent(values, |_| true).unwrap_or((0.0, 1.0));
        let margin = 0.04 * (to - from);
        if margin > 0.0 {
            // An axis that begins at zero stays there.
            from = if from == 0.0 { 0.0 } else { from - margin };
            to = if to == 0.0 { 0.0 } else { to + margin };
        } else {
            let half = if from == 0.0 { 1.0 } else { 0.5 * from.abs() };
            (from, to) = (from - half, to + half);
        }
        Self::new(name, unit, from, to, false)
    }

    /// A linear axis over exactly this range.
    pub fn exact(name: &str, unit: &str, from: f64, to: f64) -> Self {
        if from.is_finite() && to > from {
            Self::new(name, unit, from, to, false)
        } else {
            Self::linear(name, unit, [from, to])
        }
    }

    /// A logarithmic axis around the positive ones of `values`.
    pub fn log(name: &str, unit: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let (from, to) = extent(values, |v| v > 0.0).unwrap_or((0.1, 10.0));
        // At least half a decade, or the ticks say nothing.
        let room = (1.8 * from / to).sqrt().max(1.12);
        Self::new(name, unit, from / room, to * room, true)
    }

    fn new(name: &str, unit: &str, from: f64, to: f64, log: bool) -> Self {
        let (prefix, factor) = prefix_for(from.abs().max(to.abs()), unit);
        Self {
            name: name.to_owned(),
            unit: format!("{prefix}{unit}"),
            factor,
            from,
            to,
            log,
        }
    }

    /// The least value shown, SI.
    pub fn from(&self) -> f64 {
        self.from
    }

    /// The greatest value shown, SI.
    pub fn to(&self) -> f64 {
        self.to
    }

    /// Place of a value, 0 at the least, 1 at the greatest; beyond them the nearer one;
    /// NaN for NaN. On a logarithmic axis all that is not positive lies at the least.
    pub fn place(&self, value: f64) -> f64 {
        if value.is_nan() {
            return f64::NAN;
        }
        let share = if self.log {
            if value <= 0.0 {
                return 0.0;
            }
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        };
        share.clamp(0.0, 1.0)
    }

    /// Name with unit: `xp [µm]`.
    pub fn title(&self) -> String {
        if self.unit.is_empty() {
            self.name.clone()
        } else {
            format!("{} [{}]", self.name, self.unit)
        }
    }

    /// About `count` ticks: value (SI) and label (in the unit shown).
    pub fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        let (from, to) = (self.from / self.factor, self.to / self.factor);
        let values = if self.log {
            log_ticks(from, to, count)
        } else {
            linear_ticks(from, to, count)
        };
        values
            .into_iter()
            .map(|(v, label)| (v * self.factor, label))
            .collect()
    }
}

fn extent(values: impl IntoIterator<Item = f64>, also: impl Fn(f64) -> bool) -> Option<(f64, f64)> {
    values
        .into_iter()
        .filter(|v| v.is_finite() && also(*v))
        .fold(None, |range, v| {
            let (low, high) = range.unwrap_or((v, v));
            Some((f64::min(low, v), f64::max(high, v)))
        })
}

fn linear_ticks(from: f64, to: f64, count: usize) -> Vec<(f64, String)> {
    let rough = (to - from) / count.max(1) as f64;
    let decade = 10f64.powf(rough.log10().floor());
    let step = decade
        * STEPS
            .into_iter()
            .find(|s| s * decade >= 0.999 * rough)
            .unwrap_or(10.0);
    let (first, last) = ((from / step - 1e-9).ceil(), (to / step + 1e-9).floor());
    if !(step > 0.0 && last - first < 100.0) {
        return Vec::new();
    }
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    // Numbers that would be too long to stand side by side get a power of ten.
    let long = !(1e-4..1e6).contains(&from.abs().max(to.abs()));
    (first as i64..=last as i64)
        .map(|i| {
            let v = i as f64 * step;
            let label = if long {
                format_number(v, 3)
            } else {
                format!("{v:.decimals$}")
            };
            (v, label)
        })
        .collect()
}

fn log_ticks(from: f64, to: f64, count: usize) -> Vec<(f64, String)> {
    let decades = (to / from).log10();
    let within: &[f64] = if decades < 0.9 {
        &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]
    } else if decades * 3.0 <= count as f64 + 2.0 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let every = (decades / count.max(1) as f64).ceil().max(1.0) as i32;
    let (low, high) = (from.log10().floor() as i32, to.log10().ceil() as i32);
    (low..=high)
        .filter(|d| d.rem_euclid(every) == 0)
        .flat_map(|d| within.iter().map(move |m| m * 10f64.powi(d)))
        .filter(|v| (0.9999 * from..=1.0001 * to).contains(v))
        .map(|v| (v, format_number(v, 2)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::axis::*;

    fn labels(axis: &Axis, count: usize) -> Vec<String> {
        axis.ticks(count).into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_and_in_a_unit_that_suits() {
        let axis = Axis::exact("xp", "m", -60e-6, 62e-6);
        assert_eq!(axis.title(), "xp [\u{b5}m]");
        assert_eq!(labels(&axis, 6), ["-50", "0", "50"]);
        assert_eq!(
            labels(&axis, 7),
            ["-60", "-40", "-20", "0", "20", "40", "60"]
        );
        let time = Axis::exact("t", "s", 0.0, 0.05);
        assert_eq!(time.title(), "t [ms]");
        assert_eq!(labels(&time, 5), ["0", "10", "20", "30", "40", "50"]);
        let plain = Axis::exact("ratio", "", 0.1, 0.4);
        assert_eq!(plain.title(), "ratio");
        assert_eq!(labels(&plain, 4), ["0.1", "0.2", "0.3", "0.4"]);
    }

    #[test]
    fn decades() {
        let axis = Axis::log("rms", "m", [7e-9, 12e-6]);
        assert_eq!(labels(&axis, 5), ["0.01", "0.1", "1", "10"]);
        assert!(axis.place(7e-9) > 0.0 && axis.place(12e-6) < 1.0);
        assert_eq!(axis.place(-1.0), 0.0);
        assert_eq!(labels(&Axis::log("chi2", "", [0.9, 1.4]), 4).len(), 1);
    }

    #[test]
    fn nothing_to_show_is_no_reason_to_fail() {
        for axis in [
            Axis::linear("a", "m", []),
            Axis::linear("a", "m", [f64::NAN, 0.0]),
            Axis::linear("a", "m", [3.0, 3.0]),
            Axis::exact("a", "m", 1.0, 1.0),
            Axis::exact("a", "m", f64::NAN, 1.0),
            Axis::log("a", "m", [0.0, -1.0]),
        ] {
            assert!(axis.place(0.5).is_finite());
            assert!(axis.ticks(5).len() < 20);
        }
    }
}
