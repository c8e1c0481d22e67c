//! MAT files as SciPy writes them; HDF5 and MAT 7.3 as h5py writes them.

use super::helpers::{
    INTERVAL, clock, names, notes_say, refusal, t, table, tables, test_file, times, unit, v,
    values, xp,
};

#[test]
fn plain_variables() {
    for file in [
        test_file!("mat5/rows.mat"),
        test_file!("mat5/columns_packed.mat"),
    ] {
        let read = table(file);
        assert_eq!(names(&read), ["t", "V", "xp"]);
        assert_eq!(values(&read, "t"), t());
        assert_eq!(values(&read, "V"), v());
        assert_eq!(values(&read, "xp"), xp());
        assert!(read.notes.is_empty(), "{:?}", read.notes);
    }
    let old = refusal(test_file!("mat5/version_4.mat"));
    assert!(old.contains("version 4") && old.contains("-v7"), "{old}");
}

#[test]
fn structures_cells_and_other_kinds() {
    let read = tables(test_file!("mat5/nested.mat"));
    let run = read.iter().find(|t| t.name == "run").unwrap();
    assert_eq!(names(run), ["A", "B"]);
    assert_eq!(values(run, "A"), times(&xp(), 2.0));
    assert_eq!(values(run, "B"), v());
    // PicoScope's names of a clock, inside the structure.
    assert_eq!(run.clock, clock(-0.001, INTERVAL));
    let rest = read.iter().find(|t| t.name == "nested").unwrap();
    assert_eq!(values(rest, "c{1}"), xp());
    assert_eq!(values(rest, "z.im"), xp());
    assert_eq!(values(rest, "m column 1"), v());
    assert_eq!(values(rest, "on")[..2], [1.0, 0.0]);
    assert!(notes_say(rest, &["sp (sparse", "text \"run 7\""]));
    let several = tables(test_file!("mat5/struct_array.mat"));
    let of: Vec<&str> = several.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(of, ["runs(1)", "runs(2)"]);
    assert_eq!(values(&several[1], "x")[0], 1.0);
}

#[test]
fn hdf5_datasets() {
    let plain = table(test_file!("hdf5/plain.h5"));
    assert_eq!(names(&plain), ["V", "t", "xp"]);
    assert_eq!((values(&plain, "t"), values(&plain, "xp")), (t(), xp()));
    let packed = table(test_file!("hdf5/attributes.h5"));
    assert_eq!(packed.name, "run");
    assert_eq!(values(&packed, "V"), v());
    assert_eq!(values(&packed, "xp"), times(&xp(), 2.0));
    assert_eq!(unit(&packed, "V"), Some("V"));
    assert_eq!(unit(&packed, "xp"), Some("um"));
    assert_eq!(packed.clock, clock(0.1, INTERVAL));
    let latest = table(test_file!("hdf5/latest.h5"));
    assert_eq!((values(&latest, "V"), values(&latest, "xp")), (v(), xp()));
    assert_eq!(latest.clock, clock(0.0, INTERVAL));
    assert!(notes_say(&latest, &["image (an array of 3 dimensions"]));
    assert_eq!(values(&table(test_file!("hdf5/lzf.h5")), "xp"), xp());
    let compound = table(test_file!("hdf5/compound.h5"));
    assert_eq!(names(&compound), ["t", "V", "xp", "on"]);
    assert_eq!(values(&compound, "xp"), times(&xp(), 2.0));
}

#[test]
fn matlab_7_3() {
    let read = tables(test_file!("hdf5/matlab_73.mat"));
    assert_eq!(read.len(), 2);
    let root = read.iter().find(|t| t.name == "matlab_73").unwrap();
    assert_eq!(names(root), ["m column 1", "m column 2", "t"]);
    assert_eq!(values(root, "m column 2"), xp());
    assert_eq!(values(root, "t"), t());
    assert_eq!(root.clock, None);
    assert!(notes_say(root, &["Fs = 4000"]));
    assert!(notes_say(root, &["name (char)", "none (double"]));
    let run = read.iter().find(|t| t.name == "run").unwrap();
    assert_eq!((values(run, "V"), values(run, "xp")), (v(), xp()));
    assert_eq!(run.clock, clock(0.0, INTERVAL));
}
