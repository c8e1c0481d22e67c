//! `device`: a preset for one's own device, from geometry, a table of modes, lumped parts, or a swept sine.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::Args;
use serde_json::json;

use super::recordings::ReadingArguments;
use super::{Failure, interrupt, output, recordings, terminal, wrong_command};
use crate::fit::Control;
use crate::fit::modal::{ModalOptions, identify};
use crate::model::design::{DesignKind, Designed, MATERIALS, describe};
use crate::model::preset::Preset;
use crate::model::unit::format_quantity;

/// What the texts say, for `--help`.
fn keys() -> String {
    let materials: Vec<&str> = MATERIALS.iter().map(|m| m.name).collect();
    format!(
        "Texts are KEY=VALUE,...; values take units, none is SI.\n  \
         beam:     L, W; layers=Si:5um+PZT:1um (from the bottom; PZT:1um:80um has its own width), or t with\n            \
         material or E and rho, or EI and m (mass per length); mass_size=150x100x10um with mass or\n            \
         mass_material, or mass with mass_offset and inertia; modes=2; piezo=0..500um\n  \
         spring:   m and k, or m and f; x0\n  \
         pendulum: L, angle, m, g, inertia\n  \
         free:     m, x0, v0, g\n  \
         modes:    mass\n  \
         all:      name, zeta or Q (several as 0.02/0.03), ground (distance to contact), film (gas left at\n            \
         contact), plate=150x100um, viscosity, alpha, adhesion, force (per volt), V (amplitude of the drive)\n\
         Materials: {}",
        materials.join(", ")
    )
}

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(after_help = keys())]
#[group(id = "from", required = true, multiple = false, args = ["beam", "modes", "spring", "pendulum", "free", "sweep"])]
pub struct Arguments {
    /// A cantilever with a mass at its end, e.g. L=750um,W=100um,layers=Si:5um+PZT:1um,mass_size=150x100x10um
    #[arg(long, value_name = "KEY=VALUE,...", allow_hyphen_values = true)]
    beam: Option<String>,
    /// A table of modes (CSV or TOML): frequency, damping, shapes at the cantilever's centre and the mass
    #[arg(long, value_name = "FILE")]
    modes: Option<PathBuf>,
    /// A mass on a spring, e.g. m=0.2kg,k=15N/m
    #[arg(long, value_name = "KEY=VALUE,...", allow_hyphen_values = true)]
    spring: Option<String>,
    /// A pendulum, e.g. L=1m,angle=5deg
    #[arg(long, value_name = "KEY=VALUE,...", allow_hyphen_values = true)]
    pendulum: Option<String>,
    /// A free mass, e.g. m=57g,x0=2m
    #[arg(long, value_name = "KEY=VALUE,...", allow_hyphen_values = true)]
    free: Option<String>,
    /// A swept sine at a low voltage, clear of the ground; repeatable. Its modes replace those of --preset
    #[arg(long, value_name = "RECORDING")]
    sweep: Vec<PathBuf>,
    /// More of the device for --modes, e.g. ground=58um,zeta=0.02
    #[arg(
        long = "with",
        value_name = "KEY=VALUE,...",
        requires = "modes",
        allow_hyphen_values = true
    )]
    with: Option<String>,
    /// The device that --sweep goes on from: its drive, ground and film
    #[arg(long, default_value = "paper", requires = "sweep")]
    preset: String,
    #[command(flatten)]
    reading: ReadingArguments,
    /// File for the device; - for standard output, then without the summary
    #[arg(long, value_name = "DEVICE.toml")]
    out: Option<PathBuf>,
    /// File for what was found as JSON; - for standard output, then without the summary
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`Failure`] with the exit code.
pub fn run(args: &Arguments) -> Result<(), Failure> {
    let outputs = [
        ("--out", args.out.as_deref()),
        ("--json", args.json.as_deref()),
    ];
    let inputs: Vec<PathBuf> = args.sweep.iter().chain(&args.modes).cloned().collect();
    let mut results = output::ready(&outputs, &inputs)?;
    let (preset, notes, found) = if args.sweep.is_empty() {
        let made = described(args)?;
        (made.preset, made.notes, None)
    } else {
        let (preset, notes, found) = identified(args)?;
        (preset, notes, Some(found))
    };
    if let Some(path) = &args.out {
        results.add(path, preset.to_toml());
    }
    if let Some(path) = &args.json {
        let structure = preset.model.structure();
        let modes = structure.modes.iter().map(|mode| {
            json!({
                "frequency": mode.frequency, "zeta": mode.zeta, "phi_c": mode.phi_c, "phi_p": mode.phi_p,
            })
        });
        let value = json!({
            "name": preset.model.name, "modes": modes.collect::<Vec<_>>(), "notes": notes, "identified": found,
        });
        results.add_json(path, &value);
    }
    results.say(&summary(&preset, &notes, args.out.as_deref()));
    results.end()
}

