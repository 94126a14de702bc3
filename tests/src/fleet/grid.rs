//! Draws a scene whose lengths are quarters, as people's are: what is drawn stands on floors, against walls and on each other, lamps hang in
//! planes, suns and cameras look along axes. See [`super::snapped`].
//!
//! Each can be written with everything a hair apart: closed objects a hair larger, so that what touched overlaps a hair; lamps off their planes, on
//! the side that they shine to; suns tilted. Its picture is the same but for 1e-4.

use super::draw::{chance, pick, tint};
use super::text::color;
use crate::random::Stream;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

#[cfg(test)]
mod tests;

/// Of the scene's size.
const HAIR: f64 = 1e-4;

/// Light paths a pass.
const PATHS: u32 = 1000;

/// What surrounds what is drawn.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    /// A closed room.
    Room,
    /// A floor, and suns.
    Open,
    /// Water under a sun along the view: its light has no width, so that no path from the camera finds it behind the water's surface.
    Pool,
    /// A floor in coloured fog without end that absorbs nothing or little, where paths are long.
    Sea,
}

/// Scene file number `key[1]` of the fleet `key[0]`, candidate `key[2]`; `is_apart`: everything moved a hair.
pub(super) fn scene(key: [u64; 3], width: u32, is_apart: bool) -> String {
    let mut stream = Stream::new(
        key[0].wrapping_mul(0xD6E8_FEB8_6659_FD93)
            ^ key[1].wrapping_mul(0xA076_1D64_78BD_642F)
            ^ key[2].wrapping_mul(0xE703_7ED1_A0B4_28DB)
            ^ 0x6A09_E667_F3BC_C908,
    );
    let stream = &mut stream;
    let place =
        pick(stream, &[(0.5, Place::Room), (0.26, Place::Open), (0.12, Place::Pool), (0.12, Place::Sea)]);
    // Tenths are no numbers of base two: what coincides does so but for rounding.
    let scale = pick(stream, &[(0.6, 1.0), (0.2, 0.1), (0.2, 100.0)]);
    let half = DVec3::new(quarters(stream, 2.0, 4.0), 0.0, quarters(stream, 2.5, 4.5));
    let (min, max) = (-half, half + DVec3::Y * quarters(stream, 3.0, 5.0));
    let hair = if is_apart { HAIR * (max - min).max_element() } else { 0.0 };
    let mut draft = Draft {
        scale,
        hair,
        min,
        max,
        head: String::new(),
        objects: Vec::new(),
        lamps: String::new(),
        taken: Vec::new(),
        fogs: Vec::new(),
        bends: false,
        number: 0,
    };
    match place {
        Place::Room => draft.room(width, stream),
        Place::Open => draft.open(width, stream),
        Place::Pool => draft.pool(width, stream),
        Place::Sea => draft.sea(width, stream),
    }
    draft.finish(stream)
}

/// A multiple of a quarter, in [low, high].
fn quarters(stream: &mut Stream, low: f64, high: f64) -> f64 {
    let steps = ((high - low) * 4.0).round() + 1.0;
    low + 0.25 * (steps * stream.uniform()).floor()
}

type Bounds = [DVec3; 2];

/// A scene in the making, in metres.
struct Draft {
    /// Scene units in a metre.
    scale: f64,
    /// How far things are moved; 0: not.
    hair: f64,
    min: DVec3,
    max: DVec3,
    head: String,
    objects: Vec<String>,
    lamps: String,
    /// What stands where.
    taken: Vec<Bounds>,
    /// Boxes of fog.
    fogs: Vec<Bounds>,
    /// Whether there is glass or a mirror: then lamps have a size.
    bends: bool,
    /// Of things that were moved.
    number: u32,
}

impl Draft {
    /// Objects are listed in any order.
    fn finish(mut self, stream: &mut Stream) -> String {
        for last in (1..self.objects.len()).rev() {
            let other = (stream.uniform() * (last + 1) as f64) as usize;
            self.objects.swap(last, other);
        }
        // Many short passes: a scene is rendered dozens of times.
        let render = format!("\n[render]\nphotons = {PATHS}\n");
        [self.head, self.objects.concat(), self.lamps, render].concat()
    }

    /// Half a hair to a whole one, another for each thing.
    fn hair(&mut self) -> f64 {
        self.number += 1;
        self.hair * (0.5 + 0.5 * (0.618_034 * f64::from(self.number)).fract())
    }

