//! The part of a photon's way on which there is light of it: of lamps with a size it begins and ends anywhere along their lines.

use crate::light::falloff::Falloff;
use crate::paths::photon::Photon;
use crate::paths::reception::Reception;
use crate::paths::record::{FieldSegment, PathBeam, PhotonRecord};
use crate::paths::segment::{Inside, Loss, PathSegment};
use covbeam::{Beam, Column, Medium};
use glam::Vec3;

impl Photon {
    /// Whether there is light at a distance on its way.
    #[inline]
    pub(super) fn is_lit(&self, distance: f32) -> bool {
        (self.dark..self.until).contains(&distance)
    }

    /// The part of its power that arrives so far along its way, but for what is lost there.
    #[inline]
    pub(super) fn faded(&self, distance: f32) -> f32 {
        if self.falloff.acts() { self.falloff.share(self.gone + distance) } else { 1.0 }
    }

    /// At a distance along its way it is turned, and from there on there is light all along that.
    #[inline]
    pub(super) fn begin(&mut self, distance: f32) {
        if self.falloff.acts() {
            self.power *= self.faded(distance);
            self.falloff = Falloff::default();
        }
        (self.dark, self.until, self.near) = (0.0, f32::INFINITY, 0.0);
        (self.seen_by, self.reception) = (self.reception.seen_by, Reception::PLAIN);
    }

    /// Goes along its way to where something happens to it.
    #[inline]
    pub(super) fn go(&mut self, distance: f32) {
        self.origin += distance * self.direction;
        self.gone += distance;
    }

    /// It has gone straight on.
    #[inline]
    pub(super) fn advance(&mut self, distance: f32) {
        self.dark = (self.dark - distance).max(0.0);
        self.until -= distance;
        self.near = (self.near - distance).max(0.0);
        self.reception = Reception::PLAIN;
        self.gone += distance;
    }

    /// Leaves the beam along a segment; where its light fades otherwise than by what the medium takes of it, the beams of its pieces.
    pub(super) fn leave_beams(&self, along: &PathSegment, out: &mut PhotonRecord) {
        let whole = self.beam(along);
        let (Some(whole), Some(inside)) = (whole, &along.inside) else { return };
        let is_kept = inside.loss == Loss::None;
        if !(self.falloff.acts() || is_kept) {
            return out.beams.push(whole);
        }
        let (dark, end) = (self.dark, self.dark + whole.beam.length);
        let mut leave = |[from, to]: [f32; 2], factor: Vec3| {
            let start_normal = if from == dark { whole.beam.start_normal } else { Vec3::ZERO };
            let end_normal = if to == end { whole.beam.end_normal } else { Vec3::ZERO };
            let (origin, power) =
                (self.origin + from * self.direction, self.power * factor * inside.lit(from));
            let beam = Beam { origin, length: to - from, power, start_normal, end_normal, ..whole.beam };
            out.beams.push(PathBeam { near: (whole.near - (from - dark)).max(0.0), beam, ..whole });
        };
        let mut divided = |ends, factor: f32| match is_kept {
            true => inside.pieces(ends, self.shift, |ends, kept| leave(ends, factor * kept)),
            false => leave(ends, Vec3::splat(factor)),
        };
        if !self.falloff.acts() {
            return divided([dark, end], 1.0);
        }
        let from_here = |distance: f32| distance - self.gone;
        for (ends, factor) in self.falloff.pieces([self.gone + dark, self.gone + end], self.shift) {
            let [from, to] = ends.map(from_here);
            divided([from.max(dark), to.min(end)], factor);
        }
    }

    /// The beam along a segment: to the next surface, or until nothing is left; None: there is no light of it, or
    /// nothing that scatters it.
    pub(super) fn beam(&self, along: &PathSegment) -> Option<PathBeam> {
        let inside = along.inside.as_ref()?;
        let Inside { id: medium, fog, opaque, scatters, .. } = *inside;
        let Photon { origin, direction, power, normal: start_normal, dark, .. } = *self;
        let opaque = opaque.min(self.until);
        let reach = along.reach;
        let length = reach.min(opaque) - dark;
        let end_normal = match along.hit {
            Some(hit) if reach <= opaque => {
                let against = if hit.geometric_normal.dot(direction) > 0.0 { -1.0 } else { 1.0 };
                against * hit.geometric_normal
            }
            _ => Vec3::ZERO,
        };
        let (origin, power) = if dark > 0.0 || !inside.dims() {
            (origin + dark * direction, power * inside.lit(dark))
        } else {
            (origin, power)
        };
        let beam = Beam { origin, direction, length, power, start_normal, end_normal };
        let is_beam = scatters && length >= 0.0 && length.is_finite() && fog.scattering.max_element() > 0.0;
        is_beam.then_some(PathBeam { medium, kind: self.kind(), near: self.near, beam })
    }

