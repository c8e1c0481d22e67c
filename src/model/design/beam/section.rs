//! A cantilever of layers with a rigid mass at its end.
//!
//! Composite beam: each layer strains by `e0 - w'' z`, so that with the heights `z` of the layers'
//! middles and their areas `A`
//! `z_n = sum(E A z) / sum(E A)`, `EI = sum(E (I + A (z - z_n)^2))`, and a voltage on a piezo layer
//! of thickness `t` bends the beam like the moment `w'' EI = -E d31 V (A/t) (z - z_n)`
//! (J. G. Smits, W. Choi, IEEE Trans. UFFC 38 (1991) 256; Timoshenko's bimetal).

use crate::model::design::error::{DesignError, not_negative, positive};
use crate::model::design::materials::Material;

/// A layer of a beam, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// What it is of.
    pub name: String,
    /// Young's modulus \[Pa\].
    pub modulus: f64,
    /// Density [kg/m^3].
    pub density: f64,
    /// Transverse piezoelectric coefficient \[m/V\]; 0 for a layer that the voltage does not act on,
    /// of the other sign for one poled the other way.
    pub d31: f64,
    /// Thickness \[m\].
    pub thickness: f64,
    /// Width \[m\].
    pub width: f64,
}

impl Layer {
    /// A layer of a material of the catalogue.
    pub fn of(material: &Material, thickness: f64, width: f64) -> Self {
        Self {
            name: material.name.to_owned(),
            modulus: material.modulus,
            density: material.density,
            d31: material.d31,
            thickness,
            width,
        }
    }
}

/// The cross-section of a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Bending stiffness `EI` [N m^2].
    pub stiffness: f64,
    /// Mass per length [kg/m].
    pub mass_per_length: f64,
    /// Height of the neutral axis above the lowest face \[m\]; `None` where the stiffness was given.
    pub neutral_axis: Option<f64>,
    /// Bending moment per volt [N m/V], positive if a positive voltage bends the tip upward; 0 without
    /// a piezo layer.
    pub moment_per_volt: f64,
}

impl Section {
    /// That of layers from bottom to top.
    ///
    /// # Errors
    /// [`DesignError::Value`] naming the layer if there is none, or a size or material value is not
    /// above 0.
    ///
    /// # Examples
    /// ```
    /// use impactscope::model::design::{Layer, Material, Section};
    ///
    /// let silicon = Material::find("Si").unwrap();
    /// let one = Section::of_layers(&[Layer::of(silicon, 10e-6, 100e-6)])?;
    /// let two = [Layer::of(silicon, 4e-6, 100e-6), Layer::of(silicon, 6e-6, 100e-6)];
    /// let two = Section::of_layers(&two)?;
    /// assert!((one.stiffness / (169e9 * 100e-6 * 10e-6f64.powi(3) / 12.0) - 1.0).abs() < 1e-12);
    /// assert!((two.stiffness / one.stiffness - 1.0).abs() < 1e-12);
    /// # Ok::<(), impactscope::model::design::DesignError>(())
    /// ```
    pub fn of_layers(layers: &[Layer]) -> Result<Self, DesignError> {
        if layers.is_empty() {
            return Err(DesignError::value("layers", "give at least one layer"));
        }
        for layer in layers {
            let name = |what| format!("layer {}: {what}", layer.name);
            positive(&name("Young's modulus"), layer.modulus, "Pa")?;
            positive(&name("density"), layer.density, "kg/m^3")?;
            positive(&name("thickness"), layer.thickness, "m")?;
            positive(&name("width"), layer.width, "m")?;
            if !layer.d31.is_finite() {
                return Err(DesignError::value(name("d31"), "must be a finite number"));
            }
        }
        let mut bottom = 0.0;
        let middles: Vec<f64> = layers
            .iter()
            .map(|layer| {
                bottom += layer.thickness;
                bottom - 0.5 * layer.thickness
            })
            .collect();
        let sum = |f: &dyn Fn(&Layer, f64) -> f64| -> f64 {
            layers.iter().zip(&middles).map(|(l, z)| f(l, *z)).sum()
        };
        let area = |l: &Layer| l.width * l.thickness;
        let axis = sum(&|l, z| l.modulus * area(l) * z) / sum(&|l, _| l.modulus * area(l));
        let own = |l: &Layer| l.width * l.thickness.powi(3) / 12.0;
        Ok(Self {
            stiffness: sum(&|l, z| l.modulus * (own(l) + area(l) * (z - axis).powi(2))),
            mass_per_length: sum(&|l, _| l.density * area(l)),
            neutral_axis: Some(axis),
            moment_per_volt: sum(&|l, z| -l.modulus * l.d31 * l.width * (z - axis)),
        })
    }

