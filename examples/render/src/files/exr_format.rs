//! Pictures as the bytes of an OpenEXR file.

use covbeam::ImageFilter;
use covbeam_session::film::{LayerMaps, Layers, Maps, Picture};
use covbeam_session::kind::Kind;
use covbeam_session::pass::memory::available;
use exr::block::lines::LineRefMut;
use exr::image::Blocks;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::MetaData;
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Image, Layer,
    LayerAttributes, LineOrder, ReadChannels, ReadLayers, Text, Vec2, WritableImage, read,
};
use glam::Vec3;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom, Write};

/// What is written beside the pixels of an EXR, as attributes `method`, `passes`, `photons`, `seed`, `scene`;
/// `software` says which version of covbeam wrote it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RenderInfo {
    /// `ppb`, `adaptive` or `light-trace`.
    pub method: String,
    /// Passes in the picture.
    pub passes: u32,
    /// Light paths a pass.
    pub photons: u32,
    /// Seed.
    pub seed: u32,
    /// Name of the scene.
    pub scene: String,
}

/// Names of the channels of [`Layers`]: layer.channel, as Blender, Nuke and the OpenEXR tools understand it.
const LAYER_CHANNELS: [&str; 3] = ["radius.Y", "sigma.Y", "samples.Y"];

/// Name of the channel of the standard error.
const ERROR_CHANNEL: &str = "error.Y";

/// Names of the channels of [`Maps`].
const VOLUME_CHANNELS: [&str; 3] = ["volume.R", "volume.G", "volume.B"];

/// And of [`LayerMaps`], after the kind of light and a dash if there are several.
const MAP_CHANNELS: [&str; 4] = ["filter.xx", "filter.xy", "filter.yy", "density.Y"];

/// Colours of a kind of light.
fn kind_channels(kind: Kind) -> [String; 3] {
    ["R", "G", "B"].map(|color| format!("{}.{color}", kind.name()))
}

/// Names of the channels of the maps of a layer of light; None: of all light.
fn map_channels(kind: Option<Kind>) -> [String; 4] {
    MAP_CHANNELS.map(|name| kind.map_or(name.to_owned(), |kind| format!("{}-{name}", kind.name())))
}

/// A channel of the picture, read off it line by line as the file is written: copies of all channels would be as large as the picture.
struct Channel<'a> {
    width: usize,
    /// By number of the pixel.
    number: Box<dyn Fn(usize) -> f32 + Sync + 'a>,
}

impl<'a, 'picture: 'a> WritableSamples<'a> for Channel<'picture> {
    type Writer = &'a Self;

    fn sample_type(&self) -> SampleType {
        SampleType::F32
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'a self, _: &Header) -> Self::Writer {
        self
    }
}

impl SamplesWriter for &Channel<'_> {
    fn extract_line(&self, line: LineRefMut) {
        let first = line.location.position.y() * self.width + line.location.position.x();
        line.write_samples(|x| (self.number)(first + x)).expect("as many bytes as the line asks for");
    }
}

/// All channels of a picture.
fn channels(picture: &Picture) -> Vec<AnyChannel<Channel<'_>>> {
    fn channel<'a>(
        picture: &Picture,
        name: &str,
        number: impl Fn(usize) -> f32 + Sync + 'a,
    ) -> AnyChannel<Channel<'a>> {
        AnyChannel::new(name, Channel { width: picture.width as usize, number: Box::new(number) })
    }
    let mut channels = Vec::new();
    for (axis, name) in ["R", "G", "B"].into_iter().enumerate() {
        channels.push(channel(picture, name, move |i| picture.radiance[i][axis]));
    }
    if let Some(Layers { radius, sigma, samples }) = &picture.layers {
        for (name, values) in LAYER_CHANNELS.into_iter().zip([radius, sigma, samples]) {
            channels.push(channel(picture, name, |i| values[i]));
        }
    }
    if let Some(error) = &picture.error {
        channels.push(channel(picture, ERROR_CHANNEL, |i| error[i]));
    }
    if let Some(Maps { volume, layers }) = &picture.maps {
        for (axis, name) in VOLUME_CHANNELS.into_iter().enumerate() {
            channels.push(channel(picture, name, move |i| volume[i][axis]));
        }
        for LayerMaps { kind, filters, density } in layers {
            let [xx, xy, yy, rays] = map_channels(*kind);
            channels.push(channel(picture, &xx, |i| filters[i].xx));
            channels.push(channel(picture, &xy, |i| filters[i].xy));
            channels.push(channel(picture, &yy, |i| filters[i].yy));
            channels.push(channel(picture, &rays, |i| density[i]));
        }
    }
    for (kind, radiance) in &picture.kinds {
        for (axis, name) in kind_channels(*kind).into_iter().enumerate() {
            channels.push(channel(picture, &name, move |i| radiance[i][axis]));
        }
    }
    channels
}

