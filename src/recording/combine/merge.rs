//! Two runs with one point each, under the same drive: a vibrometer that reads one point was moved
//! between them.

use super::error::CombineError;
use super::interpolate::at_instants;
use super::overlay::{Overlay, compare_voltages, differ, lay_over};
use super::said::{clock_in_words, lag_in_words, period_in_words};
use crate::model::unit::{counted, format_quantity};
use crate::recording::error::{ImportWarning, WarningKind};
use crate::recording::{Channel, Recording};

/// Fewest samples that both runs have.
const MIN_COMMON_SAMPLES: usize = 16;

/// One recording from a run with the proof mass and one with the cantilever, both with the voltage:
/// `cantilever` has its displacement where a recording of one point has it, in
/// [`Recording::proof_mass`]. It is laid over the other by the voltages, or by `lag` \[s\] where that is
/// given (added to its times), and read on the clock of `proof_mass`, by cubics between its samples.
/// The warnings say the lag and how the voltages differ.
///
/// # Errors
/// [`CombineError`]: a voltage is missing, or they differ; nothing in common.
///
/// # Examples
/// ```
/// use impactscope::recording::Recording;
/// use impactscope::recording::combine::merge_points;
///
/// let time: Vec<f64> = (0..4000).map(|i| 2e-5 * f64::from(i)).collect();
/// let sweep = |t: f64| 5.0 * (1e3 * t + 4e4 * t * t).sin();
/// // The second run was started 1.23 ms later.
/// let at = |late: f64, gain: f64| time.iter().map(|t| gain * sweep(t + late)).collect::<Vec<f64>>();
/// let xp = Recording::new("tip", time.clone(), Some(at(0.0, 1.0)), at(0.0, 1e-6), None)?;
/// let xc = Recording::new("centre", time.clone(), Some(at(1.23e-3, 1.0)), at(1.23e-3, 3e-7), None)?;
/// let both = merge_points(&xp, &xc, None)?;
/// let cantilever = both.cantilever.as_ref().ok_or("no xc")?;
/// assert!((cantilever[500] - 0.3 * both.proof_mass[500]).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn merge_points(
    proof_mass: &Recording,
    cantilever: &Recording,
    lag: Option<f64>,
) -> Result<Recording, CombineError> {
    for one in [proof_mass, cantilever] {
        if one.cantilever.is_some() {
            return Err(CombineError::HasBothPoints {
                name: one.name.clone().into(),
            });
        }
    }
    let overlay = match lag {
        Some(lag) => Overlay {
            lag,
            ..Overlay::default()
        },
        None => lay_over(proof_mass, cantilever, false)?,
    };
    let agreement = compare_voltages(proof_mass, cantilever, overlay.lag);
    if let Some(found) = agreement.filter(|found| !found.is_one_drive()) {
        return Err(differ(proof_mass, cantilever, &found));
    }
    let (first, last) = cantilever.span();
    let slack = 1e-6 * proof_mass.interval();
    let from = proof_mass
        .time
        .partition_point(|t| *t < first + overlay.lag - slack);
    let to = proof_mass
        .time
        .partition_point(|t| *t <= last + overlay.lag + slack);
    let no_overlap = || CombineError::NoOverlap {
        name: cantilever.name.clone().into(),
        reference: proof_mass.name.clone().into(),
    };
    if to.saturating_sub(from) < MIN_COMMON_SAMPLES {
        return Err(no_overlap());
    }
    let cut = |values: &[f64]| values.get(from..to).unwrap_or_default().to_vec();
    let time = cut(&proof_mass.time);
    let instants: Vec<f64> = time
        .iter()
        .map(|t| (t - overlay.lag).clamp(first, last))
        .collect();
    let xc = at_instants(cantilever, Channel::ProofMass, &instants);
    let mut merged = Recording::new(
        format!("{} with xc of {}", proof_mass.name, cantilever.name),
        time,
        proof_mass.voltage.as_deref().map(cut),
        cut(&proof_mass.proof_mass),
        xc,
    )
    .map_err(|_| no_overlap())?;
    merged.origin = proof_mass.origin.clone();
    merged.drive_source = proof_mass.drive_source.clone();
    merged.instrument = proof_mass.instrument;
    merged.warnings = warnings(proof_mass, cantilever);
    let cut_away = proof_mass.len() - merged.len();
    let mut said = vec![lag_in_words(proof_mass, cantilever, &overlay)];
    if let Some(found) = agreement {
        said.push(format!(
            "the voltages of the two runs differ by {} rms (up to {} is taken for one drive)",
            format_quantity(found.rms, "V", 3),
            format_quantity(found.allowed, "V", 3)
        ));
    } else {
        said.push(
            "the voltages of the two runs could not be compared; that it was one drive is taken on trust"
                .to_owned(),
        );
    }
    said.extend(clock_in_words(cantilever, &overlay));
    said.extend(period_in_words(proof_mass, &overlay));
    if (cantilever.interval() / proof_mass.interval() - 1.0).abs() > 0.01 {
        said.push(format!(
            "{} was sampled at {}, {} at {}; xc is read on the clock of xp",
            proof_mass.name,
            format_quantity(proof_mass.sampling_rate(), "Hz", 6),
            cantilever.name,
            format_quantity(cantilever.sampling_rate(), "Hz", 6)
        ));
    }
    if cut_away > 0 {
        said.push(format!(
            "{} of {} lie outside of {} and are left out",
            counted(cut_away, "row"),
            proof_mass.name,
            cantilever.name
        ));
    }
    let warn = |text: String| ImportWarning::new(WarningKind::Merged, 1, None, &text);
    merged.warnings.extend(said.into_iter().map(warn));
    Ok(merged)
}

/// What the reader said of both files, each once.
fn warnings(first: &Recording, second: &Recording) -> Vec<ImportWarning> {
    let named = [first, second].into_iter().flat_map(|one| {
        one.warnings.iter().map(move |warning| ImportWarning {
            message: format!("{}: {}", one.name, warning.message),
            ..warning.clone()
        })
    });
    named.collect()
}
