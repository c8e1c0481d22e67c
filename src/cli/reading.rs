//! Options that change how the columns of recordings are read: `--sign`, `--scale`.

use anyhow::anyhow;
use clap::Args;

use super::{Failure, wrong_command};
use crate::model::unit::unit_factor;
use crate::recording::Channel;
use crate::recording::csv::ImportSettings;

/// How columns are read, for all recordings of a command.
#[derive(Debug, Clone, Default, Args)]
pub struct ReadingArguments {
    /// Turns a channel over, e.g. xp=-1 where displacements are positive downwards; V, xp or xc; repeatable
    #[arg(long, value_name = "CHANNEL=-1", allow_hyphen_values = true)]
    sign: Vec<String>,
    /// Factor of a channel, e.g. V=20 or V=20V/V for a voltage read at a 1/20 monitor; V, xp or xc;
    /// repeatable
    #[arg(long, value_name = "CHANNEL=FACTOR", allow_hyphen_values = true)]
    scale: Vec<String>,
}

impl ReadingArguments {
    /// The factors of `V`, `xp` and `xc`, in the order of [`Channel::ALL`].
    ///
    /// # Errors
    /// A wrong command: an unknown channel, a sign that is not 1 or -1, a factor that is no number or 0.
    pub fn factors(&self) -> Result<[f64; 3], Failure> {
        let mut all = [1.0; 3];
        for text in &self.sign {
            let (channel, value) = split("--sign", text)?;
            all[channel as usize] *= match value {
                "-1" => -1.0,
                "1" | "+1" => 1.0,
                _ => {
                    return Err(wrong_command(anyhow!(
                        "--sign {text}: a sign is 1 or -1; write for example --sign xp=-1"
                    )));
                }
            };
        }
        for text in &self.scale {
            let (channel, value) = split("--scale", text)?;
            let factor = factor(value, channel.base_unit()).ok_or_else(|| {
                wrong_command(anyhow!(
                    "--scale {text}: \"{value}\" is no factor of {}; write for example --scale V=20 or --scale xp=1nm/um",
                    channel.symbol()
                ))
            })?;
            all[channel as usize] *= factor;
        }
        Ok(all)
    }
}

/// The settings of a header with these factors.
pub fn scaled(settings: &mut ImportSettings, [voltage, xp, xc]: [f64; 3]) {
    settings.voltage_scale *= voltage;
    settings.xp_scale *= xp;
    settings.xc_scale *= xc;
}

/// `CHANNEL=VALUE` in two.
fn split<'t>(option: &str, text: &'t str) -> Result<(Channel, &'t str), Failure> {
    let named = |name: &str| {
        let name = name.trim();
        let mut all = Channel::ALL.into_iter();
        all.find(|c| c.symbol().eq_ignore_ascii_case(name))
    };
    let found = text
        .split_once('=')
        .and_then(|(name, value)| Some((named(name)?, value.trim())));
    found.ok_or_else(|| {
        wrong_command(anyhow!(
            "{option} {text}: name a channel, V, xp or xc, and its value; write for example {option} xp=-1"
        ))
    })
}

/// A finite factor that is not 0: `20`, or with units of the channel, `20V/V`, `1nm/um`.
fn factor(text: &str, base: &str) -> Option<f64> {
    let end = |c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E');
    let at = text.find(end).unwrap_or(text.len());
    let (number, units) = (text[..at].trim(), text[at..].trim());
    let number: f64 = number.parse().ok()?;
    let ratio = match units.split_once('/') {
        Some((now, read)) => {
            let filled = |unit: &str| {
                Some(unit.trim())
                    .filter(|u| !u.is_empty())
                    .map(str::to_owned)
            };
            unit_factor(&filled(now)?, base)? / unit_factor(&filled(read)?, base)?
        }
        None if units.is_empty() => 1.0,
        None => return None,
    };
    let factor = number * ratio;
    (factor.is_finite() && factor != 0.0).then_some(factor)
}

#[cfg(test)]
mod tests {
    use super::super::reading::*;

    fn of(sign: &[&str], scale: &[&str]) -> Result<[f64; 3], Failure> {
        let own = |all: &[&str]| all.iter().map(|s| (*s).to_owned()).collect();
        let (sign, scale) = (own(sign), own(scale));
        ReadingArguments { sign, scale }.factors()
    }

    #[test]
    fn signs_and_scales_multiply() {
        assert_eq!(of(&[], &[]).unwrap(), [1.0; 3]);
        assert_eq!(of(&["xp=-1"], &["V=20V/V"]).unwrap(), [20.0, -1.0, 1.0]);
        assert_eq!(
            of(&["V=-1", "xc=1"], &["v=2e1", "xc = -0.5"]).unwrap(),
            [-20.0, 1.0, -0.5]
        );
        let [_, xp, _] = of(&[], &["xp=1nm/um"]).unwrap();
        assert!((xp / 1e-3 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_factor_is_a_wrong_command() {
        for (sign, scale, word) in [
            ("xp=2", "", "1 or -1"),
            ("xp", "", "name a channel"),
            ("", "x=2", "name a channel"),
            ("", "V=0", "no factor"),
            ("", "V=nan", "no factor"),
            ("", "V=20um/V", "no factor"),
            ("", "V=20V", "no factor"),
        ] {
            let given = |text: &'static str| if text.is_empty() { vec![] } else { vec![text] };
            let failure = of(&given(sign), &given(scale)).unwrap_err();
            assert_eq!(failure.code, 2);
            let said = failure.error.to_string();
            assert!(said.contains(word), "{said}");
        }
    }
}
