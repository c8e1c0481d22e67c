//! What a frame of the real window costs the processor: everything the program does in
//! one, and its shapes made into triangles, without drawing these. A recording fills the
//! view and is dragged to and fro, so that every frame shows another part of it.
//!
//! `cargo bench --bench frame`. Besides criterion's figures: the slowest of 600 frames.

use std::hint::black_box;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use criterion::Criterion;
use eframe::App;
use eframe::egui::{
    Context, Event, FullOutput, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, Shape,
    ViewportId, pos2, vec2,
};
use impactscope::app::shell::options::WindowOptions;
use impactscope::app::shell::screenshot::PictureOutcome;
use impactscope::app::shell::window::Shell;
use impactscope::model::preset::Preset;

type Failed = Box<dyn std::error::Error>;

/// Size of the window [points].
const WINDOW_SIZE: [f32; 2] = [1440.0, 900.0];
/// A point in the plot of the trajectories.
const PLOT_MIDDLE: Pos2 = pos2(640.0, 480.0);
/// How far the pointer moves between two frames [points].
const POINTER_STEP: f32 = 3.0;
/// Frames after which the pointer turns back.
const TURN_FRAMES: usize = 50;
/// The time that the window shows at first [s].
const SHOWN_SPAN: f64 = 0.4;

/// The window as its owner drives it, less the picture on a screen.
struct Window {
    context: Context,
    shell: Shell,
    frame: eframe::Frame,
    pointer: Pos2,
    frames: usize,
    pans: usize,
}

impl Window {
    fn new(files: Vec<PathBuf>) -> Result<Self, Failed> {
        let context = Context::default();
        let options = WindowOptions {
            files,
            ..WindowOptions::default()
        };
        let preset = Preset::default();
        let outcome = PictureOutcome::default();
        let shell = Shell::new(&context, options, Some(preset), outcome)?;
        Ok(Self {
            context,
            shell,
            frame: eframe::Frame::_new_kittest(),
            pointer: PLOT_MIDDLE,
            frames: 0,
            pans: 0,
        })
    }

    /// One frame, 1/60 s after the last.
    fn draw(&mut self, events: Vec<Event>) -> FullOutput {
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, WINDOW_SIZE.into())),
            time: Some(self.frames as f64 / 60.0),
            events,
            ..RawInput::default()
        };
        self.frames += 1;
        let mut output = self
            .context
            .run_ui(input, |ui| self.shell.ui(ui, &mut self.frame));
        // Nobody draws the text.
        output.textures_delta.clear();
        output
    }

    /// Draws until all of `texts` are to be read and nothing is to be drawn any more.
    fn settle(&mut self, texts: &[&str]) -> Result<(), Failed> {
        let started = Instant::now();
        let mut still = 0;
        while still < 50 {
            if started.elapsed() > Duration::from_secs(120) {
                return Err(format!("{texts:?} are not there, or it does not come to rest").into());
            }
            let output = self.draw(Vec::new());
            let root = output.viewport_output.get(&ViewportId::ROOT);
            let rests = root.is_none_or(|root| root.repaint_delay > Duration::from_secs(1));
            let shown = written(&output);
            let done = |text: &&str| shown.iter().any(|(known, _)| known.contains(*text));
            let all = texts.iter().all(done);
            still = if rests && all { still + 1 } else { 0 };
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(())
    }

    fn key(&mut self, key: Key) {
        self.draw(vec![Event::Key {
            key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: Modifiers::NONE,
        }]);
    }

    fn button(&mut self, pressed: bool) {
        let button = Event::PointerButton {
            pos: self.pointer,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.draw(vec![Event::PointerMoved(self.pointer), button]);
    }

    /// A frame in which the view is dragged on.
    fn pan(&mut self) -> FullOutput {
        let back = (self.pans / TURN_FRAMES) % 2 == 1;
        self.pans += 1;
        self.pointer += vec2(if back { -POINTER_STEP } else { POINTER_STEP }, 0.0);
        let moved = Event::PointerMoved(self.pointer);
        self.draw(vec![moved])
    }

    /// The same with the triangles; how long its two parts took [ms].
    fn whole(&mut self) -> [f64; 2] {
        let started = Instant::now();
        let output = self.pan();
        let described = Instant::now();
        let triangles = self
            .context
            .tessellate(output.shapes, output.pixels_per_point);
        black_box(triangles);
        let parts = [described - started, described.elapsed()];
        parts.map(|part| part.as_secs_f64() * 1e3)
    }
}

/// All texts and their places.
fn written(output: &FullOutput) -> Vec<(String, Pos2)> {
    fn collect(shape: &Shape, texts: &mut Vec<(String, Pos2)>) {
        match shape {
            Shape::Text(text) => texts.push((text.galley.text().to_owned(), text.pos)),
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, texts)),
            _ => {}
        }
    }
    let mut all = Vec::new();
    for clipped in &output.shapes {
        collect(&clipped.shape, &mut all);
    }
    all
}