    fn length(&self, metres: f64) -> String {
        // Seven digits: those of single precision, and of a hair three.
        let rounded: f64 = format!("{:.6e}", metres * self.scale + 0.0).parse().expect("a number");
        format!("{rounded:?}")
    }

    fn point(&self, metres: DVec3) -> String {
        let [x, y, z] = metres.to_array().map(|length| self.length(length));
        format!("[{x}, {y}, {z}]")
    }

    /// A box, a hair larger.
    fn block(&mut self, [min, max]: Bounds, fields: &str) -> String {
        let hair = self.hair();
        self.exact_block([min - hair, max + hair], fields)
    }

    fn exact_block(&self, [min, max]: Bounds, fields: &str) -> String {
        let (min, max) = (self.point(min), self.point(max));
        format!("\n[[object]]\nshape = \"box\"\nmin = {min}\nmax = {max}\n{fields}\n")
    }

    fn floor(&mut self, material: &str) {
        let corner = self.point(self.min);
        let (u, v) = (self.length(self.max.z - self.min.z), self.length(self.max.x - self.min.x));
        self.objects.push(format!(
            "\n[[object]]\nname = \"floor\"\nshape = \"rectangle\"\ncorner = {corner}\nedge_u = [0, 0, {u}]\nedge_v = [{v}, 0, 0]\nmaterial = {material}\n"
        ));
    }

    fn medium(&mut self, name: &str, extinction: f64, stream: &mut Stream) {
        let albedo = stream.between(0.3, 0.95);
        let of = |share: f64, stream: &mut Stream| {
            if chance(stream, 0.35) {
                // Channels up to 100:1 apart.
                let (a, b) = (stream.decades(-2.0, 0.0), stream.decades(-2.0, 0.0));
                let shares = [DVec3::new(1.0, a, b), DVec3::new(a, 1.0, b), DVec3::new(a, b, 1.0)];
                2.0 * share * shares[(3.0 * stream.uniform()) as usize]
            } else {
                tint(stream, share, 0.4)
            }
        };
        let unit = extinction / self.scale;
        let (scattering, absorption) = (of(albedo * unit, stream), of((1.0 - albedo) * unit, stream));
        let phase = if chance(stream, 0.5) {
            "\"isotropic\"".to_owned()
        } else {
            format!("{{ henyey_greenstein = {:.1} }}", stream.between(-0.4, 0.8))
        };
        let _ = writeln!(
            self.head,
            "\n[[medium]]\nname = \"{name}\"\nscattering = {}\nabsorption = {}\nphase = {phase}",
            color(scattering),
            color(absorption)
        );
    }

    fn camera(&mut self, width: u32, view: &View) {
        let (position, look_at) = (self.point(view.position), self.point(view.position + 2.0 * view.forward));
        let size = match view.parallel {
            Some(size) => format!("projection = \"orthographic\"\nvertical_size = {}", self.length(size)),
            None => "vertical_fov = 60".to_owned(),
        };
        let up = if view.forward.y.abs() > 0.9 { "\nup = [0, 0, 1]" } else { "" };
        let _ = writeln!(
            self.head,
            "\n[camera]\nposition = {position}\nlook_at = {look_at}{up}\n{size}\nwidth = {width}\nheight = {width}"
        );
    }

    fn fog_box(&mut self, bounds: Bounds, medium: &str) {
        let fields = format!(
            "name = \"{medium}\"\nmaterial = {{ dielectric = {{ index = 1 }} }}\ninside = \"{medium}\""
        );
        let text = self.block(bounds, &fields);
        self.objects.push(text);
        self.fogs.push(bounds);
    }

    /// Fog that stands on the floor, in one box or in two that touch.
    fn fog(&mut self, bounds: Bounds, stream: &mut Stream) {
        if chance(stream, 0.5) {
            return self.fog_box(bounds, "fog");
        }
        let axis = (3.0 * stream.uniform()) as usize;
        let [min, max] = bounds;
        let middle = 0.25 * (2.0 * (min[axis] + max[axis])).round();
        let (mut low, mut high) = (max, min);
        (low[axis], high[axis]) = (middle, middle);
        self.fog_box([min, low], "fog");
        self.fog_box([high, max], "haze");
    }
}

struct View {
    position: DVec3,
    forward: DVec3,
    /// Height of what parallel rays show.
    parallel: Option<f64>,
}

