//! `meniscus tag`: a page with an AprilTag to print.

use super::outputs::Force;
use super::run::{NUMBERS, SIZES_MM};
use anyhow::{Context, ensure};
use meniscus_platform::files::write_whole;
use meniscus_virtual::render::TagPattern;
use meniscus_virtual::tag_page::{Paper, TagPage};
use std::path::PathBuf;

/// Print an AprilTag of a stated width for `run --motion tag`.
///
/// The page is SVG in millimetres: a tag of the family 36h11, marks to cut it out with its white margin, and a bar of 100 mm. Print it
/// from a browser at 100 %, without "fit to page", and measure the bar. docs/robots.md has more.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus tag 7\n  meniscus tag 7 --size-mm 60 --paper letter --out gripper.svg"
)]
pub(crate) struct Arguments {
    /// Number of the tag in the family 36h11, 0 to 586.
    #[arg(value_name = "NUMBER", value_parser = clap::value_parser!(u32).range(..i64::from(NUMBERS)))]
    number: u32,
    /// Width of the black square, without the white margin, mm.
    #[arg(long, default_value_t = 40.0, value_name = "MM")]
    size_mm: f64,
    /// Paper, upright.
    #[arg(long, value_enum, default_value_t = PaperName::A4)]
    paper: PaperName,
    /// File for the page [default: tag-NUMBER-MMmm.svg].
    #[arg(long, value_name = "SVG", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// Name of a paper on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum PaperName {
    A4,
    A3,
    Letter,
}

impl From<PaperName> for Paper {
    fn from(name: PaperName) -> Self {
        match name {
            PaperName::A4 => Self::A4,
            PaperName::A3 => Self::A3,
            PaperName::Letter => Self::Letter,
        }
    }
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { number, size_mm, paper, force, .. } = *arguments;
    let [least, most] = SIZES_MM;
    ensure!(
        (least..=most).contains(&size_mm),
        "--size-mm {size_mm} is out of range: {least} to {most}. It is the width of the black square"
    );
    let largest_mm = Paper::from(paper).largest_tag_mm();
    ensure!(
        size_mm <= largest_mm,
        "--size-mm {size_mm} does not fit on the paper: at most {largest_mm} on this one, {} with --paper a3",
        Paper::A3.largest_tag_mm()
    );
    let pattern = TagPattern::of(number).context("the family 36h11 has no such tag")?;
    let out = arguments.out.clone().unwrap_or_else(|| format!("tag-{number}-{size_mm}mm.svg").into());
    force.check(&out)?;
    let option = format!("--motion tag:{number},{size_mm}");
    let text = [
        "This bar is 100 mm long. If it is not, print again at 100 %, without fitting to the page.",
        &format!("AprilTag 36h11, number {number}. The black square is {size_mm} mm wide."),
        &format!("meniscus run --source usb {option}"),
    ];
    let page = TagPage { pattern, size_mm, paper: paper.into(), text: &text };
    write_whole(&out, page.svg().as_bytes())?;
    println!(
        "{}: print it at 100 %, measure the bar, then: meniscus run --source usb {option}",
        out.display()
    );
    Ok(())
}
