//! Devices as texts of the command line: `key=value,key=value,...`.

use super::beam::{BeamDesign, EndMass, Layer, Section, beam_device};
use super::error::{DesignError, positive};
use super::lumped::{FreeMass, MassOnSpring, Pendulum};
use super::materials::Material;
use super::modes_table::{ModesTable, modes_device};
use super::setting::{AIR_VISCOSITY, Designed, GroundDesign, Setting};
use crate::model::unit::{UnitError, parse_quantity};

/// Modes of a beam where their number is not given: those of the paper.
const USUAL_MODES: usize = 2;

/// What a text describes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DesignKind<'a> {
    /// A beam with an end mass.
    Beam,
    /// A table of modes: name and content of its file.
    Modes(&'a str, &'a str),
    /// A mass on a spring.
    Spring,
    /// A pendulum.
    Pendulum,
    /// A free mass.
    Free,
}

/// Keys of every device.
const COMMON_KEYS: [&str; 12] = [
    "name",
    "zeta",
    "Q",
    "ground",
    "film",
    "plate",
    "viscosity",
    "alpha",
    "adhesion",
    "force",
    "V",
    "g",
];
const BEAM_KEYS: [&str; 15] = [
    "L",
    "W",
    "t",
    "material",
    "E",
    "rho",
    "layers",
    "EI",
    "m",
    "mass",
    "mass_size",
    "mass_material",
    "mass_offset",
    "inertia",
    "modes",
];
const PIEZO_KEY: &str = "piezo";

/// The device that a text describes. All values take units with a prefix, and none is SI.
///
/// A beam: `L` length; its section as `layers` from bottom to top (`Si:5um+PZT:1um:80um`: material,
/// thickness, width if not `W`), or `t` with `material` or `E` and `rho`, or `EI` and `m` (mass per
/// length); its end mass as `mass_size` (along x across x height, `150x100x10um`) with `mass` or
/// `mass_material` (silicon if neither), or `mass` with `mass_offset` and `inertia`; `modes`, and `piezo`,
/// where the piezo layer begins and ends (`0..500um`). A layer may have own values:
/// `PZT(d31=-120pm/V;E=80GPa):1um`.
///
/// A spring: `m` and `k`, or `m` and `f`; `x0`. A pendulum: `L`, `angle` (deg or rad), `m`, `g`,
/// `inertia`. A free mass: `m`, `x0`, `v0`, `g`. A table of modes: `mass`.
///
/// All: `name`, `zeta` or `Q` (several as `0.02/0.03`), `ground` (distance to contact), `film` (gas left
/// at contact), `plate` (`150x100um`), `viscosity`, `alpha`, `adhesion`, `force` (per volt, on the
/// cantilever), `V` (amplitude of the usual drive).
///
/// # Errors
/// [`DesignError`] naming the key, what is wrong and what would be right.
///
/// # Examples
/// ```
/// use impactscope::model::design::{DesignKind, describe};
///
/// let text = "L=750um,EI=1.139e-12,m=3.519e-7,mass=0.3495ug,mass_size=150x100x10um";
/// let made = describe(DesignKind::Beam, text)?;
/// assert!((made.preset.model.get("f2").unwrap() / 6424.0 - 1.0).abs() < 1e-3);
/// let swing = describe(DesignKind::Pendulum, "L=1m,angle=5deg")?;
/// assert!((swing.preset.model.get("f1").unwrap() - 0.4984).abs() < 1e-4);
/// assert!(describe(DesignKind::Beam, "L=750us").is_err());
/// # Ok::<(), impactscope::model::design::DesignError>(())
/// ```
pub fn describe(kind: DesignKind<'_>, text: &str) -> Result<Designed, DesignError> {
    match kind {
        DesignKind::Beam => {
            let mut own = BEAM_KEYS.to_vec();
            own.push(PIEZO_KEY);
            let fields = Fields::parse(text, &own)?;
            beam_device(&beam(&fields)?, &fields.setting()?)
        }
        DesignKind::Modes(file, content) => {
            let fields = Fields::parse(text, &["mass"])?;
            let table = ModesTable::parse(file, content)?;
            modes_device(&table, fields.quantity("mass", "kg")?, &fields.setting()?)
        }
        DesignKind::Spring => {
            let fields = Fields::parse(text, &["m", "k", "f", "x0"])?;
            let mass = fields.needed("m", "kg", "1g")?;
            let stiffness = match (fields.quantity("k", "N/m")?, fields.quantity("f", "Hz")?) {
                (Some(k), None) => k,
                (None, Some(f)) => mass * (std::f64::consts::TAU * positive("f", f, "Hz")?).powi(2),
                _ => {
                    return Err(DesignError::value(
                        "k",
                        "give either k or f, for example k=15N/m",
                    ));
                }
            };
            let start = fields.quantity("x0", "m")?;
            MassOnSpring {
                mass,
                stiffness,
                start,
            }
            .device(&fields.setting()?)
        }
        DesignKind::Pendulum => {
            let fields = Fields::parse(text, &["L", "m", "angle", "inertia"])?;
            Pendulum {
                arm: fields.needed("L", "m", "1m")?,
                mass: fields.quantity("m", "kg")?.unwrap_or(1.0),
                inertia: fields.quantity("inertia", "kg m^2")?,
                gravity: fields.quantity("g", "m/s^2")?.unwrap_or(9.80665),
                start: fields.quantity("angle", "rad")?.unwrap_or(0.0),
            }
            .device(&fields.setting()?)
        }
        DesignKind::Free => {
            let fields = Fields::parse(text, &["m", "x0", "v0"])?;
            FreeMass {
                mass: fields.needed("m", "kg", "5g")?,
                height: fields.quantity("x0", "m")?.unwrap_or(0.0),
                speed: fields.quantity("v0", "m/s")?.unwrap_or(0.0),
                gravity: fields.quantity("g", "m/s^2")?,
            }
            .device(&fields.setting()?)
        }
    }
}

