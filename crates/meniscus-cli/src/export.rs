//! `meniscus export`: a recording for other programs.

use super::inputs;
use super::outputs::{Force, check_folder};
use super::stop::{finish, watched_until};
use anyhow::ensure;
use meniscus_data::recording::Recording;
use meniscus_data::vtk::{ParticleFile, Selected, write, write_particles};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Export a recording to VTK files, for ParaView, PyVista or VisIt.
///
/// The --vtp folder gets tracers.pvd and surface.pvd with one .vtp file a frame. Tracers are points with velocity, internal energy and
/// stresses, as far as the recording knows them. The surface is a mesh of triangles. With NAME.particles.safetensors beside the
/// recording (`meniscus simulate --particles`) it also gets particles.pvd. Positions are in the room, all values in SI units.
///
/// Python writes the same files, and HDF5 for LagrangeBench (docs/python.md). Ctrl-C leaves no collection.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus export --vtp vtk\n  meniscus export strokes-7.safetensors --vtp vtk --every 2"
)]
pub(crate) struct Arguments {
    /// Recording of `meniscus simulate`, or the one in the program (shipped).
    #[arg(default_value = "shipped", value_name = "shipped|RECORDING")]
    recording: String,
    /// Folder for the VTK files; it is made.
    #[arg(long, required = true, value_name = "DIR", help_heading = "Output")]
    vtp: PathBuf,
    /// One frame of so many; 1 takes all 60 a second.
    #[arg(
        long,
        default_value_t = 1,
        value_name = "FRAMES",
        value_parser = clap::value_parser!(u32).range(1..=100_000),
        help_heading = "Output"
    )]
    every: u32,
    #[command(flatten)]
    force: Force,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let (recording, particles) = match arguments.recording.as_str() {
        "shipped" => {
            let origin = Path::new("the shipped recording");
            (Recording::from_bytes(origin, meniscus_shipped::RECORDING)?, None)
        }
        file => {
            let beside = Path::new(file).with_extension("particles.safetensors");
            let particles = beside.exists().then(|| ParticleFile::load(&beside)).transpose()?;
            (inputs::recording(Path::new(file))?, particles)
        }
    };
    arguments.force.check_absent(&arguments.vtp)?;
    check_folder(&arguments.vtp)?;
    let stop = watched_until(format!(
        "{} holds the files of the frames that were written, and no collection",
        arguments.vtp.display()
    ))?;
    let selected = Selected { every: arguments.every as usize };
    let frames = selected.of(recording.frames()).len();
    let bar = crate::bars::bar((frames * (1 + usize::from(particles.is_some()))) as u64);
    bar.set_style(crate::bars::style("frames {wide_bar} {pos}/{len}, {left}")?);
    let mut watch = |_| {
        bar.inc(1);
        !stop.load(Ordering::Relaxed)
    };
    let mut collections = vec!["tracers.pvd", "surface.pvd"];
    write(&recording, &arguments.vtp, selected, &mut watch)?;
    if let Some(particles) = &particles {
        write_particles(particles, &recording, &arguments.vtp, selected, &mut watch)?;
        collections.push("particles.pvd");
    }
    bar.finish_and_clear();
    ensure!(
        !stop.load(Ordering::Relaxed),
        "the export was interrupted: there are files without a collection"
    );
    finish();
    for name in collections {
        println!("{}", arguments.vtp.join(name).display());
    }
    Ok(())
}