/// Whether the ticks of the time axis went with the pointer: otherwise the figures would
/// be those of a window at rest.
fn follows(window: &mut Window) -> bool {
    let (before, from) = (written(&window.pan()), window.pointer.x);
    let (after, to) = (written(&window.pan()), window.pointer.x);
    let moved = before.iter().filter(|(text, place)| {
        let goes = |(other, now): &&(String, Pos2)| {
            other == text && now.y == place.y && (now.x - place.x - (to - from)).abs() < 1.5
        };
        text.parse::<f64>().is_ok() && after.iter().any(|other| goes(&other))
    });
    moved.count() >= 3
}

/// A recording of `samples` that fills the window's span: noise on a wave, so that each
/// column of pixels holds other extremes.
fn recording(folder: &Path, samples: usize) -> Result<PathBuf, Failed> {
    let path = folder.join(format!("samples-{samples}.csv"));
    let mut file = std::io::BufWriter::new(std::fs::File::create(&path)?);
    writeln!(file, "t [s],V [V],xp [um],xc [um]")?;
    let mut state = 1u64;
    for i in 0..samples {
        let t = SHOWN_SPAN * i as f64 / samples as f64;
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
        let noise = (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5;
        let wave = (600.0 * t).sin();
        let (xp, xc) = (50.0 * wave + 4.0 * noise, 15.0 * wave - noise);
        writeln!(file, "{t:.8},{:.3},{xp:.4},{xc:.4}", 8.0 * wave.signum())?;
    }
    file.flush()?;
    Ok(path)
}

fn main() -> Result<(), Failed> {
    // The window remembers what it opened: not in the person's own folder.
    const DATA: &str = "IMPACTSCOPE_DATA_DIR";
    let folder = tempfile::tempdir()?;
    if std::env::var_os("FRAME_BENCH").is_none() {
        let again = std::process::Command::new(std::env::current_exe()?)
            .args(std::env::args_os().skip(1))
            .env("FRAME_BENCH", "1")
            .env(DATA, folder.path())
            .status()?;
        return again.success().then_some(()).ok_or("see above".into());
    }
    let mut criterion = Criterion::default().configure_from_args();
    for (samples, more) in [
        (0, &[][..]),
        (10_000, &[][..]),
        (1_000_000, &[][..]),
        // Forces, phase portrait and drive loop as well.
        (1_000_000, &[Key::Num4, Key::Num5, Key::Num6][..]),
    ] {
        let files = match samples {
            0 => Vec::new(),
            _ => vec![recording(folder.path(), samples)?],
        };
        let mut window = Window::new(files)?;
        // The comparison with the recording comes last.
        let name = format!("xp samples-{samples}");
        let texts = [name.as_str(), "NRMSE"];
        let texts = if samples > 0 { &texts[..] } else { &[] };
        window.settle(texts)?;
        for &key in more {
            window.key(key);
        }
        window.settle(texts)?;
        window.button(true);
        // A few points are a click still.
        for _ in 0..5 {
            window.pan();
        }
        if !follows(&mut window) {
            return Err("the view does not follow the pointer".into());
        }
        let pictures = if more.is_empty() { "usual" } else { "all" };
        let name = format!("frame, {samples} samples, {pictures} pictures");
        criterion.bench_function(&name, |bench| bench.iter(|| window.whole()));
        let mut frames: Vec<[f64; 2]> = (0..600).map(|_| window.whole()).collect();
        frames.sort_by(|a, b| a.iter().sum::<f64>().total_cmp(&b.iter().sum()));
        let [(ui, triangles), (u, t)] = [300, 599].map(|i| (frames[i][0], frames[i][1]));
        println!(
            "{name}: median {:.2} ms (ui {ui:.2}, triangles {triangles:.2}), slowest of 600 {:.2} ms",
            ui + triangles,
            u + t
        );
        window.button(false);
    }
    Ok(())
}
