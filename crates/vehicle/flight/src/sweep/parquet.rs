//! The results as a Parquet file next to the CSV file, for DuckDB, Polars, pandas or Spark.
//!
//! The Parquet file is written from the CSV file when a sweep, or a part of a sweep, is complete; only one group of rows is in memory.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use crate::error::{During, Result, refused};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};
use planesman_text::write_whole;

use super::column::Kind;

/// Number of rows in a group.
const GROUP: usize = 65_536;

impl Kind {
    fn column(self, name: &str) -> Result<TypePtr> {
        let (physical, logical) = match self {
            Self::Whole => (Physical::INT64, None),
            Self::Number => (Physical::DOUBLE, None),
            Self::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let column = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()?;
        Ok(Arc::new(column))
    }
}

/// Writes the rows of `csv` into a file of the same name with the extension `.parquet`; `kinds` are its columns' types.
///
/// # Errors
/// If a file cannot be read or written.
pub(super) fn write(csv: &Path, kinds: &[Kind]) -> Result<()> {
    let path = csv.with_extension("parquet");
    write_whole(&path, |file| write_to(csv, kinds, file))
        .during(|| format!("cannot write '{}'", path.display()))
}

fn write_to(csv: &Path, kinds: &[Kind], file: &mut File) -> Result<()> {
    let mut rows = csv::Reader::from_path(csv)?;
    let columns = rows.headers()?.iter().zip(kinds);
    let columns = columns.map(|(name, kind)| kind.column(name));
    let schema = Type::group_type_builder("case")
        .with_fields(columns.collect::<Result<_>>()?)
        .build()?;
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::default())?;
    let mut records = rows.into_records();
    loop {
        let group = records
            .by_ref()
            .take(GROUP)
            .collect::<Result<Vec<_>, _>>()?;
        if group.is_empty() {
            break;
        }
        let mut of_group = writer.next_row_group()?;
        for (place, kind) in kinds.iter().enumerate() {
            let cell = |row: &csv::StringRecord| row.get(place).unwrap_or_default().to_owned();
            let cells: Vec<String> = group.iter().map(cell).collect();
            let there: Vec<i16> = cells.iter().map(|it| i16::from(!it.is_empty())).collect();
            let full = cells.iter().filter(|it| !it.is_empty());
            let mut column = of_group
                .next_column()?
                .ok_or_else(|| refused!("a row has more cells than the header"))?;
            let levels = Some(there.as_slice());
            match kind {
                Kind::Whole => {
                    let values: Vec<i64> = full.map(|it| it.parse()).collect::<Result<_, _>>()?;
                    column
                        .typed::<Int64Type>()
                        .write_batch(&values, levels, None)?;
                }
                Kind::Number => {
                    let values: Vec<f64> = full.map(|it| it.parse()).collect::<Result<_, _>>()?;
                    column
                        .typed::<DoubleType>()
                        .write_batch(&values, levels, None)?;
                }
                Kind::Text => {
                    let values: Vec<ByteArray> = full.map(|it| it.as_str().into()).collect();
                    column
                        .typed::<ByteArrayType>()
                        .write_batch(&values, levels, None)?;
                }
            }
            column.close()?;
        }
        of_group.close()?;
    }
    writer.close()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::record::RowAccessor as _;

    #[test]
    fn every_cell_is_read_back_and_an_empty_one_is_null() {
        let folder = tempfile::tempdir().expect("a folder");
        let csv = folder.path().join("cases.csv");
        let rows = "case,gain [rad/m],model,error\n0,0.1,dha,\n1,0.2,ideal,broke off\n2,,dha,\n";
        std::fs::write(&csv, rows).expect("written");
        write(&csv, &[Kind::Whole, Kind::Number, Kind::Text, Kind::Text]).expect("written");
        let file = File::open(folder.path().join("cases.parquet")).expect("there");
        let reader = SerializedFileReader::new(file).expect("Parquet");
        let rows: Vec<_> = reader
            .get_row_iter(None)
            .expect("rows")
            .map(|it| it.expect("a row"))
            .collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[1].get_long(0).expect("whole"), 1);
        assert_eq!(rows[1].get_double(1).expect("a number"), 0.2);
        assert!(rows[2].get_double(1).is_err());
        assert_eq!(rows[1].get_string(2).expect("text"), "ideal");
        assert_eq!(rows[1].get_string(3).expect("text"), "broke off");
    }
}
