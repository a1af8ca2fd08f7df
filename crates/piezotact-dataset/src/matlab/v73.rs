//! MATLAB 7.3: HDF5 in which attributes name the classes. Cells and arrays of structures are references to objects of a hidden group.
//!
//! Source of the layout: files of MATLAB, as `matio` (BSD) and `mat73` (MIT) read them. HDF5 itself is read by `hdf5-pure`. What a
//! file claims is checked before it is read: the number of elements times their size, and the number of values.

use std::collections::HashMap;

use hdf5_pure::{AttrValue, CompoundField, DType, Dataset, Datatype, File, Group, Object};

use super::v5::{DEEPEST, MOST_OF_ONE_BYTE};
use super::{
    LARGEST, MOST_NUMBERS, MatFile, MatNumbers, MatValue, MatVariable, NumberClass, Source, count,
    is_exact, rows_of_text, sparse_entries,
};
use crate::error::ReadError;

type Attributes = HashMap<String, AttrValue>;

pub(super) fn read(source: &Source<'_>, bytes: &[u8]) -> Result<MatFile, ReadError> {
    let mut reader = Reader {
        source,
        largest: bytes
            .len()
            .saturating_mul(MOST_OF_ONE_BYTE)
            .saturating_add(1 << 16)
            .min(LARGEST),
        unpacked: 0,
        // A reference takes 8 bytes.
        values_left: bytes.len() / 8,
    };
    let file = File::from_bytes(bytes.to_vec()).map_err(|error| reader.damaged(error))?;
    let members = reader.members(&file.root())?;
    let mut variables = Vec::new();
    for (name, member) in members {
        // `#refs#` and `#subsystem#`: what the variables refer to.
        if !name.starts_with('#') {
            let value = reader.object(&member, 0)?;
            variables.push(MatVariable { name, value });
        }
    }
    Ok(MatFile { variables })
}

struct Reader<'s> {
    source: &'s Source<'s>,
    /// More bytes than this one array cannot have.
    largest: usize,
    /// Bytes read so far.
    unpacked: usize,
    values_left: usize,
}

