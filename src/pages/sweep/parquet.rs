//! `points.parquet`: the table of points with the types of its columns.

use super::Points;
use crate::pages::PageError;
use crate::vary::Scalar;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use std::sync::Arc;

/// What all cells of a column are: numbers, flags, or else texts.
enum Cells {
    Numbers(Vec<f64>),
    Flags(Vec<bool>),
    Texts(Vec<ByteArray>),
}

impl Cells {
    fn of(cells: &[&Scalar]) -> Self {
        let number = |cell: &&Scalar| if let Scalar::Number(number) = cell { Some(*number) } else { None };
        let flag = |cell: &&Scalar| if let Scalar::Flag(flag) = cell { Some(*flag) } else { None };
        let text = |cell: &&Scalar| ByteArray::from(cell.to_string().into_bytes());
        if let Some(numbers) = cells.iter().map(number).collect() {
            return Self::Numbers(numbers);
        }
        cells
            .iter()
            .map(flag)
            .collect::<Option<_>>()
            .map_or_else(|| Self::Texts(cells.iter().map(text).collect()), Self::Flags)
    }

    fn named(&self, name: &str) -> Result<Type, ParquetError> {
        let (physical, logical) = match self {
            Self::Numbers(_) => (Physical::DOUBLE, None),
            Self::Flags(_) => (Physical::BOOLEAN, None),
            Self::Texts(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let column = Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
        column.with_logical_type(logical).build()
    }
}

/// `points.parquet`: numbers are 64-bit floats, and a cell without a value is null.
///
/// # Errors
/// Never for what a sweep holds.
pub fn points_parquet(points: &Points) -> Result<Vec<u8>, PageError> {
    bytes(points).map_err(|error| PageError::Table { file: "points.parquet", error: error.into() })
}

fn bytes(points: &Points) -> Result<Vec<u8>, ParquetError> {
    let there =
        |column: usize| points.rows.iter().map(move |row| row.get(column).and_then(Option::as_ref)).collect::<Vec<_>>();
    let cells = |column: usize| Cells::of(&there(column).into_iter().flatten().collect::<Vec<_>>());
    let columns: Vec<Cells> = (0..points.head.len()).map(cells).collect();
    let fields = columns.iter().zip(&points.head).map(|(cells, name)| cells.named(name).map(Arc::new));
    let schema = Type::group_type_builder("points").with_fields(fields.collect::<Result<_, _>>()?).build()?;
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::default())?;
    let mut group = writer.next_row_group()?;
    for (k, cells) in columns.iter().enumerate() {
        let levels: Vec<i16> = there(k).iter().map(|cell| i16::from(cell.is_some())).collect();
        let Some(mut column) = group.next_column()? else { break };
        match cells {
            Cells::Numbers(values) => write::<DoubleType>(&mut column, values, &levels)?,
            Cells::Flags(values) => write::<BoolType>(&mut column, values, &levels)?,
            Cells::Texts(values) => write::<ByteArrayType>(&mut column, values, &levels)?,
        }
        column.close()?;
    }
    group.close()?;
    writer.into_inner()
}

fn write<T: DataType>(
    column: &mut SerializedColumnWriter,
    values: &[T::T],
    levels: &[i16],
) -> Result<(), ParquetError> {
    column.typed::<T>().write_batch(values, Some(levels), None).map(|_| ())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::record::Field;
    use std::io::Write as _;

    #[test]
    fn a_reader_finds_each_cell_with_its_type_and_nothing_where_there_is_none() {
        let text = |text: &str| Some(Scalar::Text(text.into()));
        let number = |number: f64| Some(Scalar::Number(number));
        let points = Points {
            head: ["row", "status", "led", "force_n"].map(str::to_owned).to_vec(),
            rows: vec![
                vec![number(0.0), text("done"), Some(Scalar::Flag(true)), number(0.1 + 0.2)],
                vec![number(1.0), text("failed"), Some(Scalar::Flag(false)), None],
                vec![number(2.0), None, None, number(-1e-300)],
            ],
        };
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&bytes(&points).unwrap()).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let rows: Vec<Vec<Field>> = reader
            .get_row_iter(None)
            .unwrap()
            .map(|row| row.unwrap().into_columns().into_iter().map(|(_, f)| f).collect())
            .collect();
        let (double, word) = (Field::Double, |text: &str| Field::Str(text.into()));
        assert_eq!(
            rows,
            [
                [double(0.0), word("done"), Field::Bool(true), double(0.1 + 0.2)],
                [double(1.0), word("failed"), Field::Bool(false), Field::Null],
                [double(2.0), Field::Null, Field::Null, double(-1e-300)],
            ]
        );
    }
}
