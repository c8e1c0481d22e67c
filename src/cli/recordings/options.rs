//! Options that decide how recordings are read: `--column`, `--unit`, `--scale`, `--sign`, `--dt`, `--rate`,
//! `--trial`, `--encoding`, `--decimal`, `--accept-losses`, `--drift`. They are the same wherever a recording is
//! taken, as are those that make one recording of several.

use anyhow::{Context, anyhow};
use clap::Args;

use super::combine::{Combine, CombineArguments};
use crate::cli::{Failure, wrong_command};
use crate::model::unit::parse_quantity;
use crate::recording::csv::{Decimal, DriftRemoval, Encoding, ReadingChoices};

/// How recordings are read, for all recordings of a command.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "How recordings are read")]
pub struct ReadingArguments {
    /// Column of a channel, by its name or its number from 1, e.g. xp="Displacement tip" or V=2; t, V,
    /// xp or xc; repeatable
    #[arg(long, value_name = "CHANNEL=NAME|N")]
    column: Vec<String>,
    /// Unit of a column, e.g. xp=nm or t=ms; repeatable
    #[arg(long, value_name = "CHANNEL=UNIT")]
    unit: Vec<String>,
    /// Turns a channel over, e.g. xp=-1 where displacements are positive downwards; V, xp or xc; repeatable
    #[arg(long, value_name = "CHANNEL=-1", allow_hyphen_values = true)]
    sign: Vec<String>,
    /// Factor of a channel, or what one unit of its column stands for, e.g. V=20 at a 1/20 monitor or
    /// xp=0.5um/V for the output of a displacement meter; repeatable
    #[arg(long, value_name = "CHANNEL=FACTOR", allow_hyphen_values = true)]
    scale: Vec<String>,
    /// Time from sample to sample where there is no column of times, e.g. 20us
    #[arg(long, value_name = "TIME", conflicts_with = "rate")]
    dt: Option<String>,
    /// Samples per second where there is no column of times, e.g. 50kHz
    #[arg(long, value_name = "RATE")]
    rate: Option<String>,
    /// Which recording, from 1, of a file that holds several; with --average which ones, e.g. 1,2,4
    #[arg(long, value_name = "N", value_delimiter = ',')]
    trial: Vec<usize>,
    /// Encoding of text, e.g. windows-1252, utf-16le, gbk; recognised unless it is given
    #[arg(long, value_name = "NAME")]
    encoding: Option<String>,
    /// The decimal mark, where the numbers do not say it: point or comma
    #[arg(long, value_name = "MARK")]
    decimal: Option<String>,
    /// Reads a file although more than a few of its rows cannot be used
    #[arg(long)]
    accept_losses: bool,
    /// What is taken out of a displacement that is the integral of a velocity or an acceleration: none, mean,
    /// line, or high-pass, e.g. high-pass:2Hz
    #[arg(long, value_name = "WHAT")]
    drift: Option<String>,
    #[command(flatten)]
    combine: CombineArguments,
}

impl ReadingArguments {
    /// The choices that these options make.
    ///
    /// # Errors
    /// A wrong command: an option that cannot be understood.
    pub fn choices(&self) -> Result<ReadingChoices, Failure> {
        self.parsed().map_err(wrong_command)
    }

    /// How recordings are put together, and which ones of a file are named.
    pub(super) fn combine(&self) -> Result<(Combine, &[usize]), Failure> {
        let combine = self.combine.parsed().map_err(wrong_command)?;
        Ok((combine, &self.trial))
    }

    fn parsed(&self) -> anyhow::Result<ReadingChoices> {
        let pairs = |option: &str, all: &[String], example: &str| {
            let one = |text: &String| pair(option, text, example);
            all.iter().map(one).collect::<anyhow::Result<Vec<_>>>()
        };
        let signs = pairs("--sign", &self.sign, "xp=-1")?;
        let signs = signs
            .into_iter()
            .map(|(channel, value)| match value.as_str() {
                "-1" => Ok((channel, -1.0)),
                "1" | "+1" => Ok((channel, 1.0)),
                _ => Err(anyhow!(
                    "--sign {channel}={value}: a sign is 1 or -1; write for example --sign xp=-1"
                )),
            });
        Ok(ReadingChoices {
            columns: pairs("--column", &self.column, "xp=3")?,
            units: pairs("--unit", &self.unit, "xp=um")?,
            scales: pairs("--scale", &self.scale, "xp=0.5um/V")?,
            signs: signs.collect::<anyhow::Result<_>>()?,
            interval: self.interval()?,
            trial: match self.trial[..] {
                [only] => Some(only),
                _ => None,
            },
            encoding: self.encoding.as_deref().map(encoding).transpose()?,
            decimal: self.decimal.as_deref().map(decimal).transpose()?,
            accept_losses: self.accept_losses,
            drift: self
                .drift
                .as_deref()
                .map_or(Ok(DriftRemoval::None), drift)?,
        })
    }

