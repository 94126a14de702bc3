//! Hosts with materials, lamps and cameras of their own: the pictures of the same that are described.

use crate::hosts::{Truthful, described_with, meshes};
use crate::scenes::{BLACK, GLASS, LAMP, light, options, session};
use covbeam_geometry::hit::Hit;
use covbeam_session::camera::Frame;
use covbeam_session::describe::{CameraFields, Description, LightFields, LightKind, MaterialFields};
use covbeam_session::film::Picture;
use covbeam_session::host::{HostPhoton, HostScene, HostWay, HostWays};
use covbeam_session::material::{Asks, Lobes};
use covbeam_session::scene::Scene;
use covbeam_session::work::failure::Failure;
use covbeam_session::work::threads::{Spawn, Worker};
use glam::{DVec3, Vec3};
use std::f32::consts::{PI, TAU};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

/// Answers for what is the host's own; the geometry is that of meshes.
trait Answers: std::fmt::Debug + Send + Sync + 'static {
    fn lobes(&self, _hit: &Hit, lobes: &Lobes) -> Lobes {
        *lobes
    }

    fn ways(&self, _hit: &Hit, _direction: Vec3, _xi: [f32; 2]) -> HostWays {
        HostWays::default()
    }

    fn emit(&self, _place: [f32; 2], _xi: [f32; 2]) -> HostPhoton {
        HostPhoton::default()
    }

    fn illuminate(&self, _place: Vec3, _xi: [f32; 2]) -> (Vec3, Vec3) {
        (Vec3::ZERO, Vec3::ZERO)
    }

    fn eye(&self, _place: [f32; 2]) -> Option<(Vec3, Vec3)> {
        None
    }
}

#[derive(Debug)]
struct Own<A> {
    truth: Truthful,
    answers: A,
}

impl<A: Answers> HostScene for Own<A> {
    fn bounds(&self) -> (Vec3, Vec3) {
        self.truth.bounds()
    }

    /// Marked by its object.
    fn cast(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        let hit = self.truth.cast(origin, direction, reach)?;
        Some(Hit { mark: [hit.object, 7, 8], ..hit })
    }

