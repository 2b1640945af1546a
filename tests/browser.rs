//! The live page in a headless Chromium: it draws, and it says what is old or lost.
//!
//! ```sh
//! cargo test --release -p meniscus-tests --test browser                                   # without Chromium: skipped, a failure in CI
//! MENISCUS_PAGE_PICTURE=docs/page.png cargo test --release -p meniscus-tests --test browser draws    # the picture of the documentation
//! ```

#[path = "support/chromium.rs"]
mod chromium;
#[path = "support/corrected.rs"]
mod corrected;
#[path = "support/optional.rs"]
mod optional;
#[path = "support/server.rs"]
#[allow(dead_code, reason = "each test takes what it needs of it")]
mod server;

use chromium::{Browser, Tab};
use server::Run;
use std::collections::HashSet;
use std::sync::Mutex;

/// One browser and one run at a time: a machine without a graphics card draws on its processor.
static ONE: Mutex<()> = Mutex::new(());

const DESKTOP: (u32, u32) = (1440, 900);
const PHONE: (u32, u32) = (390, 844);

fn state(of: &str) -> String {
    format!("document.documentElement.dataset.state === '{of}'")
}

fn banner(words: &str) -> String {
    format!(
        "!document.getElementById('banner').hidden && document.getElementById('banner').textContent.includes('{words}')"
    )
}

/// Waits until the liquid is tracked and some frames have been drawn.
fn until_tracking(browser: &mut Browser, tab: &Tab) {
    browser.until(tab, &state("live"));
    browser.until(tab, "document.documentElement.dataset.mode === 'tracking'");
    browser.until(tab, "Number(document.documentElement.dataset.frames) > 20");
}

/// Different colours in the picture of an element.
fn colours(browser: &mut Browser, tab: &Tab, selector: &str) -> usize {
    let png = browser.picture(tab, selector);
    let image = image::load_from_memory(&png).expect("a PNG").into_rgb8();
    image.pixels().map(|pixel| pixel.0).collect::<HashSet<_>>().len()
}

/// A paused page shows its last seconds again: an earlier time, another liquid and another image.
fn looks_back(browser: &mut Browser, tab: &Tab) {
    let paused_at = "parseFloat(/at ([0-9.e+-]+) s/.exec(document.getElementById('banner').textContent)[1])";
    let stopped = browser.evaluate(tab, paused_at).as_f64().expect("a time");
    let pictures = |browser: &mut Browser| ["#gl", "#camera"].map(|part| browser.picture(tab, part));
    let [liquid, image] = pictures(browser);
    // Sixty frames, of the seconds in which the glass moves.
    let back =
        "{ const b = document.getElementById('back'); b.value = Math.max(b.max - 60, 0); b.oninput() }";
    browser.evaluate(tab, back);
    browser.until(tab, &format!("{paused_at} < {stopped}"));
    let earlier = browser.evaluate(tab, paused_at).as_f64().expect("a time");
    assert!((0.5..20.5).contains(&(stopped - earlier)), "{stopped} s back to {earlier} s");
    // The image is decoded beside the page. Of a slow browser the nearest one may be some tenths of a second away.
    let image_time = "parseFloat(document.documentElement.dataset.imageTime)";
    browser.until(tab, &format!("{image_time} < {stopped} - 0.25"));
    let [liquid_before, image_before] = pictures(browser);
    assert!(liquid != liquid_before, "the liquid of an earlier time");
    assert!(image != image_before, "the image of an earlier time");
}

