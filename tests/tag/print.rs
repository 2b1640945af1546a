//! The printed page: its rectangles are drawn by a camera of the test's own, and the reader finds the tag of the stated number and width.

use crate::program::{errors, folder, meniscus};
use meniscus::surface::Intrinsics;
use meniscus_tag::{TagFinder, pose};
use std::path::Path;

/// Camera before the page.
const LENS: Intrinsics = Intrinsics { width: 640, height: 480, fx: 600.0, fy: 600.0, ppx: 319.5, ppy: 239.5 };
/// Distance of the page from the camera, mm.
const DISTANCE_MM: f64 = 400.0;
/// Rays through a pixel in a row and in a column.
const RAYS: usize = 4;

/// A rectangle of the page, mm, and its grey level.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    grey: f64,
}

/// A page, its later rectangles over earlier ones.
struct Page {
    size_mm: [f64; 2],
    rectangles: Vec<Rectangle>,
}

/// Returns the value of an attribute.
fn attribute<'t>(element: &'t str, name: &str) -> &'t str {
    let (_, rest) = element.split_once(&format!(" {name}=\"")).unwrap_or_else(|| panic!("{name}: {element}"));
    rest.split_once('"').expect("an end").0
}

impl Page {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("a page");
        let head = text.lines().next().expect("a line");
        let size_mm = ["width", "height"].map(|name| {
            attribute(head, name).strip_suffix("mm").expect("millimetres").parse().expect("a number")
        });
        // A unit is a millimetre.
        assert_eq!(attribute(head, "viewBox"), format!("0 0 {} {}", size_mm[0], size_mm[1]));
        let rectangles = text.lines().filter(|line| line.starts_with("<rect")).map(|line| {
            let number = |name: &str| attribute(line, name).parse().expect("a number");
            let grey = if attribute(line, "fill") == "black" { 30.0 } else { 220.0 };
            let [left, top, width, height] = ["x", "y", "width", "height"].map(number);
            Rectangle { left, top, width, height, grey }
        });
        Self { size_mm, rectangles: rectangles.collect() }
    }

    /// Grey level at a place; a dark table beside the page.
    fn grey(&self, [x, y]: [f64; 2]) -> f64 {
        let over =
            |r: &&Rectangle| (0.0..r.width).contains(&(x - r.left)) && (0.0..r.height).contains(&(y - r.top));
        self.rectangles.iter().rev().find(over).map_or(60.0, |rectangle| rectangle.grey)
    }

    /// The page before the camera, whose axis goes through `centre_mm` of it, turned about the vertical by `turn_rad`.
    fn picture(&self, centre_mm: [f64; 2], turn_rad: f64) -> Vec<u8> {
        let (sin, cos) = turn_rad.sin_cos();
        let ray = |u: f64, v: f64| {
            let [across, down] = [(u - f64::from(LENS.ppx)) / f64::from(LENS.fx), (v - 239.5) / 600.0];
            // The page is the plane of (cos, 0, sin) and (0, 1, 0): t (across, down, 1) = a (cos, 0, sin) + b (0, 1, 0) + distance.
            let along = DISTANCE_MM * across / (cos - across * sin);
            let depth = DISTANCE_MM + along * sin;
            self.grey([centre_mm[0] + along, centre_mm[1] + depth * down])
        };
        let offset = |k: usize| (k as f64 + 0.5) / RAYS as f64 - 0.5;
        let pixel = |at: usize| {
            let [u, v] = [at % LENS.width, at / LENS.width].map(|place| place as f64);
            let greys = (0..RAYS * RAYS).map(|k| ray(u + offset(k % RAYS), v + offset(k / RAYS)));
            (greys.sum::<f64>() / (RAYS * RAYS) as f64).round() as u8
        };
        (0..LENS.width * LENS.height).map(pixel).collect()
    }

    /// Left, top and width of the black square: the largest one that is black.
    fn black_square(&self) -> Rectangle {
        let black = self.rectangles.iter().filter(|r| r.grey < 100.0 && (r.width - r.height).abs() < 1e-9);
        *black.max_by(|a, b| a.width.total_cmp(&b.width)).expect("a black square")
    }
}