    /// A beam whose stiffness [N m^2] and mass per length [kg/m] are known.
    ///
    /// # Errors
    /// [`DesignError::Value`] if either is not above 0.
    pub fn given(stiffness: f64, mass_per_length: f64) -> Result<Self, DesignError> {
        Ok(Self {
            stiffness: positive("EI", stiffness, "N m^2")?,
            mass_per_length: positive("mass per length", mass_per_length, "kg/m")?,
            neutral_axis: None,
            moment_per_volt: 0.0,
        })
    }
}

/// The rigid mass at the end of a beam; none has mass 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EndMass {
    /// Mass \[kg\].
    pub mass: f64,
    /// Moment of inertia about its own centre, for bending [kg m^2].
    pub inertia: f64,
    /// Distance of its centre beyond the beam's end \[m\].
    pub offset: f64,
}

impl EndMass {
    /// A block that begins at the beam's end: `length` along the beam and `height` \[m\].
    pub fn block(mass: f64, length: f64, height: f64) -> Self {
        Self {
            mass,
            inertia: mass * (length * length + height * height) / 12.0,
            offset: 0.5 * length,
        }
    }
}

/// A beam with its end mass.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamDesign {
    /// Length from the clamp to the end mass \[m\].
    pub length: f64,
    /// Its cross-section.
    pub section: Section,
    /// What is at its end.
    pub end_mass: EndMass,
    /// Where along the beam the piezo layer begins and ends \[m\].
    pub piezo_span: (f64, f64),
    /// Number of modes, 1 to 32.
    pub modes: usize,
}

impl BeamDesign {
    /// A beam with one end mass, all of it covered by its piezo layer.
    pub fn new(length: f64, section: Section, end_mass: EndMass, modes: usize) -> Self {
        Self {
            length,
            section,
            end_mass,
            piezo_span: (0.0, length),
            modes,
        }
    }

    /// Checks all values.
    ///
    /// # Errors
    /// [`DesignError::Value`] naming the value.
    pub fn check(&self) -> Result<(), DesignError> {
        positive("L", self.length, "m")?;
        positive("EI", self.section.stiffness, "N m^2")?;
        positive("mass per length", self.section.mass_per_length, "kg/m")?;
        not_negative("mass", self.end_mass.mass, "kg")?;
        not_negative("inertia", self.end_mass.inertia, "kg m^2")?;
        if !self.end_mass.offset.is_finite() {
            return Err(DesignError::value("mass_offset", "must be a finite number"));
        }
        if self.modes == 0 || self.modes > crate::model::MAX_MODES {
            let reason = format!(
                "must be 1 to {}, not {}",
                crate::model::MAX_MODES,
                self.modes
            );
            return Err(DesignError::value("modes", reason));
        }
        let (from, to) = self.piezo_span;
        if !(from >= 0.0 && from < to && to <= self.length * (1.0 + 1e-9)) {
            let reason = format!(
                "must begin and end on the beam of {} m, one after the other, not {from} m and {to} m",
                self.length
            );
            return Err(DesignError::value("piezo", reason));
        }
        Ok(())
    }
}
