//! Reads Wavefront OBJ text into indexed triangles.
//!
//! `tobj` does the parsing and triangulation; a scan before it finds what `tobj` accepts or reports without a
//! line number (NaN, index 0, indices beyond the list).

use std::borrow::Cow;
use std::io::Cursor;

use glam::Vec3;

/// More triangles than this are refused.
pub const MAX_TRIANGLES: usize = 1 << 26;

/// What an OBJ file holds, as far as a renderer of one material needs it: all its groups in one list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjTriangles {
    /// Vertex positions, finite.
    pub positions: Vec<Vec3>,
    /// Vertex normals as written, finite and not zero; empty when the file has none.
    pub normals: Vec<Vec3>,
    /// Three vertices a triangle.
    pub indices: Vec<[u32; 3]>,
}

/// Why an OBJ text was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ObjError {
    /// A line that does not follow the format.
    #[error("line {line}: found `{found}`, expected {expected}")]
    Line {
        /// Counted from 1.
        line: usize,
        /// The offending word.
        found: String,
        /// What should be there.
        expected: &'static str,
    },
    /// A face refers to something that is not in the file.
    #[error("line {line}: index {found} is out of range, the file has {available} {kind}")]
    Index {
        /// Counted from 1.
        line: usize,
        /// As written.
        found: i64,
        /// How many there are.
        available: usize,
        /// `vertices`, `texture coordinates` or `normals`.
        kind: &'static str,
    },
    /// Some faces have normals and some do not.
    #[error("some faces have normals and some do not: export normals for all of them or for none")]
    MixedNormals,
    /// No face with at least three corners.
    #[error("no triangles")]
    NoTriangles,
    /// More than [`MAX_TRIANGLES`].
    #[error("{0} triangles, at most {MAX_TRIANGLES} are allowed")]
    TooManyTriangles(usize),
    /// Refused by the parser for a reason that the scan does not know.
    #[error("{0}")]
    Parser(tobj::LoadError),
}

/// Reads OBJ text: `v`, `vn` and `f` lines; polygons become triangle fans, so they should be convex. A `\` at a line's end goes on with the
/// next one. Texture coordinates, colours, materials, groups, points and lines are ignored.
///
/// Errors: every input gives triangles or an [`ObjError`]; test
/// `a_valid_obj_cut_anywhere_or_with_any_byte_changed_is_read_or_refused`.
pub fn parse(bytes: &[u8]) -> Result<ObjTriangles, ObjError> {
    // Names in other encodings than UTF-8 are harmless: nothing here reads names.
    let text = String::from_utf8_lossy(bytes);
    let geometry = scan(&text)?;
    let options =
        tobj::LoadOptions { triangulate: true, single_index: true, ignore_points: true, ignore_lines: true };
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(geometry), &options, no_materials).map_err(ObjError::Parser)?;
    // The scan keeps no line that starts a second model.
    let Some(mesh) = models.into_iter().map(|model| model.mesh).find(|mesh| !mesh.indices.is_empty()) else {
        return Err(ObjError::NoTriangles);
    };
    if !mesh.normals.is_empty() && mesh.normals.len() != mesh.positions.len() {
        return Err(ObjError::MixedNormals);
    }
    let triangles = mesh.indices.len() / 3;
    if triangles > MAX_TRIANGLES {
        return Err(ObjError::TooManyTriangles(triangles));
    }
    let to_vectors = |values: &[f32]| values.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
    Ok(ObjTriangles {
        positions: to_vectors(&mesh.positions),
        normals: to_vectors(&mesh.normals),
        indices: mesh.indices.chunks_exact(3).map(|i| [i[0], i[1], i[2]]).collect(),
    })
}

/// What the indices of a face stand in.
const CORNER: &str = "a face corner v, v/vt, v//vn or v/vt/vn";

/// How many of each the file has so far, and the largest index used with the line that uses it.
#[derive(Default)]
struct Counted {
    count: usize,
    largest: usize,
    largest_line: usize,
}

impl Counted {
    /// Checks one index as written: 1 is the first, -1 the latest so far.
    fn check(&mut self, word: &str, line: usize, kind: &'static str) -> Result<(), ObjError> {
        let malformed = || ObjError::Line { line, found: word.to_owned(), expected: CORNER };
        let index: i64 = word.parse().map_err(|_| malformed())?;
        let out_of_range = ObjError::Index { line, found: index, available: self.count, kind };
        if index == 0 || (index < 0 && index.unsigned_abs() > self.count as u64) {
            return Err(out_of_range);
        }
        if index > 0 && index as usize > self.largest {
            (self.largest, self.largest_line) = (index as usize, line);
        }
        Ok(())
    }

    /// Positive indices may point forward, so they are checked against the whole file.
    fn check_largest(&self, kind: &'static str) -> Result<(), ObjError> {
        if self.largest > self.count {
            let (line, found) = (self.largest_line, self.largest as i64);
            return Err(ObjError::Index { line, found, available: self.count, kind });
        }
        Ok(())
    }
}

