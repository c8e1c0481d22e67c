//! Shares with their intervals.

use serde::{Deserialize, Serialize};

/// A share with its 95 % interval (Wilson).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// The interval.
    pub low: f64,
    /// The interval.
    pub high: f64,
}

impl Share {
    /// `count` of `of`; without any, the interval is all of 0 to 1.
    #[must_use]
    pub fn new(count: usize, of: usize) -> Self {
        if of == 0 {
            return Self {
                count,
                of,
                low: 0.0,
                high: 1.0,
            };
        }
        let (n, z2) = (of as f64, 1.959_964f64.powi(2));
        let p = count as f64 / n;
        let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = (z2 * (p * (1.0 - p) / n + z2 / (4.0 * n * n))).sqrt() / (1.0 + z2 / n);
        Self {
            count,
            of,
            low: (centre - half).max(0.0),
            high: (centre + half).min(1.0),
        }
    }

    /// `8/10 (80 %, 49-94)`, or a dash without any.
    #[must_use]
    pub fn text(&self) -> String {
        if self.of == 0 {
            return "-".into();
        }
        format!(
            "{}/{} ({:.0} %, {:.0}-{:.0})",
            self.count,
            self.of,
            100.0 * self.count as f64 / self.of as f64,
            100.0 * self.low,
            100.0 * self.high
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::share::*;

    #[test]
    fn intervals_of_wilson() {
        // 8 of 10: 0.4902 to 0.9433 (Wilson 1927).
        let share = Share::new(8, 10);
        assert!((share.low - 0.4902).abs() < 1e-4 && (share.high - 0.9433).abs() < 1e-4);
        assert_eq!(share.text(), "8/10 (80 %, 49-94)");
        assert_eq!(Share::new(0, 0).text(), "-");
    }
}
