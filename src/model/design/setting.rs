//! What is around a structure: ground, gas film and drive; and how a preset is made of all.

use std::collections::BTreeMap;

use super::error::{DesignError, not_negative, positive};
use super::film::plate_film_coefficient;
use super::ranges::{round_number, slider_ranges};
use crate::model::Model;
use crate::model::ground::BounceRule;
use crate::model::parameter::{ParameterId, Parameters};
use crate::model::piezo::Piezo;
use crate::model::preset::Preset;
use crate::model::structure::Mode;
use crate::model::unit::{Coordinate, format_quantity};

/// Viscosity of air at 20 C and any usual pressure [Pa s].
pub const AIR_VISCOSITY: f64 = 1.81e-5;

/// Damping ratio where none is given. Silicon in air has some thousandths to some hundredths.
pub(super) const ASSUMED_ZETA: f64 = 0.01;
/// Coefficient of restitution where none is given.
const ASSUMED_ALPHA: f64 = 0.5;
/// Mean free path of air at one atmosphere \[m\].
const AIR_FREE_PATH: f64 = 68e-9;
/// Share of the free path in the film from which its flow slips at the walls.
const SLIP_SHARE: f64 = 0.01;
/// Gap of the film over the contact distance where no film is given: any above 1.
const FILMLESS_GAP: f64 = 1.2;

/// The ground below a device, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundDesign {
    /// Distance from the zero position to contact, `dp` \[m\].
    pub distance: f64,
    /// Thickness of the gas film left at contact \[m\].
    pub film_at_contact: Option<f64>,
    /// Sides of the plate on the film \[m\].
    pub plate: Option<(f64, f64)>,
    /// Viscosity of the gas [Pa s].
    pub viscosity: f64,
    /// Coefficient of restitution.
    pub alpha: Option<f64>,
    /// Adhesion at touch \[N\].
    pub adhesion: Option<f64>,
}

impl GroundDesign {
    /// A ground at a distance \[m\], nothing else known.
    pub fn at(distance: f64) -> Self {
        Self {
            distance,
            film_at_contact: None,
            plate: None,
            viscosity: AIR_VISCOSITY,
            alpha: None,
            adhesion: None,
        }
    }
}

/// What a device is called and what is around its structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Name of the preset.
    pub name: String,
    /// Damping ratios of the modes; the last counts for all further ones. Empty for an assumed one.
    pub zetas: Vec<f64>,
    /// Its ground, if it has one.
    pub ground: Option<GroundDesign>,
    /// Force on the cantilever's point per volt \[N/V\], for a drive that is not a piezo layer.
    pub force_per_volt: Option<f64>,
    /// Amplitude of its usual drive \[V\].
    pub voltage: f64,
}

impl Default for Setting {
    fn default() -> Self {
        Self {
            name: "own device".to_owned(),
            zetas: Vec::new(),
            ground: None,
            force_per_volt: None,
            voltage: 1.0,
        }
    }
}

/// A device made from a description.
#[derive(Debug, Clone, PartialEq)]
pub struct Designed {
    /// The device, checked, with the ranges of its sliders.
    pub preset: Preset,
    /// Sentences: what follows from the description, and what was assumed because it was not given.
    pub notes: Vec<String>,
}

/// A structure before its setting.
pub(super) struct Parts {
    pub(super) about: String,
    pub(super) modes: Vec<Mode>,
    pub(super) proof_mass: f64,
    pub(super) has_cantilever: bool,
    pub(super) coordinate: Coordinate,
    /// Force per unit of the drive's polynomial \[N\], and the polynomial.
    pub(super) drive: Option<(f64, Piezo)>,
    pub(super) bounce: BounceRule,
    /// Starting values that differ from the table's.
    pub(super) start: Vec<(ParameterId, f64)>,
    pub(super) notes: Vec<String>,
}

impl Setting {
    /// The damping ratio of mode `i`, from 0.
    pub(super) fn zeta(&self, i: usize) -> f64 {
        let given = self.zetas.get(i).or(self.zetas.last());
        given.copied().unwrap_or(ASSUMED_ZETA)
    }

    /// Notes on damping that was not given.
    pub(super) fn damping_notes(&self, modes: usize) -> Vec<String> {
        let given = self.zetas.len();
        if given == 0 {
            return vec![format!(
                "No damping was given: zeta = {ASSUMED_ZETA} is assumed for all modes; fit it to a ring or a sweep."
            )];
        }
        let said = format!(
            "Damping was given for {given} of {modes} modes; the last value counts for the others."
        );
        (given < modes).then_some(said).into_iter().collect()
    }

    /// The device of `parts` in this setting.
    ///
    /// # Errors
    /// [`DesignError`] naming the value at fault.
    pub(super) fn device(&self, parts: Parts) -> Result<Designed, DesignError> {
        use ParameterId as P;
        let Parts {
            about,
            modes,
            proof_mass,
            has_cantilever,
            coordinate,
            drive,
            bounce,
            start,
            mut notes,
        } = parts;
        for zeta in &self.zetas {
            not_negative("zeta", *zeta, "")?;
        }
        let mut parameters = Parameters::default();
        for (mode, (f, zeta)) in modes.iter().zip([(P::F1, P::Zeta1), (P::F2, P::Zeta2)]) {
            parameters.set(f, mode.frequency);
            parameters.set(zeta, mode.zeta);
        }
        let drive = match (drive, self.force_per_volt) {
            (Some(drive), _) => Some(drive),
            (None, Some(force)) => {
                if !(force.is_finite() && force != 0.0) {
                    return Err(DesignError::value(
                        "force",
                        format!("must be a finite force per volt other than 0, not {force} N/V"),
                    ));
                }
                let piezo = Piezo::without_hysteresis([0.0, force.signum(), 0.0, 0.0]);
                Some((force.abs(), piezo))
            }
            (None, None) => None,
        };
        if let Some((eta, _)) = drive {
            parameters.set(P::Eta, eta);
        }
        // Rows that the device does not use keep the table's value and are not written.
        if let Some(ground) = &self.ground {
            notes.extend(set_ground(&mut parameters, ground)?);
        }
        for (id, value) in start {
            parameters.set(id, value);
        }
        let model = Model {
            name: self.name.clone(),
            parameters,
            modes,
            proof_mass,
            piezo: drive.map(|(_, piezo)| piezo),
            has_ground: self.ground.is_some(),
            bounce,
            has_cantilever,
            coordinate,
            effects: Vec::new(),
        };
        self.finish(model, about, notes)
    }

