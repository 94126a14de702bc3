//! Pictures inside a page: previews, errors and maps in false colours, with their scales.

use super::SceneResult;
use super::palette::Scale;
use super::tables::{escape, number};
use crate::files::maps::{Bitmap, filter_map};
use crate::files::output::encode_png;
use crate::files::preview::preview_exposed_as;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use covbeam_session::film::Picture;
use std::fmt::Write;

/// A picture with its caption, and a scale of colours if it is in false ones.
struct Figure {
    bitmap: Bitmap,
    /// For those who cannot see it.
    alt: String,
    caption: String,
    scale: Option<Legend>,
}

/// A colour scale with labels at its ends and in between.
struct Legend {
    scale: Scale,
    labels: Vec<String>,
}

impl Figure {
    /// # Panics
    /// Never: a figure has pixels, as many as its size says.
    fn html(&self) -> String {
        let png = encode_png(&self.bitmap).expect("a bitmap of width x height pixels");
        let mut html = format!(
            "<figure><img alt=\"{}\" width=\"{}\" height=\"{}\" src=\"data:image/png;base64,{}\">",
            escape(&self.alt),
            self.bitmap.width,
            self.bitmap.height,
            STANDARD.encode(png)
        );
        if let Some(Legend { scale, labels }) = &self.scale {
            let labels: String =
                labels.iter().map(|label| format!("<span>{}</span>", escape(label))).collect();
            let _ = write!(
                html,
                "<div class=\"bar\" style=\"background:{}\"></div><div class=\"ticks\">{labels}</div>",
                scale.css()
            );
        }
        let _ = writeln!(html, "<figcaption>{}</figcaption></figure>", self.caption);
        html
    }
}

fn gallery(figures: impl Iterator<Item = Figure>) -> String {
    let figures: String = figures.map(|figure| figure.html()).collect();
    format!("<div class=\"gallery\">{figures}</div>\n")
}

/// The reference and each method's picture at the end of its first run, all with the exposure of the reference.
pub(super) fn previews(scene: &SceneResult) -> String {
    let reference = &scene.reference_picture;
    let shown = |picture: &Picture, name: &str, caption: String| Figure {
        bitmap: Bitmap {
            width: picture.width,
            height: picture.height,
            bytes: preview_exposed_as(picture, reference),
        },
        alt: format!("{}, {name}", scene.name),
        caption,
        scale: None,
    };
    let first = shown(reference, "reference", "<b>reference</b>".to_owned());
    let methods = scene.runs.iter().filter(|run| run.seed == 1).map(|run| {
        let last = run.points.last();
        let (passes, seconds) = last.map_or((0, 0.0), |point| (point.passes, point.cpu_seconds));
        let caption = format!(
            "{}<br>{seconds:.2} CPU-s, {passes} passes<br>relMSE {}",
            super::tables::method_label(run.method),
            last.and_then(|point| point.errors.first())
                .map_or_else(String::new, |error| number(error.rel_mse))
        );
        shown(&run.picture, run.method, caption)
    });
    gallery(std::iter::once(first).chain(methods))
}

/// Relative errors of the same pictures, all on one scale, which 2 % of them exceed.
pub(super) fn errors(scene: &SceneResult) -> String {
    let mut sizes: Vec<f32> =
        scene.relative_errors.iter().flat_map(|(_, errors)| errors.iter().map(|error| error.abs())).collect();
    sizes.sort_by(f32::total_cmp);
    let typical = sizes.get(sizes.len().saturating_sub(1) * 98 / 100).copied().unwrap_or(0.0);
    let rounds = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0];
    let largest = rounds.into_iter().find(|end| *end >= typical).unwrap_or(1.0);
    let figure = |(name, errors): &(&str, Vec<f32>)| {
        let color = |error: &f32| Scale::BlueWhiteRed.color(0.5 + 0.5 * error / largest);
        let (width, height) = (scene.width, scene.height);
        let percent = 100.0 * largest;
        Figure {
            bitmap: Bitmap { width, height, bytes: errors.iter().flat_map(color).collect() },
            alt: format!(
                "{}, relative error of the method {name}: blue is too dark, red too bright",
                scene.name
            ),
            caption: super::tables::method_label(name),
            scale: Some(Legend {
                scale: Scale::BlueWhiteRed,
                labels: vec![format!("−{percent:.0} %"), "0".to_owned(), format!("+{percent:.0} %")],
            }),
        }
    };
    gallery(scene.relative_errors.iter().map(figure))
}

/// Kernel radius, bandwidth and pairs where every pixel has an eye ray; density of eye rays and filters where they are planned.
pub(super) fn maps(scene: &SceneResult) -> String {
    let mut figures = Vec::new();
    let first = || scene.runs.iter().filter(|run| run.seed == 1);
    // Maps of adaptive kernels: the method that has an eye ray in each pixel shows them best.
    let adaptive = |run: &&super::Run| run.method != super::METHODS[0].name;
    let source =
        first().filter(adaptive).find(|run| run.picture.maps.is_none()).or_else(|| first().find(adaptive));
    if let Some((run, layers)) = source.and_then(|run| Some((run, run.picture.layers.as_ref()?))) {
        for (name, values) in [
            ("kernel radius [scene units]", &layers.radius),
            ("bandwidth σ of the light across the beam [cycles/unit]", &layers.sigma),
            ("beams met by an eye ray, a pass", &layers.samples),
        ] {
            figures.extend(logarithmic(scene, run.method, name, values));
        }
    }
    if let Some((run, maps)) = first().find_map(|run| Some((run, run.picture.maps.as_ref()?))) {
        figures.extend(logarithmic(scene, run.method, "eye rays a pixel and pass", &maps.density()));
        figures.push(Figure {
            bitmap: filter_map(&run.picture, maps),
            alt: format!("{}, filters of the eye rays as ellipses over the picture", scene.name),
            caption: format!(
                "filters between eye rays, one standard deviation; {}",
                super::tables::method_label(run.method)
            ),
            scale: None,
        });
    }
    if figures.is_empty() { String::new() } else { gallery(figures.into_iter()) }
}

/// A map on a logarithmic scale from its 1st to its 99th percentile; black where there is no value.
fn logarithmic(scene: &SceneResult, method: &str, name: &str, values: &[f32]) -> Option<Figure> {
    let mut positive: Vec<f32> = values.iter().copied().filter(|value| *value > 0.0).collect();
    positive.sort_by(f32::total_cmp);
    let quantile = |share: usize| positive.get((positive.len().checked_sub(1)?) * share / 100).copied();
    let (low, high) = (quantile(1)?, quantile(99)?);
    // A map that is the same everywhere still has a scale.
    let high = high.max(1.01 * low);
    let color = |value: &f32| {
        if *value > 0.0 { Scale::Viridis.color((value / low).ln() / (high / low).ln()) } else { [0; 3] }
    };
    let labels = [low, (low * high).sqrt(), high].map(|value| number(f64::from(value))).to_vec();
    Some(Figure {
        bitmap: Bitmap {
            width: scene.width,
            height: scene.height,
            bytes: values.iter().flat_map(color).collect(),
        },
        alt: format!("{}, map of the {name}, method {method}", scene.name),
        caption: format!("{name}; {}", super::tables::method_label(method)),
        scale: Some(Legend { scale: Scale::Viridis, labels }),
    })
}
