//! Pictures as the bytes of an OpenEXR file.

use crate::film::{Layers, Maps, Picture};
use crate::output::RenderInfo;
use covbeam::ImageFilter;
use exr::image::Blocks;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, Vec2, WritableImage, read,
};
use glam::Vec3;
use std::io::Cursor;

/// Names of the channels of [`Layers`]: layer.channel, as Blender, Nuke and the OpenEXR tools understand it.
const LAYER_CHANNELS: [&str; 3] = ["radius.Y", "sigma.Y", "samples.Y"];

/// Name of the channel of the standard error.
const ERROR_CHANNEL: &str = "error.Y";

/// Names of the channels of [`Maps`].
const MAP_CHANNELS: [&str; 7] =
    ["volume.R", "volume.G", "volume.B", "filter.xx", "filter.xy", "filter.yy", "density.Y"];

/// The picture as an EXR of one part, f32, ZIP; the same input gives the same bytes.
pub(crate) fn encode(picture: &Picture, info: &RenderInfo) -> Result<Vec<u8>, String> {
    let size = Vec2(picture.width as usize, picture.height as usize);
    let channel = |name: &str, samples: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(samples));
    let color = |axis: usize| picture.radiance.iter().map(|v| v[axis]).collect();
    let mut channels = vec![channel("R", color(0)), channel("G", color(1)), channel("B", color(2))];
    if let Some(layers) = &picture.layers {
        let samples = [&layers.radius, &layers.sigma, &layers.samples];
        channels
            .extend(LAYER_CHANNELS.iter().zip(samples).map(|(name, samples)| channel(name, samples.clone())));
    }

    if let Some(error) = &picture.error {
        channels.push(channel(ERROR_CHANNEL, error.clone()));
    }

    if let Some(Maps { volume, filters, density }) = &picture.maps {
        let of_light = (0..3).map(|axis| volume.iter().map(|v| v[axis]).collect());
        let of_filters: [fn(&ImageFilter) -> f32; 3] = [|f| f.xx, |f| f.xy, |f| f.yy];
        let of_filters = of_filters.map(|number| filters.iter().map(number).collect());
        let samples = of_light.chain(of_filters).chain([density.clone()]);
        channels.extend(MAP_CHANNELS.iter().zip(samples).map(|(name, samples)| channel(name, samples)));
    }

    let software = concat!("covbeam ", env!("CARGO_PKG_VERSION"));
    let mut attributes = LayerAttributes { software_name: Some(text(software)), ..Default::default() };
    for (name, value) in [
        ("method", info.method.clone()),
        ("passes", info.passes.to_string()),
        ("photons", info.photons.to_string()),
        ("seed", info.seed.to_string()),
        ("scene", info.scene.clone()),
    ] {
        attributes.other.insert(text(name), AttributeValue::Text(text(&value)));
    }
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels.into()));

    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|error| error.to_string())?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// EXR strings are bytes of UTF-8.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

/// Puts the attributes of the header in alphabetical order. The encoder keeps them in a randomly seeded hash map, so
/// without this two runs would differ in bytes. The header keeps its length, so every offset in the file stays right.
fn sort_attributes(bytes: &mut [u8]) {
    const HEADER: usize = 8; // magic number and version
    let mut attributes = Vec::new();
    let mut start = HEADER;
    // name \0 type \0 size:i32 value[size], until an empty name.
    while bytes[start] != 0 {
        let after_zero = |from: usize| from + bytes[from..].iter().position(|b| *b == 0).unwrap_or(0) + 1;
        let size_at = after_zero(after_zero(start));
        let size = [bytes[size_at], bytes[size_at + 1], bytes[size_at + 2], bytes[size_at + 3]];
        let end = size_at + 4 + u32::from_le_bytes(size) as usize;
        attributes.push(bytes[start..end].to_vec());
        start = end;
    }
    attributes.sort();
    bytes[HEADER..start].copy_from_slice(&attributes.concat());
}

