//! The one table of parameters. Sliders, fits, presets, the command line and the
//! documentation all read it; nothing else names a default, a range or a unit.

use serde::{Deserialize, Serialize};

use super::unit::format_quantity;

/// How a parameter is stepped, drawn and fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps are equal differences.
    Linear,
    /// Equal steps are equal ratios: the range spans decades.
    Log,
}

/// Where a parameter stands in the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// The five that are tuned by hand: large and first.
    Primary,
    /// Next in use.
    Secondary,
    /// Under "Advanced".
    Advanced,
}

/// One row of the table. Values, ranges and limits are SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSpec {
    /// What people type: `Cs`, `gp`.
    pub id: &'static str,
    /// The symbol as drawn on screen.
    pub symbol: &'static str,
    /// The term of the field.
    pub name: &'static str,
    /// SI unit, empty for a plain number.
    pub unit: &'static str,
    /// Value of the `paper` preset.
    pub default: f64,
    /// Range of the slider, inclusive.
    pub range: (f64, f64),
    /// Values outside are refused everywhere, inclusive.
    pub limits: (f64, f64),
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Place in the window.
    pub rank: Rank,
    /// What it is, in one line.
    pub meaning: &'static str,
    /// The equation it stands in.
    pub equation: &'static str,
}

impl ParameterSpec {
    /// Position of `value` in the slider range as 0..1, on the parameter's scale.
    pub fn fraction(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Log => (value / low).ln() / (high / low).ln(),
        }
    }

    /// Inverse of [`Self::fraction`].
    pub fn value_at(&self, fraction: f64) -> f64 {
        let (low, high) = self.range;
        match self.scale {
            Scale::Linear => low + fraction * (high - low),
            Scale::Log => low * (high / low).powf(fraction),
        }
    }

    /// Why `value` cannot be taken, if it cannot.
    pub fn refusal(&self, value: f64) -> Option<String> {
        let (low, high) = self.limits;
        if !value.is_finite() {
            return Some(format!("{} must be a finite number", self.id));
        }
        if value < low {
            return Some(format!(
                "{} = {} is below {}",
                self.id,
                format_quantity(value, self.unit, 5),
                format_quantity(low, self.unit, 5)
            ));
        }
        if value > high {
            return Some(format!(
                "{} = {} is above {}",
                self.id,
                format_quantity(value, self.unit, 5),
                format_quantity(high, self.unit, 5)
            ));
        }
        None
    }
}

