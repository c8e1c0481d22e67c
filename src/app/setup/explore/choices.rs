//! Choices of the Explore workspace.

use serde::{Deserialize, Serialize};

use super::sweeps::{BasinChoices, DriveSource, MapChoices, OrbitChoices, RobustnessChoices};
use crate::explore::gait::{FOOT_COUNTS, GaitPreset};
use crate::explore::waveform::{DriveLimits, EditableWaveform, SnapGrid};
use crate::model::drive::{Handle, Handles, Interpolation};

/// A foot of the gait.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FootChoice {
    /// Name of an embedded preset; `None` is the device of the Tune workspace.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// By how much its drive is later, as a share of the drive's period.
    pub delay: f64,
}

/// The gait.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GaitChoices {
    /// Which drive.
    pub source: DriveSource,
    /// The feet.
    pub feet: Vec<FootChoice>,
}

/// Feet of the first gait.
const FIRST_FOOT_COUNT: usize = 4;

impl Default for GaitChoices {
    fn default() -> Self {
        let mut new = Self {
            source: DriveSource::Tune,
            feet: Vec::new(),
        };
        new.set_count(FIRST_FOOT_COUNT);
        new.apply(GaitPreset::Tripod);
        new
    }
}

impl GaitChoices {
    /// More or fewer feet; new ones have the present device and no delay.
    pub fn set_count(&mut self, count: usize) {
        let foot = FootChoice {
            device: None,
            delay: 0.0,
        };
        let (fewest, most) = FOOT_COUNTS;
        self.feet.resize(count.clamp(fewest, most), foot);
    }

    /// The delays of a gait.
    pub fn apply(&mut self, gait: GaitPreset) {
        // The number of feet is always one that gaits have.
        let delays = gait.delays(self.feet.len()).unwrap_or_default();
        for (foot, delay) in self.feet.iter_mut().zip(delays) {
            foot.delay = delay;
        }
    }

    /// The gait whose delays these are.
    #[must_use]
    pub fn preset(&self) -> Option<GaitPreset> {
        GaitPreset::ALL.into_iter().find(|gait| {
            let delays = gait.delays(self.feet.len()).unwrap_or_default();
            !delays.is_empty() && self.feet.iter().map(|f| f.delay).eq(delays)
        })
    }
}

/// All choices.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExploreChoices {
    /// The drawn waveform.
    #[serde(with = "waveform_text")]
    pub drawn: EditableWaveform,
    /// The gait.
    pub gait: GaitChoices,
    /// The map.
    pub map: MapChoices,
    /// The orbit diagram.
    pub orbit: OrbitChoices,
    /// The basins.
    pub basins: BasinChoices,
    /// The robustness.
    pub robustness: RobustnessChoices,
}

impl Default for ExploreChoices {
    fn default() -> Self {
        Self {
            drawn: first_drawn(),
            gait: GaitChoices::default(),
            map: MapChoices::default(),
            orbit: OrbitChoices::default(),
            basins: BasinChoices::default(),
            robustness: RobustnessChoices::default(),
        }
    }
}

impl ExploreChoices {
    /// Whether nothing was chosen.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

/// Handles of the first waveform: a square with ramps of a twentieth of the period, share of the
/// period and volts. At the paper's frequency and amplitude.
const FIRST_HANDLES: [(f64, f64); 4] = [(0.0, -8.0), (0.05, 8.0), (0.5, 8.0), (0.55, -8.0)];
/// Its frequency \[Hz\].
const FIRST_FREQUENCY: f64 = 15.0;
/// Its grid: a hundredth of the period, a tenth of a volt.
const FIRST_GRID: SnapGrid = SnapGrid {
    time: Some(0.01),
    voltage: Some(0.1),
};
/// Its limit \[V\]: up to there the paper measured the gain of the film.
const FIRST_VOLTAGE_LIMIT: f64 = crate::model::piezo::MEASURED_VOLTAGE;

fn first_drawn() -> EditableWaveform {
    let points = FIRST_HANDLES.map(|(time, voltage)| Handle { time, voltage });
    // The points are in order, a test makes sure; a single one is always valid.
    let handles = Handles::new(points.to_vec(), Interpolation::Linear);
    let rest = || Handles::new(vec![points[0]], Interpolation::Linear);
    let handles = handles.or_else(|_| rest());
    let mut new = match handles {
        Ok(handles) => EditableWaveform::new("drawn", handles, FIRST_FREQUENCY),
        Err(error) => unreachable!("one handle within the limits is a period: {error}"),
    };
    new.grid = FIRST_GRID;
    new.limits = DriveLimits {
        voltage: Some(FIRST_VOLTAGE_LIMIT),
        slew: None,
    };
    new
}

/// A drawn waveform as the text of its file.
mod waveform_text {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser};

    use crate::explore::waveform::{EditableWaveform, parse, to_text};

    pub(super) fn serialize<S: Serializer>(
        waveform: &EditableWaveform,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let text = to_text(waveform).map_err(ser::Error::custom)?;
        text.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<EditableWaveform, D::Error> {
        let text = String::deserialize(deserializer)?;
        parse(&text).map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::super::choices::*;

    #[test]
    fn the_first_waveform_is_that_of_its_table() {
        let drawn = first_drawn();
        assert_eq!(drawn.handles().len(), FIRST_HANDLES.len());
        assert!(drawn.excesses().unwrap().is_empty());
    }

    #[test]
    fn choices_come_back_from_a_session() {
        let mut choices = ExploreChoices::default();
        choices.drawn.frequency = 22.5;
        choices.drawn.offset = -0.3;
        choices.gait.set_count(6);
        choices.gait.apply(GaitPreset::Wave);
        choices.gait.feet[1].device = Some("paper".to_owned());
        let text = toml::to_string(&choices).unwrap();
        assert_eq!(toml::from_str::<ExploreChoices>(&text).unwrap(), choices);
        assert_eq!(choices.gait.preset(), Some(GaitPreset::Wave));
        assert!(!choices.is_usual());
    }
}
