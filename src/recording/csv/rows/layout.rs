//! Which columns are read, and as what.

use std::collections::BTreeMap;

use crate::recording::csv::columns::units::{
    TimeUnit, example_scale, kind_of, sensitivity, time_unit, unit_shift,
};
use crate::recording::csv::number::kinds::OVERRANGE;
use crate::recording::csv::number::marks::Marks;
use crate::recording::csv::number::{calendar, relative_time};
use crate::recording::csv::settings::{ColumnChoice, Decimal, ImportSettings};
use crate::recording::error::ImportError;
use crate::recording::times::exact_time::ExactTime;

/// Slot of the time column.
pub(in crate::recording::csv) const TIME_SLOT: usize = 0;

/// How the numbers of a slot are read.
#[derive(Debug, Clone, Copy)]
pub(in crate::recording::csv) struct Slot {
    /// Power of ten of the unit.
    pub shift: i32,
    /// A further factor, applied after the reading.
    pub factor: f64,
    /// Readings of this size were out of range: from the first to the second.
    pub overrange: (f64, f64),
    /// The marks of the column.
    pub marks: Marks,
}

/// The columns to read. Slots are t, V, xp, xc.
#[derive(Debug, Clone)]
pub(in crate::recording::csv) struct Layout {
    pub delimiter: u8,
    /// Whether an unquoted number may have a decimal comma.
    pub comma: bool,
    /// The columns needed, in their order, with their slots.
    pub columns: Vec<(usize, Vec<usize>)>,
    pub slots: [Slot; 4],
    pub present: [bool; 4],
    /// The time column; `None` if samples are counted.
    pub time: Option<usize>,
    /// Whether times are clock times, and the column of their dates.
    pub is_clock: bool,
    pub date: Option<usize>,
    /// Whether all numbers are plain, so that they are read in one pass over the bytes.
    pub is_plain: bool,
}

impl Layout {
    /// # Errors
    /// A column that is required is not chosen; a unit that is none of the quantity.
    pub(in crate::recording::csv) fn new(
        file: &str,
        settings: &ImportSettings,
    ) -> Result<Self, ImportError> {
        let line = settings.skip_lines.max(1);
        let found = || "the chosen columns".to_owned();
        if settings.time.is_none() && settings.clock.is_none() {
            return Err(ImportError::NoTimeColumn {
                file: file.into(),
                line,
                found: found().into(),
            });
        }
        if settings.proof_mass.is_none() {
            return Err(ImportError::NoPositionColumn {
                file: file.into(),
                line,
                found: found().into(),
            });
        }
        let chosen = [
            settings.time.as_ref(),
            settings.voltage.as_ref(),
            settings.proof_mass.as_ref(),
            settings.cantilever.as_ref(),
        ];
        let mut columns: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut slots = [Slot {
            shift: 0,
            factor: 1.0,
            overrange: (OVERRANGE.start, OVERRANGE.end),
            marks: Marks::PLAIN,
        }; 4];
        let mut is_clock = false;
        for (slot, choice) in chosen.into_iter().enumerate() {
            let Some(choice) = choice else { continue };
            let own = if slot == TIME_SLOT {
                let unit = Self::time_of(file, line, choice, settings)?;
                is_clock = unit.is_clock;
                (unit.factor, unit.shift)
            } else {
                Self::reading_of(file, line, slot, choice)?
            };
            columns.entry(choice.index).or_default().push(slot);
            if let Some(reading) = slots.get_mut(slot) {
                (reading.factor, reading.shift) = own;
                let unit = 10f64.powi(own.1);
                reading.overrange = (OVERRANGE.start * unit, OVERRANGE.end * unit);
            }
        }
        let delimiter = settings.delimiter.byte();
        let comma = settings.decimal == Decimal::Comma && delimiter != b',';
        Ok(Self {
            delimiter,
            comma,
            columns: columns.into_iter().collect(),
            slots,
            present: chosen.map(|choice| choice.is_some()),
            time: settings.time.as_ref().map(|choice| choice.index),
            is_clock,
            date: settings.date_column.filter(|_| is_clock),
            is_plain: !is_clock,
        })
    }

