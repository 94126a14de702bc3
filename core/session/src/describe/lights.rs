//! Lights.

use super::fields::{BRIGHTEST, Fields};
use super::volumes::Media;
use crate::host::Host;
use crate::light::OwnLight;
use crate::light::falloff::Falloff;
use crate::scene::{Area, Ball, Cone, Lamp, Light as RenderLight, Links, Pattern, ShiningMesh, Sky, Sun};
use crate::work::failure::Result;
use covbeam_geometry::MAX_COORDINATE;
use glam::{DVec3, Mat3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Where fog is, and all that a scene has.
pub(super) struct Lit {
    /// A ball around all fog; without any, one around the camera.
    pub(super) media: Ball,
    /// A ball around that and all geometry.
    pub(super) scene: Ball,
}

/// What a light is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightKind {
    /// A point or ball that shines all around, or by a pattern.
    #[default]
    Point,
    /// The same into a cone.
    Spot,
    /// A parallelogram or ellipse.
    Area,
    /// A disk infinitely far away.
    Sun,
    /// Triangles that shine on both sides.
    Mesh,
    /// What is around the scene, infinitely far away.
    Sky,
}

/// Most cells of a pattern or a sky.
const MOST_CELLS: usize = 1 << 24;

/// A light source. See Light in the extension's `host/scene.py`; fields that its kind does not name are not read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightFields {
    /// \[m\]
    pub position: [f64; 3],
    /// Unit.
    pub axis: [f64; 3],
    /// First whole edge of an area \[m\].
    pub u: [f64; 3],
    /// Second one.
    pub v: [f64; 3],
    /// Of points and spots \[W/sr\].
    pub intensity: [f64; 3],
    /// Of areas and meshes \[W/(m² sr)\].
    pub radiance: [f64; 3],
    /// Of suns \[W/m²\].
    pub irradiance: [f64; 3],
    /// Of a pattern, by rows: to the right of the lamp, up, along its axis; of a sky: the rotation into its picture.
    pub axes: [[f64; 3]; 3],
    /// Of points and spots \[m\].
    pub radius: f64,
    /// Of the half angle of a spot's cone.
    pub cosine: f64,
    /// How far the cosine rises inside of that until the light is full.
    pub blend: f64,
    /// Half angle of an area's honeycomb \[rad\].
    pub spread: f64,
    /// Half angle that a sun is seen under \[rad\].
    pub angle: f64,
    /// Angle from the axis that a pattern's rows end at \[rad\].
    pub reach: f64,
    /// What it is.
    pub kind: LightKind,
    /// Not 0: all points see a disk of a lamp's radius that faces them, and no ball.
    pub soft: u32,
    /// Not 0: an area is the ellipse in its edges.
    pub round: u32,
    /// Rows of a pattern or a sky.
    pub rows: u32,
    /// Columns of it.
    pub columns: u32,
    /// Whether the camera sees it, and mirrors and glass show it: what has a surface, a sky, or a sun with an angle. Others are seen by nobody.
    pub is_visible: bool,
    /// Whether a host says what it sends; what is described is an estimate then, which shines wherever the host's light does, and what is seen.
    pub is_own: bool,
    /// Sets of objects and volumes that it does not fall on, a bit each.
    pub unlit: u64,
    /// Sets of objects that it passes as if they were not there.
    pub unshadowed: u64,
    /// Rays that do not see it where it falls: the bits of [`Rays`](crate::scene::visibility::Rays). The camera's and those to lamps do not count.
    pub hidden_from: u32,
    /// Its straight light is times dᵃ d²/(s + d²) at a distance d, s in m²: a from 0 to 4, and s. Suns and skies have none.
    pub falloff: f64,
    /// That is s.
    pub smooth: f64,
    /// Largest number of events of its light, plus 1, where bounces are limited; 0: as many as these limits let.
    pub most_events: u32,
}

impl LightFields {
    pub(super) fn is_mesh(&self) -> bool {
        self.kind == LightKind::Mesh
    }

    pub(super) fn is_far(&self) -> bool {
        matches!(self.kind, LightKind::Sun | LightKind::Sky)
    }
}

/// The same with its arrays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Light<'a> {
    /// All that is a number.
    pub fields: LightFields,
    /// Corners of a mesh \[m\].
    pub triangles: &'a [[[f32; 3]; 3]],
    /// Of a pattern or a sky, row by row; None: a lamp without a pattern.
    pub cells: Option<&'a [[f32; 3]]>,
}

