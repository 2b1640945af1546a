//! `meniscus flash`: a model to a board, so that whatever happens a whole one boots.

use super::inputs;
use super::profile::Profile;
use anyhow::{Context, bail};
use meniscus::blob::Model;
use meniscus_data::validity::Validity;
use meniscus_service::flash::{Folder, boot, flash, rehearse, sibling};
use serde_json::json;
use std::path::PathBuf;

/// Write a model to a board's spare slot, safe against power loss.
///
/// TARGET is the folder with the slots, on the board or where its disk is mounted. The slot that boots stays as it is. The new
/// model goes into the other slot, is read back, and is made the one that boots by a single rename. If it is damaged at a
/// start, the other slot boots. `meniscus run --model TARGET` starts what boots.
///
/// With a public key in the board's profile, a model without a valid signature is neither written nor started.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus flash my.blob --to /var/lib/meniscus\n  meniscus flash my.blob --signature my.blob.sig \\\n    --profile /etc/meniscus/board.toml\n  meniscus flash --rehearse 200 --json",
    after_long_help = "Key and signature are made with openssl:\n  openssl genpkey -algorithm ed25519 -out key.pem\n  openssl pkeyutl -sign -rawin -inkey key.pem -in my.blob -out my.blob.sig\nThe profile's public_key is printed by:\n  openssl pkey -in key.pem -pubout -outform DER | tail -c 32 | xxd -p -c 32"
)]
pub(crate) struct Arguments {
    /// The model: a blob file, or the one in the program (shipped).
    #[arg(value_name = "BLOB", required_unless_present = "rehearse")]
    blob: Option<String>,
    /// Folder with the slots [default: the profile's].
    #[arg(long, value_name = "TARGET", help_heading = "Board")]
    to: Option<PathBuf>,
    /// The board's profile.
    #[arg(long, value_name = "FILE.toml", help_heading = "Board")]
    profile: Option<PathBuf>,
    /// The blob's ed25519 signature, 64 bytes.
    #[arg(long, value_name = "FILE", help_heading = "Board")]
    signature: Option<PathBuf>,
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
    let blob = arguments.blob.as_deref().unwrap_or("shipped");
    let blob = inputs::file(blob)?;
    if let Some(cuts) = arguments.rehearse {
        return rehearsal(&blob, cuts, arguments.json);
    }
    let profile = arguments.profile.as_deref().map(Profile::read).transpose()?;
    let to = arguments.to.clone().or_else(|| profile.as_ref().map(|profile| profile.slots.clone()));
    let Some(to) = to else { bail!("give the folder with the slots (--to) or a profile that names it") };
    let key = profile.as_ref().map(Profile::key).transpose()?.flatten();
    let signature = match &arguments.signature {
        Some(path) => Some(std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?),
        None => None,
    };
    let mut folder = Folder::create(&to).with_context(|| format!("cannot use {}", to.display()))?;
    let slot = flash(&mut folder, &blob, signature.as_deref(), key.as_ref())?;
    let booted = boot(&folder, key.as_ref())?;
    let header = Model::load(&booted.blob).context("the slot that boots holds no model")?.header;
    let (liquid, validity) = (header.liquid.as_str(), Validity::of(&header));
    if arguments.json {
        let report = json!({ "command": "meniscus flash", "version": env!("CARGO_PKG_VERSION"),
                             "slot": format!("{slot:?}"), "liquid": liquid, "signed": key.is_some(),
                             "known": validity.names() });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        let board = profile.map_or(String::new(), |profile| format!(" of {}", profile.name));
        println!("{}: {liquid} in slot {slot:?}{board}; it boots at the next start", to.display());
        validity.sentence.iter().for_each(|sentence| println!("{sentence}"));
    }
    Ok(())
}

fn rehearsal(blob: &[u8], cuts: u32, as_json: bool) -> anyhow::Result<()> {
    let done = rehearse([meniscus_shipped::MODEL, &sibling(blob)], cuts, 1);
    if as_json {
        let report = json!({
            "command": "meniscus flash", "version": env!("CARGO_PKG_VERSION"), "new_boots": done.new,
            "fell_back": done.fell_back, "first_failure": done.first_failure,
            "checks": [{ "name": "power_cuts_survived", "value": done.survived, "unit": "1",
                         "target": format!("= {cuts}"), "ok": done.survived == cuts }],
        });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        println!(
            "{} of {cuts} power cuts survived; the new model booted behind {} of them, the old one behind the rest",
            done.survived, done.new
        );
    }
    if let Some(why) = done.first_failure {
        bail!("{why}");
    }
    Ok(())
}
