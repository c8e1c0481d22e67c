//! The correlation matrix as a picture, and the combinations of parameters that the data
//! determine.

use eframe::egui::{Align2, Color32, FontId, Grid, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};

use super::choose::symbol;
use crate::app::widgets::text::{heading, small};
use crate::fit::FitResult;
use crate::fit::uncertainty::identifiability::{Combinations, determined};
use crate::model::unit::format_number;

/// Side of a cell \[points\].
const CELL_SIZE: f32 = 30.0;
/// Width of the names on the left \[points\].
const NAMES_WIDTH: f32 = 62.0;
/// Height of the names on top \[points\].
const NAMES_HEIGHT: f32 = 18.0;

/// Draws the correlation matrix of the parameters that the data determine, and below it the
/// eigenvalues of the Fisher information.
pub fn correlations(ui: &mut Ui, result: &FitResult) {
    let determined = determined(result);
    let n = determined.len();
    if n < 2 {
        return;
    }
    heading(ui, "Correlations");
    let value = |i: usize, j: usize| result.correlations[(determined[i], determined[j])];
    let id = |i: usize| result.parameters[determined[i]].id.as_str();
    let side = CELL_SIZE * n as f32;
    let size = vec2(NAMES_WIDTH + side, side + NAMES_HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    let (ink, strong) = (ui.visuals().text_color(), ui.visuals().strong_text_color());
    let font = FontId::proportional(11.0);
    let at = |i: usize, j: usize| {
        let corner = rect.min
            + vec2(
                NAMES_WIDTH + CELL_SIZE * j as f32,
                NAMES_HEIGHT + CELL_SIZE * i as f32,
            );
        Rect::from_min_size(corner, vec2(CELL_SIZE - 1.0, CELL_SIZE - 1.0))
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
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, spoken(result, &determined)));
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
    if let Some(found) = Combinations::of(result) {
        ui.add_space(6.0);
        eigenvalues(ui, &found);
    }
}

/// A correlation as text; near zero it has no sign.
fn written(value: f64) -> String {
    if value.abs() < 0.005 {
        "0".to_owned()
    } else {
        format!("{value:.2}")
    }
}

/// The strong correlations in words, for screen readers.
fn spoken(result: &FitResult, determined: &[usize]) -> String {
    let mut text = "Correlations".to_owned();
    for (place, &i) in determined.iter().enumerate() {
        for &j in &determined[place + 1..] {
            let value = result.correlations[(i, j)];
            if value.abs() > 0.5 {
                let (a, b) = (&result.parameters[i].id, &result.parameters[j].id);
                text += &format!("; {a} and {b} {value:.2}");
            }
        }
    }
    text
}

/// The combinations of parameters, the best determined first.
fn eigenvalues(ui: &mut Ui, found: &Combinations) {
    heading(ui, "Fisher eigenvalues");
    Grid::new("fisher")
        .num_columns(3)
        .striped(true)
        .spacing([14.0, 3.0])
        .show(ui, |ui| {
            for title in ["eigenvalue", "std. error", "combination of"] {
                ui.label(small(title).strong());
            }
            ui.end_row();
            for k in 0..found.values.len() {
                for text in row(found, k) {
                    ui.label(text);
                }
                ui.end_row();
            }
        });
    let text = "For relative changes. Each combination is determined independently of the others; the last one is determined worst.";
    ui.label(small(text).weak());
}

/// Combination number `k`: eigenvalue, standard error and parameters.
fn row(found: &Combinations, k: usize) -> [String; 3] {
    let names: Vec<String> = found.named(k).into_iter().map(symbol).collect();
    [
        format_number(found.values[k], 3),
        format!("{} %", format_number(100.0 * found.error(k), 2)),
        names.join(", "),
    ]
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
    use super::super::picture::*;
    use crate::fit::uncertainty::identifiability::tests::made_up;

    #[test]
    fn only_determined_parameters_are_shown() {
        let result = made_up();
        assert_eq!(
            spoken(&result, &determined(&result)),
            "Correlations; Cs and gp 0.60"
        );
        assert_eq!(written(-1e-9), "0");
        let found = Combinations::of(&result).unwrap();
        let [value, error, names] = row(&found, 1);
        assert_eq!((value.as_str(), error.as_str()), ("6250", "1.3 %"));
        assert!(names == "Cs, gp" || names == "gp, Cs", "{names}");
    }
}
