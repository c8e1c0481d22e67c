//! Options of `sweep`, and its help.

use std::path::PathBuf;

use clap::Args;

use crate::explore::measures::MEASURES;

/// Syntax, measures and examples, for `--help`.
fn lists() -> String {
    let mut text = String::from(
        "Axes for --grid, one or two, joined by a comma:\n  ID=FROM:TO:COUNT[UNIT][:log]   f=5:100:20Hz is from 5 to 100 Hz in 20 points,\n                                 both ends with it; an end may have its own unit, or\n                                 be a multiple of the device's value: Cs=0.5x:2x:9:log\n  ID is a number of the drive (f, V, offset, lambda, duty, asymmetry, phase, h1, t1)\n  or a parameter of the device or of an effect (Cs, gp, gravity.g); a wrong one lists all\n\nCoefficients for --over, joined by a comma:\n  ID:LOW..HIGH[:linear]          Cs:0.5x..2x is from half to twice the device's value,\n                                 equal ratios equally likely; linear: equal differences\n\nMeasures for --measure, joined by a comma (unit; meaning):\n",
    );
    for row in MEASURES {
        let unit = if row.unit.is_empty() { "-" } else { row.unit };
        text += &format!("  {:<20} {unit:<10} {}\n", row.id, row.meaning);
    }
    text += "  contact is short for contact_share\n\nThe environment's RAYON_NUM_THREADS sets the number of threads.\n";
    text
}

/// Arguments of `sweep`.
#[derive(Debug, Args)]
#[command(after_help = lists())]
pub struct Arguments {
    /// Device: paper, paper-as-printed, oscillator, faller, bouncing-ball, or a preset file
    #[arg(long, default_value = "paper")]
    pub preset: String,
    /// Drive; a kind alone (square, sine, triangle, ramped) takes frequency and amplitude of the preset's
    /// drive [default: the preset's]
    #[arg(long, allow_hyphen_values = true)]
    pub drive: Option<String>,
    /// One or two axes, e.g. f=5:100:20Hz,V=4:8:9V
    #[arg(long, value_name = "AXIS[,AXIS]", allow_hyphen_values = true)]
    pub grid: Option<String>,
    /// Coefficients that vary in an ensemble, e.g. Cs:0.5x..2x
    #[arg(long, value_name = "ID:LOW..HIGH,...")]
    pub over: Vec<String>,
    /// Devices of the ensemble [default with --over: 32]
    #[arg(long, value_name = "N")]
    pub ensemble: Option<usize>,
    /// What is wanted of the response, for the column of its probability: regime=sticks or
    /// contact=0.3..0.4; repeatable
    #[arg(long, value_name = "MEASURE=LOW..HIGH")]
    pub want: Vec<String>,
    /// Measures [default: regime,contact_share,peak,impact_speed_first]
    #[arg(long, value_name = "ID,...")]
    pub measure: Option<String>,
    /// Parameter to change, e.g. Cs=2e-21 or gp="72 um"; repeatable
    #[arg(long, value_name = "ID=VALUE")]
    pub set: Vec<String>,
    /// Effect to switch on, e.g. quadratic_drag:cd=1e-7; repeatable
    #[arg(long, value_name = "ID[:PARAMETER=VALUE,...]")]
    pub effect: Vec<String>,
    /// Seed of the ensemble
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Compute only part I of N: points I-1, I-1+N, ...
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Put shards together, whatever their order; one that is given twice counts once
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["grid", "over", "ensemble", "want", "measure", "set", "effect", "shard", "drive"])]
    pub merge: Vec<PathBuf>,
    /// File for the table (CSV); - for standard output
    #[arg(long, value_name = "F.csv")]
    pub out: PathBuf,
}
