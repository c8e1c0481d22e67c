//! `.npy` and `.npz` as NumPy writes them.

use proptest::prelude::*;

use super::helpers::{
    clock, column, names, notes_say, refusal, t, table, tables, test_file, times, unit, v, values,
    xp,
};

#[test]
fn columns_in_either_order() {
    let read = table(test_file!("npy/columns_f8.npy"));
    assert_eq!(read.name, "columns_f8");
    let columns: Vec<_> = read.columns.iter().map(|c| c.values.clone()).collect();
    assert_eq!(columns, [t(), v(), xp()]);
    assert!(read.notes.is_empty());
    let read = table(test_file!("npy/fortran_f4.npy"));
    assert_eq!(values(&read, "fortran_f4 column 2"), xp());
    let read = table(test_file!("npy/rows_f8.npy"));
    assert_eq!(values(&read, "rows_f8 column 3"), xp());
    assert!(notes_say(&read, &["3 channels as rows"]));
}

#[test]
fn kinds_of_numbers() {
    let one = table(test_file!("npy/one_i2.npy"));
    assert_eq!(values(&one, "one_i2"), times(&xp(), 2.0));
    let big = table(test_file!("npy/big_endian_i4.npy"));
    assert_eq!(values(&big, "big_endian_i4 column 2"), times(&xp(), 2.0));
    assert_eq!(values(&table(test_file!("npy/half.npy")), "half"), xp());
    let complex = table(test_file!("npy/complex.npy"));
    assert_eq!(values(&complex, "complex.re"), v());
    assert_eq!(values(&complex, "complex.im"), xp());
    assert!(notes_say(&complex, &["complex", "two columns"]));
}

#[test]
fn fields_of_a_structured_array() {
    let read = table(test_file!("npy/structured.npy"));
    assert_eq!(names(&read), ["when", "V", "n", "pos 1", "pos 2", "on"]);
    assert_eq!(values(&read, "V"), v());
    assert_eq!(values(&read, "pos 2"), times(&xp(), -1.0));
    assert_eq!(values(&read, "n")[11], 11.0);
    assert_eq!(values(&read, "on")[..3], [0.0, 1.0, 0.0]);
    // 2026-01-01 in Unix seconds, then 1 ms a row.
    let when = column(&read, "when");
    assert!((when.values[3] - 1_767_225_600.003).abs() < 1e-6);
    assert_eq!(unit(&read, "when"), Some("s"));
    assert!(notes_say(&read, &["name", "no numbers"]));
    assert!(refusal(test_file!("npy/objects.npy")).contains("Python objects"));
}

#[test]
fn archives() {
    let plain = table(test_file!("npz/plain.npz"));
    assert_eq!(names(&plain), ["t", "V", "xp"]);
    assert_eq!((values(&plain, "t"), values(&plain, "xp")), (t(), xp()));
    assert_eq!(plain.clock, None);
    let packed = tables(test_file!("npz/packed.npz"));
    assert_eq!(packed.len(), 2);
    assert_eq!(packed[0].clock, clock(0.0, 0.00025));
    assert_eq!(values(&packed[0], "V"), v());
    assert_eq!(names(&packed[1]), ["slow"]);
    assert!(notes_say(&packed[0], &["names", "Python objects"]));
    assert!(notes_say(&packed[0], &["number fs"]));
}

proptest! {
    /// Written here after NEP 1, read in the same values.
    #[test]
    fn what_is_written_is_read(
        values in proptest::collection::vec(-1e300..1e300f64, 6..200),
        is_fortran in any::<bool>(),
    ) {
        let rows = values.len() / 2;
        let order = if is_fortran { "True" } else { "False" };
        let header = format!(
            "{{'descr': '>f8', 'fortran_order': {order}, 'shape': ({rows}, 2), }}\n"
        );
        let mut bytes = b"\x93NUMPY\x01\0".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(values[..2 * rows].iter().flat_map(|v| v.to_be_bytes()));
        let read = table(("a.npy", &bytes));
        let second: Vec<f64> = if is_fortran {
            values[rows..2 * rows].to_vec()
        } else {
            values[..2 * rows].iter().skip(1).step_by(2).copied().collect()
        };
        prop_assert_eq!(&read.columns[1].values, &second);
    }
}

#[test]
fn headers_that_are_not_believed() {
    let of = |header: &str| {
        let mut bytes = b"\x93NUMPY\x01\0".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend([0; 64]);
        refusal(("a.npy", &bytes))
    };
    let huge = "{'descr': '<f8', 'fortran_order': False, 'shape': (1152921504606846976, 2), }\n";
    assert!(of(huge).contains("a.npy"), "{}", of(huge));
    let more = "{'descr': '<f8', 'fortran_order': False, 'shape': (9,), }\n";
    assert!(of(more).contains("ends at byte"), "{}", of(more));
    let deep = "(".repeat(5000);
    assert!(of(&deep).contains("the header"));
    // What, where, and what to do.
    let odd = of("{'descr': '<f8', 'shape': (9,), }\n");
    for part in ["a.npy", "byte 10", "'shape': (9,)", "numpy.save"] {
        assert!(odd.contains(part), "{odd}");
    }
    let long = refusal(("a.npy", b"\x93NUMPY\x02\0\xff\xff\xff\xff{}"));
    assert!(
        long.contains("length of the header") && long.contains("numpy.save"),
        "{long}"
    );
}