/// The fields of a text.
struct Fields<'a> {
    pairs: Vec<(&'a str, &'a str)>,
}

impl<'a> Fields<'a> {
    /// Splits a text at its commas; every key must be known and stand once.
    fn parse(text: &'a str, own: &[&str]) -> Result<Self, DesignError> {
        let fail = |field: &str, reason: String| DesignError::Field {
            field: field.chars().take(60).collect(),
            reason,
        };
        let known: Vec<&str> = own.iter().chain(&COMMON_KEYS).copied().collect();
        let mut pairs: Vec<(&str, &str)> = Vec::new();
        for field in text.split(',').map(str::trim).filter(|f| !f.is_empty()) {
            let Some((key, value)) = field.split_once('=') else {
                let reason = "is no KEY=VALUE; separate the fields by commas, and write decimals with a point";
                return Err(fail(field, reason.to_owned()));
            };
            let key = key.trim();
            let Some(key) = known.iter().find(|k| **k == key).map(|_| key) else {
                let reason = format!("there is no key {key} here; there are {}", known.join(", "));
                return Err(fail(field, reason));
            };
            if pairs.iter().any(|(other, _)| *other == key) {
                return Err(fail(field, format!("{key} is given twice")));
            }
            pairs.push((key, value.trim()));
        }
        Ok(Self { pairs })
    }

    fn text(&self, key: &str) -> Option<&'a str> {
        self.pairs.iter().find(|(k, _)| *k == key).map(|(_, v)| *v)
    }

    fn quantity(&self, key: &str, unit: &str) -> Result<Option<f64>, DesignError> {
        self.text(key)
            .map(|text| quantity(key, text, unit))
            .transpose()
    }

    fn needed(&self, key: &str, unit: &str, example: &str) -> Result<f64, DesignError> {
        self.quantity(key, unit)?.ok_or_else(|| {
            DesignError::value(
                key,
                format!("is missing; write for example {key}={example}"),
            )
        })
    }

    /// What is around the structure.
    fn setting(&self) -> Result<Setting, DesignError> {
        let list = |key: &str| -> Result<Option<Vec<f64>>, DesignError> {
            let read = |text: &str| -> Result<Vec<f64>, DesignError> {
                text.split('/').map(|one| quantity(key, one, "")).collect()
            };
            self.text(key).map(read).transpose()
        };
        let zetas = match (list("zeta")?, list("Q")?) {
            (Some(_), Some(_)) => return Err(DesignError::value("Q", "give zeta or Q, not both")),
            (Some(zetas), None) => zetas,
            (None, Some(qualities)) => {
                let zeta = |q: f64| positive("Q", q, "").map(|q| 0.5 / q);
                qualities.into_iter().map(zeta).collect::<Result<_, _>>()?
            }
            (None, None) => Vec::new(),
        };
        let usual = Setting::default();
        Ok(Setting {
            name: self.text("name").map_or(usual.name, str::to_owned),
            zetas,
            ground: self.ground()?,
            force_per_volt: self.quantity("force", "N/V")?,
            voltage: self.quantity("V", "V")?.unwrap_or(usual.voltage),
        })
    }

    fn ground(&self) -> Result<Option<GroundDesign>, DesignError> {
        let Some(distance) = self.quantity("ground", "m")? else {
            let stray = ["film", "plate", "viscosity", "alpha", "adhesion"];
            if let Some(key) = stray.into_iter().find(|key| self.text(key).is_some()) {
                let reason =
                    "belongs to a ground, which is not given; write for example ground=58um";
                return Err(DesignError::value(key, reason));
            }
            return Ok(None);
        };
        let plate = match (self.text("plate"), self.text("mass_size")) {
            (Some(text), _) => {
                let sides = sizes("plate", text, 2)?;
                Some((sides[0], sides[1]))
            }
            // The underside of the end mass.
            (None, Some(text)) => {
                let sides = sizes("mass_size", text, 3)?;
                Some((sides[0], sides[1]))
            }
            (None, None) => None,
        };
        Ok(Some(GroundDesign {
            distance,
            film_at_contact: self.quantity("film", "m")?,
            plate,
            viscosity: self.quantity("viscosity", "Pa s")?.unwrap_or(AIR_VISCOSITY),
            alpha: self.quantity("alpha", "")?,
            adhesion: self.quantity("adhesion", "N")?,
        }))
    }
}