/// A device from a text or a table.
fn described(args: &Arguments) -> Result<Designed, Failure> {
    let texts = [
        (DesignKind::Beam, "--beam", &args.beam),
        (DesignKind::Spring, "--spring", &args.spring),
        (DesignKind::Pendulum, "--pendulum", &args.pendulum),
        (DesignKind::Free, "--free", &args.free),
    ];
    for (kind, option, text) in texts {
        if let Some(text) = text {
            return describe(kind, text)
                .with_context(|| option.to_owned())
                .map_err(wrong_command);
        }
    }
    let Some(path) = &args.modes else {
        return Err(wrong_command(anyhow!(
            "say what the device is, for example --beam L=750um,..."
        )));
    };
    let file = path.display().to_string();
    let content = std::fs::read_to_string(path).with_context(|| {
        format!("{file}: cannot be read; check the path, and that it is a text")
    })?;
    let with = args.with.as_deref().unwrap_or_default();
    Ok(describe(DesignKind::Modes(&file, &content), with)?)
}

/// A device with the modes of a sweep.
fn identified(args: &Arguments) -> Result<(Preset, Vec<String>, serde_json::Value), Failure> {
    let mut preset = Preset::load(&args.preset)?;
    let recordings = recordings::read(&args.sweep, &args.reading)?;
    let control = Control {
        cancel: interrupt::flag(),
        progress: &|_| {},
    };
    let fit = identify(
        &preset.model,
        &recordings,
        &ModalOptions::default(),
        &control,
    )?;
    if !fit.follows_sweep() {
        terminal::warning(
            "these modes do not follow the sweep; the device keeps them, but do not trust it",
        );
    }
    fit.apply(&mut preset.model);
    preset.about = format!("{}, modes from a swept sine", preset.about);
    let found = serde_json::to_value(&fit)?;
    Ok((preset, fit.remarks, found))
}

fn summary(preset: &Preset, notes: &[String], out: Option<&Path>) -> String {
    let mut text = format!("{}: {}\n", preset.model.name, preset.about);
    for (i, mode) in preset.model.structure().modes.iter().enumerate() {
        text += &format!(
            "  mode {}: {}, damping ratio {:.4}, shape {:.5} at the mass\n",
            i + 1,
            format_quantity(mode.frequency, "Hz", 5),
            mode.zeta,
            mode.phi_p
        );
    }
    for note in notes {
        text += &format!("  {note}\n");
    }
    match out {
        Some(path) => text + &format!("written to {}\n", path.display()),
        None => text + "--out DEVICE.toml writes it as a preset\n",
    }
}

#[cfg(test)]
mod tests {
    use super::super::design::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Only {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn parse(line: &str) -> Result<Arguments, clap::Error> {
        let words = std::iter::once("device").chain(line.split_whitespace());
        Only::try_parse_from(words).map(|only| only.arguments)
    }

    #[test]
    fn one_way_to_a_device_is_chosen() {
        assert!(parse("").is_err());
        assert!(parse("--spring m=1,k=1 --pendulum L=1").is_err());
        let made = described(&parse("--spring m=0.2kg,k=15N/m,name=own").unwrap())
            .ok()
            .unwrap();
        assert_eq!(made.preset.model.name, "own");
        let frequency = (15.0f64 / 0.2).sqrt() / std::f64::consts::TAU;
        assert!((made.preset.model.get("f1").unwrap() / frequency - 1.0).abs() < 1e-9);
        let failure = described(&parse("--beam L=750us").unwrap()).unwrap_err();
        assert_eq!(failure.code, 2);
        let said = format!("{:#}", failure.error);
        assert!(said.contains("--beam") && said.contains('L'), "{said}");
        let failure = described(&parse("--modes /no/such.csv").unwrap()).unwrap_err();
        assert_eq!(failure.code, 1);
    }

    #[test]
    fn a_device_that_is_written_loads_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.toml");
        let line = format!(
            "--beam L=750um,EI=1.139e-12,m=3.519e-7,mass=0.3495ug,mass_size=150x100x10um,ground=58um --out {}",
            path.display()
        );
        run(&parse(&line).unwrap()).ok().unwrap();
        let preset = Preset::load(&path.display().to_string()).unwrap();
        let f2 = preset.model.get("f2").unwrap();
        assert!((f2 / 6424.0 - 1.0).abs() < 5e-3, "{f2}");
    }
}
