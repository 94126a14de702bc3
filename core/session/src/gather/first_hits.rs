//! How far light gets from a light in each direction: coarse maps, to expect the visibility of a place by,
//! never to decide it. (The grid's voxels would say so too, but are wider than tracery.)

use crate::light::cap_height;
use crate::random::{Random, spread};
use crate::scene::{Light, Scene};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::FRAC_PI_4;

/// Points of a disk light, each with a map of its own.
const DISK_POINTS: usize = 16;

/// And of a rectangle, along each edge.
const RECTANGLE_SIDE: usize = 4;

/// And of an area or a mesh.
const SPREAD_POINTS: usize = 16;

/// Weight of not knowing, in rays: half of it says lit, half dark.
const DOUBT: f32 = 0.25;

/// What a light's rays hit first.
pub(crate) struct FirstHits {
    /// Axes of the light's cone, its own last.
    axes: [Vec3; 3],
    /// 1 - cosine of the cone's half-angle.
    height: f32,
    /// Texels along a side of a map.
    side: u32,
    /// Where the rays start, and their distances, texel by texel; negative where there is no direction.
    maps: Vec<(Vec3, Vec<f32>)>,
}

impl FirstHits {
    /// Traces about `rays` rays from a light, at random in texels of equal solid angle.
    pub(crate) fn new(scene: &Scene, light: &Light, rays: usize, key: [u32; 2]) -> Self {
        if let Light::Own(own) = light {
            return Self::new(scene, &own.described, rays, key);
        }
        let (axis, height, points) = match *light {
            Light::Point { .. } | Light::Sphere { .. } => (Vec3::Y, 2.0, 1),
            Light::Spot { direction, outer_angle, .. } => (direction, cap_height(outer_angle), 1),
            Light::Disk { normal, .. } => (normal, 1.0, DISK_POINTS),
            Light::Rectangle { edge_u, edge_v, .. } => {
                (edge_u.cross(edge_v).normalize(), 1.0, RECTANGLE_SIDE * RECTANGLE_SIDE)
            }
            Light::Lamp(ref lamp) => match lamp.cone {
                Some(cone) => (cone.axis, cone.height(), 1),
                None => (Vec3::Y, 2.0, 1),
            },
            Light::Area(area) => (area.normal(), 1.0, SPREAD_POINTS),
            Light::Mesh(_) => (Vec3::Y, 2.0, SPREAD_POINTS),
            // From everywhere, or by no shadow rays.
            Light::Sun(_) | Light::Sky(_) | Light::Glow(_) | Light::Own(_) => (Vec3::Y, 2.0, 0),
        };
        let (across, aside) = axis.any_orthonormal_pair();
        let side = ((rays as f32 / (points.max(1) as f32 * FRAC_PI_4)).sqrt() as u32).max(1);
        let mut all = Self { axes: [across, aside, axis], height, side, maps: Vec::new() };
        for point in 0..points {
            let origin = match *light {
                Light::Disk { center, radius, .. } => {
                    // Evenly over the disk, turned by the golden angle from one to the next.
                    let rho = radius * ((point as f32 + 0.5) / points as f32).sqrt();
                    let (sine, cosine) = libm::sincosf(2.399_963_2 * point as f32);
                    center + rho * (cosine * across + sine * aside) + 1e-4 * radius * axis
                }
                Light::Rectangle { edge_u, edge_v, .. } => {
                    let share = |index: usize| (index as f32 + 0.5) / RECTANGLE_SIDE as f32 - 0.5;
                    light.position()
                        + share(point % RECTANGLE_SIDE) * edge_u
                        + share(point / RECTANGLE_SIDE) * edge_v
                }
                Light::Area(area) => area.start(spread([0.5; 2], point)),
                Light::Mesh(ref mesh) => {
                    let (place, normal) = mesh.place(spread([0.5; 2], point));
                    mesh.off(place, if point % 2 == 0 { normal } else { -normal })
                }
                _ => light.position(),
            };
            let distances = (0..side * side).into_par_iter().map(|texel| {
                let mut random = Random::new([key[0], key[1], texel, 0xf125 + point as u32]);
                let corner = Vec2::new((texel % side) as f32, (texel / side) as f32);
                all.direction(corner + Vec2::new(random.uniform(), random.uniform())).map_or(
                    -1.0,
                    |direction| {
                        let hit = scene.intersect_solid(origin, direction, f32::INFINITY);
                        hit.map_or(f32::INFINITY, |hit| hit.distance)
                    },
                )
            });
            let distances = distances.collect();
            all.maps.push((origin, distances));
        }
        all
    }

    /// Rays that were traced.
    pub(crate) fn rays(&self) -> u64 {
        let traced =
            |map: &(Vec3, Vec<f32>)| map.1.iter().filter(|&&distance| distance >= 0.0).count() as u64;
        self.maps.iter().map(traced).sum()
    }

    /// Of a point of a map, in texels; None outside the cone.
    fn direction(&self, at: Vec2) -> Option<Vec3> {
        let p = at * (2.0 / self.side as f32) - 1.0;
        let r2 = p.length_squared();
        (r2 < 1.0).then(|| {
            // 1 - cos θ = r² height: equal areas for equal solid angles.
            let versine = r2 * self.height;
            let scale = ((2.0 - versine) * self.height).sqrt();
            let [across, aside, axis] = self.axes;
            (across * (p.x * scale) + aside * (p.y * scale) + axis * (1.0 - versine)).normalize()
        })
    }

    /// Expected share of the light that gets to a place, in (0, 1). Of a sun and of a sky it is not known.
    pub(crate) fn visibility(&self, place: Vec3) -> f32 {
        if self.maps.is_empty() {
            return 0.5;
        }
        self.maps.iter().map(|map| self.visibility_from(map, place)).sum::<f32>() / self.maps.len() as f32
    }

    fn visibility_from(&self, (origin, distances): &(Vec3, Vec<f32>), place: Vec3) -> f32 {
        let offset = place - *origin;
        let distance = offset.length();
        let [across, aside, axis] = self.axes.map(|axis| axis.dot(offset));
        let scale = ((1.0 + axis / distance) * self.height).sqrt() * distance;
        let at = (Vec2::new(across, aside) / scale + 1.0) * (0.5 * self.side as f32);
        let (mut lit, mut all) = (0.5 * DOUBT, DOUBT);
        // The texel and its neighbours, the farther ones as far as the texel's own width around the place reaches into them.
        let first = (at - 1.0).floor();
        for number in 0..9 {
            let texel = first + Vec2::new((number % 3) as f32, (number / 3) as f32);
            let share = (1.5 - (texel + 0.5 - at).abs()).clamp(Vec2::ZERO, Vec2::ONE).element_product();
            let inside = texel.cmpge(Vec2::ZERO).all() && texel.cmplt(Vec2::splat(self.side as f32)).all();
            if !(inside && share > 0.0) {
                continue;
            }
            let found = distances[(texel.y as u32 * self.side + texel.x as u32) as usize];
            if found >= 0.0 {
                all += share;
                lit += if found >= distance { share } else { 0.0 };
            }
        }
        lit / all
    }
}
