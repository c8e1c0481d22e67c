//! What is wrong with the readings of a recording: a line in the lists of recordings.

use eframe::egui::{Id, Label, Ui};

use crate::app::setup::overlay::Overlay;
use crate::app::widgets::text::small;
use crate::model::unit::counted;
use crate::recording::instrument_faults::InstrumentFault;

/// A line that says how many kinds of faults the instrument has, with sizes and places on hover.
/// Nothing where there are none, or while they are looked for, which happens on a thread of its
/// own.
pub(super) fn show(ui: &mut Ui, overlay: &Overlay) {
    let recording = &overlay.recording;
    let Some(found) = recording.known_faults() else {
        let key = Id::unique((
            "instrument faults",
            std::sync::Arc::as_ptr(recording) as usize,
        ));
        let asked = ui.data_mut(|data| std::mem::replace(data.get_temp_mut_or_default(key), true));
        if !asked {
            let (context, recording) = (ui.ctx().clone(), recording.clone());
            std::thread::spawn(move || {
                let _ = recording.instrument_faults();
                context.request_repaint();
            });
        }
        return;
    };
    let faults = &found.faults;
    if faults.is_empty() {
        return;
    }
    let text = match &faults[..] {
        [one] => one.label(),
        [first, rest @ ..] => {
            format!(
                "{} and {}",
                first.label(),
                counted(rest.len(), "other fault")
            )
        }
        [] => return,
    };
    let text = small(format!("Instrument: {text}")).color(ui.visuals().warn_fg_color);
    let sentences: Vec<String> = faults.iter().map(InstrumentFault::sentence).collect();
    ui.add(Label::new(text).wrap())
        .on_hover_text(sentences.join("\n"));
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::super::recording_faults::*;
    use crate::app::files::built_in;
    use crate::recording::Recording;

    #[test]
    fn spikes_of_a_recording_are_listed() {
        let time: Vec<f64> = (0..2000).map(|i| 1e-4 * f64::from(i)).collect();
        let mut xp: Vec<f64> = time.iter().map(|t| 1e-5 * (300.0 * t).sin()).collect();
        let sensor = crate::model::sensor::Sensor {
            noise: 1e-8,
            ..Default::default()
        };
        sensor.add_noise(&mut xp, 1);
        xp[500] += 5e-6;
        xp[900] -= 4e-6;
        let mut overlay = built_in::setup().overlays.swap_remove(0);
        overlay.recording = Arc::new(Recording::new("spiky", time, None, xp, None).unwrap());
        let _ = overlay.recording.instrument_faults();
        let mut harness = Harness::new_ui(|ui| show(ui, &overlay));
        harness.run();
        harness.get_by_label("Instrument: 2 spikes in xp");
    }
}
