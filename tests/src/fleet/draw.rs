//! Draws a scene: room, camera, fog and lamps, around the objects of [`super::objects`].
//!
//! Everything is drawn in metres for a room of ordinary size and written at the scene's own scale: lengths by the scale s, coefficients by
//! 1/s, intensities by s², so that the picture does not change with it.

use super::objects::{Clear, Obstacle, Plate};
use super::text::{Text, color, number, vector};
use crate::random::Stream;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// The box x in ±width/2, y in 0..height, z in ±depth/2.
pub(super) struct Room {
    pub(super) size: DVec3,
}

impl Room {
    pub(super) fn min(&self) -> DVec3 {
        DVec3::new(-0.5 * self.size.x, 0.0, -0.5 * self.size.z)
    }

    pub(super) fn max(&self) -> DVec3 {
        DVec3::new(0.5 * self.size.x, self.size.y, 0.5 * self.size.z)
    }

    /// Whether a ball around `point` stays clear of the walls.
    pub(super) fn holds(&self, point: DVec3, radius: f64) -> bool {
        (point - self.min()).min_element() > radius && (self.max() - point).min_element() > radius
    }

    /// From a point inside to the wall.
    fn wall(&self, origin: DVec3, direction: DVec3) -> f64 {
        let to = DVec3::select(direction.cmpgt(DVec3::ZERO), self.max(), self.min());
        let distance = (to - origin) / direction;
        distance.min_element()
    }

    pub(super) fn place(&self, stream: &mut Stream) -> DVec3 {
        self.min() + self.size * DVec3::new(stream.uniform(), stream.uniform(), stream.uniform())
    }
}

/// What the camera sees.
pub(super) struct View {
    pub(super) position: DVec3,
    look_at: DVec3,
    /// Degrees.
    fov: f64,
}

impl View {
    fn draw(room: &Room, stream: &mut Stream) -> Self {
        let at = |stream: &mut Stream, low: [f64; 3], high: [f64; 3]| {
            let share = DVec3::from_array(std::array::from_fn(|axis| stream.between(low[axis], high[axis])));
            room.min() + room.size * share
        };
        Self {
            position: at(stream, [0.2, 0.2, 0.03], [0.8, 0.65, 0.1]),
            look_at: at(stream, [0.35, 0.3, 0.45], [0.65, 0.6, 0.75]),
            fov: stream.between(38.0, 65.0),
        }
    }

    /// The direction through (u, v), -1..1 across the picture.
    fn direction(&self, [u, v]: [f64; 2]) -> DVec3 {
        let forward = (self.look_at - self.position).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let slope = (0.5 * self.fov).to_radians().tan();
        (forward + slope * (u * right + v * right.cross(forward))).normalize()
    }

    fn sees(&self, point: DVec3) -> bool {
        let forward = (self.look_at - self.position).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let (offset, slope) = (point - self.position, (0.5 * self.fov).to_radians().tan());
        let edge = slope * offset.dot(forward);
        offset.dot(right).abs() < edge && offset.dot(right.cross(forward)).abs() < edge
    }

    /// A place in the picture, in the middle stretch of the way to the wall behind it.
    pub(super) fn place(&self, room: &Room, stream: &mut Stream, spread: f64, depth: [f64; 2]) -> DVec3 {
        let direction = self.direction([stream.between(-spread, spread), stream.between(-spread, spread)]);
        let distance = stream.between(depth[0], depth[1]) * room.wall(self.position, direction);
        self.position + distance * direction
    }
}

/// True with this probability.
pub(super) fn chance(stream: &mut Stream, probability: f64) -> bool {
    stream.uniform() < probability
}

/// One of some, with these weights.
pub(super) fn pick<T: Copy>(stream: &mut Stream, choices: &[(f64, T)]) -> T {
    let mut left = stream.uniform() * choices.iter().map(|choice| choice.0).sum::<f64>();
    for &(weight, choice) in choices {
        left -= weight;
        if left < 0.0 {
            return choice;
        }
    }
    choices[choices.len() - 1].1
}

