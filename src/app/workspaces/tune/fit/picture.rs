//! Correlations as a picture, and how many combinations of parameters the data tell.

use eframe::egui::{Align2, Color32, FontId, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};
use nalgebra::{DMatrix, SymmetricEigen};

use super::choose::symbol;
use super::heading;
use crate::app::workspaces::tune::small;
use crate::fit::FitResult;
use crate::model::unit::format_number;

/// Side of a cell [points], and room for the names.
const CELL: f32 = 30.0;
const NAMES: f32 = 62.0;

/// Draws the matrix of correlations of what the data tell, and Fisher's eigenvalues below.
pub fn correlations(ui: &mut Ui, result: &FitResult) {
    let told: Vec<usize> = (0..result.parameters.len())
        .filter(|&i| result.parameters[i].std_error.is_finite())
        .collect();
    let n = told.len();
    if n < 2 {
        return;
    }
    heading(ui, "Correlations");
    let value = |i: usize, j: usize| result.correlations[(told[i], told[j])];
    let id = |i: usize| result.parameters[told[i]].id.as_str();
    let side = NAMES + CELL * n as f32;
    let (rect, response) = ui.allocate_exact_size(vec2(side, side - NAMES + 18.0), Sense::hover());
    let painter = ui.painter_at(rect);
    let (ink, strong) = (ui.visuals().text_color(), ui.visuals().strong_text_color());
    let font = FontId::proportional(11.0);
    let at = |i: usize, j: usize| {
        let corner = rect.min + vec2(NAMES + CELL * j as f32, 18.0 + CELL * i as f32);
        Rect::from_min_size(corner, vec2(CELL - 1.0, CELL - 1.0))
    };
    let name = |i: usize| shorten(&symbol(id(i)));
    for i in 0..n {
        let row = at(i, 0);
        painter.text(
            pos2(row.left() - 6.0, row.center().y),
            Align2::RIGHT_CENTER,
            name(i),
            font.clone(),
            ink,
        );
        let column = at(0, i);
        painter.text(
            pos2(column.center().x, column.top() - 3.0),
            Align2::CENTER_BOTTOM,
            name(i),
            font.clone(),
            ink,
        );
        for j in 0..n {
            let value = value(i, j);
            let cell = at(i, j);
            painter.rect_filled(cell, 2.0, color(value, ui.visuals().dark_mode));
            painter.text(
                cell.center(),
                Align2::CENTER_CENTER,
                written(value),
                FontId::proportional(10.0),
                if value.abs() > 0.5 { strong } else { ink },
            );
        }
    }
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, spoken(result, &told)));
    let under = response.hover_pos().and_then(|pointer| {
        let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        places
            .into_iter()
            .find(|&(i, j)| at(i, j).contains(pointer))
    });
    if let Some((i, j)) = under {
        let text = format!("{} and {}: {:.3}", id(i), id(j), value(i, j));
        response.on_hover_text_at_pointer(text);
    }
    if let Some(text) = eigenvalues(result, &told) {
        ui.label(small(text).weak());
    }
}

/// A correlation in a cell; one near zero has no sign.
fn written(value: f64) -> String {
    if value.abs() < 0.005 {
        "0".to_owned()
    } else {
        format!("{value:.2}")
    }
}

/// The strong correlations in words.
fn spoken(result: &FitResult, told: &[usize]) -> String {
    let mut text = "Correlations".to_owned();
    for (place, &i) in told.iter().enumerate() {
        for &j in &told[place + 1..] {
            let value = result.correlations[(i, j)];
            if value.abs() > 0.5 {
                let (a, b) = (&result.parameters[i].id, &result.parameters[j].id);
                text += &format!("; {a} and {b} {value:.2}");
            }
        }
    }
    text
}

