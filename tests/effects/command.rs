//! The command `meniscus simulate` with scene files: images of a scene, and scenes that it refuses.

use super::Scratch;
use meniscus_data::recording::Recording;
use std::process::Output;

fn command(arguments: &[&str]) -> Output {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"));
    command.arg("simulate").args(arguments).output().expect("the command starts")
}

#[test]
fn the_command_lists_and_takes_a_scene_to_images() {
    let listed = command(&["--list"]);
    let text = String::from_utf8_lossy(&listed.stdout);
    for part in
        ["honey", "tilts", "surface_tension", "0 to 2 N/m", "Lamb 1932", "pinned_line", "camera_pitch"]
    {
        assert!(listed.status.success() && text.contains(part), "{part} is missing in {text}");
    }
    let folder = Scratch::new("scene");
    std::fs::create_dir_all(&folder.0).expect("a folder");
    let path = |name: &str| folder.0.join(name).to_string_lossy().into_owned();
    let scene = "liquid = 'honey'\nmotion = 'still'\nspacing_mm = 8.75\n[glass]\nfill_m = 0.06\n[effects]\nfoam = 0.1\n";
    std::fs::write(path("s.toml"), scene).expect("written");
    let done = command(&[
        "--scene",
        &path("s.toml"),
        "--effect",
        "wall_slip=0.001",
        "--seconds",
        "0.1",
        "--out",
        &path("r.safetensors"),
        "--camera",
        &path("images"),
    ]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let recording = Recording::load(&folder.0.join("r.safetensors")).expect("read");
    assert_eq!((recording.glass.fill_m, recording.provenance.liquid.as_str()), (0.06, "honey"));
    assert_eq!(recording.provenance.effects, [("wall_slip".into(), 0.001), ("foam".into(), 0.1)]);
    assert!(
        recording.provenance.command.contains("--effect wall_slip=0.001"),
        "{}",
        recording.provenance.command
    );
    let depth = image::open(path("images/depth-0005.png")).expect("an image");
    let image::DynamicImage::ImageLuma16(depth) = depth else { panic!("the depth has not 16 bit") };
    let nearest = depth.pixels().map(|z| z.0[0]).filter(|z| *z > 0).min().expect("some depth");
    assert!((1000..4000).contains(&nearest), "{nearest} is the nearest depth");
    let image::DynamicImage::ImageLuma8(grey) =
        image::open(path("images/infrared-0000.png")).expect("an image")
    else {
        panic!("the infrared image has not 8 bit")
    };
    assert_eq!(grey.dimensions(), (640, 480));
    let table = std::fs::read_to_string(path("images/frames.csv")).expect("a table");
    assert_eq!(
        (table.lines().count(), table.lines().nth(2)),
        (7, Some("1,0.016667,depth-0001.png,infrared-0001.png"))
    );
}

#[test]
fn the_command_refuses_scenes_that_cannot_be() {
    let folder = Scratch::new("refused");
    std::fs::create_dir_all(&folder.0).expect("a folder");
    let (scene, out) = (folder.0.join("s.toml"), folder.0.join("r.safetensors"));
    let [scene_name, out_name] = [&scene, &out].map(|path| path.to_string_lossy().into_owned());
    for (text, extra, reason) in [
        ("[effects]\nviscosity = -1", &[][..], "viscosity = -1 Pa s^n is out of range"),
        ("[glass]\nfill_m = 0.2", &[], "rim from the fill"),
        ("liquid = 'treacle'", &[], "no liquid is called 'treacle'"),
        ("", &["--effect", "ghosts=1"], "no effect is called 'ghosts'"),
        ("", &["--effect", "camera_pitch=0.03"], "camera_pitch is not simulated"),
        (
            "",
            &["--effect", "fill=0.002"],
            "fill = 0.002 m is out of range: 0.005 to 0.3 m (height of the liquid",
        ),
        ("step_us = 5000.0", &[], "would blow up"),
        ("[glass]\ntaper = 0.1", &["--camera", "x"], "upright cylinders only"),
        (
            "[glass]\nfill_m = 0.03\nprofile_m = [[0, 0], [0.02, 0.03], [0.06, 0.04]]",
            &["--camera", "x"],
            "a curved profile",
        ),
        ("[glass]\nprofile_m = [[0, 0], [0.02, 0.03], [0.06, 0.04]]", &[], "rim from the fill"),
        ("[glass]\nprofile_m = [[0, 0.03], [0.06, 0.04]]", &[], "it needs 3 to 32"),
    ] {
        std::fs::write(&scene, text).expect("written");
        let mut arguments =
            vec!["--scene", &scene_name, "--motion", "still", "--seconds", "0.1", "--out", &out_name];
        arguments.extend(extra);
        let output = command(&arguments);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(reason), "{text} {extra:?} said {said}");
        assert!(!out.exists(), "{text} left a file");
    }
}
