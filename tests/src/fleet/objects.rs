//! Draws what stands in the room: balls, boxes, meshes, and plates with holes.

use super::draw::{Room, View, chance, tint};
use super::meshes;
use super::text::{Text, color, number, vector};
use crate::random::Stream;
use glam::DVec3;

/// What is already in the room, which everything else keeps clear of.
pub(super) struct Clear {
    pub(super) room: Room,
    pub(super) view: View,
    /// Objects stay inside this box, if there is one, and lamps off its sides.
    pub(super) inside: Option<[DVec3; 2]>,
    pub(super) obstacles: Vec<Obstacle>,
}

pub(super) enum Obstacle {
    Ball { centre: DVec3, radius: f64 },
    Plate(Plate),
}

impl Clear {
    /// Whether a ball there meets nothing.
    pub(super) fn is_free(&self, centre: DVec3, radius: f64) -> bool {
        let off_box = self.inside.is_none_or(|[min, max]| {
            let within = (centre - min).min_element() > radius && (max - centre).min_element() > radius;
            let beyond = (min - centre).max_element() > radius || (centre - max).max_element() > radius;
            within || beyond
        });
        let apart = |obstacle: &Obstacle| match obstacle {
            Obstacle::Ball { centre: other, radius: wide } => centre.distance(*other) > radius + wide,
            Obstacle::Plate(plate) => (centre - plate.centre)[plate.axis].abs() > radius,
        };
        off_box && self.room.holds(centre, radius) && self.obstacles.iter().all(apart)
    }

    /// What a lamp points at: an object, more often than not, or a place in the picture.
    pub(super) fn target(&self, stream: &mut Stream) -> DVec3 {
        let balls: Vec<DVec3> = self
            .obstacles
            .iter()
            .filter_map(|obstacle| match obstacle {
                Obstacle::Ball { centre, .. } => Some(*centre),
                Obstacle::Plate(_) => None,
            })
            .collect();
        if !balls.is_empty() && chance(stream, 0.6) {
            return balls[(stream.uniform() * balls.len() as f64) as usize];
        }
        self.view.place(&self.room, stream, 0.6, [0.3, 0.8])
    }

    /// Adds an object if there is room for it; `milk`: whether there is a medium of this name to fill glass with.
    pub(super) fn add_object(&mut self, text: &mut Text, milk: bool, stream: &mut Stream) {
        let radius = self.room.size.y * stream.between(0.05, 0.17);
        let on_floor = chance(stream, 0.3);
        let far = 0.12 * self.room.size.z + radius;
        let place = (0..50).find_map(|_| {
            let mut place = self.view.place(&self.room, stream, 0.75, [0.35, 0.8]);
            if on_floor && self.inside.is_none() {
                place.y = 1.04 * radius;
            }
            let inside = self.inside.is_none_or(|[min, max]| {
                (place - min).min_element() > radius && (max - place).min_element() > radius
            });
            let free = inside && place.distance(self.view.position) > far;
            (free && self.is_free(place, 1.02 * radius)).then_some(place)
        });
        let Some(centre) = place else { return };
        self.obstacles.push(Obstacle::Ball { centre, radius: 1.02 * radius });
        text.line("\n[[object]]");
        match stream.uniform() {
            ..0.45 => {
                text.field("shape", "\"sphere\"");
                text.point("center", centre);
                text.length("radius", radius);
            }
            ..0.7 => {
                let share =
                    DVec3::new(stream.between(0.4, 1.0), stream.between(0.4, 1.0), stream.between(0.4, 1.0));
                let half = radius * share / share.length();
                text.field("shape", "\"box\"");
                text.point("min", centre - half);
                text.point("max", centre + half);
            }
            kind => {
                let mesh = &meshes::ALL[(((kind - 0.7) / 0.3 * 3.0) as usize).min(2)];
                text.field("shape", "\"mesh\"");
                text.field("file", format!("{:?}", mesh.file));
                text.length("scale", radius);
                let (axis, degrees) =
                    (vector(stream.direction().as_dvec3()), number(stream.between(0.0, 360.0)));
                text.field("rotate", format!("{{ axis = {axis}, degrees = {degrees} }}"));
                text.point("translate", centre);
                text.field("smooth", mesh.smooth.to_string());
            }
        }
        match stream.uniform() {
            ..0.3 => {
                let index = number(stream.between(1.2, 1.8));
                text.field("material", format!("{{ dielectric = {{ index = {index} }} }}"));
                if milk && chance(stream, 0.5) {
                    text.field("inside", "\"milk\"");
                }
            }
            ..0.4 => {
                let reflectance = color(tint(stream, 0.9, 0.5));
                text.field("material", format!("{{ mirror = {{ reflectance = {reflectance} }} }}"));
            }
            ..0.7 => text.field("material", lambert(stream)),
            _ => text.field("material", "\"black\""),
        }
    }
}

