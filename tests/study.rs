//! A small study of the surface: the same scenes as `meniscus camera study`, fewer of them, of another seed.

use meniscus_virtual::camera_study::conditions::Condition;
use meniscus_virtual::camera_study::judge::{Judged, Row};
use meniscus_virtual::camera_study::scenes;

#[test]
fn heights_lie_inside_their_intervals_and_nothing_is_made_up() {
    let scenes = scenes(11, 60, || ()).expect("sound scenes");
    let of = |keep: &dyn Fn(Condition) -> bool| {
        let chosen: Vec<&Judged> = scenes.iter().filter(|judged| keep(judged.case.condition)).collect();
        Row::of("", "", &chosen)
    };
    let nominal = of(&|condition| condition == Condition::Nominal);
    let all = of(&|condition| condition != Condition::NoLiquid);
    let none = of(&|condition| condition == Condition::NoLiquid);
    println!("{}", Row::HEAD.join("  "));
    for row in [&nominal, &all, &none] {
        println!("{}", row.cells().join("  "));
    }
    assert_eq!(none.profiles, 0, "a profile without liquid");
    assert!(nominal.rms_mm <= 0.6, "{nominal:?}");
    assert!(u64::from(nominal.profiles) == nominal.frames && nominal.points_seen >= 0.97, "{nominal:?}");
    assert!(
        all.coverage >= 0.93,
        "{all:?}: of 60 scenes, whose errors belong together, a little less than of 200"
    );
    // An interval that is wide enough to hold anything would say nothing.
    assert!(all.half_mm <= 1.0, "{all:?}");
}
