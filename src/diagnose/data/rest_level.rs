//! Readings counted from where the device rests. Without a ground the zero of a reading says nothing,
//! and a law of displacement acts about the place of rest.

use std::sync::Arc;

use crate::fit::Part;
use crate::model::Model;
use crate::model::parameter::ParameterId;

/// `part` with the readings of its recording counted from their means, where a spring brings a device
/// without a ground back to rest. The fits estimate what a mean is off by.
pub fn from_rest(model: &Model, part: &Part) -> Part {
    let mut part = part.clone();
    if model.has_ground || model.parameters[ParameterId::F1] <= 0.0 {
        return part;
    }
    let mut recording = (*part.recording).clone();
    count_from_mean(&mut recording.proof_mass);
    if let Some(cantilever) = &mut recording.cantilever {
        count_from_mean(cantilever);
    }
    part.recording = Arc::new(recording);
    part
}

fn count_from_mean(readings: &mut [f64]) {
    let finite = readings.iter().filter(|x| x.is_finite());
    let mean = finite.clone().sum::<f64>() / finite.count().max(1) as f64;
    readings.iter_mut().for_each(|x| *x -= mean);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::preset::Preset;
    use crate::recording::Recording;

    #[test]
    fn readings_of_a_spring_count_from_their_mean_and_those_over_a_ground_do_not() {
        let time = (0..8).map(|i| 0.01 * f64::from(i)).collect();
        let xp = vec![0.5, 0.4, 0.5, 0.4, 0.5, 0.4, 0.5, 0.4];
        let read = Part::whole(Arc::new(Recording::new("r", time, None, xp, None).unwrap()));
        let of = |preset: &str| {
            let model = Preset::embedded(preset).unwrap().model;
            from_rest(&model, &read).recording.proof_mass[0]
        };
        assert!((of("oscillator") - 0.05).abs() < 1e-12);
        for preset in ["paper", "faller"] {
            assert!((of(preset) - 0.5).abs() < 1e-12, "{preset}");
        }
    }
}
