//! Options that make one recording of several: `--average`, `--leave-out-misfits`, `--match-zeros`,
//! `--points`, `--lag`. They are the same wherever a recording is taken.

use std::path::PathBuf;

use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};

use crate::model::unit::{counted, parse_quantity};
use crate::recording::Recording;
use crate::recording::combine::AverageOptions;
use crate::recording::csv::ReadingChoices;
use crate::recording::import::{average_files, import_chosen, import_trials, merge_files};

/// What is averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum AverageOf {
    /// The trials within each file: one recording a file
    Trials,
    /// All trials of all files: one recording
    Files,
}

/// How one recording is made of several.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "How recordings are put together")]
pub(super) struct CombineArguments {
    /// Averages repeated trials of one motion, laid over each other by their voltage; the spread between them
    /// is kept as the noise
    #[arg(long, value_enum, value_name = "WHAT")]
    average: Option<AverageOf>,
    /// Leaves trials out of the average that have another drive or another motion
    #[arg(long, requires = "average")]
    leave_out_misfits: bool,
    /// Makes the zeros of the trials that of the first before they are averaged
    #[arg(long, requires = "average")]
    match_zeros: bool,
    /// Merges runs of one point each, two files after each other in this order, by their common voltage: xp,xc
    /// or xc,xp
    #[arg(long, value_name = "ORDER", conflicts_with = "average")]
    points: Option<String>,
    /// Time added to the run of the cantilever, e.g. -1.5ms, in place of the lag that the voltages show
    #[arg(
        long,
        value_name = "TIME",
        requires = "points",
        allow_hyphen_values = true
    )]
    lag: Option<String>,
}

/// How recordings are put together, as it was understood.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Combine {
    /// Each as it is.
    Separate,
    Average(AverageOf, AverageOptions),
    /// Files in pairs.
    Points {
        is_proof_mass_first: bool,
        lag: Option<f64>,
    },
}

impl CombineArguments {
    pub(super) fn parsed(&self) -> anyhow::Result<Combine> {
        if let Some(what) = self.average {
            let options = AverageOptions {
                leave_out_misfits: self.leave_out_misfits,
                match_zeros: self.match_zeros,
            };
            return Ok(Combine::Average(what, options));
        }
        let Some(order) = &self.points else {
            return Ok(Combine::Separate);
        };
        let is_proof_mass_first = match order.replace(' ', "").as_str() {
            "xp,xc" => true,
            "xc,xp" => false,
            _ => {
                return Err(anyhow!(
                    "--points {order}: say which point each of two files has; write xp,xc or xc,xp"
                ));
            }
        };
        let lag = self.lag.as_deref();
        let lag =
            lag.map(|text| parse_quantity(text, "s").with_context(|| format!("--lag {text}")));
        Ok(Combine::Points {
            is_proof_mass_first,
            lag: lag.transpose()?,
        })
    }
}

impl Combine {
    /// Which paths make one recording each.
    pub(super) fn groups(&self, paths: &[PathBuf]) -> anyhow::Result<Vec<Vec<PathBuf>>> {
        match self {
            Combine::Average(AverageOf::Files, _) => Ok(vec![paths.to_vec()]),
            Combine::Separate | Combine::Average(AverageOf::Trials, _) => {
                Ok(paths.iter().map(|path| vec![path.clone()]).collect())
            }
            Combine::Points { lag, .. } => {
                if !paths.len().is_multiple_of(2) {
                    return Err(anyhow!(
                        "--points takes files in pairs, one of each point; {} given",
                        counted(paths.len(), "file")
                    ));
                }
                if lag.is_some() && paths.len() > 2 {
                    return Err(anyhow!(
                        "--lag is that of one pair of files; {} given: read the pairs one after the other",
                        counted(paths.len(), "file")
                    ));
                }
                Ok(paths.chunks(2).map(<[PathBuf]>::to_vec).collect())
            }
        }
    }

    /// Reads the recordings of a group: several only where `which` names several of a file.
    pub(super) fn read(
        &self,
        group: &[PathBuf],
        choices: &ReadingChoices,
        which: &[usize],
    ) -> anyhow::Result<Vec<Recording>> {
        let named = (!which.is_empty()).then_some(which);
        match (self, group) {
            (Combine::Average(_, options), _) => {
                Ok(vec![average_files(group, named, choices, *options, None)?])
            }
            (
                Combine::Points {
                    is_proof_mass_first,
                    lag,
                },
                [first, second],
            ) => {
                let (xp, xc) = if *is_proof_mass_first {
                    (first, second)
                } else {
                    (second, first)
                };
                Ok(vec![merge_files(xp, xc, choices, *lag, None)?])
            }
            (_, [path]) if which.len() > 1 => Ok(import_trials(path, choices, named, None)?),
            _ => {
                let read = |path: &PathBuf| import_chosen(path, choices, None);
                Ok(group.iter().map(read).collect::<Result<_, _>>()?)
            }
        }
    }
}