    fn time_of(
        file: &str,
        line: usize,
        choice: &ColumnChoice,
        settings: &ImportSettings,
    ) -> Result<TimeUnit, ImportError> {
        let interval = settings.clock.map(|clock| clock.interval);
        time_unit(&choice.unit, interval).ok_or_else(|| {
            if choice.unit == "sample" {
                return ImportError::Undecided {
                    file: file.into(),
                    line,
                    question: format!(
                        "column {} counts samples, and the file does not say how far they are apart",
                        choice.index.saturating_add(1)
                    )
                    .into(),
                    options: "--rate 50kHz or --dt 20us".into(),
                };
            }
            ImportError::UnknownUnit {
                file: file.into(),
                line,
                column: choice.index.saturating_add(1),
                unit: choice.unit.clone().into(),
                quantity: "time".to_owned(),
                expected: "s, ms or us".to_owned(),
            }
        })
    }

    /// Factor and power of ten of a channel.
    fn reading_of(
        file: &str,
        line: usize,
        slot: usize,
        choice: &ColumnChoice,
    ) -> Result<(f64, i32), ImportError> {
        let (base, quantity, symbol) = match slot {
            1 => ("V", "voltage", "V"),
            2 => (choice.kind.base_unit(), choice.kind.label(), "xp"),
            _ => (choice.kind.base_unit(), choice.kind.label(), "xc"),
        };
        let expected = match base {
            "V" => "V or mV",
            "m" => "m, mm, um or nm",
            "m/s" => "m/s or mm/s",
            _ => "m/s^2 or mm/s^2",
        };
        let column = choice.index.saturating_add(1);
        if let Some(scale) = &choice.scale {
            return sensitivity(scale, &choice.unit, base).ok_or_else(|| ImportError::BadScale {
                file: file.into(),
                column,
                scale: scale.clone().into(),
                unit: choice.unit.clone().into(),
                symbol,
                base,
            });
        }
        if let Some(shift) = unit_shift(&choice.unit, base) {
            return Ok((1.0, shift));
        }
        if kind_of(&choice.unit).is_some_and(|k| k.takes_scale()) {
            return Err(ImportError::NeedsScale {
                file: file.into(),
                line,
                column,
                unit: choice.unit.clone().into(),
                symbol: symbol.to_owned(),
                example: example_scale(base, &choice.unit).into(),
            });
        }
        Err(ImportError::UnknownUnit {
            file: file.into(),
            line,
            column,
            unit: choice.unit.clone().into(),
            quantity: quantity.to_owned(),
            expected: expected.to_owned(),
        })
    }

    /// The time in the cells of a row as decimal text, in the file's unit.
    pub(in crate::recording::csv) fn time_text(&self, time: &[u8], date: &[u8]) -> Option<Vec<u8>> {
        if !self.is_clock {
            return relative_time::plain_text(time, self.slots[TIME_SLOT].marks);
        }
        let text = |cell: &[u8]| String::from_utf8_lossy(cell.trim_ascii()).replace('"', "");
        let whole = if self.date.is_some() {
            format!("{} {}", text(date).trim(), text(time).trim())
        } else {
            text(time)
        };
        calendar::seconds(&whole).map(String::into_bytes)
    }

    /// `exact` in the file's unit of time as seconds.
    pub(in crate::recording::csv) fn seconds(&self, exact: ExactTime) -> ExactTime {
        let Slot { shift, factor, .. } = self.slots[TIME_SLOT];
        let exact = exact.shifted(shift);
        if factor == 1.0 {
            exact
        } else {
            ExactTime::from_seconds(exact.seconds() * factor)
        }
    }
}
