//! How times were written, and how far from the written number each may lie.

/// How the times of a file were written, counted from its first row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::recording) struct Printed {
    /// Lowest decimal place, as a power of ten, in the file's unit.
    pub last_place: i32,
    /// Largest number that the digits of one time make without their decimal mark.
    pub most_digits: u64,
    /// Power of ten of the file's unit of time.
    pub unit: i32,
    /// A further factor of the unit, which is no power of ten (60 for minutes).
    pub factor: f64,
}

impl Printed {
    /// Nothing printed yet.
    pub(in crate::recording) const NONE: Self = Self {
        last_place: i32::MAX,
        most_digits: 0,
        unit: 0,
        factor: 1.0,
    };

    /// Takes note of a number: `digits` is the integer that its digits make, and `place` the power of
    /// ten of the last. Zero has no last place.
    #[inline]
    pub(in crate::recording) fn note(&mut self, digits: u64, place: i32) {
        if digits > 0 {
            self.last_place = self.last_place.min(place);
            self.most_digits = self.most_digits.max(digits);
        }
    }

    /// What two parts of a file show together.
    pub(in crate::recording) fn join(&mut self, other: &Self) {
        self.last_place = self.last_place.min(other.last_place);
        self.most_digits = self.most_digits.max(other.most_digits);
    }
}

/// The precision to which times were rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::recording) enum Precision {
    /// The digits in the file.
    Digits,
    /// Single precision.
    Single,
}

/// How far a time may lie from its rounded value.
pub(super) struct Rounding {
    precision: Precision,
    /// What single precision held is the time and this \[s\].
    from: f64,
    /// Half of the last place \[s\].
    places: f64,
    /// Significant digits.
    digits: i32,
    /// Whether the largest times have fewer places than the others, because their digits are
    /// counted from the front.
    significant: bool,
    /// Power of ten of the file's unit.
    unit: i32,
    /// A further factor of the unit.
    factor: f64,
    /// Rounding of the arithmetic here \[s\].
    arithmetic: f64,
}

impl Rounding {
    /// The rounding of times up to `largest` \[s\]; what single precision held is counted from `from`
    /// \[s\] before. `start` is the instant in the file of time 0 \[s\].
    pub(super) fn new(
        precision: Precision,
        from: f64,
        printed: Printed,
        largest: f64,
        start: f64,
    ) -> Self {
        let digits = printed.most_digits.checked_ilog10().map_or(1, |d| d + 1) as i32;
        let place = printed.last_place.saturating_add(printed.unit);
        let factor = printed.factor;
        let top = (largest / factor).log10().floor() as i32;
        Self {
            precision,
            from,
            places: 0.5 * 10f64.powi(place) * factor,
            digits,
            significant: top - digits + 1 > place,
            unit: printed.unit,
            factor,
            // A day number was computed from seconds, and rounded to a double before its digits were.
            arithmetic: 2.0 * spacing(largest)
                + if factor == 1.0 {
                    0.0
                } else {
                    let unit = 10f64.powi(printed.unit) * factor;
                    spacing(start / unit) * unit
                },
        }
    }

    /// Half of the rounding interval around the time `t` \[s\].
    pub(super) fn half_width(&self, t: f64) -> f64 {
        let stored = match self.precision {
            Precision::Digits => 0.0,
            // Half a step when it was stored, in the file's unit, and as much again when it was
            // written with the fewest digits that identify it.
            Precision::Single => {
                let unit = 10f64.powi(self.unit) * self.factor;
                single_spacing((t + self.from) / unit) * unit
            }
        };
        self.printed(t) + stored + self.arithmetic
    }

    /// Half of the last place of the time `t` \[s\].
    fn printed(&self, t: f64) -> f64 {
        let mut printed = self.places;
        if self.significant && t != 0.0 {
            let top = (t.abs() / self.factor).log10().floor() as i32;
            printed = printed.max(0.5 * 10f64.powi(top - self.digits + 1) * self.factor);
        }
        printed
    }

    /// Whether the times are numbers of the precision: within their digits of one, or its shortest
    /// text.
    pub(super) fn explains(&self, time: &[f64]) -> bool {
        if self.precision == Precision::Digits {
            return true;
        }
        let unit = 10f64.powi(self.unit) * self.factor;
        time.iter().all(|t| {
            let whole = t + self.from;
            let single = (whole / unit) as f32;
            let tolerance = self.arithmetic + 2.0 * spacing(whole);
            let is = |x: f64| (x * unit - whole).abs() <= tolerance;
            (f64::from(single) * unit - whole).abs() <= self.printed(*t) + tolerance
                || single.to_string().parse().is_ok_and(is)
        })
    }
}

/// Distance from `|x|` to the next `f64`.
fn spacing(x: f64) -> f64 {
    let x = x.abs();
    f64::from_bits(x.to_bits() + 1) - x
}

/// Distance from `|x|` to the next `f32`.
fn single_spacing(x: f64) -> f64 {
    let x = (x as f32).abs();
    f64::from(f32::from_bits(x.to_bits() + 1)) - f64::from(x)
}
