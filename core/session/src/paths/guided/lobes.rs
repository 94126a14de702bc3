//! Surfaces of several lobes on guided paths: what leaves them diffusely goes where it is worth it, and of the rest one way is drawn.

use super::{Branch, Tree};
use crate::material::{Asks, Lobes};
use crate::paths::photon::Photon;
use crate::paths::record::{PhotonRecord, add};
use crate::paths::scattering::Scattering;
use crate::scene::Material;
use crate::scene::bounces::Bounce;
use crate::surface::encounter::{Encounter, Lobe, Met};
use covbeam_geometry::hit::Hit;
use glam::Vec3;

impl Tree<'_, '_> {
    /// The lobes of a surface that a photon's light leaves diffusely, too, in ways that no host knows better.
    pub(super) fn diffuse_lobes(&self, photon: &Photon, hit: &Hit) -> Option<Lobes> {
        let is_met = photon.is_lit(hit.distance) && !photon.reception.is_void();
        let material = is_met.then(|| self.transport.scene.material_at(hit))?;
        let lobes = match *material {
            Material::Lobes(lobes) => lobes,
            _ => photon.reception.part.is_some().then(|| material.lobes())?,
        };
        let is_diffuse = lobes.diffuse.max(lobes.translucent) != Vec3::ZERO;
        (is_diffuse && lobes.asks != Asks::Ways).then_some(lobes)
    }

    /// Divides a photon at such a surface.
    pub(super) fn divide(&mut self, mut branch: Branch, hit: &Hit, lobes: &Lobes, out: &mut PhotonRecord) {
        let Branch { ref mut photon, ref mut sampler, depth } = branch;
        let xi = sampler.uniform_pair();
        let scene = self.transport.scene;
        let met = Encounter::new(scene, hit, (Met::ByLight, photon.direction), &photon.interior, lobes, xi);
        photon.arrive(scene, hit, met.normal, self.record, out);
        add(&mut out.energy.surfaces, photon.power);
        let other = met.draw_undiffused(self.transport.lobe_weights(photon, hit), sampler.uniform());
        let ways = [(Lobe::Diffuse, Bounce::Diffuse, 1.0), (Lobe::Translucent, Bounce::Transmission, -1.0)];
        for ((lobe, bounce, side), factor) in ways.into_iter().zip(met.diffuse()) {
            if factor == Vec3::ZERO || !photon.reception.sends(lobe) {
                continue;
            }
            let mut part = Branch { photon: photon.clone(), sampler: sampler.branch(), depth };
            part.photon.power *= factor;
            add(&mut out.energy.surfaces, -part.photon.power);
            if lobe.crosses() {
                part.photon.interior = met.beyond();
            }
            let (normal, geometric) = (side * met.normal, side * met.geometric);
            let by = Scattering::Surface { hit, normal, geometric, bounce };
            self.scatter_at(&mut part, &by, out);
        }
        if let Some(way) = other.filter(|way| photon.reception.sends(way.lobe)) {
            photon.power *= way.factor;
            add(&mut out.energy.surfaces, -photon.power);
            self.transport.take(photon, &way, hit, &met);
            self.follow_if_worth_it(branch, out);
        }
    }

