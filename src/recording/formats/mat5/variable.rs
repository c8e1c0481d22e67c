//! A variable: an array of numbers, or one of arrays.

use super::super::arrays::{ArrayLabel, Arrays};
use super::super::bytes::{ByteOrder, Cursor, Layout, decode, text};
use super::super::matrix::Matrix;
use super::element::{Element, MATRIX, next_element};

/// Deepest nesting of structures and cells that is followed.
const MAX_DEPTH: usize = 16;
/// Most characters of a text that a note shows.
const MAX_TEXT_CHARS: usize = 60;
/// Bit of the flags of an array: it has an imaginary part.
const IS_COMPLEX: u32 = 0x0800;

/// Adds a variable to `arrays`; `None` if its bytes are not as they should be.
pub(super) fn read_variable(bytes: &[u8], order: ByteOrder, arrays: &mut Arrays) -> Option<()> {
    let mut reader = Reader { order, arrays };
    let variable = Variable::read(bytes, order)?;
    let name = variable.name.clone();
    reader.add(&variable, "", &name, 0)
}

/// A variable before its data are looked at.
struct Variable<'a> {
    class: u32,
    is_complex: bool,
    shape: Vec<usize>,
    name: String,
    /// Its data.
    rest: Cursor<'a>,
}

impl<'a> Variable<'a> {
    fn read(bytes: &'a [u8], order: ByteOrder) -> Option<Self> {
        let mut rest = Cursor::new(bytes, order);
        let flags = next_element(&mut rest)?;
        let flags = Cursor::new(flags.bytes, order).u32()?;
        let class = flags & 0xff;
        if class == 17 {
            // Opaque objects (tables, strings) have another layout: a name comes first.
            let name = next_element(&mut rest).map_or_else(String::new, |name| text(name.bytes));
            return Some(Self {
                class,
                is_complex: false,
                shape: Vec::new(),
                name,
                rest,
            });
        }
        let shape = next_element(&mut rest)?;
        let shape = integers(&shape, order)?
            .into_iter()
            .map(|n| usize::try_from(n).ok())
            .collect::<Option<Vec<_>>>()?;
        let name = text(next_element(&mut rest)?.bytes);
        Some(Self {
            class,
            is_complex: flags & IS_COMPLEX != 0,
            shape,
            name,
            rest,
        })
    }

    /// Number of its elements.
    fn count(&self) -> Option<usize> {
        self.shape
            .iter()
            .try_fold(1_usize, |product, n| product.checked_mul(*n))
    }
}

/// Whole numbers of an element.
fn integers(element: &Element, order: ByteOrder) -> Option<Vec<i64>> {
    let number = element.number()?;
    let layout = Layout {
        number,
        order,
        offset: 0,
        stride: number.size(),
        count: element.bytes.len() / number.size(),
    };
    let values = decode(element.bytes, &layout)?;
    Some(values.into_iter().map(|v| v as i64).collect())
}

struct Reader<'a> {
    order: ByteOrder,
    arrays: &'a mut Arrays,
}

impl Reader<'_> {
    /// Adds a variable, or what is in it, as `name` in the folder `parent`.
    fn add(&mut self, variable: &Variable, parent: &str, name: &str, depth: usize) -> Option<()> {
        let label = ArrayLabel {
            parent: parent.to_owned(),
            name: name.to_owned(),
            ..ArrayLabel::default()
        };
        let kind = match variable.class {
            1 => return self.add_cell(variable, &label, depth),
            2 => return self.add_structure(variable, &label, depth),
            6..=15 => return self.add_numbers(variable, &label),
            4 => {
                let shown = self.text(variable);
                self.arrays
                    .left_out
                    .push(format!("{} (text \"{shown}\")", label.path()));
                return Some(());
            }
            3 => "object",
            5 => "sparse matrix",
            16 => "function",
            17 => "table, string or other object",
            _ => "unknown kind",
        };
        self.arrays
            .left_out
            .push(format!("{} ({kind})", label.path()));
        Some(())
    }

    fn add_numbers(&mut self, variable: &Variable, label: &ArrayLabel) -> Option<()> {
        let mut rest = variable.rest;
        let parts: &[&str] = if variable.is_complex {
            self.arrays.notes.push(format!(
                "\"{}\" is complex; its real and imaginary parts became two columns.",
                label.path()
            ));
            &[".re", ".im"]
        } else {
            &[""]
        };
        for suffix in parts {
            let element = next_element(&mut rest)?;
            let number = element.number()?;
            let content = Matrix {
                bytes: element.bytes,
                number,
                order: self.order,
                offset: 0,
                element: number.size(),
                shape: &variable.shape,
                column_major: true,
            }
            .read();
            let label = ArrayLabel {
                name: format!("{}{suffix}", label.name),
                ..label.clone()
            };
            if !self.arrays.add(&label, content) {
                return None;
            }
        }
        Some(())
    }

    /// The variables in a cell array: `c{1}`, `c{2}`, ...
    fn add_cell(&mut self, variable: &Variable, label: &ArrayLabel, depth: usize) -> Option<()> {
        if depth >= MAX_DEPTH {
            self.arrays
                .left_out
                .push(format!("{} (nested too deep)", label.path()));
            return Some(());
        }
        let mut rest = variable.rest;
        for index in 0..variable.count()? {
            let element = next_element(&mut rest)?;
            let name = format!("{}{{{}}}", label.name, index + 1);
            self.add_inner(&element, &label.parent, &name, depth)?;
        }
        Some(())
    }

    /// The fields of a structure, in a folder of its name; `s(2)` for the second of several.
    fn add_structure(
        &mut self,
        variable: &Variable,
        label: &ArrayLabel,
        depth: usize,
    ) -> Option<()> {
        if depth >= MAX_DEPTH {
            self.arrays
                .left_out
                .push(format!("{} (nested too deep)", label.path()));
            return Some(());
        }
        let mut rest = variable.rest;
        let length = integers(&next_element(&mut rest)?, self.order)?;
        let length = usize::try_from(*length.first()?).ok().filter(|n| *n > 0)?;
        let names = next_element(&mut rest)?;
        let fields: Vec<String> = names
            .bytes
            .chunks(length)
            .map(|name| text(name.split(|b| *b == 0).next().unwrap_or_default()))
            .collect();
        let count = variable.count()?;
        if fields.is_empty() {
            return Some(());
        }
        for index in 0..count {
            let folder = if count == 1 {
                label.path()
            } else {
                format!("{}({})", label.path(), index + 1)
            };
            for field in &fields {
                let element = next_element(&mut rest)?;
                self.add_inner(&element, &folder, field, depth)?;
            }
        }
        Some(())
    }

    fn add_inner(
        &mut self,
        element: &Element,
        parent: &str,
        name: &str,
        depth: usize,
    ) -> Option<()> {
        if element.kind != MATRIX {
            return None;
        }
        // An empty array may be stored without anything in it.
        if element.bytes.is_empty() {
            return Some(());
        }
        let variable = Variable::read(element.bytes, self.order)?;
        self.add(&variable, parent, name, depth + 1)
    }

    /// The text of a variable, as a note shows it.
    fn text(&self, variable: &Variable) -> String {
        let mut rest = variable.rest;
        let Some(element) = next_element(&mut rest) else {
            return String::new();
        };
        let codes = integers(&element, self.order).unwrap_or_default();
        codes
            .iter()
            .take(MAX_TEXT_CHARS)
            .filter_map(|code| char::from_u32(u32::try_from(*code).ok()?))
            .collect()
    }
}