fn quantity(key: &str, text: &str, unit: &str) -> Result<f64, DesignError> {
    parse_quantity(text, unit).map_err(|source| DesignError::Quantity {
        key: key.to_owned(),
        source,
    })
}

/// `count` sizes as `150x100x10um`: a unit at the end counts for all before it without one.
fn sizes(key: &str, text: &str, count: usize) -> Result<Vec<f64>, DesignError> {
    let parts: Vec<&str> = text.split(['x', '\u{d7}']).map(str::trim).collect();
    if parts.len() != count {
        let form = if count == 2 {
            "150x100um"
        } else {
            "150x100x10um"
        };
        let reason = format!(
            "{text:?} has {} sizes, {count} are needed, as {form}",
            parts.len()
        );
        return Err(DesignError::value(key, reason));
    }
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E' | '-' | '+');
    let last = parts.last().copied().unwrap_or_default();
    let unit = last.trim_start_matches(is_number).trim();
    parts
        .iter()
        .map(|part| {
            let own = if part.chars().all(is_number) {
                format!("{part} {unit}")
            } else {
                (*part).to_owned()
            };
            positive(key, quantity(key, &own, "m")?, "m")
        })
        .collect()
}

fn find_material(key: &str, name: &str) -> Result<&'static Material, DesignError> {
    Material::find(name.trim()).ok_or_else(|| {
        let reason = format!(
            "there is no material {name:?}; there are {}; or give E and rho",
            Material::names()
        );
        DesignError::value(key, reason)
    })
}

/// The beam of the fields.
fn beam(fields: &Fields<'_>) -> Result<BeamDesign, DesignError> {
    let length = fields.needed("L", "m", "750um")?;
    let section = section(fields)?;
    let modes = match fields.text("modes") {
        None => USUAL_MODES,
        Some(text) => text.parse().map_err(|_| DesignError::Quantity {
            key: "modes".to_owned(),
            source: UnitError::NotANumber(text.to_owned()),
        })?,
    };
    let mut design = BeamDesign::new(length, section, end_mass(fields)?, modes);
    if let Some(text) = fields.text(PIEZO_KEY) {
        let Some((from, to)) = text.split_once("..") else {
            let reason = format!("{text:?} is no span; write for example piezo=0..500um");
            return Err(DesignError::value(PIEZO_KEY, reason));
        };
        design.piezo_span = (
            quantity(PIEZO_KEY, from, "m")?,
            quantity(PIEZO_KEY, to, "m")?,
        );
    }
    Ok(design)
}

