//! Reads the fields of a TOML document so that every refusal names file, line, field, what was found and what
//! was expected.

use std::fmt::Display;
use std::ops::Range;

use covbeam_geometry::MAX_COORDINATE;
use covbeam_geometry::mesh::MeshError;
use glam::Vec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use covbeam_session::medium::volume::VolumeError;

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The scene file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// Scene file.
        file: String,
        /// From the operating system.
        source: std::io::Error,
    },
    /// The text is not TOML.
    #[error("{file}:{line}: not valid TOML: {message}")]
    Syntax {
        /// Scene file.
        file: String,
        /// Counted from 1.
        line: usize,
        /// What the parser stumbled on.
        message: String,
    },
    /// A field is missing, unknown, of the wrong kind or out of range.
    #[error("{file}:{line}: {field}: found {found}, expected {expected}")]
    Field {
        /// Scene file.
        file: String,
        /// Counted from 1.
        line: usize,
        /// Path of the field; lists count from 0, as in `object[2].radius`.
        field: String,
        /// The text in the file.
        found: String,
        /// What would be accepted.
        expected: String,
    },
    /// A mesh file is missing or wrong.
    #[error("{file}:{line}: {field}: mesh {mesh}: {source}")]
    Mesh {
        /// Scene file.
        file: String,
        /// Counted from 1.
        line: usize,
        /// Path of the field that names the mesh.
        field: String,
        /// The mesh file.
        mesh: String,
        /// What is wrong with it.
        source: Box<MeshError>,
    },
    /// A volume file is missing or wrong.
    #[error("{file}:{line}: {field}: volume {volume}: {source}")]
    Volume {
        /// Scene file.
        file: String,
        /// Counted from 1.
        line: usize,
        /// Path of the field that names the volume.
        field: String,
        /// The volume file.
        volume: String,
        /// What is wrong with it.
        source: Box<VolumeError>,
    },
}

/// A scene file's name and text.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) name: &'a str,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    fn line(&self, offset: usize) -> usize {
        1 + self.text.bytes().take(offset).filter(|&byte| byte == b'\n').count()
    }

    /// Parses the document.
    pub(crate) fn parse(&self) -> Result<Spanned<DeTable<'_>>, SceneError> {
        DeTable::parse(self.text).map_err(|error| self.syntax(error.span(), error.message()))
    }

    /// The error for a text that is no TOML.
    pub(crate) fn syntax(&self, span: Option<Range<usize>>, message: &str) -> SceneError {
        SceneError::Syntax {
            file: self.name.to_owned(),
            line: self.line(span.map_or(0, |span| span.start)),
            message: message.to_owned(),
        }
    }
}

/// A value with its place.
#[derive(Clone)]
pub(crate) struct Field<'a> {
    source: Source<'a>,
    pub(crate) path: String,
    span: Range<usize>,
    value: &'a DeValue<'a>,
}

/// A table with its place.
pub(crate) struct Table<'a> {
    source: Source<'a>,
    path: String,
    /// Of the header, or of the braces.
    span: Range<usize>,
    entries: &'a DeTable<'a>,
}

impl<'a> Table<'a> {
    pub(crate) fn root(source: Source<'a>, document: &'a Spanned<DeTable<'a>>) -> Self {
        Self { source, path: String::new(), span: 0..0, entries: document.get_ref() }
    }

    fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// Refuses every field that is not among `known`.
    pub(crate) fn only(&self, known: &[&str]) -> Result<(), SceneError> {
        match self.entries.keys().find(|key| !known.contains(&&**key.get_ref())) {
            None => Ok(()),
            Some(key) => Err(SceneError::Field {
                file: self.source.name.to_owned(),
                line: self.source.line(key.span().start),
                field: self.path_of(&shorten(key.get_ref())),
                found: "an unknown field".to_owned(),
                expected: format!("one of {}", known.join(", ")),
            }),
        }
    }

    pub(crate) fn optional(&self, key: &str) -> Option<Field<'a>> {
        self.entries.get(key).map(|value| Field {
            source: self.source,
            path: self.path_of(key),
            span: value.span(),
            value: value.get_ref(),
        })
    }

    pub(crate) fn required(&self, key: &str) -> Result<Field<'a>, SceneError> {
        self.optional(key).ok_or_else(|| self.lacks(key, "this field"))
    }

    /// The error for a field that is not there.
    pub(crate) fn lacks(&self, key: &str, expected: impl Display) -> SceneError {
        SceneError::Field {
            file: self.source.name.to_owned(),
            line: self.source.line(self.span.start),
            field: self.path_of(key),
            found: "nothing".to_owned(),
            expected: expected.to_string(),
        }
    }

    /// The tables of `[[key]]`; none if the key is absent.
    pub(crate) fn tables(&self, key: &str) -> Result<Vec<Table<'a>>, SceneError> {
        match self.optional(key) {
            None => Ok(Vec::new()),
            Some(field) => {
                field.elements(&format!("tables headed [[{key}]]"))?.iter().map(Field::table).collect()
            }
        }
    }
}

impl<'a> Field<'a> {
    /// The error for a value that is not `expected`.
    pub(crate) fn refuse(&self, expected: impl Display) -> SceneError {
        let found = match self.value {
            DeValue::Table(_) => "a table".to_owned(),
            _ => shorten(self.source.text.get(self.span.clone()).unwrap_or_default()),
        };
        SceneError::Field {
            file: self.source.name.to_owned(),
            line: self.source.line(self.span.start),
            field: self.path.clone(),
            found,
            expected: expected.to_string(),
        }
    }

