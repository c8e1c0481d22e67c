//! HDF5 and MATLAB's MAT files of version 7.3, by `hdf5-reader`: each dataset of numbers is one or
//! several columns, in the group it lies in.
//!
//! Attributes that name a unit, a sampling rate or an interval are used.

use hdf5_reader::error::Error;
use hdf5_reader::filters::FilterFn;
use hdf5_reader::group::Group;
use hdf5_reader::messages::datatype::Datatype;
use hdf5_reader::{Attribute, Dataset, FilterRegistry, Hdf5File, OpenOptions};

use super::arrays::{ArrayLabel, Arrays, joined, stem};
use super::bytes::{ByteOrder, NumberType};
use super::error::{FileContext, FormatError};
use super::format::{Format, FormatContent};
use super::hdf5_attributes::Attributes;
use super::hdf5_lzf::{LZF, unpack};
use super::matrix::Matrix;
use super::unpack::{MAX_DEFLATE_RATIO, MAX_UNPACKED_BYTES};

/// Reads `.h5` files and `.mat` files of version 7.3.
#[derive(Debug)]
pub struct Hdf5;

const NAME: &str = "HDF5";
/// First bytes of the format.
const MAGIC: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Where they may stand: at 0, or after a user block of 512 bytes or a multiple by 2^n.
const MAGIC_OFFSETS: [usize; 4] = [0, 512, 1024, 2048];
/// Deepest nesting of groups that is followed; links may go in circles.
const MAX_DEPTH: usize = 12;
/// Most datasets that are looked at.
const MAX_DATASETS: usize = 20_000;
/// Largest chunk that is unpacked \[bytes\]; writers make chunks of some MB.
const MAX_CHUNK_BYTES: usize = 256 << 20;

impl Format for Hdf5 {
    fn id(&self) -> &'static str {
        "hdf5"
    }

    fn name(&self) -> &'static str {
        NAME
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["h5", "hdf5", "hdf", "he5", "mat"]
    }

    fn recognises(&self, head: &[u8], _file_name: &str) -> bool {
        let at = |offset: &usize| {
            head.get(*offset..)
                .is_some_and(|rest| rest.starts_with(MAGIC))
        };
        MAGIC_OFFSETS.iter().any(at)
    }

    fn read(&self, file: &str, bytes: &[u8]) -> Result<FormatContent, FormatError> {
        let context = FileContext { file, format: NAME };
        let possible = (bytes.len() as u64).saturating_mul(MAX_DEFLATE_RATIO);
        let limit = possible.min(MAX_UNPACKED_BYTES);
        let options = OpenOptions::default()
            .with_max_chunk_bytes(MAX_CHUNK_BYTES)
            .with_max_read_bytes(usize::try_from(limit).unwrap_or(usize::MAX))
            .with_filter_registry(filters())
            // Each dataset is read once.
            .with_chunk_cache_bytes(0);
        let file = Hdf5File::from_bytes_with_options(bytes, options)
            .map_err(|error| context.unreadable(error))?;
        let root = file
            .root_group()
            .map_err(|error| context.unreadable(error))?;
        let mut reader = Reader {
            arrays: Arrays::default(),
            datasets: 0,
            limit,
        };
        reader.group(&root, "", &Attributes::default(), 0, &context)?;
        let tables = reader.arrays.into_tables(&context, &stem(context.file))?;
        Ok(FormatContent::Tables(tables))
    }
}

/// The filters of `hdf5-reader`, and LZF.
fn filters() -> FilterRegistry {
    let mut filters = FilterRegistry::new();
    let lzf: FilterFn = Box::new(|_, bytes, _| {
        unpack(bytes).ok_or_else(|| Error::InvalidData("LZF data of a chunk".to_owned()))
    });
    filters.register(LZF, lzf);
    filters
}

struct Reader {
    arrays: Arrays,
    datasets: usize,
    /// Bytes that may still be unpacked.
    limit: u64,
}

impl Reader {
    /// Goes through a group; `above` are the attributes of those it lies in.
    fn group(
        &mut self,
        group: &Group,
        path: &str,
        above: &Attributes,
        depth: usize,
        context: &FileContext,
    ) -> Result<(), FormatError> {
        let attributes = self
            .attributes(group.attributes().unwrap_or_default(), path)
            .over(above);
        let (groups, mut datasets) = match group.members() {
            Ok(members) => members,
            Err(error) if path.is_empty() => return Err(context.unreadable(error)),
            Err(error) => {
                self.arrays.left_out.push(format!("{path} ({error})"));
                return Ok(());
            }
        };
        datasets.sort_by(|a, b| a.name().cmp(b.name()));
        for dataset in &datasets {
            self.datasets += 1;
            if self.datasets > MAX_DATASETS {
                return Err(context.unsupported(
                    format!("it has more than {MAX_DATASETS} datasets"),
                    "save the signals of the recording alone",
                ));
            }
            self.dataset(dataset, path, &attributes);
        }
        for inner in &groups {
            // Where MATLAB keeps what cells refer to.
            let name = inner.name();
            if path.is_empty() && name.starts_with('#') {
                self.arrays
                    .left_out
                    .push(format!("{name} (contents of cells)"));
                continue;
            }
            let inner_path = joined(path, name);
            if depth >= MAX_DEPTH {
                self.arrays
                    .left_out
                    .push(format!("{inner_path} (nested too deep)"));
                continue;
            }
            self.group(inner, &inner_path, &attributes, depth + 1, context)?;
        }
        Ok(())
    }