impl Draft {
    fn room(&mut self, width: u32, stream: &mut Stream) {
        let (min, max) = (self.min, self.max);
        let size = max - min;
        let everywhere = chance(stream, 0.3);
        if everywhere {
            self.head += "outside_medium = \"fog\"\n";
        }
        // On a quarter of the depth a box of fog begins.
        let front = min.z + quarters(stream, 1.0, 2.0);
        let view = self.view_in_room(front, stream);
        self.camera(width, &view);
        let thickness = stream.decades(-0.6, 0.4) / size.z;
        self.medium("fog", thickness, stream);
        self.medium("haze", 1.5 * stream.decades(-0.6, 0.4) / size.z, stream);
        self.medium("drink", stream.decades(-0.3, 0.6), stream);
        let lambert = matt(stream);
        let is_black = chance(stream, 0.6);
        if is_black {
            let drop = chance(stream, 0.6);
            if drop {
                self.floor(&lambert);
            }
            let below = if drop { 0.25 * DVec3::Y } else { DVec3::ZERO };
            self.objects.push(self.exact_block([min - below, max], "name = \"room\"\nmaterial = \"black\""));
        } else {
            let fields = format!("name = \"room\"\nmaterial = {lambert}");
            self.objects.push(self.exact_block([min, max], &fields));
        }
        if !everywhere {
            let mut bounds = [min, max];
            if chance(stream, 0.7) {
                bounds[0].z = front;
                bounds[1].y = quarters(stream, 0.25 * (2.0 * max.y).round(), max.y);
                if chance(stream, 0.5) {
                    (bounds[0].x, bounds[1].x) = (min.x + 0.5, max.x - 0.5);
                }
            }
            self.fog(bounds, stream);
        }
        self.things(&view, stream);
        self.lamps(&view, is_black, stream);
    }

    fn view_in_room(&self, front: f64, stream: &mut Stream) -> View {
        let (min, max) = (self.min, self.max);
        let middle = 0.25 * (2.0 * max.y).round();
        let is_parallel = chance(stream, 0.35);
        if chance(stream, 0.2) {
            let size = (max.x - min.x).min(max.z - min.z) - 0.5;
            let position = DVec3::new(0.0, max.y - 0.25, 0.0);
            return View { position, forward: -DVec3::Y, parallel: is_parallel.then_some(size) };
        }
        if is_parallel {
            let size = (max.x - min.x).min(max.y) - 0.5;
            let position = DVec3::new(0.0, middle, min.z + 0.25);
            return View { position, forward: DVec3::Z, parallel: Some(size) };
        }
        // On the face where fog begins, or in front of it.
        let z = if chance(stream, 0.3) { front } else { min.z + 0.5 };
        let position = DVec3::new(quarters(stream, -1.0, 1.0), middle, z);
        let aside = DVec3::new(quarters(stream, -1.0, 1.0), quarters(stream, 0.25, max.y - 0.5), 1.0);
        let forward = if chance(stream, 0.6) { DVec3::Z } else { (aside - position).normalize() };
        View { position, forward, parallel: None }
    }

    fn open(&mut self, width: u32, stream: &mut Stream) {
        let (min, max) = (self.min, self.max);
        let is_parallel = chance(stream, 0.4);
        let middle = 0.25 * (2.0 * max.y).round();
        let back = if is_parallel { 1.0 } else { 4.0 };
        let position = DVec3::new(0.0, middle, min.z - back);
        let parallel = is_parallel.then_some((max.x - min.x).min(max.y));
        let view = View { position, forward: DVec3::Z, parallel };
        self.camera(width, &view);
        for (name, factor) in [("fog", 1.0), ("haze", 1.5), ("drink", 6.0)] {
            let thickness = factor * stream.decades(-0.6, 0.4) / (max.z - min.z);
            self.medium(name, thickness, stream);
        }
        let material = if chance(stream, 0.7) { matt(stream) } else { "\"black\"".to_owned() };
        self.floor(&material);
        let inset = if chance(stream, 0.5) { 0.0 } else { 0.5 };
        let low = DVec3::new(min.x + inset, 0.0, min.z + inset);
        let high = DVec3::new(max.x - inset, quarters(stream, 1.5, max.y), max.z - inset);
        self.fog([low, high], stream);
        self.things(&view, stream);
        if chance(stream, 0.7) {
            self.sun(&view, stream);
        } else {
            self.lamps(&view, false, stream);
        }
    }