    fn is_blocked(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<bool> {
        self.truth.is_blocked(origin, direction, reach)
    }

    fn lobes(&self, hit: &Hit, lobes: &Lobes) -> Lobes {
        assert_eq!(hit.mark, [hit.object, 7, 8], "what the host gave");
        self.answers.lobes(hit, lobes)
    }

    fn ways(&self, hit: &Hit, direction: Vec3, xi: [f32; 2]) -> HostWays {
        assert_eq!(hit.mark, [hit.object, 7, 8], "what the host gave");
        self.answers.ways(hit, direction, xi)
    }

    fn emit(&self, light: u32, place: [f32; 2], xi: [f32; 2]) -> HostPhoton {
        assert_eq!(light, 0);
        self.answers.emit(place, xi)
    }

    fn illuminate(&self, light: u32, place: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
        assert_eq!(light, 0);
        self.answers.illuminate(place, xi)
    }

    fn eye(&self, place: [f32; 2], _lens: [f32; 2]) -> Option<(Vec3, Vec3)> {
        self.answers.eye(place)
    }
}

/// The scene of a ball of glass, one of fog and a floor, changed.
fn scene(answers: impl Answers, change: impl Fn(&mut Description)) -> Arc<Scene> {
    let host = Arc::new(Own { truth: Truthful(meshes()), answers });
    Arc::new(described_with(BOUND, |given| {
        let mut given = given.clone();
        change(&mut given);
        given.scene_of_host(host).expect("valid")
    }))
}

#[derive(Debug)]
struct Nothing;
impl Answers for Nothing {}

const BOUND: MaterialFields = MaterialFields { transparent: [1.0; 3], ..BLACK };

/// Passes of a scene.
const PASSES: u32 = 10;

/// Of each quarter of the picture: mean over the passes, and its variance. Their light paths are independent of each other.
pub(crate) fn quarters(scene: &Arc<Scene>) -> [[f64; 2]; 4] {
    let session = session(scene, options(1000));
    let sums = |picture: &Picture| {
        let mut sums = [0.0; 4];
        for (pixel, radiance) in picture.radiance.iter().enumerate() {
            sums[pixel % 16 / 8 + pixel / 16 / 8 * 2] += f64::from(radiance.element_sum());
        }
        sums
    };
    let (mut before, mut passes) = ([0.0; 4], Vec::new());
    for count in 1..=PASSES {
        session.pass(&mut || true).expect("a pass");
        let all = sums(&session.picture(&mut || true).expect("made")).map(|mean| f64::from(count) * mean);
        passes.push([0, 1, 2, 3].map(|quarter| all[quarter] - before[quarter]));
        before = all;
    }
    let count = f64::from(PASSES);
    [0, 1, 2, 3].map(|quarter| {
        let mean = before[quarter] / count;
        let squares = passes.iter().map(|pass| (pass[quarter] - mean).powi(2));
        [mean, squares.sum::<f64>() / (count * (count - 1.0))]
    })
}

/// What most are compared with.
fn described() -> [[f64; 2]; 4] {
    static QUARTERS: OnceLock<[[f64; 2]; 4]> = OnceLock::new();
    *QUARTERS.get_or_init(|| quarters(&scene(Nothing, |_| {})))
}

/// Panics unless the pictures are the same but for noise, of which there is little.
#[track_caller]
pub(crate) fn assert_alike(name: &str, own: &Arc<Scene>, described: [[f64; 2]; 4]) {
    for ([a, va], [b, vb]) in quarters(own).into_iter().zip(described) {
        let error = (va + vb).sqrt();
        println!("{name}: {a} for {b} ± {error}");
        assert!(error < 0.05 * b, "{name}: too few to tell: {error} of {b}");
        // Of four quarters and a dozen cases, with seven degrees of freedom and more each, one in a hundred runs has one so far out.
        assert!((a - b).abs() < 5.0 * error, "{name}: {a} for {b} ± {error}");
    }
}

/// A checker of the floor, of which the host says the colours, is that of two materials.
#[test]
fn textures_are_what_the_host_says() {
    #[derive(Debug)]
    struct Floor;
    impl Answers for Floor {
        fn lobes(&self, hit: &Hit, lobes: &Lobes) -> Lobes {
            assert_eq!(hit.mark[0], 2, "only the floor asks");
            // More than the material has is cut.
            Lobes { diffuse: Vec3::new(0.2, 9.0, 0.5), translucent: Vec3::ONE, ..*lobes }
        }
    }
    let floor = |diffuse, asks| {
        move |given: &mut Description| given.materials[2] = MaterialFields { diffuse, asks, ..BLACK }
    };
    let textured = scene(Floor, floor([0.8; 3], Asks::Lobes));
    let plain = scene(Nothing, floor([0.2, 0.8, 0.5], Asks::Nothing));
    assert_alike("texture", &textured, quarters(&plain));
}

/// Half of a floor lets light through, by a mask.
#[test]
fn masks_are_what_the_host_says() {
    #[derive(Debug)]
    struct Mask;
    impl Answers for Mask {
        fn lobes(&self, hit: &Hit, lobes: &Lobes) -> Lobes {
            let hole = if hit.position.x < 0.0 { Vec3::ONE } else { Vec3::ZERO };
            Lobes { transparent: hole, diffuse: lobes.diffuse * (1.0 - hole), ..*lobes }
        }
    }
    let masked = scene(Mask, |given| {
        given.materials[2] =
            MaterialFields { diffuse: [0.5; 3], transparent: [1.0; 3], asks: Asks::Lobes, ..BLACK };
    });
    // The same by chance, not by place, has the same mean where light comes from straight above; so the picture is compared with none of either kind.
    let [masked, solid] = [quarters(&masked), described()];
    println!("{masked:?} {solid:?}");
    // Lower left: the floor is gone, and fog is seen through it. Lower right: it is there.
    assert!(masked[2][0] < 0.9 * solid[2][0], "a hole");
    assert!((masked[3][0] / solid[3][0] - 1.0).abs() < 0.15, "the floor beside it");
}

/// Fresnel's and Snell's laws, written once more.
#[derive(Debug)]
struct Optics;
impl Answers for Optics {
    fn ways(&self, hit: &Hit, direction: Vec3, _xi: [f32; 2]) -> HostWays {
        if hit.object == 2 {
            return HostWays { diffuse: Vec3::splat(0.5), ..HostWays::default() };
        }
        let outside = hit.normal.dot(direction) < 0.0;
        let (normal, eta) = if outside { (hit.normal, 1.0 / 1.5) } else { (-hit.normal, 1.5) };
        let cos_in = -normal.dot(direction);
        let sin2 = eta * eta * (1.0 - cos_in * cos_in);
        let reflected = direction + 2.0 * cos_in * normal;
        if sin2 >= 1.0 {
            let back = HostWay { factor: Vec3::ONE, direction: reflected, deviation: 0.0 };
            return HostWays {
                reflected: [back, HostWay::default(), HostWay::default()],
                ..HostWays::default()
            };
        }
        let cos_out = (1.0 - sin2).sqrt();
        let share = |a: f32, b: f32| ((a - b) / (a + b)).powi(2);
        let back = 0.5 * (share(eta * cos_in, cos_out) + share(cos_in, eta * cos_out));
        let refracted = (eta * direction + (eta * cos_in - cos_out) * normal).normalize();
        // In two parts, as a base and a coat would be.
        let part = HostWay { factor: Vec3::splat(0.5 * back), direction: reflected, deviation: 0.0 };
        HostWays {
            reflected: [part, part, HostWay::default()],
            refracted: HostWay { factor: Vec3::splat(1.0 - back), direction: refracted, deviation: 0.0 },
            ..HostWays::default()
        }
    }
}

#[test]
fn scattering_functions_are_what_the_host_says() {
    let own = scene(Optics, |given| {
        given.materials[0].asks = Asks::Ways;
        given.materials[2].asks = Asks::Ways;
    });
    assert_alike("ways", &own, described());
}

/// A mirror of standard deviation .2 that draws its directions, on a floor of which half of the light is absorbed, is a rough metal's: by energy.
#[test]
fn rough_ways_keep_their_light() {
    #[derive(Debug)]
    struct Rough;
    impl Answers for Rough {
        fn ways(&self, hit: &Hit, direction: Vec3, xi: [f32; 2]) -> HostWays {
            let normal = if hit.normal.dot(direction) < 0.0 { hit.normal } else { -hit.normal };
            let mirrored = direction - 2.0 * direction.dot(normal) * normal;
            let (u, v) = mirrored.any_orthonormal_pair();
            let (sine, cosine) = (TAU * xi[0]).sin_cos();
            let angle = 0.2 * (-2.0 * (1.0 - xi[1]).ln()).sqrt();
            let drawn = (mirrored + angle * (cosine * u + sine * v)).normalize();
            let way = HostWay { factor: Vec3::splat(0.5), direction: drawn, deviation: 0.2 };
            HostWays { reflected: [way, HostWay::default(), HostWay::default()], ..HostWays::default() }
        }
    }
    let metal = MaterialFields { metal: [0.5; 3], edge: [0.5; 3], roughness: 0.15, ..BLACK };
    let alone = |asks| {
        move |given: &mut Description| {
            given.materials[2] = MaterialFields { asks, ..metal };
            // Above the floor only fog shows what it reflects.
            given.sees = covbeam_session::scene::Sees::FogAlone;
        }
    };
    let [own, described] =
        [scene(Rough, alone(Asks::Ways)), scene(Nothing, alone(Asks::Nothing))].map(|scene| quarters(&scene));
    for ([a, _], [b, _]) in own.into_iter().zip(described) {
        println!("rough: {a} for {b}");
        // Lobes of about one width.
        assert!((a / b - 1.0).abs() < 0.1, "{a} for {b}");
    }
}

/// A spot whose cone is 40° wide, and which is twice as bright on its axis as at its edge.
#[derive(Debug)]
struct Spot;

const PLACE: Vec3 = Vec3::new(1.0, 2.4, 0.0);
const COSINE: f32 = 0.9;
const BRIGHT: f32 = 60.0;

fn axis() -> Vec3 {
    -PLACE.normalize()
}

impl Answers for Spot {
    fn emit(&self, [a, b]: [f32; 2], _xi: [f32; 2]) -> HostPhoton {
        let cosine = 1.0 - a * (1.0 - COSINE);
        let (u, v) = axis().any_orthonormal_pair();
        let (sin, cos) = (TAU * b).sin_cos();
        let sine = (1.0 - cosine * cosine).sqrt();
        let direction = (cosine * axis() + sine * (cos * u + sin * v)).normalize();
        let power = Vec3::splat(TAU * (1.0 - COSINE) * BRIGHT);
        HostPhoton { origin: PLACE, direction, power, ..HostPhoton::default() }
    }

