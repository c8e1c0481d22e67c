//! The example that comes with the program: made-up recordings of a device that is not
//! quite the paper's, and what had been put into it.

use std::sync::Arc;

use super::draw::Recordings;
use super::truth::Truth;
use crate::recording::csv::import_bytes_auto;
use crate::recording::{ImportError, Recording};

/// A file that comes with the program: name and text.
type File = (&'static str, &'static str);

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$((
            $name,
            include_str!(concat!("../../assets/demo/", $name, ".csv")),
        )),*]
    };
}

const TRAIN: &[File] = files!["train-1", "train-2", "train-3", "train-4", "train-5"];
const HELD_OUT: &[File] = files!["held-out-1", "held-out-2", "held-out-3", "held-out-4"];
const TRUTH: &str = include_str!("../../assets/demo/truth.json");

/// The recordings.
///
/// # Errors
/// [`ImportError`] if one of them cannot be read.
pub fn recordings() -> Result<Recordings, ImportError> {
    Ok(Recordings {
        train: TRAIN.iter().map(read).collect::<Result<_, _>>()?,
        held_out: HELD_OUT.iter().map(read).collect::<Result<_, _>>()?,
    })
}

/// The recording of that name, if there is one.
pub fn recording(name: &str) -> Option<Arc<Recording>> {
    let all = TRAIN.iter().chain(HELD_OUT);
    let file = all.into_iter().find(|(known, _)| *known == name)?;
    read(file).ok()
}

fn read((name, text): &File) -> Result<Arc<Recording>, ImportError> {
    let mut recording = import_bytes_auto(name, text.as_bytes())?;
    recording.name = (*name).to_owned();
    Ok(Arc::new(recording))
}

/// What had been put in, in a few words.
///
/// # Errors
/// That of `serde_json` if the file that tells it cannot be read.
pub fn put_in() -> Result<String, serde_json::Error> {
    let truth: Truth = serde_json::from_str(TRUTH)?;
    let effects: Vec<String> = truth
        .effects
        .iter()
        .map(|e| {
            let size = e
                .size_nn
                .map_or_else(String::new, |nn| format!(", about {nn:.1} nN"));
            format!("{} ({}{size})", e.id, e.formulation)
        })
        .collect();
    Ok(effects.join(" and "))
}

#[cfg(test)]
mod tests {
    use super::super::demo::*;

    #[test]
    fn the_recordings_can_be_read() {
        let Recordings { train, held_out } = recordings().unwrap();
        assert_eq!((train.len(), held_out.len()), (5, 4));
        for recording in train.iter().chain(&held_out) {
            assert!(recording.warnings.is_empty(), "{}", recording.name);
            assert!(recording.cantilever.is_some());
            assert!((recording.sampling_rate() - 25e3).abs() < 1.0);
        }
        let bytes: usize = TRAIN.iter().chain(HELD_OUT).map(|f| f.1.len()).sum();
        assert!(bytes < 1_500_000, "{bytes}");
        assert!(put_in().unwrap().contains("quadratic_drag"));
        assert!(recording("train-3").is_some() && recording("train-9").is_none());
    }
}
