//! A page of pictures of the worst scenes.

use super::Fleet;
use super::row::Row;
use super::table::{command, summary};
use crate::Outcome;
use covbeam_render::files::maps::Bitmap;
use covbeam_render::files::output::write_bitmap;
use covbeam_render::files::preview::preview_exposed_as;
use std::fmt::Write;

const NAMES: [&str; 4] = ["default", "plain", "every-pixel", "reference"];

/// Writes index.html and its pictures, all of a scene at the exposure of its reference.
pub(super) fn write(fleet: &Fleet, worst: &[&Row]) -> Outcome<()> {
    let folder = fleet.out.join("pictures");
    std::fs::create_dir_all(&folder)?;
    let mut html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>covbeam fleet</title>\n<style>\n\
        body { font: 16px/1.5 system-ui, sans-serif; margin: 16px; }\n\
        div { display: flex; flex-wrap: wrap; gap: 14px; }\n\
        figure { margin: 0; }\n\
        img { display: block; width: 288px; image-rendering: pixelated; background: #eee; }\n\
        </style></head><body>\n<h1>The worst scenes of a fleet</h1>\n"
        .to_owned();
    for row in worst {
        let number = row.number;
        let _ = write!(
            html,
            "<h2><a href=\"scenes/{number:03}.toml\">Scene {number}</a> of seed {}</h2>\n<p>{}</p>\n<pre>{}</pre>\n<div>\n",
            fleet.seed,
            summary(row),
            command(fleet, number)
        );
        let reference = row.pictures.last().expect("every scene has a reference");
        for (name, picture) in NAMES.into_iter().zip(&row.pictures) {
            let file = format!("{number:03}-{name}.png");
            let bytes = preview_exposed_as(picture, reference);
            write_bitmap(
                &folder.join(&file),
                &Bitmap { width: picture.width, height: picture.height, bytes },
            )?;
            let _ = writeln!(
                html,
                "<figure><img alt=\"scene {number}, {name}\" src=\"pictures/{file}\"><figcaption>{name}</figcaption></figure>"
            );
        }
        html += "</div>\n";
    }
    html += "</body></html>\n";
    std::fs::write(fleet.out.join("index.html"), html)?;
    Ok(())
}
