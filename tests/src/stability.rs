//! The hard cases of the light field's arithmetic, and the one table of their tolerances.
//!
//! Measure: the largest difference of an entry of the 3x3 fluence covariance, relative to the largest entry of the
//! true one (which does not depend on the choice of a frame). Where the slice has full rank, also the relative
//! error of its determinant, which sees the smaller eigenvalue however small it is. The truth is the textbook
//! form in 1600 bits or more on the same `f32` inputs; the stored axes of the frame are inputs of the next
//! event too, and the direction must agree with the truth's to its rounding.

use crate::random::Stream;
use crate::twin::{Big, Bigger, Event, Real, Source, Twin, apply, start};
use covbeam::{
    Column, CovarianceGrid, Curvature, FluenceCell, FluenceSpectrum, GridCell, GridLayout, LightField,
    Medium, Segment, Vec3,
};

/// A light path whose arithmetic is hard.
pub struct Case {
    /// What it is.
    pub name: &'static str,
    /// Where light starts.
    pub source: Source,
    /// What happens to it.
    pub events: Vec<Event>,
    /// Largest accepted relative error of the slice and of its determinant.
    pub tolerance: f64,
    /// Why this tolerance.
    pub reason: &'static str,
}

/// Errors of the forms on one case.
#[derive(Debug)]
pub struct Errors {
    /// Textbook form in `f32`.
    pub textbook: f64,
    /// Textbook form stored in `f32`, each operator computed in `f64`.
    pub textbook_wide: f64,
    /// The library.
    pub square_root: f64,
    /// The library's determinant of the slice; None where the true slice is singular.
    pub determinant: Option<f64>,
}

/// Runs a case in all forms. Panics if the library's result is NaN, infinite or not positive semi-definite after
/// any event.
pub fn errors<Truth: Real>(case: &Case) -> Errors {
    let mut truth = Twin::<Truth>::start(case.source);
    let mut textbook = Twin::<f32>::start(case.source);
    let mut textbook_wide = Twin::<f64>::start(case.source);
    let mut field = start(case.source);
    let adopt =
        |field: &LightField, truth: &mut Twin<Truth>, textbook: &mut Twin<f32>, wide: &mut Twin<f64>| {
            textbook.adopt_frame(field);
            wide.adopt_frame(field);
            truth.adopt_frame(field)
        };
    // Each of three coordinates is rounded by at most half an ulp of 1, 3e-8, and so is the axis made unit of it.
    let rounding = 1.1e-7;
    assert!(adopt(&field, &mut truth, &mut textbook, &mut textbook_wide) < rounding);
    for event in &case.events {
        truth.apply(event);
        textbook.apply(event);
        textbook_wide.apply(event);
        textbook_wide.store_in_single_precision();
        apply(&mut field, event);
        assert_sound(&field);
        let apart = adopt(&field, &mut truth, &mut textbook, &mut textbook_wide);
        assert!(apart < rounding, "{}: direction {apart:.1e} off after {event:?}", case.name);
    }
    let expected = truth.fluence();
    let determinant = truth.slice_determinant().to_f64();
    let [_, _, _, _, _, xx, _, _, _, yy] = field.root.map(f64::from);
    let largest = expected.iter().fold(0.0f64, |largest, e| largest.max(e.abs()));
    // Beyond single precision's squared digits below the trace: the limit of a singular slice, not a number.
    let full_rank = determinant > 1e-60 * largest * largest && determinant > 1e-200;
    Errors {
        textbook: relative(textbook.fluence(), expected),
        textbook_wide: relative(textbook_wide.fluence(), expected),
        square_root: relative(field.fluence().to_array().map(f64::from), expected),
        determinant: full_rank.then(|| ((xx * yy).powi(2) / determinant - 1.0).abs()),
    }
}

/// How far the truth itself moves when every number of the path is moved to a neighbouring `f32`: no single-precision
/// renderer can be closer to the scene that it was meant to show. The largest of three random moves.
pub fn sensitivity<Truth: Real>(case: &Case) -> f64 {
    let mut random = Stream::new(9);
    let mut truth = Twin::<Truth>::start(case.source);
    let mut moved = [truth.clone(), truth.clone(), truth.clone()];
    let mut field = start(case.source);
    for event in &case.events {
        truth.apply(event);
        for twin in &mut moved {
            let near = |x: f32| if random.uniform() < 0.5 { x.next_up() } else { x.next_down() };
            twin.apply(&event.with_numbers(near));
        }
        apply(&mut field, event);
        truth.adopt_frame(&field);
        for twin in &mut moved {
            twin.adopt_frame(&field);
        }
    }
    moved.iter().map(|twin| relative(twin.fluence(), truth.fluence())).fold(0.0, f64::max)
}