    /// The part of a segment of its light field on which there is light; None: no part.
    ///
    /// - `segment`: from where the photon is; `acting`: the medium as it acts on light fields.
    pub(super) fn lit_segment(
        &self,
        segment: FieldSegment,
        inside: &Inside,
        acting: &Medium,
    ) -> Option<FieldSegment> {
        let dark = self.dark;
        let mut lit = FieldSegment { length: segment.length.min(self.until) - dark, ..segment };
        if dark > 0.0 {
            lit.origin += dark * self.direction;
            lit.field = segment.with(Column::Uniform).field_at(acting, dark);
            // Edges before that lie behind it then.
            lit.edges.iter_mut().for_each(|edge| edge.depth -= dark);
            let left = self.power * inside.fog.transmittance(inside.column.at(dark));
            lit.power *= left.element_sum() / self.power.element_sum();
        }
        (lit.length >= 0.0).then_some(lit)
    }
}

#[cfg(test)]
mod tests {
    use crate::kind::Kind;
    use crate::light::falloff::Falloff;
    use crate::paths::PhotonTracer;
    use crate::paths::record::{PhotonRecord, Record};
    use crate::pilot::of_still;
    use crate::random::{Emission, Random};
    use crate::scene::made::{BOUND, Made, camera, cuboid, rectangle, sphere};
    use crate::scene::optics::Interior;
    use crate::scene::passage::{Looks, passage};
    use crate::scene::{Area, Cone, Lamp, Light, Links, Lobes, Material, Rays, Scene, ShiningMesh, media};
    use glam::Vec3;

    const MIN: Vec3 = Vec3::new(0.1, -1.0, -1.2);
    const MAX: Vec3 = Vec3::new(1.6, 1.1, 0.9);
    const SCATTERING: f64 = 1e-3;
    const ABSORPTION: f64 = 0.7;

    /// A box of fog through which a lamp reaches, with a black ball and a curtain that lets half of the light through.
    fn unlit() -> Made {
        let (transparent, diffuse) = (Vec3::splat(0.5), Vec3::splat(0.3));
        let curtain = Material::Lobes(Lobes { transparent, diffuse, ..Lobes::NONE });
        Made::new(camera([0.0, 0.0, -9.0], [0.8, 0.0, 0.0], 20.0, [32, 32]))
            .fog(SCATTERING as f32, ABSORPTION as f32)
            .filled(cuboid(MIN.into(), MAX.into()), BOUND, 0)
            .object(sphere([0.35, 0.15, 0.0], 0.15), Material::Black)
            .object(rectangle([0.7, -0.9, -1.1], [0.0, 1.5, 0.0], [0.2, 0.0, 1.6]), curtain)
    }

    /// A lamp, all around or into a cone of 35° that falls off over two fifths of its height.
    fn lamp(radius: f32, soft: bool, has_cone: bool) -> Light {
        let position = Vec3::new(-0.1, 0.1, 0.0);
        let axis = (Vec3::X.as_dvec3() - position.as_dvec3()).normalize().as_vec3().normalize();
        let height = 2.0 * (0.5 * 35.0_f32.to_radians()).sin().powi(2);
        let cone = has_cone.then_some(Cone { axis, cosine: 1.0 - height, blend: 0.4 * height });
        let glow = Lamp::glow_of(radius, has_cone, 0.5 * (MAX - MIN).length());
        Light::Lamp(Lamp { position, intensity: Vec3::splat(3.0), radius, soft, cone, pattern: None, glow })
    }

    /// An ellipse behind a honeycomb.
    fn area() -> Light {
        Light::Area(Area {
            center: Vec3::new(0.0, 0.1, 0.0),
            edge_u: Vec3::new(0.2, 0.7, 0.0),
            edge_v: Vec3::new(0.0, 0.0, 0.9),
            round: true,
            spread: 40.0_f32.to_radians(),
            radiance: Vec3::splat(2.0),
        })
    }

    /// Two triangles.
    fn mesh() -> Light {
        let [a, b] = [Vec3::new(-0.3, -0.4, 0.2), Vec3::new(0.5, 0.3, 0.4)];
        let [c, d] = [Vec3::new(0.2, 0.5, -0.6), Vec3::new(0.3, -0.5, -0.5)];
        Light::Mesh(ShiningMesh::new(&[[a, b, c], [a, c, d]], Vec3::splat(2.0)).expect("triangles"))
    }

