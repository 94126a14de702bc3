//! Lamps and skies that are seen: by the camera, in mirrors and through glass.
//!
//! Lamps hide nothing, as no shadow ray ends at one: what a ray sees of them is the sum of all whose shining sides it meets before a surface
//! ends it. Those that shine on one side are not there from behind.

mod border;
mod small;

pub(crate) use border::{Fill, Pixels};
pub use small::SmallLamps;

use crate::eye::starts::{EyeStart, EyeStarts};
use crate::kind::Kind;
use crate::light::Meetings;
use crate::light::shown::Shown;
use crate::scene::Scene;
use crate::scene::optics::Interior;
use crate::scene::passage::{Looks, passage};
use covbeam::Medium;
use covbeam_geometry::hit::Hit;
use glam::Vec3;

/// How far behind a surface that ends a ray a lamp may lie on it, in shares of the way and of the largest coordinate, and in twice
/// [`Hit::offset`] across the surface: ten times what rounding makes of all of them. Lamps hang in ceilings.
const ON_SURFACE: f64 = 1e-6;

/// And along the ray no farther than so many times that: a ray along a surface meets others where these are.
const ALONG: f64 = 256.0;

impl Shown {
    /// Radiance of those that an eye ray meets before a surface at `end`, or of small ones in its pixel, if nothing dims them.
    pub(crate) fn undimmed(
        &self,
        scene: &Scene,
        small: &SmallLamps,
        start: &EyeStart,
        end: f32,
        surface: Option<&Hit>,
    ) -> Vec3 {
        if self.is_empty() {
            return Vec3::ZERO;
        }
        let end = f64::from(end) + surface.map_or(0.0, |hit| slack(start.origin, start.direction, hit));
        let mut met = Meetings::new();
        let wanted = |lamp| !small.has(lamp);
        self.met(&scene.lights, wanted, start.origin, start.direction, [0.0, end], &mut met);
        let large: Vec3 = met.iter().map(|(_, radiance)| *radiance).sum();
        large + small.undimmed(scene, start, end)
    }

    /// Of those that an eye ray sees straight, or asks for because they are small, what is seen if nothing dims or hides it.
    pub(crate) fn seen(
        &self,
        scene: &Scene,
        small: &SmallLamps,
        starts: &EyeStarts,
        start: &EyeStart,
    ) -> Vec<Sighting> {
        let mut seen = Vec::new();
        if !self.is_empty() && start.sees {
            let mut met = Meetings::new();
            let wanted = |lamp| !small.has(lamp);
            let ends = [0.0, f64::INFINITY];
            self.met(&scene.lights, wanted, start.origin, start.direction, ends, &mut met);
            self.add_seen(scene, &met, start, &mut seen);
            small.add_seen(scene, starts, start, &mut seen);
        }
        seen
    }

    /// What an eye ray meets, as it is seen.
    fn add_seen(&self, scene: &Scene, met: &Meetings, start: &EyeStart, seen: &mut Vec<Sighting>) {
        let EyeStart { origin, direction, interior, .. } = *start;
        // Beyond all that the scene has, for what is infinitely far away.
        let (middle, around) =
            self.far.first().map_or((origin, 0.0), |&lamp| scene.lights[lamp as usize].middle());
        let beyond = f64::from(origin.distance(middle) + around);
        seen.extend(met.iter().map(|&(distance, radiance)| {
            let distance = if distance.is_finite() { distance } else { beyond };
            let place = (origin.as_dvec3() + distance * direction.as_dvec3()).as_vec3();
            Sighting { radiance, eye: origin, interior, place }
        }));
    }
}

/// A lamp that may be seen straight.
pub(crate) struct Sighting {
    /// If nothing dims it.
    radiance: Vec3,
    /// From where, inside of what.
    eye: Vec3,
    interior: Interior,
    place: Vec3,
}

impl Sighting {
    /// Radiance of what is seen of it, through nothing but fog, its bounds, and what is transparent.
    pub(crate) fn dimmed(&self, scene: &Scene, fogs: &[Medium]) -> Vec3 {
        self.radiance * passage(scene, fogs, self.interior, [self.eye, self.place], Looks::Camera)
    }
}

