//! The pictures of a film, laid out as in the window.

use eframe::egui::{CentralPanel, Context, Pos2, RawInput, Rect, RichText, Ui, vec2};
use image::RgbaImage;

use super::raster::Raster;
use super::request::FilmRequest;
use crate::app::analysis::learning::runs::SceneResult;
use crate::app::plots::device::DeviceLook;
use crate::app::plots::stage::{Overlay, Stage};
use crate::app::theme;
use crate::model::unit::format_quantity;

/// Passes before the first picture: sizes settle in the second.
const SETTLING_PASSES: usize = 3;

/// A window without a screen.
pub(super) struct Studio {
    context: Context,
    raster: Raster,
    size: [u32; 2],
    passes: usize,
}

impl Studio {
    /// A studio for pictures of `size` \[pixels\].
    pub(super) fn new(request: &FilmRequest, size: [u32; 2]) -> Self {
        let context = Context::default();
        theme::apply(&context, request.dark);
        Self {
            context,
            raster: Raster::new(size),
            size,
            passes: 0,
        }
    }

    /// The picture of a moment \[s\].
    pub(super) fn picture(
        &mut self,
        request: &FilmRequest,
        result: &SceneResult,
        time: f64,
    ) -> RgbaImage {
        while self.passes < SETTLING_PASSES {
            self.pass(request, result, time);
        }
        self.pass(request, result, time);
        self.raster.picture()
    }

    fn pass(&mut self, request: &FilmRequest, result: &SceneResult, time: f64) {
        let [width, height] = self.size;
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(width as f32, height as f32));
        let input = RawInput {
            screen_rect: Some(screen),
            time: Some(self.passes as f64),
            ..RawInput::default()
        };
        self.passes += 1;
        let mut output = self.context.run_ui(input, |ui| {
            CentralPanel::default().show(ui, |ui| draw(ui, request, result, time));
        });
        self.raster.take_textures(&output.textures_delta);
        output.textures_delta.clear();
        let background = self
            .context
            .style_of(self.context.theme())
            .visuals
            .panel_fill;
        self.raster.clear(background);
        let scale = output.pixels_per_point;
        for clipped in self.context.tessellate(output.shapes, scale) {
            self.raster.paint(&clipped, scale);
        }
    }
}

fn draw(ui: &mut Ui, request: &FilmRequest, result: &SceneResult, time: f64) {
    let saved = &request.saved;
    let head = format!(
        "{}   t = {}",
        saved.scene.preset.model.name,
        format_quantity(time, "s", 4)
    );
    ui.label(RichText::new(head).size(16.0).strong());
    let zoom = if saved.shows.zoom && request.is_slow_at_impacts {
        result.slow.nearness(time)
    } else {
        0.0
    };
    let stage = Stage {
        scene: &saved.scene,
        result,
        time,
        pictures: &saved.pictures,
        look: DeviceLook {
            zoom,
            has_labels: saved.shows.forces,
            is_movable: false,
        },
        overlay: Overlay::default(),
        holds_scale: false,
        name: "film",
    };
    stage.show(ui);
}
