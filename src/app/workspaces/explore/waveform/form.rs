//! A standard form to start from, with duty, asymmetry and ramps.

use eframe::egui::{ComboBox, Ui};

use super::super::fields::{Row, name, within};
use crate::app::analysis::explore::drawing::{Drawing, FormChoice, FormKind};
use crate::explore::waveform::EditableWaveform;

/// Largest amplitude that can be typed \[V\].
const LARGEST_AMPLITUDE: f64 = 1e4;

/// Draws the choice; each change puts the form in the place of the handles, which can be undone.
pub fn show(ui: &mut Ui, drawn: &mut EditableWaveform, drawing: &mut Drawing) {
    let mut form = drawing.form;
    let mut is_asked = false;
    ui.horizontal(|ui| {
        name(ui, "Start from", "A standard form, in place of the handles");
        let picker = ComboBox::from_id_salt("form")
            .width(108.0)
            .selected_text(form.kind.label())
            .show_ui(ui, |ui| {
                for kind in FormKind::ALL {
                    let entry = ui.selectable_value(&mut form.kind, kind, kind.label());
                    is_asked |= entry.clicked();
                }
            });
        picker
            .response
            .on_hover_text("A standard form, in place of the handles; it can be undone");
    });
    numbers(ui, &mut form);
    if form == drawing.form && !is_asked {
        return;
    }
    drawing.form = form;
    match form.drawn(drawn) {
        Ok(new) => {
            *drawn = new;
            drawing.selected = None;
            drawing.refusal = None;
        }
        Err(error) => drawing.refusal = Some(error.to_string()),
    }
}

fn numbers(ui: &mut Ui, form: &mut FormChoice) {
    let amplitude = Row {
        label: "form amplitude",
        name: "Amplitude",
        help: "Largest voltage of the form, without the offset",
        value: form.amplitude,
        unit: "V",
    };
    let most = LARGEST_AMPLITUDE;
    if let Some(new) = amplitude.show(ui, |v| within(v, -most, most, "the amplitude")) {
        form.amplitude = new;
    }
    let shares: &mut [(&str, &str, &str, &mut f64)] = &mut match form.kind {
        FormKind::Sine => return,
        FormKind::Square => vec![duty(&mut form.duty)],
        FormKind::Triangle => vec![(
            "form asymmetry",
            "Asymmetry",
            "Share of the period that the voltage rises; 0.5 is symmetric, 1 a sawtooth",
            &mut form.asymmetry,
        )],
        FormKind::Ramped => vec![
            duty(&mut form.duty),
            (
                "form ramp",
                "Ramp share",
                "Share of the period that each ramp takes; 0 is a square wave",
                &mut form.lambda,
            ),
        ],
    };
    for (label, name, help, value) in shares {
        let row = Row {
            label,
            name,
            help,
            value: **value,
            unit: "",
        };
        let what = format!("the {}", name.to_lowercase());
        if let Some(new) = row.show(ui, |v| within(v, 0.0, 1.0, &what)) {
            **value = new;
        }
    }
}

fn duty(value: &mut f64) -> (&'static str, &'static str, &'static str, &mut f64) {
    (
        "form duty",
        "Duty",
        "Share of the period that the voltage is high",
        value,
    )
}
