//! Fog of the world that thins with height.

use crate::own::{assert_alike, quarters};
use crate::scenes::{FOG, GLASS, LAMP, light, sphere, view, volume, without_meshes};
use covbeam_session::describe::{Description, Volume, VolumeFields};
use covbeam_session::scene::{Scene, Sees};
use covbeam_session::work::failure::Failure;
use glam::Vec3;
use std::sync::Arc;

const THINNING: VolumeFields = VolumeFields {
    scattering: [0.4, 0.3, 0.2],
    scale_height: 1.5,
    origin: [0.0, -0.5, 0.0],
    up: [0.0, 1.0, 0.0],
    ..FOG
};

fn description(world: Volume<'_>) -> Description<'_> {
    Description {
        materials: vec![GLASS],
        objects: Vec::new(),
        shapes: vec![sphere(Vec3::ZERO, 0.5)],
        volumes: vec![world],
        world_volume: 0,
        lights: vec![light(LAMP)],
        camera: view(16),
        sees: Sees::Everything,
    }
}

fn scene(world: Volume) -> Arc<Scene> {
    without_meshes(&description(world))
}

/// Voxels of a tenth of a metre, between whose middles the density is taken as straight: 4e-4 too large in the mean.
#[test]
fn fog_that_thins_is_that_of_voxels() {
    let cells = 300;
    let height = |cell: usize| -15.0 + 0.1 * (cell as f64 + 0.5);
    let density = |cell| (-(height(cell) + 0.5) / THINNING.scale_height).exp() as f32;
    let densities: Vec<f32> = (0..cells).map(density).collect();
    let fields = VolumeFields {
        scale_height: 0.0,
        cells: [1, cells as u32, 1],
        density_min: [-15.0; 3],
        density_max: [15.0; 3],
        ..THINNING
    };
    let voxels = scene(Volume { fields, densities: Some(&densities), ..Volume::default() });
    assert_alike("thinning", &scene(volume(THINNING)), quarters(&voxels));
}

#[test]
fn fog_that_thins_is_refused_where_it_cannot_be() {
    let refused = |world, change: &dyn Fn(&mut Description), part: &str| {
        let mut given = description(world);
        change(&mut given);
        let Err(Failure::Invalid(message)) = given.scene(Arc::default()) else { panic!("taken: {part}") };
        assert!(message.contains(part), "{message}");
    };
    let changed = |scale_height, up: [f64; 3]| volume(VolumeFields { scale_height, up, ..THINNING });
    let whole = |_: &mut Description| {};
    refused(changed(f64::NAN, [0.0, 1.0, 0.0]), &whole, "volumes[0].scale_height");
    refused(changed(-1.0, [0.0, 1.0, 0.0]), &whole, "volumes[0].scale_height");
    refused(changed(1.5, [0.0, 2.0, 0.0]), &whole, "volumes[0].up");
    // e^25 and more at the camera.
    refused(changed(0.02, [0.0, 1.0, 0.0]), &|given| given.volumes[0].fields.origin[1] = 1.0, "lower origin");
    let elsewhere = |given: &mut Description| {
        (given.world_volume, given.volumes) = (0, vec![volume(FOG), volume(THINNING)])
    };
    refused(volume(FOG), &elsewhere, "volumes[1].scale_height");
    let voxels = Volume { densities: Some(&[1.0]), ..volume(THINNING) };
    refused(voxels, &whole, "volumes[0].scale_height");
}