/// The picture in an EXR of any program; see [`crate::output::read_picture`].
pub(crate) fn decode(bytes: &[u8]) -> Result<Picture, String> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("{error}; expected an OpenEXR picture"))?;

    // The first part that has a colour.
    let find = |name: &str, layer: &Layer<AnyChannels<FlatSamples>>| {
        let list = &layer.channel_data.list;
        list.iter().find(|c| c.name.eq(name)).map(|c| c.sample_data.values_as_f32().collect::<Vec<f32>>())
    };
    let (layer, [red, green, blue]) = image
        .layer_data
        .iter()
        .find_map(|layer| match (find("R", layer), find("G", layer), find("B", layer), find("Y", layer)) {
            (Some(red), Some(green), Some(blue), _) => Some((layer, [red, green, blue])),
            (None, _, _, Some(grey)) => Some((layer, [grey.clone(), grey.clone(), grey])),
            _ => None,
        })
        .ok_or("it has neither channels R, G, B nor Y")?;

    let window = image.attributes.display_window;
    if window.size != layer.size || window.position != layer.attributes.layer_position {
        return Err("it is cropped: save it with the data window equal to the display window".to_owned());
    }
    let pixels = layer.size.area();
    if [&red, &green, &blue].iter().any(|samples| samples.len() != pixels) {
        return Err("its colour channels are subsampled; save it with all channels at full size".to_owned());
    }
    let radiance = (0..pixels).map(|i| Vec3::new(red[i], green[i], blue[i])).collect();
    let layers = match LAYER_CHANNELS.map(|name| find(name, layer)) {
        [Some(radius), Some(sigma), Some(samples)] => Some(Layers { radius, sigma, samples }),
        _ => None,
    };
    let all = |names: &[&str]| names.iter().map(|name| find(name, layer)).collect::<Option<Vec<_>>>();
    let maps = all(&MAP_CHANNELS).map(|found| Maps {
        volume: (0..pixels).map(|i| Vec3::new(found[0][i], found[1][i], found[2][i])).collect(),
        filters: (0..pixels)
            .map(|i| ImageFilter { xx: found[3][i], xy: found[4][i], yy: found[5][i] })
            .collect(),
        density: found[6].clone(),
    });
    let error = find(ERROR_CHANNEL, layer);
    Ok(Picture { width: layer.size.0 as u32, height: layer.size.1 as u32, radiance, error, layers, maps })
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{Sample, f16};

    fn info() -> RenderInfo {
        let (method, scene) = ("adaptive".to_owned(), "Glaskugel für Ida".to_owned());
        RenderInfo { method, passes: 64, photons: 5000, seed: u32::MAX, scene }
    }

    fn picture() -> Picture {
        // Values over the whole range of f32, subnormal included.
        let value = |i: u32| f32::from_bits(i.wrapping_mul(2_654_435_761) & 0x7f7f_ffff);
        let many = |from: u32| (from..from + 35 * 21).map(value).collect::<Vec<f32>>();
        let radiance =
            (0..35 * 21).map(|i| Vec3::new(value(i), value(3 * i + 1), value(5 * i + 2))).collect();
        let layers = Layers { radius: many(9), sigma: many(99), samples: many(999) };
        Picture { width: 35, height: 21, radiance, error: Some(many(7)), layers: Some(layers), maps: None }
    }

    #[test]
    fn what_is_encoded_is_decoded_bit_for_bit() {
        let with = picture();
        assert_eq!(decode(&encode(&with, &info()).unwrap()).unwrap(), with);
        let without = Picture { layers: None, error: None, ..with };
        assert_eq!(decode(&encode(&without, &info()).unwrap()).unwrap(), without);
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let first = encode(&picture(), &info()).unwrap();
        for _ in 0..8 {
            assert!(encode(&picture(), &info()).unwrap() == first);
        }
    }

    #[test]
    fn the_attributes_say_how_the_picture_was_made() {
        let bytes = encode(&picture(), &info()).unwrap();
        let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(&bytes), true).unwrap();
        let own = &meta.headers[0].own_attributes;
        let software = own.software_name.as_ref().unwrap();
        assert_eq!(software.as_slice(), concat!("covbeam ", env!("CARGO_PKG_VERSION")).as_bytes());
        let shared = &meta.headers[0].shared_attributes;
        let get = |name: &str| {
            let value = own.other.get(&text(name)).or(shared.other.get(&text(name)));
            let Some(AttributeValue::Text(value)) = value else { panic!("no attribute {name}") };
            String::from_utf8(value.as_slice().to_vec()).unwrap()
        };
        assert_eq!(get("method"), "adaptive");
        assert_eq!(get("passes"), "64");
        assert_eq!(get("photons"), "5000");
        assert_eq!(get("seed"), "4294967295");
        assert_eq!(get("scene"), "Glaskugel für Ida");
        let names: Vec<String> = meta.headers[0].channels.list.iter().map(|c| c.name.to_string()).collect();
        assert_eq!(names, ["B", "G", "R", "error.Y", "radius.Y", "samples.Y", "sigma.Y"]);
    }

    #[test]
    fn a_grey_picture_of_half_floats_is_read() {
        let samples = FlatSamples::F16(vec![f16::from_f32(0.5), f16::from_f32(2.0)]);
        assert_eq!(samples.value_by_flat_index(0), Sample::F16(f16::from_f32(0.5)));
        let channels = AnyChannels::sort(vec![AnyChannel::new("Y", samples)].into());
        let mut bytes = Cursor::new(Vec::new());
        Image::from_channels((2, 1), channels).write().to_buffered(&mut bytes).unwrap();
        let picture = decode(&bytes.into_inner()).unwrap();
        assert_eq!(picture.radiance, [Vec3::splat(0.5), Vec3::splat(2.0)]);
    }

    #[test]
    fn what_is_no_picture_is_refused_with_what_was_expected() {
        assert!(decode(b"P6 1 1 255").unwrap_err().contains("expected an OpenEXR picture"));
        let bytes = encode(&picture(), &info()).unwrap();
        for length in [0, 4, 9, 100, bytes.len() / 2, bytes.len() - 1] {
            assert!(decode(&bytes[..length]).is_err(), "{length} of {} bytes", bytes.len());
        }
        let depth = AnyChannels::sort(vec![AnyChannel::new("Z", FlatSamples::F32(vec![1.0]))].into());
        let mut bytes = Cursor::new(Vec::new());
        Image::from_channels((1, 1), depth).write().to_buffered(&mut bytes).unwrap();
        assert!(decode(&bytes.into_inner()).unwrap_err().contains("R, G, B nor Y"));
    }
}
