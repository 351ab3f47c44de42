//! Poses of a tool in contact as Parquet: the columns of
//! [`pose_file`](crate::io::manifold::pose_file), of numbers, uncompressed, snappy, gzip or zstd.

use parquet::file::reader::{ChunkReader, FileReader, SerializedFileReader};

use super::pose_row::{COLUMNS, MAX_POSES, columns, pose};
use crate::io::base::bounded_pages::BoundedPages;
use crate::io::base::error::{IoError, Place, caught};
use crate::io::base::number_columns::{NumberColumns, damaged};
use crate::se3::Pose;

/// Reads the poses of a file's content; `file` is its name for messages.
pub(crate) fn read(content: impl ChunkReader + 'static, file: &str) -> Result<Vec<Pose>, IoError> {
    caught(file, "Parquet", || read_groups(content, file))
}

fn read_groups(content: impl ChunkReader + 'static, file: &str) -> Result<Vec<Pose>, IoError> {
    let reader = SerializedFileReader::new(BoundedPages(content)).map_err(|error| damaged(file, &error))?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let names: Vec<&[u8]> = schema.columns().iter().map(|column| column.name().as_bytes()).collect();
    let used = columns(&names, Place::file(file))?;
    let mut poses = Vec::new();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(|error| damaged(file, &error))?;
        let mut numbers = NumberColumns::new(group.as_ref(), used.into_iter().zip(COLUMNS), file)?;
        loop {
            let rows = numbers.advance()?;
            if rows == 0 {
                break;
            }
            if poses.len() + rows > MAX_POSES {
                return Err(IoError::unexpected(Place::file(file), format!("at most {MAX_POSES} poses"), "more"));
            }
            for row in 0..rows {
                let place = Place::file(file).field(format!("row {}", poses.len() + 1));
                let values: [f64; 7] = std::array::from_fn(|k| numbers.value(k, row));
                if let Some(k) = values.iter().position(|value| !value.is_finite()) {
                    let found = format!("{} in column {}", values[k], COLUMNS[k]);
                    return Err(IoError::unexpected(place, "finite numbers", found));
                }
                poses.push(pose(&values, place)?);
            }
        }
    }
    Ok(poses)
}
