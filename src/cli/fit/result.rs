//! The result of a fit as text and as JSON.

use serde_json::{Map, Value, json};

use crate::fit::uncertainty::identifiability::{Combinations, determined};
use crate::fit::{FitResult, Misfit};
use crate::model::parameter::ParameterId;
use crate::model::unit::{format_number, format_quantity};

/// Width of a value in the tables.
const VALUE_WIDTH: usize = 16;

/// The result as text.
pub fn text(result: &FitResult) -> String {
    let mut text = String::new();
    if result.cancelled {
        text += "Ended early: this is the best so far.\n";
    }
    text += &values(result);
    if let Some(film) = film_at_contact(result) {
        text += &format!(
            "film damping at contact {}\n",
            format_quantity(film, "N s/m", 4)
        );
    }
    for remark in &result.remarks {
        text += &format!("note: {remark}\n");
    }
    let held_out = result.held_out.as_ref();
    for (title, set) in [("fitted to", Some(&result.train)), ("held out", held_out)] {
        let Some((all, each)) = set else { continue };
        text += &format!("{title}: {}\n", misfit(all));
        for one in each.iter().filter(|_| each.len() > 1) {
            text += &format!("  {}: {}\n", one.name, misfit(one));
        }
    }
    text + &correlations(result) + &eigenvalues(result)
}

fn values(result: &FitResult) -> String {
    let mut text = format!(
        "{:<22} {:>VALUE_WIDTH$} {:>14} {:>VALUE_WIDTH$}\n",
        "parameter", "value", "std. error", "before"
    );
    for p in &result.parameters {
        text += &format!(
            "{:<22} {:>VALUE_WIDTH$} {:>14} {:>VALUE_WIDTH$}{}\n",
            p.id,
            format_quantity(p.value, p.unit, 5),
            error(p.std_error, p.unit),
            format_quantity(p.start, p.unit, 4),
            if p.at_bound { "  at its bound" } else { "" }
        );
    }
    text
}

/// A standard error as text; infinite ones are "not determined".
pub fn error(std_error: f64, unit: &str) -> String {
    if std_error.is_finite() {
        format_quantity(std_error, unit, 2)
    } else {
        "not determined".to_owned()
    }
}

/// Correlations of the determined parameters; empty for a single one.
fn correlations(result: &FitResult) -> String {
    let shown = determined(result);
    if shown.len() < 2 {
        return String::new();
    }
    let id = |i: &usize| result.parameters[*i].id.as_str();
    let longest = shown.iter().map(|i| id(i).len()).max().unwrap_or(0);
    let mut text = format!("correlations\n{:longest$}", "");
    for i in &shown {
        text += &format!("  {:>6}", id(i));
    }
    text.push('\n');
    for (row, i) in shown.iter().enumerate() {
        text += &format!("{:longest$}", id(i));
        for j in &shown[..=row] {
            let wide = id(j).len().max(6);
            text += &format!("  {:>wide$.2}", result.correlations[(*i, *j)]);
        }
        text.push('\n');
    }
    text
}

/// Fisher eigenvalues with their combinations of parameters.
fn eigenvalues(result: &FitResult) -> String {
    let Some(found) = Combinations::of(result) else {
        return String::new();
    };
    let mut text = "Fisher eigenvalues, standard error of each combination\n".to_owned();
    for (k, value) in found.values.iter().enumerate() {
        text += &format!(
            "  {:>10}  {:>8} %  {}\n",
            format_number(*value, 3),
            format_number(100.0 * found.error(k), 2),
            found.named(k).join(", ")
        );
    }
    text
}

/// `Cs / (gp - dp)^3` where there is a film \[N s/m\].
fn film_at_contact(result: &FitResult) -> Option<f64> {
    let p = &result.model.parameters;
    let thickness = p[ParameterId::Gp] - p[ParameterId::Dp];
    result
        .model
        .has_ground
        .then(|| p[ParameterId::Cs] / thickness.powi(3))
}