    fn attributes(&mut self, list: Vec<Attribute>, path: &str) -> Attributes {
        Attributes::of(&list, path, &mut self.arrays.scalars)
    }

    /// Adds a dataset; what cannot be read is named with the reason.
    fn dataset(&mut self, dataset: &Dataset, parent: &str, above: &Attributes) {
        let path = joined(parent, dataset.name());
        let attributes = Attributes::of(&dataset.attributes(), &path, &mut Vec::new());
        if let Some(class) = attributes.matlab_class.as_deref()
            && (class == "char" || class == "cell" || attributes.is_matlab_empty)
        {
            self.arrays.left_out.push(format!("{path} ({class})"));
            return;
        }
        let label = ArrayLabel {
            parent: parent.to_owned(),
            name: dataset.name().to_owned(),
            unit: attributes.unit.clone(),
            clock: attributes.clock().or_else(|| above.clock()),
            columns: attributes.columns.clone(),
        };
        if let Err(reason) = self.read_dataset(dataset, &label) {
            self.arrays.left_out.push(format!("{path} ({reason})"));
        }
    }

    fn read_dataset(&mut self, dataset: &Dataset, label: &ArrayLabel) -> Result<(), String> {
        let numbers = Number::all(dataset.dtype());
        if numbers.is_empty() {
            return Err(kind(dataset.dtype()).to_owned());
        }
        let shape: Option<Vec<usize>> = dataset
            .shape()
            .iter()
            .map(|n| usize::try_from(*n).ok())
            .collect();
        let shape = shape.ok_or("too large")?;
        let element = dataset
            .raw_element_size()
            .map_err(|error| error.to_string())?;
        let size = dataset.raw_byte_len().map_err(|error| error.to_string())? as u64;
        if size > self.limit {
            return Err("larger than its bytes can hold".to_owned());
        }
        self.limit -= size;
        let bytes = dataset
            .read_raw_bytes()
            .map_err(|error| error.to_string())?;
        for number in &numbers {
            let content = Matrix {
                bytes: &bytes,
                number: number.number,
                order: number.order,
                offset: number.offset,
                element,
                shape: &shape,
                column_major: false,
            }
            .read();
            let label = if number.name.is_empty() {
                label.clone()
            } else {
                ArrayLabel {
                    name: number.name.clone(),
                    unit: None,
                    columns: Vec::new(),
                    ..label.clone()
                }
            };
            if !self.arrays.add(&label, content) {
                return Err("shorter than its shape".to_owned());
            }
        }
        Ok(())
    }
}

/// A number in each element of a dataset.
struct Number {
    /// Field of a compound type, else empty.
    name: String,
    number: NumberType,
    order: ByteOrder,
    offset: usize,
}

impl Number {
    /// The numbers of a type: itself, or the fields of a compound one.
    fn all(dtype: &Datatype) -> Vec<Self> {
        if let Datatype::Compound { fields, .. } = dtype {
            return fields
                .iter()
                .filter_map(|field| {
                    let (number, order) = plain(&field.datatype)?;
                    Some(Self {
                        name: field.name.clone(),
                        number,
                        order,
                        offset: usize::try_from(field.byte_offset).ok()?,
                    })
                })
                .collect();
        }
        plain(dtype)
            .map(|(number, order)| Self {
                name: String::new(),
                number,
                order,
                offset: 0,
            })
            .into_iter()
            .collect()
    }
}

/// How a type stores a number; `None` for others.
fn plain(dtype: &Datatype) -> Option<(NumberType, ByteOrder)> {
    let order = |order: hdf5_reader::ByteOrder| match order {
        hdf5_reader::ByteOrder::LittleEndian => ByteOrder::Little,
        hdf5_reader::ByteOrder::BigEndian => ByteOrder::Big,
    };
    match dtype {
        Datatype::FixedPoint {
            size,
            signed,
            byte_order,
        } => Some((
            NumberType::integer(usize::from(*size), *signed)?,
            order(*byte_order),
        )),
        Datatype::FloatingPoint { size, byte_order } => {
            Some((NumberType::float(usize::from(*size))?, order(*byte_order)))
        }
        // NumPy's bool is an enumeration of a small integer.
        Datatype::Enum { base, .. } => plain(base),
        _ => None,
    }
}

/// What a type without numbers is.
fn kind(dtype: &Datatype) -> &'static str {
    match dtype {
        Datatype::String { .. } | Datatype::VarLen { .. } => "text",
        Datatype::Reference { .. } => "references",
        Datatype::Compound { .. } => "records without numbers",
        _ => "no numbers",
    }
}
