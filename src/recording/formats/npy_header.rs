//! The header of an `.npy` array: a Python dictionary with the type, the order and the shape.

use super::bytes::{ByteOrder, NumberType};

/// Deepest nesting of brackets. A structured type with arrays in it has four.
const MAX_NESTING: usize = 16;
/// Most dimensions of an array in a structured type.
const MAX_DIMENSIONS: usize = 8;

/// A header.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    /// Type of an element.
    pub dtype: Dtype,
    /// Whether the first dimension runs fastest.
    pub is_fortran: bool,
    /// Extent of each dimension.
    pub shape: Vec<usize>,
}

/// Type of an element.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Dtype {
    /// Numbers.
    Plain(Plain),
    /// Text, raw bytes and what has no numbers: its code and its bytes.
    Other { code: String, size: usize },
    /// Python objects, pickled.
    Objects,
    /// So many of a type.
    Array(usize, Box<Dtype>),
    /// Fields with names.
    Record(Vec<(String, Dtype)>),
}

/// A type of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plain {
    /// How one is stored.
    pub number: NumberType,
    /// Order of its bytes.
    pub order: ByteOrder,
    /// Seconds of one unit, for times.
    pub scale: Option<f64>,
    /// Two numbers: real and imaginary part.
    pub is_complex: bool,
}

impl Dtype {
    /// Bytes of an element; `None` if they cannot be told or do not fit a `usize`.
    pub fn size(&self) -> Option<usize> {
        match self {
            Self::Plain(plain) => Some(plain.number.size() * if plain.is_complex { 2 } else { 1 }),
            Self::Other { size, .. } => Some(*size),
            Self::Objects => None,
            Self::Array(count, inner) => inner.size()?.checked_mul(*count),
            Self::Record(fields) => fields
                .iter()
                .try_fold(0_usize, |sum, (_, dtype)| sum.checked_add(dtype.size()?)),
        }
    }

    /// Columns that it makes.
    pub fn columns(&self) -> usize {
        match self {
            Self::Array(count, inner) => inner.columns().saturating_mul(*count),
            Self::Record(fields) => fields
                .iter()
                .fold(0, |sum, (_, dtype)| dtype.columns().saturating_add(sum)),
            _ => 1,
        }
    }

    /// Whether there are Python objects in it.
    pub fn has_objects(&self) -> bool {
        match self {
            Self::Objects => true,
            Self::Array(_, inner) => inner.has_objects(),
            Self::Record(fields) => fields.iter().any(|(_, dtype)| dtype.has_objects()),
            Self::Plain(_) | Self::Other { .. } => false,
        }
    }
}

/// Parses the text of a header; `None` if it is not one.
pub(super) fn parse(text: &str) -> Option<Header> {
    let mut parser = Parser { rest: text };
    let Literal::Dict(entries) = parser.literal(0)? else {
        return None;
    };
    let get = |key: &str| {
        entries
            .iter()
            .find(|(name, _)| name == key)
            .map(|(_, value)| value)
    };
    let Literal::Name(order) = get("fortran_order")? else {
        return None;
    };
    Some(Header {
        dtype: dtype(get("descr")?)?,
        is_fortran: order == "True",
        shape: shape(get("shape")?)?,
    })
}

/// A Python literal, as far as headers have them.
#[derive(Debug, Clone, PartialEq)]
enum Literal {
    Text(String),
    Number(usize),
    /// `True`, `False`, `None`.
    Name(String),
    /// A list or a tuple.
    List(Vec<Literal>),
    Dict(Vec<(String, Literal)>),
}

struct Parser<'a> {
    rest: &'a str,
}

impl Parser<'_> {
    /// Takes `mark` if it comes next.
    fn takes(&mut self, mark: char) -> bool {
        self.rest = self.rest.trim_start();
        let after = self.rest.strip_prefix(mark);
        self.rest = after.unwrap_or(self.rest);
        after.is_some()
    }

    fn literal(&mut self, depth: usize) -> Option<Literal> {
        if depth > MAX_NESTING {
            return None;
        }
        if self.takes('{') {
            let mut entries = Vec::new();
            while !self.takes('}') {
                let Literal::Text(key) = self.literal(depth + 1)? else {
                    return None;
                };
                if !self.takes(':') {
                    return None;
                }
                entries.push((key, self.literal(depth + 1)?));
                self.takes(',');
            }
            return Some(Literal::Dict(entries));
        }
        for (open, close) in [('(', ')'), ('[', ']')] {
            if self.takes(open) {
                let mut items = Vec::new();
                while !self.takes(close) {
                    items.push(self.literal(depth + 1)?);
                    self.takes(',');
                }
                return Some(Literal::List(items));
            }
        }
        for quote in ['\'', '"'] {
            if self.takes(quote) {
                return self.text(quote);
            }
        }
        let end = self.rest.find(|c: char| !c.is_ascii_alphanumeric());
        let (word, after) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = after;
        if word.starts_with(|c: char| c.is_ascii_digit()) {
            // Python 2 wrote long numbers with an L.
            return word.trim_end_matches('L').parse().ok().map(Literal::Number);
        }
        (!word.is_empty()).then(|| Literal::Name(word.to_owned()))
    }

    /// A text up to its closing quote.
    fn text(&mut self, quote: char) -> Option<Literal> {
        let mut text = String::new();
        let mut chars = self.rest.char_indices();
        while let Some((at, c)) = chars.next() {
            match c {
                '\\' => text.push(chars.next()?.1),
                c if c == quote => {
                    self.rest = self.rest.get(at + 1..)?;
                    return Some(Literal::Text(text));
                }
                c => text.push(c),
            }
        }
        None
    }
}