macro_rules! parameter_table {
    ($($variant:ident: $id:literal, $symbol:literal, $name:literal, $unit:literal, $default:expr,
        $range:expr, $limits:expr, $scale:ident, $rank:ident, $meaning:literal, $equation:literal;)*) => {
        /// Index into [`PARAMETERS`] and [`Parameters`].
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(usize)]
        pub enum ParameterId { $(#[doc = $meaning] $variant),* }

        impl ParameterId {
            /// All parameters in the order of the table.
            pub const ALL: [ParameterId; [$(ParameterId::$variant),*].len()] =
                [$(ParameterId::$variant),*];
        }

        /// The table.
        pub const PARAMETERS: [ParameterSpec; ParameterId::ALL.len()] = [$(ParameterSpec {
            id: $id, symbol: $symbol, name: $name, unit: $unit, default: $default,
            range: $range, limits: $limits, scale: Scale::$scale, rank: Rank::$rank,
            meaning: $meaning, equation: $equation,
        }),*];
    };
}

const UNBOUNDED_RANGE: (f64, f64) = (-1e9, 1e9);
const NOT_NEGATIVE: (f64, f64) = (0.0, 1e9);

parameter_table! {
    Cs: "Cs", "Cs", "squeeze-film coefficient", "N m^2 s", 1.747e-21, (1e-23, 1e-19), NOT_NEGATIVE, Log, Primary,
        "strength of the gas film's damping between proof mass and ground", "F_film = -Cs xp' / (xp + gp)^3   (eq. 10)";
    Gp: "gp", "gp", "effective film gap", "m", 70e-6, (20e-6, 200e-6), (1e-9, 1e9), Linear, Primary,
        "thickness of the gas film when the proof mass is at its zero position; must exceed dp", "F_film = -Cs xp' / (xp + gp)^3   (eq. 10)";
    Ca: "Ca", "Ca", "adhesion growth rate", "N/s", 1.7e-6, (1e-8, 1e-4), NOT_NEGATIVE, Log, Primary,
        "how fast adhesion grows while the mass rests on the ground", "f_a = Ca (t - tc) + Ca0   (eq. 14)";
    Ca0: "Ca0", "Ca0", "initial adhesion", "N", 2.743e-8, (1e-10, 1e-5), NOT_NEGATIVE, Log, Primary,
        "adhesion at the moment of touch; below it a bounce sticks", "f_a = Ca (t - tc) + Ca0   (eq. 14)";
    Alpha: "alpha", "α", "coefficient of restitution", "", 0.378, (0.0, 1.0), (0.0, 1.0), Linear, Primary,
        "speed after an impact over speed before it", "v+ = -alpha v-   (eq. 12)";
    Eta: "eta", "η", "drive gain", "N", 3.819e-7, (1e-8, 1e-5), NOT_NEGATIVE, Log, Secondary,
        "force on the cantilever per unit of the piezo polynomial gc; 3.819e-7 N gives 16.5 µm of static tip motion", "F_drive = eta gc(V, V')   (eq. 6)";
    Dp: "dp", "dp", "contact distance", "m", 58e-6, (20e-6, 200e-6), (1e-9, 1e9), Linear, Secondary,
        "distance from the zero position of the proof mass down to the ground", "contact at xp = -dp   (eq. 11)";
    Zeta1: "zeta1", "ζ1", "damping ratio, mode 1", "", 0.0262, (1e-3, 1.0), (0.0, 20.0), Log, Secondary,
        "share of critical damping of the first mode", "q1'' + 2 zeta1 w1 q1' + w1^2 q1 = ...   (eq. 1)";
    Zeta2: "zeta2", "ζ2", "damping ratio, mode 2", "", 0.0257, (1e-3, 1.0), (0.0, 20.0), Log, Secondary,
        "share of critical damping of the second mode", "q2'' + 2 zeta2 w2 q2' + w2^2 q2 = ...   (eq. 1)";
    F1: "f1", "f1", "frequency, mode 1", "Hz", 623.0, (0.1, 1e4), (0.0, 1e7), Log, Advanced,
        "undamped natural frequency of the first mode; 0 is a free mass", "w1 = 2 pi f1   (eq. 1)";
    F2: "f2", "f2", "frequency, mode 2", "Hz", 6424.0, (1e2, 1e5), (0.0, 1e7), Log, Advanced,
        "undamped natural frequency of the second mode", "w2 = 2 pi f2   (eq. 1)";
    ShapeC1: "shape_c1", "shape_c1", "cantilever's share in mode 1", "", 1.0, (0.5, 2.0), (-1e3, 1e3), Linear, Advanced,
        "factor on the first mode's shape at the cantilever's reading, for a reading taken elsewhere or a scale that is off", "xc = shape_c1 phi_c1 q1 + ...   (eq. 1)";
    ShapeC2: "shape_c2", "shape_c2", "cantilever's share in mode 2", "", 1.0, (0.5, 2.0), (-1e3, 1e3), Linear, Advanced,
        "factor on the second mode's shape at the cantilever's reading", "xc = ... + shape_c2 phi_c2 q2   (eq. 1)";
    ShapeP2: "shape_p2", "shape_p2", "proof mass's share in mode 2", "", 1.0, (0.5, 2.0), (-1e3, 1e3), Linear, Advanced,
        "factor on the second mode's shape at the proof mass: how much it moves there, and how hard an impact rings it", "xp = phi_p1 q1 + shape_p2 phi_p2 q2   (eq. 1)";
    DriveP: "drive_p", "drive_p", "share of the drive on the proof mass", "", 0.0, (-0.2, 0.2), (-1e3, 1e3), Linear, Advanced,
        "force of the drive on the proof mass over that on the cantilever: how unevenly it drives the modes", "F_drive on p = drive_p eta gc(V, V')   (eq. 6)";
    X0: "x0", "x0", "initial displacement", "m", 0.0, (-100e-6, 100e-6), UNBOUNDED_RANGE, Linear, Advanced,
        "displacement of the proof mass at t = 0, the structure bent as by a force on it", "xp(0) = x0";
    V0: "v0", "v0", "initial velocity", "m/s", 0.0, (-1.0, 1.0), UNBOUNDED_RANGE, Linear, Advanced,
        "velocity of the proof mass at t = 0, given as by an impulse on it", "xp'(0) = v0";
    OffsetP: "offset_p", "offset_p", "sensor offset, proof mass", "m", 0.0, (-100e-6, 100e-6), UNBOUNDED_RANGE, Linear, Advanced,
        "constant added to the reading of xp", "reading = xp + offset_p + noise";
    OffsetC: "offset_c", "offset_c", "sensor offset, cantilever", "m", 0.0, (-100e-6, 100e-6), UNBOUNDED_RANGE, Linear, Advanced,
        "constant added to the reading of xc", "reading = xc + offset_c + noise";
    Noise: "noise", "noise", "sensor noise", "m", 0.0, (0.0, 1e-6), (0.0, 1e9), Linear, Advanced,
        "standard deviation of the white noise added when a recording is made up", "reading = x + offset + noise";
}

impl ParameterId {
    /// The row of the table.
    pub fn spec(self) -> &'static ParameterSpec {
        &PARAMETERS[self as usize]
    }

    /// Finds a parameter by what people type, in any case.
    ///
    /// # Examples
    /// ```
    /// use impactscope::model::parameter::ParameterId;
    ///
    /// let alpha = ParameterId::from_id("alpha").unwrap();
    /// assert_eq!(alpha.spec().unit, "");
    /// assert_eq!(ParameterId::from_id("no such parameter"), None);
    /// ```
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|p| p.spec().id == id)
            .or_else(|| {
                Self::ALL
                    .into_iter()
                    .find(|p| p.spec().id.eq_ignore_ascii_case(id))
            })
    }
}

