//! Numbers and tables of a scene file, in the units of the file.

use glam::DVec3;
use std::fmt::Write;

/// Writes a scene's tables; what it is given is in metres of a room of ordinary size.
pub(super) struct Text {
    body: String,
    /// Scene units in a metre.
    pub(super) scale: f64,
}

impl Text {
    pub(super) fn new(scale: f64) -> Self {
        Self { body: String::new(), scale }
    }

    pub(super) fn line(&mut self, line: &str) {
        self.body.push_str(line);
        self.body.push('\n');
    }

    pub(super) fn field(&mut self, name: &str, value: impl AsRef<str>) {
        let _ = writeln!(self.body, "{name} = {}", value.as_ref());
    }

    pub(super) fn length(&mut self, name: &str, metres: f64) {
        self.field(name, number(self.scale * metres));
    }

    pub(super) fn point(&mut self, name: &str, metres: DVec3) {
        let point = self.scaled(metres);
        self.field(name, point);
    }

    /// A point or an edge in the file's unit.
    pub(super) fn scaled(&self, metres: DVec3) -> String {
        vector(metres * self.scale)
    }

    pub(super) fn finish(self) -> String {
        self.body
    }
}

/// Four significant digits: short in the file, and moves nothing by more than a hundredth of what is kept clear between things.
pub(super) fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().expect("a number");
    format!("{rounded:?}")
}

pub(super) fn vector(v: DVec3) -> String {
    format!("[{}, {}, {}]", number(v.x), number(v.y), number(v.z))
}

/// One number where it is grey.
pub(super) fn color(v: DVec3) -> String {
    if v.x == v.y && v.y == v.z { number(v.x) } else { vector(v) }
}
