//! `fit --profile`: how much worse the fit becomes with one parameter held elsewhere, all
//! others refitted, and its 95 % interval.

use serde_json::{Value, json};

use crate::fit::thresholds::CHI2_95_ONE_DOF;
use crate::fit::uncertainty::confidence_interval::interval;
use crate::fit::{Control, FitError, FitOptions, FitResult, Part, ProfilePoint, profile_of};
use crate::model::unit::{format_number, format_quantity};

/// Where the parameter is held, in its standard errors from the best.
const PROFILE_SHIFTS: [f64; 13] = [
    -4.0, -3.0, -2.3, -1.7, -1.2, -0.6, 0.0, 0.6, 1.2, 1.7, 2.3, 3.0, 4.0,
];

/// The profile of one parameter.
#[derive(Debug, Clone)]
pub struct Profile {
    id: String,
    unit: &'static str,
    points: Vec<ProfilePoint>,
    cancelled: bool,
}

impl Profile {
    /// Makes the profile of the parameter `id` of a fit to `train`.
    ///
    /// # Errors
    /// [`FitError`] if the parameter was not fitted.
    pub fn new(
        result: &FitResult,
        train: &[Part],
        id: &str,
        options: &FitOptions,
        control: &Control<'_>,
    ) -> Result<Self, FitError> {
        let points = profile_of(result, train, id, &PROFILE_SHIFTS, options, control)?;
        let parameter = result
            .parameters
            .iter()
            .find(|p| p.id.eq_ignore_ascii_case(id));
        Ok(Self {
            id: parameter.map_or(id, |p| p.id.as_str()).to_owned(),
            unit: parameter.map_or("", |p| p.unit),
            points,
            cancelled: control.cancelled(),
        })
    }

    /// The curve and the interval as text.
    pub fn text(&self) -> String {
        let mut text = format!(
            "profile of {}: increase of the cost when it is fixed at each value and all others are refitted\n",
            self.id
        );
        let write = |value: f64| format_quantity(value, self.unit, 6);
        for p in &self.points {
            text += &format!(
                "  {:>22}  {:>8}\n",
                write(p.value),
                format_number(p.rise, 3)
            );
        }
        if self.cancelled {
            return text + "cancelled before the profile was complete\n";
        }
        let between = match interval(&self.points) {
            [Some(low), Some(high)] => format!("{} to {}", write(low), write(high)),
            [Some(low), None] => format!("from {}, no upper end among these values", write(low)),
            [None, Some(high)] => format!("up to {}, no lower end among these values", write(high)),
            [None, None] => "none: the data exclude none of these values".to_owned(),
        };
        text + &format!("95 % interval (increase of {CHI2_95_ONE_DOF}): {between}\n")
    }

    /// The same as JSON, values in SI; an end of the interval that was not reached is null.
    pub fn as_json(&self) -> Value {
        let points: Vec<[f64; 2]> = self.points.iter().map(|p| [p.value, p.rise]).collect();
        json!({
            "id": self.id, "unit": self.unit, "points": points,
            "interval_95": (!self.cancelled).then(|| interval(&self.points)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::profile::*;

    fn made_up(rise: impl Fn(f64) -> f64) -> Profile {
        Profile {
            id: "dp".to_owned(),
            unit: "m",
            points: PROFILE_SHIFTS
                .map(|k| ProfilePoint {
                    value: 58e-6 + 1e-7 * k,
                    rise: rise(k),
                })
                .to_vec(),
            cancelled: false,
        }
    }

    #[test]
    fn the_interval_is_written_with_its_unit() {
        let parabola = made_up(|k| k * k);
        let text = parabola.text();
        assert!(
            text.contains("57.804 \u{b5}m to 58.196 \u{b5}m")
                || text.contains("57.804 um to 58.196 um"),
            "{text}"
        );
        let ends = &parabola.as_json()["interval_95"];
        assert!(
            (ends[0].as_f64().unwrap() - 57.804e-6).abs() < 1e-9,
            "{ends}"
        );
        let open = made_up(|k| k.min(0.0).powi(2));
        assert!(open.text().contains("no upper end"), "{}", open.text());
        assert!(open.as_json()["interval_95"][1].is_null());
        let flat = made_up(|_| 0.0);
        assert!(flat.text().contains("none: the data"), "{}", flat.text());
    }

    #[test]
    fn a_cancelled_profile_has_no_interval() {
        let part = Profile {
            cancelled: true,
            ..made_up(|k| k * k)
        };
        assert!(part.text().contains("cancelled before"), "{}", part.text());
        assert!(part.as_json()["interval_95"].is_null());
    }
}
