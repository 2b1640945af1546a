//! `meniscus flash`: a model to a board, so that whatever happens a whole one boots.

use super::inputs;
use super::profile::Profile;
use anyhow::{Context, bail};
use meniscus::blob::Model;
use meniscus_data::validity::Validity;
use meniscus_platform::files::{Links, read_regular, write_whole};
use meniscus_service::flash::{
    Flashed, Folder, Release, Rollback, Signed, boot, flash, rehearse, rehearse_signed, sibling,
};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Write a model to a board's spare slot, safe against power loss.
///
/// TARGET is the folder with the slots, on the board or where its disk is mounted. The slot that boots stays as it is. The new
/// model goes into the other slot, is read back, and is made the one that boots by a single rename. If it is damaged at a
/// start, the other slot boots. `meniscus run --model TARGET` starts it.
///
/// With a public key in the board's profile, a model without a valid signature is neither written nor started. A signature
/// can hold the number of a release. Then no earlier release is written, except with --allow-rollback, and the later one of
/// both slots starts. The profile's least_release excludes earlier ones.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus flash my.blob --to /var/lib/meniscus\n  meniscus flash my.blob --signature my.blob.sig \\\n    --profile /etc/meniscus/board.toml\n  meniscus flash --rehearse 200 --json",
    after_long_help = "Key and signature are made with openssl:\n  openssl genpkey -algorithm ed25519 -out key.pem\n  openssl pkeyutl -sign -rawin -inkey key.pem -in my.blob -out my.blob.sig\nWith a release, what is signed is written first, and the number given again:\n  meniscus flash my.blob --release 7 --to-sign my.blob.7\n  openssl pkeyutl -sign -rawin -inkey key.pem -in my.blob.7 -out my.blob.sig\n  meniscus flash my.blob --release 7 --signature my.blob.sig \\\n    --profile board.toml\nThe profile's public_key is printed by:\n  openssl pkey -in key.pem -pubout -outform DER | tail -c 32 | xxd -p -c 32"
)]
pub(crate) struct Arguments {
    /// The model: a blob file, or the one in the program (shipped).
    #[arg(value_name = "BLOB", required_unless_present = "rehearse")]
    blob: Option<PathBuf>,
    /// Folder with the slots [default: the profile's].
    #[arg(long, value_name = "TARGET", help_heading = "Board")]
    to: Option<PathBuf>,
    /// The board's profile.
    #[arg(long, value_name = "FILE.toml", help_heading = "Board")]
    profile: Option<PathBuf>,
    /// The blob's ed25519 signature, 64 bytes.
    #[arg(long, value_name = "FILE", help_heading = "Board")]
    signature: Option<PathBuf>,
    /// Number of the release that the signature holds; 0 is none.
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true, help_heading = "Board")]
    release: u64,
    /// Only write the bytes that a signature of this release is of.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["to", "profile", "signature", "rehearse"], help_heading = "Board")]
    to_sign: Option<PathBuf>,
    /// Write an earlier release than that on the board, into both slots.
    #[arg(long, help_heading = "Board")]
    allow_rollback: bool,
    /// Only cut the power this many times on a simulated disk.
    ///
    /// The cuts come at random steps, and the disk loses what was not synced.
    #[arg(long, value_name = "N", conflicts_with_all = ["to", "profile", "signature"], help_heading = "Board")]
    rehearse: Option<u32>,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let blob = arguments.blob.as_deref().unwrap_or(Path::new("shipped"));
    let blob = inputs::file(blob)?;
    if let Some(cuts) = arguments.rehearse {
        return rehearsal(&blob, cuts, arguments.json);
    }
    if let Some(path) = &arguments.to_sign {
        write_whole(path, &Release(arguments.release).signed_bytes(&blob))?;
        eprintln!("sign {}, and give the signature with --release {}", path.display(), arguments.release);
        return Ok(());
    }
    let profile = arguments.profile.as_deref().map(Profile::read).transpose()?;
    let to = arguments.to.clone().or_else(|| profile.as_ref().map(|profile| profile.slots.clone()));
    let Some(to) = to else { bail!("give the folder with the slots (--to) or a profile that names it") };
    let mut policy = profile.as_ref().map(Profile::policy).transpose()?.unwrap_or_default();
    if arguments.allow_rollback {
        policy.rollback = Rollback::Allowed;
    }
    let signed =
        arguments.signature.as_deref().map(|path| signature(path, Release(arguments.release))).transpose()?;
    let mut folder = Folder::create(&to).with_context(|| format!("cannot use {}", to.display()))?;
    let slot = flash(&mut folder, Flashed { blob: &blob, signed }, &policy)?;
    let booted = boot(&folder, &policy)?;
    let header = Model::load(&booted.blob).context("the slot that boots holds no model")?.header;
    let (liquid, validity) = (header.liquid.as_str(), Validity::of(&header));
    if arguments.json {
        let report = json!({ "command": "meniscus flash", "version": env!("CARGO_PKG_VERSION"),
                             "slot": format!("{slot:?}"), "liquid": liquid, "signed": policy.key.is_some(),
                             "release": booted.release.0,
                             "known": validity.names() });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        let board = profile.map_or(String::new(), |profile| format!(" of {}", profile.name));
        println!("{}: {liquid} in slot {slot:?}{board}; it boots at the next start", to.display());
        validity.sentence.iter().for_each(|sentence| println!("{sentence}"));
    }
    Ok(())
}

/// Reads the signature file at `path`: 64 bytes of openssl as this release, or a slot's own file.
fn signature(path: &Path, release: Release) -> anyhow::Result<Signed> {
    let bytes = read_regular(path, inputs::SIGNATURE_FILE, Links::Followed);
    let bytes = bytes.with_context(|| format!("cannot read {}", path.display()))?;
    let signed = Signed::read(&bytes).with_context(|| {
        format!("{} holds {} bytes: an ed25519 signature has 64", path.display(), bytes.len())
    })?;
    Ok(if signed.release == Release(0) { Signed { release, ..signed } } else { signed })
}

fn rehearsal(blob: &[u8], cuts: u32, as_json: bool) -> anyhow::Result<()> {
    let (shipped, sibling) = (meniscus_shipped::MODEL, sibling(blob));
    let done = rehearse([shipped, &sibling], cuts, 1);
    // Every fourth cut again on a board with a key, where a flash writes a signature, too.
    let signed_cuts = cuts.div_ceil(4);
    let signed = rehearse_signed([shipped, &sibling], signed_cuts, 2);
    if as_json {
        let report = json!({
            "command": "meniscus flash", "version": env!("CARGO_PKG_VERSION"), "new_boots": done.new,
            "fell_back": done.fell_back, "first_failure": done.first_failure.as_ref().or(signed.first_failure.as_ref()),
            "checks": [{ "name": "power_cuts_survived", "value": done.survived, "unit": "1",
                         "target": format!("= {cuts}"), "ok": done.survived == cuts },
                       { "name": "signed_power_cuts_survived", "value": signed.survived, "unit": "1",
                         "target": format!("= {signed_cuts}"), "ok": signed.survived == signed_cuts }],
        });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        println!(
            "{} of {cuts} power cuts survived; the new model booted behind {} of them, the old one behind the rest",
            done.survived, done.new
        );
        println!("signed models: {} of {signed_cuts} power cuts survived", signed.survived);
    }
    if let Some(why) = done.first_failure.or(signed.first_failure) {
        bail!("{why}");
    }
    Ok(())
}
