//! Materials of layers, by the names that people type. Values of a layer may always be given
//! instead.

/// A material of a layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// What people type, in any case.
    pub name: &'static str,
    /// Young's modulus along the beam \[Pa\].
    pub modulus: f64,
    /// Density [kg/m^3].
    pub density: f64,
    /// Transverse piezoelectric coefficient \[m/V\], 0 for a passive material. The voltage is
    /// positive along the poling.
    pub d31: f64,
    /// Which form of it, and whose values.
    pub about: &'static str,
}

const fn material(
    name: &'static str,
    modulus: f64,
    density: f64,
    d31: f64,
    about: &'static str,
) -> Material {
    Material {
        name,
        modulus,
        density,
        d31,
        about,
    }
}

/// The catalogue. Thin films differ by tens of percent from one process to the next: measured
/// values of one's own are better.
pub const MATERIALS: [Material; 22] = [
    material(
        "Si",
        169e9,
        2330.0,
        0.0,
        "silicon along <110>; Hopcroft et al., JMEMS 19 (2010) 229",
    ),
    material(
        "Si100",
        130e9,
        2330.0,
        0.0,
        "silicon along <100>; Hopcroft et al., JMEMS 19 (2010) 229",
    ),
    material(
        "polySi",
        160e9,
        2320.0,
        0.0,
        "polysilicon; Sharpe et al., MEMS 1997",
    ),
    material("SiO2", 70e9, 2200.0, 0.0, "thermal oxide"),
    material(
        "Si3N4",
        250e9,
        3100.0,
        0.0,
        "silicon nitride of low pressure deposition",
    ),
    material(
        "PZT",
        70e9,
        7600.0,
        -80e-12,
        "thin film of PZT 52/48; d31 from -50 to -130 pm/V in use",
    ),
    material(
        "PZT-5A",
        61e9,
        7750.0,
        -171e-12,
        "ceramic, 1/s11E; makers' tables",
    ),
    material(
        "PZT-5H",
        60.6e9,
        7500.0,
        -274e-12,
        "ceramic, 1/s11E; makers' tables",
    ),
    material(
        "PZT-4",
        81e9,
        7500.0,
        -123e-12,
        "ceramic, 1/s11E; makers' tables",
    ),
    material(
        "AlN",
        330e9,
        3260.0,
        -2.0e-12,
        "sputtered aluminium nitride",
    ),
    material("ZnO", 140e9, 5610.0, -5.0e-12, "sputtered zinc oxide"),
    material(
        "PVDF",
        2.5e9,
        1780.0,
        23e-12,
        "stretched film; makers' tables",
    ),
    material("Pt", 168e9, 21450.0, 0.0, "platinum"),
    material("Au", 79e9, 19300.0, 0.0, "gold"),
    material("Al", 70e9, 2700.0, 0.0, "aluminium"),
    material("Ti", 110e9, 4510.0, 0.0, "titanium"),
    material("Cr", 279e9, 7190.0, 0.0, "chromium"),
    material("steel", 200e9, 7850.0, 0.0, "steel"),
    material("brass", 100e9, 8500.0, 0.0, "brass"),
    material("glass", 64e9, 2230.0, 0.0, "borosilicate glass"),
    material("PMMA", 3.0e9, 1180.0, 0.0, "acrylic"),
    material("SU-8", 4.0e9, 1200.0, 0.0, "photoresist SU-8"),
];

impl Material {
    /// The material of that name, in any case.
    pub fn find(name: &str) -> Option<&'static Self> {
        MATERIALS.iter().find(|m| m.name.eq_ignore_ascii_case(name))
    }

    /// All names, for a message.
    pub(super) fn names() -> String {
        let names: Vec<&str> = MATERIALS.iter().map(|m| m.name).collect();
        names.join(", ")
    }
}
