//! Text exports of oscilloscopes and recorders whose header says what the plain form says in its
//! names: one file a maker.

mod digilent;
mod hioki;
mod keysight;
mod lecroy;
mod picoscope;
mod red_pitaya;
mod rigol;
mod rohde_schwarz;
mod siglent;
mod tektronix;
mod tracker;

use super::line::show_row;
use super::settings::SampleClock;

/// Lines of the head that are looked at.
const MAX_HEAD_LINES: usize = 200;

/// The beginning of a file.
pub(super) struct Head<'a> {
    /// Lines without their ends.
    pub lines: &'a [&'a [u8]],
}

impl Head<'_> {
    /// The cells of a line, separated by commas.
    fn cells(&self, line: usize) -> Vec<String> {
        let line = self.lines.get(line).copied().unwrap_or_default();
        show_row(line, b',')
    }

    /// The first of the lines whose first cell is `name`, with its cells.
    fn named(&self, name: &str) -> Option<(usize, Vec<String>)> {
        let head = self.lines.iter().take(MAX_HEAD_LINES);
        let starts = |line: &[u8]| {
            let cell = line.trim_ascii_start();
            let cell = cell.strip_prefix(b"\"").unwrap_or(cell);
            cell.get(..name.len())
                .is_some_and(|own| own.eq_ignore_ascii_case(name.as_bytes()))
        };
        head.enumerate()
            .filter(|(_, line)| starts(line))
            .map(|(i, _)| (i, self.cells(i)))
            .find(|(_, cells)| {
                let first = cells.first().map(|c| c.trim_end_matches(':'));
                first.is_some_and(|c| c.eq_ignore_ascii_case(name))
            })
    }

    /// The cells after `name` in its line.
    fn values(&self, name: &str) -> Option<Vec<String>> {
        let (_, mut cells) = self.named(name)?;
        cells.remove(0);
        Some(cells)
    }

    /// The first number after `name`.
    fn number(&self, name: &str) -> Option<f64> {
        let values = self.values(name)?;
        number(values.first()?)
    }
}

/// A number in a cell.
fn number(cell: &str) -> Option<f64> {
    let value: f64 = cell.trim().parse().ok()?;
    value.is_finite().then_some(value)
}

/// What a maker's header says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ScopeHeader {
    /// What wrote the file.
    pub maker: &'static str,
    /// Names of the columns with their units.
    pub cells: Vec<String>,
    /// Index of the header's last line; rows start below.
    pub last_line: usize,
    /// Sampling clock, where times are not written out.
    pub clock: Option<SampleClock>,
    /// Whether times and lengths without a unit are SI.
    pub is_si: bool,
}

impl ScopeHeader {
    fn new(maker: &'static str, cells: Vec<String>, last_line: usize) -> Self {
        Self {
            maker,
            cells,
            last_line,
            clock: None,
            is_si: false,
        }
    }
}

/// The readers, one a maker.
const MAKERS: [fn(&Head) -> Option<ScopeHeader>; 11] = [
    digilent::read,
    hioki::read,
    picoscope::read,
    red_pitaya::read,
    keysight::read,
    rigol::read,
    siglent::read,
    lecroy::read,
    rohde_schwarz::read,
    tektronix::read,
    tracker::read,
];

/// What the header of a known maker says; `None` for any other file.
pub(super) fn recognise(head: &Head) -> Option<ScopeHeader> {
    MAKERS.iter().find_map(|read| read(head))
}

/// Names with units, by position.
fn with_units(names: &[String], units: &[String]) -> Vec<String> {
    let mut cells: Vec<String> = names
        .iter()
        .enumerate()
        .map(|(i, name)| match units.get(i).map(|u| u.trim()) {
            Some("") | None => name.clone(),
            Some(unit) => format!("{} [{unit}]", name.trim()),
        })
        .collect();
    while cells.last().is_some_and(|c| c.trim().is_empty()) {
        cells.pop();
    }
    cells
}