    fn illuminate(&self, place: Vec3, _xi: [f32; 2]) -> (Vec3, Vec3) {
        let is_lit = (place - PLACE).normalize().dot(axis()) > COSINE;
        let intensity = if is_lit { BRIGHT } else { 0.0 };
        (Vec3::splat(intensity / place.distance_squared(PLACE)), PLACE)
    }
}

fn spot(is_own: bool) -> LightFields {
    LightFields {
        kind: LightKind::Spot,
        axis: axis().as_dvec3().to_array(),
        cosine: COSINE.into(),
        blend: 1e-6,
        intensity: [BRIGHT.into(); 3],
        is_own,
        ..LAMP
    }
}

#[test]
fn lamps_are_what_the_host_says() {
    let described = quarters(&scene(Nothing, |given| given.lights = vec![light(spot(false))]));
    let own = scene(Spot, |given| given.lights = vec![light(spot(true))]);
    assert_alike("lamp", &own, described);
    // An estimate that is a point all around, three times as bright: the picture is the host's.
    let estimate = LightFields { is_own: true, intensity: [180.0; 3], ..LAMP };
    let own = scene(Spot, |given| given.lights = vec![light(estimate)]);
    assert_alike("lamp by another estimate", &own, described);
}

/// A rectangle of the host's that shines down, by places on it.
#[test]
fn lamps_that_have_a_size_are_what_the_host_says() {
    const SIDE: f32 = 0.8;
    const RADIANCE: f32 = 40.0;
    #[derive(Debug)]
    struct Panel;
    fn place([c, d]: [f32; 2]) -> Vec3 {
        PLACE + SIDE * Vec3::new(c - 0.5, 0.0, d - 0.5)
    }
    impl Answers for Panel {
        fn emit(&self, [a, b]: [f32; 2], xi: [f32; 2]) -> HostPhoton {
            let (sine, cosine) = (TAU * b).sin_cos();
            let direction =
                Vec3::new(a.sqrt() * cosine, -(1.0 - a).max(1e-9).sqrt(), a.sqrt() * sine).normalize();
            let power = Vec3::splat(PI * SIDE * SIDE * RADIANCE);
            let (normal, radius) = (Vec3::NEG_Y, 0.5 * SIDE);
            HostPhoton {
                origin: place(xi) - 1e-5 * Vec3::Y,
                direction,
                power,
                normal,
                radius,
                angular_variance: 0.0,
            }
        }

        fn illuminate(&self, at: Vec3, xi: [f32; 2]) -> (Vec3, Vec3) {
            let from = place(xi);
            let offset = from - at;
            let cosine = (offset.y / offset.length()).max(0.0);
            (Vec3::splat(RADIANCE * SIDE * SIDE * cosine / offset.length_squared()), from)
        }
    }
    let panel = |is_own| {
        let side = f64::from(SIDE);
        let (u, v) = ([side, 0.0, 0.0], [0.0, 0.0, side]);
        let (kind, radiance) = (LightKind::Area, [RADIANCE.into(); 3]);
        LightFields { kind, u, v, radiance, spread: f64::from(PI) / 2.0, is_own, ..LAMP }
    };
    let described = quarters(&scene(Nothing, |given| given.lights = vec![light(panel(false))]));
    let own = scene(Panel, |given| given.lights = vec![light(panel(true))]);
    assert_alike("panel", &own, described);
}

/// Rays of a pinhole, from the camera that is described.
#[derive(Debug)]
struct Eye(CameraFields);
impl Answers for Eye {
    fn eye(&self, [x, y]: [f32; 2]) -> Option<(Vec3, Vec3)> {
        let Frame::Part { left, top, step } = self.0.frame else { unreachable!("as the view has it") };
        let [right, up, forward] =
            [self.0.right, self.0.up, self.0.forward].map(|axis| DVec3::from(axis).as_vec3());
        let [h, v] = [left + x * step[0], top - y * step[1]];
        // What is farther than seven pixels from the left is dark.
        let direction = (forward + h * right + v * up).normalize();
        (x < 8.0).then_some((DVec3::from(self.0.position).as_vec3(), direction))
    }
}

#[test]
fn cameras_are_what_the_host_says() {
    let camera = described_with(BOUND, |given| given.camera);
    let own = scene(Eye(camera), |given| given.camera.is_own = true);
    let [own, described] = [quarters(&own), described()];
    for quarter in [0, 2] {
        let ([a, va], [b, vb]) = (own[quarter], described[quarter]);
        assert!((a - b).abs() < 5.0 * (va + vb).sqrt(), "{a} for {b}");
        assert_eq!(own[quarter + 1][0], 0.0, "no ray");
    }
}

/// Numbers that mean nothing as often as not, others each time.
#[derive(Debug, Default)]
struct Wild(AtomicU32);

impl Wild {
    fn number(&self) -> f32 {
        const NUMBERS: [f32; 12] =
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e30, 3e38, 1e-38, 0.0, 0.3, 0.7, 1.0, 2.0];
        // Multiples of the golden ratio: all of them, in no order that repeats soon.
        let asked = self.0.fetch_add(1, Ordering::Relaxed);
        NUMBERS[(asked.wrapping_mul(0x9e37_79b9) >> 16) as usize % NUMBERS.len()]
    }

