//! A matrix in a file: its numbers of rows and columns, and its values column by column.

use nalgebra::DMatrix;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Writes a matrix.
///
/// # Errors
/// Those of the writer.
pub(super) fn serialize<S: Serializer>(
    matrix: &DMatrix<f64>,
    writer: S,
) -> Result<S::Ok, S::Error> {
    (matrix.nrows(), matrix.ncols(), matrix.as_slice()).serialize(writer)
}

/// Reads a matrix.
///
/// # Errors
/// Those of the reader, and a number of values that is not rows times columns.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(reader: D) -> Result<DMatrix<f64>, D::Error> {
    let (rows, columns, values) = <(usize, usize, Vec<f64>)>::deserialize(reader)?;
    if rows.checked_mul(columns) != Some(values.len()) {
        return Err(D::Error::custom("a matrix has another number of values"));
    }
    Ok(DMatrix::from_vec(rows, columns, values))
}
