//! Colours and sizes of the whole window, dark and light.

use eframe::egui::{Color32, Context, FontFamily, FontId, TextStyle, Theme, ThemePreference};

/// Sets sizes once and the colours of the theme.
pub fn apply(context: &Context, dark: bool) {
    context.set_theme(if dark {
        ThemePreference::Dark
    } else {
        ThemePreference::Light
    });
    // White fields on near white would not be seen.
    context.style_mut_of(Theme::Light, |style| {
        style.visuals.text_edit_bg_color = Some(Color32::from_gray(0xe4));
    });
    context.all_styles_mut(|style| {
        style.text_styles.insert(
            TextStyle::Small,
            FontId::new(11.5, FontFamily::Proportional),
        );
        style.spacing.item_spacing.y = 4.0;
    });
}

/// Text of an error.
pub fn error(dark: bool) -> Color32 {
    if dark {
        Color32::from_rgb(0xff, 0x8a, 0x75)
    } else {
        Color32::from_rgb(0xb0, 0x2a, 0x16)
    }
}
