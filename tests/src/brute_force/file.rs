//! Reads a scene file for the brute-force path tracer: what it does not know it refuses.

use super::lamps::{Kind, Lamp};
use super::shapes::Shape;
use super::world::{Camera, Material, Medium, Object, World};
use glam::DVec3;
use toml::{Table, Value};

/// Whether the camera sees lamps that have a surface, where the scene file does not say so.
const VISIBLE: bool = true;

/// Objects are bits of a set.
const MOST_OBJECTS: usize = 64;

type Found<T> = Result<T, String>;

pub(super) fn read(text: &str) -> Found<World> {
    let root: Table = text.parse().map_err(|error| format!("{error}"))?;
    only(&root, &["outside_medium", "camera", "medium", "object", "light", "grid", "render"])?;
    let tables = |key: &str| -> Found<Vec<&Table>> {
        let Some(value) = root.get(key) else { return Ok(Vec::new()) };
        let array = value.as_array().ok_or(format!("{key}: expected tables"))?;
        array.iter().map(|entry| entry.as_table().ok_or(format!("{key}: expected a table"))).collect()
    };
    let media_tables = tables("medium")?;
    let names: Vec<&str> = media_tables.iter().map(|table| word(table, "name")).collect::<Found<_>>()?;
    let medium_of = |table: &Table, key: &str| -> Found<Option<usize>> {
        if !table.contains_key(key) {
            return Ok(None);
        }
        let name = word(table, key)?;
        let place = names.iter().position(|known| *known == name);
        place.map(Some).ok_or(format!("{key}: no medium is called {name}"))
    };
    let objects = tables("object")?;
    if objects.len() > MOST_OBJECTS {
        return Err(format!("{} objects, for at most {MOST_OBJECTS}", objects.len()));
    }
    let objects = objects.into_iter().map(|table| object(table, medium_of(table, "inside")?));
    let mut world = World {
        camera: camera(root.get("camera").and_then(Value::as_table).ok_or("camera: expected a table")?)?,
        media: media_tables.into_iter().map(medium).collect::<Found<_>>()?,
        outside: medium_of(&root, "outside_medium")?,
        objects: objects.collect::<Found<_>>()?,
        lamps: tables("light")?.into_iter().map(lamp).collect::<Found<_>>()?,
        size: 0.0,
        within: Vec::new(),
    };
    let corners =
        world.objects.iter().flat_map(|object| object.shape.corners()).chain([world.camera.position]);
    world.size = corners.map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
    world.nest();
    Ok(world)
}

fn only(table: &Table, known: &[&str]) -> Found<()> {
    match table.keys().find(|key| !known.contains(&key.as_str())) {
        Some(key) => Err(format!("{key}: the brute-force path tracer does not know this field")),
        None => Ok(()),
    }
}

fn as_number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn number(table: &Table, key: &str) -> Found<f64> {
    table.get(key).and_then(as_number).ok_or(format!("{key}: expected a number"))
}

fn vector(table: &Table, key: &str) -> Found<DVec3> {
    let numbers = table.get(key).and_then(Value::as_array).map(|array| array.iter().filter_map(as_number));
    let numbers: Vec<f64> = numbers.into_iter().flatten().collect();
    <[f64; 3]>::try_from(numbers).map(DVec3::from_array).map_err(|_| format!("{key}: expected three numbers"))
}

/// One number is grey.
fn color(table: &Table, key: &str) -> Found<DVec3> {
    number(table, key).map(DVec3::splat).or_else(|_| vector(table, key))
}

fn word<'a>(table: &'a Table, key: &str) -> Found<&'a str> {
    table.get(key).and_then(Value::as_str).ok_or(format!("{key}: expected a text"))
}

fn camera(table: &Table) -> Found<Camera> {
    only(
        table,
        &["position", "look_at", "up", "vertical_fov", "width", "height", "projection", "vertical_size"],
    )?;
    let is_parallel = match table.get("projection").map(|_| word(table, "projection")).transpose()? {
        Some("orthographic") => true,
        Some("perspective") | None => false,
        Some(other) => return Err(format!("projection: {other} is not known")),
    };
    let half = if is_parallel {
        0.5 * number(table, "vertical_size")?
    } else {
        (0.5 * number(table, "vertical_fov")?).to_radians().tan()
    };
    let position = vector(table, "position")?;
    let forward = (vector(table, "look_at")? - position).normalize();
    let up = if table.contains_key("up") { vector(table, "up")? } else { DVec3::Y };
    let right = forward.cross(up).normalize();
    let side = |key| -> Found<u32> { Ok(number(table, key)? as u32) };
    let (width, height) = (side("width")?, side("height")?);
    Ok(Camera { position, forward, right, up: right.cross(forward), half, is_parallel, width, height })
}