fn section(fields: &Fields<'_>) -> Result<Section, DesignError> {
    let by_layers = fields.text("layers");
    let one_layer = fields.quantity("t", "m")?;
    let given = (
        fields.quantity("EI", "N m^2")?,
        fields.quantity("m", "kg/m")?,
    );
    let width = || fields.needed("W", "m", "100um");
    match (by_layers, one_layer, given) {
        (Some(text), None, (None, None)) => {
            let width = width()?;
            let layers = text.split('+').map(|one| layer(one, width));
            Section::of_layers(&layers.collect::<Result<Vec<_>, _>>()?)
        }
        (None, Some(thickness), (None, None)) => {
            let mut own = Layer {
                name: "beam".to_owned(),
                modulus: f64::NAN,
                density: f64::NAN,
                d31: 0.0,
                thickness,
                width: width()?,
            };
            if let Some(name) = fields.text("material") {
                own = Layer::of(find_material("material", name)?, thickness, own.width);
                // One layer bends nothing, and its voltage would not be asked for.
                own.d31 = 0.0;
            }
            own.modulus = fields.quantity("E", "Pa")?.unwrap_or(own.modulus);
            own.density = fields.quantity("rho", "kg/m^3")?.unwrap_or(own.density);
            if own.modulus.is_nan() || own.density.is_nan() {
                return Err(DesignError::value(
                    "material",
                    "is missing; write for example material=Si, or E=169GPa,rho=2330",
                ));
            }
            Section::of_layers(&[own])
        }
        (None, None, (Some(stiffness), Some(mass))) => Section::given(stiffness, mass),
        _ => Err(DesignError::value(
            "section",
            "give one of layers=Si:5um+PZT:1um with W, t with W and material, or EI with m (mass per length)",
        )),
    }
}

/// A layer, `PZT:1um`, `PZT:1um:80um`, `PZT(d31=-120pm/V;E=80GPa):1um`.
fn layer(text: &str, width: f64) -> Result<Layer, DesignError> {
    let fail = |reason: String| DesignError::Field {
        field: text.trim().chars().take(60).collect(),
        reason,
    };
    let (material, sizes) = text
        .trim()
        .split_once(':')
        .ok_or_else(|| fail("a layer is MATERIAL:THICKNESS, for example Si:5um".to_owned()))?;
    let (name, own) = match material.split_once('(') {
        Some((name, own)) => (name.trim(), own.trim_end().strip_suffix(')')),
        None => (material.trim(), Some("")),
    };
    let own = own.ok_or_else(|| fail("a bracket is not closed".to_owned()))?;
    let mut sizes = sizes.split(':');
    let thickness = quantity("layer thickness", sizes.next().unwrap_or_default(), "m")?;
    let width = match sizes.next() {
        Some(text) => quantity("layer width", text, "m")?,
        None => width,
    };
    if sizes.next().is_some() {
        return Err(fail(
            "a layer has a thickness and a width, no more".to_owned(),
        ));
    }
    let mut made = match Material::find(name) {
        Some(known) => Layer::of(known, thickness, width),
        // A material of one's own needs its values.
        None if own.contains("E=") && own.contains("rho=") => Layer {
            name: name.to_owned(),
            modulus: f64::NAN,
            density: f64::NAN,
            d31: 0.0,
            thickness,
            width,
        },
        None => {
            return Err(find_material("layers", name)
                .err()
                .unwrap_or_else(|| fail(String::new())));
        }
    };
    for pair in own.split(';').map(str::trim).filter(|p| !p.is_empty()) {
        match pair.split_once('=') {
            Some(("E", v)) => made.modulus = quantity("E", v, "Pa")?,
            Some(("rho", v)) => made.density = quantity("rho", v, "kg/m^3")?,
            Some(("d31", v)) => made.d31 = quantity("d31", v, "m/V")?,
            _ => return Err(fail(format!("{pair:?} is none of E=, rho=, d31="))),
        }
    }
    Ok(made)
}

fn end_mass(fields: &Fields<'_>) -> Result<EndMass, DesignError> {
    let given = fields.quantity("mass", "kg")?;
    let material = fields.text("mass_material");
    let mut end = match (fields.text("mass_size"), given) {
        (Some(text), mass) => {
            let size = sizes("mass_size", text, 3)?;
            if mass.is_some() && material.is_some() {
                let reason = "give mass or mass_material, not both";
                return Err(DesignError::value("mass_material", reason));
            }
            let density = find_material("mass_material", material.unwrap_or("Si"))?.density;
            let mass = mass.unwrap_or(density * size[0] * size[1] * size[2]);
            EndMass::block(mass, size[0], size[2])
        }
        (None, mass) if material.is_some() => {
            let _ = mass;
            let reason = "needs mass_size, for example mass_size=150x100x10um";
            return Err(DesignError::value("mass_material", reason));
        }
        (None, Some(mass)) => EndMass {
            mass,
            ..EndMass::default()
        },
        (None, None) => EndMass::default(),
    };
    if let Some(inertia) = fields.quantity("inertia", "kg m^2")? {
        end.inertia = inertia;
    }
    if let Some(offset) = fields.quantity("mass_offset", "m")? {
        end.offset = offset;
    }
    Ok(end)
}
