//! The commands that learn, in a program that was built without learning: they say how to get it.

/// One such command.
macro_rules! absent {
    ($name:ident, $about:literal) => {
        pub(crate) mod $name {
            #[doc = $about]
            ///
            /// Learning needs the feature `train`, which takes some minutes to build. From the repository,
            /// with the name of the command for NAME:
            ///
            ///   cargo run --release --features train -- NAME --help
            #[derive(clap::Args)]
            #[command(verbatim_doc_comment)]
            pub(crate) struct Arguments {
                /// Whatever the command would have been asked.
                #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
                _rest: Vec<String>,
            }

            /// Refuses, with the remedy.
            pub(crate) fn run(_: &Arguments) -> anyhow::Result<()> {
                anyhow::bail!(
                    "this program was built without training; from the repository: \
                     cargo run --release --features train -- {} --help",
                    stringify!($name)
                )
            }
        }
    };
}

absent!(train, "Learn a liquid from recordings and write the weight blob (not in this build: see below).");
absent!(correct, "Correct a model by what a camera saw of another liquid (not in this build: see below).");
absent!(
    evaluate,
    "Hold a model against other liquids, before and after correction (not in this build: see below)."
);
absent!(
    generic,
    "Learn any closed system from its trajectories, the laws kept exactly (not in this build: see below)."
);
