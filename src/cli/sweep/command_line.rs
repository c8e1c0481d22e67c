//! What a sweep is asked for, and the command as it stands in its file.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use sha2::{Digest, Sha256};

use super::arguments::Arguments;
use super::{ensemble, grid, shard};
use crate::cli::device::{add_effect, drive_input, read_drive, set_parameter, warn_of_odd_values};
use crate::cli::{Failure, wrong_command};
use crate::explore::map::MapRequest;
use crate::explore::robustness::RobustnessRequest;
use crate::explore::waveform;
use crate::model::drive::Waveform;
use crate::model::preset::Preset;

/// Kinds of drives that may stand alone.
const KINDS: [&str; 4] = ["square", "sine", "triangle", "ramped"];
/// Frequency \[Hz\] and amplitude \[V\] of such a one where the preset's drive has none.
const USUAL_DRIVE: (f64, f64) = (50.0, 5.0);
/// Share of the period that the ramps of a ramped square take that stands alone.
const USUAL_LAMBDA: f64 = 0.1;
/// Measures without `--measure`.
const USUAL_MEASURES: &str = "regime,contact_share,peak,impact_speed_first";

/// A sweep, ready to be computed.
pub struct Sweep {
    /// The points; `measures` are the columns.
    pub map: MapRequest,
    /// The same over an ensemble, if there is one.
    pub robustness: Option<RobustnessRequest>,
    /// Part and number of parts.
    pub shard: Option<(usize, usize)>,
    /// Lines at the beginning of the file, without those that differ between shards.
    pub header: Vec<String>,
    /// Files that are read.
    pub inputs: Vec<PathBuf>,
}

impl Sweep {
    /// Reads the options.
    pub fn read(args: &Arguments) -> Result<Self, Failure> {
        let preset = Preset::load(&args.preset)?;
        let text = drive_text(args.drive.as_deref(), &preset);
        let drive = read_drive(&text, preset.duration)?;
        let mut model = preset.model.clone();
        for text in &args.set {
            set_parameter(&mut model, text).map_err(wrong_command)?;
        }
        for text in &args.effect {
            add_effect(&mut model, text).map_err(wrong_command)?;
        }
        let grid = args.grid.as_deref().ok_or_else(|| {
            wrong_command(anyhow!(
                "--grid is missing; write for example --grid f=5:100:20Hz,V=4:8:9V, or --merge FILE..."
            ))
        })?;
        let axes = grid::axes(grid, &model, &drive).map_err(wrong_command)?;
        let measures = args.measure.as_deref().unwrap_or(USUAL_MEASURES);
        let measures = grid::measures(measures).map_err(wrong_command)?;
        warn_of_odd_values(&preset, &model, &drive);
        let map = MapRequest::new(model, drive, axes, measures);
        let robustness = ensemble::request(args, &map).map_err(wrong_command)?;
        let shard = args.shard.as_deref().map(shard::parse).transpose();
        let mut sweep = Self {
            map,
            robustness,
            shard: shard.map_err(wrong_command)?,
            header: Vec::new(),
            inputs: drive_input(&text).into_iter().collect(),
        };
        sweep.check()?;
        sweep.header = sweep.header(args, &text).map_err(Failure::from)?;
        if Path::new(&args.preset).is_file() {
            sweep.inputs.push(PathBuf::from(&args.preset));
        }
        Ok(sweep)
    }

    fn check(&self) -> Result<(), Failure> {
        let axes = self.map.axes.iter();
        let points = axes.fold(1u128, |all, axis| all.saturating_mul(axis.count as u128));
        let parts = self.shard.map_or(1, |(_, parts)| parts as u128);
        let own = points.div_ceil(parts);
        if parts > points {
            return Err(wrong_command(anyhow!(
                "--shard: {parts} parts of {points} points leave some empty; take at most {points} parts"
            )));
        }
        let checked = match &self.robustness {
            None => self.map.check_for(own).map_err(anyhow::Error::from),
            Some(request) => request.check_for(own).map_err(anyhow::Error::from),
        };
        checked.map_err(wrong_command)
    }

    /// Points of this part, in order.
    pub fn indices(&self) -> Vec<usize> {
        let (part, parts) = self.shard.unwrap_or((1, 1));
        (part - 1..self.map.points()).step_by(parts).collect()
    }

    /// Program, command, seed, device and number of points. Paths are left out, for they differ from
    /// machine to machine; the digest says what was in the files.
    fn header(&self, args: &Arguments, drive: &str) -> anyhow::Result<Vec<String>> {
        let mut words = vec!["impactscope".to_owned(), "sweep".to_owned()];
        let mut option = |name: &str, value: &str| {
            words.push(format!("--{name}"));
            words.push(quoted(value));
        };
        option("preset", &without_folder(&args.preset));
        option("drive", &without_folder(drive));
        if let Some(grid) = &args.grid {
            option("grid", grid);
        }
        args.over.iter().for_each(|text| option("over", text));
        if let Some(request) = &self.robustness {
            option("ensemble", &request.ensemble.members.to_string());
        }
        args.want.iter().for_each(|text| option("want", text));
        let measures: Vec<&str> = self.map.measures.iter().map(|m| m.spec().id).collect();
        option("measure", &measures.join(","));
        args.set.iter().for_each(|text| option("set", text));
        args.effect.iter().for_each(|text| option("effect", text));
        option("seed", &args.seed.to_string());
        let model = serde_json::to_string(&self.map.model).context("device")?;
        let drive = format!("{:?}", self.map.drive);
        let digest = Sha256::new()
            .chain_update(model)
            .chain_update(drive)
            .finalize();
        let digest: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(vec![
            format!("# impactscope {} sweep", env!("CARGO_PKG_VERSION")),
            format!("# command: {}", words.join(" ")),
            format!("# seed: {}", args.seed),
            format!("# device and drive: sha256 {digest}"),
            format!("# points: {}", self.map.points()),
        ])
    }
}

/// The drive as text: a kind alone takes numbers of the preset's drive.
fn drive_text(given: Option<&str>, preset: &Preset) -> String {
    let Some(text) = given else {
        return preset.drive.clone();
    };
    if !KINDS.contains(&text) {
        return text.to_owned();
    }
    let own = Waveform::parse(&preset.drive, preset.duration).unwrap_or(Waveform::Rest);
    let frequency = waveform::get(&own, "frequency").unwrap_or(USUAL_DRIVE.0);
    let amplitude = waveform::get(&own, "amplitude").unwrap_or(USUAL_DRIVE.1);
    let mut full = format!("{text}:{frequency}Hz:{amplitude}V");
    if text == "ramped" {
        full += &format!(":{USUAL_LAMBDA}");
    }
    full
}

/// A value in which a file's folder is left out.
fn without_folder(text: &str) -> String {
    let (kind, path) = match drive_input(text) {
        Some(path) => (&text[..text.find(':').map_or(0, |at| at + 1)], path),
        None => ("", PathBuf::from(text)),
    };
    match path
        .file_name()
        .filter(|_| !kind.is_empty() || path.is_file())
    {
        Some(name) => format!("{kind}{}", name.to_string_lossy()),
        None => text.to_owned(),
    }
}

/// A word of a command for a shell, on one line.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.,:=/+%".contains(c);
    let one_line = word.replace(['\n', '\r'], " ");
    if !one_line.is_empty() && one_line.chars().all(is_plain) {
        one_line
    } else {
        format!("'{}'", one_line.replace('\'', "'\\''"))
    }
}