/// Panics unless a field is finite and its slice and fluence are positive semi-definite up to rounding.
pub fn assert_sound(field: &LightField) {
    assert!(field.root.iter().all(|entry| entry.is_finite()), "{field:?}");
    assert!((field.direction.length() - 1.0).abs() < 1e-6, "{field:?}");
    assert!((field.x_axis.length() - 1.0).abs() < 1e-6, "{field:?}");
    assert!(field.x_axis.dot(field.direction).abs() < 1e-6, "{field:?}");
    let [xx, xy, yy] = field.slice().map(f64::from);
    // Three numbers rounded to f32: half an ulp each, or half the smallest subnormal.
    let least = f64::from(f32::from_bits(1));
    assert!(xx >= 0.0 && yy >= 0.0, "{xx} {xy} {yy}");
    assert!(xy * xy <= (xx + least) * (yy + least) * (1.0 + 4e-7), "{xx} {xy} {yy}");
    let [xx, yy, zz, xy, xz, yz] = field.fluence().to_array().map(f64::from);
    assert!([xx, yy, zz, xy, xz, yz].iter().all(|entry| entry.is_finite()), "{field:?}");
    // Principal minors, against the rounding of the entries.
    assert!(xx >= 0.0 && yy >= 0.0 && zz >= 0.0);
    for (a, b, c) in [(xx, yy, xy), (xx, zz, xz), (yy, zz, yz)] {
        assert!(c * c <= a * b + (4e-7 * (a + b) + least) * (a + b + least), "{field:?}");
    }
}

fn relative(got: [f64; 6], expected: [f64; 6]) -> f64 {
    let largest = expected.iter().fold(0.0f64, |largest, e| largest.max(e.abs()));
    // The limit 0 of a singular case: below anything that f32 can hold.
    let floor = 1e-100;
    let worst = got.iter().zip(&expected).map(|(g, e)| (g - e).abs());
    worst.fold(0.0, |worst: f64, e| if e.is_nan() { f64::NAN } else { worst.max(e) }) / largest.max(floor)
}

const ROUNDING: &str = "one f32 rounding an event, twice in a variance";
const LIMIT: &str = "exactly singular: the limit";
const MANY: &str = "1000 roundings, random walk";

fn mirror(normal: Vec3, along: f32, across: f32, twist: f32) -> Event {
    let tangent = if normal.x.abs() < 0.6 { Vec3::X } else { Vec3::Y };
    Event::Reflect(normal, Curvature { tangent, along, across, twist })
}

fn glass(normal: Vec3, along: f32, across: f32, twist: f32, eta: f32) -> Event {
    let tangent = if normal.x.abs() < 0.6 { Vec3::X } else { Vec3::Y };
    Event::Refract(normal, Curvature { tangent, along, across, twist }, eta)
}

