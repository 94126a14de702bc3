//! What the generators write is what is committed, and is sound.

use covbeam_scenes::church::{files, nave, rose_lights, rose_window};
use covbeam_scenes::outline::{Outline, area};
use covbeam_scenes::plume::{CELLS, STEPS, plume};
use covbeam_scenes::solid::Solid;
use glam::DVec2;
use std::collections::HashMap;
use std::path::Path;

fn scenes() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Times that each directed edge is used.
fn edges(solid: &Solid) -> HashMap<(u32, u32), u32> {
    let mut edges = HashMap::new();
    for [a, b, c] in &solid.triangles {
        for edge in [(*a, *b), (*b, *c), (*c, *a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    edges
}

/// By the divergence theorem.
fn volume(solid: &Solid) -> f64 {
    let corner = |i: u32| solid.vertices[i as usize];
    solid.triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
}

#[test]
fn the_committed_church_is_what_the_program_writes() {
    for (name, text) in files() {
        let committed = std::fs::read_to_string(scenes().join("meshes").join(name)).unwrap();
        assert!(committed == text, "{name} differs: run the program rose-window again");
        assert!(text.len() < 1_500_000, "{name} has {} bytes", text.len());
    }
}

#[test]
fn every_edge_of_a_solid_is_used_once_in_each_direction() {
    for (name, solid) in [("nave", nave()), ("rose window", rose_window())] {
        let edges = edges(&solid);
        for (&(a, b), &count) in &edges {
            assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "{name}: edge {a}, {b}");
        }
    }
}

#[test]
fn no_triangle_is_thinner_than_the_rounding_of_its_corners_by_far() {
    for (name, solid) in [("nave", nave()), ("rose window", rose_window())] {
        for corners in &solid.triangles {
            let [a, b, c] = corners.map(|i| solid.vertices[i as usize]);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let height = (b - a).cross(c - a).length() / longest;
            // OBJ coordinates are rounded to 0.05 mm: a triangle 20 times higher keeps its side and its normal.
            assert!(height > 1e-3, "{name}: {a} {b} {c} is {height} high");
        }
    }
}

#[test]
fn the_tracery_has_the_volume_of_its_plate_less_its_lights() {
    // Areas of the outlines by the shoelace formula; a 96-gon of radius 3.1; plate 0.3 thick.
    let plate = 48.0 * 3.1 * 3.1 * (std::f64::consts::TAU / 96.0).sin();
    let lights: f64 = rose_lights().iter().map(|light| area(light)).sum();
    let expected = 0.3 * (plate - lights);
    // f64 sums of 16,000 terms below 100: 1e-9 relative is far above their rounding.
    assert!((volume(&rose_window()) / expected - 1.0).abs() < 1e-9);
    // Open enough to be a window, closed enough to be one of stone.
    assert!(lights / plate > 0.3 && lights / plate < 0.7, "{}", lights / plate);
}

/// Distance of two segments that do not cross.
fn segment_distance([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> f64 {
    let to_segment = |p: DVec2, q: DVec2, r: DVec2| {
        let along = ((p - q).dot(r - q) / (r - q).length_squared()).clamp(0.0, 1.0);
        p.distance(q.lerp(r, along))
    };
    let ends = [to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

#[test]
fn stone_bars_between_two_lights_are_at_least_eight_centimetres_wide() {
    let lights = rose_lights();
    let sides = |light: &Outline| -> Vec<[DVec2; 2]> {
        (0..light.len()).map(|i| [light[i], light[(i + 1) % light.len()]]).collect()
    };
    let sides: Vec<_> = lights.iter().map(sides).collect();
    let mut thinnest = f64::INFINITY;
    for (i, first) in sides.iter().enumerate() {
        for second in &sides[..i] {
            for one in first {
                for other in second {
                    thinnest = thinnest.min(segment_distance(*one, *other));
                }
            }
        }
        for [point, _] in first {
            // To the rim of the opening.
            thinnest = thinnest.min(3.0 - point.length());
        }
    }
    // Roundels touch that width exactly: 1e-9 for rounding.
    assert!(thinnest >= 0.08 - 1e-9, "{thinnest}");
}

#[test]
fn the_nave_lets_light_in_through_the_rose_only() {
    let nave = nave();
    // From a point of the nave, along 2000 directions on a spiral that covers the sphere evenly, every ray meets
    // stone, but for those through the opening.
    let start = glam::DVec3::new(0.3, 4.0, 10.0);
    let mut through = 0;
    for i in 0..2000 {
        let up = 1.0 - (2.0 * f64::from(i) + 1.0) / 2000.0;
        let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
        let direction = glam::DVec3::new((1.0 - up * up).sqrt() * cos, up, (1.0 - up * up).sqrt() * sin);
        let hit = nave.triangles.iter().any(|corners| {
            let [a, b, c] = corners.map(|i| nave.vertices[i as usize]);
            // Möller and Trumbore.
            let (e, f) = (b - a, c - a);
            let p = direction.cross(f);
            let det = e.dot(p);
            let t = start - a;
            let (u, q) = (t.dot(p) / det, t.cross(e));
            let v = direction.dot(q) / det;
            det != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && f.dot(q) / det > 0.0
        });
        if !hit {
            through += 1;
            let at = start - direction * (start.z / direction.z);
            assert!(
                direction.z < 0.0 && (at.truncate() - DVec2::new(0.0, 7.0)).length() < 3.0,
                "{direction}"
            );
        }
    }
    // The opening's solid angle from there, area x cos / distance², over 4π, times 2000 = 38.
    assert!((28..=48).contains(&through), "{through}");
}

#[test]
fn the_committed_smoke_follows_the_format_and_is_empty_at_the_border() {
    let bytes = std::fs::read(scenes().join("volumes/smoke.vol")).unwrap();
    let number = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(&bytes[..4], b"VOL\x03");
    let [nx, ny, nz] = CELLS;
    assert_eq!([4, 8, 12, 16, 20].map(number), [3, nx as i32, ny as i32, nz as i32, 1]);
    let extent = [0, 1, 2].map(|axis| float(36 + 4 * axis) - float(24 + 4 * axis));
    // Voxels are cubes: to rounding of the box in f32.
    for (extent, n) in extent.iter().zip(CELLS) {
        assert!((extent / n as f32 - 0.04).abs() < 1e-6);
    }
    let values = &bytes[48..];
    assert_eq!(values.len(), nx * ny * nz);
    assert_eq!(values.iter().max(), Some(&255));
    for (i, value) in values.iter().enumerate() {
        let at = [i % nx, i / nx % ny, i / (nx * ny)];
        let border = at.iter().zip(CELLS).any(|(i, n)| *i == 0 || i + 1 == n);
        assert!(!border || *value == 0, "{at:?}");
    }
}

#[test]
#[ignore = "simulates for half a minute"]
fn the_committed_smoke_is_what_the_program_writes() {
    let committed = std::fs::read(scenes().join("volumes/smoke.vol")).unwrap();
    assert!(committed == plume(CELLS, STEPS).to_bytes(), "smoke.vol differs: run the program smoke again");
}

#[test]
fn the_smoke_is_the_same_every_time_and_rises() {
    let cells = [24, 40, 24];
    let early = plume(cells, 15);
    assert_eq!(early, plume(cells, 15));
    let height = |volume: &covbeam_scenes::volume::ByteVolume| {
        let filled = volume.values.iter().enumerate().filter(|(_, v)| **v > 12);
        filled.map(|(i, _)| i / 24 % 40).max().unwrap()
    };
    let late = plume(cells, 45);
    assert!(height(&late) >= height(&early) + 5, "{} {}", height(&early), height(&late));
}
