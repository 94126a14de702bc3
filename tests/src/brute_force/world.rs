//! A scene as the brute-force path tracer has it, and what is where in it.
//!
//! Nothing is counted on the way: what fills a stretch between two faces is asked of the point in its middle. So faces in one plane, in
//! whatever order, cannot matter.

use super::lamps::Lamp;
use super::shapes::Shape;
use glam::DVec3;

/// Faces are at one place that are no farther apart along a ray, as part of the world's size: far above the rounding of f64, far below
/// whatever a scene file says.
const TOGETHER: f64 = 1e-9;

#[derive(Clone, Debug)]
pub(super) struct World {
    pub(super) camera: Camera,
    pub(super) media: Vec<Medium>,
    pub(super) outside: Option<usize>,
    pub(super) objects: Vec<Object>,
    pub(super) lamps: Vec<Lamp>,
    /// Largest extent of what has one.
    pub(super) size: f64,
    /// The objects that lie inside of each, a bit each.
    pub(super) within: Vec<u64>,
}

#[derive(Clone, Debug)]
pub(super) struct Camera {
    pub(super) position: DVec3,
    pub(super) forward: DVec3,
    pub(super) right: DVec3,
    pub(super) up: DVec3,
    /// Half of what the picture shows from bottom to top: a length of parallel rays, else at distance 1.
    pub(super) half: f64,
    pub(super) is_parallel: bool,
    pub(super) width: u32,
    pub(super) height: u32,
}

