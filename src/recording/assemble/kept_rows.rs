//! Which rows are kept, and which of their cells are missing.

/// Number of missing samples, and the first.
pub(super) fn missing(values: &[f64]) -> (usize, Option<usize>) {
    let count = values.iter().filter(|v| !v.is_finite()).count();
    let first = if count > 0 {
        values.iter().position(|v| !v.is_finite())
    } else {
        None
    };
    (count, first)
}

/// [`missing`] among the rows to `keep`; all, if `None`.
pub(super) fn missing_in(values: &[f64], keep: Option<&[bool]>) -> (usize, Option<usize>) {
    let Some(keep) = keep else {
        return missing(values);
    };
    let mut absent = (0..values.len()).filter(|&i| keep[i] && !values[i].is_finite());
    let first = absent.next();
    (absent.count() + usize::from(first.is_some()), first)
}

/// Rows whose times increase.
pub(in crate::recording) struct ForwardRows {
    /// Whether a row is one of them.
    pub keep: Vec<bool>,
    /// Rows with a time that are not.
    pub dropped: usize,
    /// The first of those.
    pub first_dropped: Option<usize>,
}

/// Which rows to keep so that time increases. A single time that is too large is dropped rather
/// than all that follow it.
pub(in crate::recording) fn forward_rows(time: &[f64]) -> ForwardRows {
    let mut keep = vec![false; time.len()];
    let mut dropped = 0;
    let mut first = None;
    let mut last = f64::NEG_INFINITY;
    let finite: Vec<usize> = (0..time.len()).filter(|&i| time[i].is_finite()).collect();
    for (k, &i) in finite.iter().enumerate() {
        let t = time[i];
        let next = finite.get(k + 1).map(|&j| time[j]);
        let spike = next.is_some_and(|next| next < t && next > last) && k > 0;
        if t > last && !spike {
            keep[i] = true;
            last = t;
        } else {
            dropped += 1;
            first.get_or_insert(i);
        }
    }
    ForwardRows {
        keep,
        dropped,
        first_dropped: first,
    }
}
