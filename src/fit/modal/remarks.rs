//! What a reader of a modal identification must know, as sentences.

use super::result::{IdentifiedMode, Quality};
use super::shapes::{Normalisation, drives_the_point};
use super::thresholds::{
    MAX_CIRCLE_DAMPING_DIFFERENCE, MAX_CIRCLE_FREQUENCY_DIFFERENCE, MAX_MISFIT_RATIO,
};
use crate::model::Model;
use crate::model::parameter::ParameterId;
use crate::model::piezo::Piezo;
use crate::model::unit::format_quantity;

/// How the modes were found.
pub(super) struct Identification<'a> {
    /// The device.
    pub(super) model: &'a Model,
    /// What fixes the scale of the shapes.
    pub(super) normalisation: Normalisation,
    /// The law of the input; `None` for the voltage itself.
    pub(super) piezo: Option<Piezo>,
    /// Whether the damping by the film was taken out.
    pub(super) has_film: bool,
}

/// Remarks on the whole.
pub(super) fn remarks(
    of: &Identification<'_>,
    modes: &[IdentifiedMode],
    noise: [Option<f64>; 2],
    misfit: [Option<f64>; 2],
) -> Vec<String> {
    let mut remarks = Vec::new();
    for ((noise, misfit), name) in noise.into_iter().zip(misfit).zip(["xp", "xc"]) {
        if let (Some(noise), Some(misfit)) = (noise, misfit)
            && misfit > MAX_MISFIT_RATIO * noise
        {
            remarks.push(format!(
                "The modes leave {} of {name}, {:.1} times its noise of {}: the device is not linear there, or the input is not what is assumed.",
                format_quantity(misfit, "m", 3),
                misfit / noise,
                format_quantity(noise, "m", 3)
            ));
        }
    }
    let has_cantilever = modes.iter().any(|m| m.static_gain[1].is_some());
    if of.model.piezo.is_none() && matches!(of.normalisation, Normalisation::Eta) {
        remarks.push("The device has no drive yet, so eta is taken as 1 N/V, and the scale of the shapes is arbitrary: give a known modal mass or stiffness.".to_owned());
    }
    if of.piezo.is_none() {
        remarks.push("The input is the voltage itself: the gain of the drive is in the shapes, and hysteresis would be misfit.".to_owned());
    }
    if !has_cantilever {
        remarks.push("xc was not recorded: only the product of the shapes at both points is measured. phi_p is that of the device where it has the mode, and the coupling to the drive follows.".to_owned());
    } else if matches!(of.normalisation, Normalisation::Eta) {
        remarks.push("The scale of the shapes is that of eta: a drive twice as strong on a device twice as heavy moves the same. A known mass or stiffness would tell it.".to_owned());
    } else if !drives_the_point(of.model) && of.model.piezo.is_some() {
        remarks.push(
            "The drive's coupling to each mode is that of the device; its shapes follow from it."
                .to_owned(),
        );
    }
    let reversed = modes
        .iter()
        .filter_map(|m| m.static_gain[1])
        .any(|g| g.value < 0.0);
    if reversed && of.piezo.is_some() && drives_the_point(of.model) {
        remarks.push("A mode moves the cantilever against the drive: check the signs of V and xc, and whether xc is read where the drive acts.".to_owned());
    }
    let film = of.has_film;
    if of.model.has_ground && of.model.parameters[ParameterId::Cs] > 0.0 {
        remarks.push(if film {
            "The damping by the gas film (Cs, gp) is taken out: zeta is that of the structure."
                .to_owned()
        } else {
            "The damping ratios contain that by the gas film.".to_owned()
        });
    }
    if !of.model.effects.is_empty() {
        remarks.push("Effects of the device are not considered in this step.".to_owned());
    }
    remarks
}

/// Remarks on one mode.
pub(super) fn remark_on_mode(mode: &IdentifiedMode) -> Vec<String> {
    let f = mode.frequency.value;
    let at = format_quantity(f, "Hz", 4);
    let mut remarks = Vec::new();
    match mode.quality {
        Quality::Identified => {}
        Quality::Weak => remarks.push(format!(
            "A mode near {at} is seen but too weakly excited to be determined: frequency +- {:.2} %, damping +- {:.0} %. It is not given to the device.",
            100.0 * mode.frequency.std_error / f,
            100.0 * mode.zeta.std_error / mode.zeta.value
        )),
        Quality::OutsideBand => remarks.push(format!(
            "A resonance near {at}, outside the swept band, stands for what the modes there add. It is not given to the device."
        )),
    }
    // The circle of the reading on which it is clearest.
    let clearest = mode
        .circles
        .iter()
        .flatten()
        .min_by(|a, b| a.scatter.total_cmp(&b.scatter));
    if let (Some(circle), Quality::Identified) = (clearest, mode.quality) {
        let frequency = (circle.frequency.0 / f - 1.0).abs();
        let damping = (circle.zeta.0 / mode.zeta.value - 1.0).abs();
        if frequency > MAX_CIRCLE_FREQUENCY_DIFFERENCE || damping > MAX_CIRCLE_DAMPING_DIFFERENCE {
            remarks.push(format!(
                "The circle fit of the mode at {at} differs: {} and zeta {:.4} for {:.4}. Close modes, or damping by the film, move it.",
                format_quantity(circle.frequency.0, "Hz", 5),
                circle.zeta.0,
                mode.zeta.value
            ));
        }
    }
    remarks
}