/// A colour whose largest channel is `value`; grey more often than not.
pub(super) fn tint(stream: &mut Stream, value: f64, least: f64) -> DVec3 {
    if chance(stream, 0.6) {
        return DVec3::splat(value);
    }
    let mut shares = DVec3::new(1.0, stream.between(least, 1.0), stream.between(least, 1.0));
    for _ in 0..(3.0 * stream.uniform()) as u32 {
        shares = DVec3::new(shares.z, shares.x, shares.y);
    }
    value * shares
}

/// Where the fog is.
#[derive(Clone, Copy, PartialEq)]
enum Fog {
    Uniform,
    Exponential,
    Smoke,
    /// In a box of clear sides (a dielectric of index 1, or nearly), with the camera in the vacuum outside.
    Inside {
        index: f64,
    },
}

/// Scene file number `key[1]` of the fleet `key[0]`, candidate `key[2]`.
pub(super) fn scene(key: [u64; 3], width: u32) -> String {
    // Odd multipliers keep the streams of neighbouring keys apart; the stream itself mixes well.
    let mut stream = Stream::new(
        key[0].wrapping_mul(0xD6E8_FEB8_6659_FD93)
            ^ key[1].wrapping_mul(0xA076_1D64_78BD_642F)
            ^ key[2].wrapping_mul(0xE703_7ED1_A0B4_28DB),
    );
    let stream = &mut stream;
    let room = Room {
        size: DVec3::new(stream.between(4.0, 9.0), stream.between(3.0, 6.0), stream.between(6.0, 12.0)),
    };
    // The room is 1e-2 to 1e3 long.
    let scale = stream.decades(-2.0, 3.0) / room.size.z;
    let view = View::draw(&room, stream);
    let mut text = Text::new(scale);
    let fog = pick(
        stream,
        &[
            (5.0, Fog::Uniform),
            (1.5, Fog::Exponential),
            (1.5, Fog::Smoke),
            (0.8, Fog::Inside { index: 1.0 }),
            (0.4, Fog::Inside { index: 1.2 }),
        ],
    );
    // The box of clear sides stands clear of camera and walls.
    let fog_box = [room.min() + room.size * DVec3::new(0.15, 0.06, 0.3), room.max() - 0.15 * room.size];
    if !matches!(fog, Fog::Inside { .. }) {
        text.field("outside_medium", "\"fog\"");
    }
    write_camera(&mut text, &view, width);
    let milk = write_media(&mut text, &room, fog, stream);
    write_walls(&mut text, &room, stream);
    let mut clear = Clear { room, view, inside: None, obstacles: Vec::new() };
    if let Fog::Inside { index } = fog {
        text.line("\n[[object]]\nname = \"fog box\"\nshape = \"box\"");
        text.point("min", fog_box[0]);
        text.point("max", fog_box[1]);
        text.field("material", format!("{{ dielectric = {{ index = {index:?} }} }}"));
        text.field("inside", "\"fog\"");
        clear.inside = Some(fog_box);
    }
    let plate = (clear.inside.is_none() && chance(stream, 0.3)).then(|| Plate::draw(&clear, stream));
    if let Some(plate) = &plate {
        plate.write(&mut text, [clear.room.min(), clear.room.max()], stream);
        clear.obstacles.push(Obstacle::Plate(plate.clone()));
    }
    let objects = (5.0 * stream.uniform()) as u32;
    for _ in 0..objects {
        clear.add_object(&mut text, milk, stream);
    }
    write_lamps(&mut text, &clear, plate.as_ref(), stream);
    text.finish()
}

fn write_camera(text: &mut Text, view: &View, width: u32) {
    text.line("\n[camera]");
    text.point("position", view.position);
    text.point("look_at", view.look_at);
    text.field("vertical_fov", number(view.fov));
    text.field("width", width.to_string());
    text.field("height", width.to_string());
}