/// How far past a surface, along a ray that it ends, lamps count as lying on it.
fn slack(origin: Vec3, direction: Vec3, hit: &Hit) -> f64 {
    let cosine = f64::from(hit.geometric_normal.dot(direction).abs());
    let across = 2.0 * f64::from(hit.offset) * cosine.recip().min(ALONG);
    across + ON_SURFACE * f64::from(hit.distance + origin.abs().max_element())
}

/// What an eye path sees of lamps on a straight line, which goes on through what only bounds media and what is transparent: no lamp is seen
/// twice along it.
#[derive(Clone, Copy)]
pub(crate) struct Watch {
    sees: Sees,
    /// Where the line starts.
    origin: Vec3,
    /// Distance from there up to which lamps were looked for.
    looked: f64,
    /// Whether it starts at the camera: small lamps are asked for there.
    is_first: bool,
    /// Whether all others are looked for apart, too, on the line that starts at the camera.
    is_apart: bool,
}

/// Which lamps are seen: each way from a lamp to the camera counts once. Diffuse surfaces and fog end eye paths.
#[derive(Clone, Copy)]
enum Sees {
    /// Those that are shown: nothing but mirrors and clear glass was met.
    Shown,
    /// None: a rough surface reflected the path, where shadow rays looked for all of them.
    None,
    /// All: rough glass let the path through, where no shadow ray finds any.
    All,
}

impl Watch {
    /// From the camera.
    ///
    /// - `is_apart`: whether other rays look for lamps there.
    pub(crate) fn new(origin: Vec3, is_apart: bool) -> Self {
        Self { sees: Sees::Shown, origin, looked: 0.0, is_first: true, is_apart }
    }

    /// The same on another line.
    pub(crate) fn from(self, origin: Vec3) -> Self {
        Self { origin, looked: 0.0, is_first: false, ..self }
    }

    /// After rough glass.
    pub(crate) fn of_all(self) -> Self {
        Self { sees: Sees::All, ..self }
    }

    /// After reflection by a rough surface.
    pub(crate) fn of_none(self) -> Self {
        Self { sees: Sees::None, ..self }
    }

    /// What the light of lamps has met that is seen.
    pub(crate) fn kind(self) -> Kind {
        if matches!(self.sees, Sees::All) { Kind::Focused } else { Kind::Straight }
    }

    /// The lamps that the next piece of the line sees up to `hit`, by their distances from its start.
    ///
    /// - `small`: those that are asked for and not met; None: none are wanted that are shown.
    pub(crate) fn look(
        &mut self,
        scene: &Scene,
        small: Option<&SmallLamps>,
        start: Vec3,
        direction: Vec3,
        hit: Option<&Hit>,
    ) -> Meetings {
        let mut met = Meetings::new();
        let is_blind = match self.sees {
            Sees::None => true,
            Sees::Shown => small.is_none() || scene.shown.is_empty() || self.is_first && self.is_apart,
            Sees::All => false,
        };
        if is_blind || !scene.shows_surfaces() {
            return met;
        }
        let passed = (start.as_dvec3() - self.origin.as_dvec3()).dot(direction.as_dvec3());
        let until = |hit: &Hit| passed + f64::from(hit.distance) + slack(start, direction, hit);
        let ends = [self.looked, hit.map_or(f64::INFINITY, until)];
        match self.sees {
            Sees::All => {
                scene.lights.iter().for_each(|light| light.met(self.origin, direction, ends, &mut met))
            }
            _ => {
                let wanted = |lamp| !(self.is_first && small.is_some_and(|small| small.has(lamp)));
                scene.shown.met(&scene.lights, wanted, self.origin, direction, ends, &mut met);
            }
        }
        // The next surface may be nearer than what counts as lying on this one.
        self.looked = self.looked.max(ends[1]);
        met.iter_mut().for_each(|(distance, _)| *distance -= passed);
        met
    }
}