    /// Time from sample to sample \[s\], if it is given.
    fn interval(&self) -> anyhow::Result<Option<f64>> {
        let positive = |option: &str, text: &str, unit: &str| -> anyhow::Result<f64> {
            let value = parse_quantity(text, unit).with_context(|| format!("{option} {text}"))?;
            if value > 0.0 && value.is_finite() {
                return Ok(value);
            }
            Err(anyhow!("{option} {text}: it must be above 0"))
        };
        let dt = self.dt.as_deref().map(|text| positive("--dt", text, "s"));
        let rate = || {
            let rate = self.rate.as_deref();
            rate.map(|text| positive("--rate", text, "Hz").map(|rate| 1.0 / rate))
        };
        dt.or_else(rate).transpose()
    }
}

/// `CHANNEL=VALUE` in two.
fn pair(option: &str, text: &str, example: &str) -> anyhow::Result<(String, String)> {
    let found = text
        .split_once('=')
        .map(|(channel, value)| (channel.trim().to_owned(), value.trim().to_owned()));
    let is_channel = |name: &str| {
        let known = ["t", "V", "xp", "xc"];
        known
            .iter()
            .any(|channel| channel.eq_ignore_ascii_case(name))
    };
    found
        .filter(|(channel, value)| is_channel(channel) && !value.is_empty())
        .ok_or_else(|| {
            anyhow!(
                "{option} {text}: name a channel, t, V, xp or xc, and its value; write for example {option} {example}"
            )
        })
}

fn encoding(name: &str) -> anyhow::Result<Encoding> {
    Encoding::named(name).ok_or_else(|| {
        let all: Vec<&str> = Encoding::ALL.iter().map(|e| e.label()).collect();
        anyhow!(
            "--encoding {name}: it is not known; there are {}",
            all.join(", ")
        )
    })
}

fn decimal(mark: &str) -> anyhow::Result<Decimal> {
    match mark.trim() {
        "point" | "." => Ok(Decimal::Point),
        "comma" | "," => Ok(Decimal::Comma),
        _ => Err(anyhow!("--decimal {mark}: write point or comma")),
    }
}

