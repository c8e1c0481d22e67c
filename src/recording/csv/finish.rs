//! From rows in the order of time to a recording: scales, times, the rules for time and gaps, integrals.

use super::line;
use super::read::{Rows, Source};
use super::rows::Table;
use super::rows::layout::{Layout, TIME_SLOT};
use super::settings::{Quantity, TimeZero};
use crate::model::unit::{counted, format_quantity};
use crate::recording::assemble::{Columns, FileClock, Place, assemble};
use crate::recording::csv::integrate::drift::remove_drift;
use crate::recording::csv::integrate::integrate;
use crate::recording::error::{ImportError, ImportWarning, WarningKind};
use crate::recording::times::exact_time::ExactTime;
use crate::recording::times::{even_times, time_samples};
use crate::recording::{Channel, Recording};

impl Source<'_> {
    /// The recording of the rows.
    pub(super) fn recording(
        &self,
        mut rows: Rows,
        layout: &Layout,
        mut warnings: Vec<ImportWarning>,
    ) -> Result<Recording, ImportError> {
        let settings = self.settings;
        let [time, voltage, proof_mass, cantilever] = std::mem::take(&mut rows.columns);
        let kind_of = |channel: Channel| {
            let choice = settings.choice(channel);
            choice.map_or(Quantity::Displacement, |choice| choice.kind)
        };
        let is_motion = kind_of(Channel::ProofMass) == Quantity::Displacement;
        let scaled = |channel: Channel, slot: usize, column: Option<Vec<f64>>| {
            let (scale, offset) = settings.scaling(channel);
            let scale = scale * layout.slots[slot].factor;
            // An offset is a displacement's.
            let offset = if kind_of(channel) == Quantity::Displacement {
                offset
            } else {
                0.0
            };
            column.map(|mut values| {
                if scale != 1.0 || offset != 0.0 {
                    values.iter_mut().for_each(|v| {
                        let scaled = *v * scale + offset;
                        // What leaves the range of numbers is missing, as it would be in the file.
                        *v = if scaled.is_finite() { scaled } else { f64::NAN };
                    });
                }
                values
            })
        };
        let (time, origin) = self.times(time, &rows, layout, proof_mass.as_deref());
        self.say_overrange(&rows.table, &mut warnings);
        let columns = Columns {
            time,
            voltage: scaled(Channel::Voltage, 1, voltage),
            proof_mass: scaled(Channel::ProofMass, 2, proof_mass).unwrap_or_default(),
            cantilever: scaled(Channel::Cantilever, 3, cantilever),
            is_displacement: is_motion,
        };
        let clock = FileClock {
            origin,
            keeps_zero: settings.time_zero == TimeZero::File,
            printed: rows.table.printed,
            as_written: settings.times_as_written || settings.time.is_none(),
            offset: settings.time_offset,
            accept_losses: settings.accept_losses,
        };
        let place = self.place(&rows, layout);
        let place = Place {
            file: self.file,
            line_of: &place.line_of,
            column_of: &place.column_of,
            cell_of: &place.cell_of,
            columns_at: &place.columns_at,
        };
        let mut recording = assemble(columns, clock, &place, warnings)?;
        self.integrate(&mut recording, kind_of);
        Ok(recording)
    }

    /// Times \[s\] and the instant in the file of their zero.
    fn times(
        &self,
        time: Option<Vec<f64>>,
        rows: &Rows,
        layout: &Layout,
        proof_mass: Option<&[f64]>,
    ) -> (Vec<f64>, ExactTime) {
        let clock = self.settings.clock;
        let start = clock.map_or(0.0, |clock| clock.start);
        let keeps_zero = self.settings.time_zero == TimeZero::File;
        let begin = if keeps_zero { start } else { 0.0 };
        let Some(mut time) = time else {
            let interval = clock.map_or(1.0, |clock| clock.interval);
            let count = proof_mass.map_or(rows.table.rows - rows.text_rows, <[f64]>::len);
            let times = even_times(interval, count);
            let times = times.into_iter().map(|t| begin + t).collect();
            let origin = if keeps_zero { 0.0 } else { start };
            return (times, ExactTime::from_seconds(origin));
        };
        let factor = layout.slots[TIME_SLOT].factor;
        let mut origin = layout.seconds(rows.zero.clone());
        let unit = self.settings.time.as_ref().map(|t| t.unit.as_str());
        if unit == Some("sample") {
            time_samples(factor, &mut time);
            time.iter_mut().for_each(|t| *t += begin);
        } else if factor != 1.0 || begin != 0.0 {
            time.iter_mut().for_each(|t| *t = *t * factor + begin);
        }
        if !keeps_zero && start != 0.0 {
            origin = origin.plus(&ExactTime::from_seconds(start));
        }
        (time, origin)
    }

    fn say_overrange(&self, table: &Table, warnings: &mut Vec<ImportWarning>) {
        let symbols = ["t", "V", "xp", "xc"];
        for (symbol, count) in symbols.iter().zip(table.overrange) {
            if count > 0 {
                let cells = counted(count, "reading");
                let message = format!(
                    "{cells} of {symbol} were out of the instrument's range and are missing"
                );
                let kind = WarningKind::Overrange;
                warnings.push(ImportWarning::new(kind, count, None, &message));
            }
        }
    }

    /// Integrates what is a velocity or an acceleration, and says by how much it drifts.
    fn integrate(&self, recording: &mut Recording, kind_of: impl Fn(Channel) -> Quantity) {
        for channel in [Channel::ProofMass, Channel::Cantilever] {
            let kind = kind_of(channel);
            let times = match kind {
                Quantity::Displacement => continue,
                Quantity::Velocity => 1,
                Quantity::Acceleration => 2,
            };
            let Some(values) = recording.channel(channel) else {
                continue;
            };
            let mut values = values.to_vec();
            let (mut net, mut mean, mut bridged) = (0.0, 0.0, 0);
            let mut removed = Vec::new();
            for turn in 0..times {
                let integral = integrate(&recording.time, &values);
                values = integral.values;
                net = integral.net;
                bridged = integral.bridged;
                if turn == 0 {
                    mean = integral.mean;
                }
                let unit = if turn + 1 < times { "m/s" } else { "m" };
                let drift = self.settings.drift;
                let what = remove_drift(drift, &recording.time, &mut values, unit);
                if !removed.contains(&what) {
                    removed.push(what);
                }
            }
            let removed = removed.join("; of its integral ");
            let offset = self.settings.scaling(channel).1;
            values.iter_mut().for_each(|x| *x += offset);
            let bridges = match bridged {
                0 => String::new(),
                n => format!("; {} bridged by straight lines", counted(n, "gap")),
            };
            let message = format!(
                "{} is the integral of a {} (trapezoid, 0 at the first row): its level is not known, and it moves by {} from the first to the last row (the mean {} is {}); {removed}{bridges}",
                channel.symbol(),
                kind.label(),
                format_quantity(net, "m", 3),
                kind.label(),
                format_quantity(mean, kind.base_unit(), 3),
            );
            let warning = ImportWarning::new(WarningKind::Integrated, 1, None, &message);
            recording.warnings.push(warning);
            match channel {
                Channel::Cantilever => recording.cantilever = Some(values),
                _ => recording.proof_mass = values,
            }
        }
    }

    /// Where rows stand in the file.
    fn place<'s>(&'s self, rows: &'s Rows, layout: &'s Layout) -> Places<'s> {
        let row_of = move |row: usize| match &rows.order {
            Some(order) => order.get(row).copied().unwrap_or(row),
            None => row,
        };
        let column_of = move |channel: Option<Channel>| match channel {
            None => self.settings.time.as_ref().map_or(0, |c| c.index),
            Some(channel) => self.settings.choice(channel).map_or(0, |c| c.index),
        };
        let (table, text) = (&rows.table, self.text);
        let start = self.part.range.start;
        Places {
            line_of: Box::new(move |row| table.line_of(text, layout, row_of(row))),
            column_of: Box::new(move |channel| column_of(channel).saturating_add(1)),
            cell_of: Box::new(move |row, channel| {
                table.cell_of(text, layout, row_of(row), column_of(channel))
            }),
            columns_at: Box::new(move |row| {
                let before = text.split(&text.bytes[..start]);
                let named = before.map(|l| line::cells(l, layout.delimiter).count());
                let cells = table.cells_of(text, layout, row_of(row));
                named.max().unwrap_or(0).max(cells)
            }),
        }
    }
}

/// Functions of a [`Place`].
struct Places<'a> {
    line_of: Box<dyn Fn(usize) -> usize + 'a>,
    column_of: Box<dyn Fn(Option<Channel>) -> usize + 'a>,
    cell_of: Box<dyn Fn(usize, Option<Channel>) -> String + 'a>,
    columns_at: Box<dyn Fn(usize) -> usize + 'a>,
}