fn lambert(stream: &mut Stream) -> String {
    let albedo = stream.between(0.1, 0.8);
    format!("{{ lambert = {{ albedo = {} }} }}", color(tint(stream, albedo, 0.3)))
}

/// A plate across the room with a hole in it, and perhaps bars across the hole.
#[derive(Clone)]
pub(super) struct Plate {
    /// Normal of the plate: 0 = x, 1 = y.
    pub(super) axis: usize,
    /// Of the hole.
    pub(super) centre: DVec3,
    /// Half the size of the hole along the two other axes.
    hole: [f64; 2],
    bars: u32,
}

impl Plate {
    /// A ceiling with a hole, or a wall with a window at one side.
    pub(super) fn draw(clear: &Clear, stream: &mut Stream) -> Self {
        let room = &clear.room;
        let axis = usize::from(chance(stream, 0.6));
        let mut centre = clear.view.place(room, stream, 0.4, [0.4, 0.7]);
        if axis == 1 {
            centre.y = room.size.y * stream.between(0.7, 0.85);
        } else {
            // The window is opposite to the camera's side.
            let side = if clear.view.position.x > 0.0 { -1.0 } else { 1.0 };
            centre.x = side * room.size.x * stream.between(0.3, 0.4);
            centre.y = room.size.y * stream.between(0.4, 0.7);
        }
        let hole = [stream.between(0.04, 0.18), stream.between(0.04, 0.18)].map(|share| share * room.size.y);
        let [along, across] = Self::others(axis);
        // Not cut off by a wall.
        for (axis, half) in [(along, hole[0]), (across, hole[1])] {
            let margin = 1.1 * half;
            centre[axis] = centre[axis].clamp(room.min()[axis] + margin, room.max()[axis] - margin);
        }
        let bars = if chance(stream, 0.5) { 0 } else { 1 + (3.0 * stream.uniform()) as u32 };
        Self { axis, centre, hole, bars }
    }

    fn others(axis: usize) -> [usize; 2] {
        [(axis + 1) % 3, (axis + 2) % 3]
    }

    /// A place for a lamp on the side where the camera is not.
    pub(super) fn beyond(&self, room: &Room, stream: &mut Stream) -> DVec3 {
        let out = if self.axis == 1 { room.max().y } else { room.max().x.copysign(self.centre.x) };
        let mut place = self.centre;
        place[self.axis] += (out - self.centre[self.axis]) * stream.between(0.4, 0.75);
        for axis in Self::others(self.axis) {
            place[axis] += 0.1 * room.size[axis] * stream.between(-1.0, 1.0);
        }
        place
    }

    pub(super) fn write(&self, text: &mut Text, room_walls: [DVec3; 2], stream: &mut Stream) {
        let material = if chance(stream, 0.6) { "\"black\"".to_owned() } else { lambert(stream) };
        let [along, across] = Self::others(self.axis);
        let [min, max] = room_walls;
        let (low_u, high_u) = (self.centre[along] - self.hole[0], self.centre[along] + self.hole[0]);
        let (low_v, high_v) = (self.centre[across] - self.hole[1], self.centre[across] + self.hole[1]);
        // Pieces overlap a little, so that rounding opens no gap between them.
        let lap = 0.02 * self.hole[0].min(self.hole[1]);
        let mut pieces = vec![
            [min[along], low_u, min[across], max[across]],
            [high_u, max[along], min[across], max[across]],
            [low_u - lap, high_u + lap, min[across], low_v],
            [low_u - lap, high_u + lap, high_v, max[across]],
        ];
        let pitch = 2.0 * self.hole[0] / f64::from(self.bars + 1);
        for bar in 1..=self.bars {
            let middle = low_u + pitch * f64::from(bar);
            pieces.push([middle - 0.2 * pitch, middle + 0.2 * pitch, low_v - lap, high_v + lap]);
        }
        for [from_u, to_u, from_v, to_v] in pieces {
            let mut corner = self.centre;
            (corner[along], corner[across]) = (from_u, from_v);
            let edge = |axis: usize, length: f64| {
                let mut edge = DVec3::ZERO;
                edge[axis] = length;
                edge
            };
            text.line("\n[[object]]\nname = \"plate\"\nshape = \"rectangle\"");
            text.point("corner", corner);
            text.point("edge_u", edge(along, to_u - from_u));
            text.point("edge_v", edge(across, to_v - from_v));
            text.field("material", &material);
        }
    }
}