/// Also writes a second medium, for the insides of glass, now and then; says whether it did.
fn write_media(text: &mut Text, room: &Room, fog: Fog, stream: &mut Stream) -> bool {
    // Optical thickness from wall to wall; fog that is only in a part of the room is denser there.
    let thickness = stream.decades(-1.0, 0.6);
    let extinction = match fog {
        Fog::Smoke => 10.0 * thickness / room.size.z,
        Fog::Inside { .. } => 2.0 * thickness / room.size.z,
        _ => thickness / room.size.z,
    };
    write_medium(text, "fog", extinction, stream);
    match fog {
        Fog::Exponential => {
            let height = number(text.scale * room.size.y * stream.between(0.25, 1.5));
            text.field(
                "density",
                format!("{{ exponential = {{ origin = [0.0, 0.0, 0.0], scale_height = {height} }} }}"),
            );
        }
        Fog::Smoke => {
            // The file's plume is twice as high as wide.
            let height = room.size.y * stream.between(0.6, 0.9);
            let half = 0.5 * height * stream.between(0.4, 0.9);
            let centre = DVec3::new(stream.between(-0.1, 0.1), 0.0, stream.between(0.0, 0.2)) * room.size;
            let low = centre + DVec3::new(-half, 0.02 * room.size.y, -half);
            let high = centre + DVec3::new(half, height, half);
            let (low, high) = (text.scaled(low), text.scaled(high));
            text.field(
                "density",
                format!("{{ volume = {{ file = \"volumes/smoke.vol\", min = {low}, max = {high} }} }}"),
            );
        }
        Fog::Uniform | Fog::Inside { .. } => {}
    }
    let milk = chance(stream, 0.3);
    if milk {
        write_medium(text, "milk", stream.decades(-0.5, 0.5), stream);
    }
    milk
}

/// `extinction`: of the largest channel \[1/m\].
fn write_medium(text: &mut Text, name: &str, extinction: f64, stream: &mut Stream) {
    let albedo = if chance(stream, 0.04) { 0.0 } else { stream.between(0.2, 0.95) };
    let extinction = extinction / text.scale;
    text.line("\n[[medium]]");
    text.field("name", format!("\"{name}\""));
    text.field("scattering", color(tint(stream, albedo * extinction, 0.4)));
    text.field("absorption", color(tint(stream, (1.0 - albedo) * extinction, 0.2)));
    let phase = match stream.uniform() {
        ..0.4 => "\"isotropic\"".to_owned(),
        ..0.55 => "\"rayleigh\"".to_owned(),
        _ => format!("{{ henyey_greenstein = {} }}", number(stream.between(-0.5, 0.85))),
    };
    text.field("phase", phase);
}

fn write_walls(text: &mut Text, room: &Room, stream: &mut Stream) {
    let albedo = stream.between(0.05, 0.6);
    let lambert = format!("{{ lambert = {{ albedo = {} }} }}", color(tint(stream, albedo, 0.3)));
    let (walls, floor) = pick(stream, &[(0.5, (false, false)), (0.15, (true, false)), (0.35, (false, true))]);
    text.line("\n[[object]]\nname = \"room\"\nshape = \"box\"");
    // A floor of its own is inside the black box.
    let drop = if floor { DVec3::new(0.0, 0.01, 0.0) } else { DVec3::ZERO };
    text.point("min", room.min() - drop);
    text.point("max", room.max());
    text.field("material", if walls { lambert.as_str() } else { "\"black\"" });
    if floor {
        text.line("\n[[object]]\nname = \"floor\"\nshape = \"rectangle\"");
        text.point("corner", room.min());
        text.point("edge_u", DVec3::new(0.0, 0.0, room.size.z));
        text.point("edge_v", DVec3::new(room.size.x, 0.0, 0.0));
        text.field("material", &lambert);
    }
}

/// Tries for places that keep clear of everything.
const PLACES: u32 = 200;

