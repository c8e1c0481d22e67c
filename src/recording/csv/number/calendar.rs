//! Clock times, dates and both as seconds.

/// Seconds of a day.
pub(in crate::recording::csv) const DAY: i64 = 86_400;

/// A clock time, a date, or a date with a clock time as decimal seconds: of the day without a date,
/// since 1970 with one. `14:03:12.5`, `2026-01-01T14:03:12,5Z`, `01.01.2026 02:03 PM`. Zones are left
/// out of account: a recording stays in one.
pub(in crate::recording::csv) fn seconds(text: &str) -> Option<String> {
    let text = text.trim().trim_matches('"').trim();
    if text.len() > 64 || !text.is_ascii() {
        return None;
    }
    let (date, time) = match text.split_once(['T', ' ']) {
        Some((date, time)) if days(date).is_some() => (days(date), Some(time)),
        _ => match days(text) {
            Some(day) => (Some(day), None),
            None => (None, Some(text)),
        },
    };
    let (whole, fraction) = match time {
        Some(time) => of_day(time)?,
        None => (0, String::new()),
    };
    let total = date.unwrap_or(0).checked_mul(DAY)?.checked_add(whole)?;
    // A fraction adds to a negative total the other way.
    if total < 0 && !fraction.is_empty() {
        return None;
    }
    Some(if fraction.is_empty() {
        total.to_string()
    } else {
        format!("{total}.{fraction}")
    })
}

/// Whether `text` is a date, with or without a clock time.
pub(in crate::recording::csv) fn has_date(text: &str) -> bool {
    let text = text.trim().trim_matches('"').trim();
    let date = text.split(['T', ' ']).next();
    text.is_ascii() && date.is_some_and(|date| days(date).is_some())
}

/// Days since 1970 of `2026-01-31`, `2026/01/31`, `31.01.2026`, `01/31/2026` or `31/01/2026` (month
/// first where both can be).
fn days(text: &str) -> Option<i64> {
    let mark = ['-', '/', '.'].into_iter().find(|m| text.contains(*m))?;
    let parts: Vec<&str> = text.split(mark).collect();
    let [a, b, c] = parts.as_slice() else {
        return None;
    };
    let number = |t: &str| -> Option<i64> {
        let digits = !t.is_empty() && t.len() <= 4 && t.bytes().all(|b| b.is_ascii_digit());
        digits.then(|| t.parse().ok())?
    };
    let (first, second, third) = (number(a)?, number(b)?, number(c)?);
    let (year, month, day) = match (a.len(), c.len(), mark) {
        (4, ..) => (first, second, third),
        (_, 4, '.') => (third, second, first),
        (_, 4, _) if first > 12 => (third, second, first),
        (_, 4, _) => (third, first, second),
        _ => return None,
    };
    let valid = (1..=12).contains(&month) && (1..=31).contains(&day);
    // H. Hinnant, "chrono-compatible low-level date algorithms" (days_from_civil).
    valid.then(|| {
        let year = if month <= 2 { year - 1 } else { year };
        let era = year.div_euclid(400);
        let of_era = year - era * 400;
        let of_year = (153 * (month + if month > 2 { -3 } else { 9 }) + 2) / 5 + day - 1;
        era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
    })
}

/// Seconds of the day of `14:03:12.500`, `14:03`, `02:03:12 PM`, `14:03:12:500`, and the digits of the
/// fraction.
fn of_day(text: &str) -> Option<(i64, String)> {
    let mut text = text.trim();
    let mut half = None;
    for (mark, is_pm) in [("AM", false), ("PM", true), ("am", false), ("pm", true)] {
        if let Some(rest) = text.strip_suffix(mark) {
            (text, half) = (rest.trim_end(), Some(is_pm));
        }
    }
    let text = text.strip_suffix('Z').unwrap_or(text);
    let zone = text.rfind(['+', '-']).filter(|at| *at > 0);
    let text = zone.and_then(|at| text.get(..at)).unwrap_or(text);
    let parts: Vec<&str> = text.split(':').collect();
    let number = |t: &str| -> Option<i64> {
        let digits = (1..=2).contains(&t.len()) && t.bytes().all(|b| b.is_ascii_digit());
        digits.then(|| t.parse().ok())?
    };
    let with_fraction = |t: &str| -> Option<(i64, String)> {
        let (whole, fraction) = t.split_once(['.', ',']).unwrap_or((t, ""));
        // Some instruments write 12.500.000.000: milli-, micro- and nanoseconds.
        let fraction = fraction.replace('.', "");
        let digits = fraction.len() <= 18 && fraction.bytes().all(|b| b.is_ascii_digit());
        digits.then(|| Some((number(whole)?, fraction)))?
    };
    let (mut hours, minutes, seconds, fraction) = match parts.as_slice() {
        [h, m] => (number(h)?, number(m)?, 0, String::new()),
        [h, m, s] => {
            let (s, fraction) = with_fraction(s)?;
            (number(h)?, number(m)?, s, fraction)
        }
        [h, m, s, milli] if milli.len() == 3 && milli.bytes().all(|b| b.is_ascii_digit()) => {
            (number(h)?, number(m)?, number(s)?, (*milli).to_owned())
        }
        _ => return None,
    };
    if minutes > 59 || seconds > 60 {
        return None;
    }
    if let Some(is_pm) = half {
        hours = hours % 12 + if is_pm { 12 } else { 0 };
    }
    Some((hours * 3600 + minutes * 60 + seconds, fraction))
}

#[cfg(test)]
mod tests {
    use super::super::calendar::*;

    #[test]
    fn clock_times_and_dates_are_seconds() {
        for (text, expected) in [
            ("14:03:12.500250", "50592.500250"),
            ("14:03", "50580"),
            ("02:03:12 PM", "50592"),
            ("12:00:01 AM", "1"),
            ("14:03:12:500", "50592.500"),
            ("1970-01-02", "86400"),
            ("2026-01-01T14:03:12,5Z", "1767276192.5"),
            ("01.01.2026 14:03:12.5", "1767276192.5"),
            ("2026/01/01 14:03:12+01:00", "1767276192"),
            ("31/01/2026", "1769817600"),
            ("01/31/2026", "1769817600"),
        ] {
            assert_eq!(seconds(text).as_deref(), Some(expected), "{text}");
        }
        for text in [
            "",
            "1.5",
            "12",
            "14:63:00",
            "2026-13-01",
            "1-2",
            "a:b",
            "1,5",
        ] {
            assert_eq!(seconds(text), None, "{text}");
        }
        assert!(has_date("2026-01-01") && !has_date("14:03:12"));
    }
}