/// Every case with its tolerance and the reason for it.
pub fn cases() -> Vec<Case> {
    use Event::{Diffuse, Narrow, Occlude, Scatter, Travel};
    let (z, x, y) = (Vec3::Z, Vec3::X, Vec3::Y);
    let skew = Vec3::new(0.48, -0.6, 0.64);
    let inf = f32::INFINITY;
    let case = |name, source, events, tolerance, reason| Case { name, source, events, tolerance, reason };
    vec![
        // The table of the design.
        case(
            "point source, travel 10",
            Source::Gaussian(z, x, [1e10; 2], [0.1, 0.15]),
            vec![Travel(10.0)],
            1e-6,
            ROUNDING,
        ),
        case("source of 1 mm, travel 5", Source::Disk(skew, z, 1e-3, 0.1), vec![Travel(5.0)], 1e-6, ROUNDING),
        case(
            "two lenses, travel, scatter",
            Source::Disk(-z, z, 1e-2, 0.2),
            vec![
                Travel(2.0),
                glass(Vec3::new(0.1, 0.2, 1.0), 3.0, 2.0, 0.5, 1.0 / 1.5),
                Travel(0.1),
                glass(Vec3::new(0.1, -0.1, 1.0), -2.5, -3.0, 0.25, 1.5),
                Travel(1.3),
                Scatter(Vec3::new(0.3, 0.1, -0.9), 1.9),
            ],
            1e-6,
            ROUNDING,
        ),
        case(
            "1 mm from a focus",
            Source::Gaussian(-z, x, [1e8; 2], [0.1, 0.3]),
            vec![Travel(2.0), mirror(z, -1.0, -1.0, 0.0), Travel(2.0 / 3.0 + 1e-3)],
            1e-6,
            ROUNDING,
        ),
        case(
            "light sheet, edge, scatter",
            Source::Gaussian(skew, x, [1e9, 1e-3], [0.1, 1e3]),
            vec![
                Travel(1.5),
                Occlude(Vec3::new(0.3, 0.9, -0.2), 0.02),
                Travel(3.0),
                Scatter(Vec3::new(0.3, 0.9, -0.2), 0.3),
            ],
            1e-6,
            ROUNDING,
        ),
        case("100 random bounces", BOUNCING, bounces(100, 1, 0.05), 1e-6, ROUNDING),
        // Harder.
        case(
            "zero covariance",
            Source::Gaussian(-z, x, [0.0; 2], [0.0; 2]),
            vec![Travel(3.0), mirror(z, 1.0, 2.0, 0.3), Travel(1.0), Scatter(skew, 0.3), Diffuse(y, skew)],
            0.0,
            LIMIT,
        ),
        case(
            "zero covariance, then an edge",
            Source::Gaussian(-z, x, [0.0; 2], [0.0; 2]),
            vec![Travel(3.0), mirror(z, 1.0, 2.0, 0.3), Occlude(skew, 0.1), Scatter(skew, 0.3)],
            1e-6,
            LIMIT,
        ),
        case(
            "rank one, scattered in its plane",
            Source::Gaussian(z, x, [0.0; 2], [0.0; 2]),
            vec![Occlude(Vec3::new(1.0, 2.0, 0.0), 0.25), Scatter(Vec3::new(2.0, -1.0, 1.0), 0.0)],
            1e-6,
            LIMIT,
        ),
        case(
            "rank one in angle, aslant",
            Source::Gaussian(z, x, [4.0, 9.0], [0.0; 2]),
            vec![Narrow(Vec3::new(1.0, 3.0, 0.0), 2.0), Travel(0.5), Scatter(skew, 0.0)],
            1e-6,
            LIMIT,
        ),
        case(
            "no angular spectrum, travelled there and back",
            Source::Gaussian(z, x, [1.0, 0.0], [0.0; 2]),
            vec![Travel(4.0), Travel(-4.0)],
            0.0,
            LIMIT,
        ),
        case(
            "exact point without falloff",
            Source::Point(skew, 0.0),
            vec![Travel(3.0), Occlude(x, 0.01), Travel(7.0)],
            1e-6,
            LIMIT,
        ),
        case(
            "exact point, glass ball, scatter",
            Source::Point(-z, 0.1),
            vec![
                Travel(4.0),
                glass(Vec3::new(0.5, 0.2, 1.0), 2.0, 2.0, 0.0, 1.0 / 1.5),
                Travel(0.9),
                glass(Vec3::new(-0.2, 0.1, 1.0), -2.0, -2.0, 0.0, 1.5),
                Travel(0.7),
                Scatter(Vec3::new(0.6, 0.1, -0.7), 0.5),
                Travel(1.0),
            ],
            1e-6,
            ROUNDING,
        ),
        case(
            "exact line source",
            Source::Gaussian(-z, Vec3::new(1.0, 2.0, 0.0), [inf, 0.01], [0.1, 0.2]),
            vec![Travel(2.0), mirror(Vec3::new(0.3, 0.2, 1.0), 0.4, -0.3, 0.2), Travel(3.0)],
            1e-6,
            ROUNDING,
        ),
        case(
            "exact beam, curved mirror, edge",
            Source::Collimated(-z, 0.01),
            vec![
                Travel(100.0),
                mirror(Vec3::new(0.3, 0.2, 1.0), 0.4, -0.3, 0.2),
                Travel(5.0),
                Occlude(x, 0.003),
                Travel(1.0),
            ],
            1e-6,
            LIMIT,
        ),
        case(
            "exact beam, a pencil without width, scattered",
            Source::Collimated(z, 0.0),
            vec![Travel(2.0), Scatter(skew, 0.25), Travel(8.0)],
            1e-6,
            LIMIT,
        ),
        case(
            "mirror at grazing incidence, cosine 1e-6",
            Source::Disk(Vec3::new(1.0, 0.0, -1e-6), z, 0.1, 0.2),
            vec![Travel(2.0), mirror(z, 1e-4, 3e-4, 1e-4), Travel(3.0)],
            1e-6,
            ROUNDING,
        ),
        case(
            "refraction at grazing incidence, cosine 1e-6",
            Source::Gaussian(Vec3::new(0.6, 0.8, -1e-6), x, [4.0, 9.0], [0.2, 0.3]),
            vec![Travel(2.0), glass(z, 0.5, -0.25, 0.125, 1.0 / 1.5), Travel(3.0)],
            1e-6,
            ROUNDING,
        ),
        case(
            "diffuse, in and out at cosine 1e-6",
            Source::Gaussian(Vec3::new(0.6, 0.8, -1e-6), x, [4.0, 9.0], [0.2, 0.3]),
            vec![Travel(2.0), Diffuse(z, Vec3::new(0.8, -0.6, 1e-6))],
            1e-6,
            ROUNDING,
        ),
        case(
            "the focus itself",
            // Source at 2, concave mirror of radius 2: image at exactly 2, all of it exact in f32.
            Source::Gaussian(-z, x, [2f32.powi(60); 2], [0.1, 0.3]),
            vec![Travel(2.0), mirror(z, -1.0, -1.0, 0.0), Travel(1.0), Travel(-1.0), Travel(2.0 / 3.0)],
            1e-6,
            ROUNDING,
        ),
        case(
            "the focus of an exact point",
            // 1/2 + 1/2 = 2/2: a dish of radius 2 images its centre of curvature on itself.
            Source::Gaussian(-z, x, [2f32.powi(100); 2], [0.0; 2]),
            vec![Travel(2.0), mirror(z, -0.5, -0.5, 0.0), Travel(2.0)],
            1e-6,
            LIMIT,
        ),
        case(
            "the focal line of a twisted mirror",
            Source::Gaussian(-z, x, [1e12; 2], [0.1, 0.3]),
            vec![Travel(4.0), mirror(z, -0.5, -0.5, 0.25), Travel(4.0)],
            1e-6,
            ROUNDING,
        ),
        case("1000 bounces", BOUNCING, bounces(1000, 2, 0.05), 1e-5, MANY),
        case("1000 events of all kinds", BOUNCING, gentle(1000, 3), 1e-5, MANY),
        case("a scene 1e6 units from the origin", BOUNCING, far_away(), 1e-6, ROUNDING),
        case(
            "a source 1e6 units away, detail of 1e-4",
            Source::Point(-z, 0.1),
            vec![
                Travel(1e6),
                Occlude(x, 1e-4),
                mirror(Vec3::new(0.3, 0.2, 1.0), 1e3, -2e3, 500.0),
                Travel(1e-4),
                Occlude(skew, 1e-4),
                Scatter(skew, 0.3),
                Travel(1e6),
            ],
            1e-6,
            ROUNDING,
        ),
        case(
            "strongly bent, then 1e8 units away",
            Source::Gaussian(-z, x, [1e10, 3e9], [0.1, 0.3]),
            vec![mirror(Vec3::new(0.3, 0.2, 1.0), 1e4, -2e4, 5e3), Travel(1e8)],
            1e-6,
            ROUNDING,
        ),
        case(
            "a scene of 1e-4 units",
            Source::Disk(-z, z, 1e-6, 0.1),
            vec![
                Travel(1e-4),
                glass(Vec3::new(0.5, 0.2, 1.0), 2e4, 2e4, 0.0, 1.0 / 1.5),
                Travel(9e-5),
                glass(Vec3::new(-0.2, 0.1, 1.0), -2e4, -2e4, 0.0, 1.5),
                Occlude(y, 2e-6),
                Travel(5e-5),
                Scatter(Vec3::new(0.6, 0.1, -0.7), 0.5),
                Travel(1e-4),
            ],
            1e-6,
            ROUNDING,
        ),
        case("optical depth 200, scattered at each mean free path", BOUNCING, fog(200, 4), 1e-6, ROUNDING),
        case(
            "index matched to 2^-20, strongly curved",
            Source::Gaussian(-z, x, [4.0, 9.0], [0.2, 0.3]),
            vec![glass(Vec3::new(0.5, 0.2, 1.0), 1e6, -3e5, 2e5, 1.0 + 2f32.powi(-20)), Travel(1.0)],
            1e-6,
            ROUNDING,
        ),
        case(
            "1e-3 rad from total reflection",
            Source::Gaussian(Vec3::new(0.666_666, 0.0, -0.745_356_5), x, [4.0, 9.0], [0.2, 0.3]),
            vec![Travel(1.0), glass(z, 0.5, -0.25, 0.125, 1.5), Travel(1.0)],
            1e-6,
            ROUNDING,
        ),
        case(
            "scattered straight back",
            Source::Disk(skew, y, 0.1, 0.2),
            vec![Travel(3.0), Scatter(-skew, 0.7), Travel(3.0)],
            1e-6,
            ROUNDING,
        ),
        case(
            "scattered at a right angle",
            Source::Disk(z, skew, 0.1, 0.2),
            vec![Travel(3.0), Scatter(x, 0.7), Travel(3.0)],
            1e-6,
            LIMIT,
        ),
        case(
            "an edge on the ray",
            Source::Disk(z, skew, 0.1, 0.2),
            vec![Travel(3.0), Occlude(Vec3::new(1.0, 2.0, 3.0), 0.0), Travel(2.0)],
            1e-6,
            ROUNDING,
        ),
    ]
}

