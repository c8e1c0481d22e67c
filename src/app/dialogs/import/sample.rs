//! The beginning of a file, to preview it with other settings than the guessed ones.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use eframe::egui::Context;

pub use crate::recording::csv::ShownRows as Cells;
use crate::recording::csv::{Decimal, ImportSettings, shown_rows};

/// Bytes read for the preview.
const SAMPLE_BYTES: u64 = 256 << 10;

/// The first bytes of a file, read in a thread of their own.
#[derive(Debug)]
pub struct Sample {
    coming: Option<Receiver<Vec<u8>>>,
    bytes: Vec<u8>,
}

impl Sample {
    /// Starts reading; asks for a repaint when done.
    pub fn read(path: PathBuf, context: &Context) -> Self {
        let (send, coming) = channel();
        let context = context.clone();
        let started = std::thread::Builder::new()
            .name("sample".to_owned())
            .spawn(move || {
                // The dialog may be closed meanwhile.
                let _ = send.send(head(&path).unwrap_or_default());
                context.request_repaint();
            });
        Self {
            coming: started.is_ok().then_some(coming),
            bytes: Vec::new(),
        }
    }

    /// The first rows as `settings` split them; `None` while the file is being read.
    pub fn split(&mut self, settings: &ImportSettings) -> Option<Cells> {
        if let Some(coming) = &self.coming {
            match coming.try_recv() {
                Ok(bytes) => self.bytes = bytes,
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => {}
            }
            self.coming = None;
        }
        Some(shown_rows(&self.bytes, settings))
    }
}

fn head(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?
        .take(SAMPLE_BYTES)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Whether a cell is a number; others are marked.
pub fn is_number(cell: &str, decimal: Decimal) -> bool {
    let cell = cell.trim().trim_matches('"');
    match decimal {
        Decimal::Point => cell.parse::<f64>().is_ok(),
        Decimal::Comma => cell.replacen(',', ".", 1).parse::<f64>().is_ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::*;

    #[test]
    fn numbers_follow_the_decimal_sign() {
        assert!(is_number("1,5", Decimal::Comma) && !is_number("1,5", Decimal::Point));
        assert!(is_number("1.5e-3", Decimal::Point) && is_number("-2", Decimal::Comma));
        assert!(!is_number("", Decimal::Point) && !is_number("x", Decimal::Comma));
    }
}
