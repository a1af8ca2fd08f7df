//! The rows of a Parquet file in blocks: of each column, one page is unpacked at a time.

use std::path::Path;

use parquet::basic::Type as Physical;
use parquet::file::reader::FileReader as _;
use parquet::file::statistics::Statistics;
use piezotact::recording::StartTime;

use super::{Cells, Reader, damaged, gaps_in, name_of, require_places};
use crate::error::ReadError;

impl Reader {
    /// The rows of the file.
    pub(crate) fn count(&self) -> usize {
        let rows = self.inner.metadata().file_metadata().num_rows();
        usize::try_from(rows).unwrap_or(0)
    }

    /// Whether all columns are floats, as this program writes them.
    pub(crate) fn holds_floats(&self) -> bool {
        let mut columns = self.descriptors().iter();
        columns.all(|column| column.physical_type() == Physical::DOUBLE)
    }

    /// The columns of moments; `None` where a column holds text, which only all of it shows to be numbers.
    pub(crate) fn moments(&self, path: &Path) -> Result<Option<Vec<usize>>, ReadError> {
        let cells = self.cells(path)?;
        if cells.iter().any(Cells::is_text) {
            return Ok(None);
        }
        let cells = cells.iter().enumerate();
        let moments = cells.filter(|(_, cells)| matches!(cells, Cells::Moments(_)));
        Ok(Some(moments.map(|(number, _)| number).collect()))
    }

    /// The first moment of a column, where its day is known.
    pub(crate) fn first_moment(
        &self,
        path: &Path,
        column: usize,
    ) -> Result<Option<StartTime>, ReadError> {
        let mut cells = self.cells(path)?.swap_remove(column);
        if let Some(group) = self.groups().first() {
            let failed = |error| damaged(path, &error);
            require_places(group).map_err(failed)?;
            let mut rows = self.rows_of(group, column).map_err(failed)?;
            rows(1, &mut cells, &mut Vec::new()).map_err(failed)?;
        }
        Ok(cells.start().flatten())
    }

    /// Whether the file states that no number of the column is beyond ±`limit`.
    pub(crate) fn states_within(&self, column: usize, limit: f64) -> bool {
        let within = |low: f64, high: f64| low >= -limit && high <= limit;
        self.groups().iter().all(|group| {
            let chunk = group.columns().get(column);
            match chunk.and_then(|chunk| chunk.statistics()) {
                Some(Statistics::Double(of)) => {
                    (of.min_opt().zip(of.max_opt())).is_some_and(|(a, b)| within(*a, *b))
                }
                Some(Statistics::Float(of)) => (of.min_opt().zip(of.max_opt()))
                    .is_some_and(|(a, b)| within(f64::from(*a), f64::from(*b))),
                _ => false,
            }
        })
    }

    /// Gives the numbers of the `columns` to `take` in blocks of `block` rows, of which the last may be shorter.
    pub(crate) fn each_block<E: From<ReadError>>(
        &self,
        path: &Path,
        columns: &[usize],
        block: usize,
        take: &mut dyn FnMut(Vec<Vec<f64>>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut cells = self.cells(path)?;
        let mut held = vec![Vec::new(); columns.len()];
        for group in self.groups() {
            let failed = |error| E::from(damaged(path, &error));
            require_places(group).map_err(failed)?;
            let readers = columns.iter().map(|column| self.rows_of(group, *column));
            let mut readers = readers.collect::<Result<Vec<_>, _>>().map_err(failed)?;
            let mut left = usize::try_from(group.num_rows()).unwrap_or(0);
            while left > 0 {
                let wanted = left.min(block - held.first().map_or(0, Vec::len));
                for ((numbers, reader), column) in held.iter_mut().zip(&mut readers).zip(columns) {
                    let full = numbers.len() + wanted;
                    while numbers.len() < full {
                        let most = full - numbers.len();
                        let (rows, gaps) =
                            reader(most, &mut cells[*column], numbers).map_err(failed)?;
                        if gaps > 0 {
                            let name = name_of(&self.descriptors()[*column]);
                            return Err(gaps_in(path, &name).into());
                        }
                        if rows == 0 {
                            let text = "a column that ends before its group";
                            return Err(damaged(path, &text).into());
                        }
                    }
                }
                left -= wanted;
                if held.first().is_some_and(|numbers| numbers.len() == block) {
                    let next = held.iter().map(|_| Vec::with_capacity(block)).collect();
                    take(std::mem::replace(&mut held, next))?;
                }
            }
        }
        match held.first().is_some_and(|numbers| !numbers.is_empty()) {
            true => take(held),
            false => Ok(()),
        }
    }
}
