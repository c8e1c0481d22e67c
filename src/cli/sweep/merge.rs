//! Shards put together, row by row, to the bytes of one run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};

use super::shard;
use super::table::{INCOMPLETE_LINE, SHARD_LINE};
use crate::cli::Failure;

/// First line of each file.
const FIRST_LINE: &str = "# impactscope ";
/// Line with the number of points.
const POINTS_LINE: &str = "# points: ";

/// One shard as read.
struct Shard {
    path: PathBuf,
    /// Header without what belongs to the shard, and columns.
    head: Vec<String>,
    part: usize,
    parts: usize,
    points: usize,
    rows: Vec<String>,
}

/// The whole table.
///
/// # Errors
/// Files that are no shards, shards of different sweeps, missing or contradicting ones.
pub fn merged(paths: &[PathBuf]) -> Result<String, Failure> {
    let mut all: BTreeMap<usize, Shard> = BTreeMap::new();
    for path in paths {
        let own = Shard::read(path)?;
        if let Some(first) = all.values().next() {
            first.check_kin(&own)?;
        }
        // The same shard twice counts once.
        match all.get(&own.part) {
            Some(other) => other.check_same(&own)?,
            None => {
                all.insert(own.part, own);
            }
        }
    }
    let Some(first) = all.values().next() else {
        return Err(anyhow!("--merge names no file").into());
    };
    let missing: Vec<String> = (1..=first.parts)
        .filter(|part| !all.contains_key(part))
        .map(|part| format!("{part}/{}", first.parts))
        .collect();
    if !missing.is_empty() {
        let failure = anyhow!(
            "shards {} are missing; compute them with --shard, or name their files",
            missing.join(", ")
        );
        return Err(failure.into());
    }
    let mut text = String::new();
    let mut line = |own: &str| {
        text += own;
        text.push('\n');
    };
    first.head.iter().for_each(|own| line(own));
    for index in 0..first.points {
        let row = all.get(&(index % first.parts + 1));
        if let Some(row) = row.and_then(|own| own.rows.get(index / first.parts)) {
            line(row);
        }
    }
    Ok(text)
}

impl Shard {
    fn read(path: &Path) -> anyhow::Result<Self> {
        let name = || path.display().to_string();
        let text = std::fs::read_to_string(path).with_context(name)?;
        if !text.starts_with(FIRST_LINE) {
            bail!("{}: this is no table of impactscope sweep", name());
        }
        if !text.ends_with('\n') {
            bail!("{}: its last line is cut off; compute it again", name());
        }
        let (mut part, mut points, mut head) = (None, None, Vec::new());
        let mut lines = text.lines();
        for own in lines.by_ref() {
            if let Some(parts) = own.strip_prefix(SHARD_LINE) {
                part = Some(shard::parse(parts).with_context(name)?);
                continue;
            }
            if own.starts_with(INCOMPLETE_LINE) {
                bail!(
                    "{}: it was cancelled before its end; compute it again",
                    name()
                );
            }
            points = points.or_else(|| own.strip_prefix(POINTS_LINE)?.parse::<usize>().ok());
            head.push(own.to_owned());
            if !own.starts_with('#') {
                break;
            }
        }
        let points =
            points.ok_or_else(|| anyhow!("{}: it has no line \"{POINTS_LINE}\"", name()))?;
        let (part, parts) = part.unwrap_or((1, 1));
        let own = Self {
            path: path.to_owned(),
            head,
            part,
            parts,
            points,
            rows: lines.map(str::to_owned).collect(),
        };
        own.check_rows()?;
        Ok(own)
    }

    /// Each row has the number that it must have.
    fn check_rows(&self) -> anyhow::Result<()> {
        let name = self.path.display();
        let expected = (self.part - 1..self.points).step_by(self.parts);
        let count = expected.clone().count();
        if self.rows.len() != count {
            bail!(
                "{name}: it has {} rows, shard {}/{} of {} points has {count}; compute it again",
                self.rows.len(),
                self.part,
                self.parts,
                self.points
            );
        }
        for (index, row) in expected.zip(&self.rows) {
            let number = row
                .split(',')
                .next()
                .and_then(|cell| cell.parse::<usize>().ok());
            if number != Some(index) {
                bail!(
                    "{name}: a row begins with {:?} where point {index} must stand; compute it again",
                    row.split(',').next().unwrap_or("")
                );
            }
        }
        Ok(())
    }

    /// Both belong to one sweep.
    fn check_kin(&self, other: &Self) -> anyhow::Result<()> {
        let (a, b) = (self.path.display(), other.path.display());
        if self.parts != other.parts {
            bail!(
                "{a} is one of {} shards, {b} one of {}; take shards of one sweep",
                self.parts,
                other.parts
            );
        }
        let longer = self.head.len().max(other.head.len());
        let line = |head: &[String], k: usize| head.get(k).cloned().unwrap_or_default();
        for k in 0..longer {
            let (own, others) = (line(&self.head, k), line(&other.head, k));
            if own != others {
                bail!("{a} and {b} are of different sweeps: \"{own}\" against \"{others}\"");
            }
        }
        Ok(())
    }

    /// A shard that is given twice has the same rows.
    fn check_same(&self, other: &Self) -> anyhow::Result<()> {
        let differs = self.rows.iter().zip(&other.rows).position(|(a, b)| a != b);
        if let Some(row) = differs {
            bail!(
                "{} and {} are both shard {}/{}, and contradict one another: \"{}\" against \"{}\"; compute it again",
                self.path.display(),
                other.path.display(),
                self.part,
                self.parts,
                self.rows[row],
                other.rows[row]
            );
        }
        Ok(())
    }
}