#[test]
fn the_printed_tag_has_the_stated_number_and_width() {
    let folder = folder("tag-print", "read");
    let mut finder = TagFinder::new((LENS.width, LENS.height)).expect("a finder");
    for (number, size_mm, paper, turn_rad) in
        [(0, 40.0, "a4", 0.0), (7, 40.0, "letter", 0.35), (23, 60.0, "a4", -0.3), (586, 100.0, "a3", 0.2)]
    {
        let name = format!("{number}.svg");
        let output =
            meniscus(&folder, &format!("tag {number} --size-mm {size_mm} --paper {paper} --out {name}"));
        assert!(output.status.success(), "{}", errors(&output));
        assert!(
            String::from_utf8_lossy(&output.stdout).contains(&format!("--motion tag:{number},{size_mm}"))
        );
        let page = Page::read(&folder.join(name));
        let square = page.black_square();
        assert!((square.width - size_mm).abs() < 1e-3 && page.size_mm[0] > square.width, "{square:?}");
        let centre = [square.left + 0.5 * size_mm, square.top + 0.5 * size_mm];
        let image = page.picture(centre, turn_rad);
        let anywhere = finder.anywhere(&image).expect("searched").to_vec();
        assert_eq!(anywhere.iter().map(|tag| tag.number).collect::<Vec<_>>(), [number]);
        let tag = finder.nearby(&image, &anywhere[0].corners_px).expect("searched")[0];
        let found = pose(&tag.corners_px, 1e-3 * size_mm, &LENS).expect("a pose");
        let [x, y, z] = found.position_m.into();
        println!("{number}: {:.2} mm off in {DISTANCE_MM}", 1e3 * z - DISTANCE_MM);
        // A tag of another width by a hundredth were 4 mm nearer or farther.
        assert!((1e3 * z - DISTANCE_MM).abs() < 2.0 && x.hypot(y) < 1e-3, "{number}: {x} {y} {z}");
        // Upright as the page: the first corner is its top left one.
        assert!(tag.corners_px[0][0] < tag.corners_px[1][0] && tag.corners_px[0][1] < tag.corners_px[3][1]);
    }
}

#[test]
fn the_bar_is_a_hundred_millimetres_long() {
    let folder = folder("tag-print", "bar");
    assert!(meniscus(&folder, "tag 7").status.success());
    let page = Page::read(&folder.join("tag-7-40mm.svg"));
    let bar = page.rectangles.iter().find(|r| r.width == 100.0).expect("a bar");
    let below = page.black_square();
    assert!(
        bar.grey < 100.0 && bar.top > below.top + 1.125 * below.height && bar.top < page.size_mm[1] - 20.0
    );
    let parts: Vec<f64> = page.rectangles.iter().filter(|r| r.top > bar.top).map(|r| r.left).collect();
    assert_eq!(parts, [1, 3, 5, 7, 9].map(|part| bar.left + 10.0 * f64::from(part)));
}

#[test]
fn what_is_no_tag_and_what_would_be_replaced_is_refused() {
    let folder = folder("tag-print", "refused");
    for (arguments, due) in [
        ("tag 587", "587"),
        ("tag 7 --size-mm 9", "10 to 300"),
        ("tag 7 --size-mm NaN", "out of range"),
        ("tag 7 --size-mm 200", "--paper a3"),
    ] {
        let output = meniscus(&folder, arguments);
        let said = errors(&output);
        assert!(!output.status.success() && said.contains(due), "{arguments}: {said}");
    }
    assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 0);
    assert!(meniscus(&folder, "tag 7").status.success());
    let again = meniscus(&folder, "tag 7");
    assert!(!again.status.success() && errors(&again).contains("--force"));
    assert!(meniscus(&folder, "tag 7 --force").status.success());
}
