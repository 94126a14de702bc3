//! Reads the `material` of an object in a scene file.

use glam::Vec3;

use crate::scene_file::fields::{Field, SceneError, Table};
use covbeam_session::material::SMOOTH;
use covbeam_session::scene::{Lobes, Material};

pub(crate) fn read_material(field: &Field<'_>) -> Result<Material, SceneError> {
    let expected = "\"black\", { lambert = { albedo } }, { mirror = { reflectance } }, { dielectric = { index, roughness } }, \
                    { metal = { reflectance, edge, roughness } }, { plastic = { albedo, index, roughness } } or { lobes = { ... } }";
    let (kind, fields) = field.choice(expected)?;
    let Some(fields) = fields else {
        return if kind == "black" { Ok(Material::Black) } else { Err(field.refuse(expected)) };
    };
    let known: &[&str] = match kind {
        "lambert" => &["albedo"],
        "mirror" => &["reflectance"],
        "dielectric" => &["index", "roughness"],
        "metal" => &["reflectance", "edge", "roughness"],
        "plastic" => &["albedo", "index", "roughness"],
        "lobes" => &LOBES,
        _ => return Err(field.refuse(expected)),
    };
    let table = fields.table()?;
    table.only(known)?;
    Ok(match kind {
        "lambert" => Material::Lambert { albedo: read_fraction(&table.required("albedo")?)? },
        "mirror" => Material::Mirror { reflectance: read_fraction(&table.required("reflectance")?)? },
        "dielectric" => {
            let (index, alpha) = (read_index(&table.required("index")?)?, read_alpha(&table)?);
            let (glass_reflection, glass_transmission) = (Vec3::ONE, Vec3::ONE);
            match alpha > 0.0 {
                true => Material::Lobes(Lobes {
                    glass_reflection,
                    glass_transmission,
                    index,
                    alpha,
                    ..Lobes::NONE
                }),
                false => Material::Dielectric { index },
            }
        }
        "metal" => {
            let metal = read_fraction(&table.required("reflectance")?)?;
            let edge = table.optional("edge").map_or(Ok(Vec3::ONE), |field| read_fraction(&field))?;
            Material::Lobes(Lobes { metal, edge, alpha: read_alpha(&table)?, ..Lobes::NONE })
        }
        "plastic" => {
            let diffuse = read_fraction(&table.required("albedo")?)?;
            let index = table.optional("index").map_or(Ok(Lobes::NONE.index), |field| read_index(&field))?;
            let alpha = read_alpha(&table)?;
            Material::Lobes(Lobes { diffuse, coat: Vec3::ONE, index, alpha, ..Lobes::NONE })
        }
        _ => Material::Lobes(read_lobes(&fields, &table)?),
    })
}

/// Fields of a material of lobes.
const LOBES: [&str; 10] = [
    "diffuse",
    "translucent",
    "metal",
    "edge",
    "glass_reflection",
    "glass_transmission",
    "coat",
    "transparent",
    "index",
    "roughness",
];

fn read_lobes(field: &Field<'_>, table: &Table<'_>) -> Result<Lobes, SceneError> {
    let factor = |key| table.optional(key).map_or(Ok(Vec3::ZERO), |field| read_fraction(&field));
    let metal = factor("metal")?;
    let lobes = Lobes {
        diffuse: factor("diffuse")?,
        translucent: factor("translucent")?,
        metal,
        edge: if table.optional("edge").is_some() { factor("edge")? } else { metal },
        glass_reflection: factor("glass_reflection")?,
        glass_transmission: factor("glass_transmission")?,
        coat: factor("coat")?,
        transparent: factor("transparent")?,
        index: table.optional("index").map_or(Ok(Lobes::NONE.index), |field| read_index(&field))?,
        alpha: read_alpha(table)?,
        ..Lobes::NONE
    };
    // A mixture's shares add up to 1, but for rounding.
    let most = lobes.most();
    if most.max_element() > 1.0 + 1e-5 {
        return Err(field.refuse(format!(
            "lobes that send on no more light than arrives: the larger of diffuse and coat, translucent, the larger of metal and edge, the \
             larger of the two of glass, and transparent add up to {:.3}, for 1 at most",
            most.max_element()
        )));
    }
    Ok(lobes)
}

fn read_fraction(field: &Field<'_>) -> Result<Vec3, SceneError> {
    field.color("a fraction in 0..=1", |value| (0.0..=1.0).contains(&value))
}

fn read_index(field: &Field<'_>) -> Result<f32, SceneError> {
    field.number("an index of refraction in 0.1..=10", |index| (0.1..=10.0).contains(&index))
}

/// Of `roughness`, as artists' tools have it: the square root of α. Without it the surface is smooth.
fn read_alpha(table: &Table<'_>) -> Result<f32, SceneError> {
    let Some(field) = table.optional("roughness") else { return Ok(0.0) };
    let roughness = field.number("a roughness in 0..=1", |roughness| (0.0..=1.0).contains(&roughness))?;
    let alpha = roughness * roughness;
    Ok(if alpha < SMOOTH { 0.0 } else { alpha })
}
