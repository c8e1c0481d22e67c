//! Scales in the properties of a channel: raw numbers to volts, and on to the sensor's unit.

use super::metadata::Properties;

/// Most scales of a channel, and most coefficients of one. NI's own have three or four.
const MAX_SCALES: usize = 64;
/// An input source that is the raw data.
const RAW: f64 = u32::MAX as f64;

/// Polynomials that are applied one after the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    /// Coefficients in rising powers, first step first.
    steps: Vec<Vec<f64>>,
}

impl Scale {
    /// The scale in `properties`; `None` if there is none or the data are scaled already, `Err` with
    /// its kind if it is not one of those that are applied here.
    pub fn of(properties: &Properties) -> Option<Result<Self, String>> {
        let number = |key: &str| properties.get(key).and_then(|value| value.number());
        let text = |key: &str| properties.get(key).and_then(|value| value.text());
        let count = number("NI_Number_Of_Scales").filter(|count| *count >= 1.0)?;
        if text("NI_Scaling_Status") == Some("scaled") {
            return None;
        }
        let mut steps = Vec::new();
        // From the last scale back to the raw data.
        let mut at = count - 1.0;
        while at != RAW {
            let index = at as usize;
            if index >= MAX_SCALES || steps.len() >= MAX_SCALES {
                return Some(Err("chain of scales".to_owned()));
            }
            let key = |name: &str| format!("NI_Scale[{index}]_{name}");
            let kind = text(&key("Scale_Type")).unwrap_or("DAQmx");
            match kind {
                "Linear" => {
                    let slope = number(&key("Linear_Slope"));
                    let intercept = number(&key("Linear_Y_Intercept"));
                    let Some((slope, intercept)) = slope.zip(intercept) else {
                        return Some(Err(kind.to_owned()));
                    };
                    steps.push(vec![intercept, slope]);
                }
                "Polynomial" => {
                    let size = number(&key("Polynomial_Coefficients_Size")).unwrap_or(4.0);
                    let coefficients: Option<Vec<f64>> = (0..MAX_SCALES.min(size as usize))
                        .map(|power| number(&key(&format!("Polynomial_Coefficients[{power}]"))))
                        .collect();
                    match coefficients {
                        Some(coefficients) if size <= MAX_SCALES as f64 => {
                            steps.push(coefficients);
                        }
                        _ => return Some(Err(kind.to_owned())),
                    }
                }
                // Marks data of the application itself.
                "AdvancedAPI" => {}
                other => return Some(Err(other.to_owned())),
            }
            let next = number(&key(&format!("{kind}_Input_Source"))).unwrap_or(RAW);
            if next != RAW && next >= at {
                return Some(Err("chain of scales".to_owned()));
            }
            at = next;
        }
        steps.reverse();
        steps.retain(|step| step.as_slice() != [0.0, 1.0]);
        (!steps.is_empty()).then_some(Ok(Self { steps }))
    }

    /// Scales raw numbers.
    pub fn apply(&self, values: &mut [f64]) {
        for step in &self.steps {
            for value in values.iter_mut() {
                let raw = *value;
                *value = step.iter().rev().fold(0.0, |sum, c| sum * raw + c);
            }
        }
    }

    /// What was done, for a note.
    pub fn words(&self) -> String {
        let step = |step: &Vec<f64>| {
            let terms: Vec<String> = step.iter().map(f64::to_string).collect();
            format!("[{}]", terms.join(", "))
        };
        let steps: Vec<String> = self.steps.iter().map(step).collect();
        format!(
            "the scale in the file was applied (coefficients of rising powers of the raw number: {})",
            steps.join(", then ")
        )
    }
}
