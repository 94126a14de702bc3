//! What `examples/figures.md` says: which command answers which question.

/// A question, and the command that answers it.
pub struct Section {
    /// The question.
    pub title: &'static str,
    /// What the columns mean, and what to look at.
    pub about: &'static str,
    /// Arguments of `cargo`.
    pub command: String,
    /// What the command leaves.
    pub answer: Answer,
}

/// Where the answer of a command is.
pub enum Answer {
    /// Printed, as Markdown.
    Tables,
    /// Printed, with columns by spaces.
    Text,
    /// Printed as Markdown, with a plot in this file.
    Plot(&'static str),
    /// `results.csv` and `figure.svg` of a report.
    Report,
}

/// Where commands put what does not stay.
pub const SCRATCH: &str = "target/figures";

/// All sections. `effort`: 1 takes some ten minutes of CPU time; twice as much, twice as long, for less
/// noise.
pub fn sections(effort: f64) -> Vec<Section> {
    let times = |number: u32, least: u32| ((f64::from(number) * effort).round() as u32).max(least);
    let seconds = |seconds: f64| format!("{:.2}", (seconds * effort).max(0.1));
    let measure = |arguments: String| format!("run --release -p covbeam-tests --bin measure -- {arguments}");
    vec![
        Section {
            title: "At equal time",
            about: "relMSE, mean (I - R)² / (R² + (0.01 mean R)²), of the whole picture when each method \
                has had the same CPU time, the reference's noise taken off; mean of the seeds. *plain*: \
                progressive photon beams. *thesis*: kernels as wide as the covariance allows, an eye ray \
                through every pixel. *covbeam*: what `covbeam render` does: straight light by shadow rays, light \
                paths where the picture needs them, few eye rays. The last column is covbeam over plain: above 1 it loses. The page that the command writes has \
                every region, pictures, maps, memory and slopes.",
            command: format!(
                "run --release -- report examples/scenes --methods plain,thesis,covbeam --seeds 2 --budget {} \
                 --out {SCRATCH}/report",
                seconds(3.0)
            ),
            answer: Answer::Report,
        },
        Section {
            title: "On scenes that nobody tuned",
            about: "Scenes made from a seed. Every block of pixels is tested against plain beams with \
                narrow kernels and against light tracing; errors are compared at equal CPU time.",
            command: measure(format!(
                "fleet --scenes {} --seed 5 --width 72 --seconds 1.25 --out {SCRATCH}/fleet",
                times(8, 2)
            )),
            answer: Answer::Tables,
        },
        Section {
            title: "What each part of light by kind buys, and what is left",
            about: "Each part left out in turn, at equal CPU time; and the error budget: where the variance \
                that is left comes from.",
            command: measure(format!(
                "parts examples/scenes/shaft.toml examples/scenes/rose-window.toml \
                 examples/scenes/figurine.toml --width 128 --seeds 2 --seconds {} --reference {}",
                2.0 * effort,
                10.0 * effort
            )),
            answer: Answer::Tables,
        },
        Section {
            title: "Light scattered once: shadow rays",
            about: "`--method march`: relMSE over shadow rays a pixel. In a table's second part, values \
                below 1 say that the adaptive placement needs fewer than the best other one.",
            command: measure(format!(
                "marching examples/scenes/rose-window.toml examples/scenes/shaft.toml --width 48 \
                 --budgets 4,8,16,32 --seeds 2 --reference {} --plot {SCRATCH}/marching.svg",
                times(1024, 128)
            )),
            answer: Answer::Plot("marching.svg"),
        },
        Section {
            title: "Is the prediction true, and what does each operator buy?",
            about: "The predicted bandwidth of the light against the measured one, with each operator on \
                light fields left out in turn.",
            command: measure(format!(
                "ablation examples/scenes/glass-ball.toml --width 64 --passes 8 --paths {}",
                times(1_000_000, 100_000)
            )),
            answer: Answer::Tables,
        },
        Section {
            title: "Low-discrepancy emission",
            about: "Noise with independent photons, with those of a Sobol' sequence, and the ratio, by \
                region.",
            command: measure(format!(
                "emission examples/scenes/glass-ball.toml --width 64 --passes {} --pairs 2",
                times(16, 2)
            )),
            answer: Answer::Text,
        },
        Section {
            title: "Beams nearly parallel to eye rays",
            about: "They show as bright wedges after few passes, since a pair's contribution grows as \
                1/sin θ: pixels of smooth fog over what they should be, and the mean, which should be 1.",
            command: measure(format!(
                "wedges examples/scenes/glass-ball.toml tests/references/glass-ball.exr --seeds {}",
                times(8, 2)
            )),
            answer: Answer::Tables,
        },
        Section {
            title: "Cost of making the picture",
            about: "Of the sums of the passes; it grows with the pixels, not with the filters' width.",
            command: measure(
                "picture examples/scenes/glass-ball.toml --sides 256,1024 --passes 2".to_owned(),
            ),
            answer: Answer::Tables,
        },
        Section {
            title: "Speed of the gather",
            about: "Tests of beams and rays a core-second, against what a core could do, and growth with \
                the number of beams.",
            command: measure("speed".to_owned()),
            answer: Answer::Text,
        },
        Section {
            title: "Precision",
            about: "Largest relative errors of the fluence's spectrum over hard cases, in single \
                precision; the textbook form beside it. Below, random paths. Those of strong events lose \
                more: after a long way a rounding counts as many times as the light spreads more along one axis \
                than along the other.",
            command: "run --release -p covbeam-tests --bin stability".to_owned(),
            answer: Answer::Text,
        },
    ]
}
