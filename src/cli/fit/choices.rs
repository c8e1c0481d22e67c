//! What is chosen about parameters, effects and time on the command line: `--fix`, `--free`,
//! `--known`, `--candidates`, `--budget`. `fit` and `diagnose` share them.

use std::time::Duration;

use anyhow::{Context, anyhow, bail};
use clap::Args;

use crate::cli::{Failure, wrong_command};
use crate::fit::{FixedParameter, ParameterChoices};
use crate::model::Model;
use crate::model::effects::{self, CATALOGUE};
use crate::model::preset::Preset;
use crate::model::preset::known_value::{KnownValue, device_parameter};
use crate::model::unit::parse_quantity;

/// The word for no parameter at all.
const NO_PARAMETER: &str = "none";
/// Ways to write between a value and its error.
const ERROR_SIGNS: [&str; 3] = ["+-", "+/-", "\u{b1}"];
/// Longest time that can be asked for \[s\]: a year. Beyond it times are not counted reliably.
const MAX_BUDGET_S: f64 = 3.2e7;
/// The word for no limit.
const NO_BUDGET: &str = "none";

/// The options.
#[derive(Debug, Clone, Default, Args)]
pub struct Choices {
    /// Parameters to fit, e.g. Cs,gp,eta or quadratic_drag.cd, in place of those that are usually
    /// tuned; none for none
    #[arg(long, value_delimiter = ',', value_name = "ID,...")]
    pub free: Vec<String>,
    /// Parameter to hold, at the device's value or another, e.g. f1 or gp="72 um"; repeatable
    #[arg(long, value_name = "ID[=VALUE]")]
    pub fix: Vec<String>,
    /// Value known beforehand with its standard error, e.g. g=9.81+-0.05; it is fitted against that
    /// knowledge, and a contradiction is said; repeatable
    #[arg(long, value_name = "ID=VALUE+-ERROR")]
    pub known: Vec<String>,
    /// Time after which the work ends with the best so far, in seconds, e.g. 30; none for no limit. A
    /// diagnosis takes 60 s at most unless this is given, more only for more than a usual set of recordings
    #[arg(long, value_name = "SECONDS")]
    pub budget: Option<String>,
}

impl Choices {
    /// The choices about the parameters of a preset, with what it knows itself.
    ///
    /// # Errors
    /// [`Failure`] of a wrong command, which names the option.
    pub fn of(&self, preset: &Preset) -> Result<ParameterChoices, Failure> {
        let model = &preset.model;
        let made = self.parse(model).and_then(|choices| {
            let resolved = choices.resolve(preset).context("--free, --fix, --known")?;
            resolved.start(model).context("--fix, --known")?;
            Ok(resolved)
        });
        made.map_err(wrong_command)
    }

    fn parse(&self, model: &Model) -> anyhow::Result<ParameterChoices> {
        let fixed = self.fix.iter().map(|text| fixed(model, text));
        let known = self.known.iter().map(|text| known(model, text));
        Ok(ParameterChoices {
            free: free(&self.free)?,
            also_free: Vec::new(),
            fixed: fixed.collect::<anyhow::Result<_>>()?,
            known: known.collect::<anyhow::Result<_>>()?,
        })
    }

    /// The time that is allowed.
    ///
    /// # Errors
    /// [`Failure`] of a wrong command.
    pub fn time(&self) -> Result<Budget, Failure> {
        let read = |text: &String| {
            if text.trim().eq_ignore_ascii_case(NO_BUDGET) {
                return Ok(Budget::Unlimited);
            }
            let seconds = parse_quantity(text, "s").with_context(|| format!("--budget {text}"))?;
            if seconds > 0.0 && seconds <= MAX_BUDGET_S {
                return Ok(Budget::Of(Duration::from_secs_f64(seconds)));
            }
            bail!(
                "--budget {text}: the time must be above 0 s and at most a year, for example 30; none for no limit"
            )
        };
        let read = self.budget.as_ref().map_or(Ok(Budget::Usual), read);
        read.map_err(wrong_command)
    }
}

/// How long the work may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Budget {
    /// As long as the command allows itself.
    Usual,
    /// To its end.
    Unlimited,
    /// So long.
    Of(Duration),
}