    /// The error for a mesh file that this field names.
    pub(crate) fn refuse_mesh(&self, mesh: String, source: MeshError) -> SceneError {
        let (file, field) = (self.source.name.to_owned(), self.path.clone());
        SceneError::Mesh {
            file,
            line: self.source.line(self.span.start),
            field,
            mesh,
            source: Box::new(source),
        }
    }

    /// The error for a volume file that this field names.
    pub(crate) fn refuse_volume(&self, volume: String, source: VolumeError) -> SceneError {
        let (file, field) = (self.source.name.to_owned(), self.path.clone());
        SceneError::Volume {
            file,
            line: self.source.line(self.span.start),
            field,
            volume,
            source: Box::new(source),
        }
    }

    pub(crate) fn table(&self) -> Result<Table<'a>, SceneError> {
        match self.value {
            DeValue::Table(entries) => {
                Ok(Table { source: self.source, path: self.path.clone(), span: self.span.clone(), entries })
            }
            _ => Err(self.refuse("a table")),
        }
    }

    pub(crate) fn text(&self, expected: &str) -> Result<&'a str, SceneError> {
        match self.value {
            DeValue::String(text) => Ok(text),
            _ => Err(self.refuse(expected)),
        }
    }

    pub(crate) fn boolean(&self) -> Result<bool, SceneError> {
        self.value.as_bool().ok_or_else(|| self.refuse("true or false"))
    }

    /// A choice: a plain string, or a table of one entry that holds the choice's own fields.
    pub(crate) fn choice(&self, expected: &str) -> Result<(&'a str, Option<Field<'a>>), SceneError> {
        match self.value {
            DeValue::String(text) => Ok((text, None)),
            DeValue::Table(entries) if entries.len() == 1 => {
                let table = self.table()?;
                let name = entries.keys().next().map_or("", |key| key.get_ref());
                Ok((name, table.optional(name)))
            }
            _ => Err(self.refuse(expected)),
        }
    }

    /// A number, integer or not, that is finite as f32 and that `accept` takes.
    pub(crate) fn number(&self, expected: &str, accept: impl Fn(f32) -> bool) -> Result<f32, SceneError> {
        let value = match self.value {
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|value| value as f64)
            }
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            _ => None,
        };
        let single = value.map(|value| value as f32);
        single.filter(|&value| value.is_finite() && accept(value)).ok_or_else(|| self.refuse(expected))
    }

    /// A length > 0.
    pub(crate) fn size(&self) -> Result<f32, SceneError> {
        let (least, most) = (1.0 / MAX_COORDINATE, MAX_COORDINATE);
        self.number("a length in 1e-9..=1e9", |value| (least..=most).contains(&value))
    }

    /// A length > 0, or 0.
    pub(crate) fn size_or_zero(&self) -> Result<f32, SceneError> {
        let (least, most) = (1.0 / MAX_COORDINATE, MAX_COORDINATE);
        self.number("a length in 1e-9..=1e9, or 0", |value| value == 0.0 || (least..=most).contains(&value))
            .map(|value| value + 0.0)
    }

    pub(crate) fn integer(&self, range: Range<u64>) -> Result<u32, SceneError> {
        let value = match self.value {
            DeValue::Integer(integer) => u64::from_str_radix(integer.as_str(), integer.radix()).ok(),
            _ => None,
        };
        value
            .filter(|value| range.contains(value))
            .and_then(|value| u32::try_from(value).ok())
            .ok_or_else(|| self.refuse(format!("an integer from {} to {}", range.start, range.end - 1)))
    }

    pub(crate) fn elements(&self, expected: &str) -> Result<Vec<Field<'a>>, SceneError> {
        match self.value {
            DeValue::Array(values) => Ok(values
                .iter()
                .enumerate()
                .map(|(index, value)| Field {
                    source: self.source,
                    path: format!("{}[{index}]", self.path),
                    span: value.span(),
                    value: value.get_ref(),
                })
                .collect()),
            _ => Err(self.refuse(expected)),
        }
    }

    /// Three coordinates within ±1e9.
    pub(crate) fn vector(&self) -> Result<Vec3, SceneError> {
        let expected = "three numbers [x, y, z] within ±1e9";
        self.triple(expected, |field| {
            field.number("a number within ±1e9", |value| value.abs() <= MAX_COORDINATE)
        })
    }

    /// A direction of any length but 0, made unit.
    pub(crate) fn direction(&self) -> Result<Vec3, SceneError> {
        let unit = self.vector()?.as_dvec3().try_normalize().map(|unit| unit.as_vec3().normalize());
        unit.ok_or_else(|| self.refuse("a direction that is not zero"))
    }

    /// One number for grey, or red, green and blue; `accept` takes each of them.
    pub(crate) fn color(&self, expected: &str, accept: impl Fn(f32) -> bool) -> Result<Vec3, SceneError> {
        match self.value {
            DeValue::Array(_) => {
                self.triple("[red, green, blue] or one number", |field| field.number(expected, &accept))
            }
            _ => self.number(expected, accept).map(Vec3::splat),
        }
    }

    fn triple(
        &self,
        expected: &str,
        read: impl Fn(&Field<'a>) -> Result<f32, SceneError>,
    ) -> Result<Vec3, SceneError> {
        match self.elements(expected)?.as_slice() {
            [x, y, z] => Ok(Vec3::new(read(x)?, read(y)?, read(z)?)),
            _ => Err(self.refuse(expected)),
        }
    }
}

/// One line of at most 60 characters.
fn shorten(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default().trim();
    let cut: String = line.chars().take(60).collect();
    if cut.len() < text.trim().len() { format!("{cut}…") } else { cut }
}
