//! Parts of a sweep.

use anyhow::anyhow;

/// `I/N` with I from 1 to N.
pub fn parse(text: &str) -> anyhow::Result<(usize, usize)> {
    let parts = text.split_once('/');
    let numbers = parts.and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
    match numbers {
        Some((i, n)) if i >= 1 && i <= n => Ok((i, n)),
        _ => Err(anyhow!(
            "--shard {text}: write I/N with I from 1 to N, for example 3/8"
        )),
    }
}