impl Budget {
    /// The limit, if there is one; `usual` is the command's own.
    #[must_use]
    pub fn or(self, usual: Option<Duration>) -> Option<Duration> {
        match self {
            Self::Usual => usual,
            Self::Unlimited => None,
            Self::Of(time) => Some(time),
        }
    }
}

/// The ids of `--free`, without the empty ones between two commas; `None` if it was not given.
fn free(typed: &[String]) -> anyhow::Result<Option<Vec<String>>> {
    if typed.is_empty() {
        return Ok(None);
    }
    let ids = typed.iter().map(|id| id.trim().to_owned());
    let ids: Vec<String> = ids.filter(|id| !id.is_empty()).collect();
    if ids.is_empty() {
        bail!(
            "--free names no parameter; write for example --free Cs,gp, or --free none to hold all, or omit it"
        );
    }
    let is_none = |id: &String| id.eq_ignore_ascii_case(NO_PARAMETER);
    match ids.iter().any(is_none) {
        true if ids.len() > 1 => bail!("--free: write parameters or none, not both"),
        true => Ok(Some(Vec::new())),
        false => Ok(Some(ids)),
    }
}

fn fixed(model: &Model, text: &str) -> anyhow::Result<FixedParameter> {
    let option = || format!("--fix {text}");
    let (id, value) = match text.split_once('=') {
        Some((id, value)) => (id.trim(), Some(value)),
        None => (text.trim(), None),
    };
    let (id, spec) = device_parameter(model, id).with_context(option)?;
    let value = value.map(|value| parse_quantity(value, spec.unit));
    let value = value.transpose().with_context(option)?;
    if let Some(reason) = value.and_then(|value| spec.refusal(value)) {
        bail!("{}: {reason}", option());
    }
    Ok(FixedParameter { id, value })
}

fn known(model: &Model, text: &str) -> anyhow::Result<KnownValue> {
    let option = || format!("--known {text}");
    let parts = text.split_once('=').and_then(|(id, values)| {
        let mut signs = ERROR_SIGNS.iter();
        let (value, error) = signs.find_map(|sign| values.split_once(sign))?;
        Some((id.trim(), value, error))
    });
    let Some((id, value, error)) = parts else {
        bail!(
            "{}: write ID=VALUE+-ERROR, for example g=9.81+-0.05",
            option()
        );
    };
    let (id, spec) = device_parameter(model, id).with_context(option)?;
    let value = parse_quantity(value, spec.unit).with_context(option)?;
    let error = parse_quantity(error, spec.unit).with_context(option)?;
    KnownValue::new(model, &id, (value, error)).with_context(option)
}

/// The ids of `--candidates`, checked; all effects if there are none.
///
/// # Errors
/// [`Failure`] of a wrong command.
pub fn candidates(typed: &[String]) -> Result<Vec<String>, Failure> {
    let ids: Vec<&str> = typed
        .iter()
        .map(|id| id.trim())
        .filter(|id| !id.is_empty())
        .collect();
    if ids.is_empty() && !typed.is_empty() {
        return Err(wrong_command(anyhow!(
            "--candidates names no effect; write for example --candidates quadratic_drag,dry_friction, or omit it"
        )));
    }
    if let Some(unknown) = ids.iter().find(|id| effects::find(id).is_none()) {
        let all: Vec<&str> = CATALOGUE.iter().map(|effect| effect.id).collect();
        return Err(wrong_command(anyhow!(
            "--candidates {unknown}: there is no effect {unknown}; there are {}",
            all.join(", ")
        )));
    }
    Ok(ids.into_iter().map(str::to_owned).collect())
}

#[cfg(test)]
mod tests {
    use super::super::choices::*;

    #[test]
    fn free_parameters_are_the_named_ones() {
        let typed = |text: &str| {
            let ids: Vec<String> = text.split(',').map(str::to_owned).collect();
            free(&ids)
        };
        assert_eq!(typed("Cs,, gp ,").unwrap().unwrap(), ["Cs", "gp"]);
        assert_eq!(typed("none").unwrap(), Some(Vec::new()));
        assert_eq!(free(&[]).unwrap(), None);
        for nothing in ["", ",", " "] {
            let said = typed(nothing).unwrap_err().to_string();
            assert!(said.contains("--free Cs,gp"), "{said}");
        }
        assert!(typed("none,Cs").is_err());
    }