/// A source without symmetry.
const BOUNCING: Source = Source::Gaussian(Vec3::new(0.48, -0.6, 0.64), Vec3::X, [40.0, 900.0], [0.2, 0.05]);

/// A direction of incidence on a normal at a cosine between 0.3 and 1, on either side.
fn normal_for(direction: Vec3, random: &mut Stream) -> Vec3 {
    loop {
        let normal = random.direction();
        if normal.dot(direction).abs() > 0.3 {
            return normal;
        }
    }
}

fn curvature(random: &mut Stream, strength: f64) -> Curvature {
    let mut bend = || random.between(-strength, strength) as f32;
    let (along, across, twist) = (bend(), bend(), bend());
    Curvature { tangent: random.direction(), along, across, twist }
}

/// Mirrors and glass at random, with an edge at every tenth. Curvatures are weak: strong ones magnify by a factor at
/// each bounce, and the slice of a thousand leaves the range of any number format.
fn bounces(count: usize, seed: u64, strength: f64) -> Vec<Event> {
    let mut random = Stream::new(seed);
    let mut field = start(BOUNCING);
    let mut events = Vec::new();
    let mut push = |field: &mut LightField, event| {
        apply(field, &event);
        events.push(event);
    };
    let mut inside = false;
    for bounce in 0..count {
        push(&mut field, Event::Travel(random.between(0.1, 2.0) as f32));
        let normal = normal_for(field.direction, &mut random);
        let bend = curvature(&mut random, strength);
        let eta = if inside { 1.5 } else { 1.0 / 1.5 };
        let passes = 1.5f32.powi(2) * (1.0 - normal.dot(field.direction).powi(2)) < 0.95 || !inside;
        if random.uniform() < 0.5 && passes {
            push(&mut field, Event::Refract(normal, bend, eta));
            inside = !inside;
        } else {
            push(&mut field, Event::Reflect(normal, bend));
        }
        if bounce % 10 == 9 {
            push(&mut field, Event::Occlude(random.direction(), random.between(0.05, 1.0) as f32));
        }
    }
    events
}

