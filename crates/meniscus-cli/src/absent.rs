//! The commands that this program was built without: they say how to get them.

/// One such command, that needs a build with `$built`.
macro_rules! absent {
    ($name:ident, $about:literal, $without:literal, $built:literal) => {
        pub(crate) mod $name {
            #[doc = $about]
            #[derive(clap::Args)]
            #[command(
                about = concat!($about, " (not in this build: see its --help)"),
                long_about = concat!(
                    $about, ": not in this build.\n\nThis program was built without ", $without,
                    ". From the repository, with the name of the command for NAME:\n\n  ", $built, " -- NAME --help"
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

/// One that simulates, records or studies.
#[cfg(not(feature = "studies"))]
macro_rules! studying {
    ($name:ident, $about:literal) => {
        absent!($name, $about, "all that `run` does not need", "cargo run --release");
    };
}

#[cfg(not(feature = "train"))]
pub(crate) use learning_verbs::{correct, evaluate, generic, train};
#[cfg(not(feature = "studies"))]
pub(crate) use studying_verbs::{
    bench, camera, deadline, discover, insert, people, quantize, recognise, record, render, setup, simulate,
};

#[cfg(not(feature = "train"))]
mod learning_verbs {
    learning!(train, "Learn a liquid from recordings and write the weight blob");
    learning!(correct, "Correct a model by what a camera saw of another liquid");
    learning!(evaluate, "Hold a model against other liquids, before and after correction");
    learning!(generic, "Learn any closed system from its trajectories, the laws kept exactly");
}

#[cfg(not(feature = "studies"))]
mod studying_verbs {
    studying!(simulate, "Simulate a moved glass of liquid and record it");
    studying!(discover, "Name what recordings show and the model does not");
    studying!(setup, "Set up a glass before a camera");
    studying!(camera, "Look into the camera side");
    studying!(record, "Record a camera, or turn one recording into another");
    studying!(people, "Look into what people see of a run");
    studying!(render, "Make pictures and films of a recording");
    studying!(insert, "Put a named effect into a model");
    studying!(quantize, "The same model in fewer bytes");
    studying!(recognise, "Say which known liquid moves in a recording");
    studying!(bench, "How fast and how large everything is here");
    studying!(deadline, "Count the late turns of minutes");
}
