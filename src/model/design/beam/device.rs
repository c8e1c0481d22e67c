//! The preset of a beam with an end mass.

use super::modes::{BeamMode, beam_modes};
use super::section::BeamDesign;
use crate::model::design::error::DesignError;
use crate::model::design::setting::{Designed, Parts, Setting};
use crate::model::ground::BounceRule;
use crate::model::piezo::Piezo;
use crate::model::structure::Mode;
use crate::model::unit::{Coordinate, format_quantity};

/// Weight of a uniform beam that, as a force on its end, bends it as far as its own weight does.
const BEAM_WEIGHT_SHARE: f64 = 3.0 / 8.0;

/// The device of a beam: shapes at the middle of the cantilever and at the centre of the end mass.
///
/// A piezo layer bends the beam by a moment, `M V (w'(x2) - w'(x1))` on each mode. `eta` is the force
/// on the cantilever's centre that drives the first mode as strongly at 1 V, `phi_drive` of each mode
/// its own share; the polynomial of the drive is the voltage itself, with the sign of the first mode.
///
/// # Errors
/// [`DesignError`] naming the value at fault.
///
/// # Examples
/// ```
/// use impactscope::model::design::{BeamDesign, EndMass, Section, Setting, beam_device};
///
/// let mass = EndMass::block(3.495e-10, 150e-6, 10e-6);
/// let beam = BeamDesign::new(750e-6, Section::given(1.139e-12, 3.519e-7)?, mass, 2);
/// let made = beam_device(&beam, &Setting::default())?;
/// assert!((made.preset.model.get("f1").unwrap() / 623.0 - 1.0).abs() < 1e-3);
/// # Ok::<(), impactscope::model::design::DesignError>(())
/// ```
pub fn beam_device(design: &BeamDesign, setting: &Setting) -> Result<Designed, DesignError> {
    let found = beam_modes(design)?;
    let mut notes = vec![section_note(design)];
    notes.extend(setting.damping_notes(found.len()));
    let drive = piezo_drive(design, &found, setting)?;
    let modes = found
        .iter()
        .enumerate()
        .map(|(i, mode)| Mode {
            frequency: mode.frequency,
            zeta: setting.zeta(i),
            phi_c: mode.middle,
            phi_p: mode.mass_centre,
            phi_drive: match drive {
                Some((eta, piezo)) => {
                    design.section.moment_per_volt * mode.piezo_slope / (eta * piezo.rising[1])
                }
                None => mode.middle,
            },
        })
        .collect();
    if let Some((eta, _)) = drive {
        notes.push(format!(
            "The piezo layer bends the beam with {} per volt; on the first mode this acts like {} on the cantilever's centre.",
            format_quantity(design.section.moment_per_volt, "N m", 4),
            format_quantity(eta, "N", 4)
        ));
    } else if setting.force_per_volt.is_none() {
        notes.push(
            "There is no piezo layer and no force per volt: the device has no drive.".to_owned(),
        );
    }
    let beam_mass = design.section.mass_per_length * design.length;
    let end = &design.end_mass;
    let proof_mass = if end.mass > 0.0 {
        end.mass
    } else {
        notes.push(
            "There is no end mass: xp is the beam's end, and its weight is 3/8 of the beam's, which bends it as far.".to_owned(),
        );
        BEAM_WEIGHT_SHARE * beam_mass
    };
    let about = format!(
        "a cantilever of {} with {} at its end, {} modes from its geometry",
        format_quantity(design.length, "m", 4),
        format_mass(end.mass),
        found.len()
    );
    setting.device(Parts {
        about,
        modes,
        proof_mass,
        has_cantilever: true,
        coordinate: Coordinate::Length,
        drive,
        bounce: BounceRule::PullOff,
        start: Vec::new(),
        notes,
    })
}

/// A mass in grams with a prefix.
pub fn format_mass(mass: f64) -> String {
    format_quantity(1e3 * mass, "g", 4)
}

fn section_note(design: &BeamDesign) -> String {
    let section = &design.section;
    let axis = section.neutral_axis.map_or_else(String::new, |z| {
        format!(
            ", neutral axis {} above the lowest face",
            format_quantity(z, "m", 4)
        )
    });
    format!(
        "EI = {}, {:.4e} kg/m{axis}; end mass {}.",
        format_quantity(section.stiffness, "N m^2", 4),
        section.mass_per_length,
        format_mass(design.end_mass.mass)
    )
}

/// `eta` and the polynomial, if there is a piezo layer.
fn piezo_drive(
    design: &BeamDesign,
    modes: &[BeamMode],
    setting: &Setting,
) -> Result<Option<(f64, Piezo)>, DesignError> {
    let moment = design.section.moment_per_volt;
    if moment == 0.0 {
        return Ok(None);
    }
    if setting.force_per_volt.is_some() {
        return Err(DesignError::value(
            "force",
            "the piezo layer is the drive already; leave force out, or make the layer passive with d31=0",
        ));
    }
    let Some(first) = modes.first() else {
        return Ok(None);
    };
    let force = moment * first.piezo_slope / first.middle;
    if !(force.is_finite() && force != 0.0) {
        return Err(DesignError::value(
            "piezo",
            "the layer does not bend the first mode; give another span or thickness",
        ));
    }
    let piezo = Piezo::without_hysteresis([0.0, force.signum(), 0.0, 0.0]);
    Ok(Some((force.abs(), piezo)))
}