fn misfit(m: &Misfit) -> String {
    let aside = if m.set_aside > 0.0 {
        format!(
            "; {:.1} % of the samples set aside, around events that could not be resolved",
            100.0 * m.set_aside
        )
    } else {
        String::new()
    };
    format!(
        "rms {} against noise {} (chi2 {}){aside}",
        format_quantity(m.rms, "m", 3),
        format_quantity(m.noise, "m", 3),
        format_number(m.chi2, 3)
    )
}

/// The result as JSON, values in SI.
pub fn as_json(result: &FitResult) -> Value {
    let mut parameters = Map::new();
    for p in &result.parameters {
        let value = json!({
            "value": p.value, "std_error": p.std_error, "unit": p.unit,
            "start": p.start, "at_bound": p.at_bound,
        });
        parameters.insert(p.id.clone(), value);
    }
    let shown = determined(result);
    let ids: Vec<&str> = shown
        .iter()
        .map(|&i| result.parameters[i].id.as_str())
        .collect();
    let matrix: Vec<Vec<f64>> = shown
        .iter()
        .map(|&i| shown.iter().map(|&j| result.correlations[(i, j)]).collect())
        .collect();
    let fisher = Combinations::of(result).map(|found| {
        let directions: Vec<Vec<f64>> = (found.vectors.column_iter())
            .map(|column| column.iter().copied().collect())
            .collect();
        json!({ "ids": found.ids, "eigenvalues": found.values, "directions": directions })
    });
    let film = film_at_contact(result);
    json!({
        "parameters": parameters,
        "film_at_contact": film.map(|value| json!({ "value": value, "unit": "N s/m" })),
        "train": side(&result.train),
        "held_out": result.held_out.as_ref().map(side),
        "correlations": { "ids": ids, "matrix": matrix },
        "fisher": fisher,
        "remarks": result.remarks,
        "cancelled": result.cancelled,
    })
}

/// The misfits of one side: all recordings together, and each.
fn side((all, each): &(Misfit, Vec<Misfit>)) -> Value {
    let of = |m: &Misfit| {
        json!({
            "rms_um": m.rms * 1e6,
            "noise_um": m.noise * 1e6,
            "chi2": m.chi2,
            "set_aside": m.set_aside,
        })
    };
    let mut value = of(all);
    let each = each.iter().map(|m| {
        let mut own = of(m);
        own["name"] = json!(m.name);
        own
    });
    value["recordings"] = each.collect();
    value
}

#[cfg(test)]
mod tests {
    use super::super::result::*;
    use crate::fit::uncertainty::identifiability::tests::made_up;

    #[test]
    fn the_text_shows_values_correlations_and_eigenvalues() {
        let mut result = made_up();
        result.cancelled = true;
        result.parameters[2].at_bound = true;
        let text = text(&result);
        println!("{text}");
        assert!(text.starts_with("Ended early: this is the best so far.\n"));
        // Ca is not determined: it has neither correlation nor eigenvalue.
        assert!(
            text.contains("correlations\n        Cs      gp\nCs    1.00\ngp    0.60    1.00\n")
        );
        assert!(text.contains("25000      0.63 %  "), "{text}");
        assert!(text.contains("6250       1.3 %  "), "{text}");
        assert!(text.contains("not determined") && text.contains("at its bound"));
    }

    #[test]
    fn json_has_the_same_content() {
        let mut result = made_up();
        let own = |name: &str| Misfit {
            name: name.to_owned(),
            rms: 2e-8,
            ..Misfit::default()
        };
        result.train = (own(""), vec![own("a"), own("b")]);
        let value = as_json(&result);
        assert_eq!(value["cancelled"], false);
        assert_eq!(value["parameters"]["gp"]["at_bound"], false);
        assert!(value["parameters"]["Ca"]["std_error"].is_null());
        assert_eq!(value["correlations"]["ids"], json!(["Cs", "gp"]));
        assert_eq!(value["correlations"]["matrix"][0][1], 0.6);
        assert_eq!(value["fisher"]["eigenvalues"].as_array().unwrap().len(), 2);
        assert_eq!(value["train"]["recordings"][1]["name"], "b");
        assert!((value["train"]["recordings"][1]["rms_um"].as_f64().unwrap() - 0.02).abs() < 1e-9);
        assert!(value["film_at_contact"]["value"].as_f64().unwrap() > 0.0);
        assert!(value["held_out"].is_null());
    }
}