/// Writes the picture as an EXR of one part, f32, ZIP; the same input gives the same bytes.
pub(crate) fn encode(
    picture: &Picture,
    info: &RenderInfo,
    mut file: impl Read + Write + Seek,
) -> Result<(), exr::error::Error> {
    let size = Vec2(picture.width as usize, picture.height as usize);
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
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels(picture).into()));

    Image::from_layer(layer).write().non_parallel().to_unbuffered(&mut file)?;
    Ok(sort_attributes(&mut file)?)
}

/// EXR strings are bytes of UTF-8.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

/// Puts the attributes of the header in alphabetical order. The encoder keeps them in a randomly seeded hash map, so
/// without this two runs would differ in bytes. The header keeps its length, so every offset in the file stays right.
fn sort_attributes(file: &mut (impl Read + Write + Seek)) -> io::Result<()> {
    const HEADER: SeekFrom = SeekFrom::Start(8); // after the magic number and the version
    file.seek(HEADER)?;
    let mut reader = BufReader::new(&mut *file);
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    loop {
        // name \0 type \0 size:i32 value[size], until an empty name.
        let mut attribute = Vec::new();
        if reader.read_until(0, &mut attribute)? <= 1 {
            break;
        }
        reader.read_until(0, &mut attribute)?;
        let mut size = [0; 4];
        reader.read_exact(&mut size)?;
        attribute.extend(size);
        reader.by_ref().take(u32::from_le_bytes(size).into()).read_to_end(&mut attribute)?;
        attributes.push(attribute);
    }
    attributes.sort();
    file.seek(HEADER)?;
    file.write_all(&attributes.concat())
}

/// Bytes of samples that a byte of a file may stand for: a black picture has some 200,000 with the compression PIZ.
const MOST_PACKED: u64 = 1 << 18;

/// Refuses a file of more pixels than `most`, or that says of itself that it is larger than it can be, or than memory is.
fn check_size(bytes: &[u8], most: u64) -> Result<(), String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| format!("{error}; expected an OpenEXR picture"))?;
    let mut all = 0_u64;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        let pixels = width as u64 * height as u64;
        if pixels > most {
            return Err(format!("it has {width} x {height} pixels, and {most} are read at most"));
        }
        all = all.saturating_add(pixels.saturating_mul(header.channels.bytes_per_pixel as u64));
    }
    // Samples as they are stored, and as numbers of single precision.
    let needed = all.saturating_mul(3);
    if all / MOST_PACKED > bytes.len() as u64 || available().is_some_and(|available| needed > available) {
        let (size, needed) = (bytes.len(), needed as f64 / 1e9);
        return Err(format!(
            "{size} bytes that say they are a picture which takes {needed:.1} GB: it is damaged, or memory does not hold it"
        ));
    }
    Ok(())
}

/// A part of a file that is read.
struct Part<'a>(&'a Layer<AnyChannels<FlatSamples>>);

impl Part<'_> {
    /// Samples of a channel, if there is one of that name.
    fn find(&self, name: &str) -> Option<Vec<f32>> {
        let list = &self.0.channel_data.list;
        list.iter().find(|c| c.name.eq(name)).map(|c| c.sample_data.values_as_f32().collect())
    }

    /// Its colours: red, green and blue, or grey.
    fn colors_or_grey(&self) -> Option<[Vec<f32>; 3]> {
        match (self.find("R"), self.find("G"), self.find("B"), self.find("Y")) {
            (Some(red), Some(green), Some(blue), _) => Some([red, green, blue]),
            (None, _, _, Some(grey)) => Some([grey.clone(), grey.clone(), grey]),
            _ => None,
        }
    }

    /// Colours of three channels, if all are there.
    fn colors(&self, names: [&str; 3]) -> Option<Vec<Vec3>> {
        let [red, green, blue] = names.map(|name| self.find(name));
        Some(self.vectors([red?, green?, blue?]))
    }

    fn vectors(&self, [red, green, blue]: [Vec<f32>; 3]) -> Vec<Vec3> {
        (0..self.0.size.area()).map(|i| Vec3::new(red[i], green[i], blue[i])).collect()
    }

    fn layers(&self) -> Option<Layers> {
        let [radius, sigma, samples] = LAYER_CHANNELS.map(|name| self.find(name));
        Some(Layers { radius: radius?, sigma: sigma?, samples: samples? })
    }

    fn maps(&self) -> Option<Maps> {
        let known = [None].into_iter().chain(Kind::ALL.map(Some));
        let volume = self.colors(VOLUME_CHANNELS)?;
        Some(Maps { volume, layers: known.filter_map(|kind| self.layer_maps(kind)).collect() })
    }

    fn layer_maps(&self, kind: Option<Kind>) -> Option<LayerMaps> {
        let [xx, xy, yy, density] = map_channels(kind).map(|name| self.find(&name));
        let (xx, xy, yy) = (xx?, xy?, yy?);
        let filter = |i: usize| ImageFilter { xx: xx[i], xy: xy[i], yy: yy[i] };
        let filters = (0..self.0.size.area()).map(filter).collect();
        Some(LayerMaps { kind, filters, density: density?.into() })
    }

    fn kinds(&self) -> Vec<(Kind, Vec<Vec3>)> {
        let of_kind =
            |kind: Kind| Some((kind, self.colors(kind_channels(kind).each_ref().map(String::as_str))?));
        Kind::ALL.into_iter().filter_map(of_kind).collect()
    }
}