    fn vector(&self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// Unit as often as not.
    fn direction(&self) -> Vec3 {
        let vector = self.vector();
        if self.number() > 0.5 { vector.normalize() } else { vector }
    }
}

impl Answers for Wild {
    fn lobes(&self, _hit: &Hit, lobes: &Lobes) -> Lobes {
        let (alpha, index) = (self.number(), self.number());
        let [diffuse, transparent, metal, coat] = [(); 4].map(|()| self.vector());
        Lobes { diffuse, transparent, metal, coat, alpha, index, glass_transmission: self.vector(), ..*lobes }
    }

    fn ways(&self, _hit: &Hit, _direction: Vec3, _xi: [f32; 2]) -> HostWays {
        let way = || HostWay { factor: self.vector(), direction: self.direction(), deviation: self.number() };
        let reflected = [(); 3].map(|()| way());
        HostWays { diffuse: self.vector(), translucent: self.vector(), reflected, refracted: way() }
    }

    fn emit(&self, _place: [f32; 2], _xi: [f32; 2]) -> HostPhoton {
        HostPhoton {
            origin: self.vector(),
            direction: self.direction(),
            power: self.vector(),
            normal: self.direction(),
            radius: self.number(),
            angular_variance: self.number(),
        }
    }

    fn illuminate(&self, _place: Vec3, _xi: [f32; 2]) -> (Vec3, Vec3) {
        (self.vector(), self.vector())
    }