fn write_lamps(text: &mut Text, clear: &Clear, plate: Option<&Plate>, stream: &mut Stream) {
    let count = pick(stream, &[(0.6, 1), (0.25, 2), (0.15, 3)]);
    for index in 0..count {
        // Without the plate's light, it would hide nothing.
        let behind = plate.filter(|_| index == 0);
        let Some(position) = (0..PLACES).find_map(|_| lamp_place(clear, behind, stream)) else { continue };
        let target = match behind {
            Some(plate) => plate.centre,
            None => clear.target(stream),
        };
        // Watts per channel; the first lamp sets the exposure.
        let flux = if index == 0 { 100.0 } else { 100.0 * stream.decades(-1.2, 0.3) };
        let flux = tint(stream, flux, 0.4);
        write_lamp(text, position, target, flux, index == 0, stream);
    }
}

/// In the picture or out of it, half of the time each; high up, more often than not.
fn lamp_place(clear: &Clear, behind: Option<&Plate>, stream: &mut Stream) -> Option<DVec3> {
    let (room, view) = (&clear.room, &clear.view);
    let place = match (behind, chance(stream, 0.5)) {
        (Some(plate), _) => plate.beyond(room, stream),
        (None, true) => view.place(room, stream, 0.9, [0.3, 0.9]),
        (None, false) => {
            let mut place = room.place(stream);
            place.y = place.y.max(room.place(stream).y);
            if view.sees(place) {
                return None;
            }
            place
        }
    };
    let apart = (place - view.position).length() > 0.12 * room.size.z;
    (apart && clear.is_free(place, 0.05 * room.size.y)).then_some(place)
}

fn write_lamp(
    text: &mut Text,
    position: DVec3,
    target: DVec3,
    flux: DVec3,
    first: bool,
    stream: &mut Stream,
) {
    text.line("\n[[light]]");
    let intensity = |solid_angle: f64, text: &Text| color(flux * (text.scale * text.scale / solid_angle));
    match stream.uniform() {
        kind if kind < if first { 0.7 } else { 0.4 } => {
            let inner = stream.decades(0.6, 1.5);
            let outer = inner * stream.between(1.03, 1.5);
            text.field("kind", "\"spot\"");
            text.point("position", position);
            text.point("look_at", target);
            let value = intensity(TAU * (1.0 - outer.to_radians().cos()), text);
            text.field("intensity", value);
            text.field("inner_angle", number(inner));
            text.field("outer_angle", number(outer));
        }
        ..0.85 => {
            text.field("kind", "\"point\"");
            text.point("position", position);
            let value = intensity(2.0 * TAU, text);
            text.field("intensity", value);
        }
        _ => {
            let radius = stream.decades(-1.7, -0.7);
            let normal = (target - position).normalize();
            // Next to a lamp that is seen nothing else would count.
            text.field("visible", "false");
            // Radiance does not change with the scale.
            match stream.uniform() {
                ..0.4 => {
                    text.field("kind", "\"disk\"");
                    text.point("center", position);
                    text.field("normal", vector(normal));
                    text.length("radius", radius);
                    text.field("radiance", color(flux / (PI * PI * radius * radius)));
                }
                ..0.7 => {
                    text.field("kind", "\"sphere\"");
                    text.point("center", position);
                    text.length("radius", radius);
                    text.field("radiance", color(flux / (4.0 * PI * PI * radius * radius)));
                }
                _ => {
                    // Aslant, and up to four times as long as wide.
                    let (e, f) = normal.any_orthonormal_pair();
                    let long = stream.between(1.0, 4.0);
                    let (edge_u, edge_v) = (long * radius * e, radius * (f + stream.between(-0.5, 0.5) * e));
                    text.field("kind", "\"rectangle\"");
                    text.point("corner", position - 0.5 * (edge_u + edge_v));
                    text.field("edge_u", text.scaled(edge_u));
                    text.field("edge_v", text.scaled(edge_v));
                    let area = edge_u.cross(edge_v).length();
                    text.field("radiance", color(flux / (PI * area)));
                }
            }
        }
    }
}