fn medium(table: &Table) -> Found<Medium> {
    only(table, &["name", "scattering", "absorption", "phase"])?;
    let asymmetry = match table.get("phase") {
        None => 0.0,
        Some(Value::String(name)) if name == "isotropic" => 0.0,
        Some(Value::Table(phase)) => {
            only(phase, &["henyey_greenstein"])?;
            number(phase, "henyey_greenstein")?
        }
        Some(other) => return Err(format!("phase: {other} is not known")),
    };
    Ok(Medium { scattering: color(table, "scattering")?, absorption: color(table, "absorption")?, asymmetry })
}

fn object(table: &Table, inside: Option<usize>) -> Found<Object> {
    let shared = ["name", "shape", "material", "inside", "priority"];
    let (shape, own): (Shape, &[&str]) = match word(table, "shape")? {
        "sphere" => (
            Shape::Sphere { center: vector(table, "center")?, radius: number(table, "radius")? },
            &["center", "radius"],
        ),
        "box" => (Shape::Box { min: vector(table, "min")?, max: vector(table, "max")? }, &["min", "max"]),
        "rectangle" => {
            let (u, v) = (vector(table, "edge_u")?, vector(table, "edge_v")?);
            (Shape::Rectangle { corner: vector(table, "corner")?, u, v }, &["corner", "edge_u", "edge_v"])
        }
        other => return Err(format!("shape: {other} is not known")),
    };
    only(table, &[&shared, own].concat())?;
    let material = match table.get("material") {
        Some(Value::String(name)) if name == "black" => Material::Black,
        Some(Value::Table(choice)) => {
            only(choice, &["lambert", "mirror", "dielectric"])?;
            let fields = |kind: &str| choice.get(kind).and_then(Value::as_table);
            let known = |fields: &Table, key: &str| only(fields, &[key]);
            match (fields("lambert"), fields("mirror"), fields("dielectric")) {
                (Some(fields), None, None) => {
                    known(fields, "albedo")?;
                    Material::Lambert(color(fields, "albedo")?)
                }
                (None, Some(fields), None) => {
                    known(fields, "reflectance")?;
                    Material::Mirror(color(fields, "reflectance")?)
                }
                (None, None, Some(fields)) => {
                    known(fields, "index")?;
                    Material::Dielectric(number(fields, "index")?)
                }
                _ => return Err("material: expected one".to_owned()),
            }
        }
        other => return Err(format!("material: {other:?} is not known")),
    };
    let priority = match table.get("priority") {
        None => 0,
        Some(value) => value.as_integer().ok_or("priority: expected a whole number")?,
    };
    Ok(Object { shape, material, inside, priority })
}

fn lamp(table: &Table) -> Found<Lamp> {
    let position = || vector(table, "position");
    let (kind, power, own): (Kind, &str, &[&str]) = match word(table, "kind")? {
        "point" => (Kind::Point { position: position()? }, "intensity", &["position"]),
        "spot" => {
            let axis = (vector(table, "look_at")? - position()?).normalize();
            let angle = |key: &str| -> Found<f64> { Ok(number(table, key)?.to_radians()) };
            let (inner, outer) = (angle("inner_angle")?, angle("outer_angle")?);
            let own = &["position", "look_at", "inner_angle", "outer_angle"];
            (Kind::Spot { position: position()?, axis, inner, outer }, "intensity", own)
        }
        "disk" => {
            let normal = vector(table, "normal")?.normalize();
            let (center, radius) = (vector(table, "center")?, number(table, "radius")?);
            (Kind::Disk { center, normal, radius }, "radiance", &["center", "normal", "radius"])
        }
        "rectangle" => {
            let (u, v) = (vector(table, "edge_u")?, vector(table, "edge_v")?);
            let own = &["corner", "edge_u", "edge_v"];
            (Kind::Rectangle { corner: vector(table, "corner")?, u, v }, "radiance", own)
        }
        "sphere" => {
            let (center, radius) = (vector(table, "center")?, number(table, "radius")?);
            (Kind::Sphere { center, radius }, "radiance", &["center", "radius"])
        }
        "sun" => {
            let angle = if table.contains_key("angle") { number(table, "angle")? } else { 0.0 };
            let direction = vector(table, "direction")?.normalize();
            let kind = Kind::Sun { direction, angle: (0.5 * angle).to_radians() };
            (kind, "irradiance", &["direction", "angle"])
        }
        other => return Err(format!("kind: {other} is not known")),
    };
    only(table, &[&["kind", "visible", power], own].concat())?;
    let has_surface = matches!(kind, Kind::Disk { .. } | Kind::Rectangle { .. } | Kind::Sphere { .. });
    let is_visible = match table.get("visible") {
        None => VISIBLE && has_surface,
        Some(value) => value.as_bool().ok_or("visible: expected true or false")?,
    };
    Ok(Lamp { kind, power: color(table, power)?, is_visible })
}