    fn eye(&self, _place: [f32; 2]) -> Option<(Vec3, Vec3)> {
        Some((self.vector(), self.direction()))
    }
}

/// Light of 10³⁰ W may be more than single precision holds where it arrives: such a pass is refused by name, and no other.
#[test]
fn hosts_that_answer_anything_get_finite_pictures_or_a_word() {
    type Change = fn(&mut Description);
    let changes: [Change; 4] = [
        |given| {
            given.materials[2] = MaterialFields {
                diffuse: [0.6; 3],
                transparent: [0.3; 3],
                metal: [0.2; 3],
                asks: Asks::Lobes,
                ..BLACK
            }
        },
        |given| given.materials.iter_mut().for_each(|material| material.asks = Asks::Ways),
        |given| given.lights[0].fields.is_own = true,
        |given| given.camera.is_own = true,
    ];
    for change in changes {
        let scene = scene(Wild::default(), change);
        let session = session(&scene, options(50));
        for _ in 0..12 {
            match session.pass(&mut || true) {
                Ok(()) => {}
                Err(Failure::Invalid(message) | Failure::Data(message)) => {
                    println!("{message}");
                    assert!(message.contains("precision"), "{message}");
                }
                Err(other) => panic!("{other:?}"),
            }
        }
        let Ok(picture) = session.picture(&mut || true) else { continue };
        assert!(picture.radiance.iter().all(|pixel| pixel.is_finite() && pixel.min_element() >= 0.0));
    }
}

#[test]
fn what_only_a_host_knows_is_refused_without_one() {
    type Change = fn(&mut Description);
    let changes: [(&str, Change); 3] = [
        ("materials[2].asks", |given| given.materials[2].asks = Asks::Lobes),
        ("lights[0].is_own", |given| given.lights[0].fields.is_own = true),
        ("camera.is_own", |given| given.camera.is_own = true),
    ];
    for (name, change) in changes {
        let refused = described_with(GLASS, |given| {
            let mut given = given.clone();
            change(&mut given);
            given.scene(meshes())
        });
        let Err(Failure::Invalid(message)) = refused else { panic!("taken: {name}") };
        assert!(message.contains(name), "{message}");
    }
}

/// The same bits as of threads of the library's, of which one is one too many.
#[test]
fn threads_of_a_host_do_the_work() {
    let scene = scene(Nothing, |_| {});
    let ours = session(&scene, options(300));
    let started = Arc::new(Mutex::new(Vec::new()));
    let (threads, count) = (Arc::clone(&started), Arc::new(AtomicU32::new(0)));
    let seen = Arc::clone(&count);
    let spawn = Spawn::new(move |worker: Worker| {
        let counted = Arc::clone(&seen);
        let body = move || {
            counted.fetch_add(1, Ordering::Relaxed);
            worker.run();
        };
        threads.lock().expect("no panic").push(std::thread::spawn(body));
        true
    });
    let options = covbeam_session::session::Options { spawn: Some(spawn), threads: 3, ..options(300) };
    let theirs = session(&scene, options.clone());
    for session in [&ours, &theirs] {
        session.pass(&mut || true).expect("a pass");
    }
    crate::scenes::assert_same(&crate::scenes::shown(&theirs), &crate::scenes::shown(&ours));
    assert_eq!(count.load(Ordering::Relaxed), 3);
    drop(theirs);
    // They end with the session, or this never does.
    let threads = std::mem::take(&mut *started.lock().expect("no panic"));
    threads.into_iter().for_each(|thread| thread.join().expect("no panic"));
    let none = covbeam_session::session::Options { spawn: Some(Spawn::new(|_| false)), ..options };
    let refused = covbeam_session::session::Session::new(std::slice::from_ref(&scene), none, &mut || true);
    let Err(Failure::Invalid(message)) = refused else { panic!("taken") };
    assert!(message.contains("threads"), "{message}");
}