    /// Light in the box, ∫ fluence dV \[W m\], by shadow rays from places in it, and in the ball.
    fn by_shadow_rays(scene: &Scene) -> f64 {
        let fogs = media::all(scene);
        let inside = Interior::at(scene, MAX - 0.01);
        let mut random = Random::new([1, 1, 2, 3]);
        let count = 200_000;
        let links = scene.links_of(0);
        let mut sum = 0.0;
        for _ in 0..count {
            let mut pair = || [random.uniform(), random.uniform()];
            let ([x, y], [z, _], xi) = (pair(), pair(), pair());
            let place = MIN + Vec3::new(x, y, z) * (MAX - MIN);
            let (density, from) = scene.lights[0].flux_density(place, xi);
            sum += f64::from(
                links.falloff.at(place.distance(from))
                    * density.x
                    * passage(scene, &fogs, inside, [place, from], Looks::For(&links)).x,
            );
        }
        sum / f64::from(count) * (MAX - MIN).as_dvec3().element_product()
    }

    /// What is on a stretch of light's way.
    fn along(power: f32, length: f32) -> f64 {
        let extinction = SCATTERING + ABSORPTION;
        f64::from(power) * -(-extinction * f64::from(length)).exp_m1() / extinction
    }

    #[test]
    fn light_paths_leave_the_straight_light_that_shadow_rays_find() {
        let (smoothed, even) = (Falloff::new(0.0, 0.5, 5.0), Falloff::new(2.0, 0.0, 5.0));
        for (made, falloff, hidden) in [
            (unlit().light(lamp(0.4, true, false)), Falloff::default(), Rays::NONE),
            (unlit().light(lamp(0.4, false, false)), Falloff::default(), Rays::NONE),
            (unlit().light(lamp(0.5, true, true)), Falloff::default(), Rays::NONE),
            (unlit().light(lamp(0.5, false, true)), Falloff::default(), Rays::NONE),
            (unlit().light(area()), Falloff::default(), Rays::NONE),
            (unlit().light(mesh()), Falloff::default(), Rays::NONE),
            (unlit().sky(2.0), Falloff::default(), Rays::NONE),
            (unlit().light(area()), even, Rays::NONE),
            (unlit().light(lamp(0.4, true, false)), smoothed, Rays::NONE),
            (unlit().light(mesh()), Falloff::default(), Rays::SHADOW),
            (unlit().light(area()), even, Rays::SHADOW),
        ] {
            let mut scene = made.scene();
            scene.links = vec![Links { falloff, ..Links::default() }];
            scene.media[0].heed.hidden = hidden;
            let scene = scene;
            let is_plain = !falloff.acts() && hidden == Rays::NONE;
            let fogs = media::all(&scene);
            let expected = by_shadow_rays(&scene);
            for is_guided in [false, true] {
                let mut tracer = PhotonTracer::new(&scene, 0, Emission::LowDiscrepancy);
                if is_guided {
                    tracer.guide(of_still(&scene, &fogs).expect("light"));
                }
                let paths = 2048;
                let runs: Vec<[f64; 2]> = (0..16)
                    .map(|sequence| {
                        let mut out = PhotonRecord::default();
                        (0..paths).for_each(|index| {
                            tracer.trace(sequence, index, paths, Record::BeamsAndField, &mut out);
                        });
                        let straight = |kind| kind == Kind::Straight;
                        let beams = out.beams.iter().filter(|beam| straight(beam.kind)).map(|path| {
                            let end = path.beam.origin + path.beam.length * path.beam.direction;
                            // All of it is in the box of fog.
                            for place in [path.beam.origin, end] {
                                assert!(place.cmpge(MIN - 1e-4).all() && place.cmple(MAX + 1e-4).all());
                            }
                            along(path.beam.power.x, path.beam.length)
                        });
                        let fields = out.deposits.iter().filter(|(_, field)| straight(field.kind));
                        let fields = fields.map(|(_, field)| along(field.power, field.length));
                        [beams.sum(), fields.sum()]
                    })
                    .collect();
                // Fields tell how fine light is, and of what fades otherwise about how much there is.
                for (name, at) in [("beams", 0), ("fields", 1)].into_iter().take(if is_plain { 2 } else { 1 })
                {
                    let mean = runs.iter().map(|run| run[at]).sum::<f64>() / 16.0;
                    let variance = runs.iter().map(|run| (run[at] - mean).powi(2)).sum::<f64>() / 15.0;
                    let error = (variance / 16.0).sqrt();
                    println!(
                        "{:?}, guided: {is_guided}, {name}: {mean} ± {error} of {expected}",
                        scene.lights[0]
                    );
                    assert!(error < 0.012 * expected, "too few to tell");
                    // 200,000 places know it to half a percent; one in a thousand photons is scattered on its way.
                    assert!((mean - expected).abs() < 4.0 * error + 0.01 * expected);
                }
            }
        }
    }
}
