//! The parameters that a fit moves, and the coordinates in which it moves them.
//!
//! A parameter is scaled by its logarithm if the table says so, otherwise by its range. The film
//! has the coordinates thickness at contact, `gp - dp`, and strength there, `Cs / (gp - dp)^3`: the
//! recordings determine these directly, while `Cs` and `gp` are almost fully correlated. `gp > dp`
//! then holds by construction.
//!
//! The drive's shares in the modes are scaled so that the observed motion stays: the gain moves as
//! that of the first mode, the shares in the second mode as the motion that they cause.

use crate::fit::error::FitError;
use crate::model::Model;
use crate::model::parameter::{ParameterId, ParameterSpec, Scale};

/// How a parameter's value and its coordinate are related.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Coordinate {
    /// Natural logarithm.
    Log,
    /// Value over this unit.
    Linear(f64),
    /// Logarithm of `gp - dp` \[m\].
    FilmGap,
    /// Logarithm of `Cs / (gp - dp)^3`.
    FilmStrength,
    /// Logarithm of the drive's gain in the first mode.
    DriveGain,
    /// A share in the second mode at the same gain in the first one, over this unit.
    Share(f64),
}

/// One parameter that is moved.
#[derive(Debug, Clone)]
pub struct Entry {
    /// Id, `Cs` or `effect.parameter`.
    pub id: String,
    /// Its row of the table, or of the effect's own.
    pub spec: ParameterSpec,
    coordinate: Coordinate,
    /// Bounds of the coordinate.
    pub low: f64,
    /// See `low`.
    pub high: f64,
}

/// The free parameters, and the model that holds all others.
#[derive(Debug, Clone)]
pub struct Space {
    base: Model,
    /// In the order asked for.
    pub entries: Vec<Entry>,
}

impl Space {
    /// For the parameters `free` of `model`. There may be none: then only what belongs to the
    /// recordings is estimated.
    ///
    /// # Errors
    /// [`FitError`] for an unknown id or one without bearing on the device.
    pub fn new(model: &Model, free: &[String]) -> Result<Self, FitError> {
        let mut entries: Vec<Entry> = Vec::new();
        for id in free {
            let (id, spec) = find(model, id)?;
            if entries.iter().all(|e| e.id != id) {
                entries.push(entry(id, spec));
            }
        }
        Ok(Self {
            base: model.clone(),
            entries,
        })
    }

    /// The other free parameters, with `id` held at the SI value `value` in the `model` that holds
    /// the rest. The result may be empty.
    #[must_use]
    pub fn holding(&self, model: &Model, id: &str, value: f64) -> Self {
        let mut base = model.clone();
        set(&mut base, id, value);
        let others = self.entries.iter().filter(|e| e.id != id);
        Self {
            base,
            entries: others.cloned().collect(),
        }
    }

    /// The parameters of the entries `own` alone, all others held as at coordinates `x`.
    #[must_use]
    pub fn only(&self, own: &[usize], x: &[f64]) -> Self {
        Self {
            base: self.model(x),
            entries: own.iter().map(|&i| self.entries[i].clone()).collect(),
        }
    }

    /// The model that holds the other parameters.
    pub fn base(&self) -> &Model {
        &self.base
    }

    /// Bounds a parameter with a plain or logarithmic coordinate between two values.
    pub fn keep_between(&mut self, id: &str, (least, most): (f64, f64)) {
        for e in self.entries.iter_mut().filter(|e| e.id == id) {
            let coordinate = |value: f64| match e.coordinate {
                Coordinate::Log | Coordinate::DriveGain => value.max(f64::MIN_POSITIVE).ln(),
                Coordinate::Linear(unit) | Coordinate::Share(unit) => value / unit,
                Coordinate::FilmGap | Coordinate::FilmStrength => f64::NAN,
            };
            // A comparison with NaN leaves the bound unchanged.
            e.low = e.low.max(coordinate(least));
            e.high = e.high.min(coordinate(most));
        }
    }

    /// Number of parameters that are moved.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether no parameter is moved.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Index of an id among the entries.
    pub fn position(&self, id: &str) -> Option<usize> {
        self.entries.iter().position(|e| e.id == id)
    }

    /// Coordinates of a model's values, within the bounds.
    pub fn coordinates(&self, model: &Model) -> Vec<f64> {
        let film = film_gap(model);
        let uneven = unevenness(model);
        let coordinate = |e: &Entry| {
            let value = model.get(&e.id).unwrap_or(e.spec.default);
            let x = match e.coordinate {
                Coordinate::Log => value.max(f64::MIN_POSITIVE).ln(),
                Coordinate::Linear(unit) => value / unit,
                Coordinate::FilmGap => film.ln(),
                Coordinate::FilmStrength => (value.max(1e-40) / film.powi(3)).ln(),
                Coordinate::DriveGain => (value.max(f64::MIN_POSITIVE) * uneven).ln(),
                Coordinate::Share(unit) => value / uneven / unit,
            };
            x.clamp(e.low, e.high)
        };
        self.entries.iter().map(coordinate).collect()
    }