/// All events at random: how far light travels at a time, in powers of ten, and how its surfaces curve.
fn everything(
    count: usize,
    seed: u64,
    ways: [f64; 2],
    bends: impl Fn(&mut Stream) -> Curvature,
) -> Vec<Event> {
    let mut random = Stream::new(seed);
    let mut field = start(BOUNCING);
    let mut events = Vec::new();
    while events.len() < count {
        let normal = normal_for(field.direction, &mut random);
        let event = match (random.uniform() * 8.0) as usize {
            0..3 => Event::Travel(random.decades(ways[0], ways[1]) as f32),
            3 => Event::Reflect(normal, bends(&mut random)),
            4 => Event::Refract(normal, bends(&mut random), random.between(0.6, 1.0) as f32),
            5 => Event::Occlude(random.direction(), random.decades(-2.0, 1.0) as f32),
            6 => Event::Scatter(random.direction(), random.decades(-2.0, 2.0) as f32),
            _ => Event::Narrow(random.direction(), random.decades(-2.0, 1.0) as f32),
        };
        apply(&mut field, &event);
        events.push(event);
    }
    events
}

fn gentle(count: usize, seed: u64) -> Vec<Event> {
    everything(count, seed, [-2.0, 1.0], |random| curvature(random, 1.0))
}