/// Checks every `v`, `vn` and `f` line and returns only those: `tobj` would read an `l` with three points as a
/// triangle and starts a new model at groups and materials.
fn scan(text: &str) -> Result<String, ObjError> {
    let mut scan = Scan { geometry: String::with_capacity(text.len()), ..Scan::default() };
    // Editors of some systems begin a text with a mark of its byte order.
    for (number, content) in whole_lines(text.trim_start_matches('\u{feff}')) {
        let line = Line { number, content: content.as_ref() };
        match line.content.split_whitespace().next() {
            Some("v") => scan.vertex(line)?,
            Some("vn") => scan.normal(line)?,
            Some("vt") => scan.texture.count += 1,
            Some("f") => scan.face(line)?,
            _ => {}
        }
    }
    scan.vertices.check_largest("vertices")?;
    scan.texture.check_largest("texture coordinates")?;
    scan.normals.check_largest("normals")?;
    Ok(scan.geometry)
}

/// A line with those that it goes on in.
#[derive(Clone, Copy)]
struct Line<'a> {
    /// Counted from 1, of the first.
    number: usize,
    content: &'a str,
}

impl<'a> Line<'a> {
    /// All after the one that says what it is.
    fn words(self) -> impl Iterator<Item = &'a str> {
        self.content.split_whitespace().skip(1)
    }

    fn refused(self, expected: &'static str) -> ObjError {
        ObjError::Line { line: self.number, found: self.content.trim().to_owned(), expected }
    }
}

/// What a scan has found so far.
#[derive(Default)]
struct Scan {
    vertices: Counted,
    texture: Counted,
    normals: Counted,
    /// Lines for `tobj`.
    geometry: String,
}

impl Scan {
    /// A vertex: x y z, x y z w, or x y z r g b.
    fn vertex(&mut self, line: Line) -> Result<(), ObjError> {
        self.vertices.count += 1;
        let values = numbers(line.words(), line.number)?;
        if !matches!(values.len(), 3 | 4 | 6) {
            return Err(line.refused("3 coordinates (and w, or a colour)"));
        }
        let w = if values.len() == 4 { values[3] } else { 1.0 };
        if !values[..3].iter().all(|value| (value / w).is_finite()) {
            return Err(line.refused("finite coordinates"));
        }
        // Without the colour, which only some of the vertices may have.
        let kept = if values.len() == 6 { 4 } else { usize::MAX };
        push_line(&mut self.geometry, line.content.split_whitespace().take(kept));
        Ok(())
    }

    /// A normal: x y z.
    fn normal(&mut self, line: Line) -> Result<(), ObjError> {
        self.normals.count += 1;
        let values = numbers(line.words(), line.number)?;
        // Squares must neither overflow nor vanish: the normal is made unit later.
        let length = values.iter().map(|value| value * value).sum::<f32>();
        if values.len() != 3 || !length.is_normal() {
            return Err(line.refused("a normal of 3 numbers that is not zero"));
        }
        push_line(&mut self.geometry, line.content.split_whitespace());
        Ok(())
    }

    /// A face: its corners.
    fn face(&mut self, line: Line) -> Result<(), ObjError> {
        let mut corners = 0;
        for corner in line.words() {
            corners += 1;
            self.check_corner(corner, line.number)?;
        }
        match corners {
            0..3 => return Err(line.refused("a face of at least 3 corners")),
            3 | 4 => push_line(&mut self.geometry, line.content.split_whitespace()),
            // `tobj` takes a time that grows with the square of a polygon's corners.
            _ => push_fan(&mut self.geometry, line.content),
        }
        Ok(())
    }

    /// Checks the indices of a face's corner.
    fn check_corner(&mut self, corner: &str, line: usize) -> Result<(), ObjError> {
        let mut parts = corner.split('/');
        self.vertices.check(parts.next().unwrap_or(""), line, "vertices")?;
        if let Some(part) = parts.next().filter(|part| !part.is_empty()) {
            self.texture.check(part, line, "texture coordinates")?;
        }
        if let Some(part) = parts.next().filter(|part| !part.is_empty()) {
            self.normals.check(part, line, "normals")?;
        }
        match parts.next() {
            None => Ok(()),
            Some(_) => Err(ObjError::Line { line, found: corner.to_owned(), expected: CORNER }),
        }
    }
}

/// Lines by the number of their first, with those that follow a `\` at an end.
fn whole_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, first) = lines.next()?;
        let mut whole = Cow::Borrowed(first);
        while whole.ends_with('\\') {
            let begun = whole.to_mut();
            begun.pop();
            begun.push(' ');
            begun.push_str(lines.next().map_or("", |(_, next)| next));
        }
        Some((number + 1, whole))
    })
}

fn push_line<'a>(geometry: &mut String, words: impl Iterator<Item = &'a str>) {
    for word in words {
        geometry.push_str(word);
        geometry.push(' ');
    }
    geometry.push('\n');
}

/// Triangles of a face's first corner with each two that follow one another.
fn push_fan(geometry: &mut String, face: &str) {
    let mut corners = face.split_whitespace().skip(1);
    let (Some(first), Some(mut before)) = (corners.next(), corners.next()) else { return };
    for corner in corners {
        push_line(geometry, ["f", first, before, corner].into_iter());
        before = corner;
    }
}

fn numbers<'a>(words: impl Iterator<Item = &'a str>, line: usize) -> Result<Vec<f32>, ObjError> {
    words
        .map(|word| {
            word.parse::<f32>().ok().filter(|value| value.is_finite()).ok_or_else(|| ObjError::Line {
                line,
                found: word.to_owned(),
                expected: "a finite number",
            })
        })
        .collect()
}
