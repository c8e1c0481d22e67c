//! Which column a person means, and how a message names one so that it is found again.

use super::names::Column;

/// The column that `name` means: a whole header cell, a name, or a number from 1.
pub(in crate::recording::csv) fn column_meant(
    name: &str,
    header: &[String],
    columns: usize,
) -> Option<usize> {
    let name = name.trim();
    let whole = header.iter().position(|cell| cell.trim() == name);
    // A name that stands twice says nothing.
    let only = |is_it: &dyn Fn(&str) -> bool| {
        let mut found = (0..header.len()).filter(|i| is_it(&Column::of(&header[*i]).name));
        let first = found.next()?;
        found.next().is_none().then_some(first)
    };
    let by_number = || {
        let number: usize = name.parse().ok()?;
        number.checked_sub(1).filter(|i| *i < columns)
    };
    whole
        .or_else(|| only(&|plain| plain == name))
        .or_else(|| only(&|plain| plain.eq_ignore_ascii_case(name)))
        .or_else(by_number)
}

/// What to write for a column: its number, or its name where columns are called by numbers.
pub(super) fn option_for(index: usize, header: &[String]) -> String {
    let number = (index + 1).to_string();
    let finds = |text: &str| column_meant(text, header, header.len()) == Some(index);
    let plain = |cell: &str| Column::of(cell).name;
    let are_numbers = header
        .iter()
        .any(|cell| plain(cell).parse::<usize>().is_ok());
    if !are_numbers && finds(&number) {
        return number;
    }
    let whole = header.get(index).map_or("", |cell| cell.trim());
    let plain = plain(whole);
    let text = [plain.as_str(), whole].into_iter().find(|text| finds(text));
    match text {
        Some(text) if text.contains(char::is_whitespace) => format!("\"{text}\""),
        Some(text) => text.to_owned(),
        None => number,
    }
}

#[cfg(test)]
mod tests {
    use super::super::meant::*;

    #[test]
    fn a_message_names_a_column_so_that_it_is_found_again() {
        let header = |cells: &[&str]| cells.iter().map(|c| (*c).to_owned()).collect::<Vec<_>>();
        for cells in [
            header(&["x-axis [second]", "1 [Volt]", "2 [Volt]"]),
            header(&["2", "3", "1"]),
            header(&["t [s]", "CH 2 [V]", "xp [um]"]),
            header(&["", "", ""]),
        ] {
            for i in 0..cells.len() {
                let option = option_for(i, &cells);
                let found = column_meant(option.trim_matches('"'), &cells, cells.len());
                assert_eq!(found, Some(i), "{option} of {cells:?}");
            }
        }
        let scope = header(&["x-axis [second]", "1 [Volt]", "2 [Volt]"]);
        assert_eq!([1, 2].map(|i| option_for(i, &scope)), ["1", "2"]);
        assert_eq!(column_meant("3", &scope, 3), Some(2));
    }
}