/// 1 to 1000 events over six decades of length and four of curvature.
fn strong(seed: u64) -> Vec<Event> {
    let count = (Stream::new(!seed).uniform() * 1000.0) as usize + 1;
    everything(count, seed, [-3.0, 3.0], |random| {
        let mut bend = || random.decades(-2.0, 2.0).copysign(random.between(-1.0, 1.0)) as f32;
        let (along, across, twist) = (bend(), bend(), bend());
        Curvature { tangent: random.direction(), along, across, twist }
    })
}

/// Positions 1e6 from the origin, where f32 is spaced by 1/16; the host's distances are their differences.
fn far_away() -> Vec<Event> {
    let mut random = Stream::new(7);
    let mut position = Vec3::splat(1e6);
    let mut events = Vec::new();
    let mut field = start(BOUNCING);
    for _ in 0..30 {
        let next = position + field.direction * 2.0;
        let travel = Event::Travel((next - position).length());
        position = next;
        let turn = Event::Reflect(normal_for(field.direction, &mut random), curvature(&mut random, 0.3));
        for event in [travel, Event::Occlude(random.direction(), 0.1), turn] {
            apply(&mut field, &event);
            events.push(event);
        }
    }
    events
}

/// A mean free path, then scattering forward, again and again.
fn fog(count: usize, seed: u64) -> Vec<Event> {
    let mut random = Stream::new(seed);
    let mut direction = Vec3::new(0.48, -0.6, 0.64);
    let mut events = Vec::new();
    for _ in 0..count {
        direction = (direction + 0.3 * random.direction()).normalize();
        // Henyey-Greenstein of g = 0.9.
        events.extend([Event::Travel(1.0), Event::Scatter(direction, 6.84)]);
    }
    events
}

/// Random paths of a kind, whether or not they end near a focus.
pub struct Family {
    /// What they are.
    pub name: &'static str,
    /// The paths. Their tolerance is that of a path of their length away from foci: 3e-8 a rounding, twice in a
    /// variance, 2.5 standard deviations of a random walk.
    pub paths: Vec<Case>,
    /// [`errors`] of a path, against as many bits as it needs.
    pub errors: fn(&Case) -> Errors,
    /// [`sensitivity`] of a path, likewise.
    pub sensitivity: fn(&Case) -> f64,
}

/// The families of random paths.
pub fn families() -> Vec<Family> {
    let family = |name, count, tolerance, events: &dyn Fn(u64) -> Vec<Event>| {
        let case = |seed| Case { name, source: BOUNCING, events: events(seed), tolerance, reason: "" };
        Family {
            name,
            paths: (0..count).map(case).collect(),
            errors: errors::<Big>,
            sensitivity: sensitivity::<Big>,
        }
    };
    vec![
        family("1500 chains of 12 events of all kinds", 1500, 1e-6, &|seed| gentle(12, 100 + seed)),
        family("30 paths of 100 bounces", 30, 1e-6, &|seed| bounces(100, seed, 0.05)),
        family("30 paths of 1000 bounces", 30, 1e-5, &|seed| bounces(1000, seed, 0.05)),
        family("30 paths of 200 scatterings", 30, 3e-6, &|seed| fog(200, seed)),
        Family {
            errors: errors::<Bigger>,
            sensitivity: sensitivity::<Bigger>,
            ..family("1000 chains of up to 1000 strong events", 1000, 1e-5, &strong)
        },
    ]
}

/// Quantiles of a family's errors.
#[derive(Debug)]
pub struct Spread {
    /// Median, 99th percentile, maximum of the textbook form in `f32`; NaN sorts last.
    pub textbook: [f64; 3],
    /// The same of the library.
    pub square_root: [f64; 3],
    /// Paths above the tolerance.
    pub above: usize,
    /// Among these, the largest error in units of the path's [`sensitivity`].
    pub worst_in_units_of_sensitivity: f64,
}