#[test]
fn it_draws_the_liquid_and_everything_beside_it() {
    let _one = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(mut browser) = Browser::start("draws") else { return };
    let run = Run::start(&["--listen", "127.0.0.1:0"]);
    let tab = browser.open(&run.url, DESKTOP);
    until_tracking(&mut browser, &tab);
    // The strokes of the shipped recording begin after a third of a second, and go on for some.
    browser.until(&tab, "parseFloat(document.getElementById('slosh').textContent) > 0.05");
    for (selector, least) in
        [("#gl", 1000), ("#camera", 60), ("#profile", 40), ("#energy", 20), ("#entropy", 20), ("#bar", 100)]
    {
        let found = colours(&mut browser, &tab, selector);
        assert!(found > least, "{selector} shows {found} colours");
    }
    let before = browser.picture(&tab, "#gl");
    browser.until(&tab, "(window.seen ??= document.documentElement.dataset.frames) !== document.documentElement.dataset.frames");
    assert_ne!(before, browser.picture(&tab, "#gl"), "the liquid moves");
    for field in 0..5 {
        browser.evaluate(
            &tab,
            &format!("{{ const f = document.getElementById('field'); f.value = {field}; f.onchange() }}"),
        );
        browser.until(&tab, "/[0-9]/.test(document.getElementById('high').textContent)");
    }
    browser.evaluate(&tab, "{ const f = document.getElementById('field'); f.value = 0; f.onchange() }");
    // The source is simulated: the truth is there, and an error that a flat surface would not have.
    browser.until(&tab, "!document.getElementById('true-key').hidden");
    let error = "/error ([0-9.]+) % relative to the slosh/.exec(document.getElementById('surface-error').textContent)?.[1]";
    browser.until(&tab, &format!("((e) => e > 0 && e < 20)({error})"));
    // An own end of the scale holds, and the scale of another field is another's.
    browser.evaluate(&tab, "{ const t = document.getElementById('top'); t.value = 0.123; t.oninput() }");
    browser.until(&tab, "document.getElementById('high').textContent === '0.123 m/s'");
    browser.evaluate(&tab, "{ const f = document.getElementById('field'); f.value = 1; f.onchange() }");
    browser.until(&tab, "document.getElementById('top').value === ''");
    browser.evaluate(&tab, "{ const f = document.getElementById('field'); f.value = 0; f.onchange() }");
    // The technical counters are folded away.
    for (list, seen) in [("counters", true), ("technical", false)] {
        let visible = format!("document.getElementById('{list}').checkVisibility()");
        assert_eq!(browser.evaluate(&tab, &visible), seen, "{list}");
    }
    // The depth image has the colours of its scale: hundreds, where the infrared image is grey but for two lines.
    browser.evaluate(&tab, "{ const i = document.getElementById('image'); i.value = 1; i.onchange() }");
    browser.until(&tab, "document.getElementById('depths').textContent.startsWith('depth: yellow 330 mm')");
    let found = colours(&mut browser, &tab, "#camera");
    assert!(found > 100, "the depth image shows {found} colours");
    if let Some(path) = std::env::var_os("MENISCUS_DEPTH_PICTURE") {
        std::fs::write(&path, browser.picture(&tab, "")).expect("the picture is written");
    }
    browser.evaluate(&tab, "{ const i = document.getElementById('image'); i.value = 0; i.onchange() }");
    browser.until(&tab, "document.getElementById('depths').textContent === ''");
    // A gentler rate: without a graphics card the browser has the processor to itself no longer.
    browser.evaluate(&tab, "{ const r = document.getElementById('rate'); r.value = 30; r.onchange() }");
    browser.evaluate(&tab, "document.getElementById('pause').click()");
    browser.until(&tab, &banner("Paused"));
    looks_back(&mut browser, &tab);
    browser.evaluate(&tab, "document.getElementById('pause').click()");
    browser.until(&tab, "document.getElementById('banner').hidden");
    assert_eq!(browser.evaluate(&tab, "document.getElementById('look-back').checkVisibility()"), false);
    if let Some(path) = std::env::var_os("MENISCUS_PAGE_PICTURE") {
        let lively = "parseFloat(document.getElementById('slosh').textContent) > 0.25 \
                      && !document.body.classList.contains('no-image')";
        browser.until(&tab, lively);
        let png = browser.picture(&tab, "");
        std::fs::write(&path, png).expect("the picture is written");
    }
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

/// Of a corrected model the page offers what is known, greys out what is not, and says why.
#[test]
fn it_greys_out_what_a_corrected_model_does_not_know() {
    let _one = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(mut browser) = Browser::start("corrected") else { return };
    let model = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser-corrected.blob");
    std::fs::write(&model, &*corrected::corrected()).expect("written");
    let run = Run::start(&["--listen", "127.0.0.1:0", "--model", &model.display().to_string()]);
    let tab = browser.open(&run.url, DESKTOP);
    until_tracking(&mut browser, &tab);
    browser.until(&tab, "document.getElementById('field').selectedOptions[0].textContent === 'displacement'");
    browser.until(
        &tab,
        "[...document.getElementById('field').options].map((o) => o.disabled).join() === 'true,false,true,true,true'",
    );
    browser.until(
        &tab,
        "!document.getElementById('unknown').hidden && \
         document.getElementById('unknown').textContent.includes('corrected from the free surface alone. Velocity')",
    );
    for (number, canvas) in [("slosh", "energy"), ("heat", "entropy")] {
        browser.until(&tab, &format!("document.getElementById('{number}').textContent === 'not known'"));
        browser.until(&tab, &format!("document.getElementById('{canvas}').classList.contains('unknown')"));
    }
    browser.until(&tab, "/[0-9] mm/.test(document.getElementById('high').textContent)");
    if let Some(path) = std::env::var_os("MENISCUS_CORRECTED_PICTURE") {
        std::fs::write(&path, browser.picture(&tab, "")).expect("the picture is written");
    }
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn it_survives_a_program_that_ends_and_comes_back() {
    let _one = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(mut browser) = Browser::start("reconnect") else { return };
    let run = Run::start(&["--listen", "127.0.0.1:0"]);
    let address = run.authority().to_owned();
    let tab = browser.open(&run.url, DESKTOP);
    until_tracking(&mut browser, &tab);
    drop(run);
    browser.until(&tab, &state("reconnecting"));
    browser.until(&tab, &banner("s old"));
    browser.until(&tab, "document.body.classList.contains('old')");
    let run = Run::start(&["--listen", &address]);
    until_tracking(&mut browser, &tab);
    browser.until(&tab, "!document.body.classList.contains('old')");
    drop(run);
}

#[test]
fn a_lost_camera_is_said_and_its_return_too() {
    let _one = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(mut browser) = Browser::start("camera") else { return };
    let run = Run::start(&["--listen", "127.0.0.1:0", "--source", "simulated-usb:unplug"]);
    let tab = browser.open(&run.url, DESKTOP);
    browser.until(&tab, &banner("Camera lost"));
    // After a second without images nothing is shown as an estimate.
    browser.until(&tab, "document.body.classList.contains('no-estimate')");
    browser.until(&tab, "document.body.classList.contains('no-image')");
    // What the session met and does about it stands under the line.
    browser.until(&tab, "document.getElementById('note').textContent.startsWith('Camera: ')");
    // It is plugged in again after two seconds.
    until_tracking(&mut browser, &tab);
    browser.until(&tab, "document.getElementById('banner').hidden");
    browser.until(&tab, "document.getElementById('note').hidden");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_wrong_token_is_refused_with_a_page_that_says_what_to_do() {
    let _one = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(mut browser) = Browser::start("token") else { return };
    let run = Run::start(&["--listen", "0.0.0.0:0"]);
    let (_, token) = run.url.split_once("?token=").expect("an address for others has a token");
    let port = run.authority().rsplit(':').next().expect("a port");
    let wrong = format!("http://127.0.0.1:{port}/?token={}", token.to_uppercase());
    let tab = browser.open(&wrong, DESKTOP);
    browser.until(
        &tab,
        "document.body !== null && document.body.innerText.includes('The token in the address is wrong')",
    );
    let tab = browser.open(&run.url, DESKTOP);
    until_tracking(&mut browser, &tab);
}

#[test]
fn it_fits_a_phone() {
    let _one = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let Some(mut browser) = Browser::start("phone") else { return };
    let run = Run::start(&["--listen", "127.0.0.1:0"]);
    for size in [PHONE, (320, 640)] {
        let tab = browser.open(&run.url, size);
        until_tracking(&mut browser, &tab);
        let width = browser.evaluate(&tab, "document.documentElement.scrollWidth - window.innerWidth");
        assert!(width.as_f64().is_some_and(|over| over <= 0.0), "{size:?}: {width} pixels too wide");
        let found = colours(&mut browser, &tab, "#gl");
        assert!(found > 500, "{found} colours in 3D");
    }
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}