/// What the data tell of combinations of the parameters that they tell: standard errors
/// of the best and of the least certain one, relative to the values.
fn eigenvalues(result: &FitResult, told: &[usize]) -> Option<String> {
    let relative = |i: usize| {
        let parameter = &result.parameters[told[i]];
        parameter.std_error / parameter.value.abs()
    };
    let n = told.len();
    if !(0..n).all(|i| relative(i).is_finite()) {
        return None;
    }
    let covariance = DMatrix::from_fn(n, n, |i, j| {
        result.correlations[(told[i], told[j])] * relative(i) * relative(j)
    });
    let eigen = SymmetricEigen::new(covariance);
    let last = eigen.eigenvalues.imax();
    // Rounding leaves this much of the largest one.
    let least = 1e-14 * eigen.eigenvalues[last];
    let values = eigen.eigenvalues.map(|value| value.max(least));
    let mut parts: Vec<(f64, String)> = (0..n)
        .map(|i| {
            let share = eigen.eigenvectors[(i, last)];
            (share.abs(), symbol(&result.parameters[told[i]].id))
        })
        .collect();
    parts.sort_by(|a, b| b.0.total_cmp(&a.0));
    let names: Vec<String> = parts
        .into_iter()
        .filter(|(share, _)| *share > 0.3)
        .map(|(_, name)| name)
        .collect();
    Some(format!(
        "Fisher eigenvalues {} to {}: the least certain combination, of {}, is known to {} %.",
        format_number(1.0 / values.min(), 2),
        format_number(1.0 / values.max(), 2),
        names.join(", "),
        format_number(100.0 * values.max().sqrt(), 2),
    ))
}

fn shorten(name: &str) -> String {
    name.chars().take(9).collect()
}

/// Blue for negative, orange for positive, deeper where stronger.
fn color(value: f64, dark: bool) -> Color32 {
    let strength = value.abs().clamp(0.0, 1.0) as f32;
    let (full, none) = match (value < 0.0, dark) {
        (true, true) => ([0x1f, 0x6f, 0xb5], 0x22),
        (false, true) => ([0xb8, 0x6a, 0x10], 0x22),
        (true, false) => ([0x7f, 0xb8, 0xea], 0xf4),
        (false, false) => ([0xf5, 0xb4, 0x5f], 0xf4),
    };
    let mix = |full: u8| (none as f32 + (f32::from(full) - none as f32) * strength) as u8;
    Color32::from_rgb(mix(full[0]), mix(full[1]), mix(full[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::FittedParameter;
    use crate::model::preset::Preset;

    #[test]
    fn what_the_data_do_not_tell_spoils_no_other_figure() {
        let parameter = |id: &str, value, std_error| FittedParameter {
            id: id.to_owned(),
            value,
            std_error,
            unit: "",
            start: value,
            at_bound: false,
        };
        let mut correlations = DMatrix::identity(3, 3);
        (correlations[(0, 2)], correlations[(2, 0)]) = (0.6, 0.6);
        let result = FitResult {
            model: Preset::default().model,
            parameters: vec![
                parameter("Cs", 2e-21, 2e-23),
                parameter("Ca", 1.7e-6, f64::INFINITY),
                parameter("gp", 7e-5, 7e-7),
            ],
            correlations,
            fisher_values: vec![1e300, 1.0, 1e-213],
            fisher_vectors: DMatrix::identity(3, 3),
            remarks: Vec::new(),
            train: Default::default(),
            held_out: None,
            cancelled: false,
        };
        // Two errors of 1 %, correlated by 0.6: variances of 1.6 and 0.4 times 1e-4.
        let text = eigenvalues(&result, &[0, 2]).unwrap();
        assert!(text.contains("25000 to 6250"), "{text}");
        assert!(
            text.contains("of Cs, gp") || text.contains("of gp, Cs"),
            "{text}"
        );
        assert!(text.contains("known to 1.3 %"), "{text}");
        assert_eq!(spoken(&result, &[0, 2]), "Correlations; Cs and gp 0.60");
        assert_eq!(written(-1e-9), "0");
    }
}