impl Reader<'_> {
    fn wrong(&self, expected: impl Into<String>, found: impl Into<String>) -> ReadError {
        self.source.wrong(expected, found)
    }

    fn damaged(&self, error: impl std::fmt::Display) -> ReadError {
        self.wrong("a MATLAB file of version 7.3 (HDF5)", error.to_string())
    }

    /// What a group holds, in the order of the names.
    fn members(&self, group: &Group) -> Result<Vec<(String, Object)>, ReadError> {
        let damaged = |error| self.damaged(error);
        let datasets = group.iter_datasets().map_err(damaged)?;
        let groups = group.iter_groups().map_err(damaged)?;
        let mut members: Vec<(String, Object)> = datasets
            .map(|(name, dataset)| (name, Object::Dataset(Box::new(dataset))))
            .chain(groups.map(|(name, group)| (name, Object::Group(group))))
            .collect();
        members.sort_by(|(a, _), (b, _)| a.cmp(b));
        Ok(members)
    }

    fn object(&mut self, object: &Object, depth: usize) -> Result<MatValue, ReadError> {
        if depth > DEEPEST {
            return Err(self.wrong(format!("at most {DEEPEST} arrays within another"), "more"));
        }
        self.values_left = self.values_left.checked_sub(1).ok_or_else(|| {
            self.wrong(
                "values that the file has room for",
                "more references to them",
            )
        })?;
        match object {
            Object::Group(group) => self.group(group, depth),
            Object::Dataset(dataset) => self.dataset(dataset, depth),
            _ => Ok(MatValue::Unreadable("an object of HDF5".into())),
        }
    }

    fn dataset(&mut self, dataset: &Dataset, depth: usize) -> Result<MatValue, ReadError> {
        let attributes = dataset.attrs().map_err(|error| self.damaged(error))?;
        let class = text(&attributes, "MATLAB_class");
        if attributes.contains_key("MATLAB_object_decode") {
            return Ok(MatValue::Object(class.map(str::to_owned)));
        }
        let dims = self.claim(dataset)?;
        if number(&attributes, "MATLAB_empty").is_some_and(|empty| empty != 0) {
            return self.empty(dataset, class);
        }
        let dtype = dataset.dtype().map_err(|error| self.damaged(error))?;
        let class = match &dtype {
            DType::ObjectReference => {
                let values = self.referred(dataset, depth)?;
                return Ok(MatValue::Cell { dims, values });
            }
            DType::String | DType::VariableLengthString => return self.strings(dataset, &dtype),
            DType::Compound(_) => return self.complex(dataset, class, dims),
            _ if class == Some("char") => {
                let units = dataset.read_u16().map_err(|error| self.damaged(error))?;
                return Ok(MatValue::Text(rows_of_text(&dims, &units)));
            }
            _ if class == Some("logical") => NumberClass::Logical,
            DType::F64 => NumberClass::Double,
            DType::F32 => NumberClass::Single,
            DType::I8 => NumberClass::Int(8),
            DType::I16 => NumberClass::Int(16),
            DType::I32 => NumberClass::Int(32),
            DType::I64 => NumberClass::Int(64),
            DType::U8 => NumberClass::Uint(8),
            DType::U16 => NumberClass::Uint(16),
            DType::U32 => NumberClass::Uint(32),
            DType::U64 => NumberClass::Uint(64),
            other => return Ok(MatValue::Unreadable(format!("data of type {other}"))),
        };
        let real = dataset.read_f64().map_err(|error| self.damaged(error))?;
        if Some(real.len()) != count(&dims) {
            return Err(self.wrong(format!("{dims:?} numbers"), format!("{}", real.len())));
        }
        let whole = matches!(class, NumberClass::Int(64) | NumberClass::Uint(64));
        Ok(MatValue::Numbers(MatNumbers {
            dims,
            class,
            exact: !whole || is_exact(&real),
            real,
            imaginary: None,
        }))
    }

    /// The dimensions as MATLAB has them, of data that are about to be read: HDF5 names the slowest first.
    fn claim(&mut self, dataset: &Dataset) -> Result<Vec<usize>, ReadError> {
        let shape = dataset.shape().map_err(|error| self.damaged(error))?;
        let size = dataset
            .element_size()
            .map_err(|error| self.damaged(error))?;
        let mut dims: Vec<usize> = (shape.iter().rev())
            .map(|length| usize::try_from(*length).unwrap_or(usize::MAX))
            .collect();
        let elements = count(&dims).filter(|elements| *elements <= MOST_NUMBERS);
        let bytes = elements
            .and_then(|elements| elements.checked_mul(usize::try_from(size).ok()?))
            .filter(|bytes| *bytes <= self.largest);
        self.unpacked = self.unpacked.saturating_add(bytes.unwrap_or(LARGEST));
        if bytes.is_none() || self.unpacked > LARGEST {
            return Err(self.wrong(
                format!("arrays of at most {} bytes", self.largest),
                format!("{dims:?} elements of {size} bytes: cut the recording into parts"),
            ));
        }
        dims.resize(dims.len().max(2), 1);
        Ok(dims)
    }

    /// An array without elements, or a structure without fields, whose data are its dimensions.
    fn empty(&self, dataset: &Dataset, class: Option<&str>) -> Result<MatValue, ReadError> {
        let dims = dataset.read_u64().map_err(|error| self.damaged(error))?;
        let mut dims: Vec<usize> = (dims.iter().take(32))
            .map(|length| usize::try_from(*length).unwrap_or(usize::MAX))
            .collect();
        dims.resize(dims.len().max(2), 0);
        if count(&dims) != Some(0) && class != Some("struct") {
            return Err(self.wrong("an array without elements", format!("{dims:?} of them")));
        }
        let attributes = dataset.attrs().map_err(|error| self.damaged(error))?;
        Ok(match class {
            Some("char") => MatValue::Text(Vec::new()),
            Some("cell") => MatValue::Cell {
                dims,
                values: Vec::new(),
            },
            Some("struct") => MatValue::Struct {
                dims,
                class: None,
                fields: fields(&attributes).unwrap_or_default(),
                values: Vec::new(),
            },
            class => MatValue::Numbers(MatNumbers {
                dims,
                class: class_of(class),
                real: Vec::new(),
                imaginary: None,
                exact: true,
            }),
        })
    }

    fn referred(&mut self, dataset: &Dataset, depth: usize) -> Result<Vec<MatValue>, ReadError> {
        let objects = dataset.dereference().map_err(|error| self.damaged(error))?;
        let each = objects.iter().map(|object| self.object(object, depth + 1));
        each.collect()
    }

    fn strings(&mut self, dataset: &Dataset, dtype: &DType) -> Result<MatValue, ReadError> {
        if *dtype == DType::VariableLengthString {
            let bytes = dataset.vlen_string_payload_size();
            let bytes = bytes.map_err(|error| self.damaged(error))?;
            self.unpacked = self.unpacked.saturating_add(bytes as usize);
            if self.unpacked > LARGEST {
                return Err(self.wrong("texts that fit into memory", format!("{bytes} bytes")));
            }
        }
        let rows = dataset.read_string().map_err(|error| self.damaged(error))?;
        Ok(MatValue::Text(rows))
    }

    /// Pairs of `real` and `imag`.
    fn complex(
        &self,
        dataset: &Dataset,
        class: Option<&str>,
        dims: Vec<usize>,
    ) -> Result<MatValue, ReadError> {
        let datatype = dataset.datatype().map_err(|error| self.damaged(error))?;
        let bytes = dataset.read_raw().map_err(|error| self.damaged(error))?;
        let part = |name: &str| {
            let Datatype::Compound { size, members } = &datatype else {
                return None;
            };
            let member = members.iter().find(|member| member.name == name)?;
            let from = usize::try_from(member.byte_offset).ok()?;
            let to = from.checked_add(member.datatype.type_size() as usize)?;
            let pairs = bytes.chunks_exact((*size as usize).max(1));
            let values = pairs.map(|pair| number_of(&member.datatype, pair.get(from..to)?));
            values.collect::<Option<Vec<f64>>>()
        };
        let (Some(real), Some(imaginary)) = (part("real"), part("imag")) else {
            return Ok(MatValue::Unreadable("records of several fields".into()));
        };
        if Some(real.len()) != count(&dims) {
            return Err(self.wrong(format!("{dims:?} numbers"), format!("{}", real.len())));
        }
        Ok(MatValue::Numbers(MatNumbers {
            dims,
            class: class_of(class),
            real,
            imaginary: Some(imaginary),
            exact: true,
        }))
    }

    fn group(&mut self, group: &Group, depth: usize) -> Result<MatValue, ReadError> {
        let attributes = group.attrs().map_err(|error| self.damaged(error))?;
        let class = text(&attributes, "MATLAB_class");
        if let Some(rows) = number(&attributes, "MATLAB_sparse") {
            return self.sparse(group, rows);
        }
        match class {
            Some("function_handle") => return Ok(MatValue::Unreadable("a function".into())),
            // Files of others that are HDF5 name no class.
            None | Some("struct") => {}
            class => return Ok(MatValue::Object(class.map(str::to_owned))),
        }
        let mut members = self.members(group)?;
        if let Some(order) = fields(&attributes) {
            let place: HashMap<&str, usize> = order
                .iter()
                .enumerate()
                .map(|(k, name)| (name.as_str(), k))
                .collect();
            members.sort_by_key(|(name, _)| place.get(name.as_str()).copied());
        }
        let mut arrays = Vec::new();
        for (_, member) in &members {
            if let Object::Dataset(dataset) = member
                && dataset
                    .dtype()
                    .is_ok_and(|dtype| dtype == DType::ObjectReference)
                && dataset
                    .attrs()
                    .is_ok_and(|own| !own.contains_key("MATLAB_class"))
            {
                arrays.push(dataset);
            }
        }
        let values = match arrays.first() {
            Some(first) if arrays.len() == members.len() => {
                let dims = self.claim(first)?;
                let mut each = Vec::new();
                for dataset in &arrays {
                    self.claim(dataset)?;
                    each.push(self.referred(dataset, depth)?.into_iter());
                }
                let elements = each[0].len();
                if each.iter().any(|field| field.len() != elements) {
                    return Err(self.wrong(
                        format!("{elements} elements in each field of a structure"),
                        "others",
                    ));
                }
                let values = (0..elements)
                    .flat_map(|_| {
                        each.iter_mut()
                            .filter_map(Iterator::next)
                            .collect::<Vec<_>>()
                    })
                    .collect();
                (dims, values)
            }
            _ => {
                let each = members
                    .iter()
                    .map(|(_, member)| self.object(member, depth + 1));
                (vec![1, 1], each.collect::<Result<_, _>>()?)
            }
        };
        Ok(MatValue::Struct {
            dims: values.0,
            class: None,
            fields: members.into_iter().map(|(name, _)| name).collect(),
            values: values.1,
        })
    }

    /// A sparse matrix: where its columns begin, the rows, and the numbers; the last two are not there where nothing is.
    fn sparse(&mut self, group: &Group, rows: u64) -> Result<MatValue, ReadError> {
        let mut parts = HashMap::new();
        for (name, member) in self.members(group)? {
            if let Object::Dataset(dataset) = member {
                parts.insert(name, self.dataset(&dataset, 0)?);
            }
        }
        let list = |name: &str| match parts.get(name) {
            Some(MatValue::Numbers(numbers)) => numbers.real.as_slice(),
            _ => &[],
        };
        let imaginary = match parts.get("data") {
            Some(MatValue::Numbers(numbers)) => numbers.imaginary.as_deref(),
            _ => None,
        };
        let starts = list("jc");
        let rows = usize::try_from(rows).unwrap_or(usize::MAX);
        let entries = sparse_entries(rows, starts, list("ir"), list("data"), imaginary);
        let (Some(entries), Some(columns)) = (entries, starts.len().checked_sub(1)) else {
            return Err(self.wrong("the rows and columns of a sparse matrix", "others"));
        };
        Ok(MatValue::Sparse {
            rows,
            columns,
            entries,
        })
    }
}

