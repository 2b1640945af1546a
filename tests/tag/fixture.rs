//! Images of `tests/fixtures/tag`, rendered by `make.py` there, with their truth and the corners of an independent reader.

use meniscus::surface::Intrinsics;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use serde_json::Value;
use std::path::Path;

/// The tag that is looked for.
pub(crate) const NUMBER: u64 = 7;

/// A tag in an image.
#[derive(Debug)]
pub(crate) struct Known {
    pub(crate) number: u64,
    pub(crate) corners_px: [[f64; 2]; 4],
    /// Attitude and position; the reader states none.
    pub(crate) pose: Option<(UnitQuaternion<f64>, Vector3<f64>)>,
}

/// An image.
#[derive(Debug)]
pub(crate) struct TagImage {
    pub(crate) name: String,
    /// Expected outcome.
    pub(crate) due: String,
    pub(crate) pixels: Vec<u8>,
    pub(crate) truth: Vec<Known>,
    pub(crate) reader: Vec<Known>,
}

/// All images.
pub(crate) struct Fixture {
    pub(crate) lens: Intrinsics,
    pub(crate) size_m: f64,
    pub(crate) images: Vec<TagImage>,
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list = value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number"));
    list.collect::<Vec<f64>>().try_into().expect("as many")
}

fn known(value: &Value) -> Vec<Known> {
    let all = value.as_array().expect("a list").iter().map(|tag| {
        let corner = |k: usize| numbers::<2>(&tag["corners_px"][k]);
        let pose = tag.get("position_m").map(|position| {
            let rows: [[f64; 3]; 3] = std::array::from_fn(|row| numbers(&tag["rotation"][row]));
            let matrix = Matrix3::from_fn(|row, column| rows[row][column]);
            let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&matrix));
            (rotation, Vector3::from(numbers::<3>(position)))
        });
        let number = tag["number"].as_u64().expect("a number");
        Known { number, corners_px: std::array::from_fn(corner), pose }
    });
    all.collect()
}

impl Fixture {
    pub(crate) fn load() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/tag");
        let text = std::fs::read_to_string(folder.join("truth.json")).expect("the truth");
        let truth: Value = serde_json::from_str(&text).expect("JSON");
        let lens = &truth["lens"];
        let number = |name: &str| lens[name].as_f64().expect("a number");
        let whole = |name: &str| number(name) as usize;
        let images = truth["images"].as_array().expect("images").iter().map(|image| {
            let name = image["name"].as_str().expect("a name").to_owned();
            let png = image::open(folder.join(format!("{name}.png"))).expect("an image").into_luma8();
            assert_eq!((png.width() as usize, png.height() as usize), (whole("width"), whole("height")));
            TagImage {
                name,
                due: image["due"].as_str().expect("an outcome").to_owned(),
                pixels: png.into_raw(),
                truth: known(&image["tags"]),
                reader: known(&image["reader"]),
            }
        });
        Self {
            lens: Intrinsics {
                width: whole("width"),
                height: whole("height"),
                fx: number("fx") as f32,
                fy: number("fy") as f32,
                ppx: number("ppx") as f32,
                ppy: number("ppy") as f32,
            },
            size_m: truth["size_m"].as_f64().expect("a size"),
            images: images.collect(),
        }
    }
}