/// Lights that send any light.
pub(super) struct Lights {
    pub(super) lights: Vec<RenderLight>,
    /// Whether they are seen, by light.
    pub(super) visible: Vec<bool>,
    /// On what they fall.
    pub(super) links: Vec<Links>,
}

/// Those of a description.
pub(super) fn lights(given: &[Light], media: &Media, lit: &Lit, host: Option<&Host>) -> Result<Lights> {
    let (mut lights, mut visible, mut links) = (Vec::new(), Vec::new(), Vec::new());
    for (index, light) in given.iter().enumerate() {
        let fields = Fields::of("lights", index);
        let Some(made) = light.light(&fields, media, lit)? else { continue };
        let LightFields { unlit, unshadowed, hidden_from, .. } = light.fields;
        let hidden = fields.rays("hidden_from", hidden_from)?;
        let falloff = light.falloff(&fields, made.position(), lit)?;
        let flux = made.flux();
        if !flux.is_finite() {
            return Err(fields.wrong("flux", flux.to_array(), "a light whose power single precision holds"));
        }
        if flux != Vec3::ZERO {
            lights.push(if light.fields.is_own { own(made, index, &fields, host)? } else { made });
            visible.push(light.fields.is_visible);
            let bounces = light.fields.most_events.checked_sub(1);
            links.push(Links { unlit, unshadowed, hidden, falloff, bounces });
        }
    }
    if links.iter().all(|links| *links == Links::default()) {
        links.clear();
    }
    Ok(Lights { lights, visible, links })
}

/// A light that the host says more about.
fn own(described: RenderLight, index: usize, fields: &Fields, host: Option<&Host>) -> Result<RenderLight> {
    let Some(host) = host else {
        return Err(fields.wrong("is_own", true, "false where no host keeps the geometry"));
    };
    let (described, host) = (Box::new(described), host.clone());
    Ok(RenderLight::Own(OwnLight { described, host, number: index as u32 }))
}