/// A number of at most 53 bits.
fn number_of(datatype: &Datatype, bytes: &[u8]) -> Option<f64> {
    fn of<T: CompoundField + Into<f64>>(datatype: &Datatype, bytes: &[u8]) -> Option<f64> {
        T::decode_field(datatype, bytes).ok().map(T::into)
    }
    [
        of::<f64>, of::<f32>, of::<i8>, of::<u8>, of::<i16>, of::<u16>, of::<i32>, of::<u32>,
    ]
    .iter()
    .find_map(|of| of(datatype, bytes))
}

fn text<'a>(attributes: &'a Attributes, name: &str) -> Option<&'a str> {
    attributes.get(name).and_then(AttrValue::as_str)
}

fn number(attributes: &Attributes, name: &str) -> Option<u64> {
    attributes.get(name).and_then(AttrValue::as_u64)
}

/// The names of fields in the order of MATLAB.
fn fields(attributes: &Attributes) -> Option<Vec<String>> {
    let names = attributes.get("MATLAB_fields")?.as_strings()?;
    Some(names.to_vec())
}

fn class_of(name: Option<&str>) -> NumberClass {
    let bits = |name: &str, kind: &str| name.strip_prefix(kind).and_then(|bits| bits.parse().ok());
    match name {
        Some("single") => NumberClass::Single,
        Some("logical") => NumberClass::Logical,
        Some(name) => bits(name, "int")
            .map(NumberClass::Int)
            .or_else(|| bits(name, "uint").map(NumberClass::Uint))
            .unwrap_or(NumberClass::Double),
        None => NumberClass::Double,
    }
}
