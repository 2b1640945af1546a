//! The commands that this program was built without: they say how to get them.

/// One such command, that needs a build with `$built`.
macro_rules! absent {
    ($name:ident, $about:literal, $without:literal, $built:literal) => {
        pub(crate) mod $name {
            #[doc = $about]
            #[derive(clap::Args)]
            #[command(
                        about = concat!($about, " (not in this build)"),
                        long_about = concat!(
                            $about, ": not in this build.\n\nThis program was built without ", $without,
                            ". From the repository:\n\n  ", $built, " -- ", stringify!($name), " --help"
                        )
                    )]
            pub(crate) struct Arguments {
                /// Whatever the command would have been asked.
                #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
                _rest: Vec<String>,
            }

            /// Refuses, with the remedy.
            pub(crate) fn run(_: &Arguments) -> anyhow::Result<()> {
                anyhow::bail!(
                    concat!(
                        "this program was built without ",
                        $without,
                        "; from the repository: ",
                        $built,
                        " -- {} --help"
                    ),
                    stringify!($name)
                )
            }
        }
    };
}

/// One that learns.
#[cfg(not(feature = "train"))]
macro_rules! learning {
    ($name:ident, $about:literal) => {
        absent!(
            $name,
            $about,
            "training, which takes some minutes to build",
            "cargo run --release --features train"
        );
    };
}

/// One that simulates or studies.
#[cfg(not(feature = "studies"))]
macro_rules! studying {
    ($name:ident, $about:literal) => {
        absent!($name, $about, "all that `run` does not need", "cargo run --release");
    };
}

#[cfg(not(feature = "desk"))]
absent!(
    manual,
    "Write man pages and shell completions",
    "all that a board does not need",
    "cargo run --release"
);

#[cfg(not(feature = "desk"))]
absent!(
    camera,
    "Study the surface reader and the camera's faults",
    "all that a board does not need",
    "cargo run --release"
);

#[cfg(not(all(feature = "bags", feature = "desk")))]
absent!(
    record,
    "Record a camera's images, or convert a recording",
    "all that `run` does not need",
    "cargo run --release"
);

#[cfg(not(feature = "desk"))]
absent!(
    tag,
    "Print an AprilTag of a stated width for `run --motion tag`",
    "all that a board does not need",
    "cargo run --release"
);

#[cfg(not(feature = "train"))]
pub(crate) use learning_verbs::{correct, evaluate, generic, learn, train};
#[cfg(not(feature = "studies"))]
pub(crate) use studying_verbs::{
    bench, deadline, discover, export, insert, people, plan, quantize, recognise, render, simulate, sweep,
};

#[cfg(not(feature = "train"))]
mod learning_verbs {
    learning!(learn, "Learn a new liquid from its name or its recordings");
    learning!(train, "Train a model of a liquid on recordings and write its weight blob");
    learning!(correct, "Correct a model for another liquid from recordings of its surface");
    learning!(evaluate, "Evaluate a model on other liquids, before and after correction");
    learning!(generic, "Learn a closed system from trajectories, with exact thermodynamics");
}

#[cfg(not(feature = "studies"))]
mod studying_verbs {
    studying!(sweep, "Run one command for many values, on one machine or on a cluster");
    studying!(simulate, "Simulate a moved glass of liquid and record it");
    studying!(discover, "Identify the effect that a simulation lacks, from measurements");
    studying!(people, "Study viewers, identification and the first start");
    studying!(plan, "Plan the fastest motion of a glass whose crest stays below a limit");
    studying!(render, "Draw a recording as a film: camera, estimate, truth and error");
    studying!(export, "Export a recording to VTK files, for ParaView, PyVista or VisIt");
    studying!(insert, "Insert effects into a model: differences from the trained liquid");
    studying!(quantize, "Store a model's weights in fewer bits and measure the added error");
    studying!(recognise, "Identify the liquid of a recording among known ones");
    studying!(bench, "Time the kernels, the turn and a start beside named peers");
    studying!(deadline, "Count late turns over minutes, idle and under load");
}