    /// Water that stands on a floor, or a tank of it on edge, and a sun along the view or against it.
    fn pool(&mut self, width: u32, stream: &mut Stream) {
        let (min, max) = (self.min, self.max);
        let from_above = chance(stream, 0.6);
        let top = quarters(stream, 1.0, 2.0);
        let (position, forward) = if from_above {
            (DVec3::new(0.0, top + 2.0, 0.0), -DVec3::Y)
        } else {
            (DVec3::new(0.0, 0.5 * top, min.z - 1.0), DVec3::Z)
        };
        let size = if from_above { 2.0 } else { 0.5 * top };
        self.camera(width, &View { position, forward, parallel: Some(size) });
        self.medium("water", stream.decades(-0.6, 0.0), stream);
        let material = if chance(stream, 0.5) { matt(stream) } else { "\"black\"".to_owned() };
        self.floor(&material);
        let fields = "name = \"water\"\nmaterial = { dielectric = { index = 1.33 } }\ninside = \"water\"";
        let bounds = [min, max.with_y(top)];
        let text = self.block(bounds, fields);
        self.objects.push(text);
        // From below the floor would hide it.
        let direction = if from_above || chance(stream, 0.5) { forward } else { -forward };
        self.write_sun(direction, 0.0, stream);
    }

    fn sea(&mut self, width: u32, stream: &mut Stream) {
        self.head += "outside_medium = \"sea\"\n";
        let position = DVec3::new(0.0, quarters(stream, 1.0, 2.0), self.min.z - 2.0);
        self.camera(width, &View { position, forward: DVec3::Z, parallel: None });
        let (a, b) = (stream.decades(-1.5, 0.0), stream.decades(-0.7, 0.0));
        let shares = [DVec3::new(a, b, 1.0), DVec3::new(a, 1.0, b), DVec3::new(1.0, a, b)];
        let scattering = 0.5 / self.scale * shares[(3.0 * stream.uniform()) as usize];
        let absorption = if chance(stream, 0.5) { DVec3::ZERO } else { 0.01 * scattering };
        let _ = writeln!(
            self.head,
            "\n[[medium]]\nname = \"sea\"\nscattering = {}\nabsorption = {}\nphase = {{ henyey_greenstein = 0.5 }}",
            color(scattering),
            color(absorption)
        );
        let material = matt(stream);
        self.floor(&material);
        let place = DVec3::new(0.0, quarters(stream, 3.0, 4.0), 0.0);
        self.lamp(place, DVec3::splat(100.0), true, stream);
    }

    fn write_sun(&mut self, direction: DVec3, angle: f64, stream: &mut Stream) {
        // A tilt by as much as things move, relative to the scene.
        let tilt = if self.hair > 0.0 { HAIR } else { 0.0 };
        let [x, y, z] = (direction + tilt * direction.any_orthonormal_vector()).to_array();
        let irradiance = color(tint(stream, 1.0, 0.4));
        let _ = writeln!(
            self.lamps,
            "\n[[light]]\nkind = \"sun\"\ndirection = [{x:?}, {y:?}, {z:?}]\nangle = {angle:?}\nirradiance = {irradiance}"
        );
    }

    fn sun(&mut self, view: &View, stream: &mut Stream) {
        let directions = [
            -DVec3::Y,
            DVec3::X,
            view.forward,
            -view.forward,
            DVec3::new(1.0, -1.0, 0.0),
            DVec3::new(0.0, -1.0, 1.0),
        ];
        let direction = directions[(6.0 * stream.uniform()) as usize];
        // Behind glass paths must find it.
        let angle = if self.bends { 20.0 } else { pick(stream, &[(0.5, 0.0), (0.3, 1.0), (0.2, 10.0)]) };
        self.write_sun(direction, angle, stream);
    }
}

fn matt(stream: &mut Stream) -> String {
    let albedo = stream.between(0.2, 0.7);
    format!("{{ lambert = {{ albedo = {} }} }}", color(tint(stream, albedo, 0.4)))
}

fn grown([min, max]: Bounds, by: f64) -> Bounds {
    [min - by, max + by]
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a[0].cmplt(b[1]).all() && b[0].cmplt(a[1]).all()
}

fn holds(outer: &Bounds, inner: &Bounds) -> bool {
    outer[0].cmple(inner[0]).all() && outer[1].cmpge(inner[1]).all()
}