/// Runs a family.
pub fn spread(family: &Family) -> Spread {
    let runs: Vec<Errors> = family.paths.iter().map(family.errors).collect();
    let quantiles = |of: &dyn Fn(&Errors) -> f64| {
        let mut sorted: Vec<f64> = runs.iter().map(of).collect();
        sorted.sort_by(f64::total_cmp);
        [0.5, 0.99, 1.0].map(|q| sorted[((sorted.len() - 1) as f64 * q) as usize])
    };
    let above: Vec<f64> = family
        .paths
        .iter()
        .zip(&runs)
        .filter(|(case, run)| run.square_root.is_nan() || run.square_root > case.tolerance)
        .map(|(case, run)| run.square_root / (family.sensitivity)(case))
        .collect();
    Spread {
        textbook: quantiles(&|run| run.textbook),
        square_root: quantiles(&|run| run.square_root),
        above: above.len(),
        worst_in_units_of_sensitivity: above.iter().fold(0.0, |worst, &e| e.max(worst)),
    }
}

/// Extinction along a beam through fog of optical depth 200, where the last weights are far below the smallest f32:
/// the worst relative error of a voxel's mean, over the voxels with data, and the number of these.
pub fn extinguished_beam() -> (f64, usize) {
    const VOXELS: usize = 100;
    let layout =
        GridLayout { min: Vec3::new(-1.0, -1.0, 0.0), max: Vec3::new(1.0, 1.0, 200.0), cells: [1, 1, 100] };
    let mut cells = [GridCell::default(); VOXELS];
    let mut grid = CovarianceGrid::new(layout, &mut cells).expect("layout");
    let mut field = LightField::point(Vec3::Z, 0.05);
    field.travel(1.0);
    grid.deposit(
        &Medium::homogeneous(0.0, 1.0),
        &Segment {
            origin: Vec3::ZERO,
            length: 200.0,
            power: 1.0,
            unscattered: true,
            field,
            edges: &[],
            column: Column::Uniform,
        },
    );
    let mut means = [FluenceCell::default(); VOXELS];
    grid.resolve(&mut means).expect("length");
    let mut worst: f64 = 0.0;
    let mut filled = 0;
    for (voxel, mean) in means.iter().enumerate() {
        assert!(mean.weight.is_finite() && mean.spectrum.to_array().iter().all(|e| e.is_finite()));
        if mean.weight > 0.0 {
            filled += 1;
            // The grid takes the spectrum at the middle of the piece: A/d².
            let distance = 1.0 + 2.0 * voxel as f64 + 1.0;
            let expected = 0.05 / (distance * distance);
            worst = worst.max((f64::from(mean.spectrum.xx) / expected - 1.0).abs());
            worst = worst.max((f64::from(mean.spectrum.yy) / expected - 1.0).abs());
        }
    }
    (worst, filled)
}

/// `count` deposits of two spectra in turn into one voxel: relative errors of the mean, of a running `f32` mean and of
/// the grid.
pub fn many_deposits(count: u64) -> (f64, f64) {
    let layout = GridLayout { min: Vec3::splat(-1.0), max: Vec3::splat(1.0), cells: [1; 3] };
    let mut cells = [GridCell::default()];
    let mut grid = CovarianceGrid::new(layout, &mut cells).expect("layout");
    let spectra = [0.1f32, 0.7].map(|s| FluenceSpectrum::from_array([s; 6]));
    let weights = [0.3f32, 0.2];
    let (mut sum, mut weight) = (0.0f32, 0.0f32);
    for i in 0..count {
        let which = (i % 2) as usize;
        grid.deposit_spectrum(Vec3::ZERO, &spectra[which], weights[which]);
        sum += spectra[which].xx * weights[which];
        weight += weights[which];
    }
    let mut means = [FluenceCell::default()];
    grid.resolve(&mut means).expect("length");
    let [w0, w1] = weights.map(f64::from);
    let expected = (f64::from(0.1f32) * w0 + f64::from(0.7f32) * w1) / (w0 + w1);
    let mean_error = |mean: f32| (f64::from(mean) / expected - 1.0).abs();
    // A sum that stalls is a wrong flux even where it happens to be the right mean.
    let flux = (w0 + w1) * (count / 2) as f64;
    let flux_error = |weight: f64| (weight / flux - 1.0).abs();
    (
        mean_error(sum / weight).max(flux_error(f64::from(weight))),
        means[0].spectrum.to_array().into_iter().map(mean_error).fold(flux_error(cells[0].weight), f64::max),
    )
}