/// A value for each row of the table, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters([f64; PARAMETERS.len()]);

impl Default for Parameters {
    fn default() -> Self {
        Self(std::array::from_fn(|i| PARAMETERS[i].default))
    }
}

impl Parameters {
    /// Value of one parameter.
    pub fn get(&self, id: ParameterId) -> f64 {
        self.0[id as usize]
    }

    /// Sets one parameter; nothing is checked here, see `Model::check`.
    pub fn set(&mut self, id: ParameterId, value: f64) {
        self.0[id as usize] = value;
    }

    /// Pairs of parameter and value in the order of the table.
    pub fn iter(&self) -> impl Iterator<Item = (ParameterId, f64)> + '_ {
        ParameterId::ALL.into_iter().zip(self.0.iter().copied())
    }
}

impl Serialize for Parameters {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter().map(|(id, value)| (id.spec().id, value)))
    }
}

impl<'de> Deserialize<'de> for Parameters {
    /// Missing rows keep their default, unknown ones are an error.
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let map = std::collections::BTreeMap::<String, f64>::deserialize(deserializer)?;
        let mut parameters = Self::default();
        for (key, value) in map {
            let id = ParameterId::from_id(&key).ok_or_else(|| {
                serde::de::Error::custom(format!("there is no parameter \"{key}\""))
            })?;
            parameters.set(id, value);
        }
        Ok(parameters)
    }
}

impl std::ops::Index<ParameterId> for Parameters {
    type Output = f64;
    fn index(&self, id: ParameterId) -> &f64 {
        &self.0[id as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameter::*;

    #[test]
    fn table_is_sound() {
        for (i, id) in ParameterId::ALL.into_iter().enumerate() {
            let spec = id.spec();
            assert_eq!(id as usize, i);
            assert_eq!(ParameterId::from_id(spec.id), Some(id));
            assert!(spec.range.0 < spec.range.1, "{}", spec.id);
            assert!(spec.refusal(spec.default).is_none(), "{}", spec.id);
            assert!(spec.refusal(spec.range.0).is_none(), "{}", spec.id);
            assert!(spec.refusal(spec.range.1).is_none(), "{}", spec.id);
            if spec.scale == Scale::Log {
                assert!(spec.range.0 > 0.0, "{}", spec.id);
            }
            let middle = spec.value_at(0.3);
            assert!((spec.fraction(middle) - 0.3).abs() < 1e-12, "{}", spec.id);
        }
    }
}
