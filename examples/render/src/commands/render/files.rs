//! The files of a picture.

use crate::commands::cli::{MethodName, RenderArgs};
use covbeam_render::files::maps::{density_map, filter_map};
use covbeam_render::files::output::{OutputError, RenderInfo, write_bitmap, write_exr, write_png};
use covbeam_session::film::Film;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where the pictures go.
pub(super) struct Files {
    pub(super) exr: PathBuf,
    pub(super) info: RenderInfo,
    pub(super) maps: bool,
}

impl Files {
    pub(super) fn save(&self, film: &Film) -> Result<(), OutputError> {
        let mut picture = film.picture();
        write_exr(&self.exr, &picture, &RenderInfo { passes: film.passes(), ..self.info.clone() })?;
        write_png(&self.png(), &picture)?;
        if let (true, Some(mut maps)) = (self.maps, picture.maps.take()) {
            write_bitmap(&self.beside("density"), &density_map(&picture, &maps))?;
            // The last map has nine pixels for one of the picture: what it does not show makes room.
            (picture.error, picture.layers) = (None, None);
            maps.volume = Vec::new();
            maps.layers.iter_mut().for_each(|layer| layer.density = Arc::default());
            write_bitmap(&self.beside("filters"), &filter_map(&picture, &maps))?;
        }
        Ok(())
    }

    fn png(&self) -> PathBuf {
        self.exr.with_extension("png")
    }

    /// The sums that a render goes on from.
    pub(super) fn shard(&self) -> PathBuf {
        self.exr.with_extension("shard")
    }

    /// NAME-map.png for NAME.exr.
    fn beside(&self, map: &str) -> PathBuf {
        let name = self.exr.file_stem().unwrap_or_default().to_string_lossy();
        self.exr.with_file_name(format!("{name}-{map}.png"))
    }

    pub(super) fn all(&self) -> Vec<PathBuf> {
        let maps = self.maps.then(|| ["density", "filters"].map(|map| self.beside(map)));
        [self.exr.clone(), self.png(), self.shard()].into_iter().chain(maps.into_iter().flatten()).collect()
    }

    pub(super) fn saved(&self, film: &Film) -> String {
        let (exr, png, passes) = (self.exr.display(), self.png(), film.passes());
        let mut text = format!(
            "wrote {exr} (linear radiance and layers), {} (preview) and {} (sums: --resume goes on from them), {passes} passes\n",
            png.display(),
            self.shard().display()
        );
        if self.maps {
            let [density, filters] = ["density", "filters"].map(|map| self.beside(map));
            text += &format!(
                "wrote {} (eye rays a pixel, logarithmic) and {} (filters at one standard deviation)\n",
                density.display(),
                filters.display()
            );
        }
        text
    }

    pub(super) fn hints(&self, args: &RenderArgs) -> String {
        // Started by `cargo run`, the program is not on the user's path.
        let covbeam = if std::env::var_os("CARGO").is_some() { "cargo run --release --" } else { "covbeam" };
        let scene = args.picture.scene.as_deref().map_or(String::new(), |path| format!(" {}", quoted(path)));
        let (other, about) = match args.picture.method {
            MethodName::Adaptive => ("ppb", "the same without frequency analysis"),
            MethodName::Ppb | MethodName::LightTrace | MethodName::March => {
                ("adaptive", "the same with frequency analysis")
            }
        };
        let picture = quoted(&self.exr);
        format!(
            "\nnext, try\n  \
             {covbeam} render{scene} --method {other}\n      {about}\n  \
             {covbeam} render{scene} --passes 1000 --seed 1000 --out reference.exr\n      a reference\n  \
             {covbeam} compare {picture} reference.exr\n      how far this picture is from it\n"
        )
    }
}

pub(super) fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    if text.contains(char::is_whitespace) { format!("'{text}'") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_with_spaces_is_quoted_in_the_hints() {
        assert_eq!(quoted(Path::new("my scene.toml")), "'my scene.toml'");
        assert_eq!(quoted(Path::new("scene.toml")), "scene.toml");
    }
}
