//! How the device is looked at: whole or near the contact, with or without values at the arrows.

use eframe::egui::{Pos2, Response, Sense};

use super::Layout;
use super::moment::{Extremes, Moment};

/// Height of what is seen when the contact fills the picture, as a share of the whole.
const CONTACT_VIEW_SHARE: f64 = 0.14;
/// Share of that height below the ground.
const BELOW_GROUND_SHARE: f64 = 0.12;

/// The look of the device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DeviceLook {
    /// From 0, the whole motion, to 1, the contact.
    pub zoom: f64,
    /// Whether the arrows carry names and values.
    pub has_labels: bool,
    /// Whether the mass can be taken with the pointer.
    pub is_movable: bool,
}

impl DeviceLook {
    /// What the picture reacts to.
    pub(super) fn sense(self) -> Sense {
        if self.is_movable {
            Sense::click_and_drag()
        } else {
            Sense::CLICK
        }
    }

    /// Narrows the heights in view around the ground.
    pub(super) fn zoom_in(self, extremes: &mut Extremes, ground: Option<f64>) {
        let Some(ground) = ground.filter(|_| self.zoom > 0.0) else {
            return;
        };
        let height = CONTACT_VIEW_SHARE * (extremes.high - extremes.low);
        let low = ground - BELOW_GROUND_SHARE * height;
        let mix = |far: f64, near: f64| far + (near - far) * self.zoom.min(1.0);
        extremes.high = mix(extremes.high, low + height);
        extremes.low = mix(extremes.low, low);
    }
}

/// Where the device was drawn.
pub struct DevicePlace {
    /// The response of the picture.
    pub response: Response,
    /// Where the foot of the mass is.
    pub mass: Pos2,
    low: f64,
    low_y: f32,
    scale: f64,
    offset: f64,
}

impl DevicePlace {
    pub(super) fn new(response: Response, layout: &Layout, moment: &Moment, offset: f64) -> Self {
        Self {
            response,
            mass: Pos2::new(layout.mass_x, layout.y(moment.xp)),
            low: layout.low,
            low_y: layout.low_y,
            scale: layout.scale,
            offset,
        }
    }

    /// The reading of a mass whose foot is at the height `y` on screen \[m\].
    pub fn reading_at(&self, y: f32) -> f64 {
        self.low + f64::from(self.low_y - y) / self.scale + self.offset
    }
}