fn shape(literal: &Literal) -> Option<Vec<usize>> {
    let Literal::List(items) = literal else {
        return None;
    };
    let number = |item: &Literal| match item {
        Literal::Number(n) => Some(*n),
        _ => None,
    };
    items.iter().map(number).collect()
}

fn dtype(literal: &Literal) -> Option<Dtype> {
    match literal {
        Literal::Text(code) => plain(code),
        Literal::List(fields) => fields
            .iter()
            .map(field)
            .collect::<Option<_>>()
            .map(Dtype::Record),
        _ => None,
    }
}

/// A field: `(name, type)` or `(name, type, shape)`; the name may be `(title, name)`.
fn field(literal: &Literal) -> Option<(String, Dtype)> {
    let Literal::List(parts) = literal else {
        return None;
    };
    let name = match parts.first()? {
        Literal::Text(name) => name.clone(),
        Literal::List(names) => match names.last()? {
            Literal::Text(name) => name.clone(),
            _ => return None,
        },
        _ => return None,
    };
    let mut dtype = dtype(parts.get(1)?)?;
    if let Some(shape_of) = parts.get(2) {
        let shape = shape(shape_of)?;
        if shape.len() > MAX_DIMENSIONS {
            return None;
        }
        for count in shape.into_iter().rev() {
            dtype = Dtype::Array(count, Box::new(dtype));
        }
    }
    Some((name, dtype))
}

/// A type by its code: `<f8`, `|b1`, `<M8[ms]`.
fn plain(code: &str) -> Option<Dtype> {
    let mut chars = code.chars();
    let order = match chars.next()? {
        '<' | '|' | '=' => ByteOrder::Little,
        '>' => ByteOrder::Big,
        _ => return None,
    };
    let kind = chars.next()?;
    let rest = chars.as_str();
    let digits = rest
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(rest.len());
    let (size, unit) = rest.split_at(digits);
    if kind == 'O' {
        return Some(Dtype::Objects);
    }
    let size: usize = size.parse().ok()?;
    let (mut scale, mut is_complex) = (None, false);
    let number = match kind {
        'b' if size == 1 => Some(NumberType::U8),
        'i' => NumberType::integer(size, true),
        'u' => NumberType::integer(size, false),
        'f' => NumberType::float(size),
        'c' => {
            is_complex = true;
            NumberType::float(size / 2)
        }
        'M' | 'm' => {
            scale = seconds(unit);
            scale.and(NumberType::integer(size, true))
        }
        _ => None,
    };
    // A text has four bytes for each character.
    let bytes = if kind == 'U' {
        size.checked_mul(4)?
    } else {
        size
    };
    Some(number.map_or_else(
        || Dtype::Other {
            code: code.to_owned(),
            size: bytes,
        },
        |number| {
            Dtype::Plain(Plain {
                number,
                order,
                scale,
                is_complex,
            })
        },
    ))
}

/// Seconds of a unit of time such as `[ms]` or `[25us]`; `None` for those of no fixed length.
fn seconds(unit: &str) -> Option<f64> {
    let unit = unit.strip_prefix('[')?.strip_suffix(']')?;
    let name = unit.trim_start_matches(|c: char| c.is_ascii_digit());
    let count = unit.get(..unit.len() - name.len())?;
    let count: f64 = if count.is_empty() {
        1.0
    } else {
        count.parse().ok()?
    };
    let scale = match name {
        "W" => 604_800.0,
        "D" => 86400.0,
        "h" => 3600.0,
        "m" => 60.0,
        "s" => 1.0,
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "ps" => 1e-12,
        "fs" => 1e-15,
        "as" => 1e-18,
        _ => return None,
    };
    Some(count * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_types() {
        let size = |descr: &str| {
            let text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (3L,), }}");
            let header = parse(&text)?;
            assert_eq!(header.shape, [3]);
            header.dtype.size()
        };
        assert_eq!(size("'<f8'"), Some(8));
        assert_eq!(size("'<U5'"), Some(20));
        assert_eq!(size("'<c16'"), Some(16));
        assert_eq!(
            size("[('a', '|S3'), (('t', 'b'), '<i2', (2, 3)), ('', '|V3')]"),
            Some(18)
        );
        assert_eq!(
            size("[('a\\'b', [('x', '>f4'), ('y', '<M8[25us]')])]"),
            Some(12)
        );
        assert_eq!(size("'|O'"), None);
        assert_eq!(size("[('a', '<f8', (4294967296, 4294967296))]"), None);
        assert_eq!(size("'f8'"), None);
        assert_eq!(size(&"[".repeat(99)), None);
    }
}
