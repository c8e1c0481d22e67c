//! Colours and sizes of the whole window, dark and light. Every text has a contrast of at least
//! 4.5:1 against what it is drawn on (WCAG 2, level AA).

use eframe::egui::{
    Color32, Context, FontFamily, FontId, Style, TextStyle, Theme, ThemePreference, Visuals,
};

/// Sets sizes once and the colours of the theme.
pub fn apply(context: &Context, dark: bool) {
    context.set_theme(if dark {
        ThemePreference::Dark
    } else {
        ThemePreference::Light
    });
    for (theme, is_dark) in [(Theme::Dark, true), (Theme::Light, false)] {
        context.style_mut_of(theme, |style| colour(&mut style.visuals, is_dark));
    }
    context.all_styles_mut(|style| {
        style.text_styles.insert(
            TextStyle::Small,
            FontId::new(11.5, FontFamily::Proportional),
        );
        style.spacing.item_spacing.y = 4.0;
    });
}

/// Lets nothing glide, or lets it.
pub fn set_motion(context: &Context, is_still: bool) {
    let usual = Style::default().animation_time;
    let time = if is_still { 0.0 } else { usual };
    context.all_styles_mut(|style| style.animation_time = time);
}

/// Sets the colours that the library's own do not read well in.
fn colour(visuals: &mut Visuals, dark: bool) {
    visuals.warn_fg_color = warning(dark);
    visuals.error_fg_color = error(dark);
    visuals.weak_text_color = Some(weak(dark));
    if dark {
        visuals.widgets.noninteractive.fg_stroke.color = Color32::from_gray(0xb4);
    } else {
        visuals.hyperlink_color = Color32::from_rgb(0x00, 0x5a, 0xaa);
        visuals.selection.stroke.color = Color32::from_rgb(0x00, 0x46, 0x6e);
        // White fields on near white would not be seen.
        visuals.text_edit_bg_color = Some(Color32::from_gray(0xe4));
    }
}

/// Text of an error.
pub fn error(dark: bool) -> Color32 {
    if dark {
        Color32::from_rgb(0xff, 0x8a, 0x75)
    } else {
        Color32::from_rgb(0xb0, 0x2a, 0x16)
    }
}

/// Text of a warning.
pub fn warning(dark: bool) -> Color32 {
    if dark {
        Color32::from_rgb(0xff, 0x8f, 0x00)
    } else {
        Color32::from_rgb(0x8f, 0x42, 0x00)
    }
}

/// Text of what is less important.
fn weak(dark: bool) -> Color32 {
    Color32::from_gray(if dark { 0x9c } else { 0x5a })
}

/// Text of what is as it should be.
pub fn good(dark: bool) -> Color32 {
    if dark {
        Color32::from_rgb(0x8c, 0xd1, 0x7d)
    } else {
        Color32::from_rgb(0x19, 0x6b, 0x26)
    }
}

#[cfg(test)]
mod tests {
    use super::super::theme::*;
    use crate::app::plots::frame::style;

    /// Least contrast of text, WCAG 2.1, criterion 1.4.3.
    const LEAST_CONTRAST: f64 = 4.5;

    /// Relative luminance of an opaque colour, WCAG 2.
    fn luminance(color: Color32) -> f64 {
        let linear = |byte: u8| {
            let value = f64::from(byte) / 255.0;
            if value <= 0.03928 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        };
        0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
    }

    fn contrast(a: Color32, b: Color32) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    /// `faint` over an opaque `below`, as it is seen.
    fn over(faint: Color32, below: Color32) -> Color32 {
        let through = 1.0 - f64::from(faint.a()) / 255.0;
        let mix = |top: u8, below: u8| (f64::from(top) + through * f64::from(below)).min(255.0);
        Color32::from_rgb(
            mix(faint.r(), below.r()) as u8,
            mix(faint.g(), below.g()) as u8,
            mix(faint.b(), below.b()) as u8,
        )
    }

    fn visuals(dark: bool) -> Visuals {
        let context = Context::default();
        apply(&context, dark);
        let theme = if dark { Theme::Dark } else { Theme::Light };
        context.style_of(theme).visuals.clone()
    }

    #[test]
    fn contrast_is_that_of_the_standard() {
        assert!((contrast(Color32::BLACK, Color32::WHITE) - 21.0).abs() < 1e-9);
        // #767676 on white is the known limit.
        let limit = contrast(Color32::from_gray(0x76), Color32::WHITE);
        assert!((limit - 4.54).abs() < 0.01, "{limit}");
    }

    #[test]
    fn every_text_is_readable_in_both_themes() {
        for dark in [true, false] {
            let visuals = visuals(dark);
            let widgets = &visuals.widgets;
            let panel = visuals.panel_fill;
            let field = visuals
                .text_edit_bg_color
                .unwrap_or(visuals.extreme_bg_color);
            let plot = visuals.extreme_bg_color;
            let striped = over(visuals.faint_bg_color, panel);
            let button = widgets.inactive.weak_bg_fill;
            let grounds = vec![panel, visuals.window_fill, striped];
            let with = |more: &[Color32]| [&grounds[..], more].concat();
            let mut texts = vec![
                ("text", visuals.text_color(), grounds.clone()),
                ("weak text", visuals.weak_text_color(), with(&[field])),
                ("strong text", visuals.strong_text_color(), with(&[field])),
                ("warning", visuals.warn_fg_color, grounds.clone()),
                ("error", error(dark), with(&[field])),
                (
                    "error of the library",
                    visuals.error_fg_color,
                    grounds.clone(),
                ),
                ("good", good(dark), grounds.clone()),
                ("link", visuals.hyperlink_color, grounds.clone()),
                (
                    "button",
                    widgets.inactive.text_color(),
                    with(&[button, field]),
                ),
                (
                    "button under the pointer",
                    widgets.hovered.text_color(),
                    vec![widgets.hovered.weak_bg_fill],
                ),
                (
                    "button pressed",
                    widgets.active.text_color(),
                    vec![widgets.active.weak_bg_fill],
                ),
                (
                    "open menu",
                    widgets.open.text_color(),
                    vec![widgets.open.weak_bg_fill],
                ),
                (
                    "selection",
                    visuals.selection.stroke.color,
                    vec![visuals.selection.bg_fill],
                ),
            ];
            let palette = style::palette_of(dark);
            texts.extend([
                ("axis", palette.text, vec![panel, plot]),
                ("name of a level", palette.ground, vec![panel, plot]),
                ("after a diagnosis", palette.proof_mass, grounds.clone()),
                ("first cursor", palette.cursor[0], vec![panel, plot]),
                ("second cursor", palette.cursor[1], vec![panel, plot]),
                ("verdict, adequate", palette.release, grounds.clone()),
                ("verdict, missing", palette.impact, grounds.clone()),
                ("verdict, partly", palette.cursor[1], grounds.clone()),
                ("verdict, unexplained", palette.stick, grounds.clone()),
            ]);
            for color in style::overlay_colors(dark) {
                texts.push(("name of a recording", color, grounds.clone()));
            }
            for color in style::kept_colors(dark) {
                let places = with(&[panel, plot, field]);
                texts.push(("name of a kept curve", color, places));
            }
            for (name, color, backgrounds) in texts {
                for background in backgrounds {
                    let found = contrast(color, background);
                    assert!(
                        found >= LEAST_CONTRAST,
                        "{name}, dark {dark}: {color:?} on {background:?} has {found:.2}"
                    );
                }
            }
        }
    }
}
