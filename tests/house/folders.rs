//! A folder holds at most twelve files.

use std::collections::BTreeMap;

use super::assert_none;
use super::source::Tree;

const MAX_FILES: usize = 12;
/// Folders with one file for each thing of a kind, as many as there are.
const CATALOGUES: [&str; 3] = ["effects", "formats", "lessons"];

fn too_full(tree: &Tree) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for path in tree.files.keys() {
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        *counts.entry(folder).or_default() += 1;
    }
    let is_catalogue = |folder: &str| CATALOGUES.contains(&folder.rsplit('/').next().unwrap_or(""));
    let full = counts
        .into_iter()
        .filter(|(folder, n)| *n > MAX_FILES && !is_catalogue(folder));
    full.map(|(folder, n)| format!("{folder}: {n} files"))
        .collect()
}

#[test]
fn folders_hold_twelve_files_at_most() {
    let found = too_full(&Tree::of_this_repository());
    assert_none("folders of more than twelve files", &found);
}

#[test]
fn a_full_folder_is_seen() {
    let tree = |folder: &str, n: usize| {
        let paths: Vec<String> = (0..n).map(|i| format!("src/{folder}/f{i}.rs")).collect();
        let files: Vec<(&str, &str)> = paths.iter().map(|path| (path.as_str(), "")).collect();
        Tree::made(&files)
    };
    assert!(too_full(&tree("fit", 12)).is_empty());
    assert_eq!(too_full(&tree("fit", 13)), ["src/fit: 13 files"]);
    assert!(too_full(&tree("model/effects", 30)).is_empty());
    assert_eq!(too_full(&tree("effects_of_time", 13)).len(), 1);
}
