//! A fault as a sentence for people. It begins with a small letter or the channel's symbol and has
//! no full stop.

use super::fault::{FaultKind, InstrumentFault};
use crate::model::unit::{counted, format_number, format_quantity};

/// Places that a sentence lists.
const PLACES_IN_A_SENTENCE: usize = 3;

impl InstrumentFault {
    /// What it is, for a list: "7 spikes in xp".
    #[must_use]
    pub fn label(&self) -> String {
        let channel = self.channel.symbol();
        match self.kind {
            FaultKind::MissingReadings => {
                format!("{} in {channel}", counted(self.samples, "missing reading"))
            }
            FaultKind::Clipping => {
                format!(
                    "{} at the end of the range of {channel}",
                    counted(self.samples, "reading")
                )
            }
            FaultKind::HeldReadings => {
                format!("{} in {channel}", counted(self.samples, "repeated reading"))
            }
            FaultKind::Spikes => format!("{} in {channel}", counted(self.count, "spike")),
            FaultKind::FringeJumps => {
                format!("{} in {channel}", counted(self.count, "fringe jump"))
            }
            FaultKind::SteadyLine { frequency } => {
                format!("{channel} hums at {}", format_quantity(frequency, "Hz", 3))
            }
            FaultKind::AcCoupling => format!("{channel} is AC coupled"),
            FaultKind::Quantised => {
                format!(
                    "{channel} in steps of {}",
                    format_quantity(self.size, self.unit(), 3)
                )
            }
        }
    }

    /// What it is, how large, where, and what is done about it or can be.
    #[must_use]
    pub fn sentence(&self) -> String {
        let size = || format_quantity(self.size, self.unit(), 3);
        let share = || {
            format!(
                "{} % of the samples",
                format_number(100.0 * self.share(), 2)
            )
        };
        let where_they_are = self.where_it_is();
        let label = self.label();
        match self.kind {
            FaultKind::MissingReadings => format!(
                "{label} ({}), the longest gap of {} samples, {where_they_are}: there the recording says nothing",
                share(),
                format_number(self.size, 6)
            ),
            FaultKind::Clipping => {
                format!(
                    "{label} ({size}), {where_they_are}: they are not used; record with a larger range",
                    size = size()
                )
            }
            FaultKind::HeldReadings => format!(
                "{label} ({}) while the motion goes on, up to {} in a row, {where_they_are}: they are not used",
                share(),
                format_number(self.size, 6)
            ),
            FaultKind::Spikes => {
                format!(
                    "{label} of up to {}, {where_they_are}: they are not used",
                    size()
                )
            }
            FaultKind::FringeJumps => format!(
                "{label} by multiples of {}, {where_they_are}: the reading is shifted from there on; record anew, or take the jumps out of the file",
                size()
            ),
            FaultKind::SteadyLine { .. } => format!(
                "{label} by {}, also while the ground holds the mass: the instrument does, not the device{}",
                size(),
                self.mains()
                    .map_or_else(String::new, |mains| format!(" (the mains, {mains})"))
            ),
            FaultKind::AcCoupling => format!(
                "{label}: it decays to zero with a time constant of {} wherever the mass rests; switch the instrument to DC, or record faster than that",
                size()
            ),
            FaultKind::Quantised => format!(
                "{label}, coarser than its noise: its error is taken as {} at least",
                format_quantity(self.size / 12f64.sqrt(), self.unit(), 2)
            ),
        }
    }

    /// Its first places: "at 1.2 ms, 3 to 4 ms and 5 more".
    fn where_it_is(&self) -> String {
        let time = |t: f64| format_quantity(t, "s", 5);
        let listed: Vec<String> = self
            .places
            .iter()
            .take(PLACES_IN_A_SENTENCE)
            .map(|&(from, to)| {
                if from == to || self.kind == FaultKind::FringeJumps {
                    time(from)
                } else {
                    format!("{} to {}", time(from), time(to))
                }
            })
            .collect();
        let more = self.count - listed.len().min(self.count);
        let rest = if more > 0 {
            format!(" and at {more} more places")
        } else {
            String::new()
        };
        format!("at {}{rest}", listed.join(", "))
    }

    /// Which of the mains' harmonics the line is, within the resolution of the recording.
    fn mains(&self) -> Option<&'static str> {
        let FaultKind::SteadyLine { frequency } = self.kind else {
            return None;
        };
        let (from, to) = self.places.first()?;
        let resolution = 1.0 / (to - from);
        // The two frequencies of the world's mains.
        [(50.0, "50 Hz"), (60.0, "60 Hz")]
            .into_iter()
            .find_map(|(mains, text): (f64, _)| {
                let times = (frequency / mains).round();
                // Where one could lie as well anywhere between two harmonics, nothing is said.
                let near = (frequency - times * mains).abs() <= 0.5 * resolution;
                (times >= 1.0 && near && resolution < 0.2 * mains).then_some(text)
            })
    }
}