/// The picture in an EXR of any program of at most so many pixels; see [`crate::files::output::read_picture`].
pub(crate) fn decode(bytes: &[u8], most: u64) -> Result<Picture, String> {
    check_size(bytes, most)?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("{error}; expected an OpenEXR picture"))?;
    // The first part that has a colour.
    let mut parts = image.layer_data.iter().map(Part);
    let (colors, part) = parts
        .find_map(|part| Some((part.colors_or_grey()?, part)))
        .ok_or("it has neither channels R, G, B nor Y")?;

    let (layer, window) = (part.0, image.attributes.display_window);
    if window.size != layer.size || window.position != layer.attributes.layer_position {
        return Err("it is cropped: save it with the data window equal to the display window".to_owned());
    }
    if colors.iter().any(|samples| samples.len() != layer.size.area()) {
        return Err("its colour channels are subsampled; save it with all channels at full size".to_owned());
    }
    Ok(Picture {
        width: layer.size.0 as u32,
        height: layer.size.1 as u32,
        radiance: part.vectors(colors),
        error: part.find(ERROR_CHANNEL),
        layers: part.layers(),
        maps: part.maps(),
        kinds: part.kinds(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{Sample, f16};

    /// Of pixels that are read.
    const ALL: u64 = 1 << 20;

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
        Picture {
            width: 35,
            height: 21,
            radiance,
            error: Some(many(7)),
            layers: Some(layers),
            maps: None,
            kinds: Vec::new(),
        }
    }

    fn encoded(picture: &Picture) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        encode(picture, &info(), &mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn what_is_encoded_is_decoded_bit_for_bit() {
        let with = picture();
        assert_eq!(decode(&encoded(&with), ALL).unwrap(), with);
        let without = Picture { layers: None, error: None, ..with };
        assert_eq!(decode(&encoded(&without), ALL).unwrap(), without);
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let first = encoded(&picture());
        for _ in 0..8 {
            assert!(encoded(&picture()) == first);
        }
    }

    #[test]
    fn the_attributes_say_how_the_picture_was_made() {
        let bytes = encoded(&picture());
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
        let picture = decode(&bytes.into_inner(), ALL).unwrap();
        assert_eq!(picture.radiance, [Vec3::splat(0.5), Vec3::splat(2.0)]);
    }

    #[test]
    fn what_is_no_picture_is_refused_with_what_was_expected() {
        assert!(decode(b"P6 1 1 255", ALL).unwrap_err().contains("expected an OpenEXR picture"));
        let bytes = encoded(&picture());
        for length in [0, 4, 9, 100, bytes.len() / 2, bytes.len() - 1] {
            assert!(decode(&bytes[..length], ALL).is_err(), "{length} of {} bytes", bytes.len());
        }
        let depth = AnyChannels::sort(vec![AnyChannel::new("Z", FlatSamples::F32(vec![1.0]))].into());
        let mut bytes = Cursor::new(Vec::new());
        Image::from_channels((1, 1), depth).write().to_buffered(&mut bytes).unwrap();
        assert!(decode(&bytes.into_inner(), ALL).unwrap_err().contains("R, G, B nor Y"));
    }

    #[test]
    fn a_file_that_says_it_is_larger_than_it_can_be_is_refused_before_there_is_memory_for_it() {
        let mut bytes = encoded(&picture());
        let whole = i32::to_le_bytes;
        for name in ["dataWindow", "displayWindow"] {
            let attribute = [name, "\0box2i\0"].concat();
            let at = bytes.windows(attribute.len()).position(|part| part == attribute.as_bytes()).unwrap();
            // After the attribute's size: left, top, right, bottom.
            let place = at + attribute.len() + 12;
            bytes[place..place + 8].copy_from_slice(&[whole(99_999), whole(99_999)].concat());
        }
        let error = decode(&bytes, ALL).unwrap_err();
        assert!(error.contains("100000 x 100000 pixels"), "{error}");
        let error = decode(&bytes, u64::MAX).unwrap_err();
        assert!(error.contains("damaged") && error.contains("GB"), "{error}");
    }
}
