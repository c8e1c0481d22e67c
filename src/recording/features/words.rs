//! Bounces in words that cannot be misread: a mean of 1.67 says neither how many there were nor in
//! how many periods.

use super::Features;

/// Up to this many periods are written one by one.
const MAX_LISTED_PERIODS: usize = 6;

impl Features {
    /// Bounces of each steady period, in order of time; empty if there are none or the contact
    /// level is unknown.
    #[must_use]
    pub fn steady_bounces(&self) -> Vec<u32> {
        let Ok(steady) = &self.steady else {
            return Vec::new();
        };
        let whole = self.periods.iter().skip(steady.first);
        whole.filter(|p| !p.gap).filter_map(|p| p.bounces).collect()
    }

    /// The bounces as counted: `1`, `0, 1, 1`, or `0 to 2` where there are many periods.
    #[must_use]
    pub fn bounces_text(&self) -> Option<String> {
        let all = self.steady_bounces();
        let (least, most) = (*all.iter().min()?, *all.iter().max()?);
        Some(if least == most {
            least.to_string()
        } else if all.len() <= MAX_LISTED_PERIODS {
            let counts: Vec<String> = all.iter().map(u32::to_string).collect();
            counts.join(", ")
        } else {
            format!("{least} to {most}")
        })
    }

    /// The same as a sentence: `0, 1, 1 bounces in three periods`.
    #[must_use]
    pub fn bounces_sentence(&self) -> Option<String> {
        let counts = self.bounces_text()?;
        let all = self.steady_bounces();
        let bounces = if counts == "1" { "bounce" } else { "bounces" };
        let periods = match all.len() {
            1 => return Some(format!("{counts} {bounces} in one period")),
            2 => "two".to_owned(),
            3 => "three".to_owned(),
            4 => "four".to_owned(),
            n => n.to_string(),
        };
        if !counts.contains(' ') {
            return Some(format!("{counts} {bounces} in each of {periods} periods"));
        }
        let sum: u32 = all.iter().sum();
        let mean = f64::from(sum) / all.len() as f64;
        Some(format!(
            "{counts} {bounces} in {periods} periods, {mean:.2} in the mean"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;

    fn of(bounces: &[u32]) -> Features {
        let period = |b: &u32| PeriodFeatures {
            start: 0.0,
            end: 1.0,
            peak_amplitude: None,
            contact_duration: Some(0.1),
            bounces: Some(*b),
            gap: false,
        };
        Features {
            noise: 0.0,
            contact_level: Ok(0.0),
            period: Ok(1.0),
            events: Events::default(),
            periods: bounces.iter().map(period).collect(),
            steady: Ok(SteadyState {
                first: 0,
                periods: bounces.len(),
                peak_amplitude: None,
                contact_duration: None,
                bounces: None,
            }),
        }
    }

    #[test]
    fn bounces_are_said_as_they_were_counted() {
        let says = |bounces: &[u32]| of(bounces).bounces_sentence();
        for (bounces, text) in [
            (
                &[0, 0, 1][..],
                "0, 0, 1 bounces in three periods, 0.33 in the mean",
            ),
            (&[1, 1, 1], "1 bounce in each of three periods"),
            (&[2, 2], "2 bounces in each of two periods"),
            (&[0], "0 bounces in one period"),
            (
                &[0, 1, 2, 1, 1, 1, 1, 1],
                "0 to 2 bounces in 8 periods, 1.00 in the mean",
            ),
        ] {
            assert_eq!(says(bounces).as_deref(), Some(text));
        }
        assert_eq!(says(&[]), None);
    }
}
