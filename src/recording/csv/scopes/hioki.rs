//! Hioki Memory HiCorder and HiLogger (MR8880, LR8400, LR8431, LR8450; appendix "Text file (CSV) internal
//! format" of their manuals): `"File name","WAVE0001.CSV","V 1.00"`, `"Title comment"`, `"Trigger Time"`, the
//! settings of the channels, then `"Time","CH1[V]","CH2[V]"` and rows with times in seconds. The settings
//! are one line a property (`"CH"`, `"Mode"`, `"Range"`, `"Comment"`, ...) or one line a channel below
//! `"Ch","Mode","Range","Comment"`. A comment is the name that a person gave to the channel. Readings have
//! their scaling in them already; the unit in the last header line is that of the scaled reading.

use super::{Head, ScopeHeader};

pub(super) fn read(head: &Head) -> Option<ScopeHeader> {
    let first = head.cells(0);
    let is_file = first.first()?.trim().eq_ignore_ascii_case("File name");
    let is_hioki = first
        .iter()
        .any(|cell| cell.to_uppercase().contains("HIOKI"));
    if !is_file && !is_hioki {
        return None;
    }
    let (line, names) = head.named("Time").or_else(|| timed(head))?;
    let comments = comments(head, line);
    let cells: Vec<String> = names
        .iter()
        .enumerate()
        .map(|(i, cell)| match (i, split_unit(cell)) {
            (0, None) => "Time [s]".to_owned(),
            (0, Some((name, unit))) => format!("{name} [{unit}]"),
            (_, Some((channel, unit))) => {
                format!(
                    "{} [{unit}]",
                    comment_of(&comments, channel).unwrap_or(channel)
                )
            }
            (_, None) => cell.clone(),
        })
        .collect();
    let filled = cells.iter().rposition(|cell| !cell.trim().is_empty())? + 1;
    let cells = cells.into_iter().take(filled).collect();
    Some(ScopeHeader::new("Hioki", cells, line))
}

/// `Time[s]` or `Time[ms]`.
fn timed(head: &Head) -> Option<(usize, Vec<String>)> {
    let units = ["s", "ms", "us"];
    units
        .iter()
        .find_map(|unit| head.named(&format!("Time[{unit}]")))
}

/// `CH1[V]` in two.
fn split_unit(cell: &str) -> Option<(&str, &str)> {
    let (name, rest) = cell.trim().split_once('[')?;
    Some((name.trim(), rest.strip_suffix(']')?.trim()))
}

/// Channels with the names that a person gave them.
fn comments(head: &Head, below: usize) -> Vec<(String, String)> {
    let lines: Vec<Vec<String>> = (1..below).map(|i| head.cells(i)).collect();
    let starts = |name: &str| {
        let is = |cells: &&Vec<String>| cells.first().is_some_and(|c| c.trim() == name);
        lines.iter().find(is)
    };
    let mut found: Vec<(String, String)> = Vec::new();
    if let (Some(channels), Some(comments)) = (starts("CH"), starts("Comment")) {
        let pairs = channels.iter().zip(comments).skip(1);
        found.extend(pairs.map(|(channel, comment)| (channel.clone(), comment.clone())));
    }
    if let Some(title) = starts("Ch")
        && let Some(at) = title.iter().position(|c| c.trim() == "Comment")
    {
        for cells in &lines {
            if let (Some(channel), Some(comment)) = (cells.first(), cells.get(at)) {
                found.push((channel.clone(), comment.clone()));
            }
        }
    }
    found.retain(|(_, comment)| !comment.trim().is_empty());
    found
}

/// The comment of a channel, whose name may be written with other spaces and dashes: `A 1- 1`, `1-1`.
fn comment_of<'c>(comments: &'c [(String, String)], channel: &str) -> Option<&'c str> {
    let plain = |text: &str| -> String { text.chars().filter(|c| !c.is_whitespace()).collect() };
    let mut own = comments.iter();
    let found = own.find(|(name, _)| plain(name) == plain(channel));
    found.map(|(_, comment)| comment.trim())
}
