//! The page: one HTML file that needs nothing else.

use super::curves::Over;
use super::plots::{error_panel, part_bars, shown_scene};
use super::scene_section::{inline, section};
use super::tables::{escape, method_label};
use super::{Compared, Report, tables};
use crate::study::plot::PlotError;
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

/// The page of a report.
///
/// # Errors
/// Those of the drawing library.
pub fn page(report: &Report) -> Result<String, PlotError> {
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>covbeam report</title>\n<link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}</style></head>\n<body><main>\n\
         <h1>covbeam: error against time</h1>\n"
    );
    if let Some(stopped) = &report.stopped {
        let _ = writeln!(html, "<p class=\"warning\"><b>Not complete:</b> {}.</p>", escape(stopped));
    }
    html += &introduction(report);
    if report.scenes.is_empty() {
        html += "<p class=\"warning\">No run was finished.</p>\n";
    } else {
        html += &at_a_glance(report)?;
    }
    for (index, scene) in report.scenes.iter().enumerate() {
        html += &section(scene, &format!("scene-{index}"))?;
    }
    if !report.features.is_empty() {
        let rows: Vec<_> = report.features.iter().map(|feature| (feature.name, feature.parts)).collect();
        let _ = write!(
            html,
            "<section id=\"features\"><h2>What each feature costs</h2>\n<p>The glass ball at the same passes and light paths, core-milliseconds a \
             pass, of each part the fastest of three runs. A scene pays only for what it has.</p>\n<div class=\"panels\">{}</div>\n{}</section>\n",
            inline(&part_bars(&rows)?, "core-milliseconds a pass of each feature, by part"),
            tables::features(&report.features)
        );
    }
    html += &machine(report);
    html += "</main></body></html>\n";
    Ok(html)
}

fn introduction(report: &Report) -> String {
    let machine = &report.machine;
    let mut html = format!(
        "<p>How far pictures of light in fog are from the truth, and after how much time: the mean relative squared error (relMSE) of each \
         method against a reference, in runs with {} and the same light paths for all methods. CPU time is that of all threads, \
         without the measuring. Measured on {} ({} cores, {} threads used), covbeam {}.</p>\n<ul class=\"methods\">\n",
        if report.seeds == 1 { "one seed".to_owned() } else { format!("{} seeds", report.seeds) },
        escape(&machine.processor),
        machine.cores,
        machine.threads,
        machine.version
    );
    for method in report.methods.iter().filter_map(|name| Compared::named(name)) {
        let _ = writeln!(html, "<li>{}: {}</li>", method_label(method.name), escape(method.about));
    }
    html += "</ul>\n<details><summary>How to read it</summary>\n\
        <p><b>relMSE</b>: the mean over pixels of (I − R₁)(I − R₂) / (R² + (0.01 mean R)²), where I is the picture's luminance and R the mean of \
        two independent reference runs R₁ and R₂. The product is free of the reference's noise; the bias that the reference's own kernels leave is \
        not taken off. Lower is better; a tenth of it is ten times less variance.</p>\n\
        <p><b>Regions</b>: <i>smooth</i> is the half of the lit pixels where the reference changes least, <i>sharp</i> the fifth where it changes \
        most. In the ball scenes, <i>volume</i> is fog outside the ball, <i>caustic</i> the light that the ball bundles, <i>glass</i> what is seen \
        through the ball.</p>\n\
        <p><b>Curves</b>: means over the seeds after 1, 2, 4, 8, … passes and at the end; bands from the least to the largest of the seeds. \
        Slopes are fitted from the fourth pass on, from three points at least. Points whose mean error is below the noise of the measurement \
        (zero or less) are left out.</p></details>\n";
    html
}

fn at_a_glance(report: &Report) -> Result<String, PlotError> {
    let mut html = "<section id=\"overview\"><h2>At a glance</h2>\n".to_owned();
    html += "<div class=\"glance\">";
    if let Some(scene) = shown_scene(report) {
        let title = format!("{}, whole picture", scene.name);
        if let Some(svg) = error_panel(scene, 0, &title, Over::CpuTime)? {
            html += &inline(&svg, &format!("Error over CPU time, {title}"));
        }
    }
    html += "<div>";
    let table = tables::overview(report);
    if !table.is_empty() {
        let _ = write!(
            html,
            "<h3>Against {} at equal CPU time</h3>\n<p class=\"note\">“sooner”: how many times sooner the whole picture has the error that {} has then. “÷”: how many \
             times smaller relMSE is in each region; below 1 it is larger. ≈: the measurement is too noisy to tell. –: not measured at that time.</p>\n{table}",
            super::METHODS[0].name,
            super::METHODS[0].name
        );
    }
    html += "</div></div><nav><h3>Contents</h3><ul>";
    for (index, scene) in report.scenes.iter().enumerate() {
        let _ = write!(html, "<li><a href=\"#scene-{index}\">{}</a></li>", escape(&scene.name));
    }
    for (shown, id, title) in [
        (!report.features.is_empty(), "features", "what each feature costs"),
        (true, "machine", "machine and command"),
    ] {
        if shown {
            let _ = write!(html, "<li><a href=\"#{id}\">{title}</a></li>");
        }
    }
    html += "</ul></nav></section>\n";
    Ok(html)
}

fn machine(report: &Report) -> String {
    let machine = &report.machine;
    let rows = [
        ("processor", machine.processor.clone()),
        ("cores, threads used", format!("{}, {}", machine.cores, machine.threads)),
        ("memory", machine.memory.clone()),
        ("system", machine.system.clone()),
        ("compiler", machine.compiler.to_owned()),
        ("build", machine.build.clone()),
        ("covbeam", machine.version.to_owned()),
        (
            "this report took",
            format!("{:.0} s by the clock, {:.0} CPU-seconds", report.elapsed, report.cpu_seconds),
        ),
    ];
    let mut html = "<section id=\"machine\"><h2>Machine and command</h2>\n<dl>".to_owned();
    for (name, value) in rows {
        let _ = write!(html, "<dt>{name}</dt><dd>{}</dd>", escape(&value));
    }
    let _ = write!(
        html,
        "</dl>\n<p>Made by</p>\n<pre class=\"scroll\" tabindex=\"0\">{}</pre>\n<p>The numbers are in <code>results.csv</code> and \
         <code>report.json</code> beside this page.</p></section>\n",
        escape(&report.command)
    );
    html
}
