//! Small expressions over the measures and parameters of a run: `100 * contact_time * 15`,
//! `rebound_height(2) / rebound_height(1)`, `sqrt(2 * gravity.g * 0.3)`.

use thiserror::Error;

/// Deepest nesting of an expression: deeper ones are no text of a person.
const MAX_DEPTH: usize = 40;

/// Functions of one number that an expression may call.
const FUNCTIONS: [(&str, Function); 4] = [
    ("sqrt", f64::sqrt),
    ("abs", f64::abs),
    ("exp", f64::exp),
    ("ln", f64::ln),
];

/// A function of one number.
type Function = fn(f64) -> f64;
/// The value of a name, and of which occurrence.
pub type ValueOf<'a> = dyn Fn(&str, Option<usize>) -> Result<f64, ExpressionError> + 'a;

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Expression {
    /// A number.
    Number(f64),
    /// A parameter, or a measure with the number of its occurrence, from 1.
    Name {
        /// Id.
        id: String,
        /// Which occurrence, if one is named.
        nth: Option<usize>,
    },
    /// A function of one number.
    Function(&'static str, Box<Expression>),
    /// Two numbers joined by `+ - * / ^`.
    Binary(char, Box<Expression>, Box<Expression>),
}

/// An expression that cannot be read or computed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ExpressionError {
    /// It does not follow the grammar.
    #[error(
        "\"{text}\" cannot be read at \"{at}\"; write for example contact_time, rebound_height(2) / rebound_height(1) or sqrt(2 * 9.81)"
    )]
    Syntax {
        /// The expression.
        text: String,
        /// What stands where reading ended.
        at: String,
    },
    /// A name that is neither a parameter nor a measure.
    #[error("there is no parameter and no measure \"{name}\"; measures are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// What there is.
        known: String,
    },
    /// A measure that this run does not have.
    #[error("this run has no {name}{which}: {why}")]
    Missing {
        /// The measure.
        name: String,
        /// Which occurrence.
        which: String,
        /// What would be needed.
        why: &'static str,
    },
    /// A number that is not finite.
    #[error("\"{0}\" gives no finite number")]
    NotFinite(String),
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl Reader<'_> {
    fn rest(&self) -> &str {
        self.text.get(self.at..).unwrap_or_default()
    }

    fn skip_space(&mut self) {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start().len();
    }

    fn peek(&mut self) -> Option<char> {
        self.skip_space();
        self.rest().chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let is_there = self.peek() == Some(wanted);
        if is_there {
            self.at += wanted.len_utf8();
        }
        is_there
    }

    fn fail(&self) -> ExpressionError {
        let at: String = self.rest().chars().take(20).collect();
        ExpressionError::Syntax {
            text: self.text.trim().to_owned(),
            at: if at.is_empty() {
                "its end".to_owned()
            } else {
                at
            },
        }
    }

    fn sum(&mut self) -> Result<Expression, ExpressionError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.fail());
        }
        let mut left = self.product()?;
        while let Some(sign @ ('+' | '-')) = self.peek() {
            self.at += 1;
            left = Expression::Binary(sign, Box::new(left), Box::new(self.product()?));
        }
        self.depth -= 1;
        Ok(left)
    }

    fn product(&mut self) -> Result<Expression, ExpressionError> {
        let mut left = self.power()?;
        while let Some(sign @ ('*' | '/')) = self.peek() {
            self.at += 1;
            left = Expression::Binary(sign, Box::new(left), Box::new(self.power()?));
        }
        Ok(left)
    }

    fn power(&mut self) -> Result<Expression, ExpressionError> {
        let base = self.atom()?;
        if self.take('^') {
            let exponent = self.atom()?;
            return Ok(Expression::Binary('^', Box::new(base), Box::new(exponent)));
        }
        Ok(base)
    }

    fn atom(&mut self) -> Result<Expression, ExpressionError> {
        match self.peek() {
            Some('-') => {
                self.at += 1;
                self.depth += 1;
                if self.depth > MAX_DEPTH {
                    return Err(self.fail());
                }
                let of = self.power()?;
                self.depth -= 1;
                let zero = Box::new(Expression::Number(0.0));
                Ok(Expression::Binary('-', zero, Box::new(of)))
            }
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                if self.take(')') {
                    Ok(inner)
                } else {
                    Err(self.fail())
                }
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            _ => Err(self.fail()),
        }
    }

    fn number(&mut self) -> Result<Expression, ExpressionError> {
        let rest = self.rest();
        let ends = rest.char_indices().map(|(i, c)| i + c.len_utf8());
        let longest = ends
            .take_while(|end| {
                rest.get(..*end).is_some_and(|part| {
                    let digits = |c: char| c.is_ascii_digit() || matches!(c, '.' | 'e' | '-');
                    part.chars().all(digits)
                })
            })
            .filter_map(|end| {
                let number = rest.get(..end)?.parse::<f64>().ok()?;
                Some((end, number))
            })
            .last();
        match longest {
            Some((length, number)) => {
                self.at += length;
                Ok(Expression::Number(number))
            }
            None => Err(self.fail()),
        }
    }

    fn name(&mut self) -> Result<Expression, ExpressionError> {
        let rest = self.rest();
        let length = rest
            .find(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '_' | '.')))
            .unwrap_or(rest.len());
        let id = rest.get(..length).unwrap_or_default().to_owned();
        self.at += length;
        if !self.take('(') {
            return Ok(Expression::Name { id, nth: None });
        }
        let argument = self.sum()?;
        if !self.take(')') {
            return Err(self.fail());
        }
        if let Some((name, _)) = FUNCTIONS.iter().find(|(name, _)| *name == id) {
            return Ok(Expression::Function(name, Box::new(argument)));
        }
        match argument {
            Expression::Number(n) if n >= 1.0 && n.fract() == 0.0 && n <= 1e6 => {
                Ok(Expression::Name {
                    id,
                    nth: Some(n as usize),
                })
            }
            _ => Err(self.fail()),
        }
    }
}

