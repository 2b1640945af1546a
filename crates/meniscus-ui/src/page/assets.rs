//! The page's files, in the program itself, and the only paths that it answers.

/// One file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asset {
    /// Its path in an address.
    pub(super) path: &'static str,
    /// Its kind, as HTTP spells it.
    pub(super) kind: &'static str,
    /// Its bytes.
    pub(super) bytes: &'static [u8],
}

/// Plain text in the page's language.
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// The page itself.
pub(super) const INDEX: Asset =
    Asset { path: "/", kind: "text/html; charset=utf-8", bytes: include_bytes!("assets/index.html") };

/// Files that the page loads.
pub(super) const ASSETS: [Asset; 12] = [
    Asset { path: "/style.css", kind: "text/css; charset=utf-8", bytes: include_bytes!("assets/style.css") },
    Asset { path: "/page.js", kind: SCRIPT, bytes: include_bytes!("assets/page.js") },
    Asset { path: "/counters.js", kind: SCRIPT, bytes: include_bytes!("assets/counters.js") },
    Asset { path: "/connection.js", kind: SCRIPT, bytes: include_bytes!("assets/connection.js") },
    Asset { path: "/field.js", kind: SCRIPT, bytes: include_bytes!("assets/field.js") },
    Asset { path: "/colours.js", kind: SCRIPT, bytes: include_bytes!("assets/colours.js") },
    Asset { path: "/liquid.js", kind: SCRIPT, bytes: include_bytes!("assets/liquid.js") },
    Asset { path: "/camera.js", kind: SCRIPT, bytes: include_bytes!("assets/camera.js") },
    Asset { path: "/past.js", kind: SCRIPT, bytes: include_bytes!("assets/past.js") },
    Asset { path: "/plots.js", kind: SCRIPT, bytes: include_bytes!("assets/plots.js") },
    Asset { path: "/twgl.js", kind: SCRIPT, bytes: include_bytes!("assets/vendor/twgl-full.module.js") },
    Asset {
        path: "/licences.txt",
        kind: "text/plain; charset=utf-8",
        bytes: include_bytes!("assets/vendor/LICENSE.md"),
    },
];
