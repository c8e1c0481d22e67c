//! Whether recordings show a motion at all, and often enough for the model's modes.

use super::channel_noise::noise_of;
use crate::fit::error::FitError;
use crate::fit::options::Part;
use crate::fit::thresholds::{
    MAX_NOISE_CORRELATION, MAX_STILL_DEVIATION, MIN_SAMPLES_PER_PERIOD, MIN_VISIBLE_MODE_SHAPE,
    NOISE_CORRELATION_LAGS, NOISE_CORRELATION_SIGMAS,
};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::unit::{format_number, format_quantity};
use crate::recording::Channel;

/// Refuses recordings of which none shows a motion: xp is noise about one level in all of them.
///
/// # Errors
/// [`FitError::NoMotion`].
pub fn check_motion(parts: &[Part]) -> Result<(), FitError> {
    let Some(first) = parts.first().filter(|_| parts.iter().all(is_noise)) else {
        return Ok(());
    };
    let noise = noise_of(&first.recording, Channel::ProofMass);
    Err(FitError::NoMotion {
        recording: first.recording.name.clone(),
        noise: format_quantity(noise.map_or(0.0, |n| n.sigma), "m", 2),
    })
}

/// Whether the displacement of a part is white noise about one level: it deviates from its mean no
/// more than the noise between neighbours, and neighbours do not go together.
fn is_noise(part: &Part) -> bool {
    let r = &part.recording;
    let Ok(noise) = noise_of(r, Channel::ProofMass) else {
        return false;
    };
    let xp = &r.proof_mass[part.samples.clone()];
    let finite: Vec<f64> = xp.iter().copied().filter(|x| x.is_finite()).collect();
    let n = finite.len() as f64;
    let mean = finite.iter().sum::<f64>() / n;
    let product = |lag: usize| -> f64 {
        let pairs = finite.iter().zip(finite.iter().skip(lag));
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / n
    };
    let variance = product(0);
    let most = MAX_NOISE_CORRELATION + NOISE_CORRELATION_SIGMAS / n.sqrt();
    // A constant reading is refused as such.
    variance > 0.0
        && variance.sqrt() <= MAX_STILL_DEVIATION * noise.sigma
        && (1..=NOISE_CORRELATION_LAGS).all(|lag| product(lag).abs() <= most * variance)
}

/// A sentence for each mode that a recording samples too seldom. The first mode is refused
/// ([`FitError::OtherTime`]), and one that no recorded point shows is left alone.
pub fn sampling_doubts(model: &Model, parts: &[Part]) -> Vec<String> {
    let f2 = model.parameters[ParameterId::F2];
    if !model.uses(ParameterId::F2) || f2.is_nan() || f2 <= 0.0 {
        return Vec::new();
    }
    let shows = |part: &Part| {
        let shape =
            |id: ParameterId| model.uses(id) && model.parameters[id].abs() > MIN_VISIBLE_MODE_SHAPE;
        shape(ParameterId::ShapeP2)
            || (part.recording.cantilever.is_some() && shape(ParameterId::ShapeC2))
    };
    let rate = |part: &Part| part.recording.sampling_rate();
    let seldom = parts
        .iter()
        .filter(|p| rate(p) < MIN_SAMPLES_PER_PERIOD * f2 && shows(p));
    let mut out: Vec<String> = Vec::new();
    for part in seldom {
        let text = format!(
            "{}: {} samples a second are {} for each period of mode 2 at {}, too few to see it; record at {} or faster, or hold f2, zeta2 and the shape of mode 2",
            part.recording.name,
            format_number(rate(part), 3),
            format_number(rate(part) / f2, 2),
            format_quantity(f2, "Hz", 3),
            format_quantity(MIN_SAMPLES_PER_PERIOD * f2, "Hz", 2),
        );
        if !out.contains(&text) {
            out.push(text);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::motion::*;
    use crate::fit::tests::{made, paper, part};
    use crate::recording::Recording;

    /// Every so many samples of a recording.
    fn thinned(r: &Recording, every: usize) -> Recording {
        let of = |v: &[f64]| v.iter().copied().step_by(every).collect::<Vec<f64>>();
        let volts = r.voltage.as_deref().map(of);
        let xc = r.cantilever.as_deref().map(of);
        Recording::new("thin", of(&r.time), volts, of(&r.proof_mass), xc).unwrap()
    }

    #[test]
    fn a_mode_that_is_sampled_too_seldom_is_said() {
        let r = made(&paper(), "sine:50Hz:6V", 0.1, 1);
        assert!(sampling_doubts(&paper(), &[part(thinned(&r, 2))]).is_empty());
        let said = sampling_doubts(&paper(), &[part(thinned(&r, 5))]);
        assert_eq!(said.len(), 1);
        assert!(
            said[0].contains("mode 2 at 6.42 kHz") || said[0].contains("mode 2"),
            "{said:?}"
        );
    }

    #[test]
    fn noise_alone_is_no_motion() {
        let mut still = made(&paper(), "rest", 0.1, 3);
        let said = check_motion(&[part(still.clone())])
            .unwrap_err()
            .to_string();
        assert!(said.contains("nothing but noise"), "{said}");
        // A small motion is one, also where it is hidden by the noise of a single sample.
        for (x, t) in still.proof_mass.iter_mut().zip(&still.time) {
            *x += 20e-9 * (300.0 * t).sin();
        }
        check_motion(&[part(still)]).unwrap();
        for every in [1, 5, 25] {
            let moving = made(&paper(), "square:300Hz:6V", 0.1, 4);
            check_motion(&[part(thinned(&moving, every))]).unwrap();
        }
    }
}