impl Camera {
    /// Through a point of the picture in pixels from its upper left corner.
    pub(super) fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let [width, height] = [self.width, self.height].map(f64::from);
        let pixel = 2.0 * self.half / height;
        let across = pixel * ((x - 0.5 * width) * self.right + (0.5 * height - y) * self.up);
        if self.is_parallel {
            (self.position + across, self.forward)
        } else {
            (self.position, (self.forward + across).normalize())
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Medium {
    pub(super) scattering: DVec3,
    pub(super) absorption: DVec3,
    /// Mean cosine of Henyey and Greenstein.
    pub(super) asymmetry: f64,
}

impl Medium {
    pub(super) fn extinction(&self) -> DVec3 {
        self.scattering + self.absorption
    }
}

#[derive(Clone, Debug)]
pub(super) enum Material {
    Black,
    Lambert(DVec3),
    Mirror(DVec3),
    Dielectric(f64),
}

#[derive(Clone, Debug)]
pub(super) struct Object {
    pub(super) shape: Shape,
    pub(super) material: Material,
    pub(super) inside: Option<usize>,
    pub(super) priority: i64,
}

impl Object {
    fn index(&self) -> Option<f64> {
        if let Material::Dielectric(index) = self.material { Some(index) } else { None }
    }
}

/// A straight way to the first place where light does not go straight on.
pub(super) struct Way {
    /// What it goes through: where each stretch ends, and the medium there.
    pub(super) stretches: Vec<(f64, Option<usize>)>,
    pub(super) end: End,
}

pub(super) enum End {
    /// Infinitely far away.
    Nowhere,
    Surface {
        object: usize,
        normal: DVec3,
    },
    /// Indices before and beyond.
    Interface {
        before: f64,
        beyond: f64,
        normal: DVec3,
    },
}

impl Way {
    pub(super) fn length(&self) -> f64 {
        self.stretches.last().map_or(f64::INFINITY, |last| last.0)
    }
}

impl World {
    /// Finds out which objects lie inside of which.
    pub(super) fn nest(&mut self) {
        let holds = |outer: usize, inner: usize| {
            self.objects[outer].shape.holds_all(&self.objects[inner].shape, self.tolerance())
        };
        let count = self.objects.len();
        let inside = |outer: usize| {
            (0..count)
                .filter(|inner| holds(outer, *inner) && !holds(*inner, outer))
                .fold(0, |set, inner| set | 1 << inner)
        };
        self.within = (0..count).map(inside).collect();
    }

    pub(super) fn tolerance(&self) -> f64 {
        TOGETHER * self.size
    }

    /// The dielectric that fills a point: of those that hold it that of the highest priority; of these what lies inside of another one before
    /// that; else the later one.
    fn filling(&self, point: DVec3) -> Option<usize> {
        let mut around = 0_u64;
        let mut highest = i64::MIN;
        for (number, object) in self.objects.iter().enumerate() {
            if object.index().is_some() && object.priority >= highest && object.shape.holds(point) {
                around = if object.priority > highest { 0 } else { around } | 1 << number;
                highest = object.priority;
            }
        }
        let is_there = |number: &usize| around >> number & 1 == 1;
        (0..self.objects.len()).rev().filter(is_there).find(|number| around & self.within[*number] == 0)
    }

    fn index_of(&self, filling: Option<usize>) -> f64 {
        filling.and_then(|number| self.objects[number].index()).unwrap_or(1.0)
    }

    fn medium_of(&self, filling: Option<usize>) -> Option<usize> {
        filling.map_or(self.outside, |number| self.objects[number].inside)
    }

    /// Follows a ray until it meets a solid surface or another index, or reaches `limit`.
    pub(super) fn way(&self, origin: DVec3, direction: DVec3, limit: f64) -> Way {
        let mut crossings: Vec<(f64, DVec3, usize)> = Vec::new();
        for (number, object) in self.objects.iter().enumerate() {
            let found = object.shape.crossings(origin, direction).into_iter();
            let ahead = found.filter(|(t, _)| *t > self.tolerance() && *t < limit);
            crossings.extend(ahead.map(|(t, normal)| (t, normal, number)));
        }
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut stretches, mut from, mut next) = (Vec::new(), 0.0, 0);
        let middle = |from: f64, to: f64| {
            let to = if to.is_finite() { to } else { from + self.size };
            self.filling(origin + 0.5 * (from + to) * direction)
        };
        let end_of = |next: usize| crossings.get(next).map_or(limit, |crossing| crossing.0);
        let mut before = middle(0.0, end_of(0));
        while let Some(&(place, ..)) = crossings.get(next) {
            stretches.push((place, self.medium_of(before)));
            let together =
                crossings[next..].iter().take_while(|(t, ..)| *t - place <= self.tolerance()).count();
            let faces = &crossings[next..next + together];
            next += together;
            from = faces[together - 1].0;
            if let Some(&(_, normal, object)) =
                faces.iter().find(|face| self.objects[face.2].index().is_none())
            {
                return Way { stretches, end: End::Surface { object, normal } };
            }
            let beyond = middle(from, end_of(next));
            let indices = [before, beyond].map(|filling| self.index_of(filling));
            if indices[0] != indices[1] {
                let decides = |face: &&(f64, DVec3, usize)| [before, beyond].contains(&Some(face.2));
                let normal = faces.iter().find(decides).unwrap_or(&faces[0]).1;
                let [before, beyond] = indices;
                return Way { stretches, end: End::Interface { before, beyond, normal } };
            }
            before = beyond;
        }
        if from < limit {
            stretches.push((limit, self.medium_of(before)));
        }
        Way { stretches, end: End::Nowhere }
    }

    /// Whether paths from the camera find all light: lamps without a size cannot be met by way of glass or a mirror, but for suns that shine
    /// squarely on the faces of boxes.
    pub(super) fn is_all_found(&self) -> bool {
        let bends = |object: &&Object| match object.material {
            Material::Mirror(_) => true,
            Material::Dielectric(index) => index != 1.0,
            Material::Black | Material::Lambert(_) => false,
        };
        let bending: Vec<&Object> = self.objects.iter().filter(bends).collect();
        let is_box = |object: &&Object| {
            matches!((&object.shape, &object.material), (Shape::Box { .. }, Material::Dielectric(_)))
        };
        let all_boxes = bending.iter().all(is_box);
        let is_found = |lamp: &Lamp| lamp.has_size() || (all_boxes && lamp.is_along_an_axis());
        bending.is_empty() || self.lamps.iter().all(is_found)
    }

    pub(super) fn extinction(&self, medium: Option<usize>) -> DVec3 {
        medium.map_or(DVec3::ZERO, |medium| self.media[medium].extinction())
    }
}

impl Way {
    /// Transmittance of its first `length`.
    pub(super) fn transmittance(&self, world: &World, length: f64) -> DVec3 {
        let (mut depth, mut from) = (DVec3::ZERO, 0.0);
        for &(to, medium) in &self.stretches {
            let extinction = world.extinction(medium);
            if length > from {
                // A channel without extinction has no depth even at infinity.
                let passed = (to.min(length) - from) * extinction;
                depth += DVec3::select(extinction.cmpgt(DVec3::ZERO), passed, DVec3::ZERO);
            }
            from = to;
        }
        (-depth).exp()
    }
}
