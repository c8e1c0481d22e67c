//! The header of a function: records 1 to 11 of dataset 58.

use super::super::bytes::{ByteOrder, text};
use super::super::error::{FileContext, FormatError};
use super::super::lines::Lines;

/// Abscissa data type: time.
const TIME: i64 = 17;
/// Abscissa data types that may be time: unknown, general, time.
const MAYBE_TIME: [i64; 3] = [0, 1, TIME];
/// Function types that are a recording: general, time response.
const TIME_HISTORIES: [i64; 2] = [0, 1];

/// A function's numbers.
#[derive(Debug, Default)]
pub(super) struct Function {
    /// Abscissa, where it is uneven.
    pub abscissa: Option<Vec<f64>>,
    /// Ordinate; for complex data its numbers as they come.
    pub ordinate: Vec<f64>,
    /// For the user.
    pub notes: Vec<String>,
}

/// Floating point format of a binary function, and its byte order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Binary {
    pub order: ByteOrder,
    /// Bytes of data by the header, not always true.
    pub bytes: Option<usize>,
}

/// What the records before the data say.
#[derive(Debug)]
pub(super) struct Header {
    ids: Vec<String>,
    function_type: i64,
    response: String,
    pub count: usize,
    pub is_double: bool,
    pub is_complex: bool,
    pub is_even: bool,
    pub start: f64,
    pub interval: f64,
    abscissa_type: i64,
    abscissa_unit: String,
    pub ordinate_type: i64,
    ordinate_label: String,
    pub ordinate_unit: String,
    pub binary: Option<Binary>,
}

/// Fields of a line with fixed widths.
fn fixed<'a>(line: &'a str, widths: &[usize]) -> Vec<&'a str> {
    let mut rest = line;
    widths
        .iter()
        .map(|width| {
            let end = rest
                .char_indices()
                .nth(*width)
                .map_or(rest.len(), |(at, _)| at);
            let (field, after) = rest.split_at(end);
            rest = after;
            field.trim()
        })
        .collect()
}

/// The numbers of `line`: by width, or between spaces where widths do not give numbers.
fn numbers(line: &str, widths: &[usize]) -> Option<Vec<f64>> {
    let parse = |field: &str| -> Option<f64> {
        field
            .replace(['D', 'd'], "E")
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
    };
    let by_width: Option<Vec<f64>> = fixed(line, widths)
        .into_iter()
        .map(|field| {
            if field.is_empty() {
                Some(0.0)
            } else {
                parse(field)
            }
        })
        .collect();
    by_width.or_else(|| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        if fields.len() < widths.len() {
            return None;
        }
        fields.into_iter().take(widths.len()).map(parse).collect()
    })
}

/// A text that is not `NONE`.
fn some(field: Option<&&str>) -> String {
    field
        .filter(|field| !field.eq_ignore_ascii_case("none"))
        .map_or_else(String::new, |field| (*field).to_owned())
}

impl Header {
    /// Reads the eleven records; `first` is the line with the dataset's number.
    pub fn read(
        context: &FileContext,
        first: &[u8],
        lines: &mut Lines,
    ) -> Result<Self, FormatError> {
        let binary = binary(context, first, lines.number())?;
        let mut records: Vec<String> = Vec::new();
        for _ in 0..11 {
            let line = lines.next();
            let line = line.ok_or_else(|| context.truncated(lines.at(), "a function's header"))?;
            records.push(text(line));
        }
        let record = |number: usize| records.get(number - 1).map_or("", String::as_str);
        let line = lines.number() - 4;
        let bad =
            |what: &str| context.malformed_line(line, format!("{what} of a function is not valid"));
        let dof = fixed(record(6), &[5, 10, 5, 10, 11, 10, 4, 11, 10, 4]);
        let form =
            numbers(record(7), &[10, 10, 10, 13, 13, 13]).ok_or_else(|| bad("the data form"))?;
        let [kind, count, spacing, start, interval, _] = form.as_slice() else {
            return Err(bad("the data form"));
        };
        let (is_double, is_complex) = match *kind as i64 {
            2 => (false, false),
            4 => (true, false),
            5 => (false, true),
            6 => (true, true),
            _ => return Err(bad("the type of data (2, 4, 5 or 6)")),
        };
        if !(0.0..1e15).contains(count) {
            return Err(bad("the number of values"));
        }
        let axis = |number: usize| fixed(record(number), &[10, 5, 5, 5, 21, 21]);
        let kind_of = |axis: &[&str]| axis.first().and_then(|f| f.parse().ok()).unwrap_or(0);
        let (abscissa, ordinate) = (axis(8), axis(9));
        Ok(Self {
            ids: (1..=5).map(|n| record(n).trim().to_owned()).collect(),
            function_type: dof.first().and_then(|f| f.parse().ok()).unwrap_or(0),
            response: response(&dof),
            count: *count as usize,
            is_double,
            is_complex,
            is_even: *spacing == 1.0,
            start: *start,
            interval: *interval,
            abscissa_type: kind_of(&abscissa),
            abscissa_unit: some(abscissa.get(5)),
            ordinate_type: kind_of(&ordinate),
            ordinate_label: some(ordinate.get(4)),
            ordinate_unit: some(ordinate.get(5)),
            binary,
        })
    }

