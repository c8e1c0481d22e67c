//! What the coordinates of a device are: displacements, or angles of a pendulum.
//!
//! The equations are the same; an angle goes with a moment in place of a force, and with a
//! moment of inertia in place of a mass.

use serde::{Deserialize, Serialize};

/// What the readings and coordinates of a device measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coordinate {
    /// A displacement \[m\].
    #[default]
    Length,
    /// An angle \[rad\].
    Angle,
}

/// Units of a device that moves along a line, and what they are where it turns.
const TURNED: [(&str, &str); 15] = [
    ("m", "rad"),
    ("m/s", "rad/s"),
    ("m/s^2", "rad/s^2"),
    ("N", "N m"),
    ("N/s", "N m/s"),
    ("N/m", "N m/rad"),
    ("N/m^2", "N m/rad^2"),
    ("N/m^3", "N m/rad^3"),
    ("N/m^5", "N m/rad^5"),
    ("N s/m", "N m s/rad"),
    ("N s^2/m^2", "N m s^2/rad^2"),
    ("N m^2 s", "N m rad^2 s"),
    ("N/m^1.5", "N m/rad^1.5"),
    ("kg", "kg m^2"),
    ("kg^-1/2", "(kg m^2)^-1/2"),
];

impl Coordinate {
    /// As written in a preset.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Length => "length",
            Self::Angle => "angle",
        }
    }

    /// The one of that id.
    #[must_use]
    pub fn find(id: &str) -> Option<Self> {
        [Self::Length, Self::Angle]
            .into_iter()
            .find(|c| c.id() == id)
    }

    /// The unit of the coordinate itself, `m` or `rad`.
    #[must_use]
    pub fn base_unit(self) -> &'static str {
        self.unit("m")
    }

    /// The unit of a quantity of this device that is in `unit` where the coordinate is a length. Units
    /// without a length or a force stay.
    #[must_use]
    pub fn unit(self, unit: &'static str) -> &'static str {
        match self {
            Self::Length => unit,
            Self::Angle => TURNED
                .iter()
                .find(|(along, _)| *along == unit)
                .map_or(unit, |(_, turned)| turned),
        }
    }

    /// Whether it is a length, which files leave out.
    pub(in crate::model) fn is_length(&self) -> bool {
        *self == Self::Length
    }
}

#[cfg(test)]
mod tests {
    use super::super::coordinate::*;

    #[test]
    fn an_angle_goes_with_moments() {
        let angle = Coordinate::Angle;
        assert_eq!((angle.base_unit(), angle.unit("N")), ("rad", "N m"));
        assert_eq!((angle.unit("Hz"), angle.unit("")), ("Hz", ""));
        assert_eq!(Coordinate::Length.unit("N/m"), "N/m");
        for coordinate in [Coordinate::Length, Coordinate::Angle] {
            assert_eq!(Coordinate::find(coordinate.id()), Some(coordinate));
        }
        assert_eq!(Coordinate::find("metres"), None);
    }
}
