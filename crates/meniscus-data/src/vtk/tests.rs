use super::poly_data::Cells;
use super::room::Pose;
use super::*;
use crate::recording::{COLUMNS, WALL_POINTS};
use std::collections::HashMap;

fn shipped() -> Recording {
    Recording::from_bytes(Path::new("shipped"), meniscus_shipped::RECORDING).expect("the shipped recording")
}

/// A closed disc: every edge has two triangles, but for those along the wall, and Euler's number is one.
#[test]
fn the_surface_is_one_disc_without_holes_that_looks_up() {
    let triangles = surface_mesh::triangles();
    let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
    for [a, b, c] in &triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry([*from.min(to), *from.max(to)]).or_default() += 1;
        }
    }
    let border = edges.values().filter(|count| **count == 1).count();
    assert!(edges.values().all(|count| (1..=2).contains(count)), "an edge of three triangles");
    assert_eq!(border, WALL_POINTS);
    assert_eq!((COLUMNS + WALL_POINTS) as i64 - edges.len() as i64 + triangles.len() as i64, 1);

    let recording = shipped();
    let pose = Pose::of(&recording, 0);
    let mesh = surface_mesh::surface(&recording, &Lattice::new(&recording.glass), 0, &pose, &triangles);
    let at = |k: u32| mesh.points[k as usize].map(f64::from);
    let mut area = 0.0;
    for [a, b, c] in triangles.iter().map(|corners| corners.map(at)) {
        let up = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(up > 0.0, "a triangle that looks down");
        area += 0.5 * up;
    }
    // The 72-gon in the circle of the wall: n/2 R^2 sin(2 pi/n).
    let n = WALL_POINTS as f64;
    let polygon = 0.5 * n * recording.glass.radius_m.powi(2) * (std::f64::consts::TAU / n).sin();
    assert!((area / polygon - 1.0).abs() < 1e-4, "{area} for {polygon}");
}

#[test]
fn an_inclined_glass_turns_about_its_pivot() {
    let mut recording = shipped();
    recording.tilt_rad[3] = std::f64::consts::FRAC_PI_2;
    recording.provenance.pivot_m = [0.01, 0.02];
    (recording.glass_x_m[3], recording.glass_z_m[3]) = (0.1, 0.2);
    let pose = Pose::of(&recording, 3);
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-7);
    // The pivot goes with the glass; what stood above it lies on the side of +x.
    assert!(close(pose.place([0.01, 0.0, 0.02]), [0.11, 0.0, 0.22]));
    assert!(close(pose.place([0.01, 0.005, 0.05]), [0.14, 0.005, 0.22]));
}

#[test]
fn fields_that_are_not_known_are_left_out_and_an_export_that_is_stopped_has_no_collection() {
    let folder = std::env::temp_dir().join(format!("meniscus-vtk-{}", std::process::id()));
    let recording = Recording { known: meniscus::blob::KnownGroups::KINEMATICS, ..shipped() };
    let stopped = write(&recording, &folder.join("stopped"), Selected { every: 200 }, &mut |_| false);
    assert_eq!(stopped.expect("written"), 1);
    assert!(!folder.join("stopped/tracers.pvd").exists());
    let frames =
        write(&recording, &folder.join("all"), Selected { every: 300 }, &mut |_| true).expect("written");
    assert_eq!(frames, 2);
    let collection = std::fs::read_to_string(folder.join("all/tracers.pvd")).expect("a collection");
    assert!(collection.contains("timestep=\"5\"") && collection.contains("tracers-0300.vtp"), "{collection}");
    let file = std::fs::read(folder.join("all/tracers-0300.vtp")).expect("a file");
    let head = String::from_utf8_lossy(&file[..2000.min(file.len())]).into_owned();
    assert!(head.contains("NumberOfPoints=\"2134\"") && !head.contains("velocity_m_s"), "{head}");
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn a_cell_of_a_point_cloud_is_one_vertex() {
    let cloud = poly_data::PolyData {
        points: vec![[0.0; 3], [1.0; 3]],
        cells: Cells::Vertices,
        arrays: Vec::new(),
        time_s: 0.5,
    };
    let bytes = cloud.to_vtp();
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("NumberOfVerts=\"2\"") && text.contains("NumberOfPolys=\"0\""), "{text}");
    // Behind the underscore: 24 bytes of points, 8 of connectivity, 8 of offsets, each behind its length.
    let start = text.find("\n_").expect("appended data") + 2;
    assert_eq!(bytes[start..start + 8], 24_u64.to_le_bytes());
    assert_eq!(bytes[start + 8 + 24..start + 8 + 24 + 8], 8_u64.to_le_bytes());
}

/// Writes particles as the simulator does: two of them in two frames, the second gone over the rim in the last.
fn particles(path: &Path) {
    let bytes = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let vectors = bytes(&[0.0, 0.0, 0.01, 0.0, 0.0, 0.02, 0.0, 0.0, 0.01, f32::NAN, f32::NAN, f32::NAN]);
    let scalars = bytes(&[1.0, 2.0, 3.0, f32::NAN]);
    let mass = bytes(&[1.0, 1.0]);
    let view = |shape: &[usize], bytes| {
        let dtype = safetensors::tensor::Dtype::F32;
        safetensors::tensor::TensorView::new(dtype, shape.to_vec(), bytes).expect("as many bytes")
    };
    let tensors = [
        ("position_m", view(&[2, 2, 3], &vectors)),
        ("velocity_m_s", view(&[2, 2, 3], &vectors)),
        ("pressure_pa", view(&[2, 2], &scalars)),
        ("heat_j_kg", view(&[2, 2], &scalars)),
        ("mass_kg", view(&[2], &mass)),
    ];
    std::fs::write(path, safetensors::serialize(tensors, None).expect("bytes")).expect("written");
}

#[test]
fn particles_over_the_rim_are_left_out_and_other_files_are_refused() {
    let folder = std::env::temp_dir().join(format!("meniscus-vtk-particles-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("x.particles.safetensors");
    particles(&file);
    let all = ParticleFile::load(&file).expect("particles");
    let frames = write_particles(&all, &shipped(), &folder, Selected { every: 1 }, &mut |_| true);
    assert_eq!(frames.expect("written"), 2);
    for (frame, points) in [("0000", 2), ("0001", 1)] {
        let bytes = std::fs::read(folder.join(format!("particles-{frame}.vtp"))).expect("a file");
        let text = String::from_utf8_lossy(&bytes).into_owned();
        assert!(text.contains(&format!("NumberOfPoints=\"{points}\"")), "{text}");
    }
    std::fs::write(&file, meniscus_shipped::RECORDING).expect("written");
    let why = ParticleFile::load(&file).expect_err("a recording").to_string();
    assert!(why.contains("should hold particles"), "{why}");
    std::fs::remove_dir_all(&folder).expect("removed");
}