impl Draft {
    /// What stands in the scene.
    fn things(&mut self, view: &View, stream: &mut Stream) {
        for _ in 0..(4.0 * stream.uniform()) as u32 {
            let Some(bounds) = (0..50).find_map(|_| self.free(view, stream)) else { continue };
            self.taken.push(bounds);
            match stream.uniform() {
                ..0.4 => self.solid(bounds, stream),
                ..0.55 => self.ball(bounds, stream),
                ..0.8 => self.stack(bounds, stream),
                _ => self.glass(bounds, stream),
            }
        }
    }

    /// A place on the floor, beside the last thing that stands there more often than not.
    fn free(&self, view: &View, stream: &mut Stream) -> Option<Bounds> {
        let (min, max) = (self.min, self.max);
        let size = [0.75, 0.75, 0.75].map(|least| quarters(stream, least, 1.5));
        let mut low = DVec3::new(
            quarters(stream, min.x, max.x - size[0]),
            0.0,
            quarters(stream, -0.25 * max.z.floor(), max.z - size[2]),
        );
        if let (Some(last), true) = (self.taken.last(), chance(stream, 0.6)) {
            (low.x, low.z) = (last[1].x, last[0].z);
        }
        let bounds = [low, low + DVec3::from_array(size)];
        let inside = holds(&[min, max], &bounds);
        let apart = self.taken.iter().all(|other| !overlap(other, &bounds));
        // Wholly inside of a box of fog, or outside of it.
        let fogs = self.fogs.iter().all(|fog| holds(fog, &bounds) || !overlap(fog, &bounds));
        let seen = !overlap(&grown(bounds, 0.75), &[view.position - 0.01, view.position + 0.01]);
        (inside && apart && fogs && seen).then_some(bounds)
    }

    fn solid(&mut self, bounds: Bounds, stream: &mut Stream) {
        let material = match stream.uniform() {
            ..0.4 => matt(stream),
            ..0.75 => "\"black\"".to_owned(),
            _ => {
                self.bends = true;
                "{ mirror = { reflectance = 0.8 } }".to_owned()
            }
        };
        let text = self.block(bounds, &format!("material = {material}"));
        self.objects.push(text);
    }

    /// That touches the floor.
    fn ball(&mut self, [min, max]: Bounds, stream: &mut Stream) {
        let radius = 0.5 * (max - min).min_element();
        let center = DVec3::new(0.5 * (min.x + max.x), radius, 0.5 * (min.z + max.z));
        let material = if chance(stream, 0.5) {
            matt(stream)
        } else {
            self.bends = true;
            "{ dielectric = { index = 1.5 } }".to_owned()
        };
        let hair = self.hair();
        let (center, radius) = (self.point(center), self.length(radius + hair));
        self.objects.push(format!(
            "\n[[object]]\nshape = \"sphere\"\ncenter = {center}\nradius = {radius}\nmaterial = {material}\n"
        ));
    }

    /// Two pieces of glass on each other, or one that reaches into the other: then the later one counts, or
    /// the one of higher priority.
    fn stack(&mut self, [min, max]: Bounds, stream: &mut Stream) {
        self.bends = true;
        let middle = 0.5 * max.y;
        let upper = if chance(stream, 0.5) { 1.5 } else { 1.25 };
        let (reach, priority) =
            pick(stream, &[(0.7, (0.0, "")), (0.15, (0.125, "")), (0.15, (0.125, "\npriority = 1"))]);
        let lower = ([min, max.with_y(middle + reach)], 1.5, priority);
        for (bounds, index, priority) in [lower, ([min.with_y(middle), max], upper, "")] {
            let inside = if chance(stream, 0.3) { "\ninside = \"drink\"" } else { "" };
            let fields = format!("material = {{ dielectric = {{ index = {index} }} }}{inside}{priority}");
            let text = self.block(bounds, &fields);
            self.objects.push(text);
        }
    }

    /// A glass with a drink that fills it to the middle, as boxes in boxes, in the order that says which of
    /// them counts: the drink touches the glass, overlaps it, or leaves a gap.
    fn glass(&mut self, [min, max]: Bounds, stream: &mut Stream) {
        self.bends = true;
        let mut hollow = [min + 0.25, max - 0.25];
        let overlap = pick(stream, &[(0.5, 0.0), (0.25, 0.0625), (0.25, -0.0625)]);
        let drink = [hollow[0] - overlap, (hollow[1] + overlap).with_y(0.5 * max.y)];
        // No lid of a hair's thickness.
        hollow[1].y = max.y + 2.0 * self.hair;
        let index = if chance(stream, 0.5) { 1.33 } else { 1.5 };
        let text = [
            self.block([min, max], "name = \"glass\"\nmaterial = { dielectric = { index = 1.5 } }"),
            self.exact_block(hollow, "name = \"hollow\"\nmaterial = { dielectric = { index = 1 } }"),
            self.block(drink, &format!("name = \"drink\"\nmaterial = {{ dielectric = {{ index = {index} }} }}\ninside = \"drink\"")),
        ];
        // Of what overlaps by a hair the later one counts.
        self.objects.push(text.concat());
    }