    #[test]
    fn values_may_have_units_and_names_may_be_short() {
        let faller = Preset::embedded("faller").unwrap();
        let choices = Choices {
            known: vec!["g = 9.8 m/s^2 +- 0.1".to_owned()],
            ..Choices::default()
        };
        let made = choices.of(&faller).ok().unwrap();
        let known = KnownValue::new(&faller.model, "gravity.g", (9.8, 0.1)).unwrap();
        assert_eq!(made.known, [known]);
        let paper = Preset::default();
        let choices = Choices {
            fix: vec!["gp=72 um".to_owned(), "f1".to_owned()],
            known: vec![
                "Cs=1.7e-21+-2e-22".to_owned(),
                "zeta1=0.026\u{b1}1e-3".to_owned(),
            ],
            ..Choices::default()
        };
        let made = choices.of(&paper).ok().unwrap();
        let fixed: Vec<(&str, Option<f64>)> = made
            .fixed
            .iter()
            .map(|one| (one.id.as_str(), one.value))
            .collect();
        assert_eq!(fixed, [("gp", Some(72e-6)), ("f1", None)]);
        assert_eq!(
            (made.known[0].value, made.known[0].std_error),
            (1.7e-21, 2e-22)
        );
        assert_eq!(made.known[1].std_error, 1e-3);
    }

    #[test]
    fn faults_name_the_option_and_the_remedy() {
        let paper = Preset::default();
        let said = |choices: Choices| {
            let failure = choices.of(&paper).unwrap_err();
            assert_eq!(failure.code, 2);
            format!("{:#}", failure.error)
        };
        let fix = |text: &str| Choices {
            fix: vec![text.to_owned()],
            ..Choices::default()
        };
        let known = |text: &str| Choices {
            known: vec![text.to_owned()],
            ..Choices::default()
        };
        for (choices, parts) in [
            (fix("gpp=1"), ["--fix gpp=1", "no such parameter"]),
            (fix("alpha=2"), ["--fix alpha=2", "above 1"]),
            (fix("gp=1 kg"), ["--fix gp=1 kg", "not a unit"]),
            (fix("gp=50e-6"), ["--fix", "must exceed dp"]),
            (known("Cs=1e-21"), ["--known Cs=1e-21", "ID=VALUE+-ERROR"]),
            (known("Cs=1e-21+-0"), ["--known Cs=1e-21+-0", "above 0"]),
            (
                known("gravity.g=9+-1"),
                ["--known gravity.g", "no such parameter"],
            ),
            (known("Cs=1e-21+-x"), ["--known Cs", "not a number"]),
        ] {
            let text = said(choices);
            assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        }
        for text in ["0", "-1", "x", "1e99"] {
            let choices = Choices {
                budget: Some(text.to_owned()),
                ..Choices::default()
            };
            let failure = choices.time().unwrap_err();
            assert!(failure.code == 2 && failure.error.to_string().contains("--budget"));
        }
        let choices = Choices {
            budget: Some("1500ms".to_owned()),
            ..Choices::default()
        };
        assert_eq!(
            choices.time().ok().unwrap(),
            Budget::Of(Duration::from_millis(1500))
        );
        let usual = Some(Duration::from_secs(60));
        assert_eq!(Choices::default().time().ok().unwrap().or(usual), usual);
        let choices = Choices {
            budget: Some("none".to_owned()),
            ..Choices::default()
        };
        assert_eq!(choices.time().ok().unwrap().or(usual), None);
        for (typed, part) in [("drag", "no effect drag"), (",", "names no effect")] {
            let ids: Vec<String> = typed.split(',').map(str::to_owned).collect();
            let failure = candidates(&ids).unwrap_err();
            assert!(failure.code == 2 && failure.error.to_string().contains(part));
        }
        assert_eq!(
            candidates(&["gravity".to_owned()]).ok().unwrap(),
            ["gravity"]
        );
    }
}