    pub fn is_binary(&self) -> bool {
        self.binary.is_some()
    }

    /// Numbers of one sample, with its abscissa.
    pub fn numbers_per_sample(&self) -> usize {
        1 + usize::from(self.is_complex) + usize::from(!self.is_even)
    }

    /// A name: the label of its axis or its first line, and its degree of freedom.
    pub fn name(&self) -> String {
        let id = self
            .ids
            .first()
            .filter(|id| !id.is_empty() && !id.eq_ignore_ascii_case("none"));
        let label = Some(&self.ordinate_label).filter(|label| !label.is_empty());
        let name = label.or(id).map_or("", String::as_str);
        let full = format!("{name} {}", self.response);
        let full = full.trim();
        if full.is_empty() {
            "function".to_owned()
        } else {
            full.to_owned()
        }
    }

    /// Why the function is no time history; `None` if it is one.
    pub fn no_time_history(&self) -> Option<String> {
        if self.is_complex {
            return Some("complex: a spectrum".to_owned());
        }
        if !TIME_HISTORIES.contains(&self.function_type) {
            let name = match self.function_type {
                2 => "auto spectrum",
                3 => "cross spectrum",
                4 => "frequency response",
                6 => "coherence",
                7 | 8 => "correlation",
                9 => "power spectral density",
                12 => "spectrum",
                _ => "no time response",
            };
            return Some(format!("function type {}: {name}", self.function_type));
        }
        (!MAYBE_TIME.contains(&self.abscissa_type))
            .then(|| format!("abscissa of type {}, not time", self.abscissa_type))
    }

    /// Seconds in a unit of the abscissa, and a note unless it is seconds.
    pub fn seconds(&self) -> (f64, Option<String>) {
        let unit = self.abscissa_unit.as_str();
        let scale = match unit.to_lowercase().as_str() {
            "" | "s" | "sec" | "second" | "seconds" => return (1.0, None),
            "ms" | "msec" => 1e-3,
            "us" | "\u{b5}s" | "\u{3bc}s" => 1e-6,
            "min" => 60.0,
            _ => {
                return (
                    1.0,
                    Some(format!(
                        "The abscissa has the unit \"{unit}\"; it was taken as seconds."
                    )),
                );
            }
        };
        (scale, Some(format!("Times in {unit} became seconds.")))
    }
}

/// Name, node and direction of the response: `Ref 1+Z`.
fn response(dof: &[&str]) -> String {
    let name = some(dof.get(4));
    let node: i64 = dof.get(5).and_then(|f| f.parse().ok()).unwrap_or(0);
    let direction: i64 = dof.get(6).and_then(|f| f.parse().ok()).unwrap_or(0);
    let axis = match direction.abs() {
        1 => "X",
        2 => "Y",
        3 => "Z",
        4 => "RX",
        5 => "RY",
        6 => "RZ",
        _ => "",
    };
    let sign = match (axis, direction > 0) {
        ("", _) => "",
        (_, true) => "+",
        (_, false) => "-",
    };
    if node == 0 && axis.is_empty() {
        return name;
    }
    format!("{name} {node}{sign}{axis}").trim().to_owned()
}

/// What the first line says of a binary dataset; `None` for text.
fn binary(context: &FileContext, first: &[u8], line: usize) -> Result<Option<Binary>, FormatError> {
    if !first.get(6).is_some_and(|b| b.eq_ignore_ascii_case(&b'b')) {
        return Ok(None);
    }
    let rest = text(first.get(7..).unwrap_or_default());
    let fields = numbers(&rest, &[6, 6, 12, 12])
        .ok_or_else(|| context.malformed_line(line, "the line of dataset 58b is not valid"))?;
    let [order, format, _, bytes] = fields.as_slice() else {
        return Err(context.malformed_line(line, "the line of dataset 58b is not valid"));
    };
    if *format != 2.0 {
        return Err(context.unsupported(
            "its numbers are in a format of VAX or IBM machines, not IEEE 754",
            "export the functions as text (dataset 58, ASCII)",
        ));
    }
    let order = if *order == 1.0 {
        ByteOrder::Little
    } else {
        ByteOrder::Big
    };
    Ok(Some(Binary {
        order,
        bytes: (*bytes > 0.0 && *bytes < 1e15).then_some(*bytes as usize),
    }))
}
