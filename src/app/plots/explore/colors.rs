//! Colours of the Explore workspace: categories for regimes, a perceptual scale for numbers.

use eframe::egui::Color32;

use crate::explore::measures::Regime;

const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

/// Viridis at even steps (S. van der Walt and N. Smith, matplotlib 2.0, CC0): evenly brighter, and
/// readable for colour-blind people.
const VIRIDIS: [Color32; 11] = [
    rgb(0x44_0154),
    rgb(0x48_2475),
    rgb(0x41_4487),
    rgb(0x35_5f8d),
    rgb(0x2a_788e),
    rgb(0x21_918c),
    rgb(0x22_a884),
    rgb(0x44_bf70),
    rgb(0x7a_d151),
    rgb(0xbd_df26),
    rgb(0xfd_e725),
];

/// Colour of a share of the scale, 0 to 1.
#[must_use]
pub fn scale_color(share: f64) -> Color32 {
    let last = VIRIDIS.len() - 1;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let below = (at.floor() as usize).min(last - 1);
    let t = (at - below as f64) as f32;
    VIRIDIS[below].lerp_to_gamma(VIRIDIS[below + 1], t)
}

/// Bounces with colours of their own between these two: more of them are redder.
const FEW_BOUNCES: Color32 = rgb(0xf0e442);
const MANY_BOUNCES: Color32 = rgb(0xc04a00);
/// Bounces from which on the colour stays.
const REDDEST_BOUNCES: f32 = 8.0;

/// Colour of a regime, after Okabe and Ito's palette.
#[must_use]
pub fn regime_color(regime: Regime) -> Color32 {
    match regime {
        Regime::NoContact => rgb(0x6f7782),
        Regime::TapsOnce => rgb(0x009e73),
        Regime::Bounces(n) => {
            let share = (n as f32 - 2.0) / (REDDEST_BOUNCES - 2.0);
            FEW_BOUNCES.lerp_to_gamma(MANY_BOUNCES, share.clamp(0.0, 1.0))
        }
        Regime::BouncesThenSticks => rgb(0x56b4e9),
        Regime::Sticks => rgb(0x0072b2),
        Regime::NeverLetsGo => rgb(0x3b2f6b),
        Regime::NotPeriodic => rgb(0xcc79a7),
    }
}

/// Colours of responses that differ in kind alone, such as those of basins.
pub const RESPONSE_COLORS: [Color32; 8] = [
    rgb(0x0072b2),
    rgb(0xe69f00),
    rgb(0x009e73),
    rgb(0xcc79a7),
    rgb(0x56b4e9),
    rgb(0xd55e00),
    rgb(0xf0e442),
    rgb(0x9a8cd0),
];

/// What was not computed yet.
#[must_use]
pub fn pending_color(dark: bool) -> Color32 {
    if dark { rgb(0x24272b) } else { rgb(0xe4e6e8) }
}

#[cfg(test)]
mod tests {
    use super::super::colors::*;

    #[test]
    fn the_scale_grows_brighter_and_regimes_differ() {
        let brightness = |c: Color32| {
            0.2126 * f64::from(c.r()) + 0.7152 * f64::from(c.g()) + 0.0722 * f64::from(c.b())
        };
        let all: Vec<f64> = (0..=20)
            .map(|i| brightness(scale_color(f64::from(i) / 20.0)))
            .collect();
        assert!(all.windows(2).all(|w| w[1] > w[0]), "{all:?}");
        let regimes: Vec<Color32> = (0..=24)
            .filter_map(Regime::from_code)
            .filter(|r| !matches!(r, Regime::Bounces(n) if *n > 8))
            .map(regime_color)
            .collect();
        for (i, a) in regimes.iter().enumerate() {
            assert!(regimes[..i].iter().all(|b| a != b), "{i}");
        }
    }
}