    fn lamps(&mut self, view: &View, ceiling_is_black: bool, stream: &mut Stream) {
        let count = match stream.uniform() {
            ..0.55 => 1,
            ..0.8 => 2 + (3.0 * stream.uniform()) as u32,
            _ => stream.decades(1.5, 2.48) as u32,
        };
        for _ in 0..count {
            let flux = tint(stream, 100.0 / f64::from(count), 0.4);
            let Some((place, is_in_ceiling)) = (0..200).find_map(|_| self.lamp_place(view, stream)) else {
                continue;
            };
            let any_side = !is_in_ceiling || ceiling_is_black;
            self.lamp(place, flux, any_side, stream);
        }
    }

    /// In the ceiling, on a face of fog, or anywhere.
    fn lamp_place(&self, view: &View, stream: &mut Stream) -> Option<(DVec3, bool)> {
        let (min, max) = (self.min, self.max);
        let mut place = DVec3::new(
            quarters(stream, min.x + 0.5, max.x - 0.5),
            quarters(stream, 1.0, max.y - 0.5),
            quarters(stream, min.z + 1.0, max.z - 0.5),
        );
        match stream.uniform() {
            ..0.4 => place.y = max.y,
            ..0.7 => place.y = self.fogs.last().map_or(place.y, |fog| fog[1].y),
            _ => {}
        }
        let clear =
            self.taken.iter().all(|thing| !overlap(&grown(*thing, 0.5), &[place - 0.01, place + 0.01]));
        (clear && place.distance(view.position) > 1.0).then_some((place, place.y == max.y))
    }

    fn lamp(&mut self, mut place: DVec3, flux: DVec3, any_side: bool, stream: &mut Stream) {
        place.y -= self.hair();
        let kind = match (self.bends, any_side) {
            (false, true) => pick(stream, &[(0.4, 0), (0.2, 1), (0.15, 2), (0.15, 3), (0.1, 4)]),
            (false, false) => pick(stream, &[(0.4, 1), (0.3, 2), (0.3, 3)]),
            (true, true) => pick(stream, &[(0.3, 2), (0.4, 3), (0.3, 4)]),
            (true, false) => pick(stream, &[(0.5, 2), (0.5, 3)]),
        };
        let intensity = |solid_angle: f64| color(flux * (self.scale * self.scale / solid_angle));
        let at = self.point(place);
        let side = if self.bends { quarters(stream, 0.5, 1.0) } else { 0.25 };
        let radiance = |area: f64| color(flux / (PI * area));
        let text = match kind {
            0 => format!("kind = \"point\"\nposition = {at}\nintensity = {}", intensity(2.0 * TAU)),
            1 => {
                let look_at = self.point(place - DVec3::Y);
                let value = intensity(TAU * (1.0 - 45_f64.to_radians().cos()));
                format!(
                    "kind = \"spot\"\nposition = {at}\nlook_at = {look_at}\nintensity = {value}\ninner_angle = 30\nouter_angle = 45"
                )
            }
            2 => {
                let (length, value) = (self.length(0.5 * side), radiance(PI * 0.25 * side * side));
                format!(
                    "kind = \"disk\"\ncenter = {at}\nnormal = [0, -1, 0]\nradius = {length}\nradiance = {value}"
                )
            }
            3 => {
                let corner = self.point(place - 0.5 * side * DVec3::new(1.0, 0.0, 1.0));
                let (length, value) = (self.length(side), radiance(side * side));
                format!(
                    "kind = \"rectangle\"\ncorner = {corner}\nedge_u = [{length}, 0, 0]\nedge_v = [0, 0, {length}]\nradiance = {value}"
                )
            }
            _ => {
                let (length, value) = (self.length(0.5 * side), radiance(PI * side * side));
                format!("kind = \"sphere\"\ncenter = {at}\nradius = {length}\nradiance = {value}")
            }
        };
        let _ = writeln!(self.lamps, "\n[[light]]\n{text}");
    }
}