    /// The model at coordinates `x`.
    pub fn model(&self, x: &[f64]) -> Model {
        let mut model = self.base.clone();
        // Plain parameters first: the film depends on dp, its strength on the gap, and gain and
        // shares on the unevenness of the drive.
        for pass in 0..3 {
            for (e, &x) in self.entries.iter().zip(x) {
                let x = x.clamp(e.low, e.high);
                let value = match (e.coordinate, pass) {
                    (Coordinate::Log, 0) => x.exp(),
                    (Coordinate::Linear(unit), 0) => x * unit,
                    (Coordinate::FilmGap, 1) => model.parameters[ParameterId::Dp] + x.exp(),
                    (Coordinate::FilmStrength, 2) => (x + 3.0 * film_gap(&model).ln()).exp(),
                    (Coordinate::DriveGain, 1) => x.exp() / unevenness(&model),
                    (Coordinate::Share(unit), 1) => x * unit * unevenness(&model),
                    _ => continue,
                };
                set(&mut model, &e.id, value);
            }
            // A locked gp must stay above a dp that is moved.
            if pass == 0 && model.has_ground && self.position("gp").is_none() {
                let (gp, dp) = (
                    model.parameters[ParameterId::Gp],
                    model.parameters[ParameterId::Dp],
                );
                if gp <= dp {
                    model.parameters.set(ParameterId::Dp, gp - 1e-9);
                }
            }
        }
        model
    }

    /// Values in SI at coordinates `x`.
    pub fn values(&self, x: &[f64]) -> Vec<f64> {
        let model = self.model(x);
        self.entries
            .iter()
            .map(|e| model.get(&e.id).unwrap_or(f64::NAN))
            .collect()
    }

    /// Change of each value (row) per coordinate (column).
    pub fn slopes(&self, x: &[f64]) -> nalgebra::DMatrix<f64> {
        let n = self.len();
        let mut slopes = nalgebra::DMatrix::zeros(n, n);
        for j in 0..n {
            let h = 1e-5;
            let (mut a, mut b) = (x.to_vec(), x.to_vec());
            a[j] = (x[j] - h).max(self.entries[j].low);
            b[j] = (x[j] + h).min(self.entries[j].high);
            let (va, vb) = (self.values(&a), self.values(&b));
            for i in 0..n {
                slopes[(i, j)] = (vb[i] - va[i]) / (b[j] - a[j]);
            }
        }
        slopes
    }
}

/// Thickness of the film at contact \[m\], kept above zero.
fn film_gap(model: &Model) -> f64 {
    (model.parameters[ParameterId::Gp] - model.parameters[ParameterId::Dp]).max(1e-9)
}

/// Gain of the drive in the first mode over that of a drive on the cantilever alone, kept
/// above zero.
fn unevenness(model: &Model) -> f64 {
    /// Lower limit: near zero the coordinate would be singular.
    const MIN_UNEVENNESS: f64 = 0.1;
    let ratio = model.modes.first().map_or(0.0, |m| m.phi_p / m.phi_drive);
    if !ratio.is_finite() {
        return 1.0;
    }
    let gain = 1.0 + model.parameters[ParameterId::DriveP] * ratio;
    0.5 * (gain + gain.hypot(MIN_UNEVENNESS))
}

fn set(model: &mut Model, id: &str, value: f64) {
    // The ids were checked when the space was made, so there is no error.
    if let Err(error) = model.set(id, value) {
        log::error!("{error}");
    }
}

/// The canonical id and table row of a parameter of `model`.
fn find(model: &Model, id: &str) -> Result<(String, ParameterSpec), FitError> {
    if let Some(parameter) = ParameterId::from_id(id) {
        use crate::model::parameter::ParameterId as P;
        if matches!(parameter, P::OffsetP | P::OffsetC | P::Noise) {
            return Err(FitError::NuisanceParameter { id: id.to_owned() });
        }
        return if model.uses(parameter) {
            Ok((parameter.spec().id.to_owned(), *parameter.spec()))
        } else {
            Err(FitError::IrrelevantParameter {
                id: id.to_owned(),
                device: model.name.clone(),
            })
        };
    }
    if let Some((effect, parameter)) = id.split_once('.')
        && let Some(own) = model.effects.iter().find(|e| e.spec.id == effect)
        && let Some(at) = own.spec.parameters.iter().position(|p| p.id == parameter)
    {
        if !own.bears(at) {
            return Err(FitError::InactiveParameter { id: id.to_owned() });
        }
        return Ok((id.to_owned(), own.spec.parameters[at]));
    }
    let mut known: Vec<String> = ParameterId::ALL
        .iter()
        .filter(|p| model.uses(**p))
        .map(|p| p.spec().id.to_owned())
        .collect();
    known.extend(model.effect_ids());
    Err(FitError::UnknownParameter {
        id: id.to_owned(),
        known: known.join(", "),
    })
}

