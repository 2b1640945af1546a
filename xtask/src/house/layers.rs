//! Layer order of the crates, and the dependencies that break it.

use crate::report::{Check, Target};
use crate::workspace::Package;
use std::path::Path;

/// The layers, lowest first. A package depends only on packages of lower layers.
const LAYERS: &[&[&str]] = &[
    &["meniscus", "meniscus-hil", "meniscus-shipped"],
    &["meniscus-numerics", "meniscus-platform", "meniscus-report", "meniscus-usb"],
    &["meniscus-bags", "meniscus-data", "meniscus-optim", "meniscus-service", "meniscus-webcam"],
    &["generic-systems", "meniscus-ros", "meniscus-sph", "meniscus-tag", "meniscus-ui", "meniscus-virtual"],
    &["meniscus-plan", "meniscus-score", "meniscus-timing"],
    &["meniscus-discover", "meniscus-learn"],
    &["meniscus-relearn"],
    &["meniscus-cli", "meniscus-python"],
    &["meniscus-benches", "meniscus-core-tests", "meniscus-examples", "meniscus-tests", "xtask"],
];

/// Crates of the product: the root package and the members in `crates/`.
pub(super) fn crates(root: &Path, packages: &[Package]) -> Check {
    let of_product =
        |package: &&Package| package.folder == root || package.folder.starts_with(root.join("crates"));
    Check {
        name: "crates",
        value: packages.iter().filter(of_product).count() as f64,
        unit: "",
        target: Target::AtLeast(10.0),
        offenders: Vec::new(),
    }
}

/// Dependencies that do not point to a lower layer, of all kinds (normal, build, dev).
pub(super) fn upward_imports(packages: &[Package]) -> Check {
    let mut offenders = Vec::new();
    for package in packages {
        let manifest = package.folder.join("Cargo.toml");
        let manifest = manifest.display();
        let Some(own) = layer(&package.name) else {
            offenders.push(format!("{manifest}: {} has no layer in xtask/src/house/layers.rs", package.name));
            continue;
        };
        let upward = package.members.iter().filter(|member| layer(member).is_none_or(|below| below >= own));
        offenders.extend(upward.map(|member| {
            let of = layer(member).map_or("none".to_owned(), |layer| layer.to_string());
            format!("{manifest}: {} (layer {own}) depends on {member} (layer {of})", package.name)
        }));
    }
    Check::count("upward_imports", "", 0.0, offenders)
}

fn layer(package: &str) -> Option<usize> {
    LAYERS.iter().position(|names| names.contains(&package))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn package(name: &str, members: &[&str]) -> Package {
        Package {
            name: name.to_owned(),
            folder: PathBuf::from("/w/crates").join(name),
            roots: Vec::new(),
            has_library: true,
            members: members.iter().map(|&member| member.to_owned()).collect(),
            published: true,
            manifest: serde_json::Value::Null,
        }
    }

    #[test]
    fn a_dependency_upwards_or_sideways_is_reported() {
        let good = package("meniscus-data", &["meniscus", "meniscus-platform"]);
        let upward = package("meniscus-platform", &["meniscus-service"]);
        let sideways = package("meniscus-sph", &["meniscus-ui"]);
        let stranger = package("meniscus-new", &[]);
        let check = upward_imports(&[good, upward, sideways, stranger]);
        assert_eq!(check.value, 3.0, "{:?}", check.offenders);
        assert!(
            check.offenders[0].contains("meniscus-platform (layer 1) depends on meniscus-service (layer 2)")
        );
        assert!(check.offenders[2].contains("no layer"));
    }

    #[test]
    fn crates_of_the_product_are_counted_without_tests_and_tools() {
        let mut tool = package("xtask", &[]);
        tool.folder = PathBuf::from("/w/xtask");
        let check = crates(Path::new("/w"), &[package("meniscus-usb", &[]), tool]);
        assert_eq!(check.value, 1.0);
        assert!(!check.ok());
    }
}