    /// The preset of a model: usual drive, span and ranges.
    fn finish(
        &self,
        mut model: Model,
        about: String,
        notes: Vec<String>,
    ) -> Result<Designed, DesignError> {
        for id in ParameterId::ALL {
            // What the device does not use stays out of the file, and must come back the same.
            if !model.uses(id) {
                model.parameters.set(id, id.spec().default);
            }
        }
        let pairs = [
            (ParameterId::F1, ParameterId::Zeta1),
            (ParameterId::F2, ParameterId::Zeta2),
        ];
        for (mode, (frequency, zeta)) in model.modes.iter_mut().zip(pairs) {
            mode.frequency = model.parameters[frequency];
            mode.zeta = model.parameters[zeta];
        }
        let (drive, duration) = usual_drive(&model, self.voltage)?;
        let mut preset = Preset {
            about,
            drive,
            duration,
            ranges: BTreeMap::new(),
            known: Vec::new(),
            model,
        };
        preset.ranges = slider_ranges(&preset.model, self.voltage);
        preset.model.check()?;
        Ok(Designed { preset, notes })
    }
}

/// Sets film and contact; returns notes on what was assumed.
fn set_ground(
    parameters: &mut Parameters,
    ground: &GroundDesign,
) -> Result<Vec<String>, DesignError> {
    use ParameterId as P;
    let mut notes = Vec::new();
    let dp = positive("ground", ground.distance, "m")?;
    parameters.set(P::Dp, dp);
    let alpha = ground.alpha.unwrap_or(ASSUMED_ALPHA);
    if ground.alpha.is_none() {
        notes.push(format!(
            "No restitution was given: alpha = {ASSUMED_ALPHA} is assumed; identify it from bounces."
        ));
    }
    parameters.set(P::Alpha, alpha);
    let adhesion = not_negative("adhesion", ground.adhesion.unwrap_or(0.0), "N")?;
    if ground.adhesion.is_none() {
        notes.push("No adhesion was given: Ca0 and Ca are 0, so the ground is dry.".to_owned());
    }
    parameters.set(P::Ca0, adhesion);
    parameters.set(P::Ca, 0.0);
    match (ground.plate, ground.film_at_contact) {
        (Some(plate), Some(film)) => {
            let film = positive("film", film, "m")?;
            let coefficient = plate_film_coefficient(plate, ground.viscosity)?;
            parameters.set(P::Cs, coefficient);
            parameters.set(P::Gp, dp + film);
            notes.push(format!(
                "Cs = {} is Reynolds' estimate for a plate of {} by {} in a gas of {} Pa s.",
                format_quantity(coefficient, "N m^2 s", 4),
                format_quantity(plate.0, "m", 4),
                format_quantity(plate.1, "m", 4),
                ground.viscosity
            ));
            if AIR_FREE_PATH > SLIP_SHARE * film {
                notes.push(format!(
                    "At contact the film of {} is only {:.0} free paths of air thick: the gas slips, and the film is weaker than Reynolds' estimate.",
                    format_quantity(film, "m", 3),
                    film / AIR_FREE_PATH
                ));
            }
        }
        (plate, film) => {
            parameters.set(P::Cs, 0.0);
            parameters.set(P::Gp, film.map_or(FILMLESS_GAP * dp, |film| dp + film));
            let lacks = if plate.is_some() {
                "its thickness at contact (film)"
            } else {
                "the plate's size (plate)"
            };
            notes.push(format!("No gas film: {lacks} was not given, so Cs is 0."));
        }
    }
    Ok(notes)
}

/// Periods of the first mode in one period of the usual drive, slow enough to follow.
const DRIVE_PERIOD: f64 = 20.0;
/// Periods of the usual drive, or of the free ring, in the usual span.
const USUAL_PERIODS: f64 = 10.0;

/// The usual drive and span.
fn usual_drive(model: &Model, voltage: f64) -> Result<(String, f64), DesignError> {
    let f1 = model.parameters[ParameterId::F1];
    let slowest = model.modes.iter().map(|m| m.frequency).filter(|f| *f > 0.0);
    let slowest = slowest.fold(f64::INFINITY, f64::min);
    if model.piezo.is_none() {
        let ring = if slowest.is_finite() {
            2.0 * USUAL_PERIODS / slowest
        } else {
            2.0
        };
        return Ok(("rest".to_owned(), ring));
    }
    positive("V", voltage, "V")?;
    let pace = if f1 > 0.0 { f1 } else { slowest };
    let frequency = round_number(if pace.is_finite() {
        pace / DRIVE_PERIOD
    } else {
        1.0
    });
    let drive = format!("square:{frequency}Hz:{voltage}V");
    Ok((drive, USUAL_PERIODS / frequency))
}