fn drift(text: &str) -> anyhow::Result<DriftRemoval> {
    let (name, corner) = match text.split_once(':') {
        Some((name, corner)) => (name, Some(corner)),
        None => (text, None),
    };
    let known = DriftRemoval::ALL
        .into_iter()
        .find(|d| d.label() == name.trim());
    match (known, corner) {
        (Some(DriftRemoval::HighPass { .. }), Some(corner)) => {
            let hertz = parse_quantity(corner, "Hz").with_context(|| format!("--drift {text}"))?;
            if hertz > 0.0 && hertz.is_finite() {
                return Ok(DriftRemoval::HighPass {
                    corner: Some(hertz),
                });
            }
            Err(anyhow!("--drift {text}: the corner must be above 0"))
        }
        (Some(drift), None) => Ok(drift),
        _ => {
            let all: Vec<&str> = DriftRemoval::ALL.iter().map(|d| d.label()).collect();
            Err(anyhow!(
                "--drift {text}: write one of {}, or high-pass:2Hz",
                all.join(", ")
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::options::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Only {
        #[command(flatten)]
        reading: ReadingArguments,
    }

    fn of(line: &str) -> Result<ReadingChoices, Failure> {
        let words = std::iter::once("x").chain(line.split_whitespace());
        Only::try_parse_from(words).unwrap().reading.choices()
    }

    #[test]
    fn options_become_choices() {
        assert_eq!(of("").unwrap(), ReadingChoices::default());
        let line = "--column V=2 --column xp=tip --unit t=ms --scale xp=0.5um/V --sign xp=-1 --rate 50kHz \
                    --trial 3 --encoding latin1 --decimal comma --accept-losses --drift high-pass:2Hz";
        let choices = of(line).unwrap();
        let own = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(choices.columns, [own("V", "2"), own("xp", "tip")]);
        assert_eq!(choices.units, [own("t", "ms")]);
        assert_eq!(choices.scales, [own("xp", "0.5um/V")]);
        assert_eq!(choices.signs, [("xp".to_owned(), -1.0)]);
        assert!((choices.interval.unwrap() - 2e-5).abs() < 1e-18);
        assert_eq!(choices.trial, Some(3));
        assert_eq!(choices.encoding, Some(Encoding::Windows1252));
        assert_eq!(choices.decimal, Some(Decimal::Comma));
        assert!(choices.accept_losses);
        let corner = Some(2.0);
        assert_eq!(choices.drift, DriftRemoval::HighPass { corner });
        assert_eq!(of("--drift line").unwrap().drift, DriftRemoval::Line);
        assert!((of("--dt 20us").unwrap().interval.unwrap() - 2e-5).abs() < 1e-18);
    }

    fn combine_of(line: &str) -> Result<(Combine, Vec<usize>), Failure> {
        let words = std::iter::once("x").chain(line.split_whitespace());
        let reading = Only::try_parse_from(words).unwrap().reading;
        reading
            .combine()
            .map(|(combine, which)| (combine, which.to_vec()))
    }

    #[test]
    fn recordings_are_put_together_by_options() {
        use super::super::combine::AverageOf;
        use crate::recording::combine::AverageOptions;
        use std::path::PathBuf;

        assert_eq!(combine_of("").unwrap(), (Combine::Separate, Vec::new()));
        let line = "--average files --trial 1,3 --match-zeros --leave-out-misfits";
        let options = AverageOptions {
            leave_out_misfits: true,
            match_zeros: true,
        };
        let average = Combine::Average(AverageOf::Files, options);
        assert_eq!(combine_of(line).unwrap(), (average, vec![1, 3]));
        let points = combine_of("--points xc,xp --lag -1.5ms").unwrap().0;
        let lag = Some(-1.5e-3);
        let is_proof_mass_first = false;
        assert_eq!(
            points,
            Combine::Points {
                is_proof_mass_first,
                lag
            }
        );
        let files: Vec<PathBuf> = ["a", "b", "c", "d"].map(PathBuf::from).to_vec();
        assert!(
            points
                .groups(&files[..3])
                .unwrap_err()
                .to_string()
                .contains("pairs")
        );
        assert!(
            points
                .groups(&files)
                .unwrap_err()
                .to_string()
                .contains("--lag")
        );
        let both = combine_of("--points xp,xc")
            .unwrap()
            .0
            .groups(&files)
            .unwrap();
        assert_eq!(both, [files[..2].to_vec(), files[2..].to_vec()]);
        assert!(combine_of("--points tip,base").is_err());
        for line in [
            "--match-zeros",
            "--lag 1ms",
            "--average files --points xp,xc",
        ] {
            let words = std::iter::once("x").chain(line.split_whitespace());
            assert!(Only::try_parse_from(words).is_err(), "{line}");
        }
    }

    #[test]
    fn what_cannot_be_understood_is_a_wrong_command() {
        for (line, word) in [
            ("--sign xp=2", "1 or -1"),
            ("--sign xp", "name a channel"),
            ("--scale x=2", "name a channel"),
            ("--column xp=", "name a channel"),
            ("--dt 0", "above 0"),
            ("--rate 5um", "--rate"),
            ("--encoding klingon", "not known"),
            ("--decimal dot", "point or comma"),
            ("--drift slope", "none, mean, line, high-pass"),
            ("--drift high-pass:-1Hz", "above 0"),
            ("--drift mean:2Hz", "one of"),
        ] {
            let failure = of(line).unwrap_err();
            assert_eq!(failure.code, 2);
            let said = format!("{:#}", failure.error);
            assert!(said.contains(word), "{said}");
        }
    }
}