    /// Scatters what has arrived where it leaves in all directions.
    pub(super) fn scatter_at(&mut self, branch: &mut Branch, by: &Scattering, out: &mut PhotonRecord) {
        let Branch { ref mut photon, ref mut sampler, .. } = *branch;
        if self.is_scattered(photon, by.bounce(), photon.power, out) && self.keeps_field(photon, sampler) {
            self.scatter(branch, by, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::paths::{PhotonTracer, Record};
    use crate::pilot::of_still;
    use crate::random::Emission;
    use crate::scene::made::{Made, camera, cuboid, lambert, rectangle, spot};
    use crate::scene::{Scene, Shape, media};
    use covbeam_geometry::mesh::Mesh;
    use covbeam_geometry::obj::ObjTriangles;

    const PATHS: u32 = 128_000;
    const LOBES: Lobes = Lobes {
        diffuse: Vec3::splat(0.5),
        translucent: Vec3::splat(0.25),
        metal: Vec3::splat(0.1),
        edge: Vec3::splat(0.1),
        ..Lobes::NONE
    };

    /// A sheet in the middle of a room that is black, nearly; a spot shines on it from above, along (1, -1, 0).
    fn room(sheet: Shape, camera: Camera) -> Scene {
        Made::new(camera)
            .object(cuboid([-3.0; 3], [3.0; 3]), lambert(1e-4))
            .object(sheet, Material::Lobes(LOBES))
            .light(spot([-2.0, 2.0, 0.0], [0.0; 3], 100.0, [4.0, 5.0]))
            .scene()
    }

    fn flat() -> Shape {
        rectangle([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0])
    }

    /// Of two triangles, whose shading normal is tilted by 30° from the light: it sends some of it behind the sheet.
    fn tilted() -> Shape {
        let (sin, cos) = 30_f32.to_radians().sin_cos();
        let positions = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]];
        let mesh = ObjTriangles {
            positions: positions.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec(),
            normals: vec![Vec3::new(sin, cos, 0.0); 4],
            indices: vec![[0, 1, 2], [0, 2, 3]],
        };
        Shape::Mesh(Mesh::new(mesh, &Default::default(), true).expect("a sheet"))
    }

    /// What of the light that was emitted arrives on the walls, by way: above diffusely, and by the mirror; below.
    #[derive(Clone, Copy, PartialEq, Debug)]
    enum By {
        Diffuse,
        Metal,
        Translucent,
    }

    fn by(position: Vec3, caustic: bool) -> By {
        match (position.y > 0.0, caustic) {
            (true, true) => By::Metal,
            (true, false) => By::Diffuse,
            (false, _) => By::Translucent,
        }
    }

    /// Flux over the flux emitted, and the mean of the places where it arrives times it, with their standard errors, by way.
    fn arrived(scene: &Scene, is_guided: bool) -> [[[f64; 2]; 3]; 3] {
        let fogs = media::all(scene);
        let mut tracer = PhotonTracer::new(scene, 0, Emission::LowDiscrepancy);
        if is_guided {
            tracer.guide(of_still(scene, &fogs).expect("light"));
        }
        let (mut emitted, mut sums) = (0.0, [[[0.0; 2]; 3]; 3]);
        for index in 0..PATHS {
            let mut record = PhotonRecord::default();
            tracer.trace(0, index, PATHS, Record::Beams, &mut record);
            let mut of_path = [[0.0; 3]; 3];
            // What the walls reflect arrives on the sheet, too.
            for photon in record.surface.iter().filter(|photon| photon.position.y.abs() > 1e-3) {
                let of_path = &mut of_path[by(photon.position, photon.caustic) as usize];
                let power = f64::from(photon.power.x);
                of_path[0] += power;
                of_path[1] += power * f64::from(photon.position.x);
                of_path[2] += power * f64::from(photon.position.y);
            }
            emitted += record.energy.emitted[0];
            for (sum, of_path) in sums.iter_mut().flatten().zip(of_path.iter().flatten()) {
                sum[0] += of_path;
                sum[1] += of_path * of_path * f64::from(PATHS);
            }
        }
        let error = |sum: f64, squares: f64| ((squares - sum * sum) / f64::from(PATHS)).sqrt();
        sums.map(|of| of.map(|[sum, squares]| [sum, error(sum, squares)].map(|of| of / emitted)))
    }

    /// As much as the lobes say, flat or with shading normals; and at the same places on average as what one way at a time is drawn of.
    #[test]
    fn light_leaves_by_all_lobes_as_much_and_to_where_they_send_it() {
        for (name, sheet) in [("flat", flat()), ("tilted", tilted())] {
            let all = camera([0.0, 0.0, -2.9], [0.0; 3], 130.0, [48, 48]);
            let scene = room(sheet, all);
            let [guided, plain] = [true, false].map(|is_guided| arrived(&scene, is_guided));
            for (way, expected) in [(By::Diffuse, 0.5), (By::Metal, 0.1), (By::Translucent, 0.25)] {
                let [flux, error] = guided[way as usize][0];
                println!("{name}, {way:?}: {flux:.4} ± {error:.4} for {expected}");
                assert!(error < 0.02 * expected, "{name}, {way:?}: {error}");
                // And what the walls reflect.
                assert!((flux - expected).abs() < 4.0 * error + 2e-4, "{name}, {way:?}: {flux} ± {error}");
                for (place, [a, error]) in guided[way as usize].into_iter().enumerate().skip(1) {
                    let [b, plain_error] = plain[way as usize][place];
                    println!("{name}, {way:?}, {place}: {a:.4} ± {error:.4} for {b:.4} ± {plain_error:.4}");
                    let sum = libm::hypot(error, plain_error);
                    assert!((a - b).abs() < 4.0 * sum + 6e-4, "{name}, {way:?}, {place}: {a} for {b}");
                }
            }
        }
    }

    /// The camera sees a fiftieth of what the sheet lights diffusely.
    #[test]
    fn photons_go_where_the_camera_looks() {
        let scene = room(flat(), camera([-2.5, 1.5, 0.0], [3.0, 1.5, 0.0], 30.0, [48, 48]));
        let fogs = media::all(&scene);
        let mut tracer = PhotonTracer::new(&scene, 0, Emission::LowDiscrepancy);
        let seen = |tracer: &PhotonTracer| {
            let mut record = PhotonRecord::default();
            (0..PATHS).for_each(|index| tracer.trace(0, index, PATHS, Record::Beams, &mut record));
            let reach = 5.5 * 15_f32.to_radians().tan();
            let is_seen =
                |place: Vec3| place.x > 2.99 && place.z.abs() < reach && (place.y - 1.5).abs() < reach;
            let diffuse = record.surface.iter().filter(|photon| !photon.caustic);
            let all = diffuse.clone().count();
            diffuse.filter(|photon| is_seen(photon.position)).count() as f32 / all as f32
        };
        let plain = seen(&tracer);
        tracer.guide(of_still(&scene, &fogs).expect("light"));
        let guided = seen(&tracer);
        println!("seen: {plain} of the photons, guided {guided}");
        assert!(guided > 3.0 * plain, "{guided} for {plain}");
    }
}