impl Light<'_> {
    fn light(&self, fields: &Fields, media: &Media, lit: &Lit) -> Result<Option<RenderLight>> {
        match self.fields.kind {
            LightKind::Point | LightKind::Spot => self.lamp(fields, lit),
            LightKind::Area => self.area(fields),
            LightKind::Sun => self.sun(fields, media, lit),
            LightKind::Mesh => self.mesh(fields),
            LightKind::Sky => self.sky(fields, media, lit),
        }
    }

    fn falloff(&self, fields: &Fields, position: Vec3, lit: &Lit) -> Result<Falloff> {
        let exponent = fields.number("falloff", self.fields.falloff, 0.0..=4.0)?;
        let smooth = fields.number("smooth", self.fields.smooth, 0.0..=f64::from(MAX_COORDINATE))?;
        if self.fields.is_far() {
            return Ok(Falloff::default());
        }
        let Ball { center, radius } = lit.media;
        Ok(Falloff::new(exponent, smooth, position.distance(center) + radius))
    }

    fn lamp(&self, fields: &Fields, lit: &Lit) -> Result<Option<RenderLight>> {
        let given = &self.fields;
        let intensity = fields.color("intensity", given.intensity, BRIGHTEST)?;
        let radius = fields.number("radius", given.radius, 0.0..=f64::from(MAX_COORDINATE))?;
        let position = fields.point("position", given.position)?.as_vec3();
        let cone = if given.kind == LightKind::Spot { Some(self.cone(fields)?) } else { None };
        let has_pattern = self.cells.is_some();
        let pattern = self.pattern(fields, cone.as_ref())?;
        if has_pattern && pattern.is_none() {
            return Ok(None);
        }
        let (soft, pattern) = (given.soft != 0, pattern.map(Arc::new));
        let glow = Lamp::glow_of(radius.max(f32::MIN_POSITIVE), cone.is_some(), lit.media.radius);
        Ok(Some(RenderLight::Lamp(Lamp { position, intensity, radius, soft, cone, pattern, glow })))
    }

    fn cone(&self, fields: &Fields) -> Result<Cone> {
        let given = &self.fields;
        let axis = fields.direction("axis", given.axis)?.as_vec3().normalize();
        // Beyond, single precision has no cone.
        let cosine = fields.number("cosine", given.cosine, -1.0..=1.0)?.min(1.0_f32.next_down());
        let blend = fields.number("blend", given.blend, f64::from(f32::MIN_POSITIVE)..=2.0)?;
        Ok(Cone { axis, cosine, blend })
    }

    /// None without one, and if it is dark.
    fn pattern(&self, fields: &Fields, cone: Option<&Cone>) -> Result<Option<Pattern>> {
        let Some(cells) = self.cells else { return Ok(None) };
        let axes = fields.axes(["pattern.axes"; 3], self.fields.axes)?;
        let reach = fields.number("pattern.reach", self.fields.reach, 1e-6..=PI * (1.0 + 1e-6))?;
        let values = self.checked(fields, "pattern.cells", cells)?;
        let axes = axes.map(|axis| axis.as_vec3().normalize());
        Ok(Pattern::new(values, self.fields.columns as usize, axes, reach.min(PI as f32), cone))
    }

    fn area(&self, fields: &Fields) -> Result<Option<RenderLight>> {
        let given = &self.fields;
        let edge = |name, value| fields.point(name, value).map(|edge| edge.as_vec3());
        let (edge_u, edge_v) = (edge("u", given.u)?, edge("v", given.v)?);
        let center = fields.point("position", given.position)?.as_vec3();
        let radiance = fields.color("radiance", given.radiance, BRIGHTEST)?;
        // Without an upper end: none, from a right angle on.
        let spread = fields.number("spread", given.spread, 1e-4..=PI)?.min(FRAC_PI_2 as f32);
        // As single precision has it.
        let is_flat = edge_u.as_dvec3().cross(edge_v.as_dvec3()).as_vec3().length() == 0.0;
        let area = Area { center, edge_u, edge_v, round: given.round != 0, spread, radiance };
        Ok((!is_flat).then_some(RenderLight::Area(area)))
    }

    fn sun(&self, fields: &Fields, media: &Media, lit: &Lit) -> Result<Option<RenderLight>> {
        let given = &self.fields;
        let direction = fields.direction("axis", given.axis)?.as_vec3().normalize();
        let angle =
            fields.number("angle", given.angle, 0.0..=FRAC_PI_2 * (1.0 + 1e-6))?.min(FRAC_PI_2 as f32);
        let irradiance = media.far_light() * fields.color("irradiance", given.irradiance, BRIGHTEST)?;
        Ok(Some(RenderLight::Sun(Sun::around(direction, angle, irradiance, lit.media, lit.scene))))
    }

    fn mesh(&self, fields: &Fields) -> Result<Option<RenderLight>> {
        let radiance = fields.color("radiance", self.fields.radiance, BRIGHTEST)?;
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for (index, corners) in self.triangles.iter().enumerate() {
            let name = |corner: usize| format!("triangles[{index}, {corner}]");
            for (number, corner) in corners.iter().enumerate() {
                fields.point(&name(number), corner.map(f64::from))?;
            }
            triangles.push(corners.map(Vec3::from));
        }
        Ok(ShiningMesh::new(&triangles, radiance).map(RenderLight::Mesh))
    }

    fn sky(&self, fields: &Fields, media: &Media, lit: &Lit) -> Result<Option<RenderLight>> {
        let Some(cells) = self.cells else { return Err(fields.wrong("sky", "NULL", "an array of cells")) };
        let mut values = self.checked(fields, "sky", cells)?;
        let through = media.far_light();
        values.iter_mut().for_each(|value| *value *= through);
        let rows = fields.axes(["turn"; 3], self.fields.axes)?;
        if DVec3::cross(rows[0], rows[1]).dot(rows[2]) < 0.0 {
            return Err(fields.wrong("turn", self.fields.axes, "a rotation, not a mirror"));
        }
        let [x, y, z] = rows.map(|row| row.as_vec3().normalize());
        let turn = Mat3::from_cols(x, y, z).transpose();
        let columns = self.fields.columns as usize;
        Ok(Sky::around(values, columns, turn, lit.media, lit.scene).map(RenderLight::Sky))
    }

    fn checked(&self, fields: &Fields, name: &str, cells: &[[f32; 3]]) -> Result<Vec<Vec3>> {
        let shape = (self.fields.rows, self.fields.columns);
        if !(1..=MOST_CELLS).contains(&cells.len()) {
            return Err(fields.wrong(name, shape, format_args!("1 to {MOST_CELLS} cells")));
        }
        let is_light = |cell: &[f32; 3]| cell.iter().all(|value| (0.0..=BRIGHTEST as f32).contains(value));
        if let Some(wrong) = cells.iter().position(|cell| !is_light(cell)) {
            let at = [wrong / self.fields.columns as usize, wrong % self.fields.columns as usize];
            let name = format!("{name}[{}, {}]", at[0], at[1]);
            return Err(fields.wrong(&name, cells[wrong], format_args!("numbers from 0 to {BRIGHTEST:e}")));
        }
        Ok(cells.iter().map(|&cell| Vec3::from(cell)).collect())
    }
}
