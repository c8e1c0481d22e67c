//! How arrays become tables.

use crate::recording::formats::arrays::{Arrays, NamedArray};
use crate::recording::formats::error::FileContext;
use crate::recording::formats::raw_table::SampleClock;

const CONTEXT: FileContext = FileContext {
    file: "a.x",
    format: "X",
};

fn array(parent: &str, name: &str, rows: usize, interval: f64) -> NamedArray {
    NamedArray {
        parent: parent.to_owned(),
        name: name.to_owned(),
        unit: None,
        values: vec![1.0; rows],
        clock: SampleClock::new(0.0, interval),
    }
}

fn shape(arrays: Arrays) -> Vec<(String, Vec<String>, usize)> {
    let tables = arrays.into_tables(&CONTEXT, "a").unwrap();
    tables
        .into_iter()
        .map(|t| {
            let rows = t.rows();
            assert!(t.columns.iter().all(|c| c.values.len() == rows));
            let names = t.columns.into_iter().map(|c| c.name).collect();
            (t.name, names, rows)
        })
        .collect()
}

#[test]
fn tables_share_folder_length_and_clock() {
    let arrays = Arrays {
        arrays: vec![
            array("run", "V", 10, 0.1),
            array("run", "x", 9, 0.1),
            array("run", "slow", 3, 0.1),
            array("run", "fast", 10, 0.01),
            array("other", "V", 10, 0.1),
            array("other", "x", 10, 0.1),
        ],
        ..Arrays::default()
    };
    let shapes = shape(arrays);
    let names: Vec<_> = shapes.iter().map(|(_, names, _)| names.join(" ")).collect();
    assert_eq!(names, ["V x", "slow", "fast", "V x"]);
    assert_eq!(shapes[3].0, "other");
    let mut distinct: Vec<_> = shapes.iter().map(|(name, _, _)| name).collect();
    distinct.dedup();
    assert_eq!(distinct.len(), 4);
}

#[test]
fn folders_of_one_array_are_channels() {
    let arrays = Arrays {
        arrays: vec![array("ch1", "data", 5, 0.0), array("ch2", "x", 5, 0.0)],
        ..Arrays::default()
    };
    let names = vec!["ch1".to_owned(), "ch2/x".to_owned()];
    assert_eq!(shape(arrays), [("a".to_owned(), names, 5)]);
}

#[test]
fn single_numbers_give_the_clock_unless_there_are_times() {
    let of = |name: &str| {
        let arrays = Arrays {
            arrays: vec![array("", name, 5, 0.0)],
            scalars: vec![
                (String::new(), "Fs".to_owned(), 50e3),
                (String::new(), "Tstart".to_owned(), -0.5),
            ],
            ..Arrays::default()
        };
        arrays.into_tables(&CONTEXT, "a").unwrap().remove(0)
    };
    let clock = SampleClock::new(-0.5, 2e-5);
    assert_eq!(of("A").clock, clock);
    assert!(of("A").notes.iter().any(|note| note.contains("Fs")));
    assert_eq!(of("t [s]").clock, None);
}

#[test]
fn nothing_to_read_says_what_there_is() {
    let arrays = Arrays {
        scalars: vec![("s".to_owned(), "k".to_owned(), 1.0)],
        left_out: vec!["c (cell)".to_owned()],
        ..Arrays::default()
    };
    let error = arrays.into_tables(&CONTEXT, "a").unwrap_err().to_string();
    assert!(error.contains("s/k (one number), c (cell)"), "{error}");
}