/// Factor by which a parameter may lie beyond its slider's range: devices differ by as much.
const MAX_RANGE_FACTOR: f64 = 1e12;

/// Unit of the coordinate of a parameter that may have either sign: a part of its range.
pub fn linear_unit(spec: &ParameterSpec) -> f64 {
    0.1 * (spec.range.1 - spec.range.0)
}

fn entry(id: String, spec: ParameterSpec) -> Entry {
    let (low, high) = spec.range;
    let (least, most) = spec.limits;
    let (coordinate, low, high) = match id.as_str() {
        "gp" => (Coordinate::FilmGap, 2e-8f64.ln(), (10.0 * high).ln()),
        "Cs" => (
            Coordinate::FilmStrength,
            (1e-4 * low / 1e-12).ln(),
            (1e4 * high / 1e-18).ln(),
        ),
        "eta" => (Coordinate::DriveGain, (1e-4 * low).ln(), (1e4 * high).ln()),
        "shape_c2" | "shape_p2" => {
            let unit = linear_unit(&spec);
            (Coordinate::Share(unit), least / unit, most / unit)
        }
        _ => match spec.scale {
            Scale::Log => (
                Coordinate::Log,
                (low / MAX_RANGE_FACTOR).max(least).ln(),
                (high * MAX_RANGE_FACTOR).min(most).ln(),
            ),
            Scale::Linear => {
                let unit = linear_unit(&spec);
                (Coordinate::Linear(unit), least / unit, most / unit)
            }
        },
    };
    Entry {
        id,
        spec,
        coordinate,
        low,
        high,
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameter_space::*;
    use crate::fit::options::default_free;
    use crate::model::effects::{self, ActiveEffect};
    use crate::model::preset::Preset;

    #[test]
    fn an_absent_mode_is_not_fitted() {
        let mut model = Preset::embedded("paper").unwrap().model;
        let effect = effects::find("extra_mode").unwrap();
        model.effects.push(ActiveEffect::new(effect));
        let free = default_free(&model);
        assert!(free.iter().any(|id| id == "extra_mode.phi_d"));
        assert!(free.iter().all(|id| id != "extra_mode.f2"));
        Space::new(&model, &free).unwrap();
        let idle = ["extra_mode.phi_c2".to_owned()];
        let refused = Space::new(&model, &idle).unwrap_err();
        assert!(
            matches!(refused, FitError::InactiveParameter { .. }),
            "{refused}"
        );
        model.set("extra_mode.phi_c2", 1e4).unwrap();
        Space::new(&model, &idle).unwrap();
    }

    #[test]
    fn coordinates_round_trip_to_the_values() {
        let model = Preset::embedded("paper").unwrap().model;
        let free: Vec<String> = ["Cs", "gp", "dp", "alpha", "eta", "zeta1"]
            .map(str::to_owned)
            .to_vec();
        let space = Space::new(&model, &free).unwrap();
        let x = space.coordinates(&model);
        let values = space.values(&x);
        for (e, v) in space.entries.iter().zip(&values) {
            let expected = model.get(&e.id).unwrap();
            assert!((v / expected - 1.0).abs() < 1e-9, "{}: {v}", e.id);
        }
        // dp takes gp along, so that the film keeps its thickness at contact.
        let mut moved = x.clone();
        moved[2] += 1.0;
        let there = space.model(&moved);
        assert!((film_gap(&there) / film_gap(&model) - 1.0).abs() < 1e-9);
        // A drive that becomes uneven leaves the first mode's gain and what is seen of the
        // second one.
        let ids = ["eta", "shape_c2", "drive_p"].map(str::to_owned).to_vec();
        let space = Space::new(&model, &ids).unwrap();
        let mut x = space.coordinates(&model);
        x[2] += 0.5;
        let there = space.model(&x);
        assert!((there.get("drive_p").unwrap() - 0.02).abs() < 1e-12);
        let seen = |model: &Model| {
            let mode = model.structure().modes[0];
            let eta = model.parameters[ParameterId::Eta];
            let share = model.parameters[ParameterId::ShapeC2];
            (eta * mode.phi_drive, eta * share)
        };
        let (before, after) = (seen(&model), seen(&there));
        assert!((after.0 / before.0 - 1.0).abs() < 3e-3, "{after:?}");
        assert!((after.1 / before.1 - 1.0).abs() < 3e-3, "{after:?}");
        assert!(after.1 < 1.01 * before.1 && there.get("eta") < model.get("eta"));
        let empty = Space::new(&model, &[]).unwrap();
        assert!(empty.is_empty() && empty.model(&[]) == model);
        assert!(Space::new(&model, &["nonsense".to_owned()]).is_err());
    }
}