impl Expression {
    /// Reads an expression.
    ///
    /// # Errors
    /// [`ExpressionError::Syntax`].
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let mut reader = Reader {
            text,
            at: 0,
            depth: 0,
        };
        let read = reader.sum()?;
        if reader.peek().is_some() {
            return Err(reader.fail());
        }
        Ok(read)
    }

    /// Its value, with `of` for the value of a name and of which occurrence.
    ///
    /// # Errors
    /// Those of `of`, and [`ExpressionError::NotFinite`].
    pub fn value(&self, of: &ValueOf<'_>) -> Result<f64, ExpressionError> {
        let value = match self {
            Self::Number(number) => *number,
            Self::Name { id, nth } => of(id, *nth)?,
            Self::Function(name, argument) => {
                let argument = argument.value(of)?;
                let function = FUNCTIONS.iter().find(|(known, _)| known == name);
                function.map_or(f64::NAN, |(_, function)| function(argument))
            }
            Self::Binary(sign, a, b) => {
                let (a, b) = (a.value(of)?, b.value(of)?);
                match sign {
                    '+' => a + b,
                    '-' => a - b,
                    '*' => a * b,
                    '/' => a / b,
                    _ => a.powf(b),
                }
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(ExpressionError::NotFinite(self.to_string()))
        }
    }

    /// Calls `with` with each name in it.
    ///
    /// # Errors
    /// The first of `with`.
    pub fn each_name<E>(&self, with: &mut dyn FnMut(&str) -> Result<(), E>) -> Result<(), E> {
        match self {
            Self::Number(_) => Ok(()),
            Self::Name { id, .. } => with(id),
            Self::Function(_, of) => of.each_name(with),
            Self::Binary(_, a, b) => {
                a.each_name(with)?;
                b.each_name(with)
            }
        }
    }

    /// The name, if it is one alone: its unit is then known.
    pub fn single_name(&self) -> Option<&str> {
        match self {
            Self::Name { id, .. } => Some(id),
            _ => None,
        }
    }
}

impl std::fmt::Display for Expression {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Name { id, nth: None } => write!(f, "{id}"),
            Self::Name { id, nth: Some(n) } => write!(f, "{id}({n})"),
            Self::Function(name, of) => write!(f, "{name}({of})"),
            Self::Binary(sign, a, b) => write!(f, "({a} {sign} {b})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<f64, ExpressionError> {
        Expression::parse(text)?.value(&|id, nth| match id {
            "two" => Ok(2.0 * nth.unwrap_or(1) as f64),
            _ => Err(ExpressionError::Unknown {
                name: id.to_owned(),
                known: "two".to_owned(),
            }),
        })
    }

    #[test]
    fn numbers_names_and_functions_are_computed_by_the_usual_order() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("2 ^ 3 - 1", 7.0),
            ("-2 ^ 2", -4.0),
            ("two(3) / two", 3.0),
            ("sqrt(2 * 9.81 * 0.3)", (2.0f64 * 9.81 * 0.3).sqrt()),
            ("1e-3*4", 4e-3),
            ("5-3", 2.0),
            ("abs(-two)", 2.0),
        ] {
            let found = value(text).unwrap();
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        for (text, part) in [
            ("", "its end"),
            ("1 +", "its end"),
            ("two(0.5)", "its end"),
            ("(1", "its end"),
            ("1 $ 2", "$ 2"),
            ("three", "three"),
            ("1 / 0", "no finite number"),
        ] {
            let error = value(text).unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
        let deep = "(".repeat(10_000);
        assert!(value(&deep).is_err());
        let deep = "-".repeat(10_000);
        assert!(value(&deep).is_err());
    }
}
